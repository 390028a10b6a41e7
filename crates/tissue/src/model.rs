//! The constant part of a body: nodes, masses, clamps, sets of elements.

use crate::elements::Elements;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;
use std::ops::Range;
use std::sync::Arc;

/// Bodies with at least this many tetrahedra compute forces in parallel parts. Below it, handing work to threads (13–21 µs
/// with rayon, measured) costs more than it saves.
const PARALLEL_ELEMENTS: usize = 4096;

/// Parts of a parallel body. It depends on the model alone, never on the number of threads.
const PARALLEL_PARTS: usize = 8;

/// Everything about a body that does not evolve.
#[derive(Clone, Debug)]
pub struct TissueModel {
    rest_positions: Vec<Vector3<f64>>,
    masses: Vec<f64>,
    inverse_masses: Vec<f64>,
    clamped: Vec<u32>,
    tets: Vec<[u32; 4]>,
    rest_volumes: Vec<f64>,
    sets: Vec<Arc<dyn Elements>>,
    internal: Vec<Range<usize>>,
    /// Drag per mass [1/s] of runs of nodes, in order.
    drags: Vec<(Range<usize>, f64)>,
    mean_edge_length: f64,
    parts: Vec<Part>,
}

/// What one part of a parallel loop over the elements computes.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Elements of each set.
    pub elements: Vec<Range<usize>>,
    /// The run of nodes that they touch.
    pub nodes: Range<u32>,
}

/// Why a model cannot be built from a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModelError {
    /// The mesh has no node or no element.
    Empty,
    /// Drag is not finite or below zero.
    Drag {
        /// The drag [1/s].
        drag: f64,
    },
    /// One clamp flag per node is needed.
    ClampCount {
        /// Number of flags.
        flags: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// One density per element is needed.
    DensityCount {
        /// Number of densities.
        densities: usize,
        /// Number of elements.
        elements: usize,
    },
    /// An element has no positive volume at rest.
    Volume {
        /// Its index.
        element: usize,
        /// Its volume [m³].
        volume: f64,
    },
    /// A node belongs to no element and so has no mass.
    LooseNode {
        /// Its index.
        node: usize,
    },
}

impl std::fmt::Display for ModelError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Empty => f.write_str("the mesh has no element"),
            Self::Drag { drag } => write!(f, "drag is {drag} 1/s; allowed: >= 0 1/s, finite"),
            Self::ClampCount { flags, nodes } => write!(f, "{flags} clamp flags for {nodes} nodes"),
            Self::DensityCount {
                densities,
                elements,
            } => write!(f, "{densities} densities for {elements} elements"),
            Self::Volume { element, volume } => {
                write!(
                    f,
                    "element {element} has the rest volume {volume} m³; it must be positive"
                )
            }
            Self::LooseNode { node } => write!(f, "node {node} belongs to no element"),
        }
    }
}

impl std::error::Error for ModelError {}

impl TissueModel {
    /// The model of `mesh` held together by `sets`. `densities` [kg/m³] are those of the elements, `clamped[i]` fixes node `i`
    /// in space, `drag` [1/s] is the drag per mass.
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
            rest_positions,
            masses,
            inverse_masses,
            tets,
            rest_volumes,
            sets,
            internal,
            mean_edge_length,
            parts,
        }
    }

    /// One model of several bodies that no element couples: their nodes, tetrahedra, sets and internal variables one body after
    /// another. Each body keeps its drag. The characteristic length is that of the finest body. Forces on a body are those that
    /// it has alone: to the bit where it has as many parts as alone, that is always but for small bodies next to a large one.
    pub fn union(bodies: &[&TissueModel]) -> Self {
        let mut union = Self {
            rest_positions: Vec::new(),
            masses: Vec::new(),
            inverse_masses: Vec::new(),
            clamped: Vec::new(),
            tets: Vec::new(),
            rest_volumes: Vec::new(),
            sets: Vec::new(),
            internal: Vec::new(),
            drags: Vec::new(),
            mean_edge_length: f64::INFINITY,
            parts: Vec::new(),
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
        union
    }

    /// The same body with these node masses [kg], > 0: those of [`stability::mass_floor`](crate::stability::mass_floor). Weight is
    /// that of these masses; to add inertia alone, take the weight of the difference off by
    /// [`Control::forces`](crate::Control::forces).
    pub fn with_masses(mut self, masses: Vec<f64>) -> Self {
        for (w, mass) in self.inverse_masses.iter_mut().zip(&masses) {
            *w = if *w > 0.0 { 1.0 / mass } else { 0.0 };
        }
        self.masses = masses;
        self
    }

    /// The same body with the energy of each element times its factor, set after set: the factors of
    /// [`stability::stiffness_cap`](crate::stability::stiffness_cap).
    pub fn with_scaled_elements(mut self, factors: &[Vec<f64>]) -> Self {
        let sets = self.sets.iter().zip(factors);
        self.sets = sets.map(|(set, factors)| set.scaled(factors)).collect();
        self
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.rest_positions.len()
    }

    /// Rest positions [m].
    pub fn rest_positions(&self) -> &[Vector3<f64>] {
        &self.rest_positions
    }

    /// Node masses [kg], those of clamped nodes included.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Inverse node masses as the solver sees them [1/kg]; 0 for a clamped node.
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

    /// Volume of each tetrahedron at rest [m³].
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

    /// Drag per mass [1/s]; the largest where bodies differ.
    pub fn drag(&self) -> f64 {
        self.drags
            .iter()
            .fold(0.0, |most, (_, drag)| drag.max(most))
    }

    /// Drag per mass [1/s] of runs of nodes, which are all nodes in order: one run per body.
    pub fn drags(&self) -> &[(Range<usize>, f64)] {
        &self.drags
    }

    /// Mean rest length of the edges [m]: the characteristic length of the body.
    pub fn mean_edge_length(&self) -> f64 {
        self.mean_edge_length
    }

    /// The parts in which forces are computed; one for a small body.
    pub(crate) fn parts(&self) -> &[Part] {
        &self.parts
    }
}

/// Cuts every set in runs of equal size.
fn parts(tets: usize, nodes: usize, sets: &[Arc<dyn Elements>]) -> Vec<Part> {
    if tets < PARALLEL_ELEMENTS {
        let elements = sets.iter().map(|set| 0..set.count()).collect();
        return vec![Part {
            elements,
            nodes: 0..nodes as u32,
        }];
    }
    let part = |index: usize| {
        let elements: Vec<Range<usize>> = sets
            .iter()
            .map(|set| {
                let bound = |index: usize| set.count() * index / PARALLEL_PARTS;
                bound(index)..bound(index + 1)
            })
            .collect();
        let touched = || {
            let runs = sets.iter().zip(&elements);
            runs.flat_map(|(set, run)| run.clone().flat_map(|e| set.nodes(e).iter().copied()))
        };
        let nodes = touched().min().unwrap_or(0)..touched().max().map_or(0, |node| node + 1);
        Part { elements, nodes }
    };
    (0..PARALLEL_PARTS).map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::executor::Serial;
    use crate::forces::Forces;
    use crate::method::Method;
    use crate::state::{Contacts, Control, State};
    use crate::testing::{beam, build, numbers, soft_block};

    #[test]
    fn what_is_no_body_is_refused() {
        let mesh = soft_block([1; 3]);
        let nothing = TetMesh::new(Vec::new(), Vec::new(), Vec::new());
        let nodes_alone = TetMesh::new(mesh.positions.clone(), Vec::new(), Vec::new());
        let build = |mesh: &TetMesh, drag| {
            let densities = vec![1000.0; mesh.tets.len()];
            let clamped = vec![false; mesh.positions.len()];
            TissueModel::new(mesh, &densities, &clamped, Vec::new(), drag).map(|_| ())
        };
        assert_eq!(build(&nothing, 0.0), Err(ModelError::Empty));
        assert_eq!(build(&nodes_alone, 0.0), Err(ModelError::Empty));
        assert_eq!(build(&mesh, 0.0), Ok(()));
        for drag in [-1.0, f64::INFINITY] {
            assert_eq!(build(&mesh, drag), Err(ModelError::Drag { drag }));
        }
        let refused = build(&mesh, f64::NAN);
        assert!(matches!(refused, Err(ModelError::Drag { .. })));
    }

    /// Two bodies of different elements, clamps and drag, one of them twice: in the union each has the forces, the energies and
    /// the steps that it has alone, to the bit.
    #[test]
    fn bodies_of_a_union_do_not_know_of_one_another() {
        let soft = build(&soft_block([2, 2, 1]), |p| p.x < -0.9e-3);
        let stiff = beam(0.4);
        let mut dragged = soft.clone();
        dragged.drags[0].1 = 30.0;
        let bodies = [&soft, &stiff, &dragged];
        let union = TissueModel::union(&bodies);
        assert_eq!(
            union.node_count(),
            bodies.iter().map(|b| b.node_count()).sum()
        );
        assert_eq!(union.drag(), 30.0);
        assert_eq!(union.mean_edge_length(), soft.mean_edge_length());
        let control = Control {
            gravity: Vector3::new(0.0, 0.3, -9.81),
            ..Control::default()
        };
        let mut next = numbers();
        let mut alone: Vec<State> = bodies.iter().map(|b| State::at_rest(b)).collect();
        let mut joint = State::at_rest(&union);
        joint.positions.clear();
        for (state, body) in alone.iter_mut().zip(&bodies) {
            for p in &mut state.positions {
                *p += Vector3::new(next(), next(), next()) * (0.05 * body.mean_edge_length());
            }
            joint.positions.extend(&state.positions);
        }
        let contacts = Contacts::default();
        let parts = |all: &[Vector3<f64>]| {
            let mut first = 0;
            bodies.map(|body| {
                first += body.node_count();
                all[first - body.node_count()..first].to_vec()
            })
        };
        for step in 0..3 {
            let forces = parts(Forces::new(&union).compute(&union, &joint, &control, &Serial));
            for ((state, body), forces) in alone.iter_mut().zip(&bodies).zip(forces) {
                assert_eq!(
                    Forces::new(body).compute(body, state, &control, &Serial),
                    forces,
                    "step {step}"
                );
            }
            for (model, state) in bodies
                .into_iter()
                .zip(&mut alone)
                .chain([(&union, &mut joint)])
            {
                let mut solver = Method::StoermerVerlet.solver(model).unwrap();
                solver
                    .step(model, state, &control, &contacts, 1e-5, &Serial)
                    .unwrap();
            }
            let positions = parts(&joint.positions);
            assert!(alone.iter().zip(positions).all(|(a, b)| a.positions == b));
        }
    }

    /// Large bodies keep their parts, small ones next to them are one part each: the same up to the order of one sum.
    #[test]
    fn a_union_of_a_large_body_is_parallel() {
        let large = build(&soft_block([10, 10, 8]), |_| false);
        let small = build(&soft_block([2, 2, 1]), |_| false);
        let union = TissueModel::union(&[&small, &large]);
        assert_eq!(union.parts().len(), 1 + large.parts().len());
        let mut state = State::at_rest(&union);
        let mut next = numbers();
        for p in &mut state.positions {
            *p += Vector3::new(next(), next(), next()) * (0.05 * union.mean_edge_length());
        }
        let mut part = State::at_rest(&large);
        part.positions
            .copy_from_slice(&state.positions[small.node_count()..]);
        let control = Control::default();
        let mut all = Forces::new(&union);
        let all = &all.compute(&union, &state, &control, &Serial)[small.node_count()..];
        assert_eq!(
            all,
            Forces::new(&large).compute(&large, &part, &control, &Serial)
        );
    }
}
