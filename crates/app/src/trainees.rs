//! `microsim trainees`, but for what removes data.

use crate::cli::{
    GroupArgs, Place, TraineeAddArgs, TraineeExportArgs, TraineeListArgs, TraineesCommand,
};
use crate::date;
use crate::erasure::{anonymise, erase};
use crate::names::{name_or_id, shown};
use crate::output::{Exit, Problem, print, print_json};
use crate::records::{find, must_read, new_id, open};
use crate::replace_file::write_new;
use crate::result_table;
use crate::sessions::files_beside;
use microsim_settings::unwritable;
use microsim_store::{Filter, ListedTrainee, Store, Trainee};
use microsim_table::Format;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Does what was asked of trainees.
pub fn trainees(place: &Place, command: &TraineesCommand) -> Result<Exit, Problem> {
    match command {
        TraineesCommand::List(args) => list(place, args),
        TraineesCommand::Add(args) => add(place, args),
        TraineesCommand::Rename(args) => {
            let mut store = open(place)?;
            let trainee = find(&store, &args.who)?;
            store.rename(trainee.id, &args.name)?;
            let trainee = Trainee {
                name: Some(args.name.clone()),
                ..trainee
            };
            stated(&trainee, args.json)
        }
        TraineesCommand::Role(args) => {
            let mut store = open(place)?;
            let trainee = find(&store, &args.who)?;
            store.set_role(trainee.id, args.role)?;
            let trainee = Trainee {
                role: args.role,
                ..trainee
            };
            stated(&trainee, args.json)
        }
        TraineesCommand::Group(args) => group(place, args),
        TraineesCommand::Export(args) => export(place, args),
        TraineesCommand::Erase(args) => erase(place, args),
        TraineesCommand::Anonymise(args) => anonymise(place, args),
    }
}

/// A trainee as JSON.
fn document(trainee: &Trainee) -> Value {
    json!({
        "id": trainee.id,
        "name": trainee.name,
        "role": trainee.role.name(),
        "created": date::iso(trainee.created),
    })
}

/// Prints a trainee.
fn stated(trainee: &Trainee, as_json: bool) -> Result<Exit, Problem> {
    if as_json {
        print_json(&document(trainee))?;
    } else {
        let name = name_or_id(trainee.name.as_deref(), Some(trainee.id));
        print(format!(
            "{}  {:<10}  {name}",
            trainee.id,
            trainee.role.name()
        ))?;
    }
    Ok(Exit::Done)
}

fn add(place: &Place, args: &TraineeAddArgs) -> Result<Exit, Problem> {
    let mut store = open(place)?;
    let trainee = Trainee {
        id: new_id()?,
        name: Some(args.name.clone()),
        role: args.role,
        created: date::now(),
    };
    store.add_trainee(&trainee)?;
    for group in &args.group {
        store.change_group(group, &[trainee.id], &[])?;
    }
    stated(&trainee, args.json)
}

fn list(place: &Place, args: &TraineeListArgs) -> Result<Exit, Problem> {
    let store = must_read(place)?;
    if let Some(group) = &args.group {
        store.must_be_group(group)?;
    }
    listed(&store, args.group.as_deref(), args.json)
}

fn listed(store: &Store, group: Option<&str>, as_json: bool) -> Result<Exit, Problem> {
    let trainees = store.trainees(group)?;
    if as_json {
        let entry = |listed: &ListedTrainee| {
            let mut entry = document(&listed.trainee);
            entry["groups"] = json!(listed.groups);
            entry["sessions"] = json!(listed.sessions);
            entry["last"] = json!(listed.last.map(date::iso));
            entry
        };
        let trainees: Vec<Value> = trainees.iter().map(entry).collect();
        print_json(&json!({ "trainees": trainees }))?;
        return Ok(Exit::Done);
    }
    for listed in &trainees {
        let trainee = &listed.trainee;
        let groups: Vec<String> = listed.groups.iter().map(|g| shown(g)).collect();
        let groups = match groups.is_empty() {
            true => String::new(),
            false => format!("  [{}]", groups.join(", ")),
        };
        print(format!(
            "{}  {:<10}  {:>4} sessions  {:<16}  {}{groups}",
            trainee.id,
            trainee.role.name(),
            listed.sessions,
            listed.last.map_or_else(|| "–".into(), date::shown),
            name_or_id(trainee.name.as_deref(), None),
        ))?;
    }
    Ok(Exit::Done)
}

fn group(place: &Place, args: &GroupArgs) -> Result<Exit, Problem> {
    let store = match args.add.is_empty() && args.remove.is_empty() {
        true => {
            let store = must_read(place)?;
            store.must_be_group(&args.group)?;
            store
        }
        false => {
            let mut store = open(place)?;
            let ids = |store: &Store, all: &[String]| {
                let ids = all.iter().map(|who| Ok(find(store, who)?.id));
                ids.collect::<Result<Vec<_>, Problem>>()
            };
            let (add, remove) = (ids(&store, &args.add)?, ids(&store, &args.remove)?);
            store.change_group(&args.group, &add, &remove)?;
            store
        }
    };
    listed(&store, Some(&args.group), args.json)
}

/// Writes all that is stored of a trainee into a new folder.
fn export(place: &Place, args: &TraineeExportArgs) -> Result<Exit, Problem> {
    let store = must_read(place)?;
    let trainee = find(&store, &args.who)?;
    let (document, losses) = store.export();
    let document = document.of_trainee(trainee.id);
    std::fs::create_dir(&args.folder).map_err(|e| unwritable(&args.folder, e))?;
    let rows = serde_json::to_vec_pretty(&document)?;
    write_new(&args.folder.join("trainee.json"), &rows)?;
    let filter = Filter {
        trainee: Some(trainee.id),
        ..Filter::default()
    };
    let results = args.folder.join("results.csv");
    result_table::write(&store, &filter, true, Format::Csv, &results)?;
    let sessions = args.folder.join("sessions");
    std::fs::create_dir(&sessions).map_err(|e| unwritable(&sessions, e))?;
    let (mut copied, mut missing) = (Vec::new(), Vec::new());
    for entry in &document.sessions {
        let file = Path::new(&entry.session.path);
        // Names of two folders may be the same.
        let folder = sessions.join(entry.session.id.to_string());
        std::fs::create_dir(&folder).map_err(|e| unwritable(&folder, e))?;
        let beside = files_beside(file);
        let others = entry.files.iter().map(PathBuf::from);
        for path in std::iter::once(file.to_path_buf())
            .chain(beside)
            .chain(others)
        {
            let name = path.file_name().unwrap_or_default();
            if path.is_file() {
                let to = folder.join(name);
                std::fs::copy(&path, &to).map_err(|e| unwritable(&to, e))?;
                copied.push(to);
            } else if path == file {
                missing.push(path);
            }
        }
    }
    if args.json {
        print_json(&json!({
            "trainee": trainee.id,
            "folder": args.folder,
            "sessions": document.sessions.len(),
            "files": copied,
            "missing": missing,
            "unreadable": losses,
        }))?;
        return Ok(Exit::Done);
    }
    print(format!(
        "{} sessions and {} files of {} are in {}",
        document.sessions.len(),
        copied.len(),
        name_or_id(trainee.name.as_deref(), Some(trainee.id)),
        args.folder.display()
    ))?;
    for path in missing {
        print(format!("  no longer there: {}", path.display()))?;
    }
    for loss in losses {
        print(format!("  {loss}"))?;
    }
    Ok(Exit::Done)
}
