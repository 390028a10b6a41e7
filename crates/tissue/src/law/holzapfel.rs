//! Laws of arterial walls: two families of dispersed fibres that stiffen exponentially, in a neo-Hookean matrix.

use super::constants::FourFamilies;
use super::decomposition::{SignedSvd, cofactor, cofactor_of};
use super::elasticity::{Elasticity, Family, FamilyOf, Lame};
use super::exponential::exponential;
use super::invariants::{self, InvariantDerivatives};
use super::volume::volume_power;
use super::{
    Constants, Law, LawName, Matrix9, NeoHookean, Parameters, PrincipalTangent, neo_hookean,
};
use crate::lanes::{FourTangents, FourVectors, Lanes};
use crate::number::{
    Columns, Columns9, Number, Three, add_outer, columns, columns_of, components_of, dot, entries,
    norm_squared, product,
};
use crate::range::{MaterialError, require};
use microsim_mesh::FAMILIES;
use nalgebra::{Matrix3, SVector, Vector3};

/// Ψ = Ψ_nH(F) + Σ φ(E) over two families of fibres, E = H:C − 1 with C = FᵀF and H = κ 1 + (1 − 3κ) a₀ ⊗ a₀, and
/// φ(E) = k₁/(2 k₂) (exp(k₂ E²) − 1) where E > 0, else 0 (Holzapfel, Gasser & Ogden 2000; with dispersion Gasser, Ogden & Holzapfel
/// 2006; fibres with the full invariants Nolan, Gower, Destrade, Ogden & McGarry 2014).
///
/// E and ν are those of the neo-Hookean matrix (Bonet & Wood 1997), whose shear modulus is the constant c of the papers. E = κ (tr C − 3) +
/// (1 − 3κ) (a₀·C a₀ − 1) is the mean over the fibres of a family of the square of their stretch less one: κ = 0 is that of fibres that all
/// lie along a₀, κ = 1/3 has no direction. A family bears no compression; its stress begins continuously, its stiffness does not.
///
/// The papers write E with the isochoric C̄ = J^(−2/3) C, for an incompressible wall, where both are one. At the finite compressibility of
/// elements fibres of C̄ bear no dilation, and a wall that is pulled along them swells ([`HolzapfelGasserOgdenIsochoric`]); with the full
/// invariants it does not.
///
/// Where k₂ E² exceeds 12, of a stress of 1.6·10⁵ times k₁ E and far beyond what tissue bears, φ goes on as its Taylor polynomial of second
/// order: every F has finite values.
///
/// # Limitations
/// As every fibre that does not lie along edges, stiff ones lock linear elements ([`TransverselyIsotropic`](super::TransverselyIsotropic)).
/// Fibres stiffen exponentially: bounds of the explicit step at rest do not hold under stretch.
#[derive(Clone, Copy, Debug, Default)]
pub struct HolzapfelGasserOgden;

/// The same with fibres of the isochoric C̄ = J^(−2/3) C: E = J^(−2/3) H:C − 1 (Gasser, Ogden & Holzapfel 2006), for comparison.
///
/// # Limitations
/// Fibres do not resist dilation, and under tension they dilate the matrix: a wall pulled along its fibres swells where the matrix is
/// compressible (Nolan et al. 2014). Below J = 1/5 the power goes on as its Taylor polynomial. The positive tangent takes the eigenvalues of a
/// 9 × 9 matrix for each family.
#[derive(Clone, Copy, Debug, Default)]
pub struct HolzapfelGasserOgdenIsochoric;

/// What fibres of a wall are given beside E and ν of their matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HolzapfelParameters {
    /// k₁ \[Pa\], ≥ 0.
    pub fibre_stiffness: f64,
    /// k₂, 0 to 10⁴.
    pub fibre_exponent: f64,
    /// Dispersion κ, 0 to 1/3.
    pub fibre_dispersion: f64,
}

impl Default for HolzapfelParameters {
    /// A media of moderate stiffness, 10 kPa, with little dispersion.
    fn default() -> Self {
        Self {
            fibre_stiffness: 10e3,
            fibre_exponent: 1.0,
            fibre_dispersion: 0.1,
        }
    }
}

impl Parameters for HolzapfelParameters {
    fn read<E>(value: &dyn Fn(&'static str) -> Result<f64, E>) -> Result<Self, E> {
        Ok(Self {
            fibre_stiffness: value("fibre_stiffness")?,
            fibre_exponent: value("fibre_exponent")?,
            fibre_dispersion: value("fibre_dispersion")?,
        })
    }

    fn check(&self, _poisson: f64) -> Result<(), MaterialError> {
        let k1 = self.fibre_stiffness;
        require(
            k1.is_finite() && k1 >= 0.0,
            "fibre_stiffness",
            k1,
            ">= 0 Pa",
        )?;
        let k2 = self.fibre_exponent;
        require(
            (0.0..=LARGEST_EXPONENT).contains(&k2),
            "fibre_exponent",
            k2,
            "0 to 10000; arteries have 0.1 to 500",
        )?;
        let dispersion = self.fibre_dispersion;
        require(
            (0.0..=1.0 / 3.0).contains(&dispersion),
            "fibre_dispersion",
            dispersion,
            "0 (all along one direction) to 1/3 (no direction)",
        )
    }
}

/// Largest k₂: from there on a family bears less than 2 % of stretch.
const LARGEST_EXPONENT: f64 = 1e4;

/// k₂ E² from which on φ goes on as a polynomial.
const LARGEST_POWER: f64 = 12.0;

/// E to which rounding leaves fibres at rest.
const AT_REST: f64 = 1e-12;

/// Lamé's constants of the matrix, and the fibres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HolzapfelConstants {
    /// Of the matrix.
    pub lame: Lame,
    /// k₁, k₂, κ.
    pub fibres: HolzapfelParameters,
    /// E from which on φ goes on as a polynomial.
    pub end: f64,
    /// Whether fibres are those of the isochoric deformation.
    pub isochoric: bool,
    /// Unit vectors a₀ along the fibres in the natural state; zero for a family that is not there.
    pub directions: [Vector3<f64>; FAMILIES],
}

impl Constants for HolzapfelConstants {
    const DIRECTIONS: usize = FAMILIES;

    #[inline(always)]
    fn along(self, directions: [Vector3<f64>; FAMILIES]) -> Self {
        Self { directions, ..self }
    }

    #[inline(always)]
    fn elasticity(&self) -> Elasticity {
        let families = self.families_at_rest(&components_of(&self.directions));
        let family = |(stiffness, structure): FamilyOf<f64>| Family {
            stiffness,
            structure: structure.into(),
        };
        Elasticity {
            lame: self.lame,
            families: families.map(|families| families.map(family)),
        }
    }

    #[inline(always)]
    fn families_of_four(&self, directions: &[FourVectors; FAMILIES]) -> Option<FourFamilies> {
        self.families_at_rest(directions)
    }

    fn split(self) -> Option<[Self; 2]> {
        let [isochoric, volumetric] = self.lame.split()?;
        let without = HolzapfelParameters {
            fibre_stiffness: 0.0,
            ..self.fibres
        };
        Some([
            Self {
                lame: isochoric,
                ..self
            },
            Self {
                lame: volumetric,
                fibres: without,
                ..self
            },
        ])
    }

    fn with_volumetric(self, factor: f64) -> Self {
        Self {
            lame: self.lame.with_volumetric(factor),
            ..self
        }
    }
}

impl HolzapfelConstants {
    fn new(lame: &Lame, parameters: &HolzapfelParameters, isochoric: bool) -> Self {
        Self {
            lame: *lame,
            fibres: *parameters,
            end: (LARGEST_POWER / parameters.fibre_exponent).sqrt(),
            isochoric,
            directions: [Vector3::zeros(); FAMILIES],
        }
    }

    /// The directions of the families that are there and bear something.
    #[inline(always)]
    fn families(&self) -> impl Iterator<Item = &Vector3<f64>> {
        let bears = self.fibres.fibre_stiffness > 0.0;
        let there = self.directions.iter();
        there.filter(move |a| bears && **a != Vector3::zeros())
    }

    /// H = κ 1 + (1 − 3κ) a₀ ⊗ a₀.
    #[inline(always)]
    fn structure<N: Number>(&self, a: &Three<N>) -> Columns<N> {
        let dispersion = self.fibres.fibre_dispersion;
        let aligned = N::of(1.0 - 3.0 * dispersion);
        let mut structure = columns(|k, i| a[i] * a[k] * aligned);
        for (k, column) in structure.iter_mut().enumerate() {
            column[k] = column[k] + N::of(dispersion);
        }
        structure
    }

    /// m and H of the elasticity at rest. At small strain φ is ½ k₁ (2 H:ε)², so m = 4 k₁ under tension; of the isochoric deformation with
    /// H − 1/3 in place of H.
    #[inline(always)]
    fn families_at_rest<N: Number>(
        &self,
        directions: &[Three<N>; FAMILIES],
    ) -> Option<[FamilyOf<N>; FAMILIES]> {
        let stiffness = N::of(4.0 * self.fibres.fibre_stiffness);
        let family = |a: &Three<N>| {
            let mut structure = self.structure(a);
            if self.isochoric {
                for (k, column) in structure.iter_mut().enumerate() {
                    column[k] = column[k] - N::of(1.0 / 3.0);
                }
            }
            let stiffness = dot(a, a).select_above(0.0, stiffness, N::of(0.0));
            (stiffness, structure)
        };
        (self.fibres.fibre_stiffness > 0.0).then(|| directions.each_ref().map(family))
    }

    /// (1 − 3κ) F a₀ and H:C: F H is κ F and the outer product of the first with a₀.
    #[inline(always)]
    fn stretched<N: Number>(&self, f: &Columns<N>, a: &Three<N>) -> (Three<N>, N) {
        let dispersion = self.fibres.fibre_dispersion;
        let aligned = N::of(1.0 - 3.0 * dispersion);
        let fa = product(f, a);
        let square = N::of(dispersion) * norm_squared(f) + aligned * dot(&fa, &fa);
        (fa.map(|x| x * aligned), square)
    }

    /// F H and H:C.
    #[inline(always)]
    fn pulled<N: Number>(&self, f: &Columns<N>, a: &Three<N>) -> (Columns<N>, N) {
        let (along, square) = self.stretched(f, a);
        let dispersion = N::of(self.fibres.fibre_dispersion);
        (
            columns(|k, i| f[k][i] * dispersion + along[i] * a[k]),
            square,
        )
    }

    /// φ \[J/m³\] and its derivatives \[Pa\] by E.
    #[inline(always)]
    fn exponential<N: Number>(&self, e: N) -> [N; 3] {
        let of = N::of;
        let (k1, k2) = (self.fibres.fibre_stiffness, self.fibres.fibre_exponent);
        let pull = e.most(of(0.0));
        // Beyond its end the polynomial goes on from there.
        let at = pull.least(of(self.end));
        let beyond = pull - at;
        let power = of(k2) * at * at;
        let [growth, exp] = exponential(power);
        // (exp(q) − 1)/q, of q without rounding of what is small.
        let mean = power.select_above(0.0, growth / power, of(1.0));
        let energy = of(0.5 * k1) * at * at * mean;
        let slope = of(k1) * at * exp;
        let curvature = of(k1) * (of(1.0) + of(2.0) * power) * exp;
        [
            energy + beyond * (slope + of(0.5) * curvature * beyond),
            slope + curvature * beyond,
            // At rest, where E is zero to rounding, fibres count as under tension.
            e.select_above(-AT_REST, curvature, of(0.0)),
        ]
    }

    /// E = g H:C − 1; −1, at which fibres bear nothing, of a family that is not there.
    #[inline(always)]
    fn strain<N: Number>(&self, square: N, power: N, a: &Three<N>) -> N {
        dot(a, a).select_above(0.0, power * square - N::of(1.0), N::of(-1.0))
    }

    /// Ψ with these g(J).
    #[inline(always)]
    fn energy<N: Number>(
        &self,
        f: &Columns<N>,
        directions: &[Three<N>; FAMILIES],
        volume_power: impl Fn(N) -> [N; 3],
    ) -> N {
        let (_, j) = cofactor_of(f);
        let mut energy = neo_hookean::energy(norm_squared(f), j, &self.lame);
        if self.fibres.fibre_stiffness > 0.0 {
            let [power, ..] = volume_power(j);
            for a in directions {
                let (_, square) = self.stretched(f, a);
                let [of_family, ..] = self.exponential(self.strain(square, power, a));
                energy = energy + of_family;
            }
        }
        energy
    }

    /// P with these g(J): of the matrix, and φ' ∂E/∂F = φ' (2g F H + g' H:C cof F) of each family.
    #[inline(always)]
    fn stress<N: Number>(
        &self,
        f: &Columns<N>,
        directions: &[Three<N>; FAMILIES],
        volume_power: impl Fn(N) -> [N; 3],
    ) -> Columns<N> {
        let (cofactor, j) = cofactor_of(f);
        let mut along = N::of(self.lame.mu);
        let [mut across, _] = neo_hookean::volume_slopes(j, &self.lame);
        let mut of_fibres = [[N::of(0.0); 3]; 3];
        if self.fibres.fibre_stiffness > 0.0 {
            let [power, power_slope, _] = volume_power(j);
            let dispersion = N::of(self.fibres.fibre_dispersion);
            for a in directions {
                let (stretched, square) = self.stretched(f, a);
                let [_, slope, _] = self.exponential(self.strain(square, power, a));
                let pull = N::of(2.0) * slope * power;
                along = along + pull * dispersion;
                across = across + slope * power_slope * square;
                let pulled = stretched.map(|x| x * pull);
                of_fibres = columns(|k, i| of_fibres[k][i] + pulled[i] * a[k]);
            }
        }
        columns(|k, i| f[k][i] * along + cofactor[k][i] * across + of_fibres[k][i])
    }

    /// ∂P/∂F with full invariants.
    #[inline(always)]
    fn set_tangent<N: Number>(
        &self,
        f: &Columns<N>,
        directions: &[Three<N>; FAMILIES],
        tangent: &mut Columns9<N>,
    ) {
        let (cofactor, j) = cofactor_of(f);
        let derivatives = neo_hookean::derivatives(j, &self.lame);
        invariants::set_tangent(f, &cofactor, &derivatives, tangent);
        self.add_tangent(f, directions, tangent);
    }

    /// Adds 4φ'' n nᵀ + 2φ' (1 ⊗ H) with n = F H: ∂²φ/∂F² of full invariants. H and φ' have no negative eigenvalue, and neither has this.
    #[inline(always)]
    fn add_tangent<N: Number>(
        &self,
        f: &Columns<N>,
        directions: &[Three<N>; FAMILIES],
        tangent: &mut Columns9<N>,
    ) {
        if self.fibres.fibre_stiffness == 0.0 {
            return;
        }
        for a in directions {
            let (pulled, square) = self.pulled(f, a);
            let [_, slope, curvature] = self.exponential(self.strain(square, N::of(1.0), a));
            add_outer(tangent, &entries(&pulled), N::of(4.0) * curvature);
            add_second(tangent, N::of(2.0) * slope, &self.structure(a));
        }
    }
}

/// g of the full invariants, and its derivatives.
#[inline(always)]
fn full<N: Number>(_j: N) -> [N; 3] {
    [1.0, 0.0, 0.0].map(N::of)
}

/// Adds a factor times δ_ik H_jl at (i + 3j, k + 3l): the derivative of F H by F.
#[inline(always)]
fn add_second<N: Number>(tangent: &mut Columns9<N>, factor: N, structure: &Columns<N>) {
    for l in 0..3 {
        for j in 0..3 {
            let along = factor * structure[l][j];
            for i in 0..3 {
                let entry = &mut tangent[i + 3 * l][i + 3 * j];
                *entry = *entry + along;
            }
        }
    }
}

impl Law for HolzapfelGasserOgden {
    type Constants = HolzapfelConstants;
    type Parameters = HolzapfelParameters;
    const NAME: LawName = LawName::HolzapfelGasserOgden;

    fn constants(lame: &Lame, parameters: &HolzapfelParameters) -> HolzapfelConstants {
        HolzapfelConstants::new(lame, parameters, false)
    }

    fn energy(f: &Matrix3<f64>, c: &HolzapfelConstants) -> f64 {
        c.energy(&columns_of(f), &components_of(&c.directions), full)
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, c: &HolzapfelConstants) -> Matrix3<f64> {
        c.stress(&columns_of(f), &components_of(&c.directions), full)
            .into()
    }

    #[inline(always)]
    fn energy_of_four(
        f: &[FourVectors; 3],
        directions: &[FourVectors; FAMILIES],
        c: &HolzapfelConstants,
    ) -> Lanes {
        c.energy(f, directions, full)
    }

    #[inline(always)]
    fn stress_of_four(
        f: &[FourVectors; 3],
        directions: &[FourVectors; FAMILIES],
        c: &HolzapfelConstants,
    ) -> [FourVectors; 3] {
        c.stress(f, directions, full)
    }

    fn tangent(f: &Matrix3<f64>, c: &HolzapfelConstants) -> Matrix9 {
        let mut tangent = [[0.0; 9]; 9];
        let directions = components_of(&c.directions);
        c.set_tangent(&columns_of(f), &directions, &mut tangent);
        tangent.into()
    }

    #[inline(always)]
    fn set_tangents_of_four(
        f: &[FourVectors; 3],
        directions: &[FourVectors; FAMILIES],
        c: &HolzapfelConstants,
        tangents: &mut FourTangents,
    ) {
        c.set_tangent(f, directions, tangents);
    }

    fn positive_principal_tangent(f: &SignedSvd, c: &HolzapfelConstants) -> PrincipalTangent {
        NeoHookean::positive_principal_tangent(f, &c.lame)
    }

    /// The exact one.
    fn add_positive_fibres(f: &SignedSvd, c: &HolzapfelConstants, tangent: &mut Matrix9) {
        let directions = components_of(&c.directions);
        c.add_tangent(
            &columns_of(&deformation(f)),
            &directions,
            &mut tangent.data.0,
        );
    }
}

/// F of its decomposition.
fn deformation(f: &SignedSvd) -> Matrix3<f64> {
    f.u * Matrix3::from_diagonal(&f.stretches) * f.v.transpose()
}

/// A family of fibres of the isochoric C̄: E = g(J) S − 1, g = J^(−2/3), S = H:C.
struct Isochoric {
    /// ∂E/∂F = 2g F H + g' S cof F.
    slope: Matrix3<f64>,
    /// F H and S.
    stretched: (Matrix3<f64>, f64),
    /// g, g', g''.
    powers: [f64; 3],
    /// φ and its derivatives.
    exponential: [f64; 3],
}

impl Isochoric {
    fn new(c: &HolzapfelConstants, f: &Matrix3<f64>, a: &Vector3<f64>) -> Self {
        let (cofactor, j) = cofactor(f);
        let powers = volume_power(j);
        let [g, g1, _] = powers;
        let (stretched, square) = c.pulled(&columns_of(f), &(*a).into());
        let stretched = Matrix3::from(stretched);
        Self {
            slope: stretched * (2.0 * g) + cofactor * (g1 * square),
            stretched: (stretched, square),
            powers,
            exponential: c.exponential(g * square - 1.0),
        }
    }

    /// ∂²E/∂F² = 2g (1 ⊗ H) + 2g' (F H ⊗ cof + cof ⊗ F H) + S (g'' cof ⊗ cof + g' ∂cof/∂F).
    fn curvature(&self, c: &HolzapfelConstants, f: &Matrix3<f64>, a: &Vector3<f64>) -> Matrix9 {
        let (cofactor, _) = cofactor(f);
        let [g, g1, g2] = self.powers;
        let (stretched, square) = &self.stretched;
        let of_volume = InvariantDerivatives {
            a1: 0.0,
            a2: 0.0,
            b1: g1 * square,
            b2: g2 * square,
        };
        let mut curvature = invariants::tangent(f, &cofactor, &of_volume);
        let [along, across] =
            [stretched, &cofactor].map(|m| SVector::<f64, 9>::from_column_slice(m.as_slice()));
        let mixed = along * across.transpose() * (2.0 * g1);
        curvature += mixed + mixed.transpose();
        add_second(&mut curvature.data.0, 2.0 * g, &c.structure(&(*a).into()));
        curvature
    }

    /// φ'' ∂E ⊗ ∂E.
    fn direct(&self) -> Matrix9 {
        let slope = SVector::<f64, 9>::from_column_slice(self.slope.as_slice());
        slope * slope.transpose() * self.exponential[2]
    }
}

impl Law for HolzapfelGasserOgdenIsochoric {
    type Constants = HolzapfelConstants;
    type Parameters = HolzapfelParameters;
    const NAME: LawName = LawName::HolzapfelGasserOgdenIsochoric;

    fn constants(lame: &Lame, parameters: &HolzapfelParameters) -> HolzapfelConstants {
        HolzapfelConstants::new(lame, parameters, true)
    }

    fn energy(f: &Matrix3<f64>, c: &HolzapfelConstants) -> f64 {
        c.energy(&columns_of(f), &components_of(&c.directions), volume_power)
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, c: &HolzapfelConstants) -> Matrix3<f64> {
        c.stress(&columns_of(f), &components_of(&c.directions), volume_power)
            .into()
    }

    #[inline(always)]
    fn energy_of_four(
        f: &[FourVectors; 3],
        directions: &[FourVectors; FAMILIES],
        c: &HolzapfelConstants,
    ) -> Lanes {
        c.energy(f, directions, volume_power)
    }

    #[inline(always)]
    fn stress_of_four(
        f: &[FourVectors; 3],
        directions: &[FourVectors; FAMILIES],
        c: &HolzapfelConstants,
    ) -> [FourVectors; 3] {
        c.stress(f, directions, volume_power)
    }

    fn tangent(f: &Matrix3<f64>, c: &HolzapfelConstants) -> Matrix9 {
        let mut tangent = NeoHookean::tangent(f, &c.lame);
        for a in c.families() {
            let family = Isochoric::new(c, f, a);
            let slope = family.exponential[1];
            tangent += family.direct() + family.curvature(c, f, a) * slope;
        }
        tangent
    }

    fn positive_principal_tangent(f: &SignedSvd, c: &HolzapfelConstants) -> PrincipalTangent {
        NeoHookean::positive_principal_tangent(f, &c.lame)
    }

    /// Of each family φ'' ∂E ⊗ ∂E, and φ' ∂²E/∂F² with its negative eigenvalues cut off.
    fn add_positive_fibres(f: &SignedSvd, c: &HolzapfelConstants, tangent: &mut Matrix9) {
        let f = deformation(f);
        for a in c.families() {
            let family = Isochoric::new(c, &f, a);
            *tangent += family.direct();
            let slope = family.exponential[1];
            if slope == 0.0 {
                continue;
            }
            let eigen = (family.curvature(c, &f, a) * slope).symmetric_eigen();
            let values = Matrix9::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0)));
            *tangent += eigen.eigenvectors * values * eigen.eigenvectors.transpose();
        }
    }
}

#[cfg(test)]
mod tests;
