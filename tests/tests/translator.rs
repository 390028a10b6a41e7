//! The instrument and the tool know nothing of each other: config alone decides which device drives what.

use microsim_host::record::Session;
use microsim_message::{ToolSample, ToolStates, decode};
use microsim_tests::{RECORDING, finish, repository, scratch, tree};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// The built tree with level 1 of touch-spheres and the translator's file changed.
fn changed(
    level: impl Fn(&str) -> String,
    translator: impl Fn(&str) -> String,
) -> tempfile::TempDir {
    let root = scratch();
    let at = |path: &str| root.path().join(path);
    for name in ["plugins", "installed.b3"] {
        symlink(tree().join(name), at(name)).expect("a link");
    }
    let module = tree().join("modules/touch-spheres");
    fs::create_dir_all(at("modules/touch-spheres/levels")).expect("a folder");
    for entry in fs::read_dir(&module)
        .expect("the module")
        .flatten()
        .filter(|e| e.path().is_file())
    {
        symlink(
            entry.path(),
            at("modules/touch-spheres").join(entry.file_name()),
        )
        .expect("a link");
    }
    let text = fs::read_to_string(module.join("levels/level1.toml")).expect("the level");
    fs::write(at("modules/touch-spheres/levels/level1.toml"), level(&text)).expect("written");
    fs::create_dir(at("config")).expect("a folder");
    symlink(tree().join("config/tools"), at("config/tools")).expect("a link");
    symlink(tree().join("config/host.toml"), at("config/host.toml")).expect("a link");
    let text =
        fs::read_to_string(tree().join("config/translator.toml")).expect("the translator's file");
    fs::write(at("config/translator.toml"), translator(&text)).expect("written");
    root
}

/// All tool states and translated samples of the recorded hand on that tree.
fn played(root: &Path) -> (Vec<ToolStates>, Vec<ToolSample>) {
    let session = root.join("x.session");
    let mut run = Command::new(microsim_tests::program());
    run.current_dir(repository()).arg("--root").arg(root);
    microsim_tests::apart(&mut run);
    run.args([
        "run",
        "touch-spheres",
        "--json",
        "--input",
        RECORDING,
        "--session",
    ])
    .arg(&session);
    finish(&mut run).expect(0);
    let session = Session::read(&fs::read(&session).expect("read")).expect("a session");
    let frames = |log: &[u8]| -> Vec<(Option<ToolStates>, Option<ToolSample>)> {
        let frames = microsim_bus::Frames::new(log).filter_map(Result::ok);
        frames
            .map(|f| {
                (
                    decode(&f).and_then(Result::ok),
                    decode(&f).and_then(Result::ok),
                )
            })
            .collect()
    };
    let all = session.ticks.iter().flat_map(|(_, tick)| frames(&tick.log));
    let (states, samples): (Vec<_>, Vec<_>) = all.unzip();
    (
        states.into_iter().flatten().collect(),
        samples.into_iter().flatten().collect(),
    )
}

fn same(text: &str) -> String {
    text.to_owned()
}

#[test]
fn one_recording_drives_forceps_or_scissors_by_config_alone() {
    let scissors = |text: &str| text.replace("model = \"forceps\"", "model = \"micro-scissors\"");
    let (forceps, as_forceps) = played(changed(same, same).path());
    let (scissors, as_scissors) = played(changed(scissors, same).path());
    assert!(forceps.iter().all(|s| s.tools[0].model == "forceps"));
    assert!(
        scissors
            .iter()
            .all(|s| s.tools[0].model == "micro-scissors")
    );
    assert_eq!(as_forceps, as_scissors, "the motion is that of the hand");
    assert_eq!(
        as_forceps.len(),
        3466,
        "every sample of the recording (README beside it)"
    );
}

/// Scaling by a power of two is exact in binary numbers, whatever the positions are.
#[test]
fn the_scale_acts_on_positions_alone_and_opening_is_as_configured() {
    let twice = |text: &str| {
        text.replace("scale = 0.2", "scale = 0.4")
            .replace("opening = \"closed\"", "opening = 0.25")
    };
    let (_, once) = played(changed(same, same).path());
    let (_, twice) = played(changed(same, twice).path());
    for (a, b) in once.iter().zip(&twice) {
        assert_eq!(a.pose.position.map(|c| 2.0 * c), b.pose.position);
        assert_eq!(a.pose.orientation, b.pose.orientation);
        assert_eq!((a.opening, b.opening), (0.0, 0.25));
    }
}

/// A device that drives no tool of the level is left out, and the run goes on without it.
#[test]
fn a_device_without_a_tool_drives_nothing() {
    let other = |text: &str| text.replace("tool = \"right\"", "tool = \"left\"");
    let root = changed(same, other);
    let (states, samples) = played(root.path());
    assert!(samples.is_empty());
    let seen = |s: &ToolStates| s.tools[0].status != microsim_message::ToolStatus::NeverSeen;
    assert!(!states.iter().any(seen), "never seen, not merely lost");
}
