//! The top of the page: what was trained, how it ended and why, and whether that counts.

use crate::number::{date_time, fixed, shown};
use crate::text::{bilingual, in_both, spans};
use crate::{Report, Verdict};
use microsim_drawing::escape;
use microsim_message::{LevelPhase, MetricRecord};
use std::fmt::Write;

/// Module, level, verdict, reasons, warnings that come before everything else, and the scores.
pub fn head(out: &mut String, report: &Report) {
    let session = &report.session;
    out.push_str("<header>\n<div class=\"bar\"><span class=\"brand\">MicroSim</span>\
        <nav><label for=\"language-en\">English</label><label for=\"language-de\">Deutsch</label></nav></div>\n");
    let _ = write!(
        out,
        "<h1>{}</h1>\n<p class=\"level\">{} {} · {}</p>\n<p class=\"task\">{}</p>\n<p class=\"facts\">",
        spans(&session.module_title),
        bilingual("Stufe", "Level"),
        session.level,
        spans(&session.level_title),
        spans(&session.level_summary),
    );
    if let Some(trainee) = &session.trainee {
        let _ = write!(out, "<b>{}</b> · ", escape(trainee));
    }
    let _ = write!(
        out,
        "{} · {} <code>{}</code></p>\n</header>\n",
        spans(&date_time(session.started)),
        bilingual("Eingabe", "input"),
        escape(&session.input)
    );
    banners(out, report);
    verdict(out, report);
    if let (Verdict::Failed, Some(text)) = (report.verdict, session.foreign_hand()) {
        let _ = writeln!(out, "<p class=\"banner warn\">{}</p>", spans(&text));
    }
    if let Some(text) = report.left_out() {
        let _ = writeln!(out, "<p class=\"banner warn\">{}</p>", spans(&text));
    }
    better(out, report);
    categories(out, report);
}

/// What to do better: what was outside its limit, and the mistakes of a run that failed; where no limit was broken, what is missing; in a run
/// that passed, what cost most points.
fn better(out: &mut String, report: &Report) {
    let records = || report.metrics.iter().map(|metric| &metric.record);
    let failed = report.verdict == Verdict::Failed;
    let broken = |m: &MetricRecord| m.within == Some(false);
    let mut advised: Vec<_> = records()
        .filter(|m| broken(m) || (failed && is_mistake(m)))
        .collect();
    // What else cost points is no help against a target that was missed.
    let missing = failed && !records().any(broken);
    if advised.is_empty() && !failed {
        // What the level sets no limit to it may not even want.
        let lost =
            records().filter(|m| m.limit.is_some() && m.score.is_some_and(|score| score < 100.0));
        let points = |m: &MetricRecord| m.score.unwrap_or(100.0);
        advised.extend(lost.min_by(|a, b| points(a).total_cmp(&points(b))));
    }
    let reasons = report.reasons.iter().filter(|_| missing);
    let tracker = !report.implausible.is_empty();
    if advised.is_empty() && reasons.clone().next().is_none() && !tracker {
        return;
    }
    super::section(out, "So wird es besser", "What to do better");
    out.push_str("<ul class=\"better\">");
    if tracker {
        let _ = write!(
            out,
            "<li><b>{}</b> {}</li>",
            bilingual("Tracker:", "Tracker:"),
            bilingual(
                "Prüfen Sie Sicht, Licht und Befestigung der Marker, bevor Sie weiterüben; was der Tracker falsch meldet, \
                 ist kein Fehler der Hand.",
                "Check view, light and how the markers are fixed before the next run; what the tracker reports wrongly is no mistake \
                 of the hand.",
            )
        );
    }
    for reason in reasons {
        let first = bilingual(
            "Nehmen Sie sich das zuerst vor; danach kommt es auf die Messgrößen an.",
            "Work on this first; the metrics matter after it.",
        );
        let _ = write!(out, "<li><b>{}</b> {first}</li>", spans(reason));
    }
    for metric in advised {
        let _ = write!(
            out,
            "<li><b>{}:</b> {}</li>",
            spans(&metric.title),
            spans(&metric.advice)
        );
    }
    out.push_str("</ul>\n</section>\n");
}

/// Whether it counts mistakes, and there was one: a drop, for example, also where the level sets no limit to it.
fn is_mistake(metric: &MetricRecord) -> bool {
    let counts = metric.unit == "count" && metric.direction == "lower-is-better";
    counts && metric.value.is_some_and(|value| value >= 1.0)
}

/// Reasons to distrust or disregard the run.
fn banners(out: &mut String, report: &Report) {
    let session = &report.session;
    if let Some(made) = &session.synthetic {
        let made = escape(made);
        let _ = writeln!(
            out,
            "<div class=\"banner made\" role=\"alert\"><b>{}</b> {} <code>{made}</code></div>",
            bilingual("Synthetischer Trainee.", "Synthetic trainee."),
            bilingual(
                "Ein Programm hat diese Bewegungen gemacht, kein Mensch. Sie prüfen die Software; über Menschen, und darüber, ob \
                 die Grenzwerte gut gewählt sind, erlauben sie keine Aussage.",
                "A program made these motions, not a person. They test the software; about people, and about whether the limits \
                 are well chosen, they allow no conclusion.",
            )
        );
    }
    let mut banner = |class: &str, title: String, text: String| {
        let _ = writeln!(
            out,
            "<div class=\"banner {class}\" role=\"alert\"><b>{title}</b> {text}</div>"
        );
    };
    if session.mirrored {
        banner(
            "made",
            bilingual("Linkshändig.", "Left-handed."),
            bilingual(
                "Die Stufe war gespiegelt: Wo ihr Text links sagt, war es rechts.",
                "The level was mirrored: where its text has left, it was right.",
            ),
        );
    }
    if !session.without.is_empty() {
        banner(
            "stop",
            bilingual("Kein Ergebnis.", "No result."),
            bilingual(
                &format!(
                    "Dieser Lauf wurde ohne {} berechnet und zählt nicht.",
                    session.without.join(", ")
                ),
                &format!(
                    "This run was computed without {} and does not count.",
                    session.without.join(", ")
                ),
            ),
        );
    }
    if !session.changed_files.is_empty() {
        let files = escape(&session.changed_files.join(", "));
        banner(
            "stop",
            bilingual(
                "Nicht die ausgelieferte Aufgabe.",
                "Not the level that was installed.",
            ),
            format!(
                "{} <code>{files}</code>",
                bilingual(
                    "Grenzwerte, Gewebe oder Instrumente können andere sein; angegebene Fehler des Gewebes gelten nicht. Geändert:",
                    "Limits, tissue or tools may be others; what is stated of the tissue's error does not hold. Changed:",
                )
            ),
        );
    }
    if report.verdict == Verdict::Incomplete {
        let end = shown(report.simulated, "s");
        let phase = phase(report.phase);
        banner(
            "stop",
            bilingual("Unvollständig.", "Incomplete."),
            bilingual(
                &format!(
                    "Die Aufzeichnung endet nach {} (Zustand: {}), bevor es ein Ergebnis gab. \
                     Was bis dahin geschah, steht unten.",
                    end.de, phase.de
                ),
                &format!(
                    "The record ends after {} (state: {}), before there was a result. \
                     What happened until then is shown below.",
                    end.en, phase.en
                ),
            ),
        );
    }
    if let Some(complaint) = &session.complaint {
        banner(
            "warn",
            bilingual(
                "Sitzungsdatei abgebrochen oder beschädigt.",
                "Session file cut or damaged.",
            ),
            escape(complaint),
        );
    }
    for failure in &session.failures {
        banner(
            "warn",
            bilingual("Ein Plugin ist ausgefallen.", "A plugin failed."),
            escape(failure),
        );
    }
}

fn phase(phase: LevelPhase) -> microsim_message::LocalText {
    match phase {
        LevelPhase::Introduction => in_both("Einführung", "introduction"),
        LevelPhase::Running => in_both("läuft", "running"),
        LevelPhase::Paused => in_both("Pause", "paused"),
        LevelPhase::Passed => in_both("bestanden", "passed"),
        LevelPhase::Failed => in_both("nicht bestanden", "failed"),
        LevelPhase::NotJudged => in_both("nicht gewertet", "not judged"),
    }
}

fn verdict(out: &mut String, report: &Report) {
    let (class, symbol, word) = match report.verdict {
        Verdict::Passed => ("passed", "✓", in_both("Bestanden", "Passed")),
        Verdict::Failed => ("failed", "✗", in_both("Nicht bestanden", "Not passed")),
        Verdict::NotJudged => ("open", "–", in_both("Nicht gewertet", "Not judged")),
        Verdict::Aborted => ("open", "■", in_both("Abgebrochen", "Aborted")),
        Verdict::Incomplete => ("open", "?", in_both("Kein Ergebnis", "No result")),
    };
    let class = if report.session.without.is_empty() {
        class
    } else {
        "open"
    };
    let _ = write!(
        out,
        "<section class=\"verdict {class}\">\n<div class=\"symbol\" aria-hidden=\"true\">{symbol}</div>\n\
         <div class=\"words\"><p class=\"word\">{}",
        spans(&word)
    );
    if !report.session.without.is_empty() {
        let _ = write!(
            out,
            " <small>{}</small>",
            bilingual("(zählt nicht)", "(does not count)")
        );
    }
    out.push_str("</p>\n");
    let sentence = match report.verdict {
        Verdict::Passed => bilingual(
            "Alle Ziele erreicht, alle anwendbaren Grenzwerte eingehalten.",
            "All targets reached, all applicable limits met.",
        ),
        Verdict::Aborted => bilingual(
            "Der Lauf wurde von Hand abgebrochen; er erlaubt keine Aussage über den Trainee.",
            "The run was stopped by hand; it allows no conclusion about the trainee.",
        ),
        Verdict::NotJudged => bilingual(
            "Berechnung oder Messung reichen für ein Urteil nicht aus; der Lauf erlaubt keine Aussage über den Trainee.",
            "Computation or measurement is no ground for a verdict; the run allows no conclusion about the trainee.",
        ),
        Verdict::Failed | Verdict::Incomplete => String::new(),
    };
    if !sentence.is_empty() {
        let _ = writeln!(out, "<p>{sentence}</p>");
    }
    if report.verdict == Verdict::NotJudged {
        out.push_str("<ul class=\"reasons\">");
        for why in &report.reasons {
            let _ = write!(out, "<li>{}</li>", spans(why));
        }
        out.push_str("</ul>\n");
    }
    if !report.failed.is_empty() {
        out.push_str("<ul class=\"reasons\">");
        for (k, id) in report.failed.iter().enumerate() {
            // A reason without words is at least named.
            let words = report.reasons.get(k).map_or_else(|| escape(id), spans);
            let _ = write!(out, "<li>{words}</li>");
        }
        out.push_str("</ul>\n");
    }
    out.push_str("</div>\n<dl class=\"tiles\">");
    let mut tile = |name: String, value: String| {
        let _ = write!(out, "<div><dt>{name}</dt><dd>{value}</dd></div>");
    };
    if let Some(score) = report.score {
        let of = "<small> / 100</small>";
        tile(
            bilingual("Punkte", "Score"),
            format!("{}{of}", spans(&fixed(score, 1))),
        );
    }
    tile(
        bilingual("Ziele", "Targets"),
        format!(
            "{}<small> / {}</small>",
            report.targets_done, report.targets
        ),
    );
    tile(
        bilingual("Zeit", "Time"),
        spans(&shown(report.duration, "s")),
    );
    out.push_str("</dl>\n</section>\n");
}

fn categories(out: &mut String, report: &Report) {
    if report.categories.is_empty() {
        return;
    }
    super::section(out, "Punkte nach Bereichen", "Score by category");
    out.push_str("<div class=\"bars\">\n");
    for category in &report.categories {
        let width = if category.score.is_finite() {
            category.score.clamp(0.0, 100.0)
        } else {
            0.0
        };
        let _ = writeln!(
            out,
            "<div class=\"row\"><span>{}</span><span class=\"rail\"><span style=\"width:{width:.1}%\"></span></span>\
             <b>{}</b></div>",
            spans(&category.title),
            spans(&fixed(category.score, 1))
        );
    }
    let _ = write!(
        out,
        "</div>\n<p class=\"note\">{}</p>\n</section>\n",
        bilingual(
            "Die Punkte (0–100) zeigen den Fortschritt. Bestanden ist eine Stufe nur, wenn jeder einzelne Grenzwert \
             eingehalten ist, der kein Richtwert ist; Punkte gleichen keinen überschrittenen Grenzwert aus.",
            "The score (0–100) shows progress. A level is passed only if every single limit is met that is no reference value; a \
             high score does not make up for a violated limit.",
        )
    );
}
