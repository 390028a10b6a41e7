//! Percentiles of measurements, and how far two groups of them lie apart.

/// The value below which `fraction` (0…1) of the values lie, by nearest rank; NaN without values.
pub fn percentile(values: &[f64], fraction: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (fraction * sorted.len() as f64).ceil() as usize;
    sorted
        .get(rank.saturating_sub(1))
        .copied()
        .unwrap_or(f64::NAN)
}

/// A group of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// How many.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation, from n − 1.
    pub deviation: f64,
}

impl Group {
    /// Of values; `None` for fewer than two.
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        (values.len() > 1).then(|| Self {
            count: values.len(),
            mean,
            deviation: (squares / (n - 1.0)).sqrt(),
        })
    }
}

/// Cohen's d of two groups: how much larger the mean of the second is, in pooled standard deviations; `None` where neither varies.
pub fn effect_size(first: &Group, second: &Group) -> Option<f64> {
    let [a, b] = [first, second].map(|g| (g.count as f64 - 1.0) * g.deviation * g.deviation);
    let pooled = ((a + b) / (first.count as f64 + second.count as f64 - 2.0)).sqrt();
    (pooled > 0.0).then(|| (second.mean - first.mean) / pooled)
}

/// Standard error of Cohen's d (Hedges and Olkin 1985): √((n + m)/(n·m) + d²/(2(n + m))).
pub fn effect_error(first: &Group, second: &Group, effect: f64) -> f64 {
    let [n, m] = [first.count as f64, second.count as f64];
    ((n + m) / (n * m) + effect * effect / (2.0 * (n + m))).sqrt()
}

/// Hedges' g of two groups and its standard error: Cohen's d times 1 - 3/(4 (n + m - 2) - 1), without which d of small groups is too large (Hedges 1981). `None` where neither
/// varies.
pub fn hedges(first: &Group, second: &Group) -> Option<(f64, f64)> {
    let effect = effect_size(first, second)?;
    let freedom = (first.count + second.count) as f64 - 2.0;
    let unbiased = 1.0 - 3.0 / (4.0 * freedom - 1.0);
    Some((
        unbiased * effect,
        unbiased * effect_error(first, second, effect),
    ))
}

/// The mean of effects of several strata, each with its standard error, weighted by their inverse squares, and its own (fixed-effect meta-analysis; Hedges and Olkin 1985). `None`
/// of none. As the error of a small group grows with its effect, large ones count for less: the mean is rather too small than too large.
pub fn pooled(effects: &[(f64, f64)]) -> Option<(f64, f64)> {
    let weights = || effects.iter().map(|(_, error)| error.powi(-2));
    let all: f64 = weights().sum();
    let weighted = weights().zip(effects).map(|(weight, (g, _))| weight * g);
    (!effects.is_empty()).then(|| (weighted.sum::<f64>() / all, all.powf(-0.5)))
}

/// Two-sided probability of an effect at least as large without a difference, from its standard error (normal approximation).
pub fn probability(effect: f64, error: f64) -> f64 {
    libm::erfc(effect.abs() / error / std::f64::consts::SQRT_2)
}

/// Probabilities of a family of tests, corrected for their number (Holm 1979): the k-th smallest of n times n + 1 − k, at least as large as those
/// before it, at most 1.
pub fn corrected(probabilities: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|a, b| probabilities[*a].total_cmp(&probabilities[*b]));
    let mut corrected = vec![0.0; probabilities.len()];
    let mut largest = 0.0f64;
    for (rank, index) in order.into_iter().enumerate() {
        let tests = (probabilities.len() - rank) as f64;
        largest = largest.max((tests * probabilities[index]).min(1.0));
        corrected[index] = largest;
    }
    corrected
}

#[cfg(test)]
mod tests {
    use super::{Group, corrected, effect_error, effect_size, hedges, percentile, probability};

    /// By hand: sorted 0.01, 0.02, 0.03, 0.6 times 4, 3, 2, 1 are 0.04, 0.06, 0.06, 0.6.
    #[test]
    fn probabilities_are_corrected_for_their_number() {
        let found = corrected(&[0.03, 0.01, 0.6, 0.02]);
        for (found, expected) in found.iter().zip([0.06, 0.04, 0.6, 0.06]) {
            assert!((found - expected).abs() < 1e-15, "{found}");
        }
        assert_eq!(corrected(&[0.7, 0.9]), [1.0, 1.0]);
    }

    /// 1.959964 standard errors leave 5 % of the normal distribution (tables).
    #[test]
    fn two_standard_errors_leave_one_in_twenty() {
        let found = probability(-2.0 * 1.959_963_985, 2.0);
        assert!((found - 0.05).abs() < 1e-9, "{found}");
    }

    /// By hand: 1, 2, 3 have mean 2 and variance 1; 4 and 8 have mean 6 and variance 8. Pooled: (2·1 + 1·8)/3 = 10/3.
    #[test]
    fn groups_and_their_effect_size() {
        let a = Group::of(&[1.0, 2.0, 3.0]).expect("three values");
        let b = Group::of(&[4.0, 8.0]).expect("two values");
        assert_eq!((a.mean, a.deviation, b.mean), (2.0, 1.0, 6.0));
        let d = effect_size(&a, &b).expect("they vary");
        assert!((d - 4.0 / (10.0_f64 / 3.0).sqrt()).abs() < 1e-14, "{d}");
        // 5/6 + 4.8/10 = 1.3133…
        let error = effect_error(&a, &b, d);
        assert!((error * error - 394.0 / 300.0).abs() < 1e-14, "{error}");
        // Three degrees of freedom: 1 - 3/11.
        let (g, of_g) = hedges(&a, &b).expect("they vary");
        assert!((g - 8.0 / 11.0 * d).abs() < 1e-14, "{g}");
        assert!((of_g - 8.0 / 11.0 * error).abs() < 1e-14, "{of_g}");
        assert_eq!(Group::of(&[1.0]), None);
        assert_eq!(
            effect_size(
                &Group {
                    deviation: 0.0,
                    ..a
                },
                &Group {
                    deviation: 0.0,
                    ..b
                }
            ),
            None
        );
    }

    /// Nearest rank: of the whole numbers 1 to 100 the p-th percentile is p.
    #[test]
    fn of_the_whole_numbers() {
        let values: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        for p in [1, 50, 99, 100] {
            assert_eq!(percentile(&values, f64::from(p) / 100.0), f64::from(p));
        }
        assert_eq!(percentile(&[7.0], 0.0), 7.0);
        assert!(percentile(&[], 0.5).is_nan());
    }
}
