//! From what is published in a tick to a [`Picture`]: the one translation that files and windows share.

use microsim_bus::{BlockView, kind_id};
use microsim_geometry::{Capsule, Pose as Place};
use microsim_message::{
    self as message, ObjectScene, ObjectState, ToolPlacements, ToolState, ToolStates, ToolStatus,
};
use microsim_settings::{self as settings, BodyLook, RendererConfig};

use crate::picture::{DRAPE, Item, Picture, Shape, View};

/// Opacity of a tool whose pose is not up to date.
const LOST_OPACITY: f32 = 0.35;

/// The microscope's field as a level states it, with what is in it.
///
/// `placements` are those of the same tick, if there are any: they go before what `tools` has of the same slots. `blocks` are the
/// newest of kind [`TISSUE_SNAPSHOT`](microsim_message::TISSUE_SNAPSHOT), one per body; bodies that the configuration does not name
/// are not drawn.
pub fn picture<'a>(
    config: &RendererConfig,
    objects: &ObjectScene,
    tools: &ToolStates,
    placements: Option<&ToolPlacements>,
    blocks: impl Iterator<Item = BlockView<'a>>,
) -> Picture {
    Picture {
        width: config.width,
        height: config.height,
        view: View::of_microscope(config.view.centre, config.view.field, config.view.tilt),
        background: DRAPE,
        items: items(config, objects, tools, placements, blocks),
    }
}

/// What is in the field: objects, bodies, tools, in this order; objects from files are those of [`Models`](crate::Models).
pub fn items<'a>(
    config: &RendererConfig,
    objects: &ObjectScene,
    tools: &ToolStates,
    placements: Option<&ToolPlacements>,
    blocks: impl Iterator<Item = BlockView<'a>>,
) -> Vec<Item> {
    let objects = objects.objects.iter();
    let mut items: Vec<Item> = objects
        .filter_map(|o| object(o, config.view.field))
        .collect();
    items.extend(
        blocks
            .filter_map(|block| body(&block, &config.bodies))
            .flatten(),
    );
    let seen = tools
        .tools
        .iter()
        .filter(|t| t.status != ToolStatus::NeverSeen);
    for state in seen {
        let Some(model) = config.models.get(&state.model) else {
            continue;
        };
        let mut placed = placements.iter().flat_map(|placements| &placements.tools);
        let place = placed.find(|placed| placed.tool == state.tool);
        let (pose, opening) = place.map_or((state.pose, state.opening), |placed| {
            (placed.pose, placed.opening)
        });
        items.extend(tool(state, pose, opening, model));
    }
    items
}

fn colour(colour: settings::Colour) -> [f32; 3] {
    colour.srgb().map(|c| c as f32)
}

/// An object in the field of view of this diameter \[m\]; none if it is a model from a file.
fn object(object: &ObjectState, field: f64) -> Option<Item> {
    let (position, orientation) = (object.pose.position, object.pose.orientation);
    let colour = object.colour.map(|c| c as f32);
    let finish = object.finish;
    let item = |shape| Item::new(shape, position, colour, finish).at(position, orientation);
    let item = match object.shape {
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
        message::Shape::Model { .. } => return None,
    };
    Some(item)
}

/// A tool at a pose and opening, as its capsules.
fn tool(
    state: &ToolState,
    pose: message::Pose,
    opening: f64,
    model: &settings::Tool,
) -> impl Iterator<Item = Item> {
    let world = Place::from_arrays(pose.position, pose.orientation);
    let opacity = match state.status {
        ToolStatus::Tracked => 1.0,
        _ => LOST_OPACITY,
    };
    let (colour, finish) = (colour(model.colour), model.finish);
    model.capsules_at(opening).map(move |capsule| {
        let Capsule { a, b, radius } = capsule.posed(&world);
        let shape = Shape::Capsule {
            a: a.into(),
            b: b.into(),
            radius,
        };
        let item = Item::new(shape, [0.0; 3], colour, finish);
        Item { opacity, ..item }
    })
}

fn body(block: &BlockView<'_>, bodies: &[BodyLook]) -> Option<Vec<Item>> {
    let body = bodies.iter().find(|b| kind_id(&b.name) == block.name())?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_bus::BlockBuilder;
    use microsim_message::{Pose, TISSUE_SNAPSHOT, ToolPlacement};
    use microsim_settings::read_tool;

    const TOOL: &str = r##"doc = "A rod."
colour = "#ff0000"
[title]
de = "Stab"
en = "Rod"
[[capsule]]
name = "rod"
a = [0, 0, "1 mm"]
b = [0, 0, "5 mm"]
radius = "0.5 mm"
"##;

    fn config() -> RendererConfig {
        let rod = read_tool(TOOL, "rod.toml").unwrap().settings;
        RendererConfig {
            view: settings::View {
                field: 0.02,
                centre: [0.0, 0.0, 1e-3],
                tilt: 0.0,
            },
            models: [("rod".to_owned(), rod)].into(),
            bodies: vec![BodyLook {
                name: "strip".to_owned(),
                colour: serde_json::from_str("\"#0000ff\"").unwrap(),
                finish: message::Finish::Moist,
            }],
            width: 64,
            height: 32,
        }
    }

    fn state(tool: &str, status: ToolStatus, x: f64) -> ToolState {
        ToolState {
            tool: tool.to_owned(),
            model: "rod".to_owned(),
            status,
            pose: at(x),
            opening: 0.0,
        }
    }

    fn at(x: f64) -> Pose {
        Pose {
            position: [x, 0.0, 0.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
        }
    }

    /// A placement goes before the tracked pose of the same slot alone; a tool never seen is not there, a lost one is faint; each item
    /// is where the message put it.
    #[test]
    fn tools_are_where_they_are_placed() {
        let tools = ToolStates {
            tools: vec![
                state("left", ToolStatus::Tracked, 1e-3),
                state("right", ToolStatus::Stale, 2e-3),
                state("third", ToolStatus::NeverSeen, 3e-3),
            ],
        };
        let placements = ToolPlacements {
            tick: 4,
            tools: vec![ToolPlacement {
                tool: "left".to_owned(),
                pose: at(7e-3),
                opening: 0.0,
            }],
        };
        let none = std::iter::empty();
        let objects = ObjectScene::default();
        let items = items(&config(), &objects, &tools, Some(&placements), none);
        let ends: Vec<([f64; 3], f32)> = items
            .iter()
            .map(|item| match item.shape {
                Shape::Capsule { a, .. } => (a, item.opacity),
                _ => panic!("{item:?}"),
            })
            .collect();
        assert_eq!(
            ends,
            [([7e-3, 0.0, 1e-3], 1.0), ([2e-3, 0.0, 1e-3], LOST_OPACITY)]
        );
    }

    /// Outer and opened faces of a body that the configuration names; another body is left out.
    #[test]
    fn bodies_are_those_with_a_look() {
        let block = |name| {
            let builder = BlockBuilder::new(TISSUE_SNAPSHOT, name, 1, 0)
                .f64s("position", (0..12).map(f64::from))
                .u32s("triangle", [0, 1, 2, 1, 2, 3])
                .u32s("inner", [0, 1]);
            builder.finish()
        };
        let (strip, other) = (block("strip"), block("other"));
        let blocks = [&other, &strip].map(|words| BlockView::new(words).unwrap());
        let (objects, tools) = (ObjectScene::default(), ToolStates::default());
        let picture = picture(&config(), &objects, &tools, None, blocks.into_iter());
        assert_eq!((picture.width, picture.height), (64, 32));
        assert_eq!(picture.view.centre, [0.0, 0.0, 1e-3]);
        let triangles: Vec<&[[u32; 3]]> = picture
            .items
            .iter()
            .map(|item| match &item.shape {
                Shape::Mesh { triangles, .. } => triangles.as_slice(),
                _ => panic!("{item:?}"),
            })
            .collect();
        assert_eq!(triangles, [[[0, 1, 2]], [[1, 2, 3]]]);
    }
}
