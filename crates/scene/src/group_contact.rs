//! From points of contact to contact constraints of a solver: friction, forces of the last step, how much of an old overlap is undone.

use crate::body::Body;
use crate::box_grip::BoxGrip;
use crate::exemption::Exemption;
use crate::jump::{JumpWatch, StepForces};
use crate::member::Member;
use crate::pairs::{Pair, PairPartner};
use crate::surface_edits::SurfaceDiff;
use microsim_contact::{
    BroadPhaseMethod, CapsuleMotion, ContactPair, ContactSurface, Detector, Frame, Key,
    ObstaclePart, Partner, Point, Sides, SurfaceUpdate, VesselEnd,
};
use microsim_tissue::{Contact, ContactSource, Method, Response, TissueModel};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// At most this fraction of the mean edge length of an old overlap is undone in one step (NUMERICS 2.7).
const OVERLAP_PER_STEP: f64 = 0.2;

/// Points within this fraction of the mean edge length are given to the solver before they touch, for the nodes that it moves.
const REACH_EXPLICIT: f64 = 0.1;
const REACH_IMPLICIT: f64 = 0.3;

/// Contact state of one group, carried from step to step.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ContactState {
    /// Which side of tools and obstacles nodes are on.
    pub sides: Sides,
    /// The forces that the last step ended with, ascending by key; those that are zero are left out.
    pub forces: Vec<ContactForce>,
}

/// The force of a point of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactForce {
    pub key: Key,
    /// Along the normal \[N\].
    pub normal_force: f64,
    /// Across it \[N\].
    pub friction_force: Vector3<f64>,
}

impl ContactState {
    /// Nothing is touched.
    pub fn clear(&mut self) {
        self.sides = Sides::new();
        self.forces.clear();
    }

    fn find(&self, key: &Key) -> Option<&ContactForce> {
        let place = self.forces.binary_search_by_key(key, |force| force.key);
        place.ok().map(|place| &self.forces[place])
    }

    /// Stores what a step ended with.
    fn store(&mut self, points: &[Point], contacts: &[Contact]) {
        let touched = |contact: &Contact| contact.normal_force > 0.0;
        self.forces.clear();
        let both = || points.iter().zip(contacts);
        let acting = both().filter(|(_, contact)| touched(contact));
        self.forces
            .extend(acting.map(|(point, contact)| ContactForce {
                key: point.key,
                normal_force: contact.normal_force,
                friction_force: contact.friction_force,
            }));
        // The normals of points that are still apart count as well.
        self.sides.remember(points);
    }

    /// Gives nodes other numbers; entries of nodes without a number are removed.
    pub fn renumber(&mut self, number: impl Fn(u32) -> Option<u32>) {
        const UNUSED: u32 = u32::MAX;
        let of = |node: u32| match node {
            UNUSED => Some(UNUSED),
            node => number(node),
        };
        let forces = self.forces.drain(..).filter_map(|mut force| {
            for node in &mut force.key.first {
                *node = of(*node)?;
            }
            force.key.first.sort_unstable();
            if matches!(force.key.partner, Partner::Body { .. }) {
                for node in &mut force.key.second {
                    *node = of(*node)?;
                }
                force.key.second.sort_unstable();
            }
            Some(force)
        });
        let mut forces: Vec<ContactForce> = forces.collect();
        forces.sort_unstable_by_key(|force| force.key);
        self.forces = forces;
        let entries = self.sides.entries().iter();
        let entries =
            entries.filter_map(|(partner, node, normal)| Some((*partner, of(*node)?, *normal)));
        self.sides = Sides::from_entries(entries.collect());
    }

    /// The nodes at which something touches or is about to.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        let keys = self.forces.iter().map(|force| &force.key);
        let of_keys = keys.flat_map(|key| {
            let second = match key.partner {
                Partner::Body { .. } => &key.second[..],
                _ => &[],
            };
            key.first.iter().chain(second)
        });
        let beside = self.sides.entries().iter().map(|(_, node, _)| node);
        of_keys.chain(beside).copied()
    }

    /// Removes the entries of a tool that has jumped: from its new position it pushes to the nearest side.
    pub fn remove_tool(&mut self, tool: u32) {
        let of_tool =
            |partner: &Partner| matches!(partner, Partner::Tool { tool: t, .. } if *t == tool);
        self.forces.retain(|force| !of_tool(&force.key.partner));
        let entries = self.sides.entries().iter();
        let others = entries.filter(|(partner, _, _)| !of_tool(partner));
        self.sides = Sides::from_entries(others.copied().collect());
    }
}

/// Contact of a group: its detector and working memory.
#[derive(Clone, Debug)]
pub(crate) struct GroupContact {
    detector: Detector,
    /// The pair that a point belongs to, by the body of its first side and its partner (of a tool without the capsule), and
    /// whether the first side is the pair's body.
    pair_of: BTreeMap<(u32, Partner), (usize, bool)>,
    /// The pairs of bodies that touch end to end.
    end_to_end: Vec<[u32; 2]>,
    /// Friction and response of each pair of the scene.
    laws: Vec<(f64, Response)>,
    /// Of each pair of the scene that is with a tool in motion.
    pub jump_watches: Vec<Option<JumpWatch>>,
    /// Whether tools go on within the motion of the step before.
    pub moves_on: bool,
    /// The tools that touch anything here.
    tools: Vec<usize>,
    /// Whether only tools touch anything here.
    tools_only: bool,
    reach: f64,
    overlap_per_step: f64,
    /// Positions before the step \[m\].
    pub start: Vec<Vector3<f64>>,
    /// The points of the last search.
    pub points: Vec<Point>,
    /// The contacts of these points, as the solver left them.
    pub contacts: Vec<Contact>,
    guesses: Vec<(Key, f64)>,
    /// Parts of tools that touch nothing, as they are in what they cut.
    pub exemptions: Vec<Exemption>,
    /// Jaws that hold bodies by the box between them.
    grips: Vec<BoxGrip>,
}

impl GroupContact {
    /// Of the pairs that concern these bodies; `None` where there is none.
    pub fn new(
        members: &[Member],
        bodies: &[Body],
        pairs: &[Pair],
        obstacles: &[ObstaclePart],
        broad_phase: BroadPhaseMethod,
        method: &Method,
        model: &TissueModel,
    ) -> Option<Self> {
        let member_of = |body: usize| members.iter().position(|member| member.body == body);
        let mut contact_pairs = Vec::new();
        let mut pair_of = BTreeMap::new();
        let mut tools = Vec::new();
        let mut end_to_end = Vec::new();
        let mut grips = Vec::new();
        for (index, pair) in pairs.iter().enumerate() {
            let Some(own) = member_of(pair.body) else {
                continue;
            };
            let body = own as u32;
            match &pair.with {
                PairPartner::Tool(tool) => {
                    let tool = *tool as u32;
                    tools.push(tool as usize);
                    if !pair.grip.is_empty() {
                        let couples = pair.grip.clone();
                        grips.push(BoxGrip {
                            body,
                            tool,
                            couples,
                        });
                    }
                    pair_of.insert((body, Partner::Tool { tool, capsule: 0 }), (index, true));
                    contact_pairs.push(ContactPair::Tool { body, tool });
                }
                PairPartner::Obstacle { parts, .. } => {
                    for part in parts.clone().map(|part| part as u32) {
                        pair_of.insert((body, Partner::Obstacle { part }), (index, true));
                        contact_pairs.push(ContactPair::Obstacle { body, part });
                    }
                }
                PairPartner::Body(other) => {
                    let Some(other) = member_of(*other) else {
                        continue;
                    };
                    let with = other as u32;
                    pair_of.insert((body, Partner::Body { body: with }), (index, true));
                    pair_of.insert((with, Partner::Body { body }), (index, false));
                    let ends = pair.end_planes.then(|| {
                        facing_ends([own, other].map(|m| (&bodies[members[m].body], members[m])))
                    });
                    end_to_end.extend(ends.is_some().then_some([body, with]));
                    contact_pairs.push(ContactPair::Bodies { body, with, ends });
                }
                PairPartner::Itself => {
                    pair_of.insert((body, Partner::Body { body }), (index, true));
                    contact_pairs.push(ContactPair::Itself { body });
                }
            }
        }
        if contact_pairs.is_empty() {
            return None;
        }
        let tools_only = contact_pairs
            .iter()
            .all(|t| matches!(t, ContactPair::Tool { .. }));
        let surfaces = members.iter().enumerate().map(|(place, member)| {
            let Body {
                mesh,
                surface,
                model,
                ..
            } = &bodies[member.body];
            let inside = contact_pairs.iter().any(|touch| match touch {
                ContactPair::Bodies { body, with, .. } => [*body, *with].contains(&(place as u32)),
                ContactPair::Itself { body } => *body == place as u32,
                ContactPair::Tool { .. } | ContactPair::Obstacle { .. } => false,
            });
            let (edge, offset) = (model.mean_edge_length(), member.first_node as u32);
            ContactSurface::of_surface(mesh, surface, edge, offset, inside)
        });
        let surfaces: Vec<ContactSurface> = surfaces.collect();
        let edge = model.mean_edge_length();
        let reach = match method.is_explicit() {
            true => REACH_EXPLICIT,
            false => REACH_IMPLICIT,
        };
        let mut detector = Detector::new(surfaces, obstacles.to_vec(), contact_pairs)
            .with_broad_phase(broad_phase);
        for pair in pairs {
            let other = match pair.with {
                PairPartner::Body(other) => other,
                PairPartner::Itself => pair.body,
                PairPartner::Tool(_) | PairPartner::Obstacle { .. } => continue,
            };
            if let (Some(own), Some(other)) = (member_of(pair.body), member_of(other)) {
                detector.set_detection([own as u32, other as u32], pair.response.detection());
            }
        }
        Some(Self {
            detector,
            pair_of,
            end_to_end,
            jump_watches: Vec::new(),
            moves_on: false,
            laws: pairs
                .iter()
                .map(|pair| (pair.friction, pair.response.of_contact()))
                .collect(),
            tools,
            tools_only,
            reach: reach * edge,
            overlap_per_step: OVERLAP_PER_STEP * edge,
            start: Vec::new(),
            points: Vec::new(),
            contacts: Vec::new(),
            guesses: Vec::new(),
            exemptions: Vec::new(),
            grips,
        })
    }

    /// Updates contact after edits of bodies: the result equals a rebuilt one.
    pub fn update_after_edit(
        &mut self,
        members: &[Member],
        bodies: &[Body],
        surface_diffs: &[Option<SurfaceDiff>],
    ) {
        let first = members
            .iter()
            .position(|member| surface_diffs[member.body].is_some());
        let Some(first) = first else {
            return;
        };
        for (place, member) in members.iter().enumerate().skip(first) {
            let of = &bodies[member.body];
            let elements_at = |node: u32| match &of.topology {
                Some(topology) => topology.elements_at(node),
                None => &[],
            };
            let (removed, added, touched) = match &surface_diffs[member.body] {
                Some(SurfaceDiff {
                    removed,
                    added,
                    touched,
                }) => (&removed[..], &added[..], &touched[..]),
                // Its nodes have other numbers in the group.
                None => Default::default(),
            };
            let change = SurfaceUpdate {
                mesh: &of.mesh,
                surface: &of.surface,
                offset: member.first_node as u32,
                removed,
                added,
                touched,
                elements_at: &elements_at,
            };
            self.detector.update_after_edit(place as u32, &change);
        }
        for &[one, other] in &self.end_to_end {
            let ends = facing_ends([one, other].map(|place| {
                let member = members[place as usize];
                (&bodies[member.body], member)
            }));
            self.detector.set_ends([one, other], ends);
        }
        self.start.clear();
        self.clear();
        self.guesses.clear();
        self.exemptions.clear();
    }

    /// Whether there is anything that could touch.
    pub fn is_active(&self, tools: &[Option<Vec<CapsuleMotion>>]) -> bool {
        !self.tools_only || self.tools.iter().any(|&tool| tools[tool].is_some())
    }

    /// Nothing is touched.
    pub fn clear(&mut self) {
        self.points.clear();
        self.contacts.clear();
    }

    /// The nodes that jaws hold by the box between them, and where they bring these by the end of a step from `positions` \[m\].
    pub fn carried(
        &self,
        members: &[Member],
        tools: &[Option<Vec<CapsuleMotion>>],
        state: &ContactState,
        positions: &[Vector3<f64>],
    ) -> Vec<(u32, Vector3<f64>)> {
        let mut carried = Vec::new();
        for grip in &self.grips {
            let Some(motion) = &tools[grip.tool as usize] else {
                continue;
            };
            let place = grip.body as usize;
            let first = members[place].first_node;
            let next = members.get(place + 1);
            let end = next.map_or(positions.len(), |member| member.first_node);
            grip.add(
                &state.sides,
                motion,
                first,
                &positions[first..end],
                &mut carried,
            );
        }
        carried
    }

    /// The pair that a point belongs to, and whether its first side is the pair's body.
    pub fn pair(&self, key: &Key) -> Option<(usize, bool)> {
        self.pair_of.get(&(key.body, whole(key.partner))).copied()
    }

    /// The source of contacts for a step that begins at `start` \[m\].
    pub fn source<'a>(
        &'a mut self,
        start: &[Vector3<f64>],
        tools: &'a [Option<Vec<CapsuleMotion>>],
        state: &'a ContactState,
    ) -> Source<'a> {
        self.start.clear();
        self.start.extend_from_slice(start);
        self.points.clear();
        Source {
            of: self,
            tools,
            state,
        }
    }

    /// Stores what the solver made of the contacts.
    pub fn finish(&mut self, contacts: Vec<Contact>, state: &mut ContactState) {
        assert_eq!(
            contacts.len(),
            self.points.len(),
            "a solver gives back the contacts that it was given last"
        );
        self.contacts = contacts;
        state.store(&self.points, &self.contacts);
    }
}

/// A partner without the part of it.
fn whole(partner: Partner) -> Partner {
    match partner {
        Partner::Tool { tool, .. } => Partner::Tool { tool, capsule: 0 },
        other => other,
    }
}

/// The ends of two vessels that lie nearest to each other at the start, of those of which something is left.
fn facing_ends(both: [(&Body, Member); 2]) -> [VesselEnd; 2] {
    let centres = both.map(|(body, _)| -> Vec<Option<Vector3<f64>>> {
        let ends = body.ends.iter().map(|end| {
            let nodes = end.iter().flatten();
            let sum: Vector3<f64> = nodes.map(|&node| body.start.positions[node as usize]).sum();
            (!end.is_empty()).then(|| sum / (3 * end.len()) as f64)
        });
        ends.collect()
    });
    let mut nearest = (f64::INFINITY, [0; 2]);
    for (i, a) in centres[0].iter().enumerate() {
        for (j, b) in centres[1].iter().enumerate() {
            let (Some(a), Some(b)) = (a, b) else {
                continue;
            };
            let distance = (a - b).norm();
            if distance < nearest.0 {
                nearest = (distance, [i, j]);
            }
        }
    }
    [0, 1].map(|side| {
        let (body, member) = &both[side];
        let shift = member.first_node as u32;
        let triangles = body.ends[nearest.1[side]].iter();
        VesselEnd {
            triangles: triangles.map(|t| t.map(|node| node + shift)).collect(),
        }
    })
}

/// Finds the contacts of one step.
pub(crate) struct Source<'a> {
    of: &'a mut GroupContact,
    tools: &'a [Option<Vec<CapsuleMotion>>],
    state: &'a ContactState,
}

impl ContactSource for Source<'_> {
    fn find(
        &mut self,
        step_fraction: f64,
        positions: &[Vector3<f64>],
        contacts: &mut Vec<Contact>,
    ) {
        let GroupContact {
            detector,
            pair_of,
            laws,
            reach,
            overlap_per_step,
            start,
            points,
            guesses,
            exemptions,
            ..
        } = &mut *self.of;
        guesses.clear();
        let known = points.iter().zip(contacts.iter());
        guesses.extend(known.map(|(point, contact)| (point.key, contact.normal_force)));
        let frame = Frame {
            start,
            now: positions,
            tools: self.tools,
            fraction: step_fraction,
            reach: *reach,
            sides: &self.state.sides,
        };
        let _span = tracing::debug_span!("contact-detection").entered();
        detector.find(&frame, points);
        if !exemptions.is_empty() {
            points.retain(|point| {
                !exemptions
                    .iter()
                    .any(|part| part.covers(point, self.tools, step_fraction))
            });
        }
        contacts.clear();
        contacts.extend(points.iter().map(|point| {
            let remembered = self.state.find(&point.key);
            let guess = guesses.binary_search_by_key(&point.key, |(key, _)| *key);
            let normal_force = match guess {
                Ok(place) => guesses[place].1,
                Err(_) => remembered.map_or(0.0, |force| force.normal_force),
            };
            let friction_force =
                remembered.map_or_else(Vector3::zeros, |force| force.friction_force);
            let normal = point.normal;
            let pair = pair_of.get(&(point.key.body, whole(point.key.partner)));
            let (friction, response) =
                pair.map_or((0.0, Response::Constraint), |&(pair, _)| laws[pair]);
            let mut contact = Contact {
                nodes: point.nodes,
                weights: point.weights,
                first: point.first,
                normal,
                offset: 0.0,
                floor: (point.start_gap + *overlap_per_step).min(0.0),
                start_gap: point.start_gap,
                response,
                friction,
                drift: point.drift,
                normal_force,
                // The surface has turned since.
                friction_force: friction_force - normal * normal.dot(&friction_force),
                is_sliding: false,
            };
            contact.offset = contact.gap(positions) - point.gap;
            contact
        }));
    }

    fn moves_on(&self) -> bool {
        self.of.moves_on
    }

    fn has_jumped(&self, contacts: &[Contact]) -> bool {
        let mut sums: BTreeMap<usize, StepForces> = BTreeMap::new();
        let watch = |pair: usize| self.of.jump_watches.get(pair)?.as_ref();
        for (point, contact) in self.of.points.iter().zip(contacts) {
            if let (Partner::Tool { capsule, .. }, Some((pair, _))) =
                (point.key.partner, self.of.pair(&point.key))
                && let Some(watch) = watch(pair)
            {
                let push = contact.normal * contact.normal_force;
                let sum = sums.entry(pair).or_default();
                sum.add(watch, capsule, contact.force(), push);
            }
        }
        sums.iter()
            .any(|(&pair, forces)| watch(pair).is_some_and(|watch| forces.have_jumped(watch)))
    }
}

#[cfg(test)]
mod tests;
