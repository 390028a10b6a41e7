//! `config/trainees.toml`: how synthetic trainees move.
//!
//! A synthetic trainee follows the plan of a script, the way a hand does. What is here describes kinds of them; it is set before
//! anything is scored, and a group of synthetic trainees validates nothing.

use crate::check::{texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::schema::{Form, Key, Kind, Schema};
use microsim_vocabulary::Unit;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Kinds of synthetic trainees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trainees {
    /// The kinds.
    pub profile: Vec<TraineeProfile>,
}

/// One kind of synthetic trainee.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraineeProfile {
    /// Its name.
    pub name: String,
    /// RMS of the tremor between 8 and 12 Hz, all axes together, while the opening stands \[m\].
    pub tremor_still: Sourced,
    /// The same while the jaws are opened or closed \[m\].
    pub tremor_actuating: Sourced,
    /// Time for everything, as a share of that of the plan.
    pub pace: Sourced,
    /// Chance of a pause where all tools rest.
    pub hesitation_chance: Sourced,
    /// Mean length of such a pause \[s\].
    pub hesitation: Sourced,
    /// Standard deviation along each axis of where a movement ends \[m\].
    pub aiming_error: Sourced,
    /// Standard deviation about each axis of how the tool is turned where a movement ends \[rad\].
    pub angular_error: Sourced,
    /// How far a movement gets ahead of the plan, as a share of its length: beyond its end by what this is above 0.9 %.
    pub lead: Sourced,
    /// How far a movement goes astray to the side, as a share of its length.
    pub detour: Sourced,
    /// How much further than planned jaws are closed, as a share of the closing.
    pub grip_excess: Sourced,
    /// Standard deviation of the logarithm of the factor by which one trainee differs from the profile, for each parameter.
    pub spread: Sourced,
}

/// A value and where it comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sourced {
    /// The value, in SI.
    pub value: f64,
    /// Where it comes from.
    pub source: String,
    /// Whether it is a judgement that no measurement backs yet.
    pub provisional: bool,
}

/// The schema of the file.
pub fn trainees_schema() -> Schema {
    let sourced = |name: &str, unit: Unit, (min, max): (f64, f64), doc: &str| {
        let keys = vec![
            Key::required("value", Kind::quantity(unit, min, max), doc),
            Key::required("source", Kind::Text, "Where it comes from."),
            Key::with_default(
                "provisional",
                Kind::Bool,
                "Whether it is a judgement that no measurement backs yet.",
                true,
            ),
        ];
        Key::required(name, Kind::Table(keys), doc)
    };
    let share = |name: &str, max: f64, doc: &str| sourced(name, Unit::Ratio, (0.0, max), doc);
    let length = |name: &str, doc: &str| sourced(name, Unit::Length, (0.0, 0.01), doc);
    let profile = vec![
        Key::required("name", Kind::Name(Form::Identifier), "Its name."),
        length(
            "tremor_still",
            "RMS of the tremor between 8 and 12 Hz, all axes together, while the opening stands.",
        ),
        length(
            "tremor_actuating",
            "RMS of the tremor between 8 and 12 Hz, all axes together, while the jaws are opened or closed.",
        ),
        sourced(
            "pace",
            Unit::Ratio,
            (0.1, 10.0),
            "Time for everything, as a share of that of the plan.",
        ),
        share(
            "hesitation_chance",
            1.0,
            "Chance of a pause where all tools rest.",
        ),
        sourced(
            "hesitation",
            Unit::Time,
            (0.0, 60.0),
            "Mean length of such a pause.",
        ),
        length(
            "aiming_error",
            "Standard deviation along each axis of where a movement of at least 1 mm ends; in proportion less for a shorter one.",
        ),
        sourced(
            "angular_error",
            Unit::Angle,
            (0.0, 0.5),
            "Standard deviation about each axis of how the tool is turned where a movement of at least 1 mm ends; in proportion less for a shorter one.",
        ),
        share(
            "lead",
            1.0,
            "How far a movement gets ahead of the plan, as a share of its length: beyond its end by what this is above 0.9 %.",
        ),
        share(
            "detour",
            1.0,
            "How far a movement goes astray to the side, as a share of its length.",
        ),
        share(
            "grip_excess",
            1.0,
            "How much further than planned jaws are closed, as a share of the closing.",
        ),
        share(
            "spread",
            1.0,
            "Standard deviation of the logarithm of the factor by which one trainee differs from the profile, for each parameter.",
        ),
    ];
    Schema {
        name: "trainees".to_owned(),
        doc: "config/trainees.toml: how synthetic trainees move. They test the software and validate nothing."
            .to_owned(),
        keys: vec![Key::list(
            "profile",
            Kind::Table(profile),
            32,
            "Kinds of synthetic trainees.",
        )],
    }
}

/// Reads the file from a text; `file` is the name that complaints use.
pub fn read_trainees(text: &str, file: &str) -> Result<Loaded<Trainees>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &trainees_schema())?;
    let names = texts(reading.value(), "profile", "name");
    unique(&mut reading, &KeyPath::root(), &names, "profile", "name");
    reading.finish()
}

/// Reads the file at `path`.
pub fn load_trainees(path: &Path) -> Result<Loaded<Trainees>, ConfigErrors> {
    let text = load_text(
        path,
        "the kinds of synthetic trainees (config/trainees.toml)",
    )?;
    read_trainees(&text, &path.display().to_string())
}
