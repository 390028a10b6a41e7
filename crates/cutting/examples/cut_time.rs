//! What a step of a cut costs: CPU time of one core, against the size of the body, at about 60 elements touched.
//!
//! A blade three cells wide goes into a block from above, a third of a cell per step, again and again in other places. Timed are the
//! search for elements near the blade, which is all that a step does where nothing is cut; the whole of the step; and what
//! the mesh and what is stored by node and element do with the edit.
//!
//! `cargo run --release -p microsim-cutting --example cut_time`

use microsim_cutting::{Blade, Settings, Stroke, Sweep, Topology};
use microsim_mesh::{Block, CellSplit};
use microsim_random::SplitMix64;
use nalgebra::Vector3;
use rustix::time::{ClockId, clock_gettime};

type V3 = Vector3<f64>;

/// CPU time of this thread \[s\].
fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// A percentile of the sorted times, in microseconds.
fn at(times: &mut [f64], fraction: f64) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    let place = (fraction * times.len() as f64) as usize;
    times
        .get(place.min(times.len() - 1))
        .map_or(0.0, |t| t * 1e6)
}

fn main() {
    println!(
        "CPU time in microseconds: median, 99th of a hundred; steps of 40 to 60 elements divided.\n"
    );
    println!("elements | steps | divided | search      | cut         | apply       | cut + apply");
    for cells in [6, 8, 12, 17, 26] {
        measure(cells);
    }
}

fn measure(cells: usize) {
    let size = cells as f64;
    let block = Block {
        center: [0.0; 3],
        size: [size; 3],
        cells: [cells; 3],
        split: CellSplit::Kuhn,
    };
    let Ok(whole) = block.mesh() else { return };
    let mut random = SplitMix64(7);
    let (mut search, mut cuts, mut applied, mut both, mut divided) =
        (vec![], vec![], vec![], vec![], 0);
    for _ in 0..40 {
        let mut mesh = whole.clone();
        for p in &mut mesh.positions {
            *p += random.vector() * 0.1;
        }
        let mut topology = Topology::new(&mesh);
        let mut positions = mesh.positions.clone();
        let mut velocities = vec![V3::zeros(); positions.len()];
        let mut stroke = Stroke::new();
        let side = (random.vector() - V3::z() * 0.3)
            .cross(&V3::z())
            .normalize();
        let (spacing, width) = (0.35, 4.0);
        let foot = random.vector() * (0.5 * size - 2.5).max(0.0);
        let top = V3::new(foot.x, foot.y, 0.5 * size + 0.1 * random.below(6) as f64);
        let place = |k: usize| {
            let middle = top - V3::z() * (spacing * k as f64);
            [middle - side * (width / 2.0), middle + side * (width / 2.0)]
        };
        for k in 0..(4.0 / spacing) as usize {
            let sweep = Sweep {
                before: place(k),
                now: place(k + 1),
            };
            let outside = sweep.before.map(|p| p + V3::z() * (2.0 * size));
            let outside = Sweep {
                before: outside,
                now: outside,
            };
            let settings = Settings::default();
            let blade = |sweep| Blade::Sweep {
                sweeps: std::slice::from_ref(sweep),
                before: &positions,
                now: &positions,
            };
            let start = cpu();
            let nothing = topology.cut(&mesh, &mut Stroke::new(), &blade(&outside), &settings);
            let after_search = cpu();
            assert!(matches!(nothing, Ok(None)));
            let cut = topology.cut(&mesh, &mut stroke, &blade(&sweep), &settings);
            let after_cut = cpu();
            let Ok(Some(cut)) = cut else { continue };
            mesh.apply(&cut.edit).expect("an edit for this mesh");
            cut.edit.carry_nodes(&mut positions);
            cut.edit.carry_nodes(&mut velocities);
            let end = cpu();
            if (40..=60).contains(&cut.divided) {
                divided += cut.divided;
                search.push(after_search - start);
                cuts.push(after_cut - after_search);
                applied.push(end - after_cut);
                both.push(end - after_search);
            }
        }
    }
    if cuts.is_empty() {
        return println!("{}: no such step", whole.tets.len());
    }
    let count = cuts.len();
    let pair = |times: &mut Vec<f64>| format!("{:5.0} {:5.0}", at(times, 0.5), at(times, 0.99));
    println!(
        "{:8} | {count:5} | {:7} | {} | {} | {} | {}",
        whole.tets.len(),
        divided / count,
        pair(&mut search),
        pair(&mut cuts),
        pair(&mut applied),
        pair(&mut both),
    );
}
