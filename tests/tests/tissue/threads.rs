//! Any number of threads gives the same bits: explicit, implicit and static steps of a body that is large enough to be computed in
//! parts (`Forces`).

use crate::beam::{GRAVITY, beam, mesh};
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Control, Discretisation, Executor, Method, Newton, Serial, State, TissueModel, stability,
};
use nalgebra::Vector3;
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Threads that begin together, each with every n-th part, backwards: one thread already has the order of no other executor.
struct Workers {
    threads: usize,
    /// Parts that were run, all loops together.
    parts: AtomicUsize,
}

impl Executor for Workers {
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        let together = Barrier::new(self.threads);
        let work = |worker: usize| {
            together.wait();
            let own = (0..parts).rev().skip(worker).step_by(self.threads);
            own.for_each(body);
        };
        std::thread::scope(|scope| {
            for worker in 1..self.threads {
                let work = &work;
                scope.spawn(move || work(worker));
            }
            work(0);
        });
        self.parts.fetch_add(parts, Ordering::Relaxed);
    }
}

/// All numbers of a state, to the bit: zeros of both signs differ.
fn bits(state: &State) -> Vec<u64> {
    let vectors = state.positions.iter().chain(&state.velocities);
    let vectors = vectors.chain(&state.accelerations);
    vectors
        .flat_map(|v| v.iter().copied())
        .chain(state.internal.iter().copied())
        .chain([state.step])
        .map(f64::to_bits)
        .collect()
}

/// The state after some steps from a beam of which one node is pushed through its neighbours.
fn stepped(
    model: &TissueModel,
    method: Method,
    h: f64,
    steps: usize,
    exec: &dyn Executor,
) -> Vec<u64> {
    let mut state = State::at_rest(model);
    let inside = Vector3::new(0.06, 0.0, 0.0);
    let distance = |p: &Vector3<f64>| (p - inside).norm_squared();
    let nodes = 0..model.node_count();
    let pushed = nodes
        .min_by(|&a, &b| distance(&state.positions[a]).total_cmp(&distance(&state.positions[b])))
        .expect("a node");
    state.positions[pushed].z += 4e-3;
    let control = Control {
        gravity: GRAVITY,
        ..Control::default()
    };
    let mut solver = method.solver(model).expect("a method for continua");
    for _ in 0..steps {
        solver
            .step(model, &mut state, &control, &[], h, exec)
            .expect("a law without poles");
    }
    bits(&state)
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mesh = mesh("M");
    assert!(mesh.tets.len() > 4096, "large enough for parts");
    let newton = Newton {
        iterations: 2,
        must_converge: false,
        ..Newton::default()
    };
    for discretisation in [Discretisation::Tetrahedra, Discretisation::PatchPressure] {
        let model = beam(&mesh, LawName::StableNeoHookean, 0.45, discretisation);
        let explicit = stability::stable_step(&model, stability::SAFETY);
        for (method, h, steps) in [
            (Method::StoermerVerlet, 0.5 * explicit, 20),
            (Method::GuardedMidpoint(newton), 0.02, 3),
            (Method::QuasiStatic(newton), 0.02, 1),
        ] {
            let serial = stepped(&model, method, h, steps, &Serial);
            for threads in [1, 2, 3, 5] {
                let workers = Workers {
                    threads,
                    parts: AtomicUsize::new(0),
                };
                let case = || format!("{}, {threads} threads", method.name());
                let threaded = stepped(&model, method, h, steps, &workers);
                assert!(threaded == serial, "{}", case());
                // Each step computes forces once at least, in more than one part.
                assert!(workers.parts.into_inner() > steps, "{}", case());
            }
        }
    }
}
