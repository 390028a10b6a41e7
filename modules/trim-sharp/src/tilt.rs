//! How steeply scissors point towards the vessel where they cut.

use microsim_sdk::tissue::VesselAxis;
use serde::{Deserialize, Serialize};

/// The angle between the scissors, from the handle to the tip, and the plane that is tangential to the vessel at what they cut: 0 where they are parallel to the wall, along
/// the vessel or across it, and a right angle where they point at its axis. Mean over each bite, by the area that it opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Tilt {
    /// Of the bite that goes on: its number, Σ area · sine \[m²\], Σ area \[m²\].
    bite: u32,
    sines: f64,
    area: f64,
    /// Largest one of the bites before it \[rad\].
    before: f64,
}

impl Tilt {
    /// In a tick in which the bite of this number opened `area` \[m²\] around `place` \[m\] with scissors whose z axis, from the tip to the handle, is `handle`.
    pub fn update(
        &mut self,
        bite: u32,
        area: f64,
        place: [f64; 3],
        handle: [f64; 3],
        axis: &VesselAxis,
    ) {
        if bite != self.bite {
            *self = Self {
                bite,
                before: self.largest(),
                ..Self::default()
            };
        }
        let radial = axis.radial(place);
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let size = dot(radial, radial).sqrt();
        // On the axis every direction across it is the outward one: there nothing points towards the vessel more than anything else.
        if size > 0.0 {
            self.sines += area * dot(radial, handle) / size;
            self.area += area;
        }
    }

    /// Largest one of all bites, 0 where none points towards the vessel \[rad\].
    pub fn largest(&self) -> f64 {
        let sine = match self.area > 0.0 {
            true => self.sines / self.area,
            false => 0.0,
        };
        self.before.max(libm::asin(sine.clamp(0.0, 1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_4, FRAC_PI_6};

    /// By hand, above a vessel along x: scissors along it, across it, and with their handle raised by 45 degrees.
    #[test]
    fn scissors_beside_the_wall_do_not_point_towards_it() {
        let axis = VesselAxis::new([0.0; 3], [1.0, 0.0, 0.0]).expect("a direction");
        let of = |handle: [f64; 3]| {
            let mut tilt = Tilt::default();
            tilt.update(1, 1e-6, [3.0, 0.0, 2.0], handle, &axis);
            tilt.largest()
        };
        assert_eq!(of([1.0, 0.0, 0.0]), 0.0);
        assert_eq!(of([0.0, -1.0, 0.0]), 0.0);
        let diagonal = std::f64::consts::FRAC_1_SQRT_2;
        assert!((of([diagonal, 0.0, diagonal]) - FRAC_PI_4).abs() < 1e-12);
        // Tips that point away from the vessel do it no harm.
        assert_eq!(of([diagonal, 0.0, -diagonal]), 0.0);
    }

    /// Before the axis and behind it by as much, blades across the vessel lean by opposite angles, which cancel; what the next bite does is not averaged with it.
    #[test]
    fn a_bite_counts_as_a_whole_and_the_worst_one_decides() {
        let axis = VesselAxis::new([0.0; 3], [1.0, 0.0, 0.0]).expect("a direction");
        let mut tilt = Tilt::default();
        for y in [-1.0, 1.0] {
            tilt.update(1, 1e-6, [0.0, y, 1.0], [0.0, -1.0, 0.0], &axis);
        }
        assert!(tilt.largest() < 1e-12);
        let half = [0.0, -0.75_f64.sqrt(), 0.5];
        tilt.update(2, 1e-6, [0.0, 0.0, 1.0], half, &axis);
        tilt.update(3, 1e-6, [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], &axis);
        assert!((tilt.largest() - FRAC_PI_6).abs() < 1e-12);
    }
}
