//! The contract at any state of flow; bars that are stretched and released; energy; what can flow and what treats it.

use super::*;
use crate::build::{BuildError, build_model};
use crate::elements::contract;
use crate::executor::Serial;
use crate::flow::flow;
use crate::law::LawName;
use crate::material::{Behaviour, ContinuumConstants, Material};
use crate::method::Method;
use crate::model::TissueModel;
use crate::stability::{SAFETY, stable_step, stable_step_at};
use crate::state::{Control, State};
use crate::testing::{block_mesh, fibres, numbers};
use microsim_mesh::TetMesh;
use microsim_vocabulary::Discretisation;

const WALL: ContinuumPlasticity = ContinuumPlasticity {
    yield_strain: 0.05,
    yield_growth: 0.0,
    creep_rate: None,
    max_strain: 2.0,
    hardening: 0.0,
    max_stiffening: 1.0,
};

/// A block of 1 m of a modulus of 1 Pa, that flows.
fn block(
    law: LawName,
    discretisation: Discretisation,
    plasticity: ContinuumPlasticity,
    relaxation_time: f64,
) -> Result<TissueModel, BuildError> {
    block_of(law, discretisation, plasticity, relaxation_time, 0.4)
}

/// With this Poisson's ratio.
fn block_of(
    law: LawName,
    discretisation: Discretisation,
    plasticity: ContinuumPlasticity,
    relaxation_time: f64,
    poisson: f64,
) -> Result<TissueModel, BuildError> {
    let mut mesh = block_mesh([1.0; 3], [1, 1, 1]);
    if discretisation.is_quadratic() {
        mesh = mesh.refined().mesh;
    }
    build(
        mesh,
        law,
        discretisation,
        plasticity,
        relaxation_time,
        poisson,
    )
}

fn build(
    mut mesh: TetMesh,
    law: LawName,
    discretisation: Discretisation,
    plasticity: ContinuumPlasticity,
    relaxation_time: f64,
    poisson: f64,
) -> Result<TissueModel, BuildError> {
    fibres(&mut mesh);
    let material = Material {
        density: 1.0,
        relaxation_time,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: law.into(),
            young: 1.0,
            poisson,
            discretisation,
            plasticity: Some(plasticity),
        }),
    };
    let clamped = vec![false; mesh.positions.len()];
    build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new())
}

/// Every element has flowed by its own amount, up to a strain of 0.3, and is stiffer.
fn flowed(model: &TissueModel, next: &mut impl FnMut() -> f64) -> Vec<f64> {
    let mut internal = State::at_rest(model).internal;
    for (index, set) in model.sets().iter().enumerate() {
        let internal = &mut internal[model.internal_range(index)];
        if internal.is_empty() {
            continue;
        }
        for element in 0..set.count() {
            let half = Matrix3::from_fn(|_, _| next()) * 0.15;
            let mut state = PlasticState {
                inverse: Matrix3::identity() + half + half.transpose(),
                stiffening: 1.5 + 0.5 * next(),
                ..PlasticState::START
            };
            state.inverse /= libm::cbrt(state.inverse.determinant());
            state.write(internal, set.count(), element);
        }
    }
    internal
}

#[test]
fn the_contract_holds_at_any_state_of_flow() {
    let mut next = numbers();
    for law in [
        LawName::StableNeoHookean,
        LawName::MooneyRivlin,
        LawName::TransverselyIsotropic,
    ] {
        for discretisation in Discretisation::ALL {
            // Ten nodes each and four points: quadratic ones once.
            if discretisation.is_quadratic() && law != LawName::StableNeoHookean {
                continue;
            }
            for relaxation_time in [0.0, 0.1] {
                let model = block(law, discretisation, WALL, relaxation_time).unwrap();
                let internal = flowed(&model, &mut next);
                let noise = |_: &Vector3<f64>| Vector3::from_fn(|_, _| next()) * 0.04;
                let noise: Vec<_> = model.rest_positions().iter().map(noise).collect();
                let map = Matrix3::new(1.1, 0.2, -0.1, -0.2, 0.9, 0.1, 0.1, 0.1, 1.05);
                let rest = model.rest_positions().iter().zip(&noise);
                let positions: Vec<_> = rest.map(|(x, noise)| map * x + noise).collect();
                let set = &model.sets()[0];
                let internal = &internal[model.internal_range(0)];
                assert_eq!(internal.len(), BLOCKS * set.count());
                contract::check(&**set, &positions, &noise, internal);
            }
        }
    }
}

/// Without flow it is the elastic set, to rounding: products with 1.
#[test]
fn before_any_flow_it_is_the_elastic_set() {
    for discretisation in Discretisation::ALL {
        let model = block(LawName::NeoHookean, discretisation, WALL, 0.1).unwrap();
        let set = &model.sets()[0];
        let (state, mut next) = (State::at_rest(&model), numbers());
        let mut cloud = |size: f64| -> Vec<Vector3<f64>> {
            let rest = model.rest_positions().iter();
            rest.map(|x| x + Vector3::from_fn(|_, _| next()) * size)
                .collect()
        };
        let (positions, velocities) = (cloud(0.1), cloud(0.3));
        let energy_and_forces = |set: &dyn Elements, internal| {
            let at = Configuration {
                positions: &positions,
                velocities: &velocities,
                internal,
            };
            let mut values = vec![Vector3::zeros(); positions.len()];
            let mut window = NodeWindow {
                first: 0,
                values: &mut values,
            };
            set.add_forces(0..set.count(), &at, &mut window);
            (set.energy(&at), values)
        };
        let internal = &state.internal[model.internal_range(0)];
        let now = energy_and_forces(&**set, internal);
        assert_eq!(now, energy_and_forces(&**set, &[]));
        let elastic = (&**set as &dyn Any)
            .downcast_ref::<PlasticSet<crate::law::NeoHookean, crate::elements::Tetrahedra>>();
        if let Some(plastic) = elastic {
            let (energy, forces) = energy_and_forces(&plastic.elastic, &[]);
            assert!((energy - now.0).abs() < 1e-14);
            let same = forces.iter().zip(&now.1);
            same.for_each(|(a, b)| assert!((a - b).norm() < 1e-14, "{a} {b}"));
        }
    }
}

/// Positions at the logarithmic strain `strain` along x at constant volume.
fn stretched(model: &TissueModel, strain: f64) -> Vec<Vector3<f64>> {
    let across = libm::exp(-0.5 * strain);
    let stretches = Vector3::new(libm::exp(strain), across, across);
    let rest = model.rest_positions().iter();
    rest.map(|x| x.component_mul(&stretches)).collect()
}

/// Takes a body to a strain in so many equal steps, with flow after each.
fn pull(model: &TissueModel, strain: f64, steps: usize) -> State {
    let mut state = State::at_rest(model);
    for step in 1..=steps {
        state.positions = stretched(model, strain * step as f64 / steps as f64);
        flow(model, &mut state, 1.0);
    }
    state
}

fn forces(model: &TissueModel, state: &State) -> Vec<Vector3<f64>> {
    let mut values = vec![Vector3::zeros(); model.node_count()];
    for (index, set) in model.sets().iter().enumerate() {
        let mut window = NodeWindow {
            first: 0,
            values: &mut values,
        };
        set.add_forces(
            0..set.count(),
            &state.configuration(model, index),
            &mut window,
        );
    }
    values
}

/// A bar stretched to the logarithmic strain ε at constant volume and released retains the strain (ε − e_y)/(1 + K): at this length, and no
/// other, it bears no force. For each discretisation and in any number of steps, one too.
#[test]
fn a_bar_that_is_released_retains_its_plastic_strain() {
    for discretisation in Discretisation::ALL {
        for (growth, steps) in [(0.0, 1), (0.0, 40), (0.6, 1), (0.6, 40)] {
            let plasticity = ContinuumPlasticity {
                yield_growth: growth,
                ..WALL
            };
            let model = block(LawName::NeoHookean, discretisation, plasticity, 0.0).unwrap();
            let mut state = pull(&model, 0.45, steps);
            let retained = 0.4 / (1.0 + growth);
            state.positions = stretched(&model, retained);
            let largest = forces(&model, &state)
                .iter()
                .map(Vector3::norm)
                .fold(0.0, f64::max);
            // Rounding of forces of size one, per step.
            assert!(
                largest < 1e-14 * (1.0 + steps as f64),
                "{discretisation:?} {largest}"
            );
            let elastic = state.energies(&model).elastic();
            assert!(elastic < 1e-14 * (1.0 + steps as f64), "{elastic}");
            state.positions = stretched(&model, retained - 1e-3);
            let largest = forces(&model, &state)
                .iter()
                .map(Vector3::norm)
                .fold(0.0, f64::max);
            assert!(largest > 1e-4, "{largest}");
        }
    }
}

/// Work on a bar that is stretched and let back: what is elastic at the end, none, and what flow took. Without hardening the stress power while
/// it flows is ψ'(e_y) per plastic strain, with ψ(ε) = μ/2 (e^(2ε) + 2 e^(−ε) − 3) of the neo-Hookean law at constant volume. A step of Δ takes
/// ψ(e_y + Δ) − ψ(e_y) instead of ψ'(e_y) Δ, which is more by Δ/2 ψ''/ψ' at most with ψ'' at e_y + Δ; the work is summed by forces at both
/// ends of each step, and is off by the rule's Δ²/12 (ψ'(end) − ψ'(start)) of each step.
#[test]
fn the_work_on_a_bar_is_its_elastic_and_its_dissipated_energy() {
    let (strain, yielding) = (0.45, 0.05);
    let mu = 1.0 / 2.8;
    let slope = |e: f64| mu * (libm::exp(2.0 * e) - libm::exp(-e));
    let curvature = |e: f64| mu * (2.0 * libm::exp(2.0 * e) + libm::exp(-e));
    let model = block(LawName::NeoHookean, Discretisation::Selective, WALL, 0.0).unwrap();
    let mut excess = Vec::new();
    for steps in [90, 180, 360] {
        let step = strain / steps as f64;
        let (mut state, mut work) = (State::at_rest(&model), 0.0);
        let retained = strain - yielding;
        // Out, and back to where no force is left.
        let back = (yielding / step).round() as usize;
        let out = (1..=steps).map(|k| step * k as f64);
        let strains = out.chain((1..=back).map(|k| strain - yielding * k as f64 / back as f64));
        for strain in strains {
            let start = state.clone();
            state.positions = stretched(&model, strain);
            let ends = forces(&model, &start)
                .into_iter()
                .zip(forces(&model, &state));
            let moved = state.positions.iter().zip(&start.positions);
            for ((a, b), (to, from)) in ends.zip(moved) {
                work -= 0.5 * (a + b).dot(&(to - from));
            }
            flow(&model, &mut state, 1.0);
        }
        let energies = state.energies(&model);
        assert!(energies.elastic() < 1e-12, "{energies:?}");
        let expected = slope(yielding) * retained;
        let first_order = 0.5 * step * curvature(yielding + step) / slope(yielding);
        let more = energies.dissipated / expected - 1.0;
        assert!(more > 0.0 && more < first_order, "{more} {first_order}");
        excess.push(more);
        // The third derivative of the energy by a coordinate is that by the strain and what the exponentials of the motion add: within 4 times
        // the second one for strains below one half.
        let rule = (strain + yielding) * step * step / 12.0 * 4.0 * curvature(yielding + step);
        let missing = work - energies.dissipated;
        assert!(missing.abs() < rule, "{missing} {rule}");
    }
    // Of first order: with half of the step half of it.
    for two in excess.windows(2) {
        assert!((two[1] / two[0] - 0.5).abs() < 0.02, "{excess:?}");
    }
}

/// A free block that starts with a stretching motion, too fast to come back: kinetic, elastic and dissipated energy together stay what they were. Velocity
/// Verlet at a tenth of its limit, hω = 0.2 for the fastest mode and less for all others, is off by (hω)²/8 of the energy in a mode (Hairer et al.
/// 2003), and the quadratic form that it preserves changes at each flow: twice that is allowed.
#[test]
fn energy_that_moves_is_dissipated_and_nothing_else() {
    let model = block(
        LawName::StableNeoHookean,
        Discretisation::Selective,
        WALL,
        0.0,
    )
    .unwrap();
    let step = 0.1 * stable_step(&model, 1.0);
    let mut state = State::at_rest(&model);
    let rest = model.rest_positions().iter();
    state.velocities = rest
        .map(|x| Vector3::new(0.5 * x.x, -0.25 * x.y, -0.2 * x.z))
        .collect();
    let start = state.energies(&model).total();
    let mut solver = Method::VelocityVerlet.solver(&model).unwrap();
    for _ in 0..400 {
        let control = Control::default();
        solver
            .step(&model, &mut state, &control, &[], step, &Serial)
            .unwrap();
        flow(&model, &mut state, step);
        let energies = state.energies(&model);
        let drift = (energies.total() + energies.dissipated) / start - 1.0;
        assert!(drift.abs() < 0.01, "{drift} {energies:?}");
    }
    let taken = state.energies(&model).dissipated / start;
    assert!(taken > 0.2, "{taken}");
}

/// Half the step changes what is retained after a motion that is not straight by less than 1 %.
#[test]
fn half_the_step_changes_little() {
    let model = block(
        LawName::StableNeoHookean,
        Discretisation::Selective,
        WALL,
        0.0,
    )
    .unwrap();
    let run = |steps: usize| {
        let mut state = State::at_rest(&model);
        for step in 1..=steps {
            let s = step as f64 / steps as f64;
            let map = Matrix3::new(
                1.0 + 0.5 * s,
                0.8 * s * s,
                0.0,
                0.0,
                1.0,
                0.3 * s,
                0.0,
                0.0,
                1.0 - 0.2 * s,
            );
            state.positions = model.rest_positions().iter().map(|x| map * x).collect();
            flow(&model, &mut state, 1.0);
        }
        let count = model.sets()[0].count();
        PlasticState::read(&state.internal[model.internal_range(0)], count, 0)
    };
    let (coarse, fine) = (run(50), run(100));
    assert!(fine.strain > 0.4);
    assert!((coarse.strain / fine.strain - 1.0).abs() < 0.01);
    assert!((coarse.inverse - fine.inverse).norm() < 0.01 * fine.strain);
}

/// Laws whose pressure is no function of the volume alone cannot flow where it is carried apart, and can elsewhere.
#[test]
fn a_pressure_that_sees_the_shape_does_not_go_with_flow_elsewhere() {
    for law in LawName::ALL {
        for discretisation in Discretisation::ALL {
            let built = block(law, discretisation, WALL, 0.0);
            let refused = discretisation.is_split() && !law.is_volumetric_of_j();
            let expected = match refused {
                true => Some(BuildError::Plasticity { region: 0 }),
                false => None,
            };
            assert_eq!(built.err(), expected, "{law:?} {discretisation:?}");
        }
    }
    let message = BuildError::Plasticity { region: 3 }.to_string();
    assert!(message.contains("region 3") && message.contains("preserves volumes"));
    let wrong = ContinuumPlasticity {
        yield_strain: -0.1,
        ..WALL
    };
    let built = block(LawName::NeoHookean, Discretisation::Tetrahedra, wrong, 0.0);
    let message = built.err().map(|error| error.to_string());
    assert_eq!(
        message.as_deref(),
        Some("material of region 0: yield_strain is -0.1, allowed is >= 0")
    );
}

#[test]
fn position_based_methods_refuse_it_with_the_reason() {
    let xpbd = Method::Xpbd {
        substeps: 1,
        iterations: 1,
    };
    let law = LawName::NeoHookeanPolynomial;
    let model = block(law, Discretisation::Tetrahedra, WALL, 0.0).unwrap();
    let reason = xpbd.solver(&model).err().map(|error| error.reason);
    assert!(reason.is_some_and(|reason| reason.contains("without plasticity")));
}

/// A body without λ whose shear stiffness grows fourfold, freed of stress: everything is four times as stiff, and the step is half of what it was, to the
/// bit.
#[test]
fn stiffening_shortens_the_step_of_explicit_methods() {
    let plasticity = ContinuumPlasticity {
        hardening: 1e3,
        max_stiffening: 4.0,
        ..WALL
    };
    let (law, tetrahedra) = (LawName::NeoHookean, Discretisation::Tetrahedra);
    let model = block_of(law, tetrahedra, plasticity, 0.0, 0.0).unwrap();
    let mut state = State::at_rest(&model);
    let before = stable_step(&model, SAFETY);
    state.positions = stretched(&model, 0.4);
    assert!(flow(&model, &mut state, 1.0), "it is stiffer");
    assert!(
        !flow(&model, &mut state, 1.0),
        "and does not grow stiffer again"
    );
    state.positions = stretched(&model, 0.0);
    let count = model.sets()[0].count();
    for element in 0..count {
        let mut one = PlasticState::read(&state.internal, count, element);
        assert_eq!(one.stiffening, 4.0);
        one.inverse = Matrix3::identity();
        one.write(&mut state.internal, count, element);
    }
    assert_eq!(stable_step_at(&model, &state, SAFETY), 0.5 * before);
}

/// The equivalent strain of a stretch at constant volume is its logarithm along it, whatever the frame. Up to the yield strain nothing flows where the
/// body lies in its mesh, and beyond it is refused, with the element and its strain.
#[test]
fn a_body_that_yields_by_its_prestretch_is_refused() {
    let turn = nalgebra::Rotation3::from_euler_angles(0.4, -0.7, 1.1).into_inner();
    for discretisation in Discretisation::ALL {
        let built = |strain: f64| {
            let mut mesh = block_mesh([1.0; 3], [1, 1, 1]);
            if discretisation.is_quadratic() {
                mesh = mesh.refined().mesh;
            }
            let across = libm::exp(-0.5 * strain);
            let stretch = Vector3::new(libm::exp(strain), across, across);
            let prestretch = turn * Matrix3::from_diagonal(&stretch) * turn.transpose();
            mesh.prestretches = vec![prestretch; mesh.tets.len()];
            build(mesh, LawName::NeoHookean, discretisation, WALL, 0.0, 0.4)
        };
        let model = built(0.049).unwrap();
        let mut state = State::at_rest(&model);
        flow(&model, &mut state, 1.0);
        assert_eq!(state, State::at_rest(&model), "{discretisation:?}");
        let error = built(0.53).unwrap_err();
        let BuildError::YieldsAtRest {
            region: 0,
            strain,
            yield_strain: 0.05,
            ..
        } = error
        else {
            panic!("{error}");
        };
        assert!((strain - 0.53).abs() < 1e-12, "{strain}");
        assert!(error.to_string().contains("strain of 0.530"), "{error}");
    }
}

/// Flow makes an F_p that is symmetric with positive eigenvalues, and sums that only grow; saved values that it cannot make are refused.
#[test]
fn values_that_no_flow_makes_are_refused() {
    let (law, of) = (LawName::NeoHookean, Discretisation::Tetrahedra);
    let model = block(law, of, WALL, 0.0).unwrap();
    let start = State::at_rest(&model);
    assert!(model.admits(&start.internal));
    let flowed = pull(&model, 0.45, 40);
    assert_ne!(flowed.internal, start.internal);
    assert!(model.admits(&flowed.internal));
    let count = model.sets()[0].count();
    let with = |block: usize, value: f64| {
        let mut internal = flowed.internal.clone();
        internal[(block + 1) * count - 1] = value;
        model.admits(&internal)
    };
    // Diagonal of F_p⁻¹ (0 to 2), beside it (3 to 5), p, g, dissipated energy.
    for (block, value) in [
        (0, -1.0),
        (1, 0.0),
        (2, -1.0),
        (4, f64::NAN),
        (5, 10.0),
        (6, -1e-3),
        (7, 0.999),
        (7, f64::INFINITY),
        (8, -1e-3),
    ] {
        assert!(!with(block, value), "{block} {value}");
    }
    assert!(with(6, 0.1) && with(7, 1.5) && with(8, 0.1));
}
