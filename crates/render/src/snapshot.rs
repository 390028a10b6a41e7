//! From what is published in a tick to a [`Picture`]: the one translation of files and windows.

use microsim_bus::{BlockView, kind_id};
use microsim_geometry::{Capsule, Pose as Place};
use microsim_message::{
    self as message, ObjectScene, ObjectState, TISSUE_ELEMENTS, TISSUE_REST, TISSUE_SNAPSHOT,
    ToolPlacements, ToolState, ToolStates, ToolStatus,
};
use microsim_settings::{self as settings, BodyLook, RendererConfig};
use microsim_vocabulary::Finish;

use crate::instruments::{Instrument, Kind, Sizes};
use crate::picture::{Item, Picture, View};
use crate::shape::Shape;
use crate::tissue::Tissue;

/// Opacity of a tool whose pose is not up to date.
const LOST_OPACITY: f32 = 0.35;
/// Edges of a metal box are rounded by this part of its smallest half.
const ROUNDED: f64 = 0.3;

/// The microscope's field as a level states it, with what is in it.
///
/// `placements` are those of the same tick, if there are any: they go before what `tools` has of the same slots. `blocks` are the
/// newest of kind [`TISSUE_SNAPSHOT`], one per body; bodies that the configuration does not name
/// are not drawn. Where the bodies of [`TISSUE_REST`] and [`TISSUE_ELEMENTS`] are among them, patterns lie where the tissue lies at rest, and layers of a wall are known from
/// the regions; otherwise from how the body lay when it was first drawn.
pub fn picture<'a>(
    config: &RendererConfig,
    objects: &ObjectScene,
    tools: &ToolStates,
    placements: Option<&ToolPlacements>,
    blocks: impl Iterator<Item = BlockView<'a>>,
) -> Picture {
    let view = View::of_microscope(config.view.centre, config.view.field, config.view.tilt);
    let items = items(config, objects, tools, placements);
    Picture {
        tissues: tissues(&config.bodies, blocks),
        mirrored: config.mirrored,
        ..Picture::new((config.width, config.height), view, items)
    }
}

/// What is in the field besides tissue: objects and tools, in this order; objects from files are those of [`Models`](crate::Models).
pub fn items(
    config: &RendererConfig,
    objects: &ObjectScene,
    tools: &ToolStates,
    placements: Option<&ToolPlacements>,
) -> Vec<Item> {
    let objects = objects.objects.iter();
    let mut items: Vec<Item> = objects
        .filter_map(|o| object(o, config.view.field))
        .collect();
    for (state, model) in seen(config, tools) {
        let (pose, opening) = place(state, placements);
        items.extend(tool(&state.model, model, pose, opening, opacity(state)));
    }
    items
}

/// The capsules of all tools, which are what touches tissue, drawn half translucent over the models.
pub fn capsules(
    config: &RendererConfig,
    tools: &ToolStates,
    placements: Option<&ToolPlacements>,
) -> Vec<Item> {
    let all = seen(config, tools).flat_map(|(state, model)| {
        let (pose, opening) = place(state, placements);
        own_capsules(model, pose, opening)
    });
    all.map(|item| Item {
        opacity: LOST_OPACITY,
        ..item
    })
    .collect()
}

/// Tools that were in view at some time, with their shapes.
pub(crate) fn seen<'a>(
    config: &'a RendererConfig,
    tools: &'a ToolStates,
) -> impl Iterator<Item = (&'a ToolState, &'a settings::Tool)> {
    let states = tools.tools.iter();
    let seen = states.filter(|state| state.status != ToolStatus::NeverSeen);
    seen.filter_map(|state| Some((state, config.models.get(&state.model)?)))
}

/// Where a tool is.
pub(crate) fn place(
    state: &ToolState,
    placements: Option<&ToolPlacements>,
) -> (message::Pose, f64) {
    let mut placed = placements.iter().flat_map(|placements| &placements.tools);
    let placed = placed.find(|placed| placed.tool == state.tool);
    placed.map_or((state.pose, state.opening), |placed| {
        (placed.pose, placed.opening)
    })
}

fn opacity(state: &ToolState) -> f32 {
    match state.status {
        ToolStatus::Tracked => 1.0,
        _ => LOST_OPACITY,
    }
}

fn colour(colour: settings::Colour) -> [f32; 3] {
    colour.srgb().map(|c| c as f32)
}

/// An object in the field of view of this diameter \[m\].
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
        message::Shape::Box { half_size: half } if finish == Finish::Metal => {
            let radius = ROUNDED * half.iter().copied().fold(f64::INFINITY, f64::min);
            item(Shape::RoundedBox { half, radius })
        }
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

/// A tool of this name at a pose and opening: its model, or what has none as its capsules.
pub fn tool(
    name: &str,
    tool: &settings::Tool,
    pose: message::Pose,
    opening: f64,
    opacity: f32,
) -> Vec<Item> {
    let model = Kind::of_tool(name).zip(Sizes::of_tool(tool));
    let items = match model {
        Some((kind, sizes)) => {
            let angle = tool.opening_angle.unwrap_or_default();
            let world = Place::from_arrays(pose.position, pose.orientation);
            let parts = Instrument::of(kind, sizes);
            let item = |(model, position, turn): (&std::sync::Arc<_>, [f64; 3], [f64; 4])| {
                let shape = Shape::Model(std::sync::Arc::clone(model));
                let place = Place {
                    position: world.apply(&position.into()),
                    orientation: world.orientation * Place::from_arrays([0.0; 3], turn).orientation,
                };
                let item = Item::new(shape, [0.0; 3], colour(tool.colour), tool.finish);
                item.at(place.position.into(), place.orientation.coords.into())
            };
            parts
                .posed(sizes.pivot, angle, opening)
                .into_iter()
                .map(item)
                .collect()
        }
        None => own_capsules(tool, pose, opening).collect::<Vec<_>>(),
    };
    let faded = items.into_iter().map(|item| Item { opacity, ..item });
    faded.collect()
}

/// A tool at a pose and opening, as its capsules.
fn own_capsules(
    tool: &settings::Tool,
    pose: message::Pose,
    opening: f64,
) -> impl Iterator<Item = Item> {
    let world = Place::from_arrays(pose.position, pose.orientation);
    let (colour, finish) = (colour(tool.colour), tool.finish);
    tool.capsules_at(opening).map(move |capsule| {
        let Capsule { a, b, radius } = capsule.posed(&world);
        let shape = Shape::Capsule {
            a: a.into(),
            b: b.into(),
            radius,
        };
        Item::new(shape, [0.0; 3], colour, finish)
    })
}

/// The bodies of blocks that have a look.
pub fn tissues<'a>(
    bodies: &[BodyLook],
    blocks: impl Iterator<Item = BlockView<'a>>,
) -> Vec<Tissue> {
    let blocks: Vec<BlockView<'a>> = blocks.collect();
    let of_kind = |kind: &str| {
        let kind = kind_id(kind);
        blocks.iter().filter(move |block| block.kind() == kind)
    };
    let named = |kind: &str, name: u64| of_kind(kind).find(|block| block.name() == name);
    of_kind(TISSUE_SNAPSHOT)
        .filter_map(|block| {
            let look = bodies.iter().find(|b| kind_id(&b.name) == block.name())?;
            let rest = named(TISSUE_REST, block.name());
            let elements = named(TISSUE_ELEMENTS, block.name());
            // Of another generation it is not of these nodes.
            let elements = elements.filter(|e| e.generation() == block.generation());
            body(look, block, rest, elements)
        })
        .collect()
}

fn body(
    look: &BodyLook,
    block: &BlockView<'_>,
    rest: Option<&BlockView<'_>>,
    elements: Option<&BlockView<'_>>,
) -> Option<Tissue> {
    let points = |list: &[f64]| -> Vec<[f32; 3]> {
        let points = list.chunks_exact(3);
        points
            .map(|p| [p[0] as f32, p[1] as f32, p[2] as f32])
            .collect()
    };
    let triangles = block.u32s("triangle")?.chunks_exact(3);
    // A session from before cutting has none.
    let inner = block.u32s("inner").unwrap_or_default().iter();
    let positions = points(block.f64s("position")?);
    let of_rest = |name: &str| rest.and_then(|rest| rest.u32s(name)).unwrap_or_default();
    let original = rest.and_then(|rest| rest.f64s("position"));
    let of_elements = elements.and_then(|elements| elements.f64s("rest"));
    let regions = elements.and_then(|elements| elements.u32s("triangle_region"));
    Some(Tissue {
        body: block.name(),
        node_ids: block.u32s("node_id").unwrap_or_default().to_vec(),
        rest: points(of_elements.unwrap_or_default()),
        original_ids: of_rest("node_id").to_vec(),
        original: points(original.unwrap_or_default()),
        triangles: triangles.map(|t| [t[0], t[1], t[2]]).collect(),
        inner: inner.map(|inner| *inner != 0).collect(),
        regions: regions.unwrap_or_default().to_vec(),
        colour: colour(look.colour),
        vein: look.name.contains("vein"),
        positions,
    })
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
            mirrored: false,
            views: Vec::new(),
            caption: None,
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
        let objects = ObjectScene::default();
        let items = items(&config(), &objects, &tools, Some(&placements));
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
        let [tissue] = picture.tissues.as_slice() else {
            panic!("{picture:?}");
        };
        assert_eq!(tissue.triangles, [[0, 1, 2], [1, 2, 3]]);
        assert_eq!(tissue.inner, [false, true]);
        assert_eq!(tissue.positions[3], [9.0, 10.0, 11.0]);
        assert!(tissue.rest.is_empty() && tissue.regions.is_empty());
    }
}
