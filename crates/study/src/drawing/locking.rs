//! Error over Poisson's ratio: what nearly incompressible tissue does to each discretisation.

use super::marker;
use microsim_drawing::{Anchor, LogAxis, broken_line, percent, text};
use std::fmt::Write;

/// A discretisation over Poisson's ratio.
#[derive(Clone, Debug)]
pub struct LockingCurve {
    /// Its series: colour and form.
    pub series: usize,
    /// Poisson's ratio and relative error, by ascending ratio.
    pub points: Vec<(f64, f64)>,
    /// Text shown when it is pointed at.
    pub tip: String,
}

/// Size of one drawing.
pub const SIZE: (f64, f64) = (340.0, 278.0);
const LEFT: f64 = 52.0;
const RIGHT: f64 = 312.0;
const TOP: f64 = 42.0;
const BOTTOM: f64 = 230.0;
/// The error at which a line is drawn.
const LIMIT: f64 = 0.05;

/// One of several small drawings; all have the same range of errors, so that they can be compared.
pub fn locking_plot(
    out: &mut String,
    [title, mesh]: [&str; 2],
    curves: &[LockingCurve],
    errors: &[f64],
) {
    let mut ratios: Vec<f64> = curves.iter().flat_map(|c| &c.points).map(|p| p.0).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.dedup();
    // The ratios stand at equal distances: between 0.45 and 0.49 lies most of what happens.
    let across = |ratio: f64| {
        let index = ratios.iter().position(|r| *r == ratio).unwrap_or(0);
        let step = (RIGHT - LEFT - 40.0) / (ratios.len().max(2) - 1) as f64;
        LEFT + 20.0 + step * index as f64
    };
    let percents = errors.iter().map(|e| 100.0 * e.max(1e-5)).chain([5.0]);
    let up = LogAxis::around(percents, 2.0, (BOTTOM, TOP));
    text(out, (LEFT, 15.0), "heading", Anchor::Start, title);
    text(out, (LEFT, 31.0), "label", Anchor::Start, mesh);
    for (value, named) in up.ticks() {
        let y = up.at(value);
        let _ = write!(out, "<path class=\"rule\" d=\"M{LEFT} {y:.1}H{RIGHT}\"/>");
        if named {
            text(
                out,
                (LEFT - 6.0, y + 4.0),
                "tick",
                Anchor::End,
                &LogAxis::label(value),
            );
        }
    }
    for ratio in &ratios {
        let x = across(*ratio);
        let _ = write!(out, "<path class=\"rule\" d=\"M{x:.1} {TOP}V{BOTTOM}\"/>");
        text(
            out,
            (x, BOTTOM + 16.0),
            "tick",
            Anchor::Middle,
            &ratio.to_string(),
        );
    }
    let limit = up.at(100.0 * LIMIT);
    let _ = write!(
        out,
        "<path class=\"frame\" d=\"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}\"/>\
         <path class=\"limit\" d=\"M{LEFT} {limit:.1}H{RIGHT}\"/>"
    );
    text(
        out,
        (RIGHT + 4.0, limit + 4.0),
        "limit-text",
        Anchor::Start,
        "5 %",
    );
    let middle = (LEFT + RIGHT) / 2.0;
    text(
        out,
        (middle, BOTTOM + 36.0),
        "label",
        Anchor::Middle,
        "Poisson’s ratio",
    );
    let _ = write!(
        out,
        "<text class=\"label\" transform=\"translate(11 {:.1}) rotate(-90)\" text-anchor=\"middle\">error [%]</text>",
        (TOP + BOTTOM) / 2.0
    );
    for curve in curves {
        let places: Vec<(f64, f64)> = curve
            .points
            .iter()
            .map(|(ratio, error)| (across(*ratio), up.at(100.0 * error.max(1e-5))))
            .collect();
        let path = broken_line(places.iter().map(|&(x, y)| (0, x, y)));
        let series = curve.series % super::SERIES;
        let dashed = if curve.series >= super::SERIES {
            " dashed"
        } else {
            ""
        };
        let _ = write!(
            out,
            "<path class=\"curve series-{series}{dashed}\" d=\"{path}\"/>"
        );
        for ((ratio, error), at) in curve.points.iter().zip(&places) {
            let tip = format!("{}, ν = {ratio}: error {}", curve.tip, percent(*error));
            marker(out, curve.series, *at, 4.0, "", &tip);
        }
    }
}
