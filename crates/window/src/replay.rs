//! Replay: a recorded session under a microscope of the viewer's own, with its time line below and what happened beside it. Nothing of it is recorded.

use crate::canvas::{Canvas, Subject};
use crate::console::{Asked, Console, by_key};
use crate::device::Waker;
use crate::field::Field;
use crate::film::{self, Filming};
use crate::film_row::{self, FilmRow};
use crate::ledger::Debrief;
use crate::live::Snapshot;
use crate::player::{Player, State};
use crate::plot::Curve;
use crate::references::Ghost;
use crate::scope::Scope;
use crate::shortcut;
use crate::station::{Recording, Station};
use crate::text::{self, Phrase};
use crate::timeline::{self, Mark};
use crate::views;
use eframe::egui::{self, Event, Key, Ui};
use microsim_message::SetupFile;
use microsim_render::Models;
use microsim_settings::RendererConfig;
use microsim_vocabulary::Language;
use std::thread::JoinHandle;

/// A notch of the wheel multiplies the magnification with this.
const WHEEL: f64 = 1.1;
/// Points of scrolling that are a notch.
const NOTCH: f64 = 50.0;

/// A session that is replayed.
pub struct Replay {
    /// What came of it.
    pub debrief: Box<Debrief>,
    marks: Vec<Mark>,
    /// Speeds and forces, in a language.
    curves: Option<(Language, [Vec<Curve>; 2])>,
    config: RendererConfig,
    models: Models,
    player: Player,
    scope: Scope,
    snapshot: Option<Snapshot>,
    canvas: Canvas,
    /// The files of models that objects have, for films.
    files: Vec<SetupFile>,
    ghost: Ghost,
    film: FilmRow,
    /// Of the window.
    waker: Waker,
}

/// What the viewer asked for that leads elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// To the debrief.
    Back,
    /// The other language.
    Language,
}

/// What stands where no picture is yet. After a failure nothing is waited for.
pub fn waiting(state: &State) -> Option<Phrase> {
    match (&state.failure, state.is_open && state.range.is_empty()) {
        (Some(_), _) => None,
        (None, true) => Some(text::NOTHING_RECORDED),
        (None, false) => Some(text::RECORDING_IS_READ),
    }
}

/// Has the next picture shown.
fn wake_of(waker: &Waker) -> impl Fn() + Send + 'static {
    let waker = waker.clone();
    move || waker.wake()
}

impl Replay {
    /// Opens a session at a tick.
    ///
    /// # Errors
    /// If a model cannot be read, or the system has no thread for it; the debrief comes back with the reason.
    pub fn begin(
        debrief: Box<Debrief>,
        recording: Box<dyn Recording>,
        tick: u64,
        waker: Waker,
    ) -> Result<Self, (Box<Debrief>, String)> {
        let config = recording.picture().clone();
        let files = recording.files().to_vec();
        let named: Vec<(&str, &[u8])> = files.iter().map(|f| (&f.name[..], &f.bytes[..])).collect();
        let wake = wake_of(&waker);
        let models = Models::new(&named);
        let begun = models.and_then(|models| Ok((models, Player::start(recording, tick, wake)?)));
        let (models, player) = match begun {
            Ok(begun) => begun,
            Err(why) => return Err((debrief, why)),
        };
        Ok(Self {
            marks: timeline::marks(&debrief.report),
            debrief,
            curves: None,
            scope: Scope::new(config.view, config.mirrored),
            config,
            models,
            player,
            snapshot: None,
            canvas: Canvas::default(),
            files,
            ghost: Ghost::default(),
            film: FilmRow::default(),
            waker,
        })
    }

    /// Lets go of the picture, and so of the device that has drawn it.
    pub fn let_go_of_picture(&mut self) {
        self.canvas.redraw();
    }

    /// Leaves it: what came of the session, the thread that computed it, which ends soon, and a film that is being made.
    pub fn leave(mut self) -> (Box<Debrief>, Option<JoinHandle<()>>, Option<Filming>) {
        let filming = self.film.leave();
        (self.debrief, self.player.leave(), filming)
    }

    /// Shows it, and does what is asked for.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        field: &mut Field,
        station: &dyn Station,
        panels: bool,
        language: Language,
    ) -> Option<Outcome> {
        let newest = self.player.take();
        let is_new = newest.is_some();
        self.snapshot = newest.or(self.snapshot.take());
        let before = self.config.views.clone();
        views::press(ui, &mut self.config.views);
        let mut asked = self.use_keys(ui, field);
        let report = &self.debrief.report;
        if self.curves.as_ref().is_none_or(|(of, _)| *of != language) {
            let both = [
                timeline::speeds(report, language),
                timeline::forces(report, language),
            ];
            self.curves = Some((language, both));
        }
        let state = self.player.state();
        let console = Console {
            report,
            marks: &self.marks,
            curves: self.curves.as_ref().map_or(&[], |(_, curves)| curves),
            state: &state,
            plays: self.player.plays(),
            speed: self.player.speed(),
            magnification: self.scope.magnification(),
            quality: field.quality(),
            ghost: self.ghost.is_on,
            films: self.film.is_open,
            panels,
        };
        asked.extend(console.show(ui, &mut self.config.views, language));
        if self.config.views != before {
            let shows = self.config.surface_view().is_some();
            self.player.show_fields(shows);
            self.canvas.redraw();
        }
        self.show_rows(ui, field, station, &state, language);
        let waiting = waiting(&state).map_or("", |waiting| waiting.of(language));
        let frame = egui::Frame::NONE;
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            let subject = Subject {
                config: &self.config,
                models: &mut self.models,
                snapshot: self.snapshot.as_ref(),
                ghost: self.ghost.track().map(|track| &**track),
                is_new,
            };
            let (response, _) = self.canvas.show(ui, field, subject, waiting, language);
            let eye = field.eye(response.rect);
            self.set_scope(ui, &response, eye);
        });
        let mut outcome = None;
        for asked in asked {
            match asked {
                Asked::Ghost => {
                    let wake = wake_of(&self.waker);
                    self.ghost.toggle(station, &self.debrief, wake);
                    self.canvas.redraw();
                }
                Asked::Film => self.film.is_open = !self.film.is_open,
                asked => outcome = self.follow(asked).or(outcome),
            }
        }
        outcome
    }

    /// The rows of the reference and of films, where they are wanted.
    fn show_rows(
        &mut self,
        ui: &mut Ui,
        field: &Field,
        station: &dyn Station,
        state: &State,
        language: Language,
    ) {
        if self.ghost.take() {
            self.canvas.redraw();
        }
        if self.ghost.is_on {
            let time = self.snapshot.as_ref().map_or(0.0, |seen| seen.time);
            let is_other = egui::Panel::top("reference")
                .show_separator_line(false)
                .show(ui, |ui| {
                    let (of, wake) = ((station, &*self.debrief), wake_of(&self.waker));
                    self.ghost.show(ui, of, time, wake, language)
                })
                .inner;
            if is_other {
                self.canvas.redraw();
            }
        }
        if self.film.is_open || self.film.is_filming() {
            let tick_s = self.debrief.report.session.tick_s;
            let wanted = egui::Panel::bottom("film")
                .show_separator_line(false)
                .show(ui, |ui| {
                    let of = (state.shown, &state.range, tick_s);
                    self.film.show(ui, of, language)
                })
                .inner;
            match wanted {
                None => {}
                Some(film_row::Wanted::Stop) => self.film.stop(),
                Some(film_row::Wanted::Begin(section)) => {
                    let seen = (field, language);
                    let started = self.begin_film(section, seen, station, wake_of(&self.waker));
                    self.film.begin(started);
                }
            }
        }
    }

    /// A film of a section, as it is seen now, but without the instruments of another session: a film goes with its own, also when that is erased.
    fn begin_film(
        &self,
        section: [u64; 2],
        (field, language): (&Field, Language),
        station: &dyn Station,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Filming, String> {
        let session = &self.debrief.session;
        let ghost = self.ghost.of_script().cloned();
        let (config, files) = (self.config.clone(), self.files.clone());
        let scene = film::Scene {
            recording: station.replay(session)?,
            section,
            shows_fields: config.surface_view().is_some(),
            camera: field
                .sight()
                .camera(config, files, ghost, (film::SIZE, language)),
            film: station.film(session)?,
        };
        Filming::start(scene, wake)
    }

    /// What keys ask for, one after the other, unless something is being chosen by keyboard.
    fn use_keys(&mut self, ui: &Ui, field: &mut Field) -> Vec<Asked> {
        if !shortcut::is_free(ui) {
            return Vec::new();
        }
        let pressed = |event: &Event| match event {
            Event::Key {
                key, pressed: true, ..
            } => Some(*key),
            _ => None,
        };
        let keys: Vec<Key> = ui.input(|input| input.events.iter().filter_map(pressed).collect());
        let mut asked = Vec::new();
        let before = self.scope.view();
        for key in keys {
            match by_key(key) {
                Some(wanted) => asked.push(wanted),
                None if key == Key::F2 => {
                    field.change_quality();
                    self.canvas.redraw();
                }
                None => self.scope.press(key),
            }
        }
        self.look_again(before != self.scope.view());
        asked
    }

    /// The wheel magnifies, dragging moves the view along with the pointer.
    fn set_scope(&mut self, ui: &Ui, response: &egui::Response, eye: egui::Rect) {
        let before = self.scope.view();
        let scrolled = f64::from(ui.input(|input| input.smooth_scroll_delta().y));
        if response.hovered() && scrolled != 0.0 {
            self.scope.magnify(libm::pow(WHEEL, scrolled / NOTCH));
        }
        let dragged = response.drag_delta();
        if response.dragged() && dragged != egui::Vec2::ZERO {
            // The field touches the nearer pair of edges.
            let size = f64::from(eye.size().min_elem().max(1.0));
            let [right, up] = [-f64::from(dragged.x) / size, f64::from(dragged.y) / size];
            self.scope.shift([right, up]);
        }
        self.look_again(before != self.scope.view());
    }

    fn look_again(&mut self, is_changed: bool) {
        if is_changed {
            self.config.view = self.scope.view();
            self.canvas.redraw();
        }
    }

    /// Does what is asked for.
    fn follow(&mut self, asked: Asked) -> Option<Outcome> {
        // Where it goes, though it may not be there yet.
        let goal = self.player.goal().unwrap_or_default();
        match asked {
            Asked::Back => return Some(Outcome::Back),
            Asked::Language => return Some(Outcome::Language),
            Asked::PlayOrPause => self.player.play(!self.player.plays()),
            Asked::Speed(speed) => self.player.set_speed(speed),
            Asked::GoTo(tick) => self.player.go_to(tick),
            Asked::Begin => self.player.go_to(0),
            Asked::End => self.player.go_to(u64::MAX),
            Asked::Step(by) => self.player.step(by),
            Asked::EventBefore => {
                if let Some(tick) = timeline::previous(&self.marks, goal) {
                    self.player.go_to(tick);
                }
            }
            Asked::Ghost | Asked::Film => {}
            Asked::EventAfter => {
                if let Some(tick) = timeline::next(&self.marks, goal) {
                    self.player.go_to(tick);
                }
            }
        }
        None
    }
}
