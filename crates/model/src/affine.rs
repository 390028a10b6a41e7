//! Affine maps.

/// An affine map: `linear`, by rows, then `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Linear part, by rows.
    pub linear: [[f64; 3]; 3],
    /// Where the origin comes to lie.
    pub offset: [f64; 3],
}

impl Affine {
    /// Leaves all as it is.
    pub const IDENTITY: Self = Self {
        linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        offset: [0.0; 3],
    };

    fn turned(&self, v: [f64; 3]) -> [f64; 3] {
        self.linear
            .map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// Where a point comes to lie.
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let t = self.turned(p);
        [0, 1, 2].map(|i| t[i] + self.offset[i])
    }

    /// This map behind another.
    pub fn after(&self, first: &Self) -> Self {
        let columns = [0, 1, 2].map(|j| self.turned([0, 1, 2].map(|i| first.linear[i][j])));
        Self {
            linear: [0, 1, 2].map(|i| [0, 1, 2].map(|j| columns[j][i])),
            offset: self.point(first.offset),
        }
    }

    /// Whether its numbers are finite, and not too large for single precision to work with.
    pub(crate) fn is_bounded(&self) -> bool {
        let mut numbers = self.linear.as_flattened().iter().chain(&self.offset);
        numbers.all(|x| x.abs() <= 1e6)
    }

    /// Cofactors of the linear part: what normals are multiplied by, up to their length and the sign of the determinant.
    pub(crate) fn cofactors(&self) -> [[f64; 3]; 3] {
        let m = &self.linear;
        let minor = |i: usize, j: usize| {
            let (r, s) = ((i + 1) % 3, (i + 2) % 3);
            let (c, d) = ((j + 1) % 3, (j + 2) % 3);
            m[r][c] * m[s][d] - m[r][d] * m[s][c]
        };
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| minor(i, j)))
    }

    /// Determinant of the linear part.
    pub(crate) fn determinant(&self) -> f64 {
        let (m, c) = (&self.linear, self.cofactors());
        m[0][0] * c[0][0] + m[0][1] * c[0][1] + m[0][2] * c[0][2]
    }
}
