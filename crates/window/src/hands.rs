//! Mouse and keyboard as wishes for the tools.
//!
//! The pointer moves the tip of the active tool in the plane of the field, so that it goes along with the pointer in the picture; the wheel lifts and lowers it. The left button
//! closes it, the right one turns it. The other hand stays where it is.

use eframe::egui::{self, Event, Key, MouseWheelUnit, PointerButton, Rect, Vec2};
use microsim_message::DesktopInput;
use microsim_settings::{Desktop, View};

/// A drag of the right button turns by this much \[rad per point\].
const TURN: f64 = 0.006;
/// A key that is held turns by this much in a second \[rad/s\].
const KEY_TURN: f64 = 1.2;
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
    /// The tool that the button closes now.
    closing: Option<usize>,
    desktop: Desktop,
    view: View,
}

impl Hands {
    /// Hands for the tools of a level; the right one, which is the last, begins.
    pub fn new(tools: Vec<String>, desktop: Desktop, view: View) -> Self {
        Self {
            active: tools.len().saturating_sub(1),
            keeps: vec![false; tools.len()],
            closing: None,
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

    fn wish(&self, tool: usize) -> DesktopInput {
        DesktopInput {
            tool: self.tools[tool].clone(),
            ..DesktopInput::default()
        }
    }

    /// What the events since the last picture ask for; `picture` is where the field is shown \[points\], of whose smaller side the field takes all.
    pub fn wishes(&mut self, input: &egui::InputState, picture: Rect) -> Vec<DesktopInput> {
        let mut wishes = Vec::new();
        if self.tools.is_empty() {
            return wishes;
        }
        if input.key_pressed(Key::Tab) && self.tools.len() > 1 {
            wishes.extend(self.release());
            self.active = (self.active + 1) % self.tools.len();
        }
        let fine = if input.modifiers.shift { FINE } else { 1.0 };
        let mut wish = self.wish(self.active);
        let is_over = |position: Option<egui::Pos2>| position.is_some_and(|p| picture.contains(p));
        let over = is_over(input.pointer.latest_pos());
        if over && !input.pointer.button_down(PointerButton::Secondary) {
            self.move_tip(&mut wish, input.pointer.delta(), picture, fine);
        }
        if input.pointer.button_down(PointerButton::Secondary) && is_over(input.pointer.press_origin())
        {
            let Vec2 { x, y } = input.pointer.delta();
            wish.turn[0] += f64::from(x) * TURN * fine;
            wish.turn[1] += f64::from(y) * TURN * fine;
        }
        let step = self.desktop.step * self.view.field * fine;
        wish.shift[2] += if over { notches(input) } else { 0.0 } * step;
        self.press_keys(&mut wish, input, step, fine);
        if wish.shift != [0.0; 3] || wish.turn != [0.0; 3] {
            wishes.push(wish);
        }
        if over && input.pointer.button_pressed(PointerButton::Primary) {
            self.closing = Some(self.active);
            self.keeps[self.active] = false;
            wishes.push(DesktopInput {
                opening: Some(0.0),
                ..self.wish(self.active)
            });
        }
        if input.key_pressed(Key::C) {
            self.keeps[self.active] = !self.keeps[self.active];
            let opening = match self.keeps[self.active] {
                true => 0.0,
                false => self.desktop.opening,
            };
            if self.closing != Some(self.active) {
                wishes.push(DesktopInput {
                    opening: Some(opening),
                    ..self.wish(self.active)
                });
            }
        }
        if !input.pointer.button_down(PointerButton::Primary) {
            wishes.extend(self.release());
        }
        wishes
    }

    /// The button is no longer pressed: jaws that are not kept closed open.
    pub fn release(&mut self) -> Option<DesktopInput> {
        let tool = self.closing.take()?;
        (!self.keeps[tool]).then(|| DesktopInput {
            opening: Some(self.desktop.opening),
            ..self.wish(tool)
        })
    }

    /// A motion in the plane of the field that is seen as this one \[points\].
    fn move_tip(&self, wish: &mut DesktopInput, delta: Vec2, picture: Rect, fine: f64) {
        let side = f64::from(picture.width().min(picture.height())).max(1.0);
        let scale = self.view.field / side * fine;
        let foreshortening = libm::cos(self.view.tilt).max(LEAST_FORESHORTENING);
        wish.shift[0] += f64::from(delta.x) * scale;
        wish.shift[1] -= f64::from(delta.y) * scale / foreshortening;
    }

    fn press_keys(&self, wish: &mut DesktopInput, input: &egui::InputState, step: f64, fine: f64) {
        let presses = |key: Key| {
            let is_press = |event: &&Event| matches!(event, Event::Key { key: k, pressed: true, .. } if *k == key);
            input.events.iter().filter(is_press).count() as f64
        };
        for (key, axis, sign) in [
            (Key::ArrowRight, 0, 1.0),
            (Key::ArrowLeft, 0, -1.0),
            (Key::ArrowUp, 1, 1.0),
            (Key::ArrowDown, 1, -1.0),
            (Key::W, 2, 1.0),
            (Key::S, 2, -1.0),
        ] {
            wish.shift[axis] += presses(key) * sign * step;
        }
        let dt = f64::from(input.stable_dt.min(0.1));
        for (key, sign) in [(Key::Q, -1.0), (Key::E, 1.0)] {
            if input.key_down(key) {
                wish.turn[2] += sign * KEY_TURN * dt * fine;
            }
        }
    }
}

/// Notches of the wheel since the last picture, away from the hand positive.
fn notches(input: &egui::InputState) -> f64 {
    let turned = |event: &Event| match event {
        Event::MouseWheel {
            unit: MouseWheelUnit::Line | MouseWheelUnit::Page,
            delta,
            ..
        } => f64::from(delta.y),
        // A touch pad: a line has about the height of a text.
        Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta,
            ..
        } => f64::from(delta.y) / 16.0,
        _ => 0.0,
    };
    input.events.iter().map(turned).sum()
}
