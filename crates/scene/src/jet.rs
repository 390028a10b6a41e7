//! A jet of fluid from the opening of a tool, and what it presses on where nothing surrounds it.
//!
//! In the open the jet presses on the surfaces that face it, as far as its reach and no further than the first surface that its axis
//! meets. There its pressure at rest, the stagnation pressure, acts with the square of the cosine between axis and normal (Newton's
//! law of impact: what counts is the velocity along the normal). It falls to nothing towards its radius and its reach by (1 − u²)²: a
//! judgement, smooth and with an end, for a spray whose spread nobody measured. What is not here: fluid that splashes or runs off, the
//! friction of what flows along a surface, one body in the shadow of another one.

use microsim_geometry::Aabb;
use nalgebra::Vector3;

/// A jet in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jet {
    /// The opening \[m\].
    pub tip: Vector3<f64>,
    /// Where it flows to, of length 1.
    pub direction: Vector3<f64>,
    /// Of the fluid at rest \[Pa\].
    pub pressure: f64,
    /// \[m\]
    pub radius: f64,
    /// \[m\]
    pub reach: f64,
}

impl Jet {
    /// A box around all that it reaches.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(&[self.tip, self.tip + self.direction * self.reach]).inflated(self.radius)
    }

    /// How far the first of these triangles is along its axis \[m\]: the nearest that faces it and that the axis goes through.
    pub fn stop(&self, triangles: &[[u32; 3]], positions: &[Vector3<f64>]) -> f64 {
        let hits = triangles.iter().filter_map(|triangle| {
            let [a, b, c] = triangle.map(|node| positions[node as usize] - self.tip);
            let area = (b - a).cross(&(c - a));
            let facing = area.dot(&self.direction);
            if facing >= 0.0 {
                return None;
            }
            // The axis is on the inner side of all three edges.
            let inside =
                |p: &Vector3<f64>, q: &Vector3<f64>| p.cross(q).dot(&self.direction) <= 0.0;
            let distance = area.dot(&a) / facing;
            let is_hit = inside(&a, &b) && inside(&b, &c) && inside(&c, &a) && distance >= 0.0;
            is_hit.then_some(distance)
        });
        hits.fold(f64::INFINITY, f64::min)
    }

    /// The pressure on a triangle with these outward corners \[Pa\], where the axis is stopped at `stop` \[m\].
    pub fn pressure_on(&self, corners: [Vector3<f64>; 3], stop: f64) -> f64 {
        let [a, b, c] = corners;
        let area = (b - a).cross(&(c - a));
        let facing = -area.dot(&self.direction);
        let from = (a + b + c) / 3.0 - self.tip;
        let along = from.dot(&self.direction);
        let across = (from - self.direction * along).norm();
        let is_reached = facing > 0.0 && along > 0.0 && along < stop + self.radius;
        if !is_reached || along >= self.reach || across >= self.radius {
            return 0.0;
        }
        let fall = |u: f64| (1.0 - u * u) * (1.0 - u * u);
        let cosine = facing / area.norm();
        self.pressure * cosine * cosine * fall(across / self.radius) * fall(along / self.reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 2 across z at the height `z`, of two triangles that face +z (`up`) or −z.
    fn plate(z: f64, up: bool) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
        let corner = |x: f64, y: f64| Vector3::new(x, y, z);
        let corners = vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let triangles = match up {
            true => vec![[0, 1, 2], [0, 2, 3]],
            false => vec![[0, 2, 1], [0, 3, 2]],
        };
        (corners, triangles)
    }

    fn jet() -> Jet {
        Jet {
            tip: Vector3::new(0.1, 0.2, 1.0),
            direction: -Vector3::z(),
            pressure: 8.0,
            radius: 0.5,
            reach: 4.0,
        }
    }

    /// Nothing outside the box is pressed on: places all around the jet, also one that flows askew.
    #[test]
    fn all_that_a_jet_reaches_is_in_its_box() {
        let askew = Jet {
            direction: Vector3::new(2.0, -1.0, 2.0) / 3.0,
            ..jet()
        };
        for jet in [jet(), askew] {
            let mut reached = [0, 0];
            for index in 0..40 * 40 * 40 {
                let at = [index % 40, index / 40 % 40, index / 1600];
                let from = Vector3::from(at.map(|k| 0.25 * f64::from(k) - 4.9));
                // Small, and facing the jet.
                let one = jet.direction.cross(&Vector3::y()).normalize() * 1e-6;
                let two = one.cross(&jet.direction);
                let middle = jet.tip + from;
                let corners = [middle - one - two, middle + one, middle + two];
                let is_reached = jet.pressure_on(corners, f64::INFINITY) > 0.0;
                let is_inside = jet.bounds().contains(&middle);
                assert!(is_inside || !is_reached, "{from}");
                reached[usize::from(is_reached)] += 1;
            }
            // A cylinder of 0.5 by 4, in cubes of 0.25.
            assert!(
                reached[0] > 0 && (100..300).contains(&reached[1]),
                "{reached:?}"
            );
        }
    }

    #[test]
    fn a_jet_stops_at_the_first_surface_that_faces_it() {
        for (z, up, expected) in [
            (0.25, true, 0.75),
            (0.25, false, f64::INFINITY),
            (2.0, true, f64::INFINITY),
        ] {
            let (corners, triangles) = plate(z, up);
            assert_eq!(jet().stop(&triangles, &corners), expected);
        }
        let aside = Jet {
            tip: Vector3::new(1.1, 0.0, 1.0),
            ..jet()
        };
        let (corners, triangles) = plate(0.25, true);
        assert_eq!(aside.stop(&triangles, &corners), f64::INFINITY);
    }

    /// A small triangle on the axis at half the reach has (1 − 1/4)² of the pressure, at half the radius (1 − 1/4)² of that, turned by
    /// 60° a quarter; from behind, beyond the radius, the reach or what stops the jet, nothing.
    #[test]
    fn its_pressure_falls_with_radius_reach_and_angle() {
        let small = 1e-6;
        let at = |x: f64, z: f64, normal: Vector3<f64>| {
            let one = normal.cross(&Vector3::y()).normalize() * small;
            let two = normal.cross(&one);
            let middle = jet().tip + Vector3::new(x, 0.0, -z);
            [
                middle - (one + two) / 3.0,
                middle + one * (2.0 / 3.0) - two / 3.0,
                middle + two * (2.0 / 3.0) - one / 3.0,
            ]
        };
        let up = Vector3::z();
        let tilted = Vector3::new(0.75f64.sqrt(), 0.0, 0.5);
        let far = f64::INFINITY;
        for (corners, stop, expected) in [
            (at(0.0, 2.0, up), far, 8.0 * 9.0 / 16.0),
            (at(0.25, 2.0, up), far, 8.0 * 81.0 / 256.0),
            (at(0.0, 2.0, tilted), far, 2.0 * 9.0 / 16.0),
            (at(0.0, 2.0, -up), far, 0.0),
            (at(0.51, 2.0, up), far, 0.0),
            (at(0.0, 4.1, up), far, 0.0),
            (at(0.0, -0.1, up), far, 0.0),
            (at(0.0, 2.0, up), 1.4, 0.0),
            (at(0.0, 2.0, up), 1.6, 8.0 * 9.0 / 16.0),
        ] {
            let found = jet().pressure_on(corners, stop);
            assert!((found - expected).abs() < 1e-5 * 8.0, "{found} {expected}");
        }
    }
}
