//! Filling a closed triangle surface with tetrahedra.
//!
//! The steps are those of Müller & Teschner 2003 (dissertation 3.3): a grid of cells over the surface, cells cut into
//! tetrahedra, those outside left away, nodes near the surface moved onto it. The cells and the cutting are those of
//! isosurface stuffing (Labelle & Shewchuk 2007, uniform lattice): body-centred cubic cells, nodes warped onto the
//! surface where it comes too close, the rest cut by stencils. It needs no iteration towards the surface and no
//! smoothing, and it bounds the shape of every element beforehand, which the original steps do not.
//!
//! **What holds** for any surface that passes the checks and any `cell_size` h:
//! - The mesh fits together, every element is positive, no dihedral angle is below [`MIN_DIHEDRAL`] or above
//!   [`MAX_DIHEDRAL`]. The bounds are those of an enumeration of all cut pieces, which is a test here.
//! - Every node of the boundary lies on the surface, and no boundary edge is longer than 1.72 h (a long edge with both
//!   ends moved). So no point of the boundary is farther than 1.72 h/√3 < h from the surface. Where the surface is
//!   smooth, with radii of curvature above R ≫ h, it is within (1.72 h)²/(6R) < h²/(2R), and the error of the volume is
//!   below that times the area.
//! - Sharp edges become chamfers of about h. At right angles the volume lacks below 0.2 h² for each metre of edge
//!   (measured: 0.11).
//!
//! **Limitations.** What is thinner than about 1.5 h can be lost: the boundary lies on the surface, but not everywhere
//! where the surface is. If parts of the result touch in an edge or node only, the filling is refused. Elements are about
//! h everywhere; there is no grading. The lattice is parallel to the axes, with a layer of cell corners in the lower
//! sides of the bounding box: a box parallel to the axes, its sides multiples of h, is met exactly. Crossing triangles
//! are noticed only where the surface winds around a lattice point more than once.

mod fitted;
mod lattice;
mod stuffing;
mod winding;

use crate::box_grid::BoxGrid;
use crate::topology::{edge_uses, pinched_nodes};
use crate::{Severity, SurfaceDefect, TetMesh, TriangleSurface};
pub use fitted::{Fitted, LEAST_HEIGHT, fit_lattice};
use lattice::Lattice;
use microsim_geometry::{Aabb, closest_on_triangle};
use nalgebra::Vector3;

/// No dihedral angle of a filled surface is smaller \[rad\]: 9.2°.
pub const MIN_DIHEDRAL: f64 = 0.1605;

/// No dihedral angle of a filled surface is larger \[rad\]: 161.65°.
pub const MAX_DIHEDRAL: f64 = 2.8214;

/// Largest number of cells over the bounding box.
const MAX_CELLS: usize = 1 << 22;

/// Why a surface cannot be filled.
#[derive(Clone, Debug, PartialEq)]
pub enum FillError {
    /// The surface does not bound a body; every error, no warnings.
    Surface(Vec<SurfaceDefect>),
    /// The surface winds around a point neither 0 times nor once: parts overlap, or an inner shell faces outward.
    Overlap {
        /// How often it winds around the point.
        winding: i32,
        /// A triangle between the point and the outside.
        triangle: u32,
        /// The point \[m\].
        point: [f64; 3],
    },
    /// The cell size is not finite and positive, or the bounding box would need too many cells.
    CellSize {
        /// What was asked for \[m\].
        cell_size: f64,
        /// The smallest size that would do \[m\].
        least: f64,
    },
    /// Cells too large for the body: nothing is left of it, or parts of the result touch in an edge or node only.
    Coarse {
        /// What was asked for \[m\].
        cell_size: f64,
        /// Where \[m\].
        point: [f64; 3],
    },
}

impl std::fmt::Display for FillError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Surface(defects) => {
                write!(
                    f,
                    "a surface must be closed, manifold and turned one way to be filled"
                )?;
                for defect in defects.iter().take(3) {
                    write!(f, "; {defect}")?;
                }
                match defects.len() {
                    0..=3 => Ok(()),
                    n => write!(f, "; and {} more", n - 3),
                }
            }
            Self::Overlap {
                winding,
                triangle,
                point,
            } => write!(
                f,
                "the surface winds {winding} times around the point {point:?} m, behind triangle {triangle}; 0 or 1 expected: separate parts that overlap there, or turn an inner shell inward"
            ),
            Self::CellSize { cell_size, least } => write!(
                f,
                "the cell size must be finite and at least {least:.1e} m for this surface (at most {MAX_CELLS} cells), not {cell_size:?} m"
            ),
            Self::Coarse { cell_size, point } => write!(
                f,
                "cells of {cell_size:?} m are too large for the body near {point:?} m: what is thinner than about 1.5 cells is lost or torn; use smaller cells"
            ),
        }
    }
}

impl std::error::Error for FillError {}

impl From<winding::Overlap> for FillError {
    fn from(overlap: winding::Overlap) -> Self {
        Self::Overlap {
            winding: overlap.winding,
            triangle: overlap.triangle,
            point: overlap.point.into(),
        }
    }
}

/// Fills the closed `surface` with tetrahedra of about `cell_size` \[m\], the edge of a cubic cell and the longest edge of
/// an inner element; a cell holds twelve. All in region 0. A surface that faces inward as a whole is taken as turned.
///
/// ```
/// use microsim_mesh::{Block, CellSplit, TriangleSurface, defects, fill};
///
/// // The boundary of a cube of 1 cm, filled again.
/// let block = Block { center: [0.0; 3], size: [0.01; 3], cells: [1; 3], split: CellSplit::Kuhn };
/// let cube = block.mesh()?;
/// let surface = TriangleSurface {
///     triangles: cube.surface().triangles,
///     positions: cube.positions,
/// };
/// let mesh = fill(&surface, 0.002)?;
/// assert!(defects(&mesh).is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fill(surface: &TriangleSurface, cell_size: f64) -> Result<TetMesh, FillError> {
    let surface = outward(surface)?;
    let lattice = lattice_around(&surface, cell_size)?;
    let inside = winding::inside(&surface, &lattice)?;
    let boxes: Vec<Aabb> = (0..surface.triangles.len())
        .map(|triangle| Aabb::of(&surface.corners(triangle)))
        .collect();
    let grid = BoxGrid::new(&boxes);
    let (positions, tets) = stuffing::stuff(&lattice, &inside, |i, o| {
        crossing(&surface, &grid, &lattice.position(i), &lattice.position(o))
    });

    let regions = vec![0; tets.len()];
    let mesh = TetMesh::new(positions, tets, regions);
    if let Some(point) = torn(&mesh, &surface) {
        return Err(FillError::Coarse {
            cell_size,
            point: point.into(),
        });
    }
    Ok(mesh)
}

/// A copy of `surface` that faces outward, if it bounds a body.
fn outward(surface: &TriangleSurface) -> Result<TriangleSurface, FillError> {
    let mut errors = surface.defects();
    errors.retain(|defect| defect.severity() == Severity::Error);
    if !errors.is_empty() {
        return Err(FillError::Surface(errors));
    }
    let mut surface = surface.clone();
    if surface.volume() < 0.0 {
        surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(surface)
}

/// The lattice over the used vertices, one cell wider on each side.
fn lattice_around(surface: &TriangleSurface, cell_size: f64) -> Result<Lattice, FillError> {
    let corners = surface
        .triangles
        .iter()
        .flatten()
        .map(|&v| &surface.positions[v as usize]);
    let bounds = Aabb::of(corners);
    let size = bounds.max - bounds.min;
    let count = |cell: f64| size.map(|s| (s / cell).ceil() + 2.0);
    let fits = |cell: f64| count(cell).product() <= MAX_CELLS as f64;
    if !(cell_size.is_finite() && cell_size > 0.0 && fits(cell_size)) {
        // The longest side alone fits for sure; halve while the whole does.
        let mut least = size.max();
        while fits(least / 2.0) {
            least /= 2.0;
        }
        return Err(FillError::CellSize { cell_size, least });
    }
    let count = count(cell_size);
    Ok(Lattice {
        origin: bounds.min - Vector3::repeat(cell_size),
        cell: cell_size,
        cells: [count.x as usize, count.y as usize, count.z as usize],
    })
}

/// Where the surface crosses the segment between the points `i` inside and `o` outside, as a fraction from `i`; the
/// crossing closest to `i` of several.
fn crossing(surface: &TriangleSurface, grid: &BoxGrid, i: &Vector3<f64>, o: &Vector3<f64>) -> f64 {
    let direction = o - i;
    let mut first = f64::INFINITY;
    for triangle in grid.near(&Aabb::of([i, o])) {
        let [a, b, c] = surface.corners(triangle as usize);
        let normal = (b - a).cross(&(c - a));
        let approach = direction.dot(&normal);
        // From the inside through the outside of the triangle only: the other way it is no crossing from i.
        if approach <= 0.0 {
            continue;
        }
        let share = (a - i).dot(&normal) / approach;
        let point = i + direction * share;
        // Shares of the triangle's area on the left of each edge; a hair outside still counts, so that a crossing on
        // an edge is not missed by both sides.
        let area = normal.norm_squared();
        let within = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(from, to)| (to - from).cross(&(point - from)).dot(&normal) >= -1e-9 * area);
        if within && (-1e-9..=1.0 + 1e-9).contains(&share) {
            first = first.min(share);
        }
    }
    if first.is_finite() {
        return first;
    }
    // The line only grazes the surface, within rounding: where the distances of the two ends say.
    let distance = |p: &Vector3<f64>| {
        let mut least = f64::INFINITY;
        grid.search_nearest(p, |triangle| {
            let closest = closest_on_triangle(p, &surface.corners(triangle as usize)).point;
            let distance = (closest - p).norm();
            least = least.min(distance);
            distance
        });
        least
    };
    let (from_i, from_o) = (distance(i), distance(o));
    if from_i + from_o > 0.0 {
        from_i / (from_i + from_o)
    } else {
        0.5
    }
}

/// A place where parts of `mesh` touch in an edge or node only; a vertex of `surface` when there is no element at all.
fn torn(mesh: &TetMesh, surface: &TriangleSurface) -> Option<Vector3<f64>> {
    if mesh.tets.is_empty() {
        return surface
            .triangles
            .first()
            .map(|t| surface.positions[t[0] as usize]);
    }
    let boundary = mesh.surface().triangles;
    let edges = edge_uses(&boundary);
    let edge = edges.iter().find(|shared| shared.triangles.len() > 2);
    let node = edge.map(|shared| shared.edge[0]).or_else(|| {
        let pinched = pinched_nodes(&boundary);
        pinched.first().map(|&(node, _)| node)
    });
    node.map(|node| mesh.positions[node as usize])
}

#[cfg(test)]
mod tests;
