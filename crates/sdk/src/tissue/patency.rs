//! How far a vessel lets through: the areas of its lumen along the axis.

use super::VesselWall;
use nalgebra::Vector3;

/// The narrowest place of a lumen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patency {
    /// Area of its section across the axis \[m²\]; 0 where the walls lie on one another.
    pub area: f64,
    /// Where it is, along the axis \[m\].
    pub along: f64,
}

impl Patency {
    /// The least of the sections of the lumen of the held piece as it lies now, at so many places evenly spaced from one length along the axis to another \[m\]; `None`
    /// of no place. An oblique end is no closed section: stop before it.
    pub fn of(wall: &VesselWall<'_>, [from, to]: [f64; 2], places: usize) -> Option<Self> {
        let sections = (0..places).map(|k| {
            let part = if places == 1 {
                0.0
            } else {
                k as f64 / (places - 1) as f64
            };
            let along = from + (to - from) * part;
            let area = section(wall, along);
            Self { area, along }
        });
        sections.min_by(|a, b| a.area.total_cmp(&b.area))
    }
}

/// Area of the lumen at a length along the axis \[m²\]: what its triangles cut out of a plane across, by the fan of their lines. Walls that lie on one another enclose
/// nothing.
fn section(wall: &VesselWall<'_>, along: f64) -> f64 {
    let axis = wall.axis();
    let direction = Vector3::from(axis.direction());
    let height = |row: u32| axis.along(wall.now(row).into()) - along;
    let mut twice = 0.0;
    for rows in wall.lumen() {
        let edges = [0, 1, 2].map(|k| (rows[k], rows[(k + 1) % 3]));
        // What lies in the plane counts as above it: then a plane crosses two edges of a triangle, or none.
        let above = |row: u32| height(row) >= 0.0;
        let down = edges.iter().find(|(a, b)| above(*a) && !above(*b));
        let up = edges.iter().find(|(a, b)| !above(*a) && above(*b));
        let (Some(down), Some(up)) = (down, up) else {
            continue;
        };
        let [p, q] = [down, up].map(|(a, b)| {
            let (a, b, part) = (
                wall.now(*a),
                wall.now(*b),
                height(*a) / (height(*a) - height(*b)),
            );
            Vector3::from(axis.radial((a + (b - a) * part).into()))
        });
        // Seen against the axis the line of a surface that faces it runs clockwise.
        twice -= p.cross(&q).dot(&direction);
    }
    (0.5 * twice).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tissue::test_tube::TestTube;
    use std::f64::consts::PI;

    fn measured(places: usize, now: impl Fn([f64; 3]) -> [f64; 3]) -> Patency {
        let tube = TestTube::default();
        let (snapshot, elements) = tube.blocks(now);
        let (snapshot, elements) = (snapshot.view(), elements.view());
        let wall = VesselWall::of(&snapshot, &elements, TestTube::axis()).expect("a wall");
        Patency::of(&wall, [0.1e-3, 3.9e-3], places).expect("places")
    }

    /// A regular polygon of n corners has the area n r²/2 sin(2π/n); flattened to a tenth in its middle, a tenth of it; turned inside out, where walls have passed through
    /// one another, none. Tolerance: rounding.
    #[test]
    fn the_narrowest_section_counts() {
        let TestTube {
            radii: [r, ..],
            around,
            length,
            ..
        } = TestTube::default();
        let n = around as f64;
        let whole = 0.5 * n * r * r * libm::sin(2.0 * PI / n);
        let round = measured(7, |place| place);
        assert!((round.area - whole).abs() < 1e-12 * whole, "{round:?}");
        for flat in [0.1, -0.1] {
            // Sections between rings of nodes are in between: of 9 places the middle one is such a ring.
            let narrow = measured(9, |[x, y, z]| match (x - 0.5 * length).abs() < 1e-9 {
                true => [x, y, flat * z],
                false => [x, y, z],
            });
            let expected = f64::max(flat, 0.0) * whole;
            assert!((narrow.area - expected).abs() < 1e-12 * whole, "{narrow:?}");
            assert!((narrow.along - 0.5 * length).abs() < 1e-12, "{narrow:?}");
        }
    }
}
