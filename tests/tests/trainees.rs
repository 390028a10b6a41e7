//! A small sample of synthetic trainees: what is true of all of them by construction. How groups of them differ is measured by
//! `cargo xtask soak trainees`, and shows nothing about people.

use microsim_tests::{microsim, trainees};
use std::path::Path;

/// A level that costs little, and one of a surgical module; numbers of trainees.
const SAMPLES: [(&str, u32, &[u64]); 2] = [("push-strip", 3, &[1, 2]), ("coordination", 2, &[1])];

/// Both kinds come to an end with a verdict, are labelled in session, page, tables and all output, and replay to the bit;
/// on coordination they press no harder than a hand can. The same number gives the same bytes, another one others.
#[test]
fn trainees_run_are_labelled_and_replay() {
    let folder = tempfile::tempdir().expect("a folder");
    let again = tempfile::tempdir().expect("a folder");
    for (module, level, seeds) in SAMPLES {
        let mut scripts = Vec::new();
        for profile in ["expert", "novice"] {
            for &seed in seeds {
                let [folder, again] =
                    [&folder, &again].map(|f| f.path().join(format!("{module}-{profile}-{seed}")));
                for folder in [&folder, &again] {
                    std::fs::create_dir(folder).expect("a new folder");
                }
                let script = trainees::make(module, level, profile, seed, &folder);
                let bytes = std::fs::read(&script).expect("a script");
                let same = trainees::make(module, level, profile, seed, &again);
                assert_eq!(bytes, std::fs::read(same).expect("a script"));
                assert!(!scripts.contains(&bytes));
                scripts.push(bytes);
                runs(
                    module,
                    level,
                    &script,
                    &format!("profile {profile}, seed {seed}"),
                );
            }
        }
    }
}

/// One run of a trainee made as `made` prescribes.
fn runs(module: &str, level: u32, script: &Path, made: &str) {
    let (session, printed, report) = trainees::run(module, level, script);
    let verdict = &report["verdict"];
    assert!(verdict == "passed" || verdict == "failed", "{verdict}");
    let label = format!("{made}, from level{level}-pass.toml");
    assert_eq!(report["session"]["synthetic"], *label);
    assert_eq!(printed["synthetic"], *label);
    let read = |extension: &str| {
        let path = script.with_extension(extension);
        std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    };
    let page = read("html");
    assert!(page.contains("Synthetic trainee.") && page.contains(&label));
    for table in ["metrics.csv", "series.csv"] {
        let table = read(table);
        let mut lines = table.lines();
        assert!(
            lines
                .next()
                .is_some_and(|header| header.ends_with(",synthetic"))
        );
        // Each row ends with the label, quoted as it has commas in it.
        let end = format!(",\"{label}\"");
        assert!(lines.clone().count() > 0 && lines.all(|line| line.ends_with(&end)));
    }
    // Where effect sizes are measured, a force that cannot be would be among the figures.
    if module == "coordination" {
        assert!(trainees::largest_force(&report) < trainees::ABSURD_FORCE);
    }
    microsim_tests::assert_verified(&session);
    // A synthetic trainee stays one when its session is played as a recording.
    if made == "profile expert, seed 1" {
        let played = script.with_extension("played.session");
        let input = format!("recording:{}", session.display());
        let level = level.to_string();
        let printed = microsim_tests::run(module, &played, &["--level", &level, "--input", &input]);
        assert_eq!(printed["synthetic"], *label);
    }
}

/// A plan that is synthetic already, a profile that is not there and a file that is there are refused by name.
#[test]
fn what_cannot_be_made_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = trainees::make("push-strip", 1, "expert", 1, folder.path());
    let script = script.to_str().expect("UTF-8");
    let other = folder.path().join("other.toml");
    let other = other.to_str().expect("UTF-8");
    let make = |plan: &str, profile: &str, out: &str| {
        let printed = microsim(["trainee", plan, "--profile", profile, "--out", out]);
        printed.expect(2).err
    };
    assert!(make(script, "expert", other).contains("synthetic trainee already"));
    let plan = "modules/push-strip/scripts/level1-pass.toml";
    assert!(make(plan, "surgeon", other).contains("it has: expert, novice"));
    assert!(make(plan, "expert", script).contains(script));
}

/// Forceps whose reading with nothing between the jaws is 0 close completely where they hold anything: a trembling hand that does so on the tuft of a vessel crushes it, holds it all the while and lets it go,
/// so that the end is left free for the time that the level asks for. Before jaws left a tenth of what they squeeze the tuft turned inside out and hung on a jaw: these trainees failed for other reasons besides.
#[test]
fn a_trembling_hand_that_closes_completely_lets_go() {
    for level in [2, 4] {
        let folder = tempfile::tempdir().expect("a folder");
        let script = trainees::make("dilatation", level, "expert", 1, folder.path());
        let text = std::fs::read_to_string(&script).expect("a script");
        let mut motion: toml::Table = text.parse().expect("TOML");
        let tools = motion["tool"].as_array_mut().expect("tools");
        let left = tools
            .iter_mut()
            .find(|tool| tool["name"].as_str() == Some("left"));
        let keys = left.expect("forceps")["key"].as_array_mut();
        let mut closed = 0;
        for key in keys.expect("keys") {
            // What is held is held at 0.09, and all else is at 0.35.
            if key["opening"]
                .as_float()
                .is_some_and(|opening| opening < 0.12)
            {
                key["opening"] = toml::Value::Float(0.0);
                closed += 1;
            }
        }
        assert!(closed > 100, "level {level}: {closed}");
        std::fs::write(&script, motion.to_string()).expect("a script");
        let (_, printed, _) = trainees::run("dilatation", level, &script);
        assert_eq!(
            printed["failed"],
            serde_json::json!(["crushed"]),
            "level {level}"
        );
    }
}
