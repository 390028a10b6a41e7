//! `cargo xtask results`: which pages of results are older than the code that they measure, and how they are made again.
//!
//! A page is older if what it measures has other code now than at the page's commit: the packages that its head names, all of the
//! workspace that these depend on, and the paths that it names. Versions of crates from elsewhere are not compared.

mod age;
mod code;
mod page;

use crate::child;
use crate::command::{self, Make};
use crate::failure::Failure;
use crate::outcome::Outcome;
use crate::programs;
use crate::workspace::Workspace;
use age::{Age, History};
use page::{Again, Head, Page};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

const FOLDER: &str = "tests/results";

/// Lists the pages and makes some of them again.
pub fn results(workspace: &Workspace, make: Make) -> Result<(), Failure> {
    let (pages, ages) = listed(workspace)?;
    let wanted = |(page, age): (Page, &Age)| {
        let head = page.head.ok()?;
        let wanted = match (make, head.again) {
            (Make::Nothing, _) | (_, Again::ByHand | Again::Never) => false,
            (Make::Light, again) => again == Again::Light && *age != Age::Same,
            (Make::All, _) => true,
        };
        wanted.then_some((page.path, head))
    };
    let wanted: Vec<(PathBuf, Head)> = pages.into_iter().zip(&ages).filter_map(wanted).collect();
    if wanted.is_empty() {
        return none_older(&ages);
    }
    crate::setup::setup(crate::setup::Mode::Install)?;
    crate::tree::build(workspace)?;
    let mut done: Vec<&str> = Vec::new();
    for (path, head) in &wanted {
        for line in &head.commands {
            if !done.contains(&&line[..]) {
                stamped(workspace, std::slice::from_ref(line), || {
                    start(workspace, line)
                })?;
                done.push(line);
            }
        }
        // Also where the figures are the same, or the command only compares them.
        stamp(workspace, path, head.clone())?;
    }
    let (_, ages) = listed(workspace)?;
    none_older(&ages)
}

/// The phase of `cargo xtask test`: a head that cannot be read, or a commit that does not exist, fails it; a page that is older is named.
pub fn check(workspace: &Workspace) -> Result<Outcome, Failure> {
    let (_, ages) = listed(workspace)?;
    Ok(match ages.iter().filter(|age| age.is_older()).count() {
        0 => Outcome::Passed,
        _ if ages
            .iter()
            .any(|age| matches!(age, Age::NoHead(_) | Age::NamesMissing(_))) =>
        {
            Outcome::Failed
        }
        older => Outcome::Warned(format!(
            "{older} pages are older than their code or of unknown age"
        )),
    })
}

/// Runs commands that may write pages. Those that they wrote get their heads back: with this commit and this machine if the commands are those of the
/// page, all of them, and ended well, else as they were. A part of a page is of the old commit.
pub fn stamped(
    workspace: &Workspace,
    commands: &[String],
    work: impl FnOnce() -> Result<(), Failure>,
) -> Result<(), Failure> {
    let before = pages(workspace)?;
    let done = work();
    for old in before {
        let new = Page::read(&old.path).map_err(Failure::Cannot)?;
        let Ok(head) = old.head else { continue };
        if new.text == old.text {
            continue;
        }
        if done.is_ok() && head.is_made_by(commands) {
            stamp(workspace, &old.path, head)?;
        } else {
            write(&old.path, &head.put(&new.text))?;
        }
    }
    done
}

/// Puts this commit and this machine into the head of a page.
fn stamp(workspace: &Workspace, path: &Path, head: Head) -> Result<(), Failure> {
    let text = Page::read(path).map_err(Failure::Cannot)?.text;
    let head = head.made(History::of(&workspace.root).head()?, machine());
    write(path, &head.put(&text))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|e| Failure::Cannot(format!("{}: {e}", path.display())))
}

/// Prints a line for each page.
fn listed(workspace: &Workspace) -> Result<(Vec<Page>, Vec<Age>), Failure> {
    let pages = pages(workspace)?;
    let mut history = History::of(&workspace.root);
    let mut ages = Vec::new();
    for page in &pages {
        let mut age = match &page.head {
            Ok(head) => history.age(head, &mut |package| packages(workspace, package))?,
            Err(error) => Age::NoHead(error.clone()),
        };
        if matches!(age, Age::Same | Age::Older(_) | Age::Record) {
            let missing = history.missing_commits(&page.text);
            if !missing.is_empty() {
                age = Age::NamesMissing(missing);
            }
        }
        let path = page.path.strip_prefix(&workspace.root);
        let path = path.unwrap_or(&page.path).display();
        println!("{path}: {age}");
        if let (Ok(head), Age::Older(_)) = (&page.head, &age) {
            println!("    {:?}: {}", head.again, head.commands.join(" and "));
        }
        ages.push(age);
    }
    Ok((pages, ages))
}

fn none_older(ages: &[Age]) -> Result<(), Failure> {
    match ages.iter().filter(|age| age.is_older()).count() {
        0 => Ok(()),
        count => Err(Failure::Check(format!(
            "{count} of {} pages are older than their code, or of unknown age",
            ages.len()
        ))),
    }
}

fn pages(workspace: &Workspace) -> Result<Vec<Page>, Failure> {
    let mut paths = Vec::new();
    collect(&workspace.root.join(FOLDER), &mut paths)
        .map_err(|e| Failure::Cannot(format!("{FOLDER}: {e}")))?;
    paths.sort();
    let read = paths.iter().map(|path| Page::read(path));
    read.collect::<Result<_, _>>().map_err(Failure::Cannot)
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, found)?;
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.push(path);
        }
    }
    Ok(())
}

/// Folders of a package and of all of the workspace that it depends on.
fn packages(workspace: &Workspace, package: &str) -> Result<Vec<String>, Failure> {
    let mut cargo = workspace.cargo();
    cargo.args(["tree", "--locked", "-p", package, "-e", "normal,build"]);
    cargo.args(["--prefix", "none", "--format", "{p}"]);
    let output = cargo
        .output()
        .map_err(|e| Failure::Cannot(format!("cargo cannot be started: {e}")))?;
    if !output.status.success() {
        let error = String::from_utf8_lossy(&output.stderr);
        return Err(Failure::Cannot(format!(
            "`cargo tree` knows no package \"{package}\": {error}"
        )));
    }
    let root = format!("({}/", workspace.root.display());
    let text = String::from_utf8_lossy(&output.stdout);
    let mut folders: Vec<_> = text
        .lines()
        .filter_map(|line| Some(line.split_once(&root)?.1.split_once(')')?.0.to_owned()))
        .collect();
    folders.sort();
    folders.dedup();
    Ok(folders)
}

/// Starts a command of a head: one of this program's, or the simulator.
fn start(workspace: &Workspace, line: &str) -> Result<(), Failure> {
    let mut words = line.split_whitespace();
    let rest = |words: std::str::SplitWhitespace| words.map(OsString::from).collect::<Vec<_>>();
    match (words.next(), words.clone().next()) {
        (Some("microsim"), _) => {
            let mut program = workspace.simulator();
            child::must(program.args(words).current_dir(&workspace.root))
        }
        (Some("cargo"), Some("xtask")) => {
            words.next();
            match command::parse(rest(words)) {
                Ok(command::Command::Programs {
                    programs,
                    arguments,
                }) => programs
                    .iter()
                    .try_for_each(|program| programs::run(workspace, program, &arguments)),
                _ => Err(Failure::Cannot(format!("`{line}` measures nothing"))),
            }
        }
        _ => Err(Failure::Cannot(format!("`{line}` is no command of a page"))),
    }
}

/// This machine, in words.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| {
        let (key, value) = line.split_once(':')?;
        (key.trim() == "model name").then(|| value.trim().to_owned())
    });
    let model = model.unwrap_or_else(|| std::env::consts::ARCH.into());
    format!("{}, {cores} processor cores, {model}", std::env::consts::OS).replace('|', "/")
}
