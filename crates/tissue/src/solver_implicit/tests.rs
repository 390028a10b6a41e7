//! Convergence of Newton's method, conservation, targets, failures, same bits.

mod accuracy;
mod kinks;

use super::*;
use crate::executor::Serial;
use crate::model::TissueModel;
use crate::state::{NodeTarget, Pressure};
use crate::testing::{build, numbers, soft_block};
use nalgebra::Vector3;

const SCHEMES: [ImplicitScheme; 3] = [
    ImplicitScheme::BackwardEuler,
    ImplicitScheme::Midpoint,
    ImplicitScheme::Sdirk2,
];

const TIGHT: Newton = Newton {
    iterations: 30,
    tolerance: 1e-12,
    must_converge: true,
};

/// A block of soft tissue clamped on one side, bent by `bend` \[1/m\].
fn block(clamp: bool, bend: f64) -> (TissueModel, State) {
    let model = build(&soft_block([2, 2, 1]), |p| clamp && p.x < -0.9e-3);
    let mut state = State::at_rest(&model);
    for position in &mut state.positions {
        let x = position.x + 1e-3;
        position.z += bend * x * x;
    }
    (model, state)
}

fn run(
    model: &TissueModel,
    state: &mut State,
    scheme: ImplicitScheme,
    newton: Newton,
    control: &Control,
    h: f64,
    steps: usize,
) -> StepReport {
    let mut solver = SolverImplicit::new(model, scheme, newton);
    let mut last = StepReport::without_residual(0);
    for _ in 0..steps {
        last = solver.step(model, state, control, &[], h, &Serial).unwrap();
    }
    last
}

/// Three times the effort of one iteration are three iterations, to the bit, and back again.
#[test]
fn effort_is_a_multiple_of_the_iterations() {
    let (model, start) = block(true, 150.0);
    let of = |iterations| Newton {
        iterations,
        tolerance: 1e-14,
        must_converge: false,
    };
    let step = |solver: &mut SolverImplicit| {
        let mut state = start.clone();
        let report = solver.step(&model, &mut state, &Control::default(), &[], 1e-3, &Serial);
        (report.unwrap().iterations, state)
    };
    let new = |iterations| SolverImplicit::new(&model, SCHEMES[0], of(iterations));
    let (once, thrice) = (step(&mut new(1)), step(&mut new(3)));
    assert_eq!((once.0, thrice.0), (1, 3));
    let mut solver = new(1);
    solver.set_effort(Effort {
        iterations: 3,
        ..Effort::default()
    });
    assert_eq!(step(&mut solver), thrice);
    // Also with the model after elements have slid.
    solver.follow(&model);
    assert_eq!(step(&mut solver), thrice);
    solver.set_effort(Effort::default());
    assert_eq!(step(&mut solver), once);
}

/// A body of which every node has a target has no equation: it is there without an iteration, and moves as fast as from where it was (backward Euler: (x₁ − x₀)/h).
#[test]
fn a_body_that_is_prescribed_takes_no_iteration() {
    let (model, start) = block(false, 150.0);
    let h = 1e-3;
    let turned = |p: &Vector3<f64>| Vector3::new(-p.y, p.x, p.z + 1e-4);
    let targets: Vec<NodeTarget> = (0..)
        .zip(&start.positions)
        .map(|(node, p)| NodeTarget {
            node,
            target: turned(p),
            overlap: Vector3::zeros(),
        })
        .collect();
    let mut solver = SolverImplicit::new(&model, ImplicitScheme::BackwardEuler, TIGHT);
    let mut state = start.clone();
    let control = Control::default();
    let report = solver.step(&model, &mut state, &control, &targets, h, &Serial);
    let report = report.unwrap();
    assert_eq!((report.iterations, report.converged), (0, true));
    for ((x, v), from) in state
        .positions
        .iter()
        .zip(&state.velocities)
        .zip(&start.positions)
    {
        assert_eq!(*x, turned(from));
        assert!((v - (x - from) / h).norm() <= 1e-12 * v.norm());
    }
}

/// A step ends with the iteration in which its work is spent, and is marked as cut short; it has one in any case. What must converge goes on. The work is that of its
/// iterations: three take three times as much as one.
#[test]
fn a_step_ends_when_its_work_is_spent() {
    let (model, start) = block(true, 150.0);
    let newton = Newton {
        iterations: 5,
        tolerance: 1e-14,
        must_converge: false,
    };
    let step = |newton: Newton, most: f64| {
        let mut solver = SolverImplicit::new(&model, SCHEMES[0], newton);
        solver.limit_work(most);
        solver.follow(&model);
        let mut state = start.clone();
        let control = Control::default();
        let report = solver.step(&model, &mut state, &control, &[], 1e-3, &Serial);
        report.unwrap()
    };
    let free = step(newton, f64::INFINITY);
    assert_eq!((free.iterations, free.is_cut_short), (5, false));
    let once = free.work / 5.0;
    for (parts, iterations) in [(0.0, 1), (0.9, 1), (2.5, 3)] {
        let report = step(newton, parts * once);
        assert_eq!(report.iterations, iterations, "{parts}");
        assert!(report.is_cut_short && !report.converged);
        // The factor is the same each time, and solutions end in as many iterations to one.
        let work = report.work / (f64::from(iterations) * once);
        assert!((0.8..1.2).contains(&work), "{work}");
    }
    let must = Newton {
        tolerance: 1e-8,
        iterations: 30,
        must_converge: true,
    };
    let report = step(must, 0.0);
    assert!(report.converged && !report.is_cut_short && report.iterations > 1);
}

#[test]
fn newton_converges_quadratically() {
    let (model, start) = block(true, 150.0);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -2e3),
        ..Control::default()
    };
    let residual = |iterations| {
        let newton = Newton {
            iterations,
            tolerance: 0.0,
            must_converge: false,
        };
        let mut state = start.clone();
        run(
            &model,
            &mut state,
            ImplicitScheme::BackwardEuler,
            newton,
            &control,
            2e-3,
            1,
        )
        .residual
    };
    let residuals: Vec<f64> = (1..12).map(residual).collect();
    // The last step that is above rounding, and the two before it: r' = C r² in all of them.
    let last = residuals.iter().rposition(|r| *r > 0.0).unwrap();
    assert!(last >= 3, "it takes a few iterations: {residuals:?}");
    let falls = [last - 1, last].map(|i| libm::log(residuals[i] / residuals[i - 1]));
    assert!(falls[1] / falls[0] > 1.8, "{residuals:?}");
}

#[test]
fn momentum_of_a_free_body_is_kept() {
    for scheme in SCHEMES {
        let (model, mut state) = block(false, 100.0);
        let mut next = numbers();
        for velocity in &mut state.velocities {
            *velocity = Vector3::new(next(), next(), next()) * 0.05;
        }
        let momentum = |state: &State| -> Vector3<f64> {
            let each = state.velocities.iter().zip(model.masses());
            each.map(|(v, m)| v * *m).sum()
        };
        let spin = |state: &State| -> Vector3<f64> {
            let each = state.positions.iter().zip(&state.velocities);
            each.zip(model.masses())
                .map(|((x, v), m)| x.cross(v) * *m)
                .sum()
        };
        let start = (momentum(&state), spin(&state));
        let size: f64 = model.masses().iter().sum::<f64>() * 0.05;
        run(
            &model,
            &mut state,
            scheme,
            TIGHT,
            &Control::default(),
            2e-4,
            20,
        );
        // What Newton leaves, 1e-12 of the forces, for 20 steps; forces are below 1e3 times momentum per step.
        let change = (momentum(&state) - start.0).norm() / size;
        assert!(change < 1e-9, "{scheme:?}: {change}");
        let turned = (spin(&state) - start.1).norm() / (size * 1e-3);
        if scheme == ImplicitScheme::Midpoint {
            assert!(turned < 1e-9, "{turned}");
        } else {
            // The failure that the documentation names.
            assert!(turned > 1e-6, "{scheme:?}: {turned}");
        }
    }
}

#[test]
fn targets_and_clamps_are_met_to_the_last_bit() {
    for scheme in SCHEMES {
        let (model, mut state) = block(true, 0.0);
        let mut solver = SolverImplicit::new(&model, scheme, TIGHT);
        let lead = model.node_count() - 1;
        let goal = state.positions[lead] + Vector3::new(1e-4, 2e-4, -3e-4);
        let overlap = Vector3::new(0.0, 0.0, -1e-4);
        let before = state.positions[lead];
        let targets = [NodeTarget {
            node: lead as u32,
            target: goal,
            overlap,
        }];
        let shift = Vector3::new(0.0, 5e-5, 0.0);
        let clamps: Vec<Vector3<f64>> = model
            .clamped()
            .iter()
            .map(|&node| model.rest_positions()[node as usize] + shift)
            .collect();
        let control = Control {
            clamped_positions: clamps.clone(),
            ..Control::default()
        };
        let h = 1e-3;
        solver
            .step(&model, &mut state, &control, &targets, h, &Serial)
            .unwrap();
        assert_eq!(state.positions[lead], goal, "{scheme:?}");
        assert_eq!(state.velocities[lead], (goal - before) / h - overlap / h);
        for (node, place) in model.clamped().iter().zip(&clamps) {
            assert_eq!(state.positions[*node as usize], *place, "{scheme:?}");
        }
    }
}

#[test]
fn a_follower_pressure_is_balanced() {
    // A free block under even pressure on all sides shrinks and does not move. Its surface: outward triangles of all faces that
    // one element alone has.
    let mesh = soft_block([2, 2, 1]);
    let model = build(&mesh, |_| false);
    let mut faces: Vec<([u32; 3], [u32; 3])> = Vec::new();
    for [a, b, c, d] in mesh.tets.iter().copied() {
        for face in [[a, c, b], [a, b, d], [b, c, d], [a, d, c]] {
            let mut sorted = face;
            sorted.sort_unstable();
            faces.push((sorted, face));
        }
    }
    faces.sort_unstable();
    let outside: Vec<[u32; 3]> = faces
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() == 1)
        .map(|same| same[0].1)
        .collect();
    let control = Control {
        pressures: vec![Pressure {
            triangles: outside.into(),
            pressure: 2e3,
        }],
        ..Control::default()
    };
    let volume = |state: &State| -> f64 {
        let corners = |tet: &[u32; 4]| tet.map(|node| state.positions[node as usize]);
        let volumes = model.tets().iter().map(corners);
        volumes
            .map(|[a, b, c, d]| microsim_mesh::signed_volume(&a, &b, &c, &d))
            .sum()
    };
    let mut state = State::at_rest(&model);
    let start = volume(&state);
    let h = 0.05;
    run(
        &model,
        &mut state,
        ImplicitScheme::BackwardEuler,
        TIGHT,
        &control,
        h,
        30,
    );
    let share = volume(&state) / start;
    // Bulk modulus: κ = 5e4 Pa of the volumes and, of springs with c·E per edge and tetrahedron, less than E = 25e3 Pa:
    // between p/(κ + E) and p/κ.
    assert!(
        1.0 - share > 2e3 / 7.5e4 && 1.0 - share < 2e3 / 5e4,
        "{share}"
    );
    let drift: Vector3<f64> = state
        .positions
        .iter()
        .zip(model.rest_positions())
        .map(|(x, rest)| x - rest)
        .sum();
    assert!(drift.norm() < 1e-9, "{drift}");
}

/// In equilibrium under even pressure there are no reactions, and in a long step no inertia: the residual is relative to
/// the pressure alone. After one linear step it is of the order of the strain, p/κ = 50/5e4.
#[test]
fn a_residual_under_pressure_is_relative_to_the_pressure() {
    let mesh = soft_block([2, 2, 1]);
    let model = build(&mesh, |_| false);
    let control = Control {
        pressures: vec![Pressure {
            triangles: mesh.surface().triangles.into(),
            pressure: 50.0,
        }],
        ..Control::default()
    };
    let newton = Newton {
        iterations: 1,
        must_converge: false,
        ..TIGHT
    };
    let mut state = State::at_rest(&model);
    let scheme = ImplicitScheme::BackwardEuler;
    let report = run(&model, &mut state, scheme, newton, &control, 1.0, 1);
    assert!(
        report.residual > 0.0 && report.residual < 1e-2,
        "{report:?}"
    );
}

#[test]
fn a_body_far_from_rest_comes_back() {
    // Inverted, flat, and with one node far out: backward Euler goes down its potential to the rest shape.
    for (case, scheme) in (0..3).flat_map(|case| {
        [
            ImplicitScheme::BackwardEuler,
            ImplicitScheme::GuardedMidpoint,
        ]
        .map(|scheme| (case, scheme))
    }) {
        let model = build(&soft_block([4, 2, 2]), |p| p.x < -0.9e-3);
        let mut state = State::at_rest(&model);
        for (node, position) in state.positions.iter_mut().enumerate() {
            if model.is_clamped(node) {
                continue;
            }
            match case {
                0 => position.z = -position.z,
                1 => position.z = 0.0,
                _ if node + 1 == model.node_count() => position.z += 4e-3,
                _ => {}
            }
        }
        let newton = Newton {
            must_converge: false,
            ..Newton::default()
        };
        run(
            &model,
            &mut state,
            scheme,
            newton,
            &Control::default(),
            5e-3,
            60,
        );
        let farthest = state
            .positions
            .iter()
            .zip(model.rest_positions())
            .map(|(x, rest)| (x - rest).norm())
            .fold(0.0, f64::max);
        // What guarded midpoint keeps swings on: less than it takes to be distorted.
        let bound = if scheme == ImplicitScheme::BackwardEuler {
            1e-6
        } else {
            2e-4
        };
        assert!(
            farthest < bound,
            "case {case} {scheme:?}: {farthest} m of 2 mm"
        );
    }
}

#[test]
fn guarded_midpoint_is_implicit_midpoint_where_nothing_is_distorted() {
    let ends = [ImplicitScheme::Midpoint, ImplicitScheme::GuardedMidpoint].map(|scheme| {
        let (model, mut state) = block(true, 100.0);
        run(
            &model,
            &mut state,
            scheme,
            TIGHT,
            &Control::default(),
            1e-4,
            10,
        );
        state
    });
    assert_eq!(ends[0], ends[1]);
}

#[test]
fn failures_leave_the_state_as_it_was() {
    for scheme in SCHEMES {
        let (model, mut state) = block(true, 100.0);
        let mut solver = SolverImplicit::new(
            &model,
            scheme,
            Newton {
                iterations: 1,
                tolerance: 1e-14,
                must_converge: true,
            },
        );
        let start = state.clone();
        let result = solver.step(&model, &mut state, &Control::default(), &[], 1e-2, &Serial);
        assert!(
            matches!(result, Err(StepFailure::NotConverged { iterations: 1, residual }) if residual > 1e-14),
            "{result:?}"
        );
        assert_eq!(state, start);
        state.velocities[3].y = f64::NAN;
        let result = solver.step(&model, &mut state, &Control::default(), &[], 1e-2, &Serial);
        assert_eq!(result, Err(StepFailure::NotFinite), "{scheme:?}");
        assert_eq!(state.positions, start.positions);
        assert!(state.velocities[3].y.is_nan());
    }
}

/// Runs the parts of a loop backwards.
struct Backwards;

impl Executor for Backwards {
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        (0..parts).rev().for_each(body);
    }
}

#[test]
fn same_bits_on_any_executor_and_from_any_copy() {
    // Large enough for several parts.
    let model = build(&soft_block([10, 10, 8]), |p| p.x < -0.9e-3);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -500.0),
        ..Control::default()
    };
    let newton = Newton {
        iterations: 2,
        must_converge: false,
        ..Newton::default()
    };
    let mut solver = SolverImplicit::new(&model, ImplicitScheme::BackwardEuler, newton);
    let mut state = State::at_rest(&model);
    solver
        .step(&model, &mut state, &control, &[], 1e-3, &Serial)
        .unwrap();
    let mut twin = state.clone();
    let mut copy = solver.boxed_clone();
    solver
        .step(&model, &mut state, &control, &[], 1e-3, &Serial)
        .unwrap();
    copy.step(&model, &mut twin, &control, &[], 1e-3, &Backwards)
        .unwrap();
    assert_eq!(state, twin);
}

/// Weight of a hundredth of the earth's: strains of 1e-5. Rounding of the energy near rest is no reason to refuse a step.
#[test]
fn small_loads_converge() {
    let model = crate::testing::beam(0.49);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -0.1),
        ..Control::default()
    };
    let mut solver = SolverImplicit::new(&model, ImplicitScheme::BackwardEuler, Newton::default());
    let mut state = State::at_rest(&model);
    for step in 0..20 {
        let report = solver.step(&model, &mut state, &control, &[], 0.02, &Serial);
        assert!(report.is_ok(), "step {step}: {report:?}");
    }
}
