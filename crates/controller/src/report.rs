//! Records of a device as states, each of which holds until the next one.

use crate::capabilities::Capabilities;
use crate::code::{RX, RZ, X, Z};
use crate::event::Event;
use crate::probe::Probed;
use crate::range::{Range, SPACE_MOUSE};
use std::collections::{BTreeMap, BTreeSet};

/// Axes that a SpaceMouse reports together: those that it leaves out of such a report are not deflected.
const TOGETHER: [[u16; 2]; 2] = [[X, Z], [RX, RZ]];

/// How a device is held.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    ranges: BTreeMap<u16, Range>,
    values: BTreeMap<u16, i32>,
    buttons: BTreeSet<u16>,
    /// Whether its axes state deflections, of which the last one before zero is not followed by any.
    pub is_relative: bool,
}

impl State {
    /// As it was found.
    pub fn new(capabilities: &Capabilities, probed: Probed) -> Self {
        let mut state = Self {
            is_relative: capabilities.absolute.is_empty() && !capabilities.relative.is_empty(),
            ..Self::default()
        };
        if state.is_relative {
            let ranges = capabilities.relative.iter();
            state.ranges = ranges.map(|axis| (*axis, SPACE_MOUSE)).collect();
        }
        state.find(probed);
        state
    }

    /// As it was found after records were lost.
    pub fn find(&mut self, probed: Probed) {
        for (axis, range, value) in probed.axes {
            self.ranges.insert(axis, range);
            self.values.insert(axis, value);
        }
        if self.is_relative {
            self.values.clear();
        }
        self.buttons = probed.buttons.into_iter().collect();
    }

    /// Whether it has an axis.
    pub fn has(&self, axis: u16) -> bool {
        self.ranges.contains_key(&axis)
    }

    /// Deflection of an axis, from −1 to 1; 0 of one that it has not.
    pub fn deflection(&self, axis: u16) -> f64 {
        let value = self.values.get(&axis).zip(self.ranges.get(&axis));
        value.map_or(0.0, |(value, range)| range.deflection(*value))
    }

    /// How far a trigger is pressed, from 0 to 1.
    pub fn pressed(&self, axis: u16) -> f64 {
        let value = self.values.get(&axis).zip(self.ranges.get(&axis));
        value.map_or(0.0, |(value, range)| range.pressed(*value))
    }

    /// Whether a button is pressed.
    pub fn is_down(&self, button: u16) -> bool {
        self.buttons.contains(&button)
    }
}

/// What came of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The report goes on.
    Incomplete,
    /// Another state holds; whether it has deflections of translation, and of rotation.
    Complete([bool; 2]),
    /// Records were lost: the device is to be asked.
    Lost,
}

/// Reads records.
#[derive(Clone, Debug, Default)]
pub struct Reports {
    relative: BTreeMap<u16, i32>,
    absolute: BTreeMap<u16, i32>,
    buttons: Vec<(u16, bool)>,
    is_lost: bool,
}

impl Reports {
    /// Takes the next record; a report changes the state as a whole.
    pub fn take(&mut self, event: Event, state: &mut State) -> Outcome {
        match event {
            Event::Relative(axis, value) => {
                self.relative.insert(axis, value);
            }
            Event::Absolute(axis, value) => {
                self.absolute.insert(axis, value);
            }
            Event::Button(button, is_down) => self.buttons.push((button, is_down)),
            Event::Lost => self.is_lost = true,
            Event::Other => {}
            Event::Complete => {
                let report = std::mem::take(self);
                return match report.is_lost {
                    true => Outcome::Lost,
                    false => Outcome::Complete(report.apply(state)),
                };
            }
        }
        Outcome::Incomplete
    }

    fn apply(self, state: &mut State) -> [bool; 2] {
        let has = TOGETHER.map(|[first, last]| {
            let has = self.relative.range(first..=last).next().is_some();
            if has {
                state
                    .values
                    .retain(|axis, _| !(first..=last).contains(axis));
            }
            has
        });
        state.values.extend(self.relative);
        state.values.extend(self.absolute);
        for (button, is_down) in self.buttons {
            match is_down {
                true => state.buttons.insert(button),
                false => state.buttons.remove(&button),
            };
        }
        has
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{RY, Y};

    fn cap() -> State {
        let capabilities = Capabilities {
            relative: vec![X, Y, Z, RX, RY, RZ],
            ..Capabilities::default()
        };
        State::new(&capabilities, Probed::default())
    }

    fn play(state: &mut State, reports: &mut Reports, events: &[Event]) -> Outcome {
        let mut outcome = Outcome::Incomplete;
        for event in events {
            outcome = reports.take(*event, state);
        }
        outcome
    }

    /// A cap states translation and rotation in turn, and no zeros.
    #[test]
    fn axes_that_a_report_leaves_out_are_not_deflected() {
        let (mut state, mut reports) = (cap(), Reports::default());
        let translation = [
            Event::Relative(X, 350),
            Event::Relative(Z, -175),
            Event::Complete,
        ];
        let outcome = play(&mut state, &mut reports, &translation);
        assert_eq!(outcome, Outcome::Complete([true, false]));
        let rotation = [Event::Relative(RY, 70), Event::Complete];
        assert_eq!(
            play(&mut state, &mut reports, &rotation),
            Outcome::Complete([false, true])
        );
        let deflections = [X, Y, Z, RX, RY, RZ].map(|axis| state.deflection(axis));
        // 70 of 350: a fifth, up to rounding.
        let expected = [1.0, 0.0, -0.5, 0.0, 0.2, 0.0];
        assert!(
            deflections
                .iter()
                .zip(expected)
                .all(|(found, expected)| (found - expected).abs() < 1e-15),
            "{deflections:?}"
        );
        play(
            &mut state,
            &mut reports,
            &[Event::Relative(Y, 1), Event::Complete],
        );
        assert_eq!((state.deflection(X), state.deflection(Z)), (0.0, 0.0));
        assert!((state.deflection(RY) - 0.2).abs() < 1e-15, "rotation stays");
    }

    /// What stands before and after the mark of a loss, up to the end of the report, counts for nothing.
    #[test]
    fn a_report_with_a_loss_is_void() {
        let (mut state, mut reports) = (cap(), Reports::default());
        let outcome = play(
            &mut state,
            &mut reports,
            &[
                Event::Relative(X, 350),
                Event::Lost,
                Event::Button(0x100, true),
                Event::Complete,
            ],
        );
        assert_eq!(outcome, Outcome::Lost);
        assert_eq!(state, cap());
        // The next one counts.
        play(
            &mut state,
            &mut reports,
            &[Event::Button(0x101, true), Event::Complete],
        );
        assert!(state.is_down(0x101) && !state.is_down(0x100));
        play(
            &mut state,
            &mut reports,
            &[Event::Button(0x101, false), Event::Complete],
        );
        assert!(!state.is_down(0x101));
    }

    #[test]
    fn nothing_holds_before_a_report_is_complete() {
        let (mut state, mut reports) = (cap(), Reports::default());
        let outcome = play(&mut state, &mut reports, &[Event::Relative(X, 350)]);
        assert_eq!((outcome, state.deflection(X)), (Outcome::Incomplete, 0.0));
    }
}
