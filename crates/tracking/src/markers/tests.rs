//! Known poses and openings come back from markers that are permuted, hidden, merged and off, within the error that least squares have.

use super::*;
use crate::random::Stream;
use nalgebra::{SVector, UnitQuaternion};

const TOLERANCE: f64 = 5e-4;
const SIGMA: f64 = 1e-4;

/// Forceps: three markers on the handle, one on each arm; the arms' come together to 6 mm when it closes.
fn forceps() -> MarkerModel {
    let still = |x: f64, y: f64, z: f64| Marker {
        closed: [x, y, z],
        open: [x, y, z],
    };
    let arm = |side: f64| Marker {
        closed: [side * 3e-3, 0.0, 0.0],
        open: [side * 9e-3, 0.0, 0.0],
    };
    let markers = vec![
        still(0.0, 15e-3, 90e-3),
        still(-22e-3, -4e-3, 75e-3),
        still(14e-3, -9e-3, 60e-3),
        arm(-1.0),
        arm(1.0),
    ];
    MarkerModel::new(markers, TOLERANCE, 8e-3).expect("markers")
}

struct Truth {
    rotation: UnitQuaternion<f64>,
    translation: Vector3<f64>,
    opening: f64,
}

impl Truth {
    fn random(random: &mut Stream) -> Self {
        let mut vector = |size: f64| Vector3::from_fn(|_, _| size * random.normal());
        Self {
            rotation: UnitQuaternion::from_scaled_axis(vector(1.0)),
            translation: vector(0.3),
            opening: 0.0,
        }
    }

    /// All markers in their order, with errors.
    fn points(&self, model: &MarkerModel, random: &mut Stream, sigma: f64) -> Vec<MarkerPoint> {
        let point = |(index, marker): (usize, &Marker)| {
            let place = self.rotation * marker.at(self.opening) + self.translation;
            MarkerPoint {
                marker: Some(index),
                position: place.map(|x| x + sigma * random.normal()).into(),
            }
        };
        model.markers.iter().enumerate().map(point).collect()
    }

    /// What is off: turn about the device's axes, translation, opening.
    fn off(&self, found: &MarkerFit) -> SVector<f64, 7> {
        let [x, y, z, w] = found.orientation;
        let seen = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z));
        let turn = (seen * self.rotation.inverse()).scaled_axis();
        let shift = Vector3::from(found.position) - self.translation;
        let opening = found.opening.map_or(0.0, |opening| opening - self.opening);
        SVector::from([turn.x, turn.y, turn.z, shift.x, shift.y, shift.z, opening])
    }
}

/// A shuffle of names: each point gets the name of another.
fn permute(points: &mut [MarkerPoint], random: &mut Stream) {
    for last in (1..points.len()).rev() {
        let other = (random.unit() * (last + 1) as f64) as usize;
        let (a, b) = (points[last].marker, points[other].marker);
        points[last].marker = b;
        points[other].marker = a;
    }
}

#[track_caller]
fn assert_chi_square(sum: f64, degrees: f64) {
    let off = (sum - degrees) / (2.0 * degrees).sqrt();
    assert!(
        off.abs() < 4.0,
        "{sum} of {degrees} degrees of freedom: {off} standard deviations"
    );
}

#[test]
fn without_noise_pose_and_opening_are_exact() {
    let model = forceps();
    for seed in 0..20 {
        let mut random = Stream::new(seed, 0);
        let truth = Truth {
            opening: random.unit(),
            ..Truth::random(&mut random)
        };
        let found = model
            .locate(&truth.points(&model, &mut random, 0.0))
            .expect("a pose");
        // Rounding of coordinates below 2 m over the 10 mm of the arms.
        assert!(
            truth.off(&found).amax() < 1e-11,
            "{}: {found:?}",
            truth.off(&found)
        );
        assert_eq!(
            (
                found.seen,
                found.missing,
                found.permuted,
                found.merged,
                found.unknown
            ),
            (5, 0, 0, 0, 0)
        );
    }
}

/// 300 poses with errors of 0.1 mm, names permuted at random: all markers have their places again, errors of pose and opening together have seven degrees of
/// freedom, xᵀ JᵀJ x/σ², and the squared residuals 15 − 7.
#[test]
fn permuted_and_noisy_markers_have_the_error_of_theory() {
    const TRIALS: u64 = 300;
    let model = forceps();
    let (mut errors, mut residuals) = (0.0, 0.0);
    for seed in 0..TRIALS {
        let mut random = Stream::new(seed, 1);
        // Away from the ends, where the opening is cut off.
        let truth = Truth {
            opening: 0.3 + 0.4 * random.unit(),
            ..Truth::random(&mut random)
        };
        let mut points = truth.points(&model, &mut random, SIGMA);
        permute(&mut points, &mut random);
        let wrong = points
            .iter()
            .enumerate()
            .filter(|(i, p)| p.marker != Some(*i))
            .count();
        let found = model.locate(&points).expect("a pose");
        assert_eq!((found.seen, found.permuted), (5, wrong), "seed {seed}");
        let off = truth.off(&found);
        errors += (off.transpose() * found.information * off)[0] / (SIGMA * SIGMA);
        residuals += 5.0 * found.rms * found.rms / (SIGMA * SIGMA);
    }
    assert_chi_square(errors, 7.0 * TRIALS as f64);
    assert_chi_square(residuals, 8.0 * TRIALS as f64);
}

/// One marker hidden, whichever: pose and opening with their larger error, five degrees of freedom less three.
#[test]
fn a_hidden_marker_costs_accuracy_and_is_counted() {
    const TRIALS: u64 = 300;
    let model = forceps();
    let (mut errors, mut residuals, mut poses) = (0.0, 0.0, 0.0);
    for seed in 0..TRIALS {
        let mut random = Stream::new(seed, 2);
        let truth = Truth {
            opening: 0.3 + 0.4 * random.unit(),
            ..Truth::random(&mut random)
        };
        let mut points = truth.points(&model, &mut random, SIGMA);
        points.remove((seed % 5) as usize);
        let found = match model.locate(&points) {
            Ok(found) => found,
            Err(loss) => panic!("seed {seed}: {loss}"),
        };
        assert_eq!(
            (found.seen, found.missing, found.permuted),
            (4, 1, 0),
            "seed {seed}: {found:?}"
        );
        poses += 1.0;
        let off = truth.off(&found);
        errors += (off.transpose() * found.information * off)[0] / (SIGMA * SIGMA);
        residuals += 4.0 * found.rms * found.rms / (SIGMA * SIGMA);
    }
    assert_chi_square(errors, 7.0 * poses);
    assert_chi_square(residuals, 5.0 * poses);
}

/// The arms are hidden: a pose from the handle alone, with the error of three points, and no opening.
#[test]
fn without_the_arms_there_is_a_pose_and_no_opening() {
    const TRIALS: u64 = 300;
    let model = forceps();
    let mut errors = 0.0;
    for seed in 0..TRIALS {
        let mut random = Stream::new(seed, 3);
        let truth = Truth {
            opening: random.unit(),
            ..Truth::random(&mut random)
        };
        let points = truth.points(&model, &mut random, SIGMA);
        let found = model.locate(&points[..3]).expect("a pose");
        assert_eq!((found.opening, found.missing), (None, 2));
        let off = truth.off(&found);
        errors += (off.transpose() * found.information * off)[0] / (SIGMA * SIGMA);
    }
    assert_chi_square(errors, 6.0 * TRIALS as f64);
}

/// Closed, the markers of the arms are seen as one point between them, under the name of either: the pose is as good as with a point at the mean of the two, and
/// both are counted.
#[test]
fn markers_that_merge_are_compared_with_their_mean() {
    let model = forceps();
    for seed in 0..100 {
        let mut random = Stream::new(seed, 4);
        let truth = Truth {
            opening: 0.05 * random.unit(),
            ..Truth::random(&mut random)
        };
        let mut points = truth.points(&model, &mut random, SIGMA);
        let [a, b] = [3, 4].map(|index| Vector3::from(points[index].position));
        points.truncate(3);
        points.push(MarkerPoint {
            marker: Some(3 + (seed % 2) as usize),
            position: ((a + b) * 0.5).into(),
        });
        let found = model.locate(&points).expect("a pose");
        assert_eq!(
            (found.merged, found.missing, found.permuted),
            (2, 0, 0),
            "seed {seed}: {found:?}"
        );
        // Four points, the worst of them off by five σ; levers of the fit are below 2.
        let off = truth.off(&found).fixed_rows::<3>(3).norm();
        assert!(off < 10.0 * SIGMA, "seed {seed}: {off}");
    }
}

/// Two points that are none, as reflections are: left out and counted.
#[test]
fn reflections_are_left_out() {
    let model = forceps();
    for seed in 0..50 {
        let mut random = Stream::new(seed, 5);
        let truth = Truth {
            opening: 0.5,
            ..Truth::random(&mut random)
        };
        let mut points = truth.points(&model, &mut random, SIGMA);
        for _ in 0..2 {
            let off = Vector3::from_fn(|_, _| 0.05 * random.normal());
            points.insert(
                0,
                MarkerPoint {
                    marker: None,
                    position: (truth.translation + off).into(),
                },
            );
        }
        let found = model.locate(&points).expect("a pose");
        assert_eq!((found.seen, found.unknown), (5, 2), "seed {seed}");
    }
}

#[test]
fn what_shows_no_pose_is_named() {
    let model = forceps();
    let mut random = Stream::new(1, 6);
    let truth = Truth {
        opening: 0.5,
        ..Truth::random(&mut random)
    };
    let points = truth.points(&model, &mut random, SIGMA);
    assert_eq!(model.locate(&points[..2]), Err(MarkerLoss::TooFew));
    let mut far = points.clone();
    for (index, point) in far.iter_mut().enumerate() {
        point.position[0] += 0.02 * (index * index) as f64;
    }
    assert_eq!(model.locate(&far), Err(MarkerLoss::NoFit));
    let mut bad = points.clone();
    for point in &mut bad[1..] {
        point.position[2] = f64::NAN;
    }
    assert_eq!(model.locate(&bad), Err(MarkerLoss::TooFew));
}

/// An equilateral triangle has the same distances in three turns: its names decide, and without them nothing does.
#[test]
fn a_symmetric_instrument_is_ambiguous_without_names() {
    let corner = |angle: f64| {
        let place = [0.02 * libm::cos(angle), 0.02 * libm::sin(angle), 0.0];
        Marker {
            closed: place,
            open: place,
        }
    };
    let third = 2.0 * std::f64::consts::PI / 3.0;
    let model = MarkerModel::new(
        (0..3).map(|i| corner(f64::from(i) * third)).collect(),
        5e-4,
        0.0,
    );
    let model = model.expect("markers");
    let mut random = Stream::new(2, 7);
    let truth = Truth::random(&mut random);
    let mut points = truth.points(&model, &mut random, SIGMA);
    let found = model.locate(&points).expect("a pose");
    assert!(
        truth.off(&found).fixed_rows::<3>(0).norm() < 0.1,
        "{found:?}"
    );
    for point in &mut points {
        point.marker = None;
    }
    // Points without names agree with all of them.
    assert_eq!(model.locate(&points), Err(MarkerLoss::Ambiguous));
}

#[test]
fn markers_that_determine_nothing_are_refused() {
    let still = |x: f64, y: f64| Marker {
        closed: [x, y, 0.0],
        open: [x, y, 0.0],
    };
    let new = |markers| MarkerModel::new(markers, TOLERANCE, 0.0);
    assert_eq!(new(vec![still(0.0, 0.0); 2]), Err(MarkerProblem::Count(2)));
    assert_eq!(new(vec![still(0.0, 0.0); 9]), Err(MarkerProblem::Count(9)));
    let line = vec![still(0.0, 0.0), still(0.02, 0.001), still(0.05, 0.0)];
    assert_eq!(new(line), Err(MarkerProblem::Line));
    let good = vec![still(0.0, 0.0), still(0.02, 0.03), still(0.05, 0.0)];
    let nan = vec![good[0], still(f64::NAN, 0.0), good[2]];
    assert_eq!(new(nan), Err(MarkerProblem::NotFinite(1)));
    assert_eq!(
        MarkerModel::new(good, 0.0, 0.0),
        Err(MarkerProblem::Rule(0.0))
    );
}
