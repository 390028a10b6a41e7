//! Times of ordering, analysis, factorisation, solution and product on grids with the edges of six tetrahedra per cell.
//!
//! `cargo run --release -p microsim-sparse --example bench_sparse [repetitions]`; the fastest repetition counts.

use std::sync::Arc;
use std::time::Instant;

use microsim_sparse::{BlockMatrix, Factor, Ordering, Pattern, Real, Symbolic};
use nalgebra::{Matrix3, Vector3};

fn main() {
    let repetitions = std::env::args()
        .nth(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(5);
    println!(
        "grid  nodes fronts  entries    MFLOP  order  analyse factorise GFLOP/s  solve product [ms]"
    );
    for (name, size) in [("S", [16, 4, 4]), ("M", [36, 8, 8]), ("L", [61, 13, 13])] {
        bench::<f64>(name, size, repetitions);
        bench::<f32>(name, size, repetitions);
    }
}

fn bench<T: Real>(name: &str, size: [usize; 3], repetitions: usize) {
    let (positions, cells) = kuhn_grid(size);
    let nodes = positions.len();
    let pattern = Arc::new(Pattern::from_cliques(nodes, &cells));
    let mut matrix = BlockMatrix::zeros(pattern.clone());
    for cell in &cells {
        for (k, &i) in cell.iter().enumerate() {
            for &j in &cell[..k] {
                let along = positions[i as usize] - positions[j as usize];
                let block = along * along.transpose() + Matrix3::identity() * 0.1;
                matrix.add(i as usize, j as usize, &-block);
                matrix.add_diagonal(i as usize, &block);
                matrix.add_diagonal(j as usize, &block);
            }
        }
    }
    let fixed: Vec<bool> = positions.iter().map(|position| position.x == 0.0).collect();

    let (order, ordering) = fastest(repetitions, || {
        Ordering::nested_dissection(&pattern, Some(&positions))
    });
    let (analyse, symbolic) = fastest(repetitions, || {
        Arc::new(Symbolic::analyse(&pattern, &ordering))
    });
    let mut factor = Factor::<T>::new(symbolic.clone());
    let (factorise, outcome) = fastest(repetitions, || factor.factorise(&matrix, Some(&fixed)));
    outcome.expect("a beam held at one end");
    let load: Vec<Vector3<f64>> = fixed
        .iter()
        .map(|&fixed| {
            if fixed {
                Vector3::zeros()
            } else {
                -Vector3::z()
            }
        })
        .collect();
    let (solve, x) = fastest(repetitions, || {
        let mut x = load.clone();
        factor.solve(&mut x);
        x
    });
    let mut product = vec![Vector3::zeros(); nodes];
    let (multiply, ()) = fastest(repetitions, || matrix.multiply(&x, &mut product));
    let residual = (0..nodes)
        .filter(|&i| !fixed[i])
        .map(|i| (product[i] - load[i]).norm())
        .fold(0.0, f64::max);
    println!(
        "{name:4} {nodes:6} {:6} {:8} {:8.1} {order:6.2} {analyse:8.2} {factorise:9.2} {:7.1} {solve:6.2} {multiply:7.3}  residual {residual:.0e}",
        symbolic.fronts(),
        symbolic.factor_entries(),
        symbolic.flops() / 1e6,
        symbolic.flops() / factorise / 1e6,
    );
}

/// Milliseconds of the fastest run, and its last result.
fn fastest<T>(repetitions: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let mut timed = || {
        let start = Instant::now();
        let result = run();
        (start.elapsed().as_secs_f64() * 1e3, result)
    };
    let (mut best, mut result) = timed();
    for _ in 1..repetitions {
        let (time, next) = timed();
        best = best.min(time);
        result = next;
    }
    (best, result)
}

/// Nodes on a grid of unit cells, first axis slowest, and the six tetrahedra of each cell.
fn kuhn_grid(size: [usize; 3]) -> (Vec<Vector3<f64>>, Vec<[u32; 4]>) {
    let node = |at: [usize; 3]| ((at[0] * size[1] + at[1]) * size[2] + at[2]) as u32;
    let mut positions = Vec::new();
    let mut cells = Vec::new();
    for x in 0..size[0] {
        for y in 0..size[1] {
            for z in 0..size[2] {
                positions.push(Vector3::new(x as f64, y as f64, z as f64));
                if x + 1 == size[0] || y + 1 == size[1] || z + 1 == size[2] {
                    continue;
                }
                // One tetrahedron per order of the axes: from one corner to the opposite one along three edges.
                for axes in [
                    [0, 1, 2],
                    [0, 2, 1],
                    [1, 0, 2],
                    [1, 2, 0],
                    [2, 0, 1],
                    [2, 1, 0],
                ] {
                    let mut at = [x, y, z];
                    cells.push(std::array::from_fn(|k| {
                        if k > 0 {
                            at[axes[k - 1]] += 1;
                        }
                        node(at)
                    }));
                }
            }
        }
    }
    (positions, cells)
}
