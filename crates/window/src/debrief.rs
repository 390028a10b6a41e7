//! After a run: the verdict, what it rests on, and how it went.

use crate::ledger::Debrief;
use crate::look;
use crate::plot;
use crate::shortcut;
use crate::text::{self, Phrase, local, number};
use crate::timeline;
use eframe::egui::{self, Color32, Key, ProgressBar, RichText, ScrollArea, Ui};
use microsim_report::{MetricEntry, Report, Verdict};
use microsim_vocabulary::Language;

/// What the operator asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The same level.
    Again,
    /// The one after it.
    Onward,
    /// The session as it was recorded, from a tick on.
    Replay(u64),
    /// The modules.
    Back,
}

/// A verdict in a word, and its colour.
pub fn verdict(verdict: Verdict) -> (Phrase, Color32) {
    match verdict {
        Verdict::Passed => (text::PASSED, look::GOOD),
        Verdict::Failed => (text::FAILED, look::BAD),
        Verdict::NotJudged => (text::NOT_JUDGED, look::QUIET),
        Verdict::Aborted => (text::ABORTED, look::QUIET),
        Verdict::Incomplete => (text::INCOMPLETE, look::QUIET),
    }
}

/// Shows it; `has_next`: whether there is a level after this one.
pub fn show(ui: &mut Ui, debrief: &Debrief, has_next: bool, language: Language) -> Option<Next> {
    let report = &debrief.report;
    let mut next = None;
    egui::Panel::top("verdict")
        .show_separator_line(false)
        .show(ui, |ui| {
            ui.add_space(8.0);
            show_verdict(ui, report, language);
            ui.add_space(4.0);
        });
    egui::Panel::bottom("next")
        .show_separator_line(false)
        .show(ui, |ui| {
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                // What most people want next is the next level, once this one is passed.
                let has_passed = report.verdict == Verdict::Passed;
                let mut button = |text: Phrase, key, is_main| match is_main {
                    true => shortcut::main_button(ui, text.of(language), key),
                    false => shortcut::button(ui, text.of(language), key),
                };
                if has_next && button(text::NEXT_LEVEL, Key::N, has_passed) {
                    next = Some(Next::Onward);
                }
                if button(text::AGAIN, Key::A, !has_passed) {
                    next = Some(Next::Again);
                }
                if button(text::REPLAY, Key::R, false) {
                    next = Some(Next::Replay(0));
                }
                if button(text::BACK, shortcut::BACK, false) {
                    next = Some(Next::Back);
                }
            });
            let session = debrief.session.display();
            ui.label(look::quiet(format!(
                "{}: {session}",
                text::SESSION.of(language)
            )));
            ui.add_space(6.0);
        });
    egui::Panel::left("scores")
        .exact_size(ui.available_width() * 0.5)
        .resizable(false)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("scores")
                .auto_shrink(false)
                .show(ui, |ui| {
                    for complaint in &debrief.complaints {
                        ui.label(RichText::new(complaint).color(look::BAD));
                    }
                    show_scores(ui, report, language);
                });
        });
    egui::CentralPanel::default().show(ui, |ui| {
        ScrollArea::vertical()
            .id_salt("course")
            .auto_shrink(false)
            .show(ui, |ui| {
                if let Some(tick) = show_course(ui, report, language) {
                    next = Some(Next::Replay(tick));
                }
            });
    });
    next
}

fn show_verdict(ui: &mut Ui, report: &Report, language: Language) {
    let (word, colour) = verdict(report.verdict);
    ui.horizontal_wrapped(|ui| {
        ui.label(
            RichText::new(word.of(language))
                .size(28.0)
                .strong()
                .color(colour),
        );
        if let Some(score) = report.score {
            let score = number(score, 0, language);
            let score = format!("{} {score} / 100", text::SCORE.of(language));
            ui.label(RichText::new(score).size(20.0));
        }
        let title = format!(
            "{} · {} {}: {}",
            local(&report.session.module_title, language),
            text::LEVEL.of(language),
            report.session.level,
            local(&report.session.level_title, language)
        );
        ui.label(look::quiet(title));
    });
    for reason in &report.reasons {
        ui.label(RichText::new(local(reason, language)).color(colour));
    }
    if let Some(left_out) = report.left_out() {
        ui.label(look::quiet(local(&left_out, language)));
    }
}

fn show_scores(ui: &mut Ui, report: &Report, language: Language) {
    if !report.categories.is_empty() {
        ui.label(look::heading(text::CATEGORIES.of(language)));
    }
    for category in &report.categories {
        let score = number(category.score, 0, language);
        ui.horizontal(|ui| {
            ui.add_sized(
                [190.0, 20.0],
                egui::Label::new(local(&category.title, language))
                    .truncate()
                    .halign(egui::Align::LEFT),
            );
            let bar = ProgressBar::new((category.score / 100.0) as f32).corner_radius(2.0);
            ui.add(
                bar.fill(look::ACCENT)
                    .desired_width(ui.available_width() - 50.0),
            );
            ui.label(score);
        });
    }
    ui.add_space(6.0);
    ui.label(look::heading(text::METRICS.of(language)));
    for metric in &report.metrics {
        show_metric(ui, metric, language);
    }
}

fn show_metric(ui: &mut Ui, metric: &MetricEntry, language: Language) {
    let record = &metric.record;
    let colour = match record.within {
        Some(true) => look::GOOD,
        Some(false) => look::BAD,
        None => look::QUIET,
    };
    let unit = match record.display_unit.as_str() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let shown = |value: f64| number(value, decimals(value), language);
    let value = match (metric.display_value, &record.not_applicable) {
        (Some(value), _) => format!("{}{unit}", shown(value)),
        (None, Some(why)) => local(why, language).to_owned(),
        (None, None) => "–".to_owned(),
    };
    let mut limits = Vec::new();
    if let Some(min) = metric.display_min {
        limits.push(format!(
            "{} {}{unit}",
            text::AT_LEAST.of(language),
            shown(min)
        ));
    }
    if let Some(max) = metric.display_max {
        limits.push(format!(
            "{} {}{unit}",
            text::AT_MOST.of(language),
            shown(max)
        ));
    }
    ui.horizontal_wrapped(|ui| {
        ui.label(local(&record.title, language));
        ui.label(RichText::new(value).strong().color(colour));
        if !limits.is_empty() {
            ui.label(look::quiet(format!("({})", limits.join(", "))));
        }
    });
    if record.within == Some(false) {
        ui.label(look::quiet(local(&record.advice, language)));
    }
}

/// Three digits, no more decimals than that.
pub fn decimals(value: f64) -> usize {
    match value.abs() {
        v if v >= 100.0 || v == 0.0 => 0,
        v if v >= 10.0 => 1,
        _ => 2,
    }
}

/// How it went; the tick of what was clicked.
fn show_course(ui: &mut Ui, report: &Report, language: Language) -> Option<u64> {
    ui.label(look::heading(text::COURSE.of(language)));
    let marks = timeline::marks(report);
    let times: Vec<f64> = marks.iter().map(|mark| mark.time).collect();
    let frame = plot::Frame {
        end: report.simulated,
        events: &times,
        now: None,
        height: plot::HEIGHT,
    };
    let mut time = None;
    let speeds = timeline::speeds(report, language);
    let title = text::TIP_SPEED.of(language);
    time = plot::show(ui, title, &speeds, &frame, language).or(time);
    let forces = timeline::forces(report, language);
    if !forces.is_empty() {
        let title = text::FORCE.of(language);
        time = plot::show(ui, title, &forces, &frame, language).or(time);
    }
    ui.add_space(6.0);
    ui.label(look::quiet(text::CLICK_TO_REPLAY.of(language)));
    let clicked = timeline::list(ui, &marks, None, language);
    clicked.or(time.map(|time| timeline::tick_at(report, time)))
}
