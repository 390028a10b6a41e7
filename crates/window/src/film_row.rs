//! The row below a replay in which a film of it is ordered: its section, how far it is, and what came of it.

use crate::film::{Filming, Part};
use crate::films::{Filmed, Video};
use crate::look;
use crate::rows::{LINE, in_a_row};
use crate::text::{self, number};
use eframe::egui::{self, Label, ProgressBar, RichText, Ui, WidgetText, vec2};
use microsim_vocabulary::Language;
use std::ops::Range;

/// Width of the bar that shows how far it is \[points\].
const BAR: f32 = 220.0;

/// What the viewer asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// A film of the section.
    Begin([u64; 2]),
    /// Its end.
    Stop,
}

/// The row.
#[derive(Default)]
pub struct FilmRow {
    /// Whether it is shown.
    pub is_open: bool,
    /// First and last tick, where the viewer has chosen them.
    from: Option<u64>,
    to: Option<u64>,
    filming: Option<Filming>,
    /// What came of the last one.
    ended: Option<Result<Filmed, String>>,
}

impl FilmRow {
    /// A film goes on, or why it does not.
    pub fn begin(&mut self, started: Result<Filming, String>) {
        self.ended = None;
        match started {
            Ok(filming) => self.filming = Some(filming),
            Err(why) => self.ended = Some(Err(why)),
        }
    }

    /// Shows what came of a film.
    #[cfg(test)]
    pub fn set_ended(&mut self, ended: Option<Result<Filmed, String>>) {
        self.ended = ended;
    }

    /// The section that is chosen, of the ticks that there are.
    fn section(&self, range: &Range<u64>) -> [u64; 2] {
        let last = range.end.saturating_sub(1);
        let from = self.from.unwrap_or(range.start);
        [from, self.to.unwrap_or(last).max(from)]
    }

    /// Shows it; `now` is the tick that is shown, of these ticks of a length \[s\].
    pub fn show(
        &mut self,
        ui: &mut Ui,
        (now, range, tick_s): (Option<u64>, &Range<u64>, f64),
        language: Language,
    ) -> Option<Wanted> {
        if let Some(ended) = self.filming.as_mut().and_then(Filming::ended) {
            (self.filming, self.ended) = (None, Some(ended));
        }
        let mut wanted = None;
        let section = self.section(range);
        in_a_row(ui, LINE, |ui| {
            ui.strong(text::FILM.of(language));
            match &self.filming {
                Some(filming) => {
                    let part = filming.part();
                    let bar = ProgressBar::new(fraction(part)).fill(look::ACCENT);
                    ui.add(bar.desired_width(BAR).corner_radius(2.0));
                    if ui.button(text::STOP_FILM.of(language)).clicked() {
                        wanted = Some(Wanted::Stop);
                    }
                    ui.add(Label::new(look::quiet(progress(part, language))).truncate());
                }
                None => {
                    let time = |tick: u64| number((tick + 1) as f64 * tick_s, 2, language);
                    let [from, to] = section;
                    ui.label(format!("{} – {} s", time(from), time(to)));
                    ui.spacing_mut().button_padding = vec2(8.0, 4.0);
                    if ui.button(text::FROM_HERE.of(language)).clicked() {
                        self.from = now;
                        self.to = self.to.filter(|to| now.is_some_and(|now| now < *to));
                    }
                    if ui.button(text::TO_HERE.of(language)).clicked() {
                        self.to = now;
                        self.from = self.from.filter(|from| now.is_some_and(|now| *from < now));
                    }
                    if ui.button(text::ALL_OF_IT.of(language)).clicked() {
                        (self.from, self.to) = (None, None);
                    }
                    let begin = RichText::new(text::MAKE_FILM.of(language));
                    let begin = begin.strong().color(look::ON_ACCENT);
                    let begin = egui::Button::new(begin).fill(look::ACCENT);
                    if ui.add_enabled(!range.is_empty(), begin).clicked() {
                        wanted = Some(Wanted::Begin(section));
                    }
                }
            }
        });
        let note: WidgetText = match &self.ended {
            None => look::quiet(text::FILM_EXPLAINED.of(language)).into(),
            Some(ended) => note(ended, language).into(),
        };
        ui.add(Label::new(note).wrap());
        wanted
    }

    /// The film that is being made, which is no longer that of this row.
    pub fn leave(&mut self) -> Option<Filming> {
        self.filming.take()
    }

    /// Ends the film that is being made.
    pub fn stop(&self) {
        if let Some(filming) = &self.filming {
            filming.stop();
        }
    }

    /// Whether a film is being made.
    pub fn is_filming(&self) -> bool {
        self.filming.is_some()
    }
}

/// How far a film is, from 0 to 1: computing all ticks up to the section's end is one half, drawing the other one.
fn fraction(part: Part) -> f32 {
    let drawn = f64::from(part.written) / f64::from(part.of.max(1));
    (0.5 * (part.computed + drawn)) as f32
}

fn progress(part: Part, language: Language) -> String {
    match (part.of, part.written == part.of) {
        (0, _) => text::RECORDING_IS_READ.of(language).to_owned(),
        (_, true) => text::VIDEO_IS_MADE.of(language).to_owned(),
        (of, false) => {
            let pictures = text::PICTURES_WRITTEN.of(language);
            format!("{} / {of} {pictures}", part.written)
        }
    }
}

/// What came of a film.
pub fn note(ended: &Result<Filmed, String>, language: Language) -> RichText {
    match ended {
        Ok(filmed) => outcome(filmed, language),
        Err(why) => {
            let text = format!("{} {why}", text::FILM_ENDED.of(language));
            RichText::new(text).color(look::BAD)
        }
    }
}

/// What there is of a film.
fn outcome(filmed: &Filmed, language: Language) -> RichText {
    let (pictures, folder) = (filmed.pictures, filmed.folder.display());
    let written = text::PICTURES_WRITTEN.of(language);
    let pictures = format!("{pictures} {written}: {folder}");
    match &filmed.video {
        Video::Made(file) => {
            let text = format!("{} · {pictures}", file.display());
            RichText::new(text).color(look::GOOD)
        }
        Video::NoProgram => {
            let why = text::NO_FFMPEG.of(language);
            RichText::new(format!("{pictures}. {why}")).color(look::GOOD)
        }
        Video::Failed(why) => {
            let failed = text::FFMPEG_FAILED.of(language);
            RichText::new(format!("{failed} {why}. {pictures}")).color(look::BAD)
        }
        Video::Stopped => {
            let stopped = text::FILM_STOPPED.of(language);
            RichText::new(format!("{stopped} {pictures}"))
        }
    }
}
