//! Films of replays that were left: they end with the picture that is drawn then, and what came of them is stated.

use crate::film::Filming;
use crate::film_row;
use crate::films::Filmed;
use crate::look;
use crate::text;
use eframe::egui::{self, Label, Ui};
use microsim_vocabulary::Language;

/// Films that end, and what came of the last one. Whoever drops it waits for them.
#[derive(Default)]
pub struct LeftFilms {
    ending: Vec<Filming>,
    outcome: Option<Result<Filmed, String>>,
}

impl LeftFilms {
    /// Takes the film of a replay that is left, and has it end; nothing is waited for.
    pub fn leave(&mut self, filming: Option<Filming>) {
        if let Some(filming) = filming {
            filming.stop();
            self.ending.push(filming);
            self.outcome = None;
        }
    }

    /// Takes up what came of those that have ended.
    pub fn look(&mut self) {
        let outcome = &mut self.outcome;
        self.ending.retain_mut(|filming| match filming.ended() {
            Some(ended) => {
                let note = film_row::note(&ended, Language::English);
                tracing::info!("the video of a replay that was left: {}", note.text());
                *outcome = Some(ended);
                false
            }
            None => true,
        });
    }

    /// Whether one is still at its last picture.
    pub fn is_ending(&self) -> bool {
        !self.ending.is_empty()
    }

    /// What came of the last one that was left.
    pub fn outcome(&self) -> Option<&Result<Filmed, String>> {
        self.outcome.as_ref()
    }

    /// What came of it was seen.
    pub fn forget(&mut self) {
        self.outcome = None;
    }

    /// Until none is made any more.
    pub fn wait(&mut self) {
        self.ending.clear();
    }

    /// Shows below a screen that one ends, or what came of it.
    pub fn show(&mut self, ui: &mut Ui, language: Language) {
        self.look();
        let note = match (self.is_ending(), self.outcome()) {
            (true, _) => look::quiet(text::FILM_ENDS.of(language)),
            (false, Some(ended)) => film_row::note(ended, language),
            (false, None) => return,
        };
        egui::Panel::bottom("left film")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(4.0);
                ui.horizontal_wrapped(|ui| {
                    ui.strong(text::FILM.of(language));
                    ui.add(Label::new(note).wrap());
                });
                ui.add_space(4.0);
            });
    }
}
