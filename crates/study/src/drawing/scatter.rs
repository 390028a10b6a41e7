//! Error against CPU time: one point per run, both axes logarithmic.

use super::{Area, marker};
use microsim_drawing::{Anchor, LogAxis, text};
use std::fmt::Write;

/// Where a point belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zone {
    /// By its error.
    Inside,
    /// Above the scale: it diverged.
    Diverged,
    /// Above the scale: it was cut off.
    OverBudget,
}

/// A run in the drawing.
#[derive(Clone, Debug)]
pub struct ScatterPoint {
    /// CPU time per simulated time.
    pub cost: f64,
    /// Relative error; of no meaning outside [`Zone::Inside`].
    pub error: f64,
    /// Its series: colour and form.
    pub series: usize,
    /// From 0: the coarsest mesh and the smallest marker.
    pub size: usize,
    /// Whether only the outline is drawn.
    pub hollow: bool,
    /// Whether it is drawn in the colour of the dissertation's methods.
    pub dissertation: bool,
    /// Text shown when it is pointed at.
    pub tip: String,
    /// Where it belongs.
    pub zone: Zone,
}

/// Size of the drawing.
pub const SIZE: (f64, f64) = (520.0, 430.0);
const LEFT: f64 = 84.0;
const RIGHT: f64 = 482.0;
const TOP: f64 = 52.0;
const BOTTOM: f64 = 386.0;
/// Height of a row above the scale.
const ROW: f64 = 17.0;
/// Errors below this are drawn on the lower edge: they are round-off.
const LEAST_ERROR: f64 = 1e-6;
/// The error at which a line is drawn.
const LIMIT: f64 = 0.03;
const NUMBER_RADIUS: f64 = 8.0;

/// A drawing with its upper left corner at `x`; `front` are the points of the Pareto front by ascending cost.
pub fn scatter(out: &mut String, x: f64, heading: &str, points: &[ScatterPoint], front: &[usize]) {
    let _ = write!(out, "<g transform=\"translate({x:.0} 0)\">");
    text(out, (LEFT, 18.0), "heading", Anchor::Start, heading);
    let rows: Vec<(Zone, &str)> = [
        (Zone::Diverged, "diverged"),
        (Zone::OverBudget, "over budget"),
    ]
    .into_iter()
    .filter(|(zone, _)| points.iter().any(|p| p.zone == *zone))
    .collect();
    let top = TOP + ROW * rows.len() as f64;
    let inside = || points.iter().filter(|p| p.zone == Zone::Inside);
    let costs = points.iter().map(|p| p.cost).chain([1.0]);
    let across = LogAxis::around(costs, 1.0, (LEFT, RIGHT));
    let percents = inside().map(|p| 100.0 * p.error.max(LEAST_ERROR));
    let percents = percents.chain([100.0 * LIMIT]);
    let up = LogAxis::around(percents, 2.0, (BOTTOM, top));

    frame(out, &across, &up, top, &rows);
    for (zone, point) in points.iter().map(|p| (p.zone, p)) {
        let at = place(&across, &up, &rows, zone, point);
        // The hit area stays large enough to point at.
        let radius = 3.6 + 1.3 * point.size as f64;
        let class = match (point.hollow, point.dissertation) {
            (false, false) => "",
            (true, false) => "hollow",
            (false, true) => "dissertation",
            (true, true) => "hollow dissertation",
        };
        marker(out, point.series, at, radius, class, &point.tip);
    }
    let places: Vec<(f64, f64)> = front
        .iter()
        .map(|&index| place(&across, &up, &rows, Zone::Inside, &points[index]))
        .collect();
    steps(out, &places);
    numbers(out, &places, top);
    out.push_str("</g>");
}

fn place(
    across: &LogAxis,
    up: &LogAxis,
    rows: &[(Zone, &str)],
    zone: Zone,
    point: &ScatterPoint,
) -> (f64, f64) {
    let x = across.at(point.cost);
    match rows.iter().position(|(row, _)| *row == zone) {
        Some(row) => (x, TOP + ROW * (row as f64 + 0.5)),
        None => (x, up.at(100.0 * point.error.max(LEAST_ERROR))),
    }
}

fn frame(out: &mut String, across: &LogAxis, up: &LogAxis, top: f64, rows: &[(Zone, &str)]) {
    let (real, limit) = (across.at(1.0), up.at(100.0 * LIMIT));
    let _ = write!(
        out,
        "<rect class=\"good\" x=\"{LEFT}\" y=\"{limit:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
        real - LEFT,
        BOTTOM - limit
    );
    for (row, (_, name)) in rows.iter().enumerate() {
        let y = TOP + ROW * row as f64;
        let _ = write!(
            out,
            "<rect class=\"strip\" x=\"{LEFT}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
            y + 0.5,
            RIGHT - LEFT,
            ROW - 1.0
        );
        text(out, (LEFT - 7.0, y + 12.5), "tick", Anchor::End, name);
    }
    let area = Area {
        left: LEFT,
        right: RIGHT,
        top: TOP,
        bottom: BOTTOM,
    };
    for (value, named) in across.ticks() {
        let label = LogAxis::label(value);
        area.column(out, across.at(value), named.then_some(&label));
    }
    for (value, named) in up.ticks() {
        let (y, label) = (up.at(value), LogAxis::label(value));
        // Not into the name of a row.
        let below = if rows.is_empty() {
            4.0
        } else {
            4.0f64.max(top + 12.0 - y)
        };
        area.row(out, y, named.then_some((below, &label)));
    }
    let _ = write!(
        out,
        "<path class=\"real\" d=\"M{real:.1} {TOP}V{BOTTOM}\"/>"
    );
    // Outside the area, where no point can be.
    text(
        out,
        (real, TOP - 6.0),
        "real-text",
        Anchor::Middle,
        "real time",
    );
    area.frame(
        out,
        (limit, "3 %"),
        "CPU seconds per simulated second",
        15.0,
    );
}

/// The front as stairs: at each cost the smallest error that can be had.
fn steps(out: &mut String, places: &[(f64, f64)]) {
    let Some((first, rest)) = places.split_first() else {
        return;
    };
    let mut path = format!("M{:.1} {:.1}", first.0, first.1);
    for (x, y) in rest {
        let _ = write!(path, "H{x:.1}V{y:.1}");
    }
    let _ = write!(path, "H{RIGHT}");
    let _ = write!(out, "<path class=\"front\" d=\"{path}\"/>");
}

/// Numbers beside the points of the front, where they cover neither each other nor points of the front.
fn numbers(out: &mut String, points: &[(f64, f64)], top: f64) {
    let distance = |a: (f64, f64), b: (f64, f64)| {
        ((a.0 - b.0) * (a.0 - b.0) + (a.1 - b.1) * (a.1 - b.1)).sqrt()
    };
    let mut placed: Vec<(f64, f64)> = Vec::new();
    for (k, &(x, y)) in points.iter().enumerate() {
        // Rings of places around the point, the nearest and the lower left ones first.
        let candidates = [17.0, 26.0, 38.0].into_iter().flat_map(|reach| {
            (0..12).map(move |turn| {
                let angle = std::f64::consts::TAU * (f64::from(turn) / 12.0 + 0.375);
                (x + reach * libm::cos(angle), y + reach * libm::sin(angle))
            })
        });
        let free = |at: &(f64, f64)| {
            let margin = NUMBER_RADIUS + 1.0;
            let inside = (LEFT + margin..RIGHT - margin).contains(&at.0)
                && (top + margin..BOTTOM - margin).contains(&at.1);
            inside
                && placed
                    .iter()
                    .all(|other| distance(*at, *other) > 2.0 * margin)
                && points
                    .iter()
                    .all(|other| distance(*at, *other) > margin + 5.0)
        };
        let Some(at) = candidates.into_iter().find(free) else {
            continue;
        };
        placed.push(at);
        let _ = write!(
            out,
            "<path class=\"leader\" d=\"M{x:.1} {y:.1}L{:.1} {:.1}\"/>\
             <circle class=\"number\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{NUMBER_RADIUS}\"/>",
            at.0, at.1, at.0, at.1
        );
        let label = (k + 1).to_string();
        text(
            out,
            (at.0, at.1 + 4.0),
            "number-text",
            Anchor::Middle,
            &label,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Centres of the number discs in a drawing.
    fn discs(svg: &str) -> Vec<(f64, f64)> {
        let number = |text: &str, key: &str| -> f64 {
            let from = text.find(key).expect(key) + key.len();
            let rest = &text[from..];
            rest[..rest.find('"').expect("closed")]
                .parse()
                .expect("a number")
        };
        svg.split("<circle class=\"number\"")
            .skip(1)
            .map(|part| (number(part, "cx=\""), number(part, "cy=\"")))
            .collect()
    }

    #[test]
    fn numbers_never_cover_each_other() {
        // A front as dense as the drawing could get: points 3 units apart.
        let front: Vec<(f64, f64)> = (0..12)
            .map(|k| (200.0 + 3.0 * f64::from(k), 150.0 + 3.0 * f64::from(k)))
            .collect();
        let mut svg = String::new();
        numbers(&mut svg, &front, TOP);
        let discs = discs(&svg);
        assert!(discs.len() >= 6, "{}", discs.len());
        for (i, a) in discs.iter().enumerate() {
            for b in &discs[..i] {
                let apart = ((a.0 - b.0).powi(2) + (a.1 - b.1).powi(2)).sqrt();
                assert!(apart > 2.0 * NUMBER_RADIUS, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn a_run_that_diverged_is_drawn_above_the_scale() {
        let point = |zone, error| ScatterPoint {
            cost: 2.0,
            error,
            series: 0,
            size: 0,
            hollow: false,
            dissertation: false,
            tip: format!("{zone:?}"),
            zone,
        };
        let points = [
            point(Zone::Inside, 0.05),
            point(Zone::Diverged, f64::NAN),
            point(Zone::OverBudget, f64::NAN),
        ];
        let mut svg = String::new();
        scatter(&mut svg, 0.0, "", &points, &[0]);
        for tip in ["Inside", "Diverged", "OverBudget"] {
            assert!(svg.contains(&format!("<title>{tip}</title>")));
        }
        assert!(svg.contains(">diverged<") && svg.contains(">over budget<"));
        assert!(!svg.contains("NaN"), "{svg}");
    }

    /// An error of 95 % makes 100 the highest number of the scale, right below the row of what diverged.
    #[test]
    fn numbers_of_the_scale_keep_clear_of_the_rows() {
        let mut out = String::new();
        let top = TOP + ROW;
        let up = LogAxis::around([1.0, 95.0], 2.0, (BOTTOM, top));
        let across = LogAxis::around([0.1, 1.0], 1.0, (LEFT, RIGHT));
        frame(&mut out, &across, &up, top, &[(Zone::Diverged, "diverged")]);
        let baseline = |label: &str| -> f64 {
            let (before, _) = out.split_once(&format!(">{label}<")).expect("a label");
            let (_, y) = before.rsplit_once(" y=\"").expect("a place");
            y.split('"').next().unwrap().parse().unwrap()
        };
        assert!(baseline("100") >= baseline("diverged") + 11.0, "{out}");
    }
}
