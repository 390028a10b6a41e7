//! Heat maps: rows, grouped columns, a coloured field with its number; as SVG and as a Markdown table.

use crate::drawing::document;
use microsim_drawing::{Anchor, escape, significant, text};
use std::fmt::Write;

/// Style of the fields; colours are distinguishable for everyone, and each field carries its text.
pub const STYLE: &str = include_str!("heat_map.css");

/// One field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// One or two short lines.
    pub lines: Vec<String>,
    /// Class of its colour in the style sheet `STYLE`.
    pub class: &'static str,
    /// Text shown when it is pointed at.
    pub tip: String,
}

/// A heat map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMap {
    /// Name of its file, without extension.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// Group and label of each column; equal neighbouring groups are named once.
    pub columns: Vec<(String, String)>,
    /// Labels of the rows.
    pub rows: Vec<String>,
    /// The fields, row after row; `None` where there is nothing.
    pub fields: Vec<Vec<Option<Field>>>,
    /// Width and height of a field \[px\].
    pub size: (f64, f64),
}

/// Width of a letter of a label \[px\], about.
const LETTER: f64 = 6.3;
/// Height of the two lines of column labels \[px\].
const HEAD: f64 = 46.0;
/// Height of the title of a drawing that stands alone \[px\].
const TITLE: f64 = 28.0;
/// Gap between groups of columns \[px\].
const GAP: f64 = 6.0;

impl HeatMap {
    /// The drawing; `alone` for a file of its own, with title and style.
    pub fn to_svg(&self, alone: bool) -> String {
        let left = self.left();
        let top = HEAD + if alone { TITLE } else { 0.0 };
        let places = self.places(left);
        let height = self.size.1;
        let title = if alone {
            16.0 + 1.25 * LETTER * self.title.chars().count() as f64
        } else {
            0.0
        };
        let bottom = top + height * self.rows.len() as f64 + 4.0;

        let mut out = String::new();
        if alone {
            let _ = write!(out, "<style>{STYLE}</style>");
            text(&mut out, (4.0, 18.0), "heading", Anchor::Start, &self.title);
        }
        self.column_labels(&mut out, &places, top);
        for (row, label) in self.rows.iter().enumerate() {
            let y = top + height * row as f64;
            text(
                &mut out,
                (left - 8.0, y + 0.5 * height + 4.0),
                "row",
                Anchor::End,
                label,
            );
            for (field, x) in self.fields[row].iter().zip(&places) {
                if let Some(field) = field {
                    draw(&mut out, field, (*x, y), self.size);
                }
            }
        }
        document(self.width().max(title), bottom, &self.title, &out, alone)
    }

    /// Width without the title \[px\].
    pub fn width(&self) -> f64 {
        let left = self.left();
        self.places(left).last().map_or(left, |x| x + self.size.0) + 4.0
    }

    /// Width of the labels of the rows \[px\].
    fn left(&self) -> f64 {
        let longest = self
            .rows
            .iter()
            .map(|row| row.chars().count())
            .max()
            .unwrap_or(0);
        12.0 + LETTER * longest as f64
    }

    /// Left ends of the columns \[px\].
    fn places(&self, left: f64) -> Vec<f64> {
        let mut x = left;
        let mut places = Vec::new();
        for (index, (group, _)) in self.columns.iter().enumerate() {
            if index > 0 {
                x += self.size.0;
                if self.columns[index - 1].0 != *group {
                    x += GAP;
                }
            }
            places.push(x);
        }
        places
    }

    fn column_labels(&self, out: &mut String, places: &[f64], top: f64) {
        let width = self.size.0;
        let mut first = 0;
        for run in self.columns.chunk_by(|a, b| a.0 == b.0) {
            let (start, end) = (places[first], places[first + run.len() - 1] + width);
            first += run.len();
            // A name that is longer than its columns stands in two lines.
            let name = &run[0].0;
            let fits = LETTER * name.chars().count() as f64 <= end - start + 2.0;
            let (upper, lower) = if fits {
                ("", name.as_str())
            } else {
                halves(name)
            };
            let middle = 0.5 * (start + end);
            for (line, y) in [(upper, top - 34.0), (lower, top - 21.0)] {
                if !line.is_empty() {
                    text(out, (middle, y), "group", Anchor::Middle, line);
                }
            }
        }
        for ((_, label), x) in self.columns.iter().zip(places) {
            text(
                out,
                (x + 0.5 * width, top - 6.0),
                "tick",
                Anchor::Middle,
                label,
            );
        }
    }

    /// The numbers as a Markdown table.
    pub fn to_markdown(&self) -> String {
        let mut out = String::from("| |");
        for (group, label) in &self.columns {
            let _ = write!(out, " {} |", format!("{group} {label}").trim());
        }
        let _ = write!(out, "\n|---|{}\n", "---|".repeat(self.columns.len()));
        for (label, fields) in self.rows.iter().zip(&self.fields) {
            let _ = write!(out, "| {label} |");
            for field in fields {
                let lines = field
                    .as_ref()
                    .map_or(String::new(), |field| field.lines.join(", "));
                let _ = write!(out, " {lines} |");
            }
            out.push('\n');
        }
        out
    }
}

/// A name in two lines, cut at the space or hyphen that is nearest to its middle.
fn halves(name: &str) -> (&str, &str) {
    let cuts = name.match_indices([' ', '-']).map(|(place, _)| place + 1);
    match cuts.min_by_key(|cut| (2 * cut).abs_diff(name.len())) {
        Some(cut) => (name[..cut].trim_end(), &name[cut..]),
        None => ("", name),
    }
}

/// Class and text of a ratio that should be 1.
pub fn ratio_field(ratio: f64, tip: String) -> Field {
    let class = match ratio {
        r if r.is_nan() => "unknown",
        r if r < 0.2 => "below-4",
        r if r < 0.5 => "below-3",
        r if r < 0.8 => "below-2",
        r if r < 0.97 => "below-1",
        r if r <= 1.03 => "equal",
        r if r <= 1.25 => "above-1",
        r if r <= 2.0 => "above-2",
        r if r <= 5.0 => "above-3",
        _ => "above-4",
    };
    let line = match ratio {
        r if (0.0995..9.995).contains(&r) => format!("{r:.2}"),
        r if (9.995..99.95).contains(&r) => format!("{r:.1}"),
        r if r > 0.0 && r < 0.0995 => significant(r, 1),
        r => significant(r, 2),
    };
    Field {
        lines: vec![line],
        class,
        tip,
    }
}

/// The key of the colours of [`ratio_field`], as HTML.
pub fn ratio_key() -> String {
    let names = [
        ("below-4", "below 0.2"),
        ("below-3", "0.2–0.5"),
        ("below-2", "0.5–0.8"),
        ("below-1", "0.8–0.97"),
        ("equal", "within 3 %"),
        ("above-1", "1.03–1.25"),
        ("above-2", "1.25–2"),
        ("above-3", "2–5"),
        ("above-4", "above 5"),
    ];
    key(&names)
}

/// A key of colours, as HTML.
pub fn key(names: &[(&str, &str)]) -> String {
    let mut out = String::from("<p class=\"heat-key\">");
    for (class, name) in names {
        let _ = write!(
            out,
            "<span><svg class=\"drawing swatch\" viewBox=\"0 0 18 14\" aria-hidden=\"true\"><rect class=\"field {class}\" width=\"18\" height=\"14\" rx=\"2\"/></svg>{}</span>",
            escape(name)
        );
    }
    out.push_str("</p>");
    out
}

fn draw(out: &mut String, field: &Field, (x, y): (f64, f64), (width, height): (f64, f64)) {
    let _ = write!(
        out,
        "<g class=\"{0}\"><title>{1}</title><rect class=\"field {0}\" x=\"{2:.1}\" y=\"{3:.1}\" width=\"{4:.1}\" height=\"{5:.1}\" rx=\"2\"/>",
        field.class,
        escape(&field.tip),
        x + 1.0,
        y + 1.0,
        width - 2.0,
        height - 2.0
    );
    let first = y + 0.5 * height + 4.0 - 6.5 * (field.lines.len() as f64 - 1.0);
    for (line, content) in field.lines.iter().enumerate() {
        let class = if line == 0 { "value" } else { "value second" };
        let at = (x + 0.5 * width, first + 13.0 * line as f64);
        text(out, at, class, Anchor::Middle, content);
    }
    out.push_str("</g>");
}
