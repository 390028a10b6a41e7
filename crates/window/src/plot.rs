//! Curves over time, with what happened marked on them, and over attempts.

use crate::look;
use crate::text::number;
use eframe::egui::{
    Align2, FontId, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, pos2, vec2,
};
use microsim_vocabulary::Language;

/// A curve: times \[s\] and values, `None` where it has a gap.
#[derive(Clone, Debug)]
pub struct Curve {
    /// What it is.
    pub name: String,
    /// Its points.
    pub points: Vec<(f64, Option<f64>)>,
}

/// Height of a plot of a debrief \[points\].
pub const HEIGHT: f32 = 120.0;
/// Room for the numbers of the vertical axis and the horizontal one \[points\].
const MARGIN: [f32; 2] = [42.0, 18.0];

/// The frame of a plot: where numbers lie.
struct Axes {
    inner: Rect,
    /// From 0 to this.
    end: f64,
    low: f64,
    high: f64,
}

impl Axes {
    /// Takes the room of a plot.
    fn new(ui: &mut Ui, height: f32, end: f64, [low, high]: [f64; 2]) -> (Self, Response) {
        let size = vec2(ui.available_width(), height);
        let (place, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let low_corner = place.min + vec2(MARGIN[0], 4.0);
        let inner = Rect::from_min_max(low_corner, place.max - vec2(4.0, MARGIN[1]));
        ui.painter_at(place).rect_filled(inner, 2.0, look::SURFACE);
        let positive = |length: f64| if length > 0.0 { length } else { 1.0 };
        let axes = Self {
            inner,
            end: positive(end),
            low,
            high: low + positive(high - low),
        };
        (axes, response)
    }

    /// The value of the horizontal axis at a place.
    fn value(&self, place: Pos2) -> f64 {
        let along = (place.x - self.inner.left()) / self.inner.width().max(1.0);
        f64::from(along.clamp(0.0, 1.0)) * self.end
    }

    fn at(&self, x: f64, y: f64) -> Pos2 {
        let along = (x / self.end) as f32;
        let up = ((y - self.low) / (self.high - self.low)) as f32;
        pos2(
            self.inner.left() + along * self.inner.width(),
            self.inner.bottom() - up * self.inner.height(),
        )
    }

    /// Numbers and lines of both axes; those of the horizontal one with this unit, without one whole where they are.
    fn show(&self, painter: &Painter, unit: &str, language: Language) {
        let font = FontId::proportional(12.0);
        for part in [0.0, 0.5, 1.0] {
            let value = self.low + part * (self.high - self.low);
            let height = self.at(0.0, value).y;
            painter.hline(self.inner.x_range(), height, Stroke::new(1.0, look::RAISED));
            let decimals = if self.high - self.low < 10.0 { 1 } else { 0 };
            let text = number(value, decimals, language);
            let align = if part == 1.0 {
                Align2::RIGHT_TOP
            } else {
                Align2::RIGHT_BOTTOM
            };
            let at = pos2(self.inner.left() - 4.0, height);
            painter.text(at, align, text, font.clone(), look::QUIET);
        }
        for (part, align) in [
            (0.0, Align2::LEFT_TOP),
            (0.5, Align2::CENTER_TOP),
            (1.0, Align2::RIGHT_TOP),
        ] {
            let value = part * self.end;
            let decimals = usize::from(!unit.is_empty() || value.fract() > 0.0);
            let text = number(value, decimals, language);
            let at = pos2(self.at(part * self.end, 0.0).x, self.inner.bottom() + 2.0);
            painter.text(
                at,
                align,
                format!("{text}{unit}"),
                font.clone(),
                look::QUIET,
            );
        }
    }
}

/// What a plot over time has besides its curves.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Where it ends \[s\]; it begins at 0.
    pub end: f64,
    /// Times that are marked \[s\].
    pub events: &'a [f64],
    /// The time that is shown beside it \[s\].
    pub now: Option<f64>,
    /// How high it is \[points\].
    pub height: f32,
}

/// Shows curves over time; the time that was clicked \[s\].
pub fn show(
    ui: &mut Ui,
    title: &str,
    curves: &[Curve],
    frame: &Frame<'_>,
    language: Language,
) -> Option<f64> {
    ui.horizontal_wrapped(|ui| {
        ui.label(look::quiet(title).strong());
        for (index, curve) in curves.iter().enumerate() {
            let colour = look::CURVES[index % look::CURVES.len()];
            let (square, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
            ui.painter().rect_filled(square, 1.0, colour);
            ui.label(look::quiet(&curve.name));
        }
    });
    let values = curves
        .iter()
        .flat_map(|curve| curve.points.iter().filter_map(|point| point.1));
    let top = values.fold(0.0, f64::max);
    let (axes, response) = Axes::new(ui, frame.height, frame.end, [0.0, top]);
    let painter = ui.painter_at(response.rect);
    let upright = |time: f64, stroke| {
        let ends = [axes.at(time, axes.low), axes.at(time, axes.high)];
        painter.line_segment(ends, stroke);
    };
    for event in frame.events {
        upright(*event, Stroke::new(1.0, look::QUIET));
    }
    axes.show(&painter, " s", language);
    for (index, curve) in curves.iter().enumerate() {
        let stroke = Stroke::new(1.5, look::CURVES[index % look::CURVES.len()]);
        let segments = curve.points.split(|point| point.1.is_none());
        for segment in segments.filter(|segment| segment.len() > 1) {
            let points = segment
                .iter()
                .filter_map(|(time, value)| Some(axes.at(*time, (*value)?)));
            painter.add(Shape::line(points.collect(), stroke));
        }
    }
    if let Some(now) = frame.now {
        upright(now, Stroke::new(2.0, look::TEXT));
    }
    let is_pressed = response.clicked() || response.dragged();
    let pointer = response.interact_pointer_pos().filter(|_| is_pressed);
    pointer.map(|pointer| axes.value(pointer))
}

/// Shows a value after each attempt, from 0 before the first one, between two limits.
pub fn attempts(ui: &mut Ui, title: &str, values: &[f64], limits: [f64; 2], language: Language) {
    ui.label(look::quiet(title).strong());
    let [lower, upper] = limits;
    let low = values.iter().copied().fold(lower, f64::min);
    let high = values.iter().copied().fold(upper, f64::max);
    let (axes, response) = Axes::new(ui, HEIGHT, values.len() as f64, [low, high]);
    let painter = ui.painter_at(response.rect);
    axes.show(&painter, "", language);
    for (limit, colour) in [(lower, look::GOOD), (upper, look::BAD)] {
        let ends = [axes.at(0.0, limit), axes.at(axes.end, limit)];
        painter.line_segment(ends, Stroke::new(1.0, colour));
    }
    let points = std::iter::once(&0.0).chain(values).enumerate();
    let points: Vec<Pos2> = points
        .map(|(attempt, value)| axes.at(attempt as f64, *value))
        .collect();
    for point in &points {
        painter.circle_filled(*point, 2.5, look::ACCENT);
    }
    painter.add(Shape::line(points, Stroke::new(1.5, look::ACCENT)));
}
