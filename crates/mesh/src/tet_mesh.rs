//! The tetrahedral mesh.

use crate::surface::Surface;
use microsim_geometry::signed_volume;
use nalgebra::{Matrix3, Vector3};

/// Most families of fibres in an element.
pub const FAMILIES: usize = 2;

/// The six edges of a tetrahedron as pairs of corners.
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The four faces of a positive tetrahedron (A, B, C, D), outward by the right-hand rule: ACB, ABD, BCD, CAD.
pub(crate) const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

/// A tetrahedral mesh at rest.
///
/// ```
/// use microsim_mesh::TetMesh;
/// use nalgebra::Vector3;
///
/// let corners = vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
/// let mesh = TetMesh::new(corners, vec![[0, 1, 2, 3]], vec![0]);
/// assert_eq!(mesh.volumes(), [1.0 / 6.0]);
/// assert_eq!((mesh.edges().len(), mesh.surface().triangles.len()), (6, 4));
/// // A quarter of the mass at each node.
/// assert_eq!(mesh.node_masses(&[6000.0]), [250.0; 4]);
/// ```
///
/// Indices address the arrays of one generation. Ids name nodes and elements for ever: they are never reused and survive
/// every renumbering, so that a reader of an older generation still knows what it meant.
#[derive(Clone, Debug, PartialEq)]
pub struct TetMesh {
    /// Rest positions \[m\].
    pub positions: Vec<Vector3<f64>>,
    /// Four node indices per element, positively oriented.
    pub tets: Vec<[u32; 4]>,
    /// Region of each element: layers of a wall, physical groups of a file. Materials are given by region.
    pub regions: Vec<u32>,
    /// Fibre directions of each element in its natural state: a unit vector for each family, zero where there is none. Empty for a mesh
    /// without fibres.
    pub directions: Vec<[Vector3<f64>; FAMILIES]>,
    /// Prestretch of each element: the deformation gradient G from its natural state, in which it has no stress, to its place in the mesh. Empty
    /// where all of them are at rest without stress.
    pub prestretches: Vec<Matrix3<f64>>,
    /// Stable id of each node.
    pub node_ids: Vec<u32>,
    /// Stable id of each element.
    pub element_ids: Vec<u32>,
    /// Grows with every topology edit.
    pub generation: u64,
    /// Id of the next new node: above all that were ever given.
    pub(crate) next_node_id: u32,
    /// Id of the next new element.
    pub(crate) next_element_id: u32,
}

impl TetMesh {
    /// A first-generation mesh; ids are the indices. Nothing is checked here.
    pub fn new(positions: Vec<Vector3<f64>>, tets: Vec<[u32; 4]>, regions: Vec<u32>) -> Self {
        let (nodes, elements) = (positions.len() as u32, tets.len() as u32);
        let node_ids = (0..nodes).collect();
        let element_ids = (0..elements).collect();
        Self {
            positions,
            tets,
            regions,
            directions: Vec::new(),
            prestretches: Vec::new(),
            node_ids,
            element_ids,
            generation: 0,
            next_node_id: nodes,
            next_element_id: elements,
        }
    }

    /// Fibre directions of element `element` in its natural state: a unit vector for each family, zero where there is none.
    pub fn fibres(&self, element: usize) -> [Vector3<f64>; FAMILIES] {
        self.directions.get(element).copied().unwrap_or_default()
    }

    /// Prestretch G of element `element`; 1 where there is none.
    pub fn prestretch(&self, element: usize) -> Matrix3<f64> {
        let prestretch = self.prestretches.get(element).copied();
        prestretch.unwrap_or_else(Matrix3::identity)
    }

    /// The corners of element `element` \[m\].
    pub fn corners(&self, element: usize) -> [Vector3<f64>; 4] {
        self.tets[element].map(|node| self.positions[node as usize])
    }

    /// The six edges of element `element`, smaller node index first.
    pub fn element_edges(&self, element: usize) -> [[u32; 2]; 6] {
        let tet = &self.tets[element];
        EDGES.map(|[i, j]| [tet[i].min(tet[j]), tet[i].max(tet[j])])
    }

    /// Every edge once, smaller node index first, in ascending order.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges: Vec<_> = (0..self.tets.len())
            .flat_map(|element| self.element_edges(element))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Mean length of the edges \[m\]: the characteristic length of the mesh.
    pub fn mean_edge_length(&self) -> f64 {
        let edges = self.edges();
        let sum: f64 = edges
            .iter()
            .map(|[i, j]| (self.positions[*j as usize] - self.positions[*i as usize]).norm())
            .sum();
        sum / edges.len() as f64
    }

    /// The faces that belong to one element only, outward, in the order of their elements.
    pub fn surface(&self) -> Surface {
        self.surface_of(|_| true)
    }

    /// The boundary of the part made of the chosen elements, outward: of a region, with
    /// `|element| mesh.regions[element] == region`.
    pub(crate) fn surface_of(&self, chosen: impl FnMut(usize) -> bool) -> Surface {
        let faces = self.boundary_faces(chosen);
        Surface::new(faces.into_iter().map(|(triangle, _)| triangle).collect())
    }

    /// The faces that belong to one of the chosen elements only, outward, each with its element, in the order of the
    /// elements.
    pub fn boundary_faces(&self, mut chosen: impl FnMut(usize) -> bool) -> Vec<([u32; 3], u32)> {
        // Sorting all faces by their nodes puts the two copies of an inner face next to each other.
        let mut faces: Vec<([u32; 3], usize)> = Vec::with_capacity(4 * self.tets.len());
        for (element, tet) in self.tets.iter().enumerate() {
            if !chosen(element) {
                continue;
            }
            for (face, corners) in FACES.iter().enumerate() {
                let mut key = corners.map(|corner| tet[corner]);
                key.sort_unstable();
                faces.push((key, 4 * element + face));
            }
        }
        faces.sort_unstable();
        let mut outer: Vec<usize> = faces
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|copies| copies.len() == 1)
            .map(|copies| copies[0].1)
            .collect();
        outer.sort_unstable();
        outer
            .iter()
            .map(|&index| {
                let triangle = FACES[index % 4].map(|corner| self.tets[index / 4][corner]);
                (triangle, (index / 4) as u32)
            })
            .collect()
    }

    /// Adds the nodes and elements of `other` behind those of this mesh, its regions raised by `region_offset`, with new
    /// ids above all ids so far. Nothing is joined where the two touch.
    pub fn append(&mut self, other: &Self, region_offset: u32) {
        let first_node = self.positions.len() as u32;
        // Ids may have been given from outside.
        let free = |ids: &[u32]| ids.iter().max().map_or(0, |id| id + 1);
        let node_id = free(&self.node_ids).max(self.next_node_id);
        let element_id = free(&self.element_ids).max(self.next_element_id);
        self.positions.extend(&other.positions);
        self.tets
            .extend(other.tets.iter().map(|tet| tet.map(|n| n + first_node)));
        self.regions
            .extend(other.regions.iter().map(|region| region + region_offset));
        let (elements, added) = (self.tets.len(), other.tets.len());
        append(
            &mut self.directions,
            &other.directions,
            [elements, added],
            Default::default(),
        );
        append(
            &mut self.prestretches,
            &other.prestretches,
            [elements, added],
            Matrix3::identity(),
        );
        self.node_ids
            .extend((node_id..).take(other.positions.len()));
        self.element_ids
            .extend((element_id..).take(other.tets.len()));
        self.next_node_id = node_id + other.positions.len() as u32;
        self.next_element_id = element_id + other.tets.len() as u32;
        self.generation += 1;
    }

    /// Volume of each element \[m³\].
    pub fn volumes(&self) -> Vec<f64> {
        (0..self.tets.len())
            .map(|element| {
                let [a, b, c, d] = self.corners(element);
                signed_volume(&a, &b, &c, &d)
            })
            .collect()
    }

    /// Lumped node masses \[kg\] for the density of each element \[kg/m³\]: a quarter of the mass of each element at the node.
    pub fn node_masses(&self, densities: &[f64]) -> Vec<f64> {
        let mut masses = vec![0.0; self.positions.len()];
        for ((tet, density), volume) in self.tets.iter().zip(densities).zip(self.volumes()) {
            for &node in tet {
                masses[node as usize] += 0.25 * density * volume;
            }
        }
        masses
    }
}

/// Adds the values of appended elements to those of the first ones; an empty list stands for `none` at each. `counts` are all elements
/// and those appended.
fn append<T: Copy>(values: &mut Vec<T>, added: &[T], [all, appended]: [usize; 2], none: T) {
    if values.is_empty() && added.is_empty() {
        return;
    }
    values.resize(all - appended, none);
    values.extend(added);
    values.resize(all, none);
}

#[cfg(test)]
mod tests {
    use super::Matrix3;
    use crate::{Arc, CellSplit, Layer, Severity, Tube, defects};

    fn two_layers() -> Tube {
        let layer = |region| Layer {
            thickness: 1e-4,
            cells: 1,
            region,
        };
        Tube {
            center: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            inner_radius: 5e-4,
            layers: vec![layer(1), layer(2)],
            length: 2e-3,
            around: 12,
            along: 6,
            arc: Arc::Full,
            split: CellSplit::Kuhn,
        }
    }

    /// Each layer of 12 × 6 cells by itself: two triangles per cell on both walls, per cell of the ring on both ends. The
    /// layers' boundaries have a common wall, which is not on that of the whole.
    #[test]
    fn the_surface_of_a_region_is_that_of_its_elements() {
        let mesh = two_layers().mesh().unwrap();
        let layers = [1, 2].map(|region| mesh.surface_of(|e| mesh.regions[e] == region));
        for layer in &layers {
            assert_eq!(layer.triangles.len(), 4 * 12 * 6 + 4 * 12);
        }
        let whole = mesh.surface();
        assert_eq!(whole.triangles.len(), 4 * 12 * 6 + 2 * 4 * 12);
        let common = layers[0].within(|node| layers[1].nodes.binary_search(&node).is_ok());
        assert_eq!(common.triangles.len(), 2 * 12 * 6);
        assert!(
            common
                .triangles
                .iter()
                .all(|t| !whole.triangles.contains(t))
        );
        for (face, element) in mesh.boundary_faces(|_| true) {
            let tet = mesh.tets[element as usize];
            assert!(face.iter().all(|node| tet.contains(node)));
        }
    }

    #[test]
    fn appended_parts_keep_what_they_are_under_new_indices_and_ids() {
        let first = two_layers().mesh().unwrap();
        let second = Tube {
            center: [5e-3, 0.0, 0.0],
            around: 9,
            ..two_layers()
        }
        .mesh()
        .unwrap();
        let mut both = first.clone();
        both.append(&second, 10);
        assert_eq!(both.generation, first.generation + 1);
        let (n, e) = (first.positions.len(), first.tets.len());
        assert_eq!(both.corners(e + 5), second.corners(5));
        assert_eq!(both.regions[e..].iter().min(), Some(&11));
        assert!(both.directions.is_empty() && both.prestretch(0) == Matrix3::identity());
        assert_eq!(both.node_ids[n], n as u32);
        assert_eq!(both.element_ids[e], e as u32);
        let found = defects(&both);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].severity(), Severity::Warning);
        assert!(found[0].to_string().contains("2 parts"));
    }
}
