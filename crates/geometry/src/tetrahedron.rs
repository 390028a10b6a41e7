//! Points in tetrahedra.

use nalgebra::Vector3;

/// A point counts as inside when no barycentric coordinate is below minus this: it may lie outside of a face by this fraction of
/// the tetrahedron's height over that face, so that a point on a common face is never outside of both neighbours.
pub const INSIDE_TOLERANCE: f64 = 1e-9;

/// A tetrahedron of a volume below this fraction of the cube of its longest edge L, over 6, is flat.
///
/// A triple product of vectors up to √3 L, which is how far points in its box are from a corner, is rounded by
/// less than 2e-15 L³, and three of them go into the fourth coordinate: with 6 V ≥ 1e-5 L³ no coordinate is
/// wrong by more than 6e-15 / 1e-5 = 6e-10, less than the tolerance.
const FLAT: f64 = 1e-5;

/// The barycentric coordinates of `p` in the tetrahedron, in the order of its corners, when `p` is inside: A.20–A.23 as four
/// signed volumes (NUMERICS 1.5). Faces, edges and corners count as inside.
///
/// `None` as well when the tetrahedron is flat or left-handed (inverted): such a one has no inside (NUMERICS 6).
pub fn point_in_tetrahedron(p: &Vector3<f64>, corners: &[Vector3<f64>; 4]) -> Option<[f64; 4]> {
    let [a, b, c, d] = corners;
    let (ab, ac, ad, ap) = (b - a, c - a, d - a, p - a);
    let across = ac.cross(&ad);
    let volume = ab.dot(&across);
    // Half of all candidates lie behind the face opposite to the second corner.
    let along_b = ap.dot(&across);
    if !(volume > 0.0 && along_b >= -INSIDE_TOLERANCE * volume) {
        return None;
    }
    let longest = [ab, ac, ad, c - b, d - b, d - c]
        .iter()
        .map(Vector3::norm_squared)
        .fold(0.0, f64::max);
    if volume < FLAT * longest * longest.sqrt() {
        return None;
    }
    let across = ab.cross(&ap);
    let (b1, b2, b3) = (
        along_b / volume,
        across.dot(&ad) / volume,
        -across.dot(&ac) / volume,
    );
    let coordinates = [1.0 - b1 - b2 - b3, b1, b2, b3];
    coordinates
        .iter()
        .all(|&b| b >= -INSIDE_TOLERANCE)
        .then_some(coordinates)
}

#[cfg(test)]
mod tests;
