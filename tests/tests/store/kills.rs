//! A sample of `cargo xtask soak store`.

use microsim_tests::stations::killed_runs;

/// Sixteen runs of four trainees, two at a time on one store, every other one killed.
#[test]
fn killed_runs_lose_no_finished_session() {
    let outcome = killed_runs(16, 4, 20_261_125);
    println!("{outcome:?}");
    assert!(outcome.is_good(), "{outcome:?}");
    // Nine are not killed; of the seven others some end before their moment.
    assert!(outcome.finished >= 9 && outcome.killed >= 2, "{outcome:?}");
    // One of them 2.6 ms after its end, which is before its result is entered: the session is read again first.
    assert!(outcome.caught_up >= 1, "{outcome:?}");
}
