//! A known tip comes back from poses with noise, within the error that the theory of least squares gives.

use super::*;
use crate::QuaternionError;
use crate::random::Stream;
use microsim_message::Pose;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// A tip as that of micro-forceps: 130 mm before the tracked point, a little beside its axis `[m]`.
const TIP: [f64; 3] = [4e-3, -2e-3, -0.13];
const CENTRE: [f64; 3] = [0.05, -0.2, 0.8];

fn normals(random: &mut Stream, sigma: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| sigma * random.normal())
}

/// Orientations of a handle that is tilted to all sides by up to `tilt` and turned about its axis by up to `turn` `[rad]`.
fn orientations(
    random: &mut Stream,
    count: usize,
    tilt: f64,
    turn: f64,
) -> Vec<UnitQuaternion<f64>> {
    let both = |random: &mut Stream, most: f64| most * (2.0 * random.unit() - 1.0);
    let one = |_| {
        let tilted = Vector3::new(both(random, tilt), both(random, tilt), 0.0);
        let turned = Vector3::new(0.0, 0.0, both(random, turn));
        UnitQuaternion::from_scaled_axis(tilted) * UnitQuaternion::from_scaled_axis(turned)
    };
    (0..count).map(one).collect()
}

/// Poses about a tip that stands; positions are off by `sigma` `[m]` along each axis, orientations by `angle` `[rad]`.
fn poses(random: &mut Stream, turns: &[UnitQuaternion<f64>], sigma: f64, angle: f64) -> Vec<Pose> {
    let one = |turn: &UnitQuaternion<f64>| {
        let place = Vector3::from(CENTRE) - turn * Vector3::from(TIP) + normals(random, sigma);
        let seen = turn * UnitQuaternion::from_scaled_axis(normals(random, angle));
        Pose {
            position: place.into(),
            orientation: seen.coords.into(),
        }
    };
    turns.iter().map(one).collect()
}

/// Whether a sum of squares with this many degrees of freedom is that of χ², within four of its standard deviations.
#[track_caller]
fn assert_chi_square(sum: f64, degrees: f64) {
    let off = (sum - degrees) / (2.0 * degrees).sqrt();
    assert!(
        off.abs() < 4.0,
        "{sum} of {degrees} degrees of freedom: {off} standard deviations"
    );
}

#[test]
fn without_noise_the_tip_is_exact() {
    let mut random = Stream::new(1, 0);
    let turns = orientations(&mut random, 50, 0.5, 0.8);
    let found = pivot(&poses(&mut random, &turns, 0.0, 0.0)).expect("a tip");
    // Rounding of coordinates of size 1, amplified by 1/λ of about ten.
    let rounding = 100.0 * f64::EPSILON;
    for axis in 0..3 {
        assert!((found.tip[axis] - TIP[axis]).abs() < rounding, "{found:?}");
        assert!(
            (found.centre[axis] - CENTRE[axis]).abs() < rounding,
            "{found:?}"
        );
    }
    assert!(found.rms < rounding, "{}", found.rms);
}

/// 300 calibrations of 100 poses with noise of 0.1 mm: (t̂ − t)ᵀ S (t̂ − t)/σ² has three degrees of freedom and the sum of squared residuals over σ² has
/// 3·100 − 6; the estimate of σ and the stated error follow from them.
#[test]
fn a_known_tip_comes_back_within_the_error_of_least_squares() {
    const TRIALS: u64 = 300;
    let sigma = 1e-4;
    let (mut tips, mut residuals, mut stated, mut real) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..TRIALS {
        let mut random = Stream::new(seed, 1);
        let turns = orientations(&mut random, 100, 0.5, 0.8);
        let found = pivot(&poses(&mut random, &turns, sigma, 0.0)).expect("a tip");
        let off = Vector3::from(found.tip) - Vector3::from(TIP);
        let information = Matrix3::from(found.cofactor)
            .try_inverse()
            .expect("regular");
        tips += (off.transpose() * information * off)[0] / (sigma * sigma);
        residuals += found.residuals.iter().map(|r| r * r).sum::<f64>() / (sigma * sigma);
        stated += found.tip_error() * found.tip_error();
        real += off.norm_squared();
    }
    let trials = TRIALS as f64;
    assert_chi_square(tips, 3.0 * trials);
    assert_chi_square(residuals, (3.0 * 100.0 - 6.0) * trials);
    // The mean square of what is stated is that of what is true: its standard deviation is at most √2 of one trial's.
    assert!(
        (real / stated - 1.0).abs() < 4.0 * (2.0 / trials).sqrt(),
        "{real} {stated}"
    );
}

/// Noise of orientations, 0.2°, is one of positions by R (δ × t): the covariance of the tip is then S⁻¹ Σ B C Bᵀ S⁻¹ with B = 1 − R̄ᵀ R and
/// C = σ² (|t|² 1 − t tᵀ), to first order in δ.
#[test]
fn noise_of_orientations_has_the_error_of_its_lever() {
    const TRIALS: u64 = 300;
    let angle = 0.2_f64.to_radians();
    let tip = Vector3::from(TIP);
    let lever =
        (Matrix3::identity() * tip.norm_squared() - tip * tip.transpose()) * (angle * angle);
    let mut sum = 0.0;
    for seed in 0..TRIALS {
        let mut random = Stream::new(seed, 2);
        let turns = orientations(&mut random, 100, 0.5, 0.8);
        let found = pivot(&poses(&mut random, &turns, 0.0, angle)).expect("a tip");
        let matrices: Vec<Matrix3<f64>> = turns
            .iter()
            .map(|q| q.to_rotation_matrix().into_inner())
            .collect();
        let mean = matrices.iter().sum::<Matrix3<f64>>() / 100.0;
        let mut middle = Matrix3::zeros();
        for turn in &matrices {
            let b = Matrix3::identity() - mean.transpose() * turn;
            middle += b * lever * b.transpose();
        }
        let inverse = Matrix3::from(found.cofactor);
        let covariance = inverse * middle * inverse;
        let off = Vector3::from(found.tip) - tip;
        sum += (off.transpose() * covariance.try_inverse().expect("regular") * off)[0];
    }
    assert_chi_square(sum, 3.0 * TRIALS as f64);
}

/// Turned about one axis alone the tip may be anywhere along it, and rocked by five degrees nearly so: refused, with the direction and what to do.
#[test]
fn too_little_rotation_is_refused_with_what_to_do() {
    let mut random = Stream::new(7, 0);
    let about_one = orientations(&mut random, 100, 0.0, 1.0);
    let refused = pivot(&poses(&mut random, &about_one, 1e-4, 0.0)).expect_err("one axis");
    let PivotError::TooLittleRotation { spread, direction } = refused else {
        panic!("{refused:?}");
    };
    assert!(
        spread < 1e-6 && (direction[2].abs() - 1.0).abs() < 1e-9,
        "{refused:?}"
    );
    let words = refused.to_string();
    assert!(
        words.contains("tilt the handle") && words.contains("0.0°"),
        "{words}"
    );
    let rocked = orientations(&mut random, 100, 5.0_f64.to_radians(), 0.1);
    let refused = pivot(&poses(&mut random, &rocked, 1e-4, 0.0)).expect_err("five degrees");
    assert!(
        matches!(refused, PivotError::TooLittleRotation { .. }),
        "{refused:?}"
    );
}

#[test]
fn poses_that_are_none_are_refused() {
    let mut random = Stream::new(8, 0);
    let turns = orientations(&mut random, 30, 0.5, 0.8);
    let good = poses(&mut random, &turns, 1e-4, 0.0);
    assert_eq!(pivot(&good[..19]), Err(PivotError::TooFew(19)));
    let mut bad = good.clone();
    bad[3].position[1] = f64::NAN;
    assert_eq!(pivot(&bad), Err(PivotError::NotFinite(3)));
    let mut bad = good;
    bad[4].orientation = [0.0; 4];
    assert_eq!(
        pivot(&bad),
        Err(PivotError::Orientation(4, QuaternionError::Zero))
    );
}
