//! Probes: numbers taken from a scene.

use crate::edits::{Edit, nodes_after_edit};
use crate::from_settings::selections;
use crate::report::ContactPartner;
use crate::scene::Scene;
use microsim_mesh::signed_volume;
use microsim_settings as settings;
use nalgebra::Vector3;
use settings::Quantity;

/// A probe that is ready to measure.
#[derive(Clone, Debug)]
pub(super) struct Probe {
    pub name: String,
    body: usize,
    nodes: Vec<u32>,
    quantity: Quantity,
    direction: Vector3<f64>,
    /// A point of the axis in the world \[m\], and its direction.
    point: Vector3<f64>,
    axis: Vector3<f64>,
    /// The other body of a gap or of crossings.
    other: usize,
    /// The pair of a contact force, and the sign of the force on the body.
    pair: (usize, f64),
    /// Mean distance of the nodes from the axis at rest \[m\], for a radius; volume of the body at rest \[m³\], for a volume.
    reference: f64,
}

/// Why a probe cannot measure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProbeError {
    /// Index of the probe in the settings.
    pub probe: usize,
    /// Its name.
    pub name: String,
    /// Why.
    pub reason: &'static str,
}

impl std::fmt::Display for ProbeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "probe '{}' {}", self.name, self.reason)
    }
}

impl std::error::Error for ProbeError {}

impl Probe {
    pub fn new(
        index: usize,
        settings: &settings::Probe,
        scene: &Scene,
    ) -> Result<Self, ProbeError> {
        let wrong = |reason| ProbeError {
            probe: index,
            name: settings.name.clone(),
            reason,
        };
        let body = (0..scene.body_count()).find(|&body| scene.body(body).name() == settings.body);
        let body = body.ok_or_else(|| wrong("is for a body that is not there"))?;
        let mut nodes: Vec<u32> = (0..scene.body(body).rest_positions().len() as u32).collect();
        for selection in selections(&settings.nodes) {
            let selected = scene.body(body).select(&selection);
            nodes.retain(|node| selected.binary_search(node).is_ok());
        }
        if nodes.is_empty() {
            return Err(wrong(
                "selects no node of its body (places are in the body's frame, at rest)",
            ));
        }
        let vector = |v: Option<[f64; 3]>| v.map_or_else(Vector3::zeros, Vector3::from);
        let mut probe = Self {
            name: settings.name.clone(),
            body,
            nodes,
            quantity: settings.quantity,
            direction: vector(settings.direction),
            point: scene.body(body).origin() + vector(settings.point),
            axis: vector(settings.axis),
            other: 0,
            pair: (0, 1.0),
            reference: 0.0,
        };
        let with = settings.with.as_deref().unwrap_or_default();
        match settings.quantity {
            Quantity::Gap | Quantity::Crossings => {
                let mut bodies = 0..scene.body_count();
                let other = bodies.find(|&body| scene.body(body).name() == with);
                probe.other =
                    other.ok_or_else(|| wrong("is for another body that is not there"))?;
            }
            Quantity::ContactForce | Quantity::Grip => {
                let found = (0..scene.pair_count()).find_map(|index| {
                    let (of, partner) = scene.pair(index);
                    let own = of == body && scene.partner_name(partner) == with;
                    let turned =
                        partner == ContactPartner::Body(body) && scene.body(of).name() == with;
                    (own || turned).then_some((index, if own { 1.0 } else { -1.0 }))
                });
                probe.pair = found.ok_or_else(|| wrong("is for two that do not touch"))?;
            }
            _ => {}
        }
        probe.reference = match settings.quantity {
            Quantity::Radius => probe.mean_radius(scene.body(body).rest_positions()),
            Quantity::Volume => scene.body(body).model().rest_volumes().iter().sum(),
            _ => 0.0,
        };
        Ok(probe)
    }

    /// The value now, in SI; `forces` are those of the pairs and of the jaws since the last sample \[N\].
    pub fn value(&self, scene: &Scene, forces: &[(Vector3<f64>, f64)]) -> f64 {
        let (now, rest) = (
            scene.body(self.body).positions(),
            scene.body(self.body).rest_positions(),
        );
        let moved = |node: &u32| now[*node as usize] - rest[*node as usize];
        let count = self.nodes.len() as f64;
        match self.quantity {
            Quantity::Displacement => {
                let sum: f64 = self
                    .nodes
                    .iter()
                    .map(|n| moved(n).dot(&self.direction))
                    .sum();
                sum / count
            }
            Quantity::Centre => {
                let masses = scene.body(self.body).masses();
                let (mut sum, mut mass) = (0.0, 0.0);
                for node in &self.nodes {
                    let m = masses[*node as usize];
                    sum += m * moved(node).dot(&self.direction);
                    mass += m;
                }
                sum / mass
            }
            Quantity::Radius => self.mean_radius(now) - self.reference,
            Quantity::Distance => self
                .nodes
                .iter()
                .map(|n| moved(n).norm())
                .fold(0.0, f64::max),
            Quantity::Force => {
                let forces = scene.body(self.body).forces();
                let held = scene.body(self.body).held();
                let nodes = self.nodes.iter().filter(|n| held[**n as usize]);
                -nodes
                    .map(|n| forces[*n as usize].dot(&self.direction))
                    .sum::<f64>()
            }
            Quantity::Torque => {
                let forces = scene.body(self.body).forces();
                let held = scene.body(self.body).held();
                let nodes = self.nodes.iter().filter(|n| held[**n as usize]);
                let torque: Vector3<f64> = nodes
                    .map(|n| (now[*n as usize] - self.point).cross(&forces[*n as usize]))
                    .sum();
                -torque.dot(&self.axis)
            }
            Quantity::ContactForce => {
                let (pair, sign) = self.pair;
                sign * forces[pair].0.dot(&self.direction)
            }
            Quantity::Grip => forces[self.pair.0].1,
            Quantity::Gap => {
                let along = |p: &Vector3<f64>| p.dot(&self.direction);
                let own = self.nodes.iter().map(|n| along(&now[*n as usize]));
                let others = scene.body(self.other).positions().iter().map(along);
                others.fold(f64::INFINITY, f64::min) - own.fold(f64::NEG_INFINITY, f64::max)
            }
            Quantity::Inside => scene.body(self.body).overlap().nodes as f64 / now.len() as f64,
            Quantity::Depth => scene.body(self.body).overlap().depth,
            Quantity::Crossings => scene.crossings(self.body, self.other) as f64,
            Quantity::Pieces => f64::from(scene.body(self.body).piece_count()),
            Quantity::Volume => scene.body(self.body).volume() / self.reference - 1.0,
            Quantity::SmallestVolume => {
                let rest = scene.body(self.body).model().rest_volumes();
                let ratios = scene
                    .body(self.body)
                    .tets()
                    .iter()
                    .zip(rest)
                    .map(|(tet, rest)| {
                        let [a, b, c, d] = tet.map(|node| &now[node as usize]);
                        signed_volume(a, b, c, d) / rest
                    });
                ratios.fold(f64::INFINITY, f64::min)
            }
            Quantity::Energy => {
                let masses = scene.body(self.body).masses();
                let gravity = scene.gravity();
                let fallen: f64 = self
                    .nodes
                    .iter()
                    .map(|n| masses[*n as usize] * gravity.dot(&moved(n)))
                    .sum();
                scene.body(self.body).energies().total() - fallen
            }
        }
    }

    /// Updates the probe after an edit of its body's mesh.
    pub fn update_after_edit(&mut self, edit: &Edit, scene: &Scene) {
        if edit.body != self.body {
            return;
        }
        self.nodes = nodes_after_edit(self.nodes.iter().copied(), &edit.edit, edit.nodes);
        // New nodes have a mean distance from the axis of their own.
        let last = edit.edit.generation + 1 == scene.body(self.body).generation();
        if last && self.quantity == Quantity::Radius {
            self.reference = self.mean_radius(scene.body(self.body).rest_positions());
        }
    }

    fn mean_radius(&self, positions: &[Vector3<f64>]) -> f64 {
        let radius = |node: &u32| {
            let arm = positions[*node as usize] - self.point;
            (arm - self.axis * self.axis.dot(&arm)).norm()
        };
        self.nodes.iter().map(radius).sum::<f64>() / self.nodes.len() as f64
    }
}
