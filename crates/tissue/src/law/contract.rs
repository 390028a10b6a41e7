//! What every law fulfils, as one test.

use super::decomposition::{FourSvds, SignedSvd};
use super::{Constants, Family, IsotropicLaw, Lame, Law, Matrix9, PrincipalTangent};
use crate::lanes::{LANES, Lanes, four_columns, matrix_of, tangent_of};
use crate::testing::numbers;
use microsim_mesh::FAMILIES;
use nalgebra::{Matrix3, Vector3};

/// Constants of unequal size, in units that make all numbers of order one.
const LAME: Lame = Lame {
    mu: 0.8,
    lambda: 2.5,
};

/// Step of central differences: ∛ε balances rounding ε/d against the truncated d² term, about 4e-11 with numbers of order one.
const STEP: f64 = 6e-6;

/// Difference quotients, relative to the stresses that occur.
const DIFFERENCES: f64 = 1e-8;

/// A few hundred operations on numbers of order one.
const ROUNDING: f64 = 1e-13;

/// Checks one law, with fibre directions where it has any.
pub fn check<L: Law>() {
    check_with::<L>(&L::Parameters::default());
}

/// Checks one law with these parameters, moduli of order one.
pub fn check_with<L: Law>(parameters: &L::Parameters) {
    let mut next = numbers();
    let states = states(&mut next);
    let directions = [
        Vector3::new(0.48, -0.6, 0.64),
        Vector3::new(0.36, 0.48, 0.8),
    ];
    let constants = L::constants(&LAME, parameters).along(directions);
    rest::<L>(&constants);
    for f in &states {
        derivatives::<L>(f, &constants);
        frame_and_axes::<L>(f, &rotation(&mut next), directions, &constants);
        parts::<L>(f, &constants);
        positive_tangent::<L>(f, &constants);
    }
    four_at_once::<L>(&states, &constants);
    far_states::<L>(&constants);
}

/// Checks one isotropic law.
pub fn check_isotropic<L: IsotropicLaw>() {
    check::<L>();
    let constants = L::constants(&LAME, &L::Parameters::default());
    assert_eq!(constants.along([Vector3::y(); FAMILIES]), constants);
    for f in states(&mut numbers()) {
        nearest_tangent::<L>(&f, &constants);
    }
}

/// Moderate and large strain, near and far from a rotation, some inverted.
fn states(next: &mut impl FnMut() -> f64) -> Vec<Matrix3<f64>> {
    let mut states = Vec::new();
    for size in [0.05, 0.3, 0.8] {
        for _ in 0..20 {
            let strain = Matrix3::from_fn(|_, _| next()) * size;
            states.push(rotation(next) * (Matrix3::identity() + strain));
        }
    }
    for stretches in [[1.3, 0.9, -0.4], [1.1, 0.8, -0.2], [2.0, 0.5, 0.1]] {
        let stretches = Matrix3::from_diagonal(&Vector3::from(stretches));
        states.push(rotation(next) * stretches * rotation(next));
    }
    // Where a rotation is not unique nothing can be differentiated, and near it no difference quotient is exact.
    states.retain(|f| {
        let s = SignedSvd::new(f).stretches;
        s[1] + s[2] > 0.2
    });
    assert!(states.len() > 40 && states.iter().any(|f| f.determinant() < 0.0));
    states
}

fn rotation(next: &mut impl FnMut() -> f64) -> Matrix3<f64> {
    SignedSvd::new(&Matrix3::from_fn(|_, _| next())).rotation()
}

/// No energy, no stress, and the tangent of the elasticity that the constants state, whose moduli are those that were given.
fn rest<L: Law>(c: &L::Constants) {
    let one = Matrix3::identity();
    assert!(L::energy(&one, c).abs() < ROUNDING);
    assert!(L::stress(&one, c).amax() < ROUNDING);
    let elasticity = c.elasticity();
    assert!((elasticity.lame.mu - LAME.mu).abs() < ROUNDING);
    assert!((elasticity.lame.lambda - LAME.lambda).abs() < ROUNDING);
    let families = elasticity.families.unwrap_or([Family::NONE; FAMILIES]);
    let expected = Matrix9::from_fn(|p, q| {
        let (i, j, k, l) = (p % 3, p / 3, q % 3, q / 3);
        let same = |a, b| f64::from(u8::from(a == b));
        LAME.lambda * same(i, j) * same(k, l)
            + LAME.mu * (same(i, k) * same(j, l) + same(i, l) * same(j, k))
            + families
                .iter()
                .map(|of| of.stiffness * of.structure[(i, j)] * of.structure[(k, l)])
                .sum::<f64>()
    });
    let error = L::tangent(&one, c) - expected;
    assert!(error.amax() < ROUNDING, "{error}");
}

/// Stress is the gradient of the energy, tangent the derivative of the stress, and symmetric.
fn derivatives<L: Law>(f: &Matrix3<f64>, c: &L::Constants) {
    let (stress, tangent) = (L::stress(f, c), L::tangent(f, c));
    let (stress_scale, tangent_scale) = (stress.amax().max(1.0), tangent.amax().max(1.0));
    for q in 0..9 {
        let [plus, minus] = [STEP, -STEP].map(|d| {
            let mut moved = *f;
            moved.as_mut_slice()[q] += d;
            moved
        });
        let slope = (L::energy(&plus, c) - L::energy(&minus, c)) / (2.0 * STEP);
        let error = slope - stress.as_slice()[q];
        assert!(
            error.abs() < DIFFERENCES * stress_scale,
            "stress {q}: {error:e} at {f}"
        );
        let slopes = (L::stress(&plus, c) - L::stress(&minus, c)) / (2.0 * STEP);
        for p in 0..9 {
            let error = slopes.as_slice()[p] - tangent[(p, q)];
            assert!(
                error.abs() < DIFFERENCES * tangent_scale,
                "tangent {p} {q}: {error:e} at {f}"
            );
        }
    }
    assert!((tangent - tangent.transpose()).amax() < ROUNDING * tangent_scale);
}

/// Ψ(Q F) = Ψ(F) and P(Q F) = Q P(F); with the fibres turned by Qᵀ Ψ(F Q) = Ψ(F) and P(F Q) = P(F) Q.
fn frame_and_axes<L: Law>(
    f: &Matrix3<f64>,
    q: &Matrix3<f64>,
    directions: [Vector3<f64>; FAMILIES],
    c: &L::Constants,
) {
    let (energy, stress) = (L::energy(f, c), L::stress(f, c));
    let scale = energy.abs().max(stress.amax()).max(1.0);
    let turned = c.along(directions.map(|a| q.tr_mul(&a)));
    for (f, c, expected) in [(q * f, c, q * stress), (f * q, &turned, stress * q)] {
        assert!((L::energy(&f, c) - energy).abs() < ROUNDING * scale);
        assert!((L::stress(&f, c) - expected).amax() < ROUNDING * scale);
    }
}

/// The isochoric and the volumetric part sum up to the whole; all shear stiffness and all fibres belong to the first, and neither has
/// λ < 0 at small strain.
fn parts<L: Law>(f: &Matrix3<f64>, c: &L::Constants) {
    let parts = c.split().expect("λ is positive");
    let energy: f64 = parts.iter().map(|part| L::energy(f, part)).sum();
    let stress: Matrix3<f64> = parts.iter().map(|part| L::stress(f, part)).sum();
    let tangent: Matrix9 = parts.iter().map(|part| L::tangent(f, part)).sum();
    let scale = L::tangent(f, c).amax().max(energy.abs()).max(1.0);
    assert!((energy - L::energy(f, c)).abs() < ROUNDING * scale);
    assert!((stress - L::stress(f, c)).amax() < ROUNDING * scale);
    assert!((tangent - L::tangent(f, c)).amax() < ROUNDING * scale);
    // A part of the volumetric part may go elsewhere.
    let shares = [c.with_volumetric(0.25), parts[1].with_volumetric(0.75)];
    let stress: Matrix3<f64> = shares.iter().map(|part| L::stress(f, part)).sum();
    assert!((stress - L::stress(f, c)).amax() < ROUNDING * scale);
    assert_eq!(c.with_volumetric(0.0), parts[0]);
    volumetric_part::<L>(f, &parts[1]);
    let [isochoric, volumetric] = parts.map(|part| part.elasticity());
    assert_eq!(
        (volumetric.lame.mu, isochoric.lame.mu),
        (0.0, c.elasticity().lame.mu)
    );
    assert!(volumetric.lame.lambda > 0.0 && isochoric.lame.lambda >= 0.0);
    let families = volumetric.families.into_iter().flatten();
    assert!(families.into_iter().all(|family| family.stiffness == 0.0));
}

/// The volumetric part is the same at every F with this volume, if and only if its name states that.
fn volumetric_part<L: Law>(f: &Matrix3<f64>, volumetric: &L::Constants) {
    let mut round = Matrix3::identity();
    round[(0, 0)] = f.determinant();
    let [energy, other] = [f, &round].map(|f| L::energy(f, volumetric));
    let same = (energy - other).abs() < ROUNDING * energy.abs().max(1.0);
    assert_eq!(
        same,
        L::NAME.is_volumetric_of_j(),
        "{energy} {other} at {f}"
    );
}

/// The positive tangent has no negative eigenvalue, and is nowhere below the exact one.
fn positive_tangent<L: Law>(f: &Matrix3<f64>, c: &L::Constants) {
    let exact = L::tangent(f, c);
    let positive = L::positive_tangent(&SignedSvd::new(f), c);
    let least = -10.0 * ROUNDING * exact.amax().max(1.0);
    assert!((positive - positive.transpose()).amax() < -least);
    assert!(positive.symmetric_eigenvalues().min() > least, "at {f}");
    let above = positive - exact;
    let above = (above + above.transpose()) * 0.5;
    assert!(above.symmetric_eigenvalues().min() > least, "at {f}");
}

/// Those of four elements at once have the same bits as one after the other, whose constants differ.
fn four_at_once<L: Law>(states: &[Matrix3<f64>], c: &L::Constants) {
    let constants = [1.0, 0.5, 0.75, 0.0].map(|factor| c.with_volumetric(factor));
    for f in states.as_chunks::<LANES>().0 {
        let columns = four_columns(f);
        let svds = FourSvds::new(&columns);
        let mut tangents = [[Lanes::splat(0.0); 9]; 9];
        L::set_positive_tangents_of_each(&svds, &constants, &mut tangents);
        let energies = L::energy_of_each(&columns, &constants);
        let stresses = L::stress_of_each(&columns, &constants);
        for (lane, c) in constants.iter().enumerate() {
            let one = L::positive_tangent(&svds.of(lane), c);
            assert_eq!(tangent_of(&tangents, lane), one);
            assert_eq!(energies.0[lane], L::energy(&f[lane], c));
            assert_eq!(matrix_of(&stresses, lane), L::stress(&f[lane], c));
        }
    }
}

/// In principal axes the tangent is the same, and its positive form is the dense one with the eigenvalues cut off at zero.
fn nearest_tangent<L: IsotropicLaw>(f: &Matrix3<f64>, c: &L::Constants) {
    let svd = SignedSvd::new(f);
    let tangent = L::tangent(f, c);
    let scale = tangent.amax().max(1.0);
    let principal: PrincipalTangent = L::principal_tangent(&svd.stretches, c);
    assert!((principal.rotated(&svd) - tangent).amax() < ROUNDING * scale);
    let eigen = tangent.symmetric_eigen();
    let cut = Matrix9::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0)));
    let nearest = eigen.eigenvectors * cut * eigen.eigenvectors.transpose();
    let error = (L::positive_tangent(&svd, c) - nearest).amax();
    assert!(error < 10.0 * ROUNDING * scale, "{error:e} at {f}");
}

/// Finite where laws with logarithms or rotations break: flat, collapsed, inverted, huge.
fn far_states<L: Law>(c: &L::Constants) {
    for stretches in [
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, -1.0],
        [1.0, 0.5, -0.5],
        [-1.0, -1.0, -1.0],
        [1e6, 1e-6, -1e6],
    ] {
        let f = Matrix3::from_diagonal(&Vector3::from(stretches));
        assert!(L::energy(&f, c).is_finite(), "{stretches:?}");
        assert!(
            L::stress(&f, c).iter().all(|p| p.is_finite()),
            "{stretches:?}"
        );
        assert!(
            L::tangent(&f, c).iter().all(|p| p.is_finite()),
            "{stretches:?}"
        );
        let svd = SignedSvd::new(&f);
        let positive = L::positive_tangent(&svd, c);
        assert!(positive.iter().all(|p| p.is_finite()), "{stretches:?}");
    }
}
