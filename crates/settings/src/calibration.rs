//! `calibration.toml` of a station: where the tips of its instruments are, and where the frames of its trackers lie. `microsim calibrate` writes it, the translator
//! reads it.

use crate::check::{texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{identifier, quantity, rotation, vector3};
use crate::table::table;
use microsim_vocabulary::Unit;
use std::fmt::Write;
use std::path::Path;

table! {
    /// What was calibrated on a station. A later calibration of the same devices takes the place of an earlier one.
    #[derive(Default)]
    pub struct Calibration {
        /// Tips of instruments.
        tip: Vec<TipCalibration> [0, 64],
        /// Where frames of trackers lie.
        workspace: Vec<WorkspaceCalibration> [0, 16],
    }
}

table! {
    /// Where the tip of an instrument is in the frame of its handle.
    pub struct TipCalibration {
        /// The device.
        device: String = identifier(),
        /// The lever from the tracked point to the tip \\[m\\].
        tip: [f64; 3] = vector3(Unit::Length, 10.0),
        /// Root mean square residual of the poses \\[m\\].
        residual: f64 = quantity(Unit::Length, 0.0, 1.0),
        /// Standard error of the tip \\[m\\].
        error: f64 = quantity(Unit::Length, 0.0, 1.0),
        /// How far the poses were spread \\[rad\\].
        spread: f64 = quantity(Unit::Angle, 0.0, 3.2),
        /// How many poses.
        poses: u32,
        /// When, UTC.
        date: String,
    }
}

table! {
    /// Where the frame of a tracker lies: point = scale rotation (device point) + translation. The keys of config/translator.toml act on what it gives.
    pub struct WorkspaceCalibration {
        /// The devices of the tracker.
        devices: Vec<String> [1, 32],
        /// Rotation [x, y, z, w] from the frame of the devices.
        rotation: [f64; 4] = rotation(),
        /// \\[m\\]
        translation: [f64; 3] = vector3(Unit::Length, 100.0),
        /// Length per length of the devices.
        scale: f64 = quantity(Unit::Ratio, 1e-6, 1e6) => 1.0,
        /// Root mean square residual of the points \\[m\\].
        residual: f64 = quantity(Unit::Length, 0.0, 1.0),
        /// Expected error in the middle of the points \\[m\\].
        error: f64 = quantity(Unit::Length, 0.0, 1.0),
        /// How many points.
        points: u32,
        /// When, UTC.
        date: String,
    }
}

impl Calibration {
    /// Whether nothing was calibrated.
    pub fn is_empty(&self) -> bool {
        self.tip.is_empty() && self.workspace.is_empty()
    }

    /// The calibrations of devices for which `wanted` holds.
    pub fn of_devices(&self, wanted: impl Fn(&str) -> bool) -> Self {
        let tips = self.tip.iter().filter(|tip| wanted(&tip.device));
        let spaces = self
            .workspace
            .iter()
            .filter(|space| space.devices.iter().any(|d| wanted(d)));
        Self {
            tip: tips.cloned().collect(),
            workspace: spaces.cloned().collect(),
        }
    }

    /// That of the frame of a device.
    pub fn workspace_of(&self, device: &str) -> Option<&WorkspaceCalibration> {
        let mut spaces = self.workspace.iter();
        spaces.find(|space| space.devices.iter().any(|name| name == device))
    }

    /// Takes a tip in the place of an earlier one.
    pub fn set_tip(&mut self, tip: TipCalibration) {
        self.tip.retain(|other| other.device != tip.device);
        self.tip.push(tip);
        self.tip.sort_by(|a, b| a.device.cmp(&b.device));
    }

    /// Takes a workspace; its devices belong to no other any more.
    pub fn set_workspace(&mut self, space: WorkspaceCalibration) {
        for other in &mut self.workspace {
            other
                .devices
                .retain(|device| !space.devices.contains(device));
        }
        self.workspace.retain(|other| !other.devices.is_empty());
        self.workspace.push(space);
        self.workspace.sort_by(|a, b| a.devices.cmp(&b.devices));
    }

    /// The file: what is read from it is the same to the bit.
    pub fn to_toml(&self) -> String {
        let mut text = String::from(
            "# Calibration of the instruments and trackers of this station, written by `microsim calibrate`. Lengths in m, angles in rad.\n",
        );
        // Writing to a text never fails.
        for tip in &self.tip {
            let _ = write!(
                text,
                "\n[[tip]]\ndevice = {:?}\ntip = {:?}\nresidual = {:?}\nerror = {:?}\nspread = {:?}\nposes = {}\ndate = {:?}\n",
                tip.device, tip.tip, tip.residual, tip.error, tip.spread, tip.poses, tip.date
            );
        }
        for space in &self.workspace {
            let _ = write!(
                text,
                "\n[[workspace]]\ndevices = {:?}\nrotation = {:?}\ntranslation = {:?}\nscale = {:?}\nresidual = {:?}\nerror = {:?}\npoints = {}\ndate = {:?}\n",
                space.devices,
                space.rotation,
                space.translation,
                space.scale,
                space.residual,
                space.error,
                space.points,
                space.date
            );
        }
        text
    }
}

/// Reads the file from a text; `file` is the name that complaints use.
pub fn read_calibration(text: &str, file: &str) -> Result<Loaded<Calibration>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Calibration>("calibration"))?;
    let names = texts(reading.value(), "tip", "device");
    unique(&mut reading, &KeyPath::root(), &names, "tip", "device");
    reading.finish()
}

/// Reads the file at `path`; nothing was calibrated where there is none.
pub fn load_calibration(path: &Path) -> Result<Calibration, ConfigErrors> {
    if !path.exists() {
        return Ok(Calibration::default());
    }
    let text = load_text(path, "the calibration of this station")?;
    Ok(read_calibration(&text, &path.display().to_string())?.settings)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tip(device: &str, x: f64) -> TipCalibration {
        TipCalibration {
            device: device.into(),
            tip: [x, -2.5e-3, 0.1 + 0.2],
            residual: 1.0 / 3.0 * 1e-4,
            error: 2e-5,
            spread: 0.7,
            poses: 812,
            date: "2026-11-25".into(),
        }
    }

    fn space(devices: &[&str]) -> WorkspaceCalibration {
        WorkspaceCalibration {
            devices: devices.iter().map(|d| (*d).to_owned()).collect(),
            rotation: [0.0, 0.0, 0.6, 0.8],
            translation: [0.1, 1e-17, -0.3],
            scale: 1.0,
            residual: 1e-4,
            error: 5e-5,
            points: 6,
            date: "2026-11-25".into(),
        }
    }

    #[test]
    fn what_is_written_is_read_to_the_bit() {
        let mut calibration = Calibration::default();
        calibration.set_tip(tip("right", 1e-3));
        calibration.set_tip(tip("left", 2e-3));
        calibration.set_workspace(space(&["left", "right"]));
        let text = calibration.to_toml();
        let read = read_calibration(&text, "test")
            .expect("what was written")
            .settings;
        assert_eq!(read, calibration, "{text}");
        assert_eq!(
            Calibration::default(),
            read_calibration("", "test").expect("nothing").settings
        );
    }

    #[test]
    fn a_later_calibration_takes_the_place_of_an_earlier_one() {
        let mut calibration = Calibration::default();
        calibration.set_tip(tip("left", 1e-3));
        calibration.set_tip(tip("left", 2e-3));
        calibration.set_workspace(space(&["left", "right"]));
        calibration.set_workspace(space(&["right", "pointer"]));
        assert_eq!(calibration.tip, [tip("left", 2e-3)]);
        assert_eq!(
            calibration.workspace,
            [space(&["left"]), space(&["right", "pointer"])]
        );
        let of_right = calibration.of_devices(|device| device == "right");
        assert_eq!((of_right.tip.len(), of_right.workspace.len()), (0, 1));
    }
}
