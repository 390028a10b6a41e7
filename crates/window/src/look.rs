//! Colours and sizes, the same on every screen. Text has a contrast of at least 4.5 : 1 against what it stands on (WCAG 2.2, success criterion 1.4.3); what is passed or failed is
//! also written, and the two colours are apart for those who see no red and green (blue-green and orange, after Okabe and Ito 2008).

use eframe::egui::{
    self, Color32, CornerRadius, FontFamily, FontId, Margin, RichText, Stroke, TextStyle,
};

/// Behind everything.
pub const BACKGROUND: Color32 = Color32::from_rgb(16, 20, 23);
/// Behind panels and cards.
pub const SURFACE: Color32 = Color32::from_rgb(28, 34, 38);
/// Behind what is chosen or under the pointer.
pub const RAISED: Color32 = Color32::from_rgb(42, 52, 58);
/// Text.
pub const TEXT: Color32 = Color32::from_rgb(232, 236, 238);
/// Text that matters less.
pub const QUIET: Color32 = Color32::from_rgb(170, 182, 188);
/// What can be pressed, and what is active.
pub const ACCENT: Color32 = Color32::from_rgb(86, 180, 233);
/// Passed, within a limit.
pub const GOOD: Color32 = Color32::from_rgb(64, 200, 160);
/// Failed, beyond a limit.
pub const BAD: Color32 = Color32::from_rgb(240, 150, 60);
/// A reference in the picture, as `ghost` draws it.
pub const GHOST: Color32 = Color32::from_rgb(199, 120, 255);
/// Text on a button of the accent's colour.
pub const ON_ACCENT: Color32 = Color32::from_rgb(8, 18, 24);

/// Colours of curves, in their order (Okabe and Ito 2008).
pub const CURVES: [Color32; 4] = [
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(230, 159, 0),
    Color32::from_rgb(0, 190, 140),
    Color32::from_rgb(204, 121, 167),
];

/// Sets the look of a context.
pub fn apply(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    context.global_style_mut(|style| {
        let font = |size| FontId::new(size, FontFamily::Proportional);
        style.text_styles = [
            (TextStyle::Heading, font(24.0)),
            (TextStyle::Body, font(15.0)),
            (TextStyle::Button, font(15.0)),
            (TextStyle::Small, font(13.0)),
            (
                TextStyle::Monospace,
                FontId::new(13.0, FontFamily::Monospace),
            ),
        ]
        .into();
        style.spacing.item_spacing = egui::vec2(8.0, 7.0);
        style.spacing.button_padding = egui::vec2(12.0, 7.0);
        let visuals = &mut style.visuals;
        visuals.panel_fill = BACKGROUND;
        visuals.window_fill = SURFACE;
        visuals.extreme_bg_color = BACKGROUND;
        visuals.text_edit_bg_color = Some(SURFACE);
        visuals.override_text_color = Some(TEXT);
        visuals.selection.bg_fill = RAISED;
        visuals.selection.stroke = Stroke::new(1.5, ACCENT);
        let corner = CornerRadius::same(6);
        for (widget, fill) in [
            (&mut visuals.widgets.inactive, RAISED),
            (&mut visuals.widgets.hovered, Color32::from_rgb(56, 70, 78)),
            (&mut visuals.widgets.active, Color32::from_rgb(66, 84, 94)),
        ] {
            widget.bg_fill = fill;
            widget.weak_bg_fill = fill;
            widget.corner_radius = corner;
        }
        // Whoever works by keyboard sees where they are.
        visuals.widgets.hovered.bg_stroke = Stroke::new(1.5, ACCENT);
    });
}

/// A frame for a card or panel.
pub fn card(chosen: bool) -> egui::Frame {
    let (fill, stroke) = match chosen {
        true => (RAISED, Stroke::new(1.5, ACCENT)),
        false => (SURFACE, Stroke::NONE),
    };
    egui::Frame::NONE
        .fill(fill)
        .stroke(stroke)
        .corner_radius(CornerRadius::same(8))
        .inner_margin(Margin::same(12))
}

/// A frame for what lies over the picture and waits for an answer.
pub fn overlay() -> egui::Frame {
    card(false).stroke(Stroke::new(1.5, ACCENT))
}

/// A heading within a screen.
pub fn heading(text: &str) -> RichText {
    RichText::new(text).size(18.0).strong().color(TEXT)
}

/// Text that matters less.
pub fn quiet(text: impl Into<String>) -> RichText {
    RichText::new(text).size(13.0).color(QUIET)
}

/// The button of a screen that most people want.
pub fn main_button(text: &str) -> egui::Button<'static> {
    let text = RichText::new(text).size(17.0).strong().color(ON_ACCENT);
    egui::Button::new(text)
        .fill(ACCENT)
        .min_size(egui::vec2(150.0, 40.0))
}

/// Relative luminance as WCAG 2.2 defines it.
#[cfg(test)]
fn luminance(colour: Color32) -> f64 {
    let linear = |byte: u8| {
        let c = f64::from(byte) / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    };
    let [r, g, b, _] = colour.to_array();
    0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
}

/// Contrast of two colours as WCAG 2.2 defines it, from 1 to 21.
#[cfg(test)]
pub fn contrast(a: Color32, b: Color32) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_can_be_read_on_all_that_it_stands_on() {
        assert!((contrast(Color32::WHITE, Color32::BLACK) - 21.0).abs() < 1e-9);
        for ground in [BACKGROUND, SURFACE, RAISED] {
            for text in [TEXT, QUIET, ACCENT, GOOD, BAD] {
                let contrast = contrast(text, ground);
                assert!(contrast >= 4.5, "{text:?} on {ground:?}: {contrast:.2}");
            }
        }
        assert!(contrast(ON_ACCENT, ACCENT) >= 4.5);
    }
}
