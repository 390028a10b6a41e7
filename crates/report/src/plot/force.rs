//! Contact force over time, one strip for each pair of tool and body.

use super::{MAX_POINTS, colour_class, grid, strip_labels, strips, thin};
use crate::text::in_both;
use crate::{ForceSeries, Report};
use microsim_drawing::{ValueAxis, broken_line, value_range};
use microsim_message::LocalText;
use std::fmt::Write;

/// Height of the strip of a pair.
const STRIP: f64 = 110.0;

/// Draws each pair over the session and marks the moments.
pub fn force_plot(report: &Report) -> String {
    let session = &report.session;
    let forces: Vec<ForceSeries> = report.forces.iter().map(ForceSeries::meaningful).collect();
    let title = in_both("Kontaktkraft über der Zeit", "Contact force over time");
    let times = forces.iter().flat_map(|s| s.time.iter().copied());
    strips(
        report,
        &title,
        (forces.len(), STRIP),
        times,
        |out, x, k, top| {
            let series = &forces[k];
            // Blades that close do not grip.
            let sharp = session.sharp.contains(&series.tool);
            let grip =
                (!sharp && series.grip.iter().any(|grip| *grip > 0.0)).then_some(&series.grip);
            let place = report.series.iter().position(|s| s.tool == series.tool);
            let colour = colour_class(place.unwrap_or(report.series.len()));
            let (tool, body) = (
                session.tool_name(&series.tool),
                session.body_name(&series.body),
            );
            let name = in_both(
                &format!("{} → {}", tool.de, body.de),
                &format!("{} → {}", tool.en, body.en),
            );
            strip(out, x, top, (series, grip), &colour, &name);
        },
    )
}

fn strip(
    out: &mut String,
    x: &ValueAxis,
    top: f64,
    (series, grip): (&ForceSeries, Option<&Vec<f64>>),
    colour: &str,
    name: &LocalText,
) {
    let bottom = top + STRIP;
    let all = series.peak.iter().chain(&series.force);
    let all = all.chain(grip.into_iter().flatten());
    let largest = value_range(all.copied()).map_or(0.0, |(_, largest)| largest);
    // Millinewtons up to a newton.
    let (factor, unit) = if largest < 1.0 {
        (1e3, "mN")
    } else {
        (1.0, "N")
    };
    let y = ValueAxis::from_zero(largest * factor, (bottom, top));
    grid(out, x, &y, (70.0, 26.0));
    let lines = match series.has_sustained() {
        true => [("peak", &series.force), ("curve", &series.sustained)],
        false => [("peak", &series.peak), ("curve", &series.force)],
    };
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
            broken_line(drawn)
        );
    }
    strip_labels(out, top, unit, colour, name);
}
