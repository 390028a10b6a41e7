//! A value beside its limit at a glance: a bar on which the allowed part is marked.

use crate::MetricEntry;
use microsim_drawing::{ValueAxis, value_range};
use std::fmt::Write;

const WIDTH: f64 = 130.0;

/// The bar, or nothing for a metric without value or limit.
pub fn gauge(metric: &MetricEntry) -> String {
    let (Some(value), Some(within)) = (metric.display_value, metric.record.within) else {
        return String::new();
    };
    if !value.is_finite() {
        return String::new();
    }
    let limits = [metric.display_min, metric.display_max];
    let shown = [Some(0.0), Some(value)].into_iter().chain(limits).flatten();
    let Some((lo, hi)) = value_range(shown).filter(|(lo, hi)| lo < hi) else {
        return String::new();
    };
    // Room for the mark at either end, and for what is allowed beyond the limit.
    let room = 0.12 * (hi - lo);
    let x = ValueAxis::new(
        (
            if lo < 0.0 { lo - room } else { lo },
            if hi > 0.0 { hi + room } else { hi },
        ),
        (4.0, WIDTH - 4.0),
    );
    let place = |limit: Option<f64>, end: f64| limit.map_or(end, |limit| x.at(limit));
    let (from, to) = (place(limits[0], x.places.0), place(limits[1], x.places.1));
    let mut out = format!(
        "<svg class=\"gauge\" viewBox=\"0 0 {WIDTH:.0} 16\" aria-hidden=\"true\">\
         <rect class=\"track\" x=\"4\" y=\"5\" width=\"{:.0}\" height=\"6\" rx=\"3\"/>\
         <rect class=\"allowed\" x=\"{from:.1}\" y=\"5\" width=\"{:.1}\" height=\"6\" rx=\"3\"/>",
        WIDTH - 8.0,
        (to - from).max(0.0)
    );
    for limit in limits.into_iter().flatten() {
        let at = x.at(limit);
        let _ = write!(out, "<path class=\"limit\" d=\"M{at:.1} 2V14\"/>");
    }
    let (at, class) = (x.at(value), if within { "good" } else { "bad" });
    let _ = write!(
        out,
        "<circle class=\"{class}\" cx=\"{at:.1}\" cy=\"8\" r=\"4.5\"/></svg>"
    );
    out
}
