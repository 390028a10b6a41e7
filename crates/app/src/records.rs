//! Runs and sessions as the store has them: who trains, entering what a session shows, runs that were killed before they were entered.

use crate::cli::Place;
use crate::folders::Folders;
use crate::names::shown;
use crate::output::{Problem, complain};
use crate::session_file::{read_around, report_of, verdict_word};
use crate::sessions::files_beside;
use microsim_host::record::Session as Recorded;
use microsim_report::Report;
use microsim_store::{
    Found, Id, Measured, Metric, Pending, Session, Store, StoreError, Trainee, Verdict,
};
use std::path::{Path, PathBuf};

/// Opens the store to change it, with runs entered that were killed before they were.
pub fn open(place: &Place) -> Result<Store, Problem> {
    let path = Folders::of(place)?.store();
    let mut store = Store::open(&path).map_err(|e| named(&path, &e))?;
    catch_up(&mut store)?;
    Ok(store)
}

/// Opens the store to read it; `None` if there is none yet. Runs that were killed before they were entered are, if it can be written.
pub fn open_to_read(place: &Place) -> Result<Option<Store>, Problem> {
    let path = Folders::of(place)?.store();
    let store = Store::open_to_read(&path).map_err(|e| named(&path, &e))?;
    let Some(store) = store else {
        return Ok(None);
    };
    let pending = store.pending().map_err(|e| named(&path, &e))?;
    if pending.iter().any(|run| !is_alive(run)) {
        let entered = Store::open(&path).map_err(|e| named(&path, &e));
        let entered = entered.and_then(|mut store| catch_up(&mut store));
        if let Err(Problem::Text(why)) = entered {
            complain(format!("a run that was killed is not entered yet: {why}"));
        }
    }
    Ok(Some(store))
}

/// The store to read, or a sentence that there is none.
pub fn must_read(place: &Place) -> Result<Store, Problem> {
    let path = Folders::of(place)?.store();
    open_to_read(place)?.ok_or_else(|| {
        format!(
            "there is no store yet: the first run makes {}, and so does `microsim trainees add NAME`",
            path.display()
        )
        .into()
    })
}

/// What is wrong with the store, with its file.
pub fn named(path: &Path, error: &StoreError) -> Problem {
    match error {
        StoreError::Refused(sentence) => sentence.clone().into(),
        error => format!("{}: {error}", path.display()).into(),
    }
}

/// The trainee of a name or id.
pub fn find(store: &Store, asked: &str) -> Result<Trainee, Problem> {
    match store.find_trainee(asked)? {
        Found::One(trainee) => Ok(trainee),
        Found::Nobody(near) => {
            let mut text = format!("no trainee \"{}\" in the store", shown(asked));
            if !near.is_empty() {
                let near: Vec<_> = near.iter().map(|n| format!("\"{}\"", shown(n))).collect();
                text += &format!("; near it: {}", near.join(", "));
            }
            text += "; `microsim trainees add NAME` adds one";
            Err(text.into())
        }
    }
}

/// A new id.
pub fn new_id() -> Result<Id, Problem> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|e| format!("random numbers of the system: {e}"))?;
    Ok(Id::from_random(bytes))
}

/// A run that is about to begin, as far as the store is concerned.
pub struct Attempt<'a> {
    /// Module.
    pub module: &'a str,
    /// Level.
    pub level: u32,
    /// Name or id of the trainee.
    pub trainee: Option<&'a str>,
    /// Whether it stays out of the store.
    pub no_store: bool,
}

/// A run and its place in the store.
pub struct RunRecord {
    /// Random id of the session.
    pub id: Id,
    /// Id of the trainee.
    pub trainee: Option<Id>,
    /// Name of the trainee, if the store has one.
    pub name: Option<String>,
    /// The store; `None` if the run stays out of it.
    path: Option<PathBuf>,
    /// Why the beginning could not be noted.
    failed: Option<String>,
}

impl RunRecord {
    /// Finds the trainee and notes that the run begins. Only a name that cannot be looked up keeps it from beginning.
    pub fn begin(place: &Place, attempt: &Attempt<'_>, session: &Path) -> Result<Self, Problem> {
        let asked = attempt.trainee;
        let as_id = asked.and_then(Id::parse);
        let mut record = Self {
            id: new_id()?,
            trainee: as_id,
            name: None,
            path: None,
            failed: None,
        };
        if attempt.no_store {
            return match (asked, as_id) {
                (Some(_), None) => Err(
                    "a run that the store leaves out (--no-store, --variant) with the name of a trainee: names stand in the store; give the id that `microsim trainees list` shows"
                        .into(),
                ),
                _ => Ok(record),
            };
        }
        let noted = record.note(place, attempt, asked, session);
        match noted {
            Ok(()) => Ok(record),
            // Nobody knows whose run it would be.
            Err(problem) if asked.is_some() && record.trainee.is_none() => Err(problem),
            Err(Problem::Text(why)) => {
                record.failed = Some(why);
                Ok(record)
            }
            Err(problem) => Err(problem),
        }
    }

    fn note(
        &mut self,
        place: &Place,
        attempt: &Attempt<'_>,
        asked: Option<&str>,
        session: &Path,
    ) -> Result<(), Problem> {
        let path = Folders::of(place)?.store();
        self.path = Some(path.clone());
        let mut store = open(place)?;
        if let Some(asked) = asked {
            match (find(&store, asked), self.trainee) {
                (Ok(trainee), _) => {
                    self.trainee = Some(trainee.id);
                    self.name = trainee.name;
                    advise(&store, trainee.id, attempt)?;
                }
                // An id of another store.
                (Err(_), Some(_)) => {}
                (Err(problem), None) => return Err(problem),
            }
        }
        let (process, process_started) = this_process();
        let begun = store.begin(&Pending {
            path: text(session),
            process,
            process_started,
        });
        begun.map_err(|e| named(&path, &e))
    }

    /// Enters the session. `None`: the run stays out of the store; an error is a sentence for the operator.
    pub fn enter(
        &self,
        recorded: &Recorded,
        report: &Report,
        session: &Path,
        files: &[PathBuf],
    ) -> Option<Result<(), String>> {
        let path = self.path.as_ref()?;
        let entered = Store::open(path).and_then(|mut store| {
            let mut entry = entry(recorded, report, session);
            entry.trainee = self.trainee;
            store.enter(std::slice::from_ref(&entry))?;
            let files: Vec<String> = files.iter().map(|file| text(file)).collect();
            match files.is_empty() {
                true => Ok(()),
                false => store.attach(entry.id, &files, &beside(session)),
            }
        });
        Some(entered.map_err(|e| {
            let why = match named(path, &e) {
                Problem::Text(text) => text,
                Problem::BrokenPipe => String::new(),
            };
            // What was wrong at the beginning is the same, as a rule.
            let before = self.failed.iter().filter(|before| **before != why);
            let before: String = before.map(|before| format!(" (before: {before})")).collect();
            format!(
                "the result is not in the store: {why}{before}. Session and report are complete; `microsim store rebuild` enters it later"
            )
        }))
    }
}

/// What comes first in a course in which a level is not open yet.
pub struct ComesFirst {
    /// The course.
    pub course: String,
    /// Module of the level that is next in it.
    pub module: String,
    /// That level.
    pub level: u32,
}

/// The courses of a trainee in which a level is not open yet.
pub fn closed_courses(
    store: &Store,
    trainee: Id,
    module: &str,
    level: u32,
) -> Result<Vec<ComesFirst>, Problem> {
    let mut closed = Vec::new();
    for course in store.courses_of(trainee)? {
        let progress = store.progress(&course, trainee)?;
        let mut steps = progress.steps.iter();
        let step = steps.find(|s| s.step.module == module && s.step.level == level);
        if step.is_some_and(|step| !step.open)
            && let Some(next) = progress.next()
        {
            closed.push(ComesFirst {
                course: course.clone(),
                module: next.step.module.clone(),
                level: next.step.level,
            });
        }
    }
    Ok(closed)
}

/// Names the courses in which the level is not open yet.
fn advise(store: &Store, trainee: Id, attempt: &Attempt<'_>) -> Result<(), Problem> {
    let Attempt { module, level, .. } = *attempt;
    for first in closed_courses(store, trainee, module, level)? {
        complain(format!(
            "{module}, level {level}, is not open yet in the course {}: {}, level {}, is next. The run goes on",
            first.course, first.module, first.level
        ));
    }
    Ok(())
}

/// Enters the sessions of runs that were killed before they were entered.
fn catch_up(store: &mut Store) -> Result<(), Problem> {
    let path = store.path().to_path_buf();
    let pending = store.pending().map_err(|e| named(&path, &e))?;
    let mut gone = Vec::new();
    for run in pending.iter().filter(|run| !is_alive(run)) {
        match session(Path::new(&run.path)) {
            Ok(Some(found)) => enter_all(store, vec![found])?,
            // Left out on purpose.
            Ok(None) => gone.push(run.path.clone()),
            // Nothing that could be entered: no file, no complete header. What is there is named, as nothing else will.
            Err(problem) => {
                if let Problem::Text(why) = problem
                    && Path::new(&run.path).exists()
                {
                    complain(format!("a run that was killed is not entered: {why}"));
                }
                gone.push(run.path.clone());
            }
        }
    }
    if !gone.is_empty() {
        store.forget_pending(&gone).map_err(|e| named(&path, &e))?;
    }
    Ok(())
}

/// Whether the process of a run is still there.
pub fn is_alive(run: &Pending) -> bool {
    started_of(&run.process.to_string()) == Some(run.process_started)
}

/// Number of this process, and when it began.
fn this_process() -> (i64, i64) {
    let number = std::process::id();
    (number.into(), started_of("self").unwrap_or_default())
}

/// When a process began, in ticks of the system's clock since its start; `None` if there is no such process.
fn started_of(process: &str) -> Option<i64> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name of the program stands in brackets and may be anything; the 22nd field is the 20th behind it.
    stat.rsplit_once(')')?
        .1
        .split_whitespace()
        .nth(19)?
        .parse()
        .ok()
}

/// A session as it was read from its file, with the name that sessions of earlier versions hold.
pub struct ReadSession {
    /// The session; without a trainee if there is a name.
    pub session: Session,
    /// The name.
    pub name: Option<String>,
}

/// Reads a session for the store; `None` if it stays out of it.
pub fn session(path: &Path) -> Result<Option<ReadSession>, Problem> {
    let recorded = read_around(path)?;
    if recorded.header.unlisted {
        return Ok(None);
    }
    let report = report_of(&recorded, path)?;
    let mut session = entry(&recorded, &report, path);
    if recorded.header.id.as_deref().and_then(Id::parse).is_none() {
        let bytes = microsim_settings::read_regular(path);
        let bytes = bytes.map_err(|e| format!("session {}: {e}", path.display()))?;
        session.id = id_of(&[b"MicroSim session without an id", &bytes]);
    }
    let name = recorded.header.trainee.filter(|t| Id::parse(t).is_none());
    Ok(Some(ReadSession { session, name }))
}

/// Enters sessions; a name that one holds is that of the trainee of this name, who is added if there is none.
pub fn enter_all(store: &mut Store, sessions: Vec<ReadSession>) -> Result<(), Problem> {
    let sessions = with_trainees(store, sessions)?;
    Ok(store.enter(&sessions)?)
}

/// Sessions with the ids of the trainees whose names they hold.
pub fn with_trainees(
    store: &mut Store,
    sessions: Vec<ReadSession>,
) -> Result<Vec<Session>, Problem> {
    let mut found = Vec::new();
    for ReadSession { mut session, name } in sessions {
        if let Some(name) = name {
            session.trainee = Some(match store.find_trainee(&name)? {
                Found::One(trainee) => trainee.id,
                Found::Nobody(_) => {
                    // The same name has the same id wherever sessions are read again.
                    let id = id_of(&[
                        b"MicroSim trainee of a session without an id",
                        name.as_bytes(),
                    ]);
                    store.add_trainee(&Trainee {
                        id,
                        name: Some(name),
                        role: microsim_store::Role::Trainee,
                        created: session.started,
                    })?;
                    id
                }
            });
        }
        found.push(session);
    }
    Ok(found)
}

/// An id that is a digest.
fn id_of(parts: &[&[u8]]) -> Id {
    let digest = microsim_session::digest(parts.iter().copied());
    let mut bytes = [0; 16];
    bytes.copy_from_slice(&digest[..16]);
    Id::from_random(bytes)
}

/// A session and its report as the store has them.
fn entry(recorded: &Recorded, report: &Report, path: &Path) -> Session {
    let header = &recorded.header;
    let plan = &header.plan;
    let metrics = report.metrics.iter().map(|entry| {
        let record = &entry.record;
        let limit = record.limit.as_ref();
        Measured {
            metric: Metric {
                id: record.id.clone(),
                title: record.title.en.to_string(),
                unit: record.unit.clone(),
                display_unit: record.display_unit.clone(),
                display_factor: record.display_factor,
                direction: record.direction.clone(),
                category: record.category.clone(),
                formula: record.formula.clone(),
            }
            .into(),
            value: record.value,
            min: limit.and_then(|limit| limit.min),
            max: limit.and_then(|limit| limit.max),
            decides: limit.map(|limit| limit.decides),
            within: record.within,
            score: record.score,
        }
    });
    let mut metrics: Vec<Measured> = metrics.collect();
    metrics.sort_by(|a, b| a.metric.id.cmp(&b.metric.id));
    let categories = report.categories.iter().map(|c| (c.id.clone(), c.score));
    let mut categories: Vec<(String, f64)> = categories.collect();
    categories.sort_by(|a, b| a.0.cmp(&b.0));
    Session {
        // Of a session without one another is put in its place.
        id: header
            .id
            .as_deref()
            .and_then(Id::parse)
            .unwrap_or(Id::from_random([0; 16])),
        path: text(path),
        trainee: header.trainee.as_deref().and_then(Id::parse),
        module: plan.module.clone(),
        level: plan.level,
        started: i64::try_from(header.started).unwrap_or(i64::MAX),
        started_subsec_ns: header.started_subsec_ns,
        simulated: report.simulated,
        finished: recorded.end.is_some(),
        seed: plan.seed,
        input: plan.input.clone(),
        version: header.version.clone(),
        realtime: header.realtime,
        synthetic: plan.synthetic.clone(),
        state_hash: report.session.state_hash.clone(),
        verdict: Verdict::from_name(verdict_word(report.verdict)).unwrap_or(Verdict::Incomplete),
        counts: report.counts,
        failed: report.failed.clone(),
        duration: report.duration,
        targets_done: report.targets_done,
        targets: report.targets,
        score: report.score,
        categories,
        metrics,
    }
}

/// A path as the store has it: from the root, without links where the file is there.
pub fn text(path: &Path) -> String {
    let whole = path
        .canonicalize()
        .or_else(|_| match (path.parent(), path.file_name()) {
            (Some(folder), Some(name)) if !folder.as_os_str().is_empty() => {
                folder.canonicalize().map(|folder| folder.join(name))
            }
            (_, Some(name)) => std::env::current_dir().map(|folder| folder.join(name)),
            _ => std::path::absolute(path),
        });
    let whole = whole.unwrap_or_else(|_| path.to_path_buf());
    whole.to_string_lossy().into_owned()
}

/// Name of the trainee of a session, if the store has one; the session holds an id, or a name in earlier versions.
pub fn name_of(place: &Place, recorded: &Recorded) -> Option<String> {
    let trainee = recorded.header.trainee.as_deref()?;
    let Some(id) = Id::parse(trainee) else {
        return Some(shown(trainee));
    };
    let path = Folders::of(place).ok()?.store();
    let store = Store::open_to_read(&path).ok()??;
    let name = store.trainee(id).ok()??.name?;
    Some(shown(&name))
}

/// The files beside a session, as the store would have them.
fn beside(session: &Path) -> [String; 4] {
    files_beside(session).map(|path| text(&path))
}

/// Notes files that were made of a session, so that those that do not lie beside it go with it, and with no other whose files they have replaced. Only tried: the store may not be there.
pub fn attach(place: &Place, recorded: &Recorded, session: &Path, files: &[&Path]) {
    let id = recorded.header.id.as_deref().and_then(Id::parse);
    let (Some(id), Ok(folders)) = (id, Folders::of(place)) else {
        return;
    };
    let files: Vec<String> = files.iter().map(|path| text(path)).collect();
    if files.is_empty() || !folders.store().exists() {
        return;
    }
    let attached = Store::open(&folders.store())
        .and_then(|mut store| store.attach(id, &files, &beside(session)));
    if let Err(why) = attached {
        tracing::warn!("not noted in the store: {why}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names of verdicts in reports and in the store are the same.
    #[test]
    fn every_verdict_of_a_report_is_one_of_the_store() {
        use microsim_report::Verdict as Reported;
        for verdict in [
            Reported::Passed,
            Reported::Failed,
            Reported::NotJudged,
            Reported::Aborted,
            Reported::Incomplete,
        ] {
            let name = verdict_word(verdict);
            assert_eq!(Verdict::from_name(name).map(Verdict::name), Some(name));
        }
    }

    #[test]
    fn a_process_is_alive_by_number_and_start() {
        let (process, process_started) = this_process();
        let run = |process, process_started| Pending {
            path: String::new(),
            process,
            process_started,
        };
        assert!(process_started > 0);
        assert!(is_alive(&run(process, process_started)));
        assert!(!is_alive(&run(process, process_started + 1)));
        // No system has processes of such numbers.
        assert!(!is_alive(&run(i64::from(u32::MAX), process_started)));
    }
}
