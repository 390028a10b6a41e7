//! Four numbers that are worked on together, one of each of four elements.
//!
//! Every operation is that of the single numbers, rounded alike: a result does not depend on which element stands beside which.

use nalgebra::{Matrix3, SMatrix, Vector3};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers worked on together: as many as fill a register of 256 bits.
pub const LANES: usize = 4;

/// Four numbers that are computed with at once.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Lanes(pub [f64; LANES]);

/// A value for each lane. Unlike the `map` of an array it is always inlined.
#[inline(always)]
pub fn lanes<T>(of: impl Fn(usize) -> T) -> [T; LANES] {
    [of(0), of(1), of(2), of(3)]
}

impl Lanes {
    /// One number four times.
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// √.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(lanes(|lane| self.0[lane].sqrt()))
    }

    /// |·|.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(lanes(|lane| self.0[lane].abs()))
    }

    /// Each with the sign of the one in `sign`.
    #[inline(always)]
    pub fn copysign(self, sign: Self) -> Self {
        self.with(sign, f64::copysign)
    }

    /// The smaller ones.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.with(other, |a, b| if b < a { b } else { a })
    }

    /// The larger ones.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.with(other, |a, b| if b > a { b } else { a })
    }

    /// Where these are above `limit` the numbers `yes`, elsewhere `no`.
    #[inline(always)]
    pub fn where_above(self, limit: Self, yes: Self, no: Self) -> Self {
        let mut chosen = no;
        for lane in 0..LANES {
            if self.0[lane] > limit.0[lane] {
                chosen.0[lane] = yes.0[lane];
            }
        }
        chosen
    }

    #[inline(always)]
    fn with(self, other: Self, each: impl Fn(f64, f64) -> f64) -> Self {
        Self(lanes(|lane| each(self.0[lane], other.0[lane])))
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a += b;
        }
        self
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a -= b;
        }
        self
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a *= b;
        }
        self
    }
}

impl Div for Lanes {
    type Output = Self;

    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a /= b;
        }
        self
    }
}

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(mut self) -> Self {
        for a in &mut self.0 {
            *a = -*a;
        }
        self
    }
}

/// Three components of four vectors.
pub type FourVectors = [Lanes; 3];

/// One of four vectors.
#[inline(always)]
pub fn vector_of(v: &FourVectors, lane: usize) -> Vector3<f64> {
    Vector3::new(v[0].0[lane], v[1].0[lane], v[2].0[lane])
}

/// Makes this vector one of four.
#[inline(always)]
pub fn set_vector(v: &mut FourVectors, lane: usize, one: &Vector3<f64>) {
    for (i, lanes) in v.iter_mut().enumerate() {
        lanes.0[lane] = one[i];
    }
}

/// One of four matrices, of which there are the columns.
#[inline(always)]
pub fn matrix_of(m: &[FourVectors; 3], lane: usize) -> Matrix3<f64> {
    Matrix3::from_fn(|i, k| m[k][i].0[lane])
}

/// Makes this matrix one of four.
#[inline(always)]
pub fn set_matrix(m: &mut [FourVectors; 3], lane: usize, one: &Matrix3<f64>) {
    for (k, column) in m.iter_mut().enumerate() {
        for (i, lanes) in column.iter_mut().enumerate() {
            lanes.0[lane] = one[(i, k)];
        }
    }
}

/// The columns of four matrices.
#[inline(always)]
pub fn four_columns(m: &[Matrix3<f64>; LANES]) -> [FourVectors; 3] {
    [0, 1, 2].map(|k| [0, 1, 2].map(|i| Lanes(m.each_ref().map(|m| m[(i, k)]))))
}

/// Four tangents ∂P/∂F, column after column.
pub type FourTangents = [[Lanes; 9]; 9];

/// One of four tangents.
#[inline(always)]
pub fn tangent_of(tangents: &FourTangents, lane: usize) -> SMatrix<f64, 9, 9> {
    SMatrix::from_fn(|p, q| tangents[q][p].0[lane])
}

/// Makes this tangent one of four.
#[inline(always)]
pub fn put_tangent(tangents: &mut FourTangents, lane: usize, one: &SMatrix<f64, 9, 9>) {
    let ones = one.as_slice().chunks_exact(9);
    for (column, ones) in tangents.iter_mut().zip(ones) {
        for (lanes, one) in column.iter_mut().zip(ones) {
            lanes.0[lane] = *one;
        }
    }
}
