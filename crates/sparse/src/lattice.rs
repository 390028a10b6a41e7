//! A coarse space for vectors on the nodes of a body: linear functions on a lattice laid through it.
//!
//! The box around the nodes is divided into cells, each cell into the six tetrahedra of Kuhn; a node has the barycentric weights of
//! the tetrahedron in which it lies, on at most four points. Translations and linear fields of the positions are in the space,
//! whatever the shape of the body. Points of the lattice in which no node has a part are left out.

use std::collections::BTreeMap;

use nalgebra::Vector3;

/// Weights below this are left out: rounding of a node that lies on a face, an edge or a point.
const LEAST_WEIGHT: f64 = 1e-9;

/// The weights of the nodes on the points: the prolongation P of a multigrid method, with the same weight for all components.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Per node, and the end.
    starts: Vec<u32>,
    points: Vec<u32>,
    weights: Vec<f64>,
    count: usize,
    positions: Vec<Vector3<f64>>,
}

impl Lattice {
    /// A lattice through `positions` \[m\] with cells of about `spacing` \[m\], a whole number of them along each side of the box.
    ///
    /// # Panics
    /// When `spacing` is not positive: meshes are validated before they get here.
    pub fn new(positions: &[Vector3<f64>], spacing: f64) -> Self {
        assert!(spacing > 0.0, "a spacing above 0");
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = Vector3::repeat(f64::NEG_INFINITY);
        for position in positions {
            low = low.inf(position);
            high = high.sup(position);
        }
        let extent = high - low;
        let cells = extent.map(|side| (side / spacing).round().max(1.0));
        let side = extent.zip_map(&cells, |extent, cells| {
            if extent > 0.0 {
                extent / cells
            } else {
                spacing
            }
        });
        let mut numbers = BTreeMap::new();
        let mut lattice = Self {
            starts: vec![0],
            points: Vec::new(),
            weights: Vec::new(),
            count: 0,
            positions: Vec::new(),
        };
        for position in positions {
            let at = (position - low).component_div(&side);
            let cell = at.zip_map(&cells, |at, cells| at.floor().clamp(0.0, cells - 1.0));
            for (corner, weight) in kuhn((at - cell).into()) {
                if weight <= LEAST_WEIGHT {
                    continue;
                }
                let point: [u32; 3] = std::array::from_fn(|axis| cell[axis] as u32 + corner[axis]);
                let next = numbers.len() as u32;
                let number = *numbers.entry(point).or_insert(next);
                if number == next {
                    let steps = Vector3::from(point.map(f64::from));
                    lattice.positions.push(low + steps.component_mul(&side));
                }
                lattice.points.push(number);
                lattice.weights.push(weight);
            }
            lattice.starts.push(lattice.points.len() as u32);
        }
        lattice.count = numbers.len();
        lattice
    }

    /// Number of points.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Where the points are \[m\].
    pub fn positions(&self) -> &[Vector3<f64>] {
        &self.positions
    }

    /// Bytes of the weights and points.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.starts)
            + size_of_val(&*self.points)
            + size_of_val(&*self.weights)
            + size_of_val(&*self.positions)
    }

    /// The points in which node `node` has a part, with its weights; these sum to 1.
    pub fn weights(&self, node: usize) -> impl Iterator<Item = (u32, f64)> + Clone {
        let range = self.starts[node] as usize..self.starts[node + 1] as usize;
        let points = self.points[range.clone()].iter().copied();
        points.zip(self.weights[range].iter().copied())
    }
}

/// The corners of the tetrahedron of the unit cube in which `at` lies, with its barycentric weights: from corner to corner along
/// the axes in the order of descending coordinates.
fn kuhn(at: [f64; 3]) -> [([u32; 3], f64); 4] {
    let mut axes = [0, 1, 2];
    // Stable, so that equal coordinates have one order.
    axes.sort_by(|&a, &b| at[b].total_cmp(&at[a]));
    let [first, second, third] = axes.map(|axis| at[axis]);
    let mut corner = [0; 3];
    let mut result = [(corner, 1.0 - first); 4];
    let weights = [first - second, second - third, third];
    for ((entry, axis), weight) in result[1..].iter_mut().zip(axes).zip(weights) {
        corner[axis] = 1;
        *entry = (corner, weight);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::vectors;
    use microsim_random::Congruential;

    /// Linear fields are in the space: that is what the weights are for. 8 ε: three roundings of numbers of the size of the box.
    #[test]
    fn positions_are_the_sum_of_points() {
        let random = vectors(&mut Congruential(31), 500);
        let on_a_plane: Vec<_> = random.iter().map(|p| Vector3::new(p.x, 2.0, p.z)).collect();
        for (positions, spacing) in [(&random, 0.3), (&random, 5.0), (&on_a_plane, 0.4)] {
            let lattice = Lattice::new(positions, spacing);
            for (node, position) in positions.iter().enumerate() {
                let mut sum = Vector3::zeros();
                let mut one = 0.0;
                for (point, weight) in lattice.weights(node) {
                    assert!(weight > 0.0);
                    sum += lattice.positions()[point as usize] * weight;
                    one += weight;
                }
                assert!((sum - position).amax() <= 8.0 * f64::EPSILON + 4.0 * LEAST_WEIGHT);
                assert!((one - 1.0).abs() <= 4.0 * LEAST_WEIGHT);
            }
        }
    }

    /// 3 × 1 × 1 cells of the side 0.5; the nodes at corners of cells have one point each.
    #[test]
    fn cells_fit_the_box() {
        let positions: Vec<_> = [
            [0.0, 0.0, 0.0],
            [0.5, 0.0, 0.0],
            [1.5, 0.5, 0.5],
            [0.75, 0.0, 0.0],
        ]
        .map(Vector3::from)
        .into();
        let lattice = Lattice::new(&positions, 0.45);
        let of = |node| lattice.weights(node).collect::<Vec<_>>();
        assert_eq!(of(0), [(0, 1.0)]);
        assert_eq!(of(1), [(1, 1.0)]);
        assert_eq!(of(2), [(2, 1.0)]);
        assert_eq!(of(3), [(1, 0.5), (3, 0.5)]);
        assert_eq!(lattice.count(), 4, "points without a node are left out");
    }
}
