//! A blade that stands still: a sheet of triangles.
//!
//! It is displaced a little as a moving blade is, so that a sheet through nodes of the mesh, along its edges or in its faces is on one side of
//! them; what is decided then is decided without rounding.

use crate::crossing::{Crossing, displacement};
use microsim_geometry::{Aabb, orientation};
use nalgebra::Vector3;

/// A sheet in current space: triangles with common points, so that they join without a gap. Positive is the side from which
/// the corners run counter-clockwise; neighbours have the same.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// Its points \[m\].
    pub points: Vec<Vector3<f64>>,
    /// Three points per triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Sheet {
    /// The quad `p0 p1 q1 q0` that a segment sweeps from `p` to `q`, divided along its shorter diagonal.
    pub fn quad(p: [Vector3<f64>; 2], q: [Vector3<f64>; 2]) -> Self {
        let [p0, p1] = p;
        let [q0, q1] = q;
        let first = (q1 - p0).norm_squared() <= (q0 - p1).norm_squared();
        Self {
            points: vec![p0, p1, q1, q0],
            triangles: if first {
                vec![[0, 1, 2], [0, 2, 3]]
            } else {
                vec![[0, 1, 3], [1, 2, 3]]
            },
        }
    }

    /// The surface of `rows` × `columns` quads through the points that `at` gives for numbers 0..1 along both: a curved or twisted sheet.
    pub fn grid(rows: usize, columns: usize, mut at: impl FnMut(f64, f64) -> Vector3<f64>) -> Self {
        let mut sheet = Self::default();
        for i in 0..=rows {
            for j in 0..=columns {
                let (u, v) = (i as f64 / rows as f64, j as f64 / columns as f64);
                sheet.points.push(at(u, v));
            }
        }
        let point = |i: usize, j: usize| (i * (columns + 1) + j) as u32;
        for i in 0..rows {
            for j in 0..columns {
                let [a, b] = [point(i, j), point(i, j + 1)];
                let [c, d] = [point(i + 1, j + 1), point(i + 1, j)];
                sheet.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        sheet
    }

    /// The sheet as it is tested against a mesh with this mean edge \[m\].
    pub(crate) fn displaced(&self, mean_edge: f64) -> Self {
        let by = displacement(mean_edge);
        Self {
            points: self.points.iter().map(|p| p + by).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Corners of a triangle.
    pub(crate) fn corners(&self, triangle: usize) -> [Vector3<f64>; 3] {
        self.triangles[triangle].map(|p| self.points[p as usize])
    }

    /// Box around it.
    pub(crate) fn bounds(&self) -> Aabb {
        Aabb::of(&self.points)
    }

    /// Box around each triangle.
    pub(crate) fn triangle_bounds(&self) -> Vec<Aabb> {
        let triangles = 0..self.triangles.len();
        triangles.map(|t| Aabb::of(&self.corners(t))).collect()
    }

    /// Where the edge `u`–`v` goes through; `boxes` are those of the triangles. `None` as well where it goes through and back. Decided
    /// without rounding; exactly on the sheet counts as the positive side, and every point of the sheet, its rim apart, belongs to
    /// exactly one triangle. An edge must always be asked from the same node.
    pub(crate) fn crossing(
        &self,
        u: &Vector3<f64>,
        v: &Vector3<f64>,
        boxes: &[Aabb],
    ) -> Option<Crossing> {
        let bounds = Aabb::of([u, v]);
        let mut found: Option<Crossing> = None;
        let mut count = 0;
        for (triangle, b) in boxes.iter().enumerate() {
            if !b.overlaps(&bounds) {
                continue;
            }
            if let Some(hit) = self.through(triangle, u, v) {
                count += 1;
                found = found.or(Some(hit));
            }
        }
        found.filter(|_| count % 2 == 1)
    }

    fn through(&self, triangle: usize, u: &Vector3<f64>, v: &Vector3<f64>) -> Option<Crossing> {
        let points = self.triangles[triangle];
        let [a, b, c] = self.corners(triangle);
        let (at_u, at_v) = (orientation(&a, &b, &c, u), orientation(&a, &b, &c, v));
        if (at_u >= 0.0) == (at_v >= 0.0) {
            return None;
        }
        // The side of the edge on which each edge of the sheet lies, asked in the order of the sheet's points: so two triangles
        // at an edge get opposite answers.
        let side = |i: usize, j: usize| {
            let (p, q) = (points[i], points[j]);
            let along = |p: u32, q: u32| {
                orientation(u, v, &self.points[p as usize], &self.points[q as usize]) >= 0.0
            };
            if p < q { along(p, q) } else { !along(q, p) }
        };
        let first = side(0, 1);
        if side(1, 2) != first || side(2, 0) != first {
            return None;
        }
        let fraction = at_u / (at_u - at_v);
        Some(Crossing {
            // Rounded values near 0 have the right sign alone.
            fraction: if fraction.is_finite() {
                fraction.clamp(0.0, 1.0)
            } else {
                0.5
            },
            positive: at_v >= 0.0,
            is_certain: true,
            normal: (b - a).cross(&(c - a)),
        })
    }
}

#[cfg(test)]
mod tests;
