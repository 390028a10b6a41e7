//! A small sample of synthetic trainees: what is true of all of them by the way they are made. How groups of them differ is measured by
//! `cargo xtask soak trainees`, and shows nothing about people.

use microsim_tests::{microsim, trainees};

/// Both kinds come to an end with a verdict, are labelled in session and page, and replay to the bit; the same number gives the same
/// bytes, another one others.
#[test]
fn trainees_run_are_labelled_and_replay() {
    let folder = tempfile::tempdir().expect("a folder");
    let again = tempfile::tempdir().expect("a folder");
    let mut scripts = Vec::new();
    for profile in ["expert", "novice"] {
        for seed in [1, 2] {
            let script = trainees::make("push-strip", 3, profile, seed, folder.path());
            let bytes = std::fs::read(&script).expect("a script");
            let same = trainees::make("push-strip", 3, profile, seed, again.path());
            assert_eq!(bytes, std::fs::read(same).expect("a script"));
            assert!(!scripts.contains(&bytes));
            scripts.push(bytes);

            let (session, report) = trainees::run("push-strip", 3, &script);
            assert!(
                report["verdict"] == "passed" || report["verdict"] == "failed",
                "{}",
                report["verdict"]
            );
            let label = format!("profile {profile}, seed {seed}, from level3-pass.toml");
            assert_eq!(report["session"]["synthetic"], *label);
            let page = std::fs::read_to_string(script.with_extension("html")).expect("a page");
            assert!(page.contains("Synthetic trainee.") && page.contains(&label));
            let session = session.to_str().expect("UTF-8");
            microsim(["replay", session, "--verify"]).expect(0);
            // A synthetic trainee stays one when its session is played as a recording.
            let played = folder
                .path()
                .join(format!("played-{profile}-{seed}.session"));
            let played = played.to_str().expect("UTF-8");
            if seed == 1 && profile == "expert" {
                let input = format!("recording:{session}");
                let args = [
                    "run",
                    "push-strip",
                    "--level",
                    "3",
                    "--input",
                    &input,
                    "--session",
                    played,
                    "--json",
                ];
                microsim(args).expect(0);
                let said = microsim(["report", played, "--json"]).expect(0).json();
                assert_eq!(said["session"]["synthetic"], *label);
            }
        }
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
        let said = microsim(["trainee", plan, "--profile", profile, "--out", out]);
        said.expect(2).err
    };
    assert!(make(script, "expert", other).contains("synthetic trainee already"));
    let plan = "modules/push-strip/scripts/level1-pass.toml";
    assert!(make(plan, "surgeon", other).contains("it has: expert, novice"));
    assert!(make(plan, "expert", script).contains(script));
}
