//! Results: the list, two of them side by side, and the table that is written of them.

use crate::debrief::{decimals, verdict};
use crate::ledger::{Attempt, ComparedRow, Comparison, Debrief, Ledger, Selection};
use crate::look;
use crate::rows::{LINE, cell, row};
use crate::text::{self, local, number};
use eframe::egui::{self, Align, Button, Label, RichText, ScrollArea, TextEdit, Ui};
use microsim_vocabulary::Language;
use std::path::Path;

/// Widths of the cells of an attempt but for the last: mark, time, verdict, score, duration \[points\].
const CELLS: [f32; 5] = [20.0, 125.0, 150.0, 55.0, 60.0];
/// Width of a number in a comparison \[points\].
const NUMBER: f32 = 82.0;

/// Whose results are listed and written.
pub struct Of {
    /// Those that are listed.
    pub selection: Selection,
    /// The group of an export of a group.
    pub group: Option<String>,
}

/// What the operator asked for.
#[derive(Debug)]
pub enum Asked {
    /// To show a sentence, and whether it is a complaint.
    Message(String, bool),
    /// What came of a session.
    Debrief(Box<Debrief>),
    /// The session as it was recorded.
    Replay(Box<Debrief>),
}

/// The results that are listed.
#[derive(Debug, Default)]
pub struct Attempts {
    list: Vec<Attempt>,
    /// Ids of at most two.
    marked: Vec<String>,
    comparison: Option<Comparison>,
    /// Where the table goes, once it was changed.
    file: Option<String>,
    without_names: bool,
}

impl Attempts {
    /// Lists other results. Of one trainee the last two attempts of one level are marked: what most people compare.
    pub fn take(&mut self, list: Vec<Attempt>, is_of_one: bool) {
        (self.list, self.comparison) = (list, None);
        self.marked.clear();
        if let (true, Some(last)) = (is_of_one, self.list.first()) {
            let level = (&last.module, last.level);
            let same = self.list.iter().filter(|a| (&a.module, a.level) == level);
            self.marked = same.take(2).map(|attempt| attempt.id.clone()).collect();
            self.marked.reverse();
        }
    }

    /// Modules and levels of the results, each once, the last attempted first.
    pub fn levels(&self) -> impl Iterator<Item = (String, u32)> {
        let mut levels: Vec<(String, u32)> = Vec::new();
        for attempt in &self.list {
            let level = (attempt.module.clone(), attempt.level);
            if !levels.contains(&level) {
                levels.push(level);
            }
        }
        levels.into_iter()
    }

    /// Shows them.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        of: &Of,
        ledger: &dyn Ledger,
        language: Language,
    ) -> Option<Asked> {
        let mut asked = None;
        egui::Panel::bottom("export")
            .show_separator_line(false)
            .show(ui, |ui| {
                asked = self.show_export(ui, of, ledger, language);
            });
        ui.horizontal(|ui| {
            if self.comparison.is_some() {
                if ui.button(text::TO_THE_LIST.of(language)).clicked() {
                    self.comparison = None;
                }
                return;
            }
            let compare = Button::new(text::COMPARE.of(language));
            let two = <&[String; 2]>::try_from(&self.marked[..]).ok();
            if ui.add_enabled(two.is_some(), compare).clicked()
                && let Some([a, b]) = two
            {
                match ledger.compare([a, b]) {
                    Ok(comparison) => self.comparison = Some(comparison),
                    Err(why) => asked = Some(Asked::Message(why, true)),
                }
            }
            let last = self.marked.last();
            let show = Button::new(text::SHOW_DEBRIEF.of(language));
            let shows = ui.add_enabled(last.is_some(), show).clicked();
            let replay = Button::new(text::REPLAY.of(language));
            let replays = ui.add_enabled(last.is_some(), replay).clicked();
            if let Some(id) = last.filter(|_| shows || replays) {
                asked = Some(match ledger.debrief(id).map(Box::new) {
                    Ok(debrief) if replays => Asked::Replay(debrief),
                    Ok(debrief) => Asked::Debrief(debrief),
                    Err(why) => Asked::Message(why, true),
                });
            }
            let hint = match self.list.is_empty() {
                true => text::NO_RESULTS,
                false => text::MARK_TWO,
            };
            let hint = look::quiet(hint.of(language));
            ui.add(Label::new(hint).truncate());
        });
        match &self.comparison {
            Some(comparison) => show_comparison(ui, comparison, language),
            None => self.show_list(ui, language),
        }
        asked
    }

    fn show_list(&mut self, ui: &mut Ui, language: Language) {
        let is_of_many = self.list.iter().any(|a| a.who != self.list[0].who);
        let mut pressed = None;
        ScrollArea::vertical()
            .id_salt("attempts")
            .auto_shrink(false)
            .show_rows(ui, LINE, self.list.len(), |ui, range| {
                for attempt in &self.list[range] {
                    let mark = self.marked.iter().position(|id| *id == attempt.id);
                    if row(ui, LINE, mark.is_some(), &attempt.id, |ui| {
                        show_attempt(ui, mark, attempt, is_of_many, language);
                    }) {
                        pressed = Some((mark, attempt.id.clone()));
                    }
                }
            });
        match pressed {
            None => {}
            Some((Some(mark), _)) => {
                self.marked.remove(mark);
            }
            // Of more than two the one that was marked first goes.
            Some((None, id)) => {
                self.marked.push(id);
                let excess = self.marked.len().saturating_sub(2);
                self.marked.drain(..excess);
            }
        }
    }

    fn show_export(
        &mut self,
        ui: &mut Ui,
        of: &Of,
        ledger: &dyn Ledger,
        language: Language,
    ) -> Option<Asked> {
        let mut wanted = None;
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            if ui.button(text::EXPORT_THESE.of(language)).clicked() {
                wanted = Some(of.selection.clone());
            }
            if let Some(group) = &of.group
                && ui.button(text::EXPORT_GROUP.of(language)).clicked()
            {
                wanted = Some(Selection {
                    trainee: None,
                    group: Some(group.clone()),
                });
            }
            let mut names = !self.without_names;
            ui.checkbox(&mut names, text::WITH_NAMES.of(language));
            self.without_names = !names;
        });
        let mut file = match &self.file {
            Some(file) => file.clone(),
            None => ledger.table().display().to_string(),
        };
        ui.horizontal(|ui| {
            ui.label(look::quiet(text::FILE.of(language)));
            let line = TextEdit::singleline(&mut file).desired_width(ui.available_width());
            if ui.add(line).changed() {
                self.file = Some(file.clone());
            }
        });
        ui.add_space(4.0);
        let selection = wanted?;
        let written = ledger.export(&selection, Path::new(&file), !self.without_names);
        Some(match written {
            Ok(sessions) => {
                let are_in = text::SESSIONS_ARE_IN.of(language);
                Asked::Message(format!("{sessions} {are_in} {file}"), false)
            }
            Err(why) => Asked::Message(why, true),
        })
    }
}

/// `mark`: place among those that are compared.
fn show_attempt(
    ui: &mut Ui,
    mark: Option<usize>,
    attempt: &Attempt,
    with_name: bool,
    language: Language,
) {
    let letter = mark.map_or("", |mark| ["A", "B"][mark.min(1)]);
    let (word, colour) = verdict(attempt.verdict);
    let score = attempt.score.map(|score| number(score, 0, language));
    let [of_mark, of_time, of_verdict, of_score, of_duration] = CELLS;
    let letter = RichText::new(letter).strong().color(look::ACCENT);
    cell(ui, of_mark, Align::Min, letter);
    cell(ui, of_time, Align::Min, &attempt.started);
    let word = RichText::new(word.of(language)).color(colour);
    cell(ui, of_verdict, Align::Min, word);
    cell(
        ui,
        of_score,
        Align::Max,
        score.unwrap_or_else(|| "–".into()),
    );
    let duration = format!("{} s", number(attempt.duration, 1, language));
    cell(ui, of_duration, Align::Max, duration);
    let title = local(&attempt.title, language);
    let mut title = format!("{title}, {} {}", text::LEVEL.of(language), attempt.level);
    if with_name {
        title = format!("{} · {title}", attempt.who);
    }
    let rest = ui.available_width();
    cell(ui, rest, Align::Min, title);
}

fn show_comparison(ui: &mut Ui, comparison: &Comparison, language: Language) {
    for (attempt, letter) in comparison.attempts.iter().zip(["A", "B"]) {
        let (word, colour) = verdict(attempt.verdict);
        ui.horizontal(|ui| {
            ui.label(RichText::new(letter).strong().color(look::ACCENT));
            ui.label(&attempt.started);
            ui.label(RichText::new(word.of(language)).color(colour));
            let title = local(&attempt.title, language);
            let level = text::LEVEL.of(language);
            let whose = format!("{}, {title}, {level} {}", attempt.who, attempt.level);
            ui.add(Label::new(whose).truncate());
        });
    }
    if !comparison.same_level {
        let warning = RichText::new(text::NOT_SAME_LEVEL.of(language)).color(look::BAD);
        ui.label(warning);
    }
    let title = (ui.available_width() - 3.0 * (NUMBER + 8.0) - 160.0).max(120.0);
    let change = 70.0;
    ui.horizontal(|ui| {
        cell(ui, title, Align::Min, "");
        for head in ["A", "B", "B − A"] {
            cell(ui, NUMBER, Align::Max, RichText::new(head).strong());
        }
    });
    ScrollArea::vertical()
        .id_salt("comparison")
        .auto_shrink(false)
        .show(ui, |ui| {
            for row in &comparison.rows {
                ui.horizontal(|ui| {
                    cell(ui, title, Align::Min, local(&row.title, language));
                    show_values(ui, row, language);
                    let (word, colour) = match row.is_better {
                        Some(true) => (text::BETTER.of(language), look::GOOD),
                        Some(false) => (text::WORSE.of(language), look::BAD),
                        None => ("", look::QUIET),
                    };
                    cell(ui, 44.0, Align::Min, look::quiet(&row.unit));
                    cell(ui, change, Align::Min, RichText::new(word).color(colour));
                });
            }
            ui.label(look::quiet(text::OUTSIDE.of(language)));
        });
}

fn show_values(ui: &mut Ui, row: &ComparedRow, language: Language) {
    let shown = |value: f64| number(value, decimals(value), language).replace('-', "−");
    for (value, outside) in row.values.iter().zip(row.outside) {
        let text = value.map_or_else(|| "–".into(), shown);
        let text = match outside {
            true => RichText::new(format!("{text} !")).color(look::BAD),
            false => RichText::new(text),
        };
        cell(ui, NUMBER, Align::Max, text);
    }
    let difference = row.values[0].zip(row.values[1]).map(|(a, b)| b - a);
    let difference = difference.map_or_else(|| "–".into(), shown);
    cell(ui, NUMBER, Align::Max, difference);
}
