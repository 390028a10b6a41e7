//! The tables of metrics: those with a limit, and those for information.

use crate::number::{against_limits, fixed};
use crate::plot::gauge;
use crate::text::{bilingual, spans};
use crate::{MetricEntry, Report};
use microsim_drawing::escape;
use microsim_message::LimitRecord;
use std::fmt::Write;

/// The metrics that the verdict rests on; nothing without a result.
pub fn with_limit(out: &mut String, report: &Report) {
    let all = report.metrics.iter();
    let limited: Vec<_> = all.filter(|m| m.record.limit.is_some()).collect();
    if limited.is_empty() {
        return;
    }
    super::section(out, "Messgrößen mit Grenzwert", "Metrics with a limit");
    table(out, report, &limited, true);
    if limited.iter().any(|m| {
        m.record
            .limit
            .as_ref()
            .is_some_and(|limit| limit.provisional)
    }) {
        let _ = write!(
            out,
            "<p class=\"note\"><span class=\"provisional\">{}</span> {}</p>",
            bilingual("vorläufig", "provisional"),
            bilingual(
                "heißt: nach Ermessen gesetzt; Messungen an Menschen, die den Grenzwert stützen, gibt es noch nicht.",
                "means: set by judgement; there are no measurements of people yet that back the limit.",
            )
        );
    }
    if limited.iter().any(|metric| !decides(metric)) {
        let _ = write!(
            out,
            "<p class=\"note\"><span class=\"provisional\">{}</span> {}</p>",
            reference_value(),
            bilingual(
                "heißt: zählt für die Punkte, aber nicht für Bestehen oder Nichtbestehen, weil die Messgröße in dieser Stufe zu sehr von der Berechnung abhängt.",
                "means: it counts for the score, but neither for nor against a pass, as the metric depends too much on the computation in this level.",
            )
        );
    }
    out.push_str("</section>\n");
}

/// Whether the verdict rests on the limit of a metric.
fn decides(metric: &MetricEntry) -> bool {
    metric
        .record
        .limit
        .as_ref()
        .is_none_or(|limit| limit.decides)
}

fn reference_value() -> String {
    bilingual("Richtwert", "reference value")
}

/// The metrics without a limit, to be opened; those without a value by their names alone.
pub fn further(out: &mut String, report: &Report) {
    let without_limit = || report.metrics.iter().filter(|m| m.record.limit.is_none());
    let measured: Vec<_> = without_limit()
        .filter(|m| m.record.value.is_some())
        .collect();
    let rest: Vec<_> = without_limit()
        .filter(|m| m.record.value.is_none())
        .collect();
    if measured.is_empty() && rest.is_empty() {
        return;
    }
    let _ = write!(
        out,
        "<section>\n<details>\n<summary><h2>{}</h2> <span class=\"note\">{}</span></summary>\n",
        bilingual("Weitere Messgrößen", "Further metrics"),
        bilingual(
            "In dieser Stufe ohne Grenzwert; sie gehen nicht in die Bewertung ein.",
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
            bilingual("Nicht anwendbar", "Not applicable")
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

fn table(out: &mut String, report: &Report, metrics: &[&MetricEntry], limited: bool) {
    let _ = write!(
        out,
        "<table class=\"metrics\">\n<thead><tr><th>{}</th><th class=\"n\">{}</th>",
        bilingual("Messgröße", "Metric"),
        bilingual("Wert", "Value")
    );
    if limited {
        let _ = write!(
            out,
            "<th>{}</th><th>{}</th><th class=\"n\">{}</th>",
            bilingual("Grenzwert", "Limit"),
            bilingual("Bewertung", "Result"),
            bilingual("Punkte", "Score")
        );
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for metric in metrics {
        row(out, report, metric, limited);
    }
    out.push_str("</tbody>\n</table>\n");
}

fn row(out: &mut String, report: &Report, metric: &MetricEntry, limited: bool) {
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
    let class = if record.within == Some(false) && decides(metric) {
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
    let mut explained = explanation(&record.id).unwrap_or_default();
    // What the level sets no limit to it may not even want: a still hand is no fault where one has to be still.
    if limited {
        let _ = write!(out, "<p class=\"advice\">{}</p>", spans(&record.advice));
        explained = format!("{}. {explained}", direction(&record.direction));
    }
    let _ = write!(out, "<p class=\"small\">{explained}</p></td>");
    match (&value, &record.not_applicable) {
        (Some(value), _) => {
            let _ = write!(out, "<td class=\"n value\">{}</td>", spans(value));
        }
        (None, reason) => {
            let reason = reason.as_ref().map(spans).unwrap_or_default();
            let _ = write!(
                out,
                "<td class=\"none\">{}<br><small>{reason}</small></td>",
                bilingual("nicht anwendbar", "not applicable")
            );
        }
    }
    if limited {
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
                bilingual("vorläufig", "provisional")
            );
        }
        if !decides(metric) {
            let _ = write!(
                out,
                "<span class=\"provisional\">{}</span>",
                reference_value()
            );
        }
        out.push_str(&gauge(metric));
        let mark = match record.within {
            Some(false) if !decides(metric) => {
                format!(
                    "<span class=\"mark\">{}</span>",
                    bilingual("außerhalb", "outside")
                )
            }
            Some(true) => format!(
                "<span class=\"mark good\">✓ {}</span>",
                bilingual("erfüllt", "ok")
            ),
            Some(false) => format!(
                "<span class=\"mark bad\">✗ {}</span>",
                bilingual("verfehlt", "failed")
            ),
            None => "<span class=\"mark\">–</span>".into(),
        };
        let score = record
            .score
            .map_or_else(|| "–".into(), |score| spans(&fixed(score, 1)));
        let _ = write!(out, "</td><td>{mark}</td><td class=\"n\">{score}</td>");
    }
    out.push_str("</tr>\n");
}

/// What a metric is, where few know it by its name.
fn explanation(id: &str) -> Option<String> {
    let (de, en) = match id {
        "sparc" => (
            "Länge der Kurve des Geschwindigkeitsspektrums, negativ: je näher an null, desto glatter die Bewegung.",
            "Length of the curve of the speed's spectrum, negative: the nearer to zero, the smoother the motion.",
        ),
        "ldlj" => (
            "Ruck (Änderung der Beschleunigung) ohne Einheit, als Logarithmus: je näher an null, desto glatter.",
            "Jerk (change of acceleration) without a unit, as a logarithm: the nearer to zero, the smoother.",
        ),
        "idle-fraction" => (
            "Anteil der Zeit, in der das Instrument so gut wie stillsteht.",
            "Fraction of the time in which the instrument as good as stands still.",
        ),
        "bimanual-fraction" => (
            "Anteil der Zeit, in der sich beide Instrumente bewegen.",
            "Fraction of the time in which both tools move.",
        ),
        "speed-correlation" => (
            "Ob sich beide Instrumente zugleich bewegen (1), unabhängig voneinander (0) oder abwechselnd (−1).",
            "Whether both tools move at the same time (1), independently (0) or in turn (−1).",
        ),
        "path-asymmetry" => (
            "Unterschied der Wege beider Instrumente: 0 % heißt gleich lang, 100 % nur eine Hand.",
            "Difference of the paths of both tools: 0 % is even, 100 % one hand alone.",
        ),
        _ => return None,
    };
    Some(bilingual(de, en))
}

fn direction(direction: &str) -> String {
    match direction {
        "lower-is-better" => bilingual("Weniger ist besser", "Lower is better"),
        "higher-is-better" => bilingual("Mehr ist besser", "Higher is better"),
        "range" => bilingual("Die Mitte ist besser", "The middle is better"),
        "informative" => bilingual("Zur Information", "For information"),
        other => escape(other),
    }
}

/// How each metric with a value or a limit is formed, and where its limit comes from.
pub fn sources(out: &mut String, report: &Report) {
    let all = report.metrics.iter().map(|metric| &metric.record);
    let listed: Vec<_> = all
        .filter(|record| record.value.is_some() || record.limit.is_some())
        .collect();
    if listed.is_empty() {
        return;
    }
    let _ = write!(
        out,
        "<section>\n<details>\n<summary><h2>{}</h2> <span class=\"note\">{}</span></summary>\n<table class=\"sources\">\n\
         <thead><tr><th>{}</th><th>{}</th><th>{}</th></tr></thead>\n<tbody>\n",
        bilingual("Formeln und Quellen", "Formulas and sources"),
        bilingual(
            "Wie gemessen wird und woher die Grenzwerte kommen; Angaben auf Englisch.",
            "How each metric is measured and where the limits come from.",
        ),
        bilingual("Messgröße", "Metric"),
        bilingual("Formel", "Formula"),
        bilingual("Grenzwert", "Limit"),
    );
    for record in listed {
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

/// Where a limit comes from, without what its badge states already.
fn limit_source(limit: &LimitRecord) -> String {
    let (badge, source) = match limit.source.strip_prefix("provisional:") {
        Some(source) if limit.provisional => (true, source.trim_start()),
        _ => (limit.provisional, &limit.source[..]),
    };
    let badge = match badge {
        true => format!(
            "<span class=\"provisional\">{}</span> ",
            bilingual("vorläufig", "provisional")
        ),
        false => String::new(),
    };
    badge + &escape(source)
}
