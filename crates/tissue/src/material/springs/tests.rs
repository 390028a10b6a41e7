//! The forms against closed forms, the fit against its closed form and against a body that is pulled.

use super::*;
use crate::build::build_model;
use crate::elements::Configuration;
use crate::executor::Serial;
use crate::homogenise::homogenise;
use crate::law::LawName;
use crate::material::{Behaviour, ContinuumConstants, Material};
use crate::method::Method;
use crate::state::{Control, State};
use crate::testing::block_mesh;
use microsim_mesh::{Block, CellSplit};
use microsim_vocabulary::Discretisation;
use nalgebra::{Matrix3, Vector3};

fn block(size: f64, cells: usize, split: CellSplit) -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: [size; 3],
        cells: [cells; 3],
        split,
    };
    block.mesh().unwrap()
}

fn all(mesh: &TetMesh) -> Vec<u32> {
    (0..mesh.tets.len() as u32).collect()
}

fn form(form: SpringForm) -> SpringConstants {
    SpringConstants {
        form,
        plasticity: None,
    }
}

/// Energy of all elements when every node is at `stretch` times its rest position.
fn energy(mesh: &TetMesh, sets: &[Arc<dyn Elements>], stretch: f64) -> f64 {
    let positions: Vec<_> = mesh.positions.iter().map(|p| p * stretch).collect();
    let energies = sets.iter().map(|set| {
        let internal = set.initial_internal();
        set.energy(&Configuration {
            positions: &positions,
            velocities: &positions,
            internal: &internal,
        })
    });
    energies.sum()
}

const ONES: KindConstants = KindConstants {
    length: Coefficients {
        stiffness: 2.0,
        damping: 0.1,
    },
    area: Coefficients {
        stiffness: 3.0,
        damping: 0.2,
    },
    volume: Coefficients {
        stiffness: 5.0,
        damping: 0.3,
    },
};

#[test]
fn plain_and_normalised_energies_are_those_of_their_equations() {
    let mesh = block_mesh([2.0, 1.0, 3.0], [2, 1, 1]);
    let (edges, faces) = (mesh.edges(), 2 * 6 * 2 + 2 * (2 + 2 + 1));
    let sets = form(SpringForm::Normalised(ONES)).build(&mesh, &all(&mesh), 0.0);
    assert_eq!(
        sets.iter().map(|s| s.count()).collect::<Vec<_>>(),
        [edges.len(), faces, 12]
    );
    // (3.5)–(3.7) at twice the size: (q − q0)/q0 is 1, 3, 7 for every element.
    let expected = 0.5 * (2.0 * edges.len() as f64 + 3.0 * faces as f64 * 9.0 + 5.0 * 12.0 * 49.0);
    assert!((energy(&mesh, &sets, 2.0) / expected - 1.0).abs() < 1e-13);
    // (4.1), (4.2) at twice the size: q − q0 is L0, 3 A0, 7 V0.
    let sets = form(SpringForm::Plain(KindConstants {
        area: Coefficients::default(),
        ..ONES
    }))
    .build(&mesh, &all(&mesh), 0.0);
    assert_eq!(sets.len(), 2, "what resists nothing is not there");
    let lengths: f64 = edges
        .iter()
        .map(|[i, j]| (mesh.positions[*i as usize] - mesh.positions[*j as usize]).norm_squared())
        .sum();
    let expected = 0.5 * (2.0 * lengths + 5.0 * 12.0 * 49.0 * 0.5 * 0.5);
    assert!((energy(&mesh, &sets, 2.0) / expected - 1.0).abs() < 1e-13);
}

/// At the face between two cells; damping of (3.8) and the relaxation time add up.
#[test]
fn damping_is_the_own_one_and_that_of_the_relaxation_time() {
    let mesh = block_mesh([1.0; 3], [1, 1, 1]);
    for (constants, expected) in [
        // k_d + τ k with the edge (0, 1) of length 1.
        (SpringForm::Plain(ONES), 0.1 + 0.5 * 2.0),
        (SpringForm::Normalised(ONES), 0.1 + 0.5 * 2.0),
        (
            SpringForm::Scaled(SpringModuli {
                stretch: 10.0,
                ..SpringModuli::default()
            }),
            0.5 * 2.0 * 0.8 * f64::sqrt(2.0),
        ),
    ] {
        let sets = form(constants).build(&mesh, &all(&mesh), 0.5);
        assert_eq!(sets[0].nodes(0), [0, 1]);
        let at = Configuration {
            positions: &mesh.positions,
            velocities: &mesh.positions,
            internal: &[],
        };
        let mut matrix = crate::elements::ElementMatrix::new();
        sets[0].damping(0, &at, &mut matrix);
        // The edge is part of two of the six tetrahedra.
        let damping = matrix.block(0, 0)[(0, 0)];
        assert!(
            (damping / expected - 1.0).abs() < 1e-14,
            "{damping} {expected}"
        );
    }
}

#[test]
fn a_nearly_flat_tetrahedron_is_normalised_by_the_regular_one() {
    // Corners of a square of edge 1, the fourth lifted by 1e-6: V0 = 1e-6/6 far below 10⁻³ of the regular volume.
    let corners = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 1e-6],
    ];
    let mesh = TetMesh::new(
        corners.map(Vector3::from).to_vec(),
        vec![[0, 1, 2, 3]],
        vec![0],
    );
    let region = Region {
        mesh: &mesh,
        elements: &[0],
        form: &SpringForm::Normalised(ONES),
        relaxation_time: 0.0,
    };
    let mean = (4.0 + 2.0 * f64::sqrt(2.0)) / 6.0;
    let regular = f64::sqrt(2.0) / 12.0 * mean * mean * mean;
    let volume = region.volumes()[0];
    assert!((volume.stiffness * regular * regular / 5.0 - 1.0).abs() < 1e-10);
    assert!(
        (volume.rest - 1e-6 / 6.0).abs() < 1e-20,
        "the rest value is the true one"
    );
    // Three nodes in line are a flat triangle; lifted as little.
    let corners = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [2.0, 1e-6, 0.0],
        [1.0, 1.0, 1.0],
    ];
    let mesh = TetMesh::new(
        corners.map(Vector3::from).to_vec(),
        vec![[0, 1, 2, 3]],
        vec![0],
    );
    let region = Region {
        mesh: &mesh,
        ..region
    };
    let (mean, area) = (4.0 / 3.0, region.areas()[0]);
    let regular = f64::sqrt(3.0) / 4.0 * mean * mean;
    assert!((area.stiffness * regular * regular / 3.0 - 1.0).abs() < 1e-10);
}

/// Scaled constants: ½ α V (s² − 1)², ½ κ V (s³ − 1)² for a body at s times its size, and springs alike on all meshes of one
/// kind.
#[test]
fn scaled_energies_do_not_depend_on_the_mesh() {
    let s = 1.1f64;
    let springs = |mesh: &TetMesh| {
        let sets = SpringConstants::scaled(7.0, 0.0).build(mesh, &all(mesh), 0.0);
        energy(mesh, &sets, s)
    };
    let reference = springs(&block(2.0, 1, CellSplit::Kuhn));
    for cells in [2, 5] {
        let mesh = block(2.0, cells, CellSplit::Kuhn);
        assert!((springs(&mesh) / reference - 1.0).abs() < 1e-12);
        let moduli = SpringModuli {
            stretch: 0.0,
            area: 3.0,
            volume: 5.0,
        };
        let sets = form(SpringForm::Scaled(moduli)).build(&mesh, &all(&mesh), 0.0);
        let (a, v) = (s * s - 1.0, s * s * s - 1.0);
        let expected = 0.5 * 8.0 * (3.0 * a * a + 5.0 * v * v);
        assert!((energy(&mesh, &sets, s) / expected - 1.0).abs() < 1e-12);
    }
}

#[test]
fn regions_bring_their_parts_and_plasticity_flows_lengths_and_volumes() {
    let mesh = block_mesh([1.0; 3], [1, 1, 1]);
    let plasticity = Plasticity {
        yield_strain: 0.0,
        creep_rate: 1.0,
        max_strain: 9.0,
        hardening: 0.0,
        max_stiffening: 1.0,
    };
    let constants = SpringConstants {
        plasticity: Some(plasticity),
        ..SpringConstants::fitted(1.0, 0.4)
    };
    // Two halves of the cell have the six tetrahedra together; inner edges once for each.
    let halves = [[0u32, 1, 2], [3, 4, 5]].map(|half| constants.build(&mesh, &half, 0.0));
    assert_eq!(halves.iter().map(|sets| sets[1].count()).sum::<usize>(), 6);
    assert!(halves.iter().map(|sets| sets[0].count()).sum::<usize>() > mesh.edges().len());
    let stretched: Vec<_> = mesh.positions.iter().map(|p| p * 1.2).collect();
    for set in constants.build(&mesh, &all(&mesh), 0.0) {
        let start = set.initial_internal();
        let mut internal = start.clone();
        set.flow(&stretched, &mut internal, 1e9);
        // Held for ever without a yield strain, the stretched size is the new rest size.
        let at = Configuration {
            positions: &stretched,
            velocities: &stretched,
            internal: &internal,
        };
        assert!(set.energy(&at) < 1e-25);
    }
}

#[test]
fn values_out_of_range_are_refused_by_name() {
    let name = |constants: SpringConstants| constants.check().unwrap_err().value_name;
    assert_eq!(SpringConstants::scaled(1.0, 0.0).check(), Ok(()));
    assert_eq!(name(SpringConstants::scaled(-1.0, 2.0)), "stretch modulus");
    assert_eq!(
        name(SpringConstants::scaled(0.0, 0.0)),
        "the sum of all moduli"
    );
    assert_eq!(name(SpringConstants::fitted(0.0, 0.3)), "young");
    assert_eq!(name(SpringConstants::fitted(1.0, 0.5)), "poisson");
    assert_eq!(name(SpringConstants::fitted(1.0, f64::NAN)), "poisson");
    assert_eq!(
        name(form(SpringForm::Plain(KindConstants::default()))),
        "the sum of all stiffnesses"
    );
    let area = Coefficients {
        stiffness: 1.0,
        damping: -0.1,
    };
    assert_eq!(
        name(form(SpringForm::Normalised(KindConstants { area, ..ONES }))),
        "area damping"
    );
}

/// Any spring network, averaged over all directions, has Poisson's ratio ¼ (Cauchy): any mesh, any form.
#[test]
fn springs_alone_have_a_poissons_ratio_of_one_quarter() {
    let mut mesh = block(2.0, 3, CellSplit::Kuhn);
    let mut next = crate::testing::numbers();
    for p in &mut mesh.positions {
        *p += Vector3::new(next(), next(), next()) * 0.1;
    }
    let length = KindConstants {
        length: ONES.length,
        ..KindConstants::default()
    };
    for constants in [
        form(SpringForm::Plain(length)),
        form(SpringForm::Normalised(length)),
        SpringConstants::scaled(1.0, 0.0),
        SpringConstants::fitted(1.0, 0.1),
    ] {
        let sets = constants.build(&mesh, &all(&mesh), 0.0);
        let (_, poisson) = homogenise(&mesh.positions, &sets, 8.0).isotropic();
        assert!((poisson - 0.25).abs() < 1e-12, "{constants:?}: {poisson}");
    }
}

#[test]
fn a_fit_has_the_mean_it_wants_on_any_mesh_and_is_exact_on_mirrored_cells() {
    for split in [CellSplit::Kuhn, CellSplit::Mirrored] {
        let mesh = block(2.0, 2, split);
        for poisson in [0.25, 0.3, 0.45, 0.49] {
            let fit = fit(&mesh, &all(&mesh), 2e4, poisson);
            assert!((fit.achieved_young / 2e4 - 1.0).abs() < 1e-10);
            assert!((fit.achieved_poisson - poisson).abs() < 1e-11);
            if split == CellSplit::Mirrored {
                assert!(fit.error < 1e-10 && fit.anisotropy < 1e-11, "{fit:?}");
            } else {
                // All space diagonals along (1, 1, 1): more than twice as stiff that way, a third across.
                assert!(fit.error > 1.0 && fit.error < 1.3, "{fit:?}");
            }
        }
        // Below a quarter Young's modulus is kept, and Poisson's ratio is that of springs.
        let fit = fit(&mesh, &all(&mesh), 2e4, 0.1);
        assert!((fit.achieved_young / 2e4 - 1.0).abs() < 1e-10);
        assert!((fit.achieved_poisson - 0.25).abs() < 1e-11);
        assert_eq!(fit.volume_modulus, 0.0);
    }
}

#[test]
fn a_continuum_homogenises_to_its_own_constants() {
    let mesh = block(2.0, 2, CellSplit::Kuhn);
    let constants = ContinuumConstants {
        law: LawName::StableNeoHookean.into(),
        young: 3e4,
        poisson: 0.4,
        discretisation: Discretisation::Tetrahedra,
        plasticity: None,
    };
    let material = Material {
        density: 1e3,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(constants),
    };
    let clamped = vec![false; mesh.positions.len()];
    let model = build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new()).unwrap();
    let effective = homogenise(&mesh.positions, model.sets(), 8.0);
    let (young, poisson) = effective.isotropic();
    assert!((young / 3e4 - 1.0).abs() < 1e-12 && (poisson - 0.4).abs() < 1e-12);
    assert!(effective.anisotropy() < 1e-12 && effective.error(3e4) < 1e-11);
}

/// Pulls a free block along x by a small traction until it rests; Young's modulus and Poisson's ratio (mean of the two) of what
/// its inner nodes do.
fn pulled(mesh: &TetMesh, constants: SpringConstants, young: f64) -> (f64, f64) {
    let material = Material {
        density: 1e3,
        relaxation_time: 0.0,
        behaviour: Behaviour::Springs(constants),
    };
    let length = 2.0 * mesh.positions[0].x.abs();
    // Critical damping of the slowest mode of a free bar, ω = (π/L)√(E/ρ).
    let slowest = std::f64::consts::PI / length * (young / 1e3).sqrt();
    let clamped = vec![false; mesh.positions.len()];
    let model = build_model(mesh, &[(0, material)], &clamped, 2.0 * slowest, Vec::new()).unwrap();
    let stress = 1e-4 * young;
    let mut control = Control::default();
    for side in [-1.0, 1.0] {
        let end = mesh
            .surface()
            .select(&mesh.positions, |_, normal| normal.x * side > 0.5);
        let areas = end.node_areas(&mesh.positions);
        let loads = end.nodes.iter().zip(areas);
        control
            .forces
            .extend(loads.map(|(&node, area)| (node, Vector3::x() * (side * stress * area))));
    }
    let mut state = State::at_rest(&model);
    let h = crate::stability::stable_step(&model, 0.9);
    let mut solver = Method::VelocityVerlet.solver(&model).unwrap();
    // e^(−ωt) of the slowest: to 1e-6.
    for _ in 0..(56.0 / (slowest * h)) as usize {
        solver
            .step(&model, &mut state, &control, &[], h, &Serial)
            .unwrap();
    }
    // The gradient of the displacements of the inner nodes, by least squares.
    let edge = 0.5 * length * (1.0 - 1e-9);
    let (mut xx, mut ux) = (Matrix3::zeros(), Matrix3::zeros());
    for (rest, now) in mesh.positions.iter().zip(&state.positions) {
        if rest.amax() < edge {
            xx += rest * rest.transpose();
            ux += (now - rest) * rest.transpose();
        }
    }
    let strain = ux * xx.try_inverse().unwrap();
    (
        stress / strain[(0, 0)],
        -0.5 * (strain[(1, 1)] + strain[(2, 2)]) / strain[(0, 0)],
    )
}

/// What the homogenised tensor predicts of a stretch along x is what a body does. Plain Kuhn cells are all alike, so one strain of
/// all nodes is in balance up to the surface: exact, but for strains of 1e-4 and what the slow shear modes have left to
/// go. Mirrored cells are softer by a part of a layer at the surface: a fraction O(1/cells) that halves with twice the cells.
#[test]
fn a_block_that_is_pulled_shows_the_homogenised_constants() {
    let errors = |split: CellSplit, cells: usize, poisson: f64| {
        let mesh = block(cells as f64 * 1e-3, cells, split);
        let fit = fit(&mesh, &all(&mesh), 2e4, poisson);
        let (young, ratio) = fit.effective.along(&Vector3::x(), &Vector3::y());
        let (measured, contraction) = pulled(&mesh, SpringConstants::fitted(2e4, poisson), 2e4);
        [1.0 - measured / young, ratio - contraction]
    };
    for poisson in [0.1, 0.3, 0.45] {
        for error in errors(CellSplit::Kuhn, 4, poisson) {
            assert!(error.abs() < 1e-3, "ν = {poisson}: {error}");
        }
        let [coarse, fine] = [4, 8].map(|cells| errors(CellSplit::Mirrored, cells, poisson));
        assert!(
            coarse[0] < 0.05 && fine[0] < 0.6 * coarse[0],
            "ν = {poisson}: {coarse:?} {fine:?}"
        );
        assert!(
            coarse[1] < 0.02 && fine[1] < 0.6 * coarse[1],
            "ν = {poisson}: {coarse:?} {fine:?}"
        );
        assert!(
            fine.iter().all(|error| *error > 0.0),
            "softer at the surface"
        );
    }
}
