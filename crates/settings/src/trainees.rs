//! `config/trainees.toml`: how synthetic trainees move.
//!
//! A synthetic trainee follows the plan of a script, as a hand does. What is here describes kinds of them; it is set before
//! anything is scored, and a group of synthetic trainees validates nothing.

use crate::check::{texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{identifier, quantity, ratio, time};
use crate::schema::Kind;
use crate::table::{Table, table};
use microsim_vocabulary::Unit;
use std::path::Path;

table! {
    /// Kinds of synthetic trainees.
    pub struct Trainees {
        /// Kinds of synthetic trainees.
        profile: Vec<TraineeProfile> [0, 32],
    }
}

table! {
    /// One kind of synthetic trainee.
    pub struct TraineeProfile {
        /// Its name.
        name: String = identifier(),
        /// RMS of the tremor between 8 and 12 Hz, all axes together, while the opening stands \[m\].
        tremor_still: Sourced = sourced(length()),
        /// RMS of the tremor between 8 and 12 Hz, all axes together, while the jaws are opened or closed \[m\].
        tremor_actuating: Sourced = sourced(length()),
        /// Time for everything, relative to that of the plan.
        pace: Sourced = sourced(quantity(Unit::Ratio, 0.1, 10.0)),
        /// Chance of a pause where all tools rest.
        hesitation_chance: Sourced = sourced(ratio(1.0)),
        /// Mean length of such a pause \[s\].
        hesitation: Sourced = sourced(time(0.0, 60.0)),
        /// Standard deviation along each axis of where a movement of at least 1 mm ends \[m\]; in proportion less for a
        /// shorter one.
        aiming_error: Sourced = sourced(length()),
        /// Standard deviation about each axis of how the tool is turned where a movement of at least 1 mm ends \[rad\]; in
        /// proportion less for a shorter one.
        angular_error: Sourced = sourced(quantity(Unit::Angle, 0.0, 0.5)),
        /// How far a movement gets ahead of the plan, relative to its length: beyond its end by what this is above 0.9 %.
        lead: Sourced = sourced(ratio(1.0)),
        /// How far a movement goes astray to the side, relative to its length.
        detour: Sourced = sourced(ratio(1.0)),
        /// How much further than planned jaws are closed, relative to the closing.
        grip_excess: Sourced = sourced(ratio(1.0)),
        /// Standard deviation of the logarithm of the factor by which one trainee differs from the profile, for each
        /// parameter.
        spread: Sourced = sourced(ratio(1.0)),
    }
}

table! {
    /// A value and where it comes from.
    pub struct Sourced {
        /// The value.
        value: f64,
        /// Where it comes from.
        source: String,
        /// Whether it is a judgement that no measurement backs yet.
        provisional: bool => true,
    }
}

/// A value of this kind and where it comes from.
fn sourced(value: Kind) -> Kind {
    let mut keys = Sourced::keys();
    keys[0].kind = value;
    Kind::Table(keys)
}

fn length() -> Kind {
    quantity(Unit::Length, 0.0, 0.01)
}

/// Reads the file from a text; `file` is the name that complaints use.
pub fn read_trainees(text: &str, file: &str) -> Result<Loaded<Trainees>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Trainees>("trainees"))?;
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
