//! Where points lie in a mesh, and points that follow it: the finer surface that is drawn follows the mesh that is
//! computed.

use crate::TetMesh;
use crate::box_grid::BoxGrid;
use microsim_geometry::{Aabb, closest_on_triangle};
use nalgebra::Vector3;

/// A point this far outside, as a share of an element's heights, is still inside: what rounding leaves on a face.
const INSIDE: f64 = 1e-12;

/// Distances that differ by less than this share of the mesh's size are equal: to a node, edge or face of several
/// elements.
const EQUAL: f64 = 1e-12;

/// A place in an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// Index of the element.
    pub element: u32,
    /// Barycentric coordinates for its four nodes, sum 1; one below 0 where the point is outside.
    pub weights: [f64; 4],
}

/// Finds points in one mesh at rest.
pub struct Locator<'a> {
    mesh: &'a TetMesh,
    elements: BoxGrid,
    /// The boundary's triangles with their elements.
    faces: Vec<([u32; 3], u32)>,
    face_grid: BoxGrid,
    size: f64,
}

impl<'a> Locator<'a> {
    /// A locator for `mesh`, which has no defect of severity error.
    pub fn new(mesh: &'a TetMesh) -> Self {
        let boxes: Vec<Aabb> = (0..mesh.tets.len())
            .map(|element| {
                let bounds = Aabb::of(&mesh.corners(element));
                // Room for the points that rounding leaves outside.
                bounds.inflated(INSIDE * (bounds.max - bounds.min).max())
            })
            .collect();
        let faces = mesh.boundary_faces(|_| true);
        let face_boxes: Vec<Aabb> = faces
            .iter()
            .map(|(face, _)| Aabb::of(face.iter().map(|&n| &mesh.positions[n as usize])))
            .collect();
        let bounds = Aabb::of(&mesh.positions);
        Self {
            mesh,
            elements: BoxGrid::new(&boxes),
            faces,
            face_grid: BoxGrid::new(&face_boxes),
            size: (bounds.max - bounds.min).norm(),
        }
    }

    /// The element that holds `point` \[m\]; of several (on a face, edge or node) the one with the lowest index. `None`
    /// outside the mesh.
    pub fn locate(&self, point: &Vector3<f64>) -> Option<Location> {
        self.elements.at(point).iter().find_map(|&element| {
            let weights = self.weights(element, point);
            let inside = weights.iter().all(|&w| w >= -INSIDE);
            inside.then_some(Location { element, weights })
        })
    }

    /// The element that holds `point`, else the one closest to it, with the coordinates continued outside it, so that they
    /// still give the point. Of several at the same distance the one that the point leaves least (whose smallest weight
    /// is largest), then the one with the lowest index. `None` only when the mesh has no element or the point is not
    /// finite.
    pub fn nearest(&self, point: &Vector3<f64>) -> Option<Location> {
        if let Some(inside) = self.locate(point) {
            return Some(inside);
        }
        if !point.iter().all(|x| x.is_finite()) || self.faces.is_empty() {
            return None;
        }
        let mut candidates: Vec<(f64, u32)> = Vec::new();
        let mut least = f64::INFINITY;
        self.face_grid.search_nearest(point, |face| {
            let (nodes, element) = self.faces[face as usize];
            let corners = nodes.map(|n| self.mesh.positions[n as usize]);
            let distance = (closest_on_triangle(point, &corners).point - point).norm();
            least = least.min(distance);
            candidates.push((distance, element));
            distance
        });
        let equal = least + EQUAL * self.size;
        let smallest = |weights: &[f64; 4]| weights.iter().copied().fold(f64::INFINITY, f64::min);
        candidates
            .into_iter()
            .filter(|(distance, _)| *distance <= equal)
            .map(|(_, element)| Location {
                element,
                weights: self.weights(element, point),
            })
            .min_by(|a, b| {
                smallest(&b.weights)
                    .total_cmp(&smallest(&a.weights))
                    .then(a.element.cmp(&b.element))
            })
    }

    fn weights(&self, element: u32, point: &Vector3<f64>) -> [f64; 4] {
        barycentric(&self.mesh.corners(element as usize), point)
    }
}

/// Barycentric coordinates of `point` in the tetrahedron with `corners` \[m\], which has a volume. Products with edges of
/// the element only, so that a point far away loses no digits.
fn barycentric([a, b, c, d]: &[Vector3<f64>; 4], point: &Vector3<f64>) -> [f64; 4] {
    let (b, c, d, p) = (b - a, c - a, d - a, point - a);
    let (cd, db, bc) = (c.cross(&d), d.cross(&b), b.cross(&c));
    let volume = b.dot(&cd);
    let [u, v, w] = [cd, db, bc].map(|normal| p.dot(&normal) / volume);
    [1.0 - u - v - w, u, v, w]
}

/// Points that follow a mesh: each has an element and weights for its four nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mapping {
    /// Element of each point.
    pub elements: Vec<u32>,
    /// The four nodes of that element.
    pub nodes: Vec<[u32; 4]>,
    /// Barycentric coordinates of each point at rest, sum 1; below 0 for points outside the mesh, which so keep their
    /// place relative to the closest element.
    pub weights: Vec<[f64; 4]>,
}

/// The point that has no element to follow: it, or every point, because the mesh has no element or the point is not
/// finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappingError {
    /// Index of the point.
    pub point: usize,
    /// Where it is \[m\].
    pub position: [f64; 3],
}

impl std::fmt::Display for MappingError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "point {} at {:?} m has no element to follow: it needs finite coordinates and a mesh with elements",
            self.point, self.position
        )
    }
}

impl std::error::Error for MappingError {}

impl Mapping {
    /// The mapping of `points` \[m\] onto `mesh` at rest.
    pub fn new(mesh: &TetMesh, points: &[Vector3<f64>]) -> Result<Self, MappingError> {
        let locator = Locator::new(mesh);
        let mut mapping = Self::default();
        for (index, point) in points.iter().enumerate() {
            let location = locator.nearest(point).ok_or(MappingError {
                point: index,
                position: (*point).into(),
            })?;
            mapping.elements.push(location.element);
            mapping.nodes.push(mesh.tets[location.element as usize]);
            mapping.weights.push(location.weights);
        }
        Ok(mapping)
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Places of the points \[m\] when the nodes of the mesh are at `positions` \[m\]; `out` is as long as the mapping.
    pub fn apply(&self, positions: &[Vector3<f64>], out: &mut [Vector3<f64>]) {
        for ((place, nodes), weights) in out.iter_mut().zip(&self.nodes).zip(&self.weights) {
            let [a, b, c, d] = nodes.map(|n| positions[n as usize]);
            *place = a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Arc, CellSplit, Layer, Tube};
    use proptest::prelude::*;

    fn tube() -> TetMesh {
        let layer = Layer {
            thickness: 1e-3,
            cells: 2,
            region: 0,
        };
        Tube {
            center: [0.01, 0.0, 0.0],
            axis: [1.0, 0.3, -0.2],
            inner_radius: 2e-3,
            layers: vec![layer],
            length: 6e-3,
            around: 7,
            along: 5,
            arc: Arc::Full,
            split: CellSplit::Kuhn,
        }
        .mesh()
        .unwrap()
    }

    /// Distance to an element \[m\]: 0 inside, else to the closest of its faces.
    fn distance(mesh: &TetMesh, element: usize, point: &Vector3<f64>) -> f64 {
        let corners = mesh.corners(element);
        if barycentric(&corners, point).iter().all(|&w| w >= 0.0) {
            return 0.0;
        }
        crate::tet_mesh::FACES
            .iter()
            .map(|face| {
                let triangle = face.map(|corner| corners[corner]);
                (closest_on_triangle(point, &triangle).point - point).norm()
            })
            .fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

        /// Brute force over all elements: the element found is at the smallest distance, the point is what its weights
        /// give, and it is located exactly when that distance is 0. Points in the wall, in the lumen, around, far away.
        #[test]
        fn the_nearest_element_agrees_with_brute_force(p in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0], scale in prop::sample::select(vec![4e-3, 1e-2, 1.0])) {
            let mesh = tube();
            let locator = Locator::new(&mesh);
            let point = Vector3::new(0.01, 0.0, 0.0) + Vector3::from(p) * scale;
            let expected = (0..mesh.tets.len()).map(|e| distance(&mesh, e, &point)).fold(f64::INFINITY, f64::min);
            let found = locator.nearest(&point).unwrap();
            prop_assert!(distance(&mesh, found.element as usize, &point) <= expected + 1e-13 * scale);
            prop_assert!((found.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let corners = mesh.corners(found.element as usize);
            let again: Vector3<f64> = corners.iter().zip(found.weights).map(|(c, w)| c * w).sum();
            // Weights grow with the distance in element heights, about 1e-4 m: up to 1e4, and round with it.
            prop_assert!((again - point).norm() < 1e-11 * scale);
            prop_assert_eq!(locator.locate(&point).is_some(), expected == 0.0);
        }
    }

    #[test]
    fn nodes_and_middles_are_located_in_an_element_of_theirs() {
        let mesh = tube();
        let locator = Locator::new(&mesh);
        for (node, position) in mesh.positions.iter().enumerate() {
            let found = locator.locate(position).unwrap();
            let corner = mesh.tets[found.element as usize]
                .iter()
                .position(|&n| n as usize == node);
            assert!((found.weights[corner.unwrap()] - 1.0).abs() < 1e-11);
        }
        for element in 0..mesh.tets.len() {
            let [a, b, c, d] = mesh.corners(element);
            let found = locator.locate(&((a + b + c + d) / 4.0)).unwrap();
            assert_eq!(found.element as usize, element);
        }
    }

    /// An affine motion of the nodes moves every point by the same map, also those outside the mesh.
    #[test]
    fn mapped_points_follow_an_affine_motion_exactly() {
        let mesh = tube();
        let points: Vec<Vector3<f64>> = mesh
            .surface()
            .area_vectors(&mesh.positions)
            .iter()
            .zip(&mesh.surface().triangles)
            .map(|(normal, t)| {
                let centroid = t
                    .iter()
                    .map(|&n| mesh.positions[n as usize])
                    .sum::<Vector3<f64>>();
                centroid / 3.0 + normal.normalize() * 1e-4
            })
            .collect();
        let mapping = Mapping::new(&mesh, &points).unwrap();
        assert_eq!(mapping.len(), points.len());
        let map = nalgebra::Matrix3::new(1.2, 0.3, 0.0, -0.1, 0.9, 0.2, 0.05, 0.0, 1.1);
        let moved: Vec<Vector3<f64>> = mesh
            .positions
            .iter()
            .map(|p| map * p + Vector3::x() * 0.01)
            .collect();
        let mut out = vec![Vector3::zeros(); points.len()];
        mapping.apply(&moved, &mut out);
        for (place, point) in out.iter().zip(&points) {
            assert!((place - (map * point + Vector3::x() * 0.01)).norm() < 1e-15);
        }
        let error = Mapping::new(&mesh, &[points[0], Vector3::repeat(f64::NAN)]).unwrap_err();
        assert_eq!(error.point, 1);
    }
}
