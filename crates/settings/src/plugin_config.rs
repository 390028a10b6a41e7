//! What the host gives each kind of plugin: types of host and plugin alike, made of a level, its module's manifest and
//! the files of the installation. On the wire they are the value `config` of a set-up. What is wrong in a file is refused before, with file
//! and line; a plugin that was built for other keys refuses the value itself.

use crate::body::Body;
use crate::calibration::{Calibration, TipCalibration, WorkspaceCalibration};
use crate::colour::Colour;
use crate::contact::{ContactPair, CutPair};
use crate::level::{Level, Limit, MetricParameters, Object, Physics, ToolSlot, View};
use crate::manifest::{Manifest, ModuleMetric, Reason};
use crate::method::Method;
use crate::recording::RecordingMap;
use crate::rigid::Rigid;
use crate::script::Script;
use crate::tool::Tool;
use crate::translator::{
    ClutchMap, DeviceMap, DominantHand, Filter, Hand, MarkerTool, OpeningName, OpeningSource,
    Translator,
};
use microsim_vocabulary::{DebugView, Finish, MICROSCOPE_VIEW};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Shapes of tool models, by the names that slots use.
pub type ToolModels = BTreeMap<String, Tool>;

/// What the source that plays scripts is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScriptConfig {
    /// The script, checked and in SI units.
    pub script: Script,
}

/// What the source that plays recordings is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "format", rename_all = "kebab-case", deny_unknown_fields)]
pub enum RecordingConfig {
    /// A CSV file with its column map.
    Csv {
        /// Name of the file, for complaints.
        name: String,
        /// The TOML beside it, checked.
        map: Box<RecordingMap>,
    },
    /// The input samples of a session, each with the time at which it arrived.
    Samples,
}

/// What a translator is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TranslatorConfig {
    /// A tool whose last sample is older is stale \[s\].
    pub stale_after: f64,
    /// What no hand goes beyond.
    pub hand: Hand,
    /// The devices that drive tools of the level, one per tool at most.
    pub devices: Vec<DeviceMap>,
    /// All tools of the level.
    pub tools: Vec<ToolSlot>,
    /// Instruments with markers, of those devices. What follows is not written where there is none of it, so that runs without it are those of earlier versions
    /// to the bit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub markers: Vec<MarkerTool>,
    /// Clutches.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clutches: Vec<ClutchMap>,
    /// Filters of those devices.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub filters: Vec<Filter>,
    /// What was calibrated on this station.
    #[serde(default, skip_serializing_if = "Calibration::is_empty")]
    pub calibration: Calibration,
    /// The trainee's dominant hand: with the left one the level is shown mirrored.
    #[serde(default, skip_serializing_if = "is_right")]
    pub dominant: DominantHand,
    /// Whether poses of devices are mirrored: those of instruments in the hands of a left-handed trainee. A script, and mouse and keyboard, move in the level's own field.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mirrored: bool,
}

fn is_right(hand: &DominantHand) -> bool {
    *hand == DominantHand::Right
}

/// Who moves the devices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trainee {
    /// The dominant hand.
    pub dominant: DominantHand,
    /// Whether the devices are instruments in hands, which see the level mirrored where the left one is dominant: all but scripts, and mouse and keyboard.
    pub holds_instruments: bool,
}

impl Trainee {
    /// Whether devices of the slots `left` and `right` change places, and poses are mirrored.
    fn mirrors(self) -> bool {
        self.dominant == DominantHand::Left && self.holds_instruments
    }
}

impl TranslatorConfig {
    /// Which of the source's `devices` drives which tool: as the translator's file states, otherwise the tool of the device's
    /// own name. Where the devices are not known beforehand, every tool that the file does not list has a device of its own name.
    pub fn new(
        translator: &Translator,
        calibration: &Calibration,
        devices: Option<&[String]>,
        tools: &[ToolSlot],
        trainee: Trainee,
    ) -> Self {
        let mirrored = trainee.mirrors();
        let has_tool = |map: &DeviceMap| tools.iter().any(|tool| tool.name == map.tool);
        let map_of = |device: &str| {
            let map = translator.device.iter().find(|map| map.name == device);
            let mut map = map.cloned().unwrap_or_else(|| DeviceMap::identity(device));
            adjust(translator, mirrored, &mut map);
            map
        };
        let maps: Vec<DeviceMap> = match devices {
            Some(devices) => {
                let made_up = translator.markers.iter().filter(|tool| {
                    let mut markers = tool.marker.iter();
                    markers.any(|marker| devices.contains(&marker.name))
                });
                let made_up = made_up.map(|tool| tool.device.clone());
                let mut all = devices.to_vec();
                for device in made_up {
                    if !all.contains(&device) {
                        all.push(device);
                    }
                }
                all.iter()
                    .map(|device| map_of(device))
                    .filter(has_tool)
                    .collect()
            }
            None => {
                let listed = translator.device.iter().map(|map| map_of(&map.name));
                let mut maps: Vec<DeviceMap> = listed.filter(has_tool).collect();
                for tool in tools {
                    if !maps.iter().any(|map| map.tool == tool.name) {
                        let mut map = map_of(slot_of(&tool.name, mirrored));
                        map.tool = tool.name.clone();
                        maps.push(map);
                    }
                }
                maps
            }
        };
        let drives = |device: &str| maps.iter().any(|map| map.name == device);
        let markers = translator
            .markers
            .iter()
            .filter(|tool| drives(&tool.device));
        let filters = translator
            .filter
            .iter()
            .filter(|filter| drives(&filter.device));
        let clutches = translator.clutch.iter().filter_map(|clutch| {
            let is_here = |name: &&String| tools.iter().any(|tool| tool.name == **name);
            // What a clutch holds is moved by the same hand.
            let held = clutch
                .tool
                .iter()
                .map(|tool| slot_of(tool, mirrored).to_owned());
            let tool: Vec<String> = held.filter(|tool| is_here(&tool)).collect();
            let device = clutch.device.clone();
            (!tool.is_empty()).then_some(ClutchMap { device, tool })
        });
        Self {
            stale_after: translator.stale_after,
            hand: translator.hand,
            tools: tools.to_vec(),
            markers: markers.cloned().collect(),
            clutches: clutches.collect(),
            filters: filters.cloned().collect(),
            calibration: calibration.of_devices(drives),
            devices: maps,
            dominant: trainee.dominant,
            mirrored,
        }
    }

    /// Where the tip of a device was calibrated to be.
    pub fn tip(&self, device: &str) -> Option<&TipCalibration> {
        self.calibration.tip.iter().find(|tip| tip.device == device)
    }

    /// Where the frame of a device was registered to lie.
    pub fn workspace(&self, device: &str) -> Option<&WorkspaceCalibration> {
        self.calibration.workspace_of(device)
    }
}

/// What the trainee's hand and a box of the tracker make of a device's map.
fn adjust(translator: &Translator, mirrored: bool, map: &mut DeviceMap) {
    map.tool = slot_of(&map.tool, mirrored).to_owned();
    let space = translator
        .tracking_box
        .iter()
        .find(|space| space.device == map.name);
    if let Some(space) = space {
        map.origin = space.centre;
        map.scale = space.scale();
    }
}

/// The slot that a tool of a right-handed trainee is in, and the device that drives a slot where none is listed: those of the same name, or of the other hand.
fn slot_of(tool: &str, mirrored: bool) -> &str {
    match tool {
        "left" if mirrored => "right",
        "right" if mirrored => "left",
        tool => tool,
    }
}

impl DeviceMap {
    /// A device that drives the tool of its own name, with its poses taken as they are.
    fn identity(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            tool: name.to_owned(),
            origin: [0.0; 3],
            field_offset: [0.0; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
            tool_rotation: [0.0, 0.0, 0.0, 1.0],
            scale: 1.0,
            opening: OpeningSource::Named(OpeningName::Device),
        }
    }
}

/// What a physics plugin is given: the parts of a level that a scene is built of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhysicsConfig {
    /// What acts on all bodies.
    pub physics: Physics,
    /// How they are advanced.
    pub method: Method,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// Rigid obstacles.
    pub rigid: Vec<Rigid>,
    /// What touches what.
    pub contacts: Vec<ContactPair>,
    /// What cuts what.
    pub cuts: Vec<CutPair>,
    /// The tool slots.
    pub tools: Vec<ToolSlot>,
    /// The shapes of the tools.
    pub models: ToolModels,
    /// Whether there is any friction.
    pub friction: bool,
    /// Whether tissue can be divided, by a cut or by tearing.
    pub cutting: bool,
    /// Whether what is known of elements is published beside the snapshots of bodies.
    #[serde(default)]
    pub elements: bool,
}

impl PhysicsConfig {
    /// Of a level; `None` if it has no physics.
    pub fn new(level: &Level, models: &ToolModels) -> Option<Self> {
        Some(Self {
            physics: level.physics?,
            method: level.method?,
            bodies: level.body.clone(),
            rigid: level.rigid.clone(),
            contacts: level.contact.clone(),
            cuts: level.cut.clone(),
            tools: level.tool.clone(),
            models: models.clone(),
            friction: true,
            cutting: true,
            elements: false,
        })
    }
}

/// What a training module is given of its level, checked and in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModuleConfig {
    /// Tool slots.
    pub tools: Vec<ToolSlot>,
    /// Shapes of the tool models.
    pub models: ToolModels,
    /// Limits of metrics: what the level demands.
    pub limits: Vec<Limit>,
    /// Parameters of the motion metrics.
    pub metrics: MetricParameters,
    /// Metrics that the module brings.
    pub own_metrics: Vec<ModuleMetric>,
    /// Reasons for failing that the module declares.
    pub reasons: Vec<Reason>,
    /// The level's `[module]` table: the keys that the manifest declares, in SI units.
    pub module: Value,
    /// The level's objects.
    #[serde(default)]
    pub objects: Vec<Object>,
    /// Names of the bodies; what is known of their tissue comes over the bus.
    #[serde(default)]
    pub bodies: Vec<String>,
    /// The level's rigid obstacles.
    #[serde(default)]
    pub rigid: Vec<Rigid>,
    /// How the level sets the microscope, for a module that follows it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
}

impl ModuleConfig {
    /// Of a level and the manifest of its module.
    pub fn new(level: &Level, manifest: &Manifest, models: &ToolModels) -> Self {
        let follows = |kind: &str| manifest.subscribes.iter().any(|other| other == kind);
        Self {
            tools: level.tool.clone(),
            models: models.clone(),
            limits: level.limit.clone(),
            metrics: level.metrics,
            own_metrics: manifest.metric.clone(),
            reasons: manifest.reason.clone(),
            module: Value::Object(level.module.clone()),
            objects: level.object.clone(),
            bodies: level.body.iter().map(|body| body.name.clone()).collect(),
            rigid: level.rigid.clone(),
            view: follows(MICROSCOPE_VIEW).then_some(level.view),
        }
    }

    /// Slots of the tools that hold tissue: those that do not cut it.
    pub fn holders(&self) -> Vec<String> {
        let cuts = |model: &str| self.models.get(model).is_some_and(|m| m.sharpness > 0.0);
        let holding = self.tools.iter().filter(|tool| !cuts(&tool.model));
        holding.map(|tool| tool.name.clone()).collect()
    }
}

/// What the plugin of virtual objects is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectsConfig {
    /// Objects that a module moves.
    pub objects: Vec<Object>,
    /// Rigid obstacles, which stand.
    pub rigid: Vec<Rigid>,
    /// Digests of the files of models and textures, hexadecimal, by their names: another file is another plan.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
}

impl ObjectsConfig {
    /// Of a level, and the digests of the files that its objects name.
    pub fn new(level: &Level, files: BTreeMap<String, String>) -> Self {
        Self {
            objects: level.object.clone(),
            rigid: level.rigid.clone(),
            files,
        }
    }
}

/// How a body is drawn.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyLook {
    /// Name of the body.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// How its surface answers light.
    pub finish: Finish,
}

/// Of a renderer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RendererConfig {
    /// What is seen.
    pub view: View,
    /// Shapes of the tool models.
    pub models: ToolModels,
    /// The bodies.
    pub bodies: Vec<BodyLook>,
    /// Width of a picture \[px\].
    pub width: u32,
    /// Height of a picture \[px\].
    pub height: u32,
    /// What stands in the picture's corner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub caption: Option<String>,
    /// Whether right and left are exchanged, for a left-handed trainee.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mirrored: bool,
    /// What is laid over it to see what is computed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub views: Vec<DebugView>,
}

impl RendererConfig {
    /// What colours the surfaces of bodies: the last of its views that does.
    pub fn surface_view(&self) -> Option<DebugView> {
        let mut views = self.views.iter().rev().copied();
        views.find(|view| view.colours_surfaces())
    }

    /// Of a level, for pictures of this size \[px\].
    pub fn new(level: &Level, models: &ToolModels, (width, height): (u32, u32)) -> Self {
        let look = |body: &Body| BodyLook {
            name: body.name.clone(),
            colour: body.colour,
            finish: body.finish,
        };
        Self {
            view: level.view,
            models: models.clone(),
            bodies: level.body.iter().map(look).collect(),
            width,
            height,
            caption: None,
            mirrored: false,
            views: Vec::new(),
        }
    }
}

/// Of a recorder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecorderConfig {
    /// The session file to write; it must not exist.
    pub path: PathBuf,
}
