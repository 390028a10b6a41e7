use nalgebra::Matrix3;

use super::*;
use crate::testing::{bits, elastic, grid, vectors};
use microsim_random::Congruential;

/// A block of elastic cells and its nodes at x = 0.
fn held(size: [usize; 3]) -> (BlockMatrix, Vec<Vector3<f64>>, Vec<bool>) {
    let (positions, edges) = grid(size);
    let fixed = positions.iter().map(|position| position.x == 0.0).collect();
    (elastic(&positions, &edges), positions, fixed)
}

/// |b − A x| / |b| over the nodes that are not fixed.
fn residual(matrix: &BlockMatrix, fixed: &[bool], x: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let mut free = x.to_vec();
    let mut product = x.to_vec();
    free.iter_mut()
        .zip(fixed)
        .filter(|(_, fixed)| **fixed)
        .for_each(|(x, _)| *x = Vector3::zeros());
    matrix.multiply(&free, &mut product);
    let (mut left, mut size) = (0.0, 0.0);
    for node in (0..b.len()).filter(|&node| !fixed[node]) {
        left += (b[node] - product[node]).norm_squared();
        size += b[node].norm_squared();
    }
    (left / size).sqrt()
}

/// The first method of small and slender bodies is a factor, of large solid ones two levels; both reach the tolerance and leave fixed
/// nodes as they are.
#[test]
fn each_way_solves() {
    for (size, method) in [
        ([4, 4, 4], Method::FactorF32),
        ([400, 3, 3], Method::FactorF32),
        ([16, 16, 16], Method::TwoLevel),
    ] {
        let (matrix, positions, fixed) = held(size);
        let mut solver = LinearSolver::new(matrix.pattern(), &positions);
        assert_eq!(solver.first, method, "{size:?}");
        let b = vectors(&mut Congruential(51), positions.len());
        for tolerance in [1e-3, 1e-9] {
            solver.factorise(&matrix, &fixed).unwrap();
            let mut x = b.clone();
            solver.solve(&matrix, &mut x, tolerance).unwrap();
            assert!(residual(&matrix, &fixed, &x, &b) <= 1.01 * tolerance);
            let fixed_nodes = (0..b.len()).filter(|&node| fixed[node]);
            assert!(fixed_nodes.into_iter().all(|node| x[node] == b[node]));
        }
    }
}

/// Stiffness of 10⁹ along a chain and 1 across is beyond the precision of f32: the last method takes it.
#[test]
fn the_surer_way_follows() {
    let positions: Vec<_> = (0..200).map(|k| Vector3::x() * f64::from(k)).collect();
    let edges: Vec<[u32; 2]> = (0..199).map(|k| [k, k + 1]).collect();
    let mut matrix = BlockMatrix::zeros(Arc::new(Pattern::from_cliques(200, &edges)));
    for (k, edge) in edges.iter().enumerate() {
        let [i, j] = edge.map(|node| node as usize);
        let stiffness = if k % 2 == 0 { 1e9 } else { 1.0 };
        let block = Matrix3::from_diagonal_element(stiffness);
        matrix.add_diagonal(i, &block);
        matrix.add_diagonal(j, &block);
        matrix.add(i, j, &-block);
    }
    let fixed: Vec<bool> = (0..200).map(|node| node == 0).collect();
    let b = vectors(&mut Congruential(52), 200);
    let mut solver = LinearSolver::new(matrix.pattern(), &positions);
    solver.factorise(&matrix, &fixed).unwrap();
    let mut x = b.clone();
    solver.solve(&matrix, &mut x, 1e-10).unwrap();
    assert_eq!(solver.method, Method::FactorF64);
    // Forces from the free end sum up along the soft springs: the closed form. 200² ε of the stiffest, over the softest.
    let mut expected = Vector3::zeros();
    let mut pull: Vector3<f64> = b[1..].iter().sum();
    for (k, x) in x[1..].iter().enumerate() {
        expected += pull / if k % 2 == 0 { 1e9 } else { 1.0 };
        pull -= b[k + 1];
        assert!(
            (x - expected).norm() <= 1e-2 * expected.norm().max(1.0),
            "{k}"
        );
    }
}

/// Nodes whose stiffness differs by up to 10⁸ without order: no lattice sees that, and the factor takes it.
#[test]
fn a_factor_follows_two_levels() {
    let (mut matrix, positions, fixed) = held([16, 16, 16]);
    let mut random = Congruential(55);
    let scales: Vec<f64> = positions
        .iter()
        .map(|_| 10f64.powi(random.below(5) as i32))
        .collect();
    for i in 0..positions.len() {
        for k in 0..matrix.pattern().row(i).len() {
            let j = matrix.pattern().row(i)[k] as usize;
            let slot = matrix.pattern().first_slot(i) + k;
            matrix.values_mut()[slot] *= scales[i] * scales[j];
        }
    }
    let mut solver = LinearSolver::new(matrix.pattern(), &positions);
    assert_eq!(solver.first, Method::TwoLevel);
    let b = vectors(&mut random, positions.len());
    let mut x = b.clone();
    solver.factorise(&matrix, &fixed).unwrap();
    solver.solve(&matrix, &mut x, 1e-9).unwrap();
    assert!(solver.method > Method::TwoLevel);
    assert!(residual(&matrix, &fixed, &x, &b) <= 1.01e-9);
}

/// Nothing of a system is left for the next one, nor for a clone.
#[test]
fn same_numbers_same_bits() {
    let (matrix, positions, fixed) = held([14, 14, 14]);
    let mut solver = LinearSolver::new(matrix.pattern(), &positions);
    let b = vectors(&mut Congruential(53), positions.len());
    let run = |solver: &mut LinearSolver, matrix: &BlockMatrix| {
        let mut x = b.clone();
        solver.factorise(matrix, &fixed).unwrap();
        solver.solve(matrix, &mut x, 1e-6).unwrap();
        bits(&x)
    };
    let first = run(&mut solver, &matrix);
    let mut other = matrix.clone();
    other.add_diagonal(b.len() / 2, &Matrix3::identity());
    assert!(run(&mut solver, &other) != first);
    assert!(run(&mut solver.clone(), &matrix) == first);
    assert!(run(&mut solver, &matrix) == first);
}

/// A body that was large enough for two levels retains this method when a cut leaves less of it, and solves to the tolerance, by the methods
/// after it as well; one that was small gets the method of what it has become. Bodies between do not matter.
#[test]
fn another_pattern_is_followed() {
    let (large, small) = (held([16, 16, 16]), held([4, 4, 4]));
    let of = |(matrix, positions, _): &(BlockMatrix, Vec<_>, _)| {
        LinearSolver::new(matrix.pattern(), positions)
    };
    let check = |solver: &mut LinearSolver, to: &(BlockMatrix, Vec<_>, Vec<bool>), method| {
        let (matrix, positions, fixed) = to;
        *solver = solver.following(matrix.pattern(), positions);
        assert_eq!(solver.first, method);
        let b = vectors(&mut Congruential(57), positions.len());
        [method, Method::FactorF32, Method::FactorF64].map(|method| {
            let mut x = b.clone();
            solver.factorise(matrix, fixed).unwrap();
            solver.prepare(matrix, method).unwrap();
            solver.solve(matrix, &mut x, 1e-9).unwrap();
            assert!(residual(matrix, fixed, &x, &b) <= 1.01e-9);
            bits(&x)
        })
    };
    let mut was_large = of(&large);
    let first = check(&mut was_large, &small, Method::TwoLevel);
    check(&mut was_large, &large, Method::TwoLevel);
    assert!(check(&mut was_large.clone(), &small, Method::TwoLevel) == first);
    let mut was_small = of(&small);
    let first = check(&mut was_small, &small, Method::FactorF32);
    check(&mut was_small, &large, Method::TwoLevel);
    assert!(check(&mut was_small, &small, Method::FactorF32) == first);
}

#[test]
fn an_indefinite_matrix_is_refused() {
    for (size, method) in [
        ([4, 4, 4], Method::FactorF32),
        ([16, 16, 16], Method::TwoLevel),
    ] {
        let (mut matrix, positions, fixed) = held(size);
        // A shift that leaves every diagonal block positive and the lowest modes negative.
        for node in 0..positions.len() {
            matrix.add_diagonal(node, &Matrix3::from_diagonal_element(-0.3));
        }
        let mut solver = LinearSolver::new(matrix.pattern(), &positions);
        assert_eq!(solver.first, method);
        let b = vectors(&mut Congruential(54), positions.len());
        let mut x = b.clone();
        let refused = solver
            .factorise(&matrix, &fixed)
            .and_then(|()| solver.solve(&matrix, &mut x, 1e-9));
        assert!(refused.is_err());
        assert_eq!(x, b);
    }
}

/// An f64 factor solves to rounding, whatever tolerance is asked for, for bodies small enough to have it each time.
#[test]
fn a_small_body_has_a_factor_of_double_numbers() {
    for (size, small) in [
        ([4, 4, 4], true),
        ([400, 3, 3], false),
        ([16, 16, 16], false),
    ] {
        let (matrix, positions, _) = held(size);
        let solver = LinearSolver::new(matrix.pattern(), &positions);
        assert_eq!(solver.is_small(), small, "{size:?}");
    }
    let (matrix, positions, fixed) = held([4, 4, 4]);
    let mut solver = LinearSolver::new(matrix.pattern(), &positions);
    let b = vectors(&mut Congruential(58), positions.len());
    let mut x = b.clone();
    solver.factorise_f64(&matrix, &fixed).unwrap();
    solver.solve(&matrix, &mut x, 0.1).unwrap();
    // Condition 1e3 at most for a few cells along, times the rounding of a hundred sums.
    assert!(residual(&matrix, &fixed, &x, &b) <= 1e-11);
}
