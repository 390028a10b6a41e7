//! Mouse and keyboard as wishes for the tools.
//!
//! The pointer moves the tip of the active tool in the plane of the field, so that it goes along with the pointer in the picture; the wheel lifts and lowers it. The left button
//! closes it, the right one turns it, and keys open it by as much as a grip, a ring or a lumen takes. The other hand stays where it is.

use crate::steering::Grasp;
use eframe::egui::{self, Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Rect, Vec2};
use microsim_message::DesktopInput;
use microsim_settings::{Desktop, View};

/// A drag of the right button turns by this much \[rad per point\].
const TURN: f64 = 0.006;
/// Keys that roll the handle by a step: key, direction.
const ROLLS: [(Key, f64); 2] = [(Key::Q, -1.0), (Key::E, 1.0)];
/// Such a step \[rad\]; a key that is held repeats it 25 to 30 times in a second on most desktops.
const ROLL_STEP: f64 = 0.04;
/// Keys that open jaws by a step: key, direction.
const OPENINGS: [(Key, f64); 2] = [(Key::A, -1.0), (Key::D, 1.0)];
/// What such a step is of the whole opening.
const OPENING_STEP: f64 = 0.04;
/// Keys that move the tip by a step: key, axis of the field, direction.
const STEPS: [(Key, usize, f64); 6] = [
    (Key::ArrowRight, 0, 1.0),
    (Key::ArrowLeft, 0, -1.0),
    (Key::ArrowUp, 1, 1.0),
    (Key::ArrowDown, 1, -1.0),
    (Key::W, 2, 1.0),
    (Key::S, 2, -1.0),
];
/// With Shift, motions are this much of what they are without.
const FINE: f64 = 0.25;
/// Lifting a tip moves it in the picture, too; a field that is seen from the side would make depth of a small motion, which this bounds.
const LEAST_FORESHORTENING: f64 = 0.3;

/// Who holds what.
#[derive(Clone, Debug)]
pub struct Hands {
    tools: Vec<String>,
    active: usize,
    /// Whether each keeps its jaws closed when the button is released.
    keeps: Vec<bool>,
    /// How far each is open where nothing closes it.
    openings: Vec<f64>,
    /// The tool that the button closes now.
    closing: Option<usize>,
    /// Whether the right button turns.
    is_turning: bool,
    /// Whether Shift was pressed with the picture before.
    had_shift: bool,
    /// Where the pointer was last \[points\].
    pointer: Option<Pos2>,
    desktop: Desktop,
    view: View,
}

impl Hands {
    /// Hands for the tools of a level; the right one, which is the last, begins.
    pub fn new(tools: Vec<String>, desktop: Desktop, view: View) -> Self {
        Self {
            active: tools.len().saturating_sub(1),
            keeps: vec![false; tools.len()],
            openings: vec![desktop.opening; tools.len()],
            closing: None,
            is_turning: false,
            had_shift: false,
            pointer: None,
            tools,
            desktop,
            view,
        }
    }

    /// The tool that moves.
    pub fn active(&self) -> usize {
        self.active
    }

    /// Whether a tool keeps its jaws closed.
    pub fn keeps(&self, tool: usize) -> bool {
        self.keeps.get(tool).copied().unwrap_or_default()
    }

    /// What the microscope shows now.
    pub fn look(&mut self, view: View) {
        self.view = view;
    }

    /// The tool in hand for other devices, which do not move it yet.
    pub fn grasp(&self) -> Option<Grasp> {
        Some(Grasp {
            tool: self.tools.get(self.active)?.clone(),
            speed: 0.0,
            opening: self.openings[self.active],
            keeps: self.keeps(self.active),
            is_closed: false,
        })
    }

    fn wish(&self, tool: usize) -> DesktopInput {
        DesktopInput {
            tool: self.tools[tool].clone(),
            ..DesktopInput::default()
        }
    }

    /// What the events since the last picture ask for, one after the other, however many there are: `picture` is where the field is shown \[points\], of whose smaller side
    /// the field takes all.
    pub fn wishes(&mut self, input: &egui::InputState, picture: Rect) -> Vec<DesktopInput> {
        let mut wishes = Vec::new();
        if self.tools.is_empty() {
            return wishes;
        }
        // A pointer that lay there before the level began.
        let before = input
            .pointer
            .latest_pos()
            .map(|now| now - input.pointer.delta());
        self.pointer = self.pointer.or(before);
        for event in &input.events {
            let is_fine = self.is_fine(event, input.modifiers);
            self.handle(event, is_fine, picture, &mut wishes);
        }
        self.had_shift = input.modifiers.shift;
        wishes
    }

    fn handle(
        &mut self,
        event: &Event,
        is_fine: bool,
        picture: Rect,
        wishes: &mut Vec<DesktopInput>,
    ) {
        let fine = if is_fine { FINE } else { 1.0 };
        let step = self.desktop.step * self.view.field * fine;
        let mut wish = self.wish(self.active);
        match event {
            Event::PointerMoved(to) => {
                let from = self.pointer.replace(*to);
                let is_over =
                    from.is_some_and(|from| picture.contains(from)) && picture.contains(*to);
                let delta = *to - from.unwrap_or(*to);
                match self.is_turning {
                    true => {
                        wish.turn[0] = f64::from(delta.x) * TURN * fine;
                        wish.turn[1] = f64::from(delta.y) * TURN * fine;
                    }
                    false if is_over => self.move_tip(&mut wish, delta, picture, fine),
                    false => {}
                }
            }
            Event::PointerGone => self.pointer = None,
            Event::PointerButton {
                pos,
                button: PointerButton::Secondary,
                pressed,
                ..
            } => self.is_turning = *pressed && picture.contains(*pos),
            Event::PointerButton {
                pos,
                button: PointerButton::Primary,
                pressed,
                ..
            } => match pressed {
                true if picture.contains(*pos) => {
                    self.closing = Some(self.active);
                    self.keeps[self.active] = false;
                    wish.opening = Some(0.0);
                }
                true => {}
                false => wishes.extend(self.release()),
            },
            Event::MouseWheel { unit, delta, .. } => {
                // A touch pad counts points: a line has about the height of a text.
                let points = if *unit == MouseWheelUnit::Point {
                    16.0
                } else {
                    1.0
                };
                if self.pointer.is_some_and(|at| picture.contains(at)) {
                    wish.shift[2] = f64::from(delta.y) / points * step;
                }
            }
            Event::Key {
                key,
                pressed: true,
                repeat,
                ..
            } => {
                if let Some((_, axis, sign)) = STEPS.iter().find(|(of, ..)| of == key) {
                    wish.shift[*axis] = sign * step;
                } else if let Some((_, sign)) = ROLLS.iter().find(|(of, _)| of == key) {
                    wish.turn[2] = sign * ROLL_STEP * fine;
                } else if let Some((_, sign)) = OPENINGS.iter().find(|(of, _)| of == key) {
                    wish.opening = self.open(sign * OPENING_STEP * fine);
                } else if *key == Key::Tab && !repeat && self.tools.len() > 1 {
                    wishes.extend(self.release());
                    self.active = (self.active + 1) % self.tools.len();
                } else if *key == Key::C && !repeat {
                    self.keeps[self.active] = !self.keeps[self.active];
                    let keeps = self.keeps[self.active];
                    // While the button is pressed they are closed; what counts is its release.
                    if self.closing != Some(self.active) {
                        let opening = self.openings[self.active];
                        wish.opening = Some(if keeps { 0.0 } else { opening });
                    }
                }
            }
            // Whoever looks at another window lets go.
            Event::WindowFocused(false) => {
                self.is_turning = false;
                wishes.extend(self.release());
            }
            _ => {}
        }
        if wish.shift != [0.0; 3] || wish.turn != [0.0; 3] || wish.opening.is_some() {
            wishes.push(wish);
        }
    }

    /// Whether Shift was pressed with an event. Of motions of the pointer it is not stated: with the pictures before and after them it was.
    fn is_fine(&self, event: &Event, after: Modifiers) -> bool {
        match event {
            Event::Key { modifiers, .. } | Event::MouseWheel { modifiers, .. } => modifiers.shift,
            _ => self.had_shift && after.shift,
        }
    }

    /// The button is no longer pressed: jaws open that are not to stay closed.
    pub fn release(&mut self) -> Option<DesktopInput> {
        let tool = self.closing.take()?;
        (!self.keeps[tool]).then(|| DesktopInput {
            opening: Some(self.openings[tool]),
            ..self.wish(tool)
        })
    }

    /// Opens the jaws in hand by this much more, from closed where they stay closed; those that the button closes open so far when it is released.
    fn open(&mut self, by: f64) -> Option<f64> {
        let stayed_closed = std::mem::take(&mut self.keeps[self.active]);
        let opening = &mut self.openings[self.active];
        // Steps back end where those forth began, and closed is closed.
        let sum = if stayed_closed { 0.0 } else { *opening } + by;
        *opening = (libm::round(sum * 1e6) / 1e6).clamp(0.0, 1.0);
        (self.closing != Some(self.active)).then_some(*opening)
    }

    /// A motion in the plane of the field that is seen as this one \[points\].
    fn move_tip(&self, wish: &mut DesktopInput, delta: Vec2, picture: Rect, fine: f64) {
        let side = f64::from(picture.width().min(picture.height())).max(1.0);
        let scale = self.view.field / side * fine;
        let foreshortening = libm::cos(self.view.tilt).max(LEAST_FORESHORTENING);
        wish.shift[0] += f64::from(delta.x) * scale;
        wish.shift[1] -= f64::from(delta.y) * scale / foreshortening;
    }
}

/// What is wished for in the picture, for a field that is mirrored in it: x, the azimuth and the roll of a handle change their signs.
pub fn mirrored(wish: DesktopInput) -> DesktopInput {
    let ([x, y, z], [azimuth, elevation, roll]) = (wish.shift, wish.turn);
    DesktopInput {
        shift: [-x, y, z],
        turn: [-azimuth, elevation, -roll],
        ..wish
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shortcut;
    use eframe::egui::{pos2, vec2};

    const PICTURE: Rect = Rect {
        min: pos2(0.0, 0.0),
        max: pos2(500.0, 500.0),
    };

    fn hands() -> Hands {
        let view = View {
            field: 0.025,
            centre: [0.0; 3],
            tilt: 60_f64.to_radians(),
        };
        let desktop = microsim_settings::read_desktop("", "desktop.toml")
            .unwrap()
            .settings;
        Hands::new(vec!["left".into(), "right".into()], desktop, view)
    }

    fn handle(hands: &mut Hands, events: &[Event]) -> Vec<DesktopInput> {
        let mut wishes = Vec::new();
        for event in events {
            hands.handle(event, false, PICTURE, &mut wishes);
        }
        wishes
    }

    fn button(button: PointerButton, pressed: bool) -> Event {
        Event::PointerButton {
            pos: pos2(100.0, 100.0),
            button,
            pressed,
            modifiers: Modifiers::NONE,
        }
    }

    /// 500 points are 25 mm, so 20 points are 1 mm to the right; upwards, seen at 60°, they are 1 mm / cos 60° in the plane of the field. Shift takes a quarter.
    #[test]
    fn the_tip_goes_along_with_the_pointer() {
        let mut hands = hands();
        let there = Event::PointerMoved(pos2(100.0, 100.0));
        let moved = Event::PointerMoved(pos2(120.0, 80.0));
        let wishes = handle(&mut hands, &[there.clone(), moved.clone()]);
        let [wish] = &wishes[..] else {
            panic!("{wishes:?}")
        };
        assert_eq!(wish.tool, "right");
        assert!((wish.shift[0] - 1e-3).abs() < 1e-9 && (wish.shift[1] - 2e-3).abs() < 1e-9);
        handle(&mut hands, &[there]);
        let mut fine = Vec::new();
        hands.handle(&moved, true, PICTURE, &mut fine);
        assert!((fine[0].shift[0] - 0.25e-3).abs() < 1e-9);
        // From outside of the picture nothing is pulled along.
        let outside = Event::PointerMoved(pos2(900.0, 80.0));
        assert_eq!(handle(&mut hands, &[outside, moved]), []);
    }

    /// However slow the pictures are: what was done between two of them counts in its order.
    #[test]
    fn buttons_close_and_turn_in_the_order_of_the_events() {
        let mut hands = hands();
        let to = |x, y| Event::PointerMoved(pos2(x, y));
        let turn = button(PointerButton::Secondary, true);
        let events = [
            to(100.0, 100.0),
            turn,
            to(110.0, 100.0),
            button(PointerButton::Secondary, false),
            to(110.0, 120.0),
        ];
        let wishes = handle(&mut hands, &events);
        assert_eq!(wishes.len(), 2, "{wishes:?}");
        assert!(wishes[0].turn[0] > 0.0 && wishes[0].shift == [0.0; 3]);
        assert!(wishes[1].turn == [0.0; 3] && wishes[1].shift[1] < 0.0);

        let opening =
            |wishes: Vec<DesktopInput>| wishes.iter().map(|w| w.opening).collect::<Vec<_>>();
        let press = button(PointerButton::Primary, true);
        let release = button(PointerButton::Primary, false);
        assert_eq!(
            opening(handle(&mut hands, &[press.clone(), release.clone()])),
            [Some(0.0), Some(0.8)]
        );
        // Kept closed: the release does not open, the key does.
        assert_eq!(
            opening(handle(
                &mut hands,
                &[press.clone(), shortcut::press(Key::C), release.clone()]
            )),
            [Some(0.0)]
        );
        assert_eq!(
            opening(handle(&mut hands, &[shortcut::press(Key::C)])),
            [Some(0.8)]
        );
        // By steps from where they are, to the end of their way, and back to it after the button; from closed where they stayed so.
        let steps = |keys: &[Key]| {
            keys.iter()
                .map(|key| shortcut::press(*key))
                .collect::<Vec<_>>()
        };
        let asked = opening(handle(&mut hands, &steps(&[Key::A, Key::A, Key::D])));
        let expected = [0.76, 0.72, 0.76];
        assert!(
            asked
                .iter()
                .zip(expected)
                .all(|(a, b)| (a.unwrap() - b).abs() < 1e-12),
            "{asked:?}"
        );
        let asked = opening(handle(&mut hands, &[press.clone(), release.clone()]));
        assert!(asked[0] == Some(0.0) && (asked[1].unwrap() - 0.76).abs() < 1e-12);
        let asked = opening(handle(&mut hands, &steps(&[Key::C, Key::A, Key::D])));
        assert_eq!(asked, [Some(0.0), Some(0.0), Some(0.04)]);
        let asked = opening(handle(&mut hands, &steps(&[Key::D; 26])));
        assert_eq!(asked.last(), Some(&Some(1.0)));
        let mut wishes = Vec::new();
        hands.handle(&shortcut::press(Key::A), true, PICTURE, &mut wishes);
        assert_eq!(wishes[0].opening, Some(0.99), "a quarter of a step");
        // The other hand: what the button closed opens, and the wheel lifts the other one.
        let wheel = Event::MouseWheel {
            unit: MouseWheelUnit::Line,
            delta: vec2(0.0, 1.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        };
        let wishes = handle(&mut hands, &[press, shortcut::press(Key::Tab), wheel]);
        let of: Vec<(&str, Option<f64>)> =
            wishes.iter().map(|w| (&w.tool[..], w.opening)).collect();
        assert_eq!(
            of,
            [("right", Some(0.0)), ("right", Some(0.99)), ("left", None)]
        );
        assert!((wishes[2].shift[2] - 0.25e-3).abs() < 1e-12);
    }

    /// As often as a key was pressed, however slow the pictures are; with Shift, which may be released before the picture, by a quarter.
    #[test]
    fn a_key_rolls_by_a_step() {
        let rolls = [Key::E, Key::E, Key::Q].map(shortcut::press);
        let turns = handle(&mut hands(), &rolls);
        let turns: Vec<f64> = turns.iter().map(|wish| wish.turn[2]).collect();
        assert_eq!(turns, [ROLL_STEP, ROLL_STEP, -ROLL_STEP]);
        let shifted = Event::Key {
            key: Key::E,
            physical_key: None,
            pressed: true,
            repeat: true,
            modifiers: Modifiers::SHIFT,
        };
        let mut own = hands();
        assert!(own.is_fine(&shifted, Modifiers::NONE));
        assert!(!own.is_fine(&rolls[0], Modifiers::SHIFT));
        let moved = Event::PointerMoved(pos2(0.0, 0.0));
        assert!(!own.is_fine(&moved, Modifiers::SHIFT));
        own.had_shift = true;
        assert!(own.is_fine(&moved, Modifiers::SHIFT));
        assert!(!own.is_fine(&moved, Modifiers::NONE));
        let mut wishes = Vec::new();
        own.handle(&shifted, true, PICTURE, &mut wishes);
        assert_eq!(wishes[0].turn, [0.0, 0.0, 0.25 * ROLL_STEP]);
    }

    /// Where right and left are exchanged in the picture, a pointer that goes to the right asks for a smaller x; up stays up. How the angles of a hand change is in its
    /// own tests.
    #[test]
    fn in_a_mirrored_picture_the_tip_goes_along_with_the_pointer() {
        let wish = DesktopInput {
            shift: [1e-3, 2e-3, 3e-3],
            turn: [0.1, 0.2, 0.3],
            opening: Some(0.5),
            tool: "right".into(),
        };
        let seen = mirrored(wish.clone());
        assert_eq!(seen.shift, [-1e-3, 2e-3, 3e-3]);
        assert_eq!(seen.turn, [-0.1, 0.2, -0.3]);
        assert_eq!(mirrored(seen), wish);
    }
}
