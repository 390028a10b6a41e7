//! What hands at mouse and keyboard do, one after the other, so that the tools go where a script has them: motions of the pointer, of the wheel's keys, turns, rolls and openings.
//!
//! Nothing is seen and nothing is asked: like somebody who practised a level, the player knows how far the instruments go with the mouse, from `desktop.toml` and the help beside the picture.

use microsim_settings::{Desktop, DesktopConfig, View};
use microsim_tracking::{HandAngles, Script};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// The picture of a window of 1280 × 720: what the pointer has there \[pixels\], and the smaller side, of which the field takes all.
const PICTURE: [[f64; 2]; 2] = [[300.0, 25.0], [980.0, 695.0]];
const SIDE: f64 = 720.0;
const MIDDLE: [f64; 2] = [640.0, 360.0];
/// A place beside it, from which the pointer pulls nothing along.
const BESIDE: [&str; 2] = ["137", "500"];
/// A drag of the right button \[rad per pixel\], a step of the keys that roll \[rad\] and of those that open.
const TURN: f64 = 0.006;
const ROLL_STEP: f64 = 0.04;
const OPENING_STEP: f64 = 0.04;
/// What Shift leaves of a step.
const FINE: f64 = 0.25;
/// The longest time between two motions \[s\], and the largest turn between them \[rad\].
const PAUSE: f64 = 0.05;
const LARGEST_TURN: f64 = 0.06;
/// A picture comes within \[s\]. What is briefer than this \[s\] is followed by the next motion at once.
const PICTURE_TIME: f64 = 0.08;
const BRIEF: f64 = 0.35;
/// Hands that move at once in the script take turns of \[s\].
const TAKE_TURNS: f64 = 0.15;
/// How fast hands go to where a script begins \[m/s, rad/s\].
const APPROACH: [f64; 2] = [0.03, 1.5];
/// And how high above the middle [diameters of the field].
const ABOVE: f64 = 0.4;

/// What is asked of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Asked {
    tip: [f64; 3],
    angles: HandAngles,
    opening: f64,
}

/// Hands that are moved, and where they were asked to be.
pub struct Strokes {
    tools: Vec<String>,
    asked: Vec<Asked>,
    active: usize,
    pointer: [f64; 2],
    view: View,
    step: f64,
    /// What is done, command by command of xdotool, and how long each takes \[s\].
    commands: Vec<(Vec<String>, f64)>,
}

/// The angles with which a handle is turned so, the nearest ones to those before; jaws are the same after half a turn.
fn angles_of(orientation: [f64; 4], before: HandAngles) -> HandAngles {
    let [x, y, z, w] = orientation;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let (handle, jaws) = (turn * Vector3::z(), turn * Vector3::x());
    let elevation = handle.z.clamp(-1.0, 1.0).asin();
    let azimuth = match handle.xy().norm() > 1e-3 {
        true => handle.x.atan2(-handle.y),
        false => before.azimuth,
    };
    let near = |angle: f64, period: f64, to: f64| angle - period * ((angle - to) / period).round();
    let azimuth = near(azimuth, 2.0 * PI, before.azimuth);
    let (sin_a, cos_a) = azimuth.sin_cos();
    let (sin_e, cos_e) = elevation.sin_cos();
    let up = Vector3::new(-sin_a * sin_e, cos_a * sin_e, cos_e);
    let roll = jaws.dot(&handle.cross(&up)).atan2(jaws.dot(&up));
    HandAngles {
        azimuth,
        elevation,
        roll: near(roll, PI, before.roll),
    }
}

impl Strokes {
    /// The hands as a level begins.
    pub fn new(tools: Vec<String>, view: View, desktop: Desktop) -> Self {
        let config = DesktopConfig {
            desktop,
            tools: tools.clone(),
            centre: view.centre,
            field: view.field,
        };
        let hands = config.hands();
        let asked = hands.iter().map(|hand| {
            let state = hand.state();
            Asked {
                tip: state.tip[0],
                angles: state.angles[0],
                opening: state.opening[0],
            }
        });
        let mut strokes = Self {
            asked: asked.collect(),
            active: tools.len().saturating_sub(1),
            tools,
            pointer: MIDDLE,
            view,
            step: desktop.step * view.field,
            commands: Vec::new(),
        };
        strokes.back_to_the_middle();
        strokes
    }

    fn add(&mut self, words: &[&str]) {
        let words = words.iter().map(|word| (*word).to_owned());
        self.commands.push((words.collect(), 0.0));
    }

    fn wait(&mut self, seconds: f64) {
        if seconds > 1e-3 {
            let words = ["sleep".to_owned(), format!("{seconds:.3}")];
            self.commands.push((words.into(), seconds));
        }
    }

    fn back_to_the_middle(&mut self) {
        let [x, y] = MIDDLE.map(|c| c.to_string());
        self.add(&["mousemove", BESIDE[0], BESIDE[1], "mousemove", &x, &y]);
        self.pointer = MIDDLE;
    }

    /// Has the pointer where it stays in the picture when it moves by this much \[pixels\].
    fn make_room(&mut self, by: [f64; 2]) {
        let stays = |k: usize| (PICTURE[0][k]..=PICTURE[1][k]).contains(&(self.pointer[k] + by[k]));
        if !(0..2).all(stays) {
            self.back_to_the_middle();
        }
    }

    /// Moves the pointer by whole pixels.
    fn drag(&mut self, by: [f64; 2]) {
        if by == [0.0; 2] {
            return;
        }
        self.pointer = [self.pointer[0] + by[0], self.pointer[1] + by[1]];
        // A motion to a place: one by a distance is accelerated by the display.
        let [x, y] = self.pointer.map(|c| c.to_string());
        self.add(&["mousemove", &x, &y]);
    }

    fn take(&mut self, tool: usize) {
        while self.active != tool {
            self.add(&["key", "--delay", "2", "Tab"]);
            self.active = (self.active + 1) % self.tools.len();
        }
    }

    /// Moves the tip towards a place, as near as whole pixels and steps of keys come, which are the smaller ones with Shift.
    fn shift(&mut self, to: [f64; 3], is_fine: bool) {
        let asked = self.asked[self.active].tip;
        let scale = self.view.field / SIDE;
        let depth = scale / self.view.tilt.cos().max(0.3);
        let by = [(to[0] - asked[0]) / scale, (asked[1] - to[1]) / depth].map(f64::round);
        if !is_fine {
            self.make_room(by);
            self.drag(by);
            let tip = &mut self.asked[self.active].tip;
            *tip = [tip[0] + by[0] * scale, tip[1] - by[1] * depth, tip[2]];
        }
        let steps = self.press(["s", "w"], to[2] - asked[2], self.step, is_fine);
        self.asked[self.active].tip[2] += steps;
    }

    /// Presses one of two keys as often as comes nearest to what is to be done; what is done.
    fn press(&mut self, [less, more]: [&str; 2], by: f64, step: f64, is_fine: bool) -> f64 {
        let step = if is_fine { FINE * step } else { step };
        let count = (by / step).round();
        let key = if count < 0.0 { less } else { more };
        for _ in 0..count.abs() as u32 {
            self.add(&["key", "--delay", "2", key]);
        }
        count * step
    }

    fn turn(&mut self, to: HandAngles, is_fine: bool) {
        let asked = self.asked[self.active].angles;
        let by = [to.azimuth - asked.azimuth, to.elevation - asked.elevation];
        let by = by.map(|angle| (angle / TURN).round());
        if by != [0.0; 2] && !is_fine {
            // While the button is pressed every motion turns, also a leap.
            self.make_room(by);
            self.add(&["mousedown", "3"]);
            self.drag(by);
            self.add(&["mouseup", "3"]);
            let angles = &mut self.asked[self.active].angles;
            angles.azimuth += by[0] * TURN;
            angles.elevation += by[1] * TURN;
        }
        let roll = self.press(["q", "e"], to.roll - asked.roll, ROLL_STEP, is_fine);
        self.asked[self.active].angles.roll += roll;
    }

    fn open(&mut self, to: f64, is_fine: bool) {
        let by = to - self.asked[self.active].opening;
        // Large steps close no farther than that: a grip that is too firm for a moment crushes.
        let by = match is_fine {
            true => by,
            false => (by / OPENING_STEP + 1e-6 * by.signum()).trunc() * OPENING_STEP,
        };
        let opened = self.press(["a", "d"], by, OPENING_STEP, is_fine);
        let opening = &mut self.asked[self.active].opening;
        *opening = (*opening + opened).clamp(0.0, 1.0);
    }

    /// With Shift, what steps of a quarter can mend. Pictures come before and after, so that no motion of the pointer counts as fine.
    fn mend(&mut self, to: Asked) {
        let before = self.commands.len();
        self.shift(to.tip, true);
        self.turn(to.angles, true);
        self.open(to.opening, true);
        let fine = self.commands.split_off(before);
        if fine.is_empty() {
            return;
        }
        self.wait(PICTURE_TIME);
        self.add(&["keydown", "shift"]);
        self.wait(PICTURE_TIME);
        self.commands.extend(fine);
        self.wait(PICTURE_TIME);
        self.add(&["keyup", "shift"]);
        self.wait(PICTURE_TIME);
    }

    /// Has a tool go somewhere within a time \[s\].
    fn go(&mut self, tool: usize, to: Asked, seconds: f64) {
        self.take(tool);
        let from = self.asked[tool];
        let turn = turn_between(from.angles, to.angles);
        // The tip waits for the handle, which turns slower than a script may have it.
        let seconds = seconds.max(turn / APPROACH[1]);
        let pieces = (seconds / PAUSE)
            .max(turn / LARGEST_TURN)
            .ceil()
            .clamp(1.0, 400.0) as u32;
        for piece in 1..=pieces {
            let now = between_poses(from, to, f64::from(piece) / f64::from(pieces));
            self.shift(now.tip, false);
            self.turn(now.angles, false);
            self.open(now.opening, false);
            self.wait(seconds / f64::from(pieces));
        }
    }

    /// To where a script begins: over what lies between.
    fn approach(&mut self, tool: usize, first: Asked) {
        let above = self.view.centre[2] + ABOVE * self.view.field;
        let mut lifted = self.asked[tool];
        lifted.tip[2] = lifted.tip[2].max(above);
        let mut over = first;
        over.tip[2] = over.tip[2].max(above);
        for to in [lifted, over, first] {
            let from = self.asked[tool];
            let way = (Vector3::from(to.tip) - Vector3::from(from.tip)).norm();
            let turn = turn_between(from.angles, to.angles);
            self.go(tool, to, (way / APPROACH[0]).max(turn / APPROACH[1]));
        }
        self.mend(first);
    }

    fn target(&self, script: &Script, tool: usize, time: f64) -> Option<Asked> {
        let sample = script.sample(&self.tools[tool], time)?;
        Some(Asked {
            tip: sample.pose.position,
            angles: angles_of(sample.pose.orientation, self.asked[tool].angles),
            opening: sample.opening.unwrap_or_default(),
        })
    }

    /// All that is done for a script, command by command of xdotool, and how long each takes \[s\].
    pub fn of(mut self, script: &Script) -> Vec<(Vec<String>, f64)> {
        for tool in 0..self.tools.len() {
            if let Some(first) = self.target(script, tool, 0.0) {
                self.approach(tool, first);
            }
        }
        let keys = script.tracks().iter().flat_map(|track| &track.keyframes);
        let times: BTreeSet<u64> = keys.map(|key| (key.time_s * 1e6).round() as u64).collect();
        let times: Vec<f64> = times.into_iter().map(|time| time as f64 * 1e-6).collect();
        for between in times.windows(2) {
            let seconds = between[1] - between[0];
            let is_moved = |tool: &usize| {
                let at = |time| script.sample(&self.tools[*tool], time);
                let [before, after] = [between[0], between[1]].map(at);
                before.zip(after).is_some_and(|(before, after)| {
                    (before.pose, before.opening) != (after.pose, after.opening)
                })
            };
            // The last one first, which steadies or lifts for the other; what lowers goes after it, as
            // tissue that is lowered onto an open instrument would be pushed by it.
            let mut moved: Vec<usize> = (0..self.tools.len()).rev().filter(is_moved).collect();
            moved.sort_by_key(|&tool| {
                let height = |time| {
                    let sample = script.sample(&self.tools[tool], time);
                    sample.map_or(0.0, |sample| sample.pose.position[2])
                };
                height(between[1]) < height(between[0])
            });
            // What both hands do at once is done in turns.
            let turns = match moved.len() {
                0 | 1 => 1,
                _ => (seconds / TAKE_TURNS).ceil() as u32,
            };
            let from = self.asked.clone();
            let targets = moved
                .iter()
                .map(|&tool| self.target(script, tool, between[1]));
            let targets: Vec<Option<Asked>> = targets.collect();
            let targets = || {
                moved
                    .iter()
                    .zip(&targets)
                    .filter_map(|(tool, to)| Some((*tool, (*to)?)))
            };
            for turn in 1..=turns {
                for (tool, to) in targets() {
                    let to = between_poses(from[tool], to, f64::from(turn) / f64::from(turns));
                    // Both together take as long as in the script.
                    self.go(tool, to, seconds / f64::from(turns) / moved.len() as f64);
                }
            }
            if seconds > BRIEF {
                for (tool, to) in targets() {
                    self.take(tool);
                    self.mend(to);
                }
            }
            if moved.is_empty() {
                self.wait(seconds);
            }
        }
        self.commands
    }
}

/// A part of the motion from one to another.
fn between_poses(from: Asked, to: Asked, part: f64) -> Asked {
    let mix = |a: f64, b: f64| a + (b - a) * part;
    Asked {
        tip: std::array::from_fn(|k| mix(from.tip[k], to.tip[k])),
        angles: HandAngles {
            azimuth: mix(from.angles.azimuth, to.angles.azimuth),
            elevation: mix(from.angles.elevation, to.angles.elevation),
            roll: mix(from.angles.roll, to.angles.roll),
        },
        opening: mix(from.opening, to.opening),
    }
}

fn turn_between(from: HandAngles, to: HandAngles) -> f64 {
    let [a, e, r] = [
        to.azimuth - from.azimuth,
        to.elevation - from.elevation,
        to.roll - from.roll,
    ];
    a.abs().max(e.abs()).max(r.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_random::SplitMix64;

    /// A hand with the angles that are found is held as the one that was turned, up to half a turn about its shaft: the quaternion between the two is (0, 0, 0, 1) or (0, 0, 1, 0), and
    /// its azimuth and roll are the nearest of all that are.
    #[test]
    fn angles_are_those_of_the_handle() {
        let mut random = SplitMix64(1);
        for _ in 0..1000 {
            let mut within = |most: f64| most * random.number();
            let angles = HandAngles {
                azimuth: within(3.0),
                elevation: within(1.5),
                roll: within(6.0),
            };
            let before = HandAngles {
                azimuth: within(3.0),
                elevation: within(1.5),
                roll: within(6.0),
            };
            let found = angles_of(angles.orientation(), before);
            let [held, again] = [angles, found].map(|angles| {
                let [x, y, z, w] = angles.orientation();
                UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
            });
            let shaft = (held.inverse() * again).coords;
            assert!(shaft.x.hypot(shaft.y) < 1e-9, "{angles:?} {found:?}");
            assert!(
                shaft.z.abs() < 1e-9 || shaft.w.abs() < 1e-9,
                "{angles:?} {found:?}"
            );
            assert!((found.azimuth - before.azimuth).abs() <= PI + 1e-9);
            assert!((found.roll - before.roll).abs() <= PI / 2.0 + 1e-9);
        }
    }
}
