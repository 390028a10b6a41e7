//! Synthetic trainees: the plan of a script, followed as a hand does.
//!
//! The plan states where each tool should be when. A trainee is slower than it, pauses where all tools rest, misses where it
//! aims and how it holds the tool there, goes astray and beyond its end, closes jaws further than need be, and trembles. All of it is added to the plan:
//! a trainee with no error of any kind makes exactly the motion of the plan. Times of the tools stay together.
//!
//! These motions test software. That two groups of them differ follows from their parameters and shows nothing about people.
//!
//! - Between two keyframes a distance L apart the tip is beside the plan by `detour`·L and ahead of it by `lead`·L, most at
//!   90 % of the time. There 0.9 % of L is left of a movement with minimum jerk: it gets beyond its end by what the lead is above
//!   that, and comes back. Sizes are half-normal with this mean.
//! - It ends beside its end, and turned about the tip, by normal errors, which stay until the next movement.
//! - Tremor is a sum of sines between 8 and 12 Hz (Riviere 1997: RMS; DOMAIN 1), in real time, along all axes alike.

mod tremor;

use crate::random::Stream;
use crate::rotation::product;
use crate::script::{Keyframe, Script, ScriptError, ScriptTrack, minimum_jerk, mix};
use nalgebra::Vector3;
use tremor::Tremor;

/// Movements from this length on end with the whole aiming error \[m\].
const AIMED: f64 = 1e-3;
/// When within a movement it is farthest ahead of the plan, and from when on it is, as fractions of its time.
const AHEAD_AT: f64 = 0.9;
const AHEAD_FROM: f64 = 0.4;
/// Fraction of the time of an opening or closing within which the tremor grows to that of actuating, and falls from it.
const GROWS: f64 = 0.1;
/// Of the random streams of a trainee: own parameters, pauses; from `TOOLS` on two per tool, from `TURNS` on one.
const PARAMETERS: u64 = 0;
const PAUSES: u64 = 1;
const TOOLS: u64 = 2;
const TURNS: u64 = 1 << 32;

/// How a kind of trainees moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// RMS of the tremor between 8 and 12 Hz, all axes together, while the opening stands \[m\].
    pub tremor_still: f64,
    /// The same while the jaws are opened or closed \[m\].
    pub tremor_actuating: f64,
    /// Time for everything, relative to that of the plan; above 0.
    pub pace: f64,
    /// Chance of a pause where all tools rest.
    pub hesitation_chance: f64,
    /// Mean length of such a pause \[s\].
    pub hesitation: f64,
    /// Standard deviation along each axis of where a movement of at least 1 mm ends \[m\]; in proportion less for a shorter one.
    pub aiming_error: f64,
    /// Standard deviation about each axis of how the tool is turned where a movement of at least 1 mm ends \[rad\]; in proportion less
    /// for a shorter one.
    pub angular_error: f64,
    /// How far a movement gets ahead of the plan, relative to its length: beyond its end by what this is above 0.9 %.
    pub lead: f64,
    /// How far a movement goes astray to the side, relative to its length.
    pub detour: f64,
    /// How much further than planned jaws are closed, relative to the closing.
    pub grip_excess: f64,
    /// Standard deviation of the logarithm of the factor by which one trainee differs from this, for each of the above.
    pub spread: f64,
}

/// One trainee.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trainee {
    own: Profile,
    seed: u64,
}

impl Trainee {
    /// The trainee of this number; the same one for the same number.
    pub fn new(profile: &Profile, seed: u64) -> Self {
        let mut stream = Stream::new(seed, PARAMETERS);
        let mut own = |value: f64| value * libm::exp(profile.spread * stream.normal());
        Self {
            own: Profile {
                tremor_still: own(profile.tremor_still),
                tremor_actuating: own(profile.tremor_actuating),
                pace: own(profile.pace),
                hesitation_chance: own(profile.hesitation_chance).min(1.0),
                hesitation: own(profile.hesitation),
                aiming_error: own(profile.aiming_error),
                lead: own(profile.lead),
                detour: own(profile.detour),
                grip_excess: own(profile.grip_excess),
                // The last one drawn: those before it are the same as without it.
                angular_error: own(profile.angular_error),
                spread: profile.spread,
            },
            seed,
        }
    }

    /// The motion of this trainee along a plan: a keyframe for each sample at `rate_hz` \[1/s\], to be joined linearly.
    ///
    /// # Errors
    /// [`ScriptError`] where the plan's numbers are so large that the motion is not finite.
    ///
    /// # Panics
    /// If the rate is not a finite positive number.
    pub fn follow(&self, plan: &Script, rate_hz: f64) -> Result<Script, ScriptError> {
        assert!(
            rate_hz.is_finite() && rate_hz > 0.0,
            "a motion cannot be sampled at {rate_hz} Hz"
        );
        let course = Course::new(&self.own, self.seed, plan);
        let count = (course.real_time(plan.duration()) * rate_hz).ceil() as u64;
        let tracks = plan.tracks().iter().enumerate().map(|(index, track)| {
            let hand = Hand::new(&self.own, self.seed, index as u64, track);
            let samples = (0..=count).map(|k| k as f64 / rate_hz);
            let keyframes =
                samples.filter_map(|t| hand.keyframe(plan, track, course.plan_time(t), t));
            ScriptTrack {
                device: track.device.clone(),
                keyframes: keyframes.collect(),
            }
        });
        Script::new(tracks.collect(), crate::Interpolation::Linear)
    }
}

/// How the time of the plan passes.
struct Course {
    pace: f64,
    /// Where in the plan there is a pause, and how long \[s\], ascending.
    pauses: Vec<[f64; 2]>,
}

impl Course {
    fn new(own: &Profile, seed: u64, plan: &Script) -> Self {
        let mut stream = Stream::new(seed, PAUSES);
        let mut pauses = Vec::new();
        for time in rests(plan) {
            let (drawn, length) = (stream.unit(), stream.exponential());
            if drawn < own.hesitation_chance {
                pauses.push([time, length * own.hesitation]);
            }
        }
        Self {
            pace: own.pace,
            pauses,
        }
    }

    /// When the plan's time `u` is over \[s\].
    fn real_time(&self, u: f64) -> f64 {
        let before = self.pauses.iter().filter(|[at, _]| *at <= u);
        before.fold(self.pace * u, |t, [_, length]| t + length)
    }

    /// The plan's time at time `t` \[s\].
    fn plan_time(&self, t: f64) -> f64 {
        let mut paused = 0.0;
        for [at, length] in &self.pauses {
            let begins = self.pace * at + paused;
            if t <= begins {
                break;
            }
            if t < begins + length {
                return *at;
            }
            paused += length;
        }
        (t - paused) / self.pace
    }
}

/// The times of keyframes at which no tool moves, ascending.
fn rests(plan: &Script) -> Vec<f64> {
    let frames = plan.tracks().iter().flat_map(|track| &track.keyframes);
    let mut times: Vec<f64> = frames.map(|frame| frame.time_s).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let still = |track: &ScriptTrack, time: f64| {
        let frames = &track.keyframes;
        let next = frames.partition_point(|frame| frame.time_s <= time);
        let (Some(from), Some(to)) = (
            next.checked_sub(1).and_then(|at| frames.get(at)),
            frames.get(next),
        ) else {
            return true;
        };
        let stays = from.position == to.position
            && from.orientation == to.orientation
            && from.opening == to.opening;
        // A keyframe is a rest of its own.
        from.time_s == time || stays || time >= to.time_s
    };
    times.retain(|time| plan.tracks().iter().all(|track| still(track, *time)));
    times
}

/// The errors of a movement from one keyframe to the next.
struct Movement {
    /// Beside the plan at its begin and its end \[m\].
    aside: [Vector3<f64>; 2],
    /// Turned from the plan at its begin and its end, as a vector along the axis \[rad\].
    turned: [Vector3<f64>; 2],
    /// How far it gets ahead of the plan, and beside it \[m\].
    ahead: Vector3<f64>,
    astray: Vector3<f64>,
    /// What the opening is less than planned, at its begin and its end.
    squeeze: [f64; 2],
    /// Whether jaws are opened or closed.
    actuates: bool,
}

/// What one hand adds to its part of the plan.
struct Hand {
    movements: Vec<Movement>,
    tremor: Tremor,
    still: f64,
    actuating: f64,
}

impl Hand {
    fn new(own: &Profile, seed: u64, index: u64, track: &ScriptTrack) -> Self {
        let mut stream = Stream::new(seed, TOOLS + 2 * index);
        let mut turns = Stream::new(seed, TURNS + index);
        let (mut aside, mut turned, mut squeeze) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        let mut movements = Vec::new();
        for pair in track.keyframes.windows(2) {
            let path = Vector3::from(pair[1].position) - Vector3::from(pair[0].position);
            let length = path.norm();
            // Drawn for each movement alike, so that one parameter does not shift the numbers of another.
            let miss = normal_vector(&mut stream);
            let [ahead, astray, firmly] = [
                stream.half_normal(),
                stream.half_normal(),
                stream.half_normal(),
            ];
            let side = across(&path, &normal_vector(&mut stream));
            let fraction = (length / AIMED).min(1.0);
            let ends = between(&aside, &(miss * own.aiming_error), fraction);
            let turn = normal_vector(&mut turns);
            let turns_to = between(&turned, &(turn * own.angular_error), fraction);
            let closing = pair[0].opening - pair[1].opening;
            let squeezes = match closing {
                closing if closing > 0.0 => squeeze + own.grip_excess * closing * firmly,
                0.0 => squeeze,
                _ => 0.0,
            };
            movements.push(Movement {
                aside: [aside, ends],
                turned: [turned, turns_to],
                ahead: path * (own.lead * ahead),
                astray: side * (own.detour * astray * length),
                squeeze: [squeeze, squeezes],
                actuates: closing != 0.0,
            });
            (aside, turned, squeeze) = (ends, turns_to, squeezes);
        }
        Self {
            movements,
            tremor: Tremor::new(&mut Stream::new(seed, TOOLS + 2 * index + 1)),
            still: own.tremor_still,
            actuating: own.tremor_actuating,
        }
    }

    /// Where the hand is at time `t` \[s\], when it is at time `u` of its plan; `None` before the first keyframe.
    fn keyframe(&self, plan: &Script, track: &ScriptTrack, u: f64, t: f64) -> Option<Keyframe> {
        let frames = &track.keyframes;
        let from = frames
            .partition_point(|frame| frame.time_s <= u)
            .checked_sub(1)?;
        let planned = plan.sample(&track.device, u)?;
        let error = match (self.movements.get(from), frames.get(from + 1)) {
            (Some(movement), Some(to)) => {
                let begin = frames[from].time_s;
                let fraction = ((u - begin) / (to.time_s - begin)).max(0.0);
                movement.at(fraction, self.still, self.actuating)
            }
            _ => match self.movements.last() {
                Some(movement) => movement.at(1.0, self.still, self.actuating),
                None => Deviation {
                    shift: Vector3::zeros(),
                    turn: Vector3::zeros(),
                    squeeze: 0.0,
                    tremor: self.still,
                },
            },
        };
        let tremor = self.tremor.at(t, error.tremor);
        Some(Keyframe {
            time_s: t,
            position: (Vector3::from(planned.pose.position) + error.shift + tremor).into(),
            orientation: turned_by(planned.pose.orientation, &error.turn),
            opening: (planned.opening? - error.squeeze).max(0.0),
            visible: planned.visible,
        })
    }
}

/// How far a hand is from its plan at a moment.
struct Deviation {
    /// \[m\]
    shift: Vector3<f64>,
    /// About the tip, as a vector along the axis \[rad\].
    turn: Vector3<f64>,
    /// What the opening is less.
    squeeze: f64,
    /// RMS of the tremor \[m\].
    tremor: f64,
}

impl Movement {
    /// At a fraction of its time; RMS of the tremor \[m\] of an opening that stands, and of one that changes.
    fn at(&self, fraction: f64, still: f64, actuating: f64) -> Deviation {
        let done = minimum_jerk(fraction);
        let bulge = {
            let half = 4.0 * done * (1.0 - done);
            half * half
        };
        let ahead = if fraction < AHEAD_AT {
            minimum_jerk(((fraction - AHEAD_FROM) / (AHEAD_AT - AHEAD_FROM)).max(0.0))
        } else {
            1.0 - minimum_jerk((fraction - AHEAD_AT) / (1.0 - AHEAD_AT))
        };
        let aside = between(&self.aside[0], &self.aside[1], done);
        let shift = aside + self.ahead * ahead + self.astray * bulge;
        let effort = match self.actuates {
            true => minimum_jerk((fraction.min(1.0 - fraction) / GROWS).clamp(0.0, 1.0)),
            false => 0.0,
        };
        Deviation {
            shift,
            turn: between(&self.turned[0], &self.turned[1], done),
            squeeze: mix(self.squeeze[0], self.squeeze[1], fraction),
            tremor: mix(still, actuating, effort),
        }
    }
}

/// An orientation, turned in the field by a vector along the axis \[rad\].
fn turned_by(orientation: [f64; 4], turn: &Vector3<f64>) -> [f64; 4] {
    let angle = turn.norm();
    if angle == 0.0 {
        return orientation;
    }
    let [x, y, z] = (turn * libm::sin(0.5 * angle) / angle).into();
    product([x, y, z, libm::cos(0.5 * angle)], orientation)
}

/// [`mix`] of each component.
fn between(from: &Vector3<f64>, to: &Vector3<f64>, fraction: f64) -> Vector3<f64> {
    from.zip_map(to, |from, to| mix(from, to, fraction))
}

fn normal_vector(stream: &mut Stream) -> Vector3<f64> {
    Vector3::new(stream.normal(), stream.normal(), stream.normal())
}

/// The unit vector across `path` that is nearest to `to`, upwards; 0 where there is none.
fn across(path: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    let square = path.norm_squared();
    if square == 0.0 {
        return Vector3::zeros();
    }
    let side = to - path * (path.dot(to) / square);
    let length = side.norm();
    if length == 0.0 {
        return Vector3::zeros();
    }
    // What lies below is what one does not want to touch.
    let sign = if side.z < 0.0 { -1.0 } else { 1.0 };
    side * sign / length
}

#[cfg(test)]
mod tests;
