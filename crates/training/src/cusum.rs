//! CUSUM learning curves: after each attempt a sum that falls with successes and rises with failures (DOMAIN 2).
//!
//! With P = ln(p1/p0) and Q = ln((1 − p0)/(1 − p1)) a success adds −s and a failure 1 − s, where s = Q/(P + Q). The sum is then the
//! logarithm of the likelihood ratio of the two failure rates over P + Q, so that it is a sequential probability ratio test (Wald): at or
//! below −h0 the rate is acceptable, at or above h1 it is not, with errors of the second and first kind β and α.

/// What a learning curve is judged by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CusumPlan {
    acceptable: f64,
    unacceptable: f64,
    step: f64,
    lower: f64,
    upper: f64,
}

/// What the first crossing of a limit means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CusumDecision {
    /// The failure rate is the acceptable one rather than the other.
    Acceptable,
    /// The failure rate is the unacceptable one rather than the other.
    Unacceptable,
}

/// A learning curve.
#[derive(Clone, Debug, PartialEq)]
pub struct CusumCurve {
    /// The sum after each attempt.
    pub values: Vec<f64>,
    /// Index of the first attempt after which a limit is reached, and which one.
    pub decision: Option<(usize, CusumDecision)>,
}

impl CusumPlan {
    /// Failure rates of 5 % and 15 % (PMC4188705); errors of 10 % each are a convention.
    ///
    /// # Panics
    /// Never: these numbers make a plan.
    pub fn published() -> Self {
        Self::new(0.05, 0.15, 0.1, 0.1).expect("rates in order")
    }

    /// A plan for an acceptable and an unacceptable failure rate, with the error of calling an acceptable rate unacceptable (α) and that of
    /// the opposite (β); `None` unless 0 < acceptable < unacceptable < 1 and both errors lie between 0 and 0.5.
    pub fn new(acceptable: f64, unacceptable: f64, alpha: f64, beta: f64) -> Option<Self> {
        let is_error = |error: f64| 0.0 < error && error < 0.5;
        let rates = 0.0 < acceptable && acceptable < unacceptable && unacceptable < 1.0;
        if !rates || !is_error(alpha) || !is_error(beta) {
            return None;
        }
        let p = libm::log(unacceptable / acceptable);
        let q = libm::log((1.0 - acceptable) / (1.0 - unacceptable));
        Some(Self {
            acceptable,
            unacceptable,
            step: q / (p + q),
            lower: libm::log((1.0 - alpha) / beta) / (p + q),
            upper: libm::log((1.0 - beta) / alpha) / (p + q),
        })
    }

    /// The acceptable and the unacceptable failure rate.
    pub fn rates(&self) -> [f64; 2] {
        [self.acceptable, self.unacceptable]
    }

    /// What a success takes off, s.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Limit from which on downwards the failure rate is acceptable, −h0.
    pub fn lower(&self) -> f64 {
        -self.lower
    }

    /// Limit from which on upwards the failure rate is unacceptable, h1.
    pub fn upper(&self) -> f64 {
        self.upper
    }

    /// The curve of attempts in their order: `true` is a success.
    pub fn curve(&self, attempts: impl IntoIterator<Item = bool>) -> CusumCurve {
        let mut curve = CusumCurve {
            values: Vec::new(),
            decision: None,
        };
        // Counted and then multiplied: the same sum, without the rounding of each step.
        let (mut all, mut failures) = (0_u32, 0_u32);
        for success in attempts {
            all += 1;
            failures += u32::from(!success);
            let value = f64::from(failures) - f64::from(all) * self.step;
            if curve.decision.is_none() {
                let attempt = curve.values.len();
                if value <= self.lower() {
                    curve.decision = Some((attempt, CusumDecision::Acceptable));
                } else if value >= self.upper() {
                    curve.decision = Some((attempt, CusumDecision::Unacceptable));
                }
            }
            curve.values.push(value);
        }
        curve
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// s, h0 and h1 by the formulas of DOMAIN 2, computed with Python's `math.log`.
    #[test]
    fn limits_are_those_of_the_formulas() {
        for ((p0, p1, alpha, beta), [s, h0, h1]) in [
            (
                (0.05, 0.15, 0.1, 0.1),
                [0.0919343268417854, 1.8161313463164297, 1.8161313463164297],
            ),
            (
                (0.1, 0.2, 0.05, 0.2),
                [0.1452443543242726, 1.921428733185704, 3.4190225827029095],
            ),
        ] {
            let plan = CusumPlan::new(p0, p1, alpha, beta).expect("a plan");
            for (found, expected) in [(plan.step(), s), (-plan.lower(), h0), (plan.upper(), h1)] {
                // A few roundings of numbers of this size.
                assert!(
                    (found - expected).abs() < 8.0 * f64::EPSILON,
                    "{found} {expected}"
                );
            }
        }
        assert_eq!(CusumPlan::new(0.15, 0.05, 0.1, 0.1), None);
        assert_eq!(CusumPlan::new(0.05, 0.15, 0.5, 0.1), None);
        assert_eq!(CusumPlan::new(f64::NAN, 0.15, 0.1, 0.1), None);
    }

    /// Successes alone reach −h0 after h0/s = 19.76 of them, so with the 20th; failures alone reach h1 after h1/(1 − s) = 2.0000 of
    /// them: (1 − s) = P/(P + Q), so h1/(1 − s) = ln 9/ln 3 = 2 in closed form, up to rounding.
    #[test]
    fn runs_of_one_outcome_reach_the_limits_when_they_must() {
        let plan = CusumPlan::published();
        let good = plan.curve([true; 25]);
        assert_eq!(good.decision, Some((19, CusumDecision::Acceptable)));
        let bad = plan.curve([false; 4]);
        let (attempt, decision) = bad.decision.expect("a decision");
        assert_eq!(decision, CusumDecision::Unacceptable);
        assert!(attempt == 1 || attempt == 2, "{attempt}");
        assert!((bad.values[1] - plan.upper()).abs() < 8.0 * f64::EPSILON);
    }

    /// The sum is the logarithm of the likelihood ratio over P + Q, whatever the order.
    #[test]
    fn the_sum_is_a_likelihood_ratio() {
        let plan = CusumPlan::published();
        let attempts = [true, false, true, true, false, true, true];
        let curve = plan.curve(attempts);
        let [p0, p1] = plan.rates();
        let scale = libm::log(p1 / p0) + libm::log((1.0 - p0) / (1.0 - p1));
        let mut ratio = 1.0;
        for (success, value) in attempts.iter().zip(&curve.values) {
            ratio *= match success {
                true => (1.0 - p1) / (1.0 - p0),
                false => p1 / p0,
            };
            let expected = libm::log(ratio) / scale;
            assert!((value - expected).abs() < 1e-14, "{value} {expected}");
        }
        // Two failures of seven: neither limit is reached.
        assert_eq!(curve.decision, None);
    }
}
