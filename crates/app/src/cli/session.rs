//! Commands that make sessions, and that show them.

use super::value::{
    parse_hand, parse_input, parse_level, parse_rate, parse_seconds, table_path, utf8_path, views,
};
use clap::Args;
use microsim_host::assemble::Input;
use microsim_settings::{DebugView, DominantHand};
use std::path::PathBuf;

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
    /// Variant of the level, as `microsim list` shows it: the same task with other methods; no result of the level, and left out of the store
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// Where the motion comes from: script:FILE, recording:FILE (CSV with its TOML, or a session), openigtlink://HOST:PORT (a tracker) or plugin:NAME
    #[arg(long, value_name = "SOURCE", value_parser = parse_input)]
    pub input: Input,
    /// Who trains: name or id of a trainee in the store (`microsim trainees add NAME`); the session holds the id alone
    #[arg(long, value_name = "NAME")]
    pub trainee: Option<String>,
    /// Leave the run out of the store, for good: `store rebuild` leaves its session out as well. With --trainee only an id, as names stand in the store
    #[arg(long)]
    pub no_store: bool,
    /// Run without a window (this version has none: every run is headless)
    #[arg(long)]
    pub headless: bool,
    /// Draw pictures into this folder, which must hold none yet
    #[arg(long, value_name = "DIR", value_parser = utf8_path)]
    pub frames: Option<PathBuf>,
    /// Pictures per simulated second [default: `picture.rate` of config/host.toml]
    #[arg(long, value_name = "HZ", requires = "frames", value_parser = parse_rate)]
    pub frame_rate: Option<f64>,
    /// Lay over the pictures what is computed; may be given several times, of stress, quality and remedies one. Stress: von Mises, in Pa; quality: of the worst element at a
    /// node, 1 of a regular tetrahedron; remedies: what had to be done so that it could be computed
    #[arg(long, value_name = "WHAT", requires = "frames", value_parser = views())]
    pub view: Vec<DebugView>,
    /// Draw no pictures of the key moments into the report; with --json there are none
    #[arg(long)]
    pub no_pictures: bool,
    /// Session file to write; it must not exist; the report is written beside it [default: a new name in the folder of config/host.toml]
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub session: Option<PathBuf>,
    /// Dominant hand of who trains: for the left one the level is shown mirrored, and poses of tracked instruments are mirrored [default: `dominant` of config/translator.toml]
    #[arg(long, value_name = "HAND", value_parser = parse_hand)]
    pub hand: Option<DominantHand>,
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
    ///
    /// Keys: module, level, variant, seed, verdict, counts, synthetic, failed, score, targets_done, targets, ticks, solver, implausible, late_ticks,
    /// markers, arrivals, state_hash, physics_digest, session, session_id, trainee, stored, report, pictures, failure. With --explain: module, level, variant, tick_s, steps, plugins, parts, without,
    /// settings_of_station
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
    /// Lay over the pictures what is computed; may be given several times, of stress, quality and remedies one. Stress: von Mises, in Pa; quality: of the worst element at a
    /// node, 1 of a regular tetrahedron; remedies: what had to be done so that it could be computed
    #[arg(long, value_name = "WHAT", requires = "frames", value_parser = views())]
    pub view: Vec<DebugView>,
    /// Threads for parallel work
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,
    /// Write where the time of every tick goes to this file (Chrome trace format, for Perfetto); it must not exist
    #[arg(long, value_name = "FILE", value_parser = utf8_path)]
    pub trace: Option<PathBuf>,
    /// Print one JSON document
    ///
    /// Keys: session, ticks, verified, recomputed, other_settings, unchanged, signature, resumed, guest_ended, first_difference, state_hash,
    /// recorded_hash, complaint, rebuilt, pictures
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
    /// Write every tool, force and event as one tidy table (time_s, source, quantity, unit, value, text) here: .csv or .parquet
    #[arg(long, value_name = "FILE", value_parser = table_path)]
    pub table: Option<PathBuf>,
    /// Print one JSON document
    ///
    /// Keys: format, session, verdict, counts, failed, reasons, duration, simulated, phase, targets_done, targets, score, categories, metrics,
    /// input, implausible, markers, arrivals, presence, series, forces, events, moments, solver, recoveries, warnings
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
    /// Print one JSON document
    ///
    /// Keys: script, plan, profile, seed, synthetic, duration_s, planned_s
    #[arg(long)]
    pub json: bool,
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
    ///
    /// A list. Keys of each message: tick, time, from, kind, message; without a session of each kind: kind, version, when_full, published_by,
    /// heard_by
    #[arg(long)]
    pub json: bool,
}
