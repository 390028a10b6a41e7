//! A renderer or recorder that fails.

use crate::awkward::{Installed, RECORDER, RENDERER, SCRIPT, read};
use crate::tree::Tree;
use microsim_host::record::Ended;
use microsim_tests::{Finished, finish};
use serde_json::json;
use std::process::Command;

/// Pictures are off, with the reason in the log; the run and its state hash are those of a run without pictures.
#[test]
fn a_renderer_that_fails_changes_nothing() {
    let installed = Installed::awkward(RENDERER);
    let without = installed.run("", &["--json"]).output.expect(0).json();
    assert_eq!(without["pictures"], json!(null));
    let cases = [
        (
            "panic initialise",
            0,
            "plugin \"renderer\" panicked in `initialise` at tick 0: ",
        ),
        (
            "fault initialise",
            0,
            "plugin \"renderer\" failed in `initialise` at tick 0: awkward in initialise",
        ),
        ("unavailable initialise", 0, "awkward in initialise"),
        // Of 101 ticks every sixth is drawn: 20 pictures a second, a tick is 8 ms. The fourth is that of tick 18.
        (
            "panic process 3",
            3,
            "plugin \"renderer\" panicked in `process` at tick 18: ",
        ),
        (
            "bomb process 3",
            3,
            "plugin \"renderer\" panicked in `process` at tick 18: ",
        ),
        ("unavailable process 3", 3, "awkward in process"),
        (
            "panic stop",
            17,
            "plugin \"renderer\" panicked in `stop` at tick 96: ",
        ),
    ];
    for (told, written, reason) in cases {
        let run = installed.run(
            told,
            &["--json", "--frames", "pictures", "--frame-rate", "20"],
        );
        let json = run.output.clone().expect(0).json();
        for key in ["verdict", "score", "ticks", "state_hash"] {
            assert_eq!(json[key], without[key], "{key}: {run:?}");
        }
        assert_eq!(json["pictures"]["written"], written, "{run:?}");
        assert!(
            json["pictures"]["off"]
                .as_str()
                .is_some_and(|off| off.starts_with(reason)),
            "{run:?}"
        );
        assert!(read(&run.session).complaint.is_none(), "{run:?}");
    }
    let run = installed.run(
        "panic drop",
        &["--json", "--frames", "pictures", "--frame-rate", "20"],
    );
    let json = run.output.expect(0).json();
    assert_eq!(
        (&json["state_hash"], &json["pictures"]["off"]),
        (&without["state_hash"], &json!(null))
    );
}

#[test]
fn a_recorder_that_cannot_begin() {
    let installed = Installed::awkward(RECORDER);
    let sentence = "plugin \"recorder\" failed in `initialise` at tick 0: awkward in initialise";
    installed
        .run("fault initialise", &[])
        .assert_refused(sentence);
}

/// A run of the built recorder whose files may have this many KiB, as on a full disk.
fn limited(tree: &Tree, kib: u32) -> Finished {
    let program = microsim_tests::program();
    let mut shell = Command::new("bash");
    shell.current_dir(tree.path(""));
    microsim_tests::apart(&mut shell);
    shell.arg("-c").arg(format!(
        // Without the trap a signal would end the process instead of an error of `write`.
        "trap '' XFSZ; ulimit -f {kib}; exec \"$0\" --root . run touch-spheres --input script:script.toml --session \
         {kib}.session"
    ));
    finish(shell.arg(program))
}

#[test]
fn a_recorder_that_fails_midway() {
    let tree = Tree::new();
    tree.write("script.toml", SCRIPT);
    let full = tree.microsim(&[
        "run",
        "touch-spheres",
        "--input",
        "script:script.toml",
        "--session",
        "full.session",
    ]);
    full.expect(0);
    let full = read(&tree.path("full.session"));
    let mut seen = Vec::new();
    for kib in [24, 36, 48] {
        let printed = limited(&tree, kib);
        assert_eq!(printed.code, Some(2), "{printed:?}");
        let name = format!("{kib}.session");
        let session = read(&tree.path(&name));
        let ticks = session.ticks.len();
        let last = printed.err.lines().last().unwrap_or_default();
        let sentence = format!(
            "microsim: plugin \"recorder\" failed in `process` at tick {ticks}: cannot write {name}: File too large (os error \
             27); what was written before is safe; the session so far is safe in {name}"
        );
        assert_eq!(last, sentence, "{printed:?}");
        // All that fitted is there, to the bit, and the file says that it breaks off.
        assert!(session.ticks == full.ticks[..ticks], "{kib} KiB");
        assert!(session.end.is_none());
        let complaint = session.complaint.expect("not closed");
        assert!(
            complaint.contains("breaks off inside a frame"),
            "{complaint}"
        );
        let report = tree.microsim(&["report", &name, "--json"]).expect(0).json();
        assert_eq!(report["verdict"], "incomplete");
        seen.push(ticks);
    }
    assert!(
        0 < seen[0] && seen.is_sorted() && seen[0] < seen[2] && seen[2] < full.ticks.len(),
        "{seen:?}"
    );
    assert_eq!(full.end.map(|e| e.ended), Some(Ended::Result));
}
