//! Springs and volumes fitted to Young's modulus and Poisson's ratio, and what the fit leaves.
//!
//! Under a small strain ε a spring along the unit vector u has the energy ½ k L0² (u·ε u)², a volume ½ κ V0 (tr ε)². Averaged
//! over all directions of the strain, springs with S = Σ k L0²/V are an isotropic material of shear modulus S/15 and bulk
//! modulus S/9: Poisson's ratio ¼ (Cauchy), Young's modulus S/6. So springs of E_s = 5μ/2 and volumes of κ = λ − μ have the
//! energy of Lamé's λ and μ in the mean over all directions, which is the least-squares fit of the isotropic part; for ν < ¼ no
//! volume force helps, and E_s = E. Each tetrahedron is fitted for itself, with one k for its six springs, k = 6 E_s V/Σ L0²:
//! so the fit holds for every part of any mesh.
//!
//! What is left is the anisotropy of the mesh. On mirrored Kuhn cells it vanishes: one k per tetrahedron balances axes, face
//! and space diagonals exactly (k ∝ L0 does not). On plain Kuhn cells it is large, as all space diagonals are parallel. A
//! strain that varies from element to element, at a free surface or where volumes lock, is not in this figure.

use super::SpringConstants;
use super::edges::edges;
use crate::homogenise::{EffectiveStiffness, homogenise};
use crate::law::Lame;
use microsim_mesh::{TetMesh, signed_volume};
use nalgebra::Vector3;

/// Fitted moduli of springs, and the error of the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Young's modulus E_s of the springs alone \[Pa\].
    pub stretch_modulus: f64,
    /// κ of the volumes \[Pa\].
    pub volume_modulus: f64,
    /// Young's modulus of the mean over all directions \[Pa\].
    pub achieved_young: f64,
    /// Poisson's ratio of the mean over all directions.
    pub achieved_poisson: f64,
    /// Fraction of the stiffness tensor that is not isotropic ([`EffectiveStiffness::anisotropy`]).
    pub anisotropy: f64,
    /// The remaining error: the largest |E(n)/E − 1| over the 13 directions n along axes, face and space diagonals.
    pub error: f64,
    /// The stiffness tensor of the region.
    pub effective: EffectiveStiffness,
}

/// Fits the elements of `mesh` with the indices `elements` to Young's modulus `young` \[Pa\] and Poisson's ratio `poisson`, in
/// the range of [`SpringConstants::check`].
pub fn fit(mesh: &TetMesh, elements: &[u32], young: f64, poisson: f64) -> Fit {
    let sets = SpringConstants::fitted(young, poisson).build(mesh, elements, 0.0);
    let volume = |&element: &u32| {
        let [a, b, c, d] = mesh.corners(element as usize);
        signed_volume(&a, &b, &c, &d)
    };
    let volume: f64 = elements.iter().map(volume).sum();
    let effective = homogenise(&mesh.positions, &sets, volume);
    let (stretch_modulus, volume_modulus) = fitted_moduli(young, poisson);
    let (achieved_young, achieved_poisson) = effective.isotropic();
    Fit {
        stretch_modulus,
        volume_modulus,
        achieved_young,
        achieved_poisson,
        anisotropy: effective.anisotropy(),
        error: effective.error(young),
        effective,
    }
}

/// E_s and κ \[Pa\].
pub(super) fn fitted_moduli(young: f64, poisson: f64) -> (f64, f64) {
    let Lame { mu, lambda } = Lame::from_young_poisson(young, poisson);
    if lambda > mu {
        (2.5 * mu, lambda - mu)
    } else {
        (young, 0.0)
    }
}

/// The one k of the six springs of a tetrahedron \[N/m\].
pub(super) fn spring_stiffness(corners: &[Vector3<f64>; 4], stretch_modulus: f64) -> f64 {
    let squares: f64 = edges(corners).map(|e| e.norm_squared()).sum();
    let [a, b, c, d] = corners;
    6.0 * stretch_modulus * signed_volume(a, b, c, d) / squares
}
