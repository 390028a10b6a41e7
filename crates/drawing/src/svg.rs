//! Elements of SVG drawings. Colours and line widths stand in the style sheet of the page or drawing.

use crate::page::escape;
use std::fmt::Write;

/// Which point of a text stands at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        }
    }
}

/// Writes a text at a place.
pub fn text(out: &mut String, place: (f64, f64), class: &str, anchor: Anchor, content: &str) {
    element(out, "", place, class, anchor, content);
}

/// Writes a text of one language at a place; the style sheet of the page shows one language.
pub fn localised_text(
    out: &mut String,
    language: &str,
    place: (f64, f64),
    class: &str,
    anchor: Anchor,
    content: &str,
) {
    let language = format!(" lang=\"{}\"", escape(language));
    element(out, &language, place, class, anchor, content);
}

fn element(
    out: &mut String,
    attribute: &str,
    (x, y): (f64, f64),
    class: &str,
    anchor: Anchor,
    content: &str,
) {
    let _ = write!(
        out,
        "<text{attribute} class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{}\">{}</text>",
        anchor.name(),
        escape(content)
    );
}

/// The path data of a line through points (segment, x, y), broken where the segment changes; a segment of one point is a
/// dot. At places that are not finite nothing is drawn, and nothing across them.
pub fn broken_line(points: impl IntoIterator<Item = (u32, f64, f64)>) -> String {
    let mut path = String::new();
    let mut segment = None;
    for (of, x, y) in points {
        if !(x.is_finite() && y.is_finite()) {
            segment = None;
        } else if segment == Some(of) {
            let _ = write!(path, "L{x:.1} {y:.1}");
        } else {
            // The empty step makes a lone point visible: it gets the round ends of the line.
            let _ = write!(path, "M{x:.1} {y:.1}h0");
            segment = Some(of);
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_breaks_between_segments_and_at_nan() {
        let points = [
            (0, 0.0, 0.0),
            (0, 1.0, 1.0),
            (1, 2.0, 2.0),
            (1, f64::NAN, 3.0),
            (1, 4.0, 4.0),
        ];
        assert_eq!(
            broken_line(points),
            "M0.0 0.0h0L1.0 1.0M2.0 2.0h0M4.0 4.0h0"
        );
    }

    #[test]
    fn a_text_is_escaped_and_has_its_language() {
        let mut out = String::new();
        text(&mut out, (1.0, 2.25), "tick", Anchor::End, "a<b");
        localised_text(&mut out, "de", (0.0, 0.0), "label", Anchor::Middle, "ä");
        assert_eq!(
            out,
            "<text class=\"tick\" x=\"1.0\" y=\"2.2\" text-anchor=\"end\">a&lt;b</text>\
             <text lang=\"de\" class=\"label\" x=\"0.0\" y=\"0.0\" text-anchor=\"middle\">ä</text>"
        );
    }
}
