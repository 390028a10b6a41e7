//! `microsim trainees erase` and `anonymise`.

use crate::cli::{Place, TraineeGoneArgs};
use crate::date;
use crate::folders::Folders;
use crate::names::name_or_id;
use crate::output::{Exit, Problem, print, print_json};
use crate::progress::Progress;
use crate::records::{find, open, text};
use crate::session_file::{is_session, open as open_session};
use crate::sessions::{VIDEO, files_beside, films_beside, sessions_below};
use microsim_settings::unwritable;
use microsim_store::{Filter, Id, Store, Trainee};
use serde_json::json;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// What is there of a trainee.
pub struct Belongings {
    /// Number of sessions in the store.
    pub sessions: usize,
    /// Files that go.
    pub files: BTreeSet<PathBuf>,
    /// Sessions of earlier versions, which hold the name themselves.
    with_name: Vec<PathBuf>,
}

/// The header of a session file names this trainee.
fn is_of(path: &Path, trainee: &Trainee) -> Option<bool> {
    if !is_session(path) {
        return None;
    }
    let progress = Progress::new();
    let session = open_session(path, &progress, "reading the session").ok()?;
    let held = session.session().header.trainee.as_deref()?;
    let is_name = trainee.name.as_deref() == Some(held);
    (is_name || Id::parse(held) == Some(trainee.id)).then_some(is_name)
}

/// Looks for all that is there of a trainee.
pub fn belongings(place: &Place, store: &Store, trainee: &Trainee) -> Result<Belongings, Problem> {
    let filter = Filter {
        trainee: Some(trainee.id),
        ..Filter::default()
    };
    let sessions = store.results(&filter, false)?;
    let mut found = Belongings {
        sessions: sessions.len(),
        files: BTreeSet::new(),
        with_name: Vec::new(),
    };
    let mut take = |path: &Path| {
        let of = is_of(path, trainee);
        if of == Some(true) {
            found.with_name.push(path.to_path_buf());
        }
        // Where another session lies now, nothing is of this trainee; where none does, reports may be left.
        if of.is_some() || !path.exists() {
            let beside = files_beside(path);
            let all = std::iter::once(path.to_path_buf()).chain(beside);
            for file in all.filter(|file| file.is_file()) {
                // Not what a report of somebody else has replaced since.
                if !store.is_of_another(&text(&file), trainee.id)? {
                    found.files.insert(file);
                }
            }
            for film in films_beside(path) {
                found.files.extend(pictures_in(&film));
                let video = film.join(VIDEO);
                found.files.extend(video.is_file().then_some(video));
            }
        }
        Ok::<(), Problem>(())
    };
    let known: BTreeSet<PathBuf> = sessions
        .iter()
        .map(|s| PathBuf::from(&s.session.path))
        .collect();
    known.iter().try_for_each(|path| take(path))?;
    let folder = Folders::of(place)?.sessions();
    for path in sessions_below(&folder) {
        if !known.contains(&path) && is_of(&path, trainee).is_some() {
            take(&path)?;
        }
    }
    for named in &sessions {
        for file in store.attached(named.session.id)? {
            let file = PathBuf::from(file);
            match file.is_dir() {
                // A folder of pictures: they alone are ours.
                true => found.files.extend(pictures_in(&file)),
                false => found.files.extend(file.is_file().then_some(file)),
            }
        }
    }
    Ok(found)
}

/// The pictures that runs and replays draw.
fn pictures_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    let is_picture = |path: &PathBuf| {
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        name.starts_with("frame-") && name.ends_with(".png") && path.is_file()
    };
    paths.filter(is_picture).collect()
}

/// Removes a trainee with these belongings, and copies of the store of earlier versions.
pub fn remove(store: &mut Store, trainee: &Trainee, found: &Belongings) -> Result<(), Problem> {
    // Files first: should this end in between, the rows still show what is left.
    for file in found.files.iter().chain(&store.copies()) {
        fs::remove_file(file).map_err(|e| unwritable(file, e))?;
        if let Some(folder) = file.parent() {
            // Only an empty one goes, and only of pictures.
            let is_picture = file.extension().is_some_and(|e| e == "png");
            let _ = is_picture.then(|| fs::remove_dir(folder));
        }
    }
    Ok(store.erase(trainee.id, date::now(), found.files.len() as i64)?)
}

/// Removes the name of a trainee, and copies of the store of earlier versions.
pub fn remove_name(store: &mut Store, trainee: &Trainee) -> Result<(), Problem> {
    for file in &store.copies() {
        fs::remove_file(file).map_err(|e| unwritable(file, e))?;
    }
    Ok(store.anonymise(trainee.id, date::now())?)
}

/// `microsim trainees erase`.
pub fn erase(place: &Place, args: &TraineeGoneArgs) -> Result<Exit, Problem> {
    let mut store = open(place)?;
    let trainee = find(&store, &args.who)?;
    let found = belongings(place, &store, &trainee)?;
    let copies = store.copies();
    if args.yes {
        remove(&mut store, &trainee, &found)?;
    }
    if args.json {
        print_json(&json!({
            "erased": args.yes,
            "sessions": found.sessions,
            "files": found.files,
            "copies": copies,
        }))?;
        return Ok(Exit::Done);
    }
    for file in found.files.iter().chain(&copies) {
        print(format!("  {}", file.display()))?;
    }
    let who = name_or_id(trainee.name.as_deref(), Some(trainee.id));
    let (sessions, files) = (found.sessions, found.files.len() + copies.len());
    match args.yes {
        true => print(format!(
            "{who} is erased: {sessions} sessions in the store and these {files} files are gone. Exports and backups made before are files of their own"
        ))?,
        false => print(format!(
            "Nothing is removed yet. With --yes {who}, {sessions} sessions in the store and these {files} files go"
        ))?,
    }
    Ok(Exit::Done)
}

/// `microsim trainees anonymise`.
pub fn anonymise(place: &Place, args: &TraineeGoneArgs) -> Result<Exit, Problem> {
    let mut store = open(place)?;
    let trainee = find(&store, &args.who)?;
    let found = belongings(place, &store, &trainee)?;
    let copies = store.copies();
    if args.yes {
        remove_name(&mut store, &trainee)?;
    }
    if args.json {
        print_json(&json!({
            "anonymised": args.yes,
            "id": trainee.id,
            "sessions": found.sessions,
            "sessions_with_name": found.with_name,
            "copies": copies,
        }))?;
        return Ok(Exit::Done);
    }
    match args.yes {
        true => print(format!(
            "The name is gone; {} and {} sessions stay",
            trainee.id, found.sessions
        ))?,
        false => print(format!(
            "Nothing is removed yet. With --yes the name goes; {} and {} sessions stay",
            trainee.id, found.sessions
        ))?,
    }
    for copy in &copies {
        print(format!(
            "  a copy of an earlier version holds it as well: {}",
            copy.display()
        ))?;
    }
    for path in &found.with_name {
        print(format!(
            "  recorded by an earlier version and signed, so it holds the name and has to be erased to lose it: {}",
            path.display()
        ))?;
    }
    Ok(Exit::Done)
}
