//! The linear systems of implicit methods: K + b·D + c·M of a model, assembled, factored, solved.
//!
//! Where the blocks of each element go is found once per model, and so is the order of elimination (nested dissection of the
//! rest shape); a step only adds numbers, in a fixed order. Prescribed nodes are marked when the matrix is factored.
//!
//! The factor is one of single numbers (half the time and memory), and conjugate gradients with it as preconditioner bring the
//! solution to the accuracy wanted; where that takes more than [`ITERATIONS`], as for a very slender body without inertia, or single
//! numbers show no positive pivot, a factor of double numbers solves the system. Nothing is kept from one system to the next.

use crate::elements::{ElementMatrix, MatrixWindow, Slots, Tangent};
use crate::model::TissueModel;
use crate::state::{Pressure, State};
use microsim_sparse::{
    BlockMatrix, Factor, NotPositive, Ordering, Pattern, Symbolic, conjugate_gradients,
};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// Most iterations with the factor of single numbers: by then one of double numbers costs less.
const ITERATIONS: usize = 12;

/// The shares of a matrix K + b·D + c·M.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shares {
    /// b [1/s].
    pub damping: f64,
    /// c [1/s²].
    pub mass: f64,
}

/// A linear system with the pattern of one model.
#[derive(Debug)]
pub(crate) struct System {
    /// Of each set.
    slots: Arc<[Slots]>,
    symbolic: Arc<Symbolic>,
    matrix: BlockMatrix,
    factor: Factor<f32>,
    /// Made when it is needed first.
    exact: Option<Box<Factor<f64>>>,
    /// Whether the last factor is the one of double numbers.
    in_double: bool,
    /// Marks of the prescribed nodes of the last factorisation.
    fixed: Vec<bool>,
    right_side: Vec<Vector3<f64>>,
    solution: Vec<Vector3<f64>>,
    /// Working memory for one element.
    element: ElementMatrix,
}

impl System {
    /// The system of `model`.
    pub fn new(model: &TissueModel) -> Self {
        let cliques = model
            .sets()
            .iter()
            .flat_map(|set| (0..set.count()).map(|element| set.nodes(element)));
        let pattern = Arc::new(Pattern::from_cliques(model.node_count(), cliques));
        let slots = model.sets().iter().map(|set| {
            let elements = (0..set.count()).map(|element| set.nodes(element));
            Slots::new(elements, |row, column| {
                pattern
                    .slot(row as usize, column as usize)
                    .expect("the nodes of an element are coupled")
            })
        });
        let ordering = Ordering::nested_dissection(&pattern, Some(model.rest_positions()));
        let symbolic = Arc::new(Symbolic::analyse(&pattern, &ordering));
        Self {
            slots: slots.collect(),
            factor: Factor::new(symbolic.clone()),
            exact: None,
            in_double: false,
            fixed: vec![false; model.node_count()],
            right_side: vec![Vector3::zeros(); model.node_count()],
            solution: vec![Vector3::zeros(); model.node_count()],
            symbolic,
            matrix: BlockMatrix::zeros(pattern),
            element: ElementMatrix::new(),
        }
    }

    /// Sets the matrix to K + b·D + c·M of the elements at the positions and velocities of `state`.
    pub fn assemble(
        &mut self,
        model: &TissueModel,
        state: &State,
        shares: Shares,
        tangent: Tangent,
    ) {
        self.matrix.clear();
        let values = self.matrix.values_mut();
        for (index, (set, slots)) in model.sets().iter().zip(&*self.slots).enumerate() {
            let at = state.configuration(model, index);
            let viscous = shares.damping > 0.0 && set.is_viscous();
            let mut window = MatrixWindow { slots, values };
            set.add_stiffness(&at, tangent, &mut window);
            if viscous {
                for element in 0..set.count() {
                    set.damping(element, &at, &mut self.element);
                    window.add(element, &self.element, shares.damping);
                }
            }
        }
        if shares.mass > 0.0 {
            for (node, mass) in model.masses().iter().enumerate() {
                let block = Matrix3::from_diagonal_element(shares.mass * mass);
                self.matrix.add_diagonal(node, &block);
            }
        }
    }

    /// Adds the symmetric part of minus the derivative of pressures that follow their surfaces. Over a closed surface, or one with
    /// a prescribed rim, the other part sums to zero. Triangles whose corners no element couples are left out.
    pub fn add_pressures(&mut self, pressures: &[Pressure], positions: &[Vector3<f64>]) {
        for load in pressures {
            for triangle in load.triangles.iter() {
                // Each corner has the force −p/6 n with n the double area vector, ∂n/∂x_j = [e_j]× of the edge across from j.
                let [a, b, c] = triangle.map(|node| positions[node as usize]);
                let edges = [c - b, a - c, b - a];
                for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                    let (i, j) = if triangle[i] >= triangle[j] {
                        (i, j)
                    } else {
                        (j, i)
                    };
                    let [row, column] = [i, j].map(|corner| triangle[corner] as usize);
                    if let Some(slot) = self.matrix.pattern().slot(row, column) {
                        let block = (edges[j] - edges[i]).cross_matrix() * (load.pressure / 12.0);
                        self.matrix.add_slot(slot, &block);
                    }
                }
            }
        }
    }

    /// The assembled matrix.
    pub fn matrix(&self) -> &BlockMatrix {
        &self.matrix
    }

    /// Factors the assembled matrix, with rows and columns of the nodes marked in `fixed` those of the identity.
    pub fn factorise(&mut self, fixed: &[bool]) -> Result<(), NotPositive> {
        self.fixed.copy_from_slice(fixed);
        self.in_double = false;
        if self.factor.factorise(&self.matrix, Some(fixed)).is_err() {
            self.factorise_in_double()?;
        }
        Ok(())
    }

    fn factorise_in_double(&mut self) -> Result<(), NotPositive> {
        self.exact
            .get_or_insert_with(|| Box::new(Factor::new(self.symbolic.clone())))
            .factorise(&self.matrix, Some(&self.fixed))?;
        self.in_double = true;
        Ok(())
    }

    /// Solves with the last factor, in place, until what is left is at most `tolerance` of the right-hand side. Prescribed nodes
    /// keep their entry, which has no effect on the others.
    pub fn solve(&mut self, x: &mut [Vector3<f64>], tolerance: f64) -> Result<(), NotPositive> {
        for ((b, x), fixed) in self.right_side.iter_mut().zip(&*x).zip(&self.fixed) {
            *b = if *fixed { Vector3::zeros() } else { *x };
        }
        if self.in_double || !self.iterate(tolerance) {
            if !self.in_double {
                self.factorise_in_double()?;
            }
            self.solution.copy_from_slice(&self.right_side);
            if let Some(factor) = &mut self.exact {
                factor.solve(&mut self.solution);
            }
        }
        for ((x, solution), fixed) in x.iter_mut().zip(&self.solution).zip(&self.fixed) {
            if !fixed {
                *x = *solution;
            }
        }
        Ok(())
    }

    /// Solves by conjugate gradients with the factor of single numbers; returns whether it came to `tolerance`.
    fn iterate(&mut self, tolerance: f64) -> bool {
        let Self {
            matrix,
            factor,
            fixed,
            ..
        } = self;
        self.solution.fill(Vector3::zeros());
        conjugate_gradients(
            |p, q| {
                matrix.multiply(p, q);
                for (q, fixed) in q.iter_mut().zip(&*fixed) {
                    if *fixed {
                        *q = Vector3::zeros();
                    }
                }
            },
            |r, z| {
                z.copy_from_slice(r);
                factor.solve(z);
            },
            &self.right_side,
            &mut self.solution,
            tolerance,
            ITERATIONS,
        )
        .converged
    }

    /// For each node the lowest node that it is coupled to, directly or through others.
    pub fn components(&self) -> Vec<u32> {
        let pattern = self.matrix.pattern();
        let mut lowest: Vec<u32> = (0..pattern.nodes() as u32).collect();
        let root = |lowest: &mut Vec<u32>, mut node: u32| {
            while lowest[node as usize] != node {
                let next = lowest[lowest[node as usize] as usize];
                lowest[node as usize] = next;
                node = next;
            }
            node
        };
        for row in 0..pattern.nodes() {
            for &column in pattern.row(row) {
                let ends = [row as u32, column].map(|node| root(&mut lowest, node));
                lowest[ends[0].max(ends[1]) as usize] = ends[0].min(ends[1]);
            }
        }
        for node in 0..lowest.len() as u32 {
            lowest[node as usize] = root(&mut lowest, node);
        }
        lowest
    }
}

impl Clone for System {
    /// The numbers of a factor are made anew in each iteration, so they are not copied.
    fn clone(&self) -> Self {
        Self {
            slots: self.slots.clone(),
            symbolic: self.symbolic.clone(),
            matrix: self.matrix.clone(),
            factor: Factor::new(self.symbolic.clone()),
            exact: None,
            in_double: false,
            fixed: self.fixed.clone(),
            right_side: self.right_side.clone(),
            solution: self.solution.clone(),
            element: ElementMatrix::new(),
        }
    }
}
