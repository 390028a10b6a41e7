//! `microsim completions`.

use crate::cli::{Cli, CompletionsArgs};
use crate::output::{Exit, Problem, print_long};
use clap::{Command, CommandFactory};
use clap_complete::Generator;

/// Prints what a shell needs to complete commands and options.
pub fn completions(args: &CompletionsArgs) -> Result<Exit, Problem> {
    let whole = Cli::command();
    // What is hidden is for no person.
    let visible = whole.get_subcommands().filter(|below| !below.is_hide_set());
    let mut command = Command::new("microsim")
        .args(whole.get_arguments().cloned())
        .subcommands(visible.cloned());
    command.set_bin_name("microsim");
    command.build();
    print_long(|out| args.shell.try_generate(&command, out))?;
    Ok(Exit::Done)
}
