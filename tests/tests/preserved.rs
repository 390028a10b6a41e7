//! What is on disk stays: names do not collide, nothing is overwritten, and a session that proves nothing is not
//! called verified.

use microsim_tests::{command, finish, microsim, run, scratch, tree, verify};
use std::fs;

const INPUT: [&str; 2] = ["--input", "script:level1-fail-targets-missed.toml"];

/// A report lies beside its session, whatever the session is called, and never takes the place of another one.
#[test]
fn a_report_never_falls_on_a_session() {
    let folder = scratch();
    let names = ["a.json", "a.html", "a.b"];
    for name in names {
        run("touch-spheres", &folder.path().join(name), &INPUT);
    }
    // The reports of these two would take the places of the first two.
    for name in ["a", "a.session"] {
        let mut refused = command(["run", "touch-spheres", "--session"]);
        refused.arg(folder.path().join(name)).args(INPUT);
        let printed = finish(&mut refused).expect(2);
        assert!(printed.err.contains("is a session"), "{}", printed.err);
    }
    for name in names {
        verify(&folder.path().join(name), &[]).expect(0);
    }
    let session = folder.path().join("a.b");
    let path = session.to_str().expect("UTF-8");
    let printed = microsim(["report", path, "--html", path]).expect(2);
    assert!(
        printed.err.contains("would overwrite the session"),
        "{}",
        printed.err
    );
    verify(&session, &[]).expect(0);
}

/// Operators start runs side by side without naming sessions.
#[test]
fn runs_side_by_side_have_names_of_their_own() {
    let runs: Vec<_> = (0..8)
        .map(|_| {
            let mut run = command(["run", "touch-spheres", "--json"]);
            run.args(INPUT).stdout(std::process::Stdio::piped());
            run.spawn().expect("the built program starts")
        })
        .collect();
    let mut sessions: Vec<String> = runs
        .into_iter()
        .map(|run| {
            let printed: microsim_tests::Finished = run.wait_with_output().expect("it ends").into();
            printed.expect(0).json()["session"]
                .as_str()
                .expect("a path")
                .to_owned()
        })
        .collect();
    for session in &sessions {
        assert!(
            session.starts_with(tree().to_str().expect("UTF-8")),
            "{session}"
        );
        for ending in ["session", "html", "json", "metrics.csv", "series.csv"] {
            let path = std::path::Path::new(session).with_extension(ending);
            fs::remove_file(path).expect("every run has left its own files");
        }
    }
    sessions.sort();
    sessions.dedup();
    assert_eq!(sessions.len(), 8);
}

/// Old pictures, checkpoints and sessions stay as they are, and the run does not even begin.
#[test]
fn what_is_there_is_refused_before_the_run() {
    let folder = scratch();
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    fs::write(path("old.checkpoint"), b"old").expect("written");
    fs::create_dir(path("frames")).expect("a folder");
    fs::write(path("frames/frame-000003.png"), b"old").expect("written");
    let session = path("new.session");
    for extra in [
        vec![
            "--stop-at".into(),
            "0.1".into(),
            "--checkpoint".into(),
            path("old.checkpoint"),
        ],
        vec![
            "--stop-at".into(),
            "0.1".into(),
            "--checkpoint".into(),
            session.clone(),
        ],
        vec!["--frames".into(), path("frames")],
    ] {
        let mut run = command(["run", "touch-spheres", "--session", &session]);
        let printed = finish(run.args(INPUT).args(&extra)).expect(2);
        assert!(
            !printed.err.is_empty() && !folder.path().join("new.session").exists(),
            "{extra:?}"
        );
    }
    assert_eq!(fs::read(path("old.checkpoint")).expect("there"), b"old");
    assert_eq!(
        fs::read(path("frames/frame-000003.png")).expect("there"),
        b"old"
    );
}

/// Pictures of two computations in one folder cannot be distinguished, and what a refused command was to replace stays.
#[test]
fn pictures_and_results_of_an_earlier_scene_stay() {
    let folder = scratch();
    let (frames, result) = (folder.path().join("frames"), folder.path().join("old.json"));
    fs::create_dir(&frames).expect("a folder");
    fs::write(frames.join("frame-000000.png"), b"old").expect("written");
    fs::write(&result, b"old").expect("written");
    let mut simulate = command(["simulate", "cantilever", "--frames"]);
    let printed = finish(simulate.arg(&frames).arg("--json").arg(&result)).expect(2);
    assert!(
        printed.err.contains("holds pictures already") && printed.out.is_empty(),
        "{printed:?}"
    );
    let read = |path| fs::read(path).expect("there");
    assert_eq!(read(frames.join("frame-000000.png")), b"old");
    assert_eq!(read(result), b"old");
    assert_eq!(fs::read_dir(frames).expect("a folder").count(), 1);
}

/// A run that was recorded is not one that could not run: its status means that only the report is missing.
#[test]
fn a_report_that_cannot_be_written_has_a_status_of_its_own() {
    let folder = scratch();
    let session = folder.path().join("x.session");
    fs::create_dir(folder.path().join("x.html")).expect("a folder in the page's place");
    let mut run = command(["run", "touch-spheres", "--session"]);
    let printed = finish(run.arg(&session).args(INPUT)).expect(3);
    assert!(
        printed.err.contains("x.html") && printed.err.contains("the session is safe in"),
        "{printed:?}"
    );
    assert!(printed.out.contains("FAILED"), "{printed:?}");
    verify(&session, &[]).expect(0);
    // Elsewhere there is room for it.
    let mut report = command(["report".as_ref(), session.as_os_str(), "--html".as_ref()]);
    finish(report.arg(folder.path().join("y.html"))).expect(0);
}

/// A flipped bit in the middle and a file without a tick are no proof, whatever the rest holds.
#[test]
fn what_proves_nothing_is_not_verified() {
    let folder = scratch();
    let path = folder.path().join("x.session");
    run("touch-spheres", &path, &INPUT);
    verify(&path, &[]).expect(0);
    let bytes = fs::read(&path).expect("read");
    let mut flipped = bytes.clone();
    flipped[bytes.len() / 2] ^= 1;
    fs::write(&path, &flipped).expect("written");
    let printed = verify(&path, &[]).expect(1).json();
    assert!(
        printed["ticks"].as_u64().expect("a number") > 0 && printed["verified"] == false,
        "{printed}"
    );
    let reading = microsim_session::read(&bytes).expect("a session");
    fs::write(&path, &bytes[..reading.frames[1].offset]).expect("written");
    let printed = verify(&path, &[]).expect(1).json();
    assert_eq!(
        (printed["ticks"].as_u64(), &printed["verified"]),
        (Some(0), &false.into())
    );
}

/// Where a recording lies is not part of what is computed.
#[test]
fn the_hash_does_not_depend_on_how_a_path_is_spelled() {
    let folder = scratch();
    let path = "assets/recordings/cataract-stylus/stylus.csv";
    let absolute = microsim_tests::repository().join(path);
    let spellings = [
        path.to_owned(),
        format!("./{path}"),
        absolute.display().to_string(),
    ];
    let hashes = spellings.iter().enumerate().map(|(n, spelling)| {
        let session = folder.path().join(format!("{n}.session"));
        let input = format!("recording:{spelling}");
        run("touch-spheres", &session, &["--input", &input])["state_hash"].clone()
    });
    let hashes: Vec<_> = hashes.collect();
    assert!(
        hashes.iter().all(|h| *h == hashes[0] && h.is_string()),
        "{hashes:?}"
    );
}
