//! The work of a tick, bounded by a count and not by a clock, so that a run that is replayed takes the same.
//!
//! Its unit is the work of a tick without repetitions and without fast tools: the steps of the solver with the iterations of the method.

/// The part of a budget that sub-steps for fast tools may take: the rest is left for a repetition.
const FAST_PART: u32 = 2;

/// What is left of the budget of a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    /// `None` where there is no bound.
    left: Option<u32>,
    /// Whether something did not fit.
    pub is_exceeded: bool,
}

impl Budget {
    pub fn new(budget: Option<u32>) -> Self {
        Self {
            left: budget,
            is_exceeded: false,
        }
    }

    /// The sub-steps of a step for tools that need so many, at least 1, and the fraction of their motion that these allow.
    pub fn substeps(&mut self, needed: f64) -> (u32, f64) {
        let most = self
            .left
            .map_or(f64::INFINITY, |left| f64::from((left / FAST_PART).max(1)));
        if needed.ceil() <= most {
            // The cast saturates.
            return (needed.ceil() as u32, 1.0);
        }
        self.is_exceeded = true;
        (most as u32, most / needed)
    }

    /// Takes what a try of so many sub-steps, steps and iterations costs; whether it fits.
    pub fn take(&mut self, factors: [u32; 3]) -> bool {
        let Some(left) = &mut self.left else {
            return true;
        };
        let work = factors.into_iter().fold(1, u32::saturating_mul);
        let rest = left.checked_sub(work);
        match rest {
            Some(rest) => *left = rest,
            None => self.is_exceeded = true,
        }
        rest.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_and_marked() {
        let mut budget = Budget::new(Some(16));
        assert_eq!(budget.substeps(1.0), (1, 1.0));
        assert_eq!(budget.substeps(7.5), (8, 1.0));
        assert!(budget.take([1, 1, 1]) && budget.take([1, 2, 4]) && !budget.is_exceeded);
        // Seven are left.
        assert!(!budget.take([1, 4, 4]) && budget.is_exceeded);
        let mut fast = Budget::new(Some(16));
        assert_eq!(fast.substeps(32.0), (8, 0.25));
        assert!(fast.is_exceeded && fast.take([8, 1, 1]) && !fast.take([9, 1, 1]));
        let mut any = Budget::new(None);
        assert_eq!(any.substeps(256.0), (256, 1.0));
        assert!(any.take([u32::MAX; 3]) && !any.is_exceeded);
    }
}
