//! The contract, sticking and sliding in closed form, conservation, edits.

use super::*;
use crate::elements::{SlidingConstants, contract, couple_sliding};
use crate::testing::{block_mesh, numbers};
use microsim_mesh::TetMesh;

const FRICTION: f64 = 0.3;
const PRESSED: f64 = 0.02;

/// A plate of two regions: on a lower one, of 4 × 2 and z = 0 on top, an upper one of 1 × 1 in other cells.
fn layers() -> TetMesh {
    let mut mesh = block_mesh([4.0, 2.0, 0.5], [6, 3, 1]);
    mesh.positions.iter_mut().for_each(|p| p.z -= 0.25);
    let mut upper = block_mesh([1.0, 1.0, 0.5], [2, 2, 1]);
    upper.positions.iter_mut().for_each(|p| p.z += 0.25);
    mesh.append(&upper, 1);
    mesh
}

/// The first node of the upper block.
const UPPER: usize = 7 * 4 * 2;

fn sliding(mesh: &TetMesh) -> Sliding {
    joined(mesh, 0.0)
}

/// As [`sliding`], with a shear strength.
fn joined(mesh: &TetMesh, shear_strength: f64) -> Sliding {
    let constants = SlidingConstants {
        stiffness_per_area: 5.0,
        friction: FRICTION,
        shear_strength,
    };
    couple_sliding(mesh, 1, 0, &constants).unwrap()
}

/// The upper block moved.
fn moved(mesh: &TetMesh, by: [f64; 3]) -> Vec<Vector3<f64>> {
    let mut x = mesh.positions.clone();
    x[UPPER..].iter_mut().for_each(|p| *p += Vector3::from(by));
    x
}

/// The force on the upper block, and all of them.
fn forces(set: &Sliding, x: &[Vector3<f64>], internal: &[f64]) -> [Vector3<f64>; 2] {
    let at = Configuration {
        positions: x,
        velocities: x,
        internal,
    };
    let mut values = vec![Vector3::zeros(); x.len()];
    let mut window = NodeWindow {
        first: 0,
        values: &mut values,
    };
    set.add_forces(0..set.count(), &at, &mut window);
    [values[UPPER..].iter().sum(), values.iter().sum()]
}

/// Follows a step that ends at `x`.
fn step(set: &mut Sliding, x: &[Vector3<f64>], internal: &mut [f64]) {
    set.flow(x, internal, 1.0);
    set.relocate(internal);
    assert!(set.is_in_place(internal));
}

/// A bound is a force and a loss a work of friction: neither is negative, and all is finite.
#[test]
fn places_that_no_slide_reaches_are_refused() {
    let mesh = layers();
    let mut set = sliding(&mesh);
    let mut internal = set.initial_internal();
    for x in [0.1, 0.4] {
        step(&mut set, &moved(&mesh, [x, 0.0, -PRESSED]), &mut internal);
    }
    assert!(set.admits(&internal));
    assert!(set.dissipated(&internal) > 0.0);
    let with = |block: usize, value: f64| {
        let mut internal = internal.clone();
        internal[block * set.count() + 1] = value;
        set.admits(&internal)
    };
    for block in 0..BLOCKS {
        assert!(!with(block, f64::NAN) && !with(block, f64::INFINITY));
    }
    assert!(!with(8, -1e-9) && !with(9, -1e-9));
    assert!(with(8, 0.0) && with(9, 0.0));
}

#[test]
fn sliding_ties_keep_the_contract_while_they_stick() {
    let mesh = layers();
    let set = sliding(&mesh);
    let mut next = numbers();
    let mut cloud = || -> Vec<Vector3<f64>> {
        let random = mesh.positions.iter();
        random
            .map(|p| p + Vector3::new(next(), next(), next()) * 0.1)
            .collect()
    };
    let (x, v) = (cloud(), cloud());
    let mut internal = set.initial_internal();
    // Bounds beyond every distance.
    internal[8 * set.count()..9 * set.count()].fill(10.0);
    contract::check(&set, &x, &v, &internal);
    contract::check(&set, &x, &v, &[]);
}

#[test]
fn forces_and_tangents_of_ties_that_slide_are_derivatives() {
    let mesh = layers();
    let set = sliding(&mesh);
    let mut next = numbers();
    let x: Vec<_> = mesh
        .positions
        .iter()
        .map(|p| p + Vector3::new(next(), next(), next()) * 0.1)
        .collect();
    let mut internal = set.initial_internal();
    internal[8 * set.count()..9 * set.count()].fill(1e-3);
    let at = |x: &[Vector3<f64>]| {
        let at = Configuration {
            positions: x,
            velocities: x,
            internal: &internal,
        };
        let mut values = vec![Vector3::zeros(); x.len()];
        let mut window = NodeWindow {
            first: 0,
            values: &mut values,
        };
        set.add_forces(0..set.count(), &at, &mut window);
        let mut matrix = ElementMatrix::new();
        set.stiffness(0, &at, Tangent::Exact, &mut matrix);
        (set.energy(&at), values, *matrix.block(0, 0))
    };
    let node = set.nodes(0)[0] as usize;
    let (_, force, block) = at(&x);
    // Central differences: δ² of the third derivative, 1/(0.1)², and rounding of an energy of 0.1 over δ: 1e-8 each.
    const DELTA: f64 = 1e-5;
    for axis in 0..3 {
        let by = |step: f64| {
            let mut x = x.clone();
            x[node][axis] += step;
            at(&x)
        };
        let (low, high) = (by(-DELTA), by(DELTA));
        let slope = (low.0 - high.0) / (2.0 * DELTA);
        assert!((slope - force[node][axis]).abs() < 1e-8);
        let column = (low.1[node] - high.1[node]) / (2.0 * DELTA);
        assert!((column - block.column(axis)).norm() < 1e-7, "{column}");
    }
    // No direction has a negative stiffness.
    assert!(block.symmetric_eigenvalues().min() >= -1e-15);
    // Opposite forces; the moment is what the module states: normal force times slip of each tie.
    let sum: Vector3<f64> = force.iter().sum();
    assert!(sum.norm() < 1e-14);
    let moment: Vector3<f64> = x.iter().zip(&force).map(|(x, f)| x.cross(f)).sum();
    let stated: f64 = (0..set.count())
        .filter_map(|e| set.offset(e, &x, &internal))
        .map(|(of, k)| k * of.along.abs() * (of.distance - of.bound))
        .sum();
    assert!(moment.norm() > 0.0 && moment.norm() <= stated, "{moment}");
}

#[test]
fn a_pressed_layer_sticks_below_the_bound_and_slides_at_it() {
    let mesh = layers();
    let mut set = sliding(&mesh);
    let mut internal = set.initial_internal();
    step(&mut set, &moved(&mesh, [0.0, 0.0, -PRESSED]), &mut internal);
    // The interface is 1 × 1 and 5 per area: N = 0.1.
    let normal_force = 5.0 * PRESSED;
    let bound = FRICTION * PRESSED;
    let stick = moved(&mesh, [0.9 * bound, 0.0, -PRESSED]);
    let [force, sum] = forces(&set, &stick, &internal);
    let expected = Vector3::new(-0.9 * FRICTION * normal_force, 0.0, normal_force);
    assert!((force - expected).norm() < 1e-14, "{force}");
    assert!(sum.norm() < 1e-15);
    step(&mut set, &stick, &mut internal);
    assert_eq!(set.dissipated(&internal), 0.0);
    assert!((forces(&set, &stick, &internal)[0] - expected).norm() < 1e-14);

    // Over two cells in steps of any size, obliquely; the points come along.
    let expected = Vector3::new(-0.8, -0.6, 0.0) * (FRICTION * normal_force);
    let mut path = 0.0;
    for to in [0.05, 0.4, 0.45, 0.7] {
        let x = moved(&mesh, [0.8 * to, 0.6 * to, -PRESSED]);
        let [force, sum] = forces(&set, &x, &internal);
        let across = Vector3::new(force.x, force.y, 0.0);
        assert!(
            (across.norm() - FRICTION * normal_force).abs() < 1e-14,
            "{force}"
        );
        assert!((force.z - normal_force).abs() < 1e-14 && sum.norm() < 1e-14);
        step(&mut set, &x, &mut internal);
        path = to;
    }
    // The first step began at 0.9 b along x: after the others that is forgotten.
    let x = moved(&mesh, [0.8 * path, 0.6 * path, -PRESSED]);
    let [force, _] = forces(&set, &x, &internal);
    assert!((force - expected - Vector3::z() * normal_force).norm() < 1e-4 * normal_force);
    assert_eq!(Sliding::held(&internal), 9);

    // Backwards it sticks first.
    let back = moved(
        &mesh,
        [0.8 * (path - bound), 0.6 * (path - bound), -PRESSED],
    );
    let [force, _] = forces(&set, &back, &internal);
    assert!(force.x.hypot(force.y) < 1e-4 * normal_force);
}

#[test]
fn the_work_of_a_slide_is_friction_times_path() {
    let mesh = layers();
    let mut set = sliding(&mesh);
    let mut internal = set.initial_internal();
    step(&mut set, &moved(&mesh, [0.0, 0.0, -PRESSED]), &mut internal);
    for i in 1..=10 {
        let by = 0.06 * f64::from(i);
        step(&mut set, &moved(&mesh, [by, 0.0, -PRESSED]), &mut internal);
    }
    // What is stored at the bound, μ²N d/2, has not slid.
    let normal_force = 5.0 * PRESSED;
    let path = 0.6 - FRICTION * PRESSED;
    let expected = FRICTION * normal_force * path;
    assert!((set.dissipated(&internal) / expected - 1.0).abs() < 1e-12);
}

/// The interface is 1 × 1: a shear strength of 0.2 bears a force of 0.2 and that of the pressure besides, sticks over 0.2/5, and takes 0.2 per length.
#[test]
fn a_layer_that_is_joined_slides_at_its_shear_strength_and_friction() {
    let (mesh, strength) = (layers(), 0.2);
    let reach = strength / 5.0;
    for (lifted, friction) in [
        (PRESSED, 0.0),
        (0.0, 0.0),
        (-PRESSED, FRICTION * PRESSED * 5.0),
    ] {
        let mut set = joined(&mesh, strength);
        let mut internal = set.initial_internal();
        step(&mut set, &moved(&mesh, [0.0, 0.0, lifted]), &mut internal);
        let [force, _] = forces(&set, &moved(&mesh, [0.9 * reach, 0.0, lifted]), &internal);
        assert!((force.x + 0.9 * strength).abs() < 1e-14, "{force}");
        for by in [0.1, 0.3, 0.6] {
            let x = moved(&mesh, [by, 0.0, lifted]);
            let [force, sum] = forces(&set, &x, &internal);
            assert!((force.x + strength + friction).abs() < 1e-14, "{force}");
            assert!(sum.norm() < 1e-14);
            step(&mut set, &x, &mut internal);
        }
        // What is stored where it sticks has not slid.
        let path = 0.6 - reach - friction / 5.0;
        let expected = (strength + friction) * path;
        assert!((set.dissipated(&internal) / expected - 1.0).abs() < 1e-12);
    }
}

#[test]
fn layers_that_are_pulled_apart_stay_together_and_slide_freely() {
    let mesh = layers();
    let mut set = sliding(&mesh);
    let mut internal = set.initial_internal();
    step(&mut set, &moved(&mesh, [0.0, 0.0, PRESSED]), &mut internal);
    let [force, _] = forces(&set, &moved(&mesh, [0.5, 0.2, PRESSED]), &internal);
    assert!((force + Vector3::z() * (5.0 * PRESSED)).norm() < 1e-14);
}

#[test]
fn a_node_that_leaves_the_layer_is_free_for_ever() {
    let mesh = layers();
    let mut set = sliding(&mesh);
    let mut internal = set.initial_internal();
    // From −0.5..0.5 to 1.2..2.2: three of nine nodes are 0.2 beyond the rim at 2, where a quarter of an edge is about 0.18.
    for i in 1..=17 {
        step(
            &mut set,
            &moved(&mesh, [0.1 * f64::from(i), 0.0, 0.0]),
            &mut internal,
        );
    }
    assert_eq!(Sliding::held(&internal), 6);
    for i in 1..=17 {
        let by = 1.7 - 0.1 * f64::from(i);
        step(&mut set, &moved(&mesh, [by, 0.0, 0.0]), &mut internal);
    }
    assert_eq!(Sliding::held(&internal), 6);
    let [force, _] = forces(&set, &moved(&mesh, [0.0, 0.0, 0.1]), &internal);
    // Three ties of a quarter, an eighth and an eighth of an edge's half are gone: a quarter of the area.
    assert!((force.z / (-0.1 * 5.0) - 0.75).abs() < 0.1, "{force}");
}

#[test]
fn another_numbering_of_nodes_slides_the_same() {
    let mesh = layers();
    let set = sliding(&mesh);
    let mut internal = set.initial_internal();
    let x = moved(&mesh, [0.6, 0.3, -PRESSED]);
    let shifted = set.shifted(5);
    let mut later = vec![Vector3::zeros(); 5];
    later.extend(&x);
    let mut same = internal.clone();
    shifted.flow(&later, &mut same, 1.0);
    set.flow(&x, &mut internal, 1.0);
    assert_eq!(same, internal);
    assert_eq!(shifted.moved(&same), set.moved(&internal));
}
