//! How far the media of a vessel's end is bare of adventitia, around the vessel.

use super::VesselWall;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Bare lengths at angles around a vessel, evenly spaced from the [first one](super::VesselAxis::spoke) on.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeLength {
    /// From the foremost adventitia to the end of the media, along the axis, at each angle; negative where adventitia hangs over the end \[m\].
    pub lengths: Vec<f64>,
}

impl FreeLength {
    /// Of the layers of the held piece as they lie now, at so many angles. Where no adventitia is left, the media is bare from its other end on. `None` where some
    /// angle has no media.
    pub fn of(wall: &VesselWall<'_>, media: u32, adventitia: u32, angles: usize) -> Option<Self> {
        let [media, adventitia] = [media, adventitia].map(|region| Outline::of(wall, region));
        let lengths = (0..angles).map(|k| {
            let angle = 2.0 * PI * k as f64 / angles as f64;
            let [least, end] = media.extent(wall, angle)?;
            let covered = adventitia.extent(wall, angle);
            Some(end - covered.map_or(least, |[_, foremost]| foremost))
        });
        let lengths: Option<Vec<f64>> = lengths.collect();
        Some(Self { lengths: lengths? })
    }

    /// Mean around the vessel \[m\].
    pub fn mean(&self) -> f64 {
        self.lengths.iter().sum::<f64>() / self.lengths.len() as f64
    }

    /// The least one \[m\].
    pub fn least(&self) -> f64 {
        self.lengths.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The least one over the mean, from 0 where some angle is covered to the end, to 1 where all are alike.
    pub fn evenness(&self) -> f64 {
        match self.mean() {
            mean if mean > 0.0 => (self.least() / mean).max(0.0),
            _ => 0.0,
        }
    }
}

/// The edges of a layer: their ends, and of these the vectors from the axis \[m\].
struct Outline {
    edges: Vec<[[Vector3<f64>; 2]; 2]>,
}

impl Outline {
    fn of(wall: &VesselWall<'_>, region: u32) -> Self {
        let axis = wall.axis();
        let mut edges = Vec::new();
        for rows in wall.layer(region) {
            let corners = rows.map(|row| {
                let place = wall.now(row);
                [place, Vector3::from(axis.radial(place.into()))]
            });
            edges.extend((0..3).map(|k| [corners[k], corners[(k + 1) % 3]]));
        }
        Self { edges }
    }

    /// From where to where the layer reaches along the axis in the half-plane at an angle around it \[m\].
    fn extent(&self, wall: &VesselWall<'_>, angle: f64) -> Option<[f64; 2]> {
        let axis = wall.axis();
        let (spoke, direction) = (
            Vector3::from(axis.spoke(angle)),
            Vector3::from(axis.direction()),
        );
        let aside = direction.cross(&spoke);
        let mut extent: Option<[f64; 2]> = None;
        for ends in &self.edges {
            let [a, b] = ends.map(|[_, radial]| radial.dot(&aside));
            // What lies in the half-plane counts as beyond it.
            if (a >= 0.0) == (b >= 0.0) {
                continue;
            }
            let [from, to] = ends.map(|[place, _]| place);
            let crossing = from + (to - from) * (a / (a - b));
            if Vector3::from(axis.radial(crossing.into())).dot(&spoke) <= 0.0 {
                continue;
            }
            let along = axis.along(crossing.into());
            let [from, to] = extent.unwrap_or([along; 2]);
            extent = Some([from.min(along), to.max(along)]);
        }
        extent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tissue::test_tube::TestTube;

    fn measured(tube: TestTube, now: impl Fn([f64; 3]) -> [f64; 3]) -> FreeLength {
        let (snapshot, elements) = tube.blocks(now);
        let (snapshot, elements) = (snapshot.view(), elements.view());
        let wall = VesselWall::of(&snapshot, &elements, TestTube::axis()).expect("a wall");
        FreeLength::of(&wall, 0, 1, 16).expect("media at all angles")
    }

    /// Layers of which the outer one is shorter by a length, or by one that changes linearly from below to above: in the half-plane at an angle the adventitia reaches
    /// farthest at its inner or its outer edge, whichever is farther pushed, so that the polygon's radius at that angle counts.
    #[test]
    fn the_bare_length_is_what_the_layers_differ_by() {
        let tube = TestTube {
            bare: 1e-3,
            ..TestTube::default()
        };
        let even = measured(tube, |place| place);
        assert!(
            even.lengths.iter().all(|of| (of - 1e-3).abs() < 1e-12),
            "{even:?}"
        );
        assert!((even.mean() - 1e-3).abs() < 1e-12 && (even.evenness() - 1.0).abs() < 1e-9);

        // The outer side of the adventitia is pushed back by half of the height above its lowest point: its inner edge is still the foremost.
        let [_, between, outer] = tube.radii;
        let is_outer = |y: f64, z: f64| libm::hypot(y, z) > 0.5 * (between + outer);
        let back = |[x, y, z]: [f64; 3]| match is_outer(y, z) {
            true => [x - 0.5 * (z + outer), y, z],
            false => [x, y, z],
        };
        let pushed = measured(tube, back);
        assert!((pushed.least() - 1e-3).abs() < 1e-12 && (pushed.mean() - 1e-3).abs() < 1e-12);
        let over = measured(tube, |[x, y, z]| match is_outer(y, z) {
            true => [x + 0.5 * (z + outer), y, z],
            false => [x, y, z],
        });
        for (k, found) in over.lengths.iter().enumerate() {
            let angle = 2.0 * PI * k as f64 / 16.0;
            // Height of the polygon's side at this angle: its distance from the middle, r cos(π/n), over the cosine from the middle of the side.
            let side = 2.0 * PI / tube.around as f64;
            let from_corner = angle - (angle / side).floor() * side;
            let radius = outer * libm::cos(0.5 * side) / libm::cos(from_corner - 0.5 * side);
            let expected = 1e-3 - 0.5 * (radius * libm::cos(angle) + outer);
            assert!((found - expected).abs() < 1e-12, "{k}: {found} {expected}");
        }
        assert!((over.least() - (1e-3 - outer)).abs() < 1e-12);
        assert_eq!(TestTube::default().bare, 0.0);
        assert_eq!(measured(TestTube::default(), |place| place).evenness(), 0.0);
    }
}
