//! Physics digests of runs: what a change of names, encodings or structure must not change.
//!
//! A physics digest is a chain over positions, velocities, internal variables, topology, contact forces, metrics and score as raw
//! numbers (`microsim_scene::Scene::digest`). The state hash beside it also covers encodings: it changes with the name of a field.

use crate::{command, microsim, repository, run};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// What is run.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// A scene of `config/scenes`, by its name.
    Scene(String),
    /// A script of a module: module, name of the script (which begins with `level` and the level's number).
    Script(String, String),
}

/// What came of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// What was run.
    pub subject: Subject,
    /// The physics digest, hexadecimal.
    pub physics_digest: String,
    /// The state hash, hexadecimal.
    pub state_hash: String,
    /// Verdict, score and reasons of failure of a script, status of a scene.
    pub result: String,
}

impl Row {
    /// Whether a script `levelN-fail-REASON` failed for that reason alone; any other must have passed.
    pub fn is_as_named(&self) -> bool {
        let Subject::Script(_, script) = &self.subject else {
            return true;
        };
        let mut words = self.result.split(' ');
        let verdict = words.next();
        let reasons: Vec<&str> = words.skip(1).collect();
        match script.split_once("-fail-") {
            None => verdict == Some("passed"),
            Some((_, reason)) => verdict == Some("failed") && reasons == [reason],
        }
    }
}

/// The recorded digests.
pub fn file() -> PathBuf {
    repository().join("tests/results/digests.csv")
}

const HEAD: &str = "subject,physics_digest,state_hash,result";

impl Subject {
    /// `scenes/NAME` or `MODULE/SCRIPT`.
    pub fn name(&self) -> String {
        match self {
            Self::Scene(name) => format!("scenes/{name}"),
            Self::Script(module, script) => format!("{module}/{script}"),
        }
    }

    /// The opposite of [`Self::name`].
    pub fn from_name(name: &str) -> Option<Self> {
        let (folder, name) = name.split_once('/')?;
        Some(match folder {
            "scenes" => Self::Scene(name.to_owned()),
            module => Self::Script(module.to_owned(), name.to_owned()),
        })
    }

    /// Runs it with so many threads; sessions and documents lie in `folder`.
    ///
    /// # Panics
    /// If the program cannot run it.
    pub fn run(&self, folder: &Path, threads: usize) -> Row {
        let threads = threads.to_string();
        let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
        let (printed, result) = match self {
            Self::Scene(name) => {
                let args = ["simulate", name, "--threads", &threads, "--json", "-"];
                let output = command(args).output().expect("the program starts");
                let printed: serde_json::Value = serde_json::from_slice(&output.stdout)
                    .unwrap_or_else(|e| panic!("scene {name}: {e}"));
                let result = text(&printed["status"]);
                (printed, result)
            }
            Self::Script(module, script) => {
                let path = repository().join(format!("modules/{module}/scripts/{script}.toml"));
                let input = format!("script:{}", path.display());
                let level = script.strip_prefix("level").expect("a script of a level");
                let level: String = level.chars().take_while(char::is_ascii_digit).collect();
                let session = folder.join(format!("{module}-{script}-{threads}.session"));
                let args = ["--level", &level, "--input", &input, "--threads", &threads];
                let printed = run(module, &session, &args);
                let mut result = format!("{} {}", text(&printed["verdict"]), printed["score"]);
                for reason in printed["failed"].as_array().into_iter().flatten() {
                    let _ = write!(result, " {}", text(reason));
                }
                (printed, result)
            }
        };
        Row {
            subject: self.clone(),
            physics_digest: text(&printed["physics_digest"]),
            state_hash: text(&printed["state_hash"]),
            result,
        }
    }
}

/// Every shipped script and every shipped scene.
///
/// # Panics
/// If folders of the repository cannot be read.
pub fn all() -> Vec<Subject> {
    let stems = |folder: PathBuf| {
        let listing =
            std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        let paths = listing.map(|entry| entry.expect("a file").path());
        let files = paths.filter(|path| path.extension().is_some_and(|e| e == "toml"));
        let stem = |path: PathBuf| path.file_stem()?.to_str().map(str::to_owned);
        files.filter_map(stem).collect::<Vec<_>>()
    };
    let scenes = stems(repository().join("config/scenes"));
    let mut subjects: Vec<_> = scenes.into_iter().map(Subject::Scene).collect();
    let listed = microsim(["list", "--json"]).expect(0).json();
    for module in listed["modules"].as_array().expect("modules") {
        let module = module["name"].as_str().expect("a name");
        let scripts = stems(repository().join(format!("modules/{module}/scripts")));
        subjects.extend(
            scripts
                .into_iter()
                .map(|s| Subject::Script(module.to_owned(), s)),
        );
    }
    subjects.sort();
    subjects
}

/// Rows as a file.
pub fn to_csv(rows: &[Row]) -> String {
    let mut csv = format!("{HEAD}\n");
    for row in rows {
        let Row {
            physics_digest,
            state_hash,
            result,
            ..
        } = row;
        let _ = writeln!(
            csv,
            "{},{physics_digest},{state_hash},{result}",
            row.subject.name()
        );
    }
    csv
}

/// Rows from a file.
///
/// # Errors
/// The number of the line that is not one of these rows.
pub fn from_csv(csv: &str) -> Result<Vec<Row>, usize> {
    let mut lines = csv.lines().zip(1..);
    if lines.next().map(|(line, _)| line) != Some(HEAD) {
        return Err(1);
    }
    let row = |line: &str| {
        let mut cells = line.split(',').map(str::to_owned);
        let row = Row {
            subject: Subject::from_name(&cells.next()?)?,
            physics_digest: cells.next()?,
            state_hash: cells.next()?,
            result: cells.next()?,
        };
        cells.next().is_none().then_some(row)
    };
    lines
        .map(|(line, number)| row(line).ok_or(number))
        .collect()
}
