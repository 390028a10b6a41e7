//! Every kind of file: full examples, bad inputs with their messages, schema against type, random texts, whole trees.

mod agreement;
mod bad_input;
mod discovery;
mod examples;
mod plugin_config;
mod random;
mod vessels;

use microsim_settings::*;
use serde_json::Value;

/// A full example of each kind: every key of its schema occurs.
const EXAMPLES: [(&str, &str); 13] = [
    ("manifest", include_str!("../examples/manifest.toml")),
    ("level", include_str!("../examples/level.toml")),
    ("scene", include_str!("../examples/scene.toml")),
    ("chart", include_str!("../examples/chart.toml")),
    ("tool", include_str!("../examples/tool.toml")),
    ("vessel", include_str!("../examples/vessel.toml")),
    ("window", include_str!("../examples/window.toml")),
    ("translator", include_str!("../examples/translator.toml")),
    ("recording", include_str!("../examples/recording.toml")),
    ("script", include_str!("../examples/script.toml")),
    ("trainees", include_str!("../examples/trainees.toml")),
    ("course", include_str!("../examples/course.toml")),
    ("host", include_str!("../examples/host.toml")),
];

fn example(kind: &str) -> &'static str {
    let found = EXAMPLES.iter().find(|(name, _)| *name == kind);
    found.expect("an example of each kind").1
}

/// The manifest of the example, whose keys the example level uses.
fn manifest() -> Manifest {
    let manifest = read_manifest(example("manifest"), "module.toml");
    manifest.expect("the example is right").settings
}

/// Two metrics that every level has.
const KNOWN_METRICS: [KnownMetric<'static>; 2] = [
    KnownMetric {
        id: "time",
        unit: Unit::Time,
        direction: Direction::Lower,
    },
    KnownMetric {
        id: "economy",
        unit: Unit::Ratio,
        direction: Direction::Higher,
    },
];

/// Reads a text of a kind of file, named `f.toml`; gives the values in SI.
fn read(kind: &str, text: &str) -> Result<Value, ConfigErrors> {
    let file = "f.toml";
    let document = match kind {
        "manifest" => read_manifest(text, file)?.document,
        "level" => read_level(text, file, &manifest(), &KNOWN_METRICS)?.document,
        "scene" => read_scene(text, file, &[])?.document,
        "chart" => read_chart(text, file)?.document,
        "tool" => read_tool(text, file)?.document,
        "vessel" => read_vessel(text, file)?.document,
        "window" => read_window(text, file)?.document,
        "translator" => read_translator(text, file)?.document,
        "recording" => read_recording_map(text, file)?.document,
        "script" => read_script(text, file)?.document,
        "trainees" => read_trainees(text, file)?.document,
        "course" => read_course(text, file)?.document,
        "host" => read_host(text, file)?.document,
        other => panic!("no kind `{other}`"),
    };
    Ok(document.value().clone())
}
