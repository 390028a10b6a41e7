//! The one-euro filter (Casiez, Roussel & Vogel 2012, CHI '12, 2527): a low-pass filter of first order whose cutoff rises with speed, so that
//! a hand at rest is smoothed and one that moves is not held back.
//!
//! With T the time since the last sample, v the speed and τ(f) = 1/(2π f):
//!
//! ```text
//! f  = min_cutoff + beta v
//! x̂ += (x − x̂) / (1 + τ(f)/T)
//! ```
//!
//! The speed is that of the samples, low-passed with `derivative_cutoff`. All three axes have one cutoff, so that the result does not depend on how the axes lie. Orientations
//! are filtered by spherical interpolation with the angle in the place of the distance; openings are not filtered.
//!
//! # Delay
//! A steady motion comes out later by exactly τ(f), at any rate of samples: 1/(2π min_cutoff) at the slowest, less the faster ([`OneEuro::delay`]).
//!
//! # Prediction
//! Off unless asked for. Poses go on from the filtered one for a time p, steadily: positions with the velocity of the filter, orientations about the axis and with the rate of the last
//! turn from one filtered orientation to the next.
//!
//! ```text
//! x̂(t + p) = x̂ + p v        q̂(t + p) = (q̂ q̂₀⁻¹)^(p/T) q̂
//! ```
//!
//! A steady motion or turn then comes out later by τ(f) − p: with p = τ(f) it is where it is. Any other motion is not: what is off for a sine, of its amplitude, is |G(f) − 1| with
//! the gain G of filter and prediction together, in closed form ([`OneEuro::sine_error`]). At high frequencies G grows with p, so that jitter and tremor do: an angle that is predicted by τ(f) is
//! that of no filter at all (G = 1), with all of its tremor; positions, whose velocity is low-passed, get less of it back and are off more.

use crate::rotation::slerp;
use crate::statistics::distance;
use nalgebra::{Complex, Quaternion, Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How samples are filtered. All numbers are finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneEuro {
    /// Cutoff at rest, above 0 `[Hz]`.
    pub min_cutoff: f64,
    /// By how much the cutoff rises with the speed of the position, 0 or more `[Hz per m/s]`.
    pub beta: f64,
    /// By how much it rises with the speed of turning, 0 or more `[Hz per rad/s]`.
    pub turn_beta: f64,
    /// Cutoff of the speeds, above 0 `[Hz]`.
    pub derivative_cutoff: f64,
    /// How far ahead poses are predicted, 0 or more `[s]`; 0 is off.
    pub predict_s: f64,
}

/// What a filter remembers of a device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Filtered {
    time_s: f64,
    raw_position: [f64; 3],
    raw_orientation: [f64; 4],
    position: [f64; 3],
    orientation: [f64; 4],
    velocity: [f64; 3],
    turn_rate: f64,
}

impl OneEuro {
    /// By how much a steady motion of this speed comes out later `[s]`, without prediction.
    pub fn delay(&self, speed: f64) -> f64 {
        1.0 / (2.0 * PI * (self.min_cutoff + self.beta * speed))
    }

    /// What is off for a sine of `frequency` \[Hz\] that is sampled each `interval` \[s\], of its amplitude: of a position, and of an angle about an axis that stays. Exact where the cutoff does not depend on
    /// the speed (`beta` and `turn_beta` are 0). Follows from the difference equations with z⁻¹ = e^(−iω T):
    ///
    /// ```text
    /// H(c) = a/(1 − (1 − a) z⁻¹), a the weight of a sample with the cutoff c
    /// G    = H(min_cutoff) + p (1 − z⁻¹)/T · H(derivative_cutoff)    of a position
    /// G    = H(min_cutoff) (1 + p (1 − z⁻¹)/T)                       of an angle
    /// ```
    pub fn sine_error(&self, frequency: f64, interval: f64) -> [f64; 2] {
        let phase = 2.0 * PI * frequency * interval;
        let back = Complex::new(libm::cos(phase), -libm::sin(phase));
        let one = Complex::new(1.0, 0.0);
        let gain = |cutoff| {
            let a = weight(cutoff, interval);
            one * a / (one - back * (1.0 - a))
        };
        let rate = (one - back) * (self.predict_s / interval);
        let low = gain(self.min_cutoff);
        let position = low + rate * gain(self.derivative_cutoff);
        let off = |gain: Complex<f64>| libm::hypot(gain.re - 1.0, gain.im);
        [off(position), off(low + low * rate)]
    }

    /// The name of the first number that is not what it has to be, with its value.
    pub fn fault(&self) -> Option<(&'static str, f64)> {
        let above = [
            ("min_cutoff", self.min_cutoff),
            ("derivative_cutoff", self.derivative_cutoff),
        ];
        let not_below = [
            ("beta", self.beta),
            ("turn_beta", self.turn_beta),
            ("predict", self.predict_s),
        ];
        let is_wrong = |value: f64| !value.is_finite() || value < 0.0;
        let above = above
            .into_iter()
            .find(|(_, value)| is_wrong(*value) || *value == 0.0);
        above.or_else(|| not_below.into_iter().find(|(_, value)| is_wrong(*value)))
    }

    /// Takes a pose at `time_s` `[s]` of the device's clock, and gives the filtered one. After more than `gap_s` `[s]`, or where the clock does not go on, the
    /// filter starts again: nothing is joined across a gap.
    pub fn step(
        &self,
        memory: &mut Option<Filtered>,
        time_s: f64,
        position: [f64; 3],
        orientation: [f64; 4],
        gap_s: f64,
    ) -> ([f64; 3], [f64; 4]) {
        let before = memory.filter(|before| {
            let elapsed = time_s - before.time_s;
            elapsed > 0.0 && elapsed <= gap_s
        });
        let next = match before {
            None => Filtered {
                time_s,
                raw_position: position,
                raw_orientation: orientation,
                position,
                orientation,
                velocity: [0.0; 3],
                turn_rate: 0.0,
            },
            Some(before) => self.go_on(&before, time_s, position, orientation),
        };
        *memory = Some(next);
        if self.predict_s == 0.0 {
            return (next.position, next.orientation);
        }
        let ahead = std::array::from_fn(|i| next.position[i] + self.predict_s * next.velocity[i]);
        let turned = before.map_or(next.orientation, |before| {
            let part = self.predict_s / (next.time_s - before.time_s);
            turned_on(before.orientation, next.orientation, part)
        });
        (ahead, turned)
    }

    fn go_on(
        &self,
        before: &Filtered,
        time_s: f64,
        position: [f64; 3],
        orientation: [f64; 4],
    ) -> Filtered {
        let elapsed = time_s - before.time_s;
        let slow = weight(self.derivative_cutoff, elapsed);
        let velocity: [f64; 3] = std::array::from_fn(|i| {
            let now = (position[i] - before.raw_position[i]) / elapsed;
            before.velocity[i] + slow * (now - before.velocity[i])
        });
        let turned = angle(before.raw_orientation, orientation) / elapsed;
        let turn_rate = before.turn_rate + slow * (turned - before.turn_rate);
        let speed = distance(&Vector3::from(velocity), &Vector3::zeros());
        let moved = weight(self.min_cutoff + self.beta * speed, elapsed);
        let turned = weight(self.min_cutoff + self.turn_beta * turn_rate, elapsed);
        Filtered {
            time_s,
            raw_position: position,
            raw_orientation: orientation,
            position: std::array::from_fn(|i| {
                before.position[i] + moved * (position[i] - before.position[i])
            }),
            orientation: slerp(before.orientation, orientation, turned),
            velocity,
            turn_rate,
        }
    }
}

/// How much of the difference a sample takes away.
fn weight(cutoff: f64, elapsed: f64) -> f64 {
    1.0 / (1.0 + 1.0 / (2.0 * PI * cutoff * elapsed))
}

/// The orientation that a steady turn from one to the next comes to when it goes on for `part` of the time between them.
fn turned_on(from: [f64; 4], to: [f64; 4], part: f64) -> [f64; 4] {
    let angle = angle(from, to);
    let [from, to] = [from, to].map(|q| Unit::new_unchecked(Quaternion::from(q)));
    let turn: UnitQuaternion<f64> = to * from.inverse();
    let Some(axis) = Unit::try_new(turn.imag(), 0.0) else {
        return to.coords.into();
    };
    // q and −q are the same turn; this is the one by the smaller angle.
    let half = 0.5 * part * angle.copysign(turn.w);
    let (sine, cosine) = (libm::sin(half), libm::cos(half));
    let [x, y, z] = (axis.into_inner() * sine).into();
    let on = Unit::new_unchecked(Quaternion::new(cosine, x, y, z));
    UnitQuaternion::new_normalize((on * to).into_inner())
        .coords
        .into()
}

/// The angle of the rotation between two unit quaternions `[rad]`.
pub(crate) fn angle(a: [f64; 4], b: [f64; 4]) -> f64 {
    let (mut difference, mut sum) = (0.0, 0.0);
    for axis in 0..4 {
        difference += (a[axis] - b[axis]) * (a[axis] - b[axis]);
        sum += (a[axis] + b[axis]) * (a[axis] + b[axis]);
    }
    // q and −q are the same orientation.
    4.0 * libm::atan2(difference.min(sum).sqrt(), difference.max(sum).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: OneEuro = OneEuro {
        min_cutoff: 2.0,
        beta: 0.0,
        turn_beta: 0.0,
        derivative_cutoff: 1.0,
        predict_s: 0.0,
    };
    const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

    fn about_z(angle: f64) -> [f64; 4] {
        [0.0, 0.0, libm::sin(angle / 2.0), libm::cos(angle / 2.0)]
    }

    /// The last of a motion that lasts for 10 s, sampled at `rate`.
    fn last(filter: OneEuro, rate: f64, place: impl Fn(f64) -> f64) -> (f64, [f64; 3], [f64; 4]) {
        let mut memory = None;
        let mut found = (0.0, [0.0; 3], UPRIGHT);
        for step in 0..(10.0 * rate) as i32 {
            let time = f64::from(step) / rate;
            let (p, q) = filter.step(
                &mut memory,
                time,
                [place(time), 0.0, 0.0],
                about_z(place(time)),
                1.0,
            );
            found = (time, p, q);
        }
        found
    }

    /// Closed form: behind a ramp the filter of first order is late by τ, however often it is fed; after 10 s the start is e^(−10/0.08) of it.
    #[test]
    fn a_steady_motion_is_late_by_the_stated_delay() {
        for rate in [50.0, 100.0, 1000.0] {
            let speed = 0.05;
            let (time, position, orientation) = last(PLAIN, rate, |t| speed * t);
            let late = time - position[0] / speed;
            assert!(
                (late - PLAIN.delay(speed)).abs() < 1e-9,
                "{rate} Hz: {late}"
            );
            let turned = 2.0 * libm::atan2(orientation[2], orientation[3]);
            assert!(
                (time - turned / speed - PLAIN.delay(0.0)).abs() < 1e-9,
                "{rate} Hz: {turned}"
            );
            let adaptive = OneEuro {
                beta: 100.0,
                ..PLAIN
            };
            let (time, position, _) = last(adaptive, rate, |t| speed * t);
            let late = time - position[0] / speed;
            // 2 Hz and 100 · 0.05 Hz; the speed itself is low-passed with 1 Hz and exact by then.
            assert!(
                (late - 1.0 / (2.0 * PI * 7.0)).abs() < 1e-9,
                "{rate} Hz: {late}"
            );
            assert_eq!(adaptive.delay(speed), 1.0 / (2.0 * PI * 7.0));
        }
    }

    /// A steady motion and turn that are predicted by the delay are where they are, at any rate; with 30 ms more they are 30 ms ahead.
    #[test]
    fn prediction_by_the_delay_takes_it_away() {
        for rate in [50.0, 100.0, 1000.0] {
            for more in [0.0, 0.03] {
                let filter = OneEuro {
                    predict_s: PLAIN.delay(0.0) + more,
                    ..PLAIN
                };
                for speed in [0.05, -0.2] {
                    let (time, position, orientation) = last(filter, rate, |t| speed * t);
                    let place = speed * (time + more);
                    assert!((position[0] - place).abs() < 1e-9, "{position:?} at {time}");
                    let turned = 2.0 * libm::atan2(orientation[2], orientation[3]);
                    assert!((turned - place).abs() < 1e-9, "{turned} at {time}");
                }
            }
        }
    }

    /// Without a sample before there is nothing to go on with; half a turn and more between two samples is a turn by the smaller angle in the other direction.
    #[test]
    fn a_turn_goes_on_about_its_axis() {
        let mut memory = None;
        let filter = OneEuro {
            predict_s: 0.2,
            ..PLAIN
        };
        let first = filter.step(&mut memory, 0.0, [1.0; 3], about_z(0.4), 1.0);
        assert_eq!(first, ([1.0; 3], about_z(0.4)));
        let still = filter.step(&mut memory, 0.01, [1.0; 3], about_z(0.4), 1.0);
        assert_eq!(still, first);
        for (from, by, part, to) in [
            (0.2, 0.1, 3.0, 0.6),
            (0.2, -0.1, 0.5, 0.05),
            (0.2, 2.0 * PI - 0.1, 1.0, 0.0),
        ] {
            let found = turned_on(about_z(from), about_z(from + by), part);
            assert!(angle(found, about_z(to)) < 1e-12, "{from} {by}: {found:?}");
        }
    }

    /// A sine and what comes out for it, sampled ten thousand times: twice the mean of the square of the difference is the square of its amplitude, which the closed form states.
    #[test]
    fn a_sine_is_off_by_what_the_difference_equation_states() {
        for rate in [60.0, 100.0, 1000.0] {
            for predict_s in [0.0, 0.02, PLAIN.delay(0.0), 0.2] {
                // Whole periods in a whole number of samples: 10 s of both at each rate.
                for frequency in [0.5, 1.0, 2.0, 9.0] {
                    let filter = OneEuro { predict_s, ..PLAIN };
                    let mut memory = None;
                    let (mut off, mut count) = ([0.0; 2], 0.0);
                    for step in 0..(20.0 * rate) as i32 {
                        let time = f64::from(step) / rate;
                        let place = 0.1 * libm::sin(2.0 * PI * frequency * time + 0.3);
                        let at = [0.0, place, 0.0];
                        let (p, q) = filter.step(&mut memory, time, at, about_z(place), 1.0);
                        if step >= (10.0 * rate) as i32 {
                            let turned = 2.0 * libm::atan2(q[2], q[3]);
                            off[0] += (p[1] - place) * (p[1] - place);
                            off[1] += (turned - place) * (turned - place);
                            count += 1.0;
                        }
                    }
                    let stated = filter.sine_error(frequency, 1.0 / rate);
                    for (off, stated) in off.iter().zip(stated) {
                        let found = (2.0 * off / count).sqrt() / 0.1;
                        assert!(
                            (found - stated).abs() < 1e-9,
                            "{rate} Hz, {predict_s} s, {frequency} Hz: {found} {stated}"
                        );
                    }
                }
            }
        }
    }

    /// Gain of the discrete filter at a frequency, |α / (1 − (1 − α) e^(−iω T))|, from its difference equation.
    #[test]
    fn a_sine_comes_out_with_the_gain_of_the_difference_equation() {
        let (rate, frequency) = (100.0, 10.0);
        let mut memory = None;
        let mut largest = 0.0_f64;
        for step in 0..2000 {
            let time = f64::from(step) / rate;
            let place = libm::sin(2.0 * PI * frequency * time + 0.3);
            let (p, _) = PLAIN.step(&mut memory, time, [place, 0.0, 0.0], UPRIGHT, 1.0);
            if step > 1000 {
                largest = largest.max(p[0].abs());
            }
        }
        let a = weight(2.0, 1.0 / rate);
        let phase = 2.0 * PI * frequency / rate;
        let real = 1.0 - (1.0 - a) * libm::cos(phase);
        let imaginary = (1.0 - a) * libm::sin(phase);
        let gain = a / (real * real + imaginary * imaginary).sqrt();
        // Ten samples per period: one of them is within 18° of the peak, and less is found than the amplitude by up to 1 − cos 18°.
        assert!(
            largest <= gain * (1.0 + 1e-9) && largest >= gain * libm::cos(PI / 10.0),
            "{largest} {gain}"
        );
    }

    #[test]
    fn nothing_is_joined_across_a_gap() {
        let mut memory = None;
        PLAIN.step(&mut memory, 0.0, [0.0; 3], UPRIGHT, 0.1);
        for (time, place) in [(0.3, 1.0), (0.2, 2.0), (0.2, 3.0)] {
            let (p, q) = PLAIN.step(&mut memory, time, [place, 0.0, 0.0], about_z(place), 0.1);
            assert_eq!((p, q), ([place, 0.0, 0.0], about_z(place)));
        }
        let (p, _) = PLAIN.step(&mut memory, 0.25, [4.0, 0.0, 0.0], UPRIGHT, 0.1);
        assert!(p[0] > 3.0 && p[0] < 4.0, "{p:?}");
    }

    #[test]
    fn numbers_that_make_no_filter_are_named() {
        assert_eq!(PLAIN.fault(), None);
        assert_eq!(
            OneEuro {
                min_cutoff: 0.0,
                ..PLAIN
            }
            .fault(),
            Some(("min_cutoff", 0.0))
        );
        assert_eq!(
            OneEuro {
                predict_s: -1.0,
                ..PLAIN
            }
            .fault(),
            Some(("predict", -1.0))
        );
        assert!(
            OneEuro {
                beta: f64::NAN,
                ..PLAIN
            }
            .fault()
            .is_some()
        );
    }
}
