//! `microsim store`.

use crate::cli::{Place, RebuildArgs, StoreCommand, StoreFileArgs};
use crate::output::{Exit, Problem, complain, print, print_json};
use crate::progress::Progress;
use crate::records::open;
use crate::upkeep::{self, Checked, Taken};
use serde_json::json;
use std::path::Path;

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

fn export(place: &Place, args: &StoreFileArgs) -> Result<Exit, Problem> {
    let exported = upkeep::export(place, &args.file)?;
    if args.json {
        print_json(&json!({
            "file": args.file,
            "trainees": exported.trainees,
            "courses": exported.courses,
            "sessions": exported.sessions,
            "unreadable": exported.losses,
        }))?;
    } else {
        print(format!(
            "{} trainees, {} courses and {} sessions are in {}",
            exported.trainees,
            exported.courses,
            exported.sessions,
            args.file.display()
        ))?;
        for loss in &exported.losses {
            print(format!("  {loss}"))?;
        }
    }
    Ok(if exported.losses.is_empty() {
        Exit::Done
    } else {
        Exit::Negative
    })
}

fn import(place: &Place, args: &StoreFileArgs) -> Result<Exit, Problem> {
    match (upkeep::import(place, &args.file)?, args.json) {
        (Taken::Populations(count), true) => print_json(&json!({ "populations": count }))?,
        (Taken::Populations(count), false) => {
            print(format!("{count} populations are in the store"))?;
        }
        (Taken::Export(imported), true) => print_json(&json!(imported))?,
        (Taken::Export(imported), false) => print(format!(
            "Added: {} trainees, {} courses, {} populations, {} sessions; what was there is as it was",
            imported.trainees, imported.courses, imported.populations, imported.sessions
        ))?,
    }
    Ok(Exit::Done)
}

fn check(place: &Place, as_json: bool) -> Result<Exit, Problem> {
    let Checked {
        path,
        version,
        problems,
    } = upkeep::check(place)?;
    if as_json {
        print_json(&json!({ "file": path, "version": version, "problems": problems }))?;
    } else if problems.is_empty() {
        let version = version.map_or(String::new(), |version| format!(" (version {version})"));
        print(format!("{} is intact{version}", path.display()))?;
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

fn rebuild(place: &Place, args: &RebuildArgs) -> Result<Exit, Problem> {
    let progress = Progress::new();
    let rebuilt = upkeep::rebuild(
        place,
        &args.folders,
        &mut |part, file| progress.show(Some(part), || format!("reading {}", file.display())),
        &mut |note| {
            progress.clear();
            complain(note);
        },
    )?;
    drop(progress);
    if args.json {
        print_json(&json!({
            "sessions": rebuilt.sessions,
            "unfinished": rebuilt.unfinished,
            "without_file": rebuilt.without_file,
            "left_out": rebuilt.left_out,
            "running": rebuilt.running,
            "notes": rebuilt.notes,
            "put_aside": rebuilt.aside,
        }))?;
        return Ok(Exit::Done);
    }
    for note in &rebuilt.notes {
        complain(note);
    }
    print(format!(
        "{} sessions are entered as their files show them, {} of them without an end",
        rebuilt.sessions, rebuilt.unfinished
    ))?;
    let more = [
        (
            rebuilt.without_file,
            "stay as they were: their files are not there",
        ),
        (
            rebuilt.left_out as i64,
            "stay out, as they were run with --no-store",
        ),
        (
            rebuilt.running as i64,
            "are running, and enter by themselves",
        ),
    ];
    for (count, what) in more.iter().filter(|(count, _)| *count > 0) {
        print(format!("{count} {what}"))?;
    }
    Ok(Exit::Done)
}
