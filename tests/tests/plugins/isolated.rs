//! Guests: what the installation did not bring runs in a process of its own. However it ends, it is named, the session stays, and the next
//! level runs.

use crate::awkward::{Installed, MODULE, SOURCE, TRANSLATOR, read};
use crate::tree::Tree;
use microsim_tests::{config_with, finish, scratch, tree};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What ends a process, and the sentence about it.
const ENDS: [(&str, &str); 5] = [
    ("segfault", "its process was ended by the signal SIGSEGV"),
    ("abort", "its process was ended by the signal SIGABRT"),
    ("exit", "its process ended by itself, with exit status 0"),
    (
        "loop",
        "its process gave no answer within 800 ms and was killed",
    ),
    (
        "allocate",
        "its process ran into its memory limit of 512 MiB",
    ),
];

/// Settings with a deadline that no machine misses.
fn patient(folder: &Path) -> PathBuf {
    let text = std::fs::read_to_string(tree().join("config/host.toml")).expect("the settings");
    let deadline = "deadline = \"800 ms\"";
    assert!(text.contains(deadline), "{text}");
    let text = text.replace(deadline, "deadline = \"8 s\"");
    config_with(folder, "host.toml", &text)
}

/// The trials' segfaults, aborts, `exit(0)`, endless loops and allocations: silence, exit status 0, or no end at all.
#[test]
fn a_guest_that_ends_is_named_and_the_session_stays() {
    for (role, ends) in [
        (MODULE, &ENDS[..]),
        (SOURCE, &ENDS[..1]),
        (TRANSLATOR, &ENDS[2..4]),
    ] {
        let installed = Installed::awkward(role);
        for (how, said) in ends {
            let told = format!("{how} process 20");
            // A busy machine takes longer than the deadline to give so much memory: here the limit of memory is to end the guest.
            let folder = scratch();
            let config = match *how {
                "allocate" => patient(folder.path()),
                _ => tree().join("config"),
            };
            let config = ["--config", config.to_str().expect("UTF-8")];
            let begun = Instant::now();
            let options = [&config[..], &["--require-pass", "--no-pictures"]].concat();
            let run = installed.run(&told, &options);
            // Starting, 20 ticks and the report included; `cargo xtask soak guests` measures the end alone.
            assert!(begun.elapsed() < Duration::from_secs(10), "{run:?}");
            let sentence = format!(
                "plugin \"{}\" ended in `process` at tick 20: {said}",
                role.name
            );
            run.assert_preserved(20, &sentence);
            assert!(read(&run.session).failures[0].ended, "{run:?}");
            // That it has ended is an input: a replay reads it, and the plugin need not end again.
            let path = run.session.to_str().expect("UTF-8");
            let replay = [&config[..], &["replay", path, "--verify"]].concat();
            let mut replay = installed.command("", &replay);
            finish(&mut replay).expect(0);
            let next = installed.run("", &["--no-pictures"]);
            next.output.expect(0);
            std::fs::remove_file(&next.session).expect("removed");
        }
    }
}

/// The clock may end a guest in a run, and never in a replay, which reads in which tick that was.
#[test]
fn a_replay_reads_when_a_guest_ended_and_no_clock() {
    let installed = Installed::awkward(MODULE);
    let ended = installed.run("nap process 20", &["--no-pictures"]);
    let sentence = "plugin \"awkward\" ended in `process` at tick 20: its process gave no answer within 800 ms";
    ended.assert_preserved(20, sentence);
    let slow = installed.run("nap process 30", &["--no-pictures", "--no-deadline"]);
    slow.output.expect(0);
    // As slow as then, and with the deadline of a run.
    for (told, session) in [
        ("nap process 20", ended.session),
        ("nap process 30", slow.session),
    ] {
        let path = session.to_str().expect("UTF-8");
        let mut replay = installed.command(told, &["replay", path, "--verify", "--json"]);
        let replay = finish(&mut replay).expect(0).json();
        let read = read(&session);
        assert_eq!(replay["ticks"], read.ticks.len(), "{replay}");
        let guest = replay["guest_ended"]["tick"].as_u64();
        assert_eq!(guest, read.failures.first().map(|f| f.tick), "{replay}");
    }
}

#[test]
fn a_shipped_module_has_the_same_bits_in_a_process_of_its_own() {
    let tree = Tree::new();
    tree.write("script.toml", crate::awkward::SCRIPT);
    let run = |which: &str| {
        let session = format!("{which}.session");
        let args = [
            "run",
            "touch-spheres",
            "--input",
            "script:script.toml",
            "--json",
            "--isolate",
            which,
            "--session",
            &session,
        ];
        tree.microsim(&args).expect(0).json()
    };
    let [inside, guests, own] = ["none", "guests", "all"].map(run);
    for key in ["state_hash", "physics_digest", "score", "verdict", "ticks"] {
        assert_eq!(inside[key], own[key], "{key}");
        assert_eq!(inside[key], guests[key], "{key}");
    }
    let explained = |which: &str| {
        let args = [
            "run",
            "touch-spheres",
            "--input",
            "script:script.toml",
            "--json",
            "--isolate",
            which,
            "--explain",
        ];
        let json = tree.microsim(&args).expect(0).json();
        let plugins = json["plugins"].as_array().expect("a list").clone();
        plugins.iter().filter(|p| p["isolated"] == true).count()
    };
    // What was installed runs inside; source, translator and module can all be put out.
    assert_eq!(["none", "guests", "all"].map(explained), [0, 0, 3]);
}

/// A library of which half is missing was the end of the program, without a word; a missing one was found by nobody.
#[test]
fn a_truncated_library_is_named_and_found_by_check_and_doctor() {
    for plugin in ["translator", "physics"] {
        let tree = Tree::new();
        tree.write("script.toml", crate::awkward::SCRIPT);
        let library = format!("plugins/{plugin}/libmicrosim_plugin_{plugin}.so");
        let bytes = std::fs::read(tree.path(&library)).expect("read");
        // Linked to the built one: not written in place.
        std::fs::remove_file(tree.path(&library)).expect("removed");
        tree.write(&library, &bytes[..bytes.len() / 2]);
        let args = [
            "run",
            "push-strip",
            "--input",
            "script:script.toml",
            "--session",
            "x.session",
        ];
        let run = tree.microsim(&args).expect(2);
        assert!(
            run.err
                .starts_with(&format!("microsim: plugin \"{plugin}\" (")),
            "{run:?}"
        );
        for command in ["check", "doctor"] {
            let found = tree.microsim(&[command]).expect(1);
            let sentence = "the library is not the one that was installed";
            assert!(found.out.contains(sentence), "{found:?}");
        }
        std::fs::remove_file(tree.path(&library)).expect("removed");
        for command in ["check", "doctor"] {
            let found = tree.microsim(&[command]).expect(1);
            assert!(found.out.contains("cannot be read"), "{found:?}");
        }
    }
}

/// What a guest prints is printed once, also where the run is computed again for its pictures.
#[test]
fn what_a_guest_prints_appears_once() {
    let installed = Installed::awkward(MODULE);
    let run = installed.run("say process 0", &[]);
    let printed = run.output.err.matches("awkward in process").count();
    assert_eq!(printed, read(&run.session).ticks.len(), "{run:?}");
}

/// Nothing has to be copied into the installation.
#[test]
fn a_module_may_lie_anywhere() {
    let installed = Installed::awkward(MODULE);
    let elsewhere = installed.tree.path("elsewhere");
    std::fs::create_dir(&elsewhere).expect("a folder");
    std::fs::rename(
        installed.tree.path(MODULE.folder()),
        elsewhere.join("awkward"),
    )
    .expect("moved");
    let manifest = elsewhere.join("awkward/module.toml");
    for place in [elsewhere.clone(), elsewhere.join("awkward")] {
        let place = place.to_str().expect("UTF-8");
        let session = installed.tree.path("elsewhere.session");
        let mut run = installed.command("", &["run"]);
        run.args(MODULE.run)
            .args(["--no-pictures", "--modules", place, "--session"])
            .arg(&session);
        run.env("MICROSIM_AWKWARD_MANIFEST", &manifest);
        finish(&mut run).expect(0);
        let path = session.to_str().expect("UTF-8");
        let mut replay = installed.command("", &["replay", path, "--verify", "--modules", place]);
        replay.env("MICROSIM_AWKWARD_MANIFEST", &manifest);
        finish(&mut replay).expect(0);
        std::fs::remove_file(&session).expect("removed");
    }
}

/// The first signal works while a guest hangs, also without a deadline.
#[test]
fn the_first_signal_ends_a_run_whose_guest_hangs() {
    let installed = Installed::awkward(MODULE);
    let session = installed.tree.path("hangs.session");
    let mut run = installed.command("loop process 20", &["run"]);
    run.args(MODULE.run)
        .args(["--no-deadline", "--no-pictures", "--session"])
        .arg(&session);
    run.stderr(Stdio::piped()).stdout(Stdio::null());
    let child = run.spawn().expect("it starts");
    // Long enough for 20 ticks; without a deadline it hangs from then on.
    std::thread::sleep(Duration::from_secs(4));
    let asked = Instant::now();
    let id = child.id().to_string();
    let killed = Command::new("kill").args(["-TERM", &id]).status();
    assert!(killed.expect("kill runs").success());
    let output = child.wait_with_output().expect("it ends");
    assert!(asked.elapsed() < Duration::from_secs(5));
    let printed = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{printed}");
    assert!(
        printed.contains("ended in `process` at tick 20"),
        "{printed}"
    );
    assert_eq!(read(&session).ticks.len(), 20);
}
