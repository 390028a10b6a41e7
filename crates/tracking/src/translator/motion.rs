//! What is made of samples that count, before the tool has them: filters of devices, and clutches, with which a hand goes back to the middle of its space while the
//! tip stands.
//!
//! A clutch is a device: a pedal, for example. It is pressed while its last sample is visible and its opening, where it has one, at least one half. While
//! it is pressed the tips of its tools stand where they were; orientation and opening follow the hand. When it is released the offset between tip and hand
//! stays, so that the tip goes on from where it stands. Orientations have no such offset: nobody can hold an instrument that points elsewhere than what is seen.

use super::mapping::{Mapping, TranslatorError};
use crate::filter::{Filtered, OneEuro};
use microsim_message::InputSample;
use serde::{Deserialize, Serialize};

/// A device that holds the tips of tools while it is pressed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Clutch {
    /// Name of the device.
    pub device: String,
    /// The tools.
    pub tools: Vec<String>,
}

/// What is done to motion; constant.
#[derive(Clone, Debug, Default)]
pub(super) struct Motion {
    /// In the order of the mappings.
    filters: Vec<Option<OneEuro>>,
    clutches: Vec<Clutch>,
}

/// What filters and clutches remember, to be saved and restored.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionState {
    filters: Vec<Option<Filtered>>,
    pressed: Vec<bool>,
    grips: Vec<Grip>,
}

/// Offset of a tip from where its hand is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Grip {
    offset: [f64; 3],
    /// Where the tip stands: since a clutch was pressed, until the first sample after its release.
    held: Option<[f64; 3]>,
}

impl Motion {
    pub fn new(
        mappings: &[Mapping],
        filters: Vec<(String, OneEuro)>,
        clutches: Vec<Clutch>,
    ) -> Result<Self, TranslatorError> {
        let mut by_tool = vec![None; mappings.len()];
        for (device, filter) in filters {
            if let Some((name, value)) = filter.fault() {
                return Err(TranslatorError::Filter(device, name, value));
            }
            let at = mappings.iter().position(|mapping| mapping.device == device);
            by_tool[at.ok_or(TranslatorError::Unknown(device))?] = Some(filter);
        }
        for (index, clutch) in clutches.iter().enumerate() {
            let is_device = mappings
                .iter()
                .any(|mapping| mapping.device == clutch.device);
            if is_device
                || clutches[..index]
                    .iter()
                    .any(|other| other.device == clutch.device)
            {
                return Err(TranslatorError::ClutchDevice(clutch.device.clone()));
            }
            let is_tool = |tool: &&String| mappings.iter().any(|mapping| mapping.tool == **tool);
            if let Some(tool) = clutch.tools.iter().find(|tool| !is_tool(tool)) {
                return Err(TranslatorError::Unknown(tool.clone()));
            }
        }
        Ok(Self {
            filters: by_tool,
            clutches,
        })
    }

    /// Whether anything is done to motion.
    pub fn is_any(&self) -> bool {
        !self.clutches.is_empty() || self.filters.iter().any(Option::is_some)
    }

    /// Whether this device is that of a clutch.
    pub fn has_clutch(&self, device: &str) -> bool {
        self.clutches.iter().any(|clutch| clutch.device == device)
    }

    pub fn start(&self) -> MotionState {
        if !self.is_any() {
            return MotionState::default();
        }
        MotionState {
            filters: vec![None; self.filters.len()],
            pressed: vec![false; self.clutches.len()],
            grips: vec![Grip::default(); self.filters.len()],
        }
    }

    /// Whether a state is one of these filters and clutches.
    pub fn fits(&self, state: &MotionState) -> bool {
        let empty = self.start();
        let sizes =
            |state: &MotionState| (state.filters.len(), state.pressed.len(), state.grips.len());
        sizes(&empty) == sizes(state)
    }

    /// Takes a sample of a clutch; whether it is one. `tip` gives where the tip of a tool stands.
    pub fn press(
        &self,
        state: &mut MotionState,
        mappings: &[Mapping],
        sample: &InputSample,
        tip: impl Fn(usize) -> Option<[f64; 3]>,
    ) -> bool {
        let Some(index) = self
            .clutches
            .iter()
            .position(|clutch| clutch.device == sample.device)
        else {
            return false;
        };
        let is_pressed = sample.visible && sample.opening.is_none_or(|opening| opening >= 0.5);
        let was_pressed = std::mem::replace(&mut state.pressed[index], is_pressed);
        if is_pressed && !was_pressed {
            for tool in &self.clutches[index].tools {
                let tool = mappings.iter().position(|mapping| mapping.tool == *tool);
                if let Some((tool, tip)) = tool.and_then(|tool| Some((tool, tip(tool)?))) {
                    state.grips[tool].held.get_or_insert(tip);
                }
            }
        }
        true
    }

    /// The filtered pose of a device, in its frame; `None` where it has no filter.
    pub fn filter(
        &self,
        state: &mut MotionState,
        tool: usize,
        (time_s, position, orientation): (f64, [f64; 3], [f64; 4]),
        gap_s: f64,
    ) -> Option<([f64; 3], [f64; 4])> {
        let filter = self.filters.get(tool).copied().flatten()?;
        let memory = &mut state.filters[tool];
        Some(filter.step(memory, time_s, position, orientation, gap_s))
    }

    /// Where the tip is, of a tool whose hand would have it there.
    pub fn place(
        &self,
        state: &mut MotionState,
        mapping: &Mapping,
        tool: usize,
        hand: [f64; 3],
    ) -> [f64; 3] {
        if self.clutches.is_empty() {
            return hand;
        }
        let of_tool = |clutch: &Clutch| clutch.tools.contains(&mapping.tool);
        let mut pressed = self.clutches.iter().zip(&state.pressed);
        let is_pressed = pressed.any(|(clutch, pressed)| *pressed && of_tool(clutch));
        let grip = &mut state.grips[tool];
        match grip.held {
            Some(held) if is_pressed => held,
            Some(held) => {
                grip.offset = std::array::from_fn(|i| held[i] - hand[i]);
                grip.held = None;
                held
            }
            // No offset, no addition: what was never held has the bits of its hand.
            None if grip.offset == [0.0; 3] => hand,
            None => std::array::from_fn(|i| hand[i] + grip.offset[i]),
        }
    }

    /// The tool is not seen: what comes next is not joined to what came before.
    pub fn interrupt(&self, state: &mut MotionState, tool: usize) {
        if let Some(memory) = state.filters.get_mut(tool) {
            *memory = None;
        }
    }
}
