//! What a level asks for, from its file: the two vessels, which solution is right, and where the opening is to face.

use microsim_sdk::tissue::{Rim, VesselAxis};
use microsim_sdk::{Fault, ModuleConfig, Object};
use serde::Deserialize;
use std::f64::consts::PI;

/// The objects of the level that hold the vessels.
const CLAMPS: [&str; 2] = ["clamp-smaller", "clamp-larger"];

/// Steps of the integral of an ellipse's circumference: by the trapezoidal rule, which for a periodic function converges faster than any power, these are enough for rounding
/// up to an angle of 80 degrees.
const STEPS: u32 = 512;

/// How the smaller opening is to be matched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Solution {
    /// By an oblique cut.
    Cut,
    /// By spreading it.
    Dilate,
}

/// Where an oblique opening is to face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Facing {
    /// It does not matter.
    Any,
    /// To the trainee, in the field of view downwards.
    Trainee,
    /// Away from the trainee.
    Away,
}

impl Facing {
    /// The direction; none where it does not matter.
    pub fn direction(self) -> Option<[f64; 3]> {
        match self {
            Self::Any => None,
            Self::Trainee => Some([0.0, -1.0, 0.0]),
            Self::Away => Some([0.0, 1.0, 0.0]),
        }
    }
}

/// The level's keys of this module.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Keys {
    pub solution: Solution,
    pub facing: Facing,
    /// \[s\]
    pub dwell: f64,
    /// Relative difference of circumferences.
    pub tolerance: f64,
    /// Of media, beyond which it counts as injured.
    pub injury_stretch: f64,
}

/// A vessel of the level.
#[derive(Clone, Debug)]
pub(crate) struct Vessel {
    pub body: String,
    pub axis: VesselAxis,
}

/// A level.
#[derive(Clone, Debug)]
pub(crate) struct Site {
    pub keys: Keys,
    /// The one to be matched, and the one that it is matched to.
    pub smaller: Vessel,
    pub larger: Vessel,
    /// Tools that hold tissue and do not cut it.
    pub holders: Vec<String>,
    /// The lines that show where to cut.
    pub marks: Vec<String>,
}

impl Site {
    /// From the configuration of a level.
    pub fn new(config: &ModuleConfig) -> Result<Self, Fault> {
        let keys: Keys = serde_json::from_value(config.module.clone())?;
        let [smaller, larger] = &config.bodies[..] else {
            return Err(Fault::new(format!(
                "the level needs two [[body]]: the smaller vessel, then the larger one; it has {}",
                config.bodies.len()
            )));
        };
        let objects = &config.objects;
        let vessel = |body: &String, clamp: &str| {
            let object = objects.iter().find(|object| object.name == clamp);
            let axis = object.and_then(axis_of);
            let axis = axis.ok_or_else(|| {
                Fault::new(format!(
                    "the level needs an [[object]] \"{clamp}\" on the axis of the vessel \"{body}\", with its z axis towards the free end"
                ))
            });
            Ok::<_, Fault>(Vessel {
                body: body.clone(),
                axis: axis?,
            })
        };
        let marks = objects.iter().filter(|o| o.name.starts_with("mark-"));
        Ok(Self {
            smaller: vessel(smaller, CLAMPS[0])?,
            larger: vessel(larger, CLAMPS[1])?,
            holders: config.holders(),
            marks: marks.map(|object| object.name.clone()).collect(),
            keys,
        })
    }

    /// Ids of the targets.
    pub fn targets(&self) -> Vec<String> {
        let targets: &[&str] = match self.keys.solution {
            Solution::Cut => &[CUT, FREE],
            Solution::Dilate => &[MATCHED],
        };
        targets.iter().map(|target| (*target).to_owned()).collect()
    }

    /// Angle around the axis between where an opening faces and where it is to face \[rad\]; `None` where that does not matter.
    pub fn facing_error(&self, rim: &Rim) -> Option<f64> {
        let wanted = self.keys.facing.direction()?;
        let axis = self.smaller.axis.direction();
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let across = |v: [f64; 3]| [0, 1, 2].map(|k| v[k] - dot(v, axis) * axis[k]);
        // Out of the vessel.
        let outwards = rim.normal.map(|c| c * dot(rim.normal, axis).signum());
        let (faces, wanted) = (across(outwards), across(wanted));
        let sizes = (dot(faces, faces) * dot(wanted, wanted)).sqrt();
        let cosine = dot(faces, wanted) / sizes.max(f64::MIN_POSITIVE);
        Some(libm::acos(cosine.clamp(-1.0, 1.0)))
    }
}

/// The target of the end that has come off, of the vessel that nothing touches any more, and of the opening that matches.
pub(crate) const CUT: &str = "cut";
pub(crate) const FREE: &str = "free";
pub(crate) const MATCHED: &str = "matched";

/// The axis of a vessel in a clamp.
fn axis_of(clamp: &Object) -> Option<VesselAxis> {
    VesselAxis::new(clamp.position, microsim_sdk::axis(clamp.orientation))
}

/// The angle between the normal of an oblique cut and the axis \[rad\] at which the circumference of a tube's opening is so many times that of a straight cut: that of the
/// ellipse with half axes 1 and 1/cos of it. 0 where nothing is to be gained, and 80 degrees at most.
pub(crate) fn matching_angle(ratio: f64) -> f64 {
    let (mut low, mut high) = (0.0, 80f64.to_radians());
    while high - low > 1e-9 {
        let middle = 0.5 * (low + high);
        match ellipse(1.0 / libm::cos(middle)) / (2.0 * PI) < ratio {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

/// Circumference of an ellipse whose half axes are 1 and `long`.
fn ellipse(long: f64) -> f64 {
    let step = 2.0 * PI / f64::from(STEPS);
    let speeds = (0..STEPS).map(|k| {
        let angle = step * f64::from(k);
        libm::hypot(long * libm::sin(angle), libm::cos(angle))
    });
    speeds.sum::<f64>() * step
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The half axes of 45 degrees are 1 and √2: its circumference over 2π is G + 1/(π G) with Gauss's constant G, and 1 where nothing is to be gained. At 60 degrees, by Gauss's series
    /// in h = ((a − b)/(a + b))² = 1/9.
    #[test]
    fn the_angle_is_that_of_the_ellipse() {
        let gauss = 0.834_626_841_674_073_2;
        let ratio = gauss + 1.0 / (PI * gauss);
        assert!((matching_angle(ratio) - PI / 4.0).abs() < 1e-8);
        assert!(matching_angle(1.0) < 1e-4 && matching_angle(0.9) < 1e-8);
        let h: f64 = 1.0 / 9.0;
        let series = 1.0
            + h / 4.0
            + h.powi(2) / 64.0
            + h.powi(3) / 256.0
            + 25.0 * h.powi(4) / 16384.0
            + 49.0 * h.powi(5) / 65536.0;
        // The rest of the series is below h⁶/1000.
        assert!((ellipse(2.0) / (3.0 * PI * series) - 1.0).abs() < 1e-8);
        assert!((matching_angle(1.5 * series) - PI / 3.0).abs() < 1e-7);
    }
}
