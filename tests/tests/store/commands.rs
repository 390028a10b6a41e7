//! Finding, comparing and exporting results; who a run belongs to.

use microsim_host::record::Session;
use microsim_tests::stations::{Station, of_run};
use serde_json::Value;
use std::fs;

/// The three commands of the README.
#[test]
fn two_attempts_are_found_compared_and_exported() {
    let station = Station::new();
    let id = station.add("A. Muster");
    station.add("B. Beispiel");
    for name in ["A. Muster", "B. Beispiel"] {
        station
            .microsim(&["trainees", "group", "2026", "--add", name])
            .expect(0);
    }
    let mut runs = Vec::new();
    for (name, script, who) in [
        ("1", "fail-too-slow", "A. Muster"),
        ("2", "pass", "A. Muster"),
        ("3", "pass", "B. Beispiel"),
    ] {
        let printed = station
            .run(name, script, &["--trainee", who])
            .output()
            .expect("a run");
        let printed: Value = serde_json::from_slice(&printed.stdout).expect("JSON");
        assert_eq!(printed["stored"], true, "{printed}");
        runs.push(printed);
    }
    let found = station
        .microsim(&["results", "--trainee", "A. Muster", "--json"])
        .expect(0)
        .json();
    let results = found["results"].as_array().expect("a list");
    assert_eq!(results.len(), 2);
    for (result, run) in results.iter().zip(&runs) {
        assert_eq!(result["name"], "A. Muster");
        assert_eq!(result["trainee"], id);
        for (key, value) in of_run(run).as_object().expect("fields") {
            assert_eq!(&result[key], value, "{key}");
        }
        assert!(result["metrics"].as_array().is_some_and(|m| m.len() > 3));
    }
    let lines = station
        .microsim(&["results", "--trainee", "A. Muster"])
        .expect(0)
        .out;
    assert_eq!(lines.lines().count(), 3, "{lines}");
    assert!(
        lines.lines().last().is_some_and(|l| l == "2 sessions"),
        "{lines}"
    );
    let short = |run: &Value| run["session_id"].as_str().expect("an id")[..8].to_owned();
    let (a, b) = (short(&runs[0]), short(&runs[1]));
    let compared = station
        .microsim(&["results", "--compare", &a, &b, "--json"])
        .expect(0)
        .json();
    assert_eq!(compared["same_level"], true);
    let difference = runs[1]["score"]
        .as_f64()
        .zip(runs[0]["score"].as_f64())
        .map(|(b, a)| b - a);
    assert_eq!(compared["score_difference"].as_f64(), difference);
    let table = station
        .microsim(&["results", "--compare", &a, &b])
        .expect(0)
        .out;
    assert!(
        table.contains("A. Muster") && table.contains("B - A"),
        "{table}"
    );
    // By their files as well.
    let files = [station.session("1"), station.session("2")].map(|f| f.display().to_string());
    let by_files = station.microsim(&["results", "--compare", &files[0], &files[1], "--json"]);
    assert_eq!(by_files.expect(0).json(), compared);
    let csv = station.folder().join("group.csv");
    let csv = csv.to_str().expect("text");
    let out = station
        .microsim(&["results", "--group", "2026", "--export", csv])
        .expect(0)
        .out;
    assert!(out.starts_with("3 sessions are in"), "{out}");
    let mut reader = csv::Reader::from_path(csv).expect("a table");
    let header = reader.headers().expect("a header").clone();
    let at = |name: &str| header.iter().position(|h| h == name).expect(name);
    let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("a row")).collect();
    let sessions: std::collections::BTreeSet<&str> =
        rows.iter().map(|r| &r[at("session")]).collect();
    assert_eq!(sessions.len(), 3);
    assert!(rows.iter().all(|r| &r[at("groups")] == "2026"));
    // Every value of the first run as its report beside the session has it, in SI.
    let report = microsim_tests::report_beside(&station.session("1"));
    for metric in report["metrics"].as_array().expect("metrics") {
        let row = rows
            .iter()
            .find(|r| r[at("session")] == runs[0]["session_id"] && r[at("metric")] == metric["id"]);
        let row = row.expect("a row");
        assert_eq!(
            row[at("value")].parse::<f64>().ok(),
            metric["value"].as_f64(),
            "{metric}"
        );
        assert_eq!(&row[at("unit")], metric["unit"].as_str().expect("a unit"));
    }
}

/// The name stands in the store alone: no file of the run has it.
#[test]
fn sessions_and_reports_hold_the_id_alone() {
    let station = Station::new();
    let name = "Quetzalcoatl Unmistakable";
    let id = station.add(name);
    let input = "script:level1-pass.toml";
    let mut run = station.command(&[
        "run",
        "touch-spheres",
        "--no-pictures",
        "--input",
        input,
        "--trainee",
        name,
    ]);
    let out = microsim_tests::finish(run.arg("--session").arg(station.session("1")))
        .expect(0)
        .out;
    assert!(out.contains(&format!("trainee {name}")), "{out}");
    let bytes = fs::read(station.session("1")).expect("a session");
    let session = Session::read(&bytes).expect("a session");
    assert_eq!(session.header.trainee.as_deref(), Some(&id[..]));
    let mut files = 0;
    for entry in fs::read_dir(station.data().join("sessions")).expect("a folder") {
        let path = entry.expect("a file").path();
        let bytes = fs::read(&path).expect("a file");
        let has = |text: &str| bytes.windows(text.len()).any(|w| w == text.as_bytes());
        assert!(!has("Quetzalcoatl"), "{}", path.display());
        files += 1;
    }
    // Session, page, JSON, two tables.
    assert_eq!(files, 5);
    let report = station
        .microsim(&["report", station.session("1").to_str().expect("text")])
        .expect(0)
        .out;
    assert!(report.contains(&format!("trainee {name}")), "{report}");
}

#[test]
fn a_trainee_who_is_not_there_is_refused_with_those_who_are_near() {
    let station = Station::new();
    let id = station.add("A. Muster");
    let refused = station.microsim(&[
        "run",
        "touch-spheres",
        "--input",
        "script:level1-pass.toml",
        "--trainee",
        "A Mustr",
    ]);
    let refused = refused.expect(2);
    assert!(
        refused.err.contains("near it: \"A. Muster\"")
            && refused.err.contains("microsim trainees add"),
        "{}",
        refused.err
    );
    assert!(station.results().is_empty());
    // By id it is the same trainee.
    let printed = station
        .run("1", "pass", &["--trainee", &id])
        .output()
        .expect("a run");
    let printed: Value = serde_json::from_slice(&printed.stdout).expect("JSON");
    assert_eq!(printed["trainee"], id);
    let listed = station
        .microsim(&["trainees", "list", "--json"])
        .expect(0)
        .json();
    assert_eq!(listed["trainees"][0]["sessions"], 1);
    let again = station
        .microsim(&["trainees", "add", "A. Muster"])
        .expect(2);
    assert!(again.err.contains("already"), "{}", again.err);
}

#[test]
fn a_run_stays_out_of_the_store_when_asked_to() {
    let station = Station::new();
    let id = station.add("A. Muster");
    let printed = station
        .run("1", "pass", &["--no-store", "--trainee", &id])
        .output()
        .expect("a run");
    let printed: Value = serde_json::from_slice(&printed.stdout).expect("JSON");
    assert_eq!(
        (&printed["stored"], &printed["trainee"]),
        (&Value::Bool(false), &Value::from(&id[..]))
    );
    let rebuilt = station
        .microsim(&["store", "rebuild", "--json"])
        .expect(0)
        .json();
    assert_eq!(
        (&rebuilt["sessions"], &rebuilt["left_out"]),
        (&0.into(), &1.into())
    );
    let named = station.microsim(&[
        "run",
        "touch-spheres",
        "--input",
        "script:level1-pass.toml",
        "--no-store",
        "--trainee",
        "A. Muster",
    ]);
    assert!(named.expect(2).err.contains("names stand in the store"));
}

/// Names of any kind on the command line: stored as they are, shown and exported without harm.
#[test]
fn awkward_names_are_harmless() {
    let station = Station::new();
    let names = [
        "李 小龍",
        "محمد",
        "Robert'); DROP TABLE trainee;--",
        "=HYPERLINK(\"http://x\")",
        "@SUM(A1)",
        "a\nb\r\tc",
        "\u{1b}]0;title\u{7}",
        "\u{202e}gnirts",
        &"long ".repeat(2_000),
    ];
    let ids: Vec<String> = names.iter().map(|name| station.add(name)).collect();
    let listed = station.microsim(&["trainees", "list"]).expect(0).out;
    assert_eq!(listed.lines().count(), names.len(), "{listed}");
    let commands =
        |c: char| (c.is_control() && c != '\n') || ('\u{202a}'..='\u{202e}').contains(&c);
    assert!(!listed.contains(commands), "{listed:?}");
    assert!(listed.lines().all(|line| line.chars().count() < 200));
    station
        .run("1", "pass", &["--trainee", names[3]])
        .output()
        .expect("a run");
    let as_json = station
        .microsim(&["trainees", "list", "--json"])
        .expect(0)
        .json();
    for (name, id) in names.iter().zip(&ids) {
        let found = as_json["trainees"]
            .as_array()
            .expect("a list")
            .iter()
            .find(|t| t["id"] == **id);
        assert_eq!(found.expect("there")["name"], **name);
    }
    let csv = station.folder().join("all.csv");
    station
        .microsim(&["results", "--export", csv.to_str().expect("text")])
        .expect(0);
    let mut reader = csv::Reader::from_path(&csv).expect("a table");
    let row = reader.records().next().expect("a row").expect("a row");
    assert_eq!(&row[2], "'=HYPERLINK(\"http://x\")");
}

/// What a rebuild cannot give back comes from an export: names, groups, roles, courses.
#[test]
fn an_export_gives_back_what_sessions_do_not_hold() {
    let station = Station::new();
    station.add("A. Muster");
    station
        .microsim(&["trainees", "role", "A. Muster", "instructor"])
        .expect(0);
    station
        .microsim(&["trainees", "group", "2026", "--add", "A. Muster"])
        .expect(0);
    station
        .run("1", "pass", &["--trainee", "A. Muster"])
        .output()
        .expect("a run");
    let results = station.results();
    let listed = station
        .microsim(&["trainees", "list", "--json"])
        .expect(0)
        .json();
    let export = station.folder().join("store.json");
    let export = export.to_str().expect("text");
    station.microsim(&["store", "export", export]).expect(0);
    for end in ["", "-wal", "-shm"] {
        let mut name = station.store().into_os_string();
        name.push(end);
        let _ = fs::remove_file(name);
    }
    station.microsim(&["store", "rebuild"]).expect(0);
    assert_eq!(station.results(), results);
    assert!(
        station
            .microsim(&["results", "--trainee", "A. Muster"])
            .code
            == Some(2)
    );
    station.microsim(&["store", "import", export]).expect(0);
    assert_eq!(
        station
            .microsim(&["trainees", "list", "--json"])
            .expect(0)
            .json(),
        listed
    );
    assert_eq!(station.results(), results);
}

/// Sessions of earlier versions hold a name and no id: they are entered for the trainee of that name, who is added if there is none, with the same ids
/// whenever they are read again.
#[test]
fn sessions_that_hold_a_name_are_entered() {
    let station = Station::new();
    station
        .run("1", "pass", &["--no-store"])
        .output()
        .expect("a run");
    let bytes = fs::read(station.session("1")).expect("a session");
    for (file, name) in [
        ("old-1", "C. Früher"),
        ("old-2", "C. Früher"),
        ("old-3", "D. Früher"),
    ] {
        let old = microsim_tests::alter::change_header(&bytes, |header| {
            header.trainee = Some(name.into());
            header.started += u64::from(file.as_bytes()[4]);
            (header.id, header.unlisted) = (None, false);
        });
        fs::write(station.session(file), old).expect("a session");
    }
    station.microsim(&["store", "rebuild"]).expect(0);
    let found = station
        .microsim(&["results", "--trainee", "C. Früher", "--json"])
        .expect(0)
        .json();
    assert_eq!(found["results"].as_array().map(Vec::len), Some(2));
    let results = station.results();
    assert_eq!(results.len(), 3);
    for end in ["", "-wal", "-shm"] {
        let mut name = station.store().into_os_string();
        name.push(end);
        let _ = fs::remove_file(name);
    }
    station.microsim(&["store", "rebuild"]).expect(0);
    assert_eq!(station.results(), results);
    // Nothing but erasing takes the name out of such a session.
    let anonymised = station
        .microsim(&["trainees", "anonymise", "C. Früher", "--yes", "--json"])
        .expect(0)
        .json();
    assert_eq!(
        anonymised["sessions_with_name"].as_array().map(Vec::len),
        Some(2)
    );
}
