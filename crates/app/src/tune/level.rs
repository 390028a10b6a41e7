//! A level as a scene to be measured: its bodies under gravity and a push on their upper sides, until they rest.
//!
//! A level states no load of its own: what comes is up to the trainee. The push stands for it; error and cost of methods are
//! compared on it. Tools and contact are left out.

use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, Value, value};

/// The push as a share of the modulus of the tissue.
const PUSH: f64 = 0.01;

/// The clock of a level, as its file has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// [s]
    pub tick: f64,
}

/// A level as far as `tune` needs it.
#[derive(Clone, Debug)]
pub struct Level {
    /// The text of a scene.
    pub scene: String,
    /// Its clock.
    pub clock: Clock,
    /// Whether tools touch its bodies.
    pub contact: bool,
}

impl Level {
    /// The scene of the text of a level.
    pub fn of(text: &str) -> Result<Self, String> {
        let level: DocumentMut = text.parse().map_err(|e| format!("{e}"))?;
        let tick = quantity(level["clock"].get("tick"), microsim_settings::Unit::Time);
        let tick = tick.ok_or("no `clock.tick`")?;
        let steps = level["clock"]
            .get("steps")
            .and_then(Item::as_integer)
            .unwrap_or(1);
        let mut scene = DocumentMut::new();
        for key in ["title", "summary", "method", "accuracy", "tuned"] {
            if let Some(item) = level.get(key) {
                scene.insert(key, item.clone());
            }
        }
        if level.get("method").is_none() {
            return Err("a level without physics has nothing to tune".into());
        }
        let mut run = Table::new();
        run.insert("duration", value("2 s"));
        run.insert("step", value(tick / steps.max(1) as f64));
        run.insert("sample", value(tick));
        run.insert("frame", value("100 ms"));
        run.insert("end", value("rest"));
        run.insert("rest_speed", value("10 um/s"));
        if let Some(gravity) = level.get("physics").and_then(|p| p.get("gravity")) {
            run.insert("gravity", gravity.clone());
        }
        scene.insert("run", Item::Table(run));
        let bodies = level.get("body").and_then(Item::as_array_of_tables);
        let (mut pushed, mut probes) = (ArrayOfTables::new(), ArrayOfTables::new());
        for body in bodies.into_iter().flatten() {
            let mut body = body.clone();
            push(&mut body);
            let mut probe = Table::new();
            let name = body.get("name").and_then(Item::as_str).unwrap_or_default();
            probe.insert("name", value(format!("{name}-reach")));
            probe.insert("body", value(name));
            probe.insert("quantity", value("distance"));
            probes.push(probe);
            pushed.push(body);
        }
        scene.insert("body", Item::ArrayOfTables(pushed));
        scene.insert("probe", Item::ArrayOfTables(probes));
        Ok(Self {
            scene: scene.to_string(),
            clock: Clock { tick },
            contact: level.get("contact").is_some(),
        })
    }
}

/// Adds a push downwards on the upper side of a block; other bodies have their weight alone.
fn push(body: &mut Table) {
    use microsim_settings::Unit;
    let Some(size) = body.get("size").and_then(Item::as_array) else {
        return;
    };
    let size: Vec<f64> = size
        .iter()
        .filter_map(|v| number(v, Unit::Length))
        .collect();
    let material = body.get("material").and_then(Item::as_array_of_tables);
    let material = material.and_then(|list| list.iter().next());
    let modulus = material.and_then(|material| {
        let keys = ["youngs_modulus", "stretch_modulus"];
        keys.iter()
            .find_map(|key| quantity(material.get(key), Unit::Pressure))
    });
    let (&[x, y, z], Some(modulus)) = (size.as_slice(), modulus) else {
        return;
    };
    let list = |values: [f64; 3]| Value::Array(values.into_iter().collect::<Array>());
    let mut surface = toml_edit::InlineTable::new();
    surface.insert("min", list([-0.5 * x, -0.5 * y, 0.5 * z]));
    surface.insert("max", list([0.5 * x, 0.5 * y, 0.5 * z]));
    let mut load = Table::new();
    load.insert("surface", value(surface));
    load.insert("traction", value(list([0.0, 0.0, -PUSH * modulus])));
    let mut loads = ArrayOfTables::new();
    loads.push(load);
    body.insert("load", Item::ArrayOfTables(loads));
}

/// A number in SI, or a text with a unit.
fn quantity(item: Option<&Item>, unit: microsim_settings::Unit) -> Option<f64> {
    number(item?.as_value()?, unit)
}

fn number(value: &Value, unit: microsim_settings::Unit) -> Option<f64> {
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

    #[test]
    fn the_levels_that_come_with_the_program_are_scenes_to_measure() {
        for text in [
            include_str!("../../../../modules/push-strip/levels/level1.toml"),
            include_str!("../../../../modules/push-strip/levels/level2.toml"),
        ] {
            let level = Level::of(text).expect("a level with physics");
            assert!(level.contact && level.clock.tick == 0.008);
            let scene = microsim_settings::read_scene(&level.scene, "level.toml", &[]);
            let scene = scene.expect("a scene").settings;
            assert_eq!(scene.body.len(), 1);
            let material = &scene.body[0].material[0];
            let modulus = material.youngs_modulus.or(material.stretch_modulus);
            let push = PUSH * modulus.expect("a modulus");
            assert_eq!(scene.body[0].load[0].traction, Some([0.0, 0.0, -push]));
        }
    }

    #[test]
    fn a_level_without_physics_is_refused() {
        let refused = Level::of("[clock]\ntick = \"8 ms\"\nsteps = 1\n");
        assert!(refused.is_err_and(|e| e.contains("without physics")));
    }
}
