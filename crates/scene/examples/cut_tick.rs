//! What a step of a cut costs, all that follows it included, over the size of the body: `cargo run --release -p microsim-scene --example
//! cut_tick`. A blade goes through a block on a table in contact, so far per tick that it divides about 60 elements; the CPU time of a tick is
//! compared with that of ticks in which it stands. The blade is an edge that touches the block, and cuts what it has pressed on, as in a level;
//! the block may touch itself too; or the blade is one that touches nothing.

use microsim_scene::*;
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};
use nalgebra::Vector3;
use rustix::time::{ClockId, clock_gettime};

fn main() {
    println!(
        "contact         tetrahedra  ticks  divided (most)  tick [ms]  cut p50 [ms]  p99  (median of runs)  both p50 [ms]  p99  (median of runs)"
    );
    let bodies = [
        [5, 6, 6],
        [8, 10, 8],
        [12, 12, 12],
        [20, 20, 18],
        [34, 26, 20],
    ];
    // One of them alone, to look where its time goes.
    let only = std::env::args().nth(1).and_then(|only| only.parse().ok());
    for (index, cells) in bodies.into_iter().enumerate() {
        if only.is_none_or(|only: usize| only == index) {
            for touches in [Touches::Tool, Touches::ToolAndItself, Touches::Table] {
                measure(cells, touches);
            }
        }
    }
}

/// What is in contact beside the block and the table.
#[derive(Clone, Copy, PartialEq)]
enum Touches {
    /// The blade, which is an edge.
    Tool,
    /// The blade, and the block itself.
    ToolAndItself,
    /// Nothing else.
    Table,
}

/// Length of the blade, and how far it goes in a tick \[cells\]: it then divides 60 elements in a tick at most, whatever the size of the body.
const WIDTH: f64 = 8.0;
const SPACING: f64 = 0.25;

/// The blade goes down in the middle, and so often on each side of it, a cell further each time.
const PASSES: i32 = 1;

/// Ticks without the blade before each cut, and as many after it.
const REST: usize = 5;

/// The same is run so often. Of each tick the fastest counts: what else runs on the machine is not what is measured; beside it stands the 99th of
/// a hundred of a single run, the middle one of all runs.
const RUNS: usize = 3;

/// A tick \[s\].
const TICK: f64 = 5e-6;

/// CPU time of this process \[s\].
fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fn measure(cells: [usize; 3], touches: Touches) {
    let edge = 0.3e-3;
    let size = cells.map(|n| n as f64 * edge);
    let block = microsim_mesh::Block {
        center: [0.0; 3],
        size,
        cells,
        split: microsim_mesh::CellSplit::Kuhn,
    };
    let mesh = block.mesh().expect("a block");
    let elements = mesh.tets.len();
    let contact = |with| ContactSpec {
        friction: 0.3,
        ..ContactSpec::new("block", with)
    };
    let mut contacts = vec![contact(PartnerSpec::Obstacle("table".into()))];
    if touches != Touches::Table {
        contacts.push(contact(PartnerSpec::Tool("blade".into())));
    }
    if touches == Touches::ToolAndItself {
        contacts.push(contact(PartnerSpec::Itself));
    }
    let spec = SceneSpec {
        bodies: vec![BodySpec {
            drag: 20.0,
            // Any force cuts it: from the first touch on the blade cuts all that it meets.
            toughness: 1e-6,
            ..BodySpec::new(
                "block",
                mesh,
                Material {
                    density: 1060.0,
                    relaxation_time: 0.0,
                    behaviour: Behaviour::Continuum(ContinuumConstants {
                        law: LawName::StableNeoHookean.into(),
                        young: 40e3,
                        poisson: 0.4,
                        discretisation: Discretisation::EdgeSmoothed,
                        plasticity: None,
                    }),
                },
            )
        }],
        tools: vec![ToolSpec {
            name: "blade".into(),
            capsules: vec![CapsuleSpec {
                lonor: true,
                edge: (touches != Touches::Table).then_some([0.0, 0.0, -1.0]),
                // As thick as a cell, so that its path in a tick is one step of the solver.
                ..CapsuleSpec::new(
                    [0.0, -0.5 * WIDTH * edge, 0.0],
                    [0.0, 0.5 * WIDTH * edge, 0.0],
                    1.1 * edge,
                )
            }],
            sharpness: 1.0,
            jaw_stiffness: f64::INFINITY,
            irrigation: None,
            motion: Vec::new(),
        }],
        obstacles: vec![ObstacleSpec {
            name: "table".into(),
            parts: vec![ObstaclePart {
                shape: ObstacleShape::HalfSpace,
                pose: Pose {
                    position: Vector3::new(0.0, 0.0, -0.5 * size[2]),
                    ..Pose::identity()
                },
            }],
        }],
        contacts,
        cuts: vec![CutSpec::new("block", "blade")],
        gravity: [0.0; 3],
        containment: false,
        repeat_unconverged: false,
        ..SceneSpec::new(Vec::new(), Method::StoermerVerlet)
    };
    let runs: Vec<Vec<Tick>> = (0..RUNS)
        .map(|_| run(&spec, edge, size[2], touches))
        .collect();
    // The same ticks in each run, to the bit.
    let fastest = runs[0].iter().enumerate().map(|(index, tick)| Tick {
        time: runs
            .iter()
            .map(|run| run[index].time)
            .fold(f64::INFINITY, f64::min),
        ..*tick
    });
    let Times { rest, cut, both } = times(&fastest.collect::<Vec<_>>());
    let single: Vec<Times> = runs.iter().map(|run| times(run)).collect();
    let median = |of: fn(&Times) -> &[f64]| {
        let mut all: Vec<f64> = single
            .iter()
            .map(|times| percentile(of(times), 0.99))
            .collect();
        all.sort_by(f64::total_cmp);
        all[RUNS / 2]
    };
    let divided = runs[0].iter().map(|tick| tick.divided);
    let (most, sum) = divided.fold((0, 0), |(most, sum), n| (most.max(n), sum + n));
    let mean = sum as f64 / cut.len() as f64;
    let name = match touches {
        Touches::Tool => "tool, table",
        Touches::ToolAndItself => "and itself",
        Touches::Table => "table alone",
    };
    println!(
        "{name:15} {elements:10} {:6} {mean:8.0} {most:7} {:10.2} {:13.2} {:4.2} {:17.2} {:14.2} {:4.2} {:17.2}",
        cut.len(),
        percentile(&rest, 0.5),
        percentile(&cut, 0.5),
        percentile(&cut, 0.99),
        median(|times| &times.cut),
        percentile(&both, 0.5),
        percentile(&both, 0.99),
        median(|times| &times.both),
    );
}

/// Times \[ms\], ascending: of ticks without a cut, what a cut costs beyond those, and ticks with it.
struct Times {
    rest: Vec<f64>,
    cut: Vec<f64>,
    both: Vec<f64>,
}

fn times(ticks: &[Tick]) -> Times {
    let (mut rest, mut both, mut cut) = (vec![], vec![], vec![]);
    for pass in ticks.chunk_by(|a, b| a.pass == b.pass) {
        let without = pass.iter().filter(|tick| !tick.cuts);
        let mut without: Vec<f64> = without.map(|tick| tick.time).collect();
        without.sort_by(f64::total_cmp);
        let tick = percentile(&without, 0.5);
        rest.push(tick);
        for with in pass.iter().filter(|tick| tick.divided > 0) {
            both.push(with.time);
            // What the edit and all that follows it cost beyond the tick.
            cut.push(with.time - tick);
        }
    }
    for times in [&mut rest, &mut cut, &mut both] {
        times.sort_by(f64::total_cmp);
    }
    Times { rest, cut, both }
}

/// A tick.
#[derive(Clone, Copy)]
struct Tick {
    pass: i32,
    /// Whether the blade goes down.
    cuts: bool,
    /// Elements divided, whether anything was opened or not.
    divided: u64,
    /// CPU time \[ms\].
    time: f64,
}

/// All ticks of a body with cells of this edge and so high \[m\].
fn run(spec: &SceneSpec, edge: f64, height: f64, touches: Touches) -> Vec<Tick> {
    let mut scene = Scene::new(spec).expect("a scene");
    let spacing = SPACING * edge;
    // One that touches begins where it does not, and cuts along its axis.
    let top = 0.5 * height
        + match touches {
            Touches::Table => 0.5 * spacing,
            _ => 1.5 * edge,
        };
    let ticks = ((0.5 * height + top) / spacing) as usize + 1;
    let mut all = Vec::new();
    for pass in -PASSES..=PASSES {
        let at = |z: f64| Pose {
            position: Vector3::new((0.13 + f64::from(pass)) * edge, 0.0, z),
            ..Pose::identity()
        };
        // Without a cut before and after, as the body grows by the cut: a blade that touches stands there, the other one is away.
        for k in 0..2 * REST + ticks {
            let cuts = (REST..REST + ticks).contains(&k);
            let before = top - k.saturating_sub(REST).min(ticks) as f64 * spacing;
            let spacing = if cuts { spacing } else { 0.0 };
            let there = cuts || touches != Touches::Table;
            let motion = there.then(|| ToolMotion {
                tool: 0,
                from: at(before),
                to: at(before - spacing),
                opening_from: 0.0,
                opening_to: 0.0,
                active: true,
            });
            let before = scene.body(0).cut_tally().divided;
            let start = cpu();
            let report = scene.tick(motion.as_slice(), TICK, 1, &Serial);
            let time = (cpu() - start) * 1e3;
            let substeps = report.expect("a tick").substeps;
            assert_eq!(substeps, 1, "a tick is one step");
            let divided = scene.body(0).cut_tally().divided - before;
            all.push(Tick {
                pass,
                cuts,
                divided,
                time,
            });
        }
    }
    all
}

/// A percentile of sorted times.
fn percentile(times: &[f64], fraction: f64) -> f64 {
    times[((times.len() - 1) as f64 * fraction).round() as usize]
}
