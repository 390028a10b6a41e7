//! The surface of a straight vessel by what it bounds: the lumen, the outside, an end, or what a cut has opened.
//!
//! A triangle is what its place and its normal in the mesh at rest make it, so that tissue that is bent or folded does not change its name. Not here: bent vessels.

use super::{VesselAxis, place_of};
use microsim_bus::BlockView;
use nalgebra::Vector3;

/// What a triangle of a vessel's surface bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WallFace {
    /// It faces the axis: the lumen, or the inner side of a layer that hangs on the wall by couplings alone.
    Inside,
    /// It faces away from the axis.
    Outside,
    /// It lies across the axis: an end.
    End,
    /// A cut or a tear has opened it.
    Opened,
}

/// The surface of a vessel in a tick.
#[derive(Clone, Debug)]
pub struct VesselWall<'a> {
    axis: VesselAxis,
    positions: &'a [f64],
    rest: &'a [f64],
    pieces: &'a [u32],
    triangles: &'a [[u32; 3]],
    regions: &'a [u32],
    faces: Vec<WallFace>,
    lumen: u32,
    held: u32,
}

impl<'a> VesselWall<'a> {
    /// Of a [snapshot](microsim_message::TISSUE_SNAPSHOT) and the [elements](microsim_message::TISSUE_ELEMENTS) of the same tick; the axis is that at rest. `None`
    /// if the blocks are of something else, or of different ticks.
    pub fn of(
        snapshot: &BlockView<'a>,
        elements: &BlockView<'a>,
        axis: VesselAxis,
    ) -> Option<Self> {
        let of = |view: &BlockView<'a>| (view.name(), view.generation(), view.time_ns());
        if of(snapshot) != of(elements) {
            return None;
        }
        let mut wall = Self {
            axis,
            positions: snapshot.f64s("position")?,
            rest: elements.f64s("rest")?,
            pieces: snapshot.u32s("piece")?,
            triangles: snapshot.u32s("triangle")?.as_chunks().0,
            regions: elements.u32s("triangle_region")?,
            faces: Vec::new(),
            lumen: 0,
            held: 0,
        };
        let opened = snapshot.u32s("inner")?.iter();
        wall.faces = opened
            .zip(wall.triangles)
            .map(|(opened, rows)| match opened {
                0 => wall.face(rows),
                _ => WallFace::Opened,
            })
            .collect();
        let inside = (0..wall.faces.len()).filter(|of| wall.faces[*of] == WallFace::Inside);
        let inmost = inside.min_by(|a, b| wall.radius(*a).total_cmp(&wall.radius(*b)))?;
        wall.lumen = wall.regions[inmost];
        let along = |row: &usize| axis.along(place_of(wall.rest, *row));
        let first = (0..wall.pieces.len()).min_by(|a, b| along(a).total_cmp(&along(b)))?;
        wall.held = wall.pieces[first];
        Some(wall)
    }

    fn face(&self, rows: &[u32; 3]) -> WallFace {
        let [a, b, c] = rows.map(|row| self.at_rest(row));
        let normal = (b - a).cross(&(c - a));
        let radial = Vector3::from(self.axis.radial(((a + b + c) / 3.0).into()));
        let outward = normal.dot(&radial.try_normalize(0.0).unwrap_or_default());
        if normal.dot(&Vector3::from(self.axis.direction())).abs() > outward.abs() {
            WallFace::End
        } else if outward < 0.0 {
            WallFace::Inside
        } else {
            WallFace::Outside
        }
    }

    /// Of a triangle, at rest \[m\].
    fn radius(&self, triangle: usize) -> f64 {
        let [a, b, c] = self.triangles[triangle].map(|row| self.at_rest(row));
        Vector3::from(self.axis.radial(((a + b + c) / 3.0).into())).norm()
    }

    /// The axis at rest.
    pub fn axis(&self) -> &VesselAxis {
        &self.axis
    }

    /// The piece that is held: that of the first node along the axis at rest.
    pub fn held_piece(&self) -> u32 {
        self.held
    }

    /// The region of the layer that surrounds the lumen.
    pub fn lumen_region(&self) -> u32 {
        self.lumen
    }

    /// Where a node of the snapshot lies, by its row \[m\].
    pub(super) fn now(&self, row: u32) -> Vector3<f64> {
        place_of(self.positions, row as usize).into()
    }

    /// Where a node of the snapshot lay, by its row \[m\].
    pub(super) fn at_rest(&self, row: u32) -> Vector3<f64> {
        place_of(self.rest, row as usize).into()
    }

    /// The triangles of the lumen of the piece that is held, by their rows.
    pub(super) fn lumen(&self) -> impl Iterator<Item = &'a [u32; 3]> + '_ {
        let all = self.held_triangles();
        let of_lumen = all.filter(|(of, _)| {
            self.faces[*of] == WallFace::Inside && self.regions[*of] == self.lumen
        });
        of_lumen.map(|(_, rows)| rows)
    }

    /// The triangles of a region of the piece that is held, by their rows.
    pub(super) fn layer(&self, region: u32) -> impl Iterator<Item = &'a [u32; 3]> + '_ {
        let all = self.held_triangles();
        let of_region = all.filter(move |(of, _)| self.regions[*of] == region);
        of_region.map(|(_, rows)| rows)
    }

    fn held_triangles(&self) -> impl Iterator<Item = (usize, &'a [u32; 3])> + '_ {
        let all = self.triangles.iter().enumerate();
        all.filter(|(_, rows)| self.pieces[rows[0] as usize] == self.held)
    }

    /// Area at rest of what cuts and tears have opened in a region, of one side \[m²\].
    pub fn opened(&self, region: u32) -> f64 {
        let all = self.triangles.iter().enumerate();
        let of_region = all
            .filter(|(of, _)| self.faces[*of] == WallFace::Opened && self.regions[*of] == region);
        let areas = of_region.map(|(_, rows)| {
            let [a, b, c] = rows.map(|row| self.at_rest(row));
            0.25 * (b - a).cross(&(c - a)).norm()
        });
        areas.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tissue::test_tube::TestTube;

    /// Two layers that hang together by couplings: the lumen is that of the inner one, and is known as such where the vessel has been turned inside out. Blocks of
    /// different ticks make no wall.
    #[test]
    fn the_lumen_is_known_by_where_it_lay() {
        let tube = TestTube::default();
        let turned = |[x, y, z]: [f64; 3]| [-x, y, z];
        let (snapshot, elements) = tube.blocks(turned);
        let (snapshot, elements) = (snapshot.view(), elements.view());
        let wall = VesselWall::of(&snapshot, &elements, TestTube::axis()).expect("a wall");
        let lumen: Vec<_> = wall.lumen().collect();
        assert_eq!(lumen.len(), 2 * tube.around * tube.along);
        for row in lumen.into_iter().flatten() {
            let [_, y, z] = wall.at_rest(*row).into();
            assert!((libm::hypot(y, z) - tube.radii[0]).abs() < 1e-12);
        }
        assert_eq!((wall.held_piece(), wall.lumen_region()), (0, 0));
        assert_eq!((wall.opened(0), wall.opened(1)), (0.0, 0.0));

        // Two strips around and three along, opened on both sides: flat, so as wide as chords.
        let opened = [[3, 5], [1, 4]];
        let (now, of_elements) = TestTube { opened, ..tube }.blocks(|place| place);
        let (now, of_elements) = (now.view(), of_elements.view());
        let opened = VesselWall::of(&now, &of_elements, TestTube::axis()).expect("a wall");
        let chords = 2.0 * (tube.radii[0] + tube.radii[1]);
        let width = chords * libm::sin(std::f64::consts::PI / tube.around as f64);
        let area = 0.5 * 2.0 * width * 3.0 * tube.length / tube.along as f64;
        assert!(
            (opened.opened(0) - area).abs() < 1e-12 * area,
            "{}",
            opened.opened(0)
        );
        assert_eq!(opened.opened(1), 0.0);
        let (_, later) = TestTube { tick: 1, ..tube }.blocks(turned);
        assert!(VesselWall::of(&snapshot, &later.view(), TestTube::axis()).is_none());
    }
}
