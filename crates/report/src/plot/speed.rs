//! Speed of the tools over time, one strip for each, with gaps and events.

use super::{MAX_POINTS, colour_class, grid, strip_labels, strips, thin};
use crate::text::in_both;
use crate::{Report, ToolSeries};
use microsim_drawing::{ValueAxis, broken_line, value_range};
use microsim_message::LocalText;
use std::fmt::Write;

/// Height of the strip of a tool.
const STRIP: f64 = 130.0;
/// What the bold line averages over \[s\].
const MEAN_WINDOW: f64 = 0.5;

/// Draws the speed of each tool over the session and marks the moments by their numbers, from 1.
pub fn speed_plot(report: &Report) -> String {
    let series = &report.series;
    let title = in_both(
        "Geschwindigkeit der Instrumente über der Zeit",
        "Speed of the instruments over time",
    );
    let times = series.iter().flat_map(|s| s.time.iter().copied());
    strips(
        report,
        &title,
        (series.len(), STRIP),
        times,
        |out, x, k, top| {
            let name = report.session.tool_name(&series[k].tool);
            strip(out, x, top, &series[k], (k, &name));
        },
    )
}

fn strip(
    out: &mut String,
    x: &ValueAxis,
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
    let largest = value_range(speeds.iter().copied()).map_or(0.0, |(_, largest)| largest);
    let bottom = top + STRIP;
    let y = ValueAxis::from_zero(largest, (bottom, top));

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
        broken_line(raw.into_iter().map(|i| place(i, speeds[i]))),
        broken_line(calm.into_iter().map(|i| place(i, means[i])))
    );
    strip_labels(out, top, "mm/s", &colour, name);
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
