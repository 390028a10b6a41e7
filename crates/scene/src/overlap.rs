//! How far bodies are inside one another, measured on their shapes alone: what contact found and did is not asked.

use crate::pairs::PairPartner;
use crate::scene::Scene;
use crate::view::BodyView;
use microsim_geometry::{
    Aabb, Capsule, closest_on_triangle, closest_segment_triangle, edge_through_triangle,
    point_in_tetrahedron,
};
use nalgebra::Vector3;

/// A node counts as inside from this fraction of its body's mean edge length on: solvers that iterate leave less.
const INSIDE: f64 = 1e-3;

/// How far a body is inside what it touches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overlap {
    /// How many nodes are deeper than a thousandth of the body's mean edge length.
    pub nodes: usize,
    /// Depth of the deepest node, and of the deepest point of an edge or a face in a tool \[m\], however small.
    pub depth: f64,
}

impl BodyView<'_> {
    /// Overlap with the other bodies, the obstacles and the tools that the body touches; of tools only those that have a motion of
    /// their own.
    pub fn overlap(&self) -> Overlap {
        let (scene, body) = (self.scene, self.index);
        let (nodes, positions) = (&self.surface().nodes, self.positions());
        let mut depths = vec![0.0f64; positions.len()];
        let mut deepest = 0.0f64;
        for pair in &scene.pairs {
            match &pair.with {
                PairPartner::Body(other) if pair.body == body => {
                    scene.depths_in(body, *other, &mut depths);
                }
                PairPartner::Body(other) if *other == body => {
                    scene.depths_in(body, pair.body, &mut depths);
                }
                PairPartner::Obstacle { parts, .. } if pair.body == body => {
                    for part in &scene.obstacle_parts[parts.clone()] {
                        for &node in nodes {
                            let (distance, _) = part.distance(&positions[node as usize]);
                            let depth = &mut depths[node as usize];
                            *depth = depth.max(-distance);
                        }
                    }
                }
                PairPartner::Tool(tool) if pair.body == body => {
                    for capsule in scene.own_capsules(*tool) {
                        for &node in nodes {
                            let p = &positions[node as usize];
                            let depth = &mut depths[node as usize];
                            *depth = depth.max(-capsule.signed_distance(p));
                        }
                        for triangle in &self.surface().triangles {
                            let corners = triangle.map(|node| positions[node as usize]);
                            deepest = deepest.max(depth_of_triangle(&capsule, &corners));
                        }
                    }
                }
                _ => {}
            }
        }
        let least = INSIDE * self.mean_edge_length();
        Overlap {
            nodes: depths.iter().filter(|depth| **depth > least).count(),
            depth: depths.iter().copied().fold(deepest, f64::max),
        }
    }
}

impl Scene {
    /// The capsules of a tool with a motion of its own, as they are now.
    pub fn own_capsules(&self, tool: usize) -> Vec<Capsule> {
        let motions = self.own_motions(self.time(), self.time());
        let motion = motions.iter().find(|motion| motion.tool == tool);
        let capsules = motion.map(|motion| self.tools[tool].capsules_at(motion, 0.0).collect());
        capsules.unwrap_or_default()
    }

    /// Deepens `depths` by how far the nodes of a body are inside another one \[m\].
    fn depths_in(&self, body: usize, other: usize, depths: &mut [f64]) {
        let (nodes, within) = (self.body(body).positions(), self.body(other).positions());
        let Some(common) = common_box(nodes, within) else {
            return;
        };
        let tets = self.body(other).tets().iter();
        let tets = tets.map(|tet| tet.map(|node| within[node as usize]));
        let tets: Vec<(Aabb, [Vector3<f64>; 4])> = tets
            .map(|corners| (Aabb::of(&corners), corners))
            .filter(|(bounds, _)| bounds.overlaps(&common))
            .collect();
        for &node in &self.body(body).surface().nodes {
            let p = &nodes[node as usize];
            let inside = common.contains(p)
                && tets.iter().any(|(bounds, corners)| {
                    bounds.contains(p) && point_in_tetrahedron(p, corners).is_some()
                });
            if inside {
                let distances = self.body(other).surface().triangles.iter().map(|triangle| {
                    let corners = triangle.map(|node| within[node as usize]);
                    (closest_on_triangle(p, &corners).point - p).norm()
                });
                let depth = &mut depths[node as usize];
                *depth = depth.max(distances.fold(f64::INFINITY, f64::min));
            }
        }
    }

    /// Number of edges of one body's surface through triangles of the other's, in both directions.
    pub fn crossings(&self, one: usize, other: usize) -> usize {
        self.edges_through(one, other) + self.edges_through(other, one)
    }

    fn edges_through(&self, one: usize, other: usize) -> usize {
        let (of_edges, of_triangles) = (self.body(one).positions(), self.body(other).positions());
        let Some(common) = common_box(of_edges, of_triangles) else {
            return 0;
        };
        let triangles = self.body(other).surface().triangles.iter();
        let triangles: Vec<(Aabb, [Vector3<f64>; 3])> = triangles
            .map(|triangle| triangle.map(|node| of_triangles[node as usize]))
            .map(|corners| (Aabb::of(&corners), corners))
            .filter(|(bounds, _)| bounds.overlaps(&common))
            .collect();
        let sides = self
            .body(one)
            .surface()
            .triangles
            .iter()
            .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        // Each edge of a closed surface is in two triangles, once in each direction.
        let edges = sides.filter(|[a, b]| a < b);
        let mut count = 0;
        for [a, b] in edges {
            let (p, q) = (&of_edges[a as usize], &of_edges[b as usize]);
            let bounds = Aabb::of([p, q]);
            if bounds.overlaps(&common) {
                let through = |corners| edge_through_triangle(p, q, corners).is_some();
                let near = triangles.iter().filter(|(of, _)| of.overlaps(&bounds));
                count += near.filter(|(_, corners)| through(corners)).count();
            }
        }
        count
    }
}

/// How far the deepest point of a triangle is inside a capsule \[m\]; 0 outside.
fn depth_of_triangle(capsule: &Capsule, corners: &[Vector3<f64>; 3]) -> f64 {
    let Capsule { a, b, radius } = capsule;
    if !Aabb::of(corners).overlaps(&capsule.bounds()) {
        return 0.0;
    }
    (radius - closest_segment_triangle(a, b, corners).distance()).max(0.0)
}

/// What is common to the boxes around two sets of points.
fn common_box(one: &[Vector3<f64>], other: &[Vector3<f64>]) -> Option<Aabb> {
    let (a, b) = (Aabb::of(one), Aabb::of(other));
    a.overlaps(&b).then(|| Aabb {
        min: a.min.sup(&b.min),
        max: a.max.inf(&b.max),
    })
}

#[cfg(test)]
mod tests {
    use super::depth_of_triangle;
    use microsim_geometry::Capsule;
    use nalgebra::Vector3;

    /// A triangle that is far larger than the capsule, in the plane z = 0: its corners are outside in all cases.
    const CORNERS: [[f64; 3]; 3] = [[-10.0, -10.0, 0.0], [10.0, -10.0, 0.0], [0.0, 20.0, 0.0]];

    fn depth(a: [f64; 3], b: [f64; 3]) -> f64 {
        let capsule = Capsule {
            a: a.into(),
            b: b.into(),
            radius: 1.0,
        };
        depth_of_triangle(&capsule, &CORNERS.map(Vector3::from))
    }

    #[test]
    fn faces_and_edges_are_as_deep_as_they_are_near_to_the_axis() {
        // Above the face, with an end towards it, and through it.
        assert_eq!(depth([0.0, 0.0, 0.75], [0.0, 0.0, 5.0]), 0.25);
        assert_eq!(depth([0.0, 0.0, 1.25], [0.0, 0.0, 5.0]), 0.0);
        assert_eq!(depth([0.0, 0.0, -2.0], [0.0, 0.0, 5.0]), 1.0);
        // Across an edge, beside the triangle.
        let beside = depth([0.0, -10.5, -3.0], [0.0, -10.5, 3.0]);
        assert!((beside - 0.5).abs() < 1e-12, "{beside}");
        // The box of the capsule meets that of the triangle, the capsule nothing.
        assert_eq!(depth([-9.0, 18.0, 0.0], [-8.0, 18.0, 0.0]), 0.0);
    }
}
