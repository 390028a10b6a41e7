//! Publications that a manifest does not declare, content that is none, and queues that are flooded.

use crate::awkward::{Installed, PHYSICS, Role, SOURCE, TRANSLATOR, read};

#[track_caller]
fn assert_stopped(role: Role, told: &str, reason: &str) {
    let installed = Installed::awkward(role);
    let run = installed.run(told, &[]);
    let sentence = format!(
        "plugin \"{}\" failed in `process` at tick 20: {reason}",
        role.name
    );
    assert_eq!(run.assert_preserved(20, &sentence), "incomplete", "{run:?}");
}

#[test]
fn a_kind_that_the_manifest_does_not_list() {
    let reason = "published \"tool.states\", which its manifest does not list under `publishes`";
    assert_stopped(SOURCE, "publish undeclared 20", reason);
}

/// 64 bits FNV-1a of "awkward.unknown", computed independently (Python: the two published constants).
#[test]
fn a_kind_that_nobody_knows() {
    let reason = "published a message of unknown kind 0xbe6be58c925c9708";
    assert_stopped(SOURCE, "publish unknown 20", reason);
}

#[test]
fn another_version_of_a_kind() {
    let reason = "published \"input.end\" in version 99, this run knows version 1";
    assert_stopped(SOURCE, "publish version 20", reason);
}

#[test]
fn a_block_of_garbage() {
    assert_stopped(PHYSICS, "publish block 20", "bad block: no MSBLOCK1 header");
}

/// Events must not be lost: who sends more than a queue holds is at fault.
#[test]
fn a_flood_of_events() {
    let reason = "published more \"input.sample\" than the queue of \"translator\" holds";
    assert_stopped(SOURCE, "publish flood 20", reason);
}

/// Of states the newest are what counts: a full queue loses the oldest, reports how many, and the run goes on.
#[test]
fn a_flood_of_states() {
    let installed = Installed::awkward(TRANSLATOR);
    let run = installed.run("publish states 20", &[]);
    run.output.clone().expect(0);
    // 5000 of them, and config/host.toml gives a queue 4096 places.
    let warning = "the queue of \"touch-spheres\" was full: 904 older \"tool.states\" were dropped";
    assert_eq!(run.output.err.matches(warning).count(), 1, "{run:?}");
    let session = read(&run.session);
    assert!(session.complaint.is_none() && session.failures.is_empty());
}

/// A source whose samples are none is blamed itself, and not the translator that reads them; the kind is named, and the run ends in order.
#[test]
fn a_kind_with_other_content() {
    let installed = Installed::awkward(SOURCE);
    let run = installed.run("publish content 20", &[]);
    let sentence = "plugin \"awkward\" failed in `process` at tick 20: \"input.sample\": invalid type: integer `7`";
    run.assert_preserved(20, sentence);
}
