//! Dense kernels on strips: the arithmetic of a front.
//!
//! A matrix is kept in strips of four rows; a strip is a run of columns, each a [`Quad`] of its four rows. Both
//! operands of a product A Bᵀ of two strips are then read in order, no packing is needed, and one 4×4 tile of results
//! fits the registers of the smallest x86-64 machine (eight of two numbers) or any wider one.
//!
//! Each number of a result is one sum over the columns in ascending order, whatever the width of the registers: the
//! same bits on every machine. Only indices of whole strips are checked at run time, once per tile.

/// One column of a strip: four rows. Aligned so that a load never crosses a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Quad(pub [f64; 4]);

impl Quad {
    pub const ZERO: Self = Self([0.0; 4]);
}

/// Rows of a strip, and columns of a tile.
pub(crate) const WIDTH: usize = 4;

/// Strips that are worked on together against one other strip, so that this one is read from memory once.
const BLOCK: usize = 4;

/// Four columns of a strip.
type Tile = [Quad; WIDTH];

/// Where strip `i` of a lower triangle begins: strip k holds the columns 0..4(k + 1).
pub(crate) fn triangle_start(i: usize) -> usize {
    2 * i * (i + 1)
}

/// Tile of A Bᵀ: entry (row r of a, row c of b) = Σ_p a_rp b_cp, at column c, lane r.
#[inline(always)]
fn product(a: &[Quad], b: &[Quad]) -> Tile {
    let mut tile = [[0.0; WIDTH]; WIDTH];
    for (a, b) in a.iter().zip(b) {
        for (column, b) in tile.iter_mut().zip(&b.0) {
            for (sum, a) in column.iter_mut().zip(&a.0) {
                *sum += a * b;
            }
        }
    }
    tile.map(Quad)
}

/// tile − A Bᵀ.
#[inline(always)]
fn reduced(tile: &[Quad], a: &[Quad], b: &[Quad]) -> Tile {
    let product = product(a, b);
    let mut result = [Quad::ZERO; WIDTH];
    for ((result, tile), product) in result.iter_mut().zip(tile).zip(&product) {
        for lane in 0..WIDTH {
            result.0[lane] = tile.0[lane] - product.0[lane];
        }
    }
    result
}

/// X with X Lᵀ = tile, for the triangular tile L that has the reciprocals of its diagonal in the diagonal's place.
#[inline(always)]
fn solved(mut tile: Tile, l: &[Quad]) -> Tile {
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
fn cholesky(mut tile: Tile, least: &[f64]) -> Result<Tile, usize> {
    for j in 0..WIDTH {
        for p in 0..j {
            for lane in j..WIDTH {
                tile[j].0[lane] -= tile[p].0[lane] * tile[p].0[j];
            }
        }
        let pivot = tile[j].0[j];
        if pivot <= least[j] || !pivot.is_finite() {
            return Err(j);
        }
        let reciprocal = 1.0 / pivot.sqrt();
        for lane in j + 1..WIDTH {
            tile[j].0[lane] *= reciprocal;
        }
        tile[j].0[j] = reciprocal;
    }
    Ok(tile)
}

/// Factors a panel in place: `triangle` strips of a lower triangle, then full strips of 4·`triangle` columns below it.
/// `least` bounds each pivot from below. Fails with the column of the pivot that is not above it.
pub(crate) fn factor_panel(
    panel: &mut [Quad],
    triangle: usize,
    least: &[f64],
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
                eliminate(strip, pivot, j);
            }
        }
        for i in begin..end {
            let (done, strip) = panel.split_at_mut(triangle_start(i));
            for j in begin..i {
                eliminate(strip, &done[triangle_start(j)..][..WIDTH * (j + 1)], j);
            }
            let (before, tile) = strip[..WIDTH * (i + 1)].split_at_mut(WIDTH * i);
            let factor = cholesky(reduced(tile, before, before), &least[WIDTH * i..][..WIDTH]);
            tile.copy_from_slice(&factor.map_err(|column| WIDTH * i + column)?);
        }
    }
    // The rows below.
    let (done, below) = panel.split_at_mut(triangle_start(triangle));
    for block in below.chunks_mut((BLOCK * width).max(1)) {
        for j in 0..triangle {
            let pivot = &done[triangle_start(j)..][..WIDTH * (j + 1)];
            for strip in block.chunks_exact_mut(width) {
                eliminate(strip, pivot, j);
            }
        }
    }
    Ok(())
}

/// Finishes tile `j` of a strip: less what its columns before share with the strip `pivot`, then solved against the
/// last tile of that one.
#[inline(always)]
fn eliminate(strip: &mut [Quad], pivot: &[Quad], j: usize) {
    let (before, tile) = strip[..WIDTH * (j + 1)].split_at_mut(WIDTH * j);
    let (pivot, corner) = pivot.split_at(WIDTH * j);
    tile.copy_from_slice(&solved(reduced(tile, before, pivot), corner));
}

/// Writes −B Bᵀ into the lower triangle of strips `update`; `below` are the strips B, `width` columns each.
pub(crate) fn outer_product(below: &[Quad], width: usize, update: &mut [Quad]) {
    let strips = below.len() / width;
    for begin in (0..strips).step_by(BLOCK) {
        let end = strips.min(begin + BLOCK);
        for j in 0..end {
            let right = &below[j * width..][..width];
            for i in begin.max(j)..end {
                let tile = product(&below[i * width..][..width], right);
                let place = &mut update[triangle_start(i) + WIDTH * j..][..WIDTH];
                for (place, column) in place.iter_mut().zip(&tile) {
                    *place = Quad(column.0.map(|value| -value));
                }
            }
        }
    }
}

/// Solves L y = b in place for the panel's triangle, then takes L_below y from `below`.
pub(crate) fn solve_forward(panel: &[Quad], own: &mut [Quad], below: &mut [Quad]) {
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
                *y -= l * value;
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

/// The strip times a vector, in four interleaved sums.
#[inline(always)]
fn row_sums(strip: &[Quad], x: &[Quad]) -> [f64; WIDTH] {
    let mut sums = [[0.0; WIDTH]; WIDTH];
    for (tile, x) in strip.as_chunks::<WIDTH>().0.iter().zip(x) {
        for ((sum, column), x) in sums.iter_mut().zip(tile).zip(&x.0) {
            for (sum, value) in sum.iter_mut().zip(&column.0) {
                *sum += value * x;
            }
        }
    }
    std::array::from_fn(|lane| (sums[0][lane] + sums[1][lane]) + (sums[2][lane] + sums[3][lane]))
}

/// Solves Lᵀ x = y − L_belowᵀ `below` in place. `sums` is room for one quad per column of the panel.
pub(crate) fn solve_backward(panel: &[Quad], own: &mut [Quad], below: &[Quad], sums: &mut [Quad]) {
    let width = WIDTH * own.len();
    // Lane by lane, so that the sums over the lanes are formed once, at the end.
    let sums = &mut sums[..width];
    sums.fill(Quad::ZERO);
    let strips = panel[triangle_start(own.len())..].chunks_exact(width);
    for (strip, x) in strips.zip(below) {
        add_lanes(sums, strip, x);
    }
    for i in (0..own.len()).rev() {
        let (before, tile) = panel[triangle_start(i)..][..WIDTH * (i + 1)].split_at(WIDTH * i);
        let mut x = own[i].0;
        for j in (0..WIDTH).rev() {
            let [a, b, c, d] = sums[WIDTH * i + j].0;
            x[j] -= (a + b) + (c + d);
            for lane in j + 1..WIDTH {
                x[j] -= tile[j].0[lane] * x[lane];
            }
            x[j] *= tile[j].0[j];
        }
        own[i].0 = x;
        add_lanes(&mut sums[..WIDTH * i], before, &own[i]);
    }
}

#[inline(always)]
fn add_lanes(sums: &mut [Quad], strip: &[Quad], x: &Quad) {
    for (sum, column) in sums.iter_mut().zip(strip) {
        for lane in 0..WIDTH {
            sum.0[lane] += column.0[lane] * x.0[lane];
        }
    }
}

#[cfg(test)]
mod tests;
