//! `microsim store`.

use crate::cli::{Place, RebuildArgs, StoreCommand, StoreFileArgs};
use crate::date;
use crate::folders::Folders;
use crate::output::{Exit, Problem, complain, print, print_json};
use crate::population::read_populations;
use crate::records::{ReadSession, is_alive, named, open, session, with_trainees};
use crate::replace_file::replace;
use crate::sessions::sessions_below;
use microsim_settings::{in_words, read_regular, unwritable};
use microsim_store::{Document, Id, Store, StoreError, VERSION};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Does what was asked of the store.
pub fn store(place: &Place, command: &StoreCommand) -> Result<Exit, Problem> {
    match command {
        StoreCommand::Rebuild(args) => rebuild(place, args),
        StoreCommand::Export(args) => export(place, args),
        StoreCommand::Import(args) => import(place, args),
        StoreCommand::Check(args) => check(place, args.json),
        StoreCommand::Vacuum(args) => {
            let mut store = open(place)?;
            let size = |path: &Path| path.metadata().map_or(0, |file| file.len());
            let before = size(store.path());
            store.vacuum()?;
            let after = size(store.path());
            match args.json {
                true => print_json(&json!({ "bytes_before": before, "bytes": after }))?,
                false => print(format!("{before} bytes before, {after} now"))?,
            }
            Ok(Exit::Done)
        }
    }
}

/// The store as it lies, without entering anything: what is damaged or read-only can be read as well.
fn as_it_lies(path: &Path) -> Result<Store, Problem> {
    let opened = Store::open_to_read(path).map_err(|e| named(path, &e))?;
    opened.ok_or_else(|| format!("there is no store {}", path.display()).into())
}

fn export(place: &Place, args: &StoreFileArgs) -> Result<Exit, Problem> {
    let path = Folders::of(place)?.store();
    let store = as_it_lies(&path)?;
    let (document, losses) = store.export();
    replace(&args.file, &serde_json::to_vec(&document)?)?;
    if args.json {
        print_json(&json!({
            "file": args.file,
            "trainees": document.trainees.len(),
            "courses": document.courses.len(),
            "sessions": document.sessions.len(),
            "unreadable": losses,
        }))?;
    } else {
        print(format!(
            "{} trainees, {} courses and {} sessions are in {}",
            document.trainees.len(),
            document.courses.len(),
            document.sessions.len(),
            args.file.display()
        ))?;
        for loss in &losses {
            print(format!("  {loss}"))?;
        }
    }
    Ok(if losses.is_empty() {
        Exit::Done
    } else {
        Exit::Negative
    })
}

fn import(place: &Place, args: &StoreFileArgs) -> Result<Exit, Problem> {
    let file = args.file.display();
    let bytes = read_regular(&args.file).map_err(|e| format!("{file}: {e}"))?;
    if args.file.extension().is_some_and(|e| e == "csv") {
        let records = read_populations(&bytes).map_err(|e| format!("{file}{e}"))?;
        open(place)?.put_populations(&records)?;
        match args.json {
            true => print_json(&json!({ "populations": records.len() }))?,
            false => print(format!("{} populations are in the store", records.len()))?,
        }
        return Ok(Exit::Done);
    }
    let document: Document = serde_json::from_slice(&bytes)
        .map_err(|e| format!("{file}: {e}; expected what `microsim store export` writes"))?;
    let imported = open(place)?.import(&document)?;
    match args.json {
        true => print_json(&json!(imported))?,
        false => print(format!(
            "Added: {} trainees, {} courses, {} populations, {} sessions; what was there is as it was",
            imported.trainees, imported.courses, imported.populations, imported.sessions
        ))?,
    }
    Ok(Exit::Done)
}

fn check(place: &Place, as_json: bool) -> Result<Exit, Problem> {
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
    let problems = match checked.and_then(|store| store.check()) {
        Ok(problems) => problems,
        Err(StoreError::Damaged(what)) => vec![what],
        Err(error) => return Err(named(&path, &error)),
    };
    if as_json {
        print_json(&json!({ "file": path, "version": VERSION, "problems": problems }))?;
    } else if problems.is_empty() {
        print(format!("{} is intact (version {VERSION})", path.display()))?;
    } else {
        for problem in &problems {
            print(problem)?;
        }
        print(format!(
            "{} is damaged: `microsim store export FILE.json` writes what is intact, `microsim store rebuild` puts it aside and makes a new one",
            path.display()
        ))?;
    }
    Ok(if problems.is_empty() {
        Exit::Done
    } else {
        Exit::Negative
    })
}

/// What a rebuild has found.
#[derive(Default)]
struct Found {
    sessions: Vec<ReadSession>,
    /// Left out of the store on purpose.
    unlisted: usize,
    /// Written at this moment.
    running: usize,
    /// Files that cannot be read, and copies, a sentence each.
    notes: Vec<String>,
}

fn rebuild(place: &Place, args: &RebuildArgs) -> Result<Exit, Problem> {
    let folders = Folders::of(place)?;
    let path = folders.store();
    let (mut store, aside) = open_or_replace(&path)?;
    let mut files: BTreeSet<PathBuf> = BTreeSet::new();
    for folder in std::iter::once(&folders.sessions()).chain(&args.folders) {
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
    let mut found = Found::default();
    let mut ids: BTreeMap<Id, (PathBuf, Option<String>)> = BTreeMap::new();
    for file in files {
        match session(&file) {
            Err(Problem::Text(why)) => found.notes.push(why),
            Err(problem) => return Err(problem),
            Ok(None) => found.unlisted += 1,
            Ok(Some(read)) if !read.session.finished && running.contains(&file) => {
                found.running += 1;
            }
            Ok(Some(read)) => {
                let hash = read.session.state_hash.clone();
                if let Some((first, of_first)) = ids.get(&read.session.id) {
                    let what = match *of_first == hash {
                        true => "is a copy of",
                        false => "has the id of another session,",
                    };
                    let note = format!("{} {what} {}: left out", file.display(), first.display());
                    found.notes.push(note);
                    continue;
                }
                ids.insert(read.session.id, (file, hash));
                found.sessions.push(read);
            }
        }
    }
    found
        .sessions
        .sort_by_key(|read| (read.session.started, read.session.id));
    let unfinished = found
        .sessions
        .iter()
        .filter(|read| !read.session.finished)
        .count();
    let sessions = with_trainees(&mut store, found.sessions)?;
    let others = store.rebuild(&sessions)?;
    if args.json {
        print_json(&json!({
            "sessions": sessions.len(),
            "unfinished": unfinished,
            "without_file": others,
            "left_out": found.unlisted,
            "running": found.running,
            "notes": found.notes,
            "put_aside": aside,
        }))?;
        return Ok(Exit::Done);
    }
    for note in &found.notes {
        complain(note);
    }
    print(format!(
        "{} sessions are entered as their files show them, {unfinished} of them without an end",
        sessions.len()
    ))?;
    let more = [
        (others, "stay as they were: their files are not there"),
        (
            found.unlisted as i64,
            "stay out, as they were run with --no-store",
        ),
        (found.running as i64, "are running, and enter by themselves"),
    ];
    for (count, what) in more.iter().filter(|(count, _)| *count > 0) {
        print(format!("{count} {what}"))?;
    }
    Ok(Exit::Done)
}

/// Opens the store to change it; a damaged one is put aside, and what of it is intact taken over into a new one.
fn open_or_replace(path: &Path) -> Result<(Store, Option<PathBuf>), Problem> {
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
    complain(format!("{} is damaged: {what}", path.display()));
    let (document, losses) = match Store::open_to_read(path) {
        Ok(Some(store)) => store.export(),
        Ok(None) => return Err(format!("{} is gone", path.display()).into()),
        Err(_) => (Document::empty(), vec!["nothing of it can be read".into()]),
    };
    let aside = put_aside(path)?;
    complain(format!("it is put aside as {}", aside.display()));
    for loss in losses {
        complain(loss);
    }
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
