//! The two kinds of numbers that a factor can be made of.
//!
//! `f32` takes half the memory and about half the time; its factor is a preconditioner for
//! [`ConjugateGradients`](crate::ConjugateGradients), which needs two or three iterations then.

use crate::kernels::{Octet, Tile, WIDTH, columns_of_product};
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
    use crate::kernels::{Octet, Tile};

    /// Tiles of products.
    pub trait Products: Sized {
        /// A Bᵀ of two strips.
        fn product(a: &[Octet<Self>], b: &[Octet<Self>]) -> Tile<Self>;
    }
}
pub(crate) use sealed::Products;

/// Columns of a tile of f64 that fill eight registers.
const HALF: usize = WIDTH / 2;

impl Products for f64 {
    #[inline(always)]
    fn product(a: &[Octet<f64>], b: &[Octet<f64>]) -> Tile<f64> {
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
    fn product(a: &[Octet<f32>], b: &[Octet<f32>]) -> Tile<f32> {
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
