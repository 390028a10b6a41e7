//! The work of a tick, bounded by the count of its operations and not by a clock, so that a run that is replayed takes the same.
//!
//! A bound of every tick alone would let a hand that stays violent be late for good: its ticks may take longer than they last, one after the other. What ticks took beyond
//! their mean budget is, beyond [`BURST`], not there for the next ones (a token bucket), until calmer ones have made up for it.
//!
//! Its unit is the nominal second of `microsim_tissue::StepReport::work`. A tick makes as many sub-steps for fast tools as fit with an iteration each in
//! four fifths of the first half, each step has an even part of what is left of it, and a repetition has the other half too and begins only where its least work fits. Where iterations take more than
//! was foreseen, as contacts become many in the motion, the tools stop before what is left of the solver's steps, with an iteration each, would not fit any more, and each of these is made undivided. What has to be computed in any
//! case is computed: an iteration of each of these, whatever contact makes of it, and one of each step of the tries with tools that stand or touch nothing, which have more where the budget has. By so much a tick may exceed its budget.

use crate::spec::WorkBudget;

/// The part of a budget that is left for repetitions of a tick that diverges or whose forces mean nothing: without it they would mean nothing in every tick that is hard to solve.
const RESERVE: f64 = 0.5;

/// The part of the rest that sub-steps for fast tools may take with an iteration each: what remains is for more of these.
const FAST_PART: f64 = 0.8;

/// Work beyond the mean budget that bounds no tick yet \[s\]. A judgement, from single runs of violent and trembling hands: with half of it the short contacts of trembling hands that are hard to solve have so many ticks without meaning that runs have no
/// verdict, and with more a violent hand is late for longer.
const BURST: f64 = 0.1;

impl WorkBudget {
    /// What a tick of `tick_s` \[s\] may take \[s\] if so much is `overspent` \[s\].
    pub(crate) fn left(&self, tick_s: f64, overspent: f64) -> f64 {
        (self.tick * tick_s - (overspent - BURST).max(0.0)).max(0.0)
    }

    /// What is overspent \[s\] after a tick of `tick_s` \[s\] that took `work` \[s\], if it was `before` \[s\]. Never more than leaves nothing to a tick: an overrun that nothing
    /// could avoid is not to be made up for without end.
    pub(crate) fn overspent(&self, tick_s: f64, before: f64, work: f64) -> f64 {
        let after = before + work - self.mean * tick_s;
        after.clamp(0.0, BURST + self.tick * tick_s)
    }
}

/// What is left of the budget of a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    /// Infinite where there is no bound \[s\].
    left: f64,
    /// What of it the first try may not take \[s\].
    reserve: f64,
    /// The least work of a step \[s\].
    step: f64,
    /// All that was spent \[s\].
    pub spent: f64,
    /// Whether something did not fit.
    pub is_exceeded: bool,
}

impl Budget {
    /// So much work \[s\], any if `None`, for steps of which each takes at least `step` \[s\].
    pub fn new(budget: Option<f64>, step: f64) -> Self {
        Self {
            left: budget.unwrap_or(f64::INFINITY),
            reserve: budget.map_or(0.0, |budget| RESERVE * budget),
            step,
            spent: 0.0,
            is_exceeded: false,
        }
    }

    /// The sub-steps of each of so many steps that fit, at least 1.
    fn most_substeps(&self, steps: u32) -> f64 {
        let first = self.left - self.reserve;
        let most = (FAST_PART * first / (self.step * f64::from(steps))).floor();
        most.max(1.0)
    }

    /// Whether `steps` steps that were divided into `count` fit.
    pub fn holds(&self, count: u32, steps: u32) -> bool {
        f64::from(count) <= self.most_substeps(steps) * f64::from(steps)
    }

    /// The sub-steps of each of `steps` steps for tools that need so many, at least 1, and the fraction of their motion that these allow.
    pub fn substeps(&mut self, needed: f64, steps: u32) -> (u32, f64) {
        let most = self.most_substeps(steps);
        if needed.ceil() <= most {
            // The cast saturates.
            return (needed.ceil() as u32, 1.0);
        }
        self.is_exceeded = true;
        (most as u32, most / needed)
    }

    /// What the next one of so many steps may take \[s\].
    pub fn part(&self, steps: u32) -> f64 {
        (self.left - self.reserve).max(0.0) / f64::from(steps)
    }

    /// Whether so many undivided steps would no longer fit after one more iteration, if each takes so much \[s\].
    pub fn leaves_no_more(&mut self, undivided: u32, iteration: f64) -> bool {
        let ends = self.left - self.reserve < f64::from(undivided + 1) * iteration;
        self.is_exceeded |= ends;
        ends
    }

    /// Steps of a repetition take at least as much as an iteration has taken on average \[s\] in a try that came to its end.
    pub fn expect(&mut self, iteration: f64) {
        self.step = self.step.max(iteration);
    }

    /// Spends the work of a step \[s\].
    pub fn spend(&mut self, work: f64) {
        self.spent += work;
        self.left = (self.left - work).max(0.0);
    }

    /// What was reserved for repetitions is for the tries that follow: one has failed.
    pub fn release_reserve(&mut self) {
        self.reserve = 0.0;
    }

    /// Whether another try of so many steps fits, with the reserve.
    pub fn allows(&mut self, steps: u32) -> bool {
        self.release_reserve();
        let fits = self.left >= self.step * f64::from(steps);
        self.is_exceeded |= !fits;
        fits
    }
}

/// What an iteration takes in a try, by what those so far have taken.
#[derive(Clone, Debug)]
pub(crate) struct IterationWork {
    /// Per group of bodies, its work \[s\] and iterations.
    groups: Vec<(f64, u32)>,
}

impl IterationWork {
    /// Of so many groups.
    pub fn new(groups: usize) -> Self {
        Self {
            groups: vec![(0.0, 0); groups],
        }
    }

    /// Adds a step of a group.
    pub fn add(&mut self, group: usize, work: f64, iterations: u32) {
        let (sum, count) = &mut self.groups[group];
        *sum += work;
        *count += iterations.max(1);
    }

    /// The mean of an iteration of every group \[s\].
    pub fn mean(&self) -> f64 {
        let means = self.groups.iter();
        means
            .map(|(sum, count)| sum / f64::from((*count).max(1)))
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_and_marked() {
        let mut budget = Budget::new(Some(32.0), 1.0);
        assert_eq!(budget.substeps(1.0, 1), (1, 1.0));
        assert_eq!(budget.substeps(7.5, 1), (8, 1.0));
        assert_eq!(budget.part(8), 2.0);
        budget.spend(6.0);
        assert!(budget.allows(10) && !budget.is_exceeded);
        assert_eq!(budget.part(13), 2.0);
        assert!(!budget.allows(27) && budget.is_exceeded);
        budget.spend(27.0);
        assert_eq!((budget.part(1), budget.spent), (0.0, 33.0));
        let mut fast = Budget::new(Some(32.0), 0.5);
        assert_eq!(fast.substeps(32.0, 2), (12, 0.375));
        assert!(fast.is_exceeded);
        // At least one, however little there is.
        assert_eq!(Budget::new(Some(0.1), 1.0).substeps(2.0, 1), (1, 0.5));
        // Half of it is reserved for a repetition: after 11 s of a first try an iteration and an undivided step of 3 s each no longer fit, after 10 s an iteration and two of these.
        let mut late = Budget::new(Some(32.0), 1.0);
        late.spend(10.0);
        assert!(!late.leaves_no_more(1, 3.0) && !late.is_exceeded);
        assert!(late.clone().leaves_no_more(2, 3.0));
        late.spend(1.0);
        assert!(late.leaves_no_more(1, 3.0) && late.is_exceeded);
        late.expect(3.0);
        assert!(late.allows(7) && !late.allows(8));
        let mut any = Budget::new(None, 1.0);
        assert_eq!(any.substeps(256.0, 1), (256, 1.0));
        assert!(any.allows(u32::MAX) && any.part(9) == f64::INFINITY);
        assert!(!any.leaves_no_more(9, 1e9) && !any.is_exceeded);
    }

    #[test]
    fn ticks_make_up_for_what_was_overspent() {
        let budget = WorkBudget {
            tick: 3.0,
            mean: 0.5,
        };
        assert_eq!(budget.left(4.0, 0.0), 12.0);
        // 2 s were to be spent and 12 s were: 10 s are missing, and after five ticks without work none.
        let mut overspent = budget.overspent(4.0, 0.0, 12.0);
        assert_eq!(overspent, 10.0);
        for _ in 0..5 {
            overspent = budget.overspent(4.0, overspent, 0.0);
        }
        assert_eq!(overspent, 0.0);
        assert_eq!(budget.overspent(4.0, 0.0, 1.0), 0.0);
        assert_eq!(budget.left(4.0, BURST), 12.0);
        assert_eq!(budget.left(4.0, BURST + 8.0), 4.0);
        assert_eq!(budget.left(4.0, budget.overspent(4.0, 10.0, 100.0)), 0.0);
        // However long an overrun was, a tick's budget and the burst may be missing.
        assert_eq!(budget.overspent(4.0, 1e9, 1e9), 12.0 + BURST);
        let any = WorkBudget {
            mean: f64::INFINITY,
            ..budget
        };
        assert_eq!(any.overspent(4.0, 0.0, 100.0), 0.0);
    }

    #[test]
    fn tries_after_one_that_failed_have_the_reserve() {
        let mut budget = Budget::new(Some(32.0), 1.0);
        budget.spend(16.0);
        assert_eq!(budget.part(2), 0.0);
        budget.release_reserve();
        assert_eq!(budget.part(2), 8.0);
    }

    #[test]
    fn an_iteration_takes_the_mean_of_its_group() {
        let mut work = IterationWork::new(3);
        work.add(0, 6.0, 2);
        work.add(0, 3.0, 1);
        work.add(1, 0.5, 0);
        assert_eq!(work.mean(), 3.5);
    }
}
