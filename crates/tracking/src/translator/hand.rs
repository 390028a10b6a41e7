//! The limits of a hand, and how far a sample is beyond them, compared with the samples before it.
//!
//! # What is compared
//! With h the time since the last sample that counts and h₀ that between the two whose difference is its velocity v, a motion of
//! acceleration a ≤ A and speed ≤ V brings a point p to p′ with
//!
//! ```text
//! |p′ − p|         ≤ V h            + 2 e
//! |p′ − (p + v h)| ≤ A h (h + h₀)/2 + 2 e (1 + h/h₀)
//! ```
//!
//! where no sample is off by more than e. The second bound is that of the difference quotient of second order; its noise term is what keeps
//! jitter and rounding from being taken for acceleration, however often a device samples: at 1 kHz a jitter of 0.1 mm alone looks like 100 m/s². Turns
//! and openings have bounds like the first one.
//!
//! Stamps jitter, come in bursts or stand still, so samples that are closer than [`SHORTEST_INTERVAL_S`] are compared as if they were so far apart.
//! The limits are those of the hand and hold in the device's frame, before any scale.

use super::track::{Point, SHORTEST_INTERVAL_S, Track};
use crate::filter::angle;
use crate::statistics::distance;
use microsim_vocabulary::MotionLimit;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What no hand goes beyond, and how far off samples of one that is at rest may be. Finite, above 0; the errors may be 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandLimits {
    /// Largest speed of the tip `[m/s]`.
    pub speed: f64,
    /// Largest acceleration of the tip `[m/s²]`.
    pub acceleration: f64,
    /// Largest speed of turning `[rad/s]`.
    pub turn_rate: f64,
    /// Largest change of the opening per time `[1/s]`, from 0 closed to 1 open.
    pub opening_rate: f64,
    /// Largest error of a position, jitter and rounding `[m]`.
    pub position_error: f64,
    /// Largest error of an orientation `[rad]`.
    pub turn_error: f64,
    /// Largest error of an opening.
    pub opening_error: f64,
    /// Samples elsewhere that are consistent with each other for this long are where the instrument is `[s]`.
    pub accept_after_s: f64,
}

/// By how much a sample is beyond a limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Excess {
    /// Which limit.
    pub limit: MotionLimit,
    /// The value, errors of samples subtracted, in the limit's unit.
    pub value: f64,
    /// What a hand reaches, in the same unit.
    pub bound: f64,
}

impl HandLimits {
    /// The name of the first that is not what it has to be, with its value.
    pub(super) fn fault(&self) -> Option<(&'static str, f64)> {
        let positive = [
            ("speed", self.speed),
            ("acceleration", self.acceleration),
            ("turn_rate", self.turn_rate),
            ("opening_rate", self.opening_rate),
            ("accept_after", self.accept_after_s),
        ];
        let errors = [
            ("position_error", self.position_error),
            ("turn_error", self.turn_error),
            ("opening_error", self.opening_error),
        ];
        let is_wrong = |value: f64| !value.is_finite() || value < 0.0;
        let positive = positive
            .into_iter()
            .find(|(_, value)| is_wrong(*value) || *value == 0.0);
        positive.or_else(|| errors.into_iter().find(|(_, value)| is_wrong(*value)))
    }

    /// The largest ratio of what a sample needs after those of a track to what a hand can do, and the limit that it is of; up to 1 a
    /// hand can have gone on to it. A hand is given `longest_s` `[s]` at most for it.
    pub(super) fn ratio(&self, track: &Track, next: &Point, longest_s: f64) -> (f64, Excess) {
        let last = track.last();
        let elapsed = (next.time_s - last.time_s).clamp(0.0, longest_s);
        let h = elapsed.max(SHORTEST_INTERVAL_S);
        let [from, to] = [last.position, next.position].map(Vector3::from);
        let rate = |limit, bound: f64, amount: f64, error: f64| {
            let value = (amount - 2.0 * error).max(0.0) / h;
            let excess = Excess {
                limit,
                value,
                bound,
            };
            (amount / (bound * h + 2.0 * error), excess)
        };
        let rates = [
            rate(
                MotionLimit::Speed,
                self.speed,
                distance(&to, &from),
                self.position_error,
            ),
            rate(
                MotionLimit::TurnRate,
                self.turn_rate,
                angle(last.orientation, next.orientation),
                self.turn_error,
            ),
            rate(
                MotionLimit::OpeningRate,
                self.opening_rate,
                (next.opening - last.opening).abs(),
                self.opening_error,
            ),
        ];
        // Where no velocity is known there is no acceleration.
        let acceleration = track.before().map(|before| {
            let h0 = last.time_s - before.time_s;
            let velocity = (from - Vector3::from(before.position)) / h0;
            let off = distance(&to, &(from + velocity * elapsed));
            let reach = h * (h + h0) / 2.0;
            let error = 2.0 * self.position_error * (1.0 + h / h0);
            let excess = Excess {
                limit: MotionLimit::Acceleration,
                value: (off - error).max(0.0) / reach,
                bound: self.acceleration,
            };
            (off / (self.acceleration * reach + error), excess)
        });
        // What is no number is no motion of a hand.
        let size = |ratio: f64| if ratio.is_nan() { f64::INFINITY } else { ratio };
        let ratios = rates.into_iter().chain(acceleration);
        let worst = ratios.map(|(ratio, excess)| (size(ratio), excess));
        let worst = worst.max_by(|a, b| a.0.total_cmp(&b.0));
        worst.expect("three ratios at least")
    }
}

impl fmt::Display for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.limit.unit();
        write!(
            f,
            "no hand makes a motion of {} {:.3} {unit} (limit {} {unit})",
            self.limit.name(),
            self.value,
            self.bound
        )
    }
}
