//! The body-centred cubic lattice and its tetrahedra.

use nalgebra::Vector3;

/// Cubic cells with a point at each corner and one in each centre. Points are addressed by doubled coordinates: corners
/// are even in all three, centres odd.
///
/// A tetrahedron has one long edge between two corners, one between two centres, across it, both as long as a cell, and
/// four short edges (√3/2 of a cell) between them.
pub(super) struct Lattice {
    pub(super) origin: Vector3<f64>,
    /// Edge of a cell \[m\].
    pub(super) cell: f64,
    /// Number of cells along each axis.
    pub(super) cells: [usize; 3],
}

impl Lattice {
    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.corners() + self.cells.iter().product::<usize>()
    }

    fn corners(&self) -> usize {
        self.cells.iter().map(|n| n + 1).product()
    }

    /// The index of the point at the doubled coordinates `p`, if it is there.
    pub(super) fn index(&self, p: [i64; 3]) -> Option<u32> {
        let centre = p[0].rem_euclid(2) as usize;
        let mut index = 0;
        for axis in [2, 1, 0] {
            let along = self.cells[axis] + 1 - centre;
            let i = usize::try_from(p[axis].div_euclid(2)).ok()?;
            if i >= along || p[axis].rem_euclid(2) as usize != centre {
                return None;
            }
            index = index * along + i;
        }
        Some((index + centre * self.corners()) as u32)
    }

    /// The doubled coordinates of a point.
    pub(super) fn coordinates(&self, index: u32) -> [i64; 3] {
        let centre = usize::from(self.is_centre(index));
        let mut rest = index as usize - centre * self.corners();
        [0, 1, 2].map(|axis| {
            let along = self.cells[axis] + 1 - centre;
            let i = rest % along;
            rest /= along;
            (2 * i + centre) as i64
        })
    }

    pub(super) fn is_centre(&self, index: u32) -> bool {
        index as usize >= self.corners()
    }

    /// The coordinate \[m\] along `axis` of the points with the doubled coordinate `p`.
    pub(super) fn coordinate(&self, axis: usize, p: i64) -> f64 {
        self.origin[axis] + self.cell * (0.5 * p as f64)
    }

    /// The place of a point \[m\].
    pub(super) fn position(&self, index: u32) -> Vector3<f64> {
        let p = self.coordinates(index);
        Vector3::from_fn(|axis, _| self.coordinate(axis, p[axis]))
    }

    /// The points at the other ends of the edges at a point: 6 long edges, then 8 short ones.
    pub(super) fn neighbours(&self, index: u32) -> impl Iterator<Item = u32> + '_ {
        let [p, q, r] = self.coordinates(index);
        let long = [
            [2, 0, 0],
            [-2, 0, 0],
            [0, 2, 0],
            [0, -2, 0],
            [0, 0, 2],
            [0, 0, -2],
        ];
        let short = (0..8).map(|bits| [0, 1, 2].map(|axis| 2 * (bits >> axis & 1) - 1));
        long.into_iter()
            .chain(short)
            .filter_map(move |[i, j, k]: [i64; 3]| self.index([p + i, q + j, r + k]))
    }

    /// Whether the edge between two neighbours is a long one.
    pub(super) fn is_long(&self, i: u32, j: u32) -> bool {
        self.is_centre(i) == self.is_centre(j)
    }

    /// Whether the sum of the cell indices of a point is odd; the two ends of a long edge differ in this.
    pub(super) fn is_odd(&self, index: u32) -> bool {
        self.coordinates(index)
            .iter()
            .map(|p| p.div_euclid(2))
            .sum::<i64>()
            % 2
            == 1
    }

    /// Calls `f` with every tetrahedron between two centres and an edge of the face between their cells, positive.
    pub(super) fn visit_tets(&self, mut f: impl FnMut([u32; 4])) {
        for centre in self.corners()..self.len() {
            let from = self.coordinates(centre as u32);
            for axis in 0..3 {
                let (right, up) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut to = from;
                to[axis] += 2;
                let Some(other) = self.index(to) else {
                    continue;
                };
                // The corners of the face, counter-clockwise about the axis.
                let ring = [(1, 1), (-1, 1), (-1, -1), (1, -1)].map(|(r, u)| {
                    let mut corner = from;
                    corner[axis] += 1;
                    corner[right] += r;
                    corner[up] += u;
                    // The corners of a cell are always there.
                    self.index(corner).unwrap_or(0)
                });
                for k in 0..4 {
                    f([centre as u32, other, ring[k], ring[(k + 1) % 4]]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_geometry::signed_volume;

    /// Twelve congruent tetrahedra per inner cell, each 1/12 of it; one centre pair per inner face.
    #[test]
    fn tetrahedra_are_positive_equal_and_have_the_stated_edges() {
        let lattice = Lattice {
            origin: Vector3::new(1.0, 2.0, 3.0),
            cell: 0.5,
            cells: [3, 4, 2],
        };
        assert_eq!(lattice.len(), 4 * 5 * 3 + 3 * 4 * 2);
        let mut count = 0;
        lattice.visit_tets(|tet| {
            count += 1;
            let [a, b, c, d] = tet.map(|i| lattice.position(i));
            assert!((signed_volume(&a, &b, &c, &d) - 0.125 / 12.0).abs() < 1e-15);
            for i in 0..4 {
                for j in 0..i {
                    let length = (lattice.position(tet[i]) - lattice.position(tet[j])).norm();
                    let long = lattice.is_long(tet[i], tet[j]);
                    let expected = if long { 0.5 } else { 0.75f64.sqrt() * 0.5 };
                    assert!((length - expected).abs() < 1e-15);
                    assert!(!long || lattice.is_odd(tet[i]) != lattice.is_odd(tet[j]));
                    assert!(lattice.neighbours(tet[i]).any(|n| n == tet[j]));
                }
            }
        });
        assert_eq!(count, 4 * (2 * 4 * 2 + 3 * 3 * 2 + 3 * 4));
    }

    #[test]
    fn every_point_has_one_index() {
        let lattice = Lattice {
            origin: Vector3::zeros(),
            cell: 1.0,
            cells: [2, 3, 1],
        };
        for index in 0..lattice.len() as u32 {
            assert_eq!(lattice.index(lattice.coordinates(index)), Some(index));
        }
        for outside in [[-2, 0, 0], [0, 8, 0], [5, 1, 1], [1, 0, 1], [1, 1, -1]] {
            assert_eq!(lattice.index(outside), None);
        }
        let middle = lattice.index([2, 2, 2]).unwrap();
        assert_eq!(lattice.neighbours(middle).count(), 6 + 4 - 1);
    }
}
