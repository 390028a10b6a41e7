//! What is formed of results: the learning curve, two of them side by side, places in populations. Commands print it, the window shows it.

use microsim_store::{Measured, NamedSession, PopulationRecord, Session, Verdict};
use microsim_training::{CusumCurve, CusumPlan, Standing};

/// Whether a result is one of a person.
fn is_attempt(session: &Session) -> bool {
    session.counts && session.synthetic.is_none()
}

/// The curve over results of a trainee on a level, the oldest first.
pub fn learning_curve(found: &[NamedSession]) -> CusumCurve {
    let attempts = found.iter().filter(|named| is_attempt(&named.session));
    CusumPlan::published().curve(attempts.map(|named| named.session.verdict == Verdict::Passed))
}

/// Whether two sessions are of one level.
pub fn same_level(a: &Session, b: &Session) -> bool {
    (&a.module, a.level) == (&b.module, b.level)
}

/// The metrics that two sessions have in common.
pub fn pairs<'a>(a: &'a Session, b: &'a Session) -> Vec<(&'a Measured, &'a Measured)> {
    let pair = |of_a: &'a Measured| {
        let same = |of_b: &&Measured| {
            of_b.metric.id == of_a.metric.id && of_b.metric.unit == of_a.metric.unit
        };
        Some((of_a, b.metrics.iter().find(same)?))
    };
    a.metrics.iter().filter_map(pair).collect()
}

/// Whether a difference is for the better; `None` if there is none, or no side is better.
pub fn is_better(direction: &str, difference: f64) -> Option<bool> {
    match (direction, difference) {
        (_, 0.0) => None,
        ("lower" | "lower-is-better", difference) => Some(difference < 0.0),
        ("higher" | "higher-is-better", difference) => Some(difference > 0.0),
        _ => None,
    }
}

/// The populations that a metric of a session stands in, each with the place of its value.
pub fn standings<'a>(
    session: &Session,
    measured: &Measured,
    populations: &'a [PopulationRecord],
) -> Vec<(&'a PopulationRecord, Standing)> {
    let of = populations.iter().filter(|record| {
        record.module == session.module
            && record.level == session.level
            && record.metric == measured.metric.id
    });
    let place = |record: &'a PopulationRecord| {
        let population = record.population().ok()?;
        Some((record, population.standing(measured.value?)))
    };
    of.filter_map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::is_better;

    #[test]
    fn which_side_is_better_decides() {
        assert_eq!(is_better("lower-is-better", -1.0), Some(true));
        assert_eq!(is_better("lower-is-better", 1.0), Some(false));
        assert_eq!(is_better("higher-is-better", 1.0), Some(true));
        assert_eq!(is_better("informative", 1.0), None);
        assert_eq!(is_better("lower-is-better", 0.0), None);
    }
}
