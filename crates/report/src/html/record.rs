//! The input, what went wrong, and where all of it comes from.

use super::section;
use crate::Report;
use crate::number::{fixed, shown};
use crate::text::{bilingual, spans};
use microsim_drawing::escape;
use microsim_message::LogLevel;
use std::fmt::Write;

/// Lines of warnings that are shown; the JSON form has all.
const MAX_WARNINGS: usize = 100;
/// Stretches of samples that no hand makes that are shown; the JSON form has all.
const MAX_STRETCHES: usize = 20;

/// The raw input of each device and how long each tool was tracked.
pub fn input(out: &mut String, report: &Report) {
    section(out, "Eingabe", "Input");
    if report.input.is_empty() {
        let _ = writeln!(
            out,
            "<p>{}</p>",
            bilingual("Es kam kein Messwert an.", "No sample arrived.")
        );
    } else {
        devices(out, report);
    }
    if !report.presence.is_empty() {
        presence(out, report);
    }
    arrivals(out, report);
    markers(out, report);
    implausible(out, report);
    out.push_str("</section>\n");
}

fn devices(out: &mut String, report: &Report) {
    let _ = write!(
        out,
        "<p class=\"note\">{}</p>\n<table>\n<thead><tr>",
        bilingual(
            "Die rohen Messwerte im Koordinatensystem des Geräts, vor jeder Umrechnung. Über Lücken hinweg wird nichts \
             verbunden.",
            "The raw samples in the device's own frame, before any translation. Nothing is connected across gaps.",
        )
    );
    for (k, (de, en)) in [
        ("Gerät", "Device"),
        ("Messwerte", "Samples"),
        ("Verdeckt", "Occluded"),
        ("Abschnitte", "Segments"),
        ("Lücken", "Gaps"),
        ("Längste Lücke", "Longest gap"),
        ("Weg", "Path"),
        ("Rate", "Rate"),
        ("Dauer", "Duration"),
        ("Erfasst", "Tracked"),
    ]
    .into_iter()
    .enumerate()
    {
        let class = if k == 0 { "" } else { " class=\"n\"" };
        let _ = write!(out, "<th{class}>{}</th>", bilingual(de, en));
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for device in &report.input {
        let _ = write!(out, "<tr><td><b>{}</b></td>", escape(&device.device));
        let count = |n: usize| fixed(n as f64, 0);
        let millimetres = fixed(device.path_mm, 3);
        let with_unit =
            |text: microsim_message::LocalText, unit: &str| format!("{}\u{a0}{unit}", spans(&text));
        let rate = device.rate_hz.map(|rate| with_unit(fixed(rate, 1), "Hz"));
        for cell in [
            spans(&count(device.samples)),
            spans(&count(device.occluded_samples)),
            spans(&count(device.segments)),
            spans(&count(device.gaps)),
            with_unit(fixed(device.longest_gap_s, 2), "s"),
            with_unit(millimetres, "mm"),
            rate.unwrap_or_else(|| "–".into()),
            with_unit(fixed(device.duration_s, 1), "s"),
            with_unit(fixed(device.tracked_s, 1), "s"),
        ] {
            let _ = write!(out, "<td class=\"n\">{cell}</td>");
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table>\n");
}

/// A bar for each tool: tracked, occluded, stale, never seen.
fn presence(out: &mut String, report: &Report) {
    let _ = write!(
        out,
        "<h3>{}</h3>\n<div class=\"bars presence\">\n",
        bilingual("Erfassung der Instrumente", "Tracking of the instruments")
    );
    for tool in &report.presence {
        let parts = [
            ("tracked", tool.tracked, "erfasst", "tracked"),
            ("occluded", tool.occluded, "verdeckt", "occluded"),
            ("stale", tool.stale, "veraltet", "stale"),
            ("unseen", tool.never_seen, "noch nie gesehen", "never seen"),
        ];
        let total: f64 = parts.iter().map(|part| part.1).sum();
        let total = if total > 0.0 { total } else { 1.0 };
        let _ = write!(
            out,
            "<div class=\"row\"><span><b>{}</b> <small>{}</small></span><span class=\"rail\">",
            spans(&report.session.tool_name(&tool.tool)),
            escape(&tool.model)
        );
        for (class, time, ..) in parts {
            let _ = write!(
                out,
                "<span class=\"{class}\" style=\"width:{:.2}%\"></span>",
                100.0 * time / total
            );
        }
        out.push_str("</span><span class=\"shares\">");
        for (class, time, de, en) in parts.into_iter().filter(|part| part.1 > 0.0) {
            let _ = write!(
                out,
                "<span><span class=\"key {class}\"></span>{} {}</span>",
                bilingual(de, en),
                spans(&shown(100.0 * time / total, "%"))
            );
        }
        out.push_str("</span></div>\n");
    }
    out.push_str("</div>\n");
}

/// How samples of live trackers came.
fn arrivals(out: &mut String, report: &Report) {
    let Some(arrivals) = &report.arrivals else {
        return;
    };
    let _ = write!(
        out,
        "<h3>{}</h3>\n<table>\n<thead><tr><th>{}</th><th class=\"n\">p50</th><th class=\"n\">p99</th></tr></thead>\n<tbody>\n",
        bilingual("Verzögerung", "Delay"),
        bilingual("Abschnitt", "Stage")
    );
    let stages = [
        (
            "vom Eintreffen bis zum Takt",
            "from arrival to the tick",
            arrivals.wait,
        ),
        (
            "vom Takt bis zu seinem Abbild",
            "from the tick to its snapshot",
            arrivals.tick,
        ),
    ];
    for (de, en, spread) in stages {
        let Some(spread) = spread else {
            continue;
        };
        let cell = |time: f64| spans(&shown(1e3 * time, "ms"));
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            bilingual(de, en),
            cell(spread.p50),
            cell(spread.p99)
        );
    }
    let (samples, dropped, late) = (arrivals.samples, arrivals.dropped, arrivals.late);
    let _ = writeln!(
        out,
        "</tbody>\n</table>\n<p class=\"note\">{}</p>",
        bilingual(
            &format!("{samples} Messwerte; verworfen {dropped}, verspätet {late}."),
            &format!("{samples} samples; {dropped} dropped, {late} late."),
        )
    );
}

/// What the markers of instruments have shown.
fn markers(out: &mut String, report: &Report) {
    if report.markers.is_empty() {
        return;
    }
    let _ = write!(
        out,
        "<h3>{}</h3>\n<table>\n<thead><tr>",
        bilingual("Marker", "Markers")
    );
    for (k, (de, en)) in [
        ("Gerät", "Device"),
        ("Bilder", "Frames"),
        ("Mit Pose", "With a pose"),
        ("Residuum", "Residual"),
        ("Fehlend", "Missing"),
        ("Verschmolzen", "Merged"),
        ("Vertauscht", "Permuted"),
        ("Unbekannt", "Unknown"),
    ]
    .into_iter()
    .enumerate()
    {
        let class = if k == 0 { "" } else { " class=\"n\"" };
        let _ = write!(out, "<th{class}>{}</th>", bilingual(de, en));
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for record in &report.markers {
        let _ = write!(out, "<tr><td><b>{}</b></td>", escape(&record.device));
        let count = |n: u64| spans(&fixed(n as f64, 0));
        for cell in [
            count(record.frames),
            count(record.poses),
            spans(&shown(1e3 * record.residual, "mm")),
            count(record.missing),
            count(record.merged),
            count(record.permuted),
            count(record.unknown),
        ] {
            let _ = write!(out, "<td class=\"n\">{cell}</td>");
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table>\n");
}

/// What was left out as no hand makes it.
fn implausible(out: &mut String, report: &Report) {
    if report.implausible.is_empty() {
        return;
    }
    let _ = write!(
        out,
        "<h3>{}</h3>\n<p class=\"note\">{}</p>\n<ul>\n",
        bilingual("Was keine Hand macht", "What no hand makes"),
        bilingual(
            "Diese Messwerte gingen über das hinaus, was eine Hand kann. Sie wurden weggelassen: Das Instrument blieb stehen, wo es \
             zuletzt war, oder galt nach kurzer Zeit als verdeckt; kein Messwert verbindet, was vor und nach ihnen liegt.",
            "These samples were beyond what a hand can do. They were left out: the tool stood where it was last, or was taken for occluded after \
             a short time; no metric connects what lies before and after them.",
        )
    );
    let all = report.implausible.iter();
    let all = all.flat_map(|record| record.stretches.iter().map(move |s| (record, s)));
    let count = all.clone().count();
    for (record, stretch) in all.take(MAX_STRETCHES) {
        let _ = writeln!(
            out,
            "<li><time>{}</time> <b>{}</b>: {} <span class=\"tag\">× {}</span>, {}</li>",
            spans(&shown(stretch.session_time, "s")),
            spans(&report.session.tool_name(&record.tool)),
            spans(&stretch.words()),
            stretch.samples,
            spans(&shown(stretch.duration, "s")),
        );
    }
    if let Some(more) = count.checked_sub(MAX_STRETCHES).filter(|&n| n > 0) {
        let _ = writeln!(out, "<li>… {more} {}</li>", bilingual("weitere", "more"));
    }
    out.push_str("</ul>\n");
}

/// How far the solver of the tissue came.
fn computation(out: &mut String, report: &Report) {
    let Some(solver) = &report.solver else {
        return;
    };
    section(out, "Berechnung", "Computation");
    let [usual, largest] =
        [solver.force_residual.p99, solver.force_residual.max].map(|n| shown(n * 1e3, "mN"));
    let of = solver.ticks;
    let sentences = [
        (solver.residual.max > 0.0).then(|| {
            bilingual(
                &format!(
                    "Am Ende eines Schrittes blieb höchstens {} an Kraft übrig, in 99 von 100 Schritten höchstens {}.",
                    largest.de, usual.de
                ),
                &format!(
                    "At the end of a tick at most {} of force was left, in 99 of 100 ticks at most {}.",
                    largest.en, usual.en
                ),
            )
        }),
        Some(bilingual(
            &format!(
                "{} von {of} Schritten endeten über der Toleranz des Verfahrens; in {} bedeuten die Kräfte nichts, \
                 und kein Messwert hat eine übernommen.",
                solver.unconverged, solver.invalid
            ),
            &format!(
                "{} of {of} ticks ended above the tolerance of the method; in {} the forces mean nothing, \
                 and no metric took one.",
                solver.unconverged, solver.invalid
            ),
        )),
        (solver.repeated > 0).then(|| {
            bilingual(
                &format!(
                    "{} Schritte wurden noch einmal berechnet, mit kleineren Teilschritten oder ohne Gewebefetzen an Schnitten; \
                     {} Fetzen rissen so in sich.",
                    solver.repeated, solver.ruptured
                ),
                &format!(
                    "{} ticks were computed again, with smaller sub-steps or without shreds of tissue at cuts; {} shreds ruptured so.",
                    solver.repeated, solver.ruptured
                ),
            )
        }),
    ];
    let held_off = [
        (solver.tools_stood > 0).then(|| {
            bilingual(
                &format!(
                    "In {} Schritten blieben die Instrumente, wo sie waren, oder berührten nichts: Wohin die Hand sie führte, ließ das Gewebe sich nicht berechnen.",
                    solver.tools_stood
                ),
                &format!(
                    "In {} ticks the instruments stayed where they were or touched nothing: where the hand led them the tissue could not be computed.",
                    solver.tools_stood
                ),
            )
        }),
        (solver.tool_contacts > 0).then(|| {
            let time = shown(f64::from(solver.tool_contacts) * report.session.tick_s, "s");
            bilingual(
                &format!("Die Instrumente berührten einander, {} lang.", time.de),
                &format!("The instruments touched each other, for {}.", time.en),
            )
        }),
    ];
    for sentence in sentences.into_iter().chain(held_off).flatten() {
        let _ = writeln!(out, "<p>{sentence}</p>");
    }
    out.push_str("</section>\n");
}

/// How far the solver came, recoveries of tissue, warnings and errors.
pub fn incidents(out: &mut String, report: &Report) {
    computation(out, report);
    if !report.recoveries.is_empty() {
        section(out, "Neu berechnetes Gewebe", "Tissue computed again");
        let _ = write!(
            out,
            "<p class=\"note\">{}</p>\n<ul>\n",
            bilingual(
                "Die Berechnung dieser Körper wurde instabil; sie wurden zurückgesetzt und mit kleineren Schritten erneut berechnet.",
                "The computation of these bodies became unstable; they were reset and computed again with smaller steps.",
            )
        );
        for recovery in &report.recoveries {
            let _ = writeln!(
                out,
                "<li><time>{}</time> <b>{}</b>: {} ({} {})</li>",
                spans(&shown(recovery.session_time, "s")),
                spans(&report.session.body_name(&recovery.body)),
                escape(&recovery.cause),
                recovery.substeps,
                bilingual("Teilschritte", "sub-steps")
            );
        }
        out.push_str("</ul>\n</section>\n");
    }
    if report.warnings.is_empty() {
        return;
    }
    section(out, "Warnungen", "Warnings");
    out.push_str("<ul>\n");
    for warning in report.warnings.iter().take(MAX_WARNINGS) {
        let level = match warning.level {
            LogLevel::Error => bilingual("Fehler", "Error"),
            _ => bilingual("Warnung", "Warning"),
        };
        let _ = write!(
            out,
            "<li><time>{}</time> <b>{level}:</b> {}",
            spans(&shown(warning.session_time, "s")),
            escape(&warning.text)
        );
        if warning.count > 1 {
            let _ = write!(out, " <span class=\"tag\">× {}</span>", warning.count);
        }
        out.push_str("</li>\n");
    }
    if let Some(more) = report
        .warnings
        .len()
        .checked_sub(MAX_WARNINGS)
        .filter(|&n| n > 0)
    {
        let _ = writeln!(out, "<li>… {more} {}</li>", bilingual("weitere", "more"));
    }
    out.push_str("</ul>\n</section>\n");
}

/// All that is needed to see the same session again.
pub fn provenance(out: &mut String, report: &Report) {
    let session = &report.session;
    super::section(out, "Noch einmal ansehen", "See it again");
    let _ = write!(
        out,
        "<p>{}</p>\n<p class=\"command\"><code>{}</code></p>\n</section>\n",
        bilingual(
            "Dieser Befehl berechnet die Sitzung erneut und vergleicht jedes Bit; mit --frames ORDNER zeichnet er sie als \
             Bilderfolge. Ein Klick wählt ihn ganz aus.",
            "This command computes the session again and compares every bit; with --frames FOLDER it draws it as a series \
             of pictures. One click selects all of it.",
        ),
        escape(&session.replay_command)
    );
    let _ = write!(
        out,
        "<footer>\n<h2>{}</h2>\n<dl>",
        bilingual("Herkunft", "Provenance")
    );
    let mut fact = |name: String, value: String| {
        let _ = writeln!(out, "<dt>{name}</dt><dd>{value}</dd>");
    };
    let code = |text: &str| format!("<code>{}</code>", escape(text));
    fact("MicroSim".into(), code(&session.version));
    fact(
        bilingual("Modul, Stufe", "Module, level"),
        format!("{} {}", code(&session.module), session.level),
    );
    fact(
        bilingual("Startwert", "Seed"),
        code(&session.seed.to_string()),
    );
    let mut tick = spans(&shown(session.tick_s * 1e3, "ms"));
    if session.realtime {
        let _ = write!(
            tick,
            ", {}; {}: {}",
            bilingual("in Echtzeit", "in real time"),
            bilingual("verspätete Takte", "late ticks"),
            session.late_ticks
        );
    }
    fact(bilingual("Takt (Zeitschritt)", "Tick (time step)"), tick);
    if let Some(error) = session.model_error {
        let off = shown((1e3 * error).ceil() / 10.0, "%");
        fact(
            bilingual("Genauigkeit des Gewebes", "Accuracy of the tissue"),
            bilingual(
                &format!(
                    "Unter kleiner Last verformt es sich um {} anders als dasselbe Gewebe auf einem sehr feinen Netz.",
                    off.de
                ),
                &format!(
                    "Under a small load it deforms by {} differently from the same tissue on a very fine mesh.",
                    off.en
                ),
            ),
        );
    }
    fact(
        bilingual("Zustandsprüfsumme", "State hash"),
        session.state_hash.as_deref().map_or_else(
            || bilingual("keine: kein sauberes Ende", "none: no clean end"),
            code,
        ),
    );
    fact(
        bilingual("Sitzungsdatei", "Session file"),
        code(&session.session_file),
    );
    let _ = write!(
        out,
        "</dl>\n<p>{}</p>\n</footer>\n",
        bilingual(
            "Dieselben Eingaben ergeben bei der Wiedergabe dieselben Zahlen bis aufs letzte Bit.",
            "Replayed, the same inputs give the same numbers to the last bit.",
        )
    );
}
