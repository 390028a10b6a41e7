//! A scripted trainee: timed poses and openings of each tool.

use crate::check::{items, texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{direction, identifier, quantity, ratio, rotation, time, vector3};
use crate::schema::Kind;
use crate::table::{Setting, table};
use microsim_tracking as tracking;
use microsim_vocabulary::{Interpolation, Unit};
use serde::{Deserialize, Serialize};
use std::path::Path;

table! {
    /// A scripted trainee.
    pub struct Script {
        /// Samples per second \[Hz\].
        rate: f64 = quantity(Unit::Frequency, 1.0, 1000.0) => 62.5,
        /// How a tool moves between two keys: from rest to rest as a hand does, or at constant speed.
        interpolation: Interpolation => "minimum-jerk",
        /// Module for which it was made; a run of another one warns.
        module: Option<String> = identifier(),
        /// Level for which it was made; a run of another one warns.
        level: Option<u32> [1, 999],
        /// By what a synthetic trainee was made: session and report label it so.
        synthetic: Option<String>,
        /// The tools that move.
        tool: Vec<ScriptTool> [0, 8],
    }
}

impl Script {
    /// For what it was made, if that is not this level of this module: ``touch-spheres, level 1``.
    pub fn made_for_another(&self, module: &str, level: u32) -> Option<String> {
        let same_module = self.module.as_deref().is_none_or(|own| own == module);
        if same_module && self.level.is_none_or(|own| own == level) {
            return None;
        }
        let level = self.level.map(|level| format!("level {level}"));
        let names: Vec<String> = self.module.iter().cloned().chain(level).collect();
        Some(names.join(", "))
    }

    /// The motion through its keys.
    ///
    /// # Errors
    /// [`tracking::ScriptError`] where the keys do not make one; those of a checked file do.
    pub fn motion(&self) -> Result<tracking::Script, tracking::ScriptError> {
        let tracks = self.tool.iter().map(|tool| tracking::ScriptTrack {
            device: tool.name.as_str().into(),
            keyframes: tool.key.iter().map(|key| key.0).collect(),
        });
        tracking::Script::new(tracks.collect(), self.interpolation)
    }
}

table! {
    /// One scripted tool.
    pub struct ScriptTool {
        /// Slot of the tool, which is also the name of the device that the script plays.
        name: String = identifier(),
        /// Its poses in the order of time.
        key: Vec<ScriptKey> [1, 10_000],
    }
}

/// Where a tool is at a time: a keyframe, as files and configurations can hold it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ScriptKeyFile", into = "ScriptKeyFile")]
pub struct ScriptKey(pub tracking::Keyframe);

table! {
    /// A key as the file has it: with a direction or an orientation, which is checked before.
    pub(crate) struct ScriptKeyFile {
        /// Time since the start \[s\]; later than that of the key before.
        t: f64 = time(0.0, 3600.0),
        /// Of the tip, in the field frame \[m\].
        position: [f64; 3] = vector3(Unit::Length, 1.0),
        /// From the tip to the handle, in the field frame; the shortest turn from +z. Either this or `orientation`.
        direction: Option<[f64; 3]> = direction(),
        /// Rotation [x, y, z, w] that turns tool directions into field directions.
        orientation: Option<[f64; 4]> = rotation(),
        /// From 0 closed to 1 open.
        opening: f64 = ratio(1.0) => 0.0,
        /// Whether the device sees the tool from this time on.
        visible: bool => true,
    }
}

impl Setting for ScriptKey {
    fn kind() -> Kind {
        ScriptKeyFile::kind()
    }
}

impl TryFrom<ScriptKeyFile> for ScriptKey {
    type Error = &'static str;

    fn try_from(file: ScriptKeyFile) -> Result<Self, Self::Error> {
        let orientation = match (file.direction, file.orientation) {
            (Some(direction), None) => orientation_of_direction(direction),
            (None, Some(orientation)) => orientation,
            _ => return Err("either `direction` or `orientation`"),
        };
        Ok(Self(tracking::Keyframe {
            time_s: file.t,
            position: file.position,
            orientation,
            opening: file.opening,
            visible: file.visible,
        }))
    }
}

impl From<ScriptKey> for ScriptKeyFile {
    fn from(ScriptKey(key): ScriptKey) -> Self {
        Self {
            t: key.time_s,
            position: key.position,
            direction: None,
            orientation: Some(key.orientation),
            opening: key.opening,
            visible: key.visible,
        }
    }
}

/// The shortest rotation x, y, z, w that turns +z into `direction`, which has length 1.
///
/// With n = z × d and c = z·d the quaternion (n, 1 + c) has the right axis and half the angle, because
/// |n| / (1 + c) = sin φ / (1 + cos φ) = tan(φ/2). Straight down every horizontal axis is as short: x is taken.
pub fn orientation_of_direction(direction: [f64; 3]) -> [f64; 4] {
    let [x, y, z] = direction;
    // 1 + z loses its digits near z = −1; it equals (x² + y²) / (1 − z), which keeps them.
    let one_plus_z = if z < 0.0 {
        (x * x + y * y) / (1.0 - z)
    } else {
        1.0 + z
    };
    let (n_x, n_y, w) = (-y, x, one_plus_z);
    let length = (n_x * n_x + n_y * n_y + w * w).sqrt();
    if length > 0.0 {
        [n_x / length, n_y / length, 0.0, w / length]
    } else {
        [1.0, 0.0, 0.0, 0.0]
    }
}

/// Reads a script from a text; `file` is the name that complaints use.
pub fn read_script(text: &str, file: &str) -> Result<Loaded<Script>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Script>("script"))?;
    let names = texts(reading.value(), "tool", "name");
    unique(&mut reading, &KeyPath::root(), &names, "tool", "name");

    let times: Vec<(KeyPath, Option<f64>, bool)> = items(reading.value(), "tool")
        .flat_map(|(tool, value)| {
            items(value, "key").map(move |(i, key)| {
                (
                    KeyPath::root().key("tool").at(tool).key("key").at(i),
                    key["t"].as_f64(),
                    i == 0,
                )
            })
        })
        .collect();
    let mut latest = f64::NEG_INFINITY;
    for (path, t, first) in times {
        if first {
            latest = f64::NEG_INFINITY;
        }
        if let Some(t) = t {
            if t <= latest {
                let expected = format!(
                    "a time after that of the key before, {}",
                    Unit::Time.describe(latest)
                );
                reading.complain(&path.key("t"), &Unit::Time.describe(t), &expected);
            }
            latest = t;
        }
        let [direction, orientation] =
            ["direction", "orientation"].map(|field| reading.is_written(&path.key(field)));
        if direction == orientation {
            let found = match direction {
                true => "both `direction` and `orientation`",
                false => "neither `direction` nor `orientation`",
            };
            reading.complain(&path, found, "one of them");
        }
    }
    reading.finish()
}

/// Reads the script at `path`.
pub fn load_script(path: &Path) -> Result<Loaded<Script>, ConfigErrors> {
    let text = load_text(path, "a scripted trainee (TOML)")?;
    read_script(&text, &path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// q z q⁻¹ = (2(xz + wy), 2(yz − wx), 1 − 2(x² + y²)), written out from the rotation matrix of a unit quaternion.
    fn turned_z([x, y, z, w]: [f64; 4]) -> [f64; 3] {
        [
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        ]
    }

    /// A script of another level ran without a word, and its failure looked like one of the trainee's.
    #[test]
    fn a_script_knows_for_which_level_it_was_made() {
        let made = |keys: &str| {
            let script = read_script(&format!("{keys}tool = []"), "f.toml");
            let script = script.expect("a script without tools").settings;
            script.made_for_another("hold", 2)
        };
        for here in [
            "",
            "module = \"hold\"\n",
            "level = 2\n",
            "module = \"hold\"\nlevel = 2\n",
        ] {
            assert_eq!(made(here), None, "{here}");
        }
        for (keys, what) in [
            ("module = \"hold\"\nlevel = 1\n", "hold, level 1"),
            ("module = \"cut\"\nlevel = 2\n", "cut, level 2"),
            ("module = \"cut\"\n", "cut"),
            ("level = 3\n", "level 3"),
        ] {
            assert_eq!(made(keys).as_deref(), Some(what));
        }
    }

    #[test]
    fn the_shortest_turn_carries_z_into_the_direction() {
        let third = 1.0 / 3.0_f64.sqrt();
        for direction in [
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [third, -third, third],
            [0.6, 0.0, -0.8],
            [0.0, 0.0, -1.0],
            [1e-9, 0.0, -1.0],
        ] {
            let q = orientation_of_direction(direction);
            let turned = turned_z(q);
            for (a, b) in turned.iter().zip(direction) {
                // Each component is a sum of a few products of numbers up to 1.
                assert!(
                    (a - b).abs() < 8.0 * f64::EPSILON,
                    "{direction:?} {q:?} {turned:?}"
                );
            }
            // No turn about z itself: that is what makes it the shortest.
            assert_eq!(q[2], 0.0);
        }
    }
}
