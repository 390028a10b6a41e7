//! The numbers of levels that copies may have otherwise: of every shipped level and variant.

use microsim_host::assemble::{Installation, known_metrics};
use microsim_settings::{
    Level, LevelCopy, LevelNumber, Loaded, ModuleFolder, NumberGroup, level_numbers,
    load_level_with, read_level_with,
};
use microsim_tests::repository;
use std::collections::BTreeSet;

/// Each level with its module and numbers.
fn levels(installation: &Installation) -> Vec<(&ModuleFolder, Loaded<Level>, Vec<LevelNumber>)> {
    let vessels = installation.config.join("vessels");
    let mut found = Vec::new();
    for module in &installation.tree.modules {
        let manifest = &module.manifest.settings;
        let variants = module.variants.iter().map(|variant| &variant.path);
        for path in module.levels.iter().chain(variants) {
            let level = load_level_with(path, manifest, &known_metrics(), &vessels);
            let level = level.unwrap_or_else(|e| panic!("{e}"));
            let numbers = level_numbers(&level, manifest, &known_metrics(), &|_| None);
            found.push((module, level, numbers));
        }
    }
    found
}

/// Each number that is written once more with its own text leaves the level as it is, and its comments and all else byte for byte: so every number has its place in
/// its file. Written with another text it is that value, and nothing else is another.
#[test]
fn each_number_of_each_level_has_its_place() {
    let installation = Installation::open(&repository(), None).expect("the sources");
    let vessels = installation.config.join("vessels");
    let levels = levels(&installation);
    assert!(levels.len() > 30, "{}", levels.len());
    let mut groups = BTreeSet::new();
    for (module, level, numbers) in &levels {
        let name = level.document.path().display().to_string();
        assert!(
            numbers.iter().any(|n| n.group == NumberGroup::Limit),
            "{name}"
        );
        let copy = LevelCopy {
            text: level.document.text(),
            value: level.document.value(),
            of: "it",
        };
        let read = |text: &str| {
            let manifest = &module.manifest.settings;
            let read = read_level_with(text, &name, manifest, &known_metrics(), &vessels);
            read.unwrap_or_else(|e| panic!("{e}"))
        };
        for number in numbers {
            groups.insert(number.group);
            let key = format!("{name}: {}", number.key);
            let value = number.read(&number.text);
            // What people read has twelve digits.
            let off = value.map(|value| (value - number.value).abs() / number.value.abs().max(1.0));
            assert!(off.is_ok_and(|off| off < 1e-11), "{key}: {}", number.text);
        }
        // Those whose text is exact.
        let same = numbers.iter().filter(|n| n.read(&n.text) == Ok(n.value));
        let same = same.map(|number| (number.key.clone(), number.text.clone()));
        let same: Vec<_> = same.collect();
        assert!(same.len() > numbers.len() / 2, "{name}");
        let text = copy.with(&same).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut expected = level.document.value().clone();
        expected["tuned"] = serde_json::Value::Null;
        let mut found = read(&text).document.value().clone();
        found["tuned"] = serde_json::Value::Null;
        assert_eq!(found, expected, "{name}");
        // Half as much of what is demanded of the time alone.
        let Some(time) = numbers.iter().find(|n| n.key.to_string() == "limit[0].max") else {
            continue;
        };
        let half = format!("{} {}", 0.75 * time.value, time.unit.symbol());
        let change = [(time.key.clone(), half)];
        let text = copy.with(&change).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut expected = level.document.value().clone();
        expected["limit"][0]["max"] = serde_json::Value::from(0.75 * time.value);
        assert_eq!(read(&text).document.value(), &expected, "{name}");
        // But for that line and the first one the file is as it was.
        let lines = text.lines().skip(1).zip(level.document.text().lines());
        let others = lines.filter(|(now, before)| now != before).count();
        assert_eq!(others, 1, "{name}");
    }
    use NumberGroup::{Contact, Limit, Metrics, Module, Tissue};
    assert_eq!(groups, [Tissue, Contact, Limit, Metrics, Module].into());
}
