//! What stands around the picture of a replay: what is replayed and whether it is the same, what happened, how it is played.

use crate::look;
use crate::panels;
use crate::player::{SPEEDS, State};
use crate::plot::{self, Curve};
use crate::shortcut;
use crate::text::{self, Phrase, local, number};
use crate::timeline::{self, Mark, TimeLine};
use crate::views;
use eframe::egui::{
    self, Align, Button, Key, Label, Layout, ProgressBar, Rect, RichText, ScrollArea, Shape,
    Stroke, Ui, pos2, vec2,
};
use microsim_render::Quality;
use microsim_report::Report;
use microsim_vocabulary::{DebugView, Language};

/// Width of the panel beside the picture \[points\].
const PANEL: f32 = 290.0;
/// Height of a plot below it \[points\].
const PLOT: f32 = 78.0;
/// What the speeds are called.
pub const SPEED_NAMES: [&str; 5] = ["¼", "½", "1", "2", "4"];

/// What the viewer asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// To the debrief.
    Back,
    /// The other language.
    Language,
    /// To play, or to pause.
    PlayOrPause,
    /// Another one of the speeds.
    Speed(usize),
    /// Another tick.
    GoTo(u64),
    /// The first tick.
    Begin,
    /// The last tick.
    End,
    /// A tick after the one that is shown, or before it.
    Step(i64),
    /// The event before the tick that is shown.
    EventBefore,
    /// The event after it.
    EventAfter,
    /// A reference beside it, or none any more.
    Ghost,
    /// A film of it.
    Film,
}

/// What a key asks for.
pub fn by_key(key: Key) -> Option<Asked> {
    Some(match key {
        Key::Escape => Asked::Back,
        Key::Space => Asked::PlayOrPause,
        Key::ArrowLeft => Asked::Step(-1),
        Key::ArrowRight => Asked::Step(1),
        Key::ArrowUp => Asked::EventBefore,
        Key::ArrowDown => Asked::EventAfter,
        Key::Home => Asked::Begin,
        Key::End => Asked::End,
        Key::G => Asked::Ghost,
        Key::V => Asked::Film,
        Key::Num1 => Asked::Speed(0),
        Key::Num2 => Asked::Speed(1),
        Key::Num3 => Asked::Speed(2),
        Key::Num4 => Asked::Speed(3),
        Key::Num5 => Asked::Speed(4),
        _ => return None,
    })
}

/// A sign on a button, drawn: fonts do not have them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sign {
    Begin,
    Before,
    Back,
    Forth,
    After,
    End,
}

/// Whether a button with a sign was pressed; what it means stands under the pointer.
fn sign_button(ui: &mut Ui, sign: Sign, meaning: &str) -> bool {
    let button = Button::new("").min_size(vec2(40.0, 31.0));
    let response = ui.add(button);
    let (direction, triangles, has_bar) = match sign {
        Sign::Begin => (-1.0, 1, true),
        Sign::Before => (-1.0, 2, false),
        Sign::Back => (-1.0, 1, false),
        Sign::Forth => (1.0, 1, false),
        Sign::After => (1.0, 2, false),
        Sign::End => (1.0, 1, true),
    };
    let middle = response.rect.center();
    let tip =
        |k: usize| middle.x + direction * (5.0 + 8.0 * k as f32 - 4.0 * (triangles - 1) as f32);
    for k in 0..triangles {
        let back = tip(k) - direction * 8.0;
        let corners = [
            pos2(tip(k), middle.y),
            pos2(back, middle.y - 6.0),
            pos2(back, middle.y + 6.0),
        ];
        let triangle = Shape::convex_polygon(corners.into(), look::TEXT, Stroke::NONE);
        ui.painter().add(triangle);
    }
    if has_bar {
        let bar = Rect::from_center_size(pos2(tip(0), middle.y), vec2(2.0, 12.0));
        ui.painter().rect_filled(bar, 0.0, look::TEXT);
    }
    response.on_hover_text(meaning).clicked()
}

/// What is shown.
pub struct Console<'a> {
    /// What came of the session.
    pub report: &'a Report,
    /// What happened.
    pub marks: &'a [Mark],
    /// Speeds and forces, if there are any.
    pub curves: &'a [Vec<Curve>],
    /// How far the player is.
    pub state: &'a State,
    /// Whether it plays.
    pub plays: bool,
    /// Place of its speed.
    pub speed: usize,
    /// How many times larger the field is seen.
    pub magnification: f64,
    /// How much is done for a picture.
    pub quality: Quality,
    /// Whether a reference is shown.
    pub ghost: bool,
    /// Whether a film can be ordered.
    pub films: bool,
    /// Whether what happened stands beside the picture, and the curves below it.
    pub panels: bool,
}

impl Console<'_> {
    /// Shows all of it; what is laid over the picture can be chosen there.
    pub fn show(
        &self,
        ui: &mut Ui,
        shown_views: &mut Vec<DebugView>,
        language: Language,
    ) -> Vec<Asked> {
        let mut asked = Vec::new();
        egui::Panel::top("replayed")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(6.0);
                self.show_head(ui, language, &mut asked);
                self.show_standing(ui, language);
                ui.add_space(4.0);
            });
        egui::Panel::bottom("player")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(4.0);
                self.show_controls(ui, language, &mut asked);
                self.show_time(ui, language, &mut asked);
                ui.add_space(4.0);
            });
        if self.panels {
            egui::Panel::right("events")
                .exact_size(PANEL)
                .resizable(false)
                .show(ui, |ui| {
                    self.show_events(ui, shown_views, language, &mut asked)
                });
        }
        asked
    }

    fn show_head(&self, ui: &mut Ui, language: Language, asked: &mut Vec<Asked>) {
        ui.horizontal(|ui| {
            ui.heading(text::REPLAY.of(language));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button(text::TO_THE_DEBRIEF.of(language)).clicked() {
                    asked.push(Asked::Back);
                }
                if shortcut::button(ui, text::LANGUAGE.of(language), shortcut::LANGUAGE) {
                    asked.push(Asked::Language);
                }
                for (name, is_on, wanted) in [
                    (text::FILM_KEY, self.films, Asked::Film),
                    (text::REFERENCE, self.ghost, Asked::Ghost),
                ] {
                    let button = Button::selectable(is_on, name.of(language));
                    if ui.add(button.frame_when_inactive(true)).clicked() {
                        asked.push(wanted);
                    }
                }
                let session = &self.report.session;
                let title = format!(
                    "{} · {} {}: {}",
                    local(&session.module_title, language),
                    text::LEVEL.of(language),
                    session.level,
                    local(&session.level_title, language)
                );
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    ui.add(Label::new(look::quiet(title)).truncate());
                });
            });
        });
    }

    /// Whether what is shown is what was recorded.
    fn show_standing(&self, ui: &mut Ui, language: Language) {
        let state = self.state;
        let standing = &state.standing;
        let words = |phrase: Phrase, rest: &str, colour| {
            RichText::new(format!("{} {rest}", phrase.of(language))).color(colour)
        };
        let mut lines = Vec::new();
        if let Some(why) = &state.failure {
            lines.push(words(text::REPLAY_ENDED, why, look::BAD));
        }
        let has_compared = standing.compared > state.range.start;
        let is_at_end =
            standing.is_complete || (has_compared && standing.compared >= state.range.end);
        if let Some(found) = &standing.difference {
            let mut note = text::NOT_AS_RECORDED.of(language).to_owned();
            if !state.rebuilt.is_empty() {
                let (of, names) = (text::OTHER_BUILD.of(language), state.rebuilt.join(", "));
                note = format!("{note} ({of} {names})");
            }
            // What it means comes first: what differs may take a message to state.
            let rest = format!("{}. {note}: {}", found.tick, found.what);
            lines.push(words(text::DIFFERS_AT, &rest, look::BAD));
        } else if state.failure.is_none() {
            lines.push(match &standing.complaint {
                _ if !state.is_open => words(text::RECORDING_IS_READ, "", look::QUIET),
                Some(why) if is_at_end => words(text::SAME_AS_FAR, why, look::BAD),
                None if standing.is_complete => words(text::SAME_TO_THE_END, "", look::GOOD),
                _ if has_compared => {
                    let (last, end) = (standing.compared - 1, state.range.end.saturating_sub(1));
                    words(text::SAME_SO_FAR, &format!("{last} / {end}"), look::GOOD)
                }
                _ => words(text::NOTHING_COMPARED, "", look::QUIET),
            });
        }
        for line in lines {
            // It is whole under the pointer.
            ui.add(Label::new(line).truncate());
        }
    }

    fn show_controls(&self, ui: &mut Ui, language: Language, asked: &mut Vec<Asked>) {
        ui.horizontal(|ui| {
            let mut button = |ui: &mut Ui, sign, meaning: Phrase, wanted| {
                if sign_button(ui, sign, meaning.of(language)) {
                    asked.push(wanted);
                }
            };
            button(ui, Sign::Begin, text::TO_THE_BEGINNING, Asked::Begin);
            button(ui, Sign::Before, text::EVENT_BEFORE, Asked::EventBefore);
            button(ui, Sign::Back, text::ONE_BACK, Asked::Step(-1));
            button(ui, Sign::Forth, text::ONE_FORWARD, Asked::Step(1));
            button(ui, Sign::After, text::EVENT_AFTER, Asked::EventAfter);
            button(ui, Sign::End, text::TO_THE_END, Asked::End);
            let play = match self.plays {
                true => text::PAUSE,
                false => text::PLAY,
            };
            let play = RichText::new(play.of(language)).color(look::ON_ACCENT);
            let play = Button::new(play.strong()).fill(look::ACCENT);
            if ui.add(play.min_size(egui::vec2(110.0, 0.0))).clicked() {
                asked.push(Asked::PlayOrPause);
            }
            ui.add_space(8.0);
            for (place, name) in SPEED_NAMES.iter().enumerate() {
                let is_chosen = place == self.speed;
                let speed = Button::selectable(is_chosen, format!("×{name}"));
                if ui.add(speed).clicked() {
                    asked.push(Asked::Speed(place));
                }
            }
            ui.add_space(8.0);
            let tick = self.state.shown.unwrap_or(self.state.range.start);
            let time = |ticks: u64| number(ticks as f64 * self.report.session.tick_s, 2, language);
            let (now, end) = (time(tick + 1), time(self.state.range.end));
            ui.label(RichText::new(format!("{now} / {end} s")).strong());
            let mut note = format!("{} {tick}", text::TICK.of(language));
            let rate = self
                .state
                .rate
                .filter(|rate| self.plays && *rate < 0.95 * SPEEDS[self.speed]);
            if let Some(rate) = rate {
                let rate = number(rate, 2, language);
                note = format!("{note} · {} ×{rate}", text::COMPUTED_WITH.of(language));
            }
            ui.add(Label::new(look::quiet(note)).truncate());
        });
    }

    fn show_time(&self, ui: &mut Ui, language: Language, asked: &mut Vec<Asked>) {
        let state = self.state;
        let line = TimeLine {
            range: state.range.clone(),
            now: state.shown,
            marks: self.marks,
            standing: &state.standing,
        };
        asked.extend(line.show(ui, language).map(Asked::GoTo));
        if let Some((goal, part)) = state.working {
            ui.horizontal(|ui| {
                let seconds = number(goal as f64 * self.report.session.tick_s, 2, language);
                let what = format!("{} {seconds} s", text::IS_COMPUTED.of(language));
                ui.label(look::quiet(what));
                ui.add(
                    ProgressBar::new(part as f32)
                        .corner_radius(2.0)
                        .fill(look::ACCENT),
                );
            });
        }
        let tick_s = self.report.session.tick_s;
        let times: Vec<f64> = self.marks.iter().map(|mark| mark.time).collect();
        let frame = plot::Frame {
            end: self.report.simulated,
            events: &times,
            now: state.shown.map(|tick| (tick + 1) as f64 * tick_s),
            height: PLOT,
        };
        let titles = [text::TIP_SPEED, text::FORCE];
        let plots: Vec<(&Vec<Curve>, Phrase)> = self
            .curves
            .iter()
            .zip(titles)
            .filter(|(curves, _)| !curves.is_empty())
            .collect();
        if plots.is_empty() || !self.panels {
            return;
        }
        ui.columns(plots.len(), |columns| {
            for (ui, (curves, title)) in columns.iter_mut().zip(&plots) {
                let clicked = plot::show(ui, title.of(language), curves, &frame, language);
                let tick = clicked.map(|time| timeline::tick_at(self.report, time));
                asked.extend(tick.map(Asked::GoTo));
            }
        });
    }

    fn show_events(
        &self,
        ui: &mut Ui,
        shown_views: &mut Vec<DebugView>,
        language: Language,
        asked: &mut Vec<Asked>,
    ) {
        ui.add_space(4.0);
        egui::Panel::bottom("keys")
            .show_separator_line(false)
            .show(ui, |ui| {
                panels::scope(ui, self.magnification, language);
                panels::quality(ui, self.quality, language);
                ui.spacing_mut().item_spacing.y = 1.0;
                let keys = text::REPLAY_KEYS.of(language);
                ui.label(look::quiet(keys));
            });
        ui.label(look::heading(text::HINTS.of(language)));
        ScrollArea::vertical()
            .id_salt("moments")
            .auto_shrink(false)
            .show(ui, |ui| {
                let clicked = timeline::list(ui, self.marks, self.state.shown, language);
                asked.extend(clicked.map(Asked::GoTo));
                ui.add_space(6.0);
                views::show(ui, shown_views, language);
            });
    }
}
