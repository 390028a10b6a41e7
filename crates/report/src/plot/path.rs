//! Where the tips went in the field: from above (x to the right, y up) and from the side (x to the right, z up). One scale
//! for all axes, so that lengths and angles are true.

use super::{MAX_POINTS, colour_class, grid, open, svg_text, thin};
use crate::ToolSeries;
use crate::text::in_both;
use microsim_drawing::{Anchor, ValueAxis, broken_line, value_range};
use microsim_message::LocalText;
use std::fmt::Write;

const WIDTH: f64 = 490.0;
const LEFT: f64 = 50.0;
const RIGHT: f64 = 478.0;
const ABOVE: f64 = 24.0;
const BELOW: f64 = 40.0;
/// Least distance of grid lines.
const APART: f64 = 42.0;
const LEAST_HEIGHT: f64 = 150.0;
const MOST_HEIGHT: f64 = 380.0;

/// The two views, or `None` if no tool was ever tracked.
pub fn path_plots(series: &[ToolSeries]) -> Option<[String; 2]> {
    let along = |axis: usize| {
        let positions = series.iter().flat_map(|s| &s.position);
        value_range(positions.map(|position| position[axis] * 1e3))
    };
    let [x, y, z] = [along(0)?, along(1)?, along(2)?];
    let extent = |(lo, hi): (f64, f64)| hi - lo;
    // A little air around the paths; a tool that stood still gets a millimetre around it.
    let widest = extent(x).max(extent(y)).max(extent(z));
    let air = if widest > 0.0 { 0.08 * widest } else { 1.0 };
    let scale =
        ((RIGHT - LEFT) / (extent(x) + air)).min(MOST_HEIGHT / (extent(y).max(extent(z)) + air));
    let view = |axis: usize, vertical: (f64, f64), name: &str, title: LocalText| {
        let height = ((extent(vertical) + air) * scale).max(LEAST_HEIGHT);
        let around = |(lo, hi): (f64, f64), pixels: f64| {
            let (middle, half) = ((lo + hi) / 2.0, pixels / scale / 2.0);
            (middle - half, middle + half)
        };
        let x = ValueAxis::new(around(x, RIGHT - LEFT), (LEFT, RIGHT));
        let y = ValueAxis::new(around(vertical, height), (ABOVE + height, ABOVE));
        draw(series, axis, &x, &y, name, &title)
    };
    Some([
        view(
            1,
            y,
            "y",
            in_both(
                "Ansicht von oben: Wege in x und y",
                "Top view: paths in x and y",
            ),
        ),
        view(
            2,
            z,
            "z",
            in_both(
                "Ansicht von der Seite: Wege in x und z",
                "Side view: paths in x and z",
            ),
        ),
    ])
}

fn draw(
    series: &[ToolSeries],
    axis: usize,
    x: &ValueAxis,
    y: &ValueAxis,
    name: &str,
    title: &LocalText,
) -> String {
    let bottom = y.places.0;
    let mut out = String::new();
    open(&mut out, WIDTH, bottom + BELOW, title);
    grid(&mut out, x, y, (APART, APART));
    let label = |text: &str| LocalText::new(text.to_owned(), text.to_owned());
    svg_text(
        &mut out,
        (RIGHT, bottom + 33.0),
        "label",
        Anchor::End,
        &label("x [mm]"),
    );
    let above = label(&format!("{name} [mm]"));
    svg_text(
        &mut out,
        (LEFT, ABOVE - 9.0),
        "label",
        Anchor::Middle,
        &above,
    );
    for (k, series) in series.iter().enumerate() {
        let place = |i: usize| {
            let position = series.position[i];
            (x.at(position[0] * 1e3), y.at(position[axis] * 1e3))
        };
        let chosen = thin::evenly(series.position.len(), MAX_POINTS);
        let drawn = chosen.iter().map(|&i| {
            let (px, py) = place(i);
            (series.segment[i], px, py)
        });
        let colour = colour_class(k);
        let _ = write!(
            out,
            "<path class=\"trail {colour}\" d=\"{}\"/>",
            broken_line(drawn)
        );
    }
    // Above all lines: where each tool began (ring) and ended (square).
    for (k, series) in series.iter().enumerate() {
        let place = |position: &[f64; 3]| (x.at(position[0] * 1e3), y.at(position[axis] * 1e3));
        let (Some(first), Some(last)) = (series.position.first(), series.position.last()) else {
            continue;
        };
        let colour = colour_class(k);
        let ((ax, ay), (bx, by)) = (place(first), place(last));
        let _ = write!(
            out,
            "<circle class=\"start {colour}\" cx=\"{ax:.1}\" cy=\"{ay:.1}\" r=\"5\"/>\
             <rect class=\"end {colour}\" x=\"{:.1}\" y=\"{:.1}\" width=\"9\" height=\"9\"/>",
            bx - 4.5,
            by - 4.5
        );
    }
    out.push_str("</svg>");
    out
}
