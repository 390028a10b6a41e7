//! Training: the picture in the middle, the task to its left, the instruments to its right.

use crate::account::Account;
use crate::canvas::{Canvas, Subject};
use crate::field::Field;
use crate::hands::Hands;
use crate::live::{Ended, Live, Snapshot};
use crate::pace::Times;
use crate::panels::{Instrument, Pictures, Task};
use crate::scope::Scope;
use crate::station::{Choice, LevelEntry, LiveSession, ModuleEntry};
use crate::text;
use crate::{look, panels};
use eframe::egui::{self, Key, Rect, RichText, Ui};
use microsim_message::{LevelState, ToolStates};
use microsim_render::{Models, Quality};
use microsim_settings::RendererConfig;
use microsim_vocabulary::Language;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Width of a panel \[points\].
const PANEL: f32 = 270.0;
/// Pictures over whose time their rate is measured.
const RATED: usize = 30;

/// A level that is being trained.
pub struct Training {
    /// What it is.
    pub choice: Choice,
    module: ModuleEntry,
    level: LevelEntry,
    config: RendererConfig,
    models: Models,
    live: Live,
    scope: Scope,
    /// `None` where a tracker, a script or a recording moves the tools.
    hands: Option<Hands>,
    /// Whether the trainee has begun: before, the level lies there as it is after its first tick.
    has_begun: bool,
    snapshot: Option<Snapshot>,
    canvas: Canvas,
    /// When the last pictures were drawn.
    drawn: VecDeque<Instant>,
    /// From snapshots to their pictures.
    delays: Arc<Mutex<Times>>,
    account: Account,
}

/// What the trainee or operator asked for, or what came of the run.
pub enum Outcome {
    /// The run has ended.
    Ended(Ended),
    /// From the beginning.
    Restart,
    /// To the modules.
    Back,
}

impl Training {
    /// Begins a run.
    ///
    /// # Errors
    /// If the system has no thread for it.
    pub fn begin(
        choice: Choice,
        module: &ModuleEntry,
        level: &LevelEntry,
        session: Box<dyn LiveSession>,
        context: &egui::Context,
    ) -> Result<Self, String> {
        let config = session.picture().clone();
        let files = session.files().iter();
        let files: Vec<(&str, &[u8])> = files.map(|f| (&f.name[..], &f.bytes[..])).collect();
        let models = Models::new(&files)?;
        let slots = level.tools.iter().map(|tool| tool.slot.clone());
        let hands = session.desktop();
        let hands = hands.map(|desktop| Hands::new(slots.collect(), *desktop, config.view));
        let wake = {
            let context = context.clone();
            move || context.request_repaint()
        };
        Ok(Self {
            choice,
            module: module.clone(),
            level: level.clone(),
            scope: Scope::new(config.view),
            config,
            models,
            live: Live::start(session, wake)?,
            hands,
            has_begun: false,
            snapshot: None,
            canvas: Canvas::default(),
            drawn: VecDeque::new(),
            delays: Arc::default(),
            account: Account::default(),
        })
    }

    /// Shows it, and hands on what mouse and keyboard ask for.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        field: &mut Field,
        panels: bool,
        language: Language,
    ) -> Option<Outcome> {
        if let Some(ended) = self.live.ended() {
            return Some(Outcome::Ended(ended));
        }
        if self.has_begun && ui.input(|input| input.key_pressed(Key::Escape)) {
            self.live.pause(!self.live.is_paused());
        }
        let goes_on = self.has_begun && !self.live.is_paused();
        self.account.go_on(goes_on, field.quality(), Instant::now());
        let newest = self.live.take();
        let is_new = newest.is_some();
        self.snapshot = newest.or(self.snapshot.take());
        if panels {
            self.show_task(ui, language);
        }
        if ui.input(|input| input.key_pressed(Key::F2)) {
            field.change_quality();
        }
        if panels {
            self.show_instruments(ui, field.quality(), language);
        }
        let shown = egui::CentralPanel::default()
            .frame(egui::Frame::NONE)
            .show(ui, |ui| self.show_picture(ui, field, is_new, language));
        let picture = shown.inner;
        if !self.has_begun {
            return self.show_introduction(ui, picture, language);
        }
        if self.live.is_paused() {
            return self.show_pause(ui, picture, language);
        }
        if let Some(view) = ui.input(|input| self.scope.set(input)) {
            self.live.look(view);
            self.config.view = self.scope.view();
            // The picture is drawn again, whether or not anything moves.
            self.canvas.redraw();
        }
        if let Some(hands) = &mut self.hands {
            hands.look(self.scope.view());
            let wishes = ui.input(|input| hands.wishes(input, field.eye(picture)));
            wishes.into_iter().for_each(|wish| self.live.wish(wish));
        }
        None
    }

    fn show_task(&self, ui: &mut Ui, language: Language) {
        let state = self
            .snapshot
            .as_ref()
            .and_then(Snapshot::latest::<LevelState>);
        let task = Task {
            module: &self.module,
            level: &self.level,
            state: state.unwrap_or_default(),
            time: self.snapshot.as_ref().map_or(0.0, |seen| seen.time),
            events: &self.live.events(),
        };
        let panel = egui::Panel::left("task").exact_size(PANEL).resizable(false);
        panel.show(ui, |ui| task.show(ui, language));
    }

    fn show_instruments(&self, ui: &mut Ui, quality: Quality, language: Language) {
        let states = self
            .snapshot
            .as_ref()
            .and_then(Snapshot::latest::<ToolStates>);
        let states = states.unwrap_or_default().tools;
        let hands = self.hands.as_ref();
        let instruments: Vec<Instrument<'_>> = self
            .level
            .tools
            .iter()
            .enumerate()
            .map(|(index, tool)| Instrument {
                tool,
                state: states.iter().find(|state| state.tool == tool.slot),
                is_active: hands.is_some_and(|hands| index == hands.active()),
                keeps_closed: hands.is_some_and(|hands| hands.keeps(index)),
            })
            .collect();
        let pace = self.live.pace();
        let delays = self.delays.lock();
        let delays = delays.unwrap_or_else(PoisonError::into_inner).clone();
        let panel = egui::Panel::right("instruments")
            .exact_size(PANEL)
            .resizable(false);
        panel.show(ui, |ui| {
            panels::instruments(ui, &instruments, language);
            panels::scope(ui, self.scope.magnification(), language);
            if hands.is_some() {
                panels::help(ui, language);
            }
            let pictures = Pictures {
                rate: self.rate(),
                delays: &delays,
                quality,
            };
            panels::pace(ui, &pace, &pictures, language);
        });
    }

    /// Draws the newest snapshot; gives the place of the picture.
    fn show_picture(
        &mut self,
        ui: &mut Ui,
        field: &mut Field,
        is_new: bool,
        language: Language,
    ) -> Rect {
        let subject = Subject {
            config: &self.config,
            models: &mut self.models,
            snapshot: self.snapshot.as_ref(),
            ghost: None,
            is_new,
        };
        let waiting = text::STARTING.of(language);
        let start = Instant::now();
        let (response, is_drawn) = self.canvas.show(ui, field, subject, waiting, language);
        if is_drawn {
            if let Some(snapshot) = self.snapshot.as_ref().filter(|_| is_new && self.has_begun) {
                field.time(snapshot.finished, &self.delays);
                field.time(start, self.account.add());
            }
            self.drawn.push_back(Instant::now());
            if self.drawn.len() > RATED {
                self.drawn.pop_front();
            }
        }
        response.rect
    }

    /// Pictures in a second.
    fn rate(&self) -> Option<f64> {
        let (first, last) = (self.drawn.front()?, self.drawn.back()?);
        let time = last.duration_since(*first).as_secs_f64();
        (time > 0.0).then(|| (self.drawn.len() - 1) as f64 / time)
    }

    /// The level as it lies there, and what it asks for; nothing moves before the trainee begins.
    fn show_introduction(
        &mut self,
        ui: &mut Ui,
        picture: Rect,
        language: Language,
    ) -> Option<Outcome> {
        self.snapshot.as_ref()?;
        let mut outcome = None;
        overlay(ui, "introduction", picture, |ui| {
            let title = text::local(&self.level.title, language);
            ui.label(RichText::new(title).size(18.0).strong());
            ui.label(text::local(&self.level.summary, language));
            ui.add_space(6.0);
            let begin = ui.add(look::main_button(text::START.of(language)));
            let enter = ui.input(|input| input.key_pressed(Key::Enter));
            if begin.clicked() || enter {
                self.has_begun = true;
                self.live.pause(false);
            }
            if ui.button(text::BACK.of(language)).clicked() {
                outcome = Some(Outcome::Back);
            }
        });
        outcome
    }

    fn show_pause(&mut self, ui: &mut Ui, picture: Rect, language: Language) -> Option<Outcome> {
        let mut outcome = None;
        overlay(ui, "pause", picture, |ui| {
            ui.label(RichText::new(text::PAUSED.of(language)).size(18.0).strong());
            ui.add_space(6.0);
            if ui
                .add(look::main_button(text::RESUME.of(language)))
                .clicked()
            {
                self.live.pause(false);
            }
            if ui.button(text::RESTART.of(language)).clicked() {
                outcome = Some(Outcome::Restart);
            }
            if ui.button(text::ABORT.of(language)).clicked() {
                self.live.abort();
                self.live.pause(false);
            }
        });
        outcome
    }
}

impl Drop for Training {
    fn drop(&mut self) {
        let ticks = self.snapshot.as_ref().map_or(0, |seen| seen.tick + 1);
        self.account.log(ticks, &self.live.pace(), &self.delays);
    }
}

/// A card in the upper part of the picture, which leaves tissue and instruments free.
fn overlay(ui: &Ui, name: &str, picture: Rect, show: impl FnOnce(&mut Ui)) {
    let place = egui::pos2(picture.center().x, picture.top() + 8.0);
    egui::Area::new(egui::Id::unique(name))
        .pivot(egui::Align2::CENTER_TOP)
        .fixed_pos(place)
        .show(ui.ctx(), |ui| {
            look::overlay().show(ui, |ui| {
                ui.set_width(340.0);
                ui.vertical_centered(show);
            });
        });
}
