//! How a run can end early: stopped by a signal, or killed.

use microsim_host::record::{Ended, Session};
use microsim_tests::kill::{Moment, Target, moments};
use microsim_tests::{Finished, assert_verified, comb, command, report_beside, scratch};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for another process.
const PATIENCE: Duration = Duration::from_secs(20);

/// A paced run of the recorded hand, which would last 98 s.
fn long_run(session: &Path) -> Child {
    let mut run = command(["run", "touch-spheres", "--realtime", "--json", "--input"]);
    run.arg(microsim_tests::RECORDING)
        .arg("--session")
        .arg(session);
    run.stdout(Stdio::piped()).stderr(Stdio::piped());
    run.spawn().expect("the built program starts")
}

/// Waits until the session has this many ticks.
fn wait_for(session: &Path, ticks: usize) {
    let start = Instant::now();
    loop {
        let read = fs::read(session)
            .ok()
            .and_then(|bytes| Session::read(&bytes).ok());
        if read.is_some_and(|read| read.ticks.len() >= ticks) {
            return;
        }
        assert!(
            start.elapsed() < PATIENCE,
            "no {ticks} ticks in {}",
            session.display()
        );
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("sh")
        .arg("-c")
        .arg(format!("kill -{name} {}", child.id()))
        .status();
    assert!(sent.expect("a shell").success());
}

fn ends_in_order(signal_name: &str) {
    let folder = scratch();
    let session = folder.path().join("stopped.session");
    let child = long_run(&session);
    wait_for(&session, 50);
    signal(&child, signal_name);
    let start = Instant::now();
    let printed: Finished = child.wait_with_output().expect("the run ends").into();
    assert!(start.elapsed() < PATIENCE, "{signal_name} was not heard");
    let printed = printed.expect(0).json();
    assert_eq!(printed["verdict"], "aborted", "{printed}");
    assert_eq!(printed["counts"], false, "{printed}");

    let read = Session::read(&fs::read(&session).expect("a session")).expect("a session");
    assert_eq!(read.complaint, None);
    assert_eq!(read.end.map(|end| end.ended), Some(Ended::Result));
    assert_eq!(printed["ticks"].as_u64(), Some(read.ticks.len() as u64));
    let report = report_beside(&session);
    assert_eq!(report["verdict"], "aborted");
    assert_eq!(report["failed"], serde_json::json!(["aborted"]));
    assert_verified(&session);
}

#[test]
fn ctrl_c_ends_with_a_complete_session() {
    ends_in_order("INT");
}

#[test]
fn a_polite_kill_ends_with_a_complete_session() {
    ends_in_order("TERM");
}

#[test]
fn a_closed_terminal_ends_with_a_complete_session() {
    ends_in_order("HUP");
}

/// Verdict and page come before the pictures, and whoever does not want to wait for those is heard.
#[test]
fn ctrl_c_is_heard_while_pictures_of_the_report_are_drawn() {
    let folder = scratch();
    let session = folder.path().join("drawn.session");
    let mut run = command(["run", "coordination", "--require-pass", "--input"]);
    run.args(["script:level1-fail-not-gripped.toml", "--session"])
        .arg(&session);
    run.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = run.spawn().expect("the built program starts");
    let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    let mut told = |word: &str| {
        let line = lines.find(|line| line.as_ref().is_ok_and(|line| line.contains(word)));
        assert!(line.is_some(), "nothing said {word}");
    };
    told("FAILED");
    told("Report:");
    signal(&child, "INT");
    let start = Instant::now();
    let printed: Finished = child.wait_with_output().expect("the run ends").into();
    assert!(start.elapsed() < PATIENCE, "Ctrl-C was not heard");
    // The status that the run would have had.
    assert_eq!(printed.code, Some(1), "{printed:?}");
    let page = fs::read_to_string(session.with_extension("html")).expect("the page");
    assert!(
        page.contains("microsim report SI") || page.contains("microsim report SE"),
        "the page says how to draw what is missing"
    );
    assert_eq!(report_beside(&session)["verdict"], "failed");
    assert_verified(&session);
}

/// A hundred snips of scissors into a band, in the built program: every one lays tissue open, the session verifies, and killed in ticks that cut
/// it is readable, verifies and has lost that tick at most. A sample of what `cargo xtask soak kills` does as well.
#[test]
fn a_session_of_a_hundred_cuts_verifies_and_survives_kills() {
    let target = Target::comb(101);
    let session = target.whole("comb");
    let cuts = comb::cuts(&session);
    let snips = comb::snips(&cuts);
    println!("{} cuts in {snips} snips", cuts.len());
    assert!(cuts.len() >= 100 && snips >= 100, "{} {snips}", cuts.len());
    assert!(target.verifies(&session));
    let mut in_cuts = 0;
    for (n, part) in [(0, 30), (1, 20), (2, 10)] {
        let (tick, _) = cuts[cuts.len() / part];
        let remains = target.kill_in(n, tick, Duration::from_millis(n as u64));
        println!("killed in tick {tick}: {remains:?}");
        assert!(remains.readable && remains.verified, "{remains:?}");
        assert!(remains.lost() <= 1, "{remains:?}");
        let cut = |tick| cuts.iter().any(|(of, _)| *of == tick);
        in_cuts += usize::from(remains.unfinished().is_some_and(cut));
    }
    assert!(in_cuts >= 1, "no kill fell into a tick that cuts");
}

/// A sample of what `cargo xtask soak kills` does 200 times.
#[test]
fn a_killed_run_leaves_a_readable_session() {
    let target = Target::new(1.0, true);
    let mut running = 0;
    for (n, delay) in moments(Duration::from_secs(1), 6).into_iter().enumerate() {
        let remains = target.kill(n, delay);
        println!("killed after {delay:?}: {remains:?}");
        if remains.moment == Moment::Starting {
            continue;
        }
        running += 1;
        assert!(remains.readable && remains.verified, "{remains:?}");
        assert!(remains.on_file <= remains.begun, "{remains:?}");
        // At most 100 ms of simulated time: twelve ticks.
        assert!(remains.lost() as f64 * target.tick <= 0.1, "{remains:?}");
    }
    // A run lasts longer than the second over which the moments are spread, and starts in far less than half of one.
    assert!(
        running >= 3,
        "{running} of 6 runs were killed while running"
    );
}
