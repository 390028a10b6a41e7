//! What a step with contact costs over the size of the bodies: broad phase, narrow phase, response, and how each grows.
//!
//! Two waving layers meet face to face, so that what touches grows with the surface; and a layer of the same size meets a tool
//! of four capsules, so that what touches stays. One step each from the same state, again and again; the fastest counts.

use microsim_contact::{CapsuleMotion, ContactPair};
use microsim_geometry::Capsule;
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_tests::detected::Detected;
use microsim_tests::measured::thread_time as cpu;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, Contact, ContactSource, ContactStep, ContinuumConstants, Control, Discretisation,
    Material, Method, Newton, Serial, State, TissueModel, build_model, stability,
};
use nalgebra::Vector3;
use std::fmt::Write as _;

type V3 = Vector3<f64>;

/// Length of an edge along the layers \[m\].
const EDGE: f64 = 1e-3;
/// The implicit method is asked up to this many triangles: larger factors take longer than the whole of the rest.
const IMPLICIT: usize = 12_000;
/// CPU time that a step is repeated for \[s\], and how often at least.
const SPAN: f64 = 0.15;
const LEAST: usize = 3;

/// The least CPU time of something that gives its own time \[s\].
fn least(mut once: impl FnMut() -> f64) -> f64 {
    let (start, mut best, mut count) = (cpu(), f64::INFINITY, 0);
    while count < LEAST || cpu() - start < SPAN {
        best = best.min(once());
        count += 1;
    }
    best
}

/// A layer of `n` × `n` cells, one cell thick; its sides wave with the place, so that another one lies on it everywhere.
fn layer(n: usize, height: f64, shift: [f64; 2]) -> TetMesh {
    let size = n as f64 * EDGE;
    let block = Block {
        center: [shift[0], shift[1], height],
        size: [size, size, EDGE],
        cells: [n, n, 1],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a layer");
    for p in &mut mesh.positions {
        p.z += 0.5 * EDGE * libm::sin(0.3 * p.x / EDGE) * libm::cos(0.2 * p.y / EDGE);
    }
    mesh
}

/// What the layer meets.
#[derive(Clone, Copy, PartialEq)]
enum With {
    Layer,
    Tool,
}

/// Bodies about to meet, in one numbering.
struct Meeting {
    triangles: usize,
    model: TissueModel,
    start: State,
    detected: Detected,
    control: Control,
    h: f64,
}

impl Meeting {
    fn new(triangles: usize, with: With, explicit: bool) -> Self {
        // Two layers of n × n cells have 2 (4 n² + 4 n) triangles, one has half of them.
        let bodies = if with == With::Layer { 2.0 } else { 1.0 };
        let n = (triangles as f64 / bodies / 4.0).sqrt().round() as usize;
        let mut meshes = vec![layer(n, 0.0, [0.0; 2])];
        if with == With::Layer {
            meshes.push(layer(n, 1.01 * EDGE, [0.3 * EDGE, 0.2 * EDGE]));
        }
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
        let models: Vec<TissueModel> = meshes
            .iter()
            .map(|mesh| {
                let free = vec![false; mesh.positions.len()];
                build_model(mesh, &[(0, material)], &free, 0.0, Vec::new()).expect("a body")
            })
            .collect();
        let model = TissueModel::union(&models.iter().collect::<Vec<_>>());
        let h = match explicit {
            true => stability::stable_step(&model, stability::SAFETY),
            false => 4e-3,
        };
        // What is above comes down by 0.03 edges in the step, over a gap of 0.01.
        let way = V3::new(0.0, 0.0, -0.03 * EDGE);
        let mut start = State::at_rest(&model);
        let lower = models[0].node_count();
        let speed = way / h;
        for v in &mut start.velocities[lower..] {
            *v = speed;
        }
        start.step = h;
        let pair = match with {
            With::Layer => ContactPair::Bodies {
                body: 0,
                with: 1,
                ends: None,
            },
            With::Tool => ContactPair::Tool { body: 0, tool: 0 },
        };
        let tool = (0..4).map(|k| {
            let y = (2.0 * f64::from(k) - 4.0) * EDGE;
            let above = |y: f64| {
                let wave = 0.5 * libm::sin(0.0) * libm::cos(0.2 * y / EDGE);
                V3::new(0.0, y, (0.5 + wave + 0.71) * EDGE)
            };
            let capsule = |shift: V3| Capsule {
                a: above(y) + shift,
                b: above(y + 2.0 * EDGE) + shift,
                radius: 0.7 * EDGE,
            };
            CapsuleMotion {
                start: capsule(V3::zeros()),
                end: capsule(way),
            }
        });
        let tools = vec![Some(tool.collect())];
        let reach = if explicit { 0.1 } else { 0.3 };
        let edge = model.mean_edge_length();
        let skins: Vec<&TetMesh> = meshes.iter().collect();
        Self {
            triangles: meshes.len() * (4 * n * n + 4 * n),
            detected: Detected::new(&skins, vec![pair], tools, 0.3, reach, edge),
            control: Control::default(),
            model,
            start,
            h,
        }
    }

    /// Time of finding points while lists hold, and when they have to be rebuilt \[s\].
    fn detection(&mut self) -> [f64; 2] {
        let mut places = [self.start.positions.clone(), self.start.positions.clone()];
        let mut times = [0.0; 2];
        for (time, shift) in times.iter_mut().zip([0.0, 0.5 * EDGE]) {
            // A motion of the whole changes every list and no point; that a tool does not follow adds nothing but itself.
            let both = places[1].iter_mut().zip(&self.start.positions);
            both.for_each(|(p, start)| *p = start + V3::new(0.0, 0.0, shift));
            let (detected, mut turn) = (&mut self.detected, 0);
            detected.points(&places[0]);
            *time = least(|| {
                turn = 1 - turn;
                let before = cpu();
                detected.points(&places[turn]);
                cpu() - before
            });
        }
        times
    }

    /// Time of a step \[s\], of which that of finding points, and how many press; without contact the last two are 0.
    fn step(&mut self, method: Method, touches: bool) -> Step {
        let mut solver = method.solver(&self.model).expect("a method for it");
        let mut state = self.start.clone();
        let mut contacts: Vec<Contact> = Vec::new();
        let mut best = Step {
            all: f64::INFINITY,
            ..Step::default()
        };
        least(|| {
            state.clone_from(&self.start);
            contacts.clear();
            self.detected.forget();
            self.detected.begin(&self.start.positions);
            let mut source = Timed {
                of: &mut self.detected,
                spent: 0.0,
            };
            let mut touching = ContactStep {
                source: &mut source,
                contacts: std::mem::take(&mut contacts),
            };
            let before = cpu();
            let done = solver.advance(
                &self.model,
                &mut state,
                &self.control,
                &[],
                touches.then_some(&mut touching),
                self.h,
                &Serial,
            );
            let all = cpu() - before;
            done.expect("a step");
            contacts = touching.contacts;
            if all < best.all {
                best = Step {
                    all,
                    finding: source.spent,
                    pressing: contacts.iter().filter(|c| c.normal_force > 0.0).count(),
                };
            }
            all
        });
        best
    }
}

#[derive(Clone, Copy, Default)]
struct Step {
    all: f64,
    finding: f64,
    pressing: usize,
}

/// Counts the time of finding.
struct Timed<'a> {
    of: &'a mut Detected,
    spent: f64,
}

impl ContactSource for Timed<'_> {
    fn find(&mut self, step_fraction: f64, positions: &[V3], contacts: &mut Vec<Contact>) {
        let before = cpu();
        self.of.find(step_fraction, positions, contacts);
        self.spent += cpu() - before;
    }
}

/// A row: triangles, then times \[s\], of which 0 is none.
struct Row {
    triangles: usize,
    pressing: usize,
    times: Vec<f64>,
}

fn table(text: &mut String, titles: &[&str], rows: &[Row]) {
    let _ = writeln!(
        text,
        "| triangles | {} | points that press |\n|---|{}---|",
        titles.join(" | "),
        "---|".repeat(titles.len())
    );
    let time = |t: f64| match t {
        t if t >= 1e-3 => format!("{:.1} ms", 1e3 * t),
        t => format!("{:.0} µs", 1e6 * t),
    };
    for row in rows {
        let times: Vec<String> = row.times.iter().map(|t| time(*t)).collect();
        let (triangles, times) = (row.triangles, times.join(" | "));
        let _ = writeln!(text, "| {triangles} | {times} | {} |", row.pressing);
    }
    // Between the second size and the last: the first is small enough for the cache.
    if let [_, first, .., last] = rows {
        let sizes = libm::log(last.triangles as f64 / first.triangles as f64);
        let growth = |(a, b): (&f64, &f64)| match *a > 0.0 && *b > 0.0 {
            true => format!("{:.2}", libm::log(b / a) / sizes),
            false => "–".to_owned(),
        };
        let all = first.times.iter().zip(&last.times).map(growth);
        let _ = writeln!(
            text,
            "| **growth** | {} | |",
            all.collect::<Vec<_>>().join(" | ")
        );
    }
}

/// The rows of one method.
fn rows(with: With, method: Method, sizes: &[usize]) -> Vec<Row> {
    let explicit = method.is_explicit();
    let row = |&size: &usize| {
        let mut meeting = Meeting::new(size, with, explicit);
        let [kept, new] = meeting.detection();
        let free = meeting.step(method, false);
        let touching = meeting.step(method, true);
        Row {
            triangles: meeting.triangles,
            pressing: touching.pressing,
            times: vec![
                (new - kept).max(0.0),
                kept,
                free.all,
                touching.all,
                touching.finding,
                (touching.all - touching.finding - free.all).max(0.0),
            ],
        }
    };
    sizes.iter().map(row).collect()
}

/// Appends the section.
pub fn measure(text: &mut String) -> Result<(), String> {
    text.push_str(
        "\n## Over the size of the bodies\n\nCPU time of one thread, the fastest of several. Broad: making the lists of what is near anew, which happens when something has moved by a share of an edge; narrow: one search with the \
         lists kept. Then a step without contact, the same step with contact, and of it the search (as often as the method asks) and the response: what is left. Growth: exponent over the number of triangles, from the second row to \
         the last.\n",
    );
    let sizes = [1_000, 3_000, 10_000, 30_000, 100_000];
    let implicit = Method::ImplicitEuler(Newton {
        iterations: 1,
        tolerance: 1e-2,
        must_converge: false,
    });
    let titles = [
        "broad",
        "narrow",
        "step, nothing touched",
        "step",
        "search in it",
        "response",
    ];
    for (with, name) in [
        (
            With::Layer,
            "Two layers, face to face: what touches grows with them",
        ),
        (
            With::Tool,
            "A layer and a tool of four capsules: what touches stays",
        ),
    ] {
        let few: Vec<usize> = sizes.into_iter().filter(|s| *s <= IMPLICIT).collect();
        for (method, of, sizes) in [
            (Method::StoermerVerlet, "Störmer–Verlet", &sizes[..]),
            (implicit, "backward Euler, 1 iteration", &few[..]),
        ] {
            let _ = writeln!(text, "\n**{name}; {of}**\n");
            table(text, &titles, &rows(with, method, sizes));
        }
    }
    Ok(())
}
