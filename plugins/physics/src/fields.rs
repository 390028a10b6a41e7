//! What pictures of the computation show of bodies, for whoever asks for it: nothing of it is published, saved or hashed.

use microsim_scene::{Diverged, Material, Scene, SceneSpec, TickReport};
use microsim_sdk::BlockBuilder;
use microsim_sdk::message::TISSUE_FIELDS;
use microsim_settings::Remedy;
use std::collections::BTreeMap;

/// What they need beside the scene.
#[derive(Debug, Default)]
pub struct Shown {
    /// Of each body by the regions of its mesh.
    materials: Vec<Vec<(u32, Material)>>,
    /// What had to be done in the last tick, by bodies: to all of one, and to nodes by their ids.
    of_bodies: BTreeMap<usize, u32>,
    of_nodes: BTreeMap<(usize, u32), u32>,
}

impl Shown {
    /// Of a scene, before its first tick.
    pub fn new(spec: &SceneSpec) -> Self {
        let materials = spec.bodies.iter().map(|body| body.materials.clone());
        Self {
            materials: materials.collect(),
            ..Self::default()
        }
    }

    /// Goes on from a state whose last tick is not known.
    pub fn forget(&mut self) {
        self.of_bodies.clear();
        self.of_nodes.clear();
    }

    /// Takes over what had to be done in a tick.
    pub fn take(&mut self, report: &Result<TickReport, Diverged>) {
        self.forget();
        match report {
            Ok(report) => {
                for recovery in &report.recoveries {
                    *self.of_bodies.entry(recovery.body).or_default() |= Remedy::Repeated.bit();
                }
                for (body, ids) in &report.overlaps_undone {
                    let nodes = ids.iter().map(|id| ((*body, *id), Remedy::Overlap.bit()));
                    self.of_nodes.extend(nodes);
                }
            }
            Err(diverged) => {
                self.of_bodies.insert(diverged.body, Remedy::Held.bit());
            }
        }
    }

    /// A block for each body.
    pub fn blocks(&self, scene: &Scene) -> Vec<Vec<u64>> {
        let time = (1e9 * scene.time()).round() as u64;
        let blocks = scene
            .bodies()
            .zip(&self.materials)
            .map(|(body, materials)| {
                let fields = body.node_fields(materials);
                let of_body = self.of_bodies.get(&body.index()).copied();
                let ids = body.node_ids().iter();
                let remedies = fields.remedies.iter().zip(ids).map(|(bits, id)| {
                    let of_node = self.of_nodes.get(&(body.index(), *id)).copied();
                    bits | of_body.unwrap_or_default() | of_node.unwrap_or_default()
                });
                let block = BlockBuilder::new(TISSUE_FIELDS, body.name(), body.generation(), time)
                    .f64s("quality", fields.quality.iter().copied())
                    .u32s("remedy", remedies);
                match fields.von_mises {
                    Some(stresses) => block.f64s("von_mises", stresses),
                    None => block,
                }
                .finish()
            });
        blocks.collect()
    }
}
