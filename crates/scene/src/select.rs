//! Which nodes and triangles a description means.

use crate::spec::Selection;
use microsim_geometry::Aabb;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;

/// A region is grown by this fraction of the body's mean edge length, so that one that ends on a layer of nodes holds it whatever
/// the rounding.
const MARGIN: f64 = 1e-6;

/// The nodes of `mesh` that `selection` means, ascending; `origin` is that of the body's frame.
pub(crate) fn nodes(mesh: &TetMesh, origin: &Vector3<f64>, selection: &Selection) -> Vec<u32> {
    let margin = MARGIN * mesh.mean_edge_length();
    let matching = |inside: &dyn Fn(&Vector3<f64>) -> bool| {
        let all = mesh.positions.iter().enumerate();
        all.filter(|(_, p)| inside(&(*p - origin)))
            .map(|(node, _)| node as u32)
            .collect()
    };
    match selection {
        Selection::All => matching(&|_| true),
        Selection::Box(region) => {
            let region = Aabb {
                min: region.min.into(),
                max: region.max.into(),
            };
            let region = region.inflated(margin);
            matching(&|p| region.contains(p))
        }
        Selection::Shell {
            point,
            axis,
            radius,
        } => {
            let point = Vector3::from(*point);
            let axis = Vector3::from(*axis).normalize();
            matching(&|p| {
                let from_axis = (p - point) - axis * axis.dot(&(p - point));
                let distance = from_axis.norm();
                radius[0] - margin <= distance && distance <= radius[1] + margin
            })
        }
        Selection::Nearest(point) => {
            let point = origin + Vector3::from(*point);
            let distances = mesh.positions.iter().map(|p| (p - point).norm_squared());
            let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            nearest.map(|(node, _)| node as u32).into_iter().collect()
        }
    }
}

/// The outward triangles of the surface of which every node is among the selected ones.
pub(crate) fn triangles(surface: &[[u32; 3]], nodes: &[u32]) -> Vec<[u32; 3]> {
    let selected = |node: &u32| nodes.binary_search(node).is_ok();
    surface
        .iter()
        .filter(|triangle| triangle.iter().all(selected))
        .copied()
        .collect()
}
