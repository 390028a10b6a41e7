//! Lines over time, panel beside panel, as SVG.

use std::fmt::Write as _;

/// Size of a panel's axes, and room around them.
const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 240.0;
const LEFT: f64 = 60.0;
const TOP: f64 = 40.0;
const BELOW: f64 = 50.0;
/// Height of a line of the legend.
const LETTER: f64 = 15.0;

const COLOURS: [&str; 6] = [
    "#c0392b", "#2471a3", "#1e8449", "#7d3c98", "#b9770e", "#34495e",
];

/// A line.
pub struct Line {
    pub name: String,
    pub x: Vec<f64>,
    pub y: Vec<f64>,
}

/// Panels with the same lines in the same colours.
pub fn plot(x_title: &str, panels: &[(&str, Vec<Line>)]) -> String {
    let names = panels.first().map_or(0, |(_, lines)| lines.len());
    let width = panels.len() as f64 * (LEFT + WIDTH + 20.0);
    let height = TOP + HEIGHT + BELOW + LETTER * names as f64 + 10.0;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    for (index, (title, lines)) in panels.iter().enumerate() {
        let left = LEFT + index as f64 * (LEFT + WIDTH + 20.0);
        panel(&mut out, left, title, x_title, lines);
    }
    if let Some((_, lines)) = panels.first() {
        for (index, line) in lines.iter().enumerate() {
            let y = TOP + HEIGHT + BELOW + LETTER * index as f64;
            let colour = COLOURS[index % COLOURS.len()];
            let _ = writeln!(
                out,
                "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{y}\" y2=\"{y}\" stroke=\"{colour}\" stroke-width=\"3\"/><text x=\"{}\" y=\"{}\">{}</text>",
                LEFT + 24.0,
                LEFT + 32.0,
                y + 4.0,
                line.name
            );
        }
    }
    out + "</svg>\n"
}

fn panel(out: &mut String, left: f64, title: &str, x_title: &str, lines: &[Line]) {
    let largest = |of: fn(&Line) -> &Vec<f64>| {
        let values = lines.iter().flat_map(|line| of(line).iter().copied());
        values.filter(|v| v.is_finite()).fold(0.0, f64::max)
    };
    let (x_end, y_end) = (
        largest(|line| &line.x),
        largest(|line| &line.y).max(1e-9) * 1.05,
    );
    let place = |x: f64, y: f64| (left + WIDTH * x / x_end, TOP + HEIGHT * (1.0 - y / y_end));
    let _ = writeln!(
        out,
        "<text x=\"{left}\" y=\"{}\" font-weight=\"bold\">{title}</text>\n\
         <rect x=\"{left}\" y=\"{TOP}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#888\"/>\n\
         <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{x_title}</text>",
        TOP - 12.0,
        left + 0.5 * WIDTH,
        TOP + HEIGHT + 36.0
    );
    for k in 0..=4 {
        let share = f64::from(k) / 4.0;
        let (x, y) = place(share * x_end, share * y_end);
        let _ = writeln!(
            out,
            "<text x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{:.0}</text><text x=\"{}\" y=\"{}\" text-anchor=\"end\">{:.3}</text>",
            TOP + HEIGHT + 18.0,
            share * x_end,
            left - 6.0,
            y + 4.0,
            share * y_end
        );
    }
    for (index, line) in lines.iter().enumerate() {
        let points: Vec<String> = line
            .x
            .iter()
            .zip(&line.y)
            .map(|(x, y)| {
                let (x, y) = place(*x, *y);
                format!("{x:.1},{y:.1}")
            })
            .collect();
        let _ = writeln!(
            out,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\"/>",
            points.join(" "),
            COLOURS[index % COLOURS.len()]
        );
    }
}
