//! Variants of levels: the same task with other methods, chosen by name.

use microsim_tests::stations::Station;
use microsim_tests::{microsim, repository};
use serde_json::{Value, json};

/// A variant is listed, planned under its name and its title, and refused with those that there are.
#[test]
fn variants_of_levels_are_chosen_by_name() {
    let listed = microsim(["list", "--json"]).expect(0).json();
    let modules = listed["modules"].as_array().expect("modules");
    let levels = modules.iter().flat_map(|module| {
        let levels = module["levels"].as_array().expect("levels").iter();
        levels.map(|level| (module["name"].clone(), level))
    });
    let with_variants = levels.filter(|(_, level)| level["variants"] != json!([]));
    let found: Vec<Value> = with_variants
        .map(|(module, level)| json!([module, level["level"], level["variants"]]))
        .collect();
    let variants = ["dissertation"];
    let expected = [
        json!(["coordination", 2, variants]),
        json!(["push-strip", 2, variants]),
    ];
    assert_eq!(found, expected);
    let of_level = |level: &str, variant: &str| {
        let script = "script:level2-pass.toml";
        let arguments = [
            "run",
            "coordination",
            "--level",
            level,
            "--variant",
            variant,
        ];
        microsim(
            arguments
                .into_iter()
                .chain(["--input", script, "--explain", "--json"]),
        )
    };
    let planned = of_level("2", "dissertation").expect(0).json();
    assert_eq!(planned["variant"], "dissertation");
    let parts = planned["parts"].as_array().expect("parts");
    assert!(
        parts.iter().any(|part| part["name"] == "velocity-verlet"),
        "{parts:?}"
    );
    let refused = of_level("2", "2015").expect(2).err;
    assert!(
        refused.contains("has no variant \"2015\": there is dissertation"),
        "{refused}"
    );
    let refused = of_level("3", "dissertation").expect(2).err;
    assert!(refused.contains("has no variants"), "{refused}");
}

/// A copy of a level that was made here is listed and played as a variant, and its session and report name it and its file. Beside it a file that is none is named,
/// and hides nothing.
#[test]
fn a_copy_of_a_level_is_played_as_a_variant() {
    let station = Station::new();
    let folder = station.data().join("levels/push-strip");
    std::fs::create_dir_all(&folder).expect("a folder");
    let shipped = repository().join("modules/push-strip/levels/level1.toml");
    let shipped = std::fs::read_to_string(shipped).expect("a level");
    // The one limit that ends the level, so short that the passing script fails it.
    let time = shipped.find("metric = \"time\"").expect("a limit");
    let max = time + shipped[time..].find("max = ").expect("its value");
    let end = max + shipped[max..].find('\n').expect("a line");
    let mut changed = shipped.clone();
    changed.replace_range(max..end, "max = \"0.5 s\"");
    std::fs::write(folder.join("level1.short.toml"), changed).expect("written");
    std::fs::write(folder.join("notes.toml"), "mine").expect("written");
    // What an editor leaves beside it is none of it.
    std::fs::write(folder.join("level1.short.toml~"), "old").expect("written");
    let listed = station.microsim(&["list", "--json"]).expect(0);
    assert!(listed.err.contains("notes.toml"), "{}", listed.err);
    assert!(!listed.err.contains("toml~"), "{}", listed.err);
    let listed = listed.json();
    let modules = listed["modules"].as_array().expect("modules");
    let module = modules.iter().find(|of| of["name"] == "push-strip");
    assert_eq!(
        module.expect("push-strip")["levels"][0]["variants"],
        json!(["short"])
    );
    let session = station.session("a");
    let run = station.microsim(&[
        "run",
        "push-strip",
        "--variant",
        "short",
        "--input",
        "script:level1-pass.toml",
        "--session",
        session.to_str().expect("UTF-8"),
        "--json",
    ]);
    let run = run.expect(0).json();
    assert_eq!(
        (&run["variant"], &run["verdict"]),
        (&json!("short"), &json!("failed"))
    );
    let report = std::fs::read_to_string(session.with_extension("html")).expect("a report");
    assert!(report.contains("(variant short)") && report.contains("level1.short.toml"));
    station.microsim(&["replay", "a", "--verify"]).expect(0);
}
