//! The desk on a graphics device: the screen that is drawn, and another device in place of one that was lost.

use super::{Desk, Screen, field_of};
use crate::device;
use crate::field::Field;
use crate::look;
use crate::shortcut;
use crate::training::Outcome;
use eframe::egui::Ui;
use std::time::Duration;

/// Until the next picture of those after which memory is given back.
const NEXT_PICTURE: Duration = Duration::from_millis(50);

impl device::Shown for Desk {
    fn release(&mut self) {
        self.field = None;
        self.launcher.let_go_of_pictures();
        match &mut self.screen {
            Screen::Training(training) => training.let_go_of_picture(),
            Screen::Replay(replay, _) => replay.let_go_of_picture(),
            _ => {}
        }
    }

    fn take(&mut self, context: &eframe::CreationContext<'_>, why: &str) -> Result<(), String> {
        self.field = Some(field_of(context, &self.settings)?);
        look::apply(&context.egui_ctx);
        self.waker.turn_to(&context.egui_ctx);
        if let Screen::Training(training) = &mut self.screen {
            training.take_new_device(why);
        }
        Ok(())
    }

    fn pause(&mut self) {
        if let Screen::Training(training) = &self.screen {
            training.pause();
        }
    }

    fn lost(&self) -> Option<String> {
        self.field.as_ref().and_then(Field::lost)
    }

    fn show(&mut self, ui: &mut Ui) {
        // A file that is dropped where it can be read, or one click before.
        let takes_files = matches!(self.screen, Screen::Launcher | Screen::Records(_));
        if takes_files && !ui.input(|input| input.raw.dropped_files.is_empty()) {
            self.open_upkeep();
        }
        self.press_by_controllers(ui);
        self.set_by_keys(ui);
        let panels = self.settings.panels;
        let ran = self.runs();
        match &self.screen {
            Screen::Debrief(..) => self.left_films.show(ui, self.language),
            // What came of a film is stated where its replay has led to.
            _ => {
                self.left_films.look();
                self.left_films.forget();
            }
        }
        match &mut self.screen {
            Screen::Settings(_) => self.show_settings(ui),
            Screen::Editor(_) => self.show_editor(ui),
            Screen::Launcher => self.show_launcher(ui),
            Screen::Debrief(..) => self.show_debrief(ui),
            Screen::Replay(..) => self.show_replay(ui),
            Screen::Records(_) => self.show_records(ui),
            Screen::Upkeep => self.show_upkeep(ui),
            Screen::Complaint(_) => self.show_complaint(ui),
            Screen::Training(training) => {
                let Some(field) = &mut self.field else {
                    return;
                };
                match training.show(ui, field, panels, self.language) {
                    None => {}
                    Some(Outcome::Back) => self.screen = Screen::Launcher,
                    Some(Outcome::Restart) => {
                        let choice = training.choice.clone();
                        self.begin(choice);
                    }
                    Some(Outcome::Ended(Ok(debrief))) => {
                        let choice = training.choice.clone();
                        self.screen = Screen::Debrief(debrief, choice);
                        ui.ctx().request_repaint();
                    }
                    Some(Outcome::Ended(Err(why))) => self.screen = Screen::Complaint(why),
                }
            }
        }
        if ran && !self.runs() {
            if let Some(field) = &mut self.field {
                field.release();
            }
            self.giving_back.begin();
        }
        if !self.runs() && self.giving_back.count(self.computes_still()) {
            ui.ctx().request_repaint_after(NEXT_PICTURE);
        }
        shortcut::note_use(ui.ctx());
    }
}

impl Desk {
    /// Whether a replay that was left is computed, or filmed, still.
    fn computes_still(&self) -> bool {
        self.left.as_ref().is_some_and(|left| !left.is_finished()) || self.left_films.is_ending()
    }

    /// Whether a level or a replay is shown.
    fn runs(&self) -> bool {
        matches!(self.screen, Screen::Training(_) | Screen::Replay(..))
    }
}
