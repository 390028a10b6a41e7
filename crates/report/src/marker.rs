//! What the markers of instruments have shown.

use microsim_message::MarkerTracking;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The markers of an instrument over a session.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerRecord {
    /// The device that they make up.
    pub device: String,
    /// Times at which any of them were reported.
    pub frames: u64,
    /// Of these with a pose.
    pub poses: u64,
    /// Root mean square of the residuals \[m\].
    pub residual: f64,
    /// The largest residual \[m\].
    pub largest_residual: f64,
    /// Sums over all frames: markers that were not seen.
    pub missing: u64,
    /// Markers that were seen as one point with another.
    pub merged: u64,
    /// Points with the name of another marker.
    pub permuted: u64,
    /// Points that are no marker.
    pub unknown: u64,
    /// Why there was no pose: each reason with how often.
    pub losses: BTreeMap<String, u64>,
}

/// Gathers them, by device.
#[derive(Default)]
pub(crate) struct MarkerCollector {
    devices: BTreeMap<String, MarkerRecord>,
}

impl MarkerCollector {
    pub fn add(&mut self, tracking: MarkerTracking) {
        let record = self.devices.entry(tracking.device).or_default();
        record.frames += 1;
        record.missing += u64::from(tracking.missing);
        record.merged += u64::from(tracking.merged);
        record.permuted += u64::from(tracking.permuted);
        record.unknown += u64::from(tracking.unknown);
        if let Some(residual) = tracking.residual {
            record.poses += 1;
            // The sum of squares, until the end.
            record.residual += residual * residual;
            record.largest_residual = record.largest_residual.max(residual);
        }
        if let Some(loss) = tracking.loss {
            *record.losses.entry(loss).or_default() += 1;
        }
    }

    pub fn finish(self) -> Vec<MarkerRecord> {
        let finish = |(device, record): (String, MarkerRecord)| MarkerRecord {
            device,
            residual: (record.residual / record.poses.max(1) as f64).sqrt(),
            ..record
        };
        self.devices.into_iter().map(finish).collect()
    }
}

impl MarkerRecord {
    /// In a line.
    pub fn words(&self) -> String {
        format!(
            "markers of \"{}\": a pose in {} of {} frames, residual {:.3} mm (at most {:.3} mm); {} missing, {} merged, {} permuted, {} unknown",
            self.device,
            self.poses,
            self.frames,
            1e3 * self.residual,
            1e3 * self.largest_residual,
            self.missing,
            self.merged,
            self.permuted,
            self.unknown
        )
    }
}

#[cfg(test)]
mod tests {
    use crate::Report;
    use crate::testing::{input, log};
    use microsim_message::MarkerTracking;

    /// By hand: residuals 3 and 4 of three frames, their root mean square √12.5.
    #[test]
    fn frames_add_up() {
        let frame = |residual: Option<f64>, missing| MarkerTracking {
            device: "left".into(),
            device_time: 0.0,
            residual,
            missing,
            merged: 2,
            permuted: 1,
            unknown: 0,
            loss: residual.is_none().then(|| "too few".into()),
        };
        let log = log(&[&frame(Some(3.0), 0), &frame(Some(4.0), 1), &frame(None, 4)]);
        let markers = Report::build(&input(), [(0, &log[..])]).markers;
        let [left] = &markers[..] else {
            panic!("{markers:?}");
        };
        assert_eq!(
            (
                left.frames,
                left.poses,
                left.missing,
                left.merged,
                left.permuted
            ),
            (3, 2, 5, 6, 3)
        );
        assert_eq!(
            (left.residual, left.largest_residual),
            (12.5_f64.sqrt(), 4.0)
        );
        assert_eq!(left.losses.get("too few"), Some(&1));
    }
}
