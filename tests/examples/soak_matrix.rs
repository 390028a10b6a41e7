//! `cargo xtask soak matrix [-- MODULE...]`: the script that passes each level, of these modules or of all, played without physics, friction, cutting, plasticity and the shear strength of
//! its layers, as far as the level has them. Writes `tests/results/matrix.md` if all are played.
//!
//! Ends with status 1 if one passes that should not, or one does not that is known to.

use microsim_tests::matrix::{Entry, Found, Lever, Passes, entries, passes};
use microsim_tests::{repository, scratch};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::process::ExitCode;
use std::sync::Mutex;

/// Runs at the same time, a process each.
const WORKERS: usize = 2;

const HEAD: &str = "\
# What levels are not passed without

`cargo xtask soak matrix` plays the script that passes each level without physics, without friction of tools, without cutting, with tissue that does not flow, and with layers that slide on each other
without a shear strength, as far as the level has them (`--without`; the last two are left out of the level's file). What passes all the same is **bold** where it should not: the level does not measure it. Other
verdicts have their reasons; targets reached, of all, stand behind them. *Not judged*: too many ticks had forces that mean nothing, as jaws press where nothing answers.

";

fn main() -> ExitCode {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let is_asked = |entry: &Entry| asked.is_empty() || asked.contains(&entry.module);
    let entries: Vec<Entry> = entries().into_iter().filter(is_asked).collect();
    if entries.is_empty() {
        eprintln!("none of these modules has tissue: {}", asked.join(", "));
        return ExitCode::from(2);
    }
    let found = play(entries);
    let page = page(&found);
    println!("{page}");
    let seconds: f64 = found.values().map(|of| of.seconds).sum();
    println!(
        "{} runs of {seconds:.0} s, {WORKERS} at a time",
        found.len()
    );
    if asked.is_empty() {
        let path = repository().join("tests/results/matrix.md");
        if let Err(error) = std::fs::write(&path, page) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
    }
    let mut as_expected = true;
    for (entry, found) in &found {
        let passed = found.verdict == "passed";
        if passed != passes(entry).is_some() {
            println!(
                "{}: {}, which is not what is known of it",
                entry.name(),
                found.verdict
            );
            as_expected = false;
        }
    }
    match as_expected {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}

fn play(mut entries: Vec<Entry>) -> BTreeMap<Entry, Found> {
    let folder = scratch();
    entries.reverse();
    let open = Mutex::new(entries);
    let all = Mutex::new(BTreeMap::new());
    let work = || {
        while let Some(entry) = {
            let mut open = open.lock().expect("no panic");
            open.pop()
        } {
            let found = entry.play(folder.path());
            eprintln!("{}: {found:?}", entry.name());
            all.lock().expect("no panic").insert(entry, found);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(work);
        }
    });
    all.into_inner().expect("no panic")
}

fn page(found: &BTreeMap<Entry, Found>) -> String {
    let mut page = HEAD.to_owned();
    let names = Lever::ALL.map(|lever| format!("without {}", lever.name()));
    let _ = writeln!(page, "| module | level | {} |", names.join(" | "));
    let _ = writeln!(page, "|{}", "---|".repeat(2 + names.len()));
    let mut levels: Vec<(&str, u32)> = found.keys().map(|of| (&of.module[..], of.level)).collect();
    levels.dedup();
    for (module, level) in levels {
        let cells = Lever::ALL.map(|without| {
            let entry = Entry {
                module: module.to_owned(),
                level,
                without,
            };
            match found.get(&entry) {
                None => "–".to_owned(),
                Some(found) => cell(&entry, found),
            }
        });
        let _ = writeln!(page, "| {module} | {level} | {} |", cells.join(" | "));
    }
    let known: Vec<String> = found
        .keys()
        .filter_map(|entry| {
            let Entry { module, level, .. } = entry;
            let why = match passes(entry)? {
                Passes::Unused(why) => why.to_owned(),
                Passes::Finding(why) => format!("**{why}**"),
            };
            let without = entry.without.name();
            Some(format!(
                "- {module}, level {level}, without {without}: {why}"
            ))
        })
        .collect();
    if !known.is_empty() {
        let list = known.join("\n");
        let _ = write!(page, "\nPassed all the same:\n\n{list}\n");
    }
    page
}

fn cell(entry: &Entry, found: &Found) -> String {
    let [done, all] = found.targets;
    match found.verdict.as_str() {
        "passed" if matches!(passes(entry), Some(Passes::Unused(_))) => "passed".to_owned(),
        "passed" => "**passed**".to_owned(),
        "failed" => format!("{} ({done}/{all})", found.failed.join(", ")),
        _ => format!("not judged ({done}/{all})"),
    }
}
