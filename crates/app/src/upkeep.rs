//! What is done to the store as a whole, by command and in the window: rebuilding, checking, exports, and files that are read into it.

use crate::cli::Place;
use crate::date;
use crate::folders::Folders;
use crate::output::Problem;
use crate::population::read_populations;
use crate::records::{ReadSession, is_alive, named, open, session, with_trainees};
use crate::replace_file::replace;
use crate::session_file::installation;
use crate::sessions::sessions_below;
use microsim_settings::{Unlock, in_words, load_course, read_regular, unwritable};
use microsim_store::{Course, Document, Id, Imported, Step, Store, StoreError};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What an export has written.
pub struct Exported {
    /// Number of trainees.
    pub trainees: usize,
    /// Number of courses.
    pub courses: usize,
    /// Number of sessions.
    pub sessions: usize,
    /// What could not be read, a sentence each.
    pub losses: Vec<String>,
}

/// The store as it lies, without entering anything: what is damaged or read-only can be read as well.
fn as_it_lies(path: &Path) -> Result<Store, Problem> {
    let opened = Store::open_to_read(path).map_err(|e| named(path, &e))?;
    opened.ok_or_else(|| format!("there is no store {}", path.display()).into())
}

/// Writes all that is in the store.
pub fn export(place: &Place, file: &Path) -> Result<Exported, Problem> {
    let store = as_it_lies(&Folders::of(place)?.store())?;
    let (document, losses) = store.export();
    replace(file, &serde_json::to_vec(&document)?)?;
    Ok(Exported {
        trainees: document.trainees.len(),
        courses: document.courses.len(),
        sessions: document.sessions.len(),
        losses,
    })
}

/// What was read from a file.
pub enum Taken {
    /// So many populations.
    Populations(usize),
    /// What an export had and the store had not.
    Export(Imported),
}

/// Reads populations (`.csv`), or an export of a store, into the store.
pub fn import(place: &Place, path: &Path) -> Result<Taken, Problem> {
    let file = path.display();
    let bytes = read_regular(path).map_err(|e| format!("{file}: {e}"))?;
    if path.extension().is_some_and(|e| e == "csv") {
        let records = read_populations(&bytes).map_err(|e| format!("{file}{e}"))?;
        open(place)?.put_populations(&records)?;
        return Ok(Taken::Populations(records.len()));
    }
    let document: Document = serde_json::from_slice(&bytes)
        .map_err(|e| format!("{file}: {e}; expected what `microsim store export` writes"))?;
    Ok(Taken::Export(open(place)?.import(&document)?))
}

/// Reads a course from its file into the store; with it come levels that this installation does not have, which is no error.
pub fn take_course(place: &Place, file: &Path) -> Result<(Course, Vec<String>), Problem> {
    let settings = load_course(file)?.settings;
    let steps = settings.step.iter().map(|step| Step {
        module: step.module.clone(),
        level: step.level,
        passes: step.passes.unwrap_or(settings.passes),
    });
    let course = Course {
        name: settings.name.clone(),
        title_en: settings.title.en.to_string(),
        title_de: settings.title.de.to_string(),
        in_order: settings.unlock == Unlock::InOrder,
        steps: steps.collect(),
    };
    let mut missing = Vec::new();
    if let Ok(installation) = installation(place) {
        for step in &course.steps {
            if let Err(why) = installation.level(&step.module, step.level) {
                missing.push(format!("not in this installation: {why}"));
            }
        }
    }
    open(place)?.put_course(&course)?;
    Ok((course, missing))
}

/// What a check of the store has found.
pub struct Checked {
    /// The store.
    pub path: PathBuf,
    /// Version of its tables; `None` where they cannot be read.
    pub version: Option<i64>,
    /// What is wrong, a line each; none where it is intact.
    pub problems: Vec<String>,
}

/// The file of the store, and what is wrong with it, a sentence each.
pub fn check(place: &Place) -> Result<Checked, Problem> {
    let path = Folders::of(place)?.store();
    if !path.exists() {
        return Err(format!("there is no store {}", path.display()).into());
    }
    let checked = Store::open(&path).or_else(|error| match error {
        StoreError::ReadOnly | StoreError::CannotOpen(_) => {
            Store::open_to_read(&path)?.ok_or(error)
        }
        error => Err(error),
    });
    let found = checked.and_then(|store| Ok((Some(store.version()?), store.check()?)));
    let (version, problems) = match found {
        Ok(found) => found,
        Err(StoreError::Damaged(what)) => (None, vec![what]),
        Err(error) => return Err(named(&path, &error)),
    };
    Ok(Checked {
        path,
        version,
        problems,
    })
}

/// What a rebuild has entered.
#[derive(Default)]
pub struct Rebuilt {
    /// Number of sessions.
    pub sessions: usize,
    /// How many of them are without an end.
    pub unfinished: usize,
    /// Sessions of the store whose files are not there.
    pub without_file: i64,
    /// Left out of the store on purpose.
    pub left_out: usize,
    /// Written at this moment.
    pub running: usize,
    /// Files that cannot be read, and copies, a sentence each.
    pub notes: Vec<String>,
    /// A damaged store that was put aside.
    pub aside: Option<PathBuf>,
}

/// Reads all sessions again, those below more folders as well, and enters what they show. `part`: which part is done, and the file that is next; `note`: what of a damaged store is done and lost, which holds also if
/// the rebuild fails later.
pub fn rebuild(
    place: &Place,
    more: &[PathBuf],
    part: &mut dyn FnMut(f64, &Path),
    note: &mut dyn FnMut(String),
) -> Result<Rebuilt, Problem> {
    if let Some(missing) = more.iter().find(|folder| !folder.is_dir()) {
        return Err(format!("{}: expected a folder with sessions", missing.display()).into());
    }
    let folders = Folders::of(place)?;
    let path = folders.store();
    let (mut store, aside) = open_or_replace(&path, note)?;
    let mut rebuilt = Rebuilt {
        aside,
        ..Rebuilt::default()
    };
    let mut files: BTreeSet<PathBuf> = BTreeSet::new();
    for folder in std::iter::once(&folders.sessions()).chain(more) {
        files.extend(sessions_below(folder));
    }
    let known = store
        .session_paths()?
        .into_iter()
        .map(|(path, _)| PathBuf::from(path));
    files.extend(known.filter(|path| path.is_file()));
    let running: BTreeSet<PathBuf> = store
        .pending()?
        .iter()
        .filter(|run| is_alive(run))
        .map(|run| PathBuf::from(&run.path))
        .collect();
    let mut found: Vec<ReadSession> = Vec::new();
    let mut ids: BTreeMap<Id, (PathBuf, Option<String>)> = BTreeMap::new();
    let count = files.len();
    for (number, file) in files.into_iter().enumerate() {
        part(number as f64 / count as f64, &file);
        match session(&file) {
            Err(Problem::Text(why)) => rebuilt.notes.push(why),
            Err(problem) => return Err(problem),
            Ok(None) => rebuilt.left_out += 1,
            Ok(Some(read)) if !read.session.finished && running.contains(&file) => {
                rebuilt.running += 1;
            }
            Ok(Some(read)) => {
                let hash = read.session.state_hash.clone();
                if let Some((first, of_first)) = ids.get(&read.session.id) {
                    let what = match *of_first == hash {
                        true => "is a copy of",
                        false => "has the id of another session,",
                    };
                    let note = format!("{} {what} {}: left out", file.display(), first.display());
                    rebuilt.notes.push(note);
                    continue;
                }
                ids.insert(read.session.id, (file, hash));
                found.push(read);
            }
        }
    }
    found.sort_by_key(|read| read.session.order());
    let unfinished = found.iter().filter(|read| !read.session.finished);
    rebuilt.unfinished = unfinished.count();
    let sessions = with_trainees(&mut store, found)?;
    rebuilt.sessions = sessions.len();
    rebuilt.without_file = store.rebuild(&sessions)?;
    Ok(rebuilt)
}

/// Opens the store to change it; a damaged one is put aside, and what of it is intact taken over into a new one.
fn open_or_replace(
    path: &Path,
    note: &mut dyn FnMut(String),
) -> Result<(Store, Option<PathBuf>), Problem> {
    let opened = Store::open(path).and_then(|store| {
        let problems = store.check()?;
        match problems.is_empty() {
            true => Ok(store),
            false => Err(StoreError::Damaged(problems.join("; "))),
        }
    });
    let what = match opened {
        Ok(store) => return Ok((store, None)),
        Err(StoreError::Damaged(what)) => what,
        Err(error) => return Err(named(path, &error)),
    };
    note(format!("{} is damaged: {what}", path.display()));
    let (document, losses) = match Store::open_to_read(path) {
        Ok(Some(store)) => store.export(),
        Ok(None) => return Err(format!("{} is gone", path.display()).into()),
        Err(_) => (Document::empty(), vec!["nothing of it can be read".into()]),
    };
    let aside = put_aside(path)?;
    note(format!("it is put aside as {}", aside.display()));
    losses.into_iter().for_each(note);
    let mut store = Store::open(path).map_err(|e| named(path, &e))?;
    store.import(&document)?;
    Ok((store, Some(aside)))
}

/// Gives the file and its log another name.
fn put_aside(path: &Path) -> Result<PathBuf, Problem> {
    let with = |end: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(end);
        PathBuf::from(name)
    };
    let mut aside = with(&format!(".damaged-{}", date::now()));
    for attempt in 1.. {
        if !aside.exists() {
            break;
        }
        aside = with(&format!(".damaged-{}-{attempt}", date::now()));
    }
    for end in ["-wal", "-shm"] {
        let mut to = aside.as_os_str().to_owned();
        to.push(end);
        match std::fs::rename(with(end), to) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(unwritable(&with(end), error).into());
            }
            _ => {}
        }
    }
    std::fs::rename(path, &aside).map_err(|e| format!("{}: {}", path.display(), in_words(e)))?;
    Ok(aside)
}
