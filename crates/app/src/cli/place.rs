//! Where the installation and the files of a user are: options of every command.

use super::value::{parse_isolate, utf8_path};
use clap::{ArgAction, Args};
use microsim_host::assemble::Isolate;
use std::path::PathBuf;

/// Where the installation is.
#[derive(Clone, Debug, Args)]
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

/// How much goes to standard error.
#[derive(Debug, Args)]
pub struct Verbosity {
    /// More on standard error: what is done (-v), how long its stages take (-vv), everything (-vvv) [else as RUST_LOG has it: warnings]
    #[arg(short, long, global = true, action = ArgAction::Count, help_heading = "Output")]
    pub verbose: u8,
    /// Less: neither warnings nor progress (-q), nor errors of parts (-qq); why the command could not run is always printed
    #[arg(short, long, global = true, action = ArgAction::Count, help_heading = "Output")]
    pub quiet: u8,
}

impl Verbosity {
    /// Steps above warnings; below where it is negative.
    pub fn level(&self) -> i32 {
        i32::from(self.verbose) - i32::from(self.quiet)
    }
}
