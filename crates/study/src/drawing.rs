//! Drawings: SVG by hand, without scripts, fonts or references. Colours stand in [`STYLE`], which knows light and dark.

mod locking;
mod marker;
mod scatter;

pub use locking::{LockingCurve, SIZE as LOCKING_SIZE, locking_plot};
pub use marker::marker;
pub use scatter::{SIZE as SCATTER_SIZE, ScatterPoint, Zone, scatter};

use microsim_drawing::{Anchor, escape, text};
use std::fmt::Write;

/// Style of the drawings, for a page or a drawing of its own.
pub const STYLE: &str = include_str!("drawing/style.css");

/// Number of colours of series in the style, and of forms of markers.
pub const SERIES: usize = 12;

/// The area between the axes of a drawing.
struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Area {
    /// A line across at the height of a value, and its label at `label` from the line if it has one.
    fn row(&self, out: &mut String, y: f64, label: Option<(f64, &str)>) {
        let Self { left, right, .. } = self;
        let _ = write!(out, "<path class=\"rule\" d=\"M{left} {y:.1}H{right}\"/>");
        if let Some((below, label)) = label {
            text(out, (left - 7.0, y + below), "tick", Anchor::End, label);
        }
    }

    /// A line upwards at the place of a value, and its label if it has one.
    fn column(&self, out: &mut String, x: f64, label: Option<&str>) {
        let Self { top, bottom, .. } = self;
        let _ = write!(out, "<path class=\"rule\" d=\"M{x:.1} {top}V{bottom}\"/>");
        if let Some(label) = label {
            text(out, (x, bottom + 16.0), "tick", Anchor::Middle, label);
        }
    }

    /// The frame, a dashed line at the height of a limit with its text beside it, and the names of both axes; that of the
    /// errors at `names_at`.
    fn frame(
        &self,
        out: &mut String,
        (limit, text_of_limit): (f64, &str),
        across: &str,
        names_at: f64,
    ) {
        let Self {
            left,
            right,
            top,
            bottom,
        } = self;
        let _ = write!(
            out,
            "<path class=\"frame\" d=\"M{left} {top}V{bottom}H{right}\"/>\
             <path class=\"limit\" d=\"M{left} {limit:.1}H{right}\"/>"
        );
        let beside = (right + 4.0, limit + 4.0);
        text(out, beside, "limit-text", Anchor::Start, text_of_limit);
        let below = ((left + right) / 2.0, bottom + 36.0);
        text(out, below, "label", Anchor::Middle, across);
        let _ = write!(
            out,
            "<text class=\"label\" transform=\"translate({names_at:.0} {:.1}) rotate(-90)\" text-anchor=\"middle\">error [%]</text>",
            (top + bottom) / 2.0
        );
    }
}

/// A complete drawing: `body` on an area of this size, with its own style when it stands alone.
pub fn document(width: f64, height: f64, title: &str, body: &str, alone: bool) -> String {
    let style = if alone {
        format!(
            "<style>{STYLE}</style><rect class=\"ground\" width=\"{width:.0}\" height=\"{height:.0}\"/>"
        )
    } else {
        String::new()
    };
    let space = if alone {
        " xmlns=\"http://www.w3.org/2000/svg\""
    } else {
        ""
    };
    format!(
        "<svg{space} class=\"drawing\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\"><title>{}</title>{style}{body}</svg>",
        escape(title)
    )
}
