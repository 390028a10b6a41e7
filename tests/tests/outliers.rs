//! Samples that no hand makes: they move no tool, cost nothing and are named; what hands do is not among them.

use microsim_message::{InputSample, Pose};
use microsim_settings::{load_script, load_translator};
use microsim_tests::trainees::make;
use microsim_tests::{
    assert_verified, command, config_with, finish, microsim, report_beside, repository, scratch,
};
use microsim_tracking::{Mapping, Translator};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Where in the shipped settings it stands what no hand goes beyond.
const SETTINGS: &str = "translator.toml";

fn outlier(name: &str) -> PathBuf {
    repository().join(format!("tests/data/outliers/{name}.toml"))
}

/// Runs a script beside which the session is written; what is printed as JSON.
#[track_caller]
fn run(module: &str, level: &str, script: &Path, session: &Path) -> Value {
    let input = format!("script:{}", script.display());
    let args = ["--level", level, "--input", &input, "--no-pictures"];
    microsim_tests::run(module, session, &args)
}

/// How many samples of these devices the translator leaves out with the shipped settings; each drives the tool of its own name.
fn left_out(samples: impl Iterator<Item = InputSample>, devices: &[&str]) -> u64 {
    let config = load_translator(&repository().join("config").join(SETTINGS));
    let config = config.expect("the shipped settings").settings;
    let mappings = devices.iter().map(|name| Mapping::identity(name, name));
    let translator = Translator::new(mappings.collect(), config.stale_after, config.hand.limits());
    let mut translator = translator.expect("right settings");
    for sample in samples {
        // Refusals are counted below; a device's clock is as good as a session's.
        let _ = translator.feed(&sample, sample.device_time);
    }
    let tools = translator.tools().iter();
    tools.map(|tool| tool.implausible() + tool.refused()).sum()
}

/// The same of a script.
fn left_out_of(script: &Path) -> u64 {
    let script = load_script(script).unwrap_or_else(|e| panic!("{}: {e}", script.display()));
    let script = script.settings;
    let devices: Vec<&str> = script.tool.iter().map(|tool| tool.name.as_str()).collect();
    let motion = script.motion().expect("a checked script");
    left_out(motion.samples(script.rate), &devices)
}

/// Every shipped script, whatever it does wrong, does what a hand can do.
#[test]
fn nothing_of_the_shipped_scripts_is_left_out() {
    let mut count = 0;
    for module in fs::read_dir(repository().join("modules"))
        .expect("modules")
        .flatten()
    {
        let scripts = fs::read_dir(module.path().join("scripts"));
        for script in scripts.into_iter().flatten().flatten() {
            assert_eq!(
                left_out_of(&script.path()),
                0,
                "{}",
                script.path().display()
            );
            count += 1;
        }
    }
    assert!(count > 70, "{count} scripts");
    // The test can fail.
    assert_eq!(left_out_of(&outlier("coordination-20mm")), 1);
}

/// Nor is anything of the motion of a real hand, 98 s with tremor, pauses and gaps.
#[test]
fn nothing_of_the_recorded_hand_is_left_out() {
    let path = repository().join("assets/recordings/cataract-stylus/stylus.csv");
    let text = fs::read_to_string(path).expect("the recording is shipped");
    let samples: Vec<_> = text
        .lines()
        .skip(1)
        .map(|line| {
            let numbers: Vec<f64> = line
                .split(',')
                .map(|n| n.parse().expect("a number"))
                .collect();
            let [t, x, y, z, qx, qy, qz, qw] = numbers[..] else {
                panic!("eight numbers: {line}");
            };
            InputSample {
                visible: true,
                pose: Pose {
                    position: [x, y, z].map(|millimetres| 1e-3 * millimetres),
                    orientation: [qx, qy, qz, qw],
                },
                ..InputSample::not_visible("stylus", t)
            }
        })
        .collect();
    assert_eq!(samples.len(), 3466, "README beside the recording");
    assert_eq!(left_out(samples.into_iter(), &["stylus"]), 0);
}

/// Nor of synthetic trainees, the trembling and hasty ones among them.
#[test]
fn nothing_of_synthetic_trainees_is_left_out() {
    let folder = scratch();
    for (module, levels) in [
        ("touch-spheres", 5),
        ("guide-path", 5),
        ("push-strip", 4),
        ("coordination", 6),
        ("diagonal-cut", 4),
        ("dilatation", 5),
        ("trim-blunt", 4),
        ("trim-sharp", 4),
    ] {
        for level in 1..=levels {
            for profile in ["expert", "novice"] {
                for seed in 1..=3 {
                    let folder = folder.path().join(format!("{module}-{level}"));
                    fs::create_dir_all(&folder).expect("a folder");
                    let script = make(module, level, profile, seed, &folder);
                    assert_eq!(left_out_of(&script), 0, "{module} {level} {profile} {seed}");
                }
            }
        }
    }
}

/// Fails the test unless both runs have the same forces, iterations, cuts and pieces, to the bit. Their physics digests hold metrics of motion as well,
/// which take nothing across a sample that was left out.
#[track_caller]
fn assert_same_tissue(with: &Path, without: &Path) {
    let [with, without] = [with, without].map(report_beside);
    for fact in ["forces", "solver", "moments", "recoveries", "verdict"] {
        assert!(with[fact] == without[fact], "{fact} differ");
    }
}

/// A tool that stands still, and one sample of it far off: the tissue does to the bit what it does without that sample.
#[test]
fn a_sample_far_off_moves_no_tissue_and_costs_nothing() {
    let folder = scratch();
    for (name, module, level, tool, off, place) in [
        (
            "push-strip-500mm",
            "push-strip",
            "1",
            "right",
            "[0.0, 0.0, -0.4995]",
            "[0.0, 0.0, 0.0005]",
        ),
        (
            "coordination-20mm",
            "coordination",
            "4",
            "left",
            "[0.020300000000000002, 0.0007, 0.0]",
            "[0.0003, 0.0007, 0.0]",
        ),
    ] {
        let text = fs::read_to_string(outlier(name)).expect("the script");
        assert_eq!(text.matches(off).count(), 1, "{name}");
        let straight = folder.path().join(format!("{name}-straight.toml"));
        fs::write(&straight, text.replace(off, place)).expect("written");
        let [with, without] = [outlier(name), straight].map(|script| {
            let session = script
                .file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned();
            let session = folder.path().join(session + ".session");
            (run(module, level, &script, &session), session)
        });
        assert_same_tissue(&with.1, &without.1);
        assert_eq!(with.0["failed"], without.0["failed"], "{name}");
        assert_eq!(without.0["implausible"], Value::Array(Vec::new()));
        let [record] = &with.0["implausible"].as_array().expect("a list")[..] else {
            panic!("{}", with.0);
        };
        assert_eq!(
            (&record["tool"], &record["samples"]),
            (&tool.into(), &1.into())
        );
        // Between the samples before and after it: two intervals of 16 ms.
        let duration = record["duration"].as_f64().expect("a number");
        assert!((duration - 0.032).abs() < 1e-9, "{record}");
        let stretch = &record["stretches"][0];
        assert_eq!(
            stretch["session_time"]
                .as_f64()
                .map(|t| (t - 1.504).abs() < 0.009),
            Some(true)
        );
        assert_eq!(&report_beside(&with.1)["implausible"][0], record);
        assert_verified(&with.1);
    }
}

/// With limits that no sample is beyond the same script is another run: the comparison above can fail.
#[test]
fn without_limits_the_sample_moves_the_tissue() {
    let folder = scratch();
    let wide = "[hand]\nspeed = \"1000 m/s\"\nacceleration = \"1000000 m/s²\"\n";
    let config = config_with(folder.path(), SETTINGS, wide);
    let script = outlier("coordination-20mm");
    let input = format!("script:{}", script.display());
    let mut wide = command(["--config".as_ref(), config.as_os_str()]);
    wide.args([
        "run",
        "coordination",
        "--level",
        "4",
        "--json",
        "--no-pictures",
    ]);
    wide.args(["--input", &input, "--session"])
        .arg(folder.path().join("wide.session"));
    let wide = finish(&mut wide).expect(0).json();
    let shipped = folder.path().join("shipped.session");
    run("coordination", "4", &script, &shipped);
    assert_eq!(wide["implausible"], Value::Array(Vec::new()));
    let forces = |session: &Path| report_beside(session)["forces"].clone();
    assert!(forces(&folder.path().join("wide.session")) != forces(&shipped));
}

/// The level is passed as without the sample, with the same forces and cuts to the bit, and the sample is named beside the verdict, on the page and in the JSON.
#[test]
fn a_passing_run_with_one_wrong_sample_passes_and_names_it() {
    let folder = scratch();
    let straight = repository().join("modules/coordination/scripts/level4-pass.toml");
    let without = folder.path().join("straight.session");
    run("coordination", "4", &straight, &without);
    for (name, acceleration) in [
        // (20 mm − 4 · 0.25 mm) / (16 ms)², and the same of 5 mm.
        ("coordination-pass-20mm", 0.019 / 0.016_f64.powi(2)),
        ("coordination-pass-5mm", 0.004 / 0.016_f64.powi(2)),
    ] {
        let session = folder.path().join(format!("{name}.session"));
        let printed = run("coordination", "4", &outlier(name), &session);
        assert_eq!(printed["verdict"], "passed", "{printed}");
        assert_same_tissue(&session, &without);
        let stretch = &printed["implausible"][0]["stretches"][0];
        assert_eq!(printed["implausible"][0]["samples"], 1, "{printed}");
        assert_eq!(stretch["limit"], "acceleration");
        let value = stretch["value"].as_f64().expect("a number");
        assert!(
            (value / acceleration - 1.0).abs() < 1e-6,
            "{value}, expected {acceleration}"
        );

        let shown = microsim(["report".as_ref(), session.as_os_str()])
            .expect(0)
            .out;
        let sentence = "The tracker reported 1 sample that no hand makes; it was left out";
        assert!(shown.contains(sentence), "{shown}");
        let page = fs::read_to_string(session.with_extension("html")).expect("a page");
        for text in [
            sentence,
            "Der Tracker meldete einen Messwert, den keine Hand macht; er wurde weggelassen",
            "What no hand makes",
            "Was keine Hand macht",
            "Check view, light and how the markers are fixed",
        ] {
            assert!(page.contains(text), "{name}: no \"{text}\"");
        }
        // What a tick takes is bounded: nothing was divided, held or computed again for it.
        let warnings = report_beside(&session)["warnings"].to_string();
        assert!(
            !warnings.contains("divided") && !warnings.contains("jumped"),
            "{warnings}"
        );
    }
}

/// Jaws that close by 13 % in 16 ms are within what a hand does; the run passes with them wherever they lie between the ticks, and nothing is named.
#[test]
fn jaws_that_twitch_as_a_hand_could_are_taken() {
    let folder = scratch();
    let text = fs::read_to_string(outlier("coordination-pass-jaws")).expect("the script");
    for later in (0..8).map(|k| 2.0 * f64::from(k)) {
        let mut moved = text.clone();
        // The last one first: no key is moved onto one that is still to be.
        for time in [2.724, 2.72, 2.704, 2.7] {
            let key = format!("t = {time}\n");
            assert_eq!(moved.matches(&key).count(), 1, "{key}");
            moved = moved.replace(&key, &format!("t = {}\n", time + 1e-3 * later));
        }
        let script = folder.path().join(format!("jaws-{later}.toml"));
        fs::write(&script, moved).expect("written");
        let session = script.with_extension("session");
        let printed = run("coordination", "4", &script, &session);
        assert_eq!(printed["verdict"], "passed", "{later} ms: {printed}");
        assert_eq!(printed["implausible"], Value::Array(Vec::new()));
    }
}
