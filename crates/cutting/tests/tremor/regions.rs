//! What a blade has separated in the ideal: the regions of a box that are left when all within a distance of its sweep is taken away.

use crate::hand::Hand;
use microsim_geometry::Aabb;
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// Spacing of the grid \[m\]: a quarter of the shortest distance.
const SPACING: f64 = 0.08e-3;

/// Not yet reached.
const NONE: u32 = u32::MAX;

/// Near the sweep.
const NEAR: u32 = u32::MAX - 1;

/// A grid over a box with the region of each point.
pub struct Regions {
    low: V3,
    counts: [usize; 3],
    labels: Vec<u32>,
    /// Number of regions.
    pub count: u32,
}

impl Regions {
    /// The regions of a box that are farther than `distance` \[m\] from all that the blade has swept, without those of fewer than `least` \[m³\].
    pub fn of(bounds: &Aabb, hand: &Hand, distance: f64, least: f64) -> Self {
        let size = bounds.max - bounds.min;
        let counts = [0, 1, 2].map(|k| (size[k] / SPACING).ceil() as usize + 1);
        let mut regions = Self {
            low: bounds.min,
            counts,
            labels: vec![NONE; counts.iter().product()],
            count: 0,
        };
        regions.mark(hand);
        regions.grow(distance);
        let least = (least / (SPACING * SPACING * SPACING)).ceil() as usize;
        for start in 0..regions.labels.len() {
            if regions.labels[start] == NONE {
                let filled = regions.fill(start);
                if filled.len() < least {
                    filled.into_iter().for_each(|k| regions.labels[k] = NEAR);
                } else {
                    regions.count += 1;
                }
            }
        }
        regions
    }

    /// The region of a place; `None` near the sweep.
    pub fn at(&self, place: &V3) -> Option<u32> {
        let label = self.labels[self.index(self.cell(place)?)];
        (label < NEAR).then_some(label)
    }

    fn cell(&self, place: &V3) -> Option<[usize; 3]> {
        let cell = (place - self.low) / SPACING;
        let cell = [0, 1, 2].map(|k| cell[k].round());
        let is_in = |k: usize| (0.0..self.counts[k] as f64).contains(&cell[k]);
        (0..3).all(is_in).then(|| cell.map(|x| x as usize))
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.counts[1] + y) * self.counts[2] + z
    }

    fn cell_of(&self, index: usize) -> [usize; 3] {
        let [_, ny, nz] = self.counts;
        [index / (ny * nz), index / nz % ny, index % nz]
    }

    /// Marks the cells that the blade has come through.
    fn mark(&mut self, hand: &Hand) {
        for tick in 0..hand.ticks() {
            let [before, now] = [hand.blade_at(tick), hand.blade_at(tick + 1)];
            let path = [0, 1].map(|end| (now[end] - before[end]).norm());
            let steps = (path[0].max(path[1]) / SPACING).ceil().max(1.0);
            let samples = ((before[1] - before[0]).norm() / SPACING).ceil();
            for step in 0..=steps as usize {
                let at = [0, 1].map(|end| before[end].lerp(&now[end], step as f64 / steps));
                for sample in 0..=samples as usize {
                    let place = at[0].lerp(&at[1], sample as f64 / samples);
                    if let Some(cell) = self.cell(&place) {
                        let index = self.index(cell);
                        self.labels[index] = NEAR;
                    }
                }
            }
        }
    }

    /// Marks all within a distance of what is marked.
    fn grow(&mut self, distance: f64) {
        let reach = (distance / SPACING).ceil() as isize;
        let marked: Vec<_> = (0..self.labels.len())
            .filter(|k| self.labels[*k] == NEAR)
            .map(|k| self.cell_of(k).map(|x| x as isize))
            .collect();
        let square = (distance / SPACING).powi(2);
        for dx in -reach..=reach {
            for dy in -reach..=reach {
                for dz in -reach..=reach {
                    if (dx * dx + dy * dy + dz * dz) as f64 > square {
                        continue;
                    }
                    for [x, y, z] in &marked {
                        let cell = [x + dx, y + dy, z + dz];
                        let is_in = |k: usize| (0..self.counts[k] as isize).contains(&cell[k]);
                        if (0..3).all(is_in) {
                            let index = self.index(cell.map(|x| x as usize));
                            self.labels[index] = NEAR;
                        }
                    }
                }
            }
        }
    }

    /// Gives all that hangs together with `start` the next label.
    fn fill(&mut self, start: usize) -> Vec<usize> {
        self.labels[start] = self.count;
        let mut found = vec![start];
        let mut next = 0;
        while let Some(&index) = found.get(next) {
            next += 1;
            let cell = self.cell_of(index);
            for axis in 0..3 {
                for up in [false, true] {
                    let mut other = cell;
                    other[axis] = match up {
                        true => cell[axis] + 1,
                        false => cell[axis].wrapping_sub(1),
                    };
                    if other[axis] < self.counts[axis] {
                        let other = self.index(other);
                        if self.labels[other] == NONE {
                            self.labels[other] = self.count;
                            found.push(other);
                        }
                    }
                }
            }
        }
        found
    }
}
