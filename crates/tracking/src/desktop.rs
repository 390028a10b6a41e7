//! Hands that mouse and keyboard move: a target that is asked for, and a tool that goes there as fast as a hand would.

use crate::rotation::fixed_unit;
use microsim_message::{DesktopInput, InputSample, Pose};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Lowest elevation of a handle \[rad\]: a hand has no room below the table.
const LOWEST: f64 = -FRAC_PI_2 / 3.0;

/// How fast a hand goes where it is asked to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesktopLimits {
    /// Fastest motion of the tip \[m/s\].
    pub speed: f64,
    /// Most acceleration of the tip \[m/s²\].
    pub acceleration: f64,
    /// By how much the tip is behind at a steady motion \[s\].
    pub lag: f64,
    /// Fastest change of each angle \[rad/s\].
    pub turn_rate: f64,
    /// Fastest change of the opening \[1/s\].
    pub opening_rate: f64,
}

/// How an instrument is held. Its handle lies in the direction (sin a cos e, −cos a cos e, sin e) of the field frame; with a roll of zero its jaws open in the
/// vertical plane through it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandAngles {
    /// Azimuth a of the handle from −y, towards +x \[rad\].
    pub azimuth: f64,
    /// Elevation e of the handle above the xy plane \[rad\].
    pub elevation: f64,
    /// Roll about the shaft \[rad\].
    pub roll: f64,
}

impl HandAngles {
    /// `field_from_tool`: quaternion x, y, z, w.
    pub fn orientation(&self) -> [f64; 4] {
        let (sin_a, cos_a) = libm::sincos(self.azimuth);
        let (sin_e, cos_e) = libm::sincos(self.elevation);
        let handle = Vector3::new(sin_a * cos_e, -cos_a * cos_e, sin_e);
        let up = Vector3::new(-sin_a * sin_e, cos_a * sin_e, cos_e);
        let (sin_r, cos_r) = libm::sincos(self.roll);
        let jaws = up * cos_r + handle.cross(&up) * sin_r;
        let axes = Matrix3::from_columns(&[jaws, handle.cross(&jaws), handle]);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let q = turn.coords;
        fixed_unit([q.x, q.y, q.z, q.w]).unwrap_or([0.0, 0.0, 0.0, 1.0])
    }

    fn parts(&self) -> [f64; 3] {
        [self.azimuth, self.elevation, self.roll]
    }

    fn of_parts([azimuth, elevation, roll]: [f64; 3]) -> Self {
        Self {
            azimuth,
            elevation,
            roll,
        }
    }
}

/// All that changes of a hand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesktopHandState {
    /// Where the tip is asked to be \[m\], where it is \[m\], and its velocity \[m/s\].
    pub tip: [[f64; 3]; 3],
    /// The angles that are asked for, and those that it has.
    pub angles: [HandAngles; 2],
    /// The opening that is asked for, and the one that it has.
    pub opening: [f64; 2],
}

/// A hand that mouse and keyboard move.
#[derive(Clone, Debug, PartialEq)]
pub struct DesktopHand {
    tool: String,
    limits: DesktopLimits,
    start: DesktopHandState,
    state: DesktopHandState,
}

impl DesktopHand {
    /// A hand at rest with its tip at a place of the field \[m\].
    pub fn new(
        tool: &str,
        limits: DesktopLimits,
        tip: [f64; 3],
        angles: HandAngles,
        opening: f64,
    ) -> Self {
        let start = DesktopHandState {
            tip: [tip, tip, [0.0; 3]],
            angles: [angles; 2],
            opening: [opening; 2],
        };
        Self {
            tool: tool.to_owned(),
            limits,
            start,
            state: start,
        }
    }

    /// The tool that it holds.
    pub fn tool(&self) -> &str {
        &self.tool
    }

    /// What changes of it.
    pub fn state(&self) -> DesktopHandState {
        self.state
    }

    /// Goes on from a saved state.
    pub fn restore(&mut self, state: DesktopHandState) {
        self.state = state;
    }

    /// Back to where it began.
    pub fn reset(&mut self) {
        self.state = self.start;
    }

    /// Takes over what is asked of it; numbers that are not finite ask for nothing.
    pub fn ask(&mut self, input: &DesktopInput) {
        let numbers = input.shift.iter().chain(&input.turn).chain(&input.opening);
        if !numbers.into_iter().all(|number| number.is_finite()) {
            return;
        }
        for (target, shift) in self.state.tip[0].iter_mut().zip(input.shift) {
            *target += shift;
        }
        let wanted = self.state.angles[0].parts();
        let [azimuth, elevation, roll] = std::array::from_fn(|k| wanted[k] + input.turn[k]);
        self.state.angles[0] = HandAngles {
            azimuth,
            elevation: elevation.clamp(LOWEST, FRAC_PI_2),
            roll,
        };
        if let Some(opening) = input.opening {
            self.state.opening[0] = opening.clamp(0.0, 1.0);
        }
    }

    /// Goes on by `dt` \[s\] towards what is asked, and gives the sample of then.
    ///
    /// The velocity that is wanted is the distance over the lag, at most `speed`; it changes by at most `acceleration` times `dt`.
    pub fn advance(&mut self, dt: f64, device_time: f64) -> InputSample {
        let limits = self.limits;
        let [target, tip, velocity] = self.state.tip.map(Vector3::from);
        let within = |vector: Vector3<f64>, most: f64| {
            let length = vector.norm();
            if length > most {
                vector * (most / length)
            } else {
                vector
            }
        };
        let wanted = within((target - tip) / limits.lag.max(dt), limits.speed);
        let velocity = velocity + within(wanted - velocity, limits.acceleration * dt);
        self.state.tip = [target, tip + velocity * dt, velocity].map(Into::into);

        let towards = |from: f64, to: f64, most: f64| from + (to - from).clamp(-most, most);
        let [wanted, angles] = self.state.angles.map(|angles| angles.parts());
        let turned = |k: usize| towards(angles[k], wanted[k], limits.turn_rate * dt);
        self.state.angles[1] = HandAngles::of_parts(std::array::from_fn(turned));
        let [wanted, opening] = self.state.opening;
        self.state.opening[1] = towards(opening, wanted, limits.opening_rate * dt);
        InputSample {
            device: self.tool.clone(),
            device_time,
            visible: true,
            pose: Pose {
                position: self.state.tip[1],
                orientation: self.state.angles[1].orientation(),
            },
            opening: Some(self.state.opening[1]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Quaternion;

    const LIMITS: DesktopLimits = DesktopLimits {
        speed: 0.08,
        acceleration: 4.0,
        lag: 0.04,
        turn_rate: 2.0,
        opening_rate: 2.0,
    };
    const DT: f64 = 0.008;

    fn hand() -> DesktopHand {
        DesktopHand::new("right", LIMITS, [0.0; 3], HandAngles::default(), 0.8)
    }

    /// The columns of the rotation are where jaws and handle have to be, from the formula of the documentation.
    #[test]
    fn the_handle_lies_where_its_angles_put_it() {
        let angles = HandAngles {
            azimuth: 0.4,
            elevation: 0.3,
            roll: 0.0,
        };
        let [x, y, z, w] = angles.orientation();
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let handle = turn * Vector3::z();
        let expected = [
            0.4f64.sin() * 0.3f64.cos(),
            -(0.4f64.cos()) * 0.3f64.cos(),
            0.3f64.sin(),
        ];
        assert!(
            (handle - Vector3::from(expected)).norm() < 1e-15,
            "{handle}"
        );
        // In the vertical plane through the handle, perpendicular to it and upwards.
        let jaws = turn * Vector3::x();
        assert!(jaws.dot(&handle).abs() < 1e-15 && jaws.z > 0.0);
        assert!(jaws.dot(&Vector3::z().cross(&handle)).abs() < 1e-15);

        // A quarter turn about the shaft lays them into the horizontal.
        let rolled = HandAngles {
            roll: FRAC_PI_2,
            ..angles
        };
        let [x, y, z, w] = rolled.orientation();
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        assert!((turn * Vector3::x()).z.abs() < 1e-15);
    }

    /// In the mirror x → −x a hand has the opposite azimuth and roll: its handle, and the line along which its jaws open, lie where the mirror images of these do. (The left
    /// jaw is then the right one: instruments are symmetric.)
    #[test]
    fn the_mirror_image_of_a_hand_has_the_opposite_azimuth_and_roll() {
        let axes = |side: f64| {
            let angles = HandAngles {
                azimuth: side * 0.4,
                elevation: 0.3,
                roll: side * 0.7,
            };
            let [x, y, z, w] = angles.orientation();
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
            [turn * Vector3::z(), turn * Vector3::x()]
        };
        for (seen, held) in axes(-1.0).iter().zip(axes(1.0)) {
            let mirrored = Vector3::new(-held.x, held.y, held.z);
            assert!((seen - mirrored).norm() < 1e-15, "{seen} {mirrored}");
        }
    }

    /// However far it is asked to go at once, speed and acceleration stay within their limits, and it arrives without going beyond.
    #[test]
    fn a_leap_of_the_pointer_is_a_motion_of_a_hand() {
        let mut hand = hand();
        hand.ask(&DesktopInput {
            shift: [0.02, 0.0, 0.0],
            ..DesktopInput::default()
        });
        let (mut last, mut last_velocity) = (0.0, 0.0);
        for tick in 0..250 {
            let sample = hand.advance(DT, f64::from(tick) * DT);
            let x = sample.pose.position[0];
            let velocity = (x - last) / DT;
            let rounding = 1e-12 / DT;
            assert!(velocity <= LIMITS.speed + rounding && velocity >= -rounding);
            assert!((velocity - last_velocity).abs() <= LIMITS.acceleration * DT + 2.0 * rounding);
            (last, last_velocity) = (x, velocity);
        }
        // What is left after so many lags is below a nanometre: 20 mm exp(−(2 s − 0.25 s)/0.04 s).
        assert!((last - 0.02).abs() < 1e-9, "{last}");
    }

    /// Angles and opening change by their rates and stop at what is asked; the handle goes no lower than it can.
    #[test]
    fn angles_and_opening_have_their_rates() {
        let mut hand = hand();
        hand.ask(&DesktopInput {
            turn: [0.1, -9.0, 0.0],
            opening: Some(0.0),
            ..DesktopInput::default()
        });
        let sample = hand.advance(DT, 0.0);
        assert!((sample.opening.unwrap() - (0.8 - LIMITS.opening_rate * DT)).abs() < 1e-15);
        assert!((hand.state().angles[1].azimuth - LIMITS.turn_rate * DT).abs() < 1e-15);
        for tick in 0..200 {
            hand.advance(DT, f64::from(tick) * DT);
        }
        let HandAngles {
            azimuth, elevation, ..
        } = hand.state().angles[1];
        assert_eq!((hand.state().opening[1], elevation), (0.0, LOWEST));
        assert!((azimuth - 0.1).abs() < 1e-15);
    }

    #[test]
    fn numbers_that_are_none_ask_for_nothing() {
        let mut hand = hand();
        let before = hand.state();
        hand.ask(&DesktopInput {
            shift: [f64::NAN, 1.0, 0.0],
            opening: Some(0.0),
            ..DesktopInput::default()
        });
        assert_eq!(hand.state(), before);
    }
}
