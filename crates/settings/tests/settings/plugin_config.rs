//! The types common to host and plugins cross between them unchanged.

use crate::{KNOWN_METRICS, example, manifest};
use microsim_settings::*;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Value, json};
use std::fmt::Debug;

/// As the value of a set-up, and back.
fn crossed<T: Serialize + DeserializeOwned>(config: &T) -> T {
    let value = serde_json::to_value(config).expect("plain data");
    serde_json::from_value(value).expect("the same type")
}

/// Nothing is lost, and a key that the other side does not know, a key that is missing and a value of another type are refused by name.
fn assert_crosses<T: Serialize + DeserializeOwned + PartialEq + Debug>(config: &T) {
    assert_eq!(crossed(config), *config);
    let value = serde_json::to_value(config).expect("plain data");
    let refused = |key: &str, changed: Option<Value>| {
        let mut value = value.clone();
        let table = value.as_object_mut().expect("a table");
        match changed {
            Some(changed) => table.insert(key.to_owned(), changed),
            None => table.remove(key),
        };
        let read = serde_json::from_value::<T>(value);
        read.map(drop).map_err(|error| error.to_string())
    };
    let message = refused("zzz", Some(json!(1))).expect_err("an unknown key");
    assert!(message.contains("unknown field `zzz`"), "{message}");
    for (key, value) in value.as_object().expect("a table") {
        // What a module's own keys may hold, its manifest decides.
        if key == "module" {
            continue;
        }
        let other = if value.is_boolean() {
            json!("yes")
        } else {
            json!(true)
        };
        let message = refused(key, Some(other)).expect_err(key);
        assert!(message.contains("expected"), "{key}: {message}");
        if let Err(message) = refused(key, None) {
            assert!(
                message.contains(&format!("missing field `{key}`")),
                "{message}"
            );
        }
    }
}

/// The examples write every key of their schemas.
#[test]
fn configurations_cross_unchanged() {
    let manifest = manifest();
    let level = read_level(example("level"), "level1.toml", &manifest, &KNOWN_METRICS);
    let level = level.expect("the example is right").settings;
    let tool = read_tool(example("tool"), "tool.toml").expect("the example is right");
    let mut models = ToolModels::new();
    for slot in &level.tool {
        models.insert(slot.model.clone(), tool.settings.clone());
    }
    assert_crosses(&PhysicsConfig::new(&level, &models).expect("a level with physics"));
    assert_crosses(&ModuleConfig::new(&level, &manifest, &models));
    assert_crosses(&ObjectsConfig::new(&level));
    assert_crosses(&RendererConfig::new(&level, &models, (640, 480)));
    let script = read_script(example("script"), "script.toml").expect("the example is right");
    assert_crosses(&ScriptConfig {
        script: script.settings,
    });
    let map = read_recording_map(example("recording"), "map.toml").expect("the example is right");
    assert_crosses(&RecordingConfig::Csv {
        name: "motion.csv".into(),
        map: Box::new(map.settings),
    });
    assert_eq!(crossed(&RecordingConfig::Samples), RecordingConfig::Samples);
    let translator = read_translator(example("translator"), "translator.toml");
    let translator = translator.expect("the example is right").settings;
    assert_crosses(&TranslatorConfig::new(&translator, None, &level.tool));
    assert_crosses(&RecorderConfig {
        path: "runs/a.session".into(),
    });
}

/// A device that the file lists drives the tool that it names, another one the tool of its own name; one that drives no tool of
/// the level is left out.
#[test]
fn devices_drive_the_tools_that_the_file_says_or_those_of_their_own_names() {
    let text = "[[device]]\nname = \"stylus\"\ntool = \"left\"\n";
    let translator = read_translator(text, "translator.toml");
    let translator = translator.expect("a right file").settings;
    let slot = |name: &str| ToolSlot {
        name: name.into(),
        model: "probe".into(),
    };
    let driven = |devices: Option<&[String]>| {
        let config = TranslatorConfig::new(&translator, devices, &[slot("left"), slot("right")]);
        let pairs = config.devices.into_iter().map(|map| (map.name, map.tool));
        pairs.collect::<Vec<_>>()
    };
    let pair = |device: &str, tool: &str| (device.to_owned(), tool.to_owned());
    let devices = ["right", "stylus", "camera"].map(String::from);
    let expected = [pair("right", "right"), pair("stylus", "left")];
    assert_eq!(driven(Some(&devices)), expected);
    assert_eq!(
        driven(None),
        [pair("stylus", "left"), pair("right", "right")]
    );
}
