//! What formulas take that are written once, for one number and for four that are worked on together.
//!
//! Every operation on four numbers is that of the single ones, rounded alike: a result is the same to the bit wherever it is computed.

use crate::lanes::Lanes;
use nalgebra::{Matrix3, Vector3};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or four numbers.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// This number, in every lane.
    fn of(value: f64) -> Self;

    /// The smaller ones; this where the other is no number.
    fn least(self, other: Self) -> Self;

    /// The larger ones; this where the other is no number.
    fn most(self, other: Self) -> Self;

    /// `yes` where this is above the limit, elsewhere `no`.
    fn select_above(self, limit: f64, yes: Self, no: Self) -> Self;

    /// Natural logarithm.
    fn natural_log(self) -> Self;

    /// Cube root.
    fn cube_root(self) -> Self;

    /// 2ⁿ of a whole number n, −1022 to 1023.
    fn power_of_two(self) -> Self;
}

/// Three components.
pub type Three<N> = [N; 3];

/// The columns of a 3×3 matrix.
pub type Columns<N> = [Three<N>; 3];

/// ∂P/∂F, column after column, as [`Matrix9`](crate::law::Matrix9).
pub type Columns9<N> = [[N; 9]; 9];

/// 1.5 · 2⁵²: added to a number it leaves a whole one in the last digits.
pub const WHOLE: f64 = 6_755_399_441_055_744.0;

impl Number for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn least(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    #[inline(always)]
    fn select_above(self, limit: f64, yes: Self, no: Self) -> Self {
        if self > limit { yes } else { no }
    }

    #[inline(always)]
    fn natural_log(self) -> Self {
        libm::log(self)
    }

    #[inline(always)]
    fn cube_root(self) -> Self {
        libm::cbrt(self)
    }

    /// The exponent that its bits hold is n + 1023.
    #[inline(always)]
    fn power_of_two(self) -> Self {
        f64::from_bits((self + WHOLE).to_bits().wrapping_add(1023) << 52)
    }
}

impl Number for Lanes {
    #[inline(always)]
    fn of(value: f64) -> Self {
        Self::splat(value)
    }

    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.min(other)
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline(always)]
    fn select_above(self, limit: f64, yes: Self, no: Self) -> Self {
        self.where_above(Self::splat(limit), yes, no)
    }

    #[inline(always)]
    fn natural_log(self) -> Self {
        Self(self.0.map(libm::log))
    }

    #[inline(always)]
    fn cube_root(self) -> Self {
        Self(self.0.map(libm::cbrt))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self(self.0.map(f64::power_of_two))
    }
}

/// `Σ_k columns[k] v[k]`.
#[inline(always)]
pub fn product<N: Number>(columns: &Columns<N>, v: &Three<N>) -> Three<N> {
    let [a, b, c] = columns;
    let row = |i: usize| a[i] * v[0] + b[i] * v[1] + c[i] * v[2];
    [row(0), row(1), row(2)]
}

/// Scalar product.
#[inline(always)]
pub fn dot<N: Number>(a: &Three<N>, b: &Three<N>) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
#[inline(always)]
pub fn cross<N: Number>(a: &Three<N>, b: &Three<N>) -> Three<N> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Sum of the squares of all entries.
#[inline(always)]
pub fn norm_squared<N: Number>(columns: &Columns<N>) -> N {
    let [a, b, c] = columns;
    dot(a, a) + dot(b, b) + dot(c, c)
}

/// Each entry by a function of its column and row.
#[inline(always)]
pub fn columns<N>(entry: impl Fn(usize, usize) -> N) -> Columns<N> {
    let column = |k: usize| [entry(k, 0), entry(k, 1), entry(k, 2)];
    [column(0), column(1), column(2)]
}

/// The entries, column after column.
#[inline(always)]
pub fn entries<N: Number>([a, b, c]: &Columns<N>) -> [N; 9] {
    [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]
}

/// Adds factor·n nᵀ.
#[inline(always)]
pub fn add_outer<N: Number>(sum: &mut Columns9<N>, n: &[N; 9], factor: N) {
    for (column, entry) in sum.iter_mut().zip(n) {
        let along = *entry * factor;
        for (sum, n) in column.iter_mut().zip(n) {
            *sum = *sum + *n * along;
        }
    }
}

/// The columns of one matrix.
#[inline(always)]
pub fn columns_of(m: &Matrix3<f64>) -> Columns<f64> {
    m.data.0
}

/// The components of vectors.
#[inline(always)]
pub fn components_of<const COUNT: usize>(vectors: &[Vector3<f64>; COUNT]) -> [Three<f64>; COUNT] {
    vectors.map(|v| [v[0], v[1], v[2]])
}
