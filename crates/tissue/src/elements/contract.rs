//! What every set of elements must hold: one check for all kinds.
//!
//! Differences are central with δ = 1e-5 of bodies of size one: truncation δ² f'''/6 and rounding ε/δ both stay below 1e-9 of
//! the scale of what is differentiated.

use super::{Configuration, ElementMatrix, Elements, MatrixWindow, NodeWindow, Slots, Tangent};
use microsim_sparse::BlockMatrix;
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

const DELTA: f64 = 1e-5;
const DIFFERENCE: f64 = 1e-8;
/// Sums of some hundred terms of size one.
const ROUNDING: f64 = 1e-13;
/// A multiple of the damping \[1/s\].
const DAMPING: f64 = 30.0;

/// Checks that factors of the elements of `set` scale energy, forces and matrices.
pub(crate) fn check_factors(set: &dyn Elements, at: &Configuration<'_>) {
    // Powers of two scale without rounding.
    let factors: Vec<f64> = (0..set.count()).map(|e| [2.0, 0.5][e % 2]).collect();
    let (doubled, scaled) = (set.scaled(&vec![2.0; set.count()]), set.scaled(&factors));
    assert_eq!(doubled.energy(at), 2.0 * set.energy(at));
    let forces = |set: &dyn Elements, factor: f64| {
        let mut values = vec![Vector3::zeros(); at.positions.len()];
        let mut window = NodeWindow {
            first: 0,
            values: &mut values,
        };
        set.add_forces(0..set.count(), at, &mut window);
        values.iter_mut().for_each(|f| *f *= factor);
        values
    };
    assert_eq!(forces(&*doubled, 1.0), forces(set, 2.0));
    let (mut plain, mut other) = (ElementMatrix::new(), ElementMatrix::new());
    for (element, factor) in factors.iter().enumerate() {
        set.stiffness(element, at, Tangent::Exact, &mut plain);
        scaled.stiffness(element, at, Tangent::Exact, &mut other);
        assert_eq!(dense(&other), dense(&plain) * *factor);
        set.damping(element, at, &mut plain);
        scaled.damping(element, at, &mut other);
        assert_eq!(dense(&other), dense(&plain) * *factor);
    }
}

/// Checks that the matrix of all elements, with damping, is the sum of those of single ones, which may be formed in another manner.
pub(crate) fn check_assembly(set: &dyn Elements, at: &Configuration<'_>) {
    let nodes = at.positions.len();
    let (pattern, slots) = Slots::of_sets(nodes, [set]);
    for tangent in [Tangent::Exact, Tangent::Positive] {
        let [mut whole, mut sum] = [0; 2].map(|_| BlockMatrix::zeros(pattern.clone()));
        set.add_tangent(
            at,
            tangent,
            DAMPING,
            &mut MatrixWindow {
                slots: &slots[0],
                values: whole.values_mut(),
            },
        );
        let mut element = ElementMatrix::new();
        let mut window = MatrixWindow {
            slots: &slots[0],
            values: sum.values_mut(),
        };
        for index in 0..set.count() {
            set.stiffness(index, at, tangent, &mut element);
            window.add(index, &element, 1.0);
            set.damping(index, at, &mut element);
            window.add(index, &element, DAMPING);
        }
        let size = |values: &[Matrix3<f64>]| values.iter().map(Matrix3::amax).fold(0.0, f64::max);
        let difference: Vec<_> = whole
            .values()
            .iter()
            .zip(sum.values())
            .map(|(a, b)| a - b)
            .collect();
        let (difference, scale) = (size(&difference), size(sum.values()));
        assert!(
            scale > 0.0 && difference <= ROUNDING * scale,
            "{difference} of {scale}"
        );
    }
}

/// Checks `set` at these positions (a body of size one), velocities and internal variables: forces = −dE/dx, stiffness =
/// −dF/dx, the positive tangent without negative eigenvalue, damping = −dF/dv without negative power, momentum, rigid motion,
/// forces in parts, factors of elements.
pub(crate) fn check(
    set: &dyn Elements,
    positions: &[Vector3<f64>],
    velocities: &[Vector3<f64>],
    internal: &[f64],
) {
    let n = positions.len();
    let still = vec![Vector3::zeros(); n];
    let energy = |x: &[Vector3<f64>]| {
        set.energy(&Configuration {
            positions: x,
            velocities: &still,
            internal,
        })
    };
    let forces = |x: &[Vector3<f64>], v: &[Vector3<f64>]| {
        let at = Configuration {
            positions: x,
            velocities: v,
            internal,
        };
        let mut values = vec![Vector3::zeros(); n];
        let mut window = NodeWindow {
            first: 0,
            values: &mut values,
        };
        set.add_forces(0..set.count(), &at, &mut window);
        values
    };
    let flat = |f: &[Vector3<f64>]| {
        DVector::from_iterator(3 * n, f.iter().flat_map(|f| f.iter().copied()))
    };
    let moved = |x: &[Vector3<f64>], k: usize, by: f64| {
        let mut x = x.to_vec();
        x[k / 3][k % 3] += by;
        x
    };

    // Elastic forces.
    let elastic = flat(&forces(positions, &still));
    let stiffness = assembled(set, positions, internal, Some(Tangent::Exact));
    let force_scale = elastic.amax().max(energy(positions));
    let stiffness_scale = stiffness.amax();
    for k in 0..3 * n {
        let (low, high) = (moved(positions, k, -DELTA), moved(positions, k, DELTA));
        let slope = (energy(&low) - energy(&high)) / (2.0 * DELTA);
        assert!(
            (slope - elastic[k]).abs() <= DIFFERENCE * force_scale,
            "force {k}: {slope} {}",
            elastic[k]
        );
        let column = (flat(&forces(&low, &still)) - flat(&forces(&high, &still))) / (2.0 * DELTA);
        let error = (column - stiffness.column(k)).amax();
        assert!(
            error <= DIFFERENCE * (stiffness_scale + force_scale),
            "stiffness {k}: {error} of {stiffness_scale}"
        );
    }
    assert!((&stiffness - stiffness.transpose()).amax() <= ROUNDING * stiffness_scale);

    check_factors(
        set,
        &Configuration {
            positions,
            velocities,
            internal,
        },
    );

    check_assembly(
        set,
        &Configuration {
            positions,
            velocities: &still,
            internal,
        },
    );

    // Matrices of single elements.
    for element in 0..set.count() {
        let at = Configuration {
            positions,
            velocities: &still,
            internal,
        };
        let mut matrix = ElementMatrix::new();
        set.stiffness(element, &at, Tangent::Positive, &mut matrix);
        let eigenvalues = dense(&matrix).symmetric_eigenvalues();
        assert!(
            eigenvalues.min() >= -ROUNDING * eigenvalues.amax(),
            "element {element}: {eigenvalues}"
        );
        set.damping(element, &at, &mut matrix);
        let eigenvalues = dense(&matrix).symmetric_eigenvalues();
        assert!(
            eigenvalues.min() >= -ROUNDING * eigenvalues.amax(),
            "element {element}: {eigenvalues}"
        );
    }

    // Viscous forces are linear in the velocities and take power.
    let all = forces(positions, velocities);
    let viscous = flat(&all) - &elastic;
    let damping = assembled(set, positions, internal, None);
    let expected = -(&damping * flat(velocities));
    let scale = force_scale + expected.amax();
    assert!((&viscous - expected).amax() <= ROUNDING * scale);
    assert!(viscous.dot(&flat(velocities)) <= 0.0);
    assert_eq!(set.is_viscous(), damping.amax() > 0.0);

    // Momentum.
    let sum: Vector3<f64> = all.iter().sum();
    let moment: Vector3<f64> = positions.iter().zip(&all).map(|(x, f)| x.cross(f)).sum();
    assert!(
        sum.norm() <= ROUNDING * scale && moment.norm() <= ROUNDING * scale,
        "{sum} {moment}"
    );

    // A rigid motion changes no energy, turns the forces, and meets no resistance.
    let turn = Rotation3::from_euler_angles(0.4, -1.2, 2.2);
    let turned: Vec<_> = positions
        .iter()
        .map(|x| turn * x + Vector3::new(0.3, -0.2, 0.5))
        .collect();
    assert!((energy(&turned) - energy(positions)).abs() <= ROUNDING * scale);
    let spin = Vector3::new(0.7, 0.1, -0.4);
    let rigid: Vec<_> = positions
        .iter()
        .map(|x| spin.cross(x) + Vector3::new(1.0, 2.0, 3.0))
        .collect();
    let resisted = flat(&forces(positions, &rigid)) - &elastic;
    assert!(
        resisted.amax() <= 10.0 * ROUNDING * (force_scale + damping.amax()),
        "{}",
        resisted.amax()
    );
    let at_turned = forces(&turned, &still);
    for (a, b) in at_turned.iter().zip(forces(positions, &still)) {
        assert!((a - turn * b).norm() <= 10.0 * ROUNDING * (force_scale + stiffness_scale));
    }

    // In parts, into windows.
    let at = Configuration {
        positions,
        velocities,
        internal,
    };
    let mut values = vec![Vector3::zeros(); n];
    for element in 0..set.count() {
        let first = *set.nodes(element).iter().min().unwrap();
        let mut window = NodeWindow {
            first,
            values: &mut values[first as usize..],
        };
        set.add_forces(element..element + 1, &at, &mut window);
    }
    assert_eq!(values, all);
}

/// Stiffness, or damping for `None`, of all nodes.
fn assembled(
    set: &dyn Elements,
    positions: &[Vector3<f64>],
    internal: &[f64],
    tangent: Option<Tangent>,
) -> DMatrix<f64> {
    let still = vec![Vector3::zeros(); positions.len()];
    let at = Configuration {
        positions,
        velocities: &still,
        internal,
    };
    let mut all = DMatrix::zeros(3 * positions.len(), 3 * positions.len());
    let mut matrix = ElementMatrix::new();
    for element in 0..set.count() {
        match tangent {
            Some(tangent) => set.stiffness(element, &at, tangent, &mut matrix),
            None => set.damping(element, &at, &mut matrix),
        }
        let nodes = set.nodes(element);
        for (i, &row) in nodes.iter().enumerate() {
            for (j, &column) in nodes.iter().enumerate() {
                let mut view = all.fixed_view_mut::<3, 3>(3 * row as usize, 3 * column as usize);
                view += matrix.block(i, j);
            }
        }
    }
    all
}

fn dense(matrix: &ElementMatrix) -> DMatrix<f64> {
    let n = matrix.nodes();
    DMatrix::from_fn(3 * n, 3 * n, |r, c| {
        matrix.block(r / 3, c / 3)[(r % 3, c % 3)]
    })
}
