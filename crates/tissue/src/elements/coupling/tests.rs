//! The contract, breaking, pairing of two layers.

use super::*;
use crate::elements::contract;
use crate::testing::numbers;
use microsim_mesh::TetMesh;

const HOLDS: Bond = Bond::Elastic {
    break_distance: f64::INFINITY,
};
const BREAKS: Bond = Bond::Elastic {
    break_distance: 0.5,
};

fn tie(node: u32, support: Support) -> Tie {
    Tie {
        node,
        support,
        element: 7,
        stiffness: 3.0,
    }
}

/// A node at a triangle, one at a tetrahedron, one outside of it.
fn coupling() -> Coupling {
    let ties = [
        tie(0, Support::Triangle([1, 2, 3], [0.2, 0.5, 0.3])),
        tie(4, Support::Tet([0, 1, 2, 3], [0.25, 0.25, 0.4, 0.1])),
        Tie {
            element: 8,
            ..tie(5, Support::Tet([4, 2, 1, 0], [0.6, 0.7, -0.1, -0.2]))
        },
    ];
    Coupling::new(&ties, BREAKS)
}

#[test]
fn couplings_keep_the_contract_whole_and_broken() {
    let mut next = numbers();
    let mut cloud = || -> Vec<Vector3<f64>> {
        (0..6)
            .map(|_| Vector3::new(next(), next(), next()))
            .collect()
    };
    for internal in [[0.0; 3], [0.0, 1.0, 0.0]] {
        contract::check(&coupling(), &cloud(), &cloud(), &internal);
    }
}

/// Cohesive ties that are intact, soften, have been further apart than now, and are off: lengths of the cloud are about one.
#[test]
fn cohesive_couplings_keep_the_contract_in_every_state() {
    let mut next = numbers();
    let mut cloud = || -> Vec<Vector3<f64>> {
        (0..6)
            .map(|_| Vector3::new(next(), next(), next()))
            .collect()
    };
    let (x, v) = (cloud(), cloud());
    let distances: Vec<f64> = coupling()
        .stencils
        .iter()
        .map(|stencil| stencil.offset(&x).norm())
        .collect();
    let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
    let furthest = distances.iter().copied().fold(0.0, f64::max);
    let of = |onset: f64, end: f64| {
        // Of a stiffness per area of one the strength is the onset.
        let bond = Bond::Cohesive(Cohesion::new(1.0, onset, 0.5 * onset * end));
        Coupling { bond, ..coupling() }
    };
    let intact = of(1.5 * furthest, 3.0 * furthest);
    contract::check(&intact, &x, &v, &[0.0; 3]);
    let softening = of(0.5 * nearest, 2.0 * furthest);
    contract::check(&softening, &x, &v, &[0.0; 3]);
    let pasts = [1.2, 0.0, 2.1].map(|factor| factor * furthest);
    contract::check(&softening, &x, &v, &pasts);
}

#[test]
fn a_tie_at_its_point_is_at_rest_and_a_broken_one_exerts_no_force() {
    let coupling = coupling();
    let mut x: Vec<_> = (0..6)
        .map(|i| Vector3::new(i as f64, (i * i) as f64, 1.0))
        .collect();
    x[0] = x[1] * 0.2 + x[2] * 0.5 + x[3] * 0.3;
    let forces = |internal: &[f64]| {
        let at = Configuration {
            positions: &x,
            velocities: &x,
            internal,
        };
        let mut forces = vec![Vector3::zeros(); 6];
        coupling.add_forces(
            0..1,
            &at,
            &mut NodeWindow {
                first: 0,
                values: &mut forces,
            },
        );
        forces
    };
    assert!(forces(&[0.0; 3]).iter().all(|f| f.norm() < 1e-14));
    x[0].z += 2.0;
    let forces = |internal: &[f64]| {
        let at = Configuration {
            positions: &x,
            velocities: &x,
            internal,
        };
        let mut forces = vec![Vector3::zeros(); 6];
        coupling.add_forces(
            0..1,
            &at,
            &mut NodeWindow {
                first: 0,
                values: &mut forces,
            },
        );
        forces
    };
    assert!(
        (forces(&[0.0; 3])[0] + Vector3::z() * 6.0).norm() < 1e-14,
        "k d = 3 · 2"
    );
    assert!(
        forces(&[1.0, 0.0, 0.0])
            .iter()
            .all(|f| *f == Vector3::zeros())
    );
}

#[test]
fn ties_break_for_ever_at_their_distance() {
    let coupling = Coupling::new(&coupling_ties(), BREAKS);
    let mut x = vec![Vector3::zeros(); 6];
    let mut internal = coupling.initial_internal();
    x[0].x = 0.499;
    assert!(
        !coupling.flow(&x, &mut internal, 1e-3),
        "nothing is stiffer by it"
    );
    assert_eq!(internal, [0.0, 0.0]);
    x[0].x = 0.501;
    coupling.flow(&x, &mut internal, 1e-3);
    assert_eq!(
        (&internal[..], coupling.whole(&internal)),
        (&[0.501, 0.0][..], 1)
    );
    for back in [0.0, 0.8] {
        x[0].x = back;
        coupling.flow(&x, &mut internal, 1e-3);
        assert_eq!(internal, [0.501, 0.0]);
    }
}

/// A step that ends beyond the distance is elastic to its end: what a tie held there, k d²/2, is lost, and no more later.
#[test]
fn a_tie_that_breaks_has_lost_what_it_held() {
    let coupling = Coupling::new(&coupling_ties(), BREAKS);
    let mut x = vec![Vector3::zeros(); 6];
    let mut internal = coupling.initial_internal();
    for (along, lost) in [(0.4, 0.0), (0.6, 0.5 * 3.0 * 0.36), (0.9, 0.5 * 3.0 * 0.36)] {
        x[0].x = along;
        let energy = |internal: &[f64]| {
            coupling.energy(&Configuration {
                positions: &x,
                velocities: &x,
                internal,
            })
        };
        let before = energy(&internal) + coupling.dissipated(&internal);
        coupling.flow(&x, &mut internal, 1e-3);
        let after = energy(&internal) + coupling.dissipated(&internal);
        assert!((after - before).abs() < 1e-15, "{along}");
        let found = coupling.dissipated(&internal);
        assert!((found - lost).abs() < 1e-15, "{along} {found}");
    }
}

/// One backward Euler step of a node of mass m that would fly to y, tied to a fixed one: m/h² (x − y) + k t(x) = 0, which is linear on each of
/// the lines of the law.
#[test]
fn projections_of_a_cohesive_tie_find_the_point_on_its_law() {
    let (k, h, mass) = (3.0, 0.5, 2.0);
    let inertia = mass / (h * h);
    let (onset, end) = (0.1, 0.5);
    let bond = Bond::Cohesive(Cohesion::new(1.0, onset, 0.5 * onset * end));
    let coupling = Coupling::new(&coupling_ties()[..1], bond);
    let constraints = coupling.constraints().unwrap();
    let weights = [1.0 / mass, 0.0, 0.0, 0.0];
    let project = |y: f64, past: f64| {
        let mut x = vec![Vector3::zeros(); 4];
        x[0].x = y;
        let (start, mut multipliers) = (x.clone(), [0.0; 3]);
        for _ in 0..200 {
            constraints.project(0, &mut x, &start, &weights, &[past], &mut multipliers, h);
        }
        x[0].x
    };
    let softening = k * onset / (end - onset);
    // Secant at a largest separation of 0.3, where half of the strength is left: 0.05/0.3.
    let secant = k * 0.05 / 0.3;
    for (y, past, expected) in [
        (0.12, 0.0, inertia * 0.12 / (inertia + k)),
        (
            0.4,
            0.0,
            (inertia * 0.4 - softening * end) / (inertia - softening),
        ),
        (0.25, 0.3, inertia * 0.25 / (inertia + secant)),
        (0.9, 0.0, 0.9),
        (0.2, 0.6, 0.2),
    ] {
        let found = project(y, past);
        assert!((found - expected).abs() < 1e-12, "{y} {past}: {found}");
    }
}

fn coupling_ties() -> [Tie; 2] {
    let triangle = Support::Triangle([1, 2, 3], [0.2, 0.5, 0.3]);
    [
        tie(0, triangle),
        Tie {
            element: 8,
            ..tie(4, triangle)
        },
    ]
}

#[test]
fn a_projection_of_a_stiff_tie_closes_it_and_conserves_momentum() {
    let mut next = numbers();
    let ties = [Tie {
        stiffness: 1e30,
        ..coupling_ties()[0]
    }];
    let coupling = Coupling::new(&ties, HOLDS);
    let x: Vec<_> = (0..4)
        .map(|_| Vector3::new(next(), next(), next()))
        .collect();
    let w = [0.5, 2.0, 1.0, 4.0];
    let mut moved = x.clone();
    let constraints = coupling.constraints().unwrap();
    constraints.project(0, &mut moved, &x, &w, &[0.0], &mut [0.0; 3], 1e-2);
    assert!(coupling.stencils[0].offset(&moved).norm() < 1e-15);
    let change: Vector3<f64> = (0..4).map(|i| (moved[i] - x[i]) / w[i]).sum();
    assert!(change.norm() < 1e-15);
}

/// Two blocks, one on the other at z = 0, with their own nodes; the upper one with another division.
fn layers() -> TetMesh {
    let mut mesh = crate::testing::block_mesh([2.0, 1.0, 0.5], [4, 2, 1]);
    for p in &mut mesh.positions {
        p.z -= 0.25;
    }
    let mut upper = crate::testing::block_mesh([2.0, 1.0, 0.5], [3, 3, 1]);
    for p in &mut upper.positions {
        p.z += 0.25;
    }
    mesh.append(&upper, 1);
    mesh
}

#[test]
fn layers_are_coupled_over_their_interface_at_rest() {
    let mesh = layers();
    let constants = CouplingConstants {
        stiffness_per_area: 5.0,
        bond: HOLDS,
    };
    let coupling = couple(&mesh, 1, 0, &constants).unwrap();
    // Every node of the lower side of the upper layer, rim and corners included, and no other.
    let tied: Vec<u32> = coupling
        .stencils
        .iter()
        .map(|stencil| stencil.nodes[0])
        .collect();
    let at_zero: Vec<u32> = (0..mesh.positions.len() as u32)
        .filter(|&n| mesh.positions[n as usize].z == 0.0 && n >= 30)
        .collect();
    assert_eq!((tied, at_zero.len()), (at_zero, 16));
    for (stencil, element) in coupling.stencils.iter().zip(&coupling.elements) {
        assert_eq!(mesh.regions[*element as usize], 0);
        assert!(
            stencil.offset(&mesh.positions).norm() < 1e-15,
            "at rest in the rest shape"
        );
        assert!(
            stencil.weights[1..].iter().all(|b| *b < 1e-15),
            "a point of the element"
        );
    }
    let total: f64 = coupling.stiffness.iter().sum();
    assert!(
        (total - 5.0 * 2.0).abs() < 1e-13,
        "stiffness per area times the area"
    );

    assert_eq!(
        couple(&mesh, 0, 5, &constants).unwrap_err(),
        CoupleError::NoInterface { from: 0, to: 5 }
    );
    let wrong = CouplingConstants {
        stiffness_per_area: 0.0,
        ..constants
    };
    assert!(matches!(
        couple(&mesh, 1, 0, &wrong),
        Err(CoupleError::Constants(_))
    ));
}

#[test]
fn layers_with_a_small_gap_are_at_rest_too_and_shared_nodes_are_not_tied() {
    let mut mesh = layers();
    for p in &mut mesh.positions[30..] {
        p.z += 0.01;
    }
    let constants = CouplingConstants {
        stiffness_per_area: 5.0,
        bond: BREAKS,
    };
    let coupling = couple(&mesh, 1, 0, &constants).unwrap();
    assert_eq!(coupling.count(), 16);
    for stencil in &coupling.stencils {
        assert!(stencil.offset(&mesh.positions).norm() < 1e-15);
    }
    // One block of two regions: every node of the interface belongs to both.
    let mut block = crate::testing::block_mesh([1.0; 3], [2, 1, 1]);
    for element in 6..12 {
        block.regions[element] = 1;
    }
    assert!(couple(&block, 0, 1, &constants).is_err());
}
