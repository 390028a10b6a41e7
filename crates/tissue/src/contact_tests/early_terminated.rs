//! Steps of time that need not converge, of bodies so small that the interior-point method solves the contacts: a free block in a grip.

use super::*;
use crate::newton::NewtonOptions;
use crate::solver::{Effort, ResidualBounds};
use crate::solver_implicit::{DistortionOptions, ImplicitScheme, SolverImplicit};

/// A friction that holds the piece, and one that does not: twice the grip of 19 mN, times friction, is 150 and 0.6 times the weight.
const FRICTION: f64 = 0.5;
const WEAK: f64 = 0.002;
/// Of time \[s\].
const STEPS: [f64; 2] = [1e-3, 8e-3];
/// When the grip is closed, and the end \[s\].
const CLOSED: f64 = 0.04;
const END: f64 = 0.104;

/// The two digits to which friction comes in such steps, and the multiplier residual that they leave, over the mean edge length: the options
/// `friction_tolerance` and `multiplier_tolerances` of the method.
const DIGITS: f64 = 1e-2;
const RESIDUAL: f64 = 1e-3;

fn early() -> Newton {
    Newton {
        iterations: 6,
        must_converge: false,
        ..Newton::default()
    }
}

/// How far each jaw has closed, and both have risen, at a time \[m\]: they close by 0.2 mm each, then rise with up to 20 mm/s, which they
/// reach in 20 ms.
fn place(time: f64) -> [f64; 2] {
    let closed = 2e-4 * (time / CLOSED).min(1.0);
    let eased = ((time - CLOSED) / 0.02).clamp(0.0, 1.0);
    let risen = 0.02 * (0.01 * eased * eased + (time - CLOSED - 0.02).max(0.0));
    [closed, risen]
}

/// A block of 3 × 2 × 2 mm with nothing below it, between jaws along x.
fn in_jaws(newton: Newton, friction: f64) -> World {
    let mut world = World::new(free_block([3, 2, 2], 0.0), Method::ImplicitEuler(newton));
    world.control = gravity();
    world.reach = 0.3e-3;
    let jaw = |side| Plane {
        normal: Vector3::x() * side,
        friction,
        ..Plane::floor(-1.5e-3)
    };
    world.planes = vec![jaw(1.0), jaw(-1.0)];
    world
}

/// A step with the jaws on their path.
fn move_jaws(world: &mut World, step: u32, h: f64) -> StepReport {
    let [from, to] = [step, step + 1].map(|step| place(f64::from(step) * h));
    for plane in &mut world.planes {
        plane.motion = plane.normal * (to[0] - from[0]) + Vector3::z() * (to[1] - from[1]);
    }
    let report = world.step(h);
    report.unwrap_or_else(|failure| panic!("step {step} of {h} s: {failure}"))
}

/// The block is gripped; `each` sees the world before and after every step.
fn grip(newton: Newton, friction: f64, h: f64, mut each: impl FnMut(&Vector3<f64>, &World)) {
    let mut world = in_jaws(newton, friction);
    for step in 0..(END / h).round() as u32 {
        let before = world.velocity();
        move_jaws(&mut world, step, h);
        each(&before, &world);
    }
}

/// Three times the effort of two iterations are as many as six, to the bit. By the augmented Lagrangian method contacts grip as hard, to the digits of such steps; with the usual
/// effort it is the interior-point method again, to the bit.
#[test]
fn contacts_take_the_method_that_is_asked_for() {
    let h = STEPS[1];
    let effort = |iterations, augmented_lagrangian| Effort {
        iterations,
        augmented_lagrangian,
    };
    let of = |iterations, efforts: &[Effort]| {
        let newton = Newton {
            iterations,
            ..early()
        };
        let mut world = in_jaws(newton, FRICTION);
        for effort in efforts {
            world.solver.set_effort(*effort);
        }
        for step in 0..(CLOSED / h).round() as u32 {
            move_jaws(&mut world, step, h);
        }
        world
    };
    let once = of(6, &[Effort::default()]);
    assert_eq!(of(2, &[effort(3, false)]).state, once.state);
    let other = of(2, &[effort(3, true)]);
    assert_ne!(once.state, other.state);
    let [one, other] = [&once, &other].map(squeeze);
    assert!((one - other).abs() <= DIGITS * one, "{one} N, {other} N");
    assert_eq!(
        of(6, &[effort(3, true), Effort::default()]).state,
        once.state
    );
}

/// By the augmented Lagrangian method contacts begin no step of theirs beyond the work of the equation: where there is none, the same iterations take less.
#[test]
fn contacts_take_no_more_than_the_work_of_an_equation() {
    let h = STEPS[1];
    let work = |most: f64| {
        let newton = Newton {
            iterations: 1,
            ..early()
        };
        let mut world = in_jaws(newton, FRICTION);
        world.solver.set_effort(Effort {
            iterations: 1,
            augmented_lagrangian: true,
        });
        world.solver.limit_work(most);
        let steps = 0..(CLOSED / h).round() as u32;
        let works = steps.map(|step| move_jaws(&mut world, step, h).work);
        works.sum::<f64>()
    };
    let (bounded, free) = (work(0.0), work(f64::INFINITY));
    assert!(bounded < free, "{bounded} s, {free} s");
}

/// The steps of a grip in time \[s\] `h` with one iteration each, where contacts that press harder than `jump` \[N\] have jumped.
fn steps_of_one_iteration(h: f64, options: &NewtonOptions, jump: f64) -> Vec<StepReport> {
    let newton = Newton {
        iterations: 1,
        ..early()
    };
    let mut world = in_jaws(newton, FRICTION);
    world.jump = jump;
    world.solver = Box::new(SolverImplicit::with_options(
        &world.model,
        ImplicitScheme::BackwardEuler,
        newton,
        options,
        DistortionOptions::default(),
    ));
    let steps = 0..(END / h).round() as u32;
    steps.map(|step| move_jaws(&mut world, step, h)).collect()
}

/// Where residuals are beyond their bounds a step of one iteration takes up to as many more as the options have, and they are within them in the end. Without bounds it takes one. The bounds are half of
/// what is left then at most, so that there are such steps.
#[test]
fn a_step_whose_residual_is_beyond_its_bounds_takes_more_iterations() {
    let h = STEPS[1];
    let usual = NewtonOptions::default();
    let steps = |residual: ResidualBounds| {
        let mut options = usual;
        // Overlaps take more iterations, too.
        options.contact.overlap = f64::INFINITY;
        options.contact.residual = residual;
        steps_of_one_iteration(h, &options, f64::INFINITY)
    };
    let unbounded = ResidualBounds {
        relative: f64::INFINITY,
        force: f64::INFINITY,
    };
    let free = steps(unbounded);
    assert!(free.iter().all(|of| of.iterations == 1));
    let most = |of: fn(&StepReport) -> f64| free.iter().map(of).fold(0.0, f64::max);
    let bounds = ResidualBounds {
        relative: 0.5 * most(|of| of.residual),
        force: 0.5 * most(|of| of.force_residual),
    };
    let beyond = |of: &&StepReport| !bounds.hold(of.residual, of.force_residual);
    assert!(free.iter().filter(beyond).count() > 0);
    let bounded = steps(bounds);
    let most = 1 + usual.contact.more_iterations;
    assert!(bounded.iter().all(|of| of.iterations <= most));
    assert_eq!(bounded.iter().filter(beyond).count(), 0);
}

/// Where each force counts as one that has jumped, steps of one iteration that end above the bounds of jumps take up to as many more as the options have, and only those do.
#[test]
fn a_step_whose_forces_have_jumped_takes_more_iterations() {
    let h = STEPS[1];
    let mut options = NewtonOptions::default();
    // Overlaps, and forces that mean nothing, take more iterations, too.
    options.contact.overlap = f64::INFINITY;
    options.contact.residual.force = f64::INFINITY;
    let steps = |jump: f64| steps_of_one_iteration(h, &options, jump);
    let is_unsolved = |of: &&StepReport| {
        let bounds = options.contact.jump;
        !bounds.hold(of.residual, of.force_residual, of.contact_residual)
    };
    let free = steps(f64::INFINITY);
    assert!(free.iter().all(|of| of.iterations == 1));
    assert!(free.iter().filter(is_unsolved).count() > 0);
    let jumping = steps(0.0);
    let most = 1 + options.contact.more_iterations;
    assert!(jumping.iter().any(|of| of.iterations > 1));
    assert!(jumping.iter().all(|of| of.iterations <= most));
    let unsolved = jumping.iter().filter(is_unsolved);
    assert!(unsolved.clone().all(|of| of.iterations == most));
    assert!(unsolved.count() < free.iter().filter(is_unsolved).count());
}

/// Jaws close at a constant speed. Where they are taken to move on, steps of two iterations begin with what they squeeze in motion, and less is left in the end: what two iterations
/// leave of a start that is an order nearer.
#[test]
fn what_moves_on_is_nearer_to_the_solution() {
    let h = 4e-3;
    let steps = (CLOSED / h).round() as u32;
    let newton = Newton {
        iterations: 2,
        ..early()
    };
    let left = |moves_on: bool| {
        let mut world = in_jaws(newton, FRICTION);
        world.moves_on = moves_on;
        let reports = (0..steps).map(|step| move_jaws(&mut world, step, h));
        // In the first one everything is at rest yet.
        let forces = reports.skip(1).map(|of| of.force_residual);
        forces.sum::<f64>()
    };
    let (on, anew) = (left(true), left(false));
    assert!(on < 0.5 * anew, "{on} N, {anew} N");
}

/// The force with which both jaws press against each other \[N\].
fn squeeze(world: &World) -> f64 {
    let push = |side: f64| -> f64 {
        let of_jaw = world.contacts.iter().filter(|c| c.normal.x == side);
        of_jaw.map(|c| c.normal_force).sum()
    };
    push(1.0).min(push(-1.0))
}

/// Signorini and Coulomb for each contact as it is published, and Newton's second law for the block with them. What the block does is to be
/// rounding: of positions in an acceleration, and of the sum of forces.
#[test]
fn forces_in_a_grip_obey_friction_and_move_the_piece() {
    for h in STEPS {
        for friction in [FRICTION, WEAK] {
            grip(early(), friction, h, |before, world| {
                let (mut pressures, mut sizes) = (0.0, 0.0);
                for contact in &world.contacts {
                    let (normal_force, friction_force) =
                        (contact.normal_force, contact.friction_force.norm());
                    assert!(normal_force >= 0.0);
                    assert!(
                        contact.normal.dot(&contact.friction_force).abs() <= 1e-12 * friction_force
                    );
                    assert!(friction_force <= (1.0 + DIGITS) * friction * normal_force);
                    if contact.is_sliding {
                        assert!(friction_force >= (1.0 - DIGITS) * friction * normal_force);
                    }
                    pressures += normal_force;
                    sizes += contact.force().norm();
                }
                assert!(pressures > 0.0);
                let mass = world.mass();
                let forces = world.force() + world.control.gravity * mass;
                let left = forces - (world.velocity() - before) * (mass / h);
                let positions = world.state.positions.iter();
                let reach = positions.map(|x| x.amax()).fold(0.0, f64::max);
                let rounding = 4.0 * f64::EPSILON * (mass * reach / (h * h) + sizes);
                assert!(left.norm() <= rounding, "{left:?} N, not {rounding}");
            });
        }
    }
}

/// A firm grip carries the piece and nothing slides; in a weak one all does, and falls with what friction leaves of its weight.
#[test]
fn a_piece_in_a_grip_is_carried_or_slips() {
    for h in STEPS {
        for (friction, holds) in [(FRICTION, true), (WEAK, false)] {
            let mut steps = 0;
            let steady = (0.02 / h) as usize;
            let last = (END / h).round() as usize;
            grip(early(), friction, h, |before, world| {
                steps += 1;
                if steps <= last - steady {
                    return;
                }
                let touching = world.contacts.iter().filter(|c| c.normal_force > 0.0);
                let slide = touching.map(|c| c.is_sliding).collect::<Vec<_>>();
                let velocity = world.velocity();
                if holds {
                    assert!(!slide.contains(&true), "{slide:?}");
                    // Twice the residual of a step.
                    let edge = world.model.mean_edge_length();
                    assert!((velocity.z - 0.02).abs() <= 2.0 * RESIDUAL * edge / h);
                } else {
                    assert!(!slide.contains(&false), "{slide:?}");
                    let held = 2.0 * friction * squeeze(world);
                    let fall = held / world.mass() - 9.81;
                    let found = (velocity - before).z / h;
                    let digits = DIGITS * held / world.mass();
                    assert!((found - fall).abs() <= digits, "{found}, not {fall} m/s²");
                }
            });
        }
    }
}

/// What is left out in such steps is less than they may leave: of converged ones, with six more digits, they differ by the residual: across the
/// normal once when a load comes on and once when it goes, as forces are remembered; along it relative to what the jaws have closed.
#[test]
fn an_early_terminated_grip_is_that_of_converged_steps() {
    let exact = Newton {
        tolerance: 1e-12,
        ..Newton::default()
    };
    for h in STEPS {
        let [early, exact] = [early(), exact].map(|newton| {
            let (mut places, mut grips, mut edge) = (Vec::new(), Vec::new(), 0.0);
            grip(newton, FRICTION, h, |_, world| {
                let both = world.state.positions.iter().zip(world.model.masses());
                let sum: Vector3<f64> = both.map(|(x, m)| x * *m).sum();
                places.push(sum / world.mass());
                grips.push(squeeze(world));
                edge = world.model.mean_edge_length();
            });
            (places, grips, edge)
        });
        let residual = RESIDUAL * exact.2;
        for (step, (found, right)) in early.0.iter().zip(&exact.0).enumerate() {
            let error = (found - right).norm();
            assert!(error <= 2.0 * residual, "{h} s, {step}: {error} m");
        }
        for (step, (found, right)) in early.1.iter().zip(&exact.1).enumerate() {
            let closed = place((step + 1) as f64 * h)[0];
            let error = (found / right - 1.0).abs();
            assert!(error <= residual / closed, "{h} s, {step}: {error}");
        }
        let least = exact.0.last().unwrap().z - exact.0[0].z;
        assert!(least > 0.9 * place(END)[1], "it is lifted");
    }
}

/// A floor that has come into a block by a tenth of a millimetre before the step.
struct OldOverlap {
    start: Vec<Vector3<f64>>,
    height: f64,
}

impl ContactSource for OldOverlap {
    fn find(&mut self, _: f64, _: &[Vector3<f64>], contacts: &mut Vec<Contact>) {
        contacts.clear();
        let low = self.start.iter().enumerate();
        let low = low.filter(|(_, x)| x.z < self.height);
        contacts.extend(low.map(|(node, x)| Contact {
            start_gap: x.z - self.height,
            ..Contact::of_node(node as u32, Vector3::z(), self.height)
        }));
    }
}

/// What one step has left, as the undoing of overlaps after its last iteration, is no work of the next: that has the work of a solver that has done
/// nothing before, so a session that is resumed has its steps cut short where it had them.
#[test]
fn the_work_of_a_step_depends_on_its_state_alone() {
    let mesh = block_mesh([4e-3, 2e-3, 2e-3], [4, 2, 2]);
    let model = build(&mesh, |x| x.x < -1.9e-3);
    let low = mesh.positions.iter().map(|x| x.z).fold(0.0, f64::min);
    let step = |solver: &mut dyn crate::Solver, state: &mut State| {
        let mut source = OldOverlap {
            start: state.positions.clone(),
            height: low + 1e-4,
        };
        let mut contact = ContactStep {
            source: &mut source,
            contacts: Vec::new(),
        };
        let control = Control::default();
        let step = solver.advance(
            &model,
            state,
            &control,
            &[],
            Some(&mut contact),
            8e-3,
            &Serial,
        );
        step.unwrap()
    };
    let new = || Method::ImplicitEuler(early()).solver(&model).unwrap();
    let mut used = new();
    let mut state = State::at_rest(&model);
    for _ in 0..3 {
        step(&mut *used, &mut state);
        let (mut one, mut other) = (state.clone(), state.clone());
        let reports = [step(&mut *used, &mut one), step(&mut *new(), &mut other)];
        assert!(reports[0].work > 0.0);
        assert_eq!(reports[0], reports[1]);
        assert_eq!(one, other);
    }
}
