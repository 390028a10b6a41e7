//! What formulas take that are written once, for one number and for four that are worked on together.
//!
//! Every operation on four numbers is that of the single ones, rounded alike: a result is the same to the bit wherever it is computed. Where sums of products
//! are fused ([`Number::mul_add`]), they are so on every machine.

use crate::lanes::{Lanes, lanes};
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

    /// This times a factor plus a number, rounded once.
    fn mul_add(self, factor: Self, summand: Self) -> Self;

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
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        f64::mul_add(self, factor, summand)
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
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        Self(lanes(|lane| {
            self.0[lane].mul_add(factor.0[lane], summand.0[lane])
        }))
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
        Self(lanes(|lane| libm::log(self.0[lane])))
    }

    #[inline(always)]
    fn cube_root(self) -> Self {
        Self(lanes(|lane| libm::cbrt(self.0[lane])))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self(lanes(|lane| self.0[lane].power_of_two()))
    }
}

/// Three components by their place. Unlike the `map` of an array it is always inlined.
#[inline(always)]
pub fn three<T>(component: impl Fn(usize) -> T) -> [T; 3] {
    [component(0), component(1), component(2)]
}

/// `Σ_k columns[k] v[k]`.
#[inline(always)]
pub fn product<N: Number>(columns: &Columns<N>, v: &Three<N>) -> Three<N> {
    let [a, b, c] = columns;
    three(|i| c[i].mul_add(v[2], b[i].mul_add(v[1], a[i] * v[0])))
}

/// The same with the transpose: the scalar product of each column with `v`.
#[inline(always)]
pub fn transposed_product<N: Number>(columns: &Columns<N>, v: &Three<N>) -> Three<N> {
    three(|k| dot(&columns[k], v))
}

/// Scalar product.
#[inline(always)]
pub fn dot<N: Number>(a: &Three<N>, b: &Three<N>) -> N {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// Vector product. It is not fused, so that that of a vector with itself vanishes and exchanging both changes nothing but the sign.
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
    three(|k| three(|i| entry(k, i)))
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
            *sum = n.mul_add(along, *sum);
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
