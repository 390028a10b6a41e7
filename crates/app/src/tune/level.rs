//! A level as a scene to be measured: its bodies with their clamps under gravity, and a pull upwards on the middle of their upper
//! sides, until they rest.
//!
//! A level states no load of its own: what comes is up to the trainee. The pull stands for careful forceps; error and cost of methods
//! are compared on it. Measured are how far the body is lifted and with what force moved clamps stretch it. Tools, contact and cuts
//! are left out.

use microsim_settings::{Override, Unit};
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value, value};

/// The pull as a fraction of the modulus of the tissue: the strain right below it.
const PULL: f64 = 0.03;

/// A level as far as `tune` needs it.
#[derive(Clone, Debug)]
pub struct Level {
    file: DocumentMut,
    /// Between two ticks \[s\].
    pub tick: f64,
    /// Steps in a tick.
    steps: i64,
    /// Whether tools touch its bodies.
    pub contact: bool,
    /// Whether its bodies are cut or tear.
    pub cuts: bool,
}

impl Level {
    /// The level of a text.
    pub fn of(text: &str) -> Result<Self, String> {
        let file: DocumentMut = text.parse().map_err(|e| format!("{e}"))?;
        if file.get("method").is_none() {
            return Err("a level without physics has nothing to tune".into());
        }
        let tick = quantity(file["clock"].get("tick"), Unit::Time);
        let steps = file["clock"].get("steps").and_then(Item::as_integer);
        Ok(Self {
            tick: tick.ok_or("no `clock.tick`")?,
            steps: steps.unwrap_or(1).max(1),
            contact: file.get("contact").is_some(),
            cuts: file.get("cut").is_some() || tears(&file),
            file,
        })
    }

    /// The text of the scene for a mesh with overrides, the same as will be made of the text: the pull acts between lines of nodes,
    /// and its sum is the same on every mesh.
    pub fn scene(&self, set: &[String]) -> Result<String, String> {
        let mut scene = DocumentMut::new();
        for key in ["title", "summary", "method", "accuracy", "tuned"] {
            if let Some(item) = self.file.get(key) {
                scene.insert(key, item.clone());
            }
        }
        let mut run = Table::new();
        run.insert("duration", value("2 s"));
        run.insert("step", value(self.tick / self.steps as f64));
        run.insert("sample", value(self.tick));
        run.insert("frame", value("100 ms"));
        run.insert("end", value("rest"));
        run.insert("rest_speed", value("10 um/s"));
        if let Some(gravity) = self.file.get("physics").and_then(|p| p.get("gravity")) {
            run.insert("gravity", gravity.clone());
        }
        scene.insert("run", Item::Table(run));
        let bodies = self.file.get("body").and_then(Item::as_array_of_tables);
        let (mut pulled, mut probes) = (ArrayOfTables::new(), ArrayOfTables::new());
        for (index, body) in bodies.into_iter().flatten().enumerate() {
            let mut body = body.clone();
            // Nothing tears under this pull, and the exact solution, which has no inertia, must not.
            let materials = body
                .get_mut("material")
                .and_then(Item::as_array_of_tables_mut);
            for material in materials.into_iter().flat_map(ArrayOfTables::iter_mut) {
                material.remove("tear_strain");
            }
            let cells = cells_in(set, index)?;
            let up = list([0.0, 0.0, 1.0]);
            if pull(&mut body, cells) {
                probes.push(probe(&body, "lift", "centre", Some(up)));
            } else {
                probes.push(probe(&body, "reach", "distance", None));
            }
            if let Some(probe) = stretch(&body) {
                probes.push(probe);
            }
            pulled.push(body);
        }
        scene.insert("body", Item::ArrayOfTables(pulled));
        scene.insert("probe", Item::ArrayOfTables(probes));
        Ok(scene.to_string())
    }
}

/// Whether a material of a level tears.
fn tears(level: &DocumentMut) -> bool {
    let list = |item: &Item| item.as_array_of_tables().cloned().unwrap_or_default();
    let bodies = level.get("body").map(list).unwrap_or_default();
    bodies.iter().any(|body| {
        let materials = body.get("material").map(list).unwrap_or_default();
        materials.iter().any(|m| m.contains_key("tear_strain"))
    })
}

/// The cells of a block that an override names.
fn cells_in(set: &[String], body: usize) -> Result<Option<[f64; 3]>, String> {
    let path = format!("body.{body}.cells");
    let mut found = None;
    for text in set {
        let Some((_, cells)) = text.split_once('=').filter(|(key, _)| *key == path) else {
            continue;
        };
        Override::parse(text)?;
        let cells: Value = cells.parse().map_err(|e| format!("{text}: {e}"))?;
        found = cells.as_array().and_then(|list| three(list, Unit::Count));
    }
    Ok(found)
}

fn probe(body: &Table, name: &str, quantity: &str, direction: Option<Value>) -> Table {
    let mut probe = Table::new();
    let of = body.get("name").and_then(Item::as_str).unwrap_or_default();
    probe.insert("name", value(format!("{of}-{name}")));
    probe.insert("body", value(of));
    probe.insert("quantity", value(quantity));
    if let Some(direction) = direction {
        probe.insert("direction", value(direction));
    }
    probe
}

/// The force with which the first clamp that moves ends up pulling.
fn stretch(body: &Table) -> Option<Table> {
    let clamps = body.get("clamp")?.as_array_of_tables()?;
    clamps.iter().find_map(|clamp| {
        let last = clamp.get("motion")?.as_array()?.iter().last()?;
        let shift = last.as_inline_table()?.get("shift")?.as_array()?;
        let shift = three(shift, Unit::Length)?;
        if shift == [0.0; 3] {
            return None;
        }
        let mut probe = probe(body, "stretch", "force", Some(list(shift)));
        probe.insert("nodes", clamp.get("nodes")?.clone());
        Some(probe)
    })
}

/// Adds a pull upwards on the middle of the upper side of a block, from edge to edge across, two cells of the file along it; `cells`
/// are those of the mesh if it is not the file's. Other bodies have their weight alone.
fn pull(body: &mut Table, cells: Option<[f64; 3]>) -> bool {
    let array = |key, unit| {
        let array = body.get(key).and_then(Item::as_array);
        array.and_then(|array| three(array, unit))
    };
    let material = body.get("material").and_then(Item::as_array_of_tables);
    let material = material.and_then(|list| list.iter().next());
    let modulus = material.and_then(|material| {
        let keys = ["youngs_modulus", "stretch_modulus"];
        keys.iter()
            .find_map(|key| quantity(material.get(key), Unit::Pressure))
    });
    let (Some([x, y, z]), Some(own), Some(modulus)) = (
        array("size", Unit::Length),
        array("cells", Unit::Count),
        modulus,
    ) else {
        return false;
    };
    // In cells of the mesh from the end of the block; at least one.
    let count = cells.unwrap_or(own)[0];
    let half = (own[0] % 2.0 + 2.0) * 0.5 / own[0];
    let from = ((0.5 - half) * count).round();
    let to = ((0.5 + half) * count).round().max(from + 1.0);
    let [from, to] = [from, to].map(|line| (line / count - 0.5) * x);
    let traction = PULL * modulus * 2.0 * half * x / (to - from);
    let mut surface = InlineTable::new();
    surface.insert("min", list([from, -0.5 * y, 0.5 * z]));
    surface.insert("max", list([to, 0.5 * y, 0.5 * z]));
    let mut load = Table::new();
    load.insert("surface", value(surface));
    load.insert("traction", value(list([0.0, 0.0, traction])));
    let mut loads = ArrayOfTables::new();
    loads.push(load);
    body.insert("load", Item::ArrayOfTables(loads));
    true
}

fn list(values: [f64; 3]) -> Value {
    Value::Array(values.into_iter().collect::<Array>())
}

/// Three numbers in SI.
fn three(array: &Array, unit: Unit) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = array.iter().map(|v| number(v, unit)).collect();
    numbers?.try_into().ok()
}

/// A number in SI, or a text with a unit.
fn quantity(item: Option<&Item>, unit: Unit) -> Option<f64> {
    number(item?.as_value()?, unit)
}

fn number(value: &Value, unit: Unit) -> Option<f64> {
    match value {
        Value::Float(number) => Some(*number.value()),
        Value::Integer(number) => Some(*number.value() as f64),
        Value::String(text) => unit.parse(text.value()).ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_settings::Scene;

    const LEVELS: [&str; 3] = [
        include_str!("../../../../modules/push-strip/levels/level1.toml"),
        include_str!("../../../../modules/push-strip/levels/level2.toml"),
        include_str!("../../../../modules/coordination/levels/level4.toml"),
    ];

    fn scene(level: &str, set: &[&str]) -> Scene {
        let level = Level::of(level).expect("a level with physics");
        assert!(level.contact && level.tick == 0.008);
        let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
        let text = level.scene(&set).expect("the text of a scene");
        let read = microsim_settings::read_scene(&text, "level.toml", &[]);
        read.expect("a scene").settings
    }

    /// Force of the pull: traction times area between its ends.
    fn force(scene: &Scene) -> f64 {
        let load = &scene.body[0].load[0];
        let (Some(min), Some(max)) = (load.surface.min, load.surface.max) else {
            panic!("a box");
        };
        load.traction.expect("a traction")[2] * (max[0] - min[0]) * (max[1] - min[1])
    }

    #[test]
    fn the_levels_that_come_with_the_program_are_scenes_to_measure() {
        for level in LEVELS {
            let scene = scene(level, &[]);
            assert_eq!(scene.body.len(), 1);
            let body = &scene.body[0];
            let (size, cells) = (body.size.expect("a block"), body.cells.expect("cells"));
            let modulus = body.material[0].youngs_modulus.expect("a modulus");
            let area = 2.0 * size[0] / f64::from(cells[0]) * size[1];
            let expected = PULL * modulus * area;
            assert!((force(&scene) / expected - 1.0).abs() < 1e-12);
            // Where clamps move, their force is measured besides.
            let moved = body.clamp.iter().any(|clamp| !clamp.motion.is_empty());
            assert_eq!(scene.probe.len(), 1 + usize::from(moved));
        }
    }

    /// On 12 cells of 10 mm no line of nodes lies at ±0.5 mm: the pull goes to the next ones, ±0.833 mm, and is as strong.
    #[test]
    fn the_pull_is_as_strong_on_every_mesh() {
        let own = scene(LEVELS[2], &[]);
        assert_eq!(own.body[0].cells.expect("cells")[0], 20);
        for cells in [12, 15, 40] {
            let set = format!("body.0.cells=[{cells},4,1]");
            let other = scene(LEVELS[2], &[&set]);
            assert!((force(&other) / force(&own) - 1.0).abs() < 1e-12, "{cells}");
            let from = other.body[0].load[0].surface.min.expect("a box")[0];
            let line = (from / 0.01 + 0.5) * f64::from(cells);
            assert!((line - line.round()).abs() < 1e-9, "{cells}: {line}");
        }
    }

    #[test]
    fn a_level_without_physics_is_refused() {
        let refused = Level::of("[clock]\ntick = \"8 ms\"\nsteps = 1\n");
        assert!(refused.is_err_and(|e| e.contains("without physics")));
    }
}
