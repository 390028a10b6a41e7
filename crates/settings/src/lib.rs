//! The only reader of configuration: reads every TOML file once, checks it, and says file:line of what is wrong.
//!
//! One declarative engine ([`Schema`], [`Kind`], [`Unit`]) serves both the files of the program and the keys that a
//! training module declares in its manifest. It rejects unknown keys, wrong units and values out of range, fills in
//! defaults, and gives every quantity in SI. From the same schema come the JSON Schema ([`json_schema`]) and the reference
//! ([`reference()`]). What is not here: any decision what the settings do, and any file that is not configuration.
//!
//! Each kind of file has `*_schema`, `read_*` (from a text), `load_*` (from a path) and a typed struct. Complaints are
//! collected: one reading names all that is wrong in a file.

#![forbid(unsafe_code)]

mod body;
mod body_check;
mod body_schema;
mod chart;
mod chart_schema;
mod check;
mod colour;
mod contact;
mod contact_check;
mod contact_schema;
mod describe;
mod discover;
mod document;
mod error;
mod explain;
mod guess;
mod host;
mod level;
mod level_check;
mod level_schema;
mod manifest;
mod manifest_check;
mod manifest_schema;
mod method;
mod overrides;
mod plugin_config;
mod read;
mod recording;
mod rigid;
mod scene;
mod scene_check;
mod scene_schema;
mod schema;
mod script;
mod tool;
mod trainees;
mod translator;
mod tree;

pub use body::{
    Body, Clamp, Coupling, Generator, Law, Layer, Load, MAX_ELEMENTS, Material, MotionKey, Nodes,
    Plasticity, Shell, SpringForm, Start,
};
pub use body_schema::LENGTH_MAX;
pub use chart::{
    Chart, ChartBudget, ChartExact, ChartMaterial, ChartMeasure, ChartMethod, ChartResolution,
    ChartScene, ChartSweep, ChartTune, ChartVariant, ExactKind, load_chart, read_chart,
};
pub use chart_schema::chart_schema;
pub use colour::Colour;
pub use contact::{ContactPair, CutPair, SceneTool, ToolKey};
pub use describe::{json_schema, reference};
pub use discover::{ModuleFolder, Tree, discover};
pub use document::{Document, Loaded};
pub use error::{ConfigError, ConfigErrors, KeyPath, Position};
pub use explain::{LevelPart, level_parts};
pub use guess::guess_kind;
pub use host::{
    Host, LateSettings, PictureSettings, QueueSettings, ReportSettings, SessionSettings,
    host_schema, load_host, read_host,
};
pub use level::{
    Clock, KnownMetric, Level, Limit, MetricParameters, Object, Physics, Shape, ToolSlot, View,
    load_level, read_level,
};
pub use level_schema::level_schema;
pub use manifest::{
    KeyType, Manifest, MessageKind, ModuleKey, ModuleMetric, PluginFile, Reason, load_manifest,
    read_manifest,
};
pub use manifest_schema::manifest_schema;
pub use method::{Accuracy, Method, Tuned};
pub use microsim_vocabulary::{
    Category, CellSplit, Direction, Discretisation, Finish, Interpolation, Language, LawName,
    LocalText, MethodName, Overflow, PluginKind, QuantityError, Unit,
};
pub use overrides::Override;
pub use plugin_config::{
    BodyLook, ModuleConfig, ObjectsConfig, PhysicsConfig, RecorderConfig, RecordingConfig,
    RendererConfig, ScriptConfig, ToolModels, TranslatorConfig,
};
pub use recording::{
    DeviceColumns, OpeningColumn, RecordingMap, TimeColumn, load_recording_map, read_recording_map,
    recording_map_help, recording_map_path, recording_schema,
};
pub use rigid::{Rigid, RigidPart, RigidShape, Solid};
pub use scene::{End, Expect, Feature, Probe, Quantity, Scene, SceneRun, load_scene, read_scene};
pub use scene_schema::scene_schema;
pub use schema::{Form, Key, Kind, Presence, Schema};
pub use script::{
    Script, ScriptKey, ScriptTool, load_script, orientation_of_direction, read_script,
    script_schema,
};
pub use tool::{Jaw, Tool, ToolCapsule, load_tool, read_tool, tool_schema};
pub use trainees::{
    Sourced, TraineeProfile, Trainees, load_trainees, read_trainees, trainees_schema,
};
pub use translator::{
    DeviceMap, OpeningName, OpeningSource, Translator, load_translator, read_translator,
    translator_schema,
};

/// The kinds of file, by the names that the command line uses, each with a line about it.
pub const KINDS: [(&str, &str); 10] = [
    (
        "manifest",
        "plugin.toml, module.toml: what a plugin or training module is, needs and declares",
    ),
    (
        "level",
        "modules/NAME/levels/level<N>.toml: one level of a training module",
    ),
    (
        "scene",
        "config/scenes/NAME.toml: physics alone, as demonstration, test and benchmark",
    ),
    (
        "chart",
        "config/chart.toml: the runs that `microsim chart` compares",
    ),
    ("tool", "config/tools/NAME.toml: the shape of an instrument"),
    (
        "translator",
        "config/translator.toml: which device drives which tool",
    ),
    (
        "recording",
        "the TOML of the same name beside a CSV: what its columns mean",
    ),
    ("script", "a scripted trainee: timed poses and openings"),
    (
        "trainees",
        "config/trainees.toml: how synthetic trainees move",
    ),
    ("host", "config/host.toml: how the host runs sessions"),
];

/// The schema of a kind of file by its name in [`KINDS`]. That of a level leaves the keys of the module open; see
/// [`level_schema`] for those of one module.
pub fn schema_for(kind: &str) -> Option<Schema> {
    Some(match kind {
        "manifest" => manifest_schema(),
        "level" => level_schema(None),
        "scene" => scene_schema(),
        "chart" => chart_schema(),
        "tool" => tool_schema(),
        "translator" => translator_schema(),
        "recording" => recording_schema(),
        "script" => script_schema(),
        "trainees" => trainees_schema(),
        "host" => host_schema(),
        _ => return None,
    })
}
