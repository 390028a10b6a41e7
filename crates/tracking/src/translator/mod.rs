//! From devices to tools: the translator (chapter 5.2.1 of the dissertation).
//!
//! A device knows nothing of tools and a tool nothing of devices: a [`Mapping`] states which device drives which tool, and
//! how the device frame lies in the field. With p the position and q the orientation of a sample,
//!
//! ```text
//! position in field = field_offset + scale · R(field_from_device) · (p + R(q) · tip − device_origin)
//! field_from_tool   = field_from_device · q · body_from_tool
//! ```
//!
//! The scale acts on positions alone: a hand that moves 10 mm may move the tip 1 mm, but turns it as far as itself. The
//! tip in the frame of the handle is the lever from the point that the tracker follows; without one the position of a sample is that of the tip.
//!
//! # Samples that no hand makes
//! A sample that no hand can have come to from those before it ([`HandLimits`]) is left out: as if it had not arrived, so that the tool stands where it
//! was last, and for whoever counts motion the tool is lost at its time. One that stands so for as long as makes a tool stale is occluded, and touches nothing.
//! A jump that lasts is accepted after a time, and the tool is occluded before, so that it does not sweep from one place to the other.
//!
//! # Filters and clutches
//! Samples that count can be filtered for each device ([`OneEuro`](crate::OneEuro)), and a [`Clutch`] holds tips. Neither is there unless it is asked for, and without
//! them every pose has the same bits.
//!
//! # Clocks
//! Samples carry the time of their device. Whether a tool still receives samples follows from when they *arrive* in the session's
//! time, since the two clocks need not agree.

mod hand;
mod mapping;
mod motion;
mod plausible;
mod state;
mod track;

use std::error::Error;
use std::fmt;

pub use hand::{Excess, HandLimits};
pub use mapping::{Mapping, MappingProblem, Opening, TranslatorError};
pub use motion::{Clutch, MotionState};
pub use state::{StateMismatch, TrackedTool, TranslatorState};

use crate::QuaternionError;
use crate::filter::OneEuro;
use crate::rotation::{checked_unit, product, rotated};
use microsim_message::{InputSample, Pose, ToolPose, ToolSample};
use microsim_vocabulary::ToolStatus;
use motion::Motion;
use track::Point;

/// Turns samples of devices into poses of tools, and remembers the last of each.
///
/// The mappings are constant; all that changes is the [`TranslatorState`].
#[derive(Clone, Debug)]
pub struct Translator {
    mappings: Vec<Mapping>,
    stale_after_s: f64,
    hand: HandLimits,
    motion: Motion,
    state: TranslatorState,
    motion_state: MotionState,
}

/// A sample that cannot be used. It has been counted for its tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// Name of the tool.
    pub tool: String,
    /// Name of the device.
    pub device: String,
    /// Time of the sample by the device's clock `[s]`.
    pub time_s: f64,
    /// What is wrong with it.
    pub fault: SampleFault,
    /// How many samples of the tool have been refused so far for what is wrong with them, or left out as no hand makes them, with this one.
    pub count: u64,
}

/// What is wrong with a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleFault {
    /// Its time is not finite.
    Time,
    /// Its position is not finite, or becomes so in the field.
    Position,
    /// Its opening is not finite.
    Opening,
    /// Its orientation is none.
    Orientation(QuaternionError),
    /// No hand makes such a motion.
    Implausible(Excess),
}

impl Translator {
    /// A translator whose tools stand in the order of their mappings and have not been seen yet. A tool is stale when
    /// for more than `stale_after_s` `[s]` no sample of its device has arrived. All devices are in hands of these limits.
    ///
    /// # Errors
    /// [`TranslatorError`] if a mapping breaks a rule of [`Mapping`], if two have the same tool or device, if
    /// `stale_after_s` is not a finite positive number, or a limit breaks a rule of [`HandLimits`].
    pub fn new(
        mut mappings: Vec<Mapping>,
        stale_after_s: f64,
        hand: HandLimits,
    ) -> Result<Self, TranslatorError> {
        if !(stale_after_s.is_finite() && stale_after_s > 0.0) {
            return Err(TranslatorError::StaleAfter(stale_after_s));
        }
        if let Some((name, value)) = hand.fault() {
            return Err(TranslatorError::HandLimit(name, value));
        }
        mapping::check(&mut mappings)?;
        let state = TranslatorState::new(&mappings);
        Ok(Self {
            mappings,
            stale_after_s,
            hand,
            motion: Motion::default(),
            state,
            motion_state: MotionState::default(),
        })
    }

    /// The same with filters of devices, and clutches.
    ///
    /// # Errors
    /// [`TranslatorError`] if a number of a filter is out of its range, a name is not one of the mappings', or the device of a clutch drives a tool.
    pub fn with_motion(
        mut self,
        filters: Vec<(String, OneEuro)>,
        clutches: Vec<Clutch>,
    ) -> Result<Self, TranslatorError> {
        self.motion = Motion::new(&self.mappings, filters, clutches)?;
        self.motion_state = self.motion.start();
        Ok(self)
    }

    /// Takes one sample that has arrived at `now_s` `[s]` of the session; arrivals come in the order of their times.
    ///
    /// Gives the sample of the tool that the device drives; [`Translator::lost`] if it was not visible.
    ///
    /// # Errors
    /// [`Refusal`] for a visible sample with values that are no pose: its tool is then occluded and keeps its last pose. The same for one that no hand
    /// makes, whose tool stands where it was.
    pub fn feed(
        &mut self,
        sample: &InputSample,
        now_s: f64,
    ) -> Result<Option<ToolSample>, Refusal> {
        let Some(index) = self.driven_by(&sample.device) else {
            let tools = &self.state.tools;
            let tip = |tool: usize| Some(tools[tool].pose()?.pose.position);
            self.motion
                .press(&mut self.motion_state, &self.mappings, sample, tip);
            return Ok(None);
        };
        let mapping = &self.mappings[index];
        let memory = &mut self.state.tools[index];
        let (motion, motion_state) = (&self.motion, &mut self.motion_state);
        let stale_after_s = self.stale_after_s;
        if !sample.visible {
            memory.arrived(now_s, stale_after_s, TrackedTool::lose);
            motion.interrupt(motion_state, index);
            return Ok(self.lost(sample));
        }
        let refused = match translate(mapping, sample, memory.opening()) {
            Ok((point, pose)) => {
                let hand = &self.hand;
                let left_out = memory.arrived(now_s, stale_after_s, |memory| {
                    memory.see(point, now_s, hand, || {
                        let seen = (point.time_s, point.position, point.orientation);
                        let filtered = motion.filter(motion_state, index, seen, stale_after_s);
                        let pose = match filtered {
                            None => pose,
                            Some((tip, orientation)) => ToolPose {
                                pose: in_field(mapping, tip, orientation),
                                ..pose
                            },
                        };
                        let at = motion.place(motion_state, mapping, index, pose.pose.position);
                        ToolPose {
                            pose: Pose {
                                position: at,
                                ..pose.pose
                            },
                            ..pose
                        }
                    })
                });
                match (left_out, memory.pose()) {
                    (None, Some(pose)) => {
                        return Ok(Some(ToolSample::new(&mapping.tool, true, pose)));
                    }
                    // A tool that counts has a pose.
                    (None, None) => return Ok(None),
                    (Some(excess), _) => {
                        if !memory.is_seen() {
                            self.motion.interrupt(&mut self.motion_state, index);
                        }
                        (SampleFault::Implausible(excess), memory.implausible())
                    }
                }
            }
            Err(fault) => {
                memory.arrived(now_s, stale_after_s, TrackedTool::refuse);
                motion.interrupt(motion_state, index);
                (fault, memory.refused())
            }
        };
        Err(Refusal {
            tool: mapping.tool.clone(),
            device: mapping.device.clone(),
            time_s: sample.device_time,
            fault: refused.0,
            count: refused.1,
        })
    }

    /// The tool that the device of a sample drives, not tracked at the time of the sample, with its last valid pose: for whoever
    /// counts motion, where a segment ends. `None` if the device drives none, or the tool was never seen.
    pub fn lost(&self, sample: &InputSample) -> Option<ToolSample> {
        let tool = &self.state.tools[self.driven_by(&sample.device)?];
        let last = tool.pose()?;
        let at = ToolPose {
            time: sample.device_time,
            ..last
        };
        Some(ToolSample::new(tool.name(), false, at))
    }

    fn driven_by(&self, device: &str) -> Option<usize> {
        let mut mappings = self.mappings.iter();
        mappings.position(|mapping| mapping.device == device)
    }

    /// The mappings, in the order of the tools.
    pub fn mappings(&self) -> &[Mapping] {
        &self.mappings
    }

    /// All tools, in the order of their mappings.
    pub fn tools(&self) -> &[TrackedTool] {
        &self.state.tools
    }

    /// How well one of its tools is known at `now_s` `[s]` of the session, and since when.
    pub fn status(&self, tool: &TrackedTool, now_s: f64) -> (ToolStatus, f64) {
        let status = tool.status(now_s, self.stale_after_s);
        (status, tool.since(now_s, self.stale_after_s))
    }

    /// All that changes while samples arrive, to be saved, but for what filters and clutches remember.
    pub fn state(&self) -> &TranslatorState {
        &self.state
    }

    /// What filters and clutches remember, to be saved; `None` where there is neither.
    pub fn motion_state(&self) -> Option<&MotionState> {
        self.motion.is_any().then_some(&self.motion_state)
    }

    /// Whether a device holds tips and drives no tool.
    pub fn is_clutch(&self, device: &str) -> bool {
        self.motion.has_clutch(device)
    }

    /// Goes on from what filters and clutches remembered; whether it is of the same filters and clutches, otherwise nothing is changed.
    pub fn restore_motion(&mut self, state: MotionState) -> bool {
        let fits = self.motion.fits(&state);
        if fits {
            self.motion_state = state;
        }
        fits
    }

    /// Goes on from a saved state.
    ///
    /// # Errors
    /// [`StateMismatch`], with nothing changed, if the state was saved with other tools.
    pub fn restore(&mut self, state: TranslatorState) -> Result<(), StateMismatch> {
        state.check(&self.mappings)?;
        self.state = state;
        Ok(())
    }

    /// Forgets all samples, as if new.
    pub fn reset(&mut self) {
        self.state = TranslatorState::new(&self.mappings);
        self.motion_state = self.motion.start();
    }
}

/// A visible sample as one of a hand's motion, and the pose of the mapped tool for it; `opening` is retained where the device should measure it and does
/// not.
fn translate(
    mapping: &Mapping,
    sample: &InputSample,
    opening: f64,
) -> Result<(Point, ToolPose), SampleFault> {
    if !sample.device_time.is_finite() {
        return Err(SampleFault::Time);
    }
    let device_from_body =
        checked_unit(sample.pose.orientation).map_err(SampleFault::Orientation)?;

    // Without a lever there is no addition, which would change the sign of a zero.
    let tip = match mapping.tip == [0.0; 3] {
        true => sample.pose.position,
        false => {
            let lever = rotated(device_from_body, mapping.tip);
            std::array::from_fn(|i| sample.pose.position[i] + lever[i])
        }
    };
    let placed = in_field(mapping, tip, device_from_body);
    if !placed
        .position
        .iter()
        .all(|component| component.is_finite())
    {
        return Err(SampleFault::Position);
    }
    let opening = match (mapping.opening, sample.opening) {
        (Opening::Constant(opening), _) => opening,
        (Opening::Device { .. }, None) => opening,
        (Opening::Device { closed, open }, Some(reading)) => {
            let opening = (reading - closed) / (open - closed);
            if !opening.is_finite() {
                return Err(SampleFault::Opening);
            }
            opening.clamp(0.0, 1.0)
        }
    };
    let point = Point {
        time_s: sample.device_time,
        position: tip,
        orientation: device_from_body,
        opening,
    };
    let pose = ToolPose {
        pose: placed,
        opening,
        time: sample.device_time,
    };
    Ok((point, pose))
}

/// The pose in the field of a tool whose tip and handle are there in the frame of the device.
fn in_field(mapping: &Mapping, tip: [f64; 3], device_from_body: [f64; 4]) -> Pose {
    let from_origin = std::array::from_fn(|i| tip[i] - mapping.device_origin[i]);
    let turned = rotated(mapping.field_from_device, from_origin);
    let field_from_body = product(mapping.field_from_device, device_from_body);
    let pose = Pose {
        position: std::array::from_fn(|i| mapping.field_offset[i] + mapping.scale * turned[i]),
        orientation: product(field_from_body, mapping.body_from_tool),
    };
    match mapping.mirrored {
        true => mirrored(&pose),
        false => pose,
    }
}

/// A pose in the mirror x → −x: with M = diag(−1, 1, 1) the position M p and the rotation M R M, which is one again. An instrument that is symmetric in its own
/// plane x = 0 is then seen as its mirror image.
fn mirrored(pose: &Pose) -> Pose {
    let ([px, py, pz], [x, y, z, w]) = (pose.position, pose.orientation);
    Pose {
        position: [-px, py, pz],
        orientation: [x, -y, -z, w],
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "tool \"{}\": the sample of device \"{}\" at its time {} s is refused: ",
            self.tool, self.device, self.time_s
        )?;
        match self.fault {
            SampleFault::Time => write!(f, "time is not finite"),
            SampleFault::Position => write!(f, "position is not finite"),
            SampleFault::Opening => write!(f, "opening is not finite"),
            SampleFault::Orientation(error) => write!(f, "{error}"),
            SampleFault::Implausible(excess) => write!(f, "{excess}"),
        }
    }
}

impl Error for Refusal {}

#[cfg(test)]
mod hand_tests;
#[cfg(test)]
mod motion_tests;
#[cfg(test)]
mod tests;
