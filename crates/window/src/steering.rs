//! Gamepads and SpaceMice: their motions as wishes for the tool in hand, tick by tick, and their buttons as keys.

use crate::look;
use crate::shortcut;
use crate::text;
use eframe::egui::{self, Key, Ui};
use microsim_controller::{Controllers, Kind, Motion, Presence, Press, Seen};
use microsim_message::DesktopInput;
use microsim_vocabulary::Language;

/// Turn rate at full deflection \[rad/s\], as that of keys.
const TURN_RATE: f64 = 1.2;

/// What the devices move.
#[derive(Clone, Debug)]
pub struct Steering {
    /// The devices.
    pub controllers: Controllers,
    /// How it is moved.
    pub grasp: Grasp,
}

/// How the tool in hand is moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Grasp {
    /// Its slot.
    pub tool: String,
    /// Speed of its tip at full deflection \[m/s\].
    pub speed: f64,
    /// Its opening where nobody closes it.
    pub opening: f64,
    /// Whether its jaws stay closed.
    pub keeps: bool,
    /// Whether a trigger closes it.
    pub is_closed: bool,
}

impl Grasp {
    /// What a motion of the devices asks for.
    pub fn wish(&mut self, motion: Motion) -> Option<DesktopInput> {
        if motion.is_none() {
            return None;
        }
        let closing = motion.closing.filter(|_| !self.keeps);
        self.is_closed = closing.map_or(self.is_closed, |closing| closing > 0.0);
        let wish = DesktopInput {
            tool: self.tool.clone(),
            shift: motion.shift.map(|time| time * self.speed),
            turn: motion.turn.map(|time| time * TURN_RATE),
            opening: closing.map(|closing| self.opening * (1.0 - closing)),
        };
        let asks = wish.shift != [0.0; 3] || wish.turn != [0.0; 3] || wish.opening.is_some();
        asks.then_some(wish)
    }

    /// Another tool is in hand: what a trigger closed opens, as where a button of the mouse is released.
    pub fn release(&self) -> Option<DesktopInput> {
        (self.is_closed && !self.keeps).then(|| DesktopInput {
            tool: self.tool.clone(),
            opening: Some(self.opening),
            ..DesktopInput::default()
        })
    }
}

/// What is shown, as far as buttons are concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Something that the Enter key begins.
    Before,
    /// A run that goes on or pauses.
    Run,
    /// A replay.
    Replay,
    /// Anything else.
    Other,
}

/// The key that does what a button asks for.
fn key(press: Press, stage: Stage) -> Option<Key> {
    let key = match (press, stage) {
        (Press::Pause, Stage::Before) => Key::Enter,
        (Press::Pause, Stage::Run) => Key::Escape,
        (Press::Pause, Stage::Replay) => Key::Space,
        (Press::OtherHand, Stage::Run) => Key::Tab,
        (Press::HoldClosed, Stage::Run) => Key::C,
        (Press::Magnify, Stage::Run | Stage::Replay) => Key::Plus,
        (Press::Reduce, Stage::Run | Stage::Replay) => Key::Minus,
        _ => return None,
    };
    Some(key)
}

/// Presses the keys that buttons stand for, if the window is the one that is used.
pub fn press_keys(ui: &Ui, presses: &[Press], stage: Stage) {
    let is_used = ui.input(|input| input.focused);
    let keys = presses.iter().filter_map(|press| key(*press, stage));
    for key in keys.filter(|_| is_used) {
        ui.ctx()
            .input_mut(|input| input.events.push(shortcut::press(key)));
    }
}

/// Shows which devices are there.
pub fn presences(ui: &mut Ui, presences: &[Presence], language: Language) {
    for presence in presences {
        let kind = match presence.kind {
            Kind::Gamepad => text::GAMEPAD,
            Kind::SpaceMouse => text::SPACE_MOUSE,
        };
        let (kind, name) = (kind.of(language), &presence.name);
        let line = match &presence.seen {
            Seen::Here => look::quiet(format!("{kind} {name}: {}", text::PLUGGED_IN.of(language))),
            Seen::Gone => {
                let gone = text::UNPLUGGED.of(language);
                egui::RichText::new(format!("{kind} {name}: {gone}")).color(look::BAD)
            }
            Seen::Refused(why) => {
                let refused = text::NOT_READABLE.of(language);
                egui::RichText::new(format!("{kind} {name} {refused} {why}")).color(look::BAD)
            }
        };
        ui.add(egui::Label::new(line).wrap());
    }
}

/// What the devices that are there are used for.
pub fn help(presences: &[Presence]) -> Vec<text::Phrase> {
    let is_here = |kind| {
        let mut here = presences.iter().filter(|p| p.seen == Seen::Here);
        here.any(|presence| presence.kind == kind)
    };
    let helps = [
        (Kind::Gamepad, text::GAMEPAD_HELP),
        (Kind::SpaceMouse, text::SPACE_MOUSE_HELP),
    ];
    let helps = helps.into_iter().filter(|(kind, _)| is_here(*kind));
    helps.map(|(_, help)| help).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grasp(field: f64) -> Grasp {
        Grasp {
            tool: "right".into(),
            speed: 0.5 * field,
            opening: 0.8,
            keeps: false,
            is_closed: false,
        }
    }

    /// A second of full deflection at half a diameter in a second: 12.5 mm of a field of 25 mm, half of it at twice the magnification. A turn of 1.2 rad.
    #[test]
    fn a_motion_follows_the_field_and_not_the_pictures() {
        for (field, ticks) in [(0.025, 1), (0.025, 125), (0.0125, 125), (0.0125, 40)] {
            let mut grasp = grasp(field);
            let mut sum = ([0.0; 3], [0.0; 3]);
            for _ in 0..ticks {
                let motion = Motion {
                    shift: [1.0 / f64::from(ticks), -0.5 / f64::from(ticks), 0.0],
                    turn: [0.0, 0.0, 1.0 / f64::from(ticks)],
                    closing: None,
                };
                let wish = grasp.wish(motion).expect("it moves");
                assert_eq!((&wish.tool[..], wish.opening), ("right", None));
                for k in 0..3 {
                    sum.0[k] += wish.shift[k];
                    sum.1[k] += wish.turn[k];
                }
            }
            assert!((sum.0[0] - 0.5 * field).abs() < 1e-12);
            assert!((sum.0[1] + 0.25 * field).abs() < 1e-12);
            assert!((sum.1[2] - 1.2).abs() < 1e-12);
        }
        assert_eq!(grasp(0.025).wish(Motion::default()), None);
    }

    /// Open 0.8; a trigger pressed by a quarter leaves three quarters of it. What stays closed is no longer a matter of the trigger.
    #[test]
    fn a_trigger_closes_by_as_much_as_it_is_pressed() {
        let mut grasp = grasp(0.025);
        let mut press = |closing| {
            let motion = Motion {
                closing: Some(closing),
                ..Motion::default()
            };
            let wish = grasp.wish(motion);
            (wish.and_then(|wish| wish.opening), grasp.release())
        };
        let (opening, release) = press(0.25);
        assert!((opening.unwrap() - 0.6).abs() < 1e-15);
        assert_eq!(release.unwrap().opening, Some(0.8), "the other hand");
        assert_eq!(press(1.0).0, Some(0.0));
        assert_eq!(press(0.0), (Some(0.8), None));
        press(1.0);
        grasp.keeps = true;
        assert_eq!(grasp.release(), None);
        let released = Motion {
            closing: Some(0.0),
            ..Motion::default()
        };
        assert_eq!(grasp.wish(released), None);
    }

    #[test]
    fn buttons_are_keys_of_what_is_shown() {
        assert_eq!(key(Press::Pause, Stage::Before), Some(Key::Enter));
        assert_eq!(key(Press::Pause, Stage::Run), Some(Key::Escape));
        assert_eq!(key(Press::OtherHand, Stage::Run), Some(Key::Tab));
        assert_eq!(key(Press::HoldClosed, Stage::Run), Some(Key::C));
        assert_eq!(key(Press::Magnify, Stage::Replay), Some(Key::Plus));
        assert_eq!(key(Press::HoldClosed, Stage::Before), None);
        assert_eq!(key(Press::Pause, Stage::Other), None);
    }
}
