//! What a session costs does not grow with its length: a short version of `cargo xtask soak sessions`.

use microsim_tests::long::length;

/// With hashes over all that was saved, 1,200 s cost nearly four times as much per second as 150 s (32 CPU s for 2,400 s, 0.6 for 300 s), and
/// `report` and `replay` had the file in memory twice.
#[test]
fn cost_per_second_and_memory_do_not_grow_with_the_session() {
    let [short, long] = [150, 1200].map(length);
    println!("{short:?}\n{long:?}");
    for (of_short, of_long) in [(short.run, long.run), (short.verify, long.verify)] {
        // Of the short run half a second at most is start-up.
        assert!(of_long.cpu / 8.0 < 1.5 * of_short.cpu, "{short:?} {long:?}");
    }
    let grown = long.file - short.file;
    for (of_short, of_long) in [
        (short.report, long.report),
        (short.replay, long.replay),
        (short.verify, long.verify),
    ] {
        assert!(
            of_long.memory - of_short.memory < 0.3 * grown,
            "{short:?} {long:?}"
        );
    }
}
