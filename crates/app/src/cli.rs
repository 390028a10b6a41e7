//! The command line: commands, options and their help. Validates, does nothing.

mod instruments;

pub use instruments::{
    CalibrateCommand, DevicesArgs, ListenArgs, PivotArgs, RecordInputArgs, WorkspaceArgs,
};

use clap::{Args, Parser, Subcommand};
use microsim_host::assemble::{Input, Isolate};
use microsim_mesh::Zone;
use microsim_settings::{LawName, Override};
use std::path::{Path, PathBuf};

/// Microsurgery trainer: runs training modules, records sessions, replays and reports them.
///
/// Exit status: 0 done (a failed level is a result, not an error), 1 the verdict that was asked for is negative
/// (`replay --verify`, `check`, `simulate` that diverged or did not come to rest as it should, `run --require-pass`), 2 could not run, 3 `run` is done and recorded but
/// could not write its report.
#[derive(Debug, Parser)]
#[command(name = "microsim", version, arg_required_else_help = true)]
pub struct Cli {
    #[command(flatten)]
    pub place: Place,
    #[command(subcommand)]
    pub command: Command,
}

/// Where the installation is.
#[derive(Debug, Args)]
pub struct Place {
    /// Folder with plugins/, modules/, config/ and assets/ [default: the folder of this program]
    #[arg(long, global = true, value_name = "DIR", help_heading = "Place", value_parser = utf8_path)]
    pub root: Option<PathBuf>,
    /// Use another folder instead of config/
    #[arg(long, global = true, value_name = "DIR", help_heading = "Place", value_parser = utf8_path)]
    pub config: Option<PathBuf>,
    /// More plugins: a folder with a folder for each, or the folder of one; may be given several times
    #[arg(long, global = true, value_name = "DIR", help_heading = "Place", value_parser = utf8_path)]
    pub plugins: Vec<PathBuf>,
    /// More training modules: a folder with a folder for each, or that of one, built with cargo or not; may be given several times
    #[arg(long, global = true, value_name = "DIR", help_heading = "Place", value_parser = utf8_path)]
    pub modules: Vec<PathBuf>,
    /// Folder for sessions, trainees, settings of this station, cache and logs [default: those of the system, or MICROSIM_DATA]
    #[arg(long, global = true, value_name = "DIR", help_heading = "Place", value_parser = utf8_path)]
    pub data: Option<PathBuf>,
    /// Which modules, sources and translators run in a process of their own: guests (what the installation did not bring), all, or none
    #[arg(long, global = true, value_name = "WHICH", help_heading = "Guests", default_value = "guests", value_parser = parse_isolate)]
    pub isolate: Isolate,
    /// Let guests take as long and as much memory as they like, so that a debugger can be attached; their process ids are printed
    #[arg(long, global = true, help_heading = "Guests")]
    pub no_deadline: bool,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// List modules with their levels, scenes, vessels, and plugins
    List(ListArgs),
    /// Run a level of a module; writes session and report
    Run(RunArgs),
    /// Run a scene of config/scenes: physics alone, with what was expected and what came out
    Simulate(SimulateArgs),
    /// Compare methods, elements and meshes on the scenes of config/chart.toml: error against CPU time, as CSV, SVG and HTML
    Chart(ChartArgs),
    /// Measure where methods fail and what helps: largest stable steps, bad elements, large steps, recovery of a damaged beam
    Atlas(AtlasArgs),
    /// Choose the cheapest method, mesh and step that keep the stated error of a scene or level, and write them into its file
    Tune(TuneArgs),
    /// Fit the constants of a material law to measured stretches and stresses, with intervals of confidence
    Fit(FitArgs),
    /// Recompute a recorded session, compare it, draw pictures of it
    Replay(ReplayArgs),
    /// Show the result of a recorded session, as text, JSON, CSV or an HTML page
    Report(ReportArgs),
    /// Write the motion of a synthetic trainee along the plan of a script, as a script
    Trainee(TraineeArgs),
    /// Show what an input sends: devices with rate, last pose and state
    Devices(DevicesArgs),
    /// Record what an input sends, as a recording that `--input recording:FILE` plays
    RecordInput(RecordInputArgs),
    /// Calibrate instruments and trackers of this station
    #[command(subcommand)]
    Calibrate(CalibrateCommand),
    /// Show which messages flow: the kinds and who publishes and receives them, or all messages of a session
    Bus(BusArgs),
    /// Validate config, scenes, meshes, modules, levels, scripts and recordings without running them
    Check(CheckArgs),
    /// Make a mesh file from another
    #[command(subcommand)]
    Mesh(MeshCommand),
    /// Print the JSON Schema of a kind of file, for editors
    Schema(SchemaArgs),
    /// Show what this machine has and lacks
    Doctor,
    /// The process of a guest: started by runs alone
    #[command(hide = true)]
    Guest,
    /// The digests of libraries, as an installation lists them
    #[command(hide = true)]
    Digests(DigestsArgs),
}

impl Command {
    /// The file for a trace, if one is wanted.
    pub fn trace(&self) -> Option<&Path> {
        match self {
            Self::Run(args) => args.trace.as_deref(),
            Self::Replay(args) => args.trace.as_deref(),
            Self::Simulate(args) => args.trace.as_deref(),
            _ => None,
        }
    }
}

#[derive(Debug, Args)]
pub struct ListArgs {
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  microsim run touch-spheres --input recording:assets/recordings/cataract-stylus/stylus.csv
  microsim run push-strip --level 2 --input script:level2-pass.toml --frames pictures
  microsim run push-strip --input script:level1-pass.toml --explain")]
pub struct RunArgs {
    /// Module, as `microsim list` shows it
    pub module: String,
    /// Level, from 1
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = parse_level)]
    pub level: u32,
    /// Where the motion comes from: script:FILE, recording:FILE (CSV with its TOML, or a session), openigtlink://HOST:PORT (a tracker) or plugin:NAME
    #[arg(long, value_name = "SOURCE", value_parser = parse_input)]
    pub input: Input,
    /// Who trains
    #[arg(long, value_name = "NAME")]
    pub trainee: Option<String>,
    /// Run without a window (this version has none: every run is headless)
    #[arg(long)]
    pub headless: bool,
    /// Draw pictures into this folder, which must hold none yet
    #[arg(long, value_name = "DIR", value_parser = utf8_path)]
    pub frames: Option<PathBuf>,
    /// Pictures per simulated second [default: `picture.rate` of config/host.toml]
    #[arg(long, value_name = "HZ", requires = "frames", value_parser = parse_rate)]
    pub frame_rate: Option<f64>,
    /// Draw no pictures of the key moments into the report; with --json there are none
    #[arg(long)]
    pub no_pictures: bool,
    /// Session file to write; it must not exist; the report is written beside it [default: a new name in the folder of config/host.toml]
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub session: Option<PathBuf>,
    /// Seed of everything random
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Threads for parallel work; the result does not depend on it
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,
    /// Pace ticks by the wall clock; late ticks are counted, none is left out. With a tracker as input it is always so
    #[arg(long)]
    pub realtime: bool,
    /// Leave something out, for tests: a kind of plugin, friction, or lonor (all cutting); such a run is no result
    #[arg(long, value_name = "WHAT", value_parser = ["physics", "friction", "lonor"])]
    pub without: Vec<String>,
    /// Show what would be loaded and computed, and why; runs nothing
    #[arg(long)]
    pub explain: bool,
    /// Exit with status 1 unless the level is passed
    #[arg(long)]
    pub require_pass: bool,
    /// Stop at a simulated time and write all that evolves into --checkpoint
    #[arg(long, value_name = "SECONDS", requires = "checkpoint", value_parser = parse_seconds)]
    pub stop_at: Option<f64>,
    /// File for the state at --stop-at; it must not exist
    #[arg(long, value_name = "FILE", requires = "stop_at", value_parser = utf8_path)]
    pub checkpoint: Option<PathBuf>,
    /// Go on from a checkpoint of the same module, level, seed and input
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub resume: Option<PathBuf>,
    /// Write where the time of every tick goes to this file (Chrome trace format, for Perfetto); it must not exist
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub trace: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(
    override_usage = "microsim simulate SCENE [OPTIONS]",
    after_help = "Exit status 1: it diverged, gained energy though nothing did work on it, or, of a scene that ends at rest, did not come to
rest within its duration; with --require also when an expectation was missed. The JSON document has it: status \"ok\",
\"not-at-rest\", \"gains-energy\" or \"diverged\".

Examples:
  microsim simulate cantilever
  microsim simulate cantilever --set body.0.cells=[15,3,3] --set body.0.material.0.poisson_ratio=0.45
  microsim simulate cantilever --set 'method={name=\"implicit-euler\",iterations=2}' --set run.step=5ms
  microsim simulate cantilever --set run.end=time --set run.rest_speed=
  microsim simulate cantilever --json --vtu > result.json
  microsim simulate my/scene.toml --json result.json --vtu frames"
)]
pub struct SimulateArgs {
    /// Scene: a file, or the name of one in config/scenes
    #[arg(value_parser = utf8_path)]
    pub scene: Option<PathBuf>,
    /// Use another value for a key of the scene: a path of keys and indices, and TOML or a text; KEY= takes the key out. A
    /// whole table replaces one, as another method with other keys needs
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse_override)]
    pub set: Vec<Override>,
    /// Threads for parallel work; the result does not depend on it
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,
    /// Write one JSON document with everything to this file, or, without FILE, alone to standard output
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-", value_parser = utf8_path)]
    pub json: Option<PathBuf>,
    /// Write what the probes of the scene measured to this file: a row per sample, in SI
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub csv: Option<PathBuf>,
    /// Write the deformed meshes as a series for ParaView into this folder [without DIR: SCENE-vtu]
    #[arg(long, value_name = "DIR", num_args = 0..=1, default_missing_value = "", value_parser = utf8_path)]
    pub vtu: Option<PathBuf>,
    /// Draw pictures (PNG) into this folder, one per frame
    #[arg(long, value_name = "DIR", value_parser = utf8_path)]
    pub frames: Option<PathBuf>,
    /// Exit with status 1 unless all that was expected came out
    #[arg(long)]
    pub require: bool,
    /// Run although the step is beyond what the bodies allow
    #[arg(long)]
    pub any_step: bool,
    /// Write where the time of every step goes to this file (Chrome trace format, for Perfetto); it must not exist
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub trace: Option<PathBuf>,
    /// Leave something out, to see what it does
    #[arg(long, value_name = "WHAT", value_parser = ["friction", "lonor"])]
    pub without: Vec<String>,
}

#[derive(Debug, Args)]
pub struct ChartArgs {
    /// Only the short part of the plan, within its time
    #[arg(long = "quick")]
    pub short: bool,
    /// Folder for chart.html, chart.csv and a drawing per scene
    #[arg(long, value_name = "DIR", default_value = "chart", value_parser = utf8_path)]
    pub out: PathBuf,
    /// Only this scene of the plan; may be given several times
    #[arg(long, value_name = "NAME")]
    pub scene: Vec<String>,
    /// Runs at a time; more than one makes all times longer
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// A date for the page; without one the same results give the same page
    #[arg(long, value_name = "TEXT")]
    pub date: Option<String>,
}

#[derive(Debug, Args)]
pub struct AtlasArgs {
    /// One or two of each kind, in less than a minute
    #[arg(long = "quick")]
    pub short: bool,
    /// Folder for atlas.html, atlas.md, the tables as CSV and the drawings
    #[arg(long, value_name = "DIR", default_value = "atlas", value_parser = utf8_path)]
    pub out: PathBuf,
    /// A date for the page
    #[arg(long, value_name = "TEXT")]
    pub date: Option<String>,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  microsim tune cantilever --dry-run
  microsim tune push-strip --level 2
  microsim tune my/scene.toml --verify")]
pub struct TuneArgs {
    /// Scene (a file, or the name of one in config/scenes), or module with --level
    pub target: String,
    /// Level of the module
    #[arg(long, value_name = "N", value_parser = parse_level)]
    pub level: Option<u32>,
    /// Keep mesh and elements of the file: choose method and step alone
    #[arg(long)]
    pub keep_mesh: bool,
    /// Write nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Choose nothing: run the file as it is and compare with the figures in it; exit with status 1 if they are not confirmed
    #[arg(long, conflicts_with = "dry_run")]
    pub verify: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "The table has a header: stretch_1, stretch_2 (an empty cell is a free side, without stress), cauchy_1 [kPa], cauchy_2 [kPa]
or piola_1 [kPa], piola_2 [kPa] (force per area as it is, or at rest), and protocol (name of the test). The specimen is free along
axis 3. Fibres lie in the plane of 1 and 2, fibres.angle from axis 1. Constants that are not given are fitted, but for poisson_ratio:
0.49 is assumed.

Examples:
  microsim fit strips.csv --law mooney-rivlin
  microsim fit media.csv --law transversely-isotropic --set fibres.angle=0deg --set poisson_ratio=0.49 --out media.toml"
)]
pub struct FitArgs {
    /// Table with the measurements (CSV)
    #[arg(value_parser = utf8_path)]
    pub data: PathBuf,
    /// Law, by its name in files
    #[arg(long, value_name = "LAW", value_parser = crate::constant::parse_law)]
    pub law: LawName,
    /// A constant that is given, and not fitted; may be given several times
    #[arg(long, value_name = "KEY=VALUE", value_parser = crate::constant::parse_constant)]
    pub set: Vec<(String, String)>,
    /// Write the material, as a scene takes it, to this file; it must not exist
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub out: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// Session file
    #[arg(value_parser = utf8_path)]
    pub session: PathBuf,
    /// Exit with status 1 unless every tick is recomputed to the bit, with the settings of this installation, and no signature is broken
    #[arg(long)]
    pub verify: bool,
    /// Trust this station as this one's own key is trusted (fingerprint, as `doctor` shows it there); with `--verify` the session must be
    /// signed by one of those that are trusted
    #[arg(long, value_name = "FINGERPRINT")]
    pub station: Vec<String>,
    /// Draw pictures into this folder, which must hold none yet
    #[arg(long, value_name = "DIR", value_parser = utf8_path)]
    pub frames: Option<PathBuf>,
    /// Pictures per simulated second [default: `picture.rate` of config/host.toml]
    #[arg(long, value_name = "HZ", requires = "frames", value_parser = parse_rate)]
    pub frame_rate: Option<f64>,
    /// Threads for parallel work
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,
    /// Write where the time of every tick goes to this file (Chrome trace format, for Perfetto); it must not exist
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub trace: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Session file
    #[arg(value_parser = utf8_path)]
    pub session: PathBuf,
    /// Write the page here
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub html: Option<PathBuf>,
    /// Language in which the page opens [default: `report.language` of config/host.toml]
    #[arg(long, value_name = "LANGUAGE", requires = "html", value_parser = ["de", "en"])]
    pub lang: Option<String>,
    /// Draw the key moments into the page: computes the session again
    #[arg(long, requires = "html")]
    pub pictures: bool,
    /// Write the metrics as CSV here
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub csv: Option<PathBuf>,
    /// Write motion and forces over time as CSV here
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub series: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Sessions and reports of such a script are labelled; groups of synthetic trainees validate nothing.

Example:
  microsim trainee modules/push-strip/scripts/level4-pass.toml --profile novice --seed 3 --out novice-3.toml"
)]
pub struct TraineeArgs {
    /// Script with the plan: one that passes
    #[arg(value_parser = utf8_path)]
    pub script: PathBuf,
    /// Kind of trainee, of config/trainees.toml
    #[arg(long, value_name = "NAME")]
    pub profile: String,
    /// Which one of its kind
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Script to write; it must not exist
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub out: PathBuf,
}

#[derive(Debug, Args)]
pub struct BusArgs {
    /// Session file; without one, the kinds of messages and who publishes and receives them
    #[arg(value_parser = utf8_path)]
    pub session: Option<PathBuf>,
    /// Only messages of this kind
    #[arg(long, value_name = "KIND")]
    pub kind: Option<String>,
    /// Only messages of this sender
    #[arg(long, value_name = "NAME")]
    pub from: Option<String>,
    /// Wait for more while the session is being written (until it is closed, or has not grown for 10 s)
    #[arg(long, requires = "session", conflicts_with = "json")]
    pub follow: bool,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Files, and folders with all that is known in them; without any, the whole installation with its libraries
    #[arg(value_parser = utf8_path)]
    pub paths: Vec<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Subcommand)]
pub enum MeshCommand {
    /// Halve tetrahedra where they are to be small, and around there as far as neighbours have to follow
    Refine(MeshRefineArgs),
}

#[derive(Debug, Args)]
#[command(
    after_help = "Lengths are in units of the file. Regions and fibre directions stay with the parts of an element.

Examples:
  microsim mesh refine organ.msh fine.msh --near 0,0,3,1.5 --size 0.2
  microsim mesh refine organ.vtu fine.vtu --near region:2 --size 0.4 --near plane:0,0,0,1,0,0,0.1 --size 0.2"
)]
pub struct MeshRefineArgs {
    /// Mesh file with tetrahedra
    #[arg(value_name = "IN", value_parser = utf8_path)]
    pub input: PathBuf,
    /// File to write, .msh or .vtu; it must not exist
    #[arg(value_name = "OUT", value_parser = utf8_path)]
    pub output: PathBuf,
    /// Where: X,Y,Z,R (what reaches within R of a point), segment:X,Y,Z,X,Y,Z,R, plane:X,Y,Z,NX,NY,NZ,D or region:N; may be given several times
    #[arg(long, value_name = "ZONE", required = true, allow_hyphen_values = true, value_parser = crate::zone::parse_zone)]
    pub near: Vec<Zone>,
    /// Longest edge of a tetrahedron there: once for all zones, or once for each in their order
    #[arg(
        long,
        value_name = "LENGTH",
        required = true,
        allow_hyphen_values = true
    )]
    pub size: Vec<f64>,
    /// Most tetrahedra of the result [default: those that a body may have, 5000000]
    #[arg(long, value_name = "N")]
    pub limit: Option<u64>,
}

#[derive(Debug, Args)]
pub struct DigestsArgs {
    /// Files, below --root
    #[arg(value_parser = utf8_path)]
    pub files: Vec<PathBuf>,
}

#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// Kind of file (without one: the list); `level:MODULE` includes the keys of that module
    pub kind: Option<String>,
    /// Print a table for reading instead
    #[arg(long)]
    pub markdown: bool,
}

fn parse_input(text: &str) -> Result<Input, String> {
    let known = "expected script:FILE, recording:FILE, openigtlink://HOST:PORT or plugin:NAME";
    match text.split_once(':') {
        Some((_, "")) => Err(format!("nothing behind the colon; {known}")),
        Some(("script", file)) => Ok(Input::Script(file.into())),
        Some(("recording", file)) => Ok(Input::Recording(file.into())),
        Some(("plugin", name)) => Ok(Input::Plugin(name.into())),
        Some(("openigtlink", rest)) => match rest.strip_prefix("//") {
            Some(address) if !address.is_empty() => Ok(Input::OpenIgtLink(address.into())),
            _ => Err(format!("no address behind openigtlink:; {known}")),
        },
        _ if text == "desktop" => Err(format!("mouse and keyboard are not there yet; {known}")),
        _ => Err(format!("unknown source; {known}")),
    }
}

fn parse_isolate(text: &str) -> Result<Isolate, String> {
    match text {
        "guests" => Ok(Isolate::Guests),
        "all" => Ok(Isolate::All),
        "none" => Ok(Isolate::None),
        _ => Err("expected guests, all or none".into()),
    }
}

/// Paths go into sessions and reports as text.
fn utf8_path(text: &str) -> Result<PathBuf, String> {
    Ok(text.into())
}

fn parse_override(text: &str) -> Result<Override, String> {
    Override::parse(text)
}

fn parse_positive(text: &str, what: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("expected a positive number of {what}")),
    }
}

fn parse_level(text: &str) -> Result<u32, String> {
    let level = text.parse();
    level.map_err(|_| "expected the number of a level, such as 1".into())
}

fn parse_rate(text: &str) -> Result<f64, String> {
    parse_positive(text, "pictures per simulated second")
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    parse_positive(text, "seconds")
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_level_that_is_no_number_is_refused_with_what_is() {
        assert_eq!(parse_level("4"), Ok(4));
        for text in ["vier", "-1", "1.5", "4294967296"] {
            let error = parse_level(text).expect_err(text);
            assert!(error.contains("the number of a level"), "{error}");
        }
    }

    #[test]
    fn sources_are_parsed_or_refused_with_what_is_possible() {
        assert_eq!(
            parse_input("script:a:b.toml"),
            Ok(Input::Script("a:b.toml".into()))
        );
        assert_eq!(
            parse_input("recording:x.csv"),
            Ok(Input::Recording("x.csv".into()))
        );
        assert_eq!(
            parse_input("openigtlink://host:18944"),
            Ok(Input::OpenIgtLink("host:18944".into()))
        );
        for bad in [
            "",
            "x.csv",
            "script:",
            "desktop",
            "openigtlink://",
            "openigtlink:host:18944",
        ] {
            assert!(
                parse_input(bad).unwrap_err().contains("recording:FILE"),
                "{bad}"
            );
        }
    }
}
