//! The surface that is shown of a body: vertices divided at creases, triangles finer than the mesh.
//!
//! Where two triangles of one layer meet at less than [`CREASE`] the surface is smooth, elsewhere it has an edge, and so it has between what was outside from
//! the start and what a cut has opened. Smoothly joined triangles are the control mesh of curved point-normal triangles (Vlachos et al. 2001), of which one or two
//! steps of midpoints are shown: the midpoint of an edge leaves its chord by an eighth of the sum of what its ends' tangent planes leave it. On an edge both sides
//! have the same midpoint, that of the curve which is tangent to both sides' planes at both ends, so that nothing gapes.
//!
//! The topology is made once per change of the triangles, places and normals per picture.

use crate::mesh::Vertex;
use nalgebra::Vector3;

/// Angle between the normals of two triangles from which on their common edge is sharp \[rad\]: 40°, more than the 30° between the facets of a tube with 12 of
/// them, less than the 90° at its ends.
pub const CREASE: f32 = 40.0 * std::f32::consts::PI / 180.0;
/// A midpoint leaves its chord by this part of the edge at most: an arc of 55°. Crumpled triangles would bulge.
const BULGE: f32 = 0.12;
/// Triangles that are shown at most; a body with more has fewer steps.
const TRIANGLES: usize = 32_000;

/// A new vertex in the middle of an edge.
#[derive(Clone, Copy, Debug)]
struct Middle {
    ends: [u32; 2],
    /// The ends as the other side of a sharp edge has them; the same where there is no other side.
    other: [u32; 2],
}

/// One step of refinement.
#[derive(Clone, Debug, Default)]
struct Step {
    middles: Vec<Middle>,
    triangles: Vec<[u32; 3]>,
}

/// What is shown of one body, as long as its triangles are the same.
#[derive(Clone, Debug, Default)]
pub(crate) struct Display {
    /// The node of each of the first vertices.
    nodes: Vec<u32>,
    /// Layer of each vertex.
    layers: Vec<u8>,
    base: Vec<[u32; 3]>,
    steps: Vec<Step>,
}

impl Display {
    /// Of triangles with a layer each, whose nodes lie at `reference` where edges are looked for; `finest` is the largest number of steps.
    pub fn new(
        triangles: &[[u32; 3]],
        layers: &[u8],
        reference: &[Vector3<f32>],
        finest: usize,
    ) -> Self {
        let mut display = split(triangles, layers, reference);
        let mut points: Vec<u32> = display.nodes.clone();
        let mut current = display.base.clone();
        while display.steps.len() < finest && 4 * current.len() <= TRIANGLES {
            let step = display.refine(&current, &mut points);
            current.clone_from(&step.triangles);
            display.steps.push(step);
        }
        display
    }

    /// Layer of each vertex.
    pub fn layers(&self) -> &[u8] {
        &self.layers
    }

    /// The triangles that are shown.
    pub fn triangles(&self) -> &[[u32; 3]] {
        self.steps.last().map_or(&self.base, |step| &step.triangles)
    }

    /// A quantity of the nodes, interpolated to all vertices.
    pub fn interpolated(&self, of_nodes: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mut all: Vec<[f32; 3]> = self
            .nodes
            .iter()
            .map(|&node| of_nodes[node as usize])
            .collect();
        for middle in self.steps.iter().flat_map(|step| &step.middles) {
            let [a, b] = middle.ends.map(|end| all[end as usize]);
            all.push(std::array::from_fn(|k| 0.5 * (a[k] + b[k])));
        }
        all
    }

    /// Places and normals of all vertices for nodes at `positions`.
    pub fn evaluate(&self, positions: &[[f32; 3]], out: &mut Vec<Vertex>) {
        out.clear();
        out.extend(self.nodes.iter().map(|&node| Vertex {
            position: positions[node as usize],
            normal: [0.0; 3],
        }));
        normals(&self.base, out);
        for step in &self.steps {
            for middle in &step.middles {
                let vertex = |index: u32| out[index as usize];
                let position = middle_of(middle.ends.map(vertex), middle.other.map(vertex));
                out.push(Vertex {
                    position: position.into(),
                    normal: [0.0; 3],
                });
            }
            normals(&step.triangles, out);
        }
    }

    /// Divides each triangle into four. `points` has the same number for vertices that are at the same place.
    fn refine(&mut self, triangles: &[[u32; 3]], points: &mut Vec<u32>) -> Step {
        let edges = edges_of(triangles, points);
        let mut middle_of_side = vec![u32::MAX; 3 * triangles.len()];
        let mut step = Step::default();
        let first_point = points.iter().copied().max().map_or(0, |most| most + 1);
        let groups = edges.chunk_by(|a, b| a.points == b.points);
        for (next_point, group) in (first_point..).zip(groups) {
            // One middle per pair of vertices; sides of a sharp edge know each other.
            let first = step.middles.len();
            for edge in group {
                let known = step.middles[first..]
                    .iter()
                    .position(|middle| middle.ends == edge.vertices);
                let place = first
                    + known.unwrap_or_else(|| {
                        step.middles.push(Middle {
                            ends: edge.vertices,
                            other: edge.vertices,
                        });
                        self.layers.push(self.layers[edge.vertices[0] as usize]);
                        points.push(next_point);
                        step.middles.len() - 1 - first
                    });
                let before = points.len() - (step.middles.len() - place);
                middle_of_side[edge.side as usize] = before as u32;
            }
            if let [a, b] = &mut step.middles[first..] {
                (a.other, b.other) = (b.ends, a.ends);
            }
        }
        step.triangles = triangles
            .iter()
            .enumerate()
            .flat_map(|(index, &[a, b, c])| {
                let [ab, bc, ca] = [0, 1, 2].map(|side| middle_of_side[3 * index + side]);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
        step
    }
}

/// One side of a triangle.
struct Edge {
    /// Of its ends, the smaller first.
    points: [u32; 2],
    /// In the order of `points`.
    vertices: [u32; 2],
    /// Three times the triangle and the number of its first corner there.
    side: u32,
}

/// All sides, those between the same points next to each other.
fn edges_of(triangles: &[[u32; 3]], points: &[u32]) -> Vec<Edge> {
    let mut edges: Vec<Edge> = Vec::with_capacity(3 * triangles.len());
    for (index, triangle) in triangles.iter().enumerate() {
        for corner in 0..3 {
            let (a, b) = (triangle[corner], triangle[(corner + 1) % 3]);
            let (p, q) = (points[a as usize], points[b as usize]);
            edges.push(Edge {
                points: [p.min(q), p.max(q)],
                vertices: if p <= q { [a, b] } else { [b, a] },
                side: (3 * index + corner) as u32,
            });
        }
    }
    edges.sort_unstable_by_key(|edge| (edge.points, edge.side));
    edges
}

/// One vertex per node and smooth fan of triangles around it.
fn split(triangles: &[[u32; 3]], layers: &[u8], reference: &[Vector3<f32>]) -> Display {
    let normal_of = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|node| reference[node as usize]);
        (b - a).cross(&(c - a)).try_normalize(0.0)
    };
    let normals: Vec<Option<Vector3<f32>>> = triangles.iter().map(normal_of).collect();
    let identity: Vec<u32> = (0..reference.len() as u32).collect();
    // Corners of triangles, three each, joined by a forest of parents.
    let mut parents: Vec<u32> = (0..3 * triangles.len() as u32).collect();
    let root = |parents: &mut Vec<u32>, mut corner: u32| {
        while parents[corner as usize] != corner {
            parents[corner as usize] = parents[parents[corner as usize] as usize];
            corner = parents[corner as usize];
        }
        corner
    };
    let corner_at = |triangle: usize, node: u32| {
        let corner = triangles[triangle].iter().position(|&at| at == node);
        corner.map(|corner| (3 * triangle + corner) as u32)
    };
    let least = libm::cosf(CREASE);
    for group in edges_of(triangles, &identity).chunk_by(|a, b| a.points == b.points) {
        let [first, second] = group else { continue };
        let (f, g) = (first.side as usize / 3, second.side as usize / 3);
        let smooth = match (normals[f], normals[g]) {
            (Some(n), Some(m)) => n.dot(&m) > least,
            // A triangle without area has no side of its own.
            _ => true,
        };
        if layers[f] != layers[g] || !smooth {
            continue;
        }
        for node in first.points {
            if let (Some(a), Some(b)) = (corner_at(f, node), corner_at(g, node)) {
                let (a, b) = (root(&mut parents, a), root(&mut parents, b));
                parents[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut display = Display::default();
    let mut vertex_of = vec![u32::MAX; parents.len()];
    for (index, triangle) in triangles.iter().enumerate() {
        let corners = [0, 1, 2].map(|corner| {
            let root = root(&mut parents, (3 * index + corner) as u32) as usize;
            if vertex_of[root] == u32::MAX {
                vertex_of[root] = display.nodes.len() as u32;
                display.nodes.push(triangle[corner]);
                display.layers.push(layers[index]);
            }
            vertex_of[root]
        });
        display.base.push(corners);
    }
    display
}

/// Sum of the normals of the triangles at each vertex in the order of the triangles, weighted as Max (1999) does, by the sine of the corner's angle over the lengths of its
/// sides, so that it does not matter which diagonal divides a quadrangle; unit length.
fn normals(triangles: &[[u32; 3]], vertices: &mut [Vertex]) {
    for vertex in vertices.iter_mut() {
        vertex.normal = [0.0; 3];
    }
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| Vector3::from(vertices[index as usize].position));
        // Twice the area long.
        let normal = (b - a).cross(&(c - a));
        let squares = [b - a, c - b, a - c].map(|side| side.norm_squared());
        for (corner, &index) in triangle.iter().enumerate() {
            let weight = squares[corner] * squares[(corner + 2) % 3];
            if weight > 0.0 {
                let sum = &mut vertices[index as usize].normal;
                *sum = (Vector3::from(*sum) + normal / weight).into();
            }
        }
    }
    for vertex in vertices {
        let sum = Vector3::from(vertex.normal);
        // Where only flat triangles meet, any normal will do.
        let unit = sum.try_normalize(0.0).unwrap_or_else(Vector3::z);
        vertex.normal = unit.into();
    }
}

/// The middle of the curved edge between two vertices; `other` are those of the other side of a sharp edge.
fn middle_of(ends: [Vertex; 2], other: [Vertex; 2]) -> Vector3<f32> {
    let [p, q] = ends.map(|end| Vector3::from(end.position));
    let [n, m] = ends.map(|end| Vector3::from(end.normal));
    let (chord, straight) = (q - p, 0.5 * (p + q));
    let [along_p, along_q] = [0, 1].map(|end| {
        let between = Vector3::from(ends[end].normal).cross(&Vector3::from(other[end].normal));
        // Below 12° between them two planes have no line of their own.
        let line = between.try_normalize(0.2)?;
        Some(line * chord.dot(&line).signum())
    });
    let bulge = match (along_p, along_q) {
        (Some(t), Some(u)) => (t - u) * (0.125 * chord.norm()),
        _ => (m * chord.dot(&m) - n * chord.dot(&n)) * 0.125,
    };
    let (size, most) = (bulge.norm(), BULGE * chord.norm());
    let allowed = if size > most { most / size } else { 1.0 };
    straight + bulge * allowed
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{PI, TAU};

    /// An open tube of 12 facets: walls of radius 1, and its end faces to radius 0.5.
    fn tube() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let mut positions = Vec::new();
        for x in [0.0, 1.0] {
            for radius in [1.0, 0.5] {
                for k in 0..12 {
                    let angle = TAU * k as f32 / 12.0;
                    positions.push([x, radius * angle.cos(), radius * angle.sin()]);
                }
            }
        }
        let mut triangles = Vec::new();
        for k in 0..12_u32 {
            let next = (k + 1) % 12;
            let mut quad = |a: [u32; 2], b: [u32; 2], turned: bool| {
                for t in [[a[0], a[1], b[1]], [a[0], b[1], b[0]]] {
                    triangles.push(if turned { [t[0], t[2], t[1]] } else { t });
                }
            };
            quad([k, next], [24 + k, 24 + next], true);
            quad([12 + k, 12 + next], [36 + k, 36 + next], false);
            quad([k, next], [12 + k, 12 + next], false);
            quad([24 + k, 24 + next], [36 + k, 36 + next], true);
        }
        (positions, triangles)
    }

    fn display(positions: &[[f32; 3]], triangles: &[[u32; 3]], steps: usize) -> Display {
        let reference: Vec<Vector3<f32>> = positions.iter().map(|p| (*p).into()).collect();
        Display::new(triangles, &vec![0; triangles.len()], &reference, steps)
    }

    /// A tube of 12 facets is round after two steps: the facets leave the circle by 1 − cos 15° = 3.4 % of the radius, the cubic curve through tangent ends by
    /// 0.01 % in its middle (Hermite), the chords of 48 facets by 1 − cos 3.75° = 0.21 %. The sharp edges at the ends lie on the same circles, and both sides of
    /// them at the same places.
    #[test]
    fn coarse_tube_is_round_and_closed() {
        let (positions, triangles) = tube();
        let display = display(&positions, &triangles, 2);
        let mut vertices = Vec::new();
        display.evaluate(&positions, &mut vertices);
        assert_eq!(display.triangles().len(), 16 * triangles.len());
        let radius = |p: [f32; 3]| p[1].hypot(p[2]);
        let on_wall = |v: &&Vertex| v.normal[0].abs() < 0.5;
        for vertex in vertices.iter().filter(on_wall) {
            let found = radius(vertex.position);
            let expected = if found > 0.75 { 1.0 } else { 0.5 };
            let relative = (found / expected - 1.0).abs();
            assert!(relative < 0.0023, "{vertex:?}: {relative}");
        }
        // End faces are flat, and as wide as the walls.
        let end: Vec<&Vertex> = vertices
            .iter()
            .filter(|v| v.normal[0].abs() > 0.99)
            .collect();
        assert!(
            end.iter()
                .all(|v| v.position[0].min(1.0 - v.position[0]).abs() < 1e-6)
        );
        let widest = end.iter().map(|v| radius(v.position)).fold(0.0, f32::max);
        assert!((widest - 1.0).abs() < 0.0023, "{widest}");
        // No gap: every corner of an end face's rim is also one of a wall.
        let rim = end.iter().filter(|v| radius(v.position) > 0.98);
        for vertex in rim {
            let twin = vertices.iter().filter(on_wall).any(|wall| {
                (Vector3::from(wall.position) - Vector3::from(vertex.position)).norm() < 1e-6
            });
            assert!(twin, "{vertex:?}");
        }
    }

    /// At the rim of the end face each node has two normals, along and across the tube; within the wall one.
    #[test]
    fn normals_divide_at_sharp_edges() {
        let (positions, triangles) = tube();
        let display = display(&positions, &triangles, 0);
        let mut vertices = Vec::new();
        display.evaluate(&positions, &mut vertices);
        assert_eq!(vertices.len(), 2 * positions.len());
        for vertex in &vertices {
            let [x, y, z] = vertex.normal;
            let across = y.hypot(z);
            assert!((x.abs() > 0.999) != (across > 0.999), "{vertex:?}");
        }
    }

    /// A sheet that is folded by 30° is smooth, by 50° it has an edge; so has a flat one between two layers.
    #[test]
    fn crease_angle_decides() {
        let sheet = |angle: f32, layers: [u8; 2]| {
            let reference = [
                Vector3::new(0.0, 0.0, 0.0),
                Vector3::new(0.0, 1.0, 0.0),
                Vector3::new(-1.0, 0.0, 0.0),
                Vector3::new(angle.cos(), 0.0, angle.sin()),
            ];
            let triangles = [[0, 1, 2], [0, 3, 1]];
            Display::new(&triangles, &layers, &reference, 0).nodes.len()
        };
        assert_eq!(sheet(PI / 6.0, [0, 0]), 4);
        assert_eq!(sheet(50.0 * PI / 180.0, [0, 0]), 6);
        assert_eq!(sheet(0.0, [0, 1]), 6);
    }
}
