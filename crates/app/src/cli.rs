//! The command line: commands, options and their help, one file per group of commands. Validates, does nothing.

mod instruments;
mod physics;
mod place;
mod session;
mod store;
mod tree;
mod value;
mod window;

pub use instruments::{
    CalibrateCommand, DevicesArgs, ListenArgs, PivotArgs, RecordInputArgs, WorkspaceArgs,
};
pub use physics::{
    AtlasArgs, ChartArgs, FitArgs, MeshCommand, MeshRefineArgs, SimulateArgs, TuneArgs,
};
pub use place::{Place, Verbosity};
pub use session::{BusArgs, ReplayArgs, ReportArgs, RunArgs, TraineeArgs};
pub use store::{
    CourseAddArgs, CourseEnrolArgs, CourseProgressArgs, CourseUnlockArgs, CoursesCommand,
    GroupArgs, NameArgs, RebuildArgs, ResultsArgs, StoreCommand, StoreFileArgs, TraineeAddArgs,
    TraineeExportArgs, TraineeGoneArgs, TraineeListArgs, TraineesCommand,
};
pub use tree::{
    CheckArgs, CompletionsArgs, DigestsArgs, DoctorArgs, ListArgs, ManArgs, SchemaArgs,
};

pub use window::WindowArgs;

use clap::{Parser, Subcommand};
use std::path::Path;

/// Microsurgery trainer: runs training modules, records sessions, replays and reports them.
///
/// Exit status: 0 done (a failed level is a result, not an error), 1 the verdict that was asked for is negative
/// (`replay --verify`, `check`, `simulate` that diverged or did not come to rest as it should, `run --require-pass`), 2 could not run, 3 `run` is done and recorded but
/// could not write its report.
#[derive(Debug, Parser)]
#[command(name = "microsim", version = crate::version::text())]
pub struct Cli {
    #[command(flatten)]
    pub place: Place,
    #[command(flatten)]
    pub verbosity: Verbosity,
    /// Without one: `window`.
    #[command(subcommand)]
    pub command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Open the window: choose a level, train with mouse and keyboard, see what came of it (also without a command)
    Window(WindowArgs),
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
    /// Who trains here: names, roles, groups; export and erasure of what is theirs
    #[command(subcommand)]
    Trainees(TraineesCommand),
    /// Levels in order, and how far trainees are
    #[command(subcommand)]
    Courses(CoursesCommand),
    /// Find results, compare two, export them as a table
    Results(ResultsArgs),
    /// The database of trainees, courses and results: rebuild, export, import, check it
    #[command(subcommand)]
    Store(StoreCommand),
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
    /// Show what this machine has and lacks, and where everything lies
    Doctor(DoctorArgs),
    /// Print what a shell needs to complete commands and options
    Completions(CompletionsArgs),
    /// Write manual pages: one for the program, one for each command
    Man(ManArgs),
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

    /// Its name in the log, if it is in the log: what computes or records. What only shows leaves no trace.
    pub fn logged(&self) -> Option<&'static str> {
        match self {
            Self::Window(_) => Some("window"),
            Self::Run(_) => Some("run"),
            Self::Simulate(_) => Some("simulate"),
            Self::Chart(_) => Some("chart"),
            Self::Atlas(_) => Some("atlas"),
            Self::Tune(_) => Some("tune"),
            Self::Fit(_) => Some("fit"),
            Self::Replay(_) => Some("replay"),
            Self::Report(_) => Some("report"),
            Self::Trainee(_) => Some("trainee"),
            Self::Mesh(_) => Some("mesh"),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
