//! The crossing of a blade with an edge of the mesh, and the displacement of blades.

use nalgebra::Vector3;

/// Displacement of the blade over the mean edge: far above the rounding of coordinates, far below what can be seen.
const DISPLACEMENT: f64 = 1e-9;

/// A direction in no plane that a scene would be built along.
const DIRECTION: [f64; 3] = [0.524_178_3, 0.713_926_1, 0.464_235_7];

/// Where an edge is crossed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Where on the edge, from its first node to its second, 0..1.
    pub fraction: f64,
    /// Whether the second node lies on the positive side.
    pub positive: bool,
    /// Whether that is certain: the step and the steady direction of the blade agree in it.
    pub is_certain: bool,
    /// Normal of the path there, towards the positive side: of a blade that moves its direction × its displacement relative to the
    /// edge \[m\], of a sheet that of its triangle, of any length.
    pub normal: Vector3<f64>,
}

impl Crossing {
    /// The side on which the end of the edge with this number lies.
    pub(crate) fn side_of_end(&self, end: usize) -> i8 {
        if self.positive == (end == 1) { 1 } else { -1 }
    }
}

/// By how much a blade is displaced.
pub(crate) fn displacement(mean_edge: f64) -> Vector3<f64> {
    Vector3::from(DIRECTION) * (DISPLACEMENT * mean_edge)
}
