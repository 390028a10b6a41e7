//! What stands beside the picture: task and events, instruments, how well the computer follows.

use crate::look;
use crate::pace::{Pace, Times};
use crate::station::{LevelEntry, ModuleEntry, ToolEntry};
use crate::text::{self, Phrase, local, number};
use eframe::egui::{self, RichText, ScrollArea, Ui};
use microsim_message::{LevelEvent, LevelState, ToolState, ToolStatus};
use microsim_render::Quality;
use microsim_vocabulary::Language;

/// Events that are shown, the newest last.
const EVENTS: usize = 6;

/// The task and how far it is.
pub struct Task<'a> {
    /// The module.
    pub module: &'a ModuleEntry,
    /// The level.
    pub level: &'a LevelEntry,
    /// Whether it is mirrored: where its text has left, it is right.
    pub mirrored: bool,
    /// How far it is.
    pub state: LevelState,
    /// Simulated time \[s\].
    pub time: f64,
    /// What happened.
    pub events: &'a [LevelEvent],
}

impl Task<'_> {
    /// Shows it.
    pub fn show(&self, ui: &mut Ui, language: Language) {
        ui.add_space(8.0);
        ui.label(look::quiet(local(&self.module.title, language)));
        let title = format!(
            "{} {}: {}",
            text::LEVEL.of(language),
            self.level.number,
            local(&self.level.title, language)
        );
        ui.label(RichText::new(title).size(17.0).strong());
        ui.add_space(8.0);
        ui.label(look::heading(text::TASK.of(language)));
        ui.label(local(&self.level.summary, language));
        if self.mirrored {
            ui.label(look::quiet(text::MIRRORED.of(language)));
        }
        ui.add_space(8.0);
        egui::Grid::new("state").num_columns(2).show(ui, |ui| {
            ui.label(text::TIME.of(language));
            ui.strong(format!("{} s", number(self.time, 1, language)));
            ui.end_row();
            ui.label(text::TARGETS.of(language));
            ui.strong(format!(
                "{} / {}",
                self.state.targets_done, self.state.targets
            ));
            ui.end_row();
        });
        if !self.events.is_empty() {
            ui.add_space(8.0);
            ui.label(look::heading(text::HINTS.of(language)));
            let skipped = self.events.len().saturating_sub(EVENTS);
            let room = (ui.available_height() - 12.0).max(20.0);
            let newest = ScrollArea::vertical().stick_to_bottom(true);
            newest.max_height(room).show(ui, |ui| {
                for event in &self.events[skipped..] {
                    let time = number(event.time, 1, language);
                    let text = local(&event.text, language);
                    ui.label(look::quiet(format!("{time} s  {text}")));
                }
            });
        }
    }
}

/// A tool and how it is held.
pub struct Instrument<'a> {
    /// What it is.
    pub tool: &'a ToolEntry,
    /// Where it is, once it was seen.
    pub state: Option<&'a ToolState>,
    /// Whether mouse and keyboard move it.
    pub is_active: bool,
    /// Whether its jaws stay closed.
    pub keeps_closed: bool,
}

fn status(status: ToolStatus) -> Phrase {
    match status {
        ToolStatus::Tracked => text::TRACKED,
        ToolStatus::Occluded => text::OCCLUDED,
        ToolStatus::Stale => text::STALE,
        ToolStatus::NeverSeen => text::NEVER_SEEN,
    }
}

/// Shows the instruments.
pub fn instruments(ui: &mut Ui, instruments: &[Instrument<'_>], language: Language) {
    ui.add_space(8.0);
    ui.label(look::heading(text::INSTRUMENTS.of(language)));
    for instrument in instruments {
        look::card(instrument.is_active).show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.strong(local(&instrument.tool.title, language));
            let mut words = Vec::new();
            if instrument.is_active {
                words.push(text::ACTIVE.of(language));
            }
            if instrument.keeps_closed {
                words.push(text::KEPT_CLOSED.of(language));
            }
            let state = instrument.state;
            words.push(status(state.map_or(ToolStatus::NeverSeen, |s| s.status)).of(language));
            ui.label(look::quiet(words.join(" · ")));
            if let Some(state) = state {
                let opening = number(100.0 * state.opening, 0, language);
                let height = number(1e3 * state.pose.position[2], 1, language);
                ui.label(look::quiet(format!(
                    "{} {opening} % · {} {height} mm",
                    text::OPENING.of(language),
                    text::HEIGHT.of(language)
                )));
            }
        });
    }
}

/// Shows how the microscope is set.
pub fn scope(ui: &mut Ui, magnification: f64, language: Language) {
    let magnification = number(magnification, 1, language);
    ui.label(look::quiet(format!(
        "{} ×{magnification}",
        text::MICROSCOPE.of(language)
    )));
}

/// Shows what may be higher than the panel.
pub fn scrolled(ui: &mut Ui, show: impl FnOnce(&mut Ui)) {
    let height = ui.available_height() - 8.0;
    ScrollArea::vertical().max_height(height).show(ui, show);
}

/// Shows how mouse and keyboard move them, after what other devices are used for.
pub fn help(ui: &mut Ui, devices: &[Phrase], language: Language) {
    ui.add_space(4.0);
    ui.spacing_mut().item_spacing.y = 1.0;
    for help in devices.iter().chain(&[text::MOUSE, text::KEYS]) {
        for line in help.of(language).split(" · ") {
            ui.label(look::quiet(line));
        }
    }
}

/// Shows how much is done for a picture.
pub fn quality(ui: &mut Ui, quality: Quality, language: Language) {
    let word = match quality {
        Quality::Low => text::LOW,
        Quality::Medium => text::MEDIUM,
        Quality::High => text::HIGH,
    };
    ui.label(look::quiet(format!(
        "{} {} (F2)",
        text::QUALITY.of(language),
        word.of(language)
    )));
}

/// How pictures follow the run.
#[derive(Clone, Copy, Debug)]
pub struct Pictures<'a> {
    /// So many in a second.
    pub rate: Option<f64>,
    /// From a snapshot to its picture.
    pub delays: &'a Times,
    /// How much is done for each.
    pub quality: Quality,
}

/// Shows how well the run follows the wall clock, and the delay of motions by stage: to the tick, of the tick, to the picture.
pub fn pace(ui: &mut Ui, pace: &Pace, pictures: &Pictures<'_>, language: Language) {
    ui.add_space(6.0);
    ui.label(look::quiet(text::SPEED_OF_RUN.of(language)).strong());
    let shown = |value: Option<f64>, decimals| match value {
        Some(value) => number(value, decimals, language),
        None => "–".to_owned(),
    };
    for (stage, times) in [
        (text::TO_THE_TICK, &pace.waits),
        (text::TICK, &pace.ticks),
        (text::TO_THE_PICTURE, pictures.delays),
    ] {
        let [p50, p99] = [0.5, 0.99].map(|q| shown(times.quantile(q).map(|t| 1e3 * t), 1));
        let stage = stage.of(language);
        ui.label(look::quiet(format!("{stage} p50 {p50}, p99 {p99} ms")));
    }
    if let Some(samples) = pace.samples {
        ui.label(look::quiet(format!(
            "{}: {} {} · {} {}",
            text::SAMPLES.of(language),
            samples.dropped,
            text::DROPPED.of(language),
            samples.late,
            text::LATE.of(language)
        )));
    }
    self::quality(ui, pictures.quality, language);
    let rate = shown(pictures.rate, 0);
    ui.label(look::quiet(format!(
        "{rate} {} · {} {}",
        text::PICTURES.of(language),
        pace.late,
        text::LATE.of(language)
    )));
    ui.label(look::quiet(format!(
        "{} {}",
        pace.unconverged,
        text::UNCONVERGED.of(language)
    )));
}
