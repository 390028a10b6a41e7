//! `microsim record-input`: what an input sends, as a recording in CSV with the TOML of its columns.
//!
//! A row is a moment of the devices' clocks. A device that sent nothing at that moment has empty fields, and what is read back has no sample of it there. Numbers are written
//! with all digits that they need to come back as they were.

use crate::cli::{Place, RecordInputArgs};
use crate::listen::{Listened, listen};
use crate::output::{Exit, Problem, complain, print, print_json};
use crate::replace_file::write_new;
use crate::session_file::installation;
use microsim_message::InputSample;
use microsim_settings::recording_map_path;
use microsim_tracking::fixed_unit;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// How long a live source is recorded where nothing else is asked for \[s\].
const SECONDS: f64 = 60.0;

/// Records an input.
pub fn record_input(place: &Place, args: &RecordInputArgs) -> Result<Exit, Problem> {
    let map = recording_map_path(&args.file);
    if map == args.file {
        return Err(format!("{}: its TOML would have the same name", args.file.display()).into());
    }
    for path in [&args.file, &map] {
        if path.exists() {
            return Err(
                format!("{} exists already; nothing is overwritten", path.display()).into(),
            );
        }
    }
    let installation = installation(place)?;
    let Listened {
        samples,
        dropped,
        duration,
    } = listen(&installation, &args.listen, SECONDS)?;
    let samples: Vec<InputSample> = samples.into_iter().map(|(_, sample)| sample).collect();
    let made = Recorded::of(&samples);
    if made.devices.is_empty() {
        return Err(format!("nothing came in {duration:.1} s; no file was written").into());
    }
    for name in &made.unnamed {
        complain(format!(
            "device \"{name}\" is left out, as recordings have names of lower-case words joined by hyphens; give it one in config/openigtlink.toml"
        ));
    }
    write_new(&args.file, made.csv.as_bytes())?;
    let source = format!(
        "{}, recorded by MicroSim {}",
        args.listen.input,
        env!("CARGO_PKG_VERSION")
    );
    write_new(&map, made.map(&args.licence, &source).as_bytes())?;
    if args.json {
        print_json(&json!({
            "file": args.file, "map": map, "samples": made.samples, "rows": made.rows, "devices": made.devices,
            "left_out": made.left_out, "dropped": dropped, "listened_s": duration,
        }))?;
    } else {
        print(format!(
            "{} samples of {} in {} rows: {}",
            made.samples,
            made.devices.iter().cloned().collect::<Vec<_>>().join(", "),
            made.rows,
            args.file.display()
        ))?;
        if made.left_out > 0 {
            print(format!(
                "{} samples are left out: they have the time of another one of their device",
                made.left_out
            ))?;
        }
        if dropped > 0 {
            print(format!("{dropped} samples were dropped by the source"))?;
        }
    }
    Ok(Exit::Done)
}

/// A recording as text.
#[derive(Debug, Default)]
struct Recorded {
    csv: String,
    devices: BTreeSet<String>,
    /// Devices with names that recordings cannot have.
    unnamed: BTreeSet<String>,
    samples: usize,
    rows: usize,
    /// Samples with a time that their device had already.
    left_out: usize,
}

fn is_identifier(name: &str) -> bool {
    let words = |word: &str| {
        !word.is_empty()
            && word
                .bytes()
                .all(|b| b.is_ascii_lowercase() || b.is_ascii_digit())
    };
    name.starts_with(|c: char| c.is_ascii_lowercase()) && name.split('-').all(words)
}

impl Recorded {
    fn of(samples: &[InputSample]) -> Self {
        let mut made = Self::default();
        let mut usable: Vec<&InputSample> = Vec::new();
        for sample in samples {
            match is_identifier(&sample.device) {
                true if sample.device_time.is_finite() => usable.push(sample),
                true => made.left_out += 1,
                false => {
                    made.unnamed.insert(sample.device.clone());
                }
            }
        }
        made.devices = usable.iter().map(|sample| sample.device.clone()).collect();
        usable.sort_by(|a, b| a.device_time.total_cmp(&b.device_time));
        let mut header = vec!["time".to_owned()];
        for device in &made.devices {
            header.extend(columns(device));
        }
        let _ = writeln!(made.csv, "{}", header.join(","));
        for moment in usable.chunk_by(|a, b| a.device_time == b.device_time) {
            let mut row: BTreeMap<&str, &InputSample> = BTreeMap::new();
            for sample in moment {
                match row.contains_key(&sample.device[..]) {
                    true => made.left_out += 1,
                    false => {
                        row.insert(&sample.device, sample);
                    }
                }
            }
            made.samples += row.len();
            made.rows += 1;
            let mut fields = vec![format!("{:?}", moment[0].device_time)];
            for device in &made.devices {
                fields.extend(cells(row.get(&device[..]).copied()));
            }
            let _ = writeln!(made.csv, "{}", fields.join(","));
        }
        made
    }

    /// The TOML beside it.
    fn map(&self, licence: &str, source: &str) -> String {
        let mut map = format!(
            "delimiter = \",\"\nlicence = {}\nsource = {}\n\n[time]\ncolumn = \"time\"\nunit = \"s\"\n",
            toml_text(licence),
            toml_text(source)
        );
        for device in &self.devices {
            let [visible, x, y, z, qx, qy, qz, qw, opening] = columns(device);
            let _ = write!(
                map,
                "\n[[device]]\nname = \"{device}\"\nvisible = \"{visible}\"\nposition = [\"{x}\", \"{y}\", \"{z}\"]\nposition_unit = \"m\"\n\
                 quaternion = [\"{qx}\", \"{qy}\", \"{qz}\", \"{qw}\"]\nopening = {{ column = \"{opening}\" }}\n"
            );
        }
        map
    }
}

/// A text as TOML has it.
fn toml_text(text: &str) -> String {
    toml_edit::Value::from(text).to_string().trim().to_owned()
}

/// The columns of a device.
fn columns(device: &str) -> [String; 9] {
    ["visible", "x", "y", "z", "qx", "qy", "qz", "qw", "opening"]
        .map(|name| format!("{device}.{name}"))
}

/// The fields of a device in a row.
fn cells(sample: Option<&InputSample>) -> [String; 9] {
    let mut cells = [const { String::new() }; 9];
    let Some(sample) = sample else {
        return cells;
    };
    let number = |x: f64| format!("{x:?}");
    let position = sample.pose.position;
    // As whoever reads the recording will have it.
    let orientation = fixed_unit(sample.pose.orientation);
    let (true, Ok(orientation)) = (
        sample.visible && position.iter().all(|x| x.is_finite()),
        orientation,
    ) else {
        cells[0] = "0".into();
        return cells;
    };
    cells[0] = "1".into();
    for (cell, x) in cells[1..]
        .iter_mut()
        .zip(position.iter().chain(&orientation))
    {
        *cell = number(*x);
    }
    if let Some(opening) = sample.opening.filter(|opening| opening.is_finite()) {
        cells[8] = number(opening);
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::Pose;
    use microsim_settings::read_recording_map;

    fn sample(device: &str, time: f64, x: f64) -> InputSample {
        InputSample {
            visible: true,
            pose: Pose {
                position: [x, 0.1 + 0.2, -x],
                orientation: [0.0, 0.6, 0.0, 0.8],
            },
            opening: Some(1.0 / 3.0),
            ..InputSample::not_visible(device, time)
        }
    }

    /// Devices of different rates: a moment at which one sent nothing has empty fields, what is not seen a 0, and numbers all their digits.
    #[test]
    fn a_row_has_what_came_at_its_time() {
        let samples = [
            sample("left", 1.0 / 3.0, 0.25),
            sample("right", 1.0 / 3.0, 0.5),
            InputSample::not_visible("left", 0.5),
            sample("right", 0.75, 0.125),
            sample("right", 0.75, 9.0),
            sample("Left Forceps", 0.8, 0.0),
        ];
        let made = Recorded::of(&samples);
        let rows: Vec<&str> = made.csv.lines().collect();
        assert_eq!(rows.len(), 4, "{}", made.csv);
        assert_eq!(rows[2], "0.5,0,,,,,,,,,,,,,,,,,");
        assert_eq!(
            rows[3],
            "0.75,,,,,,,,,,1,0.125,0.30000000000000004,-0.125,0.0,0.6,0.0,0.8,0.3333333333333333"
        );
        assert!(
            rows[1].starts_with("0.3333333333333333,1,0.25,"),
            "{}",
            rows[1]
        );
        assert_eq!((made.samples, made.rows, made.left_out), (4, 3, 1));
        assert!(made.unnamed.contains("Left Forceps"));
        let map = read_recording_map(&made.map("a \"b\"\n", "x"), "test");
        let map = map.expect("a column map").settings;
        assert_eq!((map.device.len(), &map.licence[..]), (2, "a \"b\"\n"));
    }
}
