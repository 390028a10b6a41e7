//! Lines between logarithmic axes, as SVG.

use microsim_drawing::{Anchor, LogAxis, escape, text};
use std::fmt::Write as _;

/// Size of the axes, and room around them, in pixels.
const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 320.0;
const LEFT: f64 = 70.0;
const TOP: f64 = 20.0;
const BELOW: f64 = 56.0;
/// Height of a line of the legend.
const LETTER: f64 = 18.0;

/// Colours that people with any colour vision distinguish (Okabe and Ito 2008).
const COLOURS: [&str; 6] = [
    "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#000000",
];

/// A line.
pub struct Line {
    pub name: String,
    points: Vec<(f64, f64)>,
}

impl Line {
    pub fn new(name: String) -> Self {
        Self {
            name,
            points: Vec::new(),
        }
    }

    pub fn push(&mut self, x: f64, y: f64) {
        self.points.push((x, y));
    }
}

/// The lines, with a legend below.
pub fn log_log(x_title: &str, y_title: &str, lines: &[Line]) -> String {
    let points = || lines.iter().flat_map(|line| &line.points);
    let x = LogAxis::around(points().map(|p| p.0), 1.0, (LEFT, LEFT + WIDTH));
    let y = LogAxis::around(points().map(|p| p.1), 1.0, (TOP + HEIGHT, TOP));
    let (width, legend) = (LEFT + WIDTH + 20.0, TOP + HEIGHT + BELOW);
    let height = legend + LETTER * lines.len() as f64;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
         <rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#888\"/>\n"
    );
    for (value, named) in x.ticks() {
        let at = x.at(value);
        let _ = writeln!(out, "<path d=\"M{at:.1} {TOP}v{HEIGHT}\" stroke=\"#ddd\"/>");
        if named {
            let place = (at, TOP + HEIGHT + 18.0);
            text(
                &mut out,
                place,
                "tick",
                Anchor::Middle,
                &LogAxis::label(value),
            );
        }
    }
    for (value, named) in y.ticks() {
        let at = y.at(value);
        let _ = writeln!(out, "<path d=\"M{LEFT} {at:.1}h{WIDTH}\" stroke=\"#ddd\"/>");
        if named {
            let place = (LEFT - 6.0, at + 4.0);
            text(&mut out, place, "tick", Anchor::End, &LogAxis::label(value));
        }
    }
    let below = (LEFT + 0.5 * WIDTH, TOP + HEIGHT + 38.0);
    text(&mut out, below, "title", Anchor::Middle, x_title);
    text(
        &mut out,
        (LEFT + 6.0, TOP + 16.0),
        "title",
        Anchor::Start,
        y_title,
    );
    for (index, line) in lines.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        let places: Vec<String> = line
            .points
            .iter()
            .map(|(a, b)| format!("{:.1},{:.1}", x.at(*a), y.at(*b)))
            .collect();
        let row = legend + LETTER * index as f64;
        let _ = writeln!(
            out,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\n\
             <path d=\"M{LEFT} {row}h24\" stroke=\"{colour}\" stroke-width=\"3\"/><text x=\"{}\" y=\"{}\">{}</text>",
            places.join(" "),
            LEFT + 32.0,
            row + 4.0,
            escape(&line.name)
        );
    }
    out + "</svg>\n"
}
