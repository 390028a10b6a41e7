//! `microsim devices`: what an input sends.

use crate::cli::{DevicesArgs, Place};
use crate::listen::{Listened, listen, translator, without_markers};
use crate::output::{Exit, Problem, print, print_json};
use crate::session_file::installation;
use microsim_message::InputSample;
use serde_json::json;
use std::collections::BTreeMap;

/// How long a live source is listened to where nothing else is asked for \[s\].
const SECONDS: f64 = 5.0;

/// What is known of a device.
#[derive(Debug, Default)]
struct Device {
    samples: u64,
    visible: u64,
    late: u64,
    first: f64,
    newest: f64,
    arrived: f64,
    last: Option<InputSample>,
    is_seen: bool,
}

impl Device {
    fn add(&mut self, arrival: f64, sample: &InputSample) {
        // Where a connection ended the time is that of this machine.
        if sample.visible {
            match self.visible {
                0 => (self.first, self.newest) = (sample.device_time, sample.device_time),
                _ if sample.device_time < self.newest => self.late += 1,
                _ => self.newest = sample.device_time,
            }
        }
        self.samples += 1;
        self.arrived = arrival;
        self.is_seen = sample.visible;
        if sample.visible {
            self.visible += 1;
            self.last = Some(sample.clone());
        }
    }

    /// Poses per second by the device's clock.
    fn rate(&self) -> Option<f64> {
        let elapsed = self.newest - self.first;
        (self.visible > 1 && elapsed > 0.0).then(|| (self.visible - 1) as f64 / elapsed)
    }

    fn state(&self, end: f64, stale_after: f64) -> &'static str {
        match &self.last {
            None => "never seen",
            Some(_) if end - self.arrived > stale_after => "stale",
            Some(_) if self.is_seen => "tracked",
            Some(_) => "occluded",
        }
    }
}

/// Shows what an input sends.
pub fn devices(place: &Place, args: &DevicesArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let translator = translator(&installation)?;
    let Listened {
        samples,
        dropped,
        duration,
    } = listen(&installation, &args.listen, SECONDS)?;
    let mut devices: BTreeMap<String, Device> = BTreeMap::new();
    for (arrival, sample) in &without_markers(&translator, samples)? {
        devices
            .entry(sample.device.clone())
            .or_default()
            .add(*arrival, sample);
    }
    let state = |device: &Device| device.state(duration, translator.stale_after);
    if args.json {
        let list = devices.iter().map(|(name, device)| {
            let last = device.last.as_ref();
            json!({
                "name": name,
                "state": state(device),
                "samples": device.samples,
                "visible": device.visible,
                "late": device.late,
                "rate_hz": device.rate(),
                "position_m": last.map(|sample| sample.pose.position),
                "orientation": last.map(|sample| sample.pose.orientation),
                "opening": last.and_then(|sample| sample.opening),
                "device_time_s": last.map(|sample| sample.device_time),
            })
        });
        let list: Vec<_> = list.collect();
        print_json(&json!({ "listened_s": duration, "dropped": dropped, "devices": list }))?;
    } else if devices.is_empty() {
        print(format!("Nothing came in {duration:.1} s"))?;
    } else {
        print(format!(
            "{:<20} {:<10} {:>8} {:>9} {:>6}   last position [mm], orientation, opening",
            "device", "state", "samples", "rate", "late"
        ))?;
        for (name, device) in &devices {
            let rate = device
                .rate()
                .map_or("-".to_owned(), |rate| format!("{rate:.1} Hz"));
            print(format!(
                "{name:<20} {:<10} {:>8} {rate:>9} {:>6}   {}",
                state(device),
                device.samples,
                device.late,
                device.last.as_ref().map_or("-".to_owned(), last_words)
            ))?;
        }
        if dropped > 0 {
            print(format!("{dropped} samples were dropped"))?;
        }
    }
    Ok(if devices.is_empty() {
        Exit::Negative
    } else {
        Exit::Done
    })
}

fn last_words(sample: &InputSample) -> String {
    let [x, y, z] = sample.pose.position.map(|x| 1e3 * x);
    let [qx, qy, qz, qw] = sample.pose.orientation;
    let opening = sample
        .opening
        .map_or(String::new(), |o| format!(", {o:.2}"));
    format!("({x:.2}, {y:.2}, {z:.2}), ({qx:.3}, {qy:.3}, {qz:.3}, {qw:.3}){opening}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: four poses in half a second, one of them late; the last sample is not seen.
    #[test]
    fn a_device_is_counted_and_has_a_state() {
        let mut device = Device::default();
        for (arrival, time, visible) in [
            (0.0, 10.0, true),
            (0.3, 10.25, true),
            (0.5, 10.5, true),
            (0.6, 10.4, true),
            (1.0, 11.0, false),
        ] {
            let sample = InputSample {
                visible,
                ..InputSample::not_visible("left", time)
            };
            device.add(arrival, &sample);
        }
        assert_eq!((device.samples, device.visible, device.late), (5, 4, 1));
        assert_eq!(device.rate(), Some(6.0));
        assert_eq!(
            (device.state(1.05, 0.1), device.state(1.2, 0.1)),
            ("occluded", "stale")
        );
        device.add(
            1.3,
            &InputSample {
                visible: true,
                ..InputSample::not_visible("left", 11.3)
            },
        );
        assert_eq!(device.state(1.3, 0.1), "tracked");
        let mut unseen = Device::default();
        unseen.add(0.0, &InputSample::not_visible("right", 0.0));
        assert_eq!(
            (unseen.state(0.0, 0.1), unseen.rate()),
            ("never seen", None)
        );
    }
}
