//! Commands about scenes, methods, materials and meshes.

use super::value::{parse_level, parse_override, utf8_path, views};
use clap::{Args, Subcommand};
use microsim_mesh::Zone;
use microsim_settings::{DebugView, LawName, Override};
use std::path::PathBuf;

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
    ///
    /// Keys: scene, set, without, run, method, method_settings, dt, steps, simulated_s, cpu_s, threads, status, diverged, came_to_rest,
    /// recoveries, most_substeps, unconverged, stiffened, jumps, warnings, physics_digest, state_hash, bodies, series, contacts, crossings, cut,
    /// probes, expectations
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
    /// Lay over the pictures what is computed; may be given several times, of stress, quality and remedies one. Stress: von Mises, in Pa; quality: of the worst element at a
    /// node, 1 of a regular tetrahedron; remedies: what had to be done so that it could be computed
    #[arg(long, value_name = "WHAT", requires = "frames", value_parser = views())]
    pub view: Vec<DebugView>,
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
    /// Print one JSON document
    ///
    /// Keys: command, machine, seconds, page, table, panels, left_out, runs (the rows of the table, by its columns)
    #[arg(long)]
    pub json: bool,
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
    /// Print one JSON document
    ///
    /// Keys: command, machine, seconds, page, findings, tables (the rows of each, by its columns)
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  microsim tune cantilever --dry-run
  microsim tune push-strip --level 2 --out level2.toml
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
    /// Write the file as tuned to this place [default: where it is; a file of the installation is never written]
    #[arg(long, value_name = "FILE", conflicts_with_all = ["dry_run", "verify"], value_parser = utf8_path)]
    pub out: Option<PathBuf>,
    /// Choose nothing: run the file as it is and compare with the figures in it; exit with status 1 if they are not confirmed
    #[arg(long, conflicts_with = "dry_run")]
    pub verify: bool,
    /// Print one JSON document
    ///
    /// Keys: file, demanded, chosen, trials, measure, doubt, error_of_linear_tetrahedra, written. With --verify: file, demanded, figures, cost,
    /// confirmed
    #[arg(long)]
    pub json: bool,
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
    ///
    /// Keys: law, stress, constants, correlations, goodness, searches, warnings, toml
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
    /// Print one JSON document
    ///
    /// Keys: input, output, notes, before, after (nodes, tetrahedra, shortest_height of both)
    #[arg(long)]
    pub json: bool,
}
