//! From samples of markers to samples of the device that they make up.
//!
//! Markers belong together if they have the same time of the device's clock. They come in one tick: in one message of a tracker, or one row of a recording.

use super::{MarkerModel, MarkerPoint};
use microsim_message::{InputSample, MarkerTracking, Pose};

/// An instrument with markers that are devices of a source.
#[derive(Clone, Debug)]
pub struct MarkedInstrument {
    device: String,
    names: Vec<String>,
    model: MarkerModel,
    /// The markers of one time.
    frame: Option<(f64, Vec<MarkerPoint>)>,
}

impl MarkedInstrument {
    /// The instrument that is device `device`, with markers that are devices of these names, in the order of the model.
    pub fn new(device: &str, names: Vec<String>, model: MarkerModel) -> Self {
        Self {
            device: device.to_owned(),
            names,
            model,
            frame: None,
        }
    }

    /// Takes a sample of one of its markers; whether it is one. What belongs to an earlier time is complete then.
    pub fn add(
        &mut self,
        sample: &InputSample,
        complete: &mut Vec<(InputSample, MarkerTracking)>,
    ) -> bool {
        let Some(marker) = self.names.iter().position(|name| *name == sample.device) else {
            return false;
        };
        let is_same = |(time, _): &(f64, _)| time.to_bits() == sample.device_time.to_bits();
        if !self.frame.as_ref().is_some_and(is_same) {
            complete.extend(self.finish());
        }
        let (_, points) = self.frame.get_or_insert((sample.device_time, Vec::new()));
        if sample.visible {
            points.push(MarkerPoint {
                marker: Some(marker),
                position: sample.pose.position,
            });
        }
        true
    }

    /// What the markers of one time make up, once all of them have come.
    pub fn finish(&mut self) -> Option<(InputSample, MarkerTracking)> {
        let (time, points) = self.frame.take()?;
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let mut sample = InputSample::not_visible(&self.device, time);
        let mut tracking = MarkerTracking {
            device: self.device.clone(),
            device_time: time,
            residual: None,
            missing: count(self.model.count().saturating_sub(points.len())),
            merged: 0,
            permuted: 0,
            unknown: 0,
            loss: None,
        };
        match self.model.locate(&points) {
            Ok(fit) => {
                sample.visible = true;
                sample.pose = Pose {
                    position: fit.position,
                    orientation: fit.orientation,
                };
                sample.opening = fit.opening;
                tracking.residual = Some(fit.rms);
                tracking.missing = count(fit.missing);
                tracking.merged = count(fit.merged);
                tracking.permuted = count(fit.permuted);
                tracking.unknown = count(fit.unknown);
            }
            Err(loss) => tracking.loss = Some(loss.to_string()),
        }
        Some((sample, tracking))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Marker;

    fn instrument() -> MarkedInstrument {
        let still = |x: f64, y: f64| Marker {
            closed: [x, y, 0.0],
            open: [x, y, 0.0],
        };
        let markers = vec![still(0.0, 0.0), still(0.03, 0.0), still(0.0, 0.05)];
        let model = MarkerModel::new(markers, 5e-4, 0.0).expect("markers");
        MarkedInstrument::new("left", ["a", "b", "c"].map(str::to_owned).to_vec(), model)
    }

    fn marker(name: &str, time: f64, place: [f64; 3]) -> InputSample {
        InputSample {
            visible: true,
            pose: Pose {
                position: place,
                ..Pose::default()
            },
            ..InputSample::not_visible(name, time)
        }
    }

    /// Markers of one time make one sample of the device, once a later time has begun or all of a tick have come; one that is not seen is missing.
    #[test]
    fn markers_of_one_time_make_one_sample() {
        let mut own = instrument();
        let mut complete = Vec::new();
        for (name, place) in [
            ("a", [0.1, 0.0, 0.0]),
            ("b", [0.13, 0.0, 0.0]),
            ("c", [0.1, 0.05, 0.0]),
        ] {
            assert!(own.add(&marker(name, 1.0, place), &mut complete));
        }
        assert!(!own.add(&marker("other", 1.0, [0.0; 3]), &mut complete));
        assert!(complete.is_empty());
        assert!(own.add(&InputSample::not_visible("a", 2.0), &mut complete));
        let (sample, tracking) = complete.pop().expect("the first time");
        assert_eq!(
            (&sample.device[..], sample.device_time, sample.visible),
            ("left", 1.0, true)
        );
        assert!((sample.pose.position[0] - 0.1).abs() < 1e-12, "{sample:?}");
        assert_eq!(
            (tracking.missing, tracking.permuted, sample.opening),
            (0, 0, None)
        );
        let (sample, tracking) = own.finish().expect("the second time");
        assert_eq!(
            (sample.visible, sample.device_time, tracking.missing),
            (false, 2.0, 3)
        );
        assert!(tracking.loss.is_some());
        assert_eq!(own.finish(), None);
    }
}
