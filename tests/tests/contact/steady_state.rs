//! A step with contact takes no memory once the solver has seen the body at its fullest.

#![allow(unsafe_code, reason = "an allocator that counts")]

use microsim_contact::{CapsuleMotion, ContactPair};
use microsim_geometry::Capsule;
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_tests::detected::Detected;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContactStep, ContinuumConstants, Control, Discretisation, Material, Method, Newton,
    Serial, Solver, State, TissueModel, build_model, stability,
};
use nalgebra::Vector3;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

type V3 = Vector3<f64>;

/// Counts how often this thread asked for memory.
struct Counted;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: everything is handed on to the system's allocator as it came; the counter needs no memory of its own.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`, and `alloc` handed out the system's memory.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTED: Counted = Counted;

fn count() -> usize {
    COUNT.with(Cell::get)
}

const SIDE: f64 = 2e-3;
const STEPS: usize = 30;

/// What the assemblies of a step may ask for: at most four of them, of two bodies, and the loads that forces are known for.
const OF_ASSEMBLIES: usize = 12;

/// Two blocks and a rod: the lower block is held below, the upper one above.
struct World {
    model: TissueModel,
    rest: State,
    state: State,
    detected: Detected,
    solver: Box<dyn Solver>,
    control: Control,
    contacts: Vec<microsim_tissue::Contact>,
    h: f64,
    most: usize,
}

fn block(z: f64) -> TetMesh {
    let block = Block {
        center: [0.05 * z, 0.1 * z, z],
        size: [SIDE; 3],
        cells: [3, 3, 3],
        split: CellSplit::Kuhn,
    };
    block.mesh().expect("a block")
}

impl World {
    fn new(method: Method) -> Self {
        let (lower, upper) = (block(0.0), block(1.005 * SIDE));
        let material = Material {
            density: 1000.0,
            relaxation_time: 0.0,
            behaviour: Behaviour::Continuum(ContinuumConstants {
                law: LawName::NeoHookeanPolynomial.into(),
                young: 20e3,
                poisson: 0.3,
                discretisation: Discretisation::Tetrahedra,
                plasticity: None,
            }),
        };
        let model_of = |mesh: &TetMesh, held: f64| {
            let held: Vec<bool> = mesh
                .positions
                .iter()
                .map(|p| (p.z - held).abs() < 0.01 * SIDE)
                .collect();
            build_model(mesh, &[(0, material)], &held, 50.0, Vec::new()).expect("a body")
        };
        let (below, above) = (
            model_of(&lower, -0.5 * SIDE),
            model_of(&upper, 1.505 * SIDE),
        );
        let model = TissueModel::union(&[&below, &above]);
        let rod = Capsule {
            a: V3::new(-SIDE, -0.62 * SIDE, 0.1 * SIDE),
            b: V3::new(SIDE, -0.62 * SIDE, 0.1 * SIDE),
            radius: 0.2 * SIDE,
        };
        let still = CapsuleMotion {
            start: rod,
            end: rod,
        };
        let pairs = vec![
            ContactPair::Bodies {
                body: 0,
                with: 1,
                ends: None,
            },
            ContactPair::Tool { body: 0, tool: 0 },
            ContactPair::Itself { body: 1 },
        ];
        let reach = if method.is_explicit() { 0.1 } else { 0.3 };
        let edge = model.mean_edge_length();
        let tools = vec![Some(vec![still])];
        let limit = stability::stable_step(&model, stability::SAFETY);
        let rest = State::at_rest(&model);
        Self {
            detected: Detected::new(&[&lower, &upper], pairs, tools, 0.3, reach, edge),
            solver: method.solver(&model).expect("a method for it"),
            control: Control::default(),
            contacts: Vec::new(),
            h: if method.is_explicit() { limit } else { 2e-3 },
            state: rest.clone(),
            rest,
            model,
            most: 0,
        }
    }

    /// Starts again at zero.
    fn reset(&mut self) {
        // Into the memory that is there.
        self.state.positions.copy_from_slice(&self.rest.positions);
        self.state.velocities.copy_from_slice(&self.rest.velocities);
        self.state.accelerations.clear();
        self.state.step = 0.0;
        self.detected.forget();
        self.contacts.clear();
    }

    /// The upper block is pressed down by a tenth of its height, pushed aside and lifted again; gives how often memory was asked for.
    fn step(&mut self, step: usize) -> usize {
        let half = STEPS as f64 / 2.0;
        let share = 1.0 - (step as f64 + 1.0 - half).abs() / half;
        let shift = V3::new(0.02 * SIDE * share, 0.0, -0.1 * SIDE * share);
        self.control.clamped_positions.clear();
        let lower = self.model.node_count() / 2;
        for &node in self.model.clamped() {
            let place = self.model.rest_positions()[node as usize];
            let moved = if node as usize >= lower {
                shift
            } else {
                V3::zeros()
            };
            self.control.clamped_positions.push(place + moved);
        }
        let before = count();
        self.detected.begin(&self.state.positions);
        let mut touching = ContactStep {
            source: &mut self.detected,
            contacts: std::mem::take(&mut self.contacts),
        };
        let report = self.solver.advance(
            &self.model,
            &mut self.state,
            &self.control,
            &[],
            Some(&mut touching),
            self.h,
            &Serial,
        );
        self.contacts = touching.contacts;
        self.detected.end(&self.contacts);
        let asked = count() - before;
        report.expect("a step");
        let acting = self.contacts.iter().filter(|c| c.normal_force > 0.0);
        self.most = self.most.max(acting.count());
        asked
    }
}

/// Blocks that are pressed on one another, against a rod and apart again, twice the same: what a method needs it has after the first
/// round, contact and all. Methods that solve systems ask for memory where they assemble them, a few times per assembly and as
/// often without contact; for what is touched they ask no more. A scene's tick, which copies its state to come back to, is not meant.
#[test]
fn no_allocation_in_the_steady_state() {
    let newton = Newton {
        iterations: 2,
        tolerance: 1e-2,
        must_converge: false,
    };
    let xpbd = Method::Xpbd {
        substeps: 2,
        iterations: 3,
    };
    for (method, most) in [
        (Method::StoermerVerlet, 0),
        (Method::SymplecticEuler, 0),
        (Method::VelocityVerlet, 0),
        (Method::VelocityVerletLagged, 0),
        (xpbd, 0),
        (Method::ImplicitEuler(newton), OF_ASSEMBLIES),
        (Method::Sdirk2(newton), 2 * OF_ASSEMBLIES),
        (Method::QuasiStatic(newton), OF_ASSEMBLIES),
    ] {
        let (mut world, name) = (World::new(method), method.name());
        let mut counts = Vec::new();
        for _ in 0..2 {
            world.reset();
            counts.extend((0..STEPS).map(|step| world.step(step)));
        }
        assert!(world.most > 15, "{name}: {} points press", world.most);
        assert!(counts[0] > 100, "{name}: the counter counts");
        let worst = counts[STEPS..].iter().max();
        assert!(worst <= Some(&most), "{name}: {counts:?}");
    }
}
