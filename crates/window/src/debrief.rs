//! After a run: the verdict, what it rests on, and how it went.

use crate::ledger::Debrief;
use crate::look;
use crate::plot::{self, Curve};
use crate::text::{self, Phrase, local, number};
use eframe::egui::{self, Color32, ProgressBar, RichText, ScrollArea, Ui};
use microsim_report::{MetricEntry, Report, Verdict};
use microsim_vocabulary::Language;

/// What the operator asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The same level.
    Again,
    /// The one after it.
    Onward,
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
                let button = |text: Phrase, is_main| match is_main {
                    true => look::main_button(text.of(language)),
                    false => egui::Button::new(text.of(language)),
                };
                if has_next && ui.add(button(text::NEXT_LEVEL, has_passed)).clicked() {
                    next = Some(Next::Onward);
                }
                if ui.add(button(text::AGAIN, !has_passed)).clicked() {
                    next = Some(Next::Again);
                }
                if ui.button(text::BACK.of(language)).clicked() {
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
                show_course(ui, report, language);
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

fn show_course(ui: &mut Ui, report: &Report, language: Language) {
    ui.label(look::heading(text::COURSE.of(language)));
    let name = |tool: &str| match report.session.tools.get(tool) {
        Some(title) => local(title, language).to_owned(),
        None => tool.to_owned(),
    };
    let speeds: Vec<Curve> = report
        .series
        .iter()
        .map(|series| {
            let speed = series.speed.iter().map(|speed| speed.map(|v| 1e3 * v));
            Curve {
                name: name(&series.tool),
                points: series.time.iter().copied().zip(speed).collect(),
            }
        })
        .collect();
    let forces: Vec<Curve> = report
        .forces
        .iter()
        .map(|series| {
            let mut points = Vec::new();
            for k in 0..series.time.len() {
                if k > 0 && series.contact[k] != series.contact[k - 1] {
                    points.push((series.time[k], None));
                }
                let force = series.valid[k].then_some(1e3 * series.sustained[k]);
                points.push((series.time[k], force));
            }
            Curve {
                name: format!("{}, {}", name(&series.tool), series.body),
                points,
            }
        })
        .collect();
    let events: Vec<f64> = report
        .events
        .iter()
        .map(|event| event.session_time)
        .collect();
    plot::show(
        ui,
        text::TIP_SPEED.of(language),
        &speeds,
        &events,
        report.simulated,
        language,
    );
    if !forces.is_empty() {
        plot::show(
            ui,
            text::FORCE.of(language),
            &forces,
            &events,
            report.simulated,
            language,
        );
    }
    ui.add_space(6.0);
    for moment in &report.events {
        let time = number(moment.session_time, 1, language);
        ui.label(look::quiet(format!(
            "{time} s  {}",
            local(&moment.text, language)
        )));
    }
}
