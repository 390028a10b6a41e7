//! Figures 4.15 and 4.16 as pictures: five bodies with each response to contact, over time.

use crate::Drawings;
use crate::response::{DURATION, settings};
use microsim_tests::repository;
use png::{BitDepth, ColorType, Decoder, Encoder};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Times of the pictures \[s\], multiples of the time between frames.
const TIMES: [f64; 4] = [0.0, 0.5, 1.0, 2.0];
const FRAME: f64 = 0.5;

/// The stiffest penalty of the table \[N/m\].
const STIFFNESS: f64 = 6000.0;

/// What is cut out of a picture \[pixel\]: left, top, width, height; and by how much it is made smaller.
const CUT: [usize; 4] = [60, 210, 840, 480];
const SMALLER: usize = 3;

/// A gap between pictures \[pixel\], and the grey of what has no picture.
const GAP: usize = 4;
const GREY: u8 = 225;

/// A row: name of its picture, title, stiffness of its penalty, keys of its contact.
struct Row {
    file: &'static str,
    title: &'static str,
    stiffness: Option<f64>,
    keys: &'static [&'static str],
}

const ROWS: [Row; 4] = [
    Row {
        file: "five_bodies_penalty.png",
        title: "penalty of 6000 N/m, nearest surface point",
        stiffness: Some(STIFFNESS),
        keys: &["response=penalty", "depth=nearest"],
    },
    Row {
        file: "five_bodies_consistent.png",
        title: "penalty of 6000 N/m, consistent depth",
        stiffness: Some(STIFFNESS),
        keys: &["response=penalty", "depth=consistent"],
    },
    Row {
        file: "five_bodies_target_force.png",
        title: "target force, consistent depth",
        stiffness: None,
        keys: &["response=target-force", "depth=consistent"],
    },
    Row {
        file: "five_bodies_constraint.png",
        title: "constraints",
        stiffness: None,
        keys: &["response=constraint"],
    },
];

/// Draws and describes it.
pub fn draw(text: &mut String) -> Result<Drawings, String> {
    let times = TIMES.map(|time| format!("{time} s")).join(", ");
    let _ = writeln!(
        text,
        "\nThe same after {times}, from left to right; grey: diverged before.\n\n| response | |\n|---|---|"
    );
    let mut drawings = Vec::new();
    for row in ROWS {
        let folder = repository().join("target").join("tmp").join(row.file);
        if folder.exists() {
            std::fs::remove_dir_all(&folder).map_err(|e| e.to_string())?;
        }
        let mut set = settings(row.stiffness, row.keys);
        set.push(format!("run.frame={FRAME}"));
        let diverged = run(&set, &folder)?;
        let lives = diverged.map_or("to its end".into(), |time| {
            format!("diverges after {time:.2} s")
        });
        let (title, file) = (row.title, row.file);
        let _ = writeln!(
            text,
            "| {title}; {lives} | ![{title}](dissertation/{file}) |"
        );
        drawings.push((file, strip(&folder, diverged.unwrap_or(DURATION))?));
    }
    Ok(drawings)
}

/// Runs the scene with pictures into `folder`; when it diverged \[s\].
fn run(set: &[String], folder: &Path) -> Result<Option<f64>, String> {
    let mut command = microsim_tests::command(["simulate", "five-bodies", "--json", "--frames"]);
    command.arg(folder);
    for set in set {
        command.args(["--set", set]);
    }
    let output = command.output().map_err(|error| error.to_string())?;
    let document: Value = serde_json::from_slice(&output.stdout)
        .map_err(|_| String::from_utf8_lossy(&output.stderr).trim().to_owned())?;
    Ok(document.pointer("/diverged/time").and_then(Value::as_f64))
}

/// The pictures beside one another, as PNG.
fn strip(folder: &Path, lives: f64) -> Result<Vec<u8>, String> {
    let [_, _, width, height] = CUT.map(|side| side / SMALLER);
    let whole = TIMES.len() * (width + GAP) - GAP;
    let mut pixels = vec![255; whole * height * 3];
    for (place, time) in TIMES.into_iter().enumerate() {
        let picture = match time <= lives {
            true => {
                let number = (time / FRAME).round() as usize;
                small(&folder.join(format!("frame-{number:06}.png")))?
            }
            false => vec![GREY; width * height * 3],
        };
        for (line, row) in picture.chunks(width * 3).enumerate() {
            let from = (line * whole + place * (width + GAP)) * 3;
            pixels[from..from + row.len()].copy_from_slice(row);
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, whole as u32, height as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer
        .write_image_data(&pixels)
        .map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// The part of a picture that is shown, each pixel the mean of those in its place.
fn small(path: &Path) -> Result<Vec<u8>, String> {
    let error = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let file = File::open(path).map_err(|e| error(&e))?;
    let mut reader = Decoder::new(BufReader::new(file))
        .read_info()
        .map_err(|e| error(&e))?;
    let size = reader
        .output_buffer_size()
        .ok_or_else(|| error(&"too large"))?;
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(|e| error(&e))?;
    let channels = info.color_type.samples();
    let [left, top, width, height] = CUT;
    if left + width > info.width as usize || top + height > info.height as usize {
        return Err(error(&"smaller than what is cut out of it"));
    }
    let mut small = Vec::with_capacity(width * height * 3 / (SMALLER * SMALLER));
    for y in 0..height / SMALLER {
        for x in 0..width / SMALLER {
            for channel in 0..3 {
                let mut sum = 0;
                for (dy, dx) in (0..SMALLER * SMALLER).map(|k| (k / SMALLER, k % SMALLER)) {
                    let line = top + y * SMALLER + dy;
                    let column = left + x * SMALLER + dx;
                    let at = (line * info.width as usize + column) * channels;
                    sum += usize::from(pixels[at + channel]);
                }
                small.push((sum / (SMALLER * SMALLER)) as u8);
            }
        }
    }
    Ok(small)
}
