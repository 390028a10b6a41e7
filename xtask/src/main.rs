//! `cargo xtask`: one program that builds, runs and checks MicroSim, the same for people and for servers. Needs nothing
//! but cargo; [`command`] lists what it can do.

#![forbid(unsafe_code)]

mod checks;
mod child;
mod command;
mod demonstration;
mod dependencies;
mod failure;
mod new_module;
mod outcome;
mod programs;
mod results;
mod setup;
mod tree;
mod workspace;

use command::Command;
use failure::Failure;
use setup::Mode;
use std::process::ExitCode;
use workspace::Workspace;

fn main() -> ExitCode {
    let command = match command::parse(std::env::args_os().skip(1)) {
        Ok(command) => command,
        Err(error) => {
            eprint!("error: {error}\n\n{}", command::help());
            return ExitCode::from(2);
        }
    };
    match act(command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !matches!(failure, Failure::Child(_)) {
                eprintln!("error: {failure}");
            }
            ExitCode::from(failure.code())
        }
    }
}

fn act(command: Command) -> Result<(), Failure> {
    let workspace = Workspace::here()?;
    match command {
        Command::Help => {
            print!("{}", command::help());
            Ok(())
        }
        Command::Run(arguments) => {
            setup::setup(Mode::Install)?;
            tree::build(&workspace)?;
            if arguments.is_empty() {
                demonstration::demonstrate(&workspace)
            } else {
                Err(demonstration::run_simulator(&workspace, &arguments))
            }
        }
        Command::Build { tests: false } => tree::build(&workspace),
        Command::Build { tests: true } => tree::build_for_tests(&workspace),
        Command::Results(make) => results::results(&workspace, make),
        Command::Test { short, harness } => checks::check(&workspace, short, &harness),
        Command::Setup { check: true } => setup::setup(Mode::Report),
        Command::Setup { check: false } => setup::setup(Mode::InstallAloud),
        Command::NewModule { name, folder } => new_module::create(&workspace, &name, folder),
        Command::Programs {
            programs,
            arguments,
        } => {
            setup::setup(Mode::Install)?;
            tree::build(&workspace)?;
            let commands: Vec<_> = programs.iter().map(|p| p.command(&arguments)).collect();
            results::stamped(&workspace, &commands, || {
                programs
                    .iter()
                    .try_for_each(|p| programs::run(&workspace, p, &arguments))
            })
        }
    }
}
