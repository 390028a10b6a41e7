//! Training: the picture in the middle, the task to its left, the instruments to its right.

use crate::account::Account;
use crate::canvas::{Canvas, Subject};
use crate::device::Waker;
use crate::field::Field;
use crate::hands::Hands;
use crate::live::{Ended, Live, Snapshot};
use crate::pace::Times;
use crate::panels::{Instrument, Pictures, Task};
use crate::scope::Scope;
use crate::station::{Choice, LevelEntry, LiveSession, ModuleEntry};
use crate::steering::{self, Grasp, Steering};
use crate::text;
use crate::{look, panels, pedal, shortcut, views};
use eframe::egui::{self, Key, Rect, RichText, Ui};
use microsim_audio::{Cues, Player};
use microsim_controller::Controllers;
use microsim_message::{LevelState, ToolStates};
use microsim_render::{Models, Quality};
use microsim_settings::{Pedal, RendererConfig};
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
    /// Why the picture was gone, until the trainee goes on.
    lost: Option<String>,
    /// Gamepads and SpaceMice, and how fast they move a tip at full deflection \[diameters of the field per second\].
    pub controllers: Option<(Controllers, f64)>,
    /// Keys of a foot switch.
    pub pedal: Pedal,
    /// Largest sustained force that the level takes \[N\].
    force_limit: Option<f64>,
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
        waker: Waker,
    ) -> Result<Self, String> {
        let config = session.picture().clone();
        let force_limit = session.force_limit();
        let files = session.files().iter();
        let files: Vec<(&str, &[u8])> = files.map(|f| (&f.name[..], &f.bytes[..])).collect();
        let models = Models::new(&files)?;
        let slots = level.tools.iter().map(|tool| tool.slot.clone());
        let hands = session.desktop();
        let hands = hands.map(|desktop| Hands::new(slots.collect(), *desktop, config.view));
        let wake = move || waker.wake();
        Ok(Self {
            choice,
            module: module.clone(),
            level: level.clone(),
            scope: Scope::new(config.view, config.mirrored),
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
            lost: None,
            controllers: None,
            pedal: Pedal::default(),
            force_limit,
        })
    }

    /// Pauses the run.
    pub fn pause(&self) {
        self.live.pause(true);
    }

    /// Lets go of the picture, and so of the device that has drawn it.
    pub fn let_go_of_picture(&mut self) {
        self.canvas.redraw();
    }

    /// Draws with another device: the one of before was lost for this reason. Whoever saw nothing for a while decides when the run goes on.
    pub fn take_new_device(&mut self, why: &str) {
        self.lost = Some(why.to_owned());
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
        let before = self.config.views.clone();
        views::press(ui, &mut self.config.views);
        if panels {
            self.show_task(ui, language);
        }
        if ui.input(|input| input.key_pressed(Key::F2)) {
            field.change_quality();
        }
        if panels {
            self.show_instruments(ui, field.quality(), language);
        }
        if self.config.views != before {
            let shows = self.config.surface_view().is_some();
            self.live.show_fields(shows);
            self.canvas.redraw();
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
        self.lost = None;
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
            let grasp = hands.grasp();
            let is_used = ui.input(|input| input.focused);
            let steering = self.controllers.as_ref().zip(grasp);
            let steering = steering.filter(|_| is_used);
            self.live
                .steer(steering.map(|((controllers, speed), grasp)| Steering {
                    controllers: controllers.clone(),
                    grasp: Grasp {
                        speed: speed * self.scope.view().field,
                        ..grasp
                    },
                }));
        }
        None
    }

    /// Plays tones of what happens.
    pub fn play_tones(&self, player: Player) {
        self.live.play_tones(Cues::new(self.force_limit), player);
    }

    /// What buttons of devices stand for.
    pub fn stage(&self) -> steering::Stage {
        match self.has_begun {
            true => steering::Stage::Run,
            false => steering::Stage::Before,
        }
    }

    fn show_task(&self, ui: &mut Ui, language: Language) {
        let state = self
            .snapshot
            .as_ref()
            .and_then(Snapshot::latest::<LevelState>);
        let task = Task {
            module: &self.module,
            level: &self.level,
            mirrored: self.config.mirrored,
            state: state.unwrap_or_default(),
            time: self.snapshot.as_ref().map_or(0.0, |seen| seen.time),
            events: &self.live.events(),
        };
        let panel = egui::Panel::left("task").exact_size(PANEL).resizable(false);
        panel.show(ui, |ui| task.show(ui, language));
    }

    fn show_instruments(&mut self, ui: &mut Ui, quality: Quality, language: Language) {
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
        let controllers = self.controllers.as_ref().filter(|_| hands.is_some());
        let presences = controllers.map(|(controllers, _)| controllers.presences());
        let presences = presences.unwrap_or_default();
        let (pace, rate) = (self.live.pace(), self.rate());
        let delays = self.delays.lock();
        let delays = delays.unwrap_or_else(PoisonError::into_inner).clone();
        let panel = egui::Panel::right("instruments")
            .exact_size(PANEL)
            .resizable(false);
        let show = |ui: &mut Ui| {
            panels::instruments(ui, &instruments, language);
            steering::presences(ui, &presences, language);
            panels::scope(ui, self.scope.magnification(), language);
            if hands.is_some() {
                panels::help(ui, &steering::help(&presences), language);
                pedal::help(ui, &self.pedal, language);
            }
            let pictures = Pictures {
                rate,
                delays: &delays,
                quality,
            };
            panels::pace(ui, &pace, &pictures, language);
            views::show(ui, &mut self.config.views, language);
        };
        panel.show(ui, |ui| panels::scrolled(ui, show));
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
            if shortcut::main_button(ui, text::START.of(language), Key::Enter) {
                self.has_begun = true;
                self.live.pause(false);
            }
            if shortcut::button(ui, text::BACK.of(language), shortcut::BACK) {
                outcome = Some(Outcome::Back);
            }
        });
        outcome
    }

    fn show_pause(&mut self, ui: &mut Ui, picture: Rect, language: Language) -> Option<Outcome> {
        let mut outcome = None;
        overlay(ui, "pause", picture, |ui| {
            ui.label(RichText::new(text::PAUSED.of(language)).size(18.0).strong());
            if let Some(why) = &self.lost {
                ui.label(RichText::new(text::DRIVER_LOST.of(language)).color(look::BAD));
                ui.label(look::quiet(why));
            }
            ui.add_space(6.0);
            // Its key is that of the pause, which is looked at before.
            let resume = shortcut::labelled(text::RESUME.of(language), Key::Escape);
            if ui.add(look::main_button(&resume)).clicked() {
                self.live.pause(false);
            }
            if shortcut::button(ui, text::RESTART.of(language), shortcut::RESTART) {
                outcome = Some(Outcome::Restart);
            }
            if shortcut::button(ui, text::ABORT.of(language), shortcut::ABORT) {
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
