//! The factor against dense Cholesky and against what must not have one.

use nalgebra::{DMatrix, DVector, Matrix3};

use super::*;
use crate::testing::{bits, dense, dense_vector, elastic, grid, random_matrix, vectors};
use crate::{Ordering, Pattern};
use microsim_random::Congruential;

fn factor(pattern: &Arc<Pattern>, ordering: &Ordering) -> Factor {
    Factor::new(Arc::new(Symbolic::analyse(pattern, ordering)))
}

fn orderings(pattern: &Pattern, positions: Option<&[Vector3<f64>]>) -> Vec<Ordering> {
    let mut backward: Vec<u32> = (0..pattern.nodes() as u32).collect();
    backward.reverse();
    vec![
        Ordering::natural(pattern.nodes()),
        Ordering::from_sequence(backward).unwrap(),
        Ordering::nested_dissection(pattern, None),
        Ordering::nested_dissection(pattern, positions),
    ]
}

/// Twice the bound of the relative error of a Cholesky solution, as both sides of a comparison have it: the backward
/// error of n unknowns is at most n (3n + 1) ε |A| (Higham 2002, theorem 10.4 with |L||Lᵀ| ≤ n |A|), the forward error
/// that times the condition number.
fn error_bound(dense: &DMatrix<f64>) -> f64 {
    let n = dense.nrows() as f64;
    let eigenvalues = dense.symmetric_eigenvalues();
    2.0 * n * (3.0 * n + 1.0) * f64::EPSILON * eigenvalues.max() / eigenvalues.min()
}

fn check(matrix: &BlockMatrix, ordering: &Ordering, rhs: &[Vector3<f64>]) {
    let dense = dense(matrix);
    let expected = dense.clone().cholesky().unwrap().solve(&dense_vector(rhs));
    let bound = error_bound(&dense);
    assert!(bound < 1e-3, "the bound is no bound: {bound}");
    let mut factor = factor(matrix.pattern(), ordering);
    factor.factorise(matrix, None).unwrap();
    let mut x = rhs.to_vec();
    factor.solve(&mut x);
    let error = (dense_vector(&x) - &expected).norm() / expected.norm();
    assert!(error <= bound, "{error} > {bound}");
}

#[test]
fn random_matrices_against_dense_cholesky() {
    let mut random = Congruential(11);
    // From separate nodes over sparse and disconnected to nearly full.
    for (nodes, cliques) in [
        (1, 1),
        (2, 0),
        (5, 3),
        (20, 12),
        (40, 40),
        (70, 70),
        (70, 400),
    ] {
        let matrix = random_matrix(&mut random, nodes, cliques, 0.1);
        let positions = vectors(&mut random, nodes);
        let rhs = vectors(&mut random, nodes);
        for ordering in orderings(matrix.pattern(), Some(&positions)) {
            check(&matrix, &ordering, &rhs);
        }
    }
}

#[test]
fn elastic_grids_against_dense_cholesky() {
    for size in [[12, 3, 2], [5, 5, 5], [90, 1, 1]] {
        let (positions, edges) = grid(size);
        let mut matrix = elastic(&positions, &edges);
        (0..positions.len()).for_each(|i| matrix.add_diagonal(i, &(Matrix3::identity() * 0.01)));
        let rhs = vectors(&mut Congruential(12), positions.len());
        for ordering in orderings(matrix.pattern(), Some(&positions)) {
            check(&matrix, &ordering, &rhs);
        }
    }
}

#[test]
fn a_clique_is_one_dense_front() {
    let all: Vec<u32> = (0..30).collect();
    let pattern = Arc::new(Pattern::from_cliques(30, [all]));
    let mut matrix = BlockMatrix::zeros(pattern.clone());
    let mut random = Congruential(13);
    for block in matrix.values_mut() {
        *block = Matrix3::from_fn(|_, _| random.number());
    }
    // Dominant diagonal: 90 numbers of magnitude at most 1 in a row.
    for i in 0..30 {
        let block = matrix.diagonal(i).symmetric_part();
        matrix.values_mut()[pattern.diagonal_slot(i)] = block + Matrix3::identity() * 91.0;
    }
    check(&matrix, &Ordering::natural(30), &vectors(&mut random, 30));
    let symbolic = Symbolic::analyse(&pattern, &Ordering::natural(30));
    // 90 columns in 12 strips of 8 (k + 1) columns and eight rows.
    assert_eq!(
        (symbolic.fronts(), symbolic.factor_entries()),
        (1, 64 * 12 * 13 / 2)
    );
    assert_eq!(symbolic.flops(), 90.0 * 90.0 * 90.0 / 3.0);
}

#[test]
fn no_nodes() {
    let pattern = Arc::new(Pattern::from_cliques(0, [[0_u32; 0]; 0]));
    let mut factor = factor(&pattern, &Ordering::nested_dissection(&pattern, Some(&[])));
    factor
        .factorise(&BlockMatrix::zeros(pattern), Some(&[]))
        .unwrap();
    factor.solve(&mut []);
}

#[test]
fn fixed_nodes_give_the_reduced_system() {
    let (positions, edges) = grid([7, 4, 3]);
    let matrix = elastic(&positions, &edges);
    let nodes = positions.len();
    let dense = dense(&matrix);
    let rhs = vectors(&mut Congruential(14), nodes);
    let mut random = Congruential(15);
    let one_end: Vec<bool> = positions.iter().map(|position| position.x == 0.0).collect();
    // A third of the nodes, at random: enough to hold a body of this size.
    let scattered: Vec<bool> = (0..nodes).map(|_| random.number() > 0.3).collect();
    for fixed in [one_end, scattered, vec![true; nodes]] {
        let free: Vec<usize> = (0..3 * nodes).filter(|k| !fixed[k / 3]).collect();
        let mut expected = dense_vector(&rhs);
        if !free.is_empty() {
            let reduced =
                DMatrix::from_fn(free.len(), free.len(), |i, j| dense[(free[i], free[j])]);
            let load = DVector::from_iterator(free.len(), free.iter().map(|&k| expected[k]));
            let bound = error_bound(&reduced);
            let solution = reduced.cholesky().unwrap().solve(&load);
            free.iter()
                .zip(solution.iter())
                .for_each(|(&k, value)| expected[k] = *value);
            assert!(bound < 1e-3);
            for ordering in orderings(matrix.pattern(), Some(&positions)) {
                let mut factor = factor(matrix.pattern(), &ordering);
                factor.factorise(&matrix, Some(&fixed)).unwrap();
                let mut x = rhs.clone();
                factor.solve(&mut x);
                for node in (0..nodes).filter(|&node| fixed[node]) {
                    assert_eq!(x[node], rhs[node], "a fixed node has its right-hand side");
                }
                assert!((dense_vector(&x) - &expected).norm() <= bound * expected.norm());
                // The same as constraining the matrix, to the bit.
                let mut constrained = matrix.clone();
                constrained.constrain(&fixed);
                factor.factorise(&constrained, None).unwrap();
                let mut again = rhs.clone();
                factor.solve(&mut again);
                assert_eq!(bits(&again), bits(&x));
            }
        } else {
            let mut factor = factor(matrix.pattern(), &Ordering::natural(nodes));
            factor
                .factorise(&BlockMatrix::zeros(matrix.pattern().clone()), Some(&fixed))
                .unwrap();
            let mut x = rhs.clone();
            factor.solve(&mut x);
            assert_eq!(x, rhs);
        }
    }
}

#[test]
fn a_bad_diagonal_block_is_named() {
    let mut random = Congruential(16);
    for bad in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        for node in [0, 7, 39] {
            // Elimination only ever lowers the pivots of later nodes, and the entry enters none but its own.
            let mut matrix = random_matrix(&mut random, 40, 60, 0.1);
            let slot = matrix.pattern().diagonal_slot(node);
            matrix.values_mut()[slot][(1, 1)] = bad;
            for ordering in orderings(matrix.pattern(), None) {
                let mut factor = factor(matrix.pattern(), &ordering);
                assert_eq!(
                    factor.factorise(&matrix, None),
                    Err(NotPositive { node }),
                    "{bad}"
                );
            }
        }
    }
}

#[test]
fn a_bad_coupling_is_noticed_at_its_later_node() {
    let (positions, edges) = grid([6, 4, 4]);
    let mut good = elastic(&positions, &edges);
    (0..positions.len()).for_each(|i| good.add_diagonal(i, &Matrix3::identity()));
    let mut random = Congruential(17);
    for bad in [f64::NAN, f64::INFINITY, 1e3, 1e200] {
        for _ in 0..10 {
            let [i, j] = edges[random.below(edges.len())].map(|node| node as usize);
            let mut matrix = good.clone();
            matrix.add(
                i,
                j,
                &Matrix3::from_fn(|r, c| if (r, c) == (2, 0) { bad } else { 0.0 }),
            );
            for ordering in orderings(matrix.pattern(), Some(&positions)) {
                let mut factor = factor(matrix.pattern(), &ordering);
                let sequence = factor.symbolic().sequence().to_vec();
                let place = |node: usize| {
                    sequence
                        .iter()
                        .position(|&other| other as usize == node)
                        .unwrap()
                };
                let later = if place(i) > place(j) { i } else { j };
                assert_eq!(
                    factor.factorise(&matrix, None),
                    Err(NotPositive { node: later }),
                    "{bad}"
                );
            }
        }
    }
}

#[test]
fn a_free_body_has_no_factor() {
    // Rigid translations cost nothing: the last pivots are zero up to rounding of either sign.
    for size in [[2, 1, 1], [5, 4, 3], [20, 4, 4], [9, 9, 9]] {
        let (positions, edges) = grid(size);
        let matrix = elastic(&positions, &edges);
        for ordering in orderings(matrix.pattern(), Some(&positions)) {
            let mut factor = factor(matrix.pattern(), &ordering);
            let last = *factor.symbolic().sequence().last().unwrap() as usize;
            assert_eq!(
                factor.factorise(&matrix, None),
                Err(NotPositive { node: last }),
                "{size:?}"
            );
        }
    }
}

#[test]
#[should_panic(expected = "factorised before")]
fn no_solution_after_a_failure() {
    let pattern = Arc::new(Pattern::from_cliques(1, [[0_u32; 0]; 0]));
    let mut factor = factor(&pattern, &Ordering::natural(1));
    factor
        .factorise(&BlockMatrix::zeros(pattern.clone()), Some(&[true]))
        .unwrap();
    factor
        .factorise(&BlockMatrix::zeros(pattern), None)
        .unwrap_err();
    factor.solve(&mut [Vector3::zeros()]);
}

#[test]
fn a_factor_of_single_numbers_is_a_good_preconditioner() {
    let (positions, edges) = grid([14, 5, 5]);
    let fixed: Vec<bool> = positions.iter().map(|position| position.x == 0.0).collect();
    let mut matrix = elastic(&positions, &edges);
    matrix.constrain(&fixed);
    let b = vectors(&mut Congruential(19), positions.len());
    let ordering = Ordering::nested_dissection(matrix.pattern(), Some(&positions));
    let mut factor = Factor::<f32>::new(Arc::new(Symbolic::analyse(matrix.pattern(), &ordering)));
    factor.factorise(&matrix, None).unwrap();
    let eigenvalues = dense(&matrix).symmetric_eigenvalues();
    let condition = eigenvalues.max() / eigenvalues.min();
    let mut x = b.clone();
    factor.solve(&mut x);
    let mut y = x.clone();
    matrix.multiply(&x, &mut y);
    let residual: f64 = y.iter().zip(&b).map(|(y, b)| (y - b).norm_squared()).sum();
    let size: f64 = b.iter().map(|b| b.norm_squared()).sum();
    // Each iteration leaves at most ε of f32 times the condition number of the error before, times a few.
    let rate = 8.0 * condition * f64::from(f32::EPSILON);
    assert!(rate < 0.05, "the bound is no bound: {rate}");
    assert!((residual / size).sqrt() < rate);
    let outcome = crate::ConjugateGradients::new(b.len()).solve(
        |x, y| matrix.multiply(x, y),
        |r, z| {
            z.copy_from_slice(r);
            factor.solve(z);
        },
        &b,
        &mut x,
        1e-12,
        12,
    );
    assert!(outcome.converged, "{outcome:?}");
}

#[test]
fn the_same_bits_every_time() {
    let (positions, edges) = grid([14, 5, 5]);
    let fixed: Vec<bool> = positions.iter().map(|position| position.x == 0.0).collect();
    let matrix = elastic(&positions, &edges);
    let rhs = vectors(&mut Congruential(18), positions.len());
    let ordering = Ordering::nested_dissection(matrix.pattern(), Some(&positions));
    let mut factor = factor(matrix.pattern(), &ordering);
    let solve = |factor: &mut Factor| {
        factor.factorise(&matrix, Some(&fixed)).unwrap();
        let mut x = rhs.clone();
        factor.solve(&mut x);
        bits(&x)
    };
    let first = solve(&mut factor);
    // Again, after a failure in between (which leaves not-a-numbers behind), and with new storage.
    assert_eq!(solve(&mut factor), first);
    let mut bad = matrix.clone();
    bad.values_mut().fill(Matrix3::from_element(f64::NAN));
    factor.factorise(&bad, None).unwrap_err();
    assert_eq!(solve(&mut factor), first);
    assert_eq!(
        solve(&mut Factor::<f64>::new(factor.symbolic().clone())),
        first
    );
}

#[test]
fn a_chain_has_no_filling() {
    // Eliminated from one end, each run of nodes updates the one node behind it, however runs are merged.
    let edges: Vec<[u32; 2]> = (0..99).map(|k| [k, k + 1]).collect();
    let pattern = Arc::new(Pattern::from_cliques(100, &edges));
    let symbolic = Symbolic::analyse(&pattern, &Ordering::natural(100));
    let covered: usize = symbolic
        .fronts
        .iter()
        .map(|front| front.columns.len())
        .sum();
    assert_eq!(covered, 100);
    assert!(symbolic.fronts.iter().all(|front| front.rows.len() <= 1));
    assert_eq!(symbolic.rows.len(), symbolic.fronts.len() - 1);
}

#[test]
fn compliance_is_that_of_the_dense_inverse() {
    let (positions, edges) = grid([5, 3, 3]);
    let mut matrix = elastic(&positions, &edges);
    let nodes = positions.len();
    let fixed: Vec<bool> = positions.iter().map(|position| position.x == 0.0).collect();
    let mut random = Congruential(31);
    // More than two strips of eight; among the nodes fixed ones, and the same one twice.
    let rows: Vec<[(u32, Vector3<f64>); 4]> = (0..19)
        .map(|_| std::array::from_fn(|_| (random.below(nodes) as u32, random.vector())))
        .collect();
    let mut factor = factor(
        matrix.pattern(),
        &Ordering::nested_dissection(matrix.pattern(), Some(&positions)),
    );
    factor.factorise(&matrix, Some(&fixed)).unwrap();
    let mut compliance = Vec::new();
    factor.set_compliance(&rows, &fixed, &mut compliance);
    matrix.constrain(&fixed);
    let dense = dense(&matrix);
    let mut transposed = DMatrix::zeros(3 * nodes, rows.len());
    for (column, row) in rows.iter().enumerate() {
        for (node, vector) in row.iter().filter(|(node, _)| !fixed[*node as usize]) {
            for a in 0..3 {
                transposed[(3 * *node as usize + a, column)] += vector[a];
            }
        }
    }
    let expected = transposed.transpose() * dense.clone().cholesky().unwrap().solve(&transposed);
    let found = DMatrix::from_row_slice(rows.len(), rows.len(), &compliance);
    let bound = error_bound(&dense);
    assert!((found - &expected).norm() <= bound * expected.norm());
}

/// Rows that join, that change and that go, one by one and many at once: always the bits of a factor that has not seen any before.
#[test]
fn compliance_of_more_rows_is_that_of_all_at_once() {
    let mut random = Congruential(77);
    let matrix = random_matrix(&mut random, 40, 120, 0.5);
    let pattern = matrix.pattern().clone();
    let ordering = Ordering::nested_dissection(&pattern, None);
    let fixed: Vec<bool> = (0..40).map(|node| node % 7 == 0).collect();
    let mut of_all = factor(&pattern, &ordering);
    of_all.factorise(&matrix, Some(&fixed)).unwrap();
    let mut row = || -> [(u32, Vector3<f64>); 4] {
        std::array::from_fn(|_| (random.below(40) as u32, random.vector()))
    };
    let mut rows: Vec<_> = (0..5).map(|_| row()).collect();
    let mut known = Vec::new();
    for (remain, join) in [
        (5, 0),
        (5, 3),
        (8, 0),
        (8, 9),
        (17, 1),
        (12, 7),
        (3, 0),
        (3, 21),
    ] {
        rows.truncate(remain);
        rows.extend((0..join).map(|_| row()));
        let mut found = Vec::new();
        known.push(of_all.set_compliance(&rows, &fixed, &mut found));
        let mut fresh = factor(&pattern, &ordering);
        fresh.factorise(&matrix, Some(&fixed)).unwrap();
        let mut expected = Vec::new();
        assert_eq!(fresh.set_compliance(&rows, &fixed, &mut expected), 0);
        assert!(found == expected && found.len() == rows.len() * rows.len());
    }
    // Whole sides of eight, and all where nothing has changed.
    assert_eq!(known, [0, 0, 8, 8, 16, 8, 0, 0]);
    of_all.factorise(&matrix, Some(&fixed)).unwrap();
    assert_eq!(of_all.set_compliance(&rows, &fixed, &mut Vec::new()), 0);
}

/// Eight sides at once and the products of sides, by the kernels of both widths of registers.
#[test]
fn sides_are_the_same_bits_in_registers_of_every_width() {
    let mut random = Congruential(12);
    let matrix = random_matrix(&mut random, 40, 120, 0.5);
    let pattern = matrix.pattern().clone();
    let mut factor = factor(&pattern, &Ordering::nested_dissection(&pattern, None));
    factor.factorise(&matrix, None).unwrap();
    let length = 3 * pattern.nodes();
    let mut sides = [(); 3].map(|()| Vec::new());
    sides[0] = (0..length)
        .map(|_| Octet([0.0; WIDTH].map(|_| random.number())))
        .collect();
    sides[1] = sides[0].clone();
    sides[2] = sides[0].clone();
    let mut reached = [(); 3].map(|()| vec![false; factor.symbolic.fronts.len()]);
    factor.solve_half(&mut sides[0], &mut reached[0]);
    let (symbolic, panels, sums) = (&*factor.symbolic, &factor.panels, &mut factor.sums);
    solve_half_in::<f64, false>(symbolic, panels, sums, &mut sides[1], &mut reached[1]);
    solve_half_in::<f64, true>(symbolic, panels, sums, &mut sides[2], &mut reached[2]);
    assert!(reached[0] == reached[1] && reached[0] == reached[2]);
    assert!(sides[0] == sides[1] && sides[0] == sides[2]);
    let mut products = [(); 3].map(|()| vec![0.0; row_start(7)]);
    multiply_halves(&sides[0], length, 0..1, 7, &mut products[0]);
    multiply_halves_in::<f64, false>(&sides[0], length, 0..1, 7, &mut products[1]);
    multiply_halves_in::<f64, true>(&sides[0], length, 0..1, 7, &mut products[2]);
    assert!(products[0] == products[1] && products[0] == products[2]);
}
