//! The series of a run's probes as CSV.

use microsim_scene::Series;
use microsim_settings::Probe;
use std::fmt::Write;

/// A row per sample: its time, then the value of each probe, in SI and with all digits. Names of probes are plain words, so that no cell needs quotes.
pub fn csv(probes: &[Probe], series: &Series) -> String {
    let mut text = String::from("time [s]");
    for probe in probes {
        let unit = probe.quantity.unit().symbol();
        let _ = write!(text, ",{} [{unit}]", probe.name);
    }
    text.push('\n');
    for (sample, time) in series.time.iter().enumerate() {
        let _ = write!(text, "{time:?}");
        for values in &series.probes {
            let _ = write!(text, ",{:?}", values[sample]);
        }
        text.push('\n');
    }
    text
}
