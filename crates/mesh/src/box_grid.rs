//! A grid of cells that finds boxes.

use microsim_geometry::Aabb;
use nalgebra::Vector3;

/// Most cells along an axis; more would cost more to empty than they save.
const MAX_CELLS_ALONG: usize = 256;

/// Boxes sorted into the cells of a grid. Everything found is a number of a box in the order in which they came.
pub(crate) struct BoxGrid {
    bounds: Aabb,
    /// Edge of a cell along each axis \[m\].
    cell: Vector3<f64>,
    cells: [usize; 3],
    /// Where the list of each cell begins; one more for the end of the last.
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl BoxGrid {
    /// The grid over `boxes`, none of them empty, its cells about as large as the mean box.
    pub(crate) fn new(boxes: &[Aabb]) -> Self {
        let bounds = boxes
            .iter()
            .fold(Aabb::empty(), |all, item| all.union(item));
        let mut extent = Vector3::zeros();
        for item in boxes {
            extent += item.max - item.min;
        }
        let mean = extent.sum() / (3 * boxes.len()).max(1) as f64;
        let size = bounds.max - bounds.min;
        let mut cells = [0, 1, 2].map(|axis| {
            // The conversion takes NaN (no size, no boxes) to 0 and bounds infinity.
            ((size[axis] / mean) as usize).clamp(1, MAX_CELLS_ALONG)
        });
        // Boxes far apart: no more cells than a few per box.
        while cells.iter().product::<usize>() > 64 + 8 * boxes.len() {
            cells = cells.map(|n| n.div_ceil(2));
        }
        let cell = Vector3::from_fn(|axis, _| size[axis] / cells[axis] as f64);
        let mut grid = Self {
            bounds,
            cell,
            cells,
            starts: vec![0; cells.iter().product::<usize>() + 1],
            items: Vec::new(),
        };
        // Counting sort: how many per cell, where each list ends, then filled from the back so that each ascends.
        for item in boxes {
            let range = grid.range(item);
            grid.visit(range, |starts, _, cell| starts[cell] += 1);
        }
        let mut sum = 0;
        for start in &mut grid.starts {
            sum += *start;
            *start = sum;
        }
        grid.items = vec![0; sum as usize];
        for (index, item) in boxes.iter().enumerate().rev() {
            let range = grid.range(item);
            grid.visit(range, |starts, items, cell| {
                starts[cell] -= 1;
                items[starts[cell] as usize] = index as u32;
            });
        }
        grid
    }

    /// The boxes that may overlap `region`, ascending, each once.
    pub(crate) fn near(&self, region: &Aabb) -> Vec<u32> {
        if !self.bounds.overlaps(region) {
            return Vec::new();
        }
        let [from, to] = self.range(region);
        let mut found = Vec::new();
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    found.extend_from_slice(self.list([x, y, z]));
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Calls `distance` \[m\] with boxes near `point` and on to those farther away until none that is left can be closer
    /// than the smallest distance returned so far; a box may come more than once. `distance` is never smaller than the
    /// distance to the box.
    pub(crate) fn search_nearest(
        &self,
        point: &Vector3<f64>,
        mut distance: impl FnMut(u32) -> f64,
    ) {
        let home = [0, 1, 2].map(|axis| self.coordinate(axis, point[axis]));
        // The point moved into the bounds is not farther from anything inside than the point itself.
        let inside = point.sup(&self.bounds.min).inf(&self.bounds.max);
        let mut best = f64::INFINITY;
        for ring in 0..*self.cells.iter().max().unwrap_or(&1) {
            // All that is not in an earlier ring lies at least this far away along some axis that has cells left.
            let reached = (0..3)
                .flat_map(|axis| {
                    let below = (home[axis] >= ring && ring > 0).then(|| {
                        inside[axis]
                            - self.bounds.min[axis]
                            - self.cell[axis] * (home[axis] - ring + 1) as f64
                    });
                    let above = (home[axis] + ring < self.cells[axis] && ring > 0).then(|| {
                        self.bounds.min[axis] + self.cell[axis] * (home[axis] + ring) as f64
                            - inside[axis]
                    });
                    [below, above]
                })
                .flatten()
                .fold(f64::INFINITY, f64::min);
            // A hair of the cells, so that rounding cannot leave out a box at the same distance.
            let margin = 1e-9 * self.cell.max();
            if ring > 0 && reached - margin > best {
                return;
            }
            self.visit_ring(home, ring, |cell| {
                for &item in self.list(cell) {
                    best = best.min(distance(item));
                }
            });
        }
    }

    /// Calls `f` with each cell `ring` cells away from `home` in the largest coordinate.
    fn visit_ring(&self, home: [usize; 3], ring: usize, mut f: impl FnMut([usize; 3])) {
        let from = home.map(|h| h.saturating_sub(ring));
        let to = [0, 1, 2].map(|axis| (home[axis] + ring).min(self.cells[axis] - 1));
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    let away = [
                        x.abs_diff(home[0]),
                        y.abs_diff(home[1]),
                        z.abs_diff(home[2]),
                    ];
                    if away.into_iter().max() == Some(ring) {
                        f([x, y, z]);
                    }
                }
            }
        }
    }

    fn coordinate(&self, axis: usize, x: f64) -> usize {
        // The conversion takes everything below 0, and the NaN of a flat grid, to 0.
        (((x - self.bounds.min[axis]) / self.cell[axis]) as usize).min(self.cells[axis] - 1)
    }

    fn range(&self, region: &Aabb) -> [[usize; 3]; 2] {
        [region.min, region.max].map(|p| [0, 1, 2].map(|axis| self.coordinate(axis, p[axis])))
    }

    fn list(&self, [x, y, z]: [usize; 3]) -> &[u32] {
        let cell = (z * self.cells[1] + y) * self.cells[0] + x;
        &self.items[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    fn visit(
        &mut self,
        [from, to]: [[usize; 3]; 2],
        mut f: impl FnMut(&mut [u32], &mut [u32], usize),
    ) {
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    let cell = (z * self.cells[1] + y) * self.cells[0] + x;
                    f(&mut self.starts, &mut self.items, cell);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Boxes of all sizes, some flat, some far away.
    fn boxes() -> impl Strategy<Value = Vec<Aabb>> {
        let coordinate = -1.0..1.0f64;
        let one = (
            [coordinate.clone(), coordinate.clone(), coordinate],
            [0.0..0.3f64, 0.0..0.3, 0.0..0.3],
            prop::sample::select(vec![1.0, 1.0, 1.0, 5.0]),
        );
        let one = one.prop_map(|(min, size, scale)| {
            let min = Vector3::from(min) * scale;
            Aabb {
                min,
                max: min + Vector3::from(size.map(|s| if s < 0.03 { 0.0 } else { s })),
            }
        });
        prop::collection::vec(one, 1..60)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

        /// Brute force over all boxes.
        #[test]
        fn nothing_is_missed(boxes in boxes(), p in [-2.0..2.0f64, -2.0..2.0, -2.0..2.0], reach in 0.0..1.0f64) {
            let grid = BoxGrid::new(&boxes);
            let point = Vector3::from(p);
            let region = Aabb { min: point, max: point + Vector3::repeat(reach) };
            let near = grid.near(&region);
            for (index, item) in boxes.iter().enumerate() {
                let index = index as u32;
                prop_assert!(!item.overlaps(&region) || near.contains(&index));
            }
            let distance = |index: u32| {
                let item = &boxes[index as usize];
                (point.sup(&item.min).inf(&item.max) - point).norm()
            };
            let mut found = f64::INFINITY;
            grid.search_nearest(&point, |index| {
                found = found.min(distance(index));
                distance(index)
            });
            let expected = (0..boxes.len() as u32).map(distance).fold(f64::INFINITY, f64::min);
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn a_grid_of_one_point_or_of_nothing_answers() {
        let point = Vector3::new(1.0, 2.0, 3.0);
        let grid = BoxGrid::new(&[Aabb::of([&point])]);
        assert_eq!(grid.near(&Aabb::of([&point])), [0]);
        let mut seen = Vec::new();
        grid.search_nearest(&Vector3::zeros(), |index| {
            seen.push(index);
            1.0
        });
        assert_eq!(seen, [0]);
        let empty = BoxGrid::new(&[]);
        assert!(empty.near(&Aabb::of([&point])).is_empty());
    }
}
