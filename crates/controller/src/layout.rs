//! Which axes and buttons of a device do what.

use crate::code::{
    BRAKE, BUTTON_0, BUTTON_1, CROSS, GAS, HAT_X, HAT_Y, LEFT_SHOULDER, LEFT_TRIGGER, NORTH,
    RIGHT_SHOULDER, RIGHT_TRIGGER, RX, RY, RZ, SOUTH, START, WEST, X, Y, Z,
};
use crate::device::Kind;
use crate::motion::Held;
use crate::report::State;
use crate::response::{CAP, STICK, pressed, rates};

/// With the left trigger pressed all motions are this much of what they are without.
const FINE: f64 = 0.25;

/// What a button asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Press {
    /// The other hand.
    OtherHand,
    /// Jaws stay closed, or no longer.
    HoldClosed,
    /// Begin, pause, go on.
    Pause,
    /// More magnification.
    Magnify,
    /// Less of it.
    Reduce,
}

/// What a device asks for while it is held so.
pub fn held(kind: Kind, state: &State) -> Held {
    match kind {
        Kind::Gamepad => gamepad(state),
        Kind::SpaceMouse => cap(state),
    }
}

/// What its buttons ask for that are pressed.
pub fn presses(kind: Kind, state: &State) -> Vec<Press> {
    let [_, _, left, right] = CROSS;
    let pressed = match kind {
        Kind::Gamepad => vec![
            // Drivers number these two by their letters or by their places.
            (
                state.is_down(NORTH) || state.is_down(WEST),
                Press::OtherHand,
            ),
            (state.is_down(SOUTH), Press::HoldClosed),
            (state.is_down(START), Press::Pause),
            (cross(state, HAT_X, 1.0, right), Press::Magnify),
            (cross(state, HAT_X, -1.0, left), Press::Reduce),
        ],
        Kind::SpaceMouse => vec![
            (state.is_down(BUTTON_0), Press::OtherHand),
            (state.is_down(BUTTON_1), Press::HoldClosed),
        ],
    };
    let pressed = pressed.into_iter().filter(|(is_down, _)| *is_down);
    pressed.map(|(_, press)| press).collect()
}

/// Whether the cross is pressed towards one of its ends, of which some gamepads have buttons.
fn cross(state: &State, axis: u16, sign: f64, button: u16) -> bool {
    state.deflection(axis) * sign > 0.5 || state.is_down(button)
}

fn number(is_down: bool) -> f64 {
    f64::from(u8::from(is_down))
}

fn gamepad(state: &State) -> Held {
    // Over Bluetooth some have the right stick where others have the triggers.
    let is_other = state.has(GAS) && state.has(BRAKE);
    let ([x, y], [left, right]) = match is_other {
        true => ([Z, RZ], [BRAKE, GAS]),
        false => ([RX, RY], [Z, RZ]),
    };
    let trigger = |axis: u16, button: u16| match state.has(axis) {
        true => pressed(state.pressed(axis)),
        false => number(state.is_down(button)),
    };
    let fine = 1.0 - (1.0 - FINE) * trigger(left, LEFT_TRIGGER);
    let stick = |x, y| rates([state.deflection(x), state.deflection(y)], STICK);
    let ([right_x, right_y], [left_x, left_y]) = (stick(x, y), stick(X, Y));
    let [up_button, down_button, ..] = CROSS;
    let raise = number(cross(state, HAT_Y, -1.0, up_button))
        - number(cross(state, HAT_Y, 1.0, down_button));
    let roll = number(state.is_down(RIGHT_SHOULDER)) - number(state.is_down(LEFT_SHOULDER));
    Held {
        shift: [left_x, -left_y, -right_y].map(|rate| rate * fine),
        turn: [right_x, raise, roll].map(|rate| rate * fine),
        closing: trigger(right, RIGHT_TRIGGER),
        until: [None; 2],
    }
}

/// A cap goes along with the instrument, whose handle lies towards the trainee: axes of the cap are to the right, towards the user and down, and turns about them are
/// right-handed.
fn cap(state: &State) -> Held {
    let [x, y, z] = rates([X, Y, Z].map(|axis| state.deflection(axis)), CAP);
    let [about_x, about_y, about_z] = rates([RX, RY, RZ].map(|axis| state.deflection(axis)), CAP);
    Held {
        shift: [x, -y, -z],
        turn: [-about_z, -about_x, about_y],
        closing: 0.0,
        until: [None; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capabilities::Capabilities;
    use crate::event::Event;
    use crate::probe::Probed;
    use crate::range::Range;
    use crate::report::Reports;

    /// A gamepad at rest.
    struct Pad {
        state: State,
    }

    impl Pad {
        fn new(axes: &[(u16, i32, i32, i32)]) -> Self {
            let axes = axes.iter();
            let axes = axes.map(|&(axis, least, most, value)| (axis, Range { least, most }, value));
            let probed = Probed {
                axes: axes.collect(),
                buttons: Vec::new(),
            };
            let capabilities = Capabilities {
                absolute: vec![X],
                ..Capabilities::default()
            };
            Self {
                state: State::new(&capabilities, probed),
            }
        }

        /// xpad: sticks ±32768, triggers 0 to 255, cross as a hat.
        fn xbox() -> Self {
            let stick = |axis| (axis, -32768, 32767, 0);
            Self::new(&[
                stick(X),
                stick(Y),
                stick(RX),
                stick(RY),
                (Z, 0, 255, 0),
                (RZ, 0, 255, 0),
                (HAT_X, -1, 1, 0),
                (HAT_Y, -1, 1, 0),
            ])
        }

        /// hid-playstation: all 0 to 255, sticks at rest at 128.
        fn dual_shock() -> Self {
            let stick = |axis| (axis, 0, 255, 128);
            Self::new(&[
                stick(X),
                stick(Y),
                stick(RX),
                stick(RY),
                (Z, 0, 255, 0),
                (RZ, 0, 255, 0),
            ])
        }

        /// hid-microsoft over Bluetooth: sticks 0 to 65535, the right one z and rz, triggers 0 to 1023.
        fn bluetooth() -> Self {
            let stick = |axis| (axis, 0, 65535, 32768);
            Self::new(&[
                stick(X),
                stick(Y),
                stick(Z),
                stick(RZ),
                (BRAKE, 0, 1023, 0),
                (GAS, 0, 1023, 0),
            ])
        }

        fn with(&mut self, events: &[Event]) -> Held {
            let mut reports = Reports::default();
            for event in events {
                reports.take(*event, &mut self.state);
            }
            reports.take(Event::Complete, &mut self.state);
            held(Kind::Gamepad, &self.state)
        }
    }

    const STILL: Held = Held {
        shift: [0.0; 3],
        turn: [0.0; 3],
        closing: 0.0,
        until: [None; 2],
    };

    fn near(found: Held, expected: Held) {
        let all = |held: Held| [held.shift, held.turn, [held.closing, 0.0, 0.0]].concat();
        for (a, b) in all(found).into_iter().zip(all(expected)) {
            assert!((a - b).abs() < 1e-12, "{found:?} is not {expected:?}");
        }
    }

    /// Full deflection of each axis, with the ranges of three drivers: rate 1 in the direction that is meant, and nothing else.
    #[test]
    fn sticks_move_and_turn() {
        // Right stick, left trigger, right trigger; end to the left or up, end to the right or down, end of a trigger.
        let pads = [
            (
                Pad::xbox as fn() -> Pad,
                [RX, RY, Z, RZ],
                [-32768, 32767, 255],
            ),
            (Pad::dual_shock, [RX, RY, Z, RZ], [0, 255, 255]),
            (Pad::bluetooth, [Z, RZ, BRAKE, GAS], [0, 65535, 1023]),
        ];
        for (pad, [right_x, right_y, left, right], [least, most, pressed]) in pads {
            near(pad().with(&[]), STILL);
            for (axis, value, shift, turn) in [
                (X, most, [1.0, 0.0, 0.0], [0.0; 3]),
                (X, least, [-1.0, 0.0, 0.0], [0.0; 3]),
                (Y, least, [0.0, 1.0, 0.0], [0.0; 3]),
                (Y, most, [0.0, -1.0, 0.0], [0.0; 3]),
                (right_y, least, [0.0, 0.0, 1.0], [0.0; 3]),
                (right_y, most, [0.0, 0.0, -1.0], [0.0; 3]),
                (right_x, most, [0.0; 3], [1.0, 0.0, 0.0]),
                (right_x, least, [0.0; 3], [-1.0, 0.0, 0.0]),
            ] {
                let found = pad().with(&[Event::Absolute(axis, value)]);
                // The other axis of a stick rests off its middle by at most half a step of 255.
                let expected = Held {
                    shift,
                    turn,
                    ..STILL
                };
                let all = |held: Held| [held.shift, held.turn].concat();
                for (a, b) in all(found).into_iter().zip(all(expected)) {
                    assert!((a - b).abs() < 0.004, "{axis} {value}: {found:?}");
                }
            }
            let closed = pad().with(&[Event::Absolute(right, pressed)]);
            near(
                closed,
                Held {
                    closing: 1.0,
                    ..STILL
                },
            );
            // Half pressed, less the dead zone of a twentieth: (0.5 − 0.05) / 0.95, up to half a step.
            let half = pad().with(&[Event::Absolute(right, pressed / 2)]).closing;
            assert!((half - 0.45 / 0.95).abs() < 0.003, "{half}");
            let fine = pad().with(&[Event::Absolute(X, most), Event::Absolute(left, pressed)]);
            assert!((fine.shift[0] - 0.25).abs() < 0.001, "{fine:?}");
        }
    }

    #[test]
    fn shoulders_roll_and_the_cross_raises() {
        let roll = Pad::xbox().with(&[Event::Button(RIGHT_SHOULDER, true)]);
        assert_eq!(roll.turn, [0.0, 0.0, 1.0]);
        let roll = Pad::xbox().with(&[Event::Button(LEFT_SHOULDER, true)]);
        assert_eq!(roll.turn, [0.0, 0.0, -1.0]);
        let raised = Pad::xbox().with(&[Event::Absolute(HAT_Y, -1)]);
        assert_eq!(raised.turn, [0.0, 1.0, 0.0]);
        // Of gamepads without hat and analogue triggers.
        let mut plain = Pad::new(&[(X, 0, 255, 128), (Y, 0, 255, 128)]);
        let raised = plain.with(&[Event::Button(CROSS[0], true)]);
        assert_eq!(raised.turn, [0.0, 1.0, 0.0]);
        let closed = plain.with(&[Event::Button(RIGHT_TRIGGER, true)]);
        assert_eq!(closed.closing, 1.0);
    }

    #[test]
    fn buttons_ask_for_what_the_help_states() {
        let mut pad = Pad::xbox();
        for (event, press) in [
            (Event::Button(NORTH, true), Press::OtherHand),
            (Event::Button(WEST, true), Press::OtherHand),
            (Event::Button(SOUTH, true), Press::HoldClosed),
            (Event::Button(START, true), Press::Pause),
            (Event::Absolute(HAT_X, 1), Press::Magnify),
            (Event::Absolute(HAT_X, -1), Press::Reduce),
        ] {
            pad.with(&[event]);
            assert_eq!(presses(Kind::Gamepad, &pad.state), [press]);
            pad.with(&[
                Event::Button(NORTH, false),
                Event::Button(WEST, false),
                Event::Button(SOUTH, false),
                Event::Button(START, false),
                Event::Absolute(HAT_X, 0),
            ]);
            assert_eq!(presses(Kind::Gamepad, &pad.state), []);
        }
        pad.with(&[Event::Button(BUTTON_0, true), Event::Button(BUTTON_1, true)]);
        let of_cap = presses(Kind::SpaceMouse, &pad.state);
        assert_eq!(of_cap, [Press::OtherHand, Press::HoldClosed]);
    }

    /// A cap to the right, away and up moves the tip there; its handle lies towards the user, so that a cap that is twisted as seen from above, whose near edge is raised, or that is
    /// tilted to its right, turns, raises and rolls it.
    #[test]
    fn an_instrument_goes_along_with_the_cap() {
        for (axis, value, shift, turn) in [
            (X, 350, [1.0, 0.0, 0.0], [0.0; 3]),
            (Y, -350, [0.0, 1.0, 0.0], [0.0; 3]),
            (Z, -350, [0.0, 0.0, 1.0], [0.0; 3]),
            // Counter-clockwise from above: a handle that lies towards the user goes to the right.
            (RZ, -350, [0.0; 3], [1.0, 0.0, 0.0]),
            (RX, -350, [0.0; 3], [0.0, 1.0, 0.0]),
            (RY, 350, [0.0; 3], [0.0, 0.0, 1.0]),
        ] {
            let capabilities = Capabilities {
                relative: vec![X, Y, Z, RX, RY, RZ],
                ..Capabilities::default()
            };
            let mut state = State::new(&capabilities, Probed::default());
            let mut reports = Reports::default();
            reports.take(Event::Relative(axis, value), &mut state);
            reports.take(Event::Complete, &mut state);
            near(
                held(Kind::SpaceMouse, &state),
                Held {
                    shift,
                    turn,
                    ..STILL
                },
            );
            // A hand that lies on it.
            reports.take(Event::Relative(axis, value / 13), &mut state);
            reports.take(Event::Complete, &mut state);
            near(held(Kind::SpaceMouse, &state), STILL);
        }
    }

    /// Axes whose least and greatest value are the same move nothing, and all is a number.
    #[test]
    fn absurd_ranges_move_nothing() {
        let axes = [X, Y, Z, RX, RY, RZ, HAT_X, HAT_Y];
        for (least, most) in [(0, 0), (5, -5), (i32::MAX, i32::MIN)] {
            let mut pad = Pad::new(&axes.map(|axis| (axis, least, most, 0)));
            for value in [i32::MIN, 0, i32::MAX] {
                near(
                    pad.with(&axes.map(|axis| Event::Absolute(axis, value))),
                    STILL,
                );
            }
        }
    }
}
