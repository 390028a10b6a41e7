//! The physics digest: one number for the state of a scene, free of names and encodings.
//!
//! BLAKE3 (256 bit) over raw little-endian values in this order: simulated time f64; per body topology (node ids, element ids,
//! elements, surface triangles, which of these a cut has opened, pieces; each list behind its length u64), positions, velocities,
//! last step, accelerations, internal variables, longest stable step; per group of bodies the contact forces in the order of their keys, each as its
//! key (u32), normal force f64 and friction force 3 × f64.
//!
//! Two builds that compute the same physics give the same digest whatever their types, fields and files are called. It is not a format:
//! nothing can be read back from it (that is [`Scene::save`]).

use crate::scene::Scene;
use microsim_contact::Partner;
use nalgebra::Vector3;

struct Digest(blake3::Hasher);

impl Digest {
    fn count(&mut self, count: usize) {
        self.0.update(&(count as u64).to_le_bytes());
    }

    fn u32s(&mut self, values: impl ExactSizeIterator<Item = u32>) {
        self.count(values.len());
        values.for_each(|value| {
            self.0.update(&value.to_le_bytes());
        });
    }

    fn f64(&mut self, value: f64) {
        self.0.update(&value.to_le_bytes());
    }

    fn f64s(&mut self, values: &[f64]) {
        self.count(values.len());
        values.iter().for_each(|&value| self.f64(value));
    }

    fn vector(&mut self, vector: &Vector3<f64>) {
        vector.iter().for_each(|&value| self.f64(value));
    }

    fn vectors(&mut self, vectors: &[Vector3<f64>]) {
        self.count(vectors.len());
        vectors.iter().for_each(|vector| self.vector(vector));
    }
}

impl Scene {
    /// The physics digest of the state now.
    pub fn digest(&self) -> [u8; 32] {
        let mut digest = Digest(blake3::Hasher::new());
        digest.f64(self.state.time);
        let bodies = self.bodies.iter().zip(&self.state.bodies);
        for ((body, state), stable_step) in bodies.zip(&self.state.stable_steps) {
            digest.u32s(body.mesh.node_ids.iter().copied());
            digest.u32s(body.mesh.element_ids.iter().copied());
            digest.u32s(body.mesh.tets.as_flattened().iter().copied());
            digest.u32s(body.surface.triangles.as_flattened().iter().copied());
            digest.u32s(body.opened.iter().map(|inner| u32::from(*inner)));
            digest.u32s(body.pieces.of_nodes.iter().copied());
            digest.vectors(&state.positions);
            digest.vectors(&state.velocities);
            digest.f64(state.step);
            digest.vectors(&state.accelerations);
            digest.f64s(&state.internal);
            digest.f64(*stable_step);
        }
        for contact in &self.state.contacts {
            digest.count(contact.forces.len());
            for force in &contact.forces {
                let partner = match force.key.partner {
                    Partner::Tool { tool, capsule } => [0, tool, capsule],
                    Partner::Obstacle { part } => [1, part, 0],
                    Partner::Body { body } => [2, body, 0],
                };
                digest.u32s([force.key.body].into_iter());
                digest.u32s(partner.into_iter());
                digest.u32s(force.key.first.into_iter());
                digest.u32s(force.key.second.into_iter());
                digest.f64(force.normal_force);
                digest.vector(&force.friction_force);
            }
        }
        digest.0.finalize().into()
    }
}
