//! `cargo xtask bench dissertation`: figures and numbers of the dissertation (Sismanidis 2015), with its own methods and with ours. Prints and writes
//! `tests/results/dissertation.md` and drawings beside it.
//!
//! `cargo xtask bench dissertation -- broad-phase` prints single sections.
//!
//! Here is what has a section of its own: broad phase and response of contact (its section 4.3). Forces, integrators and cutting as printed are not here yet.

mod broad_phase;
mod plot;
mod response;

use std::process::ExitCode;

/// A section: its name and what measures it, with the names of its drawings.
type Section = (
    &'static str,
    fn(&mut String) -> Result<Vec<(&'static str, String)>, String>,
);

const SECTIONS: [Section; 2] = [
    ("broad-phase", broad_phase::measure),
    ("response", response::measure),
];

/// Measures the sections of these names, or all of them, and prints them. Only all together are written to files.
fn measure(names: &[String]) -> Result<(), String> {
    let known = |name: &&String| SECTIONS.iter().all(|(section, _)| section != name);
    if let Some(unknown) = names.iter().find(known) {
        let all = SECTIONS.map(|(name, _)| name).join(", ");
        return Err(format!(
            "there is no section \"{unknown}\"; there are: {all}"
        ));
    }
    let mut text = String::from(
        "# The dissertation's methods\n\n`cargo xtask bench dissertation`. One core, CPU times of single runs; p50 and p99 are over the positions of a passage.\n",
    );
    let mut drawings = Vec::new();
    for (name, section) in SECTIONS {
        if names.is_empty() || names.iter().any(|n| n == name) {
            drawings.extend(section(&mut text)?);
        }
    }
    print!("{text}");
    if !names.is_empty() {
        return Ok(());
    }
    let results = microsim_tests::repository().join("tests/results");
    let folder = results.join("dissertation");
    let write = |path: &std::path::Path, text: &str| {
        std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
    };
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for (name, drawing) in drawings {
        write(&folder.join(name), &drawing)?;
    }
    write(&results.join("dissertation.md"), &text)
}

fn main() -> ExitCode {
    let names: Vec<String> = std::env::args().skip(1).collect();
    match measure(&names) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("bench dissertation: {message}");
            ExitCode::FAILURE
        }
    }
}
