//! Drawings: SVG by hand, without scripts, fonts or references. Colours stand in [`STYLE`], which knows light and dark.

mod locking;
mod marker;
mod scatter;

pub use locking::{LockingCurve, SIZE as LOCKING_SIZE, locking_plot};
pub use marker::marker;
pub use scatter::{SIZE as SCATTER_SIZE, ScatterPoint, Zone, scatter};

use std::fmt::Write;

/// Style of the drawings, for a page or a drawing of its own.
pub const STYLE: &str = include_str!("drawing/style.css");

/// Number of colours of series in the style, and of forms of markers.
pub const SERIES: usize = 12;

/// Text for HTML and SVG.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

/// A logarithmic map from values to places.
#[derive(Clone, Copy, Debug)]
struct LogAxis {
    /// Decimal logarithms of the ends.
    values: (f64, f64),
    places: (f64, f64),
}

impl LogAxis {
    /// An axis that holds all of `values` that are finite and positive; `least` decades long.
    fn around(values: impl IntoIterator<Item = f64>, least: f64, places: (f64, f64)) -> Self {
        let mut ends = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|v| v.is_finite() && *v > 0.0) {
            let log = libm::log10(value);
            ends = (ends.0.min(log), ends.1.max(log));
        }
        if ends.0 > ends.1 {
            ends = (0.0, 0.0);
        }
        let (middle, half) = ((ends.0 + ends.1) / 2.0, (ends.1 - ends.0) / 2.0);
        // A little air, so that no marker lies on the frame.
        let half = (1.08 * half + 0.06).max(least / 2.0);
        Self {
            values: (middle - half, middle + half),
            places,
        }
    }

    /// Place of a value; what lies beyond the ends lies on them.
    fn at(&self, value: f64) -> f64 {
        let log = libm::log10(value).clamp(self.values.0, self.values.1);
        let share = (log - self.values.0) / (self.values.1 - self.values.0);
        self.places.0 + share * (self.places.1 - self.places.0)
    }

    /// Round values on the axis and whether each carries a number: powers of ten, thinned when there are many, with twos and
    /// fives between when there are few.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let decades = self.values.1 - self.values.0;
        let (first, last) = (self.values.0.floor() as i32, self.values.1.ceil() as i32);
        let every = if decades > 7.0 { 2 } else { 1 };
        let mut ticks = Vec::new();
        for power in first..=last {
            for factor in [1.0, 2.0, 5.0] {
                let value: f64 = format!("{factor}e{power}").parse().unwrap_or(f64::NAN);
                let log = libm::log10(value);
                if !(self.values.0..=self.values.1).contains(&log) {
                    continue;
                }
                let whole = factor == 1.0;
                let named = (whole && power % every == 0) || (!whole && decades <= 2.0);
                if whole || decades <= 4.0 {
                    ticks.push((value, named));
                }
            }
        }
        ticks
    }
}

/// A number on a logarithmic axis.
fn tick_text(value: f64) -> String {
    if (1e-4..1e5).contains(&value) {
        format!("{value}")
    } else {
        crate::number::significant(value, 1).replace("1·10", "10")
    }
}

/// A text at a place.
fn text(out: &mut String, (x, y): (f64, f64), class: &str, anchor: &str, content: &str) {
    let _ = write!(
        out,
        "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
        escape(content)
    );
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_holds_its_values_and_names_round_ones() {
        let axis = LogAxis::around([0.01, 1.0, f64::NAN, 0.0], 1.0, (0.0, 100.0));
        assert!(axis.at(0.01) > 0.0 && axis.at(1.0) < 100.0);
        assert_eq!(axis.at(1e-9), 0.0, "beyond the end is on the end");
        assert!((axis.at(0.1) - 50.0).abs() < 1e-9, "the middle decade");
        let named: Vec<f64> = axis.ticks().iter().filter(|t| t.1).map(|t| t.0).collect();
        assert_eq!(named, [0.01, 0.1, 1.0]);
        assert_eq!(tick_text(0.01), "0.01");
        assert_eq!(tick_text(1e-7), "10⁻⁷");
    }

    #[test]
    fn markup_is_escaped() {
        assert_eq!(escape("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
