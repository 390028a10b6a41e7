//! Writes the models of instruments as glTF files (`.glb`): those of the tools in a folder, and the other kinds in sizes of their own.
//!
//! ```sh
//! cargo run --release -p microsim-render --example instruments -- config/tools instruments
//! ```
//!
//! What the nodes are, which axis is up and how jaws are opened: `microsim_render::instrument_file`.

use microsim_render::instrument_file;
use microsim_render::instruments::{Instrument, Kind, Sizes};
use microsim_settings::{Tool, load_tool};
use std::path::Path;
use std::process::ExitCode;

/// Kinds that no tool has yet, with the sizes of straight forceps and the angle between open jaws \[rad\].
const OTHERS: [(&str, f64); 3] = [
    ("forceps-angled", 0.21),
    ("needle-holder", 0.35),
    ("double-clamp", 0.35),
];
const SIZES: Sizes = Sizes {
    pivot: 18e-3,
    tip: 0.125e-3,
};
/// Of steel, sRGB.
const STEEL: [f32; 3] = [0.83, 0.85, 0.86];

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (Some(tools), Some(folder)) = (arguments.next(), arguments.next()) else {
        eprintln!("which folders? TOOLS, with a TOML file of each, and that to write to");
        return ExitCode::from(2);
    };
    match export(Path::new(&tools), Path::new(&folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::from(2)
        }
    }
}

fn export(tools: &Path, folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let entries = std::fs::read_dir(tools).map_err(|e| format!("{}: {e}", tools.display()))?;
    let mut files: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    files.sort();
    let mut written = Vec::new();
    for path in files {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let tool: Tool = load_tool(&path).map_err(|e| e.to_string())?.settings;
        let Some(sizes) = Sizes::of_tool(&tool) else {
            println!("{name}: without jaws, and drawn as its capsules");
            continue;
        };
        let colour = tool.colour.srgb().map(|part| part as f32);
        let angle = tool.opening_angle.unwrap_or_default();
        write(folder, &name, (sizes, angle, colour))?;
        written.push(name.into_owned());
    }
    for (name, angle) in OTHERS {
        if !written.iter().any(|known| known == name) {
            write(folder, name, (SIZES, angle, STEEL))?;
        }
    }
    Ok(())
}

fn write(folder: &Path, name: &str, of: (Sizes, f64, [f32; 3])) -> Result<(), String> {
    let (sizes, angle, colour) = of;
    let Some(kind) = Kind::of_tool(name) else {
        println!("{name}: no model of it, it is drawn as its capsules");
        return Ok(());
    };
    let instrument = Instrument::of(kind, sizes);
    let bytes = instrument_file::write(&instrument, sizes, angle, colour);
    let file = folder.join(name).with_extension("glb");
    std::fs::write(&file, &bytes).map_err(|e| format!("{}: {e}", file.display()))?;
    println!("{}: {} bytes", file.display(), bytes.len());
    Ok(())
}
