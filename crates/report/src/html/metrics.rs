//! The tables of metrics: those with a limit, and those for information.

use super::text::{say, spans};
use crate::number::{against_limits, fixed};
use crate::plot::gauge;
use crate::{MetricEntry, Report};
use microsim_drawing::escape;
use microsim_message::LimitRecord;
use std::fmt::Write;

/// The metrics that the verdict rests on; nothing without a result.
pub fn judged(out: &mut String, report: &Report) {
    let all = report.metrics.iter();
    let judged: Vec<_> = all.filter(|m| m.record.limit.is_some()).collect();
    if judged.is_empty() {
        return;
    }
    super::section(out, "Messgrößen mit Grenzwert", "Metrics with a limit");
    table(out, report, &judged, true);
    if judged.iter().any(|m| {
        m.record
            .limit
            .as_ref()
            .is_some_and(|limit| limit.provisional)
    }) {
        let _ = write!(
            out,
            "<p class=\"note\"><span class=\"provisional\">{}</span> {}</p>",
            say("vorläufig", "provisional"),
            say(
                "heißt: nach Ermessen gesetzt; Messungen an Menschen, die den Grenzwert stützen, gibt es noch nicht.",
                "means: set by judgement; there are no measurements of people yet that back the limit.",
            )
        );
    }
    out.push_str("</section>\n");
}

/// The metrics without a limit, to be opened; those without a value by their names alone.
pub fn further(out: &mut String, report: &Report) {
    let unjudged = || report.metrics.iter().filter(|m| m.record.limit.is_none());
    let measured: Vec<_> = unjudged().filter(|m| m.record.value.is_some()).collect();
    let rest: Vec<_> = unjudged().filter(|m| m.record.value.is_none()).collect();
    if measured.is_empty() && rest.is_empty() {
        return;
    }
    let _ = write!(
        out,
        "<section>\n<details>\n<summary><h2>{}</h2> <span class=\"note\">{}</span></summary>\n",
        say("Weitere Messgrößen", "Further metrics"),
        say(
            "In dieser Stufe ohne Grenzwert; sie gehen nicht in das Urteil ein.",
            "Without a limit in this level; the verdict does not rest on them.",
        )
    );
    if !measured.is_empty() {
        table(out, report, &measured, false);
    }
    if !rest.is_empty() {
        let _ = write!(
            out,
            "<h3>{}</h3>\n<ul class=\"rest\">",
            say("Nicht anwendbar", "Not applicable")
        );
        for MetricEntry { record, .. } in rest {
            let reason = record
                .not_applicable
                .as_ref()
                .map(spans)
                .unwrap_or_default();
            let _ = write!(
                out,
                "<li>{} <small>{reason}</small></li>",
                spans(&record.title)
            );
        }
        out.push_str("</ul>\n");
    }
    out.push_str("</details>\n</section>\n");
}

fn table(out: &mut String, report: &Report, metrics: &[&MetricEntry], judged: bool) {
    let _ = write!(
        out,
        "<table class=\"metrics\">\n<thead><tr><th>{}</th><th class=\"n\">{}</th>",
        say("Messgröße", "Metric"),
        say("Wert", "Value")
    );
    if judged {
        let _ = write!(
            out,
            "<th>{}</th><th>{}</th><th class=\"n\">{}</th>",
            say("Grenzwert", "Limit"),
            say("Urteil", "Mark"),
            say("Punkte", "Score")
        );
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for metric in metrics {
        row(out, report, metric, judged);
    }
    out.push_str("</tbody>\n</table>\n");
}

fn row(out: &mut String, report: &Report, metric: &MetricEntry, judged: bool) {
    let record = &metric.record;
    let limits: Vec<f64> = [metric.display_min, metric.display_max]
        .into_iter()
        .flatten()
        .collect();
    let (value, limit_texts) = against_limits(
        metric.display_value,
        &limits,
        &record.display_unit,
        record.within,
    );
    let class = if record.within == Some(false) {
        " class=\"outside\""
    } else {
        ""
    };
    let _ = write!(out, "<tr{class}><td><b>{}</b>", spans(&record.title));
    if let Some(category) = report.categories.iter().find(|c| c.id == record.category) {
        let _ = write!(
            out,
            " <span class=\"tag\">{}</span>",
            spans(&category.title)
        );
    }
    let _ = write!(out, "<p class=\"advice\">{}</p>", spans(&record.advice));
    let _ = write!(
        out,
        "<p class=\"small\">{}</p></td>",
        direction(&record.direction)
    );
    match (&value, &record.not_applicable) {
        (Some(value), _) => {
            let _ = write!(out, "<td class=\"n value\">{}</td>", spans(value));
        }
        (None, reason) => {
            let reason = reason.as_ref().map(spans).unwrap_or_default();
            let _ = write!(
                out,
                "<td class=\"none\">{}<br><small>{reason}</small></td>",
                say("nicht anwendbar", "not applicable")
            );
        }
    }
    if judged {
        let mut texts = limit_texts.iter();
        let words = match (metric.display_min, metric.display_max) {
            (Some(_), Some(_)) => {
                let both: Vec<_> = texts.map(spans).collect();
                both.join(" … ")
            }
            (Some(_), None) => texts
                .next()
                .map_or(String::new(), |t| format!("≥ {}", spans(t))),
            (None, Some(_)) => texts
                .next()
                .map_or(String::new(), |t| format!("≤ {}", spans(t))),
            (None, None) => "–".into(),
        };
        let _ = write!(out, "<td class=\"limits\">{words}");
        if record.limit.as_ref().is_some_and(|limit| limit.provisional) {
            let _ = write!(
                out,
                "<span class=\"provisional\">{}</span>",
                say("vorläufig", "provisional")
            );
        }
        out.push_str(&gauge(metric));
        let mark = match record.within {
            Some(true) => format!(
                "<span class=\"mark good\">✓ {}</span>",
                say("erfüllt", "ok")
            ),
            Some(false) => format!(
                "<span class=\"mark bad\">✗ {}</span>",
                say("verfehlt", "failed")
            ),
            None => "<span class=\"mark\">–</span>".into(),
        };
        let score = record
            .score
            .map_or_else(|| "–".into(), |score| spans(&fixed(score, 0)));
        let _ = write!(out, "</td><td>{mark}</td><td class=\"n\">{score}</td>");
    }
    out.push_str("</tr>\n");
}

fn direction(direction: &str) -> String {
    match direction {
        "lower-is-better" => say("weniger ist besser", "lower is better"),
        "higher-is-better" => say("mehr ist besser", "higher is better"),
        "range" => say("die Mitte ist besser", "the middle is better"),
        "informative" => say("zur Kenntnis", "for information"),
        other => escape(other),
    }
}

/// How each metric with a value or a limit is formed, and where its limit comes from.
pub fn sources(out: &mut String, report: &Report) {
    let all = report.metrics.iter().map(|metric| &metric.record);
    let told: Vec<_> = all
        .filter(|record| record.value.is_some() || record.limit.is_some())
        .collect();
    if told.is_empty() {
        return;
    }
    let _ = write!(
        out,
        "<section>\n<details>\n<summary><h2>{}</h2> <span class=\"note\">{}</span></summary>\n<table class=\"sources\">\n\
         <thead><tr><th>{}</th><th>{}</th><th>{}</th></tr></thead>\n<tbody>\n",
        say("Formeln und Quellen", "Formulas and sources"),
        say(
            "Wie gemessen wird und woher die Grenzwerte kommen; Angaben auf Englisch.",
            "How things are measured and where the limits come from.",
        ),
        say("Messgröße", "Metric"),
        say("Formel", "Formula"),
        say("Grenzwert", "Limit"),
    );
    for record in told {
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td><code>{}</code><br>{}</td><td>{}</td></tr>",
            spans(&record.title),
            escape(&record.formula),
            escape(&record.source),
            record.limit.as_ref().map_or("–".into(), limit_source),
        );
    }
    out.push_str("</tbody>\n</table>\n</details>\n</section>\n");
}

/// Where a limit comes from. What its badge says already is not said again.
fn limit_source(limit: &LimitRecord) -> String {
    let (badge, source) = match limit.source.strip_prefix("provisional:") {
        Some(source) if limit.provisional => (true, source.trim_start()),
        _ => (limit.provisional, &limit.source[..]),
    };
    let badge = match badge {
        true => format!(
            "<span class=\"provisional\">{}</span> ",
            say("vorläufig", "provisional")
        ),
        false => String::new(),
    };
    badge + &escape(source)
}
