//! Four numbers that are worked on together, one of each of four elements.
//!
//! Every operation is that of the single numbers, rounded alike: a result does not depend on which element stands beside which.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers worked on together: as many as fill a register of 256 bits.
pub const LANES: usize = 4;

/// Four numbers that are computed with at once.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// One number four times.
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// √.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    /// |·|.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
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
    fn with(mut self, other: Self, each: impl Fn(f64, f64) -> f64) -> Self {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a = each(*a, *b);
        }
        self
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

/// `Σ_k columns[k] v[k]`, written out so that it is inlined.
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
