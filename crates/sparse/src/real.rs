//! The two kinds of numbers that a factor can be made of, and their products in tiles of eight by eight.
//!
//! `f32` takes half the memory and about half the time; its factor is a preconditioner for
//! [`ConjugateGradients`](crate::ConjugateGradients), which needs two or three iterations then.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// `f64` or `f32`.
pub trait Real:
    Copy
    + Debug
    + PartialOrd
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + Products
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// The distance from 1 to the next number.
    const EPSILON: Self;

    /// The nearest number.
    fn from_f64(value: f64) -> Self;

    /// The same number.
    fn to_f64(self) -> f64;

    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;

    /// self·a + b, rounded once.
    fn mul_add(self, a: Self, b: Self) -> Self;

    /// Whether it is a number and not infinite.
    fn is_finite(self) -> bool;
}

pub(crate) mod sealed {
    use super::{Octet, Tile};

    /// Tiles of products.
    pub trait Products: Sized {
        /// A Bᵀ of two strips; `WIDE` where registers hold 512 bits.
        fn product<const WIDE: bool>(a: &[Octet<Self>], b: &[Octet<Self>]) -> Tile<Self>;
    }
}
pub(crate) use sealed::Products;

/// One column of a strip: eight rows. Aligned so that a load never crosses a cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Octet<T>(pub [T; WIDTH]);

impl<T: Real> Octet<T> {
    pub const ZERO: Self = Self([T::ZERO; WIDTH]);
}

/// Rows of a strip, and columns of a tile.
pub const WIDTH: usize = 8;

/// Eight columns of a strip.
pub type Tile<T> = [Octet<T>; WIDTH];

/// Columns `first..first + C` of the tile A Bᵀ: entry (row r of a, row c of b) = Σ_p a_rp b_cp, at column c, lane r.
#[inline(always)]
fn columns_of_product<T: Real, const C: usize>(
    a: &[Octet<T>],
    b: &[Octet<T>],
    first: usize,
) -> [Octet<T>; C] {
    let mut tile = [[T::ZERO; WIDTH]; C];
    for (a, b) in a.iter().zip(b) {
        for (c, column) in tile.iter_mut().enumerate() {
            let b = b.0[first + c];
            for (sum, a) in column.iter_mut().zip(&a.0) {
                *sum = a.mul_add(b, *sum);
            }
        }
    }
    tile.map(Octet)
}

/// Columns of a tile of f64 that fill eight registers of 256 bits.
const HALF: usize = WIDTH / 2;

impl Products for f64 {
    #[inline(always)]
    fn product<const WIDE: bool>(a: &[Octet<f64>], b: &[Octet<f64>]) -> Tile<f64> {
        if WIDE {
            return columns_of_product::<f64, WIDTH>(a, b, 0);
        }
        let left = columns_of_product::<f64, HALF>(a, b, 0);
        let right = columns_of_product::<f64, HALF>(a, b, HALF);
        let mut tile = [Octet::ZERO; WIDTH];
        tile[..HALF].copy_from_slice(&left);
        tile[HALF..].copy_from_slice(&right);
        tile
    }
}

impl Products for f32 {
    #[inline(always)]
    fn product<const WIDE: bool>(a: &[Octet<f32>], b: &[Octet<f32>]) -> Tile<f32> {
        columns_of_product::<f32, WIDTH>(a, b, 0)
    }
}

macro_rules! real {
    ($number:ident) => {
        impl Real for $number {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $number::EPSILON;

            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $number
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                $number::sqrt(self)
            }

            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                $number::mul_add(self, a, b)
            }

            #[inline(always)]
            fn is_finite(self) -> bool {
                $number::is_finite(self)
            }
        }
    };
}
real!(f64);
real!(f32);
