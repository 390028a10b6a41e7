//! Plain length and volume energies (4.1, 4.2) and their gradients.
//!
//! Free functions of explicit arguments; forces are the negative gradients. "Plain" means E = ½ k C² with C in metres or
//! cubic metres; how k follows from moduli so that it does not depend on the mesh stands in `model`.

use microsim_mesh::signed_volume;
use nalgebra::Vector3;

/// A spring shorter than this share of its rest length has no usable direction and exerts no force.
const COLLAPSED: f64 = 1e-12;

/// Length energy ½ k (|p1 − p0| − L0)² [J] (4.1); `rest_length` L0 [m], `stiffness` k [N/m].
pub fn length_energy(p: [&Vector3<f64>; 2], rest_length: f64, stiffness: f64) -> f64 {
    let c = (p[1] - p[0]).norm() - rest_length;
    0.5 * stiffness * c * c
}

/// Gradient of [`length_energy`] by p1 [N]; the gradient by p0 is its negative.
#[inline]
pub fn length_gradient(p: [&Vector3<f64>; 2], rest_length: f64, stiffness: f64) -> Vector3<f64> {
    let along = p[1] - p[0];
    let length = along.norm_squared().sqrt();
    if length <= COLLAPSED * rest_length {
        return Vector3::zeros();
    }
    along * (stiffness * (length - rest_length) / length)
}

/// Volume energy ½ k (V − V0)² [J] (4.2); `rest_volume` V0 [m³], `stiffness` k [N/m⁵].
pub fn volume_energy(p: [&Vector3<f64>; 4], rest_volume: f64, stiffness: f64) -> f64 {
    let c = signed_volume(p[0], p[1], p[2], p[3]) - rest_volume;
    0.5 * stiffness * c * c
}

/// Gradient of the signed volume by the four corners [m²].
#[inline]
pub fn volume_derivative(p: [&Vector3<f64>; 4]) -> [Vector3<f64>; 4] {
    let (e1, e2, e3) = (p[1] - p[0], p[2] - p[0], p[3] - p[0]);
    let g1 = e2.cross(&e3) / 6.0;
    let g2 = e3.cross(&e1) / 6.0;
    let g3 = e1.cross(&e2) / 6.0;
    [-(g1 + g2 + g3), g1, g2, g3]
}

/// Gradient of [`volume_energy`] by the four corners [N]. It pushes an inverted tetrahedron back.
#[inline]
pub fn volume_gradient(
    p: [&Vector3<f64>; 4],
    rest_volume: f64,
    stiffness: f64,
) -> [Vector3<f64>; 4] {
    let derivative = volume_derivative(p);
    // V = e1·(e2×e3)/6 = e1·∂V/∂p1.
    let volume = (p[1] - p[0]).dot(&derivative[1]);
    derivative.map(|g| g * (stiffness * (volume - rest_volume)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fixed sequence of numbers in −1..1.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        move || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    fn corners<const N: usize>(next: &mut impl FnMut() -> f64) -> [Vector3<f64>; N] {
        std::array::from_fn(|_| Vector3::new(next(), next(), next()))
    }

    /// Central differences: truncation δ²·|f'''|/6 with δ = 1e-5 and rounding ε/δ both stay below 1e-9 of the gradient's
    /// scale for coordinates of order one.
    fn check_gradient<const N: usize>(
        p: [Vector3<f64>; N],
        energy: impl Fn(&[Vector3<f64>; N]) -> f64,
        gradient: [Vector3<f64>; N],
    ) {
        const DELTA: f64 = 1e-5;
        let scale = gradient.iter().map(|g| g.norm()).fold(energy(&p), f64::max);
        for node in 0..N {
            for axis in 0..3 {
                let (mut low, mut high) = (p, p);
                low[node][axis] -= DELTA;
                high[node][axis] += DELTA;
                let difference = (energy(&high) - energy(&low)) / (2.0 * DELTA);
                let error = (difference - gradient[node][axis]).abs();
                assert!(
                    error < 1e-8 * scale,
                    "node {node} axis {axis}: {error} of {scale}"
                );
            }
        }
        // Momentum: Σ g = 0 and Σ p×g = 0.
        let sum: Vector3<f64> = gradient.iter().sum();
        let moment: Vector3<f64> = p.iter().zip(&gradient).map(|(p, g)| p.cross(g)).sum();
        assert!(
            sum.norm() < 1e-14 * scale && moment.norm() < 1e-14 * scale,
            "{sum} {moment}"
        );
    }

    #[test]
    fn gradients_match_central_differences_and_conserve_momentum() {
        let mut next = numbers();
        let mut signs = [false; 2];
        for _ in 0..200 {
            let (rest, k) = (0.6 + 0.5 * next(), 2.0 + next());
            let p: [_; 2] = corners(&mut next);
            if (p[1] - p[0]).norm() > 0.2 {
                let g = length_gradient([&p[0], &p[1]], rest, k);
                check_gradient(p, |p| length_energy([&p[0], &p[1]], rest, k), [-g, g]);
            }
            let p: [_; 4] = corners(&mut next);
            signs[usize::from(signed_volume(&p[0], &p[1], &p[2], &p[3]) > 0.0)] = true;
            let g = volume_gradient(p.each_ref(), rest, k);
            check_gradient(p, |p| volume_energy(p.each_ref(), rest, k), g);
        }
        assert_eq!(signs, [true; 2], "both signs of the volume were tried");
    }

    #[test]
    fn the_rest_state_has_no_energy_and_no_force() {
        let p: [_; 4] = corners(&mut numbers());
        let (length, volume) = (
            (p[1] - p[0]).norm(),
            signed_volume(&p[0], &p[1], &p[2], &p[3]),
        );
        assert_eq!(length_energy([&p[0], &p[1]], length, 3.0), 0.0);
        assert_eq!(
            length_gradient([&p[0], &p[1]], length, 3.0),
            Vector3::zeros()
        );
        assert_eq!(volume_energy(p.each_ref(), volume, 3.0), 0.0);
        assert!(
            volume_gradient(p.each_ref(), volume, 3.0)
                .iter()
                .all(|g| g.norm() < 1e-15)
        );
        assert_eq!(
            length_gradient([&p[0], &p[0]], length, 3.0),
            Vector3::zeros(),
            "a collapsed spring"
        );
    }

    #[test]
    fn the_volume_force_turns_a_flat_and_an_inverted_tetrahedron_back() {
        let base = [Vector3::zeros(), Vector3::x(), Vector3::y()];
        for height in [0.0, -0.5, -1.0] {
            let tip = Vector3::z() * height;
            let g = volume_gradient([&base[0], &base[1], &base[2], &tip], 1.0 / 6.0, 1.0);
            assert!(
                -g[3].z > 0.0,
                "the force on the tip points to the positive side"
            );
        }
    }
}
