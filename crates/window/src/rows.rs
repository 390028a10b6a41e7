//! Rows of lists and tables: cells of given widths, chosen by mouse or keyboard.

use crate::look;
use eframe::egui::{
    self, Align, Label, Layout, Sense, StrokeKind, Ui, UiBuilder, WidgetText, vec2,
};

/// Height of a row of one line \[points\].
pub const LINE: f32 = 30.0;
/// Height of a row of two lines \[points\].
pub const TWO_LINES: f32 = 48.0;

/// A row with what `show` puts into it; whether it was chosen. `name` is that of no other row of the list.
pub fn row(
    ui: &mut Ui,
    height: f32,
    is_chosen: bool,
    name: &str,
    show: impl FnOnce(&mut Ui),
) -> bool {
    let size = vec2(ui.available_width(), height);
    let (place, _) = ui.allocate_exact_size(size, Sense::hover());
    let fill = match is_chosen {
        true => look::RAISED,
        false => look::SURFACE,
    };
    ui.painter().rect_filled(place, 6.0, fill);
    let inner = place.shrink2(vec2(10.0, 3.0));
    let cells = UiBuilder::new()
        .max_rect(inner)
        .layout(Layout::left_to_right(Align::Center));
    show(&mut ui.new_child(cells));
    let response = ui.interact(place, ui.scope_id().with(name), Sense::click());
    if is_chosen || response.has_focus() || response.hovered() {
        let stroke = egui::Stroke::new(1.5, look::ACCENT);
        ui.painter()
            .rect_stroke(place, 6.0, stroke, StrokeKind::Inside);
    }
    response
        .on_hover_cursor(egui::CursorIcon::PointingHand)
        .clicked()
}

/// What stands side by side, in the middle of a height \[points\].
pub fn in_a_row(ui: &mut Ui, height: f32, show: impl FnOnce(&mut Ui)) {
    let size = vec2(ui.available_width(), height);
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), show);
}

/// A cell of a width \[points\], cut off with an ellipsis where its text is longer.
pub fn cell(ui: &mut Ui, width: f32, align: Align, text: impl Into<WidgetText>) {
    let layout = match align {
        Align::Max => Layout::right_to_left(Align::Center),
        _ => Layout::left_to_right(Align::Center),
    };
    ui.allocate_ui_with_layout(vec2(width, ui.available_height().min(24.0)), layout, |ui| {
        ui.set_width(width);
        ui.add(Label::new(text).truncate().selectable(false));
    });
}
