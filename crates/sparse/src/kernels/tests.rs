//! The kernels against plain loops over ordinary matrices.

use nalgebra::DMatrix;

use super::*;
use microsim_random::Congruential;

/// Strips of a triangle and full strips below it, as an ordinary matrix.
fn unpacked(panel: &[Octet<f64>], triangle: usize, below: usize) -> DMatrix<f64> {
    DMatrix::from_fn(
        WIDTH * (triangle + below),
        WIDTH * triangle,
        |row, column| {
            let strip = row / WIDTH;
            let start = if strip < triangle {
                triangle_start(strip)
            } else {
                triangle_start(triangle) + (strip - triangle) * triangle * WIDTH
            };
            if row < column {
                0.0
            } else {
                panel[start + column].0[row % WIDTH]
            }
        },
    )
}

/// A panel of a definite matrix: random, the diagonal larger than the sum of a row.
fn panel(random: &mut Congruential, triangle: usize, below: usize) -> Vec<Octet<f64>> {
    let count = triangle_start(triangle) + below * triangle * WIDTH;
    let mut panel: Vec<Octet<f64>> = (0..count)
        .map(|_| Octet([0.0; WIDTH].map(|_| random.number())))
        .collect();
    for row in 0..WIDTH * triangle {
        panel[triangle_start(row / WIDTH) + row].0[row % WIDTH] = 1.0 + (WIDTH * triangle) as f64;
    }
    panel
}

/// Column by column, plain loops, the diagonal left as it is.
fn plain_factor(mut a: DMatrix<f64>) -> DMatrix<f64> {
    for j in 0..a.ncols() {
        for i in j..a.nrows() {
            let sum: f64 = (0..j).map(|p| a[(i, p)] * a[(j, p)]).sum();
            a[(i, j)] -= sum;
        }
        let root = a[(j, j)].sqrt();
        for i in j..a.nrows() {
            a[(i, j)] /= root;
        }
    }
    a
}

#[test]
fn product_is_the_plain_sum_to_the_bit() {
    let mut random = Congruential(5);
    for width in [0, 1, 2, 3, 7, 64] {
        let mut strip = || -> Vec<Octet<f64>> {
            (0..width)
                .map(|_| Octet([0.0; WIDTH].map(|_| random.number())))
                .collect()
        };
        let (a, b) = (strip(), strip());
        let tile = <f64 as crate::real::Products>::product::<false>(&a, &b);
        let wide = <f64 as crate::real::Products>::product::<true>(&a, &b);
        assert_eq!(tile, wide);
        for row in 0..WIDTH {
            for (column, found) in tile.iter().enumerate() {
                let mut sum = 0.0;
                for p in 0..width {
                    sum = a[p].0[row].mul_add(b[p].0[column], sum);
                }
                assert_eq!(found.0[row], sum);
            }
        }
    }
}

#[test]
fn factor_and_update_agree_with_plain_loops() {
    let mut random = Congruential(6);
    // Around the block of four strips on both sides.
    for triangle in [1, 2, 3, 4, 5, 8, 9] {
        for below in [0, 1, 3, 4, 5, 9] {
            let mut panel = panel(&mut random, triangle, below);
            let expected = plain_factor(unpacked(&panel, triangle, below));
            let width = WIDTH * triangle;
            factor_panel(&mut panel, triangle, &vec![0.0; width]).unwrap();
            let mut factor = unpacked(&panel, triangle, below);
            for j in 0..width {
                factor[(j, j)] = 1.0 / factor[(j, j)];
            }
            // The diagonally dominant matrix has a condition number below 2 and pivots above 1: each entry is a sum of
            // at most `width` products of magnitude below √width, and errors do not grow beyond that order.
            let bound = (width * width) as f64 * f64::EPSILON;
            assert!(
                (&factor - &expected).abs().max() <= bound,
                "{triangle} {below}"
            );

            let mut update = vec![Octet([f64::NAN; WIDTH]); triangle_start(below)];
            outer_product(&panel[triangle_start(triangle)..], width, &mut update);
            for row in 0..WIDTH * below {
                for column in 0..=row {
                    let expected = -(0..width).fold(0.0, |sum, p| {
                        factor[(width + row, p)].mul_add(factor[(width + column, p)], sum)
                    });
                    let found = update[triangle_start(row / WIDTH) + column].0[row % WIDTH];
                    assert_eq!(found, expected, "{triangle} {below} {row} {column}");
                }
            }
        }
    }
}

/// What runs on this machine, with whatever registers it has, against what the build is for.
#[test]
fn registers_of_every_width_give_the_same_bits() {
    let mut random = Congruential(8);
    for (triangle, below) in [(1, 0), (2, 3), (5, 5), (9, 4)] {
        let width = WIDTH * triangle;
        let least = vec![0.0; width];
        let mut panels = [(); 3].map(|()| Vec::new());
        panels[0] = panel(&mut random, triangle, below);
        panels[1] = panels[0].clone();
        panels[2] = panels[0].clone();
        factor_panel(&mut panels[0], triangle, &least).unwrap();
        factor_panel_in::<f64, false>(&mut panels[1], triangle, &least).unwrap();
        factor_panel_in::<f64, true>(&mut panels[2], triangle, &least).unwrap();
        assert!(panels[0] == panels[1] && panels[0] == panels[2]);

        let strips = &panels[0][triangle_start(triangle)..];
        let mut updates = [(); 3].map(|()| vec![Octet::ZERO; triangle_start(below)]);
        outer_product(strips, width, &mut updates[0]);
        outer_product_in::<f64, false>(strips, width, &mut updates[1]);
        outer_product_in::<f64, true>(strips, width, &mut updates[2]);
        assert!(updates[0] == updates[1] && updates[0] == updates[2]);

        let mut side = |count: usize| -> Vec<Octet<f64>> {
            let octets = (0..count).map(|_| Octet([0.0; WIDTH].map(|_| random.number())));
            octets.collect()
        };
        let (own, rest) = (side(triangle), side(below));
        let mut sides = [(); 2].map(|()| (own.clone(), rest.clone()));
        let mut sums = vec![Octet::ZERO; width];
        let [(x, y), (a, b)] = &mut sides;
        solve_forward(&panels[0], x, y);
        solve_forward_in::<f64, false>(&panels[0], a, b);
        solve_backward(&panels[0], x, y, &mut sums);
        solve_backward_in::<f64, false>(&panels[0], a, b, &mut sums);
        assert!(sides[0] == sides[1]);
    }
}

#[test]
fn solutions_agree_with_plain_loops() {
    let mut random = Congruential(7);
    for (triangle, below) in [(1, 0), (1, 3), (3, 1), (6, 5)] {
        let mut panel = panel(&mut random, triangle, below);
        let width = WIDTH * triangle;
        factor_panel(&mut panel, triangle, &vec![0.0; width]).unwrap();
        let mut l = unpacked(&panel, triangle, below);
        (0..width).for_each(|j| l[(j, j)] = 1.0 / l[(j, j)]);
        let mut vector = |strips: usize| -> Vec<Octet<f64>> {
            (0..strips)
                .map(|_| Octet([0.0; WIDTH].map(|_| random.number())))
                .collect()
        };
        let (own, under) = (vector(triangle), vector(below));
        let flat = |octets: &[Octet<f64>]| -> Vec<f64> {
            octets.iter().flat_map(|octet| octet.0).collect()
        };
        // L y = b; below − L_below y.
        let mut y = flat(&own);
        let mut rest = flat(&under);
        for i in 0..width {
            let sum: f64 = (0..i).map(|p| l[(i, p)] * y[p]).sum();
            y[i] = (y[i] - sum) / l[(i, i)];
        }
        for (i, rest) in rest.iter_mut().enumerate() {
            *rest -= (0..width).map(|p| l[(width + i, p)] * y[p]).sum::<f64>();
        }
        // Lᵀ x = b − L_belowᵀ below.
        let mut x = flat(&own);
        for j in (0..width).rev() {
            let sum: f64 = (j + 1..width).map(|i| l[(i, j)] * x[i]).sum();
            let under: f64 = flat(&under)
                .iter()
                .enumerate()
                .map(|(i, v)| l[(width + i, j)] * v)
                .sum();
            x[j] = (x[j] - sum - under) / l[(j, j)];
        }
        let (mut own_y, mut under_y) = (own.clone(), under.clone());
        solve_forward(&panel, &mut own_y, &mut under_y);
        let mut own_x = own.clone();
        solve_backward(&panel, &mut own_x, &under, &mut vec![Octet::ZERO; width]);
        let bound = (width * (width + WIDTH * below)) as f64 * f64::EPSILON;
        for (found, expected) in [(own_y, y), (under_y, rest), (own_x, x)] {
            for (found, expected) in flat(&found).iter().zip(&expected) {
                assert!((found - expected).abs() <= bound, "{found} {expected}");
            }
        }
    }
}

#[test]
fn a_pivot_that_is_not_above_its_bound_is_named() {
    let mut random = Congruential(8);
    for column in [0, 3, 4, 17, 23] {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut panel = panel(&mut random, 6, 2);
            panel[triangle_start(column / WIDTH) + column].0[column % WIDTH] = value;
            assert_eq!(
                factor_panel(&mut panel, 6, &[0.0; 6 * WIDTH]),
                Err(column),
                "{value}"
            );
        }
    }
    let mut panel = panel(&mut random, 1, 0);
    assert_eq!(
        factor_panel(&mut panel, 1, &[0.0, 0.0, 12.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Err(2)
    );
}
