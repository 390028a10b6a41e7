//! Where files lie: those of a user in his folders, and nothing in the installation, whatever the command.

#[path = "plugins/tree.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod tree;

use microsim_tests::{Finished, finish, repository, scratch};
use std::collections::BTreeMap;
use std::fs::{self, Permissions};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use tree::Tree;

/// The user `nobody`, for whom what is read-only is read-only.
const NOBODY: u32 = 65_534;

const SCRIPT: &str = "script:level1-pass.toml";

/// The installation with a user whose folders are all below one.
struct Station {
    tree: Tree,
    data: tempfile::TempDir,
}

impl Station {
    fn new() -> Self {
        Self {
            tree: Tree::new(),
            data: scratch(),
        }
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = self.tree.command(args);
        command.env("MICROSIM_DATA", self.data.path());
        command.env_remove("MICROSIM_STATION_KEY");
        command
    }

    fn microsim(&self, args: &[&str]) -> Finished {
        finish(&mut self.command(args))
    }

    fn write(&self, below: &str, text: &str) -> PathBuf {
        let path = self.data.path().join(below);
        fs::create_dir_all(path.parent().expect("a folder above")).expect("the folder is made");
        fs::write(&path, text).expect("the file is written");
        path
    }
}

/// Every file and folder below one, with what changes when it is written: length, time of change, number of the file.
fn listing(folder: &Path) -> BTreeMap<PathBuf, (u64, i64, i64, u64)> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let of = path.symlink_metadata().expect("it is there");
            found.insert(
                path.clone(),
                (of.len(), of.mtime(), of.mtime_nsec(), of.ino()),
            );
            if of.is_dir() {
                folders.push(path);
            }
        }
    }
    found
}

fn read_only(folder: &Path) {
    for (path, _) in listing(folder).iter().rev() {
        let mode = path.metadata().expect("it is there").mode();
        // Links are to the built tree, which others use.
        if path.is_dir() {
            let mode = Permissions::from_mode(mode & 0o555 | 0o555);
            fs::set_permissions(path, mode).expect("set");
        }
    }
    fs::set_permissions(folder, Permissions::from_mode(0o555)).expect("set");
}

/// All that people do, by a user who may write into his own folder alone. Where the tests run as root, that user is `nobody`: root may
/// write everywhere. In any case nothing in the installation is another than before.
#[test]
fn a_read_only_installation_does_all() {
    let station = Station::new();
    let root = station.tree.path("");
    // As installed: the program beside its folders.
    fs::copy(microsim_tests::program(), root.join("microsim")).expect("it is copied");
    fs::create_dir(root.join("assets")).expect("a folder");
    read_only(&root);
    let before = listing(&root);
    let user = station.data.path();
    fs::set_permissions(user, Permissions::from_mode(0o777)).expect("set");
    let data = user.join("data");
    // The owner of a process's folder is its user.
    let is_root = fs::metadata("/proc/self").is_ok_and(|own| own.uid() == 0);
    let run = |args: &[&str]| {
        let mut command = Command::new(root.join("microsim"));
        command.args(args).current_dir(user);
        command.env("MICROSIM_DATA", &data).env("HOME", user);
        command.env_remove("MICROSIM_STATION_KEY");
        if is_root {
            command.uid(NOBODY).gid(NOBODY);
        }
        finish(&mut command)
    };
    if !is_root {
        let refused = fs::write(root.join("x"), "").expect_err("read-only");
        assert_eq!(refused.kind(), std::io::ErrorKind::PermissionDenied);
    }
    run(&["doctor"]).expect(0);
    run(&["list"]).expect(0);
    let printed = run(&["run", "touch-spheres", "--input", SCRIPT, "--json"]).expect(0);
    let session = printed.json()["session"]
        .as_str()
        .expect("a path")
        .to_owned();
    assert!(
        Path::new(&session).starts_with(data.join("sessions")),
        "{session}"
    );
    run(&["report", &session, "--html", "page.html"]).expect(0);
    run(&["replay", &session, "--verify"]).expect(0);
    let chart = [
        "chart", "--quick", "--scene", "stretch", "--out", "chart", "--json",
    ];
    let chart = run(&chart).expect(0).json();
    assert!(
        !chart["runs"].as_array().expect("a list").is_empty(),
        "{chart}"
    );
    run(&["simulate", "stretch", "--json", "result.json"]).expect(0);
    let module = root.join("modules/touch-spheres");
    run(&["check", module.to_str().expect("UTF-8")]).expect(0);
    run(&["man", "pages"]).expect(0);
    // What would be written into the installation is refused before anything is computed.
    let printed = run(&["tune", "cantilever"]).expect(2);
    let named =
        printed.err.contains("belongs to the installation") && printed.err.contains("--out");
    assert!(named, "{printed:?}");
    assert_eq!(listing(&root), before);
    // For the user alone: names of trainees are in them.
    // So that it can be removed.
    for (path, _) in listing(&root).into_iter().filter(|(path, _)| path.is_dir()) {
        fs::set_permissions(path, Permissions::from_mode(0o755)).expect("set");
    }
    fs::set_permissions(&root, Permissions::from_mode(0o755)).expect("set");
    let mode = |path: &str| data.join(path).metadata().expect("it is there").mode() & 0o777;
    assert_eq!(
        (mode(""), mode("sessions"), mode("logs")),
        (0o700, 0o700, 0o700)
    );
}

/// What a run writes and no command has named a place for.
#[test]
fn sessions_of_a_user_are_found_by_their_names() {
    let station = Station::new();
    let printed = station.microsim(&["run", "touch-spheres", "--input", SCRIPT, "--json"]);
    let session = printed.expect(0).json()["session"]
        .as_str()
        .expect("a path")
        .to_owned();
    let session = Path::new(&session);
    assert_eq!(
        session.parent(),
        Some(&*station.data.path().join("sessions"))
    );
    let whole = session
        .file_name()
        .expect("a name")
        .to_str()
        .expect("UTF-8");
    let short = whole.strip_suffix(".session").expect("an extension");
    for name in [whole, short] {
        let report = station
            .microsim(&["report", name, "--json"])
            .expect(0)
            .json();
        assert_eq!(report["session"]["module"], "touch-spheres");
        station.microsim(&["replay", name, "--verify"]).expect(0);
        station.microsim(&["bus", name, "--json"]).expect(0);
    }
    // A name that leads out of the folder is a path, and there is none.
    let printed = station
        .microsim(&["report", &format!("../sessions/{whole}")])
        .expect(2);
    assert!(printed.err.contains("there is no such file"), "{printed:?}");
    // A folder that the command line names comes before the environment's.
    let other = scratch();
    let at = other.path().to_str().expect("UTF-8");
    let args = [
        "--data",
        at,
        "run",
        "touch-spheres",
        "--input",
        SCRIPT,
        "--json",
    ];
    let session = station.microsim(&args).expect(0).json()["session"].clone();
    assert!(
        session.as_str().is_some_and(|path| path.starts_with(at)),
        "{session}"
    );
    assert!(other.path().join("station.key").is_file() && other.path().join("logs").is_dir());
}

/// Each file of the station in turn with a text that is wrong: it is read, and named with its line.
#[test]
fn settings_of_the_station_take_the_place_of_shipped_ones() {
    let run = ["run", "touch-spheres", "--input", SCRIPT];
    let station = Station::new();
    let own = station.write("config/host.toml", "[report]\nlanguage = \"de\"\n");
    let mut explain = run.to_vec();
    explain.extend(["--explain", "--json"]);
    let named = |printed: &serde_json::Value| printed["settings_of_station"].clone();
    let expected = serde_json::json!([own]);
    assert_eq!(
        named(&station.microsim(&explain).expect(0).json()),
        expected
    );
    let doctor = ["doctor", "--json"];
    assert_eq!(named(&station.microsim(&doctor).expect(0).json()), expected);
    let text = station
        .microsim(&explain[..explain.len() - 1])
        .expect(0)
        .out;
    assert!(text.contains(own.to_str().expect("UTF-8")), "{text}");
    // It holds: the page opens in German.
    let mut with_session = run.to_vec();
    with_session.extend(["--session", "x.session", "--no-pictures"]);
    station.microsim(&with_session).expect(0);
    let page = fs::read_to_string(station.tree.path("x.html")).expect("a page");
    let german = page
        .split_once("id=\"language-de\"")
        .and_then(|(_, rest)| rest.split('>').next());
    assert!(
        german.is_some_and(|of| of.ends_with(" checked")),
        "{german:?}"
    );
    // A folder of settings that is asked for is all that counts.
    let shipped = station.tree.path("config");
    let mut of_folder = vec!["--config", shipped.to_str().expect("UTF-8")];
    of_folder.extend(&explain);
    assert_eq!(
        named(&station.microsim(&of_folder).expect(0).json()),
        serde_json::json!([])
    );

    let mut tracker = run.to_vec();
    tracker[3] = "plugin:openigtlink";
    tracker.push("--explain");
    let script = "modules/touch-spheres/scripts/level1-pass.toml";
    let trainee = ["trainee", script, "--profile", "novice", "--out", "n.toml"];
    for (file, command) in [
        ("host.toml", &run[..]),
        ("translator.toml", &run[..]),
        ("openigtlink.toml", &tracker[..]),
        ("window.toml", &["window"]),
        ("trainees.toml", &trainee[..]),
    ] {
        let station = Station::new();
        let own = station.write(&format!("config/{file}"), "\nwrong = 1\n");
        let place = format!("{}:2:1: key `wrong`: found an unknown key", own.display());
        let printed = station.microsim(command).expect(2);
        assert!(printed.err.contains(&place), "{file}: {printed:?}");
        let host = file == "host.toml";
        let checked = station
            .microsim(&["check"])
            .expect(if host { 2 } else { 1 });
        let text = if host { &checked.err } else { &checked.out };
        assert!(text.contains(&place), "{file}: {checked:?}");
    }
    // What looks as if it took the place of something, and does not.
    let station = Station::new();
    let chart = station.write("config/chart.toml", "");
    let checked = station.microsim(&["check"]).expect(0).out;
    assert!(
        checked.contains(&format!("warning: {}: not used", chart.display())),
        "{checked}"
    );
}

/// What users have written for earlier versions.
#[test]
fn a_key_of_earlier_versions_is_named_with_what_is_now() {
    let station = Station::new();
    let own = station.write("config/host.toml", "[session]\ndirectory = \"sessions\"\n");
    let printed = station.microsim(&["list"]).expect(2);
    let sentence = format!(
        "{}:2:1: key `session.directory`: found a key of earlier versions, expected no such key any more: sessions lie in \
         the data folder of the user, which `microsim doctor` shows and --data or MICROSIM_DATA change",
        own.display()
    );
    assert!(printed.err.contains(&sentence), "{printed:?}");
}

/// The one log file of a station.
fn log_file(station: &Station) -> PathBuf {
    let files = fs::read_dir(station.data.path().join("logs")).expect("logs");
    let mut files: Vec<PathBuf> = files.map(|file| file.expect("a file").path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    files.remove(0)
}

#[test]
fn a_log_has_what_was_done_and_no_names() {
    let station = Station::new();
    let run = [
        "run",
        "touch-spheres",
        "--input",
        SCRIPT,
        "--trainee",
        "A. Muster",
    ];
    station
        .microsim(&["trainees", "add", "A. Muster"])
        .expect(0);
    station.microsim(&run).expect(0);
    station.microsim(&["report", "no.session"]).expect(2);
    station.microsim(&["list"]).expect(0);
    let log = fs::read_to_string(log_file(&station)).expect("a log");
    for (command, status) in [("run", 0), ("report", 2)] {
        let begins = log
            .lines()
            .filter(|l| l.contains(&format!("begins command=\"{command}\"")));
        let ends = log
            .lines()
            .filter(|l| l.contains(&format!("ends command=\"{command}\" status={status}")));
        assert_eq!((begins.count(), ends.count()), (1, 1), "{log}");
    }
    assert!(
        !log.contains("Muster") && !log.contains("\"list\""),
        "{log}"
    );
    // One line each, with its time in UTC.
    assert!(
        log.lines()
            .all(|line| line.starts_with("20") && line.contains('Z')),
        "{log}"
    );
}

/// The log of a file system that takes no more: here a limit of the length of files, which the log has reached and the session has not.
#[test]
fn a_log_that_cannot_be_written_costs_only_itself() {
    let station = Station::new();
    station.microsim(&["simulate", "stretch"]).expect(0);
    let log = log_file(&station);
    let file = fs::OpenOptions::new()
        .write(true)
        .open(&log)
        .expect("the log");
    file.set_len(64 << 20).expect("a hole");
    let mut shell = Command::new("bash");
    shell.current_dir(station.tree.path(""));
    shell.env("MICROSIM_DATA", station.data.path());
    shell.arg("-c").arg(format!(
        "trap '' XFSZ; ulimit -f {}; exec \"$0\" --root . run touch-spheres --input {SCRIPT} --session x.session",
        32 << 10
    ));
    let printed = finish(shell.arg(microsim_tests::program())).expect(0);
    assert_eq!(printed.err, "");
    assert_eq!(log.metadata().expect("the log").len(), 64 << 20);
    microsim_tests::assert_verified(&station.tree.path("x.session"));

    // A folder of logs that is none.
    let station = Station::new();
    station.write("logs", "a file");
    let printed = station.microsim(&["simulate", "stretch"]).expect(0);
    assert_eq!(printed.err, "");
    let doctor = station.microsim(&["doctor", "--json"]).expect(0).json();
    let logs = serde_json::json!([station.data.path().join("logs")]);
    assert_eq!(doctor["folders"]["not_writable"], logs);
}

/// What `doctor` states is where files are.
#[test]
fn doctor_states_where_all_lies() {
    let station = Station::new();
    let before = listing(station.data.path());
    let doctor = station.microsim(&["doctor", "--json"]).expect(0).json();
    assert_eq!(listing(station.data.path()), before, "it makes nothing");
    let data = station.data.path();
    for (key, path) in [
        ("data", data.to_path_buf()),
        ("sessions", data.join("sessions")),
        ("store", data.join("store.sqlite")),
        ("config", data.join("config")),
        ("cache", data.join("cache")),
        ("logs", data.join("logs")),
    ] {
        assert_eq!(doctor["folders"][key], serde_json::json!(path), "{key}");
    }
    assert_eq!(doctor["healthy"], true, "{doctor}");
    assert_eq!(doctor["folders"]["log_file"], serde_json::Value::Null);
    station
        .microsim(&["run", "touch-spheres", "--input", SCRIPT])
        .expect(0);
    let doctor = station.microsim(&["doctor", "--json"]).expect(0).json();
    assert_eq!(
        doctor["folders"]["log_file"],
        serde_json::json!(log_file(&station))
    );
    assert_eq!(
        doctor["station"]["key"],
        serde_json::json!(data.join("station.key"))
    );
    // By the system's rules where nothing else is named: XDG's.
    let mut command = station.command(&["doctor", "--json"]);
    let home = scratch();
    command.env_remove("MICROSIM_DATA").env("HOME", home.path());
    for variable in [
        "XDG_DATA_HOME",
        "XDG_CONFIG_HOME",
        "XDG_CACHE_HOME",
        "XDG_STATE_HOME",
    ] {
        command.env_remove(variable);
    }
    let folders = finish(&mut command).expect(0).json()["folders"].clone();
    for (key, below) in [
        ("sessions", ".local/share/microsim/sessions"),
        ("config", ".config/microsim"),
        ("cache", ".cache/microsim"),
        ("logs", ".local/state/microsim/logs"),
    ] {
        assert_eq!(
            folders[key],
            serde_json::json!(home.path().join(below)),
            "{key}"
        );
    }
}

/// The tests themselves and `cargo xtask run`: their data folder is below cargo's.
#[test]
fn tests_have_folders_of_their_own() {
    assert!(
        microsim_tests::data().starts_with(repository().join("target"))
            || std::env::var_os("MICROSIM_TREE").is_some()
    );
    let doctor = microsim_tests::microsim(["doctor", "--json"]).json();
    assert_eq!(
        doctor["folders"]["data"],
        serde_json::json!(microsim_tests::data())
    );
}
