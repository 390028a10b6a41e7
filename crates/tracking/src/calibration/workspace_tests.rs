//! A known registration comes back from touched points with noise, within the errors that Fitzpatrick, West & Maurer (1998) give.

use super::*;
use crate::random::Stream;
use crate::rotation::rotated;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Points of a plate with a step, as one would mark them `[m]`.
const FIELD: [[f64; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [0.08, 0.0, 0.0],
    [0.08, 0.06, 0.0],
    [0.0, 0.06, 0.0],
    [0.04, 0.03, 0.02],
    [0.02, 0.05, 0.02],
    [0.07, 0.01, 0.01],
];
const TARGET: [f64; 3] = [0.15, -0.05, 0.04];

struct Truth {
    rotation: [f64; 4],
    translation: [f64; 3],
    scale: f64,
}

impl Truth {
    fn random(random: &mut Stream, scale: f64) -> Self {
        let mut vector = || Vector3::from_fn(|_, _| random.normal());
        Self {
            rotation: UnitQuaternion::from_scaled_axis(vector()).coords.into(),
            translation: vector().into(),
            scale,
        }
    }

    /// The point of the device that lies there in the field.
    fn device(&self, field: [f64; 3]) -> [f64; 3] {
        let [x, y, z, w] = self.rotation;
        let off = std::array::from_fn(|i| (field[i] - self.translation[i]) / self.scale);
        rotated([-x, -y, -z, w], off)
    }

    /// The pairs, touched with an error of `sigma` along each axis in lengths of the field `[m]`.
    fn pairs(&self, random: &mut Stream, sigma: f64) -> Vec<Pair> {
        let pair = |field: &[f64; 3]| {
            let device = self.device(*field);
            Pair {
                device: device.map(|x| x + sigma / self.scale * random.normal()),
                field: *field,
            }
        };
        FIELD.iter().map(pair).collect()
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}

#[test]
fn without_noise_the_registration_is_exact() {
    for (seed, scale) in [(1, 1.0), (2, 0.2), (3, 1.0), (4, 5.0)] {
        let mut random = Stream::new(seed, 0);
        let truth = Truth::random(&mut random, scale);
        let found = register(&truth.pairs(&mut random, 0.0), true).expect("a registration");
        // Rounding of coordinates of the device, amplified by the distance of the target over the extent of the points, about three.
        let rounding = 200.0 * f64::EPSILON * (1.0 + 1.0 / scale) * scale.max(1.0);
        assert!(
            (found.scale - scale).abs() < 10.0 * rounding * scale,
            "{found:?}"
        );
        assert!(
            distance(found.apply(truth.device(TARGET)), TARGET) < rounding,
            "{found:?}"
        );
    }
}

/// 400 registrations with noise of 0.1 mm. The sum of squared residuals over σ² has 3N − 6 degrees of freedom, one less with a free scale; the mean square error
/// of a target is ⟨TRE²⟩, whose relative standard deviation is at most √2 for one trial.
#[test]
fn a_known_registration_comes_back_within_the_error_of_theory() {
    const TRIALS: u64 = 400;
    let sigma = 1e-4;
    for (with_scale, unknowns) in [(false, 6.0), (true, 7.0)] {
        let (mut residuals, mut targets) = (0.0, 0.0);
        for seed in 0..TRIALS {
            let mut random = Stream::new(seed, 1);
            let truth = Truth::random(&mut random, if with_scale { 0.25 } else { 1.0 });
            let found =
                register(&truth.pairs(&mut random, sigma), with_scale).expect("a registration");
            residuals += found.residuals.iter().map(|r| r * r).sum::<f64>() / (sigma * sigma);
            let off = distance(found.apply(truth.device(TARGET)), TARGET);
            targets += off * off / (sigma * sigma * found.target_cofactor(TARGET));
        }
        let trials = TRIALS as f64;
        let degrees = (3.0 * FIELD.len() as f64 - unknowns) * trials;
        let off = (residuals - degrees) / (2.0 * degrees).sqrt();
        assert!(
            off.abs() < 4.0,
            "scale {with_scale}: {residuals} of {degrees}"
        );
        let off = (targets - trials) / (2.0 * trials).sqrt();
        assert!(off.abs() < 4.0, "scale {with_scale}: {targets} of {trials}");
    }
}

/// The error of a target in the form of the paper: distances from principal axes of the points.
#[test]
fn the_error_of_a_target_is_that_of_fitzpatrick() {
    let mut random = Stream::new(3, 3);
    let truth = Truth::random(&mut random, 1.0);
    let found = register(&truth.pairs(&mut random, 0.0), false).expect("a registration");
    let points: Vec<Vector3<f64>> = FIELD.iter().map(|p| Vector3::from(*p)).collect();
    let count = points.len() as f64;
    let centre = points.iter().sum::<Vector3<f64>>() / count;
    let scatter: Matrix3<f64> = points
        .iter()
        .map(|p| (p - centre) * (p - centre).transpose())
        .sum();
    let axes = scatter.symmetric_eigen().eigenvectors;
    let target = Vector3::from(TARGET) - centre;
    let from_axis = |v: Vector3<f64>, axis: usize| {
        let axis = axes.column(axis);
        (v - axis * axis.dot(&v)).norm_squared()
    };
    let ratios = (0..3).map(|axis| {
        let mean = points
            .iter()
            .map(|p| from_axis(p - centre, axis))
            .sum::<f64>()
            / count;
        from_axis(target, axis) / mean
    });
    // ⟨FLE²⟩ is 3 σ².
    let expected = 3.0 / count * (1.0 + ratios.sum::<f64>() / 3.0);
    let found = found.target_cofactor(TARGET);
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
}

#[test]
fn points_that_determine_nothing_are_refused() {
    let mut random = Stream::new(9, 0);
    let truth = Truth::random(&mut random, 1.0);
    let good = truth.pairs(&mut random, 1e-5);
    assert_eq!(
        register(&good[..3], false),
        Err(RegistrationError::TooFew(3))
    );
    let line: Vec<Pair> = (0..6)
        .map(|i| {
            let field = [0.02 * f64::from(i), 0.0, 1e-4 * f64::from(i % 2)];
            Pair {
                device: truth.device(field),
                field,
            }
        })
        .collect();
    let refused = register(&line, false).expect_err("a line");
    assert!(matches!(refused, RegistrationError::Line(_)), "{refused:?}");
    assert!(
        refused.to_string().contains("touch one beside it"),
        "{refused}"
    );
    let one = vec![good[0]; 5];
    assert!(matches!(
        register(&one, false),
        Err(RegistrationError::Line(_))
    ));
    let mirrored: Vec<Pair> = good
        .iter()
        .map(|pair| Pair {
            field: [-pair.field[0], pair.field[1], pair.field[2]],
            ..*pair
        })
        .collect();
    let mut steep = mirrored;
    for pair in &mut steep {
        // The height of the plate is a tenth of its length; of a mirrored one with more height nothing is close to a rotation.
        let field = [-pair.field[0], pair.field[1], 3.0 * pair.field[2]];
        pair.device = truth.device(field);
        pair.field[2] *= 3.0;
    }
    assert_eq!(register(&steep, false), Err(RegistrationError::Mirrored));
    let mut bad = good;
    bad[2].field[0] = f64::INFINITY;
    assert_eq!(register(&bad, true), Err(RegistrationError::NotFinite(2)));
}

/// Points in a plane are their own mirror image in it: registered all the same.
#[test]
fn a_flat_plate_is_enough() {
    let mut random = Stream::new(10, 0);
    let truth = Truth::random(&mut random, 1.0);
    let pairs: Vec<Pair> = truth.pairs(&mut random, 5e-5).into_iter().take(4).collect();
    let found = register(&pairs, false).expect("a registration");
    let off = distance(found.apply(truth.device(TARGET)), TARGET);
    // Five standard errors, as the true σ is 0.05 mm.
    assert!(
        off < 5.0 * 5e-5 * found.target_cofactor(TARGET).sqrt(),
        "{off}"
    );
}
