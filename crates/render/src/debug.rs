//! What can be laid over a picture to see what is computed: the mesh of a body, lines of no return, contacts and their forces, values in colours. Capsules of tools:
//! [`snapshot::capsules`](crate::snapshot::capsules).

use microsim_bus::{BlockView, kind_id};
use microsim_geometry::Pose as Place;
use microsim_message::{ContactForces, TISSUE_FIELDS, ToolPlacements, ToolStates};
use microsim_settings::RendererConfig;
use microsim_vocabulary::{DebugView, Finish};
use nalgebra::{UnitQuaternion, Vector3};

use crate::fields::{Fields, surfaces};
use crate::legend::Legend;
use crate::picture::{Item, Picture};
use crate::shape::Shape;
use crate::snapshot::{capsules, place, seen};
use crate::tissue::Tissue;

/// Radius of the edges of a mesh, in diameters of the field.
const EDGE: f64 = 1e-3;

/// Lays what the configuration asks for over a picture of a tick: of its tools, its contacts and, of kind [`TISSUE_FIELDS`], its blocks. What the colours of surfaces mean, where
/// they mean anything.
pub fn overlay<'a>(
    picture: &mut Picture,
    config: &RendererConfig,
    (tools, placements): (&ToolStates, Option<&ToolPlacements>),
    forces: &ContactForces,
    blocks: impl Iterator<Item = BlockView<'a>>,
) -> Option<Legend> {
    let has = |view| config.views.contains(&view);
    if has(DebugView::Capsules) {
        picture.items.extend(capsules(config, tools, placements));
    }
    if has(DebugView::NoReturn) {
        let lines = lines_of_no_return(config, tools, placements);
        picture.items.extend(lines);
    }
    if has(DebugView::Contacts) {
        picture.items.extend(contacts(forces));
    }
    let blocks: Vec<BlockView<'a>> = blocks
        .filter(|block| block.kind() == kind_id(TISSUE_FIELDS))
        .collect();
    let of = |tissue: &Tissue| {
        let block = blocks.iter().find(|block| block.name() == tissue.body);
        block.map(Fields::of_block).unwrap_or_default()
    };
    bodies(picture, &config.views, of)
}

/// Lays what concerns bodies alone over a picture: their meshes, and their surfaces in colours of what is known of their nodes.
pub fn bodies(
    picture: &mut Picture,
    views: &[DebugView],
    of: impl Fn(&Tissue) -> Fields,
) -> Option<Legend> {
    if views.contains(&DebugView::Wireframe) {
        let radius = EDGE * picture.view.field_diameter;
        let meshes = picture.tissues.iter();
        picture
            .items
            .extend(meshes.map(|tissue| wireframe(tissue, radius)));
    }
    let mut views = views.iter().rev().copied();
    let view = views.find(|view| view.colours_surfaces())?;
    // In the place of what they look like; that of which nothing is known, as before the first tick, stays as it is.
    let (mut known, mut others) = (Vec::new(), Vec::new());
    for tissue in std::mem::take(&mut picture.tissues) {
        match of(&tissue) {
            fields if fields == Fields::default() => others.push(tissue),
            fields => known.push((tissue, fields)),
        }
    }
    picture.tissues = others;
    if known.is_empty() {
        return None;
    }
    let (items, legend) = surfaces(view, &known);
    picture.items.extend(items);
    Some(legend)
}

/// Length of the arrow of a force \[m/N\]: a millimetre for 10 mN.
pub const FORCE_SCALE: f64 = 0.1;

const LINE: [f32; 3] = [0.10, 0.10, 0.35];
const NO_RETURN: [f32; 3] = [1.0, 0.15, 0.10];
const FORCE: [f32; 3] = [0.15, 0.85, 0.25];
const DEPTH: [f32; 3] = [0.95, 0.85, 0.10];

/// The edges of the mesh's surface, as three-sided rods of this radius \[m\].
pub fn wireframe(tissue: &Tissue, radius: f64) -> Item {
    let mut edges: Vec<[u32; 2]> = tissue
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for edge in edges {
        let ends = edge.map(|node| Vector3::from(tissue.positions[node as usize]));
        let Some(along) = (ends[1] - ends[0]).try_normalize(0.0) else {
            continue;
        };
        let helper = if along.x.abs() < 0.6 {
            Vector3::x()
        } else {
            Vector3::y()
        };
        let first = helper.cross(&along).normalize();
        let second = along.cross(&first);
        let base = positions.len() as u32;
        for end in ends {
            for corner in 0..3 {
                let angle = std::f32::consts::TAU * corner as f32 / 3.0;
                let out = first * libm::cosf(angle) + second * libm::sinf(angle);
                positions.push((end + out * radius as f32).into());
            }
        }
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            let [a, b, c, d] = [corner, next, 3 + corner, 3 + next].map(|k| base + k);
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    let shape = Shape::Mesh {
        positions,
        triangles,
    };
    Item::new(shape, [0.0; 3], LINE, Finish::Matte)
}

/// The lines of no return of all tools, thinner than their capsules.
pub fn lines_of_no_return(
    config: &RendererConfig,
    tools: &ToolStates,
    placements: Option<&ToolPlacements>,
) -> Vec<Item> {
    let mut items = Vec::new();
    for (state, tool) in seen(config, tools) {
        let (pose, opening) = place(state, placements);
        let world = Place::from_arrays(pose.position, pose.orientation);
        let parts = tool.capsule.iter().zip(tool.capsules_at(opening));
        for (_, capsule) in parts.filter(|(part, _)| part.lonor) {
            let posed = capsule.posed(&world);
            let shape = Shape::Capsule {
                a: posed.a.into(),
                b: posed.b.into(),
                radius: 0.25 * posed.radius,
            };
            items.push(Item::new(shape, [0.0; 3], NO_RETURN, Finish::Matte));
        }
    }
    items
}

/// Each contact as an arrow along the force on the tissue, which ends at its point of application, and a ball of the radius by which it penetrates.
pub fn contacts(forces: &ContactForces) -> Vec<Item> {
    let mut items = Vec::new();
    for contact in forces.contacts.iter().chain(&forces.between) {
        let force = Vector3::from(contact.force);
        let length = FORCE_SCALE * force.norm();
        if let Some(axis) = force.try_normalize(0.0).filter(|_| length > 0.0) {
            // Half a turn about x where the force points down along z.
            let turn =
                UnitQuaternion::rotation_between(&Vector3::z(), &axis).unwrap_or_else(|| {
                    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
                });
            let from = Vector3::from(contact.point) - axis * length;
            let shape = Shape::Arrow {
                radius: 0.03 * length,
                length,
            };
            let item = Item::new(shape, [0.0; 3], FORCE, Finish::Matte);
            items.push(item.at(from.into(), turn.coords.into()));
        }
        if contact.depth > 0.0 {
            let shape = Shape::Sphere {
                radius: contact.depth,
            };
            items.push(Item::new(shape, contact.point, DEPTH, Finish::Matte));
        }
    }
    items
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::ContactForce;

    /// Two triangles with a common side have five edges of six corners and six triangles each.
    #[test]
    fn each_edge_is_drawn_once() {
        let tissue = Tissue {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [1, 3, 2]],
            ..Tissue::default()
        };
        match wireframe(&tissue, 0.01).shape {
            Shape::Mesh {
                positions,
                triangles,
            } => assert_eq!((positions.len(), triangles.len()), (30, 30)),
            other => panic!("{other:?}"),
        }
    }

    /// A force of 20 mN straight down is an arrow of 2 mm that ends where it acts.
    #[test]
    fn forces_end_where_they_act() {
        let force = ContactForce {
            force: [0.0, 0.0, -0.02],
            point: [1e-3, 0.0, 0.0],
            ..ContactForce::default()
        };
        let forces = ContactForces {
            contacts: vec![force],
            between: Vec::new(),
        };
        let items = contacts(&forces);
        let [item] = items.as_slice() else {
            panic!("{items:?}");
        };
        let place = Place::from_arrays(item.position, item.orientation);
        let tip = place.apply(&Vector3::new(0.0, 0.0, 2e-3));
        assert!((tip - Vector3::new(1e-3, 0.0, 0.0)).norm() < 1e-12, "{tip}");
    }
}
