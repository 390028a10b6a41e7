//! Filling a front: with the blocks of the matrix, and with the updates of its children.

use crate::BlockMatrix;
use crate::kernels::triangle_start;
use crate::real::{Octet, Real, WIDTH};
use crate::symbolic::{Entry, Front, Kind, Symbolic};

/// A pivot must exceed this fraction of the diagonal entry that it is the rest of. Each subtraction rounds by up to ε/2 of that
/// entry, and there are some hundreds of either sign; what is smaller has no correct digit. A longer path through many
/// fronts can leave more, but a larger fraction would refuse slender bodies, whose pivots are small rightly.
fn pivot_fraction<T: Real>() -> T {
    T::EPSILON * T::from_f64(64.0)
}

/// Fills a panel with the blocks of the matrix, the nodes marked in `fixed` decoupled, and the identity in the rows
/// added at its end; and sets the least admissible pivot of each column.
pub(crate) fn assemble<T: Real>(
    entries: &[Entry],
    front: &Front,
    matrix: &BlockMatrix,
    fixed: Option<&[bool]>,
    panel: &mut [Octet<T>],
    least: &mut [T],
) {
    panel.fill(Octet::ZERO);
    let mut set = |target: usize, value: f64| {
        panel[target / WIDTH].0[target % WIDTH] = T::from_f64(value);
    };
    let added = 3 * front.columns.len()..WIDTH * front.triangle();
    least[added.clone()].fill(T::ZERO);
    for row in added {
        let (octet, lane) = Front::own_row(row);
        set(WIDTH * (octet + row) + lane, 1.0);
    }
    for entry in entries {
        let is_fixed =
            fixed.is_some_and(|fixed| entry.nodes.iter().any(|&node| fixed[node as usize]));
        let block = &matrix.values()[entry.slot as usize];
        let targets = entry.targets.map(|target| target as usize);
        match entry.kind {
            Kind::Diagonal(column) => {
                for (a, &target) in targets.iter().enumerate() {
                    for b in 0..a {
                        set(
                            target + WIDTH * b,
                            if is_fixed { 0.0 } else { block[(a, b)] },
                        );
                    }
                    let diagonal = if is_fixed { 1.0 } else { block[(a, a)] };
                    set(target + WIDTH * a, diagonal);
                    least[column as usize + a] =
                        pivot_fraction::<T>() * T::from_f64(diagonal.max(0.0));
                }
            }
            _ if is_fixed => {}
            Kind::Lower => {
                for (a, &target) in targets.iter().enumerate() {
                    (0..3).for_each(|b| set(target + WIDTH * b, block[(a, b)]));
                }
            }
            Kind::Upper => {
                for (a, &target) in targets.iter().enumerate() {
                    (0..3).for_each(|b| set(target + WIDTH * b, block[(b, a)]));
                }
            }
        }
    }
}

/// Which part of a front.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    Panel,
    Update,
}

/// Where the rows and columns of a child's update go in its parent.
#[derive(Debug)]
pub(crate) struct Places {
    /// First octet of the row, and its lane.
    rows: Vec<(u32, u32)>,
    columns: Vec<u32>,
}

impl Places {
    /// Room for updates of up to `rows` rows.
    pub fn new(rows: usize) -> Self {
        Self {
            rows: vec![(0, 0); rows],
            columns: vec![0; rows],
        }
    }

    /// Adds what the update of `child`, on `stack`, holds for one part of its parent's front to that part (`target`).
    pub fn add_update<T: Real>(
        &mut self,
        symbolic: &Symbolic,
        child: u32,
        parent: &Front,
        stack: &[Octet<T>],
        part: Part,
        target: &mut [Octet<T>],
    ) {
        let child = &symbolic.fronts[child as usize];
        let update = &stack[child.update..][..child.update_octets()];
        let in_parent = &symbolic.in_parent[child.rows.clone()];
        let count = 3 * in_parent.len();
        let split = self.find(in_parent, parent, part);
        let (begin, end) = if part == Part::Panel {
            (0, split)
        } else {
            (split, count)
        };
        let columns = &self.columns[..count];
        for strip in begin / WIDTH..count.div_ceil(WIDTH) {
            let first = WIDTH * strip;
            let source = &update[triangle_start(strip)..][..first + WIDTH];
            let rows = &self.rows[first..count.min(first + WIDTH)];
            // Eight rows at once left of the diagonal tile; row by row within it and where a strip is not whole.
            let mut done = begin;
            if let Ok(rows) = <&[(u32, u32); WIDTH]>::try_from(rows)
                && first >= begin
            {
                done = end.min(first);
                add_strip(rows, &columns[begin..done], &source[begin..done], target);
            }
            for (lane, row) in rows.iter().enumerate() {
                let last = end.min(first + lane + 1).max(done);
                for (&column, value) in columns[done..last].iter().zip(&source[done..last]) {
                    target[(row.0 + column) as usize].0[row.1 as usize % WIDTH] += value.0[lane];
                }
            }
        }
    }

    /// Sets the places of an update whose nodes have the numbers `in_parent`, within one part of the parent's front;
    /// returns how many of its rows the parent eliminates.
    fn find(&mut self, in_parent: &[u32], parent: &Front, part: Part) -> usize {
        let eliminated = parent.columns.len();
        let split = 3 * in_parent.partition_point(|&number| (number as usize) < eliminated);
        let first = if part == Part::Panel { 0 } else { split };
        for index in first..3 * in_parent.len() {
            let row = 3 * in_parent[index / 3] as usize + index % 3;
            let (row, (octet, lane)) = match part {
                Part::Panel if index < split => (row, Front::own_row(row)),
                Part::Panel => (row, parent.below_row(row - 3 * eliminated)),
                Part::Update => (row - 3 * eliminated, Front::own_row(row - 3 * eliminated)),
            };
            self.rows[index] = (octet as u32, lane as u32);
            self.columns[index] = row as u32;
        }
        split
    }
}

/// Adds the columns of a strip of which the eight rows go to these places.
fn add_strip<T: Real>(
    rows: &[(u32, u32); WIDTH],
    columns: &[u32],
    source: &[Octet<T>],
    target: &mut [Octet<T>],
) {
    let [(low, shift), .., (high, _)] = *rows;
    let shift = shift as usize % WIDTH;
    let follow = |(lane, row): (usize, &(u32, u32))| match shift + lane < WIDTH {
        true => *row == (low, (shift + lane) as u32),
        false => *row == (high, (shift + lane - WIDTH) as u32),
    };
    if rows.iter().enumerate().all(follow) {
        let add = match shift {
            0 => add_shifted::<T, 0>,
            1 => add_shifted::<T, 1>,
            2 => add_shifted::<T, 2>,
            3 => add_shifted::<T, 3>,
            4 => add_shifted::<T, 4>,
            5 => add_shifted::<T, 5>,
            6 => add_shifted::<T, 6>,
            _ => add_shifted::<T, 7>,
        };
        return add([low, high], columns, source, target);
    }
    for (&column, value) in columns.iter().zip(source) {
        for (lane, row) in rows.iter().enumerate() {
            target[(row.0 + column) as usize].0[row.1 as usize % WIDTH] += value.0[lane];
        }
    }
}

/// The same for rows that follow each other in the parent too, from lane `SHIFT` of the strip at octet `low` on; those beyond it begin that at `high`.
fn add_shifted<T: Real, const SHIFT: usize>(
    [low, high]: [u32; 2],
    columns: &[u32],
    source: &[Octet<T>],
    target: &mut [Octet<T>],
) {
    for (&column, value) in columns.iter().zip(source) {
        let (first, rest) = value.0.split_at(WIDTH - SHIFT);
        let place = &mut target[(low + column) as usize].0[SHIFT..];
        place.iter_mut().zip(first).for_each(|(sum, x)| *sum += *x);
        if SHIFT > 0 {
            let place = &mut target[(high + column) as usize].0[..SHIFT];
            place.iter_mut().zip(rest).for_each(|(sum, x)| *sum += *x);
        }
    }
}
