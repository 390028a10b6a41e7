//! Commands about what is installed.

use super::value::utf8_path;
use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct ListArgs {
    /// Print one JSON document
    ///
    /// Keys: modules, scenes, vessels, plugins
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Files, and folders with all that is known in them; without any, the whole installation with its libraries
    #[arg(value_parser = utf8_path)]
    pub paths: Vec<PathBuf>,
    /// Print one JSON document
    ///
    /// Keys: checked, problems, warnings, statements
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// Kind of file (without one: the list); `level:MODULE` includes the keys of that module
    pub kind: Option<String>,
    /// Print a table for reading instead
    #[arg(long)]
    pub markdown: bool,
}

#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Print one JSON document
    ///
    /// Keys: version, commit, contract, installation, processors, instructions, folders, settings_of_station, station, pictures, healthy, problems
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  microsim completions bash > ~/.local/share/bash-completion/completions/microsim
  microsim completions fish > ~/.config/fish/completions/microsim.fish")]
pub struct CompletionsArgs {
    /// Shell
    pub shell: Shell,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:
  microsim man ~/.local/share/man/man1 && man microsim-run")]
pub struct ManArgs {
    /// Folder for the pages; those of an earlier version are replaced
    #[arg(value_name = "DIR", value_parser = utf8_path)]
    pub folder: PathBuf,
    /// Print one JSON document
    ///
    /// Keys: folder, pages
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct DigestsArgs {
    /// Files, below --root
    #[arg(value_parser = utf8_path)]
    pub files: Vec<PathBuf>,
}
