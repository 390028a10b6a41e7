//! How long the motion of a run is, for the time that is left of it.

use microsim_host::plan::{PluginKind, RunPlan};
use microsim_message::{InputSample, decode_bytes};
use microsim_settings::{RecordingConfig, RecordingMap, ScriptConfig, Unit};

/// Where the motion that the plan's source plays ends \[s\]; `None` for a tracker, whose end nobody knows.
pub fn motion_length(plan: &RunPlan) -> Option<f64> {
    let source = plan
        .plugins
        .iter()
        .find(|plugin| plugin.kind == PluginKind::Source)?;
    if let Ok(config) = source.setup.configuration::<ScriptConfig>() {
        return Some(config.script.motion().ok()?.duration());
    }
    let file = &source.setup.files.first()?.bytes;
    match source.setup.configuration::<RecordingConfig>().ok()? {
        RecordingConfig::Csv { map, .. } => csv_length(file, &map),
        RecordingConfig::Samples => {
            let samples: Vec<(f64, InputSample)> = decode_bytes(file).ok()?;
            samples.last().map(|(arrival, _)| *arrival)
        }
    }
}

/// From the first to the last row of a table. Its source reads it as a whole; this is enough to state how far a run is.
fn csv_length(bytes: &[u8], map: &RecordingMap) -> Option<f64> {
    let text = std::str::from_utf8(bytes).ok()?;
    let cells = |line: &str| -> Vec<String> {
        let cells = line.split(char::from(map.delimiter_byte()));
        cells
            .map(|cell| cell.trim().trim_matches('"').to_owned())
            .collect()
    };
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let column = cells(lines.next()?)
        .iter()
        .position(|name| *name == map.time.column)?;
    let time = |line: &str| cells(line).get(column)?.parse::<f64>().ok();
    let (first, last) = (time(lines.next()?)?, time(lines.next_back()?)?);
    let length = Unit::Time.to_si(last - first, &map.time.unit)?;
    (length.is_finite() && length > 0.0).then_some(length)
}

#[cfg(test)]
mod tests {
    use super::csv_length;
    use microsim_settings::read_recording_map;

    /// From the first row to the last, in seconds: here of milliseconds behind other columns; what cannot be read has no length.
    #[test]
    fn a_recording_is_as_long_as_its_rows() {
        let map = read_recording_map(
            "delimiter = \";\"\nlicence = \"x\"\nsource = \"y\"\n[time]\ncolumn = \"t\"\nunit = \"ms\"\n[[device]]\nname = \"right\"\n\
             position = [\"x\", \"y\", \"z\"]\nposition_unit = \"mm\"\nquaternion = [\"a\", \"b\", \"c\", \"d\"]\n",
            "map.toml",
        );
        let map = map.expect("a map").settings;
        let length = |text: &str| csv_length(text.as_bytes(), &map);
        let found = length("x;\"t\"\n1;1000\n2;1500\n\n3;3500\n\n").expect("a length");
        assert!((found - 2.5).abs() < 1e-12, "{found}");
        for none in [
            "",
            "x;t\n",
            "x;t\n1;1\n",
            "x;y\n1;2\n2;3\n",
            "x;t\n1;b\n1;c\n",
        ] {
            assert_eq!(length(none), None, "{none:?}");
        }
    }
}
