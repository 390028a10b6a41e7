//! Directions of tools and of objects that lie along a line.

/// The z axis of a frame with this orientation (unit quaternion x, y, z, w): from tip to handle of a tool, along a capsule.
pub fn axis([x, y, z, w]: [f64; 4]) -> [f64; 3] {
    [
        2.0 * (x * z + w * y),
        2.0 * (y * z - w * x),
        1.0 - 2.0 * (x * x + y * y),
    ]
}

/// The shortest rotation that turns +z into `direction`, which has length 1 and is not −z.
///
/// ```
/// let orientation = microsim_sdk::turned_to([0.6, 0.0, 0.8]);
/// let [x, _, z] = microsim_sdk::axis(orientation);
/// assert!((x - 0.6).abs() < 1e-15 && (z - 0.8).abs() < 1e-15);
/// ```
pub fn turned_to([x, y, z]: [f64; 3]) -> [f64; 4] {
    let q = [-y, x, 0.0, 1.0 + z];
    let length = (q[0] * q[0] + q[1] * q[1] + q[3] * q[3]).sqrt();
    q.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_of_what_is_turned_to_a_direction_is_that_direction() {
        for direction in [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [0.48, -0.6, -0.64]] {
            let back = axis(turned_to(direction));
            // Tolerance: rounding of a dozen operations on numbers up to 1.
            assert!(
                back.iter()
                    .zip(direction)
                    .all(|(a, b)| (a - b).abs() < 1e-15),
                "{back:?}"
            );
        }
    }
}
