//! What a material law is.

use super::constants::{Constants, Parameters};
use super::decomposition::{FourSvds, SignedSvd};
use super::elasticity::{Lame, Matrix9};
use super::principal::{FourPrincipalTangents, PrincipalTangent};
use crate::lanes::{
    FourTangents, FourVectors, LANES, Lanes, lanes, matrix_of, put_tangent, set_matrix, tangent_of,
    vector_of,
};
use microsim_mesh::FAMILIES;
use microsim_vocabulary::LawName;
use nalgebra::Matrix3;
use std::fmt::Debug;

/// A hyperelastic material law.
///
/// A law is used through its constants, which follow from E, ν and its parameters:
///
/// ```
/// use microsim_tissue::law::{Lame, Law, NeoHookean};
/// use nalgebra::{Matrix3, Vector3};
///
/// let lame = Lame::from_young_poisson(30e3, 0.45);
/// let constants = NeoHookean::constants(&lame, &());
/// // 0.1 % of stretch at free sides: E times the strain, up to terms of second order.
/// let f = Matrix3::from_diagonal(&Vector3::new(1.001, 1.0 - 0.00045, 1.0 - 0.00045));
/// let stress = NeoHookean::stress(&f, &constants);
/// assert!((stress[(0, 0)] / (30e3 * 0.001) - 1.0).abs() < 0.01);
/// ```
///
/// # A law of one's own
/// A whole law with a parameter: St Venant–Kirchhoff elasticity that stiffens with strain. What else a new law of the crate needs is
/// listed in [`law`](super#a-new-law).
///
/// ```
/// use microsim_tissue::MaterialError;
/// use microsim_tissue::law::decomposition::SignedSvd;
/// use microsim_tissue::law::*;
/// use nalgebra::Matrix3;
///
/// /// Ψ = μ (Q + k/2 Q²) + λ/2 tr²E with Green's strain E = (FᵀF − 1)/2 and Q = E:E.
/// #[derive(Clone, Copy, Debug, Default)]
/// struct Stiffening;
///
/// /// What a file gives beside E and ν.
/// #[derive(Clone, Copy, Debug, Default, PartialEq)]
/// struct StiffeningParameters {
///     /// k.
///     stiffening: f64,
/// }
///
/// impl Parameters for StiffeningParameters {
///     fn read<E>(value: &dyn Fn(&'static str) -> Result<f64, E>) -> Result<Self, E> {
///         Ok(Self { stiffening: value("stiffening")? })
///     }
///
///     fn check(&self, _poisson: f64) -> Result<(), MaterialError> {
///         if self.stiffening >= 0.0 {
///             return Ok(());
///         }
///         let (value_name, value) = ("stiffening", self.stiffening);
///         Err(MaterialError { value_name, value, allowed: ">= 0" })
///     }
/// }
///
/// /// What energy, stress and tangent take.
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// struct StiffeningConstants {
///     lame: Lame,
///     stiffening: f64,
/// }
///
/// impl Constants for StiffeningConstants {
///     fn elasticity(&self) -> Elasticity {
///         Elasticity::isotropic(self.lame)
///     }
///
///     /// The term of λ is what resists a change of volume.
///     fn split(self) -> Option<[Self; 2]> {
///         let [isochoric, volumetric] = self.lame.split()?;
///         Some([isochoric, volumetric].map(|lame| Self { lame, ..self }))
///     }
///
///     fn with_volumetric(self, factor: f64) -> Self {
///         Self { lame: self.lame.with_volumetric(factor), ..self }
///     }
/// }
///
/// impl Law for Stiffening {
///     type Constants = StiffeningConstants;
///     type Parameters = StiffeningParameters;
///     // In the crate a name of its own, `LawName::Stiffening`.
///     const NAME: LawName = LawName::StVenantKirchhoff;
///
///     fn constants(lame: &Lame, parameters: &StiffeningParameters) -> StiffeningConstants {
///         StiffeningConstants { lame: *lame, stiffening: parameters.stiffening }
///     }
///
///     fn energy(f: &Matrix3<f64>, c: &StiffeningConstants) -> f64 {
///         let strain = (f.tr_mul(f) - Matrix3::identity()) * 0.5;
///         let (q, trace) = (strain.norm_squared(), strain.trace());
///         c.lame.mu * (q + 0.5 * c.stiffening * q * q) + 0.5 * c.lame.lambda * trace * trace
///     }
///
///     /// P = F S with S = ∂Ψ/∂E = 2μ (1 + k Q) E + λ tr E 1.
///     fn stress(f: &Matrix3<f64>, c: &StiffeningConstants) -> Matrix3<f64> {
///         let strain = (f.tr_mul(f) - Matrix3::identity()) * 0.5;
///         let factor = 2.0 * c.lame.mu * (1.0 + c.stiffening * strain.norm_squared());
///         let pressure = Matrix3::from_diagonal_element(c.lame.lambda * strain.trace());
///         f * (strain * factor + pressure)
///     }
///
///     /// dP = dF S + F dS, one column for each entry of dF.
///     fn tangent(f: &Matrix3<f64>, c: &StiffeningConstants) -> Matrix9 {
///         let strain = (f.tr_mul(f) - Matrix3::identity()) * 0.5;
///         let factor = 2.0 * c.lame.mu * (1.0 + c.stiffening * strain.norm_squared());
///         let pressure = Matrix3::from_diagonal_element(c.lame.lambda * strain.trace());
///         let mut tangent = Matrix9::zeros();
///         for q in 0..9 {
///             let mut df = Matrix3::zeros();
///             df.as_mut_slice()[q] = 1.0;
///             let d_strain = (df.tr_mul(f) + f.tr_mul(&df)) * 0.5;
///             let d_factor = 4.0 * c.lame.mu * c.stiffening * strain.dot(&d_strain);
///             let d_pressure = Matrix3::from_diagonal_element(c.lame.lambda * d_strain.trace());
///             let column = df * (strain * factor + pressure)
///                 + f * (d_strain * factor + strain * d_factor + d_pressure);
///             tangent.column_mut(q).copy_from_slice(column.as_slice());
///         }
///         tangent
///     }
///
///     fn positive_principal_tangent(f: &SignedSvd, c: &StiffeningConstants) -> PrincipalTangent {
///         Self::principal_tangent(&f.stretches, c).positive()
///     }
/// }
///
/// impl IsotropicLaw for Stiffening {}
///
/// // The stress is the gradient of the energy.
/// let lame = Lame::from_young_poisson(1.0, 0.3);
/// let c = Stiffening::constants(&lame, &StiffeningParameters { stiffening: 4.0 });
/// let f = Matrix3::new(1.2, 0.1, 0.0, -0.2, 0.9, 0.3, 0.0, 0.1, 1.1);
/// let stress = Stiffening::stress(&f, &c);
/// for q in 0..9 {
///     let [above, below] = [1e-5, -1e-5].map(|d| {
///         let mut moved = f;
///         moved.as_mut_slice()[q] += d;
///         Stiffening::energy(&moved, &c)
///     });
///     assert!(((above - below) / 2e-5 - stress.as_slice()[q]).abs() < 1e-8);
/// }
/// ```
pub trait Law: Copy + Default + Debug + Send + Sync + 'static {
    /// What energy, stress and tangent take beside F; [`Lame`] for a law of μ and λ alone.
    type Constants: Constants;

    /// What a material gives beside E and ν; `()` for a law of these two alone.
    type Parameters: Parameters;

    /// Its name in files and reports.
    const NAME: LawName;

    /// Whether Ψ = μ/2 tr FᵀF + (λ+μ)/2 (det F − 1 − μ/(λ+μ))² up to a constant, so that position-based methods can treat it
    /// as two constraints with compliance. `false` by default.
    const IS_SUM_OF_SQUARES: bool = false;

    /// The constants from the moduli at small strain and the parameters, all in range ([`Parameters::check`]). A fibre direction is
    /// given later, by [`Constants::along`].
    fn constants(lame: &Lame, parameters: &Self::Parameters) -> Self::Constants;

    /// Energy density Ψ(F) \[J/m³\], Ψ(1) = 0.
    fn energy(f: &Matrix3<f64>, constants: &Self::Constants) -> f64;

    /// First Piola–Kirchhoff stress P = ∂Ψ/∂F \[Pa\].
    fn stress(f: &Matrix3<f64>, constants: &Self::Constants) -> Matrix3<f64>;

    /// For a law of the form Ψ = μ/2 tr FᵀF + b(J): b'(J) \[Pa\] at four J = det F at once, with which nodal forces are sums over face areas
    /// (half the arithmetic, other rounding). `None`, the default, for every other law.
    #[inline(always)]
    fn slope_of_four(_j: Lanes, _constants: &Self::Constants) -> Option<Lanes> {
        None
    }

    /// [`energy`](Self::energy) of four elements at once, F by its columns, each with constants of its own: the same bits. By default one after the
    /// other.
    #[inline(always)]
    fn energy_of_each(f: &[FourVectors; 3], constants: &[Self::Constants; LANES]) -> Lanes {
        let energy = |lane: usize| Self::energy(&matrix_of(f, lane), &constants[lane]);
        Lanes(lanes(energy))
    }

    /// [`stress`](Self::stress) of four elements at once, as [`energy_of_each`](Self::energy_of_each).
    #[inline(always)]
    fn stress_of_each(
        f: &[FourVectors; 3],
        constants: &[Self::Constants; LANES],
    ) -> [FourVectors; 3] {
        let mut stresses = [[Lanes::splat(0.0); 3]; 3];
        for (lane, constants) in constants.iter().enumerate() {
            let stress = Self::stress(&matrix_of(f, lane), constants);
            set_matrix(&mut stresses, lane, &stress);
        }
        stresses
    }

    /// [`energy_of_each`](Self::energy_of_each) of elements with the same constants but for the fibre directions, which [`Constants::along`] takes.
    #[inline(always)]
    fn energy_of_four(
        f: &[FourVectors; 3],
        directions: &[FourVectors; FAMILIES],
        constants: &Self::Constants,
    ) -> Lanes {
        Self::energy_of_each(f, &of_four(directions, constants))
    }

    /// [`stress_of_each`](Self::stress_of_each), as [`energy_of_four`](Self::energy_of_four).
    #[inline(always)]
    fn stress_of_four(
        f: &[FourVectors; 3],
        directions: &[FourVectors; FAMILIES],
        constants: &Self::Constants,
    ) -> [FourVectors; 3] {
        Self::stress_of_each(f, &of_four(directions, constants))
    }

    /// Tangent ∂P/∂F \[Pa\], symmetric; entry (i + 3j, k + 3l) is ∂P_ij/∂F_kl.
    fn tangent(f: &Matrix3<f64>, constants: &Self::Constants) -> Matrix9;

    /// Sets `tangents` to [`tangent`](Self::tangent) of four elements at once, as [`energy_of_four`](Self::energy_of_four).
    #[inline(always)]
    fn set_tangents_of_four(
        f: &[FourVectors; 3],
        directions: &[FourVectors; FAMILIES],
        constants: &Self::Constants,
        tangents: &mut FourTangents,
    ) {
        for (lane, constants) in of_four(directions, constants).iter().enumerate() {
            let tangent = Self::tangent(&matrix_of(f, lane), constants);
            put_tangent(tangents, lane, &tangent);
        }
    }

    /// The nearest tangent of the isotropic part without negative eigenvalues, at F = U diag(σ) Vᵀ and in these axes: of an
    /// [isotropic](super::IsotropicLaw) law [`principal_tangent`](super::IsotropicLaw::principal_tangent) made
    /// [positive](PrincipalTangent::positive), as above.
    fn positive_principal_tangent(f: &SignedSvd, constants: &Self::Constants) -> PrincipalTangent;

    /// Adds to `tangent` what fibres have \[Pa\], without negative eigenvalues; there are none by default, nor in a law without
    /// [directions](Constants::DIRECTIONS), of which this is not asked.
    #[inline(always)]
    fn add_positive_fibres(_f: &SignedSvd, _constants: &Self::Constants, _tangent: &mut Matrix9) {}

    /// Tangent without negative eigenvalues \[Pa\] at F = U diag(σ) Vᵀ, nowhere below the exact one (their difference has no negative
    /// eigenvalue either): what implicit methods take far from equilibrium. The sum of the parts above, which are what a law defines: matrices are
    /// formed from them directly, too.
    fn positive_tangent(f: &SignedSvd, constants: &Self::Constants) -> Matrix9 {
        let mut tangent = Self::positive_principal_tangent(f, constants).rotated(f);
        Self::add_positive_fibres(f, constants, &mut tangent);
        tangent
    }

    /// Sets `tangents` to [`positive_tangent`](Self::positive_tangent) of four elements at once, each with constants of its own: the same bits.
    #[inline(always)]
    fn set_positive_tangents_of_each(
        f: &FourSvds,
        constants: &[Self::Constants; LANES],
        tangents: &mut FourTangents,
    ) {
        positive_principal_tangents::<Self>(f, constants).set_tangents(tangents);
        if Self::Constants::DIRECTIONS == 0 {
            return;
        }
        for (lane, constants) in constants.iter().enumerate() {
            let mut one = tangent_of(tangents, lane);
            Self::add_positive_fibres(&f.of(lane), constants, &mut one);
            put_tangent(tangents, lane, &one);
        }
    }
}

/// [`Law::positive_principal_tangent`] of four elements, each with constants of its own.
#[inline(always)]
pub(crate) fn positive_principal_tangents<L: Law>(
    f: &FourSvds,
    constants: &[L::Constants; LANES],
) -> FourPrincipalTangents {
    let of = lanes(|lane| L::positive_principal_tangent(&f.of(lane), &constants[lane]));
    FourPrincipalTangents::new(&of, f)
}

/// The constants of four elements with these fibre directions.
#[inline(always)]
fn of_four<C: Constants>(directions: &[FourVectors; FAMILIES], constants: &C) -> [C; LANES] {
    lanes(|lane| match C::DIRECTIONS {
        0 => *constants,
        _ => constants.along(directions.each_ref().map(|a| vector_of(a, lane))),
    })
}
