//! When a body has diverged: it is rolled back and computed again with shorter steps, without tools, for a part of its motion, or held.

use crate::body::Body;
use crate::divergence::{Diverged, Divergence};
use crate::group::Group;
use crate::scene::Scene;
use crate::state::SceneState;
use crate::tally::Work;
use microsim_geometry::{Aabb, signed_volume};
use microsim_tissue::State;
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// Energy may exceed what there was and what gravity and tools brought by this fraction of it. The measure itself oscillates by
/// hω/2, which is 0.6 for the fastest modes at the recommended step.
const ENERGY_MARGIN: f64 = 1.0;

/// What undoing an old overlap may bring, as a multiple of the energy of the body stretched by 1 %: that of a stretch by 15 %. How
/// much it really brings is not computed.
const OVERLAP_ENERGY: f64 = 225.0;

/// Below −1 times its rest volume an element is turned inside out as far as its springs can hold it there.
const INVERTED: f64 = -1.0;

/// An element that goes below has diverged if it came there by more than this part of its rest volume within the tick. What a blade has pushed through a wall bit by bit is in
/// equilibrium there, with forces that mean something: without this no tick in which the tools moved succeeded any more, and they stood for seconds
/// (seen with `microsim trainee --profile expert --seed 3` of level 1 of diagonal-cut). Half is a judgement. Springs may hold an element there for good; laws of a continuum, whose energy grows with the inversion, bring it back.
const DEEPER: f64 = 0.5;

/// For elements smaller than this fraction of the mean one the bound is that of this fraction: slivers that a cut leaves turn over many times their
/// volume when their neighbours move by little, and back again. Held to their own, tick after tick failed while blades closed again beside
/// a cut (seen with `microsim trainee --profile expert --seed 3` of level 4 of coordination).
const SLIVER: f64 = 0.5;

/// No node of a body that holds together gets further from the others than this many sizes of the body.
const ESCAPE: f64 = 10.0;

/// A point of contact presses no harder than this multiple of E times the square of an edge: two jaws that close on tissue until it is
/// flat take tens of it, an iteration that was cut short between two jaws may leave a number without any meaning.
const OVERPRESSED: f64 = 1e3;

/// So often the motion of bodies that no tool touches is halved until none diverges in it: a 64th is left, less is no motion.
pub(crate) const HALVINGS: u32 = 6;

/// What is watched of one body during a tick.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    /// Energy at the start \[J\].
    start_energy: f64,
    /// Work of contact, each step and point counted positive \[J\].
    work: f64,
    /// Nodes at which an old overlap was undone: it changes the energy by an amount that is not computed.
    pub undone: BTreeSet<u32>,
    /// Whether clamps or grips move in the tick, or fluid flows: they bring energy that is not computed either.
    driven: bool,
    /// Whether a point of contact pressed harder than the material allows.
    overpressed: bool,
}

impl Watch {
    /// Begins to watch a body in the tick of `tick_s` \[s\] that begins at `time` \[s\], and in which fluid may press on it.
    pub fn new(body: &Body, state: &State, time: f64, tick_s: f64, irrigated: bool) -> Self {
        Self {
            start_energy: state.energies(&body.model).total(),
            work: 0.0,
            undone: BTreeSet::new(),
            driven: irrigated || body.drive.moves(time, time + tick_s),
            overpressed: false,
        }
    }

    /// Jaws hold the body by forces whose work is not computed.
    pub fn is_held(&mut self) {
        self.driven = true;
    }

    /// Adds what contact did in a step.
    pub fn add(&mut self, work: &Work, body: &Body) {
        self.work += work.work;
        self.overpressed |= work.normal_force > OVERPRESSED * body.force_scale;
        self.undone.extend(&work.undone);
    }

    /// Only a part of the motion counts any more, and not what contact did in all of it.
    fn forget_contact(&mut self) {
        (self.overpressed, self.work) = (false, 0.0);
        self.undone.clear();
    }

    /// Looks at a body at the end of a tick, at `time` \[s\].
    pub fn evaluate(
        &self,
        body: &Body,
        start: &State,
        end: &State,
        gravity: &Vector3<f64>,
        time: f64,
    ) -> Option<Divergence> {
        if let Some(escape) = escaped(body, end) {
            return Some(escape);
        }
        if self.overpressed {
            return Some(Divergence::Overpressed);
        }
        let energy = end.energies(&body.model).total();
        // What weight and loads brought: Σ F·(p_end − p_start), with the loads of the end on the shape of the end.
        let masses = body.model.masses().iter();
        let mut forces: Vec<Vector3<f64>> = masses.map(|m| gravity * *m).collect();
        let control = body.drive.control(gravity, time);
        control.add_loads(&end.positions, &mut forces);
        let moved = start.positions.iter().zip(&end.positions);
        let work = moved
            .zip(&forces)
            .map(|((from, to), f)| f.dot(&(to - from)));
        let brought = self.start_energy + work.sum::<f64>().abs() + self.work;
        let overlap = match self.undone.is_empty() {
            true => 0.0,
            false => OVERLAP_ENERGY,
        };
        let scale = body.energy_scale * (1.0 + overlap);
        let allowed = brought * (1.0 + ENERGY_MARGIN) + scale;
        if !energy.is_finite() {
            return Some(Divergence::NotFinite);
        }
        if !self.driven && energy > allowed {
            return Some(Divergence::EnergyGrowth);
        }
        let (tets, rest_volumes) = (body.model.tets(), body.model.rest_volumes());
        let inverted = is_inverted(tets, rest_volumes, &start.positions, &end.positions);
        inverted.then_some(Divergence::Inversion)
    }
}

/// Whether an element is inverted beyond recovery, and was far from that `before`.
fn is_inverted(
    tets: &[[u32; 4]],
    rest_volumes: &[f64],
    before: &[Vector3<f64>],
    positions: &[Vector3<f64>],
) -> bool {
    let mean = rest_volumes.iter().sum::<f64>() / rest_volumes.len().max(1) as f64;
    tets.iter().zip(rest_volumes).any(|(tet, rest_volume)| {
        let volume = |of: &[Vector3<f64>]| {
            let [a, b, c, d] = tet.map(|node| &of[node as usize]);
            signed_volume(a, b, c, d)
        };
        let scale = rest_volume.max(SLIVER * mean);
        let now = volume(positions);
        now < INVERTED * scale && now < volume(before) - DEEPER * scale
    })
}

/// Whether a node has gone further from its rest position, relative to the mean motion of its piece of the body, than [`ESCAPE`] sizes of
/// the body.
pub(crate) fn escaped(body: &Body, state: &State) -> Option<Divergence> {
    let rest = body.model.rest_positions();
    let moved = || {
        let moved = state.positions.iter().zip(rest).map(|(p, r)| p - r);
        moved.zip(&body.pieces.of_nodes)
    };
    let mut means = vec![(Vector3::zeros(), 0.0); body.pieces.count() as usize];
    for (displacement, &piece) in moved() {
        let (sum, count) = &mut means[piece as usize];
        *sum += displacement;
        *count += 1.0;
    }
    for (mean, count) in &mut means {
        *mean /= f64::max(*count, 1.0);
    }
    let size = Aabb::of(rest);
    let limit = ESCAPE * (size.max - size.min).norm();
    let far = moved()
        .any(|(displacement, &piece)| (displacement - means[piece as usize].0).norm() > limit);
    far.then_some(Divergence::Escape)
}

/// A failed try of a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Failure {
    pub body: usize,
    pub step: u32,
    pub what: Divergence,
}

/// A body at rest at these positions, with the internal variables of `start`.
fn resting(positions: Vec<Vector3<f64>>, start: &State) -> State {
    State {
        velocities: vec![Vector3::zeros(); positions.len()],
        positions,
        step: 0.0,
        accelerations: Vec::new(),
        internal: start.internal.clone(),
    }
}

impl Scene {
    /// The first body that has diverged in the tick from `start` to `end` \[s\].
    pub(crate) fn first_diverged(
        &self,
        watches: &[Watch],
        start: &[State],
        end: f64,
    ) -> Option<(usize, Divergence)> {
        let bodies = self.bodies.iter().zip(&self.state.bodies).enumerate();
        bodies.zip(start).find_map(|((index, (body, now)), start)| {
            let found = match watches.get(index) {
                Some(watch) => watch.evaluate(body, start, now, &self.gravity, end),
                None => escaped(body, now),
            };
            found.map(|what| (index, what))
        })
    }

    /// Leaves the half of the motion of a group's bodies from `start`; they are at rest at its end. The smaller the part, the less it can diverge.
    pub(crate) fn halve_motion(&mut self, group: usize, start: &[State], watches: &mut [Watch]) {
        self.state.contacts[group].clear();
        for member in &self.groups[group].members {
            if let Some(watch) = watches.get_mut(member.body) {
                watch.forget_contact();
            }
            let (state, start) = (&mut self.state.bodies[member.body], &start[member.body]);
            let positions = state.positions.iter().zip(&start.positions);
            let positions = positions.map(|(end, start)| start.lerp(end, 0.5)).collect();
            *state = resting(positions, start);
        }
        self.relocate();
    }

    /// The error for a tick that failed finally; goes back to `start`, where those bodies are at rest which have to do with the failure, with containment and implicit steps.
    pub(crate) fn diverged(
        &mut self,
        start: SceneState,
        failure: Failure,
        step_s: f64,
    ) -> Diverged {
        self.state = start;
        // The next tick is to be another one than this. Of explicit steps that are too long it would not be.
        if self.containment && self.method.has_inertia() && !self.method.is_explicit() {
            let of = |group: &&Group| group.holds(failure.body);
            for member in self.groups.iter().filter(of).flat_map(|of| &of.members) {
                let state = &mut self.state.bodies[member.body];
                *state = resting(std::mem::take(&mut state.positions), state);
            }
            self.state.placements.slow_down();
        }
        self.relocate();
        Diverged {
            body: failure.body,
            body_name: self.bodies[failure.body].name.clone(),
            step: failure.step,
            time: self.state.time + f64::from(failure.step) * step_s,
            what: failure.what,
            repetitions: 0,
            ruptured: 0,
            cuts: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::is_inverted;
    use nalgebra::Vector3;

    /// A tetrahedron of 100 units of volume and a sliver of 2 on the same base: their mean is 51, half of it 25.5.
    #[test]
    fn slivers_turn_over_by_more_than_their_own_volume() {
        let tets = [[0, 1, 2, 3], [0, 1, 2, 4]];
        let place = |volumes: [f64; 2]| {
            let corner = |x, y| Vector3::new(x, y, 0.0);
            let top = |volume: f64| Vector3::new(0.0, 0.0, 6.0 * volume);
            let [large, sliver] = volumes.map(top);
            [
                corner(0.0, 0.0),
                corner(1.0, 0.0),
                corner(0.0, 1.0),
                large,
                sliver,
            ]
        };
        let turns = |before: [f64; 2], now: [f64; 2]| {
            is_inverted(&tets, &[100.0, 2.0], &place(before), &place(now))
        };
        let inverted = |now: [f64; 2]| turns([100.0, 2.0], now);
        assert!(!inverted([100.0, 2.0]));
        assert!(!inverted([100.0, -25.0]));
        assert!(inverted([100.0, -26.0]));
        assert!(!inverted([-99.0, 2.0]));
        assert!(inverted([-101.0, 2.0]));
        // What was so before may stay or turn back, and go further by half of its volume: 50 units, of the sliver half of 25.5.
        assert!(!turns([-103.0, -40.0], [-103.0, -30.0]));
        assert!(!turns([-103.0, 2.0], [-152.0, 2.0]));
        assert!(turns([-103.0, 2.0], [-154.0, 2.0]));
        assert!(!turns([100.0, -20.0], [100.0, -32.0]));
        assert!(turns([100.0, -20.0], [100.0, -33.0]));
    }
}
