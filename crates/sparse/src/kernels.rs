//! Dense kernels on strips: the arithmetic of a front.
//!
//! A matrix is stored in strips of eight rows; a strip is a run of columns, each an [`Octet`] of its eight rows. Both operands
//! of a product A Bᵀ of two strips are then read in order and no packing is needed. As many columns of a tile of results are
//! worked on together as fill eight registers ([`Products::product`](crate::real::Products::product)): more would not fit beside the operands, with
//! fewer the processor waits for its own sums. Kernels are compiled for registers of 256 bits and of 512, and which of both runs is
//! decided by the machine (crate `pulp`).
//!
//! Each number of a result is one sum over the columns in ascending order, a multiplication and an addition rounded once
//! (`mul_add`), whatever the width of the registers: the same bits on every machine. The build must allow the instruction for
//! that (x86-64-v3); without it the bits are the same, but a call of a function per number makes it useless. Only indices of whole strips are checked at run time, once per tile.

use crate::real::{Octet, Real, Tile, WIDTH};

/// Strips that are worked on together against one other strip, so that this one is read from memory once.
const BLOCK: usize = 4;

/// Where strip `i` of a lower triangle begins: strip k holds the columns 0..8(k + 1).
pub(crate) fn triangle_start(i: usize) -> usize {
    WIDTH * i * (i + 1) / 2
}

/// tile − A Bᵀ.
#[inline(always)]
fn reduced<T: Real, const WIDE: bool>(
    tile: &[Octet<T>],
    a: &[Octet<T>],
    b: &[Octet<T>],
) -> Tile<T> {
    let mut result = T::product::<WIDE>(a, b);
    for (result, tile) in result.iter_mut().zip(tile) {
        for (result, value) in result.0.iter_mut().zip(&tile.0) {
            *result = *value - *result;
        }
    }
    result
}

/// X with X Lᵀ = tile, for the triangular tile L that has the reciprocals of its diagonal in the diagonal's place.
#[inline(always)]
fn solved<T: Real>(mut tile: Tile<T>, l: &[Octet<T>]) -> Tile<T> {
    let l = &l[..WIDTH];
    for j in 0..WIDTH {
        for p in 0..j {
            for lane in 0..WIDTH {
                tile[j].0[lane] -= tile[p].0[lane] * l[p].0[j];
            }
        }
        for lane in 0..WIDTH {
            tile[j].0[lane] *= l[j].0[j];
        }
    }
    tile
}

/// Cholesky factor of a tile, in its lower triangle, with the reciprocals of the diagonal in its place. Fails with the
/// column whose pivot is not above its `least`, or not finite.
#[inline(always)]
fn cholesky<T: Real>(mut tile: Tile<T>, least: &[T]) -> Result<Tile<T>, usize> {
    for j in 0..WIDTH {
        for p in 0..j {
            // What lies above the diagonal is worked on too: a loop of fixed length takes less time.
            let factor = tile[p].0[j];
            for lane in 0..WIDTH {
                tile[j].0[lane] -= tile[p].0[lane] * factor;
            }
        }
        let pivot = tile[j].0[j];
        if pivot <= least[j] || !pivot.is_finite() {
            return Err(j);
        }
        let reciprocal = T::ONE / pivot.sqrt();
        for lane in 0..WIDTH {
            tile[j].0[lane] *= reciprocal;
        }
        tile[j].0[j] = reciprocal;
        tile[j].0[..j].fill(T::ZERO);
    }
    Ok(tile)
}

/// Calls a kernel as it was compiled for registers of 512 bits where the machine has them, else as for all machines of the build. Both give the same bits:
/// lanes are of different rows.
macro_rules! widest {
    ($kernel:ident::<$number:ty>($($argument:expr),* $(,)?)) => {{
        #[cfg(target_arch = "x86_64")]
        if let Some(wide) = pulp::x86::V4::try_new() {
            return pulp::Simd::vectorize(wide, || $kernel::<$number, true>($($argument),*));
        }
        $kernel::<$number, false>($($argument),*)
    }};
}
pub(crate) use widest;

/// Factors a panel in place: `triangle` strips of a lower triangle, then full strips of 8·`triangle` columns below it.
/// `least` bounds each pivot from below. Fails with the column of the pivot that is not above it.
pub(crate) fn factor_panel<T: Real>(
    panel: &mut [Octet<T>],
    triangle: usize,
    least: &[T],
) -> Result<(), usize> {
    widest!(factor_panel_in::<T>(panel, triangle, least))
}

#[inline(always)]
fn factor_panel_in<T: Real, const WIDE: bool>(
    panel: &mut [Octet<T>],
    triangle: usize,
    least: &[T],
) -> Result<(), usize> {
    let width = WIDTH * triangle;
    // The triangle: blocks of strips against all strips before the block, then within the block.
    for begin in (0..triangle).step_by(BLOCK) {
        let end = triangle.min(begin + BLOCK);
        let (done, block) = panel.split_at_mut(triangle_start(begin));
        for j in 0..begin {
            let pivot = &done[triangle_start(j)..][..WIDTH * (j + 1)];
            for i in begin..end {
                let strip = &mut block[triangle_start(i) - triangle_start(begin)..];
                eliminate::<T, WIDE>(strip, pivot, j);
            }
        }
        for i in begin..end {
            let (done, strip) = panel.split_at_mut(triangle_start(i));
            for j in begin..i {
                eliminate::<T, WIDE>(strip, &done[triangle_start(j)..][..WIDTH * (j + 1)], j);
            }
            let (before, tile) = strip[..WIDTH * (i + 1)].split_at_mut(WIDTH * i);
            let factor = cholesky(
                reduced::<T, WIDE>(tile, before, before),
                &least[WIDTH * i..][..WIDTH],
            );
            tile.copy_from_slice(&factor.map_err(|column| WIDTH * i + column)?);
        }
    }
    // The rows below.
    let (done, below) = panel.split_at_mut(triangle_start(triangle));
    for block in below.chunks_mut((BLOCK * width).max(1)) {
        for j in 0..triangle {
            let pivot = &done[triangle_start(j)..][..WIDTH * (j + 1)];
            for strip in block.chunks_exact_mut(width) {
                eliminate::<T, WIDE>(strip, pivot, j);
            }
        }
    }
    Ok(())
}

/// Finishes tile `j` of a strip: less the products of its columns before with those of the strip `pivot`, then solved against the
/// last tile of that one.
#[inline(always)]
fn eliminate<T: Real, const WIDE: bool>(strip: &mut [Octet<T>], pivot: &[Octet<T>], j: usize) {
    let (before, tile) = strip[..WIDTH * (j + 1)].split_at_mut(WIDTH * j);
    let (pivot, corner) = pivot.split_at(WIDTH * j);
    tile.copy_from_slice(&solved(reduced::<T, WIDE>(tile, before, pivot), corner));
}

/// Solves X Lᵀ = B in place for a strip B, with the triangle L of a factored panel.
#[inline(always)]
pub(crate) fn solve_strip<T: Real, const WIDE: bool>(panel: &[Octet<T>], strip: &mut [Octet<T>]) {
    for j in 0..strip.len() / WIDTH {
        eliminate::<T, WIDE>(strip, &panel[triangle_start(j)..][..WIDTH * (j + 1)], j);
    }
}

/// Writes −B Bᵀ into the lower triangle of strips `update`; `below` are the strips B, `width` columns each.
pub(crate) fn outer_product<T: Real>(below: &[Octet<T>], width: usize, update: &mut [Octet<T>]) {
    widest!(outer_product_in::<T>(below, width, update))
}

#[inline(always)]
fn outer_product_in<T: Real, const WIDE: bool>(
    below: &[Octet<T>],
    width: usize,
    update: &mut [Octet<T>],
) {
    let strips = below.len() / width;
    for begin in (0..strips).step_by(BLOCK) {
        let end = strips.min(begin + BLOCK);
        for j in 0..end {
            let right = &below[j * width..][..width];
            for i in begin.max(j)..end {
                let tile = T::product::<WIDE>(&below[i * width..][..width], right);
                let place = &mut update[triangle_start(i) + WIDTH * j..][..WIDTH];
                for (place, column) in place.iter_mut().zip(&tile) {
                    *place = Octet(column.0.map(|value| -value));
                }
            }
        }
    }
}

/// Solves L y = b in place for the panel's triangle, then takes L_below y from `below`.
pub(crate) fn solve_forward<T: Real>(
    panel: &[Octet<T>],
    own: &mut [Octet<T>],
    below: &mut [Octet<T>],
) {
    widest!(solve_forward_in::<T>(panel, own, below))
}

#[inline(always)]
fn solve_forward_in<T: Real, const WIDE: bool>(
    panel: &[Octet<T>],
    own: &mut [Octet<T>],
    below: &mut [Octet<T>],
) {
    let width = WIDTH * own.len();
    for i in 0..own.len() {
        let strip = &panel[triangle_start(i)..][..WIDTH * (i + 1)];
        let (before, tile) = strip.split_at(WIDTH * i);
        let sum = row_sums(before, &own[..i]);
        let y = &mut own[i].0;
        for (j, column) in tile.iter().enumerate() {
            y[j] = (y[j] - sum[j]) * column.0[j];
            let value = y[j];
            for (y, l) in y.iter_mut().zip(&column.0).skip(j + 1) {
                *y -= *l * value;
            }
        }
    }
    let strips = panel[triangle_start(own.len())..].chunks_exact(width);
    for (strip, y) in strips.zip(below) {
        for (y, sum) in y.0.iter_mut().zip(row_sums(strip, own)) {
            *y -= sum;
        }
    }
}

/// Sums of a row that run side by side.
const SUMS: usize = 4;

/// The strip times a vector, in four interleaved sums.
#[inline(always)]
fn row_sums<T: Real>(strip: &[Octet<T>], x: &[Octet<T>]) -> [T; WIDTH] {
    let mut sums = [[T::ZERO; WIDTH]; SUMS];
    for (tile, x) in strip.as_chunks::<WIDTH>().0.iter().zip(x) {
        for (columns, x) in tile
            .as_chunks::<SUMS>()
            .0
            .iter()
            .zip(x.0.as_chunks::<SUMS>().0)
        {
            for ((sum, column), x) in sums.iter_mut().zip(columns).zip(x) {
                for (sum, value) in sum.iter_mut().zip(&column.0) {
                    *sum += *value * *x;
                }
            }
        }
    }
    std::array::from_fn(|lane| (sums[0][lane] + sums[1][lane]) + (sums[2][lane] + sums[3][lane]))
}

/// Solves Lᵀ x = y − L_belowᵀ `below` in place. `sums` is room for one octet per column of the panel.
pub(crate) fn solve_backward<T: Real>(
    panel: &[Octet<T>],
    own: &mut [Octet<T>],
    below: &[Octet<T>],
    sums: &mut [Octet<T>],
) {
    widest!(solve_backward_in::<T>(panel, own, below, sums))
}

#[inline(always)]
fn solve_backward_in<T: Real, const WIDE: bool>(
    panel: &[Octet<T>],
    own: &mut [Octet<T>],
    below: &[Octet<T>],
    sums: &mut [Octet<T>],
) {
    let width = WIDTH * own.len();
    // Lane by lane, so that the sums over the lanes are formed once, at the end.
    let sums = &mut sums[..width];
    sums.fill(Octet::ZERO);
    let strips = &panel[triangle_start(own.len())..];
    let (blocks, rest) = below.as_chunks::<BLOCK>();
    for (block, x) in strips.chunks_exact((BLOCK * width).max(1)).zip(blocks) {
        add_lanes_of_block(sums, block, x);
    }
    let strips = strips[BLOCK * width * blocks.len()..].chunks_exact(width.max(1));
    for (strip, x) in strips.zip(rest) {
        add_lanes(sums, strip, x);
    }
    for i in (0..own.len()).rev() {
        let (before, tile) = panel[triangle_start(i)..][..WIDTH * (i + 1)].split_at(WIDTH * i);
        let mut x = own[i].0;
        for j in (0..WIDTH).rev() {
            let [a, b, c, d, e, f, g, h] = sums[WIDTH * i + j].0;
            x[j] -= ((a + b) + (c + d)) + ((e + f) + (g + h));
            for lane in j + 1..WIDTH {
                let value = x[lane];
                x[j] -= tile[j].0[lane] * value;
            }
            x[j] *= tile[j].0[j];
        }
        own[i].0 = x;
        add_lanes(&mut sums[..WIDTH * i], before, &own[i]);
    }
}

/// As [`add_lanes`] for one strip after the other, but the sums are read and written once.
#[inline(always)]
fn add_lanes_of_block<T: Real>(sums: &mut [Octet<T>], block: &[Octet<T>], x: &[Octet<T>; BLOCK]) {
    let width = sums.len();
    let strips: [&[Octet<T>]; BLOCK] = std::array::from_fn(|k| &block[k * width..][..width]);
    for (column, sum) in sums.iter_mut().enumerate() {
        let mut total = sum.0;
        for (strip, x) in strips.iter().zip(x) {
            for ((total, l), x) in total.iter_mut().zip(&strip[column].0).zip(&x.0) {
                *total += *l * *x;
            }
        }
        sum.0 = total;
    }
}

#[inline(always)]
fn add_lanes<T: Real>(sums: &mut [Octet<T>], strip: &[Octet<T>], x: &Octet<T>) {
    for (sum, column) in sums.iter_mut().zip(strip) {
        for lane in 0..WIDTH {
            sum.0[lane] += column.0[lane] * x.0[lane];
        }
    }
}

#[cfg(test)]
mod tests;
