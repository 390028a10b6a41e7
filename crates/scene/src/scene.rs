//! The scene: bodies, tools, contact pairs, and what evolves.

use crate::error::SceneError;
use crate::spec::{BodySpec, Generator, SceneSpec};
use crate::tool::Tool;
use microsim_contact::ContactMemory;
use microsim_geometry::Aabb;
use microsim_mesh::{Surface, TetMesh};
use microsim_tissue::{
    Control, Energies, Serial, SolverVerlet, SpringVolume, State, TissueModel, stability,
};
use nalgebra::Vector3;

/// A clamp box is grown by this share of the body's mean edge length, so that a box that ends on a layer of nodes holds it
/// whatever the rounding.
const CLAMP_MARGIN: f64 = 1e-6;

/// A body: constant parts and working memory.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub name: String,
    pub mesh: TetMesh,
    pub surface: Surface,
    pub model: TissueModel,
    pub solver: SolverVerlet,
    pub stable_step: f64,
    /// Energy below which growth is not worth a look [J]: that of the whole body stretched by 1 %.
    pub energy_scale: f64,
}

/// Indices of a tool and a body that touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    pub tool: usize,
    pub body: usize,
}

/// All that evolves. A copy of it is all that is needed to go back.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SceneState {
    /// One per body.
    pub bodies: Vec<State>,
    /// One per contact pair.
    pub memories: Vec<ContactMemory>,
    /// Simulated time [s].
    pub time: f64,
}

/// Bodies and tools in one world.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) bodies: Vec<Body>,
    pub(crate) tools: Vec<Tool>,
    pub(crate) pairs: Vec<Pair>,
    pub(crate) control: Control,
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
        let bodies = spec
            .bodies
            .iter()
            .map(Body::new)
            .collect::<Result<Vec<_>, _>>()?;
        let tools = spec
            .tools
            .iter()
            .map(Tool::new)
            .collect::<Result<Vec<_>, _>>()?;
        let pairs = find_pairs(spec)?;
        let state = SceneState {
            bodies: bodies
                .iter()
                .map(|body| State::at_rest(&body.model))
                .collect(),
            memories: vec![ContactMemory::new(); pairs.len()],
            time: 0.0,
        };
        Ok(Self {
            bodies,
            tools,
            pairs,
            control: Control { gravity },
            state,
        })
    }

    /// Back to the state at which the scene was built.
    pub fn reset(&mut self) {
        self.state.bodies = self
            .bodies
            .iter()
            .map(|body| State::at_rest(&body.model))
            .collect();
        self.state
            .memories
            .iter_mut()
            .for_each(ContactMemory::clear);
        self.state.time = 0.0;
    }

    /// Whether `steps` solver's steps per tick of `tick_s` [s] are enough for every body; the error holds the number that is.
    pub fn check_step(&self, tick_s: f64, steps: u32) -> Result<(), SceneError> {
        if !tick_s.is_finite() || tick_s <= 0.0 {
            return Err(SceneError::Tick { tick_s });
        }
        let required_steps = self.required_steps(tick_s);
        let slowest = self
            .bodies
            .iter()
            .min_by(|a, b| a.stable_step.total_cmp(&b.stable_step));
        match slowest {
            Some(body) if steps < required_steps => Err(SceneError::StepTooLong {
                body: body.name.clone(),
                step_s: tick_s / f64::from(steps),
                stable_step_s: body.stable_step,
                required_steps,
            }),
            _ => Ok(()),
        }
    }

    /// The smallest number of solver's steps per tick of `tick_s` [s] that every body allows; at least 1.
    pub fn required_steps(&self, tick_s: f64) -> u32 {
        let stable_step = self
            .bodies
            .iter()
            .map(|body| body.stable_step)
            .fold(f64::INFINITY, f64::min);
        // The cast saturates.
        (tick_s / stable_step).ceil().max(1.0) as u32
    }

    /// Simulated time [s].
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

    /// Node positions of a body in the world [m].
    pub fn positions(&self, body: usize) -> &[Vector3<f64>] {
        &self.state.bodies[body].positions
    }

    /// Node positions of a body at rest [m].
    pub fn rest_positions(&self, body: usize) -> &[Vector3<f64>] {
        self.bodies[body].model.rest_positions()
    }

    /// Node velocities of a body in the middle of its last step [m/s].
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

    /// Topology generation of a body's mesh.
    pub fn generation(&self, body: usize) -> u64 {
        self.bodies[body].mesh.generation
    }

    /// Node masses of a body [kg].
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

    /// Volume of a body [m³].
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

    /// Energy of a body by kind [J].
    pub fn energies(&self, body: usize) -> Energies {
        self.state.bodies[body].energies(&self.bodies[body].model)
    }

    /// Elastic force and weight at each node of a body [N]; at a clamped node it is what the clamp holds.
    pub fn forces(&self, body: usize) -> Vec<Vector3<f64>> {
        let body_ref = &self.bodies[body];
        let mut solver = body_ref.solver.clone();
        solver
            .forces(
                &body_ref.model,
                &self.state.bodies[body],
                &self.control,
                &Serial,
            )
            .to_vec()
    }

    /// Mean edge length of a body at rest [m]: its characteristic length.
    pub fn mean_edge_length(&self, body: usize) -> f64 {
        self.bodies[body].model.mean_edge_length()
    }

    /// Longest step [s] that a body allows, safety factor included.
    pub fn stable_step(&self, body: usize) -> f64 {
        self.bodies[body].stable_step
    }
}

impl Body {
    fn new(spec: &BodySpec) -> Result<Self, SceneError> {
        let name = spec.name.clone();
        let Generator::Block(block) = &spec.generator;
        let mesh = block.mesh().map_err(|source| SceneError::Mesh {
            body: name.clone(),
            source,
        })?;
        let material =
            SpringVolume::from_moduli(spec.material).map_err(|source| SceneError::Material {
                body: name.clone(),
                source,
            })?;
        let origin = Vector3::from(block.center);
        let mut clamped = vec![false; mesh.positions.len()];
        let margin = CLAMP_MARGIN * mesh.mean_edge_length();
        for (index, clamp) in spec.clamps.iter().enumerate() {
            let region = Aabb {
                min: clamp.min.into(),
                max: clamp.max.into(),
            }
            .inflated(margin);
            let mut holds_node = false;
            for (flag, position) in clamped.iter_mut().zip(&mesh.positions) {
                if region.contains(&(position - origin)) {
                    *flag = true;
                    holds_node = true;
                }
            }
            if !holds_node {
                return Err(SceneError::Clamp { body: name, index });
            }
        }
        let model =
            TissueModel::new(&mesh, &material, &clamped).map_err(|source| SceneError::Model {
                body: name.clone(),
                source,
            })?;
        let volume: f64 = mesh.volumes().iter().sum();
        Ok(Self {
            surface: mesh.surface(),
            solver: SolverVerlet::new(&model),
            stable_step: stability::stable_step(&model, stability::SAFETY),
            energy_scale: 0.5 * spec.material.stretch_modulus * volume * 1e-4,
            name,
            mesh,
            model,
        })
    }
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

fn find_pairs(spec: &SceneSpec) -> Result<Vec<Pair>, SceneError> {
    let mut pairs: Vec<Pair> = Vec::new();
    for (tool, body) in &spec.contact_pairs {
        let wrong = |reason| SceneError::ContactPair {
            tool: tool.clone(),
            body: body.clone(),
            reason,
        };
        let pair = Pair {
            tool: spec
                .tools
                .iter()
                .position(|t| t.name == *tool)
                .ok_or_else(|| wrong("no such tool"))?,
            body: spec
                .bodies
                .iter()
                .position(|b| b.name == *body)
                .ok_or_else(|| wrong("no such body"))?,
        };
        if pairs.contains(&pair) {
            return Err(wrong("stands twice"));
        }
        pairs.push(pair);
    }
    Ok(pairs)
}
