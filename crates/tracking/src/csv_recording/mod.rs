//! Recordings in CSV: one header, then one row per moment with the readings of one or several devices.
//!
//! Which column is what, and in which unit, is stated by a [`ColumnMap`]; nothing is guessed from the file itself. Samples
//! come out as they stand in the file: nothing is filtered, and nothing is interpolated over a gap.

mod error;

pub use error::{CsvError, CsvProblem};

use csv::ByteRecord;

use crate::RawStatistics;
use crate::rotation::checked_unit;
use microsim_message::InputSample;

/// Most samples (rows times devices) that are read from one file: about 1 GB of memory, and at 1000 rows a second
/// nearly three hours of one device.
pub const MAX_SAMPLES: usize = 10_000_000;

/// Which columns of a CSV file hold what. Names are those of the header; factors are finite and positive.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnMap {
    /// What separates fields, for instance `b','`.
    pub delimiter: u8,
    /// The time; must increase from row to row.
    pub time: Column,
    /// The devices, each with columns of its own.
    pub devices: Vec<DeviceColumns>,
    /// Longer intervals between samples are gaps `[s]`; `None` for the default of [`RawStatistics`].
    pub gap_s: Option<f64>,
}

/// One column of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name in the header.
    pub name: String,
    /// What turns its numbers into the SI unit: 0.001 for milliseconds.
    pub factor: f64,
}

/// The columns of one device.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceColumns {
    /// Name of the device.
    pub device: String,
    /// Columns of the position x, y, z in the device frame. If all three are empty in a row, the device was not visible.
    pub position: [String; 3],
    /// What turns the numbers of the position into metres: 0.001 for millimetres.
    pub position_factor: f64,
    /// Columns of the unit quaternion `device_from_body` in the order x, y, z, w; `None` for a device without
    /// orientation, whose samples then have the identity.
    pub orientation: Option<[String; 4]>,
    /// The column of the opening, if the device has one.
    pub opening: Option<OpeningColumn>,
    /// The column with 1 or true, 0 or false for visible or not; `None` if there is none. Where it states that the
    /// device was not visible, its other fields are not looked at; where it is empty, the row has no sample of the device.
    pub visible: Option<String>,
}

/// The column of an opening, with the readings that mean closed and open (which differ). Readings beyond them are taken
/// as closed or open; an empty field is an unknown opening.
#[derive(Clone, Debug, PartialEq)]
pub struct OpeningColumn {
    /// Its name in the header.
    pub name: String,
    /// The number that means closed.
    pub closed: f64,
    /// The number that means open.
    pub open: f64,
}

/// A recording in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// All samples: in the order of their times, and at one time in the order of the devices in the column map.
    pub samples: Vec<InputSample>,
    /// The column map's threshold for gaps `[s]`.
    pub gap_s: Option<f64>,
}

impl Recording {
    /// The samples of one device, in the order of their times.
    pub fn samples_of<'a>(&'a self, device: &'a str) -> impl Iterator<Item = &'a InputSample> {
        self.samples
            .iter()
            .filter(move |sample| &*sample.device == device)
    }

    /// Raw figures of one device; those of no sample for an unknown one.
    pub fn statistics(&self, device: &str) -> RawStatistics {
        RawStatistics::of(self.samples_of(device), self.gap_s)
    }
}

/// Reads a recording from the bytes of a CSV file (UTF-8, with or without byte order mark, lines that end in LF or CRLF).
///
/// `file` is its name for error messages.
///
/// # Errors
/// [`CsvError`] for the first line that does not agree with the column map: see [`CsvProblem`].
pub fn read_csv(bytes: &[u8], file: &str, map: &ColumnMap) -> Result<Recording, CsvError> {
    read_up_to(MAX_SAMPLES, bytes, file, map)
}

fn read_up_to(
    most: usize,
    bytes: &[u8],
    file: &str,
    map: &ColumnMap,
) -> Result<Recording, CsvError> {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(map.delimiter)
        .has_headers(false)
        .flexible(true)
        .from_reader(bytes);
    let mut record = ByteRecord::new();
    // Line numbers are only needed once, so they are counted when they are.
    let error_at = |byte: usize, problem| CsvError {
        file: file.to_owned(),
        line: line_at(bytes, byte),
        problem,
    };
    let mut next = |record: &mut ByteRecord| {
        let byte = usize::try_from(reader.position().byte()).unwrap_or(usize::MAX);
        match reader.read_byte_record(record) {
            Ok(more) => Ok((more, byte)),
            Err(error) => Err(error_at(byte, CsvProblem::Syntax(error.to_string()))),
        }
    };

    let (has_header, header_byte) = next(&mut record)?;
    if !has_header {
        return Err(error_at(0, CsvProblem::Empty));
    }
    let header: Vec<String> = record
        .iter()
        .map(|name| String::from_utf8_lossy(name).trim().to_owned())
        .collect();
    let layout = Layout::new(map, &header).map_err(|problem| error_at(header_byte, problem))?;

    let mut samples = Vec::new();
    let mut before_s = None;
    loop {
        let (more, byte) = next(&mut record)?;
        if !more {
            break;
        }
        let read = if record.len() != header.len() {
            Err(CsvProblem::FieldCount {
                expected: header.len(),
                found: record.len(),
            })
        } else if samples.len() + map.devices.len() > most {
            Err(CsvProblem::TooManySamples)
        } else {
            layout.read_row(&record, before_s, &mut samples)
        };
        before_s = Some(read.map_err(|problem| error_at(byte, problem))?);
    }
    if samples.is_empty() {
        return Err(error_at(header_byte, CsvProblem::NoSamples));
    }
    Ok(Recording {
        samples,
        gap_s: map.gap_s,
    })
}

/// A column map with the places of its columns in one file.
struct Layout {
    time: Field,
    devices: Vec<DeviceLayout>,
}

struct DeviceLayout {
    device: String,
    position: [Field; 3],
    orientation: Option<[Field; 4]>,
    opening: Option<(Field, f64, f64)>,
    visible: Option<Field>,
}

/// A column: its place in each row, its name for messages, and the factor to the SI unit.
struct Field {
    index: usize,
    name: String,
    factor: f64,
}

impl Layout {
    fn new(map: &ColumnMap, header: &[String]) -> Result<Self, CsvProblem> {
        let field = |name: &str, factor| Field::find(header, name, factor);
        let mut devices = Vec::new();
        for columns in &map.devices {
            let [x, y, z] = &columns.position;
            let factor = columns.position_factor;
            devices.push(DeviceLayout {
                device: columns.device.as_str().into(),
                position: [field(x, factor)?, field(y, factor)?, field(z, factor)?],
                orientation: match &columns.orientation {
                    Some([x, y, z, w]) => Some([
                        field(x, 1.0)?,
                        field(y, 1.0)?,
                        field(z, 1.0)?,
                        field(w, 1.0)?,
                    ]),
                    None => None,
                },
                opening: match &columns.opening {
                    Some(column) => Some((field(&column.name, 1.0)?, column.closed, column.open)),
                    None => None,
                },
                visible: match &columns.visible {
                    Some(name) => Some(field(name, 1.0)?),
                    None => None,
                },
            });
        }
        Ok(Self {
            time: field(&map.time.name, map.time.factor)?,
            devices,
        })
    }

    /// Appends the samples of one row and gives its time `[s]`.
    fn read_row(
        &self,
        record: &ByteRecord,
        before_s: Option<f64>,
        samples: &mut Vec<InputSample>,
    ) -> Result<f64, CsvProblem> {
        let time_s = self.time.number(record)?;
        if let Some(before_s) = before_s
            && time_s <= before_s
        {
            return Err(CsvProblem::TimeNotIncreasing {
                before_s,
                found_s: time_s,
            });
        }
        for device in &self.devices {
            samples.extend(device.sample(record, time_s)?);
        }
        Ok(time_s)
    }
}

impl DeviceLayout {
    /// The sample of the device, if the row has one.
    fn sample(&self, record: &ByteRecord, time_s: f64) -> Result<Option<InputSample>, CsvProblem> {
        let mut sample = InputSample::not_visible(&self.device, time_s);
        if let Some(visible) = &self.visible {
            if visible.text(record).is_empty() {
                return Ok(None);
            }
            if !visible.flag(record)? {
                return Ok(Some(sample));
            }
        }
        match self
            .position
            .iter()
            .filter(|field| field.text(record).is_empty())
            .count()
        {
            0 => {}
            3 => return Ok(Some(sample)),
            _ => {
                return Err(CsvProblem::PartialPosition {
                    device: self.device.clone(),
                });
            }
        }

        sample.visible = true;
        for (component, field) in sample.pose.position.iter_mut().zip(&self.position) {
            *component = field.number(record)?;
        }
        if let Some(fields) = &self.orientation {
            for (component, field) in sample.pose.orientation.iter_mut().zip(fields) {
                *component = field.number(record)?;
            }
            sample.pose.orientation =
                checked_unit(sample.pose.orientation).map_err(|error| CsvProblem::Quaternion {
                    device: self.device.clone(),
                    error,
                })?;
        }
        if let Some((field, closed, open)) = &self.opening
            && !field.text(record).is_empty()
        {
            let opening = (field.number(record)? - closed) / (open - closed);
            sample.opening = Some(opening.clamp(0.0, 1.0));
        }
        Ok(Some(sample))
    }
}

impl Field {
    fn find(header: &[String], name: &str, factor: f64) -> Result<Self, CsvProblem> {
        let mut places = (0..header.len()).filter(|&index| header[index] == name);
        let index = places.next().ok_or_else(|| CsvProblem::MissingColumn {
            column: name.to_owned(),
            present: header.to_vec(),
        })?;
        if places.next().is_some() {
            return Err(CsvProblem::AmbiguousColumn(name.to_owned()));
        }
        Ok(Self {
            index,
            name: name.to_owned(),
            factor,
        })
    }

    /// The bytes of the field, whose place was found in the header; rows have as many fields.
    fn text<'a>(&self, record: &'a ByteRecord) -> &'a [u8] {
        record[self.index].trim_ascii()
    }

    /// Its number in the SI unit.
    fn number(&self, record: &ByteRecord) -> Result<f64, CsvProblem> {
        let bytes = self.text(record);
        let number = std::str::from_utf8(bytes)
            .ok()
            .and_then(|text| text.parse::<f64>().ok());
        let Some(number) = number else {
            return Err(CsvProblem::NotANumber {
                column: self.name.clone(),
                text: String::from_utf8_lossy(bytes).into_owned(),
            });
        };
        let value = number * self.factor;
        if !value.is_finite() {
            return Err(CsvProblem::NotFinite {
                column: self.name.clone(),
                text: String::from_utf8_lossy(bytes).into_owned(),
            });
        }
        Ok(value)
    }

    fn flag(&self, record: &ByteRecord) -> Result<bool, CsvProblem> {
        let text = self.text(record);
        if text == b"1" || text.eq_ignore_ascii_case(b"true") {
            Ok(true)
        } else if text == b"0" || text.eq_ignore_ascii_case(b"false") {
            Ok(false)
        } else {
            Err(CsvProblem::NotAFlag {
                column: self.name.clone(),
                text: String::from_utf8_lossy(text).into_owned(),
            })
        }
    }
}

/// The line, from 1, of the record that begins at or after a byte. The reader stands before the line feed of a CRLF and
/// before empty lines, so those are passed first.
fn line_at(bytes: &[u8], byte: usize) -> u64 {
    let byte = byte.min(bytes.len());
    let skipped = bytes[byte..]
        .iter()
        .take_while(|&&b| b == b'\n' || b == b'\r')
        .count();
    1 + bytes[..byte + skipped]
        .iter()
        .filter(|&&b| b == b'\n')
        .count() as u64
}

#[cfg(test)]
mod tests;
