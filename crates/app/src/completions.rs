//! `microsim completions`.

use crate::cli::{Cli, CompletionsArgs};
use crate::output::{Exit, Problem, print_long};
use clap::CommandFactory;
use clap_complete::Generator;

/// Prints what a shell needs to complete commands and options.
pub fn completions(args: &CompletionsArgs) -> Result<Exit, Problem> {
    let mut command = Cli::command();
    command.set_bin_name("microsim");
    command.build();
    print_long(|out| args.shell.try_generate(&command, out))?;
    Ok(Exit::Done)
}
