//! Solution of systems with one pattern and many matrices: the method is chosen by the pattern, with more robust ones to fall back on.
//!
//! 1. Conjugate gradients with a [`TwoLevel`] preconditioner: large solid bodies.
//! 2. Conjugate gradients with an f32 Cholesky factor as preconditioner: small and slender bodies. Half the time and memory of one
//!    in f64; two or three iterations.
//! 3. An f64 Cholesky factor, whose solution is exact to rounding.
//!
//! Where a method does not reach the tolerance the next one is taken, for this matrix alone: nearly incompressible bodies and very
//! slender ones without inertia may need that. The solution is the same up to the tolerance, and the choice depends on the numbers
//! only, never on time.

use std::sync::{Arc, OnceLock};

use nalgebra::Vector3;

use crate::{
    BlockMatrix, ConjugateGradients, Factor, Lattice, NotPositive, Ordering, Pattern, Symbolic,
    TwoLevel,
};

/// Operations of a factor per block of the matrix from which on two levels cost less (`cargo xtask bench solvers`).
const OPERATIONS: f64 = 12_000.0;

/// Operations of a factor up to which it costs about as much as a few solutions, and no more than the conjugate gradients that contacts take
/// where there is none in f64. Vessels of the modules have 0.9 to 2 · 10⁷: with 1.2e7 those of both trims are left to conjugate gradients, and the 99th percentile of a tick is
/// 15 to 19 ms instead of 8 to 14. No level has vessels between 2 and 3 · 10⁷; which method is more accurate is in `tests/results/solvers_tried.md`.
const FEW: f64 = 3.0e7;

/// Distances of nodes along a cell of the lattice.
const SPACING: f64 = 3.5;

/// Most iterations with two levels, and with an f32 factor: by then the next method costs less.
const ITERATIONS_TWO_LEVEL: usize = 80;
const ITERATIONS_SINGLE: usize = 12;

/// Most iterations beyond those for what is added to the matrix.
const ITERATIONS_MORE: usize = 60;

/// What a number that is used once takes, over an operation of a dense kernel: measured on factors of 1.5 to 3 million operations.
const STREAMED: f64 = 4.0;

/// Numbers per block that are gone over when two levels take over a matrix. A judgement.
const REFRESH: f64 = 60.0;

/// Adds a product with the first vector to the second one.
type Add<'a> = &'a mut dyn FnMut(&[Vector3<f64>], &mut [Vector3<f64>]);

/// The methods, in the order of their robustness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Method {
    TwoLevel,
    FactorF32,
    FactorF64,
}

/// A solver for matrices of one pattern.
#[derive(Debug)]
pub struct LinearSolver {
    /// The analysis of the factors, once it was needed.
    symbolic: OnceLock<Arc<Symbolic>>,
    positions: Arc<[Vector3<f64>]>,
    /// The method of the pattern that it was made for.
    origin: Method,
    first: Method,
    /// The method that holds the numbers of the matrix.
    method: Method,
    /// The first method; those after it are made when they are first needed.
    two_level: Option<Box<TwoLevel>>,
    single: Option<Box<Factor<f32>>>,
    double: Option<Box<Factor<f64>>>,
    gradients: ConjugateGradients,
    /// Operations since they were asked for last.
    operations: f64,
    /// Marks of the nodes with rows and columns of the identity.
    fixed: Vec<bool>,
    right_side: Vec<Vector3<f64>>,
    solution: Vec<Vector3<f64>>,
}

impl LinearSolver {
    /// Analyses the pattern; `positions` \[m\] are those of its nodes.
    pub fn new(pattern: &Arc<Pattern>, positions: &[Vector3<f64>]) -> Self {
        let symbolic = analyse(pattern, positions);
        let origin = first_method(&symbolic, pattern);
        Self::with_analysis(Some(symbolic), pattern, positions.into(), [origin; 2])
    }

    /// One for another pattern of the same body, which was cut. Where the first method was two levels it stays so, and nothing is
    /// analysed that this method does not need: that is most of the work. Else the choice is that of the new pattern. So it depends on the pattern
    /// that the solver was made for and on the present one, not on those between.
    pub fn following(&self, pattern: &Arc<Pattern>, positions: &[Vector3<f64>]) -> Self {
        let symbolic = (self.origin != Method::TwoLevel).then(|| analyse(pattern, positions));
        let first = match &symbolic {
            Some(symbolic) => first_method(symbolic, pattern),
            None => Method::TwoLevel,
        };
        Self::with_analysis(symbolic, pattern, positions.into(), [self.origin, first])
    }

    fn with_analysis(
        symbolic: Option<Arc<Symbolic>>,
        pattern: &Arc<Pattern>,
        positions: Arc<[Vector3<f64>]>,
        [origin, first]: [Method; 2],
    ) -> Self {
        let zeros = vec![Vector3::zeros(); positions.len()];
        let two_level =
            (first == Method::TwoLevel).then(|| Box::new(two_level(pattern, &positions)));
        let mut solver = Self {
            symbolic: symbolic.map_or_else(OnceLock::new, OnceLock::from),
            origin,
            first,
            method: first,
            two_level,
            single: None,
            double: None,
            gradients: ConjugateGradients::new(positions.len()),
            operations: 0.0,
            fixed: vec![false; positions.len()],
            right_side: zeros.clone(),
            solution: zeros,
            positions,
        };
        solver.make_room();
        solver
    }

    /// Memory for the numbers of the first method, now and not with the first matrix: new memory takes as long as a factor.
    fn make_room(&mut self) {
        if let (Method::FactorF32, Some(symbolic)) = (self.first, self.symbolic.get()) {
            self.single = Some(Box::new(Factor::new(symbolic.clone())));
        }
    }

    /// Takes over the numbers of `matrix`, with rows and columns of the nodes marked in `fixed` those of the identity.
    ///
    /// # Errors
    /// When the matrix shows not to be positive definite. With two levels it may show in [`solve`](Self::solve) only.
    pub fn factorise(&mut self, matrix: &BlockMatrix, fixed: &[bool]) -> Result<(), NotPositive> {
        self.fixed.copy_from_slice(fixed);
        self.prepare(matrix, self.first)
    }

    /// Whether an f64 factor costs about as much as a few solutions: [`factorise_f64`](Self::factorise_f64) is no
    /// luxury then.
    pub fn is_small(&self) -> bool {
        let few = |symbolic: &Arc<Symbolic>| symbolic.flops() <= FEW;
        self.first == Method::FactorF32 && self.symbolic.get().is_some_and(few)
    }

    /// As [`factorise`](Self::factorise), with an f64 factor: solutions are exact to rounding.
    ///
    /// # Errors
    /// When the matrix shows not to be positive definite.
    pub fn factorise_f64(
        &mut self,
        matrix: &BlockMatrix,
        fixed: &[bool],
    ) -> Result<(), NotPositive> {
        self.fixed.copy_from_slice(fixed);
        self.prepare(matrix, Method::FactorF64)
    }

    /// The name of the first method, for reports.
    pub fn method_name(&self) -> &'static str {
        match self.first {
            Method::TwoLevel => "two levels",
            Method::FactorF32 | Method::FactorF64 => "factor",
        }
    }

    /// Bytes of the numbers and places of the methods that were needed so far.
    pub fn bytes(&self) -> usize {
        let entries = self.symbolic.get().map_or(0, |symbolic| {
            symbolic.factor_entries() + symbolic.workspace_entries()
        });
        let two_level = self
            .two_level
            .as_ref()
            .map_or(0, |two_level| two_level.bytes());
        let single = self.single.as_ref().map_or(0, |_| 4 * entries);
        let double = self.double.as_ref().map_or(0, |_| 8 * entries);
        two_level + single + double + 8 * size_of_val(&*self.solution)
    }

    /// Takes over the numbers of `matrix` for `method`, or for the first one after it that can.
    fn prepare(&mut self, matrix: &BlockMatrix, method: Method) -> Result<(), NotPositive> {
        self.method = method;
        let fixed = &*self.fixed;
        let (pattern, positions) = (matrix.pattern(), &self.positions);
        let symbolic = || {
            self.symbolic
                .get_or_init(|| analyse(pattern, positions))
                .clone()
        };
        self.operations += match method {
            Method::TwoLevel => STREAMED * REFRESH * pattern.blocks() as f64,
            Method::FactorF32 => 0.5 * symbolic().flops(),
            Method::FactorF64 => symbolic().flops(),
        };
        match method {
            Method::TwoLevel => self
                .two_level
                .get_or_insert_with(|| Box::new(two_level(matrix.pattern(), &self.positions)))
                .refresh(matrix, fixed),
            Method::FactorF32 => {
                let single = self
                    .single
                    .get_or_insert_with(|| Box::new(Factor::new(symbolic())));
                if single.factorise(matrix, Some(fixed)).is_ok() {
                    return Ok(());
                }
                // The precision of f32 may be too low.
                self.prepare(matrix, Method::FactorF64)
            }
            Method::FactorF64 => self
                .double
                .get_or_insert_with(|| Box::new(Factor::new(symbolic())))
                .factorise(matrix, Some(fixed)),
        }
    }

    /// Solves with `matrix`, that of the last [`factorise`](Self::factorise), in place, until what is left is at most `tolerance` of
    /// the right-hand side. Fixed nodes keep their entry, which has no effect on the others.
    ///
    /// # Errors
    /// When the matrix shows not to be positive definite; `x` is as before.
    ///
    /// # Panics
    /// When `x` does not have one entry per node, or before the first [`factorise`](Self::factorise).
    pub fn solve(
        &mut self,
        matrix: &BlockMatrix,
        x: &mut [Vector3<f64>],
        tolerance: f64,
    ) -> Result<(), NotPositive> {
        assert_eq!(x.len(), self.fixed.len(), "one vector per node");
        self.set_right_side(x);
        while !self.attempt(matrix, None, tolerance)? {
            self.prepare(matrix, self.next_method())?;
        }
        self.give(x);
        Ok(())
    }

    /// As [`solve`](Self::solve), for the sum of `matrix` and a symmetric one that `add` stands for: it adds its product with the first
    /// vector to the second one. The sum is positive definite; few of its eigenvalues, relative to `matrix`, are far from 1. The
    /// last method ends after a limited number of iterations with the solution that it has, which is closer than none.
    ///
    /// # Errors
    /// When the sum, or the matrix, shows not to be positive definite; `x` is as before.
    ///
    /// # Panics
    /// As [`solve`](Self::solve).
    pub fn solve_with(
        &mut self,
        matrix: &BlockMatrix,
        mut add: impl FnMut(&[Vector3<f64>], &mut [Vector3<f64>]),
        x: &mut [Vector3<f64>],
        tolerance: f64,
    ) -> Result<(), NotPositive> {
        assert_eq!(x.len(), self.fixed.len(), "one vector per node");
        self.set_right_side(x);
        while !self.attempt(matrix, Some(&mut add), tolerance)? && self.method != Method::FactorF64
        {
            self.prepare(matrix, self.next_method())?;
        }
        self.give(x);
        Ok(())
    }

    /// Sets `compliance` to J A⁻¹ Jᵀ, row by row, with the matrix A of the last [`factorise`](Self::factorise), to the accuracy of its
    /// factor; each row of J has the vectors of up to four nodes. Those at fixed nodes count as 0. Returns whether there is a factor;
    /// if not nothing is done.
    pub fn set_compliance(
        &mut self,
        rows: &[[(u32, Vector3<f64>); 4]],
        compliance: &mut Vec<f64>,
    ) -> bool {
        let fixed = &self.fixed;
        let known = match (self.method, &mut self.single, &mut self.double) {
            (Method::FactorF32, Some(factor), _) => factor.set_compliance(rows, fixed, compliance),
            (Method::FactorF64, _, Some(factor)) => factor.set_compliance(rows, fixed, compliance),
            _ => return false,
        };
        self.operations +=
            self.compliance_operations(rows.len()) - self.compliance_operations(known);
        true
    }

    /// Pairs of an addition and a multiplication since this was asked for last, as many as the dense kernels of a factor do in the same time: a
    /// count, and so the same on every machine.
    pub fn take_operations(&mut self) -> f64 {
        std::mem::take(&mut self.operations)
    }

    /// The same, without resetting it.
    pub fn operations(&self) -> f64 {
        self.operations
    }

    /// Operations of taking over a matrix for the first method.
    pub fn factor_operations(&self, pattern: &Pattern) -> f64 {
        match (self.first, self.symbolic.get()) {
            (Method::FactorF32 | Method::FactorF64, Some(symbolic)) => symbolic.flops(),
            _ => STREAMED * REFRESH * pattern.blocks() as f64,
        }
    }

    /// The numbers that one solution, or one application of the preconditioner, goes over.
    fn solution_entries(&self) -> f64 {
        let entries = |symbolic: &Arc<Symbolic>| 2.0 * symbolic.factor_entries() as f64;
        match (self.method, self.symbolic.get(), &self.two_level) {
            (Method::TwoLevel, _, Some(two_level)) => two_level.bytes() as f64 / 4.0,
            (_, Some(symbolic), _) => entries(symbolic),
            _ => 0.0,
        }
    }

    /// Operations of a compliance of so many rows; 0 where the first method has no factor.
    pub fn compliance_operations(&self, rows: usize) -> f64 {
        match (self.first, self.symbolic.get()) {
            (Method::FactorF32 | Method::FactorF64, Some(symbolic)) => {
                let (count, nodes) = (rows as f64, self.fixed.len() as f64);
                count * symbolic.factor_entries() as f64 + 1.5 * count * count * nodes
            }
            _ => 0.0,
        }
    }

    fn next_method(&self) -> Method {
        match self.method {
            Method::TwoLevel => Method::FactorF32,
            Method::FactorF32 | Method::FactorF64 => Method::FactorF64,
        }
    }

    fn set_right_side(&mut self, x: &[Vector3<f64>]) {
        for ((b, x), fixed) in self.right_side.iter_mut().zip(x).zip(&self.fixed) {
            *b = if *fixed { Vector3::zeros() } else { *x };
        }
    }

    fn give(&self, x: &mut [Vector3<f64>]) {
        for ((x, solution), fixed) in x.iter_mut().zip(&self.solution).zip(&self.fixed) {
            if !fixed {
                *x = *solution;
            }
        }
    }

    /// Solves by the present method; returns whether it reached the tolerance.
    fn attempt(
        &mut self,
        matrix: &BlockMatrix,
        mut add: Option<Add<'_>>,
        tolerance: f64,
    ) -> Result<bool, NotPositive> {
        let Self {
            two_level,
            single,
            double,
            gradients,
            fixed,
            right_side,
            solution,
            ..
        } = self;
        let more = if add.is_some() { ITERATIONS_MORE } else { 0 };
        let apply = |p: &[Vector3<f64>], q: &mut [Vector3<f64>]| {
            matrix.multiply(p, q);
            if let Some(add) = &mut add {
                add(p, q);
            }
            for (q, fixed) in q.iter_mut().zip(&*fixed) {
                if *fixed {
                    *q = Vector3::zeros();
                }
            }
        };
        solution.fill(Vector3::zeros());
        let outcome = match (self.method, two_level, single, double) {
            (Method::TwoLevel, Some(two_level), _, _) => gradients.solve(
                apply,
                |r, z| two_level.apply(r, z),
                right_side,
                solution,
                tolerance,
                ITERATIONS_TWO_LEVEL + more,
            ),
            (Method::FactorF32, _, Some(single), _) => gradients.solve(
                apply,
                |r, z| {
                    z.copy_from_slice(r);
                    single.solve(z);
                },
                right_side,
                solution,
                tolerance,
                ITERATIONS_SINGLE + more,
            ),
            (_, _, _, Some(double)) if more > 0 => gradients.solve(
                apply,
                |r, z| {
                    z.copy_from_slice(r);
                    double.solve(z);
                },
                right_side,
                solution,
                tolerance,
                more,
            ),
            (_, _, _, Some(double)) => {
                solution.copy_from_slice(right_side);
                double.solve(solution);
                self.operations += STREAMED * self.solution_entries();
                return Ok(true);
            }
            _ => panic!("`factorise` comes before `solve`"),
        };
        let (products, solution) = (
            9.0 * matrix.pattern().blocks() as f64,
            self.solution_entries(),
        );
        let once = STREAMED * (products + solution);
        self.operations += once * outcome.iterations as f64;
        match outcome.negative_curvature {
            Some(node) => Err(NotPositive { node }),
            None => Ok(outcome.converged),
        }
    }
}

impl Clone for LinearSolver {
    /// Numbers belong to one matrix, so they are not copied.
    fn clone(&self) -> Self {
        let mut solver = Self {
            symbolic: self.symbolic.clone(),
            positions: self.positions.clone(),
            origin: self.origin,
            first: self.first,
            method: self.first,
            two_level: self.two_level.clone(),
            single: None,
            double: None,
            gradients: ConjugateGradients::new(self.positions.len()),
            operations: 0.0,
            fixed: vec![false; self.positions.len()],
            right_side: self.right_side.clone(),
            solution: self.solution.clone(),
        };
        solver.make_room();
        solver
    }
}

/// What a factor of matrices with a pattern is like.
fn analyse(pattern: &Arc<Pattern>, positions: &[Vector3<f64>]) -> Arc<Symbolic> {
    let ordering = Ordering::nested_dissection(pattern, Some(positions));
    Arc::new(Symbolic::analyse(pattern, &ordering))
}

fn first_method(symbolic: &Symbolic, pattern: &Pattern) -> Method {
    if symbolic.flops() > OPERATIONS * pattern.blocks() as f64 {
        Method::TwoLevel
    } else {
        Method::FactorF32
    }
}

fn two_level(pattern: &Arc<Pattern>, positions: &[Vector3<f64>]) -> TwoLevel {
    let spacing = SPACING * distance(pattern, positions);
    TwoLevel::new(pattern, Lattice::new(positions, spacing))
}

/// The mean distance of nodes \[m\]: the edge of the cubes that fill as much as the nodes do, were they the corners of cells of six
/// tetrahedra. Distances of coupled nodes are those of 3 edges, 3 diagonals of faces and 1 of the cube.
fn distance(pattern: &Pattern, positions: &[Vector3<f64>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for i in 0..pattern.nodes() {
        for &j in pattern
            .row(i)
            .split_last()
            .map_or(&[][..], |(_, others)| others)
        {
            sum += (positions[i] - positions[j as usize]).norm();
            count += 1.0;
        }
    }
    let of_a_cube = (3.0 + 3.0 * 2f64.sqrt() + 3f64.sqrt()) / 7.0;
    sum / (count * of_a_cube)
}

#[cfg(test)]
mod tests;
