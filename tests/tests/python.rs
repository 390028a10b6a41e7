//! The Python package: installed into a fresh environment, its own tests against a session that is recorded here, its example against
//! groups of synthetic trainees.

use microsim_tests::statistics::{Group, hedges};
use microsim_tests::{finish, microsim, report_beside, repository, run, scratch, tree};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The first version that the package is for.
const LEAST: (u32, u32) = (3, 10);

/// A Python that can make environments; otherwise why there is none.
fn python() -> Result<PathBuf, String> {
    let mut ask = Command::new("python3");
    ask.args([
        "-c",
        "import ensurepip, sys, venv; print(*sys.version_info[:2])",
    ]);
    let output = ask.output().map_err(|e| format!("python3: {e}"))?;
    if !output.status.success() {
        return Err("python3 has no venv or ensurepip".into());
    }
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let numbers: Vec<u32> = text
        .split_whitespace()
        .filter_map(|n| n.parse().ok())
        .collect();
    match numbers[..] {
        [major, minor] if (major, minor) >= LEAST => Ok("python3".into()),
        _ => Err(format!("python3 is {}, older than 3.10", text.trim())),
    }
}

/// A new environment below cargo's folder with the package in it, from its files alone: no network.
fn environment(python: &Path) -> PathBuf {
    let folder = tree().with_extension("venv");
    let _ = std::fs::remove_dir_all(&folder);
    finish(Command::new(python).args(["-m", "venv"]).arg(&folder)).expect(0);
    let own = folder.join("bin/python");
    let mut pip = Command::new(&own);
    pip.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--no-index",
    ]);
    finish(pip.arg(repository().join("python"))).expect(0);
    own
}

/// Runs of a kind of synthetic trainee; the durations that their reports state \[s\].
fn group(profile: &str, count: u64, folder: &Path) -> Vec<f64> {
    let plan = repository().join("modules/touch-spheres/scripts/level1-pass.toml");
    let attempt = |seed: u64| {
        let script = folder.join(format!("{profile}-{seed}.toml"));
        let words = [
            "trainee",
            plan.to_str().expect("UTF-8"),
            "--profile",
            profile,
            "--seed",
        ];
        let seed = seed.to_string();
        let words = [
            &words[..],
            &[&seed, "--out", script.to_str().expect("UTF-8")],
        ]
        .concat();
        microsim(words).expect(0);
        let session = folder.join(format!("{profile}-{seed}.session"));
        let input = format!("script:{}", script.display());
        run("touch-spheres", &session, &["--input", &input]);
        let report = report_beside(&session);
        assert_eq!(report["counts"], true, "{report}");
        report["duration"].as_f64().expect("a duration")
    };
    (1..=count).map(attempt).collect()
}

#[test]
fn the_package_reads_what_runs_have_recorded() {
    let python = match python() {
        Ok(python) => python,
        Err(why) => {
            eprintln!("skipped: {why}");
            return;
        }
    };
    let python = environment(&python);
    let folder = scratch();
    let (experts, novices) = (
        group("expert", 3, folder.path()),
        group("novice", 4, folder.path()),
    );

    let mut tests = Command::new(&python);
    tests.args(["-m", "unittest", "discover", "--verbose", "-s"]);
    tests
        .arg(repository().join("python/tests"))
        .current_dir(folder.path());
    tests.env("MICROSIM_SESSION", folder.path().join("novice-1.session"));
    let printed = finish(&mut tests).expect(0).err;
    for test in [
        "test_the_result_is_that_of_the_report",
        "test_the_motion_is_that_of_the_report",
    ] {
        let line = printed.lines().find(|line| line.starts_with(test));
        assert!(line.is_some_and(|line| line.ends_with("ok")), "{printed}");
    }

    let mut example = Command::new(&python);
    example.arg(repository().join("python/examples/compare_groups.py"));
    example
        .arg("--sessions")
        .arg(folder.path())
        .current_dir(folder.path());
    let printed = finish(&mut example).expect(0).out;
    let [first, second] = [&experts, &novices].map(|values| Group::of(values).expect("several"));
    let (g, _) = hedges(&first, &second).expect("they vary");
    assert!(
        printed.contains("expert: 3 attempts") && printed.contains("novice: 4 attempts"),
        "{printed}"
    );
    assert!(
        printed.contains(&format!("Hedges' g {g:.2} (95 %: ")),
        "{g} in {printed}"
    );
    assert_eq!(printed.matches(", CUSUM ").count(), 2, "{printed}");
}
