//! Copies of levels with other numbers, in the data folder of the user.

use super::AtThisPlace;
use crate::discretisation::Meshes;
use crate::folders::make;
use crate::output::Problem;
use crate::replace_file::write_new;
use crate::scene_file::{check_level, models_of};
use microsim_host::assemble::{Installation, known_metrics};
use microsim_message::LocalText;
use microsim_settings::{
    self as settings, Form, LevelCopy, LevelNumber, WrongNumber, level_numbers, read_level_with,
};
use microsim_training::MOTION_METRICS;
use microsim_window::{Changes, Choice, LevelCopies};
use settings::{Level, Loaded};
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl LevelCopies for AtThisPlace {
    fn numbers(&self, choice: &Choice) -> Result<Vec<LevelNumber>, String> {
        numbers(&self.installation, choice)
    }

    fn complaints(&self, choice: &Choice, changes: &Changes) -> Vec<String> {
        match copy(&self.installation, choice, Path::new(""), changes) {
            Ok(_) => Vec::new(),
            Err(why) => why.lines().map(str::to_owned).collect(),
        }
    }

    fn store_copy(
        &self,
        choice: &Choice,
        name: &str,
        changes: &Changes,
    ) -> Result<PathBuf, String> {
        store(&self.installation, choice, name, changes)
    }
}

/// The level that is copied, which may be a copy itself.
fn original(installation: &Installation, choice: &Choice) -> Result<Arc<Loaded<Level>>, String> {
    let variant = choice.variant.as_deref();
    let level = installation.variant(&choice.module, choice.level, variant);
    level.map_err(|e| e.to_string())
}

fn numbers(installation: &Installation, choice: &Choice) -> Result<Vec<LevelNumber>, String> {
    let module = installation.module(&choice.module);
    let manifest = &module.map_err(|e| e.to_string())?.manifest.settings;
    let title = |id: &str| -> Option<LocalText> {
        let metric = MOTION_METRICS.iter().find(|metric| metric.id == id)?;
        Some(metric.title.clone())
    };
    let level = original(installation, choice)?;
    Ok(level_numbers(&level, manifest, &known_metrics(), &title))
}

/// The text of a copy, and what is read from it; `path` is its file.
fn copy(
    installation: &Installation,
    choice: &Choice,
    path: &Path,
    changes: &Changes,
) -> Result<(String, Loaded<Level>), String> {
    let module = installation.module(&choice.module);
    let manifest = &module.map_err(|e| e.to_string())?.manifest.settings;
    let level = original(installation, choice)?;
    let variant = choice.variant.as_ref();
    let variant = variant.map(|name| format!(" (variant {name})"));
    let of = format!(
        "level {}{} of {}",
        choice.level,
        variant.unwrap_or_default(),
        choice.module
    );
    let text = LevelCopy {
        text: level.document.text(),
        value: level.document.value(),
        of: &of,
    };
    let text = text.with(changes)?;
    let vessels = installation.config.join("vessels");
    let file = path.display().to_string();
    let read = read_level_with(&text, &file, manifest, &known_metrics(), &vessels);
    Ok((text, read.map_err(|e| e.to_string())?))
}

/// Why a number is none for the level, for a message.
fn refusal(number: &LevelNumber, text: &str, why: &WrongNumber) -> String {
    let what = match why {
        WrongNumber::NotANumber => "no number".to_owned(),
        WrongNumber::DecimalComma => "its decimal sign is no point".to_owned(),
        WrongNumber::NoUnit => format!("without a unit: {}", number.units().join(", ")),
        WrongNumber::OtherUnit => format!("another unit than {}", number.units().join(", ")),
        WrongNumber::NotWhole => "not a whole number".to_owned(),
        WrongNumber::OutOfRange => format!("outside {}", number.range_text()),
    };
    format!("{} = {text}: {what}", number.key)
}

fn store(
    installation: &Installation,
    choice: &Choice,
    name: &str,
    changes: &Changes,
) -> Result<PathBuf, String> {
    if !Form::Identifier.accepts(name) {
        return Err(format!(
            "\"{name}\" is no name of a level: lower-case letters, digits and single hyphens, a letter first"
        ));
    }
    let module = installation.module(&choice.module);
    let module = module.map_err(|e| e.to_string())?;
    let (variants, _) = installation.variants(module);
    let mut same = variants.iter().filter(|of| of.level == choice.level);
    if let Some(there) = same.find(|of| of.name == name) {
        let there = there.path.display();
        return Err(format!(
            "there is a variant \"{name}\" of this level already ({there}), and nothing is replaced: take another name"
        ));
    }
    let known = numbers(installation, choice)?;
    for (key, text) in changes {
        let number = known.iter().find(|number| number.key == *key);
        let number = number.ok_or_else(|| format!("the level has no number `{key}`"))?;
        number
            .read(text)
            .map_err(|why| refusal(number, text, &why))?;
    }
    let folder = installation.folder_made_here(module).ok_or(
        "there is no folder of this user: neither --data nor MICROSIM_DATA is given, and there is no home folder",
    )?;
    let path = folder.join(format!("level{}.{name}.toml", choice.level));
    let (text, level) = copy(installation, choice, &path, changes)?;
    let models = models_of(installation, &level.settings);
    check_level(&level, &models, &module.level_folder(), Meshes::Stated)?;
    make(&folder)?;
    write_new(&path, text.as_bytes()).map_err(|problem| match problem {
        Problem::Text(text) => text,
        Problem::BrokenPipe => "a closed pipe".to_owned(),
    })?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_host::assemble::Places;
    use serde_json::Value;

    /// The sources, which are an installation but for its libraries, with copies in a folder.
    fn installation(made_here: &Path) -> Installation {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let places = Places {
            levels: Some(made_here.to_path_buf()),
            ..Places::default()
        };
        Installation::open_with(&root, None, &places).expect("the sources")
    }

    fn choice(module: &str, level: u32) -> Choice {
        Choice {
            module: module.into(),
            level,
            variant: None,
            trainee: None,
            hand: Default::default(),
        }
    }

    fn change(installation: &Installation, of: &Choice, key: &str, text: &str) -> Changes {
        let numbers = numbers(installation, of).expect("numbers");
        let number = numbers.iter().find(|number| number.key.to_string() == key);
        vec![(number.expect(key).key.clone(), text.to_owned())]
    }

    /// Expected is the shipped level as it is read, with the one value replaced by hand and without what was measured of it.
    #[test]
    fn a_copy_is_the_level_with_the_one_value() {
        let folder = tempfile::tempdir().expect("a folder");
        let installation = installation(folder.path());
        let of = choice("coordination", 4);
        let key = "body[0].material[0].youngs_modulus";
        let soft = change(&installation, &of, key, "40 kPa");
        let path = store(&installation, &of, "soft", &soft).expect("stored");
        assert_eq!(path, folder.path().join("coordination/level4.soft.toml"));
        let value = |variant| {
            let read = installation.variant("coordination", 4, variant);
            read.expect("a level").document.value().clone()
        };
        let mut expected = value(None);
        expected["body"][0]["material"][0]["youngs_modulus"] = Value::from(40e3);
        expected["tuned"] = Value::Null;
        let mut found = value(Some("soft"));
        found["tuned"] = found["tuned"].take();
        assert_eq!(found, expected);
        // A copy of the copy; the meshes of a level are found from there.
        let again = Choice {
            variant: Some("soft".into()),
            ..of.clone()
        };
        let time = change(&installation, &again, "limit[0].max", "70 s");
        let path = store(&installation, &again, "slow", &time).expect("stored");
        let text = std::fs::read_to_string(path).expect("a file");
        assert!(text.starts_with(
            "# A copy of level 4 (variant soft) of coordination, with limit[0].max = 70 s.\n# A copy of level 4 of coordination, with"
        ));
        assert!(text.contains("max = \"70 s\"\nfull = \"20 s\"") && text.contains("\"40 kPa\""));
        let of = choice("trim-sharp", 1);
        store(&installation, &of, "as-it-is", &Vec::new()).expect("stored");
    }

    #[test]
    fn what_is_no_level_is_not_stored() {
        let folder = tempfile::tempdir().expect("a folder");
        let installation = installation(folder.path());
        let of = choice("coordination", 4);
        let key = "body[0].material[0].youngs_modulus";
        let refused = |text: &str| {
            let changes = change(&installation, &of, key, text);
            store(&installation, &of, "x", &changes).expect_err(text)
        };
        // The range of the schema.
        assert_eq!(
            refused("0.5 Pa"),
            format!("{key} = 0.5 Pa: outside 1 Pa … 100 GPa")
        );
        assert_eq!(
            refused("80"),
            format!("{key} = 80: without a unit: Pa, GPa, MPa, kPa")
        );
        assert!(refused("80 mm").ends_with("another unit than Pa, GPa, MPa, kPa"));
        assert!(refused("0,5 kPa").ends_with("its decimal sign is no point"));
        assert!(refused("soft").ends_with("no number"));
        // Each for itself may be, together they are no limit.
        let full = change(&installation, &of, "limit[0].full", "95 s");
        let why = store(&installation, &of, "x", &full).expect_err("no limit");
        assert!(why.contains("`full` below `zero`"), "{why}");
        for name in ["", "Soft", "a b", "../x", "a.b"] {
            let why = store(&installation, &of, name, &Vec::new()).expect_err(name);
            assert!(why.contains("is no name of a level"), "{why}");
        }
        assert!(!folder.path().join("coordination").exists());
    }

    #[test]
    fn nothing_is_replaced_and_a_place_that_takes_nothing_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let of = choice("push-strip", 1);
        let here = installation(folder.path());
        let path = store(&here, &of, "mine", &Vec::new()).expect("stored");
        let before = std::fs::read(&path).expect("a file");
        let slow = change(&here, &of, "limit[0].max", "61 s");
        let why = store(&here, &of, "mine", &slow).expect_err("there");
        assert!(why.contains("nothing is replaced"), "{why}");
        assert_eq!(std::fs::read(&path).expect("a file"), before);
        // One of the module's own variants has the name.
        let of = choice("push-strip", 2);
        let why = store(&here, &of, "dissertation", &Vec::new()).expect_err("there");
        assert!(why.contains("level2.dissertation.toml"), "{why}");
        let file = folder.path().join("file");
        std::fs::write(&file, "").expect("a file");
        let why = store(&installation(&file), &of, "mine", &Vec::new()).expect_err("no folder");
        assert!(why.contains("cannot be written"), "{why}");
    }
}
