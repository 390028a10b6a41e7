//! Uniform refinement: a node in the middle of each edge, eight tetrahedra in place of each.
//!
//! The parts of a tetrahedron and their nodes have a fixed order, by which [`ten_nodes`](TetMesh::ten_nodes) finds it again: the corners and the
//! middles of the edges of a quadratic tetrahedron.

use crate::TetMesh;
use crate::tet_mesh::EDGES;
use nalgebra::Vector3;

/// Parts of a tetrahedron.
pub const PARTS: usize = 8;

/// The parts, by the corners 0 to 3 and the middles 4 to 9 of the edges in the order of [`EDGES`]: one at each corner, then the octahedron
/// between them in four around its diagonal from edge 02 to edge 13. That is the division of Bey (1995), which makes of parts no worse shapes than
/// at the first time; all are positive.
const OF_PARTS: [[usize; 4]; PARTS] = [
    [0, 4, 5, 6],
    [4, 1, 7, 8],
    [5, 7, 2, 9],
    [6, 8, 9, 3],
    [4, 5, 6, 8],
    [4, 7, 5, 8],
    [5, 6, 8, 9],
    [5, 8, 7, 9],
];

/// A refined mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined {
    /// The mesh: eight elements in place of each, in its order; the nodes that were there, then the middles of the edges.
    pub mesh: TetMesh,
    /// The edges with the middle of each: smaller node first, ascending. That of edge i is the i-th of the new nodes.
    pub edges: Vec<[u32; 2]>,
}

impl Refined {
    /// The middle of an edge.
    fn middle(&self, a: u32, b: u32) -> Option<u32> {
        let place = self.edges.binary_search(&[a.min(b), a.max(b)]).ok()?;
        let corners = self.mesh.positions.len() - self.edges.len();
        Some((corners + place) as u32)
    }

    /// Faces of the mesh before, each in four: one at each corner, one between. A triangle that is no face of it is left as it is.
    pub fn faces(&self, faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let mut refined = Vec::with_capacity(4 * faces.len());
        for &[a, b, c] in faces {
            match (self.middle(a, b), self.middle(b, c), self.middle(c, a)) {
                (Some(ab), Some(bc), Some(ca)) => {
                    refined.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
                }
                _ => refined.push([a, b, c]),
            }
        }
        refined
    }

    /// Moves the middle of each edge to the place that `place` gives for its ends \[m\]: onto a curved surface, for example.
    pub fn place_middles(&mut self, place: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>) {
        let corners = self.mesh.positions.len() - self.edges.len();
        let (ends, middles) = self.mesh.positions.split_at_mut(corners);
        for (middle, [a, b]) in middles.iter_mut().zip(&self.edges) {
            *middle = place(&ends[*a as usize], &ends[*b as usize]);
        }
    }
}

impl TetMesh {
    /// The mesh with a node in the middle of each edge and eight elements in place of each, of its region and its fibre direction.
    ///
    /// ```
    /// use microsim_mesh::TetMesh;
    /// use nalgebra::Vector3;
    ///
    /// let corners = vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
    /// let refined = TetMesh::new(corners, vec![[0, 1, 2, 3]], vec![0]).refined();
    /// assert_eq!((refined.mesh.positions.len(), refined.mesh.tets.len()), (10, 8));
    /// assert_eq!(refined.mesh.ten_nodes(0), Some([0, 1, 2, 3, 4, 5, 6, 7, 8, 9]));
    /// assert_eq!(refined.faces(&[[0, 2, 1]]).len(), 4);
    /// ```
    pub fn refined(&self) -> Refined {
        let edges = self.edges();
        let corners = self.positions.len();
        let mut positions = self.positions.clone();
        positions.extend(edges.iter().map(|[a, b]| {
            let [a, b] = [a, b].map(|node| self.positions[*node as usize]);
            (a + b) * 0.5
        }));
        let mut tets = Vec::with_capacity(PARTS * self.tets.len());
        for (element, tet) in self.tets.iter().enumerate() {
            let mut nodes = [0; 10];
            nodes[..4].copy_from_slice(tet);
            for (node, edge) in nodes[4..].iter_mut().zip(self.element_edges(element)) {
                let place = edges.partition_point(|other| *other < edge);
                *node = (corners + place) as u32;
            }
            tets.extend(parts(&nodes));
        }
        let mut mesh = Self::new(positions, tets, of_parts(&self.regions));
        mesh.directions = of_parts(&self.directions);
        mesh.prestretches = of_parts(&self.prestretches);
        Refined { mesh, edges }
    }

    /// Corners and middles of the edges 01, 02, 03, 12, 13, 23 of the tetrahedron whose eight parts begin at element `first`, as
    /// [`refined`](Self::refined) makes them; `None` where there is none.
    pub fn ten_nodes(&self, first: usize) -> Option<[u32; 10]> {
        let tets = self.tets.get(first..first + PARTS)?;
        let mut nodes = [0; 10];
        for (place, node) in nodes.iter_mut().enumerate() {
            let found = OF_PARTS.iter().zip(tets).find_map(|(part, tet)| {
                let corner = part.iter().position(|of| *of == place)?;
                Some(tet[corner])
            });
            *node = found?;
        }
        (parts(&nodes) == *tets).then_some(nodes)
    }
}

/// Values of elements as those of their parts.
fn of_parts<T: Copy>(values: &[T]) -> Vec<T> {
    let each = values.iter().flat_map(|v| std::iter::repeat_n(*v, PARTS));
    each.collect()
}

/// The parts of the tetrahedron with these corners and middles.
fn parts(nodes: &[u32; 10]) -> [[u32; 4]; PARTS] {
    OF_PARTS.map(|part| part.map(|place| nodes[place]))
}

// The middles follow the corners in the order of the edges.
const _: () = assert!(EDGES.len() == 6);

#[cfg(test)]
mod tests {
    use crate::{Arc, Block, CellSplit, Layer, Severity, Tube, defects, signed_volume};

    fn block() -> crate::TetMesh {
        let block = Block {
            center: [0.1, 0.2, 0.3],
            size: [3.0, 1.0, 2.0],
            cells: [3, 1, 2],
            split: CellSplit::Kuhn,
        };
        block.mesh().unwrap()
    }

    /// An eighth of the volume each; the faces of the surface are in four.
    #[test]
    fn the_parts_of_a_tetrahedron_are_eighths_and_conform() {
        let mesh = block();
        let refined = mesh.refined();
        for (element, volume) in mesh.volumes().into_iter().enumerate() {
            for part in &refined.mesh.volumes()[8 * element..][..8] {
                assert!((part - volume / 8.0).abs() < 1e-14);
            }
            assert_eq!(refined.mesh.regions[8 * element + 7], mesh.regions[element]);
        }
        let mut own = refined.mesh.surface().triangles;
        let mut of_faces = refined.faces(&mesh.surface().triangles);
        for triangles in [&mut own, &mut of_faces] {
            triangles.iter_mut().for_each(|t| {
                let least = (0..3).min_by_key(|i| t[*i]).unwrap();
                t.rotate_left(least);
            });
            triangles.sort_unstable();
        }
        assert_eq!(own, of_faces);
        let found = defects(&refined.mesh);
        assert!(
            found.iter().all(|d| d.severity() != Severity::Error),
            "{found:?}"
        );
    }

    #[test]
    fn ten_nodes_are_found_in_a_refined_mesh_only() {
        let mesh = block();
        let refined = mesh.refined();
        for (element, tet) in mesh.tets.iter().enumerate() {
            let nodes = refined.mesh.ten_nodes(8 * element).unwrap();
            assert_eq!(nodes[..4], *tet);
            for (middle, [a, b]) in nodes[4..].iter().zip(super::EDGES) {
                let at = |node: u32| refined.mesh.positions[node as usize];
                let straight = (at(tet[a]) + at(tet[b])) / 2.0;
                assert!((at(*middle) - straight).norm() < 1e-15);
            }
            assert_eq!(refined.mesh.ten_nodes(8 * element + 1), None);
        }
        assert_eq!(mesh.ten_nodes(0), None);
        assert_eq!(refined.mesh.ten_nodes(refined.mesh.tets.len()), None);
    }

    /// Middles on the circles: parts are positive, and the volume is that of a ring of twice as many sides, but for third parts of the sagitta.
    #[test]
    fn middles_may_be_placed_on_a_curved_surface() {
        let tube = Tube {
            center: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            inner_radius: 1.0,
            layers: vec![Layer {
                thickness: 0.5,
                cells: 1,
                region: 0,
            }],
            length: 1.0,
            around: 8,
            along: 2,
            arc: Arc::Full,
            split: CellSplit::Kuhn,
        };
        let mut refined = tube.mesh().unwrap().refined();
        refined.place_middles(|a, b| tube.between(a, b));
        let volumes = refined.mesh.tets.iter().map(|tet| {
            let [a, b, c, d] = tet.map(|node| refined.mesh.positions[node as usize]);
            signed_volume(&a, &b, &c, &d)
        });
        let volumes: Vec<f64> = volumes.collect();
        assert!(volumes.iter().all(|v| *v > 0.0));
        let exact = std::f64::consts::PI * (1.5 * 1.5 - 1.0);
        // The area of a polygon of sixteen sides is 0.974 of that of the circle.
        let whole: f64 = volumes.iter().sum();
        assert!((whole / exact - 0.9745).abs() < 1e-3, "{}", whole / exact);
    }
}
