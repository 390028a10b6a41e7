//! Winding numbers of a closed surface at the points of a lattice, along parallel lines.
//!
//! A line along x meets a triangle when its projection to (y, z) holds the line's point. That is decided edge by edge,
//! each edge always from its smaller vertex to its larger one, so that the triangles on both sides of an edge see the
//! same bits: rounding can move a crossing, but never lose or double one. The crossings of a closed surface therefore
//! cancel on every line, whatever its shape (they would not with a tolerance).

use super::lattice::Lattice;
use crate::TriangleSurface;
use nalgebra::Vector3;

/// Where a line enters (+1) or leaves (−1) the body.
struct Crossing {
    x: f64,
    triangle: u32,
    turn: i32,
}

/// A point around which the surface does not wind 0 times (outside) or once (inside).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Overlap {
    /// The winding number.
    pub(super) winding: i32,
    /// The triangle crossed last before it.
    pub(super) triangle: u32,
    /// The point \[m\].
    pub(super) point: Vector3<f64>,
}

/// Which points of `lattice` the outward closed `surface` holds.
pub(super) fn inside(surface: &TriangleSurface, lattice: &Lattice) -> Result<Vec<bool>, Overlap> {
    let mut inside = vec![false; lattice.len()];
    for parity in [0, 1] {
        let [along, rows, columns] = lattice.cells.map(|n| n + 1 - parity);
        let mut lines = crossings(surface, lattice, parity as i64, [rows, columns]);
        for k in 0..columns {
            for j in 0..rows {
                let line = &mut lines[k * rows + j];
                line.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.triangle.cmp(&b.triangle)));
                let (mut winding, mut passed) = (0, 0);
                for i in 0..along {
                    let p = [i, j, k].map(|c| (2 * c + parity) as i64);
                    let x = lattice.coordinate(0, p[0]);
                    while passed < line.len() && line[passed].x < x {
                        winding += line[passed].turn;
                        passed += 1;
                    }
                    let Some(index) = lattice.index(p) else {
                        continue;
                    };
                    match winding {
                        0 => {}
                        1 => inside[index as usize] = true,
                        winding => {
                            return Err(Overlap {
                                winding,
                                triangle: line[passed - 1].triangle,
                                point: lattice.position(index),
                            });
                        }
                    }
                }
            }
        }
    }
    Ok(inside)
}

/// The crossings of every line through the corners (`parity` 0) or centres (1) of the cells; `rows` lines along y, then
/// `columns` along z.
fn crossings(
    surface: &TriangleSurface,
    lattice: &Lattice,
    parity: i64,
    [rows, columns]: [usize; 2],
) -> Vec<Vec<Crossing>> {
    let mut lines: Vec<Vec<Crossing>> = (0..rows * columns).map(|_| Vec::new()).collect();
    // The lines that may lie between two coordinates along an axis, one more on each side than rounding could lose.
    let range = |axis: usize, from: f64, to: f64, count: usize| {
        let place = |x: f64| (x - lattice.origin[axis]) / lattice.cell - 0.5 * parity as f64;
        let first = (place(from).floor() as i64).max(0) as usize;
        let last = (place(to).ceil().max(0.0) as usize).min(count - 1);
        first..last + 1
    };
    for (index, triangle) in surface.triangles.iter().enumerate() {
        let corners = surface.corners(index);
        let low = corners[0].inf(&corners[1]).inf(&corners[2]);
        let high = corners[0].sup(&corners[1]).sup(&corners[2]);
        for k in range(2, low.z, high.z, columns) {
            let z = lattice.coordinate(2, 2 * k as i64 + parity);
            for j in range(1, low.y, high.y, rows) {
                let y = lattice.coordinate(1, 2 * j as i64 + parity);
                let turn: i32 = (0..3)
                    .map(|e| passes(surface, [triangle[e], triangle[(e + 1) % 3]], y, z))
                    .sum();
                if turn != 0 {
                    // Counter-clockwise in (y, z) seen against x: the normal points along x, so the line leaves.
                    lines[k * rows + j].push(Crossing {
                        x: height(&corners, y, z),
                        triangle: index as u32,
                        turn: -turn,
                    });
                }
            }
        }
    }
    lines
}

/// How the half-line from (y, z) towards larger y passes the directed edge in the plane (y, z): 1 when the edge rises in
/// z, −1 when it falls, 0 when it is not met. The sum over a triangle is its turn around the point.
fn passes(surface: &TriangleSurface, [from, to]: [u32; 2], y: f64, z: f64) -> i32 {
    let [a, b] = [from.min(to), from.max(to)].map(|v| surface.positions[v as usize]);
    if (a.z <= z) == (b.z <= z) {
        return 0;
    }
    // On which side of the rising edge the point lies; the point is left of it when its half-line meets the edge.
    let side = (b.y - a.y) * (z - a.z) - (y - a.y) * (b.z - a.z);
    let rises = a.z <= z;
    if (side > 0.0) != rises {
        return 0;
    }
    if rises == (from < to) { 1 } else { -1 }
}

/// The x at which the plane of the triangle is met \[m\], within the triangle's own.
fn height([a, b, c]: &[Vector3<f64>; 3], y: f64, z: f64) -> f64 {
    let (low, high) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
    let normal = (b - a).cross(&(c - a));
    let x = a.x - (normal.y * (y - a.y) + normal.z * (z - a.z)) / normal.x;
    if x.is_finite() {
        x.clamp(low, high)
    } else {
        // Seen edge-on: only rounding can bring a line here, and any x of the triangle is as good.
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An octahedron of radius 1: a point is inside when |x| + |y| + |z| < 1. Its vertices, edges and faces all meet
    /// lines of the lattice, which is aligned with them: the hardest case for counting.
    #[test]
    fn an_aligned_octahedron_holds_the_points_that_it_holds() {
        let unit = [Vector3::x(), Vector3::y(), Vector3::z()];
        let positions: Vec<_> = unit.iter().copied().chain(unit.map(|p| -p)).collect();
        let mut triangles = Vec::new();
        for (x, y, z) in [(0, 1, 2), (3, 4, 2), (3, 1, 5), (0, 4, 5)] {
            triangles.push([x, y, z]);
        }
        for (x, y, z) in [(3, 1, 2), (0, 4, 2), (0, 1, 5), (3, 4, 5)] {
            triangles.push([y, x, z]);
        }
        let surface = TriangleSurface {
            positions,
            triangles,
        };
        assert_eq!(surface.defects(), []);
        assert!((surface.volume() - 4.0 / 3.0).abs() < 1e-15);
        let lattice = Lattice {
            origin: Vector3::repeat(-1.25),
            cell: 0.25,
            cells: [10; 3],
        };
        let inside = inside(&surface, &lattice).unwrap();
        let mut counted = [0, 0];
        for (index, &inside) in inside.iter().enumerate() {
            let sum = lattice.position(index as u32).lp_norm(1);
            // Eighths are exact; points on the surface may be counted either way.
            if sum != 1.0 {
                assert_eq!(inside, sum < 1.0, "{}", lattice.position(index as u32));
                counted[usize::from(inside)] += 1;
            }
        }
        assert!(counted[0] > 1000 && counted[1] > 100);

        let mut twice = surface.clone();
        twice
            .positions
            .extend(surface.positions.iter().map(|p| p * 0.9));
        twice
            .triangles
            .extend(surface.triangles.iter().map(|t| t.map(|v| v + 6)));
        let overlap = super::inside(&twice, &lattice).unwrap_err();
        assert_eq!(overlap.winding, 2);
        assert!(overlap.triangle >= 8 && overlap.point.lp_norm(1) < 0.9);
    }
}
