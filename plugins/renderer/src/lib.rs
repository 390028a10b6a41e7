//! Pictures of the microscope's field, off-screen: a thin adapter over the crate `render`. It hears the latest objects,
//! tools and tissue, and writes a PNG file when the host asks for one. It observes; nothing comes back.
//!
//! The graphics driver is looked for at the first call; without one the plugin says so and the run goes on.

#![forbid(unsafe_code)]

use microsim_geometry::Pose as Place;
use microsim_gpu::Gpu;
use microsim_render::{Finish, Item, Picture, Renderer, Shape, View};
use microsim_sdk::message::{
    self, ObjectScene, ObjectState, PictureRequest, TISSUE_SNAPSHOT, ToolState, ToolStates,
    ToolStatus,
};
use microsim_sdk::{BlockView, Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::{self as settings, BodyLook, RendererConfig};
use nalgebra::{UnitQuaternion, Vector3};
use std::path::Path;

/// What shows where nothing lies: the colour of a wet drape.
const BACKGROUND: [f32; 3] = [0.07, 0.16, 0.17];
/// From the main lens to the focus \[m\]: a usual focal length of surgical microscopes.
const WORKING_DISTANCE: f64 = 0.25;
/// Half the width, and half the thickness, of what stands for a half-space, in fields of view.
const PLANE: f64 = 2.0;
const PLANE_THICKNESS: f64 = 0.02;
/// Opacity of a tool whose pose is not up to date.
const LOST_OPACITY: f32 = 0.35;

/// The renderer of a run.
#[derive(Default)]
pub struct PictureRenderer {
    config: Option<RendererConfig>,
    renderer: Option<Renderer>,
}

fn colour(colour: settings::Colour) -> [f32; 3] {
    [colour.red, colour.green, colour.blue].map(|c| f32::from(c) / 255.0)
}

fn finish(finish: settings::Finish) -> Finish {
    match finish {
        settings::Finish::Matte => Finish::Matte,
        settings::Finish::Moist => Finish::Moist,
        settings::Finish::Metal => Finish::Metal,
    }
}

/// What stands in the field of view of this diameter \[m\].
fn object(object: &ObjectState, field: f64) -> Item {
    // Of a shape whose origin is not where the renderer's is: along its own z axis \[m\].
    let mut raised = 0.0;
    let shape = match object.shape {
        message::Shape::Sphere { radius } => Shape::Sphere { radius },
        message::Shape::Capsule { radius, length } => Shape::Capsule {
            a: [0.0, 0.0, -0.5 * length],
            b: [0.0, 0.0, 0.5 * length],
            radius,
        },
        message::Shape::Box { half_size } => Shape::Box { half: half_size },
        message::Shape::Ring { radius, tube } => Shape::Ring {
            radius,
            tube,
            fraction: 1.0,
        },
        message::Shape::HalfSpace => {
            let half = [PLANE * field, PLANE * field, PLANE_THICKNESS * field];
            raised = -half[2];
            Shape::Box { half }
        }
        message::Shape::Cylinder { radius, length } => {
            raised = -0.5 * length;
            Shape::Cylinder {
                radius,
                height: length,
            }
        }
    };
    let place = Place::from_arrays(object.pose.position, object.pose.orientation);
    Item {
        shape,
        position: place.apply(&Vector3::new(0.0, 0.0, raised)).into(),
        orientation: object.pose.orientation,
        colour: object.colour.map(|c| c as f32),
        finish: match object.finish {
            message::Finish::Matte => Finish::Matte,
            message::Finish::Moist => Finish::Moist,
            message::Finish::Metal => Finish::Metal,
        },
        opacity: 1.0,
    }
}

/// A tool as its capsules; jaws turned about the hinge, each by half of the opening.
fn tool(state: &ToolState, model: &settings::Tool) -> Vec<Item> {
    let world = Place::from_arrays(state.pose.position, state.pose.orientation);
    let half = 0.5 * model.opening_angle.unwrap_or_default() * state.opening;
    let items = model.capsule.iter().map(|part| {
        let angle = match part.jaw {
            settings::Jaw::Fixed => 0.0,
            // Below the hinge a right-handed turn about +y moves the jaw towards -x; the left one opens towards +x.
            settings::Jaw::Left => -half,
            settings::Jaw::Right => half,
        };
        let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle);
        let hinge = Vector3::from(model.hinge.unwrap_or_default());
        let posed = |p: [f64; 3]| {
            world
                .apply(&(hinge + turn * (Vector3::from(p) - hinge)))
                .into()
        };
        let shape = Shape::Capsule {
            a: posed(part.a),
            b: posed(part.b),
            radius: part.radius,
        };
        let item = Item::new(shape, [0.0; 3], colour(model.colour), finish(model.finish));
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
        finish(body.finish),
    ))
}

impl PictureRenderer {
    fn picture(config: &RendererConfig, tick: &Tick<'_>) -> Result<Picture, Fault> {
        let scene = tick.latest::<ObjectScene>()?.unwrap_or_default();
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default();
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
            view: View {
                centre: config.view.centre,
                field_diameter: config.view.field,
                working_distance: WORKING_DISTANCE.max(config.view.field),
                tilt: config.view.tilt,
            },
            background: BACKGROUND,
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
