//! What is asked for is not there; what standard output gets.

use crate::tree::Tree;
use crate::{assert_refused, run, tree};
use microsim_tests::{Finished, finish};
use std::process::Command;

#[test]
fn sources_that_are_none() {
    let tree = tree();
    for (input, reason) in [
        (
            "nonsense",
            "unknown source; expected script:FILE, recording:FILE, openigtlink://HOST:PORT or plugin:NAME",
        ),
        (
            "hand.csv",
            "unknown source; expected script:FILE, recording:FILE, openigtlink://HOST:PORT or plugin:NAME",
        ),
        (
            "script:",
            "nothing behind the colon; expected script:FILE, recording:FILE, openigtlink://HOST:PORT or plugin:NAME",
        ),
        (
            "desktop",
            "mouse and keyboard are those of a window (`microsim window`); expected script:FILE",
        ),
        (
            "openigtlink://",
            "no address behind openigtlink:; expected script:FILE",
        ),
    ] {
        let printed = run(&tree, input, &[]);
        let sentence = format!("error: invalid value '{input}' for '--input <SOURCE>': {reason}");
        assert_eq!(printed.code, Some(2), "{printed:?}");
        assert!(
            printed.err.starts_with(&sentence) && printed.out.is_empty(),
            "{printed:?}"
        );
    }
    assert_refused(&tree, "plugin:no-such", "no plugin \"no-such\" below");
    let printed = tree.microsim(&["run", "touch-spheres"]).expect(2);
    assert!(printed.err.contains("--input <SOURCE>"), "{printed:?}");
}

#[test]
fn modules_and_levels_that_are_not_there() {
    let tree = tree();
    let args = |module, level| {
        [
            "run",
            module,
            "--level",
            level,
            "--input",
            "script:short.toml",
            "--session",
            "x.session",
        ]
    };
    for (module, level, reason) in [
        (
            "touch-sphere",
            "1",
            "microsim: no module \"touch-sphere\" below ",
        ),
        (
            "../touch-spheres",
            "1",
            "microsim: no module \"../touch-spheres\" below ",
        ),
        (
            "touch-spheres",
            "6",
            "microsim: module \"touch-spheres\" has levels 1 to 5, not 6\n",
        ),
        (
            "touch-spheres",
            "0",
            "microsim: module \"touch-spheres\" has levels 1 to 5, not 0\n",
        ),
        (
            "touch-spheres",
            "one",
            "error: invalid value 'one' for '--level <N>': expected the number of a level, such as 1",
        ),
        (
            "touch-spheres",
            "4294967296",
            "error: invalid value '4294967296' for '--level <N>': ",
        ),
    ] {
        let printed = tree.microsim(&args(module, level)).expect(2);
        assert!(
            printed.err.starts_with(reason) && printed.out.is_empty(),
            "expected {reason:?} in {printed:?}"
        );
    }
    let printed = tree.microsim(&args("touch-sphere", "1"));
    let modules = tree.microsim(&["list", "--json"]).expect(0).json();
    let modules = modules["modules"].as_array().expect("a list").iter();
    let names: Vec<_> = modules.filter_map(|m| m["name"].as_str()).collect();
    let sentence = format!("; there are: {}\n", names.join(", "));
    assert!(
        names.contains(&"touch-spheres") && printed.err.contains(&sentence),
        "{sentence:?} in {printed:?}"
    );
    assert!(!tree.path("x.session").exists());
}

#[test]
fn places_where_nothing_is_installed() {
    let empty = microsim_tests::scratch();
    let printed =
        microsim_tests::microsim(["--root".as_ref(), empty.path().as_os_str(), "list".as_ref()])
            .expect(2);
    assert!(
        printed.err.starts_with("microsim: no plugins/ below ") && printed.err.contains("--root"),
        "{printed:?}"
    );
    let printed = microsim_tests::microsim([
        "--config".as_ref(),
        empty.path().as_os_str(),
        "list".as_ref(),
    ])
    .expect(2);
    assert!(
        printed
            .err
            .contains("host.toml: found no such file, expected the settings of the host"),
        "{printed:?}"
    );
}

#[test]
fn sessions_that_cannot_be_written() {
    let tree = tree();
    tree.write("x.session", "mine");
    let printed = run(&tree, "script:short.toml", &[]).expect(2);
    assert_eq!(
        printed.err,
        "microsim: session x.session exists already; nothing is overwritten\n"
    );
    assert_eq!(
        std::fs::read(tree.path("x.session")).expect("read"),
        b"mine"
    );

    let in_place = |session: &str| {
        tree.microsim(&[
            "run",
            "touch-spheres",
            "--input",
            "script:short.toml",
            "--session",
            session,
        ])
        .expect(2)
        .err
    };
    for (session, folder) in [
        ("no/such/folder.session", "no/such"),
        ("short.toml/x.session", "short.toml"),
    ] {
        assert_eq!(
            in_place(session),
            format!("microsim: {session}: there is no folder {folder}\n")
        );
    }
    // The folder of the user is a file.
    let data = ["--data", "short.toml"];
    let run = ["run", "touch-spheres", "--input", "script:short.toml"];
    let printed = tree.microsim(&[&data[..], &run].concat()).expect(2);
    let sentence = format!(
        "microsim: {} cannot be written: ",
        tree.path("short.toml/sessions").display()
    );
    assert!(printed.err.starts_with(&sentence), "{printed:?}");
    let doctor = tree.microsim(&[&data[..], &["doctor"]].concat()).expect(1);
    assert!(doctor.out.contains("cannot be written"), "{doctor:?}");
}

/// Whatever a user names and is not there, or cannot be written, is named in words, with its path; and before anything runs.
#[test]
fn names_that_are_none_are_told_in_words() {
    let tree = tree();
    let script = "script:short.toml";
    let run = ["run", "touch-spheres", "--input"];
    let no_file = "no.file: there is no such file";
    let in_proc = "/proc/x cannot be written: nothing can be made in /proc";
    for (args, words) in [
        (&["report", "no.file"][..], no_file),
        (&["replay", "no.file", "--verify"], no_file),
        (&["bus", "no.file"], no_file),
        (&["report", "modules"], "session modules: it is a folder"),
        (
            &[&run[..], &[script, "--resume", "no.file"]].concat(),
            no_file,
        ),
        (&[&run[..], &["recording:no.file"]].concat(), no_file),
        (
            &["simulate", "stretch", "--json", "no/x.json"],
            "no/x.json cannot be written: there is no folder no",
        ),
        (&["simulate", "stretch", "--vtu", "/proc/x"], in_proc),
        (&["chart", "--quick", "--out", "/proc/x"], in_proc),
        (
            &[&run[..], &[script, "--session", "/proc/x"]].concat(),
            "microsim: session /proc/x cannot be written",
        ),
        (
            &[
                &run[..],
                &[script, "--session", "a.session"],
                &["--stop-at", "0.02", "--checkpoint", "/proc/x"],
            ]
            .concat(),
            "microsim: checkpoint /proc/x cannot be written",
        ),
        (
            &[
                &run[..],
                &[script, "--session", "b.session", "--trace", "/proc/x"],
            ]
            .concat(),
            "microsim: trace /proc/x cannot be written",
        ),
    ] {
        let printed = tree.microsim(args).expect(2);
        let bare = printed.err.contains("os error") || printed.err.contains("`initialise`");
        assert!(printed.err.contains(words) && !bare, "{printed:?}");
    }
    assert!(!tree.path("a.session").exists() && !tree.path("b.session").exists());
}

/// A script that was made for another level runs; a warning and the report name that level.
#[test]
fn the_script_of_another_level_is_told() {
    let tree = tree();
    let text = format!("module = \"touch-spheres\"\nlevel = 4\n{}", crate::SHORT);
    tree.write("other.toml", text);
    let printed = run(&tree, "script:other.toml", &["--json"]).expect(0);
    let warned = "made for touch-spheres, level 4; this is touch-spheres, level 1";
    assert!(printed.err.contains(warned), "{printed:?}");
    let report = tree.microsim(&["report", "x.session", "--json"]).expect(0);
    let said = "script:other.toml (made for touch-spheres, level 4)";
    assert!(report.out.contains(said), "{report:?}");
    // Without the keys nothing is known, and nothing said.
    std::fs::remove_file(tree.path("x.session")).expect("removed");
    let unnamed = run(&tree, "script:short.toml", &["--json"]).expect(0);
    assert_eq!(unnamed.err, "", "{unnamed:?}");
    // What a script was made for does not decide what is computed.
    let hash = |printed: &Finished| printed.json()["state_hash"].clone();
    assert_eq!(hash(&printed), hash(&unnamed));
}

#[test]
fn json_is_one_document_whatever_the_answer() {
    let tree = tree();
    let failed = run(&tree, "script:short.toml", &["--json"]).expect(0);
    assert_eq!(failed.json()["verdict"], "failed");
    std::fs::rename(tree.path("x.session"), tree.path("y.session")).expect("renamed");
    let required = run(&tree, "script:short.toml", &["--json", "--require-pass"]).expect(1);
    assert_eq!(required.json()["verdict"], "failed");
    let explain = run(&tree, "script:short.toml", &["--json", "--explain"]).expect(0);
    assert_eq!(explain.json()["module"], "touch-spheres");
    for args in [
        &["report", "y.session"][..],
        &["bus", "y.session"],
        &["bus"],
        &["replay", "y.session", "--verify"],
        &["list"],
    ] {
        tree.microsim(&[args, &["--json"]].concat())
            .expect(0)
            .json();
    }
    // Replayed with another level than it was recorded with: the one that is recorded counts.
    tree.edit(
        "modules/touch-spheres/levels/level1.toml",
        "dwell = ",
        "dwel = ",
    );
    let check = tree.microsim(&["check", "--json"]).expect(1).json();
    assert!(!check["problems"].as_array().expect("a list").is_empty());
    let replayed = tree.microsim(&["replay", "y.session", "--json"]);
    assert_eq!(replayed.expect(0).json()["recomputed"], true);
    // But whether its limits are those of the level cannot be known.
    let verified = tree.microsim(&["replay", "y.session", "--verify", "--json"]);
    let settings = verified.expect(1).json()["other_settings"].to_string();
    assert!(settings.contains("level1.toml"), "{settings}");
}

/// `microsim ARGS | head -n 1`; the status is the program's.
fn through_head(tree: &Tree, args: &str) -> Finished {
    let mut shell = Command::new("bash");
    shell.current_dir(tree.path(""));
    microsim_tests::apart(&mut shell);
    if args.ends_with("2>&1") {
        shell.env("RUST_LOG", "debug");
    }
    shell.arg("-c").arg(format!(
        "set -o pipefail; \"$0\" --root . {args} | head -n 1"
    ));
    finish(shell.arg(microsim_tests::program()))
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let tree = tree();
    run(&tree, "script:level1-pass.toml", &[]).expect(0);
    for args in [
        "list",
        "bus x.session",
        "bus x.session --json",
        "report x.session",
        "schema level",
        "--help",
    ] {
        let printed = through_head(&tree, args).expect(0);
        assert_eq!(
            (printed.out.lines().count(), printed.err.as_str()),
            (1, ""),
            "{args}"
        );
    }
    // The session is complete, though nobody reads what is said.
    let printed = through_head(
        &tree,
        "run touch-spheres --input script:short.toml --session z.session",
    )
    .expect(0);
    assert_eq!(printed.out.lines().count(), 1);
    tree.microsim(&["check", "z.session"]).expect(0);
    // Nor does it matter that the log goes the same way: every tick writes to it.
    let printed = through_head(
        &tree,
        "run touch-spheres --input script:short.toml --session log.session 2>&1",
    )
    .expect(0);
    assert_eq!(printed.out.lines().count(), 1);
    tree.microsim(&["check", "log.session"]).expect(0);
}

/// Standard output that takes nothing is an error, unlike a reader that goes away.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error() {
    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .expect("a device of every Linux");
    let output = tree()
        .command(&["list"])
        .stdout(full)
        .output()
        .expect("the program starts");
    let printed = Finished::from(output);
    assert_eq!(printed.code, Some(2), "{printed:?}");
    assert!(
        printed
            .err
            .starts_with("microsim: standard output: No space left on device"),
        "{printed:?}"
    );
}
