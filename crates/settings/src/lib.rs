//! The only reader of configuration: reads every TOML file once, checks it, and reports file:line of what is wrong.
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
mod calibration;
mod chart;
mod check;
mod colour;
mod contact;
mod contact_check;
mod course;
mod describe;
mod desktop;
mod discover;
mod document;
mod edit;
mod edit_text;
mod error;
mod explain;
mod explain_tools;
mod files;
mod guess;
mod host;
mod kinds;
mod level;
mod level_check;
mod manifest;
mod manifest_check;
mod material;
mod method;
mod openigtlink;
mod overrides;
mod plugin_config;
mod read;
mod recording;
mod regular_file;
mod rigid;
mod scene;
mod scene_check;
mod schema;
mod script;
mod table;
mod tool;
mod trainees;
mod translator;
mod tree;
mod vessel;
mod vessel_body;
mod window;

pub use body::{
    Body, Clamp, Coupling, Generator, Layer, Load, MAX_ELEMENTS, MotionKey, Nodes, Refine, Shell,
    Start,
};
pub use calibration::{
    Calibration, TipCalibration, WorkspaceCalibration, load_calibration, read_calibration,
};
pub use chart::{
    Chart, ChartBudget, ChartExact, ChartMaterial, ChartMeasure, ChartMethod, ChartResolution,
    ChartScene, ChartSweep, ChartTune, ChartVariant, ExactKind, load_chart, read_chart,
};
pub use colour::Colour;
pub use contact::{
    BroadPhase, ContactPair, ContactResponse, CutPair, CutTopology, CutTrigger, Grip,
    PenetrationDepth, SceneTool, ToolKey,
};
pub use course::{Course, CourseStep, Unlock, load_course, read_course};
pub use describe::{json_schema, reference};
pub use desktop::{Desktop, DesktopConfig, load_desktop, read_desktop};
pub use discover::{ModuleFolder, Tree, Variant, discover, discover_with, variants_in};
pub use document::{Document, Loaded};
pub use edit::{LevelNumber, NumberGroup, WrongNumber, level_numbers, number_names};
pub use edit_text::LevelCopy;
pub use error::{ConfigError, ConfigErrors, KeyPath, Position};
pub use explain::{LevelPart, level_parts};
pub use explain_tools::translator_parts;
pub use files::KINDS;
pub use guess::guess_kind;
pub use host::{
    Host, LateSettings, PictureSettings, QueueSettings, ReportSettings, SessionSettings, load_host,
    read_host,
};
pub use kinds::LENGTH_MAX;
pub use level::{
    Clock, KnownMetric, Level, Limit, MetricParameters, Object, Physics, Shape, ToolSlot, View,
};
pub use level_check::{level_schema, load_level, load_level_with, read_level, read_level_with};
pub use manifest::{KeyType, Manifest, MessageKind, ModuleKey, ModuleMetric, PluginFile, Reason};
pub use manifest_check::{load_manifest, read_manifest};
pub use material::{Fibres, Law, Material, Plasticity, SpringForm};
pub use method::{Accuracy, Method, Tuned};
pub use microsim_vocabulary::{
    Category, CellSplit, DebugView, Direction, Discretisation, EyeLayout, Filling, Finish,
    Interpolation, Language, LawName, LocalText, MethodName, Overflow, PictureQuality, PluginKind,
    QuantityError, Remedy, Unit,
};
pub use openigtlink::{
    LinkClock, LinkDevice, LinkOpening, LinkRole, OpenIgtLink, TrackedStream, load_openigtlink,
    read_openigtlink,
};
pub use overrides::Override;
pub use plugin_config::{
    BodyLook, ModuleConfig, ObjectsConfig, PhysicsConfig, RecorderConfig, RecordingConfig,
    RendererConfig, ScriptConfig, ToolModels, Trainee, TranslatorConfig,
};
pub use recording::{
    DeviceColumns, OpeningColumn, RecordingMap, TimeColumn, load_recording_map, read_recording_map,
    recording_map_help, recording_map_path,
};
pub use regular_file::{in_words, open_regular, read_regular, unwritable};
pub use rigid::{Rigid, RigidPart, RigidShape, Solid};
pub use scene::{End, Expect, Feature, Probe, Quantity, Scene, SceneRun};
pub use scene_check::{load_scene, read_scene, read_scene_with};
pub use schema::{Form, Key, Kind, Presence, Schema};
pub use script::{
    Script, ScriptKey, ScriptTool, load_script, orientation_of_direction, read_script,
};
pub use tool::{Irrigation, Jaw, Tool, ToolCapsule, load_tool, read_tool};
pub use trainees::{Sourced, TraineeProfile, Trainees, load_trainees, read_trainees};
pub use translator::{
    ClutchMap, DeviceMap, DominantHand, Filter, FilterParameters, Hand, MarkerPlace, MarkerTool,
    OpeningName, OpeningSource, TrackingBox, Translator, load_translator, read_translator,
};
pub use vessel::{
    Basis, Vessel, VesselConstants, VesselLayer, VesselValue, load_vessel, read_vessel,
};
pub use window::{
    BASE_MAX, CONTROLLER_SPEEDS, Pedal, WORKING_DISTANCES, WindowSettings, load_window, read_window,
};

/// The schema of a kind of file by its name in [`KINDS`]. That of a level leaves the keys of the module open; see
/// [`level_schema`] for those of one module.
pub fn schema_for(kind: &str) -> Option<Schema> {
    use files::schema_of;
    Some(match kind {
        "manifest" => schema_of::<Manifest>(kind),
        "level" => level_schema(None),
        "scene" => schema_of::<Scene>(kind),
        "chart" => schema_of::<Chart>(kind),
        "tool" => schema_of::<Tool>(kind),
        "translator" => schema_of::<Translator>(kind),
        "calibration" => schema_of::<Calibration>(kind),
        "openigtlink" => schema_of::<OpenIgtLink>(kind),
        "desktop" => schema_of::<Desktop>(kind),
        "window" => schema_of::<WindowSettings>(kind),
        "recording" => schema_of::<RecordingMap>(kind),
        "script" => schema_of::<Script>(kind),
        "trainees" => schema_of::<Trainees>(kind),
        "course" => schema_of::<Course>(kind),
        "vessel" => schema_of::<Vessel>(kind),
        "host" => schema_of::<Host>(kind),
        _ => return None,
    })
}
