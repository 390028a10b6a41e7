//! The stiffness of a body as a whole: the tensor of its energy under one small strain of all nodes.
//!
//! C_ijkl = (1/V) Σ_e ∂²E_e/∂ε_ij∂ε_kl with x = (1 + ε) X for every node. The nodes follow the strain, so C is an upper bound
//! (Voigt) of what they do when they are free to relax; where every node is a centre of symmetry, as inside Kuhn and mirrored
//! Kuhn blocks, they have nothing to relax and C is exact.

use crate::elements::{Configuration, ElementMatrix, Elements, Tangent};
use nalgebra::{SMatrix, SVector, Vector3};
use std::sync::Arc;

type Vector6 = SVector<f64, 6>;

/// Axes, face diagonals, space diagonals.
const DIRECTIONS: [[f64; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// A stiffness tensor.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectiveStiffness {
    /// C \[Pa\] over strains written as 11, 22, 33, √2·23, √2·13, √2·12, in which lengths and angles of tensors are those of
    /// vectors.
    pub tensor: SMatrix<f64, 6, 6>,
}

/// The stiffness of the elements of `sets`, which fill `volume` \[m³\], at these rest positions.
pub fn homogenise(
    positions: &[Vector3<f64>],
    sets: &[Arc<dyn Elements>],
    volume: f64,
) -> EffectiveStiffness {
    let still = vec![Vector3::zeros(); positions.len()];
    let mut tensor = SMatrix::<f64, 6, 6>::zeros();
    let mut matrix = ElementMatrix::new();
    for set in sets {
        let internal = set.initial_internal();
        let at = Configuration {
            positions,
            velocities: &still,
            internal: &internal,
        };
        for element in 0..set.count() {
            set.stiffness(element, &at, Tangent::Exact, &mut matrix);
            let nodes = set.nodes(element);
            // From the first node on: a common translation costs nothing but digits.
            let origin = positions[nodes[0] as usize];
            let strained = |node: u32| strains(&(positions[node as usize] - origin));
            for (i, &row) in nodes.iter().enumerate() {
                for (j, &column) in nodes.iter().enumerate() {
                    let block = matrix.block(i, j);
                    tensor += strained(row).transpose() * block * strained(column);
                }
            }
        }
    }
    EffectiveStiffness {
        tensor: tensor / volume,
    }
}

/// Displacement of a point at `x` under each of the six unit strains, as columns.
fn strains(x: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    let shear = std::f64::consts::FRAC_1_SQRT_2;
    SMatrix::from_columns(&[
        Vector3::new(x.x, 0.0, 0.0),
        Vector3::new(0.0, x.y, 0.0),
        Vector3::new(0.0, 0.0, x.z),
        Vector3::new(0.0, x.z, x.y) * shear,
        Vector3::new(x.z, 0.0, x.x) * shear,
        Vector3::new(x.y, x.x, 0.0) * shear,
    ])
}

/// n nᵀ of a direction as a vector.
fn dyad(direction: &Vector3<f64>) -> Vector6 {
    let n = direction.normalize();
    let shear = std::f64::consts::SQRT_2;
    Vector6::from([
        n.x * n.x,
        n.y * n.y,
        n.z * n.z,
        shear * n.y * n.z,
        shear * n.x * n.z,
        shear * n.x * n.y,
    ])
}

impl EffectiveStiffness {
    /// Bulk and shear modulus of the mean over all directions \[Pa\].
    fn bulk_and_shear(&self) -> (f64, f64) {
        let nine_bulk = self.tensor.fixed_view::<3, 3>(0, 0).sum();
        (
            nine_bulk / 9.0,
            (self.tensor.trace() - nine_bulk / 3.0) / 10.0,
        )
    }

    /// Young's modulus \[Pa\] and Poisson's ratio of the mean over all directions.
    pub fn isotropic(&self) -> (f64, f64) {
        let (bulk, shear) = self.bulk_and_shear();
        let sum = 3.0 * bulk + shear;
        (
            9.0 * bulk * shear / sum,
            (3.0 * bulk - 2.0 * shear) / (2.0 * sum),
        )
    }

    /// Fraction of the tensor (Frobenius) that is not in the mean over all directions.
    pub fn anisotropy(&self) -> f64 {
        let (bulk, shear) = self.bulk_and_shear();
        let mut rest = self.tensor - SMatrix::identity() * (2.0 * shear);
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            rest[(i, j)] -= bulk - 2.0 * shear / 3.0;
        }
        rest.norm() / self.tensor.norm()
    }

    /// Young's modulus for stretch along `direction` \[Pa\], and Poisson's ratio for the contraction along `across`; both 0 for a
    /// body that does not resist every strain.
    pub fn along(&self, direction: &Vector3<f64>, across: &Vector3<f64>) -> (f64, f64) {
        let along = dyad(direction);
        match self.tensor.cholesky() {
            Some(factor) => {
                let strain = factor.solve(&along);
                let stretch = along.dot(&strain);
                (1.0 / stretch, -dyad(across).dot(&strain) / stretch)
            }
            None => (0.0, 0.0),
        }
    }

    /// The largest |E(n)/E − 1| over 13 directions n, E = `young` \[Pa\].
    pub fn error(&self, young: f64) -> f64 {
        let error = |n: [f64; 3]| {
            let n = Vector3::from(n);
            (self.along(&n, &n).0 / young - 1.0).abs()
        };
        DIRECTIONS.into_iter().map(error).fold(0.0, f64::max)
    }
}
