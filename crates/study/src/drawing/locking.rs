//! Error over Poisson's ratio: what nearly incompressible tissue does to each discretisation.

use super::{Area, marker};
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
    let area = Area {
        left: LEFT,
        right: RIGHT,
        top: TOP,
        bottom: BOTTOM,
    };
    for (value, named) in up.ticks() {
        let label = LogAxis::label(value);
        area.row(out, up.at(value), named.then_some((4.0, &label)));
    }
    for ratio in &ratios {
        area.column(out, across(*ratio), Some(&ratio.to_string()));
    }
    let limit = (up.at(100.0 * LIMIT), "5 %");
    area.frame(out, limit, "Poisson’s ratio", 11.0);
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
