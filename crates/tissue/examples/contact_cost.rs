//! What contact costs in a step of a vessel of 2,880 tetrahedra between two round tools: `cargo run --release -p microsim-tissue
//! --example contact_cost`. Times are those of the solver alone; each is the fastest of three runs.

use microsim_mesh::{Arc, CellSplit, Layer, Tube};
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, Contact, ContactSource, Contacts, ContinuumConstants, Control, Discretisation,
    Material, Method, Newton, Serial, State, Touching, build_model,
};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Two cylinders along y, above and below the vessel.
struct Tools {
    radius: f64,
    /// Distance of their axes from the middle at the start and the end of the step [m].
    from: f64,
    to: f64,
    start: Vec<Vector3<f64>>,
    friction: f64,
    memory: BTreeMap<[u32; 2], (f64, Vector3<f64>)>,
    time: Duration,
    finds: u32,
}

impl Tools {
    fn key(contact: &Contact) -> [u32; 2] {
        // The tools are pressed on from above and below.
        [contact.nodes[0], u32::from(contact.normal.z < 0.0)]
    }
}

impl ContactSource for Tools {
    fn find(&mut self, way: f64, positions: &[Vector3<f64>], contacts: &mut Vec<Contact>) {
        let clock = Instant::now();
        let last: BTreeMap<_, _> = contacts
            .iter()
            .map(|c| (Self::key(c), c.pressure))
            .collect();
        contacts.clear();
        for side in [1.0, -1.0] {
            let place =
                |share: f64| Vector3::z() * (side * (self.from + (self.to - self.from) * share));
            let axis = place(way);
            for (node, x) in positions.iter().enumerate() {
                let mut way = x - axis;
                way.y = 0.0;
                let gap = way.norm() - self.radius;
                if gap > 0.05e-3 {
                    continue;
                }
                let normal = way.normalize();
                let drift = axis - place(0.0);
                let offset = normal.dot(&axis) + self.radius;
                let mut contact = Contact {
                    nodes: [node as u32; 4],
                    weights: [1.0, 0.0, 0.0, 0.0],
                    first: 1,
                    normal,
                    offset,
                    floor: 0.0,
                    start_gap: normal.dot(&(self.start[node] + drift)) - offset,
                    friction: self.friction,
                    drift,
                    pressure: 0.0,
                    traction: Vector3::zeros(),
                };
                contact.floor = (contact.start_gap + 0.02e-3).min(0.0);
                let key = Self::key(&contact);
                let memory = self.memory.get(&key);
                contact.pressure = last
                    .get(&key)
                    .copied()
                    .or(memory.map(|m| m.0))
                    .unwrap_or(0.0);
                contact.traction = memory.map_or(Vector3::zeros(), |m| m.1);
                contacts.push(contact);
            }
        }
        self.time += clock.elapsed();
        self.finds += 1;
    }
}

fn main() {
    let layer = |thickness, region| Layer {
        thickness,
        cells: 1,
        region,
    };
    let mesh = Tube {
        center: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        inner_radius: 0.5e-3,
        layers: vec![layer(80e-6, 0), layer(40e-6, 1)],
        length: 10e-3,
        around: 12,
        along: 20,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    }
    .mesh()
    .expect("a tube");
    let material = |young| Material {
        density: 1060.0,
        relaxation_time: 2e-3,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::StableNeoHookean,
            young,
            poisson: 0.45,
            discretisation: Discretisation::PatchPressure,
        }),
    };
    let materials = [(0, material(300e3)), (1, material(60e3))];
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x.abs() > 4.99e-3).collect();
    let model = build_model(&mesh, &materials, &clamped, 1.0, Vec::new()).expect("a model");
    println!("{} tetrahedra", model.tets().len());
    let newton = Newton {
        iterations: 1,
        tolerance: 1e-3,
        must_converge: false,
    };
    for (name, method, radius, friction, touched) in [
        (
            "quasi-static, free",
            Method::QuasiStatic(newton),
            0.6e-3,
            0.0,
            false,
        ),
        (
            "quasi-static",
            Method::QuasiStatic(newton),
            0.6e-3,
            0.0,
            true,
        ),
        (
            "quasi-static, friction",
            Method::QuasiStatic(newton),
            0.6e-3,
            0.3,
            true,
        ),
        (
            "quasi-static, wide",
            Method::QuasiStatic(newton),
            2e-3,
            0.0,
            true,
        ),
        (
            "implicit Euler, free",
            Method::ImplicitEuler(newton),
            0.6e-3,
            0.0,
            false,
        ),
        (
            "implicit Euler",
            Method::ImplicitEuler(newton),
            0.6e-3,
            0.3,
            true,
        ),
        ("sdirk2", Method::Sdirk2(newton), 0.6e-3, 0.3, true),
    ] {
        let mut best = f64::INFINITY;
        let mut note = String::new();
        for _ in 0..3 {
            let mut solver = method.solver(&model).expect("a solver");
            let mut state = State::at_rest(&model);
            let mut contacts = Vec::new();
            let mut tools = Tools {
                radius,
                from: 0.63e-3 + radius,
                to: 0.0,
                start: Vec::new(),
                friction,
                memory: BTreeMap::new(),
                time: Duration::ZERO,
                finds: 0,
            };
            let (mut most, mut iterations, mut worst) = (0, 0, 0.0f64);
            let mut time = Duration::ZERO;
            let steps = 60;
            for step in 0..steps {
                // 0.3 mm in 20 steps, then held, then back.
                let speed = match step {
                    0..20 => -15e-6,
                    20..40 => 0.0,
                    _ => 15e-6,
                };
                tools.to = tools.from + speed;
                tools.start.clone_from(&state.positions);
                // A free vessel is pushed by a load, so that there is work.
                let mut control = Control {
                    gravity: Vector3::new(0.0, 0.0, -9.81),
                    ..Control::default()
                };
                if !touched {
                    let load = 1e-3 * f64::from(step.min(20));
                    control.forces = vec![(400, Vector3::new(0.0, 0.0, load))];
                }
                let found = tools.time;
                let clock = Instant::now();
                let mut touching = Touching {
                    source: &mut tools,
                    contacts: std::mem::take(&mut contacts),
                };
                let led = Contacts::default();
                let touching = touched.then_some(&mut touching);
                let kept = touching.map(|touching| {
                    let report = solver.advance(
                        &model,
                        &mut state,
                        &control,
                        &led,
                        Some(touching),
                        16e-3,
                        &Serial,
                    );
                    (report, std::mem::take(&mut touching.contacts))
                });
                let report = match kept {
                    Some((report, kept)) => {
                        contacts = kept;
                        report
                    }
                    None => solver.step(&model, &mut state, &control, &led, 16e-3, &Serial),
                };
                time += clock.elapsed() - (tools.time - found);
                iterations += report.expect("a step").iterations;
                most = most.max(contacts.iter().filter(|c| c.pressure > 0.0).count());
                for contact in &contacts {
                    let gap = contact.gap(&state.positions);
                    worst = worst.min(gap / model.mean_edge_length());
                }
                tools.memory = contacts
                    .iter()
                    .map(|c| (Tools::key(c), (c.pressure, c.traction)))
                    .collect();
                tools.from = tools.to;
            }
            let each = time.as_secs_f64() * 1e3 / f64::from(steps);
            if each < best {
                best = each;
                note = format!(
                    "{iterations} iterations in {steps} steps, at most {most} contacts closed, {:.2} finds a step, deepest {worst:.1e} edges",
                    f64::from(tools.finds) / f64::from(steps)
                );
            }
        }
        println!("{name:26} {best:6.2} ms a step; {note}");
    }
}
