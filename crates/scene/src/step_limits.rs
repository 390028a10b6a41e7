//! The longest stable step of each body, as it becomes stiffer or softer.

use crate::body::stable_step;
use crate::containment::Failure;
use crate::divergence::Divergence;
use crate::group::Group;
use crate::scene::Scene;
use crate::stretch_guard::StretchGuard;

impl Scene {
    /// Computes the longest stable step of a body with its internal variables as they are now, in which it only becomes shorter.
    pub(crate) fn update_stable_step(&mut self, body: usize) {
        let of = &self.bodies[body];
        let step = stable_step(&self.method, &of.model, &self.state.bodies[body]);
        let now = &mut self.state.stable_steps[body];
        *now = now.min(step);
    }

    /// Shortens the steps of a body, and of those that are advanced with it, that has stiffened as it stretched; whether that is why the
    /// tick failed, and shorter steps may help.
    pub(crate) fn shorten_steps(&mut self, failure: &Failure) -> bool {
        let Divergence::Stiffened { longest_step_s } = failure.what else {
            return false;
        };
        let is_its = |group: &&Group| group.members.iter().any(|of| of.body == failure.body);
        let Some(group) = self.groups.iter().find(is_its) else {
            return false;
        };
        if StretchGuard::is_hopeless(longest_step_s, group.step_at_rest(&self.bodies)) {
            return false;
        }
        for member in &group.members {
            let now = &mut self.state.stable_steps[member.body];
            *now = now.min(longest_step_s);
        }
        true
    }

    /// Lets the steps of a group grow again that has softened, to at most `longest` \[s\].
    pub(crate) fn lengthen_steps(&mut self, group: usize, longest: f64) {
        let at_rest = self.groups[group].step_at_rest(&self.bodies);
        for member in &self.groups[group].members {
            let (body, now) = (
                &self.bodies[member.body],
                &mut self.state.stable_steps[member.body],
            );
            if let Some(grown) = StretchGuard::grown(*now, longest, at_rest) {
                let state = &self.state.bodies[member.body];
                let own = stable_step(&self.method, &body.model, state);
                *now = own.min(grown).min(body.stable_step);
            }
        }
    }

    /// Whether plastic flow or stretch has shortened the stable step of a body.
    pub(crate) fn has_stiffened(&self) -> bool {
        let steps = self.bodies.iter().zip(&self.state.stable_steps);
        steps.into_iter().any(|(body, now)| *now < body.stable_step)
    }
}
