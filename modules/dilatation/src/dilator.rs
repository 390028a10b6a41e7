//! Where the dilator is in the vessel's opening, and in which directions it has pressed the wall apart.

use microsim_sdk::axis;
use microsim_sdk::message::{ContactForce, Pose};
use microsim_sdk::tissue::{Rim, VesselAxis, distance};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Directions across the vessel are counted in so many equal parts of half a turn: a direction and its opposite are one.
const DIRECTIONS: usize = 18;

/// Directions in which the wall was pressed apart with less than this fraction of the largest force do not count.
const COUNTS: f64 = 0.5;

/// A tool whose axis is steeper to the plane of the opening than the arc cosine of this, 73°, leads into no lumen.
const STEEP: f64 = 0.3;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// How deep the tip of a tool lies behind the plane of an opening \[m\]; the tool's axis has to go through the circle of the opening's area. `None` where it does not, or
/// the tip is before the plane.
pub(crate) fn depth(tool: &Pose, opening: &Rim, vessel: &VesselAxis) -> Option<f64> {
    let outward = match dot(opening.normal, vessel.direction()) < 0.0 {
        true => opening.normal.map(|c| -c),
        false => opening.normal,
    };
    let (tip, along) = (tool.position, axis(tool.orientation));
    let slope = dot(along, outward);
    let depth = dot([0, 1, 2].map(|k| opening.centre[k] - tip[k]), outward);
    if slope < STEEP || depth <= 0.0 {
        return None;
    }
    let crossing = [0, 1, 2].map(|k| tip[k] + along[k] * depth / slope);
    let radius = (opening.area / PI).sqrt();
    (distance(crossing, opening.centre) <= radius).then_some(depth)
}

/// The largest forces with which the jaws have pressed the wall apart, by direction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spreads {
    /// Of each part of half a turn about the vessel's axis \[N\].
    peaks: [f64; DIRECTIONS],
}

impl Spreads {
    /// Takes over what the dilator does to the wall in a tick.
    pub fn update(&mut self, contact: &ContactForce, vessel: &VesselAxis) {
        let jaw = |side: &str| {
            let parts = contact.parts.iter().filter(|of| of.part.starts_with(side));
            parts.fold([0.0; 3], |sum, of| [0, 1, 2].map(|k| sum[k] + of.force[k]))
        };
        let (left, right) = (jaw("left-"), jaw("right-"));
        let apart = [0, 1, 2].map(|k| 0.5 * (left[k] - right[k]));
        let [x, y] = [0.0, 0.5 * PI].map(|angle| dot(apart, vessel.spoke(angle)));
        let force = libm::hypot(x, y);
        if force > 0.0 {
            let part = libm::atan2(y, x).rem_euclid(PI) / PI * DIRECTIONS as f64;
            let peak = &mut self.peaks[(part as usize).min(DIRECTIONS - 1)];
            *peak = peak.max(force);
        }
    }

    /// Largest angle between two directions in which the wall was pressed apart, in steps of ten degrees \[rad\]; `None` if it never was.
    pub fn angle(&self) -> Option<f64> {
        let largest = self.peaks.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            return None;
        }
        let counts = |part: &usize| self.peaks[*part] >= COUNTS * largest;
        let counted: Vec<usize> = (0..DIRECTIONS).filter(counts).collect();
        let pairs = counted.iter().flat_map(|a| {
            let apart = counted.iter().map(move |b| a.abs_diff(*b));
            apart.map(|apart| apart.min(DIRECTIONS - apart))
        });
        let widest = pairs.max().unwrap_or(0);
        Some(widest as f64 * PI / DIRECTIONS as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_sdk::message::PartForce;
    use microsim_sdk::turned_to;

    fn vessel() -> VesselAxis {
        VesselAxis::new([0.0; 3], [1.0, 0.0, 0.0]).expect("a direction")
    }

    /// A square opening of 1 mm across x, its normal against the vessel's axis.
    fn opening() -> Rim {
        let corner = |y: f64, z: f64| [2e-3, 0.5e-3 * y, 0.5e-3 * z];
        let corners = [
            corner(1.0, 1.0),
            corner(1.0, -1.0),
            corner(-1.0, -1.0),
            corner(-1.0, 1.0),
        ];
        Rim::of(&corners).expect("it has an area")
    }

    fn tool(position: [f64; 3], along: [f64; 3]) -> Pose {
        Pose {
            position,
            orientation: turned_to(along),
        }
    }

    /// By hand: 0.7 mm behind the plane x = 2 mm. The circle of its area has the radius 0.564 mm.
    #[test]
    fn a_tool_is_in_the_lumen_where_its_axis_goes_through_the_opening() {
        let depth = |at, along| depth(&tool(at, along), &opening(), &vessel());
        let x = [1.0, 0.0, 0.0];
        let found = depth([1.3e-3, 0.1e-3, 0.0], x).expect("inside");
        assert!((found - 0.7e-3).abs() < 1e-15, "{found}");
        assert_eq!(depth([2.1e-3, 0.0, 0.0], x), None);
        assert_eq!(depth([1.3e-3, 0.6e-3, 0.0], x), None);
        // Oblique: it crosses the plane 0.7 mm · 3/4 beside the tip, which alone would be in the circle.
        assert_eq!(depth([1.3e-3, 0.1e-3, 0.0], [0.8, 0.6, 0.0]), None);
        assert!(depth([1.3e-3, -0.3e-3, 0.0], [0.8, 0.6, 0.0]).is_some());
        assert_eq!(depth([1.9e-3, 0.0, 0.0], [0.0, 1.0, 0.0]), None);
    }

    /// Jaws press with a force at an angle about the axis; what is common to both does not count, nor what acts along the axis.
    fn spread(log: &mut Spreads, angle: f64, force: f64) {
        let apart = vessel().spoke(angle).map(|c| c * force);
        let part = |name: &str, sign: f64| PartForce {
            part: name.into(),
            force: [0, 1, 2].map(|k| sign * apart[k] + [sign * 9.0, 0.3, 0.0][k]),
            ..PartForce::default()
        };
        let contact = ContactForce {
            parts: vec![part("left-tip", 1.0), part("right-tip", -1.0)],
            ..ContactForce::default()
        };
        log.update(&contact, &vessel());
    }

    #[test]
    fn directions_count_by_half_of_the_largest_force_and_a_turned_tool_is_the_same() {
        let degrees = |log: &Spreads| log.angle().map(|angle| angle.to_degrees().round());
        let mut log = Spreads::default();
        assert_eq!(degrees(&log), None);
        spread(&mut log, 0.1, 1.0);
        spread(&mut log, 0.1 + PI, 1.0);
        assert_eq!(degrees(&log), Some(0.0));
        spread(&mut log, 0.1 + 0.5 * PI, 0.4);
        assert_eq!(degrees(&log), Some(0.0));
        spread(&mut log, 0.1 + 0.5 * PI, 0.6);
        assert_eq!(degrees(&log), Some(90.0));
        // 170° apart are 10°.
        let mut near = Spreads::default();
        spread(&mut near, 0.1, 1.0);
        spread(&mut near, -0.1, 1.0);
        assert_eq!(degrees(&near), Some(10.0));
    }
}
