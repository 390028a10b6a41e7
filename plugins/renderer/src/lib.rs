//! Pictures of the microscope's field, off-screen: a thin adapter over the crate `render`. It reads the latest
//! objects, tools and tissue, and writes a PNG file when the host asks for one, as the microscope was set. It publishes nothing.
//!
//! The graphics driver is looked for at the first call; without one the plugin reports that and the run goes on.

#![forbid(unsafe_code)]

use microsim_gpu::Gpu;
use microsim_render::{
    Legend, LegendWords, Models, Picture, Quality, Renderer, View, debug, snapshot,
};
use microsim_sdk::message::{
    ContactForces, MicroscopeView, ObjectScene, PictureRequest, TISSUE_ELEMENTS, TISSUE_FIELDS,
    TISSUE_REST, TISSUE_SNAPSHOT, ToolPlacements, ToolStates,
};
use microsim_sdk::{Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::RendererConfig;
use std::path::Path;

/// The renderer of a run.
#[derive(Default)]
pub struct PictureRenderer {
    config: Option<RendererConfig>,
    renderer: Option<Renderer>,
    models: Models,
}

impl PictureRenderer {
    fn picture(
        config: &RendererConfig,
        models: &mut Models,
        tick: &Tick<'_>,
    ) -> Result<(Picture, Option<Legend>), Fault> {
        let objects = tick.latest::<ObjectScene>()?.unwrap_or_default();
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default();
        let placements = tick.latest::<ToolPlacements>()?;
        let placements = placements.filter(|placed| placed.tick == tick.index());
        let kinds = [TISSUE_SNAPSHOT, TISSUE_REST, TISSUE_ELEMENTS];
        let blocks = kinds.into_iter().flat_map(|kind| tick.blocks(kind));
        let mut picture = snapshot::picture(config, &objects, &tools, placements.as_ref(), blocks);
        picture.items.extend(models.items(&objects));
        if let Some(MicroscopeView { centre, field }) = tick.latest()? {
            picture.view = View::of_microscope(centre, field, config.view.tilt);
        }
        let forces = tick.latest::<ContactForces>()?.unwrap_or_default();
        let tools = (&tools, placements.as_ref());
        let fields = tick.blocks(TISSUE_FIELDS);
        let legend = debug::overlay(&mut picture, config, tools, &forces, fields);
        Ok((picture, legend))
    }
}

impl Plugin for PictureRenderer {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        self.config = Some(setup.configuration()?);
        let files = setup.files.iter();
        let files: Vec<(&str, &[u8])> = files
            .map(|file| (&file.name[..], &file.bytes[..]))
            .collect();
        self.models = Models::new(&files).map_err(Fault::new)?;
        let gpu = Gpu::off_screen().map_err(|error| Fault::unavailable(error.to_string()))?;
        let renderer = Renderer::new(&gpu);
        let mut renderer = renderer.map_err(|error| Fault::unavailable(error.to_string()))?;
        // Whoever looks at a file has time, with a software driver too.
        renderer.set_quality(Quality::Medium);
        self.renderer = Some(renderer);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let (Some(config), Some(renderer)) = (&self.config, &mut self.renderer) else {
            return Err(Fault::new("not initialised"));
        };
        for request in tick.messages::<PictureRequest>()? {
            let (picture, legend) = Self::picture(config, &mut self.models, tick)?;
            let mut image = renderer
                .draw(&picture)
                .map_err(|error| Fault::new(error.to_string()))?;
            if let Some(legend) = legend {
                image.write_legend(&legend, &LegendWords::ENGLISH);
            }
            if let Some(caption) = &config.caption {
                image.write_caption(caption);
            }
            let written = image.write_png(Path::new(&request.file));
            written
                .map_err(|error| Fault::new(format!("cannot write {}: {error}", request.file)))?;
        }
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    fn restore(&mut self, _: &[u8]) -> Result<(), Fault> {
        Ok(())
    }
}

export_plugin!(PictureRenderer, "../plugin.toml");
