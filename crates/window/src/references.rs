//! Runs beside which a replay is shown: which there are, and one of them, read in a thread of its own.

use crate::ghost::Track;
use crate::ledger::Debrief;
use crate::look;
use crate::rows::{LINE, in_a_row};
use crate::text;
use crate::text::local;
use eframe::egui::{Align, ComboBox, Label, Layout, RichText, Sense, Ui, vec2};
use microsim_message::LocalText;
use microsim_vocabulary::Language;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// Width of the choice of a reference \[points\].
const CHOICE: f32 = 330.0;

/// Where the motion of a reference comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Motion {
    /// A script.
    Script(PathBuf),
    /// A recorded session.
    Session(PathBuf),
}

/// A run that can be shown as a ghost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reference {
    /// What it is.
    pub title: LocalText,
    /// Where it comes from.
    pub motion: Motion,
}

/// Reads a reference, unless it is left meanwhile.
pub type ReadTrack = Box<dyn FnOnce(&AtomicBool) -> Result<Track, String> + Send>;

/// A station that has references.
pub trait References {
    /// The references for a session: the best first, and why there may be more.
    fn references(&self, debrief: &Debrief) -> (Vec<Reference>, Option<String>);

    /// What reads one of them for the same session.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn track(&self, debrief: &Debrief, reference: &Reference) -> Result<ReadTrack, String>;
}

/// A reference that is being read.
struct Reading {
    is_left: Arc<AtomicBool>,
    thread: JoinHandle<Result<Track, String>>,
}

/// The ghost of a replay.
#[derive(Default)]
pub struct Ghost {
    /// Whether it is shown.
    pub is_on: bool,
    /// Once it was asked for.
    known: Option<Vec<Reference>>,
    /// Why there may be more.
    lacks: Option<String>,
    chosen: usize,
    reading: Option<Reading>,
    /// Of the chosen one.
    read: Option<Result<Arc<Track>, String>>,
}

impl Ghost {
    /// Shows it, or hides it. The first time the best reference is read.
    pub fn toggle(
        &mut self,
        station: &(impl References + ?Sized),
        debrief: &Debrief,
        wake: impl Fn() + Send + 'static,
    ) {
        self.is_on = !self.is_on;
        if self.is_on && self.known.is_none() {
            let (known, lacks) = station.references(debrief);
            let is_some = !known.is_empty();
            (self.known, self.lacks) = (Some(known), lacks);
            if is_some {
                self.choose(0, station, debrief, wake);
            }
        }
    }

    /// Reads another one.
    fn choose(
        &mut self,
        place: usize,
        station: &(impl References + ?Sized),
        debrief: &Debrief,
        wake: impl Fn() + Send + 'static,
    ) {
        self.leave();
        (self.chosen, self.read) = (place, None);
        let Some(reference) = self.known.iter().flatten().nth(place) else {
            return;
        };
        let started = station.track(debrief, reference).and_then(|read| {
            let is_left = Arc::new(AtomicBool::new(false));
            let seat = Arc::clone(&is_left);
            let read = move || {
                let track = read(&seat);
                wake();
                track
            };
            let thread = std::thread::Builder::new().name("reference".into());
            let thread = thread.spawn(read);
            let thread = thread.map_err(|e| format!("no thread for the reference: {e}"))?;
            Ok(Reading { is_left, thread })
        });
        match started {
            Ok(reading) => self.reading = Some(reading),
            Err(why) => self.read = Some(Err(why)),
        }
    }

    /// What is read of it is wanted no longer.
    fn leave(&mut self) {
        if let Some(reading) = self.reading.take() {
            reading.is_left.store(true, Ordering::Relaxed);
        }
    }

    /// Takes what was read since the last picture; whether there is something new to draw.
    pub fn take(&mut self) -> bool {
        if !self
            .reading
            .as_ref()
            .is_some_and(|r| r.thread.is_finished())
        {
            return false;
        }
        let Some(reading) = self.reading.take() else {
            return false;
        };
        let read = reading.thread.join();
        let read = read.unwrap_or_else(|_| {
            Err("reading the reference broke off: a bug of MicroSim".to_owned())
        });
        self.read = Some(read.map(Arc::new));
        true
    }

    /// The tools of the reference, if they are shown.
    pub fn track(&self) -> Option<&Arc<Track>> {
        let read = self.read.as_ref().filter(|_| self.is_on);
        read.and_then(|read| read.as_ref().ok())
    }

    /// The same of a script alone.
    pub fn of_script(&self) -> Option<&Arc<Track>> {
        let chosen = self.known.iter().flatten().nth(self.chosen);
        let is_script = chosen.is_some_and(|of| matches!(of.motion, Motion::Script(_)));
        self.track().filter(|_| is_script)
    }

    /// What the ghost is, and the choice of another one; whether another one was chosen. `time` is that of the replay \[s\].
    pub fn show(
        &mut self,
        ui: &mut Ui,
        (station, debrief): (&(impl References + ?Sized), &Debrief),
        time: f64,
        wake: impl Fn() + Send + 'static,
        language: Language,
    ) -> bool {
        let mut wanted = None;
        in_a_row(ui, LINE, |ui| {
            let (place, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
            ui.painter().rect_filled(place, 3.0, look::GHOST);
            ui.label(text::REFERENCE_IS.of(language));
            let known = self.known.as_deref().unwrap_or_default();
            if let Some(chosen) = known.get(self.chosen) {
                ui.scope(|ui| {
                    ui.set_max_width(CHOICE);
                    ComboBox::from_id_salt("reference")
                        .selected_text(local(&chosen.title, language))
                        .width(CHOICE)
                        .truncate()
                        .show_ui(ui, |ui| {
                            for (place, reference) in known.iter().enumerate() {
                                let title = local(&reference.title, language);
                                if ui.selectable_label(place == self.chosen, title).clicked() {
                                    wanted = Some(place);
                                }
                            }
                        });
                });
            }
            let bad = |text: String| RichText::new(text).color(look::BAD);
            let note = match &self.read {
                Some(Err(why)) => bad(format!("{}: {why}", text::NO_REFERENCE.of(language))),
                _ if known.is_empty() => bad(text::NO_REFERENCES.of(language).to_owned()),
                None => look::quiet(text::REFERENCE_IS_READ.of(language)),
                Some(Ok(track)) if time > track.end() => {
                    let end = text::number(track.end(), 2, language);
                    look::quiet(format!("{} {end} s", text::REFERENCE_ENDED.of(language)))
                }
                Some(Ok(_)) => look::quiet(text::SAME_TIME.of(language)),
            };
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(Label::new(note).truncate());
            });
        });
        if let Some(why) = &self.lacks {
            ui.add(Label::new(RichText::new(why).color(look::BAD)).truncate());
        }
        let Some(place) = wanted.filter(|place| *place != self.chosen) else {
            return false;
        };
        self.choose(place, station, debrief, wake);
        true
    }
}

impl Drop for Ghost {
    fn drop(&mut self) {
        self.leave();
    }
}
