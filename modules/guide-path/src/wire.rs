//! The wire: a chain of links of equal length along a smooth curve, by level and seed alone, never by a recording.

use microsim_sdk::geometry::Capsule;
use microsim_sdk::{Fault, RandomStream};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Halvings of the interval in which the next joint lies: below rounding.
const HALVINGS: u32 = 60;
/// Amplitude of the second harmonic over that of the first \[-\]: a wire that is no mere wave.
const HARMONIC: f64 = 0.4;

/// How a wire is bent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bends {
    /// Number of links.
    pub links: usize,
    /// Length of a link \[m\].
    pub link: f64,
    /// Radius of the wire \[m\].
    pub radius: f64,
    /// How far it swings across the field and up and down \[m\].
    pub swing: [f64; 2],
    /// Waves along its length.
    pub waves: f64,
}

/// A bent wire.
#[derive(Clone, Debug, PartialEq)]
pub struct Wire {
    joints: Vec<Vector3<f64>>,
    link: f64,
    radius: f64,
}

impl Wire {
    /// The wire of a level for a seed. It runs from left to right, its middle in the middle of the field: its joints lie on the curve
    /// y = Y (sin(k x + a) + 0.4 sin(2 k x + b)) / 1.4, z likewise, with random a and b.
    pub fn bent(seed: u64, bends: Bends) -> Result<Self, Fault> {
        let Bends {
            links,
            link,
            radius,
            swing,
            waves,
        } = bends;
        if links < 4 {
            return Err(Fault::new(
                "the level's object \"wire\" needs a `count` of 4 or more",
            ));
        }
        let mut random = RandomStream::new(seed, "guide-path.wire");
        let phases: [[f64; 2]; 2] =
            std::array::from_fn(|_| std::array::from_fn(|_| random.between(0.0, TAU)));
        let k = TAU * waves / (links as f64 * link);
        let curve = |x: f64| {
            let [y, z]: [f64; 2] = std::array::from_fn(|axis| {
                let [first, second] = phases[axis];
                let wave = libm::sin(k * x + first) + HARMONIC * libm::sin(2.0 * k * x + second);
                swing[axis] * wave / (1.0 + HARMONIC)
            });
            Vector3::new(x, y, z)
        };
        let mut x = 0.0;
        let mut joints = vec![curve(x)];
        for _ in 0..links {
            let from = curve(x);
            // At x + link the curve is as far away or farther.
            let (mut near, mut far) = (x, x + link);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (near + far);
                if (curve(middle) - from).norm() < link {
                    near = middle;
                } else {
                    far = middle;
                }
            }
            x = far;
            joints.push(curve(x));
        }
        let shift = Vector3::new(-0.5 * x, 0.0, 0.0);
        for joint in &mut joints {
            *joint += shift;
        }
        Ok(Self {
            joints,
            link,
            radius,
        })
    }

    /// Number of links.
    pub fn len(&self) -> usize {
        self.joints.len() - 1
    }

    /// Never: a wire has links.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Its joints, one more than links \[m\].
    pub fn joints(&self) -> &[Vector3<f64>] {
        &self.joints
    }

    /// Length of the chain \[m\].
    pub fn length(&self) -> f64 {
        self.len() as f64 * self.link
    }

    /// Length of a link \[m\].
    pub fn link(&self) -> f64 {
        self.link
    }

    /// A link.
    pub fn capsule(&self, index: usize) -> Capsule {
        Capsule {
            a: self.joints[index],
            b: self.joints[index + 1],
            radius: self.radius,
        }
    }

    /// The place at a length along the wire \[m\], and the direction of its link.
    pub fn at(&self, length: f64) -> (Vector3<f64>, Vector3<f64>) {
        let links = (length / self.link).clamp(0.0, self.len() as f64);
        let index = (links as usize).min(self.len() - 1);
        let along = (self.joints[index + 1] - self.joints[index]) / self.link;
        let place = self.joints[index] + along * ((links - index as f64) * self.link);
        (place, along)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BENDS: Bends = Bends {
        links: 40,
        link: 0.6e-3,
        radius: 0.25e-3,
        swing: [4e-3, 1.5e-3],
        waves: 1.5,
    };

    #[test]
    fn links_have_one_length_and_stay_within_the_swing() {
        for seed in 0..50 {
            let wire = Wire::bent(seed, BENDS).expect("a wire");
            assert_eq!(wire.len(), 40);
            for pair in wire.joints().windows(2) {
                // Rounding of coordinates of 1e-2 m.
                assert!(
                    ((pair[1] - pair[0]).norm() - BENDS.link).abs() < 1e-16,
                    "{pair:?}"
                );
                assert!(pair[1].x > pair[0].x, "from left to right");
                assert!(pair[1].y.abs() <= 4e-3 && pair[1].z.abs() <= 1.5e-3);
            }
            let (first, last) = (wire.joints()[0], wire.joints()[40]);
            assert!(
                (first.x + last.x).abs() < 1e-17,
                "its middle is that of the field"
            );
        }
    }

    /// The curve's largest second derivative is Y k² (1 + 0.4 · 4) / 1.4 in each direction, and the curvature of a graph is no larger.
    #[test]
    fn no_bend_is_narrower_than_the_level_allows() {
        let k = TAU * BENDS.waves / (40.0 * BENDS.link);
        let across = libm::hypot(BENDS.swing[0], BENDS.swing[1]);
        let bound = across * k * k * (1.0 + 4.0 * HARMONIC) / (1.0 + HARMONIC);
        for seed in 0..50 {
            let wire = Wire::bent(seed, BENDS).expect("a wire");
            for three in wire.joints().windows(3) {
                let (a, b) = (three[1] - three[0], three[2] - three[1]);
                let turn = libm::atan2(a.cross(&b).norm(), a.dot(&b));
                // A chord's turn over its length is a mean of the curvature along the arc, which is at most as much longer as it is steep.
                assert!(
                    turn / BENDS.link < 1.1 * bound,
                    "{}",
                    turn / BENDS.link / bound
                );
            }
        }
    }

    #[test]
    fn the_seed_bends_the_wire_and_places_follow_its_length() {
        let [one, same, other] = [1, 1, 2].map(|seed| Wire::bent(seed, BENDS).expect("a wire"));
        assert_eq!(one, same);
        assert_ne!(one, other);
        let (place, along) = one.at(2.25 * BENDS.link);
        let expected = one.joints()[2] + 0.25 * (one.joints()[3] - one.joints()[2]);
        assert!((place - expected).norm() < 1e-17 && (along.norm() - 1.0).abs() < 1e-12);
        assert_eq!(one.at(1.0).0, one.joints()[40], "beyond its end");
        assert!(Wire::bent(1, Bends { links: 3, ..BENDS }).is_err());
    }
}
