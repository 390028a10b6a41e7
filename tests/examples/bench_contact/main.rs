//! `cargo xtask bench contact`: what contact costs and keeps. Prints and writes `tests/results/bench_contact.md` and
//! `two_tubes.svg`.
//!
//! `cargo xtask bench contact -- size` prints single sections: tubes, wall, level, size.
//!
//! Scenes of `config/scenes` run by the built program with other methods and steps. CPU time is that of the steps alone.

mod level;
mod plot;
mod size;
mod tubes;
mod wall;

use std::process::ExitCode;

/// A section: its name and what measures it; some come with a drawing.
type Section = (
    &'static str,
    fn(&mut String) -> Result<Option<String>, String>,
);

const SECTIONS: [Section; 4] = [
    ("tubes", |text| tubes::measure(text).map(Some)),
    ("wall", |text| wall::measure(text).map(|()| None)),
    ("level", |text| level::measure(text).map(|()| None)),
    ("size", |text| size::measure(text).map(|()| None)),
];

/// Measures the sections of these names, or all of them, and prints them. Only all together are written to a file.
fn measure(names: &[String]) -> Result<(), String> {
    let known = |name: &&String| SECTIONS.iter().all(|(section, _)| section != name);
    if let Some(unknown) = names.iter().find(known) {
        let all = SECTIONS.map(|(name, _)| name).join(", ");
        return Err(format!(
            "there is no section \"{unknown}\"; there are: {all}"
        ));
    }
    let mut text = String::from(
        "# Contact\n\n`cargo xtask bench contact`; two tubes, a thin wall, a vessel with two tools, cost over size. One core; times of single runs.\n",
    );
    let mut drawing = None;
    for (name, section) in SECTIONS {
        if names.is_empty() || names.iter().any(|n| n == name) {
            drawing = section(&mut text)?.or(drawing);
        }
    }
    print!("{text}");
    if !names.is_empty() {
        return Ok(());
    }
    let folder = microsim_tests::repository().join("tests/results");
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
    };
    write("bench_contact.md", &text)?;
    write("two_tubes.svg", &drawing.unwrap_or_default())
}

fn main() -> ExitCode {
    let names: Vec<String> = std::env::args().skip(1).collect();
    match measure(&names) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("bench contact: {message}");
            ExitCode::FAILURE
        }
    }
}
