//! The scene: bodies, tools, contact pairs, and what evolves.

use crate::boundary::{Waiting, node_areas};
use crate::check;
use crate::cutting::{self, Cut, Edit};
use crate::drive::Drive;
use crate::error::SceneError;
use crate::group::Group;
use crate::lonor::BladeMemory;
use crate::pairs::{Obstacle, Pair, PairPartner, find_obstacles, find_pairs};
use crate::pieces::Pieces;
use crate::report::ContactPartner;
use crate::select;
use crate::spec::{BodySpec, PartnerSpec, SceneSpec, Selection};
use crate::tool::{Tool, ToolMotion};
use crate::touching::ContactMemory;
use microsim_contact::ObstaclePart;
use microsim_cutting::{SurfaceTriangle, Topology};
use microsim_mesh::{Surface, TetMesh};
use microsim_tissue::elements::{CouplingConstants, couple};
use microsim_tissue::{
    Elements, Energies, Forces, Method, Serial, State, TissueModel, build_model, stability,
};
use nalgebra::{Matrix3, Vector3};
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
    /// Who is next to whom, of a body that can be cut.
    pub topology: Option<Topology>,
    pub tear_strains: Vec<(u32, f64)>,
    /// The triangles of the surface with their elements, of a body that can be cut.
    pub triangles: Vec<SurfaceTriangle>,
    /// What edits have changed in it since it was renewed.
    pub waiting: Option<Waiting>,
    /// Of each triangle of the surface whether a cut has opened it.
    pub inner: Vec<bool>,
    pub pieces: Pieces,
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
}

/// All that evolves. A copy of it is all that is needed to go back.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SceneState {
    /// One per body.
    pub bodies: Vec<State>,
    /// One per group of bodies.
    pub memories: Vec<ContactMemory>,
    /// Longest step of each body as it is now \[s\]: plastic flow makes it shorter.
    pub stable_steps: Vec<f64>,
    /// One per cut.
    pub blades: Vec<BladeMemory>,
    /// Simulated time \[s\].
    pub time: f64,
}

/// Bodies and tools in one world.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) bodies: Vec<Body>,
    pub(crate) tools: Vec<Tool>,
    pub(crate) obstacles: Vec<Obstacle>,
    /// The parts of all obstacles.
    pub(crate) obstacle_parts: Vec<ObstaclePart>,
    pub(crate) pairs: Vec<Pair>,
    pub(crate) cuts: Vec<Cut>,
    pub(crate) groups: Vec<Group>,
    /// The edits so far, and what bodies and groups were before the first one.
    pub(crate) edits: Vec<Edit>,
    pub(crate) uncut: Option<Box<(Vec<Body>, Vec<Group>)>>,
    pub(crate) gravity: Vector3<f64>,
    pub(crate) method: Method,
    pub(crate) containment: bool,
    pub(crate) state: SceneState,
}

impl Scene {
    /// Builds a scene at rest; every value of `spec` is checked.
    pub fn new(spec: &SceneSpec) -> Result<Self, SceneError> {
        check_names("body", spec.bodies.iter().map(|body| body.name.as_str()))?;
        check_names("tool", spec.tools.iter().map(|tool| tool.name.as_str()))?;
        let gravity = Vector3::from(spec.gravity);
        if !gravity.iter().all(|g| g.is_finite()) {
            return Err(SceneError::Gravity);
        }
        check_names(
            "obstacle",
            spec.obstacles.iter().map(|obstacle| obstacle.name.as_str()),
        )?;
        let touched = |body: &BodySpec| {
            let other = |with: &PartnerSpec| matches!(with, PartnerSpec::Body { name, .. } if *name == body.name);
            let mut pairs = spec.contacts.iter();
            pairs.any(|pair| pair.body == body.name || other(&pair.with))
        };
        let mut bodies = spec
            .bodies
            .iter()
            .map(|body| {
                let cut = spec.cuts.iter().any(|cut| cut.body == body.name);
                let cut = cut || !body.tear_strains.is_empty();
                Body::new(body, &spec.method, touched(body), cut)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let tools = spec
            .tools
            .iter()
            .map(Tool::new)
            .collect::<Result<Vec<_>, _>>()?;
        let (obstacles, obstacle_parts) = find_obstacles(&spec.obstacles)?;
        let pairs = find_pairs(spec, &obstacles)?;
        let cuts = cutting::cuts(spec, &pairs)?;
        let groups = Group::all(&bodies, &pairs, &obstacle_parts, &spec.method)?;
        let state = SceneState {
            bodies: bodies.iter().map(|body| body.start.clone()).collect(),
            memories: vec![ContactMemory::default(); groups.len()],
            stable_steps: bodies.iter().map(|body| body.stable_step).collect(),
            blades: vec![BladeMemory::default(); cuts.len()],
            time: 0.0,
        };
        let is_cut = bodies.iter().any(|body| body.topology.is_some());
        let uncut = is_cut.then(|| Box::new((bodies.clone(), groups.clone())));
        // After the copy, so that the first cut has nothing to copy.
        bodies.iter_mut().for_each(Body::prepare_edits);
        Ok(Self {
            tools,
            obstacles,
            obstacle_parts,
            pairs,
            uncut,
            cuts,
            groups,
            edits: Vec::new(),
            gravity,
            method: spec.method,
            containment: spec.containment,
            state,
            bodies,
        })
    }

    /// Back to the state at which the scene was built.
    pub fn reset(&mut self) {
        self.undo_edits();
        let blades = self.state.blades.iter_mut();
        blades.for_each(|blade| *blade = BladeMemory::default());
        self.state.bodies = self.bodies.iter().map(|body| body.start.clone()).collect();
        self.state
            .memories
            .iter_mut()
            .for_each(|memory| *memory = ContactMemory::default());
        self.state.stable_steps = self.bodies.iter().map(|body| body.stable_step).collect();
        self.state.time = 0.0;
    }

    /// Whether `steps` solver's steps per tick of `tick_s` \[s\] are enough for every body; the error holds the number that is.
    pub fn check_step(&self, tick_s: f64, steps: u32) -> Result<(), SceneError> {
        if !tick_s.is_finite() || tick_s <= 0.0 {
            return Err(SceneError::Tick { tick_s });
        }
        if let Some(body) = self.state.stable_steps.iter().position(|step| *step <= 0.0) {
            return Err(SceneError::NeverStable {
                body: self.bodies[body].name.clone(),
                method: self.method.name(),
            });
        }
        let required_steps = self.required_steps(tick_s);
        let stable_steps = self.bodies.iter().zip(&self.state.stable_steps);
        let slowest = stable_steps.min_by(|a, b| a.1.total_cmp(b.1));
        match slowest {
            Some((body, stable_step)) if steps < required_steps => Err(SceneError::StepTooLong {
                body: body.name.clone(),
                step_s: tick_s / f64::from(steps),
                stable_step_s: *stable_step,
                required_steps,
            }),
            _ => Ok(()),
        }
    }

    /// The smallest number of solver's steps per tick of `tick_s` \[s\] that every body allows; at least 1.
    pub fn required_steps(&self, tick_s: f64) -> u32 {
        let stable_steps = self.state.stable_steps.iter().copied();
        let stable_step = stable_steps.fold(f64::INFINITY, f64::min);
        // The cast saturates.
        (tick_s / stable_step).ceil().max(1.0) as u32
    }

    /// Simulated time \[s\].
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Number of bodies; the methods below take an index below it.
    pub fn body_count(&self) -> usize {
        self.bodies.len()
    }

    /// Name of a body.
    pub fn body_name(&self, body: usize) -> &str {
        &self.bodies[body].name
    }

    /// Number of tools.
    pub fn tool_count(&self) -> usize {
        self.tools.len()
    }

    /// Name of a tool.
    pub fn tool_name(&self, tool: usize) -> &str {
        &self.tools[tool].name
    }

    /// Number of obstacles.
    pub fn obstacle_count(&self) -> usize {
        self.obstacles.len()
    }

    /// Name of an obstacle.
    pub fn obstacle_name(&self, obstacle: usize) -> &str {
        &self.obstacles[obstacle].name
    }

    /// Number of groups of bodies that are advanced together, as they touch one another.
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// The motions of the tools that have one of their own, from one time to another \[s\].
    pub fn own_motions(&self, from: f64, to: f64) -> Vec<ToolMotion> {
        let tools = self.tools.iter().enumerate();
        let motions = tools.filter_map(|(index, tool)| {
            let (start, end) = (tool.own_place(from)?, tool.own_place(to)?);
            Some(ToolMotion {
                tool: index,
                from: start.0,
                to: end.0,
                opening_from: start.1,
                opening_to: end.1,
                active: true,
            })
        });
        motions.collect()
    }

    /// Momentum of a body \[kg m/s\]; nodes that are clamped have none.
    pub fn momentum(&self, body: usize) -> Vector3<f64> {
        let model = &self.bodies[body].model;
        let nodes = self.velocities(body).iter().enumerate();
        nodes
            .filter(|(node, _)| !model.is_clamped(*node))
            .map(|(node, v)| v * model.inertia(node))
            .sum()
    }

    /// Number of pairs that can touch.
    pub fn pair_count(&self) -> usize {
        self.pairs.len()
    }

    /// Body and partner of a pair.
    pub fn pair(&self, pair: usize) -> (usize, ContactPartner) {
        let of = &self.pairs[pair];
        let with = match &of.with {
            PairPartner::Tool(tool) => ContactPartner::Tool(*tool),
            PairPartner::Obstacle { obstacle, .. } => ContactPartner::Obstacle(*obstacle),
            PairPartner::Body(body) => ContactPartner::Body(*body),
            PairPartner::Itself => ContactPartner::Itself,
        };
        (of.body, with)
    }

    /// The pair of a body and a partner, in the order of the description.
    pub fn pair_of(&self, body: usize, with: ContactPartner) -> Option<usize> {
        (0..self.pairs.len()).find(|&pair| self.pair(pair) == (body, with))
    }

    /// Name of a body's partner.
    pub fn partner_name(&self, with: ContactPartner) -> &str {
        match with {
            ContactPartner::Tool(tool) => self.tool_name(tool),
            ContactPartner::Obstacle(obstacle) => self.obstacle_name(obstacle),
            ContactPartner::Body(body) => self.body_name(body),
            ContactPartner::Itself => "itself",
        }
    }

    /// Node positions of a body in the world \[m\].
    pub fn positions(&self, body: usize) -> &[Vector3<f64>] {
        &self.state.bodies[body].positions
    }

    /// Node positions of a body at the start \[m\]; of a node that a cut has made those of where it would have been.
    pub fn start_positions(&self, body: usize) -> &[Vector3<f64>] {
        &self.bodies[body].start.positions
    }

    /// Node positions of a body at rest \[m\].
    pub fn rest_positions(&self, body: usize) -> &[Vector3<f64>] {
        self.bodies[body].model.rest_positions()
    }

    /// Node velocities of a body \[m/s\]: at the end of its last step, with Störmer–Verlet in its middle.
    pub fn velocities(&self, body: usize) -> &[Vector3<f64>] {
        &self.state.bodies[body].velocities
    }

    /// Stable ids of a body's nodes.
    pub fn node_ids(&self, body: usize) -> &[u32] {
        &self.bodies[body].mesh.node_ids
    }

    /// Stable ids of a body's elements.
    pub fn element_ids(&self, body: usize) -> &[u32] {
        &self.bodies[body].mesh.element_ids
    }

    /// Elements of a body as node indices.
    pub fn tets(&self, body: usize) -> &[[u32; 4]] {
        &self.bodies[body].mesh.tets
    }

    /// Surface of a body: outward triangles as node indices.
    pub fn surface(&self, body: usize) -> &Surface {
        &self.bodies[body].surface
    }

    /// Whether a cut has opened each triangle of a body's surface.
    pub fn inner(&self, body: usize) -> &[bool] {
        &self.bodies[body].inner
    }

    /// The piece that each node of a body is of: 0 of what was there before any came off, else the number under which it came off.
    pub fn pieces(&self, body: usize) -> &[u32] {
        &self.bodies[body].pieces.of_nodes
    }

    /// Number of pieces of a body so far: 1 before any came off. One that is cut further counts for more.
    pub fn piece_count(&self, body: usize) -> u32 {
        self.bodies[body].pieces.count()
    }

    /// Whether anything can be cut or tear.
    pub fn has_cuts(&self) -> bool {
        self.uncut.is_some()
    }

    /// What cuts have done to a body.
    pub fn cut_tally(&self, body: usize) -> CutTally {
        self.bodies[body].tally
    }

    /// Rest volume \[m³\] and mass \[kg\] of a body before any cut.
    pub fn uncut(&self, body: usize) -> (f64, f64) {
        let uncut = self.uncut.as_deref().map(|(bodies, _)| &bodies[body]);
        let model = &uncut.unwrap_or(&self.bodies[body]).model;
        (
            model.rest_volumes().iter().sum(),
            model.masses().iter().sum(),
        )
    }

    /// Topology generation of a body's mesh.
    pub fn generation(&self, body: usize) -> u64 {
        self.bodies[body].mesh.generation
    }

    /// Node masses of a body \[kg\].
    pub fn masses(&self, body: usize) -> &[f64] {
        self.bodies[body].model.masses()
    }

    /// Whether each node of a body is clamped.
    pub fn clamped(&self, body: usize) -> Vec<bool> {
        let model = &self.bodies[body].model;
        (0..model.node_count())
            .map(|node| model.is_clamped(node))
            .collect()
    }

    /// Number of elements of a body.
    pub fn element_count(&self, body: usize) -> usize {
        self.bodies[body].mesh.tets.len()
    }

    /// Volume of a body \[m³\].
    pub fn volume(&self, body: usize) -> f64 {
        let positions = self.positions(body);
        self.tets(body)
            .iter()
            .map(|tet| {
                let [a, b, c, d] = tet.map(|node| &positions[node as usize]);
                microsim_mesh::signed_volume(a, b, c, d)
            })
            .sum()
    }

    /// Energy of a body by kind \[J\].
    pub fn energies(&self, body: usize) -> Energies {
        self.state.bodies[body].energies(&self.bodies[body].model)
    }

    /// Elastic and viscous force, weight and loads at each node of a body \[N\]; at a clamped node it is what the clamp holds.
    pub fn forces(&self, body: usize) -> Vec<Vector3<f64>> {
        let of = &self.bodies[body];
        let control = of.drive.control(&self.gravity, self.state.time);
        let mut forces = Forces::new(&of.model);
        forces
            .compute(&of.model, &self.state.bodies[body], &control, &Serial)
            .to_vec()
    }

    /// The nodes of a body that `selection` means, ascending.
    pub fn select(&self, body: usize, selection: &Selection) -> Vec<u32> {
        let of = &self.bodies[body];
        select::nodes(&of.mesh, &of.origin, selection)
    }

    /// Origin of a body's frame in the world \[m\]; its axes are the world's.
    pub fn origin(&self, body: usize) -> Vector3<f64> {
        self.bodies[body].origin
    }

    /// Acceleration of gravity \[m/s²\].
    pub fn gravity(&self) -> Vector3<f64> {
        self.gravity
    }

    /// The mesh of a body at rest.
    pub fn mesh(&self, body: usize) -> &TetMesh {
        &self.bodies[body].mesh
    }

    /// The model of a body.
    pub fn model(&self, body: usize) -> &TissueModel {
        &self.bodies[body].model
    }

    /// The state of a body.
    pub fn body_state(&self, body: usize) -> &State {
        &self.state.bodies[body]
    }

    /// Iterations of the solvers of all groups of bodies that touch one another since the scene was built, repeated ticks
    /// included; 1 per step for a method without any.
    pub fn iterations(&self) -> u64 {
        self.groups.iter().map(|group| group.iterations).sum()
    }

    /// How the bodies are advanced.
    pub fn method(&self) -> &Method {
        &self.method
    }

    /// Mean edge length of a body at rest \[m\]: its characteristic length.
    pub fn mean_edge_length(&self, body: usize) -> f64 {
        self.bodies[body].model.mean_edge_length()
    }

    /// Longest step \[s\] that a body allows, safety factor included; infinite for a method without a limit.
    pub fn stable_step(&self, body: usize) -> f64 {
        self.state.stable_steps[body]
    }

    /// Works out the longest step of a body with its internal variables as they are now. It never grows again.
    pub(crate) fn renew_stable_step(&mut self, body: usize) {
        let of = &self.bodies[body];
        let step = stable_step(&self.method, &of.model, &self.state.bodies[body]);
        let now = &mut self.state.stable_steps[body];
        *now = now.min(step);
    }
}

impl Body {
    fn new(spec: &BodySpec, method: &Method, touched: bool, cut: bool) -> Result<Self, SceneError> {
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
        if touched && !method.keeps_gaps() {
            return Err(SceneError::Contact {
                body: name,
                method: method.name(),
            });
        }
        if drive.has_grips() && !method.leads_nodes() {
            return Err(SceneError::Grip {
                body: name,
                method: method.name(),
            });
        }
        let mut start = State::at_rest(&model);
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
        let stable_step = stable_step(method, &model, &State::at_rest(&model));
        let (energy_scale, force_scale) = scales(&model);
        let mut body = Self {
            inner: vec![false; surface.triangles.len()],
            energy_scale,
            force_scale,
            node_areas: node_areas(&surface, mesh),
            end_nodes: spec
                .ends
                .iter()
                .map(|end| Surface::new(end.clone()).nodes)
                .collect(),
            ends: spec.ends.clone(),
            surface,
            drive,
            start,
            origin,
            stable_step,
            name,
            tear_strains: spec.tear_strains.clone(),
            topology: cut.then(|| Topology::new(mesh)),
            pieces: Pieces::new(vec![0; mesh.positions.len()], 1, &mesh.tets),
            triangles: Vec::new(),
            waiting: None,
            tally: CutTally::default(),
            mesh: spec.mesh.clone(),
            model,
        };
        // In the order in which a cut leaves it.
        body.make_surface();
        Ok(body)
    }
}

/// The longest step \[s\] with safety factor of a method on a body with the internal variables of `state`, its nodes at rest;
/// infinite for a method without a limit, 0 for one that is never stable.
fn stable_step(method: &Method, model: &TissueModel, state: &State) -> f64 {
    if !method.is_explicit() {
        return f64::INFINITY;
    }
    let at_rest = State {
        internal: state.internal.clone(),
        ..State::at_rest(model)
    };
    let step = stability::stable_step_at(model, &at_rest, stability::SAFETY);
    // h = 2s/√λ for a body without viscosity; a viscous one has a shorter step, hence a larger λ here, on the safe side.
    let lambda = 4.0 * stability::SAFETY * stability::SAFETY / (step * step);
    step.min(stability::SAFETY * stability::limit(method, lambda, model.drag()))
}

/// Energy of a body stretched by 1 % along x \[J\], and the modulus that it has by that times the square of an edge \[N\].
fn scales(model: &TissueModel) -> (f64, f64) {
    const STRAIN: f64 = 0.01;
    let mut state = State::at_rest(model);
    state.positions.iter_mut().for_each(|p| p.x *= 1.0 + STRAIN);
    let energy = state.energies(model).elastic();
    let volume: f64 = model.rest_volumes().iter().sum();
    let modulus = 2.0 * energy / (STRAIN * STRAIN * volume);
    let edge = model.mean_edge_length();
    (energy, modulus * edge * edge)
}

/// The couplings of a body as sets of elements.
fn couplings(spec: &BodySpec) -> Result<Vec<Arc<dyn Elements>>, SceneError> {
    let sets = spec.couplings.iter().map(|coupling| {
        let constants = CouplingConstants {
            stiffness_per_area: coupling.stiffness,
            break_distance: coupling.break_distance,
        };
        let set = couple(&spec.mesh, coupling.from, coupling.to, &constants);
        let set = set.map_err(|source| SceneError::Couple {
            body: spec.name.clone(),
            source,
        })?;
        Ok(Arc::new(set) as Arc<dyn Elements>)
    });
    sets.collect()
}

fn check_names<'a>(
    kind: &'static str,
    names: impl Iterator<Item = &'a str>,
) -> Result<(), SceneError> {
    let mut seen = std::collections::BTreeSet::new();
    for name in names {
        if name.is_empty() || !seen.insert(name) {
            return Err(SceneError::Name {
                kind,
                name: name.to_owned(),
            });
        }
    }
    Ok(())
}
