//! Curves over time, with what happened marked on them.

use crate::look;
use crate::text::number;
use eframe::egui::{Align2, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};
use microsim_vocabulary::Language;

/// A curve: times \[s\] and values, `None` where it has a gap.
pub struct Curve {
    /// What it is.
    pub name: String,
    /// Its points.
    pub points: Vec<(f64, Option<f64>)>,
}

/// Height of a plot \[points\].
const HEIGHT: f32 = 120.0;
/// Room for the numbers of the vertical axis and the horizontal one \[points\].
const MARGIN: [f32; 2] = [42.0, 18.0];

/// Shows curves from 0 to `end` \[s\]; `events` are marked at their times \[s\].
pub fn show(
    ui: &mut Ui,
    title: &str,
    curves: &[Curve],
    events: &[f64],
    end: f64,
    language: Language,
) {
    ui.horizontal_wrapped(|ui| {
        ui.label(look::quiet(title).strong());
        for (index, curve) in curves.iter().enumerate() {
            let colour = look::CURVES[index % look::CURVES.len()];
            let (square, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
            ui.painter().rect_filled(square, 1.0, colour);
            ui.label(look::quiet(&curve.name));
        }
    });
    let (place, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let values = curves
        .iter()
        .flat_map(|curve| curve.points.iter().filter_map(|point| point.1));
    let top = values.fold(0.0, f64::max);
    let top = if top > 0.0 { top } else { 1.0 };
    let end = if end > 0.0 { end } else { 1.0 };
    let inner = Rect::from_min_max(
        place.min + vec2(MARGIN[0], 4.0),
        place.max - vec2(4.0, MARGIN[1]),
    );
    let at = |time: f64, value: f64| -> Pos2 {
        let (x, y) = ((time / end) as f32, (value / top) as f32);
        pos2(
            inner.left() + x * inner.width(),
            inner.bottom() - y * inner.height(),
        )
    };
    let painter = ui.painter_at(place);
    painter.rect_filled(inner, 2.0, look::SURFACE);
    let line = Stroke::new(1.0, look::RAISED);
    for event in events {
        painter.line_segment(
            [at(*event, 0.0), at(*event, top)],
            Stroke::new(1.0, look::QUIET),
        );
    }
    let font = FontId::proportional(12.0);
    for part in [0.0, 0.5, 1.0] {
        let height = at(0.0, part * top).y;
        painter.hline(inner.x_range(), height, line);
        let decimals = if top < 10.0 { 1 } else { 0 };
        let text = number(part * top, decimals, language);
        let align = if part == 1.0 {
            Align2::RIGHT_TOP
        } else {
            Align2::RIGHT_BOTTOM
        };
        painter.text(
            pos2(inner.left() - 4.0, height),
            align,
            text,
            font.clone(),
            look::QUIET,
        );
    }
    for part in [0.0, 0.5, 1.0] {
        let x = at(part * end, 0.0).x;
        let align =
            [Align2::LEFT_TOP, Align2::CENTER_TOP, Align2::RIGHT_TOP][(part * 2.0) as usize];
        let text = format!("{} s", number(part * end, 1, language));
        painter.text(
            pos2(x, inner.bottom() + 2.0),
            align,
            text,
            font.clone(),
            look::QUIET,
        );
    }
    for (index, curve) in curves.iter().enumerate() {
        let stroke = Stroke::new(1.5, look::CURVES[index % look::CURVES.len()]);
        let segments = curve.points.split(|point| point.1.is_none());
        for segment in segments.filter(|segment| segment.len() > 1) {
            let points = segment
                .iter()
                .filter_map(|(time, value)| Some(at(*time, (*value)?)));
            painter.add(Shape::line(points.collect(), stroke));
        }
    }
}
