//! The shape of a body as it lies now: nearest nodes, normals of its surface, and what a plane cuts out of it.

use super::{distance, place_of, row_of};
use microsim_bus::BlockView;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// An edge of the surface by its rows, the smaller one first.
type Edge = [u32; 2];

/// The nodes and the surface of a snapshot. Nodes have stable ids, which a module may keep; the arrays are in another order after a cut.
///
/// The first snapshot comes after the first tick: a body that the level leaves to gravity has moved by then. How it lay before is in the
/// block [`TISSUE_REST`](microsim_message::TISSUE_REST), of which this is made just as well.
#[derive(Clone, Copy, Debug)]
pub struct BodyShape<'a> {
    ids: &'a [u32],
    positions: &'a [f64],
    triangles: &'a [u32],
}

/// A closed line in which a plane cuts the surface of a body: an outline, or the edge of a hole such as a lumen.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// Its corners in order, counter-clockwise seen against the normal of the plane if it is an outline, clockwise if it is a hole \[m\].
    pub points: Vec<[f64; 3]>,
    /// Area inside \[m²\].
    pub area: f64,
    /// Whether the body lies around it: the edge of a lumen.
    pub is_hole: bool,
}

impl Loop {
    /// Its length \[m\].
    pub fn length(&self) -> f64 {
        let next = self.points.iter().cycle().skip(1);
        self.points
            .iter()
            .zip(next)
            .map(|(a, b)| distance(*a, *b))
            .sum()
    }

    /// Diameter of the circle of the same area \[m\]: of a lumen, what lets through.
    pub fn diameter(&self) -> f64 {
        2.0 * (self.area / PI).sqrt()
    }

    /// Mean of its corners \[m\].
    pub fn centre(&self) -> [f64; 3] {
        let sum: Vector3<f64> = self.points.iter().map(|p| Vector3::from(*p)).sum();
        (sum / self.points.len() as f64).into()
    }
}

impl<'a> BodyShape<'a> {
    /// Of a snapshot; `None` if it is that of something else.
    pub fn of(block: &'a BlockView<'_>) -> Option<Self> {
        Some(Self {
            ids: block.u32s("node_id")?,
            positions: block.f64s("position")?,
            triangles: block.u32s("triangle")?,
        })
    }

    /// The id of the node nearest to a place \[m\]; `None` if there are no nodes.
    pub fn nearest_node(&self, place: [f64; 3]) -> Option<u32> {
        let away = |row: &usize| distance(place_of(self.positions, *row), place);
        let row = (0..self.ids.len()).min_by(|a, b| away(a).total_cmp(&away(b)))?;
        Some(self.ids[row])
    }

    /// Where a node lies \[m\]; `None` if it is not there any more.
    pub fn place(&self, node: u32) -> Option<[f64; 3]> {
        Some(place_of(self.positions, row_of(self.ids, node)?))
    }

    /// The outward normal of the surface at a node, of length 1: the mean of its triangles, weighted by their areas. `None` for a node that
    /// is inside the body, or not there any more.
    pub fn normal(&self, node: u32) -> Option<[f64; 3]> {
        let row = row_of(self.ids, node)? as u32;
        let around = self.corners().filter(|rows| rows.contains(&row));
        let sum: Vector3<f64> = around.map(|rows| self.twice_area(rows)).sum();
        Some(sum.try_normalize(f64::MIN_POSITIVE)?.into())
    }

    /// The closed lines in which the plane through `point` \[m\] with this `normal` cuts the surface, the largest area first: of a vessel cut
    /// across, its outline and its lumen. Empty if the plane misses the body or has no normal.
    pub fn section(&self, point: [f64; 3], normal: [f64; 3]) -> Vec<Loop> {
        let Some(normal) = Vector3::from(normal).try_normalize(f64::MIN_POSITIVE) else {
            return Vec::new();
        };
        let height = |row: u32| (self.at(row) - Vector3::from(point)).dot(&normal);
        // What lies in the plane counts as above it: then a plane crosses two edges of a triangle, or none.
        let above = |row: u32| height(row) >= 0.0;
        // Seen from outside with the normal upwards, the line of a triangle leads from the edge that goes down to the one that goes up.
        let mut next: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
        for rows in self.corners() {
            let edges = [0, 1, 2].map(|k| (rows[k], rows[(k + 1) % 3]));
            let down = edges.iter().find(|(a, b)| above(*a) && !above(*b));
            let up = edges.iter().find(|(a, b)| !above(*a) && above(*b));
            if let (Some(down), Some(up)) = (down, up) {
                let sorted = |(a, b): &(u32, u32)| [*a.min(b), *a.max(b)];
                next.entry(sorted(down)).or_default().push(sorted(up));
            }
        }
        let crossing = |edge: Edge| -> [f64; 3] {
            let [a, b] = edge.map(height);
            let [p, q] = edge.map(|row| self.at(row));
            (p + (q - p) * (a / (a - b))).into()
        };
        let mut loops = Vec::new();
        while let Some((first, _)) = next.first_key_value() {
            let (first, mut points) = (*first, Vec::new());
            let mut edge = first;
            while let Some(ends) = next.get_mut(&edge) {
                let end = ends.pop();
                if ends.is_empty() {
                    next.remove(&edge);
                }
                points.push(crossing(edge));
                let Some(end) = end else { break };
                edge = end;
            }
            // A surface of a body is closed, so every line is.
            if edge == first && points.len() > 2 {
                loops.push(closed(points, &normal));
            }
        }
        loops.sort_by(|a, b| b.area.total_cmp(&a.area));
        loops
    }

    fn corners(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.triangles.as_chunks().0.iter().copied()
    }

    fn at(&self, row: u32) -> Vector3<f64> {
        place_of(self.positions, row as usize).into()
    }

    fn twice_area(&self, rows: [u32; 3]) -> Vector3<f64> {
        let [a, b, c] = rows.map(|row| self.at(row));
        (b - a).cross(&(c - a))
    }
}

/// A line with its area.
fn closed(points: Vec<[f64; 3]>, normal: &Vector3<f64>) -> Loop {
    let from = Vector3::from(points[0]);
    let fan = points.windows(2).map(|pair| {
        let [a, b] = [0, 1].map(|k| Vector3::from(pair[k]) - from);
        0.5 * a.cross(&b)
    });
    let signed = fan.sum::<Vector3<f64>>().dot(normal);
    Loop {
        points,
        area: signed.abs(),
        is_hole: signed < 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_bus::{Block, BlockBuilder};

    const CORNERS: u32 = 24;
    const LENGTH: f64 = 4e-3;

    /// A tube along x with walls between two radii \[m\], of flat strips: rings of `CORNERS` corners at both ends. Ids are rows + 100.
    fn tube(inner: f64, outer: f64) -> Block {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for x in [0.0, LENGTH] {
            for radius in [inner, outer] {
                for k in 0..CORNERS {
                    let angle = 2.0 * PI * f64::from(k) / f64::from(CORNERS);
                    positions.extend([x, radius * angle.cos(), radius * angle.sin()]);
                }
            }
        }
        let row = |end: u32, ring: u32, k: u32| (2 * end + ring) * CORNERS + k % CORNERS;
        let mut quad = |a, b, c, d| triangles.extend([a, b, c, a, c, d]);
        for k in 0..CORNERS {
            // Outside, inside, the two ends.
            quad(
                row(0, 1, k),
                row(0, 1, k + 1),
                row(1, 1, k + 1),
                row(1, 1, k),
            );
            quad(
                row(0, 0, k + 1),
                row(0, 0, k),
                row(1, 0, k),
                row(1, 0, k + 1),
            );
            quad(
                row(0, 0, k),
                row(0, 0, k + 1),
                row(0, 1, k + 1),
                row(0, 1, k),
            );
            quad(
                row(1, 0, k + 1),
                row(1, 0, k),
                row(1, 1, k),
                row(1, 1, k + 1),
            );
        }
        let ids = (0..4 * CORNERS).map(|row| row + 100);
        let words = BlockBuilder::new("tissue.snapshot", "tube", 1, 0)
            .u32s("node_id", ids)
            .f64s("position", positions)
            .u32s("triangle", triangles);
        Block::new(&words.finish()).expect("a good block")
    }

    /// Outline and lumen of a tube cut across are regular polygons: n r²/2 · sin(2π/n), 2 n r sin(π/n).
    #[test]
    fn a_tube_cut_across_has_an_outline_and_a_lumen() {
        let (inner, outer) = (1e-3, 1.5e-3);
        let block = tube(inner, outer);
        let view = block.view();
        let shape = BodyShape::of(&view).expect("a snapshot");
        // The second plane goes through nodes.
        for x in [0.3 * LENGTH, LENGTH - f64::EPSILON * LENGTH] {
            let loops = shape.section([x, 0.0, 0.0], [2.0, 0.0, 0.0]);
            let kinds: Vec<bool> = loops.iter().map(|l| l.is_hole).collect();
            assert_eq!(kinds, [false, true]);
            for (line, radius) in loops.iter().zip([outer, inner]) {
                let n = f64::from(CORNERS);
                let area = 0.5 * n * radius * radius * (2.0 * PI / n).sin();
                let length = 2.0 * n * radius * (PI / n).sin();
                assert!(
                    (line.area - area).abs() < 1e-12 * area + 1e-18,
                    "{}",
                    line.area
                );
                assert!(
                    (line.length() - length).abs() < 1e-9 * length,
                    "{}",
                    line.length()
                );
                assert!((line.diameter() - 2.0 * (area / PI).sqrt()).abs() < 1e-12);
                assert!(distance(line.centre(), [x, 0.0, 0.0]) < 1e-9);
            }
        }
        // Lengthwise through the axis: two walls, of which each is a rectangle.
        let walls = shape.section([0.0; 3], [0.0, 1e-9, 1.0]);
        assert_eq!(walls.len(), 2);
        for wall in walls {
            assert!(!wall.is_hole && (wall.area - LENGTH * (outer - inner)).abs() < 1e-12);
        }
        assert!(
            shape
                .section([2.0 * LENGTH, 0.0, 0.0], [1.0, 0.0, 0.0])
                .is_empty()
        );
        assert!(shape.section([0.0; 3], [0.0; 3]).is_empty());
    }

    /// At the middle of the outside, and of the lumen, radially; what was cut away has none.
    #[test]
    fn nodes_are_found_and_have_outward_normals() {
        let block = tube(1e-3, 1.5e-3);
        let view = block.view();
        let shape = BodyShape::of(&view).expect("a snapshot");
        let outside = shape.nearest_node([0.1e-3, 1.7e-3, 0.0]).expect("nodes");
        assert_eq!(outside, 100 + CORNERS);
        assert_eq!(shape.place(outside), Some([0.0, 1.5e-3, 0.0]));
        let lumen = shape.nearest_node([0.1e-3, 0.9e-3, 0.0]).expect("nodes");
        let [x, y, z] = shape.normal(outside).expect("on the surface");
        // The edge between outside and end: both count, by their areas.
        assert!(x < 0.0 && y > 0.5 && z.abs() < 0.2, "{x} {y} {z}");
        let [x, y, _] = shape.normal(lumen).expect("on the surface");
        assert!(x < 0.0 && y < -0.5, "{x} {y}");
        assert_eq!((shape.normal(7), shape.place(7)), (None, None));
    }
}
