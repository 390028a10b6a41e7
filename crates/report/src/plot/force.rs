//! Contact force over time, one strip for each pair of tool and body.

use super::{
    Axis, MAX_POINTS, WIDTH, colour_class, from_zero, grid, line, moment_marks, open, range,
    svg_text, thin, time_label,
};
use crate::html::in_both;
use crate::{ForceSeries, Report};
use microsim_message::LocalText;
use std::fmt::Write;

const LEFT: f64 = 52.0;
const RIGHT: f64 = 988.0;
const ABOVE: f64 = 50.0;
const STRIP: f64 = 110.0;
const BETWEEN: f64 = 44.0;

/// Draws each pair over the session and marks the moments.
pub fn force_plot(report: &Report) -> String {
    let (forces, end) = (&report.forces, report.simulated);
    let place = |tool: &str| report.series.iter().position(|s| s.tool == tool);
    let last = range(forces.iter().flat_map(|s| s.time.iter().copied()))
        .map_or(end, |(_, last)| last.max(end));
    let x = Axis::new((0.0, if last > 0.0 { last } else { 1.0 }), (LEFT, RIGHT));
    let height = ABOVE + forces.len() as f64 * (STRIP + BETWEEN) - 4.0;
    let mut out = String::new();
    let title = in_both("Kontaktkraft über der Zeit", "Contact force over time");
    open(&mut out, WIDTH, height, &title);
    for (k, series) in forces.iter().enumerate() {
        let top = ABOVE + k as f64 * (STRIP + BETWEEN);
        // Blades that close do not grip.
        let sharp = report.session.sharp.contains(&series.tool);
        let grip = (!sharp && series.grip.iter().any(|grip| *grip > 0.0)).then_some(&series.grip);
        strip(
            &mut out,
            &x,
            top,
            (series, grip),
            &colour_class(place(&series.tool).unwrap_or(report.series.len())),
            &report.session.tool_name(&series.tool),
            &report.session.body_name(&series.body),
        );
    }
    let bottom = ABOVE + forces.len() as f64 * (STRIP + BETWEEN) - BETWEEN;
    moment_marks(&mut out, &x, (ABOVE, bottom), &report.moments);
    time_label(&mut out, &x, bottom + 34.0);
    out.push_str("</svg>");
    out
}

fn strip(
    out: &mut String,
    x: &Axis,
    top: f64,
    (series, grip): (&ForceSeries, Option<&Vec<f64>>),
    colour: &str,
    tool: &LocalText,
    body: &LocalText,
) {
    let bottom = top + STRIP;
    let all = series.peak.iter().chain(&series.force);
    let all = all.chain(grip.into_iter().flatten());
    let largest = range(all.copied()).map_or(0.0, |(_, largest)| largest);
    // Millinewtons up to a newton.
    let (factor, unit) = if largest < 1.0 {
        (1e3, "mN")
    } else {
        (1.0, "N")
    };
    let y = Axis::new(from_zero(largest * factor), (bottom, top));
    grid(out, x, &y, (70.0, 26.0));
    let lines = [("peak", &series.peak), ("curve", &series.force)];
    let grip = grip.map(|grip| ("grip", grip));
    for (class, values) in lines.into_iter().chain(grip) {
        let drawn = thin::extremes(values, MAX_POINTS).into_iter().map(|i| {
            (
                series.contact[i],
                x.at(series.time[i]),
                y.at(values[i] * factor),
            )
        });
        let _ = write!(
            out,
            "<path class=\"{class} {colour}\" d=\"{}\"/>",
            line(drawn)
        );
    }
    svg_text(
        out,
        (LEFT - 7.0, top - 9.0),
        "label",
        "end",
        &in_both(unit, unit),
    );
    let name = in_both(
        &format!("{} → {}", tool.de, body.de),
        &format!("{} → {}", tool.en, body.en),
    );
    let class = format!("name {colour}");
    svg_text(out, (LEFT, top - 8.0), &class, "start", &name);
}
