//! Cutting: paths of blades through bodies become edits of meshes, after which all that depends on a mesh is updated.
//!
//! What is here: when the edits of a tick are made (after it was accepted, or before it is computed again from its start, so that none is ever undone), what is updated after an edit and in
//! which order. What is not: which line cuts (`lonor`), how elements are divided (crate `cutting`), how elements of a model are updated (crate `tissue`).

use crate::body::Body;
use crate::cut_pairs::CutPair;
use crate::cut_report::{CutReport, RejectedCut};
use crate::edits::{Edit, renumbering};
use crate::lonor::{BladeState, Case, EdgeLoads, Path};
use crate::member::Member;
use crate::report::{ContactPartner, ContactReport};
use crate::scene::Scene;
use crate::spec::CutTrigger;
use crate::surface_edits::SurfaceDiff;
use crate::tear::Shreds;
use crate::tool::{Lonor, ToolMotion};
use microsim_cutting::{self as cutting, Blade, Sweep, TopologyChange};
use microsim_geometry::{
    Aabb, closest_on_segment, closest_segment_triangle, edge_through_triangle, point_in_tetrahedron,
};
use microsim_mesh::TopologyEdit;
use microsim_tissue::State;
use nalgebra::Vector3;
use std::collections::BTreeMap;

impl Scene {
    /// The single edges that touch what they can cut, as they are at the end of the tick, each with its tool.
    pub(crate) fn edges(&self, motions: &[ToolMotion]) -> Vec<(u32, Lonor)> {
        let mut edges = Vec::new();
        for motion in motions {
            let touching =
                |cut: &CutPair| cut.tool == motion.tool && cut.ability.line_force.is_finite();
            if self.cuts.iter().any(touching) {
                let lines = self.tools[motion.tool].lines(motion, 1.0);
                let single = lines.into_iter().filter(|line| line.edge.is_some());
                edges.extend(single.map(|line| (motion.tool as u32, line)));
            }
        }
        edges
    }

    /// Exempts parts of tools from contact that are in what they cut.
    pub(crate) fn exempt_blades(&mut self, motions: &[ToolMotion]) {
        if self.cuts.is_empty() {
            return;
        }
        let mut exemptions = vec![Vec::new(); self.groups.len()];
        for (cut, blade) in self.cuts.iter().zip(&self.state.blades) {
            let (group, place) = self.place_of(cut.body);
            if let Some(motion) = motions.iter().find(|motion| motion.tool == cut.tool) {
                let lines = self.tools[cut.tool].lines(motion, 1.0);
                exemptions[group].extend(blade.exemptions(place, cut.tool as u32, &lines));
            }
        }
        for (group, exemptions) in self.groups.iter_mut().zip(exemptions) {
            if let Some(contact) = &mut group.contact {
                contact.exemptions = exemptions;
            }
        }
    }

    /// The group of a body and its place in it.
    pub(crate) fn place_of(&self, body: usize) -> (usize, u32) {
        let places = self.groups.iter().enumerate().find_map(|(index, group)| {
            let place = group
                .members
                .iter()
                .position(|member| member.body == body)?;
            Some((index, place as u32))
        });
        places.expect("each body is in a group")
    }

    /// Makes the cuts of a tick that moved bodies from `start` to where they are now.
    pub(crate) fn cut(
        &mut self,
        motions: &[ToolMotion],
        start: &[State],
        loads: &EdgeLoads,
        contacts: &[ContactReport],
        tick: f64,
        valid: bool,
    ) -> (Vec<CutReport>, Vec<RejectedCut>) {
        let _span = tracing::debug_span!("cutting").entered();
        let (mut reports, mut rejected) = (Vec::new(), Vec::new());
        let mut before: Vec<Option<Vec<Vector3<f64>>>> = vec![None; self.bodies.len()];
        for index in 0..self.cuts.len() {
            let CutPair {
                body,
                tool,
                ability,
                ..
            } = self.cuts[index].clone();
            let mut sum = Sum::default();
            let Some(motion) = motions.iter().find(|motion| motion.tool == tool) else {
                // A tool that is away is out of the tissue.
                let lines = self.state.blades[index].lines();
                self.conclude(index, body, &lines, start, &mut before, &mut sum);
                reports.extend(sum.report(body, Some(tool), 0.0));
                self.state.blades[index] = BladeState::default();
                continue;
            };
            self.update_surfaces();
            let inside = self.state.blades[index].inside.clone();
            let reaching = self.reaching(body, motion, &inside);
            let case = Case {
                tool: &self.tools[tool],
                motion,
                at: self.place_of(body),
                ability,
                edge: self.bodies[body].model.mean_edge_length(),
                tick,
                loads,
                reach: &reaching,
            };
            let paths = self.state.blades[index].decide(&case);
            let at_start = before[body].get_or_insert_with(|| start[body].positions.clone());
            let mut before_now = std::mem::take(at_start);
            for path in paths {
                match self.sweep(index, body, &path, &mut before_now, tick, valid) {
                    Ok(Some(cut)) => sum.add(cut),
                    Ok(None) => {}
                    Err(why) => {
                        self.state.blades[index].revert(path);
                        self.bodies[body].tally.rejected += 1;
                        rejected.push(RejectedCut {
                            body,
                            tool,
                            why: why.to_string(),
                        });
                    }
                }
            }
            before[body] = Some(before_now);
            let leaving = self.state.blades[index].leaving.clone();
            self.conclude(index, body, &leaving, start, &mut before, &mut sum);
            self.state.blades[index].leave();
            let force = contacts
                .iter()
                .find(|contact| (contact.body, contact.with) == (body, ContactPartner::Tool(tool)));
            let force = force.map_or(0.0, |contact| Vector3::from(contact.force_on_tissue).norm());
            reports.extend(sum.report(body, Some(tool), force));
        }
        self.update_surfaces();
        (reports, rejected)
    }

    /// Makes what is stretched too far come apart, after a valid tick.
    pub(crate) fn tear_bodies(&mut self, torn: &mut TornBodies) {
        for body in 0..self.bodies.len() {
            if let Some(made) = self.tear(body) {
                torn.0.entry(body).or_default().add(made);
            }
        }
        self.update_surfaces();
    }

    /// Takes shreds away, by their bodies, so that the tick can be computed again without them.
    pub(crate) fn rupture(&mut self, shreds: &[(usize, Shreds)], torn: &mut TornBodies) {
        for (body, shreds) in shreds {
            if let Some(made) = self.come_apart(*body, &[], shreds) {
                torn.0.entry(*body).or_default().add(made);
            }
        }
        self.update_surfaces();
    }

    /// The capsules among `edges` that still reach into a body at the end of a motion.
    pub(crate) fn reaching(&mut self, body: usize, motion: &ToolMotion, edges: &[u32]) -> Vec<u32> {
        let positions = &self.state.bodies[body].positions;
        let Some(topology) = &mut self.bodies[body].topology else {
            return Vec::new();
        };
        let at = |node: u32| positions[node as usize];
        let mut lines = self.tools[motion.tool].lines(motion, 1.0);
        lines.retain(|line| {
            if !edges.contains(&line.capsule) {
                return false;
            }
            let bounds = Aabb::of(&[line.a, line.b]).inflated(line.radius);
            let mut near = Vec::new();
            let now = &positions[..];
            topology.elements_near(&bounds, [now, now], |element, tet| {
                near.push((element, *tet))
            });
            let reaches = |&(element, tet): &(u32, [u32; 4])| {
                let touches = topology.triangles_of(element).any(|triangle| {
                    let closest =
                        closest_segment_triangle(&line.a, &line.b, &triangle.nodes.map(at));
                    closest.distance() < line.radius
                });
                touches || is_within(&tet.map(at), [line.a, line.b])
            };
            near.iter().any(reaches)
        });
        lines.iter().map(|line| line.capsule).collect()
    }

    /// Moves a blade along its path through a body; `before` are the positions of its nodes before the tick of so many seconds, which may be `valid`.
    fn sweep(
        &mut self,
        cut: usize,
        body: usize,
        path: &Path,
        before: &mut Vec<Vector3<f64>>,
        tick: f64,
        valid: bool,
    ) -> Result<Option<(cutting::Cut, Vec<u32>)>, cutting::Rejected> {
        let Body { mesh, topology, .. } = &mut self.bodies[body];
        let Some(topology) = topology else {
            return Ok(None);
        };
        let stroke = self.state.blades[cut].stroke(path.line);
        let blade = Blade::Sweep {
            sweeps: &path.sweeps,
            before,
            now: &self.state.bodies[body].positions,
        };
        let points = stroke.points;
        let CutPair { ability, .. } = &self.cuts[cut];
        if ability.trigger == CutTrigger::Penetration && path.closed.is_none() {
            let crossed = topology.crossed(&blade)?;
            if returns(&crossed, &path.sweeps, &self.state.bodies[body], tick) {
                return Ok(None);
            }
        }
        let settings = settings_of(&self.cuts[cut]);
        let made = topology.cut(mesh, stroke, &blade, &settings)?;
        if !valid && stroke.points != cutting::PathPoints::default() {
            // Where the tissue was in such a tick means nothing.
            stroke.points = points;
        }
        let Some(made) = made else {
            return Ok(None);
        };
        made.edit.carry_nodes(before);
        self.update_strokes(body, Some((cut, path.line)), &made.edit);
        let pieces = self.apply_cut(body, &made);
        Ok(Some((made, pieces)))
    }

    /// Cuts what waits in strokes of these lines, which have left the tissue.
    fn conclude(
        &mut self,
        cut: usize,
        body: usize,
        lines: &[u32],
        start: &[State],
        before: &mut [Option<Vec<Vector3<f64>>>],
        sum: &mut Sum,
    ) {
        let settings = settings_of(&self.cuts[cut]);
        if settings.change != TopologyChange::SemiProgressive {
            return;
        }
        for &line in lines {
            let Body { mesh, topology, .. } = &mut self.bodies[body];
            let Some(topology) = topology else {
                return;
            };
            let stroke = self.state.blades[cut].stroke(line);
            let now = &self.state.bodies[body].positions;
            let Some(made) = topology.conclude_stroke(mesh, stroke, now, &settings) else {
                continue;
            };
            let before = before[body].get_or_insert_with(|| start[body].positions.clone());
            made.edit.carry_nodes(before);
            self.update_strokes(body, Some((cut, line)), &made.edit);
            let pieces = self.apply_cut(body, &made);
            sum.add((made, pieces));
        }
    }

    /// Updates the other strokes in progress in a body after an edit that one of them (cut and line) has made, before the body is updated.
    pub(crate) fn update_strokes(
        &mut self,
        body: usize,
        own: Option<(usize, u32)>,
        edit: &TopologyEdit,
    ) {
        let mesh = &self.bodies[body].mesh;
        let nodes = mesh.positions.len();
        for (cut, blade) in self.state.blades.iter_mut().enumerate() {
            if self.cuts[cut].body != body {
                continue;
            }
            let others = blade.strokes.iter_mut();
            for (_, stroke) in others.filter(|(line, _)| Some((cut, *line)) != own) {
                stroke.update_after_edit(edit, nodes);
            }
        }
    }

    /// Makes a cut that the topology of its body has made already; returns the numbers of the pieces that came off. Surfaces, and what is
    /// advanced together, are updated once for all edits.
    pub(crate) fn apply_cut(&mut self, body: usize, made: &cutting::Cut) -> Vec<u32> {
        let old = self.bodies[body].mesh.positions.len();
        let internal = &self.state.bodies[body].internal;
        let model = &mut self.bodies[body].model;
        // A tick that is computed again has left it elsewhere.
        model.relocate(internal);
        let places = model.places(internal);
        let change = self.bodies[body].update_after_edit(&made.edit, &self.method);
        let change = change.expect("the edit was made for this mesh, of which the model is");
        self.state.bodies[body].edit(&change);
        let of = &mut self.bodies[body];
        let surface_edits = of.surface_edits.get_or_insert_default();
        surface_edits.add(&made.surface, &change.touched);
        let pieces = of.pieces.number(&made.pieces, &of.mesh.tets);
        of.tally.divided += made.divided as u64;
        of.tally.lost_volume += made.lost_volume;
        of.tally.merged += made.merged as u64;
        self.edits.push(Edit {
            body,
            nodes: old,
            places,
            edit: made.edit.clone(),
        });
        self.renumber_contact(body, &made.edit, old);
        pieces
    }

    /// Gives the contact state of a body whose mesh has changed the numbers of now.
    fn renumber_contact(&mut self, body: usize, edit: &TopologyEdit, old: usize) {
        let (group, place) = self.place_of(body);
        let first = self.groups[group].members[place as usize].first_node as u32;
        let new = self.bodies[body].mesh.positions.len() as u32;
        let end = first + old as u32;
        let number = renumbering(edit, old);
        self.state.contacts[group].renumber(|node| match node {
            node if node < first => Some(node),
            node if node < end => number(node - first).map(|node| node + first),
            node => Some(node - end + first + new),
        });
        self.groups[group].renumber(&self.bodies);
    }

    /// Brings surfaces to where the edits since the last time have brought the meshes, and what is made of them: solvers, contact.
    pub(crate) fn update_surfaces(&mut self) {
        let surface_diffs = self.bodies.iter_mut().map(Body::update_surface);
        let surface_diffs: Vec<Option<SurfaceDiff>> = surface_diffs.collect();
        for group in &mut self.groups {
            let changed = |member: &Member| surface_diffs[member.body].is_some();
            if group.members.iter().any(changed) {
                group.update_after_edit(&self.bodies, &surface_diffs);
            }
        }
    }
}

/// What tore in a tick, by body.
#[derive(Debug, Default)]
pub(crate) struct TornBodies(BTreeMap<usize, Sum>);

impl TornBodies {
    /// One report per body.
    pub fn reports(self) -> Vec<CutReport> {
        let bodies = self.0.into_iter();
        bodies
            .filter_map(|(body, sum)| sum.report(body, None, 0.0))
            .collect()
    }
}

/// Whether tissue that has passed a line in a tick \[s\] moves back towards it at the end, on the mean over where edges, with a fraction each, crossed the line (dissertation
/// 4.4.3, case 2: the velocities point to the line).
fn returns(crossed: &[([u32; 2], f64)], sweeps: &[Sweep], now: &State, tick: f64) -> bool {
    let away = |([a, b], fraction): &([u32; 2], f64)| {
        let of =
            |values: &[Vector3<f64>]| values[*a as usize].lerp(&values[*b as usize], *fraction);
        let (place, velocity) = (of(&now.positions), of(&now.velocities));
        let nearest = sweeps.iter().map(|sweep| {
            let [from, to] = &sweep.now;
            let point = closest_on_segment(&place, from, to).point;
            let length = (to - from).norm_squared();
            let along = if length > 0.0 {
                (point - from).dot(&(to - from)) / length
            } else {
                0.0
            };
            let ends = [0, 1].map(|end| (sweep.now[end] - sweep.before[end]) / tick);
            let of_line = ends[0].lerp(&ends[1], along);
            (place - point, velocity - of_line)
        });
        let nearest = nearest.min_by(|one, other| one.0.norm().total_cmp(&other.0.norm()));
        nearest.map_or(0.0, |(away, velocity)| away.dot(&velocity))
    };
    crossed.iter().map(away).sum::<f64>() < 0.0
}

/// How the mesh of a body is cut by a tool.
fn settings_of(cut: &CutPair) -> cutting::Settings {
    cutting::Settings {
        change: cut.topology,
        ..cutting::Settings::default()
    }
}

/// Whether a segment goes through an element, or begins in it.
fn is_within(corners: &[Vector3<f64>; 4], segment: [Vector3<f64>; 2]) -> bool {
    let through = |face: [usize; 3]| {
        edge_through_triangle(&segment[0], &segment[1], &face.map(|k| corners[k])).is_some()
    };
    point_in_tetrahedron(&segment[0], corners).is_some()
        || [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
            .into_iter()
            .any(through)
}

/// The cuts of a tool through a body in a tick, summed up.
#[derive(Clone, Debug, Default)]
struct Sum {
    divided: usize,
    area: f64,
    now: f64,
    /// Area times centroid, and times normal: at rest and now.
    centroids: [Vector3<f64>; 2],
    normals: [Vector3<f64>; 2],
    points: cutting::PathPoints,
    pieces: Vec<u32>,
}

impl Sum {
    fn add(&mut self, (cut, pieces): (cutting::Cut, Vec<u32>)) {
        self.divided += cut.divided;
        let [rest, now] = cut.opened;
        self.area += rest.area;
        self.now += now.area;
        for (k, opened) in [rest, now].iter().enumerate() {
            self.centroids[k] += opened.centroid * opened.area;
            // One blade may come from either side.
            let turned = self.normals[k].dot(&opened.normal) < 0.0;
            let normal = if turned {
                -opened.normal
            } else {
                opened.normal
            };
            self.normals[k] += normal * opened.area;
        }
        self.points.merge(&cut.points);
        self.pieces.extend(pieces);
    }

    /// `None` where elements were divided at most, and nothing was laid open.
    fn report(self, body: usize, tool: Option<usize>, force_n: f64) -> Option<CutReport> {
        let mean = |sum: Vector3<f64>, area: f64| if area > 0.0 { sum / area } else { sum };
        let unit = |v: Vector3<f64>| v.try_normalize(0.0).unwrap_or_default();
        let opened = self.area > 0.0 || !self.pieces.is_empty();
        opened.then(|| CutReport {
            body,
            tool,
            divided: self.divided,
            area: self.area,
            rest_centroid: mean(self.centroids[0], self.area).into(),
            rest_normal: unit(self.normals[0]).into(),
            valid: true,
            points: self.points,
            centroid: mean(self.centroids[1], self.now).into(),
            normal: unit(self.normals[1]).into(),
            force_n,
            pieces: self.pieces,
        })
    }
}
