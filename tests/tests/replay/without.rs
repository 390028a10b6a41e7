//! A run without physics is no result, and is labelled so everywhere.

use crate::{PUSH_STRIP, pushed_strip};
use microsim_tests::{assert_verified, finish, microsim, report_beside, run, scratch};

#[test]
fn a_run_without_physics_is_no_result_and_replays() {
    let folder = scratch();
    let session = folder.path().join("without.session");
    let without = [&PUSH_STRIP[..], &["--without", "physics"]].concat();
    let printed = run("push-strip", &session, &without);
    assert_eq!(printed["counts"], false, "{printed}");
    let report = report_beside(&session);
    assert_eq!(report["counts"], false);
    assert_eq!(report["session"]["without"], serde_json::json!(["physics"]));
    let text = microsim(["report".as_ref(), session.as_os_str()])
        .expect(0)
        .out;
    assert!(text.contains("(no result)"), "{text}");
    assert_verified(&session);

    // The same run with physics counts.
    let whole = folder.path().join("whole.session");
    std::fs::write(&whole, pushed_strip()).expect("a file");
    let text = microsim(["report".as_ref(), whole.as_os_str()])
        .expect(0)
        .out;
    assert!(!text.contains("(no result)"), "{text}");
}

/// Such a run is no pass either, whatever its score.
#[test]
fn without_physics_nothing_is_passed() {
    let folder = scratch();
    let session = folder.path().join("without.session");
    let mut command = microsim_tests::command(["run", "push-strip", "--without", "physics"]);
    command
        .args(PUSH_STRIP)
        .args(["--require-pass", "--session"])
        .arg(session);
    finish(&mut command).expect(1);
}
