//! A panel of the picture: a logarithmic frame, lines with markers, and labels where they cover least. SVG by hand.

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
/// Size of letters of labels, and width of one as a share of it.
pub const LETTER: f64 = 12.0;
const LETTER_WIDTH: f64 = 0.56;

/// A line of points.
pub struct Line<'a> {
    /// Engine, method and settings; the first two make the label.
    pub key: [&'a str; 3],
    /// Abscissa and ordinate, sorted by abscissa.
    pub points: Vec<[f64; 2]>,
}

impl Line<'_> {
    fn label(&self) -> String {
        match self.key {
            [engine, "", _] => engine.into(),
            [engine, method, _] => format!("{engine}: {method}"),
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
                    bottom - 6.0
                );
            }
        }
    }

    fn draw_lines(&self, out: &mut String, lines: &[Line<'_>]) {
        let [left, top] = self.corner;
        let [right, bottom] = [left + PANEL[0], top + PANEL[1]];
        // Markers first: labels then keep clear of all of them.
        let mut taken: Vec<Taken> = Vec::new();
        for line in lines {
            let (_, colour, form) = look(line.key[0]);
            let points: Vec<[f64; 2]> = line.points.iter().map(|&point| self.at(point)).collect();
            let path: String = points
                .iter()
                .map(|[x, y]| format!(" {x:.1},{y:.1}"))
                .collect();
            let width = if line.key[0] == OURS { 2.4 } else { 1.4 };
            let _ = writeln!(
                out,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>",
                path.trim()
            );
            for [x, y] in points {
                marker(out, form, colour, [x, y]);
                taken.push([x - 6.0, y - 6.0, x + 6.0, y + 6.0]);
            }
        }
        // Lines of one method with other settings share a label.
        let mut told = Vec::new();
        for line in lines {
            let label = line.label();
            if told.contains(&label) {
                continue;
            }
            let (_, colour, _) = look(line.key[0]);
            let points: Vec<[f64; 2]> = line.points.iter().map(|&point| self.at(point)).collect();
            let [x, y] = place(&points, &label, [left, top, right, bottom], &taken);
            let wide = width_of(&label);
            taken.push([x, y - LETTER, x + wide, y + 3.0]);
            let weight = if line.key[0] == OURS {
                " font-weight=\"bold\""
            } else {
                ""
            };
            let _ = writeln!(
                out,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"{colour}\"{weight} stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\">{label}</text>"
            );
            told.push(label);
        }
    }
}

/// A box that a label or a marker takes: left, top, right, bottom.
type Taken = [f64; 4];

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

/// A little more than letters take, so that labels do not touch.
fn width_of(label: &str) -> f64 {
    LETTER * LETTER_WIDTH * label.chars().count() as f64 + 4.0
}

/// Where a label starts: beside one of its points, in the frame, where it covers the least of what is there.
fn place(points: &[[f64; 2]], label: &str, frame: Taken, taken: &[Taken]) -> [f64; 2] {
    let wide = width_of(label);
    let mut best = ([frame[0], frame[1]], f64::INFINITY);
    for (rank, &[x, y]) in points.iter().enumerate() {
        for (turn, [dx, dy]) in [
            [9.0, 4.0],
            [-9.0 - wide, 4.0],
            [-wide / 2.0, -11.0],
            [-wide / 2.0, 21.0],
            [5.0, -9.0],
            [5.0, 19.0],
            [-wide - 3.0, -9.0],
            [-wide - 3.0, 19.0],
        ]
        .into_iter()
        .enumerate()
        {
            let at = [
                (x + dx).clamp(frame[0] + 4.0, (frame[2] - wide).max(frame[0] + 4.0)),
                (y + dy).clamp(frame[1] + LETTER + 2.0, frame[3] - 6.0),
            ];
            let own = [at[0], at[1] - LETTER, at[0] + wide, at[1] + 3.0];
            let covered: f64 = taken.iter().map(|other| overlap(&own, other)).sum();
            // Among clear places the first.
            let cost = covered + 0.01 * (rank + turn) as f64;
            if cost < best.1 {
                best = (at, cost);
            }
        }
    }
    best.0
}

fn overlap(a: &Taken, b: &Taken) -> f64 {
    let wide = a[2].min(b[2]) - a[0].max(b[0]);
    let high = a[3].min(b[3]) - a[1].max(b[1]);
    wide.max(0.0) * high.max(0.0)
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
