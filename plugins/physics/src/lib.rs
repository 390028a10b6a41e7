//! Tissue: a thin adapter over the crate `scene`. Bodies, materials, clamps, contact pairs and the method come from the
//! level; tools come as tracked poses once per tick, and the scene moves them in sub-steps.

#![forbid(unsafe_code)]

use fields::Shown;
use microsim_scene::{
    ContactPartner, ContactReport, CutReport, Executor, LevelParts, PartReport, Pose, RegionReport,
    Scene, SolverReport, ToolMotion, largest_stretches, level_spec,
};
use microsim_sdk::message::{
    self, ContactForce, ContactForces, PartForce, PathPoints, RegionForce, SolverTick,
    TISSUE_ELEMENTS, TISSUE_FIELDS, TISSUE_REST, TISSUE_SNAPSHOT, TissueCut, TissueRecovery,
    ToolPlacement, ToolPlacements, ToolState, ToolStates, ToolStatus, decode_bytes, encode,
};
use microsim_sdk::{
    BlockBuilder, Fault, LogLevel, Parallel, Plugin, Services, Setup, Tick, export_plugin,
};
use microsim_settings::PhysicsConfig;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::Path;

/// Pose and opening of a tool at the end of the last tick, while it is tracked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Place {
    #[serde(flatten)]
    pose: message::Pose,
    opening: f64,
}

impl Place {
    fn pose(&self) -> Pose {
        Pose::from_arrays(self.pose.position, self.pose.orientation)
    }
}

/// What evolves here besides the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Memory {
    /// Last place of each tool; `None` while it is not tracked: it then touches nothing.
    places: Vec<Option<Place>>,
    /// Whether the last tick had contacts.
    touching: bool,
}

/// The physics of a run.
#[derive(Debug, Default)]
pub struct Physics {
    scene: Option<Scene>,
    memory: Memory,
    parallel: Parallel,
    /// Whether what is known of elements is published.
    elements: bool,
    /// What pictures of the computation need beside the scene.
    shown: Shown,
}

mod fields;

struct HostExecutor(Parallel);

impl Executor for HostExecutor {
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        self.0.for_each(parts, body);
    }
}

impl Physics {
    fn scene(&mut self) -> Result<&mut Scene, Fault> {
        self.scene
            .as_mut()
            .ok_or_else(|| Fault::new("not initialised"))
    }

    /// The motion of each tracked tool in this tick. A tool that has just come into view stands where it is: it does
    /// not sweep through the tissue from where it was lost.
    fn motions(&mut self, tools: &[ToolState]) -> Vec<ToolMotion> {
        let mut motions = Vec::new();
        self.memory.places.resize(tools.len(), None);
        for (tool, (state, last)) in tools.iter().zip(&mut self.memory.places).enumerate() {
            let now = (state.status == ToolStatus::Tracked).then_some(Place {
                pose: state.pose,
                opening: state.opening,
            });
            if let Some(now) = now {
                let from = last.unwrap_or(now);
                motions.push(ToolMotion {
                    tool,
                    from: from.pose(),
                    to: now.pose(),
                    opening_from: from.opening,
                    opening_to: now.opening,
                    active: true,
                });
            }
            *last = now;
        }
        motions
    }

    /// The bodies at rest, before anything has moved.
    fn publish_rest(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        for body in self.scene()?.bodies() {
            let positions = body.rest_positions().iter().flat_map(|p| [p.x, p.y, p.z]);
            let triangles = body.surface().triangles.iter().flatten().copied();
            let block = BlockBuilder::new(TISSUE_REST, body.name(), body.generation(), 0)
                .u32s("node_id", body.node_ids().iter().copied())
                .f64s("position", positions)
                .u32s("triangle", triangles);
            tick.publish_block(block.finish());
        }
        Ok(())
    }

    fn publish_bodies(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let time = tick.time_ns();
        let scene = self.scene()?;
        for body in 0..scene.body_count() {
            let positions = scene
                .body(body)
                .positions()
                .iter()
                .flat_map(|p| [p.x, p.y, p.z]);
            let triangles = scene
                .body(body)
                .surface()
                .triangles
                .iter()
                .flatten()
                .copied();
            let inner = scene
                .body(body)
                .opened()
                .iter()
                .map(|inner| u32::from(*inner));
            let block = BlockBuilder::new(
                TISSUE_SNAPSHOT,
                scene.body(body).name(),
                scene.body(body).generation(),
                time,
            )
            .u32s("node_id", scene.body(body).node_ids().iter().copied())
            .f64s("position", positions)
            .u32s("piece", scene.body(body).pieces().iter().copied())
            .u32s("triangle", triangles)
            .u32s("inner", inner);
            tick.publish_block(block.finish());
        }
        if self.elements {
            self.publish_elements(tick)?;
        }
        Ok(())
    }

    /// What is known of the elements of bodies beside their snapshots.
    fn publish_elements(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let time = tick.time_ns();
        for body in self.scene()?.bodies() {
            let mesh = body.mesh();
            let rest = body.rest_positions().iter().flat_map(|p| [p.x, p.y, p.z]);
            let volumes = body.model().rest_volumes().iter().copied();
            let stretches = largest_stretches(mesh, body.positions());
            let block = BlockBuilder::new(TISSUE_ELEMENTS, body.name(), body.generation(), time)
                .f64s("rest", rest)
                .u32s("triangle_region", body.triangle_regions())
                .u32s("region", mesh.regions.iter().copied())
                .f64s("volume", volumes)
                .f64s("stretch", stretches);
            tick.publish_block(block.finish());
        }
        Ok(())
    }
}

/// A contact as a message.
fn contact_force(scene: &Scene, contact: &ContactReport) -> ContactForce {
    let with = match contact.with {
        ContactPartner::Itself => scene.body(contact.body).name(),
        other => scene.partner_name(other),
    };
    ContactForce {
        partner: with.into(),
        body: scene.body(contact.body).name().into(),
        force: contact.force_on_tissue,
        peak_force: contact.peak_force_n,
        impulse: contact.impulse_ns,
        point: contact.point,
        depth: contact.max_depth_m,
        indentation: contact.indentation_m,
        time_over_limit: contact.over_limit_s,
        sticking_fraction: contact.stick_fraction,
        grip_force: contact.grip_n,
        sustained_force: contact.sustained_force_n,
        sustained_grip: contact.sustained_grip_n,
        parts: contact
            .parts
            .iter()
            .map(|part| part_force(scene, contact.with, part))
            .collect(),
        regions: contact.regions.iter().map(region_force).collect(),
        pieces: contact.pieces.clone(),
    }
}

/// What a part of a tool does, as a message.
fn part_force(scene: &Scene, with: ContactPartner, part: &PartReport) -> PartForce {
    let name = match with {
        ContactPartner::Tool(tool) => scene.part_name(tool, part.capsule),
        _ => "",
    };
    PartForce {
        part: name.into(),
        force: part.force_on_tissue,
        normal_force: part.normal_force_n,
        point: part.point,
        nodes: part.nodes as u32,
    }
}

/// What acts on a region of a body, as a message.
fn region_force(region: &RegionReport) -> RegionForce {
    RegionForce {
        region: region.region,
        force: region.force_on_tissue,
        normal_force: region.normal_force_n,
        point: region.point,
    }
}

/// The message of a cut.
fn tissue_cut(scene: &Scene, cut: &CutReport) -> TissueCut {
    TissueCut {
        body: scene.body(cut.body).name().to_owned(),
        tool: cut
            .tool
            .map_or_else(String::new, |tool| scene.tool_name(tool).to_owned()),
        area: cut.area,
        centroid: cut.centroid,
        normal: cut.normal,
        rest_centroid: cut.rest_centroid,
        rest_normal: cut.rest_normal,
        points: PathPoints {
            count: cut.points.count,
            sum: cut.points.sum.into(),
            products: cut.points.products,
        },
        valid: cut.valid,
        force: cut.force_n,
        pieces: cut.pieces.clone(),
    }
}

/// The solver's report as a message.
fn solver_tick(report: &SolverReport, repetitions: u32, ruptured: u32, valid: bool) -> SolverTick {
    SolverTick {
        tools_stood: false,
        over_budget: false,
        tool_contacts: 0,
        steps: report.steps,
        unconverged: report.unconverged,
        iterations: report.iterations,
        residual: report.residual,
        force_residual: report.force_residual,
        contact_residual: report.contact_residual,
        backtracks: report.backtracks,
        contact_failures: report.contact_failures,
        repetitions,
        ruptured,
        valid,
    }
}

impl Plugin for Physics {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, services: Services) -> Result<(), Fault> {
        let config: PhysicsConfig = setup.configuration()?;
        let mut contacts = config.contacts.clone();
        if !config.friction {
            contacts.iter_mut().for_each(|pair| pair.friction = 0.0);
        }
        let level = LevelParts {
            physics: &config.physics,
            method: &config.method,
            bodies: &config.bodies,
            rigid: &config.rigid,
            contacts: &contacts,
            cuts: if config.cutting { &config.cuts } else { &[] },
            tools: &config.tools,
            models: &config.models,
        };
        // The host hands over the mesh files that bodies name.
        let mut load = |path: &Path| {
            let name = path.to_string_lossy();
            let file = setup.files.iter().find(|file| file.name == name);
            let file = file.ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))?;
            Ok(file.bytes.clone())
        };
        let described = level_spec(&level, &mut load);
        let mut spec = described
            .map_err(|error| Fault::new(error.to_string()))?
            .spec;
        if !config.cutting {
            let bodies = spec.bodies.iter_mut();
            bodies.for_each(|body| body.tear_strains.clear());
        }
        self.shown = Shown::new(&spec);
        let scene = Scene::new(&spec).map_err(|error| Fault::new(error.to_string()))?;
        let checked = scene.check_step(setup.tick_ns as f64 * 1e-9, setup.steps);
        checked.map_err(|error| Fault::new(error.to_string()))?;
        self.scene = Some(scene);
        self.parallel = services.parallel;
        self.elements = config.elements;
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        self.memory = Memory::default();
        self.shown.forget();
        self.scene()?.reset();
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        if tick.index() == 0 {
            self.publish_rest(tick)?;
        }
        let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
        let motions = self.motions(&tools);
        let executor = HostExecutor(self.parallel);
        let (length, steps) = (tick.length(), tick.steps());
        let scene = self.scene.as_mut();
        let scene = scene.ok_or_else(|| Fault::new("not initialised"))?;
        let report = scene.tick(&motions, length, steps, &executor);
        self.shown.take(&report);
        let report = match report {
            Ok(report) => report,
            // The scene stands at its last good state; the trainee sees tissue that does not move for a tick, and the
            // report shows it.
            Err(diverged) => {
                tick.log(LogLevel::Error, diverged.to_string());
                tick.publish(&TissueRecovery {
                    body: diverged.body_name.clone(),
                    cause: format!(
                        "{}; held at its last good state for this tick",
                        diverged.what
                    ),
                    substeps: 0,
                });
                tick.publish(&solver_tick(
                    &SolverReport::default(),
                    diverged.repetitions,
                    diverged.ruptured,
                    false,
                ));
                for cut in &diverged.cuts {
                    tick.publish(&tissue_cut(scene, cut));
                }
                return self.publish_bodies(tick);
            }
        };
        tick.publish(&SolverTick {
            tools_stood: report.stands,
            over_budget: report.over_budget,
            tool_contacts: report.touching.len() as u32,
            ..solver_tick(
                &report.solver,
                report.repetitions,
                report.ruptured,
                report.valid,
            )
        });
        let mut invalid = Vec::new();
        let mut forces = ContactForces::default();
        for contact in &report.contacts {
            let list = match contact.with {
                ContactPartner::Tool(_) => &mut forces.contacts,
                _ => &mut forces.between,
            };
            list.push(contact_force(scene, contact));
        }
        for cut in &report.cuts {
            tick.publish(&tissue_cut(scene, cut));
        }
        for cut in &report.rejected {
            let (body, tool) = (scene.body(cut.body).name(), scene.tool_name(cut.tool));
            tick.log(
                LogLevel::Warn,
                format!("body \"{body}\", tool \"{tool}\": {}", cut.why),
            );
        }
        for motion in &report.invalid_motions {
            invalid.push(motions[*motion].tool);
            let tool = &tools[motions[*motion].tool].tool;
            tick.log(
                LogLevel::Warn,
                format!("tool \"{tool}\" has no valid pose and touches nothing in this tick"),
            );
        }
        for recovery in &report.recoveries {
            let body = scene.body(recovery.body).name().to_owned();
            tick.publish(&TissueRecovery {
                body,
                cause: recovery.what.to_string(),
                substeps: steps * report.substeps * recovery.factor,
            });
        }
        if report.many_substeps {
            let text = format!(
                "a tool moved so fast that each solver step was divided into {}",
                report.substeps
            );
            tick.log(LogLevel::Warn, text);
        }
        for tool in &report.jumped {
            let text = format!(
                "tool \"{}\" jumped: it was not guided through the tissue between its poses",
                scene.tool_name(*tool)
            );
            tick.log(LogLevel::Warn, text);
        }
        let placed = scene.placed_tools();
        if !placed.is_empty() {
            let placed = placed
                .into_iter()
                .map(|(tool, pose, opening)| ToolPlacement {
                    tool: scene.tool_name(tool).to_owned(),
                    pose: message::Pose {
                        position: pose.position.into(),
                        orientation: pose.orientation.coords.into(),
                    },
                    opening,
                });
            tick.publish(&ToolPlacements {
                tick: tick.index(),
                tools: placed.collect(),
            });
        }
        let touching = !(forces.contacts.is_empty() && forces.between.is_empty());
        if touching || self.memory.touching {
            tick.publish(&forces);
        }
        self.memory.touching = touching;
        // The next valid pose must not be reached from one that is none.
        for tool in invalid {
            self.memory.places[tool] = None;
        }
        self.publish_bodies(tick)
    }

    fn save(&self) -> Vec<u8> {
        encode(&(
            &self.memory,
            serde_bytes::ByteBuf::from(self.scene.as_ref().map(Scene::save).unwrap_or_default()),
        ))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let (memory, scene): (Memory, serde_bytes::ByteBuf) = decode_bytes(state)?;
        self.shown.forget();
        let restored = self.scene()?.restore(&scene);
        restored.map_err(|error| Fault::new(error.to_string()))?;
        self.memory = memory;
        Ok(())
    }

    fn extension(&mut self, name: &str, _request: &[u8]) -> Result<Option<Vec<u8>>, Fault> {
        let Some(scene) = &self.scene else {
            return Ok(None);
        };
        Ok(match name {
            "state.digest" => Some(scene.digest().to_vec()),
            TISSUE_FIELDS => Some(encode(&self.shown.blocks(scene))),
            _ => None,
        })
    }
}

export_plugin!(Physics, "../plugin.toml");

#[cfg(test)]
mod tests;
