//! The memory that a session takes does not grow with it as its file does: a short version of `cargo xtask soak sessions`, which measures times too.

use microsim_tests::long::length;

/// `report` and `replay` had the file in memory twice.
#[test]
fn memory_does_not_grow_with_the_session() {
    let [short, long] = [150, 1200].map(length);
    println!("{short:?}\n{long:?}");
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
