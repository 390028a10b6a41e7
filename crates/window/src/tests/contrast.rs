//! Contrast of each text as it is drawn against what was filled below it (WCAG 2.2, success criterion 1.4.3). Texts of what cannot be pressed now are exempt there, and here.

use crate::look;
use eframe::egui::epaint::{ClippedShape, TextShape};
use eframe::egui::{Color32, Pos2, Rect, Shape};

/// What is filled, in the order in which it is drawn.
type Filled = Vec<(Rect, Color32)>;

/// Checks all texts of a screen.
pub(super) fn check(what: &str, drawn: &[ClippedShape]) {
    let faults = faults(drawn);
    assert!(faults.is_empty(), "{what}: {faults:#?}");
}

fn faults(drawn: &[ClippedShape]) -> Vec<String> {
    let (mut filled, mut faults) = (Filled::new(), Vec::new());
    for clipped in drawn {
        visit(&clipped.shape, clipped.clip_rect, &mut filled, &mut faults);
    }
    faults
}

fn visit(shape: &Shape, clip: Rect, filled: &mut Filled, faults: &mut Vec<String>) {
    match shape {
        Shape::Vec(shapes) => shapes
            .iter()
            .for_each(|shape| visit(shape, clip, filled, faults)),
        Shape::Rect(rect) if rect.fill.is_opaque() => {
            filled.push((rect.rect.intersect(clip), rect.fill));
        }
        Shape::Text(text) => visit_text(text, clip, filled, faults),
        _ => {}
    }
}

fn visit_text(text: &TextShape, clip: Rect, filled: &Filled, faults: &mut Vec<String>) {
    // What is greyed out is drawn faintly.
    if text.opacity_factor < 1.0 {
        return;
    }
    for row in &text.galley.rows {
        for glyph in row.glyphs.iter().filter(|glyph| !glyph.chr.is_whitespace()) {
            let place = text.pos + row.pos.to_vec2() + glyph.logical_rect().center().to_vec2();
            if !clip.contains(place) {
                continue;
            }
            let vertex = row.visuals.mesh.vertices.get(glyph.first_vertex as usize);
            let own = match vertex.map(|vertex| vertex.color) {
                None | Some(Color32::PLACEHOLDER) => text.fallback_color,
                Some(colour) => colour,
            };
            let colour = text.override_text_color.unwrap_or(own);
            let ground = ground(filled, place);
            let contrast = look::contrast(colour, ground);
            if colour.is_opaque() && contrast < 4.5 {
                faults.push(format!(
                    "{:?}: {colour:?} on {ground:?} has {contrast:.2}",
                    row.text()
                ));
                break;
            }
        }
    }
}

/// The colour that was filled last at a place.
fn ground(filled: &Filled, place: Pos2) -> Color32 {
    let last = filled.iter().rev().find(|(rect, _)| rect.contains(place));
    last.map_or(look::BACKGROUND, |(_, colour)| *colour)
}

/// The check finds what it looks for: dark text on a button, and not the same text where it is covered.
#[test]
fn a_text_that_cannot_be_read_is_found() {
    let screen = |colour: Color32| {
        super::shapes(super::SIZES[0], Vec::new(), |ui| {
            let text = eframe::egui::RichText::new("Start").color(colour);
            ui.add(eframe::egui::Button::new(text).fill(look::ACCENT));
        })
    };
    assert_eq!(faults(&screen(look::ON_ACCENT)), Vec::<String>::new());
    assert_eq!(faults(&screen(look::TEXT)).len(), 1);
}
