//! Broad phase by spatial hashing (Teschner, Heidelberger, Müller, Pomeranets, Gross 2003: "Optimized spatial hashing for
//! collision detection of deformable objects").
//!
//! Space is divided into cubes; a table finds the cells that are in use by a hash of their three indices (4.4). Differences from
//! the paper and from the dissertation's text (NUMERICS 1.4): indices are rounded down, not towards zero; the table keeps each
//! cell's indices, so that two cells with one hash are never taken for one; a pair with several common cells is
//! reported once, in the first of them.
//!
//! Limitations: one size of cell for all. Boxes much larger than a cell are stored apart and compared one by one.

use crate::aabb::Aabb;
use crate::broad_phase::BroadPhase;

/// Factors of the hash function (4.4).
const FACTORS: [u32; 3] = [73_856_093, 19_349_663, 83_492_791];

/// A box over more cells than this is not entered into the table. At eight cells along each edge of a cube, comparing it with
/// each query costs less than its entries.
const CELLS_PER_BOX: u64 = 512;

/// A set of boxes, found by the cells that they overlap.
///
/// Nothing is cleared between two sets: each has a stamp, and what bears an older one counts as empty.
#[derive(Clone, Debug, Default)]
pub struct SpatialHash {
    /// Cells per metre; 0 puts everything into one cell.
    cells_per_metre: f64,
    items: Vec<Item>,
    /// Indices of the boxes over too many cells, ascending.
    large: Vec<u32>,
    /// The table: as long as a power of two, at most half full, open addresses.
    slots: Vec<Slot>,
    /// Stamp of this set.
    stamp: u32,
    /// The slots in use, in the order in which the boxes came to them.
    used: Vec<u32>,
    /// Slot of each entry, box by box and cell by cell.
    entries: Vec<u32>,
    /// Boxes of each cell, one cell after another, ascending within each.
    members: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Item {
    bounds: Aabb,
    first_cell: [i32; 3],
}

#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    cell: [i32; 3],
    stamp: u32,
    /// Where the cell's boxes begin in `members`.
    first: u32,
    count: u32,
}

/// The cells that a box overlaps.
#[derive(Clone, Copy)]
struct CellRange {
    first: [i32; 3],
    last: [i32; 3],
}

impl CellRange {
    /// Rounding and saturation keep the order of coordinates: boxes that overlap have a common cell wherever they are.
    fn of(bounds: &Aabb, cells_per_metre: f64) -> Self {
        let cell = |coordinate: f64| (coordinate * cells_per_metre).floor() as i32;
        Self {
            first: std::array::from_fn(|k| cell(bounds.min[k])),
            last: std::array::from_fn(|k| cell(bounds.max[k])),
        }
    }

    fn count(&self) -> u64 {
        (0..3)
            .map(|k| (i64::from(self.last[k]) - i64::from(self.first[k]) + 1).max(0) as u64)
            .fold(1, u64::saturating_mul)
    }

    /// Calls `visit` for each cell, in ascending order.
    #[inline]
    fn for_each(&self, mut visit: impl FnMut([i32; 3])) {
        for i in self.first[0]..=self.last[0] {
            for j in self.first[1]..=self.last[1] {
                for k in self.first[2]..=self.last[2] {
                    visit([i, j, k]);
                }
            }
        }
    }
}

impl SpatialHash {
    /// An empty set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces the set by `boxes`, with cells of `cell_size` \[m\]. The paper's choice is the mean edge length of the mesh, which is
    /// the fastest for nodes against tetrahedra; for boxes of surface triangles twice that is (example `broad_phase`). A
    /// size that is not positive and finite puts everything into one cell: slow, and right.
    pub fn rebuild(&mut self, cell_size: f64, boxes: &[Aabb]) {
        let cells_per_metre = cell_size.recip();
        self.cells_per_metre = if cells_per_metre.is_finite() && cells_per_metre > 0.0 {
            cells_per_metre
        } else {
            0.0
        };
        self.items.clear();
        self.large.clear();
        for (index, bounds) in boxes.iter().enumerate() {
            let range = CellRange::of(bounds, self.cells_per_metre);
            self.items.push(Item {
                bounds: *bounds,
                first_cell: range.first,
            });
            if range.count() > CELLS_PER_BOX && bounds.is_valid() {
                self.large.push(index as u32);
            }
        }
        let slots = 2 * boxes.len().next_power_of_two().max(CELLS_PER_BOX as usize);
        if self.slots.len() < slots {
            self.slots.resize(slots, Slot::default());
        }
        while !self.count_members() {
            let doubled = 2 * self.slots.len();
            self.slots.resize(doubled, Slot::default());
        }
        self.place_members();
    }

    /// Finds or makes the slot of every cell of every box and counts the boxes in it. False when the table is too full.
    fn count_members(&mut self) -> bool {
        self.next_stamp();
        self.used.clear();
        self.entries.clear();
        for item in &self.items {
            let Some(range) = entered(&item.bounds, self.cells_per_metre) else {
                continue;
            };
            // With room for the largest box, the table stays at most half full.
            if 2 * (self.used.len() + CELLS_PER_BOX as usize) > self.slots.len() {
                return false;
            }
            range.for_each(|cell| {
                let at = probe(&self.slots, self.stamp, &cell);
                let slot = &mut self.slots[at];
                if slot.stamp != self.stamp {
                    *slot = Slot {
                        cell,
                        stamp: self.stamp,
                        first: 0,
                        count: 0,
                    };
                    self.used.push(at as u32);
                }
                slot.count += 1;
                self.entries.push(at as u32);
            });
        }
        true
    }

    /// Sorts the boxes by cell, in the order of their indices.
    fn place_members(&mut self) {
        let mut first = 0;
        for &at in &self.used {
            let slot = &mut self.slots[at as usize];
            slot.first = first;
            first += slot.count;
            slot.count = 0;
        }
        self.members.clear();
        self.members.resize(self.entries.len(), 0);
        let mut entries = self.entries.iter();
        for (index, item) in self.items.iter().enumerate() {
            let Some(range) = entered(&item.bounds, self.cells_per_metre) else {
                continue;
            };
            for &at in entries.by_ref().take(range.count() as usize) {
                let slot = &mut self.slots[at as usize];
                self.members[(slot.first + slot.count) as usize] = index as u32;
                slot.count += 1;
            }
        }
    }

    /// A stamp that no slot bears.
    fn next_stamp(&mut self) {
        if self.stamp == u32::MAX {
            self.slots.fill(Slot::default());
            self.stamp = 0;
        }
        self.stamp += 1;
    }
}

impl BroadPhase for SpatialHash {
    fn len(&self) -> usize {
        self.items.len()
    }

    fn bounds(&self, index: u32) -> &Aabb {
        &self.items[index as usize].bounds
    }

    fn visit(&self, bounds: &Aabb, mut found: impl FnMut(u32)) {
        if !bounds.is_valid() {
            return;
        }
        let range = CellRange::of(bounds, self.cells_per_metre);
        // Over more cells than there are boxes, looking at every box is quicker.
        if range.count() > self.items.len() as u64 {
            for (index, item) in self.items.iter().enumerate() {
                if item.bounds.overlaps(bounds) {
                    found(index as u32);
                }
            }
            return;
        }
        for &index in &self.large {
            if self.bounds(index).overlaps(bounds) {
                found(index);
            }
        }
        range.for_each(|cell| {
            let slot = &self.slots[probe(&self.slots, self.stamp, &cell)];
            if slot.stamp != self.stamp {
                return;
            }
            let members = &self.members[slot.first as usize..][..slot.count as usize];
            for &index in members {
                let item = &self.items[index as usize];
                let is_first_shared =
                    (0..3).all(|k| cell[k] == range.first[k].max(item.first_cell[k]));
                if is_first_shared && item.bounds.overlaps(bounds) {
                    found(index);
                }
            }
        });
    }
}

/// The cells of a box that is entered into the table; `None` for one that is stored apart or overlaps nothing.
fn entered(bounds: &Aabb, cells_per_metre: f64) -> Option<CellRange> {
    let range = CellRange::of(bounds, cells_per_metre);
    (bounds.is_valid() && range.count() <= CELLS_PER_BOX).then_some(range)
}

/// Where `cell` stands, or where it would. The search ends, as the table is at most half full.
fn probe(slots: &[Slot], stamp: u32, cell: &[i32; 3]) -> usize {
    let mask = slots.len() - 1;
    let mut at = hash(cell) as usize & mask;
    while slots[at].stamp == stamp && slots[at].cell != *cell {
        at = (at + 1) & mask;
    }
    at
}

/// 4.4 before the remainder.
fn hash(cell: &[i32; 3]) -> u32 {
    (0..3).fold(0, |hash, k| {
        hash ^ (cell[k] as u32).wrapping_mul(FACTORS[k])
    })
}

#[cfg(test)]
mod tests;
