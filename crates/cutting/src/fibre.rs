//! The direction of a shred.

use nalgebra::Vector3;

/// The direction in which a shred is stretched most, of length 1: at rest, and now. Its sign means nothing.
pub type Fibre = [Vector3<f64>; 2];
