//! Warping the lattice to the surface and cutting its tetrahedra (Labelle & Shewchuk 2007, uniform lattice).
//!
//! Every tetrahedron is cut by itself from nothing but its own points, and each of its faces from nothing but the
//! face's points, so that neighbours fit.

use super::lattice::Lattice;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// A crossing closer to an end of a long edge than this fraction of the edge pulls that end onto the surface. With
/// [`WARP_SHORT`] the paper's pair: the bounds of the angles are an optimum there, or close to it.
pub(super) const WARP_LONG: f64 = 0.24999;

/// The same for the short edges.
pub(super) const WARP_SHORT: f64 = 0.41189;

/// Where a point of the warped lattice lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    Inside,
    Surface,
    Outside,
}

/// A corner of a piece: a point of the lattice, or the crossing of an edge, smaller point first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Corner {
    Point(u32),
    Crossing(u32, u32),
}

/// The inside of a surface on `lattice`: node positions \[m\] and positive tetrahedra. `crossing(i, o)` is the place where
/// the surface crosses the edge from the inside point `i` to the outside point `o`, as a fraction of the edge from `i`.
pub(super) fn stuff(
    lattice: &Lattice,
    inside: &[bool],
    crossing: impl FnMut(u32, u32) -> f64,
) -> (Vec<Vector3<f64>>, Vec<[u32; 4]>) {
    let mut crossings = crossings(lattice, inside, crossing);
    let warped = warp(lattice, &mut crossings);
    let mut pieces = Pieces {
        lattice,
        inside,
        warped,
        crossings,
        nodes: BTreeMap::new(),
        positions: Vec::new(),
        tets: Vec::new(),
    };
    lattice.visit_tets(|tet| pieces.cut(tet));
    (pieces.positions, pieces.tets)
}

/// The crossing of every edge with one end inside, as a fraction from the smaller point.
fn crossings(
    lattice: &Lattice,
    inside: &[bool],
    mut crossing: impl FnMut(u32, u32) -> f64,
) -> BTreeMap<(u32, u32), f64> {
    let mut crossings = BTreeMap::new();
    for i in (0..lattice.len() as u32).filter(|&i| inside[i as usize]) {
        for o in lattice.neighbours(i).filter(|&o| !inside[o as usize]) {
            let share = crossing(i, o).clamp(0.0, 1.0);
            crossings.insert(
                (i.min(o), i.max(o)),
                if i < o { share } else { 1.0 - share },
            );
        }
    }
    crossings
}

/// Moves every point with a crossing too close to it onto the closest of those crossings; the crossings of its edges are
/// then gone. Returns the moved points with their new places \[m\].
fn warp(
    lattice: &Lattice,
    crossings: &mut BTreeMap<(u32, u32), f64>,
) -> BTreeMap<u32, Vector3<f64>> {
    let mut ends: Vec<u32> = crossings.keys().flat_map(|&(i, j)| [i, j]).collect();
    ends.sort_unstable();
    ends.dedup();
    let mut warped = BTreeMap::new();
    for point in ends {
        let mut closest: Option<(f64, u32, f64)> = None;
        for other in lattice.neighbours(point) {
            let key = (point.min(other), point.max(other));
            let Some(&share) = crossings.get(&key) else {
                continue;
            };
            let share = if point < other { share } else { 1.0 - share };
            let long = lattice.is_long(point, other);
            let (limit, length) = if long {
                (WARP_LONG, 1.0)
            } else {
                (WARP_SHORT, 0.75f64.sqrt())
            };
            if share < limit && closest.is_none_or(|(distance, ..)| share * length < distance) {
                closest = Some((share * length, other, share));
            }
        }
        let Some((_, other, share)) = closest else {
            continue;
        };
        let (from, to) = (lattice.position(point), lattice.position(other));
        warped.insert(point, from + (to - from) * share);
        for other in lattice.neighbours(point) {
            crossings.remove(&(point.min(other), point.max(other)));
        }
    }
    warped
}

/// The pieces cut so far.
struct Pieces<'a> {
    lattice: &'a Lattice,
    inside: &'a [bool],
    warped: BTreeMap<u32, Vector3<f64>>,
    crossings: BTreeMap<(u32, u32), f64>,
    nodes: BTreeMap<Corner, u32>,
    positions: Vec<Vector3<f64>>,
    tets: Vec<[u32; 4]>,
}

impl Pieces<'_> {
    fn side(&self, point: u32) -> Side {
        if self.warped.contains_key(&point) {
            Side::Surface
        } else if self.inside[point as usize] {
            Side::Inside
        } else {
            Side::Outside
        }
    }

    /// Adds what of the tetrahedron lies inside.
    fn cut(&mut self, mut tet: [u32; 4]) {
        // Inside, surface, outside: a bubble sort, so that each swap is known to turn the orientation.
        let mut turned = false;
        for last in [3, 2, 1] {
            for i in 0..last {
                if self.side(tet[i]) > self.side(tet[i + 1]) {
                    tet.swap(i, i + 1);
                    turned = !turned;
                }
            }
        }
        let count = |side| tet.iter().filter(|&&p| self.side(p) == side).count();
        let (inside, outside) = (count(Side::Inside), count(Side::Outside));
        if inside == 0 {
            return;
        }
        // Back to positive; the first two are on the same side, or the last two are, or there is one of each of three.
        if turned {
            let pair = (0..3).find(|&i| self.side(tet[i]) == self.side(tet[i + 1]));
            let pair = pair.unwrap_or(0);
            tet.swap(pair, pair + 1);
        }
        let [a, b, c, d] = tet;
        let point = Corner::Point;
        let cross = |i: u32, o: u32| Corner::Crossing(i.min(o), i.max(o));
        match (inside, outside) {
            (_, 0) => self.add(tet.map(point)),
            (1, _) => {
                let ends = [b, c, d].map(|p| match self.side(p) {
                    Side::Outside => cross(a, p),
                    _ => point(p),
                });
                self.add([point(a), ends[0], ends[1], ends[2]]);
            }
            // A pyramid over the quadrilateral in the face without the surface point.
            (2, 1) => {
                if self.diagonal_from_first(a, b, d) {
                    self.add([point(a), point(b), point(c), cross(b, d)]);
                    self.add([point(a), cross(b, d), point(c), cross(a, d)]);
                } else {
                    self.add([point(a), point(b), point(c), cross(a, d)]);
                    self.add([cross(a, d), point(b), point(c), cross(b, d)]);
                }
            }
            // A wedge with the edges at a and at b; the quadrilateral between the crossings belongs to the boundary, so
            // its diagonal is free: the shorter one, unless the other two would leave no tetrahedron then.
            (2, _) => {
                let near = [point(a), cross(a, c), cross(a, d)];
                let far = [point(b), cross(b, c), cross(b, d)];
                let first = self.diagonal_from_first(a, b, c);
                let last = !self.diagonal_from_first(a, b, d);
                let middle = if first == last {
                    !first
                } else {
                    self.distance(near[1], far[2]) < self.distance(far[1], near[2])
                };
                self.add_prism(near, far, [first, middle, last]);
            }
            // The tetrahedron without the corner d.
            _ => {
                let diagonals = [(a, b), (b, c), (c, a)]
                    .map(|(from, to)| self.diagonal_from_first(from, to, d));
                self.add_prism(
                    [a, b, c].map(point),
                    [a, b, c].map(|p| cross(p, d)),
                    diagonals,
                );
            }
        }
    }

    /// Whether the quadrilateral that is left of the face (`u`, `v`, `outside`) is cut from `u` to the crossing on the
    /// edge of `v`. The diagonal ends at the crossing of the long edge; where both crossings are on short edges, at the
    /// odd one of the two points.
    fn diagonal_from_first(&self, u: u32, v: u32, outside: u32) -> bool {
        if self.lattice.is_long(u, v) {
            self.lattice.is_odd(u)
        } else {
            self.lattice.is_long(v, outside)
        }
    }

    /// Adds the prism between the triangles `top` and `bottom`, (top, bottom[0]) positive. `diagonals[i]` states whether
    /// the quadrilateral of the edges i and i + 1 is cut from `top[i]` to `bottom[i + 1]`; not all three are equal.
    fn add_prism(&mut self, top: [Corner; 3], bottom: [Corner; 3], diagonals: [bool; 3]) {
        // One corner of the top has two diagonals: cut off the bottom, then the pyramid over the opposite quadrilateral.
        let apex = (0..3)
            .find(|&i| diagonals[i] && !diagonals[(i + 2) % 3])
            .unwrap_or(0);
        let (i, j, k) = (apex, (apex + 1) % 3, (apex + 2) % 3);
        self.add([top[i], bottom[0], bottom[1], bottom[2]]);
        if diagonals[j] {
            self.add([top[i], top[j], top[k], bottom[k]]);
            self.add([top[i], top[j], bottom[k], bottom[j]]);
        } else {
            self.add([top[i], top[j], top[k], bottom[j]]);
            self.add([top[i], top[k], bottom[k], bottom[j]]);
        }
    }

    fn add(&mut self, corners: [Corner; 4]) {
        let tet = corners.map(|corner| match self.nodes.get(&corner) {
            Some(&node) => node,
            None => {
                let node = self.positions.len() as u32;
                self.positions.push(self.place(corner));
                self.nodes.insert(corner, node);
                node
            }
        });
        self.tets.push(tet);
    }

    fn place(&self, corner: Corner) -> Vector3<f64> {
        match corner {
            Corner::Point(point) => match self.warped.get(&point) {
                Some(place) => *place,
                None => self.lattice.position(point),
            },
            Corner::Crossing(i, j) => {
                let (from, to) = (self.lattice.position(i), self.lattice.position(j));
                // Every edge between an inside and an outside point has its crossing.
                let share = self.crossings.get(&(i, j)).copied().unwrap_or(0.5);
                from + (to - from) * share
            }
        }
    }

    fn distance(&self, a: Corner, b: Corner) -> f64 {
        (self.place(a) - self.place(b)).norm()
    }
}

#[cfg(test)]
mod tests;
