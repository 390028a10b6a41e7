//! What the pairs sum up over a tick: forces in newtons, with direction and place.

use crate::body::Body;
use crate::group::Group;
use crate::pairs::{Pair, PairPartner};
use crate::report::{ContactPartner, ContactReport, PartReport, RegionReport};
use crate::scene::Scene;
use crate::tool::{Tool, ToolMotion, squeeze};
use microsim_contact::Partner;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// An overlap from before the step counts as one from this fraction of the mean edge length on: less is what iterations leave.
const OLD_OVERLAP: f64 = 1e-2;

/// What one pair sums up over a tick. Forces are those on the pair's body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    /// Σ F h \[N·s\].
    impulse: Vector3<f64>,
    /// Σ |F| h \[N·s\].
    impulse_size: f64,
    peak: f64,
    /// Σ |F_i| h p_i and Σ |F_i| h over the contacts.
    weighted_point: Vector3<f64>,
    weight: f64,
    last_point: Vector3<f64>,
    max_depth: f64,
    nodes: BTreeSet<u32>,
    /// Σ λ h over all contacts, and over those that stick \[N·s\].
    normal_impulse: f64,
    stick_impulse: f64,
    jaws: [JawTally; 2],
    /// By the capsules of the tool.
    parts: BTreeMap<u32, PartTally>,
    /// By the regions of the body.
    regions: BTreeMap<u32, ForceTally>,
    /// Of the step that is being summed up, and of a body on itself the sum of sizes.
    step: Vector3<f64>,
    step_size: f64,
    /// Touched nodes of the step, with the jaw and how much of the node is touched.
    areas: Vec<(usize, u32, f64)>,
}

/// What some of the forces sum up to over a tick.
#[derive(Clone, Debug, Default)]
struct ForceTally {
    /// Σ F h \[N·s\].
    impulse: Vector3<f64>,
    /// Σ λ h \[N·s\].
    normal_impulse: f64,
    /// Σ |F| h p and Σ |F| h.
    weighted_point: Vector3<f64>,
    weight: f64,
    last_point: Vector3<f64>,
}

impl ForceTally {
    /// Adds a force \[N\] of normal force `normal_force` \[N\] that acted at a place \[m\] for `h` \[s\].
    fn add(&mut self, force: &Vector3<f64>, normal_force: f64, place: &Vector3<f64>, h: f64) {
        let size = force.norm() * h;
        self.impulse += force * h;
        self.normal_impulse += normal_force * h;
        self.weighted_point += place * size;
        self.weight += size;
        self.last_point = *place;
    }

    fn point(&self) -> Vector3<f64> {
        match self.weight > 0.0 {
            true => self.weighted_point / self.weight,
            false => self.last_point,
        }
    }
}

/// What one capsule of a tool sums up over a tick.
#[derive(Clone, Debug, Default)]
struct PartTally {
    forces: ForceTally,
    nodes: BTreeSet<u32>,
}

impl PartTally {
    fn report(&self, capsule: u32, tick_s: f64) -> PartReport {
        PartReport {
            capsule,
            force_on_tissue: (self.forces.impulse / tick_s).into(),
            normal_force_n: self.forces.normal_impulse / tick_s,
            point: self.forces.point().into(),
            nodes: self.nodes.len(),
        }
    }
}

/// What one jaw sums up over a tick.
#[derive(Clone, Copy, Debug, Default)]
struct JawTally {
    /// Σ λ h \[N·s\].
    impulse: f64,
    /// Σ λ n h: how it pushes the tissue, without friction \[N·s\].
    push: Vector3<f64>,
    /// Σ A h \[m²·s\].
    area: f64,
}

/// What contact did to the bodies of a group in a step, for containment.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Work {
    /// Of tools and other bodies, each contact counted positive \[J\].
    pub work: f64,
    /// The body's nodes at which an old overlap was undone.
    pub undone: Vec<u32>,
    /// The largest force at a point of contact \[N\].
    pub normal_force: f64,
}

/// Sums up the contacts that a step of `h` \[s\] of a group ended with; `end` are the positions after it \[m\]. `works` has an entry
/// per member of the group.
#[expect(clippy::too_many_arguments, reason = "a step has this many sides")]
pub(crate) fn sum_up(
    group: &Group,
    bodies: &[Body],
    pairs: &[Pair],
    tools: &[Tool],
    end: &[Vector3<f64>],
    h: f64,
    tallies: &mut [Tally],
    works: &mut [Work],
) {
    let Some(of) = &group.contact else {
        return;
    };
    for (point, contact) in of.points.iter().zip(&of.contacts) {
        let Some((index, own)) = of.pair(&point.key) else {
            continue;
        };
        let gap = contact.gap(end);
        if contact.normal_force <= 0.0 && gap > 0.0 {
            continue;
        }
        let tally = &mut tallies[index];
        tally.max_depth = tally.max_depth.max(-gap);
        let force = contact.force();
        // A body's forces on itself have no direction.
        match (&pairs[index].with, own) {
            (PairPartner::Itself, _) => tally.step_size += force.norm(),
            (_, true) => tally.step += force,
            (_, false) => tally.step -= force,
        }
        // Where it is on the first side: the point of the other one is a gap away.
        let first = usize::from(contact.first);
        let (mut place, mut displacement) = (Vector3::zeros(), [Vector3::<f64>::zeros(); 2]);
        for k in 0..4 {
            let (node, weight) = (contact.nodes[k] as usize, contact.weights[k]);
            if weight == 0.0 {
                continue;
            }
            let side = usize::from(k >= first);
            displacement[side] += (end[node] - of.start[node]) * weight;
            if side == 0 {
                place += end[node] * weight;
            }
        }
        let size = force.norm();
        tally.weighted_point += place * (size * h);
        tally.weight += size * h;
        tally.last_point = place;
        tally.normal_impulse += contact.normal_force * h;
        if !contact.is_sliding {
            tally.stick_impulse += contact.normal_force * h;
        }
        let (jaw, mut part) = match point.key.partner {
            Partner::Tool { tool, capsule } => {
                let part = tally.parts.entry(capsule).or_default();
                part.forces.add(&force, contact.normal_force, &place, h);
                (tools[tool as usize].jaw(capsule), Some(part))
            }
            _ => (None, None),
        };
        // The nodes of the pair's body: of the first side, or of the other one.
        for k in 0..4 {
            let weight = contact.weights[k];
            if weight == 0.0 || (k < first) != own {
                continue;
            }
            let node = contact.nodes[k];
            let member = group.members[group.member_of(node)];
            let local = node - member.first_node as u32;
            tally.nodes.insert(local);
            if let Some(part) = &mut part {
                part.nodes.insert(local);
            }
            if let Some(jaw) = jaw.filter(|_| contact.normal_force > 0.0) {
                tally.areas.push((jaw as usize, local, weight.abs()));
            }
        }
        // Of a body on itself both sides are its own.
        let both = matches!(pairs[index].with, PairPartner::Itself);
        for (nodes, is_first) in [(0..first, true), (first..4, false)] {
            let touched = nodes.filter(|&k| contact.weights[k] != 0.0);
            let touched: Vec<u32> = touched.map(|k| contact.nodes[k]).collect();
            let (Some(&node), true) = (touched.first(), both || is_first == own) else {
                continue;
            };
            let member = group.members[group.member_of(node)];
            let local = touched.iter().map(|node| node - member.first_node as u32);
            let local: Vec<u32> = local.collect();
            let on_it = if is_first { force } else { -force };
            for (region, weight) in bodies[member.body].region_weights(&local) {
                let of_region = tally.regions.entry(region).or_default();
                let normal_force = contact.normal_force * weight;
                of_region.add(&(on_it * weight), normal_force, &place, h);
            }
        }
        if let Some(jaw) = jaw {
            let sum = &mut tally.jaws[jaw as usize];
            let push = contact.normal * (contact.normal_force * h);
            sum.impulse += contact.normal_force * h;
            sum.push += if own { push } else { -push };
        }
        // Obstacles, and a body itself, bring no energy.
        let brings = matches!(
            pairs[index].with,
            PairPartner::Tool(_) | PairPartner::Body(_)
        );
        for (side, displacement) in displacement.iter().enumerate() {
            let node = match side {
                0 => contact.nodes[0],
                _ if first < 4 && contact.weights[first] != 0.0 => contact.nodes[first],
                _ => continue,
            };
            let member = group.member_of(node);
            let edge = bodies[group.members[member].body].model.mean_edge_length();
            let old = contact.start_gap < -OLD_OVERLAP * edge;
            if brings {
                works[member].work += force.dot(displacement).abs();
            }
            works[member].normal_force = works[member].normal_force.max(contact.normal_force);
            if old && gap > contact.start_gap {
                let first = group.members[member].first_node as u32;
                works[member].undone.push(node - first);
            }
        }
    }
    for (tally, pair) in tallies.iter_mut().zip(pairs) {
        tally.finish_step(&bodies[pair.body], h);
    }
}

impl Tally {
    fn finish_step(&mut self, body: &Body, h: f64) {
        let size = self.step.norm() + self.step_size;
        self.impulse += self.step * h;
        self.impulse_size += size * h;
        self.peak = self.peak.max(size);
        self.step = Vector3::zeros();
        self.step_size = 0.0;
        // A node that is touched in several places counts once, by the largest part of it.
        self.areas
            .sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(b.2.total_cmp(&a.2)));
        self.areas.dedup_by_key(|area| (area.0, area.1));
        for &(jaw, node, weight) in &self.areas {
            self.jaws[jaw].area += weight * body.node_areas[node as usize] * h;
        }
        self.areas.clear();
    }

    /// The report of a tick of `tick_s` \[s\]; `None` of a pair that did not touch.
    fn report(
        &self,
        index: usize,
        scene: &Scene,
        motions: &[ToolMotion],
        tick_s: f64,
    ) -> Option<ContactReport> {
        let (body, with) = scene.pair(index);
        if self.nodes.is_empty() {
            return None;
        }
        let positions = scene.body(body).positions();
        let rest = scene.body(body).rest_positions();
        let direction = self
            .impulse
            .try_normalize(0.0)
            .unwrap_or_else(Vector3::zeros);
        let indentation = self
            .nodes
            .iter()
            .map(|&node| (positions[node as usize] - rest[node as usize]).dot(&direction))
            .fold(0.0, f64::max);
        let point = match self.weight > 0.0 {
            true => self.weighted_point / self.weight,
            false => self.last_point,
        };
        let jaws = self.jaws.iter().filter(|sum| sum.area > 0.0);
        let moved = match with {
            ContactPartner::Tool(tool) => motions.iter().find(|motion| motion.tool == tool),
            _ => None,
        };
        let squeezed = moved.map_or(0.0, |motion| {
            let pushes = self.jaws.map(|sum| sum.push);
            squeeze(pushes, motion.to.orientation * Vector3::x())
        });
        let parts = self.parts.iter();
        let parts = parts.map(|(&capsule, part)| part.report(capsule, tick_s));
        let regions = self.regions.iter().map(|(&region, forces)| RegionReport {
            region,
            force_on_tissue: (forces.impulse / tick_s).into(),
            normal_force_n: forces.normal_impulse / tick_s,
            point: forces.point().into(),
        });
        let of_nodes = scene.body(body).pieces();
        let pieces: BTreeSet<u32> = self.nodes.iter().map(|&n| of_nodes[n as usize]).collect();
        Some(ContactReport {
            body,
            with,
            force_on_tissue: (self.impulse / tick_s).into(),
            peak_force_n: self.peak,
            impulse_ns: self.impulse_size,
            point: point.into(),
            max_depth_m: self.max_depth,
            indentation_m: indentation,
            nodes: self.nodes.len(),
            pieces: pieces.into_iter().collect(),
            sustained_force_n: 0.0,
            sustained_grip_n: 0.0,
            over_limit_s: 0.0,
            stick_fraction: match self.normal_impulse > 0.0 {
                true => self.stick_impulse / self.normal_impulse,
                false => 0.0,
            },
            grip_n: squeezed / tick_s,
            parts: parts.collect(),
            regions: regions.collect(),
            jaw_pressure_pa: jaws.map(|sum| sum.impulse / sum.area).fold(0.0, f64::max),
        })
    }
}

impl Scene {
    /// The reports of the pairs that touched in a tick of `tick_s` \[s\], in which the tools moved so.
    pub(crate) fn contact_reports(
        &self,
        tallies: &[Tally],
        motions: &[ToolMotion],
        tick_s: f64,
    ) -> Vec<ContactReport> {
        let tallies = tallies.iter().enumerate();
        tallies
            .filter_map(|(pair, tally)| tally.report(pair, self, motions, tick_s))
            .collect()
    }
}
