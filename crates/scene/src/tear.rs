//! Tearing: tissue that is stretched too far comes apart.
//!
//! Whole elements come apart at their faces. The stretch across a face is that of the fibre along its rest normal n in the elements on both sides, |F n|: the root of the
//! mean square by volume, as energy grows with the square and is stored in volume, so that a small element does not open the face of a large one. A face fails when this exceeds
//! 1 + the strain that its region bears; between two regions the weaker one counts. Of the faces that do in one tick only those near the worst fail:
//! what is torn takes the load off the others.
//!
//! Shreds, elements far smaller than the others, as cuts leave them, rupture themselves, at their largest principal stretch: what their few fibres store can never pay for a
//! face of a whole element (Griffith 1921), however far they are stretched.

use crate::body::Body;
use crate::scene::Scene;
use microsim_cutting::{Settings, Topology};
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeSet;

/// Faces with at least this fraction of the worst excess fail together.
const TOGETHER: f64 = 0.8;

/// An element with less than this fraction of the mean volume of the whole mesh is a shred.
const SHRED_VOLUME: f64 = 0.2;

/// What came apart in a body, with the numbers of pieces that came off.
type Torn = Option<(microsim_cutting::Cut, Vec<u32>)>;

impl Scene {
    /// Tears what is stretched too far in a body: its shreds, or where none is, faces.
    pub(crate) fn tear(&mut self, body: usize) -> Torn {
        let positions = &self.state.bodies[body].positions;
        let of = &self.bodies[body];
        let shreds = shreds(of, |element| is_overstretched(of, positions, element));
        if !shreds.is_empty() {
            return self.come_apart(body, &[], &shreds);
        }
        let faces = overstretched(of, positions);
        self.come_apart(body, &faces, &BTreeSet::new())
    }

    /// The shreds of each body that are stretched too far or turned inside out, which no tissue can be; of the bodies that have any.
    pub(crate) fn failing_shreds(&self) -> Vec<(usize, BTreeSet<u32>)> {
        let of = |(body, of): (usize, &Body)| {
            let positions = &self.state.bodies[body].positions;
            let fails = |element| {
                is_inverted(of, positions, element) || is_overstretched(of, positions, element)
            };
            (body, shreds(of, fails))
        };
        let bodies = self.bodies.iter().enumerate().map(of);
        bodies.filter(|(_, shreds)| !shreds.is_empty()).collect()
    }

    /// Opens faces of a body and takes away shreds.
    pub(crate) fn come_apart(
        &mut self,
        body: usize,
        faces: &[(u32, u8)],
        shreds: &BTreeSet<u32>,
    ) -> Torn {
        let of = &mut self.bodies[body];
        let current = &self.state.bodies[body].positions;
        let topology = of.topology.as_mut()?;
        let torn = topology.tear(&of.mesh, faces, shreds, current, &Settings::default());
        let torn = torn.expect("inner faces of this mesh")?;
        self.update_strokes(body, None, &torn.edit);
        let pieces = self.apply_cut(body, &torn);
        Some((torn, pieces))
    }
}

/// The strain that an element bears, if it is limited.
fn limit_of(body: &Body, element: u32) -> Option<f64> {
    let region = body.mesh.regions[element as usize];
    let mut strains = body.tear_strains.iter();
    strains
        .find(|(of, _)| *of == region)
        .map(|(_, strain)| *strain)
}

/// The shreds of a body that can tear for which `fails` is true, but those that hang on nothing.
fn shreds(body: &Body, fails: impl Fn(u32) -> bool) -> BTreeSet<u32> {
    let Some(topology) = &body.topology else {
        return BTreeSet::new();
    };
    let fails = |&element: &u32| {
        is_shred(body, topology, element)
            && (0..4).any(|corner| topology.neighbour(element, corner).is_some())
            && limit_of(body, element).is_some()
            && fails(element)
    };
    (0..body.mesh.tets.len() as u32).filter(fails).collect()
}

/// Whether an element is a shred.
fn is_shred(body: &Body, topology: &Topology, element: u32) -> bool {
    rest_volume(body, element) < SHRED_VOLUME * topology.mean_volume()
}

/// Whether the largest principal stretch of an element is more than it bears.
fn is_overstretched(body: &Body, positions: &[Vector3<f64>], element: u32) -> bool {
    limit_of(body, element).is_some_and(|limit| {
        let gradient = deformation_gradient(body, positions, element);
        let squares = gradient.map(|f| (f.transpose() * f).symmetric_eigenvalues());
        squares.is_some_and(|squares| squares.max().sqrt() > 1.0 + limit)
    })
}

/// Whether an element is turned inside out.
fn is_inverted(body: &Body, positions: &[Vector3<f64>], element: u32) -> bool {
    let gradient = deformation_gradient(body, positions, element);
    gradient.is_some_and(|f| f.determinant() <= 0.0)
}

/// Volume of an element at rest \[m³\].
fn rest_volume(body: &Body, element: u32) -> f64 {
    let [a, b, c, d] = body.mesh.corners(element as usize);
    microsim_geometry::signed_volume(&a, &b, &c, &d)
}

/// The inner faces that fail: element and the corner opposite.
fn overstretched(body: &Body, positions: &[Vector3<f64>]) -> Vec<(u32, u8)> {
    let Some(topology) = &body.topology else {
        return Vec::new();
    };
    let mut found: Vec<(f64, u32, u8)> = Vec::new();
    for element in 0..body.mesh.tets.len() as u32 {
        if is_shred(body, topology, element) {
            continue;
        }
        let own = limit_of(body, element);
        for corner in 0..4 {
            let Some(other) = topology.neighbour(element, corner) else {
                continue;
            };
            // What has torn but holds together around it does not tear again.
            if topology.sheet(element, corner) != 0 {
                continue;
            }
            let limit = [own, limit_of(body, other)].into_iter().flatten();
            let first = element < other && !is_shred(body, topology, other);
            let (Some(limit), true) = (limit.reduce(f64::min), first) else {
                continue;
            };
            let normal = normal(topology, &body.mesh.positions, element, corner);
            let sides = [element, other].map(|e| {
                let volume = rest_volume(body, e);
                let stretch = stretch(body, positions, e, &normal);
                (volume, volume * (stretch * stretch))
            });
            let (volume, sum) = (sides[0].0 + sides[1].0, sides[0].1 + sides[1].1);
            let excess = (sum / volume).sqrt() - 1.0 - limit;
            if excess > 0.0 {
                found.push((excess, element, corner as u8));
            }
        }
    }
    let worst = found
        .iter()
        .fold(0.0, |worst, (excess, _, _)| f64::max(worst, *excess));
    let near = found
        .iter()
        .filter(|(excess, _, _)| *excess >= TOGETHER * worst);
    near.map(|(_, element, corner)| (*element, *corner))
        .collect()
}

/// Normal at rest of the face opposite to a corner.
fn normal(topology: &Topology, rest: &[Vector3<f64>], element: u32, corner: usize) -> Vector3<f64> {
    let [a, b, c] = topology
        .face(element, corner)
        .map(|node| rest[node as usize]);
    (b - a).cross(&(c - a)).normalize()
}

/// The stretch of an element's fibre along `normal`, 1 at rest.
fn stretch(body: &Body, positions: &[Vector3<f64>], element: u32, normal: &Vector3<f64>) -> f64 {
    let gradient = deformation_gradient(body, positions, element);
    gradient.map_or(1.0, |gradient| (gradient * normal).norm())
}

/// `None` for an element without volume at rest, which no mesh has.
fn deformation_gradient(
    body: &Body,
    positions: &[Vector3<f64>],
    element: u32,
) -> Option<Matrix3<f64>> {
    let edges = |[a, b, c, d]: [Vector3<f64>; 4]| Matrix3::from_columns(&[b - a, c - a, d - a]);
    let now = edges(body.mesh.tets[element as usize].map(|node| positions[node as usize]));
    let rest = edges(body.mesh.corners(element as usize)).try_inverse()?;
    Some(now * rest)
}
