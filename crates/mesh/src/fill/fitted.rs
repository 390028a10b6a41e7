//! A background lattice fitted to a closed surface by moving its nodes (Müller & Teschner 2003; dissertation 3.3).
//!
//! Cubes of five tetrahedra, every second one mirrored, over the surface; those whose centroid is outside are left away; then
//! the nodes of the boundary are drawn onto the surface, step by step, while all nodes hold the lengths of their edges. No
//! step may make a height of an element smaller than [`LEAST_HEIGHT`] cells: that keeps every element positive, and it keeps
//! nodes off the surface where there is no room (sharp edges, parts thinner than two cells). Elements at the boundary that are
//! as flat as that, all nodes on the boundary, are removed, where that leaves the shape of the boundary alone, and the rest is
//! fitted on.
//!
//! Beside [`fill`](super::fill) it takes five elements for a cube of the lattice instead of about twelve and leaves the inner
//! ones as they are; but where the boundary lies is not bounded beforehand, only reported. Where elements that are left would
//! touch in a node or an edge alone, those around it come back, until none do.

use super::{FillError, lattice_around, outward, torn};
use crate::box_grid::BoxGrid;
use crate::cell_split::cell_tets;
use crate::fill::lattice::Lattice;
use crate::fill::winding;
use crate::tet_mesh::EDGES;
use crate::topology::{edge_uses, pinched_nodes};
use crate::{TetMesh, TriangleSurface};
use microsim_geometry::{Aabb, closest_on_triangle, signed_volume};
use microsim_vocabulary::CellSplit;
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// No height of an element of a fitted lattice is smaller, in cells. Those of the lattice itself are 0.577 at least.
pub const LEAST_HEIGHT: f64 = 0.2;

/// No node of the boundary of a fitted lattice is farther off the surface, in cells.
const FARTHEST: f64 = 0.5;

/// No fitted lattice has a volume that differs from that of its surface by more than this fraction.
const LARGEST_CHANGE: f64 = 0.5;

/// Largest number of passes over all nodes in a round.
const PASSES: usize = 60;

/// Largest number of rounds, after each of which flat elements are removed.
const ROUNDS: usize = 8;

/// A round ends when no node moves farther in a pass, in cells.
const AT_REST: f64 = 2e-3;

/// An element is flat with a height of less, in cells.
const FLAT: f64 = 1.1 * LEAST_HEIGHT;

/// How far a node follows its edges in a pass: half, as its neighbours do the other half.
const FOLLOW: f64 = 0.5;

/// How much of its distance from the surface a node goes in a pass: little, so that elements on its other sides make room before its
/// own are flat.
const APPROACH: f64 = 0.3;

/// Parts of a motion that are tried until the heights allow it.
const PARTS: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];

/// A lattice that was fitted to a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// The mesh, all in region 0.
    pub mesh: TetMesh,
    /// Largest distance of a node of the boundary from the surface \[m\].
    pub farthest: f64,
}

/// Fits cubes of `cell_size` \[m\], of five tetrahedra each, to the closed `surface`. A surface that faces inward as a whole is
/// taken as turned.
///
/// # Errors
///
/// As those of [`fill`](super::fill); too coarse is also what leaves a node of the boundary farther than half a cell off, or changes
/// the volume by more than half.
pub fn fit_lattice(surface: &TriangleSurface, cell_size: f64) -> Result<Fitted, FillError> {
    let surface = outward(surface)?;
    let cubes = lattice_around(&surface, cell_size)?;
    let (lattice, tets) = inner_elements(&surface, &cubes)?;
    let mut fit = Fit::new(&surface, cell_size, lattice, tets);
    for _ in 0..ROUNDS {
        fit.run();
        if !fit.remove_flat() {
            break;
        }
    }
    let coarse = |point: Vector3<f64>| FillError::Coarse {
        cell_size,
        point: point.into(),
    };
    let (farthest, point) = fit.farthest();
    let regions = vec![0; fit.tets.len()];
    let mesh = TetMesh::new(fit.positions, fit.tets, regions);
    let volume: f64 = mesh.volumes().iter().sum();
    let another_body = (volume / surface.volume() - 1.0).abs() > LARGEST_CHANGE;
    match torn(&mesh, &surface) {
        Some(point) => Err(coarse(point)),
        None if another_body || farthest > FARTHEST * cell_size => Err(coarse(point)),
        None => Ok(Fitted { mesh, farthest }),
    }
}

/// Positions of nodes \[m\], and the elements between them.
type Elements = (Vec<Vector3<f64>>, Vec<[u32; 4]>);

/// The elements of the cubes whose centroid is inside, and what it takes for them to join in faces.
fn inner_elements(surface: &TriangleSurface, cubes: &Lattice) -> Result<Elements, FillError> {
    // Centroids of the five are points of a body-centred lattice with half the cell: its doubled coordinates are the sums of
    // the corners' own.
    let centroids = Lattice {
        origin: cubes.origin,
        cell: cubes.cell / 2.0,
        cells: cubes.cells.map(|n| 2 * n),
    };
    let inside = winding::inside(surface, &centroids)?;
    let corner = |p: [usize; 3]| {
        let at = p.map(|i| 2 * i as i64);
        // The corners of a cell are always there.
        cubes.index(at).unwrap_or(0)
    };
    let (mut tets, mut used) = (Vec::new(), Vec::new());
    for k in 0..cubes.cells[2] {
        for j in 0..cubes.cells[1] {
            for i in 0..cubes.cells[0] {
                for tet in cell_tets(CellSplit::Five, [i, j, k]) {
                    let sum = [0, 1, 2].map(|axis| tet.iter().map(|p| p[axis] as i64).sum());
                    let at = centroids.index(sum);
                    tets.push(tet.map(corner));
                    used.push(at.is_some_and(|at| inside[at as usize]));
                }
            }
        }
    }
    join_in_faces(cubes.len(), &tets, &mut used);

    let mut number = vec![u32::MAX; cubes.len()];
    let kept: Vec<[u32; 4]> = std::iter::zip(tets, used)
        .filter_map(|(tet, used)| used.then_some(tet))
        .collect();
    kept.iter()
        .flatten()
        .for_each(|&node| number[node as usize] = 0);
    let mut positions = Vec::new();
    for (point, number) in number.iter_mut().enumerate() {
        if *number == 0 {
            *number = positions.len() as u32;
            positions.push(cubes.position(point as u32));
        }
    }
    let kept = kept
        .into_iter()
        .map(|tet| tet.map(|node| number[node as usize]));
    Ok((positions, kept.collect()))
}

/// Uses the elements around nodes and edges at which those used so far touch without a common face, until there are none.
fn join_in_faces(points: usize, tets: &[[u32; 4]], used: &mut [bool]) {
    loop {
        let kept = std::iter::zip(tets, &*used).filter_map(|(tet, used)| used.then_some(*tet));
        let kept: Vec<[u32; 4]> = kept.collect();
        let boundary = boundary(points, &kept);
        let edges = edge_uses(&boundary)
            .into_iter()
            .filter(|shared| shared.triangles.len() > 2)
            .map(|shared| shared.edge);
        let edges: BTreeSet<[u32; 2]> = edges.collect();
        let nodes = pinched_nodes(&boundary).into_iter().map(|(node, _)| node);
        let nodes: BTreeSet<u32> = nodes.collect();
        if edges.is_empty() && nodes.is_empty() {
            return;
        }
        for (tet, used) in std::iter::zip(tets, &mut *used) {
            let touches = tet.iter().any(|node| nodes.contains(node));
            *used |= touches
                || EDGES
                    .iter()
                    .any(|&[i, j]| edges.contains(&ordered(tet[i], tet[j])));
        }
    }
}

fn ordered(i: u32, j: u32) -> [u32; 2] {
    [i.min(j), i.max(j)]
}

/// The motion of the nodes of a mesh towards a surface.
struct Fit<'a> {
    surface: &'a TriangleSurface,
    grid: BoxGrid,
    cell: f64,
    /// Where nodes were in the lattice \[m\].
    lattice: Vec<Vector3<f64>>,
    positions: Vec<Vector3<f64>>,
    tets: Vec<[u32; 4]>,
    /// Elements at each node.
    around: Vec<Vec<u32>>,
    /// Neighbours of each node, with the length of the edge to them in the lattice \[m\].
    edges: Vec<Vec<(u32, f64)>>,
    on_boundary: Vec<bool>,
}

impl<'a> Fit<'a> {
    fn new(
        surface: &'a TriangleSurface,
        cell: f64,
        lattice: Vec<Vector3<f64>>,
        tets: Vec<[u32; 4]>,
    ) -> Self {
        let boxes = (0..surface.triangles.len()).map(|t| Aabb::of(&surface.corners(t)));
        let mut fit = Self {
            surface,
            grid: BoxGrid::new(&boxes.collect::<Vec<_>>()),
            cell,
            positions: lattice.clone(),
            lattice,
            tets,
            around: Vec::new(),
            edges: Vec::new(),
            on_boundary: Vec::new(),
        };
        fit.connect();
        fit
    }

    /// Brings connectivity up to date with the elements.
    fn connect(&mut self) {
        let nodes = self.positions.len();
        self.around = vec![Vec::new(); nodes];
        self.edges = vec![Vec::new(); nodes];
        for (element, tet) in self.tets.iter().enumerate() {
            for node in tet {
                self.around[*node as usize].push(element as u32);
            }
            for [i, j] in EDGES {
                let [i, j] = [tet[i], tet[j]];
                let length = (self.lattice[j as usize] - self.lattice[i as usize]).norm();
                self.edges[i as usize].push((j, length));
                self.edges[j as usize].push((i, length));
            }
        }
        for neighbours in &mut self.edges {
            neighbours.sort_by_key(|(node, _)| *node);
            neighbours.dedup_by_key(|(node, _)| *node);
        }
        self.on_boundary = vec![false; nodes];
        for node in boundary(nodes, &self.tets).into_iter().flatten() {
            self.on_boundary[node as usize] = true;
        }
    }

    /// Moves the nodes until they rest.
    fn run(&mut self) {
        for _ in 0..PASSES {
            let mut farthest = 0.0f64;
            for node in 0..self.positions.len() {
                let motion = self.motion(node);
                farthest = farthest.max(self.advance(node, &motion));
            }
            if farthest < AT_REST * self.cell {
                return;
            }
        }
    }

    /// The largest distance \[m\] of a node of the boundary from the surface, and where.
    fn farthest(&self) -> (f64, Vector3<f64>) {
        let mut farthest = (0.0, Vector3::zeros());
        let nodes = (0..self.positions.len()).filter(|node| self.on_boundary[*node]);
        for at in nodes.map(|node| self.positions[node]) {
            let distance = (self.closest(&at).0 - at).norm();
            if distance > farthest.0 {
                farthest = (distance, at);
            }
        }
        farthest
    }

    /// Removes flat elements with two faces on the boundary, whose other two take their place there if the edge between these
    /// is inside, or with three; whether there were any.
    fn remove_flat(&mut self) -> bool {
        let triangles = boundary(self.positions.len(), &self.tets);
        let edges: BTreeSet<[u32; 2]> = edge_uses(&triangles)
            .iter()
            .map(|shared| shared.edge)
            .collect();
        let faces: BTreeSet<[u32; 3]> = triangles.into_iter().map(sorted).collect();
        // Neighbours wait for the next round, as what is said of them here no longer holds.
        let mut touched = vec![false; self.positions.len()];
        let mut removed = vec![false; self.tets.len()];
        for (tet, removed) in std::iter::zip(&self.tets, &mut removed) {
            let corners = tet.map(|node| self.positions[node as usize]);
            if least_height(&corners) > FLAT * self.cell
                || tet.iter().any(|node| touched[*node as usize])
            {
                continue;
            }
            // Corners opposite to the faces of the boundary: of two, the ends of the edge that would come to lie there.
            let outer: Vec<usize> = (0..4).filter(|k| faces.contains(&face(tet, *k))).collect();
            *removed = match outer[..] {
                [k, l] => !edges.contains(&ordered(tet[k], tet[l])),
                [_, _, _] => true,
                _ => false,
            };
            if *removed {
                tet.iter().for_each(|node| touched[*node as usize] = true);
            }
        }
        if removed.iter().all(|removed| !removed) {
            return false;
        }
        let mut removed = removed.into_iter();
        self.tets.retain(|_| !removed.next().unwrap_or(false));
        let mut number = vec![u32::MAX; self.positions.len()];
        self.tets
            .iter()
            .flatten()
            .for_each(|node| number[*node as usize] = 0);
        let used: Vec<usize> = (0..number.len())
            .filter(|node| number[*node] == 0)
            .collect();
        for (new, old) in used.iter().enumerate() {
            number[*old] = new as u32;
        }
        self.tets
            .iter_mut()
            .flatten()
            .for_each(|node| *node = number[*node as usize]);
        self.positions = used.iter().map(|old| self.positions[*old]).collect();
        self.lattice = used.iter().map(|old| self.lattice[*old]).collect();
        self.connect();
        true
    }

    /// Where a node is drawn: along its edges to their lengths; one of the boundary onto the surface, and along it alone.
    fn motion(&self, node: usize) -> Vector3<f64> {
        let at = self.positions[node];
        let edges = &self.edges[node];
        let along = edges.iter().fold(Vector3::zeros(), |sum, (other, length)| {
            let edge = self.positions[*other as usize] - at;
            sum + edge * (1.0 - length / edge.norm())
        });
        let along = along * (FOLLOW / edges.len() as f64);
        if !self.on_boundary[node] {
            return along;
        }
        let (closest, normal) = self.closest(&at);
        (closest - at) * APPROACH + along - normal * along.dot(&normal)
    }

    /// The point of the surface closest to `point`, and the unit normal of a triangle there.
    fn closest(&self, point: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let mut best = (f64::INFINITY, *point, 0);
        self.grid.search_nearest(point, |triangle| {
            let corners = self.surface.corners(triangle as usize);
            let closest = closest_on_triangle(point, &corners).point;
            let distance = (closest - point).norm();
            if distance < best.0 {
                best = (distance, closest, triangle);
            }
            distance
        });
        let [a, b, c] = self.surface.corners(best.2 as usize);
        let normal = (b - a).cross(&(c - a));
        (best.1, normal / normal.norm())
    }

    /// Moves a node as far along `motion` as the heights of its elements allow; how far \[m\].
    fn advance(&mut self, node: usize, motion: &Vector3<f64>) -> f64 {
        let from = self.positions[node];
        // An element may be as low as it is, or as the floor.
        let floor = self.least_height(node).min(LEAST_HEIGHT * self.cell);
        for part in PARTS {
            self.positions[node] = from + motion * part;
            if self.least_height(node) >= floor {
                return motion.norm() * part;
            }
        }
        self.positions[node] = from;
        0.0
    }

    /// The smallest height \[m\] of the elements at a node.
    fn least_height(&self, node: usize) -> f64 {
        let heights = self.around[node].iter().map(|element| {
            let corners = self.tets[*element as usize].map(|n| self.positions[n as usize]);
            least_height(&corners)
        });
        heights.fold(f64::INFINITY, f64::min)
    }
}

/// The triangles of the boundary of elements between `nodes` nodes.
fn boundary(nodes: usize, tets: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let positions = vec![Vector3::zeros(); nodes];
    let mesh = TetMesh::new(positions, tets.to_vec(), vec![0; tets.len()]);
    mesh.surface().triangles
}

/// The face of an element opposite to its corner `k`, sorted.
fn face(tet: &[u32; 4], k: usize) -> [u32; 3] {
    sorted([tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]])
}

fn sorted(mut triangle: [u32; 3]) -> [u32; 3] {
    triangle.sort_unstable();
    triangle
}

/// The smallest height \[m\] of a tetrahedron; negative when it is inverted.
fn least_height(corners: &[Vector3<f64>; 4]) -> f64 {
    let [a, b, c, d] = corners;
    let face =
        |p: &Vector3<f64>, q: &Vector3<f64>, r: &Vector3<f64>| (q - p).cross(&(r - p)).norm() / 2.0;
    let largest = face(a, b, c)
        .max(face(a, b, d))
        .max(face(a, c, d))
        .max(face(b, c, d));
    3.0 * signed_volume(a, b, c, d) / largest
}

#[cfg(test)]
mod tests;
