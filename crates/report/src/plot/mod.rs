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

use crate::moment::{kind_class, line_kind, lines};
use crate::number::fixed;
use crate::text::in_both;
use crate::{Moment, Report};
use microsim_drawing::{Anchor, ValueAxis, escape, localised_text, text, value_range};
use microsim_message::LocalText;
use std::fmt::Write;

/// Most points that a drawing has of one series.
const MAX_POINTS: usize = 2000;
/// Width of a drawing over the whole page, in its own units; about a pixel each.
const WIDTH: f64 = 1000.0;
/// Ends of the time axis of such a drawing.
const LEFT: f64 = 52.0;
const RIGHT: f64 = 988.0;
/// Room above the first strip, and between two.
const ABOVE: f64 = 50.0;
const BETWEEN: f64 = 44.0;
/// Number of tool colours in the style sheet.
const COLOURS: usize = 4;

/// Class that gives the `k`-th tool its colour.
pub fn colour_class(k: usize) -> String {
    format!("tool-{}", k % COLOURS)
}

/// A number on an axis.
fn tick_label(out: &mut String, x: f64, y: f64, anchor: Anchor, value: f64, decimals: usize) {
    svg_text(out, (x, y), "tick", anchor, &fixed(value, decimals));
}

/// A text in both languages at a place.
fn svg_text(out: &mut String, place: (f64, f64), class: &str, anchor: Anchor, content: &LocalText) {
    if content.de == content.en {
        text(out, place, class, anchor, &content.en);
    } else {
        localised_text(out, "de", place, class, anchor, &content.de);
        localised_text(out, "en", place, class, anchor, &content.en);
    }
}

/// Opens a drawing with a title for those who cannot see it.
fn open(out: &mut String, width: f64, height: f64, title: &LocalText) {
    let _ = write!(
        out,
        "<svg viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\"><title>{}</title>",
        escape(&format!("{} / {}", title.en, title.de))
    );
}

/// Draws `count` strips of this height above each other, with one time axis and the moments across all of them. `times`
/// are those of the data; `strip` draws the one of a number, whose upper edge is given.
fn strips(
    report: &Report,
    title: &LocalText,
    (count, height): (usize, f64),
    times: impl Iterator<Item = f64>,
    mut strip: impl FnMut(&mut String, &ValueAxis, usize, f64),
) -> String {
    let end = report.simulated;
    let last = value_range(times).map_or(end, |(_, last)| last.max(end));
    let x = ValueAxis::new((0.0, if last > 0.0 { last } else { 1.0 }), (LEFT, RIGHT));
    let tops = count as f64 * (height + BETWEEN);
    let mut out = String::new();
    open(&mut out, WIDTH, ABOVE + tops - 4.0, title);
    for k in 0..count {
        strip(&mut out, &x, k, ABOVE + k as f64 * (height + BETWEEN));
    }
    let bottom = ABOVE + tops - BETWEEN;
    moment_marks(&mut out, &x, (ABOVE, bottom), &report.moments);
    time_label(&mut out, &x, bottom + 34.0);
    out.push_str("</svg>");
    out
}

/// The unit of a strip and the name of what it shows, above it.
fn strip_labels(out: &mut String, top: f64, unit: &str, colour: &str, name: &LocalText) {
    text(out, (LEFT - 7.0, top - 9.0), "label", Anchor::End, unit);
    let class = format!("name {colour}");
    svg_text(out, (LEFT, top - 8.0), &class, Anchor::Start, name);
}

/// Grid lines with numbers: values to the left of the area, times below it. `apart`: least distances of the lines along
/// both axes, in the units of the drawing.
fn grid(out: &mut String, x: &ValueAxis, y: &ValueAxis, apart: (f64, f64)) {
    let ((left, right), (bottom, top)) = (x.places, y.places);
    let rows = y.ticks(apart.1);
    for &value in &rows.values {
        let at = y.at(value);
        let _ = write!(
            out,
            "<path class=\"grid\" d=\"M{left:.1} {at:.1}H{right:.1}\"/>"
        );
        tick_label(out, left - 7.0, at + 4.0, Anchor::End, value, rows.decimals);
    }
    let columns = x.ticks(apart.0);
    for &value in &columns.values {
        let at = x.at(value);
        let _ = write!(
            out,
            "<path class=\"grid\" d=\"M{at:.1} {top:.1}V{bottom:.1}\"/>"
        );
        tick_label(
            out,
            at,
            bottom + 16.0,
            Anchor::Middle,
            value,
            columns.decimals,
        );
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
fn moment_marks(out: &mut String, x: &ValueAxis, (top, bottom): (f64, f64), moments: &[Moment]) {
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
fn time_label(out: &mut String, x: &ValueAxis, y: f64) {
    let text = in_both(
        "Zeit seit Beginn der Sitzung [s]",
        "time since the session began [s]",
    );
    svg_text(out, (x.places.1, y), "label", Anchor::End, &text);
}
