//! The scene: bodies, tools, contact pairs, and what evolves.

use crate::body::Body;
use crate::cut_pairs::{CutPair, find_cuts};
use crate::edits::Edit;
use crate::error::SceneError;
use crate::force_window::ForceWindow;
use crate::group::Group;
use crate::group_contact::ContactState;
use crate::lonor::BladeState;
use crate::pairs::{Obstacle, Pair, PairPartner, find_obstacles, find_pairs};
use crate::placement::Placements;
use crate::report::ContactPartner;
use crate::spec::{BodySpec, ContactResponse, ContactSpec, PartnerSpec, SceneSpec, WorkBudget};
use crate::state::SceneState;
use crate::tool::{Tool, ToolMotion};
use microsim_contact::ObstaclePart;
use microsim_geometry::Pose;
use microsim_tissue::Method;
use nalgebra::Vector3;

/// A scene that is simulated: built from a [`SceneSpec`], advanced by [`tick`](Self::tick), read by [`body`](Self::body).
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) bodies: Vec<Body>,
    pub(crate) tools: Vec<Tool>,
    pub(crate) obstacles: Vec<Obstacle>,
    /// The parts of all obstacles.
    pub(crate) obstacle_parts: Vec<ObstaclePart>,
    pub(crate) pairs: Vec<Pair>,
    pub(crate) cuts: Vec<CutPair>,
    pub(crate) groups: Vec<Group>,
    /// The edits so far, and what bodies and groups were before the first one.
    pub(crate) edits: Vec<Edit>,
    pub(crate) uncut: Option<Box<(Vec<Body>, Vec<Group>)>>,
    pub(crate) gravity: Vector3<f64>,
    pub(crate) method: Method,
    pub(crate) containment: bool,
    pub(crate) repeat_invalid: bool,
    pub(crate) repeat_unconverged: bool,
    pub(crate) tools_touch: bool,
    pub(crate) hand_force: f64,
    pub(crate) budget: Option<WorkBudget>,
    pub(crate) state: SceneState,
}

impl Scene {
    /// Builds a scene at rest; every value of `spec` is checked.
    ///
    /// ```
    /// # use microsim_mesh::{Block, CellSplit};
    /// # use microsim_scene::{Behaviour, BodySpec, Material, Method, Scene, SceneSpec, Serial};
    /// # use microsim_tissue::SpringConstants;
    /// # let block = Block { center: [0.0; 3], size: [2e-3; 3], cells: [2; 3], split: CellSplit::Kuhn };
    /// # let behaviour = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
    /// # let material = Material { density: 1060.0, relaxation_time: 0.0, behaviour };
    /// # let cube = BodySpec::new("cube", block.mesh()?, material);
    /// let mut spec = SceneSpec::new(vec![cube], Method::StoermerVerlet);
    /// assert_eq!(Scene::new(&spec)?.body(0).name(), "cube");
    /// spec.bodies[0].drag = -1.0;
    /// let error = Scene::new(&spec).expect_err("a drag below 0");
    /// assert!(error.to_string().starts_with("body 'cube'"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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
            let by_velocity =
                |pair: &ContactSpec| matches!(pair.response, ContactResponse::Penalty { .. });
            pairs.any(|pair| !by_velocity(pair) && (pair.body == body.name || other(&pair.with)))
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
            .map(|tool| {
                let cuts = spec.cuts.iter().any(|cut| cut.tool == tool.name);
                Ok(Tool::new(tool)?.cutting(cuts))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let (obstacles, obstacle_parts) = find_obstacles(&spec.obstacles)?;
        let pairs = find_pairs(spec, &obstacles)?;
        let cuts = find_cuts(spec, &pairs)?;
        let groups = Group::all(
            &bodies,
            &pairs,
            &obstacle_parts,
            spec.broad_phase,
            &spec.method,
        )?;
        let state = SceneState {
            bodies: bodies.iter().map(|body| body.start.clone()).collect(),
            contacts: vec![ContactState::default(); groups.len()],
            stable_steps: bodies.iter().map(|body| body.stable_step).collect(),
            blades: vec![BladeState::default(); cuts.len()],
            windows: vec![ForceWindow::default(); pairs.len()],
            placements: Placements::new(tools.len()),
            doubtful: false,
            overspent: 0.0,
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
            repeat_invalid: spec.repeat_invalid,
            repeat_unconverged: spec.repeat_unconverged,
            tools_touch: spec.tools_touch,
            hand_force: spec.hand_force,
            budget: spec.budget,
            state,
            bodies,
        })
    }

    /// Back to the state at which the scene was built.
    pub fn reset(&mut self) {
        if self.edits.is_empty() {
            // Solvers follow ties back before the bodies are replaced, which have them in place.
            self.state.bodies = self.bodies.iter().map(|body| body.start.clone()).collect();
            self.relocate();
        }
        self.undo_edits();
        let blades = self.state.blades.iter_mut();
        blades.for_each(|blade| *blade = BladeState::default());
        self.state.bodies = self.bodies.iter().map(|body| body.start.clone()).collect();
        self.state
            .contacts
            .iter_mut()
            .for_each(|contact| *contact = ContactState::default());
        self.state.stable_steps = self.bodies.iter().map(|body| body.stable_step).collect();
        let windows = self.state.windows.iter_mut();
        windows.for_each(|window| window.ticks.clear());
        self.state.placements = Placements::new(self.tools.len());
        self.state.doubtful = false;
        self.state.overspent = 0.0;
        self.state.time = 0.0;
    }

    /// The bodies as they were before the first edit.
    fn undo_edits(&mut self) {
        if let Some(uncut) = &self.uncut {
            let (bodies, groups) = &**uncut;
            // Without an edit marks of topologies may have changed.
            self.bodies.clone_from(bodies);
            if !self.edits.is_empty() {
                self.groups.clone_from(groups);
                self.edits.clear();
            }
            self.bodies.iter_mut().for_each(Body::prepare_edits);
        }
    }

    /// Whether `steps` solver's steps per tick of `tick_s` \[s\] are enough for every body; the error holds the number that is.
    ///
    /// ```
    /// # use microsim_mesh::{Block, CellSplit};
    /// # use microsim_scene::{Behaviour, BodySpec, Material, Method, Scene, SceneSpec, Serial};
    /// # use microsim_tissue::SpringConstants;
    /// # let block = Block { center: [0.0; 3], size: [2e-3; 3], cells: [2; 3], split: CellSplit::Kuhn };
    /// # let behaviour = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
    /// # let material = Material { density: 1060.0, relaxation_time: 0.0, behaviour };
    /// # let cube = BodySpec::new("cube", block.mesh()?, material);
    /// let scene = Scene::new(&SceneSpec::new(vec![cube], Method::StoermerVerlet))?;
    /// let required = scene.required_steps(10e-3);
    /// assert!(required > 1 && scene.check_step(10e-3, required).is_ok());
    /// let error = scene.check_step(10e-3, required - 1).expect_err("beyond the stability limit");
    /// assert!(error.to_string().contains(&format!("at least {required} steps")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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

    /// Number of bodies.
    pub fn body_count(&self) -> usize {
        self.bodies.len()
    }

    /// Number of tools.
    pub fn tool_count(&self) -> usize {
        self.tools.len()
    }

    /// Name of a tool.
    pub fn tool_name(&self, tool: usize) -> &str {
        &self.tools[tool].name
    }

    /// Whether any tool sends out fluid by its own motion.
    pub(crate) fn irrigates(&self) -> bool {
        let of_tool = |tool: &Tool| {
            let mut keys = tool.motion.iter();
            keys.any(|key| tool.jet(&key.pose, key.opening).is_some())
        };
        self.tools.iter().any(of_tool)
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

    /// The tools that are not where their hands hold them, with `world_from_tool` and opening.
    pub fn placed_tools(&self) -> Vec<(usize, Pose, f64)> {
        let tools = self.state.placements.tools.iter().enumerate();
        let placed = tools.filter_map(|(tool, placement)| Some((tool, placement.as_ref()?)));
        let held_off = placed.filter(|(_, placement)| !placement.is_free);
        held_off
            .map(|(tool, placement)| (tool, placement.pose, placement.opening))
            .collect()
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
            ContactPartner::Body(body) => &self.bodies[body].name,
            ContactPartner::Itself => "itself",
        }
    }

    /// The name of a part of a tool, by the index of its capsule; empty if it has none.
    ///
    /// # Panics
    /// If there is no such tool.
    pub fn part_name(&self, tool: usize, capsule: u32) -> &str {
        self.tools[tool].part_name(capsule)
    }

    /// Whether anything can be cut or tear.
    pub fn has_cuts(&self) -> bool {
        self.uncut.is_some()
    }

    /// Acceleration of gravity \[m/s²\].
    pub fn gravity(&self) -> Vector3<f64> {
        self.gravity
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
