//! Courses and learning curves by command.

use microsim_tests::stations::Station;
use std::fs;

const COURSE: &str = "
name = \"two-levels\"
title = { de = \"Zwei Level\", en = \"Two levels\" }
passes = 1

[[step]]
module = \"touch-spheres\"
level = 1

[[step]]
module = \"touch-spheres\"
level = 2
";

#[test]
fn a_course_is_taken_level_by_level() {
    let station = Station::new();
    station.add("A. Muster");
    let file = station.folder().join("course.toml");
    fs::write(&file, COURSE).expect("a file");
    station
        .microsim(&["courses", "add", file.to_str().expect("text")])
        .expect(0);
    station
        .microsim(&["courses", "enrol", "two-levels", "--trainee", "A. Muster"])
        .expect(0);
    let state = || {
        let printed = station
            .microsim(&["courses", "progress", "two-levels", "--json"])
            .expect(0)
            .json();
        let levels = printed["trainees"][0]["levels"]
            .as_array()
            .expect("levels")
            .clone();
        levels
            .iter()
            .map(|l| l["state"].as_str().expect("a word").to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(state(), ["open", "locked"]);
    // A level that is locked runs, and is named.
    let input = "script:level2-pass.toml";
    let mut run = station.command(&[
        "run",
        "touch-spheres",
        "--level",
        "2",
        "--json",
        "--input",
        input,
        "--trainee",
        "A. Muster",
    ]);
    let ran = microsim_tests::finish(run.arg("--session").arg(station.session("2"))).expect(0);
    assert!(
        ran.err
            .contains("not open yet in the course two-levels: touch-spheres, level 1, is next"),
        "{}",
        ran.err
    );
    station
        .run("1", "pass", &["--trainee", "A. Muster"])
        .output()
        .expect("a run");
    assert_eq!(state(), ["mastered", "mastered"]);
    let shown = station
        .microsim(&["courses", "progress", "two-levels"])
        .expect(0)
        .out;
    assert!(
        shown.starts_with("A. Muster\n") && shown.contains("with attempt 1"),
        "{shown}"
    );
    let curve = station.microsim(&[
        "results",
        "--trainee",
        "A. Muster",
        "--module",
        "touch-spheres",
        "--level",
        "1",
        "--json",
    ]);
    let curve = curve.expect(0).json();
    // One success: −s, of DOMAIN 2 with 5 % and 15 %.
    let value = curve["learning_curve"]["values"][0]
        .as_f64()
        .expect("a number");
    assert!((value + 0.091_934_326_841_785_4).abs() < 1e-15, "{value}");
}

#[test]
fn mistakes_in_courses_are_named() {
    let station = Station::new();
    let file = station.folder().join("course.toml");
    fs::write(&file, COURSE.replace("level = 2", "level = 1")).expect("a file");
    let refused = station
        .microsim(&["courses", "add", file.to_str().expect("text")])
        .expect(2);
    assert!(
        refused.err.contains("course.toml:10:1: key `step[1]`"),
        "{}",
        refused.err
    );
    station.add("A. Muster");
    let unknown = station
        .microsim(&["courses", "progress", "nothing"])
        .expect(2);
    assert!(
        unknown.err.contains("no course \"nothing\""),
        "{}",
        unknown.err
    );
}

/// A value among those of a population that was imported: 12.5 % of the distance from the 10th to the 90th percentile.
#[test]
fn values_stand_in_a_population() {
    let station = Station::new();
    station.run("1", "pass", &[]).output().expect("a run");
    let result = &station.results()[0];
    let metric = result["metrics"]
        .as_array()
        .expect("metrics")
        .iter()
        .find(|m| m["value"].as_f64().is_some_and(|v| v > 0.0));
    let metric = metric.expect("a metric");
    let value = metric["value"].as_f64().expect("a number");
    let file = station.folder().join("population.csv");
    let (low, high) = (0.5 * value, 4.5 * value);
    let text = format!(
        "module,level,metric,source,n,mean,sd,p10,p90\ntouch-spheres,1,{},experts,12,,,{low},{high}\n",
        metric["id"].as_str().expect("an id")
    );
    fs::write(&file, text).expect("a file");
    station
        .microsim(&["store", "import", file.to_str().expect("text")])
        .expect(0);
    let result = station.results().remove(0);
    let found = result["metrics"]
        .as_array()
        .expect("metrics")
        .iter()
        .find(|m| m["id"] == metric["id"]);
    let standing = &found.expect("the metric")["populations"][0];
    assert_eq!(
        (&standing["source"], &standing["n"]),
        (&"experts".into(), &12.into())
    );
    let percentile = standing["percentile"].as_f64().expect("a number");
    // A few roundings of numbers near 20.
    assert!((percentile - 20.0).abs() < 1e-12, "{percentile}");
}
