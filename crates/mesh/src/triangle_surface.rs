//! A triangle surface by itself, as files bring it, and what may be wrong with it.

use crate::SurfaceDefect;
use crate::defects::{COINCIDING, close_pairs};
use crate::topology::{Groups, edge_uses, pinched_nodes};
use microsim_geometry::triangle_normal;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Triangles in space: what surface files hold and what is filled with tetrahedra.
///
/// Unlike [`Surface`](crate::Surface) it belongs to no mesh. That it is closed and turned outward is not promised here;
/// [`TriangleSurface::defects`] checks it.
///
/// ```
/// use microsim_mesh::TriangleSurface;
/// use nalgebra::Vector3;
///
/// let mut surface = TriangleSurface {
///     positions: vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()],
///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// };
/// assert!(surface.defects().is_empty());
/// assert_eq!(surface.volume(), 1.0 / 6.0);
/// // Without a triangle there is a hole.
/// surface.triangles.pop();
/// assert!(!surface.defects().is_empty());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleSurface {
    /// Positions of the vertices \[m\].
    pub positions: Vec<Vector3<f64>>,
    /// Three vertex indices per triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleSurface {
    /// The corners of triangle `triangle` \[m\].
    pub fn corners(&self, triangle: usize) -> [Vector3<f64>; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }

    /// The volume it encloses \[m³\], negative when it faces inward. Meaningful only when it is closed.
    pub fn volume(&self) -> f64 {
        // About a vertex of the surface, so that a surface far from the origin does not lose digits.
        let origin = self.positions.first().copied().unwrap_or_default();
        (0..self.triangles.len())
            .map(|triangle| {
                let [a, b, c] = self.corners(triangle).map(|p| p - origin);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum()
    }

    /// Everything wrong with it as the boundary of a body; empty when nothing is. Triangles whose vertices are out of
    /// range, repeated or not finite take no part in the later checks. Crossing triangles are not looked for.
    pub fn defects(&self) -> Vec<SurfaceDefect> {
        let mut found = Vec::new();
        if self.triangles.is_empty() {
            found.push(SurfaceDefect::Empty);
        }
        let finite: Vec<bool> = self
            .positions
            .iter()
            .map(|p| p.iter().all(|x| x.is_finite()))
            .collect();
        for (i, _) in finite.iter().enumerate().filter(|(_, finite)| !**finite) {
            found.push(SurfaceDefect::NotFinite { vertex: i as u32 });
        }
        let sound = self.check_triangles(&finite, &mut found);
        let triangles: Vec<[u32; 3]> = sound.iter().map(|&t| self.triangles[t as usize]).collect();
        check_edges(&triangles, &sound, &mut found);
        for (vertex, sheets) in pinched_nodes(&triangles) {
            found.push(SurfaceDefect::VertexNotManifold { vertex, sheets });
        }
        self.check_vertices(&triangles, &finite, &mut found);
        found
    }

    /// Checks each triangle by itself; returns those that can take part in the later checks.
    fn check_triangles(&self, finite: &[bool], found: &mut Vec<SurfaceDefect>) -> Vec<u32> {
        let vertices = self.positions.len();
        let mut sound = Vec::with_capacity(self.triangles.len());
        let mut first: BTreeMap<[u32; 3], u32> = BTreeMap::new();
        for (index, t) in self.triangles.iter().enumerate() {
            let triangle = index as u32;
            if let Some(&vertex) = t.iter().find(|&&v| v as usize >= vertices) {
                found.push(SurfaceDefect::VertexOutOfRange {
                    triangle,
                    vertex,
                    vertices,
                });
                continue;
            }
            if let Some(k) = (0..3).find(|&k| t[k] == t[(k + 1) % 3]) {
                found.push(SurfaceDefect::RepeatedVertex {
                    triangle,
                    vertex: t[k],
                });
                continue;
            }
            if t.iter().any(|&v| !finite[v as usize]) {
                continue;
            }
            let mut key = *t;
            key.sort_unstable();
            if let Some(&first) = first.get(&key) {
                found.push(SurfaceDefect::Duplicated { triangle, first });
                continue;
            }
            first.insert(key, triangle);
            if triangle_normal(&self.corners(index)).is_none() {
                found.push(SurfaceDefect::Degenerate { triangle });
            }
            sound.push(triangle);
        }
        sound
    }

    /// Unused and coinciding vertices, unconnected parts.
    fn check_vertices(
        &self,
        triangles: &[[u32; 3]],
        finite: &[bool],
        found: &mut Vec<SurfaceDefect>,
    ) {
        let mut used = vec![false; self.positions.len()];
        for &v in self.triangles.iter().flatten() {
            if let Some(used) = used.get_mut(v as usize) {
                *used = true;
            }
        }
        for (i, _) in used.iter().enumerate().filter(|(_, used)| !**used) {
            found.push(SurfaceDefect::UnusedVertex { vertex: i as u32 });
        }

        let mut groups = Groups::new(self.positions.len());
        let mut in_sound = vec![false; self.positions.len()];
        let mut sum = 0.0;
        for t in triangles {
            for k in 0..3 {
                let (i, j) = (t[k] as usize, t[(k + 1) % 3] as usize);
                groups.join(i, j);
                in_sound[i] = true;
                sum += (self.positions[j] - self.positions[i]).norm();
            }
        }
        let count = (0..in_sound.len())
            .filter(|&i| in_sound[i] && groups.root(i) == i)
            .count();
        if count > 1 {
            found.push(SurfaceDefect::Components { count });
        }
        let reach = COINCIDING * sum / (3 * triangles.len()).max(1) as f64;
        for (i, j, distance) in close_pairs(&self.positions, finite, reach) {
            found.push(SurfaceDefect::CoincidingVertices {
                vertices: [i, j],
                distance,
            });
        }
    }
}

/// Open, over-full and wrongly run edges of `triangles`, whose indices in the surface are `names`.
fn check_edges(triangles: &[[u32; 3]], names: &[u32], found: &mut Vec<SurfaceDefect>) {
    for shared in edge_uses(triangles) {
        let edge = shared.edge;
        match shared.triangles[..] {
            [(t, _)] => found.push(SurfaceDefect::Open {
                edge,
                triangle: names[t as usize],
            }),
            [(s, forward), (t, also)] if forward == also => {
                found.push(SurfaceDefect::Orientation {
                    edge,
                    triangles: [names[s as usize], names[t as usize]],
                });
            }
            [_, _] => {}
            _ => found.push(SurfaceDefect::EdgeNotManifold {
                edge,
                triangle: names[shared.triangles[0].0 as usize],
                count: shared.triangles.len(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron of 1 mm, outward.
    fn tetrahedron() -> TriangleSurface {
        let h = 1e-3;
        TriangleSurface {
            positions: vec![
                Vector3::zeros(),
                Vector3::x() * h,
                Vector3::y() * h,
                Vector3::z() * h,
            ],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        }
    }

    fn texts(surface: &TriangleSurface) -> String {
        surface
            .defects()
            .iter()
            .map(|d| format!("{:?}: {d}\n", d.severity()))
            .collect()
    }

    #[test]
    fn a_sound_surface_has_no_defect_and_its_volume() {
        let mut surface = tetrahedron();
        assert_eq!(surface.defects(), []);
        // Moved by 10 m: coordinates round at 2e-15 m, edges of 1 mm lose no more than a few 1e-12 of themselves.
        surface
            .positions
            .iter_mut()
            .for_each(|p| *p += Vector3::repeat(10.0));
        assert!((surface.volume() / (1e-9 / 6.0) - 1.0).abs() < 1e-11);
        surface.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(surface.volume() < 0.0 && surface.defects().is_empty());
    }

    /// Each surface with one defect has this one complaint, with its place.
    #[test]
    fn each_defect_is_found_and_named() {
        type Spoil = fn(&mut TriangleSurface);
        let cases: [(Spoil, &[&str]); 10] = [
            (|s| s.triangles.clear(), &["Error: the surface has no"]),
            (
                |s| s.positions[2].x = f64::INFINITY,
                &["Error: vertex 2 has", "finite"],
            ),
            (
                |s| s.triangles[1] = [0, 1, 4],
                &["Error: triangle 1 names vertex 4", "0 to 3"],
            ),
            (
                |s| s.triangles.push([0, 3, 3]),
                &["Error: triangle 4 names vertex 3 more"],
            ),
            (
                |s| s.triangles.push([1, 0, 3]),
                &["Error: triangle 4 has the same vertices as triangle 1"],
            ),
            (
                |s| {
                    s.triangles.remove(2);
                },
                &[
                    "vertices 1 and 2 belongs to triangle 0 only",
                    "vertices 2 and 3",
                    "close the hole",
                ],
            ),
            (
                |s| s.triangles[2].swap(0, 1),
                &["triangles 1 and 2 run", "triangles 0 and 2", "flip"],
            ),
            (
                |s| s.positions[3] = Vector3::x() * 0.5e-3,
                &["Error: triangle 1 has no area"],
            ),
            (
                |s| s.positions.push(Vector3::repeat(1.0)),
                &["Warning: vertex 4 belongs to no"],
            ),
            (
                |s| {
                    let second = tetrahedron();
                    s.positions
                        .extend(second.positions.iter().map(|p| p + Vector3::repeat(5e-8)));
                    s.triangles
                        .extend(second.triangles.iter().map(|t| t.map(|v| v + 4)));
                },
                &[
                    "Warning: the surface falls into 2 parts",
                    "Warning: vertices 0 and 4 lie in one place",
                ],
            ),
        ];
        for (spoil, parts) in cases {
            let mut surface = tetrahedron();
            spoil(&mut surface);
            let text = texts(&surface);
            for part in parts {
                assert!(text.contains(part), "{text:?} does not contain {part:?}");
            }
        }
    }

    #[test]
    fn bodies_that_touch_in_a_vertex_or_an_edge_are_found() {
        let mut surface = tetrahedron();
        surface
            .positions
            .extend([Vector3::x(), Vector3::y(), Vector3::z()].map(|p| p * -1e-3));
        surface
            .triangles
            .extend([[0, 4, 5], [0, 6, 4], [4, 6, 5], [5, 6, 0]]);
        assert_eq!(
            surface.defects(),
            [SurfaceDefect::VertexNotManifold {
                vertex: 0,
                sheets: 2
            }]
        );
        // Vertex 4 becomes vertex 1: the edge 0–1 is shared.
        surface
            .triangles
            .iter_mut()
            .flatten()
            .for_each(|v| *v = if *v == 4 { 1 } else { *v });
        assert!(
            surface.defects().contains(&SurfaceDefect::EdgeNotManifold {
                edge: [0, 1],
                triangle: 0,
                count: 4
            }),
            "{}",
            texts(&surface)
        );
    }
}
