//! `cargo xtask bench dissertation`: figures and numbers of the dissertation (Sismanidis 2015), with its own methods and with ours. Prints and writes
//! `tests/results/dissertation.md` and drawings beside it.
//!
//! `cargo xtask bench dissertation -- broad-phase` prints single sections.
//!
//! Here is what has a section of its own: meshes (its 3.3), springs (3.4, 4.1, 4.2), change of topology (3.7, 4.2.1), broad phase and response of contact (4.3), levels in the
//! variant `dissertation`.

mod broad_phase;
mod failures;
mod five_bodies;
mod meshes;
mod overview;
mod plot;
mod response;
mod springs;
mod topology;
mod variant;

use std::process::ExitCode;

/// Files of a section beside the page: names and bytes.
type Drawings = Vec<(&'static str, Vec<u8>)>;

/// A section: its name and what measures it.
type Section = (&'static str, fn(&mut String) -> Result<Drawings, String>);

const SECTIONS: [Section; 9] = [
    ("overview", overview::list),
    ("failures", failures::run),
    ("meshes", meshes::measure),
    ("springs", springs::measure),
    ("topology", topology::measure),
    ("broad-phase", broad_phase::measure),
    ("response", response::measure),
    ("five-bodies", five_bodies::draw),
    ("variant", variant::measure),
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
    let write = |path: &std::path::Path, text: &[u8]| {
        std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
    };
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for (name, drawing) in drawings {
        write(&folder.join(name), &drawing)?;
    }
    write(&results.join("dissertation.md"), text.as_bytes())
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
