//! A session over its time: what happened when, how fast the tools were, how hard they pressed. What a debrief shows beside its metrics, and a replay along its time line.

use crate::look;
use crate::plot::Curve;
use crate::text::{local, number};
use eframe::egui::{Align, Button, Color32, Layout, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};
use microsim_host::playback::Standing;
use microsim_message::LocalText;
use microsim_report::{MomentKind, Report};
use microsim_vocabulary::Language;
use std::ops::Range;

/// Height of the time line \[points\].
const HEIGHT: f32 = 26.0;
/// Half the width of a mark on it \[points\].
const MARK: f32 = 5.0;

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// The tick that shows it best.
    pub tick: u64,
    /// Simulated time since the session began \[s\].
    pub time: f64,
    /// What kind.
    pub kind: MomentKind,
    /// One sentence.
    pub text: LocalText,
}

/// What happened in a session, in the order of ticks.
pub fn marks(report: &Report) -> Vec<Mark> {
    let mark = |moment: &microsim_report::Moment| Mark {
        tick: moment.tick,
        time: moment.session_time,
        kind: moment.kind,
        text: moment.text.clone(),
    };
    let mut marks: Vec<Mark> = report.moments.iter().map(mark).collect();
    marks.sort_by_key(|mark| mark.tick);
    marks
}

/// The mark that was the last at a tick.
pub fn last(marks: &[Mark], tick: u64) -> Option<usize> {
    marks
        .partition_point(|mark| mark.tick <= tick)
        .checked_sub(1)
}

/// The tick of the next mark after a tick.
pub fn next(marks: &[Mark], tick: u64) -> Option<u64> {
    let after = marks.partition_point(|mark| mark.tick <= tick);
    marks.get(after).map(|mark| mark.tick)
}

/// The tick of the mark before a tick.
pub fn previous(marks: &[Mark], tick: u64) -> Option<u64> {
    let before = marks
        .partition_point(|mark| mark.tick < tick)
        .checked_sub(1)?;
    marks.get(before).map(|mark| mark.tick)
}

/// The tick at a time of a session \[s\].
pub fn tick_at(report: &Report, time: f64) -> u64 {
    let tick = time / report.session.tick_s;
    match tick.is_finite() {
        true => tick.max(0.0) as u64,
        false => 0,
    }
}

fn name(report: &Report, tool: &str, language: Language) -> String {
    match report.session.tools.get(tool) {
        Some(title) => local(title, language).to_owned(),
        None => tool.to_owned(),
    }
}

/// The speed of each tip \[mm/s\].
pub fn speeds(report: &Report, language: Language) -> Vec<Curve> {
    let series = report.series.iter();
    let curve = |series: &microsim_report::ToolSeries| {
        let speed = series.speed.iter().map(|speed| speed.map(|v| 1e3 * v));
        Curve {
            name: name(report, &series.tool, language),
            points: series.time.iter().copied().zip(speed).collect(),
        }
    };
    series.map(curve).collect()
}

/// The force of each tool on each body that it touched \[mN\].
pub fn forces(report: &Report, language: Language) -> Vec<Curve> {
    let curve = |series: &microsim_report::ForceSeries| {
        let mut points = Vec::new();
        for k in 0..series.time.len() {
            if k > 0 && series.contact[k] != series.contact[k - 1] {
                points.push((series.time[k], None));
            }
            let force = series.valid[k].then_some(1e3 * series.sustained[k]);
            points.push((series.time[k], force));
        }
        Curve {
            name: format!("{}, {}", name(report, &series.tool, language), series.body),
            points,
        }
    };
    report.forces.iter().map(curve).collect()
}

fn colour(kind: MomentKind) -> Color32 {
    match kind {
        MomentKind::Begin | MomentKind::End => look::QUIET,
        MomentKind::Grip => look::CURVES[0],
        MomentKind::Cut | MomentKind::PieceOff => look::CURVES[1],
        MomentKind::Tear => look::BAD,
        MomentKind::ExcessForce | MomentKind::LargestForce => look::CURVES[3],
        MomentKind::Event => look::CURVES[2],
    }
}

/// Shows what happened as lines that can be clicked, with the one of `now` raised; the tick of the one that was clicked.
pub fn list(ui: &mut Ui, marks: &[Mark], now: Option<u64>, language: Language) -> Option<u64> {
    let current = now.and_then(|tick| last(marks, tick));
    let mut clicked = None;
    ui.with_layout(Layout::top_down_justified(Align::LEFT), |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        ui.spacing_mut().button_padding = vec2(6.0, 3.0);
        for (index, mark) in marks.iter().enumerate() {
            let time = number(mark.time, 1, language);
            let line = format!("{time} s  {}", local(&mark.text, language));
            let is_current = current == Some(index);
            let button = Button::selectable(is_current, look::quiet(line)).wrap();
            let response = ui.add(button);
            let edge = response.rect.left_center();
            let bar = Rect::from_center_size(edge, vec2(3.0, response.rect.height() - 6.0));
            ui.painter().rect_filled(bar, 1.0, colour(mark.kind));
            if response.clicked() {
                clicked = Some(mark.tick);
            }
        }
    });
    clicked
}

/// What a time line shows.
#[derive(Debug)]
pub struct TimeLine<'a> {
    /// The ticks.
    pub range: Range<u64>,
    /// The tick that is shown.
    pub now: Option<u64>,
    /// What happened.
    pub marks: &'a [Mark],
    /// What the comparison shows.
    pub standing: &'a Standing,
}

impl TimeLine<'_> {
    fn part(&self, tick: u64) -> f32 {
        let length = self.range.end.saturating_sub(self.range.start + 1).max(1);
        let passed = tick.saturating_sub(self.range.start);
        (passed as f64 / length as f64).min(1.0) as f32
    }

    /// The tick at a part of its length.
    fn tick(&self, part: f32) -> u64 {
        let length = self.range.end.saturating_sub(self.range.start + 1);
        let passed = f64::from(part.clamp(0.0, 1.0)) * length as f64;
        self.range.start + passed.round() as u64
    }

    /// Shows it; the tick that was clicked, or that the pointer was dragged to.
    pub fn show(&self, ui: &mut Ui, language: Language) -> Option<u64> {
        let size = vec2(ui.available_width(), HEIGHT);
        let (place, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let inner = place.shrink2(vec2(2.0 * MARK, 0.0));
        let painter = ui.painter_at(place);
        let at = |tick| inner.left() + self.part(tick) * inner.width();
        let line = |from: f32, to: f32, colour| {
            let rect = Rect::from_min_max(
                pos2(from, inner.center().y - 3.0),
                pos2(to.max(from), inner.center().y + 3.0),
            );
            painter.rect_filled(rect, 3.0, colour);
        };
        line(inner.left(), inner.right(), look::RAISED);
        // What was compared and is the same; from a difference on nothing is.
        let differs = self.standing.difference.as_ref().map(|found| found.tick);
        let compared = self.standing.compared.saturating_sub(1);
        let same = differs.map_or(compared, |tick| tick.min(compared));
        line(inner.left(), at(same), look::GOOD);
        if let Some(tick) = differs {
            line(at(tick), at(compared.max(tick)), look::BAD);
        }
        for mark in self.marks {
            let x = at(mark.tick);
            let (top, middle) = (inner.top(), inner.center().y);
            let corners = [
                pos2(x, middle - 2.0),
                pos2(x - MARK, top),
                pos2(x + MARK, top),
            ];
            painter.add(Shape::convex_polygon(
                corners.into(),
                colour(mark.kind),
                Stroke::NONE,
            ));
        }
        if let Some(now) = self.now {
            let x = at(now);
            painter.vline(x, inner.y_range(), Stroke::new(2.0, look::TEXT));
            painter.circle_filled(pos2(x, inner.center().y), 6.0, look::TEXT);
        }
        let pointer = response.hover_pos();
        let near = pointer.and_then(|pointer| {
            let distance = |mark: &&Mark| (at(mark.tick) - pointer.x).abs();
            let nearest = self
                .marks
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            nearest.filter(|mark| distance(mark) <= MARK)
        });
        let is_pressed = response.clicked() || response.dragged();
        let pressed = response.interact_pointer_pos().filter(|_| is_pressed);
        let is_click = response.clicked();
        if let Some(mark) = near {
            response.on_hover_text(local(&mark.text, language));
        }
        let pressed = pressed?;
        match near.filter(|_| is_click) {
            Some(mark) => Some(mark.tick),
            None => Some(self.tick((pressed.x - inner.left()) / inner.width().max(1.0))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_report::{Moment, ReportBuilder, ReportInput};

    fn report() -> Report {
        let input = ReportInput {
            tick_s: 0.008,
            ..ReportInput::default()
        };
        let mut report = ReportBuilder::new(&input).finish();
        // Of what lasts the tick is the last one, so that the order of times is not that of ticks.
        report.moments = [(10, 0.08), (90, 0.16), (40, 0.32)]
            .map(|(tick, session_time)| Moment {
                kind: MomentKind::Cut,
                session_time,
                tick,
                text: LocalText::new("Schnitt", "cut"),
                event: None,
            })
            .into();
        report
    }

    #[test]
    fn marks_are_found_before_and_after_a_tick() {
        let marks = marks(&report());
        let ticks: Vec<u64> = marks.iter().map(|mark| mark.tick).collect();
        assert_eq!(ticks, [10, 40, 90]);
        assert_eq!((next(&marks, 0), previous(&marks, 0)), (Some(10), None));
        assert_eq!(
            (next(&marks, 40), previous(&marks, 40)),
            (Some(90), Some(10))
        );
        assert_eq!((next(&marks, 90), previous(&marks, 1000)), (None, Some(90)));
        assert_eq!((last(&marks, 9), last(&marks, 40)), (None, Some(1)));
    }

    #[test]
    fn times_and_parts_are_ticks() {
        let report = report();
        assert_eq!(tick_at(&report, 0.1), 12);
        assert_eq!(tick_at(&report, -1.0), 0);
        let standing = Standing::default();
        let line = TimeLine {
            range: 100..301,
            now: None,
            marks: &[],
            standing: &standing,
        };
        assert_eq!(
            (line.tick(-1.0), line.tick(0.5), line.tick(2.0)),
            (100, 200, 300)
        );
        assert!((line.part(200) - 0.5).abs() < 1e-6);
        let empty = TimeLine {
            range: 5..5,
            ..line
        };
        assert_eq!(empty.tick(0.7), 5);
        assert!(empty.part(5).abs() < 1e-6);
    }
}
