//! Which device drives which tool, and how.

use std::error::Error;
use std::fmt;

use crate::QuaternionError;
use crate::rotation::{checked_unit, product, rotated};

/// How one device drives one tool; see the module for the formula. All numbers are finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    /// Name of the tool; each tool has one mapping.
    pub tool: String,
    /// Name of the device; each device drives one tool at most.
    pub device: String,
    /// The point of the device frame that comes to lie at `field_offset` `[m]`.
    pub device_origin: [f64; 3],
    /// Where `device_origin` comes to lie in the field `[m]`.
    pub field_offset: [f64; 3],
    /// How the axes of the device frame lie in the field: unit quaternion x, y, z, w.
    pub field_from_device: [f64; 4],
    /// Length in the field per length of the device, above 0.
    pub scale: f64,
    /// How the tool sits in the handle, whose axes the device reports: unit quaternion x, y, z, w.
    pub body_from_tool: [f64; 4],
    /// The tip in the frame of the handle, whose origin the device reports: the lever `[m]`. Zero where it reports the tip.
    pub tip: [f64; 3],
    /// Where the tool's opening comes from.
    pub opening: Opening,
    /// Whether the pose in the field is mirrored at its end, x becoming −x: the instrument of a left-handed trainee in a level for right-handed ones.
    pub mirrored: bool,
}

/// Where a tool's opening, 0 closed to 1 open, comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Opening {
    /// It does not change.
    Constant(f64),
    /// From the device, linear between the two of its readings (which differ) that mean closed and open; readings beyond
    /// them are taken as closed or open. A sample without a reading leaves the opening as it was, at first open.
    Device {
        /// The reading that means closed.
        closed: f64,
        /// The reading that means open.
        open: f64,
    },
}

impl Opening {
    /// The device's own opening.
    pub const DEVICE: Self = Self::Device {
        closed: 0.0,
        open: 1.0,
    };
}

impl Mapping {
    /// The device frame as the field frame: samples are poses of the tool as they are.
    pub fn identity(device: &str, tool: &str) -> Self {
        Self {
            tool: tool.to_owned(),
            device: device.to_owned(),
            device_origin: [0.0; 3],
            field_offset: [0.0; 3],
            field_from_device: [0.0, 0.0, 0.0, 1.0],
            scale: 1.0,
            body_from_tool: [0.0, 0.0, 0.0, 1.0],
            tip: [0.0; 3],
            opening: Opening::DEVICE,
            mirrored: false,
        }
    }
}

impl Mapping {
    /// The same for a device whose frame was registered: its points first become scale · R(rotation) p + translation, and what this mapping states of points of the
    /// device holds for those.
    #[must_use]
    pub fn registered(self, rotation: [f64; 4], translation: [f64; 3], scale: f64) -> Self {
        let [x, y, z, w] = rotation;
        let off = std::array::from_fn(|i| self.device_origin[i] - translation[i]);
        Self {
            device_origin: rotated([-x, -y, -z, w], off).map(|x| x / scale),
            field_from_device: product(self.field_from_device, rotation),
            scale: self.scale * scale,
            ..self
        }
    }
}

/// Why a translator cannot be made.
#[derive(Clone, Debug, PartialEq)]
pub enum TranslatorError {
    /// The time after which a tool is stale is not a finite positive number `[s]`.
    StaleAfter(f64),
    /// The limit of a hand of this name is not a finite positive number, or an error below 0.
    HandLimit(&'static str, f64),
    /// The number of this name of the filter of a device is out of its range.
    Filter(String, &'static str, f64),
    /// A device that is no device of a tool is to be filtered, or a tool that there is not has a clutch.
    Unknown(String),
    /// The device of a clutch drives a tool, or is that of another clutch.
    ClutchDevice(String),
    /// A mapping is wrong.
    Mapping {
        /// The tool of the mapping.
        tool: String,
        /// What is wrong.
        problem: MappingProblem,
    },
}

/// What is wrong with a mapping.
#[derive(Clone, Debug, PartialEq)]
pub enum MappingProblem {
    /// The tool has a mapping already.
    DuplicateTool,
    /// The device, named here, drives another tool already.
    DuplicateDevice(String),
    /// The vector of this name is not finite.
    NotFinite(&'static str),
    /// The scale is not a finite positive number.
    Scale(f64),
    /// The quaternion of this name is none.
    Quaternion(&'static str, QuaternionError),
    /// The constant opening is not within 0 to 1.
    ConstantOpening(f64),
    /// The readings for closed and open are not finite, or are equal.
    OpeningRange(f64, f64),
}

/// Checks all mappings, and scales their quaternions to norm 1.
pub(super) fn check(mappings: &mut [Mapping]) -> Result<(), TranslatorError> {
    for index in 0..mappings.len() {
        let (earlier, rest) = mappings.split_at_mut(index);
        let mapping = &mut rest[0];
        check_one(mapping, earlier).map_err(|problem| TranslatorError::Mapping {
            tool: mapping.tool.clone(),
            problem,
        })?;
    }
    Ok(())
}

fn check_one(mapping: &mut Mapping, earlier: &[Mapping]) -> Result<(), MappingProblem> {
    if earlier.iter().any(|other| other.tool == mapping.tool) {
        return Err(MappingProblem::DuplicateTool);
    }
    if earlier.iter().any(|other| other.device == mapping.device) {
        return Err(MappingProblem::DuplicateDevice(mapping.device.clone()));
    }
    for (name, vector) in [
        ("device_origin", mapping.device_origin),
        ("field_offset", mapping.field_offset),
        ("tip", mapping.tip),
    ] {
        if !vector.iter().all(|component| component.is_finite()) {
            return Err(MappingProblem::NotFinite(name));
        }
    }
    if !(mapping.scale.is_finite() && mapping.scale > 0.0) {
        return Err(MappingProblem::Scale(mapping.scale));
    }
    for (name, quaternion) in [
        ("field_from_device", &mut mapping.field_from_device),
        ("body_from_tool", &mut mapping.body_from_tool),
    ] {
        *quaternion =
            checked_unit(*quaternion).map_err(|error| MappingProblem::Quaternion(name, error))?;
    }
    match mapping.opening {
        Opening::Constant(opening) if !(0.0..=1.0).contains(&opening) => {
            Err(MappingProblem::ConstantOpening(opening))
        }
        Opening::Device { closed, open }
            if !(closed.is_finite() && open.is_finite() && closed != open) =>
        {
            Err(MappingProblem::OpeningRange(closed, open))
        }
        _ => Ok(()),
    }
}

impl fmt::Display for TranslatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StaleAfter(time) => {
                write!(
                    f,
                    "tools are stale after {time} s, expected a finite positive number"
                )
            }
            Self::HandLimit(name, value) => {
                write!(
                    f,
                    "{name} of a hand is {value}, expected a finite positive number"
                )
            }
            Self::Filter(device, name, value) => {
                write!(
                    f,
                    "{name} of the filter of device \"{device}\" is {value}, which is out of its range"
                )
            }
            Self::Unknown(name) => write!(f, "\"{name}\" is no device or tool of the mappings"),
            Self::ClutchDevice(device) => write!(
                f,
                "the device \"{device}\" of a clutch drives a tool or another clutch as well"
            ),
            Self::Mapping { tool, problem } => write!(f, "mapping of tool \"{tool}\": {problem}"),
        }
    }
}

impl Error for TranslatorError {}

impl fmt::Display for MappingProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DuplicateTool => write!(f, "the tool has two mappings, expected one"),
            Self::DuplicateDevice(device) => {
                write!(f, "device \"{device}\" drives another tool already")
            }
            Self::NotFinite(name) => write!(f, "{name} is not finite"),
            Self::Scale(scale) => write!(f, "scale is {scale}, expected a finite positive number"),
            Self::Quaternion(name, error) => write!(f, "{name}: {error}"),
            Self::ConstantOpening(opening) => {
                write!(f, "opening is {opening}, expected 0 (closed) to 1 (open)")
            }
            Self::OpeningRange(closed, open) => write!(
                f,
                "opening is closed at {closed} and open at {open}, expected two different finite numbers"
            ),
        }
    }
}
