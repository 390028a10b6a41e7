//! `cargo xtask soak levels [-- MODULE...]`: a picture of each level, which the window shows beside it. Writes `modules/NAME/pictures/level<N>.png`.
//!
//! A module's `pictures/moments.csv` has the moment of each level, in simulated seconds of its script that passes, the section of the field that is shown, as parts of the field's
//! diameter from its upper left corner, and what is seen there. The run is the same to the bit on every machine; pixels are those of the graphics driver and of ImageMagick, which
//! makes the section smaller and gives it a palette: the same driver and version give the same file.

use microsim_tests::peers::done;
use microsim_tests::{command, finish, repository, scratch, tree};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Diameter of the field as it is drawn \[pixels\].
const FIELD: u32 = 960;
/// Width and height of what is stored \[pixels\].
const SIZE: [u32; 2] = [320, 240];
/// Colours of a stored picture, all that a palette of PNG has: fewer show steps in what is lit softly.
const COLOURS: &str = "256";
/// How much longer than to its moment a level runs \[s\]: some ticks of the longest that a level has.
const AFTER: f64 = 0.1;

/// When a level looks like what it trains.
struct Moment {
    level: u32,
    /// Simulated time \[s\].
    seconds: f64,
    /// Left and upper edge and width of the section, as parts of the field's diameter.
    section: [f64; 3],
}

impl Moment {
    /// The section of a picture of the field, as ImageMagick has it.
    fn crop(&self) -> String {
        let [left, top, width] = self.section.map(|part| part * f64::from(FIELD));
        let height = width * f64::from(SIZE[1]) / f64::from(SIZE[0]);
        let [left, top, width, height] = [left, top, width, height].map(f64::round);
        format!("{width}x{height}+{left}+{top}")
    }
}

/// The moments of a module.
fn moments(file: &Path) -> Result<Vec<Moment>, String> {
    let wrong = |why: &dyn std::fmt::Display| format!("{}: {why}", file.display());
    let mut reader = csv::Reader::from_path(file).map_err(|error| wrong(&error))?;
    let moment = |row: Result<csv::StringRecord, csv::Error>| {
        let row = row.map_err(|error| wrong(&error))?;
        let number = |at: usize| {
            let text = row.get(at).unwrap_or_default().trim();
            let number: Result<f64, _> = text.parse();
            number.map_err(|error| wrong(&format!("{text:?}: {error}")))
        };
        Ok(Moment {
            level: number(0)? as u32,
            seconds: number(1)?,
            section: [number(2)?, number(3)?, number(4)?],
        })
    };
    reader.records().map(moment).collect()
}

/// Draws the moment of a level into its file.
fn draw(module: &Path, moment: &Moment) -> Result<(), String> {
    let name = module.file_name().unwrap_or_default().to_string_lossy();
    let (folder, level) = (scratch(), moment.level);
    let place = |name: &str| folder.path().join(name);
    let settings = place("config");
    fs::create_dir(&settings).map_err(|error| error.to_string())?;
    let size = format!("[picture]\nwidth = {FIELD}\nheight = {FIELD}\n");
    fs::write(settings.join("host.toml"), size).map_err(|error| error.to_string())?;
    // The first picture is of the start, the second of the moment.
    let rate = (1.0 / moment.seconds).to_string();
    let stop = (moment.seconds + AFTER).to_string();
    let number = level.to_string();
    let input = format!("script:level{level}-pass.toml");
    let mut run = command(["run", &name, "--level", &number, "--input", &input]);
    run.env("MICROSIM_DATA", folder.path());
    run.args(["--no-store", "--no-pictures", "--json"]);
    run.args(["--frame-rate", &rate, "--stop-at", &stop]);
    run.arg("--frames").arg(place("frames"));
    run.arg("--session").arg(place("a.session"));
    run.arg("--checkpoint").arg(place("a.checkpoint"));
    let finished = finish(&mut run);
    let frame = place("frames/frame-000001.png");
    if finished.code != Some(0) || !frame.is_file() {
        return Err(format!("{name}, level {level}: {finished:?}"));
    }
    let pictures = module.join("pictures");
    fs::create_dir_all(&pictures).map_err(|error| error.to_string())?;
    let file = pictures.join(format!("level{level}.png"));
    let mut smaller = Command::new("convert");
    let [width, height] = SIZE;
    smaller
        .arg(frame)
        .args(["-crop", &moment.crop(), "+repage"]);
    smaller.args([
        "-filter",
        "triangle",
        "-resize",
        &format!("{width}x{height}!"),
    ]);
    smaller.args(["-dither", "None"]);
    // Neither time nor name of the file that was read: the same picture is the same bytes.
    smaller.args(["-colors", COLOURS, "-strip"]);
    smaller.args(["-define", "png:exclude-chunks=date,time"]);
    done(smaller.arg(format!("PNG8:{}", file.display())))?;
    let length = fs::metadata(&file).map_or(0, |data| data.len());
    println!("{}: {length} bytes", file.display());
    Ok(())
}

/// Folders of the modules that state moments, or of those that are named.
fn modules(named: &[String]) -> Result<Vec<PathBuf>, String> {
    let all = repository().join("modules");
    if !named.is_empty() {
        return Ok(named.iter().map(|name| all.join(name)).collect());
    }
    let listing = fs::read_dir(&all).map_err(|error| format!("{}: {error}", all.display()))?;
    let folders = listing.flatten().map(|entry| entry.path());
    let mut modules: Vec<PathBuf> = folders.filter(|folder| file_of(folder).is_file()).collect();
    modules.sort();
    Ok(modules)
}

fn file_of(module: &Path) -> PathBuf {
    module.join("pictures/moments.csv")
}

fn all(named: &[String]) -> Result<(), String> {
    assert!(tree().exists(), "the assembled tree");
    for module in modules(named)? {
        for moment in moments(&file_of(&module))? {
            draw(&module, &moment)?;
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let named: Vec<String> = std::env::args().skip(1).collect();
    match all(&named) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("soak levels: {why}");
            ExitCode::FAILURE
        }
    }
}
