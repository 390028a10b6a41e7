//! Options of the commands for instruments and trackers.

use super::value::{parse_input, parse_positive, parse_seconds, utf8_path};
use clap::{Args, Subcommand};
use microsim_host::assemble::Input;
use std::path::{Path, PathBuf};

/// What to listen to, and for how long.
#[derive(Debug, Args)]
pub struct ListenArgs {
    /// What to listen to: recording:FILE or FILE.csv, openigtlink://HOST:PORT (a tracker) or plugin:NAME
    #[arg(long, value_name = "SOURCE", value_parser = parse_listened)]
    pub input: Input,
    /// For how long; a recording is read to its end without it
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    pub seconds: Option<f64>,
}

#[derive(Debug, Args)]
#[command(after_help = "Exit status 1: nothing was sent.

Examples:
  microsim devices --input openigtlink://127.0.0.1:18944
  microsim devices --input plugin:openigtlink --seconds 20 --json")]
pub struct DevicesArgs {
    #[command(flatten)]
    pub listen: ListenArgs,
    /// Print one JSON document
    ///
    /// Keys: listened_s, dropped, devices
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Writes FILE and, beside it, the TOML of the same name that says what its columns are.

Example:
  microsim record-input hand.csv --input openigtlink://127.0.0.1:18944 --seconds 60
  microsim run touch-spheres --input recording:hand.csv"
)]
pub struct RecordInputArgs {
    /// CSV file to write; neither it nor its TOML must exist
    #[arg(value_name = "FILE", value_parser = utf8_path)]
    pub file: PathBuf,
    #[command(flatten)]
    pub listen: ListenArgs,
    /// Terms under which the recording may be used, for its TOML
    #[arg(long, value_name = "TEXT", default_value = "unknown")]
    pub licence: String,
    /// Print one JSON document
    ///
    /// Keys: file, map, samples, rows, devices, left_out, dropped, listened_s
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Subcommand)]
pub enum CalibrateCommand {
    /// Where the tip of an instrument is: turn it to all sides with its tip in a dimple
    Pivot(PivotArgs),
    /// Where the frame of a tracker lies, from points that are touched, or given in pairs
    Workspace(WorkspaceArgs),
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit status 1: the residual is beyond --limit; nothing is written then.

Examples:
  microsim calibrate pivot left --input openigtlink://127.0.0.1:18944 --seconds 20
  microsim calibrate pivot left --input turned.csv --dry-run"
)]
pub struct PivotArgs {
    /// Slot of the tool, or name of the device
    pub tool: String,
    #[command(flatten)]
    pub listen: ListenArgs,
    /// Largest root mean square residual (mm)
    #[arg(long, value_name = "MM", default_value = "0.5", value_parser = parse_millimetres)]
    pub limit: f64,
    /// Write nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Points are CSV files in mm: --pairs with the columns device_x, device_y, device_z, field_x, field_y, field_z; --points with x, y, z, in the order
in which the tip touches them, each for --dwell seconds. The tip is that of `calibrate pivot`.
Exit status 1: the residual is beyond --limit; nothing is written then.

Examples:
  microsim calibrate workspace --points plate.csv --input openigtlink://127.0.0.1:18944 --tool left --devices left,right
  microsim calibrate workspace --pairs measured.csv --devices left,right --scale"
)]
pub struct WorkspaceArgs {
    /// Points in both frames
    #[arg(long, value_name = "FILE", value_parser = utf8_path, conflicts_with = "points", required_unless_present = "points")]
    pub pairs: Option<PathBuf>,
    /// Points of the field, which the tip touches
    #[arg(long, value_name = "FILE", value_parser = utf8_path, requires = "input", requires = "tool")]
    pub points: Option<PathBuf>,
    /// What to listen to, as for `calibrate pivot`
    #[arg(long, value_name = "SOURCE", value_parser = parse_listened)]
    pub input: Option<Input>,
    /// For how long to listen
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    pub seconds: Option<f64>,
    /// Slot of the tool that touches, or name of the device
    #[arg(long, value_name = "TOOL")]
    pub tool: Option<String>,
    /// Devices whose frame it is, with commas between [default: all that the input sends]
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        required_unless_present = "input"
    )]
    pub devices: Vec<String>,
    /// Let the scale be free; otherwise it is 1
    #[arg(long)]
    pub scale: bool,
    /// How long the tip has to stand on a point (s)
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, value_parser = parse_seconds)]
    pub dwell: f64,
    /// How far it may move in that time (mm)
    #[arg(long, value_name = "MM", default_value = "1", value_parser = parse_millimetres)]
    pub still: f64,
    /// Largest root mean square residual (mm)
    #[arg(long, value_name = "MM", default_value = "0.5", value_parser = parse_millimetres)]
    pub limit: f64,
    /// Write nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

/// An input to listen to: as for a run, or a recording by its name alone.
fn parse_listened(text: &str) -> Result<Input, String> {
    match Path::new(text).extension() {
        Some(extension) if extension == "csv" && !text.starts_with("recording:") => {
            Ok(Input::Recording(text.into()))
        }
        _ => parse_input(text),
    }
}

/// Millimetres, in metres.
fn parse_millimetres(text: &str) -> Result<f64, String> {
    parse_positive(text, "millimetres").map(|millimetres| 1e-3 * millimetres)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_may_be_named_alone() {
        let recording = Ok(Input::Recording("a/b.csv".into()));
        assert_eq!(parse_listened("a/b.csv"), recording);
        assert_eq!(parse_listened("recording:a/b.csv"), recording);
        let tracker = Ok(Input::OpenIgtLink("localhost:18944".into()));
        assert_eq!(parse_listened("openigtlink://localhost:18944"), tracker);
        assert!(parse_listened("b.txt").is_err());
        assert_eq!(parse_millimetres("0.5"), Ok(5e-4));
        assert!(parse_millimetres("-1").is_err());
    }
}
