//! What of a level a random player has to know: its tools, where the tissue is, and poses in which the script that passes works on it.

use crate::tree;
use microsim_host::assemble::known_metrics;
use microsim_scene::{LevelParts, level_spec};
use microsim_settings::{Unit, load_level, load_manifest, load_script, load_tool};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::num::ParseIntError;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use toml::{Table, Value};

/// Poses with the tip no farther from the tissue than this are at work on it \[m\]. Blades reach beyond the edge that they cut.
const NEAR: f64 = 1.5e-3;

/// Jaws that grip are open no farther: a tool that the script does not use grips like that of the levels where it does.
const LOOSE: f64 = 0.43;

/// A pose of a tool and how far it is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Of the tip, in the field \[m\].
    pub position: Vector3<f64>,
    /// From the tool's frame to the field; +z of the tool is from tip to handle.
    pub orientation: UnitQuaternion<f64>,
    /// 0 closed to 1 open.
    pub opening: f64,
}

impl Pose {
    /// Moved back along the tool, out of the tissue; forth for negative distances \[m\].
    pub fn back(self, distance: f64) -> Self {
        let axis = self.orientation * Vector3::z();
        self.shifted(distance * axis)
    }

    /// Moved in the field \[m\].
    pub fn shifted(mut self, by: Vector3<f64>) -> Self {
        self.position += by;
        self
    }

    /// With another opening.
    pub fn opened(mut self, opening: f64) -> Self {
        self.opening = opening.clamp(0.0, 1.0);
        self
    }

    /// Turned about its tip by the small rotation vector `by` \[rad\].
    pub fn turned(mut self, by: Vector3<f64>) -> Self {
        let half = 0.5 * by;
        let turn = Quaternion::new(1.0, half.x, half.y, half.z);
        self.orientation = UnitQuaternion::from_quaternion(turn) * self.orientation;
        self
    }

    /// Between this and another pose. Straight, the orientation by the normalised mean: no function of the system's library.
    pub fn mixed(&self, to: &Self, fraction: f64, opening: f64) -> Self {
        let [a, b] = [self, to].map(|pose| pose.orientation.into_inner());
        let b = if a.dot(&b) < 0.0 { -b } else { b };
        let orientation = a * (1.0 - fraction) + b * fraction;
        Self {
            position: self.position + fraction * (to.position - self.position),
            orientation: UnitQuaternion::from_quaternion(orientation),
            opening: self.opening + opening * (to.opening - self.opening),
        }
    }
}

/// A tool of a level.
#[derive(Clone, Debug)]
pub struct Tool {
    /// Its slot.
    pub name: String,
    /// Whether it can be closed.
    pub jaws: bool,
    /// Whether the level lets it cut.
    pub cuts: bool,
    /// The keys of the script that passes: time \[s\] and pose.
    pub passing: Vec<(f64, Pose)>,
    /// Those of its poses that are at work.
    pub at_work: Vec<Pose>,
    /// How far it is open when it reaches for something.
    pub open: f64,
    /// How far it is closed when it has a sure grip, or has cut.
    pub grip: f64,
}

/// A level of a module, or a variant of it: `2`, `2.dissertation`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct LevelName {
    /// From 1.
    pub number: u32,
    /// The variant.
    pub variant: Option<String>,
}

impl FromStr for LevelName {
    type Err = ParseIntError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (number, variant) = match text.split_once('.') {
            Some((number, variant)) => (number, Some(variant.to_owned())),
            None => (text, None),
        };
        let number = number.parse()?;
        Ok(Self { number, variant })
    }
}

impl TryFrom<String> for LevelName {
    type Error = ParseIntError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

impl From<LevelName> for String {
    fn from(level: LevelName) -> Self {
        level.to_string()
    }
}

impl fmt::Display for LevelName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.number)?;
        let mut variant = self.variant.iter();
        variant.try_for_each(|name| write!(f, ".{name}"))
    }
}

/// A level as a player sees it.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The module.
    pub module: String,
    /// The level.
    pub level: LevelName,
    /// Time of a tick \[s\].
    pub tick: f64,
    /// Its tools.
    pub tools: Vec<Tool>,
    /// Middle and half of the sides of the first body \[m\]; `None` without tissue.
    pub tissue: Option<[Vector3<f64>; 2]>,
}

/// The file of a level in the built tree.
pub fn level_file(module: &str, level: &LevelName) -> PathBuf {
    tree().join(format!("modules/{module}/levels/level{level}.toml"))
}

/// The script that passes it; a variant has those of its level.
pub fn passing_script(module: &str, level: &LevelName) -> PathBuf {
    let level = level.number;
    tree().join(format!("modules/{module}/scripts/level{level}-pass.toml"))
}

/// Middle and half of the sides of a box about the first body of a level, at rest \[m\]; `None` without tissue.
///
/// # Errors
/// The file that cannot be read, and why.
fn tissue(module: &str, path: &Path) -> Result<Option<[Vector3<f64>; 2]>, String> {
    let folder = tree().join("modules").join(module);
    let manifest = load_manifest(&folder.join("module.toml")).map_err(|e| e.to_string())?;
    let level = load_level(path, &manifest.settings, &known_metrics());
    let level = level.map_err(|e| e.to_string())?.settings;
    let (Some(physics), Some(method)) = (&level.physics, &level.method) else {
        return Ok(None);
    };
    let parts = LevelParts {
        physics,
        method,
        bodies: &level.body,
        rigid: &[],
        contacts: &[],
        cuts: &[],
        tools: &[],
        models: &BTreeMap::new(),
    };
    let levels = folder.join("levels");
    let load = &mut |file: &Path| std::fs::read(levels.join(file));
    let spec = level_spec(&parts, load).map_err(|e| format!("{}: {e}", path.display()))?;
    let nodes = spec.spec.bodies.first().map(|body| &body.mesh.positions);
    Ok(nodes.map(|nodes| {
        let [min, max] = nodes.iter().fold([nodes[0]; 2], |[min, max], node| {
            [min.inf(node), max.sup(node)]
        });
        [0.5 * (min + max), 0.5 * (max - min)]
    }))
}

impl Stage {
    /// Of a level of the built tree.
    ///
    /// # Errors
    /// The file that cannot be read, and why.
    pub fn read(module: &str, level: &LevelName) -> Result<Self, String> {
        let path = level_file(module, level);
        let wrong = |what: &str| format!("{}: {what}", path.display());
        let text = std::fs::read_to_string(&path).map_err(|e| wrong(&e.to_string()))?;
        let file: Table = text.parse().map_err(|e| wrong(&format!("{e}")))?;
        let list = |key: &str| file.get(key).and_then(Value::as_array);
        let tables = |key: &str| list(key).into_iter().flatten().filter_map(Value::as_table);
        let tissue = tissue(module, &path)?;
        let tick = file
            .get("clock")
            .and_then(|clock| clock.get("tick")?.as_str());
        let tick = tick.and_then(|tick| Unit::Time.parse(tick).ok());
        let script = passing_script(module, level);
        let script = load_script(&script).map_err(|e| e.to_string())?.settings;
        let mut tools = Vec::new();
        for slot in tables("tool") {
            let text = |key: &str| slot.get(key).and_then(Value::as_str).unwrap_or_default();
            let (name, model) = (text("name"), text("model"));
            let shape = tree().join(format!("config/tools/{model}.toml"));
            let shape = load_tool(Path::new(&shape)).map_err(|e| e.to_string())?;
            let cuts = tables("cut").any(|c| c.get("tool").and_then(Value::as_str) == Some(name));
            let track = script.tool.iter().find(|track| track.name == name);
            let track = track.ok_or_else(|| wrong(&format!("its script does not move {name}")))?;
            let passing: Vec<(f64, Pose)> = track
                .key
                .iter()
                .map(|key| {
                    let [x, y, z, w] = key.0.orientation;
                    let pose = Pose {
                        position: key.0.position.into(),
                        orientation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
                        opening: key.0.opening,
                    };
                    (key.0.time_s, pose)
                })
                .collect();
            tools.push(Tool::new(
                name,
                shape.settings.hinge.is_some(),
                cuts,
                passing,
                tissue,
            ));
        }
        Ok(Self {
            module: module.to_owned(),
            level: level.clone(),
            tick: tick.ok_or_else(|| wrong("no tick"))?,
            tools,
            tissue,
        })
    }
}

impl Tool {
    fn new(
        name: &str,
        jaws: bool,
        cuts: bool,
        passing: Vec<(f64, Pose)>,
        tissue: Option<[Vector3<f64>; 2]>,
    ) -> Self {
        let all = || passing.iter().map(|(_, pose)| *pose);
        let is_near = |pose: &Pose| {
            tissue.is_none_or(|[centre, half]| {
                let beyond = (pose.position - centre).abs() - half;
                beyond.sup(&Vector3::zeros()).norm() <= NEAR
            })
        };
        let near: Vec<Pose> = all().filter(is_near).collect();
        let at_work = match tissue {
            // What only waits in that script would have its tip in the middle of the tissue.
            Some([centre, _]) if near.is_empty() => vec![Pose {
                position: centre,
                ..all().next().expect("a script has keys")
            }],
            _ => near,
        };
        let openings = || at_work.iter().map(|pose| pose.opening);
        let open = openings().fold(0.0, f64::max);
        let grip = openings().fold(1.0, f64::min);
        Self {
            name: name.to_owned(),
            jaws,
            cuts,
            open: if jaws { open.max(0.5) } else { open },
            grip: if jaws { grip.min(LOOSE) } else { grip },
            passing,
            at_work,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tool that points down has its handle above: back is up. Turned by 0.2 rad about x it comes back along −y as well.
    #[test]
    fn back_is_along_the_handle() {
        let pose = Pose {
            position: Vector3::new(1.0, 2.0, 3.0),
            orientation: UnitQuaternion::identity(),
            opening: 0.5,
        };
        assert_eq!(pose.back(2.0).position, Vector3::new(1.0, 2.0, 5.0));
        let back = pose.turned(Vector3::x() * 0.2).back(1.0).position - pose.position;
        // The turn of a quaternion (1, 0.1, 0, 0): 2·atan 0.1.
        let angle = 2.0 * libm::atan(0.1);
        assert!(
            (back.y + libm::sin(angle)).abs() < 1e-14 && back.x == 0.0,
            "{back}"
        );
        assert_eq!(pose.opened(1.5).opening, 1.0);
    }
}
