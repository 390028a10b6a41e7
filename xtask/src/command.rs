//! The command line: words in, a command out, nothing done yet.

use crate::programs::{BENCHES, Program, SOAKS, select};
use std::ffi::OsString;
use std::path::PathBuf;

/// What is asked for.
#[derive(Debug)]
pub enum Command {
    /// What can be asked for.
    Help,
    /// The simulator; the demonstration without arguments.
    Run(Vec<OsString>),
    /// The tree.
    Build {
        /// With the features that tests build with.
        tests: bool,
    },
    /// All checks.
    Test {
        /// Without the integration tests.
        short: bool,
        /// For the test programs.
        harness: Vec<OsString>,
    },
    /// What the system has to bring.
    Setup {
        /// Only report.
        check: bool,
    },
    /// A new training module.
    NewModule {
        /// Its name.
        name: String,
        /// Folder that its own folder is made in, if not `modules`.
        folder: Option<PathBuf>,
    },
    /// The pages of results: which are older than their code.
    Results(Make),
    /// Measurements or long checks.
    Programs {
        /// Which.
        programs: Vec<&'static Program>,
        /// For each of them.
        arguments: Vec<OsString>,
    },
}

/// What to do with pages of results that are older than their code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Make {
    /// Name them.
    Nothing,
    /// Make those again that are light.
    Light,
    /// Make every page again that a command makes.
    All,
}

/// The help, with the tables of programs.
pub fn help() -> String {
    let list = |programs: &[Program]| -> String {
        let lines = programs
            .iter()
            .map(|p| format!("\n                       {}: {}", p.name, p.shows));
        lines.collect()
    };
    format!(
        "\
cargo xtask COMMAND: builds, runs and checks MicroSim

  run [ARGS]         set-up, build, then `microsim run ARGS`; without ARGS a headless demonstration:
                     the recorded hand on touch-spheres, with report, pictures and a verified replay
  test [--quick] [-- ARGS]
                     set-up, build, then format, clippy, documentation, licences and advisories of the
                     dependencies (installs cargo-deny if it is missing), and all tests; ARGS go to those;
                     --quick leaves out the integration tests (package microsim-tests)
  build [--tests]    builds everything into target/microsim/, a tree that runs as it lies; with --tests so
                     that `cargo test --release --workspace` builds nothing of it again
  setup [--check]    checks what the system needs and installs it where it can; --check only reports
  new module NAME [--dir DIR]
                     makes modules/NAME (or DIR/NAME), a small training module that builds and runs
  bench [NAME] [-- ARGS]
                     measures; without NAME everything:{}
  soak [NAME] [-- ARGS]
                     long checks; without NAME all of them:{}
  results [--list|--all]
                     names the pages of tests/results that are older than the code they measure, and makes
                     the light ones of them again; --list only names them, --all makes every page (hours)
  help               this text

Exit code: 0 done, 1 a check failed, 2 could not run; `run` ends with the code of `microsim run`.
CARGO_TARGET_DIR is honoured: the tree is then $CARGO_TARGET_DIR/microsim.
",
        list(BENCHES),
        list(SOAKS)
    )
}

/// Reads the words after `cargo xtask`. The error is one sentence.
pub fn parse(words: impl IntoIterator<Item = OsString>) -> Result<Command, String> {
    let mut words = words.into_iter();
    let Some(command) = words.next() else {
        return Err("a command is missing".into());
    };
    let command = command.to_string_lossy().into_owned();
    let mut rest: Vec<OsString> = words.collect();
    // `run --help` is the simulator's.
    let asks_help = |word: &OsString| word == "--help" || word == "-h";
    if command != "run" && rest.iter().take_while(|word| *word != "--").any(asks_help) {
        return Ok(Command::Help);
    }
    let parsed = match command.as_str() {
        "help" | "--help" | "-h" => return Ok(Command::Help),
        "run" => return Ok(Command::Run(rest)),
        "build" => Command::Build {
            tests: flag(&mut rest, "--tests"),
        },
        "test" => Command::Test {
            harness: after_dashes(&mut rest),
            short: flag(&mut rest, "--quick"),
        },
        "setup" => Command::Setup {
            check: flag(&mut rest, "--check"),
        },
        "new" => new_module(&mut rest)?,
        "bench" => programs(BENCHES, &mut rest)?,
        "soak" => programs(SOAKS, &mut rest)?,
        "results" => Command::Results(
            match (flag(&mut rest, "--list"), flag(&mut rest, "--all")) {
                (true, false) => Make::Nothing,
                (false, false) => Make::Light,
                (false, true) => Make::All,
                (true, true) => {
                    return Err("`results` takes `--list` or `--all`, not both".into());
                }
            },
        ),
        _ => return Err(format!("there is no command \"{command}\"")),
    };
    match rest.first() {
        None => Ok(parsed),
        Some(word) => Err(format!(
            "`{command}` does not take \"{}\"",
            word.to_string_lossy()
        )),
    }
}

/// Takes the words after `--`, if there is one.
fn after_dashes(words: &mut Vec<OsString>) -> Vec<OsString> {
    let Some(at) = words.iter().position(|word| word == "--") else {
        return Vec::new();
    };
    let after = words.split_off(at + 1);
    words.pop();
    after
}

/// Takes a flag; returns whether it was there.
fn flag(words: &mut Vec<OsString>, name: &str) -> bool {
    let at = words.iter().position(|word| word == name);
    at.map(|at| words.remove(at)).is_some()
}

/// Takes the first word that is no flag.
fn name(words: &mut Vec<OsString>) -> Option<String> {
    let at = words
        .iter()
        .position(|word| !word.to_string_lossy().starts_with('-'))?;
    Some(words.remove(at).to_string_lossy().into_owned())
}

fn new_module(words: &mut Vec<OsString>) -> Result<Command, String> {
    let folder = match words.iter().position(|word| word == "--dir") {
        Some(at) if at + 1 < words.len() => {
            words.remove(at);
            Some(PathBuf::from(words.remove(at)))
        }
        Some(_) => return Err("`--dir` needs a folder".into()),
        None => None,
    };
    match (name(words).as_deref(), name(words)) {
        (Some("module"), Some(name)) => Ok(Command::NewModule { name, folder }),
        (Some("module"), None) => Err("`new module` needs a name".into()),
        _ => Err("`new` makes a module: cargo xtask new module NAME".into()),
    }
}

fn programs(table: &'static [Program], words: &mut Vec<OsString>) -> Result<Command, String> {
    let arguments = after_dashes(words);
    let programs = select(table, name(words).as_deref())?;
    Ok(Command::Programs {
        programs,
        arguments,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> String {
        match parse(line.split_whitespace().map(OsString::from)) {
            Ok(Command::Programs {
                programs,
                arguments,
            }) => {
                let examples: Vec<_> = programs.iter().map(|p| p.example).collect();
                format!("{examples:?} {arguments:?}")
            }
            Ok(command) => format!("{command:?}"),
            Err(error) => error,
        }
    }

    #[test]
    fn a_line_becomes_a_command() {
        for (line, expected) in [
            ("run", "Run([])"),
            (
                "run push-strip --help -- x",
                r#"Run(["push-strip", "--help", "--", "x"])"#,
            ),
            ("build", "Build { tests: false }"),
            ("build --tests", "Build { tests: true }"),
            ("test", "Test { short: false, harness: [] }"),
            (
                "test --quick -- --quick a",
                r#"Test { short: true, harness: ["--quick", "a"] }"#,
            ),
            ("setup", "Setup { check: false }"),
            ("setup --check", "Setup { check: true }"),
            (
                "new module demo",
                r#"NewModule { name: "demo", folder: None }"#,
            ),
            (
                "new module --dir /x demo",
                r#"NewModule { name: "demo", folder: Some("/x") }"#,
            ),
            (
                "new module demo --dir x",
                r#"NewModule { name: "demo", folder: Some("x") }"#,
            ),
            ("bench kernels", r#"["bench_kernels"] []"#),
            ("bench peers -- --all", r#"["bench_peers"] ["--all"]"#),
            (
                "soak kills -- --runs 8",
                r#"["soak_kills"] ["--runs", "8"]"#,
            ),
            ("results", "Results(Light)"),
            ("results --list", "Results(Nothing)"),
            ("results --all", "Results(All)"),
            ("help", "Help"),
            ("--help", "Help"),
            ("test -h", "Help"),
            ("test -- -h", r#"Test { short: false, harness: ["-h"] }"#),
        ] {
            assert_eq!(parsed(line), expected, "{line}");
        }
    }

    #[test]
    fn a_wrong_line_is_told_what_is_wrong() {
        for (line, expected) in [
            ("", "a command is missing"),
            ("tset", "there is no command \"tset\""),
            ("build all", "`build` does not take \"all\""),
            ("test quick", "`test` does not take \"quick\""),
            ("setup --quick", "`setup` does not take \"--quick\""),
            (
                "results --all --list",
                "`results` takes `--list` or `--all`, not both",
            ),
            ("new", "`new` makes a module: cargo xtask new module NAME"),
            (
                "new plugin demo",
                "`new` makes a module: cargo xtask new module NAME",
            ),
            ("new module", "`new module` needs a name"),
            ("new module demo --dir", "`--dir` needs a folder"),
            ("new module demo more", "`new` does not take \"more\""),
            ("soak kills --runs", "`soak` does not take \"--runs\""),
        ] {
            assert_eq!(parsed(line), expected, "{line}");
        }
    }

    #[test]
    fn without_a_name_every_program_runs_and_a_wrong_name_lists_them() {
        for (command, table) in [("bench", BENCHES), ("soak", SOAKS)] {
            let examples: Vec<_> = table.iter().map(|program| program.example).collect();
            assert_eq!(parsed(command), format!("{examples:?} []"));
            let names: Vec<_> = table.iter().map(|program| program.name).collect();
            assert_eq!(
                parsed(&format!("{command} hosts")),
                format!("there is no \"hosts\"; there are: {}", names.join(", "))
            );
        }
    }

    #[test]
    fn the_help_names_every_command_and_fits_a_terminal() {
        let help = help();
        for name in [
            "run ",
            "test ",
            "build ",
            "setup ",
            "new module ",
            "bench ",
            "soak ",
            "results ",
            "help ",
        ] {
            assert!(help.contains(&format!("\n  {name}")), "{name}");
        }
        for program in BENCHES.iter().chain(SOAKS) {
            assert!(help.contains(program.shows), "{}", program.name);
        }
        assert!(help.lines().all(|line| line.chars().count() <= 110));
    }
}
