//! Panics and faults in each call of the life cycle. The calls that a run never makes stand in `boundary`.

use crate::awkward::{Installed, MODULE, OBJECTS, PHYSICS, Role, SOURCE, TRANSLATOR, read};
use microsim_bus::Frames;
use microsim_host::record::Session;
use microsim_message::{InputSample, decode};
use microsim_tests::finish;
use serde_json::json;

/// Every kind that computes.
const ROLES: [Role; 5] = [SOURCE, TRANSLATOR, PHYSICS, MODULE, OBJECTS];

/// Ticks after which the states were to be saved: `session.state_hash_every` of config/host.toml is 250 ms.
const FIRST_SAVE: u64 = 31;

fn sentence(role: Role, how: &str, call: &str, tick: u64, place: &str) -> String {
    let name = role.name;
    match how {
        "fault" => {
            format!("plugin \"{name}\" failed in `{call}` at tick {tick}: awkward in {place}")
        }
        // Where it panicked is part of the sentence; what it says stands behind the line.
        _ => format!(
            "plugin \"{name}\" panicked in `{call}` at tick {tick}: panicked at tests/fixtures/awkward/src/lib.rs:"
        ),
    }
}

#[test]
fn before_the_first_tick() {
    for role in ROLES {
        let installed = Installed::awkward(role);
        let library = installed
            .tree
            .path(role.folder())
            .join("libmicrosim_fixture_awkward.so");
        let create = format!(
            "plugin \"{}\" ({}): panicked in `create`: panicked at ",
            role.name,
            library.display()
        );
        let run = installed.run("panic new", &[]);
        run.assert_refused(&create);
        assert!(run.output.err.ends_with(": awkward in new\n"), "{run:?}");
        for how in ["panic", "fault"] {
            let sentence = sentence(role, how, "initialise", 0, "initialise");
            installed
                .run(&format!("{how} initialise"), &[])
                .assert_refused(&sentence);
        }
    }
}

#[test]
fn in_a_tick() {
    for role in ROLES {
        let installed = Installed::awkward(role);
        // A bomb is a panic whose content panics once more when it is dropped.
        for how in ["panic", "fault", "bomb"] {
            let run = installed.run(&format!("{how} process 20"), &[]);
            let verdict = run.assert_preserved(20, &sentence(role, how, "process", 20, "process"));
            assert_eq!(verdict, "incomplete", "{run:?}");
            assert_eq!(
                run.output.err.contains("awkward in process"),
                how != "bomb",
                "{run:?}"
            );
        }
        // The very first tick: the session holds the header and the failure.
        let run = installed.run("panic process 0", &["--json"]);
        run.assert_preserved(0, &sentence(role, "panic", "process", 0, "process"));
        let json = run.output.json();
        assert_eq!(json["verdict"], "incomplete", "{run:?}");
        assert!(
            json["failure"]
                .as_str()
                .is_some_and(|f| f.contains(role.name)),
            "{run:?}"
        );
    }
}

#[test]
fn in_a_part_of_a_parallel_loop() {
    let installed = Installed::awkward(PHYSICS);
    for threads in ["1", "2", "4"] {
        for how in ["panic", "bomb"] {
            let told = format!("{how} part 20");
            let run = installed.run(&told, &["--threads", threads]);
            run.assert_preserved(20, &sentence(PHYSICS, how, "process", 20, "part"));
            assert_eq!(
                run.output.err.contains("awkward in part"),
                how == "panic",
                "{run:?}"
            );
            // Nothing else is said, by the thread that panicked, say.
            assert_eq!(
                run.output
                    .err
                    .lines()
                    .filter(|l| l.contains("panicked"))
                    .count(),
                1,
                "{run:?}"
            );
            std::fs::remove_file(&run.session).expect("removed");
        }
    }
}

#[test]
fn while_saving() {
    for role in ROLES {
        let installed = Installed::awkward(role);
        let run = installed.run("panic save 20", &[]);
        // The tick itself is done and kept.
        let verdict = run.assert_preserved(
            FIRST_SAVE,
            &sentence(role, "panic", "save", FIRST_SAVE, "save"),
        );
        assert_eq!(verdict, "incomplete", "{run:?}");
    }
}

/// When the states at the end cannot be saved, the module's verdict is in the ticks already.
#[test]
fn while_saving_at_the_end() {
    for role in ROLES {
        let installed = Installed::awkward(role);
        let good = installed.run("", &["--json"]);
        let ticks = good.output.json()["ticks"].as_u64().expect("a number");
        let last_save = ticks / FIRST_SAVE * FIRST_SAVE;
        let run = installed.run(&format!("panic save {}", last_save + 1), &[]);
        let verdict = run.assert_preserved(ticks, &sentence(role, "panic", "save", ticks, "save"));
        assert_eq!(verdict, good.output.json()["verdict"], "{run:?}");
    }
}

#[test]
fn while_restoring() {
    let installed = Installed::awkward(TRANSLATOR);
    let stopped = installed.run("", &["--stop-at", "0.4", "--checkpoint", "half.checkpoint"]);
    stopped.output.clone().expect(0);
    for how in ["panic", "fault"] {
        let run = installed.run(&format!("{how} restore"), &["--resume", "half.checkpoint"]);
        run.assert_refused(&sentence(TRANSLATOR, how, "restore", 50, "restore"));
    }
    let run = installed.run(
        "panic save",
        &["--stop-at", "0.1", "--checkpoint", "other.checkpoint"],
    );
    run.assert_preserved(13, &sentence(TRANSLATOR, "panic", "save", 13, "save"));
    assert!(!installed.tree.path("other.checkpoint").exists());
}

/// What fails after the end is a complaint; the result stands.
#[test]
fn while_stopping() {
    for role in ROLES {
        let installed = Installed::awkward(role);
        let good = installed.run("", &["--json"]).output.expect(0).json();
        for told in [
            "panic stop",
            "fault stop",
            "bomb stop",
            "panic drop",
            "bomb drop",
        ] {
            let run = installed.run(told, &["--json"]);
            let json = run.output.clone().expect(0).json();
            for key in ["verdict", "failed", "score", "ticks", "state_hash"] {
                assert_eq!(json[key], good[key], "{key}: {run:?}");
            }
            assert_eq!(json["failure"], json!(null), "{run:?}");
            let session = read(&run.session);
            assert!(
                session.complaint.is_none() && session.failures.is_empty(),
                "{run:?}"
            );
            let (how, place) = told.split_once(' ').expect("two words");
            let complaint = sentence(
                role,
                how,
                "stop",
                good["ticks"].as_u64().unwrap_or(0),
                place,
            );
            assert_eq!(
                run.output.err.contains(&complaint),
                place == "stop",
                "{run:?}"
            );
        }
    }
}

/// What no boundary can hold, of a plugin that runs in the host's process: it ends, and what it has written is there, as after `kill -9`.
#[test]
fn a_plugin_that_ends_the_process() {
    let installed = Installed::awkward(PHYSICS);
    let run = installed.run("abort process 20", &[]);
    assert_eq!(run.output.code, None, "{run:?}");
    let session = read(&run.session);
    assert_eq!(session.ticks.len(), 20);
    let complaint = session.complaint.expect("not closed");
    assert_eq!(complaint, "the session has no end: its process was killed");
    let mut report = installed.tree.command(&["report", "--json"]);
    let report = finish(report.arg(&run.session)).expect(0).json();
    assert_eq!(
        (&report["verdict"], &report["session"]["complaint"]),
        (&json!("incomplete"), &json!(complaint))
    );
}

/// The tick that a plugin failed in is on file with its inputs, so that a replay meets the same failure, and reports it when
/// it does not.
#[test]
fn a_failure_can_be_replayed() {
    let installed = Installed::awkward(TRANSLATOR);
    // A tick with a sample: they come every 16 ms, ticks every 8 ms.
    let run = installed.run("panic process 21", &[]);
    let path = run.session.to_str().expect("UTF-8");
    let session = Session::read(&std::fs::read(&run.session).expect("read")).expect("a session");
    let (tick, failed) = session
        .failed_tick
        .as_ref()
        .expect("the tick of the failure");
    assert_eq!(*tick, 21);
    let inputs = Frames::new(&failed.log).filter_map(Result::ok);
    assert!(
        inputs.filter_map(|f| decode::<InputSample>(&f)).count() > 0,
        "its inputs"
    );
    let verify = |told: &str| finish(&mut installed.command(told, &["replay", path, "--verify"]));
    verify("panic process 21").expect(0);
    let healed = verify("").expect(1);
    assert!(
        healed.out.contains("tick 21") && healed.out.contains("without a failure"),
        "{healed:?}"
    );
}
