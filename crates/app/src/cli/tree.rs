//! Commands about what is installed.

use super::value::utf8_path;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct ListArgs {
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

#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// Kind of file (without one: the list); `level:MODULE` includes the keys of that module
    pub kind: Option<String>,
    /// Print a table for reading instead
    #[arg(long)]
    pub markdown: bool,
}

#[derive(Debug, Args)]
pub struct DigestsArgs {
    /// Files, below --root
    #[arg(value_parser = utf8_path)]
    pub files: Vec<PathBuf>,
}
