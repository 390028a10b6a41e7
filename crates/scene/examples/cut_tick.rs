//! What a step of a cut costs, all that follows it included, over the size of the body: `cargo run --release -p microsim-scene --example
//! cut_tick`. A blade goes through a block on a table in contact, so far per tick that it divides about 60 elements; the CPU time of a tick is
//! compared with that of the same tick without the blade.

use microsim_scene::*;
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};
use nalgebra::Vector3;
use rustix::time::{ClockId, clock_gettime};

fn main() {
    println!(
        "tetrahedra  cuts  divided (most)  tick [ms]  cut p50 [ms]  cut p99 [ms]  both p50 [ms]  both p99 [ms]"
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
            measure(cells);
        }
    }
}

/// Length of the blade, and how far it goes in a tick [cells]: it then divides 60 elements in a tick at most, whatever the size of the body.
const WIDTH: f64 = 8.0;
const WAY: f64 = 0.25;

/// The blade goes down in the middle, and so often on each side of it, a cell further each time.
const PASSES: i32 = 1;

/// Ticks without the blade before each cut, and as many after it.
const REST: usize = 5;

/// CPU time of this process [s].
fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fn measure(cells: [usize; 3]) {
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
    let spec = SceneSpec {
        bodies: vec![BodySpec {
            name: "block".into(),
            mesh,
            origin: [0.0; 3],
            materials: vec![(
                0,
                Material {
                    density: 1060.0,
                    relaxation_time: 0.0,
                    behaviour: Behaviour::Continuum(ContinuumConstants {
                        law: LawName::StableNeoHookean,
                        young: 40e3,
                        poisson: 0.4,
                        discretisation: Discretisation::EdgeSmoothed,
                    }),
                },
            )],
            drag: 20.0,
            toughness: f64::INFINITY,
            brittleness: 0.0,
            tear_strains: Vec::new(),
            clamps: Vec::new(),
            couplings: Vec::new(),
            loads: Vec::new(),
            start: Vec::new(),
            ends: Vec::new(),
        }],
        tools: vec![ToolSpec {
            name: "blade".into(),
            capsules: vec![CapsuleSpec {
                a: [0.0, -0.5 * WIDTH * edge, 0.0],
                b: [0.0, 0.5 * WIDTH * edge, 0.0],
                radius: 5e-5,
                hinge: None,
                jaw: None,
                lonor: true,
                edge: None,
            }],
            sharpness: 0.0,
            motion: Vec::new(),
        }],
        rigid: vec![RigidSpec {
            name: "table".into(),
            parts: vec![Rigid {
                shape: RigidShape::HalfSpace,
                pose: Pose {
                    position: Vector3::new(0.0, 0.0, -0.5 * size[2]),
                    ..Pose::identity()
                },
            }],
        }],
        contacts: vec![ContactSpec {
            body: "block".into(),
            with: PartnerSpec::Rigid("table".into()),
            friction: 0.3,
            force_limit: f64::INFINITY,
        }],
        cuts: vec![CutSpec {
            body: "block".into(),
            tool: "blade".into(),
        }],
        gravity: [0.0; 3],
        method: Method::StoermerVerlet,
        containment: false,
    };
    let mut scene = Scene::new(&spec).expect("a scene");
    let tick = 5e-6;
    let way = WAY * edge;
    let top = 0.5 * size[2] + 0.5 * way;
    let (mut rest, mut both, mut cut, mut touched) = (vec![], vec![], vec![], vec![]);
    let ticks = (size[2] / way) as usize + 1;
    for pass in -PASSES..=PASSES {
        let at = |z: f64| Pose {
            position: Vector3::new((0.13 + f64::from(pass)) * edge, 0.0, z),
            ..Pose::identity()
        };
        // Without the blade before and after, as the body grows by the cut.
        let (mut without, mut with) = (Vec::new(), Vec::new());
        for k in 0..2 * REST + ticks {
            let cutting = (REST..REST + ticks).contains(&k);
            let before = top - k.saturating_sub(REST) as f64 * way;
            let motion = cutting.then(|| ToolMotion {
                tool: 0,
                from: at(before),
                to: at(before - way),
                opening_from: 0.0,
                opening_to: 0.0,
                active: true,
            });
            let start = cpu();
            let report = scene.tick(motion.as_slice(), tick, 1, &Serial);
            let time = (cpu() - start) * 1e3;
            let cuts = report.expect("a tick").cuts;
            let divided: usize = cuts.iter().map(|cut| cut.divided).sum();
            if !cutting {
                without.push(time);
            } else if divided > 0 {
                with.push(time);
                touched.push(divided as f64);
            }
        }
        without.sort_by(f64::total_cmp);
        let tick = share(&without, 0.5);
        rest.push(tick);
        // What the edit and all that follows it cost beyond the tick.
        cut.extend(with.iter().map(|time| time - tick));
        both.extend(with);
    }
    for times in [&mut rest, &mut cut, &mut both] {
        times.sort_by(f64::total_cmp);
    }
    let most = touched.iter().copied().fold(0.0, f64::max);
    let mean = touched.iter().sum::<f64>() / touched.len() as f64;
    println!(
        "{elements:10} {:5} {mean:8.0} {most:7} {:13.2} {:13.2} {:13.2} {:13.2} {:13.2}",
        cut.len(),
        share(&rest, 0.5),
        share(&cut, 0.5),
        share(&cut, 0.99),
        share(&both, 0.5),
        share(&both, 0.99),
    );
}

/// The time that so large a share of sorted times does not exceed.
fn share(times: &[f64], share: f64) -> f64 {
    times[((times.len() - 1) as f64 * share).round() as usize]
}
