//! The opening of a vessel's free end: the line in which its lumen ends, at a cut or at the end that it has had.

use super::{Rim, VesselWall};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The opening of a vessel's free end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// As it lies.
    pub now: Rim,
    /// As the same nodes lie in the mesh at rest: what tension, pressure and a grip do not change.
    pub at_rest: Rim,
}

impl Opening {
    /// The last line along the axis, at rest, that surrounds it and in which the lumen of the held piece ends. `None` where there is none, as of a vessel slit along its
    /// whole length. A cut that is not through has not moved it yet.
    pub fn of(wall: &VesselWall<'_>) -> Option<Self> {
        let axis = *wall.axis();
        let along = |line: &[u32]| {
            let places = line.iter().map(|row| axis.along(wall.at_rest(*row).into()));
            places.sum::<f64>() / line.len() as f64
        };
        let lines: Vec<Vec<u32>> = ends(wall)
            .into_iter()
            .filter(|line| turns(wall, line).abs() > 0.5)
            .collect();
        // The other one is where the vessel is held.
        if lines.len() < 2 {
            return None;
        }
        let last = lines.iter().max_by(|a, b| along(a).total_cmp(&along(b)))?;
        let rim = |place: &dyn Fn(u32) -> Vector3<f64>| {
            let corners: Vec<[f64; 3]> = last.iter().map(|row| place(*row).into()).collect();
            Rim::of(&corners)
        };
        Some(Self {
            now: rim(&|row| wall.now(row))?,
            at_rest: rim(&|row| wall.at_rest(row))?,
        })
    }
}

/// The closed lines in which the lumen ends: edges of one triangle of it, by their rows.
fn ends(wall: &VesselWall<'_>) -> Vec<Vec<u32>> {
    let mut next: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for rows in wall.lumen() {
        for k in 0..3 {
            let (a, b) = (rows[k], rows[(k + 1) % 3]);
            match next.get_mut(&[b, a]) {
                Some(1) => {
                    next.remove(&[b, a]);
                }
                Some(count) => *count -= 1,
                None => *next.entry([a, b]).or_default() += 1,
            }
        }
    }
    let mut lines = Vec::new();
    while let Some((&first, _)) = next.first_key_value() {
        let (mut edge, mut line) = (first, Vec::new());
        loop {
            match next.get_mut(&edge) {
                Some(count @ 2..) => *count -= 1,
                _ => {
                    next.remove(&edge);
                }
            }
            line.push(edge[0]);
            // Where lines touch in a node, they are walked as one.
            let from = edge[1];
            let Some((&on, _)) = next.range([from, 0]..=[from, u32::MAX]).next() else {
                break;
            };
            edge = on;
        }
        lines.push(line);
    }
    lines
}

/// How often a line goes around the axis at rest.
fn turns(wall: &VesselWall<'_>, line: &[u32]) -> f64 {
    let direction = Vector3::from(wall.axis().direction());
    let radial = |row: &u32| Vector3::from(wall.axis().radial(wall.at_rest(*row).into()));
    let edges = line.iter().zip(line.iter().cycle().skip(1));
    let angles = edges.map(|(a, b)| {
        let (p, q) = (radial(a), radial(b));
        libm::atan2(p.cross(&q).dot(&direction), p.dot(&q))
    });
    angles.sum::<f64>() / (2.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tissue::test_tube::TestTube;

    /// Circumference of an ellipse with these half axes by the trapezoidal rule, which converges faster than any power for what is periodic.
    fn ellipse(a: f64, b: f64) -> f64 {
        let steps = 256;
        let speeds = (0..steps).map(|k| {
            let angle = 2.0 * PI * f64::from(k) / f64::from(steps);
            libm::hypot(a * libm::sin(angle), b * libm::cos(angle))
        });
        speeds.sum::<f64>() * 2.0 * PI / f64::from(steps)
    }

    /// A tube whose free end is oblique: half axes r and r/cos of the angle. The polygon through n points of the ellipse has the area n/2 sin(2π/n) a b, as the ellipse
    /// is a circle seen obliquely; its circumference falls short of the ellipse's by O(1/n²), a quarter with twice the corners.
    #[test]
    fn an_oblique_end_has_the_ellipse_of_its_angle() {
        for angle in [0.0, 0.4, PI / 4.0, PI / 3.0] {
            let mut short = Vec::new();
            for around in [24, 48, 96] {
                let tube = TestTube {
                    around,
                    ..TestTube::default()
                };
                let (r, length) = (tube.radii[0], tube.length);
                let oblique =
                    |[x, y, z]: [f64; 3]| [x * (1.0 + z * libm::tan(angle) / length), y, z];
                let (snapshot, elements) = tube.blocks(oblique);
                let (snapshot, elements) = (snapshot.view(), elements.view());
                let wall = VesselWall::of(&snapshot, &elements, TestTube::axis());
                let opening = Opening::of(&wall.expect("a wall")).expect("an end");
                let (a, b) = (r, r / libm::cos(angle));
                let n = around as f64;
                let area = 0.5 * n * libm::sin(2.0 * PI / n) * a * b;
                assert!((opening.now.area - area).abs() < 1e-12 * area);
                let measured = opening.now.angle_to([1.0, 0.0, 0.0]);
                assert!((measured - angle).abs() < 1e-9, "{measured} {angle}");
                assert!(opening.now.farthest < 1e-12 * length);
                assert!((opening.now.centre[0] - length).abs() < 1e-12 * length);
                short.push(ellipse(a, b) - opening.now.circumference);
                // At rest it is straight.
                let circle = 2.0 * n * r * libm::sin(PI / n);
                assert!((opening.at_rest.circumference - circle).abs() < 1e-12 * circle);
                assert!(opening.at_rest.angle_to([1.0, 0.0, 0.0]) < 1e-9);
            }
            for pair in short.windows(2) {
                assert!((pair[0] / pair[1] - 4.0).abs() < 0.1, "{angle}: {short:?}");
            }
        }
    }

    /// A hole in the wall is no end; slit along its whole length the vessel has none.
    #[test]
    fn an_opening_surrounds_the_axis() {
        let tube = TestTube::default();
        for (slit, is_open) in [([2, 5], true), ([0, tube.along], false)] {
            let opened = [[3, 5], slit];
            let (snapshot, elements) = TestTube { opened, ..tube }.blocks(|place| place);
            let (snapshot, elements) = (snapshot.view(), elements.view());
            let wall = VesselWall::of(&snapshot, &elements, TestTube::axis());
            let opening = Opening::of(&wall.expect("a wall"));
            let at = opening.map(|opening| opening.at_rest.centre[0]);
            assert_eq!(at.is_some(), is_open);
            assert!(at.is_none_or(|x| (x - tube.length).abs() < 1e-12), "{at:?}");
        }
    }
}
