//! The TOML of the same name beside a CSV: which columns are time, position, quaternion and opening, in which units.

use crate::check::{items, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{identifier, quantity, time};
use crate::schema::Kind;
use crate::table::table;
use microsim_vocabulary::Unit;
use serde_json::Value;
use std::path::{Path, PathBuf};

table! {
    /// What the columns of a recording mean.
    pub struct RecordingMap {
        /// What stands between two columns.
        delimiter: String = Kind::choice(&[",", ";", "\t", "|", " "]) => ",",
        /// Terms under which it may be used; SPDX where there is one.
        licence: String,
        /// Where it comes from.
        source: String,
        /// A longer time between two samples splits the motion \[s\].
        gap: f64 = time(0.001, 10.0) => 0.1,
        /// The column of time.
        time: TimeColumn,
        /// The devices in it.
        device: Vec<DeviceColumns> [1, 32],
    }
}

table! {
    /// The column of time.
    pub struct TimeColumn {
        /// Its heading.
        column: String,
        /// Unit of its values.
        unit: String = symbols(Unit::Time),
    }
}

table! {
    /// The columns of one device.
    pub struct DeviceColumns {
        /// Name of the device.
        name: String = identifier(),
        /// Headings of the columns x, y and z.
        position: [String; 3],
        /// Unit of the position.
        position_unit: String = symbols(Unit::Length),
        /// Headings of the columns x, y, z and w; none for a marker, which has a position alone.
        quaternion: Option<[String; 4]>,
        /// The column of the opening, if the device has one.
        opening: Option<OpeningColumn>,
        /// Heading of a column that is 1 while the device is seen and 0 while it is not; where it is empty the row has no sample of the device.
        visible: Option<String>,
    }
}

table! {
    /// The column of an opening.
    pub struct OpeningColumn {
        /// Its heading.
        column: String,
        /// Value that means closed.
        closed: f64 = quantity(Unit::Ratio, -1e9, 1e9) => 0.0,
        /// Value that means fully open.
        open: f64 = quantity(Unit::Ratio, -1e9, 1e9) => 1.0,
    }
}

impl RecordingMap {
    /// The delimiter as the byte that it is.
    pub fn delimiter_byte(&self) -> u8 {
        self.delimiter.bytes().next().unwrap_or(b',')
    }
}

impl OpeningColumn {
    /// The opening from 0 closed to 1 open that a value of the column means; values beyond the ends count as the ends.
    pub fn opening(&self, value: f64) -> f64 {
        ((value - self.closed) / (self.open - self.closed)).clamp(0.0, 1.0)
    }
}

/// One of the symbols of a unit.
fn symbols(unit: Unit) -> Kind {
    Kind::Choice(unit.symbols().map(str::to_owned).collect())
}

/// Reads the map of a recording from a text; `file` is the name that complaints use.
pub fn read_recording_map(text: &str, file: &str) -> Result<Loaded<RecordingMap>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<RecordingMap>("recording"))?;
    let root = KeyPath::root();
    let names = crate::check::texts(reading.value(), "device", "name");
    unique(&mut reading, &root, &names, "device", "name");

    let columns = column_names(reading.value());
    for (i, (key, name)) in columns.iter().enumerate() {
        if columns[..i].iter().any(|(_, earlier)| earlier == name) {
            reading.complain(
                key,
                &format!("the column `{name}` a second time"),
                "each column for one purpose",
            );
        }
    }
    let openings: Vec<(usize, Value)> = items(reading.value(), "device")
        .map(|(i, device)| (i, device["opening"].clone()))
        .collect();
    for (i, opening) in openings {
        let ends = opening["closed"].as_f64().zip(opening["open"].as_f64());
        if ends.is_some_and(|(closed, open)| closed == open) {
            let key = root.key("device").at(i).key("opening");
            reading.complain(
                &key,
                "one value for closed and open",
                "`closed` other than `open`",
            );
        }
    }
    reading.finish()
}

/// Every column that a map names, with its place.
fn column_names(map: &Value) -> Vec<(KeyPath, String)> {
    let root = KeyPath::root();
    let mut columns = vec![(root.key("time").key("column"), &map["time"]["column"])];
    for (i, device) in items(map, "device") {
        let path = root.key("device").at(i);
        for field in ["position", "quaternion"] {
            columns.extend(items(device, field).map(|(c, name)| (path.key(field).at(c), name)));
        }
        columns.push((
            path.key("opening").key("column"),
            &device["opening"]["column"],
        ));
        columns.push((path.key("visible"), &device["visible"]));
    }
    columns
        .into_iter()
        .filter_map(|(key, name)| Some((key, name.as_str()?.to_owned())))
        .collect()
}

/// Where the map of a recording lies: beside it, under the same name with `.toml`.
pub fn recording_map_path(csv: &Path) -> PathBuf {
    csv.with_extension("toml")
}

/// Reads the map beside the CSV at `csv`. Without one the complaint names the file that is missing; what to write there
/// is given by [`recording_map_help`].
pub fn load_recording_map(csv: &Path) -> Result<Loaded<RecordingMap>, ConfigErrors> {
    let path = recording_map_path(csv);
    let expected = format!("the column map of {}", csv.display());
    read_recording_map(&load_text(&path, &expected)?, &path.display().to_string())
}

/// Explains how to write the map of a recording that has none, with an example made of its header: the first line.
pub fn recording_map_help(csv: &Path, header: &str) -> String {
    let map = recording_map_path(csv);
    let found = [',', ';', '\t', '|']
        .into_iter()
        .find(|c| header.contains(*c));
    let delimiter = found.unwrap_or(',');
    let columns: Vec<&str> = header.trim().split(delimiter).collect();
    let header = columns.join(", ");
    let example = example_map(delimiter, &columns);
    format!(
        "{}: a recording needs a column map, the file {} beside it.\n\
         Its header is: {header}\n\
         Write into that file, and put right what is guessed wrong:\n\n{example}",
        csv.display(),
        map.display(),
    )
}

/// A map that fits the header as far as its headings show; what they do not show is filled with the usual names.
fn example_map(delimiter: char, header: &[&str]) -> String {
    let (time, time_unit) = guess(header, &["t", "time", "timestamp"], Unit::Time);
    let axes = ["x", "y", "z"].map(|axis| {
        let names = [
            axis.to_owned(),
            format!("p{axis}"),
            format!("pos_{axis}"),
            format!("position_{axis}"),
        ];
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        guess(header, &names, Unit::Length)
    });
    let turns = ["x", "y", "z", "w"].map(|axis| {
        let names = [
            format!("q{axis}"),
            format!("q_{axis}"),
            format!("quaternion_{axis}"),
            format!("rot_{axis}"),
        ];
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        guess(header, &names, Unit::Ratio).0
    });
    let quoted = |names: &[&str]| {
        let names: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
        names.join(", ")
    };
    let position = quoted(&axes.each_ref().map(|(name, _)| name.as_str()));
    let quaternion = quoted(&turns.each_ref().map(String::as_str));
    let length_unit = &axes[0].1;
    format!(
        "delimiter = \"{}\"\n\
         licence = \"terms under which the recording may be used\"\n\
         source = \"where it comes from\"\n\n\
         [time]\ncolumn = {time:?}\nunit = \"{time_unit}\"\n\n\
         [[device]]\nname = \"stylus\"\nposition = [{position}]\nposition_unit = \"{length_unit}\"\n\
         quaternion = [{quaternion}]\n",
        delimiter.escape_default()
    )
}

/// The heading that is one of `names`, bare or with a unit as in `x_mm`, and that unit; the first name and the SI unit if
/// there is none.
fn guess(header: &[&str], names: &[&str], unit: Unit) -> (String, String) {
    for heading in header {
        let lower = heading.trim().to_lowercase();
        for name in names {
            let Some(rest) = lower.strip_prefix(name) else {
                continue;
            };
            let suffix = rest.trim_matches(|c: char| !c.is_alphanumeric());
            if rest.is_empty() || unit.symbols().any(|symbol| symbol == suffix) {
                let symbol = if suffix.is_empty() {
                    unit.symbol()
                } else {
                    suffix
                };
                return (heading.trim().to_owned(), symbol.to_owned());
            }
        }
    }
    (names[0].to_owned(), unit.symbol().to_owned())
}
