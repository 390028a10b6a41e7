//! Save, new process, restore, go on: the same history as without the interruption.

use crate::{PUSH_STRIP, TOUCH_SPHERES, pushed_strip};
use microsim_bus::Frames;
use microsim_host::Checkpoint;
use microsim_host::record::{Session, TickRecord};
use microsim_message::{ContactForces, decode, decode_bytes, encode};
use microsim_random::SplitMix64;
use microsim_session::{read_checkpoint, write_checkpoint};
use microsim_tests::{assert_verified, command, finish, run, scratch};
use std::path::Path;

fn path(path: &Path) -> &str {
    path.to_str().expect("a temporary path is UTF-8")
}

fn goes_on(module: &str, args: &[&str], seconds: &[&str]) {
    let folder = scratch();
    let whole = run(module, &folder.path().join("whole.session"), args);
    let whole = ["state_hash", "score", "failed", "verdict", "ticks"].map(|k| whole[k].clone());
    for (n, seconds) in seconds.iter().enumerate() {
        let checkpoint = folder.path().join(format!("{n}.checkpoint"));
        let first = folder.path().join(format!("{n}-first.session"));
        let stop = ["--stop-at", seconds, "--checkpoint", path(&checkpoint)];
        let stopped = run(module, &first, &[args, &stop].concat());
        // A tick is 8 ms long in every level of both modules.
        let ticks = (seconds.parse::<f64>().expect("seconds") / 0.008).round();
        assert_eq!(stopped["ticks"].as_f64(), Some(ticks), "{stopped}");
        assert_verified(&first);

        let second = folder.path().join(format!("{n}-second.session"));
        let resume = ["--resume", path(&checkpoint), "--threads", "2"];
        let resumed = run(module, &second, &[args, &resume].concat());
        let resumed =
            ["state_hash", "score", "failed", "verdict", "ticks"].map(|k| resumed[k].clone());
        assert_eq!(resumed, whole, "{module}, interrupted at {seconds} s");
        assert_verified(&second);
    }
}

#[test]
fn touch_spheres_goes_on_from_a_checkpoint() {
    goes_on(
        "touch-spheres",
        &TOUCH_SPHERES,
        &["0.008", "12.344", "97.6"],
    );
}

/// Before the probe comes, in the first touches and while it holds the depth.
#[test]
fn push_strip_goes_on_from_a_checkpoint() {
    goes_on("push-strip", &PUSH_STRIP, &["0.4", "2.48", "3.2"]);
    // The times are those of this script: the first touch lies between the first two of them.
    let session = Session::read(pushed_strip()).expect("a session");
    let touches = |record: &TickRecord| {
        let mut frames = Frames::new(&record.log).filter_map(Result::ok);
        frames.any(|frame| decode::<ContactForces>(&frame).is_some())
    };
    let first = session.ticks.iter().find(|(_, record)| touches(record));
    let first = first.map_or(0.0, |(tick, _)| *tick as f64 * 0.008);
    assert!((0.4..2.48).contains(&first), "first touch at {first} s");
}

/// An explicit method, with the forces of the dissertation: what it remembers of a step is in the checkpoint, too.
#[test]
fn an_explicit_method_goes_on_from_a_checkpoint() {
    let script = "script:level2-fail-dwell-too-short.toml";
    let args = [
        "--level",
        "2",
        "--variant",
        "dissertation",
        "--input",
        script,
    ];
    goes_on("push-strip", &args, &["2.48"]);
}

#[test]
fn a_checkpoint_of_another_run_is_refused() {
    let folder = scratch();
    let checkpoint = folder.path().join("there.checkpoint");
    let stop = ["--stop-at", "1", "--checkpoint", path(&checkpoint)];
    let first = folder.path().join("first.session");
    run(
        "touch-spheres",
        &first,
        &[&TOUCH_SPHERES[..], &stop].concat(),
    );

    let script = ["--input", "script:level1-pass.toml"];
    let others = [
        [&TOUCH_SPHERES[..], &["--level", "2"]].concat(),
        [&TOUCH_SPHERES[..], &["--seed", "2"]].concat(),
        script.to_vec(),
    ];
    for (n, args) in others.into_iter().enumerate() {
        let session = folder.path().join(format!("{n}.session"));
        let mut command = command(["run", "touch-spheres", "--resume", path(&checkpoint)]);
        let printed = finish(command.arg("--session").arg(&session).args(args)).expect(2);
        assert!(
            printed.err.contains("belongs to another module, level, "),
            "{printed:?}"
        );
    }

    // The first checkpoint is not written over either.
    let again = folder.path().join("again.session");
    let mut command = command(["run", "touch-spheres", "--session"]);
    let printed = finish(command.arg(again).args(TOUCH_SPHERES).args(stop)).expect(2);
    assert!(printed.err.contains("there.checkpoint"), "{printed:?}");
}

/// The host itself remembers that the input has ended and what it has published to the module: every tick around the end.
#[test]
fn the_last_ticks_go_on_as_well() {
    let args = ["--input", "script:level1-fail-dwell-too-short.toml"];
    let folder = scratch();
    let whole = run("touch-spheres", &folder.path().join("whole.session"), &args);
    let ticks = whole["ticks"].as_u64().expect("a number");
    let seconds: Vec<String> = (1..=4)
        .map(|back| format!("{:.3}", (ticks - back) as f64 * 0.008))
        .collect();
    let seconds: Vec<&str> = seconds.iter().map(String::as_str).collect();
    goes_on("touch-spheres", &args, &seconds);
}

/// A run from these bytes: refused before anything runs, so that no session is there. Returns the complaint.
#[track_caller]
fn refused(folder: &Path, bytes: &[u8]) -> String {
    let checkpoint = folder.join("wrong.checkpoint");
    std::fs::write(&checkpoint, bytes).expect("a file");
    let session = folder.join("wrong.session");
    let mut command = command(["run", "push-strip", "--resume", path(&checkpoint)]);
    let printed = finish(command.arg("--session").arg(&session).args(PUSH_STRIP)).expect(2);
    assert!(!session.exists() && printed.out.is_empty(), "{printed:?}");
    printed.err
}

/// Of 14 single flipped bits ten once ran to a pass, nine of them with a wrong hash.
#[test]
fn a_checkpoint_with_a_flipped_bit_is_refused() {
    let folder = scratch();
    let checkpoint = folder.path().join("there.checkpoint");
    let stop = ["--stop-at", "2.48", "--checkpoint", path(&checkpoint)];
    let first = folder.path().join("first.session");
    let stopped = run("push-strip", &first, &[&PUSH_STRIP[..], &stop].concat());
    let bytes = std::fs::read(&checkpoint).expect("a checkpoint");
    let mut random = SplitMix64(7);
    for _ in 0..40 {
        let bit = random.below(8 * bytes.len() as u64) as usize;
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let complaint = refused(folder.path(), &flipped);
        assert!(
            complaint.contains("wrong.checkpoint: "),
            "bit {bit}: {complaint}"
        );
    }
    // As checkpoints were before they had a digest.
    let payload = read_checkpoint(&bytes).expect("a checkpoint");
    let complaint = refused(folder.path(), payload);
    assert!(
        complaint.contains("not a checkpoint of this version"),
        "{complaint}"
    );

    // With the digest computed again, but another hash: the state must be that of the session that stopped there.
    let mut saved: Checkpoint = decode_bytes(payload).expect("a checkpoint");
    let hash = microsim_host::record::hex(&saved.state_hash);
    assert_eq!(stopped["state_hash"], hash.as_str());
    saved.state_hash[5] ^= 1;
    let complaint = refused(folder.path(), &write_checkpoint(&encode(&saved)));
    assert!(
        complaint.contains("state hash that was recorded"),
        "{complaint}"
    );
}
