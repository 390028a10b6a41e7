//! The types common to host and plugins cross between them unchanged.

use crate::{KNOWN_METRICS, example, manifest};
use microsim_settings::*;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Value, json};
use std::fmt::Debug;
use std::path::Path;

/// A right-handed trainee with instruments.
const RIGHT: Trainee = Trainee {
    dominant: DominantHand::Right,
    holds_instruments: true,
};

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
    assert_crosses(&ObjectsConfig::new(
        &level,
        [("mat.glb".to_owned(), "00ff".to_owned())].into(),
    ));
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
    assert_crosses(&TranslatorConfig::new(
        &translator,
        &Calibration::default(),
        None,
        &level.tool,
        RIGHT,
    ));
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
        let slots = [slot("left"), slot("right")];
        let config =
            TranslatorConfig::new(&translator, &Calibration::default(), devices, &slots, RIGHT);
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

/// What is not configured is not in the value that decides the state hash; what is, is, and only as far as the level has tools for it.
#[test]
fn only_what_is_configured_crosses() {
    let slot = |name: &str| ToolSlot {
        name: name.into(),
        model: "probe".into(),
    };
    let slots = [slot("left"), slot("right")];
    let config = |text: &str, devices: Option<&[String]>| {
        let translator = read_translator(text, "translator.toml");
        let translator = translator.expect("a right file").settings;
        let trainee = Trainee {
            dominant: translator.dominant,
            holds_instruments: true,
        };
        TranslatorConfig::new(
            &translator,
            &Calibration::default(),
            devices,
            &slots,
            trainee,
        )
    };
    let value = serde_json::to_value(config("", None)).expect("plain data");
    let keys: Vec<&String> = value.as_object().expect("a table").keys().collect();
    assert_eq!(keys, ["devices", "hand", "stale_after", "tools"]);

    // The other hand: devices change places, known beforehand or not.
    let devices = ["left", "right"].map(String::from);
    for known in [None, Some(&devices[..])] {
        let config = config("dominant = \"left\"", known);
        let mut pairs: Vec<_> = config
            .devices
            .iter()
            .map(|d| (&d.name[..], &d.tool[..]))
            .collect();
        pairs.sort_unstable();
        assert_eq!(pairs, [("left", "right"), ("right", "left")]);
        assert!(config.mirrored && config.dominant == DominantHand::Left);
    }

    // A script moves in the level's own field, whoever is shown a mirrored picture.
    let script = Trainee {
        dominant: DominantHand::Left,
        holds_instruments: false,
    };
    let plain = read_translator("", "translator.toml").expect("nothing");
    let shown = TranslatorConfig::new(
        &plain.settings,
        &Calibration::default(),
        Some(&devices[..]),
        &slots,
        script,
    );
    assert_eq!(
        (shown.dominant, shown.mirrored),
        (DominantHand::Left, false)
    );
    assert!(
        shown
            .devices
            .iter()
            .all(|device| device.name == device.tool)
    );

    // By hand: 38 mm of the field over 420 mm of the box.
    let boxed = config(
        "[[box]]\ndevice = \"left\"\ncentre = [0.1, 0.2, 0.3]\n",
        None,
    );
    let left = boxed
        .devices
        .iter()
        .find(|device| device.name == "left")
        .expect("a device");
    assert_eq!((left.scale, left.origin), (0.038 / 0.42, [0.1, 0.2, 0.3]));
    let other = boxed
        .devices
        .iter()
        .find(|device| device.name == "right")
        .expect("a device");
    assert_eq!((other.scale, other.origin), (1.0, [0.0; 3]));

    let text = "[[clutch]]\ndevice = \"pedal\"\ntool = [\"left\", \"third\"]\n[[filter]]\ndevice = \"right\"\n[[filter]]\ndevice = \"third\"\n";
    let config = config(text, None);
    assert_eq!(config.clutches[0].tool, ["left"]);
    let filtered: Vec<_> = config
        .filters
        .iter()
        .map(|filter| &filter.device[..])
        .collect();
    assert_eq!(filtered, ["right"]);
    assert_eq!(config.filters[0].parameters.predict, 0.0);
}

/// No tool is shown further ahead than it may be unseen: with the default of `stale_after`, and with one that is written behind it.
#[test]
fn predictions_reach_no_further_than_a_tool_is_current() {
    let text = |predict: &str| {
        format!("[[filter]]\ndevice = \"right\"\nparameters = {{ predict = \"{predict}\" }}\n")
    };
    let read = |text: &str| read_translator(text, "translator.toml").map_err(|e| e.to_string());
    assert!(read(&text("100 ms")).is_ok());
    let refused = read(&text("120 ms")).expect_err("too far ahead");
    assert_eq!(
        refused,
        "translator.toml:3:26: key `filter[0].parameters.predict`: found 120 ms, expected at most 100 ms, after which a tool without samples is \
         stale (`stale_after`)"
    );
    let longer = format!("stale_after = \"150 ms\"\n{}", text("120 ms"));
    assert!(read(&longer).is_ok());
    let shorter = format!("stale_after = \"5 ms\"\n{}", text("10 ms"));
    let refused = read(&shorter).expect_err("too far ahead");
    assert!(
        refused.contains(":4:26:") && refused.contains("at most 5 ms"),
        "{refused}"
    );
    let far = read(&text("300 ms")).expect_err("beyond the range");
    assert!(far.contains("key `filter[0].parameters.predict`"), "{far}");
}

/// Markers are devices of a source, and what they make up drives the tool; a marker in two instruments, or markers on a line, are refused with their line.
#[test]
fn markers_make_up_a_device() {
    let marker =
        |name: &str, at: &str| format!("[[markers.marker]]\nname = \"{name}\"\nat = {at}\n");
    let tool = |last: &str| {
        let markers = [
            marker("a", "[0, 0, 0]"),
            marker("b", "[0.03, 0, 0]"),
            marker("c", last),
        ];
        format!("[[markers]]\ndevice = \"left\"\n{}", markers.concat())
    };
    let text = tool("[0, 0.05, 0]");
    let translator = read_translator(&text, "translator.toml")
        .expect("a right file")
        .settings;
    let slots = [ToolSlot {
        name: "left".into(),
        model: "probe".into(),
    }];
    let devices = ["a", "b", "c"].map(String::from);
    let config = TranslatorConfig::new(
        &translator,
        &Calibration::default(),
        Some(&devices),
        &slots,
        RIGHT,
    );
    assert_eq!(config.devices.len(), 1);
    assert_eq!(
        (&config.devices[0].name[..], config.markers.len()),
        ("left", 1)
    );
    let line = read_translator(&tool("[0.06, 0, 0]"), "t")
        .expect_err("a line")
        .to_string();
    assert!(line.contains("lie on a line"), "{line}");
    let twice = text.clone() + &text.replace("device = \"left\"", "device = \"right\"");
    let twice = read_translator(&twice, "t").expect_err("twice").to_string();
    assert!(twice.contains("`a` a second time"), "{twice}");
}

/// The width of the box, 0.4 m, becomes 25 mm in the field: a scale of 0.0625. The device of the right hand drives the left tool.
#[test]
fn the_dominant_hand_and_boxes_are_named() {
    let text = "dominant = \"left\"\n[[device]]\nname = \"tracker\"\ntool = \"right\"\n\
        [[box]]\ndevice = \"tracker\"\nsize = [0.4, 0.3, 0.25]\nfield_width = 0.025\n";
    let translator = read_translator(text, "translator.toml");
    let translator = translator.expect("it is right").settings;
    let tools = [ToolSlot {
        name: "left".into(),
        model: "forceps".into(),
    }];
    let trainee = Trainee {
        dominant: translator.dominant,
        holds_instruments: true,
    };
    let config = TranslatorConfig::new(&translator, &Calibration::default(), None, &tools, trainee);
    assert!(config.mirrored);
    let parts = translator_parts(&translator, &config, Path::new("calibration.toml"));
    let named: Vec<_> = parts.iter().map(|p| (p.what, p.name.as_str())).collect();
    assert_eq!(named, [("hand", "left"), ("box", "tracker")]);
    assert!(parts[1].why.contains("scale 0.0625"), "{:?}", parts[1]);
}
