//! A body of a scene: its constant parts and working memory, built from its description.

mod edit;
mod region;
mod surface;

use crate::check;
use crate::drive::Drive;
use crate::error::SceneError;
use crate::initial_equilibrium::{self, InitialEquilibrium};
use crate::lumen::Lumen;
use crate::pieces::Pieces;
use crate::select;
use crate::spec::{BodySpec, CouplingKind, Selection};
use crate::surface_edits::{SurfaceEdits, node_areas};
use microsim_cutting::{SurfaceTriangle, Topology};
use microsim_mesh::{Surface, TetMesh};
use microsim_tissue::elements::{CoupleError, couple, couple_sliding};
use microsim_tissue::{Elements, Method, State, TissueModel, build_model, stability};
use nalgebra::{Matrix3, Vector3};
use region::SurfaceRegions;
use std::sync::Arc;

/// A body: constant parts and working memory.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub name: String,
    pub mesh: TetMesh,
    pub surface: Surface,
    pub model: TissueModel,
    pub drive: Drive,
    /// Where it is at the start.
    pub start: State,
    /// How it begins in equilibrium, with prestretches.
    pub initial_equilibrium: Option<InitialEquilibrium>,
    /// Origin of the body's frame in the world \[m\].
    pub origin: Vector3<f64>,
    /// Longest step with safety factor \[s\]; infinite for a method without a limit.
    pub stable_step: f64,
    /// Energy below which growth is not worth a look \[J\]: that of the whole body stretched by 1 %.
    pub energy_scale: f64,
    /// Young's modulus times the square of an edge \[N\].
    pub force_scale: f64,
    /// A third of the area of the surface's triangles at each node, at rest \[m²\].
    pub node_areas: Vec<f64>,
    /// The faces at the open ends of a vessel.
    pub ends: Vec<Vec<[u32; 3]>>,
    /// The nodes of each, ascending.
    pub end_nodes: Vec<Vec<u32>>,
    /// The lumen of a vessel.
    pub lumen: Option<Lumen>,
    /// Who is next to whom, of a body that can be cut.
    pub topology: Option<Topology>,
    pub tear_strains: Vec<(u32, f64)>,
    /// The triangles of the surface with their elements, of a body that can be cut.
    pub triangles: Vec<SurfaceTriangle>,
    /// What edits have changed of the surface since it was last updated.
    pub surface_edits: Option<SurfaceEdits>,
    pub surface_regions: SurfaceRegions,
    /// Of each triangle of the surface whether a cut has opened it.
    pub opened: Vec<bool>,
    pub pieces: Pieces,
    /// Nodes with this id or a larger one come from cuts.
    pub first_new_node: u32,
    pub tally: CutTally,
}

/// What cuts have done to a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CutTally {
    /// Elements that were divided.
    pub divided: u64,
    /// Cuts that could not be made.
    pub rejected: u64,
    /// Rest volume of the crumbs that were taken away \[m³\].
    pub lost_volume: f64,
    /// Nodes that were merged with a neighbour.
    pub merged: u64,
}

impl Body {
    /// Builds a body; every value of `spec` is checked. `touched` and `cut`: whether anything may touch it, and cut or tear it.
    pub fn new(
        spec: &BodySpec,
        method: &Method,
        touched: bool,
        cut: bool,
    ) -> Result<Self, SceneError> {
        check::check(spec)?;
        let name = spec.name.clone();
        let (mesh, origin) = (&spec.mesh, Vector3::from(spec.origin));
        let surface = mesh.surface();
        let selected = |what: &'static str, index: usize, selection: &Selection| {
            let nodes = select::nodes(mesh, &origin, selection);
            if nodes.is_empty() {
                let body = name.clone();
                return Err(SceneError::Empty { body, what, index });
            }
            Ok(nodes)
        };

        let mut clamps = Vec::new();
        let mut clamped = vec![false; mesh.positions.len()];
        for (index, clamp) in spec.clamps.iter().enumerate() {
            let nodes = selected("clamp", index, &clamp.nodes)?;
            if clamp.release.is_none() {
                nodes.iter().for_each(|&node| clamped[node as usize] = true);
            }
            clamps.push((clamp, nodes));
        }
        let held: Vec<Vec<u32>> = clamps.iter().map(|(_, nodes)| nodes.clone()).collect();
        check::check_holders(spec, &held)?;
        let mut loads = Vec::new();
        for (index, load) in spec.loads.iter().enumerate() {
            let nodes = selected("load", index, &load.surface)?;
            let triangles = select::triangles(&surface.triangles, &nodes);
            if triangles.is_empty() {
                let (body, what) = (name.clone(), "load");
                return Err(SceneError::Empty { body, what, index });
            }
            loads.push((load, triangles));
        }
        let model = build_model(mesh, &spec.materials, &clamped, spec.drag, couplings(spec)?)
            .map_err(|source| SceneError::Build {
                body: name.clone(),
                source,
            })?;
        let drive = Drive::new(mesh, &origin, &clamps, &loads, model.clamped());
        if touched && !method.enforces_non_penetration() {
            return Err(SceneError::Contact {
                body: name,
                method: method.name(),
            });
        }
        if drive.has_grips() && !method.reaches_node_targets() {
            return Err(SceneError::Grip {
                body: name,
                method: method.name(),
            });
        }
        let mut start = State::at_rest(&model);
        let initial_equilibrium = match mesh.prestretches.is_empty() {
            true => None,
            false => Some(initial_equilibrium::find(
                &name, &model, &drive, &mut start,
            )?),
        };
        let mut stable_step = stable_step(method, &model, &State::at_rest(&model));
        if initial_equilibrium.is_some() && method.is_explicit() {
            // Beside its mesh elements are stretched a little further, or less.
            stable_step = stable_step.min(limited_step(method, &model, &start));
        }
        for (index, part) in spec.start.iter().enumerate() {
            let matrix = Matrix3::from_fn(|row, column| part.matrix[row][column]);
            let pivot = origin + Vector3::from(part.pivot);
            for node in selected("start", index, &part.nodes)? {
                let node = node as usize;
                if !model.is_clamped(node) {
                    let from_pivot = start.positions[node] - pivot;
                    start.positions[node] = pivot + matrix * from_pivot + Vector3::from(part.shift);
                    start.velocities[node] += Vector3::from(part.velocity);
                }
            }
        }
        let lumen = match &spec.lumen {
            None => None,
            Some(of) => {
                Some(Lumen::new(of, mesh).ok_or_else(|| SceneError::Lumen { body: name.clone() })?)
            }
        };
        let (energy_scale, force_scale) = scales(&model);
        let mut body = Self {
            opened: vec![false; surface.triangles.len()],
            energy_scale,
            force_scale,
            node_areas: node_areas(&surface, mesh),
            surface_regions: SurfaceRegions::new(mesh, cut),
            end_nodes: spec
                .ends
                .iter()
                .map(|end| Surface::new(end.clone()).nodes)
                .collect(),
            ends: spec.ends.clone(),
            lumen,
            surface,
            drive,
            start,
            initial_equilibrium,
            origin,
            stable_step,
            name,
            tear_strains: spec.tear_strains.clone(),
            topology: cut.then(|| Topology::new(mesh)),
            pieces: Pieces::new(vec![0; mesh.positions.len()], 1, &mesh.tets),
            first_new_node: mesh.node_ids.iter().max().map_or(0, |last| last + 1),
            triangles: Vec::new(),
            surface_edits: None,
            tally: CutTally::default(),
            mesh: spec.mesh.clone(),
            model,
        };
        // In the order in which a cut leaves it.
        body.rebuild_surface();
        Ok(body)
    }
}

/// The longest step \[s\] with safety factor of a method on a body with the internal variables of `state`, its nodes at rest;
/// infinite for a method without a limit, 0 for one that is never stable.
pub(crate) fn stable_step(method: &Method, model: &TissueModel, state: &State) -> f64 {
    if !method.is_explicit() {
        return f64::INFINITY;
    }
    let at_rest = State {
        internal: state.internal.clone(),
        ..State::at_rest(model)
    };
    limited_step(method, model, &at_rest)
}

/// The same for an explicit method at the positions of `state`.
pub(crate) fn limited_step(method: &Method, model: &TissueModel, state: &State) -> f64 {
    let step = stability::stable_step_at(model, state, stability::SAFETY);
    // h = 2s/√λ for a body without viscosity; a viscous one has a shorter step, hence a larger λ here, on the safe side.
    let lambda = 4.0 * stability::SAFETY * stability::SAFETY / (step * step);
    step.min(stability::SAFETY * stability::limit(method, lambda, model.drag()))
}

/// Energy of a body stretched by 1 % along x \[J\], and the modulus that it has by that times the square of an edge \[N\].
fn scales(model: &TissueModel) -> (f64, f64) {
    const STRAIN: f64 = 0.01;
    let mut state = State::at_rest(model);
    state.positions.iter_mut().for_each(|p| p.x *= 1.0 + STRAIN);
    let mut energy = state.energies(model).elastic();
    let rest = State::at_rest(model).energies(model).elastic();
    if rest > 0.0 {
        // Under residual stress energy grows with the strain itself; its modulus is the mean of both senses.
        for (place, at_rest) in state.positions.iter_mut().zip(model.rest_positions()) {
            place.x = at_rest.x * (1.0 - STRAIN);
        }
        energy = 0.5 * (energy + state.energies(model).elastic()) - rest;
    }
    let volume: f64 = model.rest_volumes().iter().sum();
    let modulus = 2.0 * energy / (STRAIN * STRAIN * volume);
    let edge = model.mean_edge_length();
    (energy, modulus * edge * edge)
}

/// The couplings of a body as sets of elements.
fn couplings(spec: &BodySpec) -> Result<Vec<Arc<dyn Elements>>, SceneError> {
    let sets = spec.couplings.iter().map(|coupling| {
        let (mesh, from, to) = (&spec.mesh, coupling.from, coupling.to);
        let set: Result<Arc<dyn Elements>, CoupleError> = match &coupling.kind {
            CouplingKind::Bonded(constants) => {
                couple(mesh, from, to, constants).map(|set| Arc::new(set) as _)
            }
            CouplingKind::Sliding(constants) => {
                couple_sliding(mesh, from, to, constants).map(|set| Arc::new(set) as _)
            }
        };
        set.map_err(|source| SceneError::Couple {
            body: spec.name.clone(),
            source,
        })
    });
    sets.collect()
}
