//! A store that is locked, read-only, on a full disk, of a later version or damaged: session and report are complete, the message states what to do,
//! and a rebuild enters what is missing.

use microsim_tests::stations::Station;
use microsim_tests::{Finished, assert_verified, finish, report_beside};
use rusqlite::Connection;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// A run whose result could not be entered: it ends well, session and report are there, the reason is named.
#[track_caller]
fn assert_warned(station: &Station, name: &str, run: Finished, why: &str) {
    let run = run.expect(0);
    assert_eq!(run.json()["stored"], false, "{run:?}");
    let warned = run.err.contains("the result is not in the store") && run.err.contains(why);
    assert!(
        warned && run.err.contains("microsim store rebuild"),
        "{}",
        run.err
    );
    assert_verified(&station.session(name));
    assert_eq!(report_beside(&station.session(name))["verdict"], "passed");
}

/// What could not be entered is entered by a rebuild.
#[track_caller]
fn assert_rebuilt(station: &Station, sessions: usize) {
    station.microsim(&["store", "rebuild"]).expect(0);
    assert_eq!(station.results().len(), sessions);
}

#[test]
fn a_locked_store_costs_no_session() {
    let station = Station::new();
    station.add("A. Muster");
    let other = Connection::open(station.store()).expect("a database");
    other.execute_batch("BEGIN IMMEDIATE").expect("a lock");
    // The name can be looked up all the same.
    let run = finish(&mut station.run("1", "pass", &["--trainee", "A. Muster"]));
    assert_warned(&station, "1", run, "locked by another process");
    other.execute_batch("COMMIT").expect("released");
    assert_rebuilt(&station, 1);
    let found = station
        .microsim(&["results", "--trainee", "A. Muster", "--json"])
        .expect(0)
        .json();
    assert_eq!(found["results"].as_array().map(Vec::len), Some(1));
}

/// As a user who may not write it; root may write everything.
#[test]
fn a_read_only_store_costs_no_session_and_can_be_read() {
    let station = Station::new();
    station.add("A. Muster");
    finish(&mut station.run("1", "pass", &["--trainee", "A. Muster"])).expect(0);
    let mode = |path: &std::path::Path, mode| {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("set");
    };
    mode(station.folder(), 0o755);
    mode(&station.data().join("sessions"), 0o777);
    mode(&station.store(), 0o444);
    mode(&station.data(), 0o555);
    let is_root =
        fs::metadata("/proc/self").is_ok_and(|m| std::os::unix::fs::MetadataExt::uid(&m) == 0);
    let as_other = |command: &mut Command| {
        // Of a key that only its owner may read nothing is known.
        command.env("MICROSIM_STATION_KEY", station.folder().join("none.key"));
        if is_root {
            command.uid(65_534).gid(65_534);
        }
        finish(command)
    };
    let run = as_other(&mut station.run("2", "pass", &[]));
    let found = as_other(&mut station.command(&["results", "--trainee", "A. Muster", "--json"]));
    mode(&station.data(), 0o755);
    mode(&station.store(), 0o600);
    let run = run.expect(0);
    assert_eq!(run.json()["stored"], false, "{run:?}");
    assert!(
        run.err.contains("the result is not in the store") && run.err.contains("read-only"),
        "{}",
        run.err
    );
    assert_eq!(
        found.expect(0).json()["results"].as_array().map(Vec::len),
        Some(1)
    );
    assert_rebuilt(&station, 2);
}

/// The store lies on a file system of its own without room, in a mount namespace; where the system lets nobody make one, nothing is shown, and that is printed.
#[test]
fn a_full_disk_costs_no_session() {
    let station = Station::new();
    let run = station.run("1", "pass", &[]);
    let program: Vec<String> = std::iter::once(run.get_program())
        .chain(run.get_args())
        .map(|word| word.to_str().expect("text").to_owned())
        .collect();
    let data = station.folder().join("small");
    fs::create_dir(&data).expect("a folder");
    // 48 KiB: the file and a log of a few pages, not the tables.
    let script = format!(
        "mount -t tmpfs -o size=48k tmpfs '{0}' || exit 77; MICROSIM_DATA='{0}' exec \"$@\"",
        data.display()
    );
    let mut isolated = Command::new("unshare");
    isolated
        .args(["--mount", "--map-root-user", "sh", "-c", &script, "sh"])
        .args(&program);
    isolated.current_dir(microsim_tests::repository());
    isolated.env("MICROSIM_STATION_KEY", microsim_tests::station_key());
    let run = match isolated.output() {
        Ok(output) => Finished::from(output),
        Err(why) => return println!("skipped: unshare cannot be run ({why})"),
    };
    if run.code == Some(77) || run.err.contains("unshare") {
        return println!("skipped: no mount namespaces here ({})", run.err.trim());
    }
    assert_warned(&station, "1", run, "the disk is full");
    assert_rebuilt(&station, 1);
}

#[test]
fn a_store_of_a_later_version_is_left_alone() {
    let station = Station::new();
    station.add("A. Muster");
    let other = Connection::open(station.store()).expect("a database");
    other.pragma_update(None, "user_version", 7).expect("set");
    other
        .query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(()))
        .expect("written");
    drop(other);
    let before = fs::read(station.store()).expect("a file");
    let run = finish(&mut station.run("1", "pass", &[]));
    assert_warned(
        &station,
        "1",
        run,
        "version 7 and this MicroSim knows versions up to 2",
    );
    for args in [
        &["results"][..],
        &["store", "rebuild"],
        &["trainees", "add", "B"],
        &["store", "check"],
    ] {
        let refused = station.microsim(args).expect(2);
        assert!(
            refused.err.contains("version 7"),
            "{args:?}: {}",
            refused.err
        );
    }
    assert_eq!(fs::read(station.store()).expect("a file"), before);
}

/// Noise over a page of the table of sessions: found by a check, exported as far as it is intact, put aside by a rebuild that has all sessions again.
#[test]
fn a_damaged_store_is_found_put_aside_and_made_again() {
    let station = Station::new();
    station.add("A. Muster");
    station
        .microsim(&["trainees", "group", "2026", "--add", "A. Muster"])
        .expect(0);
    for n in 0..4 {
        finish(&mut station.run(&n.to_string(), "pass", &["--trainee", "A. Muster"])).expect(0);
    }
    let results = station.results();
    station.microsim(&["store", "vacuum"]).expect(0);
    let root: i64 = {
        let store = Connection::open(station.store()).expect("a database");
        let sql = "SELECT rootpage FROM sqlite_schema WHERE name = 'session'";
        store.query_row(sql, [], |row| row.get(0)).expect("a page")
    };
    let mut bytes = fs::read(station.store()).expect("a file");
    let page = 4096 * (root as usize - 1);
    bytes[page..page + 4096].fill(0xa5);
    fs::write(station.store(), &bytes).expect("written");
    let checked = station
        .microsim(&["store", "check", "--json"])
        .expect(1)
        .json();
    assert!(
        checked["problems"]
            .as_array()
            .is_some_and(|p| !p.is_empty()),
        "{checked}"
    );
    let asked = station.microsim(&["results"]).expect(2);
    assert!(
        asked.err.contains("is damaged") && asked.err.contains("store export"),
        "{}",
        asked.err
    );
    let run = finish(&mut station.run("4", "pass", &[]));
    assert_warned(&station, "4", run, "is damaged");
    let export = station.folder().join("intact.json");
    let exported = station
        .microsim(&["store", "export", export.to_str().expect("text"), "--json"])
        .expect(1)
        .json();
    assert_eq!(
        (&exported["trainees"], &exported["sessions"]),
        (&1.into(), &0.into())
    );
    let rebuilt = station
        .microsim(&["store", "rebuild", "--json"])
        .expect(0)
        .json();
    let aside = rebuilt["put_aside"].as_str().expect("a file").to_owned();
    assert_eq!(fs::read(aside).expect("a file").len(), bytes.len());
    let again = station.results();
    // Runs of the same second are in the order of their random ids.
    let earlier: Vec<_> = again.iter().filter(|r| results.contains(r)).collect();
    assert_eq!(earlier, results.iter().collect::<Vec<_>>());
    assert_eq!(again.len(), 5);
    let listed = station
        .microsim(&["trainees", "list", "--group", "2026", "--json"])
        .expect(0)
        .json();
    assert_eq!(listed["trainees"][0]["name"], "A. Muster");
    station.microsim(&["store", "check"]).expect(0);
}

/// Two programs that write one store at the same time, many times.
#[test]
fn two_processes_work_on_one_store() {
    let station = Station::new();
    let add = |name: String| {
        let mut command = station.command(&["trainees", "add", &name]);
        command.spawn().expect("the built program starts")
    };
    for n in 0..10 {
        for mut child in [add(format!("A {n}")), add(format!("B {n}"))] {
            assert!(child.wait().expect("a process").success());
        }
    }
    let listed = station
        .microsim(&["trainees", "list", "--json"])
        .expect(0)
        .json();
    assert_eq!(listed["trainees"].as_array().map(Vec::len), Some(20));
    station.microsim(&["store", "check"]).expect(0);
}
