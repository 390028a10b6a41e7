//! `microsim doctor`.

use crate::check::libraries;
use crate::cli::{DoctorArgs, Place};
use crate::folders::Folders;
use crate::log;
use crate::output::{Exit, Problem, print, print_json};
use crate::processor;
use crate::session_file::installation;
use crate::station;
use crate::version;
use microsim_host::assemble::{Installation, probe_renderer};
use microsim_settings::unwritable;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// What was found: a line for people, and a key of the document for programs.
#[derive(Default)]
struct Findings {
    lines: Vec<String>,
    document: Map<String, Value>,
    problems: Vec<String>,
}

impl Findings {
    fn line(&mut self, what: &str, text: impl std::fmt::Display) {
        self.lines.push(format!("{what:<14} {text}"));
    }

    /// What keeps runs from working.
    fn problem(&mut self, problem: String) {
        self.line("  problem", &problem);
        self.problems.push(problem);
    }

    fn put(&mut self, key: &str, value: Value) {
        self.document.insert(key.into(), value);
    }
}

/// Prints what this machine has and lacks, and where everything lies. Only what keeps runs from working makes the answer negative.
pub fn doctor(place: &Place, args: &DoctorArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let mut findings = Findings::default();
    find_program(&mut findings);
    find_installation(&installation, &mut findings);
    find_machine(&mut findings);
    match Folders::of(place) {
        Ok(folders) => find_folders(place, &installation, &folders, &mut findings),
        Err(why) => {
            findings.put("folders", Value::Null);
            findings.problem(why);
        }
    }
    find_station(place, &mut findings);
    let pictures = probe_renderer(&installation);
    match &pictures {
        Ok(()) => findings.line("pictures", "on"),
        Err(reason) => findings.line("pictures", format!("off: {reason}")),
    }
    findings.put(
        "pictures",
        json!({ "on": pictures.is_ok(), "why": pictures.err() }),
    );
    let healthy = findings.problems.is_empty();
    findings.put("healthy", healthy.into());
    findings.put("problems", findings.problems.clone().into());
    if args.json {
        print_json(&Value::Object(findings.document))?;
    } else {
        print(findings.lines.join("\n"))?;
    }
    Ok(if healthy { Exit::Done } else { Exit::Negative })
}

fn find_program(findings: &mut Findings) {
    findings.line("version", version::text());
    findings.put("version", env!("CARGO_PKG_VERSION").into());
    findings.put("commit", version::COMMIT.into());
    findings.put("contract", version::CONTRACT.into());
}

fn find_installation(installation: &Installation, findings: &mut Findings) {
    findings.line("installation", installation.root.display());
    let (plugins, modules) = (
        installation.tree.plugins.len(),
        installation.tree.modules.len(),
    );
    findings.line("found", format!("{modules} modules, {plugins} plugins"));
    for complaint in &installation.complaints {
        findings.problem(complaint.to_string());
    }
    let problems: Vec<String> = libraries(installation)
        .into_iter()
        .filter_map(|(_, checked)| checked.err())
        .collect();
    if problems.is_empty() {
        findings.line("libraries", "all can be opened");
    }
    for problem in problems {
        findings.problem(problem);
    }
    findings.put(
        "installation",
        json!({
            "root": installation.root, "config": installation.config,
            "modules": modules, "plugins": plugins,
        }),
    );
}

fn find_machine(findings: &mut Findings) {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    findings.line("processors", cores);
    findings.put("processors", cores.into());
    // Had it lacked one, the program would have ended before.
    let instructions = processor::used_names();
    match instructions.as_str() {
        "" => findings.line(
            "instructions",
            "those of every such processor; without FMA solvers are slow",
        ),
        names => findings.line("instructions", format!("{names}: the processor has them")),
    }
    findings.put("instructions", instructions.into());
}

fn find_folders(
    place: &Place,
    installation: &Installation,
    folders: &Folders,
    findings: &mut Findings,
) {
    let sessions = folders.sessions();
    let writable = |folder: &Path| match try_to_write(folder) {
        Ok(()) => format!("{} (writable)", folder.display()),
        Err(why) => why,
    };
    findings.line("data", writable(&folders.data));
    findings.line("sessions", writable(&sessions));
    findings.line("store", folders.store().display());
    findings.line("levels", folders.levels().display());
    let replaced = installation.replaced();
    findings.line(
        "settings",
        match (&place.config, replaced.is_empty()) {
            (Some(config), _) => format!("{} (--config)", config.display()),
            (None, true) => format!("{} (none: the shipped ones hold)", folders.config.display()),
            (None, false) => folders.config.display().to_string(),
        },
    );
    for file in &replaced {
        findings.line(
            "",
            format!("{}, in place of the shipped one", file.display()),
        );
    }
    findings.line("cache", writable(&folders.cache));
    findings.line("logs", writable(&folders.logs));
    // Without a cache or a log everything works; without sessions nothing can be recorded.
    findings.problems.extend(try_to_write(&sessions).err());
    let written = [&folders.data, &sessions, &folders.cache, &folders.logs].into_iter();
    let not_writable: Vec<_> = written
        .filter(|folder| try_to_write(folder).is_err())
        .collect();
    findings.put(
        "folders",
        json!({
            "data": folders.data,
            "sessions": sessions,
            "store": folders.store(),
            "levels": folders.levels(),
            "config": folders.config,
            "cache": folders.cache,
            "logs": folders.logs,
            "log_file": log::newest(&folders.logs),
            "not_writable": not_writable,
        }),
    );
    findings.put("settings_of_station", json!(replaced));
}

/// Writes into a folder, or where it would be made, and removes it again.
fn try_to_write(folder: &Path) -> Result<(), String> {
    let there: Option<PathBuf> = folder
        .ancestors()
        .find(|ancestor| ancestor.symlink_metadata().is_ok())
        .map(Path::to_path_buf);
    let there = there.unwrap_or_default();
    let probe = there.join(format!(".doctor-{}", std::process::id()));
    let written = std::fs::write(&probe, b"").and_then(|()| std::fs::remove_file(&probe));
    written.map_err(|error| unwritable(folder, error))
}

fn find_station(place: &Place, findings: &mut Findings) {
    let found = station::path(place).and_then(|path| Ok((station::this(place)?, path)));
    let document = match found {
        Ok((this, path)) => {
            findings.line(
                "station",
                match &this {
                    Some(this) => format!("{this} ({})", path.display()),
                    None => format!("no key yet; the first run makes {}", path.display()),
                },
            );
            json!({ "fingerprint": this.map(|this| this.to_string()), "key": path })
        }
        Err(why) => {
            let problem = format!("sessions are not signed: {why}");
            findings.line("station", &problem);
            findings.problems.push(problem);
            Value::Null
        }
    };
    findings.put("station", document);
}
