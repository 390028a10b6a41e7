//! The multifrontal Cholesky factor: factorisation and solution.
//!
//! Duff and Reid (1983), Liu, "The multifrontal method for sparse matrix solution" (1992). Fronts are visited children
//! first; each takes the blocks of the matrix and the updates of its children, eliminates its own nodes with dense
//! kernels, and leaves its update for its parent.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::BlockMatrix;
use crate::assembly::{Part, Places, assemble};
use crate::kernels::{
    factor_panel, outer_product, solve_backward, solve_forward, solve_strip, triangle_start, widest,
};
use crate::real::{Octet, Real, WIDTH};
use crate::symbolic::{Front, Symbolic};

/// The matrix is not positive definite, to working accuracy, or not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPositive {
    /// The node at whose elimination it showed.
    pub node: usize,
}

impl std::fmt::Display for NotPositive {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "the matrix is not positive definite: no positive pivot at node {}",
            self.node
        )
    }
}

impl std::error::Error for NotPositive {}

/// Cholesky factor A = L Lᵀ of matrices on one pattern, with its workspace: after `new` nothing is allocated.
#[derive(Debug)]
pub struct Factor<T = f64> {
    symbolic: Arc<Symbolic>,
    panels: Vec<Octet<T>>,
    updates: [Vec<Octet<T>>; 2],
    /// Whether `panels` hold a factor.
    valid: bool,
    /// Least admissible pivots of a front's columns.
    least: Vec<T>,
    places: Places,
    /// Right-hand side in the order of elimination; that of a front, above and below; room for the backward solution.
    x: Vec<T>,
    own: Vec<Octet<T>>,
    below: Vec<Octet<T>>,
    sums: Vec<Octet<T>>,
    /// J of the last compliance since the factorisation; L⁻¹ Jᵀ, eight columns at a time; the products of these columns, the lower triangle row by row.
    rows: Vec<[(u32, Vector3<f64>); 4]>,
    halves: Vec<Octet<T>>,
    products: Vec<f64>,
    /// The fronts that any of them reaches, and the columns without the others.
    reached: Vec<bool>,
    gathered: Vec<Octet<T>>,
}

impl<T: Real> Factor<T> {
    /// Allocates the factor; it holds no numbers until `factorise`.
    pub fn new(symbolic: Arc<Symbolic>) -> Self {
        let most = |size: fn(&Front) -> usize| symbolic.fronts.iter().map(size).max().unwrap_or(0);
        let (triangle, below) = (most(Front::triangle), most(Front::below));
        Self {
            panels: vec![Octet::ZERO; symbolic.panel_octets],
            updates: symbolic
                .stack_octets
                .map(|octets| vec![Octet::ZERO; octets]),
            valid: false,
            least: vec![T::ZERO; WIDTH * triangle],
            places: Places::new(WIDTH * below),
            x: vec![T::ZERO; 3 * symbolic.sequence.len()],
            own: vec![Octet::ZERO; triangle],
            below: vec![Octet::ZERO; below],
            sums: vec![Octet::ZERO; WIDTH * triangle],
            rows: Vec::new(),
            halves: Vec::new(),
            products: Vec::new(),
            reached: vec![false; symbolic.fronts.len()],
            gathered: Vec::new(),
            symbolic,
        }
    }

    /// The analysis it was made from.
    pub fn symbolic(&self) -> &Arc<Symbolic> {
        &self.symbolic
    }

    /// Factors the matrix. Nodes marked in `fixed` get rows and columns of the identity and no coupling: the solution
    /// there is the right-hand side, and has no effect on the other nodes. (To prescribe values x_f, first take A x_f
    /// from the right-hand side of the free nodes.)
    ///
    /// # Errors
    /// When a pivot is not positive, not finite or below 64 ε of its diagonal entry, with its node; the factor is then
    /// not usable. A negative eigenvalue, and a singular matrix too, shows only beyond the rounding of elimination: a
    /// free body of ten thousand nodes may pass with a pivot of rounding's size. What passes is finite.
    ///
    /// # Panics
    /// When the matrix is on another pattern, or `fixed` does not have one entry per node.
    pub fn factorise(
        &mut self,
        matrix: &BlockMatrix,
        fixed: Option<&[bool]>,
    ) -> Result<(), NotPositive> {
        let symbolic = self.symbolic.clone();
        assert!(
            Arc::ptr_eq(matrix.pattern(), &symbolic.pattern)
                || *matrix.pattern() == symbolic.pattern,
            "the matrix is on the analysed pattern"
        );
        if let Some(fixed) = fixed {
            assert_eq!(fixed.len(), symbolic.sequence.len(), "one mark per node");
        }
        self.valid = false;
        self.rows.clear();
        for front in &symbolic.fronts {
            let panel = &mut self.panels[front.panel..][..front.panel_octets()];
            let triangle = front.triangle();
            let least = &mut self.least[..WIDTH * triangle];
            let [even, odd] = &mut self.updates;
            let (own, of_children) = if front.stack == 0 {
                (even, odd)
            } else {
                (odd, even)
            };
            let update = &mut own[front.update..][..front.update_octets()];
            assemble(
                &symbolic.entries[front.entries.clone()],
                front,
                matrix,
                fixed,
                panel,
                least,
            );
            for &child in &symbolic.children[front.children.clone()] {
                self.places
                    .add_update(&symbolic, child, front, of_children, Part::Panel, panel);
            }
            factor_panel(panel, triangle, least).map_err(|column| NotPositive {
                node: symbolic.sequence[front.columns.start + column / 3] as usize,
            })?;
            outer_product(&panel[triangle_start(triangle)..], WIDTH * triangle, update);
            for &child in &symbolic.children[front.children.clone()] {
                self.places
                    .add_update(&symbolic, child, front, of_children, Part::Update, update);
            }
        }
        self.valid = true;
        Ok(())
    }

    /// Solves L y = b in place for eight right-hand sides at once, in the order of elimination: one octet per number of a node. Fronts
    /// that have nothing to do with them are passed over, the others are marked in `reached`.
    ///
    /// # Panics
    /// When the last factorisation failed or there was none, or `x` does not have three octets per node.
    pub(crate) fn solve_half(&mut self, x: &mut [Octet<T>], reached: &mut [bool]) {
        assert!(self.valid, "factorised before");
        let symbolic = &*self.symbolic;
        assert_eq!(
            x.len(),
            3 * symbolic.sequence.len(),
            "three octets per node"
        );
        widest!(solve_half_in::<T>(
            symbolic,
            &self.panels,
            &mut self.sums,
            x,
            reached
        ));
    }

    /// Sets `compliance` to J A⁻¹ Jᵀ = (L⁻¹ Jᵀ)ᵀ (L⁻¹ Jᵀ), row by row; each row of J has the vectors of up to four nodes, of which those
    /// marked in `fixed`, as they were in the factorisation, are left out. Returns how many of the first rows it had from the call before, as contacts join others: they cost nothing.
    ///
    /// # Panics
    /// When the last factorisation failed or there was none.
    pub(crate) fn set_compliance(
        &mut self,
        rows: &[[(u32, Vector3<f64>); 4]],
        fixed: &[bool],
        compliance: &mut Vec<f64>,
    ) -> usize {
        let symbolic = self.symbolic.clone();
        let length = 3 * symbolic.sequence.len();
        let both = self.rows.iter().zip(rows);
        let known = both.take_while(|(before, row)| before == row).count();
        // Eight columns are one side: one that is filled up is solved for again.
        let sides = match known == rows.len() && known == self.rows.len() {
            true => known.div_ceil(WIDTH),
            false => known / WIDTH,
        };
        let known = known.min(WIDTH * sides);
        self.rows.truncate(known);
        self.rows.extend_from_slice(&rows[known..]);
        self.products.truncate(row_start(known));
        let mut halves = std::mem::take(&mut self.halves);
        halves.truncate(sides * length);
        halves.resize(rows.len().div_ceil(WIDTH) * length, Octet::ZERO);
        let before = self.reached.clone();
        let mut reached = std::mem::take(&mut self.reached);
        if sides == 0 {
            reached.fill(false);
        }
        let new = halves[sides * length..].chunks_exact_mut(length.max(1));
        for (rows, half) in rows[known..].chunks(WIDTH).zip(new) {
            for (lane, row) in rows.iter().enumerate() {
                for (node, vector) in row.iter().filter(|(node, _)| !fixed[*node as usize]) {
                    let place = 3 * symbolic.place[*node as usize] as usize;
                    for (octet, value) in half[place..].iter_mut().zip(vector.iter()) {
                        octet.0[lane] += T::from_f64(*value);
                    }
                }
            }
            self.solve_half(half, &mut reached);
        }
        if known < rows.len() {
            let gathered = match reached == before {
                true => sides,
                false => 0,
            };
            let length = self.gather_reached(&halves, &reached, gathered);
            multiply_halves(
                &self.gathered,
                length,
                sides..rows.len().div_ceil(WIDTH),
                rows.len(),
                &mut self.products,
            );
        }
        self.reached = reached;
        self.halves = halves;
        spread_triangle(&self.products, rows.len(), compliance);
        known
    }

    /// Gathers the places of these fronts from all columns, of which the first `sides` sides are gathered already; returns how many octets a side has, at least 1. The others add nothing to
    /// a product of two columns: contacts in one region reach a part of the fronts.
    fn gather_reached(&mut self, halves: &[Octet<T>], reached: &[bool], sides: usize) -> usize {
        let symbolic = &*self.symbolic;
        let length = 3 * symbolic.sequence.len();
        let fronts = symbolic.fronts.iter().zip(reached);
        let places = fronts.filter(|(_, reached)| **reached);
        let places = places.map(|(front, _)| 3 * front.columns.start..3 * front.columns.end);
        let shortened = places.clone().map(|places| places.len()).sum::<usize>();
        self.gathered.truncate(sides * shortened.max(1));
        for half in halves.chunks_exact(length.max(1)).skip(sides) {
            for places in places.clone() {
                self.gathered.extend_from_slice(&half[places]);
            }
            if shortened == 0 {
                self.gathered.push(Octet::ZERO);
            }
        }
        shortened.max(1)
    }

    /// Solves A x = b in place, in the numbering of the nodes.
    ///
    /// # Panics
    /// When the last factorisation failed or there was none, or `rhs` does not have one vector per node.
    pub fn solve(&mut self, rhs: &mut [Vector3<f64>]) {
        assert!(self.valid, "factorised before");
        let symbolic = &*self.symbolic;
        assert_eq!(rhs.len(), symbolic.sequence.len(), "one vector per node");
        for (x, &node) in self.x.chunks_exact_mut(3).zip(&symbolic.sequence) {
            for (x, value) in x.iter_mut().zip(rhs[node as usize].iter()) {
                *x = T::from_f64(*value);
            }
        }
        for front in &symbolic.fronts {
            let panel = &self.panels[front.panel..][..front.panel_octets()];
            let (own, below) = (
                &mut self.own[..front.triangle()],
                &mut self.below[..front.below()],
            );
            let columns = 3 * front.columns.start..3 * front.columns.end;
            let rows = &symbolic.rows[front.rows.clone()];
            load(own, &self.x[columns.clone()]);
            gather(below, rows, &self.x);
            solve_forward(panel, own, below);
            store(own, &mut self.x[columns]);
            scatter(below, rows, &mut self.x);
        }
        for front in symbolic.fronts.iter().rev() {
            let panel = &self.panels[front.panel..][..front.panel_octets()];
            let (own, below) = (
                &mut self.own[..front.triangle()],
                &mut self.below[..front.below()],
            );
            let columns = 3 * front.columns.start..3 * front.columns.end;
            load(own, &self.x[columns.clone()]);
            gather(below, &symbolic.rows[front.rows.clone()], &self.x);
            solve_backward(panel, own, below, &mut self.sums);
            store(own, &mut self.x[columns]);
        }
        for (x, &node) in self.x.chunks_exact(3).zip(&symbolic.sequence) {
            for (value, x) in rhs[node as usize].iter_mut().zip(x) {
                *value = x.to_f64();
            }
        }
    }
}

/// As [`Factor::solve_half`].
#[inline(always)]
fn solve_half_in<T: Real, const WIDE: bool>(
    symbolic: &Symbolic,
    panels: &[Octet<T>],
    sums: &mut [Octet<T>],
    x: &mut [Octet<T>],
    reached: &mut [bool],
) {
    for (front, reached) in symbolic.fronts.iter().zip(reached) {
        let columns = 3 * front.columns.start..3 * front.columns.end;
        if x[columns.clone()].iter().all(|octet| *octet == Octet::ZERO) {
            continue;
        }
        *reached = true;
        let panel = &panels[front.panel..][..front.panel_octets()];
        let width = WIDTH * front.triangle();
        // Eight right-hand sides are a strip of rows below the triangle.
        let strip = &mut sums[..width];
        strip[..columns.len()].copy_from_slice(&x[columns.clone()]);
        strip[columns.len()..].fill(Octet::ZERO);
        solve_strip::<T, WIDE>(panel, strip);
        x[columns.clone()].copy_from_slice(&strip[..columns.len()]);
        let below = panel[triangle_start(front.triangle())..].chunks_exact(width);
        let rows = &symbolic.rows[front.rows.clone()];
        for (index, below) in below.enumerate() {
            let tile = T::product::<WIDE>(strip, below);
            let first = WIDTH * index;
            for (row, sums) in (first..3 * rows.len()).zip(&tile) {
                let place = &mut x[3 * rows[row / 3] as usize + row % 3];
                for (x, sum) in place.0.iter_mut().zip(&sums.0) {
                    *x -= *sum;
                }
            }
        }
    }
}

/// Appends to `products` those of the sides in `new`, of `length` octets each and of `count` columns in all, with themselves and all before, row by row.
fn multiply_halves<T: Real>(
    halves: &[Octet<T>],
    length: usize,
    new: Range<usize>,
    count: usize,
    products: &mut Vec<f64>,
) {
    products.resize(row_start(count), 0.0);
    widest!(multiply_halves_in::<T>(
        halves, length, new, count, products
    ));
}

#[inline(always)]
fn multiply_halves_in<T: Real, const WIDE: bool>(
    halves: &[Octet<T>],
    length: usize,
    new: Range<usize>,
    count: usize,
    products: &mut [f64],
) {
    for i in new {
        let a = &halves[i * length..][..length];
        for (j, b) in halves.chunks_exact(length).take(i + 1).enumerate() {
            let tile = T::product::<WIDE>(a, b);
            for (row, lane) in (WIDTH * i..count).zip(0..WIDTH) {
                let row = &mut products[row_start(row)..row_start(row + 1)];
                for (product, values) in row[WIDTH * j..].iter_mut().zip(&tile) {
                    *product = values.0[lane].to_f64();
                }
            }
        }
    }
}

/// Where row `i` of a lower triangle begins.
fn row_start(i: usize) -> usize {
    i * (i + 1) / 2
}

/// Writes the symmetric matrix of `count` rows that has this lower triangle.
fn spread_triangle(triangle: &[f64], count: usize, matrix: &mut Vec<f64>) {
    matrix.clear();
    matrix.resize(count * count, 0.0);
    for i in 0..count {
        let row = &triangle[row_start(i)..row_start(i + 1)];
        matrix[i * count..][..=i].copy_from_slice(row);
        for (j, value) in row.iter().enumerate() {
            matrix[j * count + i] = *value;
        }
    }
}

/// Copies numbers into octets; the last octet is filled up with zeros.
pub(crate) fn load<T: Real>(octets: &mut [Octet<T>], x: &[T]) {
    for (octet, x) in octets.iter_mut().zip(x.chunks(WIDTH)) {
        *octet = Octet::ZERO;
        octet.0[..x.len()].copy_from_slice(x);
    }
}

/// Copies octets back into numbers.
pub(crate) fn store<T: Real>(octets: &[Octet<T>], x: &mut [T]) {
    for (octet, x) in octets.iter().zip(x.chunks_mut(WIDTH)) {
        x.copy_from_slice(&octet.0[..x.len()]);
    }
}

/// Copies the vectors at `rows` into octets; the last octet is filled up with zeros.
fn gather<T: Real>(octets: &mut [Octet<T>], rows: &[u32], x: &[T]) {
    if let Some(last) = octets.last_mut() {
        *last = Octet::ZERO;
    }
    for (k, &row) in rows.iter().enumerate() {
        for (a, &value) in x[3 * row as usize..][..3].iter().enumerate() {
            octets[(3 * k + a) / WIDTH].0[(3 * k + a) % WIDTH] = value;
        }
    }
}

/// Copies octets back into the vectors at `rows`.
fn scatter<T: Real>(octets: &[Octet<T>], rows: &[u32], x: &mut [T]) {
    for (k, &row) in rows.iter().enumerate() {
        for (a, value) in x[3 * row as usize..][..3].iter_mut().enumerate() {
            *value = octets[(3 * k + a) / WIDTH].0[(3 * k + a) % WIDTH];
        }
    }
}

#[cfg(test)]
mod tests;
