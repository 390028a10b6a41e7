//! A panel of the picture: a logarithmic frame, lines with markers, and labels where they cover least. SVG by hand.

use crate::labels::{LETTER, Labels};
use crate::ours::ENGINE as OURS;
use crate::report::RIGHT;
use std::fmt::Write as _;

/// Engine, colour, form.
pub const LOOKS: [(&str, &str, Form); 4] = [
    (OURS, "#0072b2", Form::Circle),
    ("MuJoCo", "#b04a00", Form::Square),
    ("Drake", "#00734f", Form::Triangle),
    ("pyPBD", "#a8407f", Form::Diamond),
];

#[derive(Clone, Copy)]
pub enum Form {
    Circle,
    Square,
    Triangle,
    Diamond,
}

/// A panel with its room for words around it.
const PANEL: [f64; 2] = [480.0, 370.0];
/// A line of points.
pub struct Line<'a> {
    /// Engine, method and settings; the first two make the label.
    pub key: [&'a str; 3],
    /// Abscissa and ordinate, sorted by abscissa.
    pub points: Vec<[f64; 2]>,
}

impl Line<'_> {
    /// The method; what its name has in brackets is explained in the table.
    fn name(&self) -> &str {
        self.key[1].split(" (").next().unwrap_or_default()
    }

    fn label(&self) -> String {
        match self.name() {
            "" => self.key[0].into(),
            name => format!("{}: {name}", self.key[0]),
        }
    }
}

/// A logarithmic frame.
pub struct Frame {
    /// Upper left corner.
    pub corner: [f64; 2],
    pub title: String,
    /// Titles of abscissa and ordinate.
    pub axes: [&'static str; 2],
    /// Ends of the abscissa.
    pub x: [f64; 2],
    /// Ends of the ordinate.
    pub y: [f64; 2],
    /// Whether it shows errors of peaks: with percents, the limit and real time.
    pub peaks: bool,
}

impl Frame {
    fn at(&self, point: [f64; 2]) -> [f64; 2] {
        let share = |value: f64, ends: [f64; 2]| {
            (value.clamp(ends[0], ends[1]) / ends[0]).ln() / (ends[1] / ends[0]).ln()
        };
        [
            self.corner[0] + PANEL[0] * share(point[0], self.x),
            self.corner[1] + PANEL[1] * (1.0 - share(point[1], self.y)),
        ]
    }

    /// The frame with its grid and lines.
    pub fn draw(&self, out: &mut String, lines: &[Line<'_>]) {
        self.draw_grid(out);
        self.draw_lines(out, lines);
    }

    fn draw_grid(&self, out: &mut String) {
        let [left, top] = self.corner;
        let [right, bottom] = [left + PANEL[0], top + PANEL[1]];
        let _ = writeln!(
            out,
            "<text x=\"{left}\" y=\"{}\" font-size=\"15\" font-weight=\"bold\">{}</text>",
            top - 10.0,
            self.title
        );
        for power in -6..=6 {
            let value = 10f64.powi(power);
            if (self.x[0] * 0.999..=self.x[1] * 1.001).contains(&value) {
                let [x, _] = self.at([value, self.y[0]]);
                let _ = writeln!(
                    out,
                    "<path d=\"M{x:.1} {top}V{bottom}\" stroke=\"#ddd\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                    bottom + 17.0,
                    grouped(value)
                );
            }
            if (self.y[0] * 0.999..=self.y[1] * 1.001).contains(&value) {
                let [_, y] = self.at([self.x[0], value]);
                let text = if self.peaks {
                    format!("{} %", grouped(100.0 * value))
                } else {
                    grouped(value)
                };
                let _ = writeln!(
                    out,
                    "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
                    left - 6.0,
                    y + 4.0
                );
            }
        }
        let _ = writeln!(
            out,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#777\"/>",
            PANEL[0], PANEL[1]
        );
        let [across, along] = [left + PANEL[0] / 2.0, top + PANEL[1] / 2.0];
        let [x, y] = self.axes;
        let _ = writeln!(
            out,
            "<text x=\"{across:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{x}</text>",
            bottom + 36.0
        );
        let _ = writeln!(
            out,
            "<text transform=\"translate({:.1} {along:.1}) rotate(-90)\" text-anchor=\"middle\">{y}</text>",
            left - 52.0
        );
        if self.peaks {
            let [_, y] = self.at([self.x[0], RIGHT]);
            let _ = writeln!(
                out,
                "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#222\" stroke-dasharray=\"6 4\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{:.0} %</text>",
                right - 4.0,
                y - 4.0,
                100.0 * RIGHT
            );
            if self.x[0] < 1.0 && self.x[1] > 1.0 {
                let [x, _] = self.at([1.0, self.y[0]]);
                let _ = writeln!(
                    out,
                    "<path d=\"M{x:.1} {top}V{bottom}\" stroke=\"#222\" stroke-dasharray=\"6 4\"/><text x=\"{:.1}\" y=\"{:.1}\">real time</text>",
                    x + 4.0,
                    top + LETTER + 2.0
                );
            }
        }
    }

    fn draw_lines(&self, out: &mut String, lines: &[Line<'_>]) {
        let [left, top] = self.corner;
        let mut labels = Labels::new([left, top, left + PANEL[0], top + PANEL[1]]);
        // The words on real time.
        let [x, _] = self.at([1.0, self.y[0]]);
        labels.keep_clear(&[[x, top + 8.0], [x + 54.0, top + 8.0]]);
        // Lines and markers first: labels then keep clear of all of them.
        let mut told = Vec::new();
        let mut drawn: Vec<(String, _, Vec<[f64; 2]>)> = Vec::new();
        for line in lines {
            let (_, colour, form) = look(line.key[0]);
            let points: Vec<[f64; 2]> = line.points.iter().map(|&point| self.at(point)).collect();
            let path: Vec<String> = points
                .iter()
                .map(|[x, y]| format!("{x:.1},{y:.1}"))
                .collect();
            let width = if line.key[0] == OURS { 2.4 } else { 1.4 };
            let misses = self.peaks && line.points.iter().all(|point| point[1] > RIGHT);
            let faint = if misses { " opacity=\"0.35\"" } else { "" };
            let _ = writeln!(
                out,
                "<g{faint}><polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>",
                path.join(" ")
            );
            for &point in &points {
                marker(out, form, colour, point);
            }
            let _ = writeln!(out, "</g>");
            labels.keep_clear(&points);
            let weight = if line.key[0] == OURS {
                "bold"
            } else {
                "normal"
            };
            if misses || told.contains(&line.label()) {
                continue;
            }
            told.push(line.label());
            match drawn.iter_mut().find(|other| near(&other.2, &points)) {
                // The same to the eye: one label for both.
                Some((label, ..)) => *label += &format!(", {}", line.name()),
                None => drawn.push((line.label(), [colour, weight], points)),
            }
        }
        for (label, [colour, weight], points) in drawn {
            let [x, y] = labels.place(&points, &label);
            let _ = writeln!(
                out,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"{colour}\" font-weight=\"{weight}\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\">{label}</text>"
            );
        }
    }
}

/// Whether a line lies on another one.
fn near(other: &[[f64; 2]], line: &[[f64; 2]]) -> bool {
    let close = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < 8.0;
    line.iter().all(|a| other.iter().any(|b| close(a, b)))
}

/// Whole decades around the values of lines along one axis.
pub fn decades(lines: &[Line<'_>], axis: usize) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for point in lines.iter().flat_map(|line| &line.points) {
        low = low.min(point[axis].log10().floor());
        high = high.max(point[axis].log10().ceil());
    }
    if low < high {
        [low, high].map(|power| 10f64.powf(power))
    } else {
        [0.1, 10.0]
    }
}

fn look(engine: &str) -> (&'static str, &'static str, Form) {
    let found = LOOKS.into_iter().find(|look| look.0 == engine);
    found.unwrap_or(("", "#222", Form::Circle))
}

fn marker(out: &mut String, form: Form, colour: &str, [x, y]: [f64; 2]) {
    let shape = match form {
        Form::Circle => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\""),
        Form::Square => format!(
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"8.4\" height=\"8.4\"",
            x - 4.2,
            y - 4.2
        ),
        Form::Triangle => format!("<path d=\"M{x:.1} {:.1}l5.4 9.4h-10.8z\"", y - 6.0),
        Form::Diamond => format!(
            "<path d=\"M{x:.1} {:.1}l5.8 5.8l-5.8 5.8l-5.8 -5.8z\"",
            y - 5.8
        ),
    };
    let _ = writeln!(out, "{shape} fill=\"{colour}\" stroke=\"#fff\"/>");
}

/// A power of ten, or a whole number, as people write it.
pub fn grouped(value: f64) -> String {
    if value < 0.999 {
        return format!("{}", (value * 1e7).round() / 1e7);
    }
    let digits = format!("{value:.0}");
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i) % 3 == 0 {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
