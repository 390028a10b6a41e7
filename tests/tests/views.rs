//! Views of what is computed: a run with them is the run without them, and what cannot be shown is refused before anything is computed.

use microsim_tests::{command, finish, microsim, run, scratch, verify};
use std::fs;

const INPUT: [&str; 2] = ["--input", "script:level1-pass.toml"];

/// The state hash of a run does not depend on what its pictures show; the session of a run with views is recomputed to the bit, also while other views are drawn of it. Where there is a
/// graphics driver the pictures are those of the views: at the last tick another one than without.
#[test]
fn views_change_nothing_but_pictures() {
    let folder = scratch();
    let path = |name: &str| folder.path().join(name);
    let text = |name: &str| path(name).to_str().expect("UTF-8").to_owned();
    let short = ["--stop-at", "0.4", "--frame-rate", "5", "--no-store"];
    let with = |name: &str, views: &[&str]| {
        let checkpoint = text(&format!("{name}.checkpoint"));
        let frames = text(name);
        let mut args = vec!["--checkpoint", &checkpoint, "--frames", &frames];
        args.extend(INPUT.iter().chain(&short).chain(views));
        run("push-strip", &path(&format!("{name}.session")), &args)
    };
    let plain = with("plain", &[]);
    let seen = with(
        "seen",
        &[
            "--view",
            "stress",
            "--view",
            "wireframe",
            "--view",
            "contacts",
        ],
    );
    assert_eq!(seen["state_hash"], plain["state_hash"]);
    assert_eq!(seen["physics_digest"], plain["physics_digest"]);
    let session = path("seen.session");
    let again = text("again");
    let others = [
        "--frames",
        &again,
        "--frame-rate",
        "5",
        "--view",
        "remedies",
        "--view",
        "capsules",
    ];
    verify(&session, &others).expect(0);
    verify(&session, &[]).expect(0);
    if plain["pictures"]["off"].is_string() {
        println!("skipped: no graphics driver: {}", plain["pictures"]["off"]);
        return;
    }
    let picture =
        |folder: &str| fs::read(path(folder).join("frame-000001.png")).expect("a picture");
    assert_ne!(picture("plain"), picture("seen"));
    assert_ne!(picture("plain"), picture("again"));
    assert_ne!(picture("seen"), picture("again"));
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let folder = scratch();
    let frames = folder.path().join("frames");
    let frames = frames.to_str().expect("UTF-8");
    let two = ["--frames", frames, "--view", "stress", "--view", "quality"];
    let refused = |args: &[&str]| {
        let mut command = command(args);
        finish(&mut command).expect(2).err
    };
    let session = folder.path().join("a.session");
    let session = session.to_str().expect("UTF-8");
    let begin = ["run", "push-strip", "--session", session];
    let why = refused(&[&begin[..], &INPUT, &two].concat());
    assert!(
        why.contains("--view stress, --view quality: surfaces have one colour"),
        "{why}"
    );
    assert!(!folder.path().join("a.session").exists());
    let why = refused(&[
        "simulate",
        "cantilever",
        "--frames",
        frames,
        "--view",
        "contacts",
    ]);
    assert!(why.contains("pictures of a scene show wireframe"), "{why}");
    // What is laid over pictures needs pictures, and has a name.
    let why = refused(&[&begin[..], &INPUT, &["--view", "stress"]].concat());
    assert!(why.contains("--frames"), "{why}");
    let why = microsim(["simulate", "cantilever", "--frames", frames, "--view", "x"])
        .expect(2)
        .err;
    assert!(why.contains("wireframe, capsules, no-return"), "{why}");
}
