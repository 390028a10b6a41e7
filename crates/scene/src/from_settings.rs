//! From settings to the description of a scene: the one conversion, for scenes and levels.
//!
//! What is here: generators and mesh files to meshes, laws to materials, selections, tools. Files are read by a function that
//! the caller brings. What is not: checks of single values (crate `settings`) and of the whole (when the scene is built).

mod body;
mod contact;
mod error;
mod fibres;
mod material;
mod method;
mod residual;

pub use error::{FromSettingsCause, FromSettingsError};

use crate::spec::{BodySpec, SceneSpec, Selection, ToolSpec, WorkBudget};
use error::missing;
use microsim_settings as settings;
use settings::KeyPath;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// Reads a file, given by its path from the folder of the settings.
pub type Load<'a> = dyn FnMut(&Path) -> io::Result<Vec<u8>> + 'a;

/// Description of a scene from a file, with remarks about its mesh files.
#[derive(Clone, Debug, PartialEq)]
pub struct Described {
    /// What it is made of.
    pub spec: SceneSpec,
    /// What was left out, turned round or assumed in mesh files: a sentence each.
    pub notes: Vec<String>,
}

/// The scene of a file `config/scenes/NAME.toml`. `load` reads mesh files.
///
/// ```
/// use microsim_scene::{Scene, scene_spec};
///
/// let text = r#"
/// title = {de = "Balken", en = "Beam"}
/// summary = {de = "Ein Balken hängt durch.", en = "A beam sags."}
/// [run]
/// duration = "0.2 s"
/// step = "1 ms"
/// [method]
/// name = "implicit-euler"
/// [[body]]
/// name = "beam"
/// generator = "block"
/// size = ["20 mm", "5 mm", "5 mm"]
/// cells = [4, 1, 1]
/// material = [{density = 1000, law = "stable-neo-hookean", youngs_modulus = "100 kPa", poisson_ratio = 0.3}]
/// [[body.clamp]]
/// nodes = {min = ["-10 mm", -1, -1], max = ["-10 mm", 1, 1]}
/// "#;
/// let settings = microsim_settings::read_scene(text, "beam.toml", &[])?.settings;
/// let load = &mut |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
/// let scene = Scene::new(&scene_spec(&settings, load)?.spec)?;
/// assert_eq!(scene.body(0).name(), "beam");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn scene_spec(
    scene: &settings::Scene,
    load: &mut Load<'_>,
) -> Result<Described, FromSettingsError> {
    let (bodies, notes) = bodies(&scene.body, load)?;
    let spec = SceneSpec {
        bodies,
        tools: contact::tools(&scene.tool, load)?,
        obstacles: contact::obstacles(&scene.rigid),
        contacts: contact::contacts(&scene.contact)?,
        cuts: contact::cuts(&scene.cut),
        gravity: scene.run.gravity,
        method: method::method(&scene.method),
        containment: scene.run.containment,
        repeat_invalid: scene.method.repeat_invalid.unwrap_or(true),
        repeat_unconverged: true,
        broad_phase: contact::broad_phase(scene.run.broad_phase, scene.run.cell_size),
        tools_touch: scene.run.tools_touch,
        hand_force: scene.run.hand_force.unwrap_or(f64::INFINITY),
        budget: None,
    };
    Ok(Described { spec, notes })
}

/// The parts of a level that physics needs.
#[derive(Clone, Copy, Debug)]
pub struct LevelParts<'a> {
    /// What drives all bodies.
    pub physics: &'a settings::Physics,
    /// How they are advanced.
    pub method: &'a settings::Method,
    /// The bodies.
    pub bodies: &'a [settings::Body],
    /// Obstacles.
    pub rigid: &'a [settings::Rigid],
    /// What touches what.
    pub contacts: &'a [settings::ContactPair],
    /// What cuts what.
    pub cuts: &'a [settings::CutPair],
    /// The tool slots.
    pub tools: &'a [settings::ToolSlot],
    /// The shapes of the tools, by the names that slots use.
    pub models: &'a BTreeMap<String, settings::Tool>,
}

/// The scene of a level. A body that diverges is rolled back: the trainee never sees it.
///
/// ```
/// use microsim_scene::{LevelParts, Scene, level_spec};
/// use std::collections::BTreeMap;
///
/// // The body and method of a scene do as well for a level; a plug-in is given those of its level.
/// let text = r#"
/// title = {de = "Balken", en = "Beam"}
/// summary = {de = "Ein Balken hängt durch.", en = "A beam sags."}
/// [run]
/// duration = "0.2 s"
/// step = "1 ms"
/// [method]
/// name = "implicit-euler"
/// [[body]]
/// name = "beam"
/// generator = "block"
/// size = ["20 mm", "5 mm", "5 mm"]
/// cells = [4, 1, 1]
/// material = [{density = 1000, law = "stable-neo-hookean", youngs_modulus = "100 kPa", poisson_ratio = 0.3}]
/// [[body.clamp]]
/// nodes = {min = ["-10 mm", -1, -1], max = ["-10 mm", 1, 1]}
/// "#;
/// let settings = microsim_settings::read_scene(text, "beam.toml", &[])?.settings;
/// let level = LevelParts {
///     physics: &microsim_settings::Physics { gravity: settings.run.gravity, broad_phase: settings.run.broad_phase, cell_size: None, tools_touch: false, hand_force: 1.0, budget: 3.0, mean_budget: 0.5 },
///     method: &settings.method,
///     bodies: &settings.body,
///     rigid: &[],
///     contacts: &[],
///     cuts: &[],
///     tools: &[],
///     models: &BTreeMap::new(),
/// };
/// let load = &mut |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
/// let scene = Scene::new(&level_spec(&level, load)?.spec)?;
/// assert_eq!(scene.required_steps(8e-3), 1, "an implicit method has no limit");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn level_spec(
    level: &LevelParts<'_>,
    load: &mut Load<'_>,
) -> Result<Described, FromSettingsError> {
    let (bodies, notes) = bodies(level.bodies, load)?;
    let mut tools = Vec::new();
    for (index, slot) in level.tools.iter().enumerate() {
        let key = || KeyPath::root().key("tool").at(index).key("model");
        let model = level.models.get(&slot.model);
        let model = model.ok_or_else(|| missing(key(), "a tool model of this name"))?;
        tools.push(ToolSpec {
            name: slot.name.clone(),
            capsules: contact::capsules(&model.capsule, model.hinge, model.opening_angle),
            sharpness: model.sharpness,
            jaw_stiffness: model.jaw_stiffness.unwrap_or(f64::INFINITY),
            irrigation: model.irrigation.as_ref().map(contact::irrigation),
            motion: Vec::new(),
        });
    }
    let spec = SceneSpec {
        bodies,
        tools,
        obstacles: contact::obstacles(level.rigid),
        contacts: contact::contacts(level.contacts)?,
        cuts: contact::cuts(level.cuts),
        gravity: level.physics.gravity,
        method: method::method(level.method),
        containment: true,
        repeat_invalid: level.method.repeat_invalid.unwrap_or(true),
        repeat_unconverged: true,
        broad_phase: contact::broad_phase(level.physics.broad_phase, level.physics.cell_size),
        tools_touch: level.physics.tools_touch,
        hand_force: level.physics.hand_force,
        budget: Some(WorkBudget {
            tick: level.physics.budget,
            mean: level.physics.mean_budget,
        }),
    };
    Ok(Described { spec, notes })
}

fn bodies(
    bodies: &[settings::Body],
    load: &mut Load<'_>,
) -> Result<(Vec<BodySpec>, Vec<String>), FromSettingsError> {
    let mut notes = Vec::new();
    let bodies = bodies.iter().enumerate().map(|(index, body)| {
        let key = KeyPath::root().key("body").at(index);
        body::body(body, &key, load, &mut notes)
    });
    Ok((bodies.collect::<Result<_, _>>()?, notes))
}

/// The selections whose common nodes are meant: none for every node.
pub(crate) fn selections(nodes: &settings::Nodes) -> Vec<Selection> {
    let mut all = Vec::new();
    if let (Some(min), Some(max)) = (nodes.min, nodes.max) {
        all.push(Selection::Box(crate::spec::BoxSpec { min, max }));
    }
    if let Some(shell) = &nodes.shell {
        all.push(Selection::Shell {
            point: shell.point,
            axis: shell.axis,
            radius: shell.radius,
        });
    }
    all.extend(nodes.nearest.map(Selection::Nearest));
    all
}

#[cfg(test)]
mod tests;
