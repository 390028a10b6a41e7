//! `microsim man`.

use crate::cli::{Cli, ManArgs};
use crate::output::{Exit, Problem, print, print_json};
use crate::replace_file::replace;
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use microsim_settings::unwritable;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Writes the manual pages.
pub fn man(args: &ManArgs) -> Result<Exit, Problem> {
    let folder = &args.folder;
    std::fs::create_dir_all(folder).map_err(|e| unwritable(folder, e))?;
    let mut command = Cli::command();
    command.build();
    let pages = write(command, folder)?;
    if args.json {
        print_json(&json!({ "folder": folder, "pages": pages }))?;
    } else {
        print(format!("{} pages in {}", pages.len(), folder.display()))?;
    }
    Ok(Exit::Done)
}

/// The page of a command and those of the commands below it.
fn write(command: Command, folder: &Path) -> Result<Vec<PathBuf>, Problem> {
    let below: Vec<Command> = command
        .get_subcommands()
        .filter(|below| !below.is_hide_set() && below.get_name() != "help")
        .cloned()
        .collect();
    let page = Man::new(command);
    let path = folder.join(page.get_filename());
    let mut text = Vec::new();
    page.render(&mut text)?;
    replace(&path, &text)?;
    let mut written = vec![path];
    for command in below {
        written.extend(write(command, folder)?);
    }
    Ok(written)
}
