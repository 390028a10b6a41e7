//! What a material law is.

use super::constants::{Constants, Parameters};
use super::decomposition::SignedSvd;
use super::elasticity::{Lame, Matrix9};
use crate::lanes::Lanes;
use microsim_vocabulary::LawName;
use nalgebra::Matrix3;
use std::fmt::Debug;

/// A hyperelastic material law.
///
/// ```
/// use microsim_tissue::law::{Lame, Law, NeoHookean};
/// use nalgebra::{Matrix3, Vector3};
///
/// let lame = Lame::from_young_poisson(30e3, 0.45);
/// // 0.1 % of stretch at free sides: E times the strain, up to terms of second order.
/// let f = Matrix3::from_diagonal(&Vector3::new(1.001, 1.0 - 0.00045, 1.0 - 0.00045));
/// let stress = NeoHookean::stress(&f, &lame);
/// assert!((stress[(0, 0)] / (30e3 * 0.001) - 1.0).abs() < 0.01);
/// ```
pub trait Law: Copy + Default + Debug + Send + Sync + 'static {
    /// What its functions take beside F.
    type Constants: Constants;

    /// What it is given beside E and ν.
    type Parameters: Parameters;

    /// Its name in files and reports.
    const NAME: LawName;

    /// Whether Ψ = μ/2 tr FᵀF + (λ+μ)/2 (det F − 1 − μ/(λ+μ))² up to a constant, so that position-based methods can treat it
    /// as two constraints with compliance.
    const IS_SUM_OF_SQUARES: bool = false;

    /// The constants of these moduli and parameters, all checked; a fibre direction is given later.
    fn constants(lame: &Lame, parameters: &Self::Parameters) -> Self::Constants;

    /// Energy density Ψ(F) \[J/m³\], Ψ(1) = 0.
    fn energy(f: &Matrix3<f64>, constants: &Self::Constants) -> f64;

    /// First Piola–Kirchhoff stress P = ∂Ψ/∂F \[Pa\].
    fn stress(f: &Matrix3<f64>, constants: &Self::Constants) -> Matrix3<f64>;

    /// b' \[Pa\] of four F at once from det F, for a law of the form Ψ = μ/2 tr FᵀF + b(det F) whose forces are to be computed by areas:
    /// half the arithmetic, other roundings.
    #[inline(always)]
    fn slope_of_four(_j: Lanes, _constants: &Self::Constants) -> Option<Lanes> {
        None
    }

    /// ∂P/∂F \[Pa\].
    fn tangent(f: &Matrix3<f64>, constants: &Self::Constants) -> Matrix9;

    /// A ∂P/∂F without negative eigenvalues \[Pa\] at a decomposed F, not below the exact one: of an isotropic law the nearest, of a
    /// sum of parts the sum of the nearest ones.
    fn positive_tangent(f: &SignedSvd, constants: &Self::Constants) -> Matrix9;
}
