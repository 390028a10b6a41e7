//! Pictures of the microscope's field, off-screen: a thin adapter over the crate `render`. It reads the latest
//! objects, tools and tissue, and writes a PNG file when the host asks for one. It publishes nothing.
//!
//! The graphics driver is looked for at the first call; without one the plugin reports that and the run goes on.

#![forbid(unsafe_code)]

use microsim_geometry::{Capsule, Pose as Place};
use microsim_gpu::Gpu;
use microsim_render::{DRAPE, Item, Picture, Renderer, Shape, View};
use microsim_sdk::message::{
    self, ObjectScene, ObjectState, PictureRequest, TISSUE_SNAPSHOT, ToolPlacements, ToolState,
    ToolStates, ToolStatus,
};
use microsim_sdk::{BlockView, Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::{self as settings, BodyLook, RendererConfig};
use std::path::Path;

/// Opacity of a tool whose pose is not up to date.
const LOST_OPACITY: f32 = 0.35;

/// The renderer of a run.
#[derive(Default)]
pub struct PictureRenderer {
    config: Option<RendererConfig>,
    renderer: Option<Renderer>,
}

fn colour(colour: settings::Colour) -> [f32; 3] {
    colour.srgb().map(|c| c as f32)
}

/// An object in the field of view of this diameter \[m\].
fn object(object: &ObjectState, field: f64) -> Item {
    let (position, orientation) = (object.pose.position, object.pose.orientation);
    let colour = object.colour.map(|c| c as f32);
    let finish = object.finish;
    let item = |shape| Item::new(shape, position, colour, finish).at(position, orientation);
    match object.shape {
        message::Shape::Sphere { radius } => item(Shape::Sphere { radius }),
        message::Shape::Capsule { radius, length } => item(Shape::Capsule {
            a: [0.0, 0.0, -0.5 * length],
            b: [0.0, 0.0, 0.5 * length],
            radius,
        }),
        message::Shape::Box { half_size } => item(Shape::Box { half: half_size }),
        message::Shape::Ring { radius, tube } => item(Shape::Ring {
            radius,
            tube,
            fraction: 1.0,
        }),
        message::Shape::HalfSpace => Item::half_space(position, orientation, field, colour, finish),
        message::Shape::Cylinder { radius, length } => {
            let height = length;
            item(Shape::Cylinder { radius, height }).raised(-0.5 * length)
        }
    }
}

/// A tool as its capsules.
fn tool(state: &ToolState, model: &settings::Tool) -> Vec<Item> {
    let world = Place::from_arrays(state.pose.position, state.pose.orientation);
    let items = model.capsules_at(state.opening).map(|capsule| {
        let Capsule { a, b, radius } = capsule.posed(&world);
        let shape = Shape::Capsule {
            a: a.into(),
            b: b.into(),
            radius,
        };
        let item = Item::new(shape, [0.0; 3], colour(model.colour), model.finish);
        let opacity = if state.status == ToolStatus::Tracked {
            1.0
        } else {
            LOST_OPACITY
        };
        Item { opacity, ..item }
    });
    items.collect()
}

fn body(block: &BlockView<'_>, bodies: &[BodyLook]) -> Option<Vec<Item>> {
    let body = bodies
        .iter()
        .find(|b| microsim_sdk::name_id(&b.name) == block.name())?;
    let positions = block
        .f64s("position")?
        .chunks_exact(3)
        .map(|p| [p[0] as f32, p[1] as f32, p[2] as f32]);
    let triangles = block
        .u32s("triangle")?
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]]);
    // A session from before cutting has none.
    let inner = block
        .u32s("inner")
        .unwrap_or_default()
        .iter()
        .map(|inner| *inner != 0);
    Some(Item::tissue(
        positions.collect(),
        &triangles.collect::<Vec<_>>(),
        &inner.collect::<Vec<_>>(),
        colour(body.colour),
        body.finish,
    ))
}

impl PictureRenderer {
    fn picture(config: &RendererConfig, tick: &Tick<'_>) -> Result<Picture, Fault> {
        let scene = tick.latest::<ObjectScene>()?.unwrap_or_default();
        let mut tools = tick.latest::<ToolStates>()?.unwrap_or_default();
        let placed = tick.latest::<ToolPlacements>()?;
        for placed in placed
            .filter(|p| p.tick == tick.index())
            .iter()
            .flat_map(|p| &p.tools)
        {
            let of_slot = |state: &&mut ToolState| state.tool == placed.tool;
            if let Some(state) = tools.tools.iter_mut().find(of_slot) {
                (state.pose, state.opening) = (placed.pose, placed.opening);
            }
        }
        let mut items: Vec<Item> = scene
            .objects
            .iter()
            .map(|o| object(o, config.view.field))
            .collect();
        items.extend(
            tick.blocks(TISSUE_SNAPSHOT)
                .filter_map(|b| body(&b, &config.bodies))
                .flatten(),
        );
        for state in tools
            .tools
            .iter()
            .filter(|t| t.status != ToolStatus::NeverSeen)
        {
            if let Some(model) = config.models.get(&state.model) {
                items.extend(tool(state, model));
            }
        }
        Ok(Picture {
            width: config.width,
            height: config.height,
            view: View::of_microscope(config.view.centre, config.view.field, config.view.tilt),
            background: DRAPE,
            items,
        })
    }
}

impl Plugin for PictureRenderer {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        self.config = Some(setup.configuration()?);
        let gpu = Gpu::off_screen().map_err(|error| Fault::unavailable(error.to_string()))?;
        let renderer = Renderer::new(&gpu);
        self.renderer = Some(renderer.map_err(|error| Fault::unavailable(error.to_string()))?);
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
            let picture = Self::picture(config, tick)?;
            let image = renderer
                .draw(&picture)
                .map_err(|error| Fault::new(error.to_string()))?;
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
