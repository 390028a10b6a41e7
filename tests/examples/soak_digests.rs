//! `cargo xtask soak digests`: the physics digest of every shipped script and scene, compared with the recorded ones in
//! `tests/results/digests.csv`.
//!
//! A script that passes or fails otherwise than its name states is a fault.
//!
//! `-- --record` writes that file instead of comparing; `-- PREFIX` takes only what begins with PREFIX (`scenes/cut`, `coordination/level4`).

use microsim_tests::digests::{Row, all, file, from_csv, to_csv};
use microsim_tests::scratch;
use std::process::ExitCode;
use std::sync::Mutex;

/// Runs at the same time.
const WORKERS: usize = 2;

fn main() -> ExitCode {
    let mut args: Vec<String> = std::env::args().skip(1).collect();
    let record = args.iter().any(|arg| arg == "--record");
    args.retain(|arg| arg != "--record");
    let wanted =
        |name: &str| args.is_empty() || args.iter().any(|arg| name.starts_with(arg.as_str()));
    let mut subjects = all();
    subjects.retain(|subject| wanted(&subject.name()));
    subjects.reverse();

    let folder = scratch();
    let recorded = std::fs::read_to_string(file()).unwrap_or_default();
    let recorded = match (from_csv(&recorded), record) {
        (Ok(rows), _) => rows,
        (Err(_), true) => Vec::new(),
        (Err(line), false) => {
            eprintln!("{}, line {line}: not a row of digests", file().display());
            return ExitCode::from(2);
        }
    };
    let open = Mutex::new(subjects);
    let rows = Mutex::new(Vec::<Row>::new());
    let work = || {
        while let Some(subject) = { open.lock().expect("no panic").pop() } {
            let start = std::time::Instant::now();
            let row = subject.run(folder.path(), 1);
            let last = recorded.iter().find(|last| last.subject == subject);
            let found = match last {
                _ if !row.is_as_named() => "NOT WHAT ITS NAME STATES",
                None => "new",
                Some(last) if last.physics_digest != row.physics_digest => "PHYSICS CHANGED",
                Some(last) if last.result != row.result => "RESULT CHANGED",
                Some(last) if last.state_hash != row.state_hash => "same physics, other state hash",
                Some(_) => "same",
            };
            let seconds = start.elapsed().as_secs_f64();
            println!(
                "{:<48} {seconds:7.1} s  {:<24} {found}",
                subject.name(),
                row.result
            );
            rows.lock().expect("no panic").push(row);
        }
    };
    std::thread::scope(|scope| {
        (0..WORKERS).for_each(|_| {
            scope.spawn(work);
        });
    });
    let mut rows = rows.into_inner().expect("no panic");
    let misnamed = rows.iter().filter(|row| !row.is_as_named()).count();
    let changed = rows.iter().filter(|row| {
        let last = recorded.iter().find(|last| last.subject == row.subject);
        last.is_none_or(|last| {
            (&last.physics_digest, &last.result) != (&row.physics_digest, &row.result)
        })
    });
    let changed = changed.count();
    println!(
        "{} runs, {changed} without the recorded physics or result, {misnamed} that pass or fail otherwise than their name states",
        rows.len()
    );
    if record {
        rows.extend(
            recorded
                .into_iter()
                .filter(|row| !wanted(&row.subject.name())),
        );
        rows.sort_by(|a, b| a.subject.cmp(&b.subject));
        std::fs::write(file(), to_csv(&rows)).expect("tests/results can be written");
    }
    if misnamed > 0 || (changed > 0 && !record) {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    }
}
