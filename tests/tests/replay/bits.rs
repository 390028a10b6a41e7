//! One state hash and one score in every process, whatever the threads, the locale and the pictures.

use crate::{PUSH_STRIP, TOUCH_SPHERES};
use microsim_host::record::{EndRecord, Session, TickRecord};
use microsim_tests::{assert_verified, command, finish, report_beside, scratch, verify};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Runs in fresh processes.
const RUNS: usize = 20;

/// All that must not differ between two runs of the same.
fn outcome(printed: &Value, report: &Value) -> Value {
    let keys = [
        "state_hash",
        "verdict",
        "failed",
        "score",
        "ticks",
        "targets_done",
    ];
    json!({
        "printed": (keys.map(|key| printed[key].clone())),
        "metrics": report["metrics"],
        "categories": report["categories"],
    })
}

/// All that a replay looks at. Equal histories verify alike.
fn history(session: &Path) -> (Vec<(u64, TickRecord)>, Option<EndRecord>) {
    let session = Session::read(&fs::read(session).expect("a session")).expect("a session");
    (session.ticks, session.end)
}

fn one_outcome(module: &str, args: &[&str]) {
    let folder = scratch();
    let mut first = None;
    let mut pictures = 0;
    for n in 0..RUNS {
        let session = folder.path().join(format!("{n}.session"));
        let mut run = command(["run", module, "--json", "--session"]);
        run.arg(&session).args(args);
        run.args(["--threads", if n % 2 == 0 { "1" } else { "2" }]);
        run.env("LC_ALL", if n % 4 < 2 { "C" } else { "de_DE.UTF-8" });
        // Pictures take far longer than the run: four of the runs draw, with each number of threads and each locale.
        let draws = n % 5 == 3;
        if draws {
            let frames = folder.path().join(format!("{n}.frames"));
            run.arg("--frames")
                .arg(frames)
                .args(["--frame-rate", "0.1"]);
        }
        let printed = finish(&mut run).expect(0).json();
        let outcome = (
            outcome(&printed, &report_beside(&session)),
            history(&session),
        );
        let first = first.get_or_insert_with(|| outcome.clone());
        assert_eq!(outcome.0, first.0, "run {n}");
        assert!(outcome.1 == first.1, "run {n}: another history");
        if draws {
            let drawn = &printed["pictures"];
            if let Some(off) = drawn["off"].as_str() {
                println!("{module}: pictures are left out of this comparison: {off}");
            } else {
                assert_ne!(drawn["written"], 0, "{drawn}");
            }
            pictures += drawn["written"].as_u64().unwrap_or_default();
        }
    }
    println!("{module}: {RUNS} processes, {pictures} pictures, one outcome");
    assert_verified(&folder.path().join("0.session"));
    let last = folder.path().join(format!("{}.session", RUNS - 1));
    verify(&last, &["--threads", "2"]).expect(0);
}

#[test]
fn touch_spheres_has_one_outcome_in_twenty_processes() {
    one_outcome("touch-spheres", &TOUCH_SPHERES);
}

#[test]
fn push_strip_has_one_outcome_in_twenty_processes() {
    one_outcome("push-strip", &PUSH_STRIP);
}

/// The comparison above would also hold if the hash were a constant.
#[test]
fn another_seed_has_another_outcome() {
    let folder = scratch();
    let hash = |seed: &str| {
        let session = folder.path().join(format!("{seed}.session"));
        let args = [TOUCH_SPHERES.as_slice(), &["--seed", seed]].concat();
        microsim_tests::run("touch-spheres", &session, &args)["state_hash"].clone()
    };
    assert_ne!(hash("1"), hash("2"));
}
