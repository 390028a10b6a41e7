//! Tearing: inner faces of tissue that is stretched too far across them come apart.
//!
//! The stretch across a face is that of the fibre along its rest normal n in the elements on both sides, |F n|. A face fails when the mean of both sides exceeds 1 + the strain that its
//! region bears; between two regions the weaker one counts. Of the faces that do in one tick only those near the worst fail:
//! what is torn takes the load off the others.

use crate::body::Body;
use crate::scene::Scene;
use microsim_cutting::Topology;
use nalgebra::{Matrix3, Vector3};

/// Faces with at least this fraction of the worst excess fail together.
const TOGETHER: f64 = 0.8;

impl Scene {
    /// Tears what is stretched too far; returns what came apart, with the numbers of pieces that came off.
    pub(crate) fn tear(&mut self, body: usize) -> Option<(microsim_cutting::Cut, Vec<u32>)> {
        let of = &mut self.bodies[body];
        if of.tear_strains.is_empty() {
            return None;
        }
        let faces = overstretched(of, &self.state.bodies[body].positions);
        let current = &self.state.bodies[body].positions;
        let topology = of.topology.as_mut()?;
        let settings = microsim_cutting::Settings::default();
        let torn = topology.tear(&of.mesh, &faces, current, &settings);
        let torn = torn.expect("inner faces of this mesh")?;
        self.update_strokes(body, None, &torn.edit);
        let pieces = self.apply_cut(body, &torn);
        Some((torn, pieces))
    }
}

/// The inner faces that fail: element and the corner opposite.
fn overstretched(body: &Body, positions: &[Vector3<f64>]) -> Vec<(u32, u8)> {
    let Some(topology) = &body.topology else {
        return Vec::new();
    };
    let limit_of = |region: u32| {
        let strains = body.tear_strains.iter();
        strains
            .filter(|(of, _)| *of == region)
            .map(|(_, strain)| *strain)
            .next()
    };
    let mut found: Vec<(f64, u32, u8)> = Vec::new();
    for element in 0..body.mesh.tets.len() as u32 {
        let own = limit_of(body.mesh.regions[element as usize]);
        for corner in 0..4 {
            let Some(other) = topology.neighbour(element, corner) else {
                continue;
            };
            // What has torn but holds together around it does not tear again.
            if topology.sheet(element, corner) != 0 {
                continue;
            }
            let theirs = limit_of(body.mesh.regions[other as usize]);
            let limit = [own, theirs].into_iter().flatten().reduce(f64::min);
            let (Some(limit), true) = (limit, element < other) else {
                continue;
            };
            let normal = normal(topology, &body.mesh.positions, element, corner);
            let stretches = [element, other].map(|e| stretch(body, positions, e, &normal));
            let excess = 0.5 * (stretches[0] + stretches[1]) - 1.0 - limit;
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
    let edges = |[a, b, c, d]: [Vector3<f64>; 4]| Matrix3::from_columns(&[b - a, c - a, d - a]);
    let now = edges(body.mesh.tets[element as usize].map(|node| positions[node as usize]));
    let rest = edges(body.mesh.corners(element as usize)).try_inverse();
    // No mesh has an element without volume at rest.
    rest.map_or(1.0, |rest| (now * (rest * normal)).norm())
}
