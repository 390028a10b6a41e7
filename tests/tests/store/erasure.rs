//! What goes on request.

use microsim_tests::stations::Station;
use std::fs;
use std::path::{Path, PathBuf};

/// All files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => found.extend(files(&path)),
            false => found.push(path),
        }
    }
    found.sort();
    found
}

/// Those that are there whether or not a process has the store open.
fn lasting(folder: &Path) -> Vec<PathBuf> {
    let of_log = |path: &PathBuf| {
        let name = path.display().to_string();
        name.ends_with("-wal") || name.ends_with("-shm")
    };
    files(folder)
        .into_iter()
        .filter(|path| !of_log(path))
        .collect()
}

fn holding(folder: &Path, text: &str) -> Vec<PathBuf> {
    let holds = |path: &PathBuf| {
        let bytes = fs::read(path).expect("a file");
        bytes
            .windows(text.len())
            .any(|window| window == text.as_bytes())
    };
    files(folder).into_iter().filter(holds).collect()
}

/// Session, reports beside it and elsewhere, checkpoint and rows of one trainee go, and no byte of name or id is left; those of another stay.
#[test]
fn an_erased_trainee_leaves_nothing() {
    let station = Station::new();
    let id = station.add("A. Muster-Erased");
    station.add("B. Beispiel");
    for (name, who) in [("1", "A. Muster-Erased"), ("2", "B. Beispiel")] {
        station
            .run(name, "pass", &["--trainee", who])
            .output()
            .expect("a run");
    }
    let checkpoint = station.data().join("state.checkpoint");
    let more = [
        "--trainee",
        "A. Muster-Erased",
        "--stop-at",
        "1",
        "--checkpoint",
        checkpoint.to_str().expect("text"),
    ];
    station.run("3", "pass", &more).output().expect("a run");
    assert!(checkpoint.is_file());
    let page = station.data().join("elsewhere.html");
    let session = station.session("1");
    station
        .microsim(&[
            "report",
            session.to_str().expect("text"),
            "--html",
            page.to_str().expect("text"),
        ])
        .expect(0);
    // A session that the store does not know.
    fs::copy(&session, station.session("copied")).expect("a copy");
    let before = lasting(&station.data());
    let listed = station
        .microsim(&["trainees", "erase", "A. Muster-Erased", "--json"])
        .expect(0)
        .json();
    assert_eq!(listed["erased"], false);
    assert_eq!(lasting(&station.data()), before);
    let named: Vec<&str> = listed["files"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|f| f.as_str())
        .collect();
    // Two sessions with four files beside each, the copy, the checkpoint and the page.
    assert_eq!(named.len(), 2 * 5 + 1 + 2, "{named:?}");
    station
        .microsim(&["trainees", "erase", "A. Muster-Erased", "--yes"])
        .expect(0);
    for text in ["Muster-Erased", &id] {
        assert_eq!(
            holding(&station.data(), text),
            Vec::<PathBuf>::new(),
            "{text}"
        );
    }
    assert!(!checkpoint.exists() && !page.exists() && !session.exists());
    let left = files(&station.data().join("sessions"));
    assert_eq!(left.len(), 5, "{left:?}");
    assert_eq!(station.results().len(), 1);
    let log = station.folder().join("export.json");
    station
        .microsim(&["store", "export", log.to_str().expect("text")])
        .expect(0);
    let document: serde_json::Value =
        serde_json::from_slice(&fs::read(&log).expect("a file")).expect("JSON");
    assert_eq!(document["erasures"][0]["what"], "erased");
    assert_eq!(document["erasures"][0]["sessions"], 2);
    assert!(holding(&station.data(), "Muster-Erased").is_empty());
}

/// A page elsewhere, and one beside a session of the trainee who goes, were written again of somebody else's session: both stay.
#[test]
fn a_page_that_another_has_replaced_stays() {
    let station = Station::new();
    for (name, who) in [("1", "A. Muster"), ("2", "B. Beispiel")] {
        station.add(who);
        station
            .run(name, "pass", &["--trainee", who])
            .output()
            .expect("a run");
    }
    let elsewhere = station.data().join("latest.html");
    let beside = station.session("1").with_extension("html");
    let report = |session: &str, page: &Path| {
        let (session, page) = (station.session(session), page.to_str().expect("text"));
        let session = session.to_str().expect("text");
        station
            .microsim(&["report", session, "--html", page])
            .expect(0);
    };
    report("1", &elsewhere);
    report("2", &elsewhere);
    report("2", &beside);
    let replaced = [&elsewhere, &beside].map(|page| fs::read(page).expect("a page"));
    station
        .microsim(&["trainees", "erase", "A. Muster", "--yes"])
        .expect(0);
    let left = [&elsewhere, &beside].map(|page| fs::read(page).ok());
    assert_eq!(left, replaced.map(Some));
    assert!(!station.session("1").exists());
    // They go with their own trainee.
    station
        .microsim(&["trainees", "erase", "B. Beispiel", "--yes"])
        .expect(0);
    assert!(!elsewhere.exists() && !beside.exists());
}

#[test]
fn an_anonymous_trainee_has_results_and_no_name() {
    let station = Station::new();
    let id = station.add("A. Muster-Anonymous");
    station
        .run("1", "pass", &["--trainee", &id])
        .output()
        .expect("a run");
    let results = station.results();
    station.microsim(&["trainees", "anonymise", &id]).expect(0);
    assert!(!holding(&station.data(), "Muster-Anonymous").is_empty());
    station
        .microsim(&["trainees", "anonymise", &id, "--yes"])
        .expect(0);
    assert_eq!(
        holding(&station.data(), "Muster-Anonymous"),
        Vec::<PathBuf>::new()
    );
    assert_eq!(station.results(), results);
    station.microsim(&["store", "rebuild"]).expect(0);
    let listed = station
        .microsim(&["trainees", "list", "--json"])
        .expect(0)
        .json();
    assert_eq!(listed["trainees"][0]["name"], serde_json::Value::Null);
    assert_eq!(listed["trainees"][0]["id"], id);
}

#[test]
fn the_data_of_a_trainee_are_handed_out() {
    let station = Station::new();
    station.add("A. Muster");
    station.add("B. Beispiel");
    for (name, who) in [("1", "A. Muster"), ("2", "B. Beispiel")] {
        station
            .run(name, "pass", &["--trainee", who])
            .output()
            .expect("a run");
    }
    let folder = station.folder().join("handed-out");
    let folder_text = folder.to_str().expect("text");
    station
        .microsim(&["trainees", "export", "A. Muster", folder_text])
        .expect(0);
    let names: Vec<String> = files(&folder)
        .iter()
        .map(|f| {
            f.file_name()
                .expect("a name")
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    assert_eq!(
        names,
        [
            "results.csv",
            "1.html",
            "1.json",
            "1.metrics.csv",
            "1.series.csv",
            "1.session",
            "trainee.json"
        ]
    );
    assert!(holding(&folder, "Beispiel").is_empty());
    assert_eq!(
        fs::read(station.session("1")).ok(),
        fs::read(files(&folder)[5].clone()).ok()
    );
    // Nothing is overwritten.
    station
        .microsim(&["trainees", "export", "A. Muster", folder_text])
        .expect(2);
}
