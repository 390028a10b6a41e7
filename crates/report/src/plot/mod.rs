//! Drawings of the page: inline SVG without scripts, fonts or references. Colours and line widths stand in the style
//! sheet of the page. Nothing is ever drawn across a gap.

mod force;
mod gauge;
mod path;
mod speed;
mod thin;

pub use force::force_plot;
pub use gauge::gauge;
pub use path::path_plots;
pub use speed::speed_plot;

use crate::Moment;
use crate::html::{escape, in_both, kind_class};
use crate::moment::{line_kind, lines};
use crate::number::{Ticks, fixed, ticks};
use microsim_message::LocalText;
use std::fmt::Write;

/// Most points that a drawing has of one series.
const MAX_POINTS: usize = 2000;
/// Width of a drawing over the whole page, in its own units; about a pixel each.
const WIDTH: f64 = 1000.0;
/// Number of tool colours in the style sheet.
const COLOURS: usize = 4;

/// Class that gives the `k`-th tool its colour.
pub fn colour_class(k: usize) -> String {
    format!("tool-{}", k % COLOURS)
}

/// A straight map from values to places in a drawing.
#[derive(Clone, Copy)]
struct Axis {
    values: (f64, f64),
    places: (f64, f64),
}

impl Axis {
    /// Ends of `values` must be finite and differ.
    fn new(values: (f64, f64), places: (f64, f64)) -> Self {
        Self { values, places }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value - self.values.0) / (self.values.1 - self.values.0);
        self.places.0 + share * (self.places.1 - self.places.0)
    }

    /// Round numbers along it, at least `apart` units of the drawing from each other.
    fn ticks(&self, apart: f64) -> Ticks {
        let (lo, hi) = self.values;
        let scale = (hi - lo) / (self.places.1 - self.places.0).abs();
        ticks(lo, hi, apart * scale)
    }
}

/// The smallest and the largest of the finite values.
fn range(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .into_iter()
        .filter(|value| value.is_finite())
        .fold(None, |range, value| match range {
            None => Some((value, value)),
            Some((lo, hi)) => Some((value.min(lo), value.max(hi))),
        })
}

/// 0 to a little above `largest`; never empty.
fn from_zero(largest: f64) -> (f64, f64) {
    (0.0, if largest > 0.0 { 1.05 * largest } else { 1.0 })
}

/// A number on an axis.
fn tick_label(out: &mut String, x: f64, y: f64, anchor: &str, value: f64, decimals: usize) {
    svg_text(out, (x, y), "tick", anchor, &fixed(value, decimals));
}

/// A text in both languages at a place.
fn svg_text(out: &mut String, (x, y): (f64, f64), class: &str, anchor: &str, text: &LocalText) {
    let mut one = |lang: &str, text: &str| {
        let _ = write!(
            out,
            "<text{lang} class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
            escape(text)
        );
    };
    if text.de == text.en {
        one("", &text.en);
    } else {
        one(" lang=\"de\"", &text.de);
        one(" lang=\"en\"", &text.en);
    }
}

/// A line through points, broken wherever the part changes; a part of one point is a dot. Numbers that are not finite
/// have no place.
fn line(points: impl IntoIterator<Item = (u32, f64, f64)>) -> String {
    let mut path = String::new();
    let mut part = None;
    for (of, x, y) in points {
        if !(x.is_finite() && y.is_finite()) {
            part = None;
        } else if part == Some(of) {
            let _ = write!(path, "L{x:.1} {y:.1}");
        } else {
            // The empty step makes a lone point visible: it gets the round ends of the line.
            let _ = write!(path, "M{x:.1} {y:.1}h0");
            part = Some(of);
        }
    }
    path
}

/// Opens a drawing with a title for those who cannot see it.
fn open(out: &mut String, width: f64, height: f64, title: &LocalText) {
    let _ = write!(
        out,
        "<svg viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\"><title>{}</title>",
        escape(&format!("{} / {}", title.en, title.de))
    );
}

/// Grid lines with numbers: values to the left of the area, times below it. `apart`: least distances of the lines along
/// both axes, in the units of the drawing.
fn grid(out: &mut String, x: &Axis, y: &Axis, apart: (f64, f64)) {
    let ((left, right), (bottom, top)) = (x.places, y.places);
    let rows = y.ticks(apart.1);
    for &value in &rows.values {
        let at = y.at(value);
        let _ = write!(
            out,
            "<path class=\"grid\" d=\"M{left:.1} {at:.1}H{right:.1}\"/>"
        );
        tick_label(out, left - 7.0, at + 4.0, "end", value, rows.decimals);
    }
    let columns = x.ticks(apart.0);
    for &value in &columns.values {
        let at = x.at(value);
        let _ = write!(
            out,
            "<path class=\"grid\" d=\"M{at:.1} {top:.1}V{bottom:.1}\"/>"
        );
        tick_label(out, at, bottom + 16.0, "middle", value, columns.decimals);
    }
    let _ = write!(
        out,
        "<path class=\"axis\" d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\"/>"
    );
}

/// Numbers of moments closer than this would overlap.
const NUMBER_WIDTH: f64 = 17.0;

/// Of the discs of numbers above the topmost strip, whose name stands between the two.
const NUMBERS_ABOVE: f64 = 32.0;

/// A line from top to bottom at the moments of each line of the list, and its number, from 1, above it where there is room.
fn moment_marks(out: &mut String, x: &Axis, (top, bottom): (f64, f64), moments: &[Moment]) {
    let middle = top - NUMBERS_ABOVE;
    let mut free_from = f64::NEG_INFINITY;
    for (k, line) in lines(moments).into_iter().enumerate() {
        let line = &moments[line];
        let at = x.at(line[0].session_time);
        let class = kind_class(line_kind(line));
        let _ = write!(
            out,
            "<path class=\"moment {class}\" d=\"M{at:.1} {middle:.1}V{bottom:.1}\"/>"
        );
        if at - NUMBER_WIDTH / 2.0 >= free_from {
            let _ = write!(
                out,
                "<circle class=\"moment-disc {class}\" cx=\"{at:.1}\" cy=\"{:.1}\" r=\"8\"/>\
                 <text class=\"moment-number\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                middle,
                middle + 3.8,
                k + 1
            );
            free_from = at + NUMBER_WIDTH / 2.0;
        }
    }
}

/// The label of a time axis.
fn time_label(out: &mut String, x: &Axis, y: f64) {
    let text = in_both(
        "Zeit seit Beginn der Sitzung [s]",
        "time since the session began [s]",
    );
    svg_text(out, (x.places.1, y), "label", "end", &text);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_breaks_between_parts_and_at_nan() {
        let points = [
            (0, 0.0, 0.0),
            (0, 1.0, 1.0),
            (1, 2.0, 2.0),
            (1, f64::NAN, 3.0),
            (1, 4.0, 4.0),
        ];
        assert_eq!(line(points), "M0.0 0.0h0L1.0 1.0M2.0 2.0h0M4.0 4.0h0");
    }

    #[test]
    fn ranges() {
        assert_eq!(range([2.0, f64::NAN, -1.0]), Some((-1.0, 2.0)));
        assert_eq!(range([f64::INFINITY]), None);
        assert_eq!(from_zero(0.0), (0.0, 1.0));
    }
}
