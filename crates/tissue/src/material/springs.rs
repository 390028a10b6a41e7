//! Springs and volumes: constants of a material in, stiffness of each element out.
//!
//! Springs carry k = Σ_tets c·E·L0 with c = 2√2/25 (Lloyd, Székely, Harders 2007, for near-regular tetrahedra), volumes
//! E_V = ½ κ V0 (V/V0 − 1)², so k = κ/V0 (NUMERICS 1.1). Both scale with the elements, so that static shapes and λ_max·(edge
//! length)² depend on the moduli and not on the mesh.
//!
//! Limitations: the moduli are constants of this discrete material, not Young's modulus and bulk modulus of a continuum;
//! a spring network has a Poisson's ratio of its own near ¼, and strong volume forces lock on linear tetrahedra
//! (NUMERICS 1.6).

use super::{MaterialError, not_negative, positive};
use crate::elements::{Constraint, Elements, Springs, Volumes};
use microsim_mesh::{TetMesh, signed_volume};
use std::sync::Arc;

/// c of k = Σ c·E·L0, 2√2/25.
const SPRING_SHARE: f64 = 0.08 * std::f64::consts::SQRT_2;

/// Constants of springs and volumes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringConstants {
    /// Modulus E of the springs [Pa], > 0.
    pub stretch_modulus: f64,
    /// Modulus κ of the volume forces [Pa], ≥ 0.
    pub volume_modulus: f64,
}

impl SpringConstants {
    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        positive("stretch_modulus", self.stretch_modulus, "> 0 Pa")?;
        not_negative("volume_modulus", self.volume_modulus, ">= 0 Pa")
    }

    /// One spring per edge of these elements, its stiffness the sum over the elements around it in ascending order, and one
    /// volume per element.
    pub(super) fn build(
        &self,
        mesh: &TetMesh,
        elements: &[u32],
        relaxation_time: f64,
    ) -> Vec<Arc<dyn Elements>> {
        let mut edges: Vec<[u32; 2]> = elements
            .iter()
            .flat_map(|&element| mesh.element_edges(element as usize))
            .collect();
        edges.sort_unstable();
        let springs = edges.chunk_by(|a, b| a == b).map(|copies| {
            let nodes = copies[0];
            let [i, j] = nodes.map(|node| mesh.positions[node as usize]);
            let rest = (j - i).norm();
            let stiffness = copies.len() as f64 * (SPRING_SHARE * self.stretch_modulus * rest);
            Constraint {
                nodes,
                rest,
                stiffness,
                damping: relaxation_time * stiffness,
            }
        });
        let springs: Arc<dyn Elements> = Arc::new(Springs::new(springs));
        if self.volume_modulus == 0.0 {
            return vec![springs];
        }
        let volumes = elements.iter().map(|&element| {
            let [a, b, c, d] = mesh.corners(element as usize);
            let rest = signed_volume(&a, &b, &c, &d);
            let stiffness = self.volume_modulus / rest;
            Constraint {
                nodes: mesh.tets[element as usize],
                rest,
                stiffness,
                damping: relaxation_time * stiffness,
            }
        });
        vec![springs, Arc::new(Volumes::new(volumes))]
    }
}
