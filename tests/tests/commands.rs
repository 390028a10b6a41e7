//! The command line as people and shells expect it: version, completions, manual pages, what goes to standard error, one JSON document.

use microsim_tests::{Finished, command, finish, microsim, repository, scratch};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

const SCRIPT: &str = "script:level1-pass.toml";

/// Commands as `--help` lists them.
fn commands() -> Vec<String> {
    let help = microsim(["--help"]).expect(0).out;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = listed.take_while(|line| line.starts_with("  "));
    names
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next())
        .filter(|name| !name.is_empty() && *name != "help")
        .map(str::to_owned)
        .collect()
}

/// Version of the package, commit of the repository, version of the contract.
#[test]
fn the_version_names_commit_and_contract() {
    let printed = microsim(["--version"]).expect(0).out;
    let version = env!("CARGO_PKG_VERSION");
    let rest = printed
        .trim_end()
        .strip_prefix(&format!("microsim {version} (commit "));
    let (commit, contract) = rest.and_then(|rest| rest.split_once(", ")).expect(&printed);
    assert_eq!(
        contract,
        format!("plugin contract {})", microsim_abi::ABI_VERSION)
    );
    let doctor = microsim(["doctor", "--json"]).json();
    assert_eq!(doctor["commit"], commit, "{doctor}");
    assert_eq!(doctor["contract"], microsim_abi::ABI_VERSION);
    let mut git = Command::new("git");
    git.current_dir(repository());
    let hash = commit.trim_end_matches("-dirty");
    // A build without the repository does not know; one with it names a commit that is in it.
    match repository().join(".git").exists() {
        true => {
            assert!(
                hash.len() >= 7 && hash.bytes().all(|b| b.is_ascii_hexdigit()),
                "{commit}"
            );
            let known = git
                .args(["cat-file", "-e", &format!("{hash}^{{commit}}")])
                .status();
            assert!(known.expect("git").success(), "{commit}");
        }
        false => assert_eq!(commit, "unknown"),
    }
}

/// Bash takes the script, and completes a command, an option and a value with it.
#[test]
fn shells_complete_commands_and_options() {
    let folder = scratch();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = microsim(["completions", shell]).expect(0).out;
        for command in commands() {
            assert!(script.contains(&command), "{shell} has no {command}");
        }
        assert!(!script.contains("digests"), "{shell}: a hidden command");
        fs::write(folder.path().join(shell), script).expect("written");
    }
    let complete = |words: &str, at: u32| {
        let mut bash = Command::new("bash");
        bash.arg("-c").arg(format!(
            "source {}; COMP_WORDS=({words}); COMP_CWORD={at}; _microsim microsim \"${{COMP_WORDS[{at}]}}\" \
             \"${{COMP_WORDS[$(({at}-1))]}}\"; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
            folder.path().join("bash").display()
        ));
        finish(&mut bash).expect(0).out
    };
    assert_eq!(complete("microsim simu", 1), "simulate\n");
    assert_eq!(complete("microsim run --explai", 2), "--explain\n");
    let shells = complete("microsim completions ''", 2);
    assert!(shells.contains("fish\n"), "{shells}");
    let unknown = microsim(["completions", "tcsh"]).expect(2);
    assert!(unknown.err.contains("bash"), "{unknown:?}");
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = scratch();
    let pages = folder.path().join("man1");
    let at = pages.to_str().expect("UTF-8");
    microsim(["man", at]).expect(0);
    let page =
        |name: &str| fs::read_to_string(pages.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(page("microsim.1").contains(".TH microsim 1"));
    let commands = commands();
    assert!(commands.len() > 15, "{commands:?}");
    for command in commands {
        let text = page(&format!("microsim-{command}.1"));
        assert!(text.contains(".SH OPTIONS"), "{command}");
    }
    assert!(page("microsim-mesh-refine.1").contains("near"));
    assert!(!pages.join("microsim-digests.1").exists());
    // Again, over those that are there.
    let document = microsim(["man", at, "--json"]).expect(0).json();
    assert_eq!(document["folder"], at);
}

/// What `-v`, `-q` and `RUST_LOG` let through, by a command that warns: a script made for another level.
#[test]
fn more_or_less_goes_to_standard_error() {
    let folder = scratch();
    let printed = |more: &[&str], rust_log: Option<&str>| -> Finished {
        let session = folder.path().join("x.session");
        let _ = fs::remove_file(&session);
        let mut run = command(["run", "touch-spheres", "--level", "2", "--no-pictures"]);
        run.args(["--input", "script:level1-pass.toml", "--session"])
            .arg(&session)
            .args(more);
        run.env_remove("RUST_LOG");
        if let Some(level) = rust_log {
            run.env("RUST_LOG", level);
        }
        finish(&mut run).expect(0)
    };
    let warns =
        |printed: &Finished| printed.err.contains("WARN") && printed.err.contains("made for");
    assert!(warns(&printed(&[], None)));
    for level in ["-q", "-qq"] {
        assert_eq!(printed(&[level], None).err, "", "{level}");
    }
    assert!(warns(&printed(&["-v"], None)));
    assert!(printed(&["-vv"], None).err.contains("DEBUG"));
    assert!(!printed(&["-v"], None).err.contains("DEBUG"));
    // Without either the environment decides, with one the command line.
    assert!(printed(&[], Some("debug")).err.contains("DEBUG"));
    assert_eq!(printed(&[], Some("error")).err, "");
    assert_eq!(printed(&["-q"], Some("debug")).err, "");
    // What is for the log file alone is not here, even if everything is.
    assert!(!printed(&["-vvv"], None).err.contains("begins"));
    // Why a command could not run is always there.
    assert!(
        !microsim(["report", "no.session", "-qq"])
            .expect(2)
            .err
            .is_empty()
    );
    // What standard output has does not depend on it.
    let out = printed(&[], None).out;
    assert_eq!(printed(&["-qq"], None).out, out);
    assert_eq!(printed(&["-vvv"], None).out, out);
}

/// On a terminal, which `script` of util-linux makes: colours unless `NO_COLOR` is set, and not even line control where it is dumb.
#[test]
fn colours_are_for_terminals_that_want_them() {
    let has_script = Command::new("script")
        .arg("--version")
        .output()
        .is_ok_and(|o| o.status.success());
    if !has_script {
        eprintln!("skipped: there is no `script` (util-linux) to make a terminal");
        return;
    }
    let program = microsim_tests::program();
    let on_terminal = |variables: &[(&str, &str)]| -> String {
        let folder = scratch();
        let mut script = Command::new("script");
        let line = format!(
            "{} run touch-spheres --level 2 --no-pictures --input {SCRIPT} --session {}",
            program.display(),
            folder.path().join("x.session").display()
        );
        script
            .args(["-qec", &line, "/dev/null"])
            .current_dir(repository());
        microsim_tests::apart(&mut script);
        script
            .env_remove("NO_COLOR")
            .env_remove("RUST_LOG")
            .env("TERM", "xterm");
        script.envs(variables.iter().copied());
        finish(&mut script).expect(0).out
    };
    let escape = "\u{1b}[";
    let plain = on_terminal(&[]);
    assert!(
        plain.contains(escape) && plain.contains("WARN"),
        "{plain:?}"
    );
    for variables in [[("NO_COLOR", "1")], [("TERM", "dumb")]] {
        let text = on_terminal(&variables);
        assert!(!text.contains(escape) && text.contains("WARN"), "{text:?}");
    }
    assert!(on_terminal(&[("NO_COLOR", "")]).contains(escape));
}

/// Remaining time of what takes long, on standard error: where there is no terminal a line every ten seconds.
#[test]
fn what_takes_long_states_how_far_it_is() {
    let folder = scratch();
    // Half a minute of a beam in steps of 0.05 ms.
    let mut simulate = command([
        "simulate",
        "cantilever-dynamic",
        "--set",
        "run.duration=60s",
        "--json",
        "-",
    ]);
    simulate.env("RUST_LOG", "error").current_dir(folder.path());
    simulate
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped());
    let mut child = simulate.spawn().expect("the program starts");
    let mut line = String::new();
    let mut reader = std::io::BufReader::new(child.stderr.take().expect("piped"));
    std::io::BufRead::read_line(&mut reader, &mut line).expect("a line");
    let _ = child.kill();
    let _ = child.wait();
    let words = [" % , ", " passed, about ", " left: ", " s simulated"];
    assert!(
        line.contains(" %, ") && words[1..].iter().all(|part| line.contains(part)),
        "{line:?}"
    );
}

/// A document, alone on standard output, with the keys that `--help` of its command lists, in both directions.
#[track_caller]
fn document(args: &[&str], folder: &Path) -> Value {
    let mut run = command(args);
    let printed = finish(run.current_dir(folder));
    assert!(matches!(printed.code, Some(0 | 1)), "{printed:?}");
    let document = printed.json();
    let names = args.iter().take_while(|word| !word.starts_with('-'));
    let subcommand = usize::from(args[0] == "mesh") + 1;
    let mut help: Vec<&str> = names.take(subcommand).copied().collect();
    help.push("--help");
    let help = microsim(help).expect(0).out;
    let text = help.split_whitespace().collect::<Vec<_>>().join(" ");
    let listed = text.split_once("Keys: ").expect(&text).1;
    // What follows in brackets or behind a full stop is about other things.
    let listed = listed.split(['.', '(', ']', '-']).next().expect("a list");
    let listed: BTreeSet<&str> = listed
        .split(',')
        .filter_map(|key| key.split_whitespace().next())
        .collect();
    let found: BTreeSet<&str> = document
        .as_object()
        .expect("a table")
        .keys()
        .map(String::as_str)
        .collect();
    assert!(
        found.is_subset(&listed),
        "{args:?} has {found:?}, --help {listed:?}"
    );
    document
}

#[test]
fn every_command_has_a_json_document() {
    // What they print is for other programs already; a window prints nothing.
    let without = ["completions", "schema", "window"];
    for name in commands() {
        // These have commands of their own.
        let groups = ["mesh", "trainees", "courses", "store", "calibrate"];
        if groups.contains(&name.as_str()) || without.contains(&name.as_str()) {
            continue;
        }
        let help = microsim([name.as_str(), "--help"]).expect(0).out;
        assert!(
            help.contains("--json") && (help.contains("Keys: ") || help.contains("Keys of")),
            "{name}"
        );
    }
    let folder = scratch();
    let at = folder.path();
    let mesh = repository().join("assets/meshes/sfepy/msh_tetra.msh");
    let mesh = mesh.to_str().expect("UTF-8");
    let refine = [
        "mesh",
        "refine",
        mesh,
        "fine.msh",
        "--near",
        "plane:0,0,0,1,0,0,1e9",
        "--size",
        "1e9",
        "--json",
    ];
    let refined = document(&refine, at);
    assert_eq!(
        refined["after"]["tetrahedra"],
        refined["before"]["tetrahedra"]
    );
    let script = repository().join("modules/touch-spheres/scripts/level1-pass.toml");
    let script = script.to_str().expect("UTF-8");
    let made = document(
        &[
            "trainee",
            script,
            "--profile",
            "novice",
            "--out",
            "n.toml",
            "--json",
        ],
        at,
    );
    assert!(
        made["duration_s"].as_f64() > made["planned_s"].as_f64(),
        "{made}"
    );
    let chart = document(&["chart", "--quick", "--scene", "stretch", "--json"], at);
    let rows = fs::read_to_string(at.join("chart/chart.csv")).expect("a table");
    assert_eq!(
        chart["runs"].as_array().expect("a list").len(),
        rows.lines().count() - 1
    );
    let doctor = document(&["doctor", "--json"], at);
    assert_eq!(doctor["problems"], serde_json::json!([]));
    let run = [
        "run",
        "touch-spheres",
        "--json",
        "--input",
        SCRIPT,
        "--session",
        "x.session",
    ];
    document(&run, at);
    document(&["report", "x.session", "--json"], at);
    document(&["replay", "x.session", "--json"], at);
    document(&["list", "--json"], at);
    document(&["check", "n.toml", "--json"], at);
    document(&["man", "pages", "--json"], at);
    document(&["simulate", "stretch", "--json"], at);
    document(&["tune", "stretch", "--dry-run", "--json"], at);
}
