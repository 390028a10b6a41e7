//! The place of the picture on a screen: the field as it was drawn last, or why there is none.

use crate::blit::Shown;
use crate::field::Field;
use crate::ghost::Track;
use crate::live::Snapshot;
use crate::look;
use crate::text;
use crate::views;
use eframe::egui::{Align2, Color32, FontId, Response, Sense, Ui};
use microsim_render::{Legend, Models};
use microsim_settings::RendererConfig;
use microsim_vocabulary::Language;

/// What is drawn.
pub struct Subject<'a> {
    /// What there is to see, and how.
    pub config: &'a RendererConfig,
    /// Models of objects.
    pub models: &'a mut Models,
    /// The newest state, if there is one.
    pub snapshot: Option<&'a Snapshot>,
    /// A reference whose tools are drawn, too.
    pub ghost: Option<&'a Track>,
    /// Whether it was not drawn yet.
    pub is_new: bool,
}

/// The picture, and what is wrong with it.
#[derive(Debug, Default)]
pub struct Canvas {
    picture: Option<Shown>,
    /// What the colours of its surfaces mean.
    legend: Option<Legend>,
    /// Width and height with which it was drawn \[pixels\], unless it is to be drawn again.
    drawn: Option<[u32; 2]>,
    complaint: Option<String>,
}

impl Canvas {
    /// Has the picture drawn again, whether or not anything moves.
    pub fn redraw(&mut self) {
        (self.picture, self.drawn) = (None, None);
    }

    /// Whether the picture is there as large as it is shown: stretched it would not be the field.
    fn fits(&self, size: [u32; 2]) -> bool {
        self.drawn == Some(size)
    }

    /// Shows it in all of the room that there is; `waiting` before there is a picture. Whether the newest state was drawn now.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        field: &mut Field,
        subject: Subject<'_>,
        waiting: &str,
        language: Language,
    ) -> (Response, bool) {
        let place = ui.available_rect_before_wrap();
        let scale = ui.ctx().pixels_per_point();
        let size = [place.width(), place.height()].map(|side| (side * scale).round() as u32);
        let mut is_drawn = false;
        if let Some(snapshot) = subject.snapshot
            && (subject.is_new || !self.fits(size))
        {
            let seen = (snapshot, subject.ghost);
            match field.draw(subject.config, subject.models, seen, size) {
                Ok((picture, legend)) => {
                    (self.picture, self.drawn) = (Some(picture), Some(size));
                    self.legend = legend;
                    self.complaint = None;
                    is_drawn = true;
                }
                Err(why) => self.complaint = Some(why),
            }
        }
        let response = ui.allocate_rect(place, Sense::click_and_drag());
        let painter = ui.painter_at(place);
        let write = |at, align, size, text: &str, colour| {
            painter.text(at, align, text, FontId::proportional(size), colour);
        };
        match &self.picture {
            Some(picture) => {
                painter.add(picture.at(place));
                if let Some(legend) = &self.legend {
                    views::legend(&painter, place, legend, language);
                }
            }
            None => {
                // A picture hides all that lies below it, and on a software driver each filling of so much costs more than the picture.
                painter.rect_filled(place, 0.0, Color32::BLACK);
                write(
                    place.center(),
                    Align2::CENTER_CENTER,
                    17.0,
                    waiting,
                    look::TEXT,
                );
            }
        }
        if let Some(why) = &self.complaint {
            let why = format!("{}: {why}", text::NO_PICTURE.of(language));
            write(
                place.center_bottom(),
                Align2::CENTER_BOTTOM,
                15.0,
                &why,
                look::BAD,
            );
        }
        (response, is_drawn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_drawn_again_where_its_place_has_another_size() {
        let mut canvas = Canvas::default();
        assert!(!canvas.fits([800, 600]));
        canvas.drawn = Some([800, 600]);
        assert!(canvas.fits([800, 600]) && !canvas.fits([800, 500]));
        canvas.redraw();
        assert!(!canvas.fits([800, 600]));
    }
}
