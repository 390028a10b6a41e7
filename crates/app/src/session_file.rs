//! Session files: reading them for a command, and making a report of one.

use crate::cli::Place;
use crate::folders::Folders;
use crate::output::Problem;
use crate::progress::Progress;
use microsim_host::assemble::{Installation, Places, hand_of};
use microsim_host::plan::{PluginKind, RunPlan};
use microsim_host::record::{Session, SessionReader, Signatures, TickRecord};
use microsim_message::LocalText;
use microsim_report::{Report, ReportBuilder, ReportInput, TimeSpread, Verdict};
use microsim_settings::{DominantHand, ToolSlot, open_regular, read_regular};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

/// The installation that a command works with.
pub fn installation(place: &Place) -> Result<Installation, Problem> {
    let root = match &place.root {
        Some(root) => root.clone(),
        None => program_folder()?,
    };
    if root.to_str().is_none() {
        return Err(
            "the path of the installation is not UTF-8; move it, or name another with --root"
                .into(),
        );
    }
    if !root.join("plugins").is_dir() {
        return Err(format!(
            "no plugins/ below {}; give with --root where MicroSim is installed (`cargo xtask build` makes target/microsim)",
            root.display()
        )
        .into());
    }
    let more = Places {
        plugins: place.plugins.clone(),
        modules: place.modules.clone(),
        // A folder of settings that is asked for is all that counts. A user without a home folder has no settings.
        settings: match place.config {
            Some(_) => None,
            None => Folders::of(place).ok().map(|folders| folders.config),
        },
        levels: Folders::of(place).ok().map(|folders| folders.levels()),
    };
    let mut installation = Installation::open_with(&root, place.config.as_deref(), &more)?;
    let guests = &mut installation.guests;
    guests.which = place.isolate;
    // Also where another installation is worked on: its libraries are for this host.
    guests.rules.program =
        std::env::current_exe().map_err(|e| format!("where this program lies: {e}"))?;
    installation.calibration = Folders::of(place).ok().map(|folders| folders.calibration());
    if place.no_deadline {
        (guests.rules.deadline, guests.rules.memory) = (None, None);
    }
    Ok(installation)
}

/// The folder of this program.
pub fn program_folder() -> Result<PathBuf, Problem> {
    let program = std::env::current_exe().map_err(|e| format!("where this program lies: {e}"))?;
    Ok(program.parent().map(Path::to_path_buf).unwrap_or_default())
}

/// Whether a file is a session, whatever its name.
pub fn is_session(path: &Path) -> bool {
    let mut start = [0; microsim_session::MAGIC.len()];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == *microsim_session::MAGIC
}

/// A session by a path, or by its name in the folder of sessions.
pub fn find(place: &Place, given: &Path) -> PathBuf {
    let named = || Folders::of(place).ok()?.session(given);
    let there = given.symlink_metadata().is_ok();
    let named = if there { None } else { named() };
    named.unwrap_or_else(|| given.to_path_buf())
}

/// A session file that is read tick by tick.
pub type OpenSession<'a> = SessionReader<BufReader<Watched<'a>>>;

/// Bytes that are read at a time: a few ticks, so that how far they are is how far the command is.
const AT_A_TIME: usize = 1 << 14;

/// A file with what is shown of how far it has been read.
#[derive(Debug)]
pub struct Watched<'a> {
    file: File,
    read: u64,
    length: u64,
    progress: &'a Progress,
    what: &'static str,
}

impl Read for Watched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        // What was read before has been worked on; what comes now has not.
        let part = self.read as f64 / self.length.max(1) as f64;
        self.progress.show(Some(part), || self.what.to_owned());
        let count = self.file.read(buffer)?;
        self.read += count as u64;
        Ok(count)
    }
}

/// Begins to read a session file; `what` is done with it.
pub fn open<'a>(
    path: &Path,
    progress: &'a Progress,
    what: &'static str,
) -> Result<OpenSession<'a>, Problem> {
    let named = |e: &dyn std::fmt::Display| format!("session {}: {e}", path.display());
    let file = open_regular(path).map_err(|e| named(&e))?;
    let file = Watched {
        length: file.metadata().map_or(0, |metadata| metadata.len()),
        file,
        read: 0,
        progress,
        what,
    };
    let file = BufReader::with_capacity(AT_A_TIME, file);
    Ok(SessionReader::open(file).map_err(|e| named(&e))?)
}

/// Reads a session file with all its ticks.
pub fn read(path: &Path) -> Result<Session, Problem> {
    let bytes = read_regular(path).map_err(|e| format!("session {}: {e}", path.display()))?;
    Ok(Session::read(&bytes).map_err(|e| format!("session {}: {e}", path.display()))?)
}

/// Reads a session file to its end, and keeps all but its ticks.
pub fn read_around(path: &Path) -> Result<Session, Problem> {
    let progress = Progress::new();
    let mut reader = open(path, &progress, "the session is read")?;
    while next_tick(&mut reader, path)?.is_some() {}
    Ok(reader.session().clone())
}

fn next_tick(
    reader: &mut OpenSession<'_>,
    path: &Path,
) -> Result<Option<(u64, TickRecord)>, Problem> {
    let tick = reader.next_tick();
    Ok(tick.map_err(|e| format!("session {}: {e}", path.display()))?)
}

/// The report of a session, whose ticks are read from its file.
pub fn report_of(session: &Session, path: &Path) -> Result<Report, Problem> {
    let plan = &session.header.plan;
    let tools = ToolsOfRun::new(plan);
    let mirrored = hand_of(plan).0 == DominantHand::Left;
    let input = ReportInput {
        version: session.header.version.clone(),
        started: session.header.started,
        trainee: session.header.trainee.clone(),
        module: plan.module.clone(),
        module_title: plan.module_title.clone(),
        level: plan.level,
        level_title: plan.level_title.clone(),
        level_summary: plan.level_summary.clone(),
        seed: plan.seed,
        tick_s: plan.tick_ns as f64 * 1e-9,
        input: match &session.resumed {
            None => plan.input.clone(),
            Some(checkpoint) => format!(
                "{} (from {:.3} s on; what came before is in another session)",
                plan.input,
                checkpoint.tick as f64 * plan.tick_ns as f64 * 1e-9
            ),
        },
        tools: tools.names(mirrored),
        sharp: tools.sharp(),
        bodies: body_names(plan),
        synthetic: plan.synthetic.clone(),
        mirrored,
        model_error: plan.model_error,
        changed_files: plan.changed_files.clone(),
        realtime: session.header.realtime,
        without: plan.without.clone(),
        state_hash: session
            .end
            .as_ref()
            .map(|end| microsim_host::record::hex(&end.chain)),
        complaint: complaint(session),
        failures: session.failures.iter().map(ToString::to_string).collect(),
        late_ticks: session.end.as_ref().map_or(0, |end| end.late_ticks),
        tick_times: session
            .end
            .as_ref()
            .and_then(|end| end.tick_times)
            .map(|[p50, p99, longest]| TimeSpread { p50, p99, longest }),
        session_file: path.display().to_string(),
        replay_command: format!("microsim replay {} --verify", shell_word(path)),
    };
    let mut builder = ReportBuilder::new(&input);
    let progress = Progress::new();
    let mut reader = open(path, &progress, "its report is made")?;
    while let Some((tick, record)) = next_tick(&mut reader, path)? {
        builder.add(tick, &record.log);
    }
    Ok(builder.finish())
}

/// Name of a verdict for people.
pub fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "passed",
        Verdict::Failed => "failed",
        Verdict::NotJudged => "not-judged",
        Verdict::Aborted => "aborted",
        Verdict::Incomplete => "incomplete",
    }
}

/// What is wrong with a session.
fn complaint(session: &Session) -> Option<String> {
    let altered = (session.signatures == Signatures::Broken)
        .then(|| "it was changed after it was signed".to_owned());
    let parts: Vec<String> = session
        .complaint
        .clone()
        .into_iter()
        .chain(altered)
        .collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// A path as a word of a command line.
fn shell_word(path: &Path) -> String {
    let path = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+:=@%,".contains(c);
    match path.chars().all(plain) {
        true => path,
        false => format!("'{}'", path.replace('\'', r"'\''")),
    }
}

/// What a report needs of the configuration of a run's module; sessions of earlier versions have it as well.
#[derive(Default, Deserialize)]
struct ToolsOfRun {
    tools: Vec<ToolSlot>,
    models: BTreeMap<String, ToolModel>,
}

/// What a report needs of a tool model.
#[derive(Deserialize)]
struct ToolModel {
    title: LocalText,
    sharpness: f64,
}

impl ToolsOfRun {
    /// Of a plan; none without a module.
    fn new(plan: &RunPlan) -> Self {
        let module = plan.plugins.iter().find(|p| p.kind == PluginKind::Module);
        module
            .and_then(|module| module.setup.configuration().ok())
            .unwrap_or_default()
    }

    /// The slots of tools with sharp jaws.
    fn sharp(&self) -> BTreeSet<String> {
        let is_sharp = |model: &ToolModel| model.sharpness > 0.0;
        let sharp = self
            .tools
            .iter()
            .filter(|slot| self.models.get(&slot.model).is_some_and(is_sharp));
        sharp.map(|slot| slot.name.clone()).collect()
    }

    /// What the tools are called: the titles of their models, with the slot where two have the same model, which a left-handed trainee has in the other hand.
    fn names(&self, mirrored: bool) -> BTreeMap<String, LocalText> {
        let named = self.tools.iter().filter_map(|slot| {
            let title = &self.models.get(&slot.model)?.title;
            let same = self.tools.iter().filter(|other| other.model == slot.model);
            let title = match same.count() {
                1 => title.clone(),
                _ => {
                    let hand = match slot.name.as_str() {
                        "left" if mirrored => "right",
                        "right" if mirrored => "left",
                        name => name,
                    };
                    LocalText::new(
                        format!("{} ({hand})", title.de),
                        format!("{} ({hand})", title.en),
                    )
                }
            };
            Some((slot.name.clone(), title))
        });
        named.collect()
    }
}

/// The bodies of a run.
fn body_names(plan: &RunPlan) -> Vec<String> {
    let bodies = plan.parts.iter().filter(|part| part.what == "body");
    bodies.map(|body| body.name.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::shell_word;
    use std::path::Path;

    #[test]
    fn a_path_is_one_word() {
        assert_eq!(shell_word(Path::new("a/b-1.session")), "a/b-1.session");
        assert_eq!(shell_word(Path::new("my run.session")), "'my run.session'");
        assert_eq!(shell_word(Path::new("it's")), r"'it'\''s'");
    }
}
