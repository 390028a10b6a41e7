//! Length, area and volume of a few nodes, with first and second derivatives (NUMERICS 1.1).

use crate::elements::{ElementMatrix, EnergyKind, Tangent};
use nalgebra::{Matrix3, Vector3};

/// At this size \[m or m²\] and below, the square of a length or of an area vector leaves the range of numbers: there is no
/// direction, and no force. Anything larger has one, however small the body.
const COLLAPSED: f64 = 1e-150;

/// A size of N nodes.
pub trait Measure<const N: usize>: std::fmt::Debug + Clone + Send + Sync + 'static {
    /// Which energy ½ k (q − q0)² is.
    const KIND: EnergyKind;
    /// q scales with this power of a length.
    const EXPONENT: u32;

    /// q.
    fn value(p: [&Vector3<f64>; N]) -> f64;

    /// q and ∂q/∂p.
    fn gradient(p: [&Vector3<f64>; N]) -> (f64, [Vector3<f64>; N]);

    /// Adds `tension`·∂²q/∂p², with `tension` = k (q − q0); for [`Tangent::Positive`] only what has no negative eigenvalue.
    fn add_curvature(
        p: [&Vector3<f64>; N],
        tension: f64,
        tangent: Tangent,
        out: &mut ElementMatrix,
    );
}

/// Distance of two nodes.
#[derive(Clone, Debug)]
pub struct Length;

/// Area of a triangle.
#[derive(Clone, Debug)]
pub struct Area;

/// Signed volume of a tetrahedron.
#[derive(Clone, Debug)]
pub struct Volume;

impl Measure<2> for Length {
    const KIND: EnergyKind = EnergyKind::Length;
    const EXPONENT: u32 = 1;

    #[inline]
    fn value(p: [&Vector3<f64>; 2]) -> f64 {
        (p[1] - p[0]).norm()
    }

    #[inline]
    fn gradient(p: [&Vector3<f64>; 2]) -> (f64, [Vector3<f64>; 2]) {
        let along = p[1] - p[0];
        let length = along.norm();
        if length <= COLLAPSED {
            return (length, [Vector3::zeros(); 2]);
        }
        let u = along / length;
        (length, [-u, u])
    }

    /// (1 − u uᵀ)/L: without negative eigenvalue, so a positive tangent drops it only for a spring in compression.
    fn add_curvature(
        p: [&Vector3<f64>; 2],
        tension: f64,
        tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        let (length, [_, u]) = Self::gradient(p);
        if length <= COLLAPSED || (tangent == Tangent::Positive && tension < 0.0) {
            return;
        }
        let block = (Matrix3::identity() - u * u.transpose()) * (tension / length);
        for i in 0..2 {
            for j in 0..2 {
                *out.block_mut(i, j) += if i == j { block } else { -block };
            }
        }
    }
}

/// Twice the area vector of a triangle, and its length.
fn double_area(p: [&Vector3<f64>; 3]) -> (Vector3<f64>, f64) {
    let n = (p[1] - p[0]).cross(&(p[2] - p[0]));
    (n, n.norm())
}

impl Measure<3> for Area {
    const KIND: EnergyKind = EnergyKind::Area;
    const EXPONENT: u32 = 2;

    fn value(p: [&Vector3<f64>; 3]) -> f64 {
        0.5 * double_area(p).1
    }

    fn gradient(p: [&Vector3<f64>; 3]) -> (f64, [Vector3<f64>; 3]) {
        let (n, size) = double_area(p);
        if size <= COLLAPSED {
            return (0.5 * size, [Vector3::zeros(); 3]);
        }
        let half = n * (0.5 / size);
        let g = [
            half.cross(&(p[2] - p[1])),
            half.cross(&(p[0] - p[2])),
            half.cross(&(p[1] - p[0])),
        ];
        (0.5 * size, g)
    }

    /// With n the double area vector, N_i = ∂n/∂p_i = \[e_i\]× and the unit n̂:
    /// ½ (N_iᵀ (1 − n̂ n̂ᵀ) N_j / |n| + ∂²(n̂·n)/∂p_i∂p_j at fixed n̂).
    fn add_curvature(
        p: [&Vector3<f64>; 3],
        tension: f64,
        tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        let (n, size) = double_area(p);
        if size <= COLLAPSED || (tangent == Tangent::Positive && tension < 0.0) {
            return;
        }
        let unit = n / size;
        let across = Matrix3::identity() - unit * unit.transpose();
        let rates = [p[2] - p[1], p[0] - p[2], p[1] - p[0]].map(|e| e.cross_matrix());
        let turn = unit.cross_matrix();
        for i in 0..3 {
            for j in 0..3 {
                let mut block = rates[i].transpose() * across * rates[j] / size;
                // The part at fixed n̂ is indefinite: a positive tangent is without it.
                if tangent == Tangent::Exact && i != j {
                    let next = (i + 1) % 3 == j;
                    block += if next { -turn } else { turn };
                }
                *out.block_mut(i, j) += block * (0.5 * tension);
            }
        }
    }
}

impl Measure<4> for Volume {
    const KIND: EnergyKind = EnergyKind::Volume;
    const EXPONENT: u32 = 3;

    #[inline]
    fn value(p: [&Vector3<f64>; 4]) -> f64 {
        microsim_mesh::signed_volume(p[0], p[1], p[2], p[3])
    }

    #[inline]
    fn gradient(p: [&Vector3<f64>; 4]) -> (f64, [Vector3<f64>; 4]) {
        let (e1, e2, e3) = (p[1] - p[0], p[2] - p[0], p[3] - p[0]);
        let g1 = e2.cross(&e3) / 6.0;
        let g2 = e3.cross(&e1) / 6.0;
        let g3 = e1.cross(&e2) / 6.0;
        (e1.dot(&g1), [-(g1 + g2 + g3), g1, g2, g3])
    }

    /// ∂g_i/∂p_j is a cross-product matrix with an edge; its eigenvalues come in pairs ±, so a positive tangent is without it.
    fn add_curvature(
        p: [&Vector3<f64>; 4],
        tension: f64,
        tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        if tangent == Tangent::Positive {
            return;
        }
        // V = e1·(e2×e3)/6 with e_k = p_k − p_0: ∂²V/∂p1∂p2 = −[e3]×/6 and cyclic.
        let e = [p[1] - p[0], p[2] - p[0], p[3] - p[0]].map(|e| e.cross_matrix() * (tension / 6.0));
        let mut blocks = [[Matrix3::zeros(); 4]; 4];
        for (i, j, k) in [(1, 2, 2), (2, 3, 0), (3, 1, 1)] {
            blocks[i][j] = -e[k];
            blocks[j][i] = e[k];
        }
        // Nothing changes under translation: row and column 0 are minus the sums of the others.
        let columns = [1, 2, 3].map(|i| -(blocks[i][1] + blocks[i][2] + blocks[i][3]));
        for (k, column) in columns.into_iter().enumerate() {
            blocks[k + 1][0] = column;
            blocks[0][k + 1] = column.transpose();
            blocks[0][0] -= column;
        }
        for (i, row) in blocks.iter().enumerate() {
            for (j, block) in row.iter().enumerate() {
                *out.block_mut(i, j) += block;
            }
        }
    }
}
