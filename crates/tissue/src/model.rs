//! The constant part of a body: nodes, masses, clamps, sets of elements.

mod error;
mod parallel;
mod relocate;
mod row_sums;

pub use error::ModelError;
pub(crate) use parallel::Part;
pub(crate) use row_sums::RowSums;

use crate::element_index::IndexCell;
use crate::elements::Elements;
use crate::material;
use microsim_contact_solver::Components;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;
use parallel::{PARALLEL_ELEMENTS, follow, parts};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Everything about a body that does not evolve.
#[derive(Clone, Debug)]
pub struct TissueModel {
    pub(crate) rest_positions: Vec<Vector3<f64>>,
    pub(crate) masses: Vec<f64>,
    pub(crate) added_inertia: Vec<f64>,
    pub(crate) inverse_masses: Vec<f64>,
    pub(crate) clamped: Vec<u32>,
    pub(crate) tets: Vec<[u32; 4]>,
    pub(crate) rest_volumes: Vec<f64>,
    pub(crate) sets: Vec<Arc<dyn Elements>>,
    /// What makes the first sets; the others are made of no material.
    pub(crate) made_of: Vec<material::Part>,
    pub(crate) internal: Vec<Range<usize>>,
    /// Drag per mass \[1/s\] of runs of nodes, in order.
    pub(crate) drags: Vec<(Range<usize>, f64)>,
    pub(crate) mean_edge_length: f64,
    pub(crate) parts: Vec<Part>,
    /// What edits look up; made at the first one.
    pub(crate) index: IndexCell,
    pub(crate) rate_bound: OnceLock<f64>,
    pub(crate) components: OnceLock<Arc<Components>>,
    /// S_i of stiffness \[N/m\] and damping \[N·s/m\] at rest (NUMERICS 3.2); edits keep them up to date.
    pub(crate) row_sums: OnceLock<Vec<RowSums>>,
}

impl TissueModel {
    /// The model of `mesh` held together by `sets`. `densities` \[kg/m³\] are those of the elements, `clamped[i]` fixes node `i`
    /// in space, `drag` \[1/s\] is the drag per mass.
    pub fn new(
        mesh: &TetMesh,
        densities: &[f64],
        clamped: &[bool],
        sets: Vec<Arc<dyn Elements>>,
        drag: f64,
    ) -> Result<Self, ModelError> {
        if mesh.tets.is_empty() || mesh.positions.is_empty() {
            return Err(ModelError::Empty);
        }
        if !drag.is_finite() || drag < 0.0 {
            return Err(ModelError::Drag { drag });
        }
        if clamped.len() != mesh.positions.len() {
            return Err(ModelError::ClampCount {
                flags: clamped.len(),
                nodes: mesh.positions.len(),
            });
        }
        if densities.len() != mesh.tets.len() {
            return Err(ModelError::DensityCount {
                densities: densities.len(),
                elements: mesh.tets.len(),
            });
        }
        for (element, volume) in mesh.volumes().into_iter().enumerate() {
            if volume.is_nan() || volume <= 0.0 {
                return Err(ModelError::Volume { element, volume });
            }
        }
        let masses = mesh.node_masses(densities);
        if let Some(node) = masses.iter().position(|&m| m == 0.0) {
            return Err(ModelError::LooseNode { node });
        }
        Ok(Self::assemble(
            mesh.positions.clone(),
            masses,
            clamped,
            mesh.tets.clone(),
            mesh.mean_edge_length(),
            sets,
            drag,
        ))
    }

    /// The model made of these parts.
    pub(crate) fn assemble(
        rest_positions: Vec<Vector3<f64>>,
        masses: Vec<f64>,
        clamped: &[bool],
        tets: Vec<[u32; 4]>,
        mean_edge_length: f64,
        sets: Vec<Arc<dyn Elements>>,
        drag: f64,
    ) -> Self {
        let inverse_masses = masses
            .iter()
            .zip(clamped)
            .map(|(m, &fixed)| if fixed { 0.0 } else { 1.0 / m })
            .collect();
        let rest_volumes = tets
            .iter()
            .map(|tet| {
                let [a, b, c, d] = tet.map(|node| &rest_positions[node as usize]);
                microsim_mesh::signed_volume(a, b, c, d)
            })
            .collect();
        let mut internal = Vec::with_capacity(sets.len());
        let mut start = 0;
        for set in &sets {
            let end = start + set.initial_internal().len();
            internal.push(start..end);
            start = end;
        }
        let parts = parts(tets.len(), rest_positions.len(), &sets);
        Self {
            clamped: (0..rest_positions.len() as u32)
                .filter(|&node| clamped[node as usize])
                .collect(),
            drags: vec![(0..rest_positions.len(), drag)],
            added_inertia: vec![0.0; rest_positions.len()],
            rest_positions,
            masses,
            inverse_masses,
            tets,
            rest_volumes,
            sets,
            made_of: Vec::new(),
            internal,
            mean_edge_length,
            parts,
            index: IndexCell::default(),
            rate_bound: OnceLock::new(),
            components: OnceLock::new(),
            row_sums: OnceLock::new(),
        }
    }

    /// One model of several bodies that no element couples: their nodes, tetrahedra, sets and internal variables one body after
    /// another. Each body keeps its drag. The characteristic length is that of the finest body. Forces on a body are those that
    /// it has alone: to the bit where it has as many parts as alone, that is always but for small bodies next to a large one.
    pub fn union(bodies: &[&TissueModel]) -> Self {
        let mut union = Self {
            rest_positions: Vec::new(),
            masses: Vec::new(),
            added_inertia: Vec::new(),
            inverse_masses: Vec::new(),
            clamped: Vec::new(),
            tets: Vec::new(),
            rest_volumes: Vec::new(),
            sets: Vec::new(),
            made_of: Vec::new(),
            internal: Vec::new(),
            drags: Vec::new(),
            mean_edge_length: f64::INFINITY,
            parts: Vec::new(),
            index: IndexCell::default(),
            rate_bound: OnceLock::new(),
            components: OnceLock::new(),
            row_sums: OnceLock::new(),
        };
        let sets: usize = bodies.iter().map(|body| body.sets.len()).sum();
        for body in bodies {
            let first = union.node_count();
            let shift = first as u32;
            let first_internal = union.internal.last().map_or(0, |range| range.end);
            let first_set = union.sets.len();
            for part in &body.parts {
                let mut elements = vec![0..0; sets];
                elements[first_set..][..body.sets.len()].clone_from_slice(&part.elements);
                let nodes = part.nodes.start + shift..part.nodes.end + shift;
                union.parts.push(Part { elements, nodes });
            }
            let shifted = body.sets.iter().map(|set| match shift {
                0 => set.clone(),
                _ => set.shifted(shift),
            });
            union.sets.extend(shifted);
            let internal = body.internal.iter();
            union.internal.extend(
                internal.map(|range| range.start + first_internal..range.end + first_internal),
            );
            let drags = body.drags.iter();
            union
                .drags
                .extend(drags.map(|(nodes, drag)| (nodes.start + first..nodes.end + first, *drag)));
            union.rest_positions.extend(&body.rest_positions);
            union.masses.extend(&body.masses);
            union.added_inertia.extend(&body.added_inertia);
            union.inverse_masses.extend(&body.inverse_masses);
            union
                .clamped
                .extend(body.clamped.iter().map(|node| node + shift));
            let tets = body.tets.iter().map(|tet| tet.map(|node| node + shift));
            union.tets.extend(tets);
            union.rest_volumes.extend(&body.rest_volumes);
            union.mean_edge_length = union.mean_edge_length.min(body.mean_edge_length);
        }
        if bodies.iter().all(|body| body.parts.len() == 1) && union.tets.len() < PARALLEL_ELEMENTS {
            union.parts = parts(union.tets.len(), union.node_count(), &union.sets);
        }
        union.components = Arc::new(Components::joined(
            bodies.iter().map(|body| &**body.components()),
        ))
        .into();
        // That of the members where edits may have kept it from before; else the same comes out.
        let bounds = bodies.iter().map(|body| body.rate_bound.get().copied());
        if let Some(bounds) = bounds.collect::<Option<Vec<f64>>>() {
            union.rate_bound = bounds.into_iter().fold(0.0, f64::max).into();
        }
        union
    }

    /// The same body, whose sets are made of these parts of materials, the first ones in order: so it can be [edited](Self::edit).
    pub(crate) fn made_of(mut self, parts: Vec<material::Part>) -> Self {
        self.made_of = parts;
        self
    }

    /// What makes the first sets.
    pub(crate) fn parts_made(&self) -> &[material::Part] {
        &self.made_of
    }

    /// Density of a region \[kg/m³\], if a material fills it.
    pub(crate) fn density(&self, region: u32) -> Option<f64> {
        let part = self.made_of.iter().find(|part| part.region == region);
        part.map(|part| part.material.density)
    }

    /// Makes the parts follow an edit: `placed` are the places of each set where there are other elements now.
    pub(crate) fn follow_parts(&mut self, placed: &[&[u32]]) {
        let (tets, nodes) = (self.tets.len(), self.rest_positions.len());
        follow(&mut self.parts, tets, nodes, &self.sets, placed);
    }

    /// The same body with this inertia at each node \[kg\], ≥ 0, beyond that of its mass: that of
    /// [`stability::mass_floor`](crate::stability::mass_floor). It has no weight.
    pub fn with_added_inertia(mut self, added: Vec<f64>) -> Self {
        self.added_inertia = added;
        self.rate_bound = OnceLock::new();
        for node in 0..self.masses.len() {
            self.update_inverse_mass(node);
        }
        self
    }

    /// Makes the inertia of a node beyond that of its mass this \[kg\].
    pub(crate) fn add_inertia(&mut self, node: usize, added: f64) {
        self.added_inertia[node] = added;
        self.update_inverse_mass(node);
    }

    /// A set to be changed: a copy first, where other models hold it too.
    pub(crate) fn own_set(&mut self, set: usize) -> &mut dyn Elements {
        if Arc::get_mut(&mut self.sets[set]).is_none() {
            self.sets[set] = self.sets[set].shifted(0);
        }
        Arc::get_mut(&mut self.sets[set]).expect("a copy has no other owner")
    }

    /// Makes the inverse mass of a node that of its inertia, unless it is clamped.
    pub(crate) fn update_inverse_mass(&mut self, node: usize) {
        let inertia = self.inertia(node);
        let w = &mut self.inverse_masses[node];
        *w = if *w > 0.0 { 1.0 / inertia } else { 0.0 };
    }

    /// The same body with the energy of each element times its factor, set after set: the factors of
    /// [`stability::stiffness_cap`](crate::stability::stiffness_cap).
    pub fn with_scaled_elements(mut self, factors: &[Vec<f64>]) -> Self {
        let sets = self.sets.iter().zip(factors);
        self.sets = sets.map(|(set, factors)| set.scaled(factors)).collect();
        self.rate_bound = OnceLock::new();
        self.row_sums = OnceLock::new();
        self
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.rest_positions.len()
    }

    /// Rest positions \[m\].
    pub fn rest_positions(&self) -> &[Vector3<f64>] {
        &self.rest_positions
    }

    /// Node masses \[kg\], those of clamped nodes included.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Inertia that a node has beyond that of its mass \[kg\]: without weight, and no part of [`masses`](Self::masses).
    pub fn added_inertia(&self) -> &[f64] {
        &self.added_inertia
    }

    /// What resists acceleration at a node \[kg\]: its mass, and what was added.
    #[inline]
    pub fn inertia(&self, node: usize) -> f64 {
        self.masses[node] + self.added_inertia[node]
    }

    /// Inverse inertias as the solver sees them \[1/kg\]; 0 for a clamped node.
    pub fn inverse_masses(&self) -> &[f64] {
        &self.inverse_masses
    }

    /// Whether a node is fixed in space.
    pub fn is_clamped(&self, node: usize) -> bool {
        self.inverse_masses[node] == 0.0
    }

    /// The clamped nodes, ascending.
    pub fn clamped(&self) -> &[u32] {
        &self.clamped
    }

    /// The tetrahedra, as node indices.
    pub fn tets(&self) -> &[[u32; 4]] {
        &self.tets
    }

    /// Volume of each tetrahedron at rest \[m³\].
    pub fn rest_volumes(&self) -> &[f64] {
        &self.rest_volumes
    }

    /// The sets of elements that hold the body together.
    pub fn sets(&self) -> &[Arc<dyn Elements>] {
        &self.sets
    }

    /// Where the internal variables of a set stand among those of a state.
    pub fn internal_range(&self, set: usize) -> Range<usize> {
        self.internal[set].clone()
    }

    /// Drag per mass \[1/s\]; the largest where bodies differ.
    pub fn drag(&self) -> f64 {
        self.drags
            .iter()
            .fold(0.0, |most, (_, drag)| drag.max(most))
    }

    /// Drag per mass \[1/s\] of runs of nodes, which are all nodes in order: one run per body.
    pub fn drags(&self) -> &[(Range<usize>, f64)] {
        &self.drags
    }

    /// Mean rest length of the edges \[m\]: the characteristic length of the body. Edits leave it what it was at the start.
    pub fn mean_edge_length(&self) -> f64 {
        self.mean_edge_length
    }

    /// The parts in which forces are computed; one for a small body.
    pub(crate) fn parts(&self) -> &[Part] {
        &self.parts
    }
}

#[cfg(test)]
mod tests;
