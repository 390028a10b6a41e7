//! Four numbers that are worked on together, one of each of four elements.
//!
//! Every operation is that of the single numbers, rounded alike: a result does not depend on which element stands beside which.

use std::ops::{Add, Mul, Neg, Sub};

/// Numbers worked on together: as many as fill a register of 256 bits.
pub const LANES: usize = 4;

/// Four numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// One number four times.
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self([value; LANES])
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

/// Σ_k columns[k] v[k], written out so that it is inlined.
#[inline(always)]
pub fn product_of_four(columns: &[FourVectors; 3], v: &FourVectors) -> FourVectors {
    let [a, b, c] = columns;
    let row = |i: usize| a[i] * v[0] + b[i] * v[1] + c[i] * v[2];
    [row(0), row(1), row(2)]
}

/// Scalar products.
#[inline(always)]
pub fn dot_of_four(a: &FourVectors, b: &FourVectors) -> Lanes {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector products.
#[inline(always)]
pub fn cross_of_four(a: &FourVectors, b: &FourVectors) -> FourVectors {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
