//! Speed of the tools over time, one strip for each, with gaps and events.

use super::{
    Axis, MAX_POINTS, WIDTH, colour_class, from_zero, grid, line, moment_marks, open, range,
    svg_text, thin, time_label,
};
use crate::html::in_both;
use crate::{Report, ToolSeries};
use microsim_message::LocalText;
use std::fmt::Write;

const LEFT: f64 = 52.0;
const RIGHT: f64 = 988.0;
const ABOVE: f64 = 50.0;
const STRIP: f64 = 130.0;
const BETWEEN: f64 = 44.0;
/// What the bold line averages over \[s\].
const MEAN_WINDOW: f64 = 0.5;

/// Draws the speed of each tool over the session and marks the moments by their numbers, from 1.
pub fn speed_plot(report: &Report) -> String {
    let (series, end) = (&report.series, report.simulated);
    let height = ABOVE + series.len() as f64 * (STRIP + BETWEEN) - 4.0;
    let last = range(series.iter().flat_map(|s| s.time.iter().copied()))
        .map_or(end, |(_, last)| last.max(end));
    let x = Axis::new((0.0, if last > 0.0 { last } else { 1.0 }), (LEFT, RIGHT));
    let mut out = String::new();
    let title = in_both(
        "Geschwindigkeit der Instrumente über der Zeit",
        "Speed of the instruments over time",
    );
    open(&mut out, WIDTH, height, &title);
    for (k, series) in series.iter().enumerate() {
        let top = ABOVE + k as f64 * (STRIP + BETWEEN);
        let name = report.session.tool_name(&series.tool);
        strip(&mut out, &x, top, series, (k, &name));
    }
    let bottom = ABOVE + series.len() as f64 * (STRIP + BETWEEN) - BETWEEN;
    moment_marks(&mut out, &x, (ABOVE, bottom), &report.moments);
    time_label(&mut out, &x, bottom + 34.0);
    out.push_str("</svg>");
    out
}

fn strip(
    out: &mut String,
    x: &Axis,
    top: f64,
    series: &ToolSeries,
    (k, name): (usize, &LocalText),
) {
    // Samples with a speed: time [s], speed [mm/s], segment.
    let points: Vec<(f64, f64, u32)> = (0..series.time.len())
        .filter_map(|i| {
            let speed = series.speed[i].filter(|speed| (speed + series.time[i]).is_finite())?;
            Some((series.time[i], speed * 1e3, series.segment[i]))
        })
        .collect();
    let speeds: Vec<f64> = points.iter().map(|point| point.1).collect();
    let largest = range(speeds.iter().copied()).map_or(0.0, |(_, largest)| largest);
    let bottom = top + STRIP;
    let y = Axis::new(from_zero(largest), (bottom, top));

    for i in 1..series.time.len() {
        if series.segment[i] != series.segment[i - 1] {
            let (from, to) = (x.at(series.time[i - 1]), x.at(series.time[i]));
            let _ = write!(
                out,
                "<rect class=\"gap\" x=\"{from:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{STRIP:.1}\"/>",
                (to - from).max(1.0)
            );
        }
    }
    grid(out, x, &y, (70.0, 26.0));
    let place = |i: usize, speed: f64| (points[i].2, x.at(points[i].0), y.at(speed));
    let raw = thin::extremes(&speeds, MAX_POINTS);
    let means = moving_means(&points);
    let calm = thin::evenly(points.len(), MAX_POINTS);
    let colour = colour_class(k);
    let _ = write!(
        out,
        "<path class=\"pale {colour}\" d=\"{}\"/><path class=\"curve {colour}\" d=\"{}\"/>",
        line(raw.into_iter().map(|i| place(i, speeds[i]))),
        line(calm.into_iter().map(|i| place(i, means[i])))
    );
    let unit = in_both("mm/s", "mm/s");
    svg_text(out, (LEFT - 7.0, top - 9.0), "label", "end", &unit);
    let class = format!("name {colour}");
    svg_text(out, (LEFT, top - 8.0), &class, "start", name);
}

/// For each of the points (time, speed, segment) the mean speed of its segment within half of [`MEAN_WINDOW`] before and
/// after it: for the eye only, no metric rests on it.
fn moving_means(points: &[(f64, f64, u32)]) -> Vec<f64> {
    let (mut from, mut to, mut sum) = (0, 0, 0.0);
    points
        .iter()
        .map(|&(time, _, segment)| {
            while to < points.len()
                && points[to].2 == segment
                && points[to].0 <= time + MEAN_WINDOW / 2.0
            {
                sum += points[to].1;
                to += 1;
            }
            while points[from].2 != segment || points[from].0 < time - MEAN_WINDOW / 2.0 {
                sum -= points[from].1;
                from += 1;
            }
            sum / (to - from) as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::moving_means;

    /// By hand: the window reaches a quarter of a second to both sides and never into another segment.
    #[test]
    fn means_stay_in_their_segment() {
        let points = [
            (0.0, 1.0, 0),
            (0.25, 2.0, 0),
            (0.5, 6.0, 0),
            (0.625, 100.0, 1),
            (0.75, 200.0, 1),
            (1.5, 7.0, 1),
        ];
        assert_eq!(moving_means(&points), [1.5, 3.0, 4.0, 150.0, 150.0, 7.0]);
    }
}
