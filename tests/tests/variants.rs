//! Variants of levels: the same task with other methods, chosen by name.

use microsim_tests::microsim;
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
