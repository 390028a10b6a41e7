//! Cutting.
mod pattern;
#[cfg(test)]
mod testing;
pub use pattern::*;
