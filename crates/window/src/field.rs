//! The field of the microscope: snapshots drawn into a texture that the window shows.

use crate::blit::{Blitter, Shown};
use crate::film::MakeCamera;
use crate::ghost::Track;
use crate::live::Snapshot;
use crate::pace::Times;
use crate::views;
use eframe::egui::Rect;
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use microsim_gpu::Gpu;
use microsim_message::{ContactForces, ObjectScene, SetupFile, ToolPlacements, ToolStates};
use microsim_render::{
    Legend, Models, Picture, Quality, Renderer, Stereo, StereoLayout, debug, snapshot,
};
use microsim_settings::{RendererConfig, WindowSettings};
use microsim_vocabulary::{EyeLayout, Language, PictureQuality};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Smallest side of a picture \[pixels\].
const LEAST_SIDE: u32 = 64;

/// Draws the field.
pub struct Field {
    state: RenderState,
    gpu: Gpu,
    renderer: Renderer,
    blitter: Blitter,
    /// The picture, with its texture, which is another one after a change of size or quality.
    shown: Option<(Shown, wgpu::Texture)>,
    /// Whether this machine's quality was measured, or another one was chosen.
    has_measured: bool,
    depth_of_field: bool,
    stereo: Stereo,
    /// From the main lens to the plane of focus \[m\].
    working_distance: f64,
}

/// Pictures per second for which a quality is chosen.
const WANTED_RATE: f64 = 25.0;

impl Field {
    /// Draws with the device of the window.
    ///
    /// # Errors
    /// What the driver refuses.
    pub fn new(state: &RenderState) -> Result<Self, String> {
        let name = state.adapter.get_info().name;
        let gpu = Gpu::from_device(state.device.clone(), state.queue.clone(), name);
        let renderer = Renderer::new(&gpu).map_err(|e| e.to_string())?;
        Ok(Self {
            state: state.clone(),
            gpu,
            renderer,
            blitter: Blitter::new(&state.device, state.target_format),
            shown: None,
            has_measured: false,
            depth_of_field: WindowSettings::default().depth_of_field,
            stereo: Stereo::default(),
            working_distance: WindowSettings::default().working_distance,
        })
    }

    /// Why the device is lost, once it is: nothing can be drawn with it any more.
    pub fn lost(&self) -> Option<String> {
        self.gpu.lost().map(str::to_owned)
    }

    /// Draws as the operator wants it from the next picture on.
    pub fn set(&mut self, settings: &WindowSettings) {
        let quality = match settings.quality {
            PictureQuality::Automatic => None,
            PictureQuality::Low => Some(Quality::Low),
            PictureQuality::Medium => Some(Quality::Medium),
            PictureQuality::High => Some(Quality::High),
        };
        if let Some(quality) = quality {
            self.renderer.set_quality(quality);
        }
        self.has_measured = quality.is_some();
        self.renderer.set_depth_of_field(settings.depth_of_field);
        self.depth_of_field = settings.depth_of_field;
        self.working_distance = settings.working_distance;
        self.stereo = Stereo {
            layout: match settings.stereo {
                EyeLayout::Mono => StereoLayout::Mono,
                EyeLayout::SideBySide => StereoLayout::SideBySide,
                EyeLayout::TopBottom => StereoLayout::TopBottom,
                EyeLayout::RowInterleaved => StereoLayout::RowInterleaved,
                EyeLayout::RedCyan => StereoLayout::RedCyan,
            },
            base: settings.stereo_base,
        };
    }

    /// The part of a place in which the left eye's picture is shown, or the one picture.
    pub fn eye(&self, place: Rect) -> Rect {
        eye(self.stereo.layout, place)
    }

    /// How much is done for a picture: with the first one the highest is chosen that this machine draws 25 times in a second, which takes a second.
    pub fn quality(&self) -> Quality {
        self.renderer.quality()
    }

    /// The next quality, after the highest the lowest.
    pub fn change_quality(&mut self) {
        let place = Quality::ALL.iter().position(|q| *q == self.quality());
        let next = place.map_or(0, |place| (place + 1) % Quality::ALL.len());
        self.renderer.set_quality(Quality::ALL[next]);
    }

    /// Once the picture that was drawn last is finished, adds how long that is since a moment to the delays. Found when the driver is asked next: a picture later at most.
    pub fn time(&self, since: Instant, delays: &Arc<Mutex<Times>>) {
        let delays = Arc::clone(delays);
        self.state.queue.on_submitted_work_done(move || {
            let mut delays = delays.lock().unwrap_or_else(PoisonError::into_inner);
            delays.push(since.elapsed().as_secs_f64());
        });
    }

    /// Draws a snapshot `size` pixels wide and high; with it comes what the colours of surfaces mean, where they mean anything.
    ///
    /// # Errors
    /// What the renderer refuses; the last picture stays.
    pub fn draw(
        &mut self,
        config: &RendererConfig,
        models: &mut Models,
        (snapshot, ghost): (&Snapshot, Option<&Track>),
        size: [u32; 2],
    ) -> Result<(Shown, Option<Legend>), String> {
        let (picture, legend) = self
            .sight()
            .picture(config, models, (snapshot, ghost), size);
        if !self.has_measured {
            let start = Instant::now();
            let mut seconds = || start.elapsed().as_secs_f64();
            let proposal = self.renderer.propose(&picture, WANTED_RATE, &mut seconds);
            self.renderer
                .set_quality(proposal.map_err(|e| e.to_string())?.quality);
            self.has_measured = true;
        }
        self.renderer.render(&picture).map_err(|e| e.to_string())?;
        Ok((self.shown()?, legend))
    }

    /// Gives up the last picture and what it was drawn with, which [`draw`](Self::draw) makes again: nothing is drawn for a while.
    pub fn release(&mut self) {
        self.renderer.release();
        self.shown = None;
    }

    /// How it is looked at now.
    pub fn sight(&self) -> Sight {
        Sight {
            quality: self.renderer.quality(),
            depth_of_field: self.depth_of_field,
            stereo: self.stereo,
            working_distance: self.working_distance,
        }
    }

    fn shown(&mut self) -> Result<Shown, String> {
        let texture = self.renderer.texture().ok_or("nothing was drawn")?;
        if let Some((shown, of)) = &self.shown
            && of == texture
        {
            return Ok(shown.clone());
        }
        let shown = self.blitter.shown(&self.state.device, texture);
        self.shown = Some((shown.clone(), texture.clone()));
        Ok(shown)
    }
}

/// How the field is looked at, whoever draws it.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    quality: Quality,
    depth_of_field: bool,
    stereo: Stereo,
    /// From the main lens to the plane of focus \[m\].
    working_distance: f64,
}

impl Sight {
    /// A snapshot with the tools of a reference, `size` pixels wide and high.
    fn picture(
        &self,
        config: &RendererConfig,
        models: &mut Models,
        (snapshot, ghost): (&Snapshot, Option<&Track>),
        size: [u32; 2],
    ) -> (Picture, Option<Legend>) {
        let (picture, legend) = picture_of(config, models, snapshot);
        let [width, height] = size.map(|side| side.max(LEAST_SIDE));
        let mut picture = Picture {
            width,
            height,
            stereo: self.stereo,
            ..picture
        };
        let nearest = picture.view.field_diameter;
        picture.view.working_distance = self.working_distance.max(nearest);
        let ghost = ghost.map(|track| track.items(config, snapshot.time));
        picture.items.extend(ghost.into_iter().flatten());
        (picture, legend)
    }

    /// A camera with a graphics device of its own, made in the thread that draws. A legend in its pictures is in a language.
    pub fn camera(
        self,
        config: RendererConfig,
        files: Vec<SetupFile>,
        ghost: Option<Arc<Track>>,
        (size, language): ([u32; 2], Language),
    ) -> MakeCamera {
        Box::new(move || {
            let files = files.iter().map(|f| (&f.name[..], &f.bytes[..]));
            let mut models = Models::new(&files.collect::<Vec<_>>())?;
            let gpu = Gpu::off_screen().map_err(|e| e.to_string())?;
            let renderer = Renderer::of_quality(&gpu, self.quality);
            let mut renderer = renderer.map_err(|e| e.to_string())?;
            renderer.set_depth_of_field(self.depth_of_field);
            let draw = move |snapshot: &Snapshot| {
                let seen = (snapshot, ghost.as_deref());
                let (picture, legend) = self.picture(&config, &mut models, seen, size);
                let mut image = renderer.draw(&picture).map_err(|e| e.to_string())?;
                if let Some(legend) = legend {
                    image.write_legend(&legend, &views::words(language));
                }
                Ok(image.to_png())
            };
            Ok(Box::new(draw))
        })
    }
}

/// What is to be seen of a snapshot. Placements count in their own tick alone.
fn picture_of(
    config: &RendererConfig,
    models: &mut Models,
    seen: &Snapshot,
) -> (Picture, Option<Legend>) {
    let objects = seen.latest::<ObjectScene>().unwrap_or_default();
    let tools = seen.latest::<ToolStates>().unwrap_or_default();
    let placements = seen.latest::<ToolPlacements>();
    let placements = placements.filter(|placed| placed.tick == seen.tick);
    let mut picture =
        snapshot::picture(config, &objects, &tools, placements.as_ref(), seen.bodies());
    picture.items.extend(models.items(&objects));
    let forces = seen.latest::<ContactForces>().unwrap_or_default();
    let of_tools = (&tools, placements.as_ref());
    let legend = debug::overlay(&mut picture, config, of_tools, &forces, seen.bodies());
    (picture, legend)
}

/// The part of a place in which the left eye's picture is shown, or the one picture.
fn eye(layout: StereoLayout, place: Rect) -> Rect {
    match layout {
        StereoLayout::SideBySide => place.split_left_right_at_fraction(0.5).0,
        StereoLayout::TopBottom => place.split_top_bottom_at_fraction(0.5).0,
        StereoLayout::Mono | StereoLayout::RowInterleaved | StereoLayout::RedCyan => place,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{pos2, vec2};

    /// A hand moves the tip as far as the pointer goes in the picture of one eye.
    #[test]
    fn each_eye_has_its_part_of_the_picture() {
        let place = Rect::from_min_size(pos2(10.0, 20.0), vec2(800.0, 600.0));
        let half = |layout| eye(layout, place).size();
        assert_eq!(half(StereoLayout::Mono), vec2(800.0, 600.0));
        assert_eq!(half(StereoLayout::RowInterleaved), vec2(800.0, 600.0));
        assert_eq!(half(StereoLayout::SideBySide), vec2(400.0, 600.0));
        assert_eq!(half(StereoLayout::TopBottom), vec2(800.0, 300.0));
        assert_eq!(eye(StereoLayout::TopBottom, place).min, place.min);
    }
}
