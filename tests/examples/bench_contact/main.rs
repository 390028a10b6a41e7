//! `cargo xtask bench contact`: what contact costs and keeps. Prints and writes `tests/results/bench_contact.md` and
//! `two_tubes.svg`.
//!
//! Scenes of `config/scenes` run by the built program with other methods and steps. CPU time is that of the steps alone.

mod level;
mod plot;
mod size;
mod tubes;
mod wall;

use std::fmt::Write as _;
use std::process::ExitCode;

/// What the sections say, and the drawing.
fn measure() -> Result<(String, String), String> {
    let mut text = String::from(
        "# Contact\n\n`cargo xtask bench contact`; two tubes, a thin wall, a vessel with two tools, cost over size. One core; times of single runs.\n",
    );
    let tubes = tubes::measure(&mut text)?;
    wall::measure(&mut text)?;
    level::measure(&mut text)?;
    size::measure(&mut text)?;
    Ok((text, tubes))
}

fn main() -> ExitCode {
    let folder = microsim_tests::repository().join("tests/results");
    let result = measure().and_then(|(text, drawing)| {
        print!("{text}");
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
        };
        write("bench_contact.md", &text)?;
        write("two_tubes.svg", &drawing)
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            let mut line = String::new();
            let _ = writeln!(line, "bench contact: {message}");
            eprint!("{line}");
            ExitCode::FAILURE
        }
    }
}
