//! Where a value stands among those of a population that was measured: its percentile.

/// The distribution of a metric in a population.
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    /// Mean and standard deviation, if they are stated.
    pub moments: Option<(f64, f64)>,
    /// Percent of the population and the value up to which it lies; rising in both.
    pub percentiles: Vec<(f64, f64)>,
}

/// Percent of a population that lies below a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing {
    /// So many.
    At(f64),
    /// Fewer than the lowest percentile that is stated.
    Below(f64),
    /// More than the highest percentile that is stated.
    Above(f64),
}

impl Population {
    /// A distribution, or what is wrong with it in words.
    ///
    /// # Errors
    /// Percentiles that do not rise, or neither two of them nor mean and deviation.
    pub fn new(
        moments: Option<(f64, f64)>,
        percentiles: Vec<(f64, f64)>,
    ) -> Result<Self, &'static str> {
        let finite = |(a, b): &(f64, f64)| a.is_finite() && b.is_finite();
        if !percentiles.iter().all(finite) || !moments.iter().all(finite) {
            return Err("numbers that are finite");
        }
        if moments.is_some_and(|(_, deviation)| deviation <= 0.0) {
            return Err("a standard deviation above 0");
        }
        let rises = |pair: &[(f64, f64)]| pair[0].0 < pair[1].0 && pair[0].1 <= pair[1].1;
        if !percentiles.windows(2).all(rises) {
            return Err("percentiles whose values do not fall");
        }
        if percentiles.len() < 2 && moments.is_none() {
            return Err("at least two percentiles, or mean and standard deviation");
        }
        Ok(Self {
            moments,
            percentiles,
        })
    }

    /// How much of the population lies below `value`: between stated percentiles along a line, from one half of a stretch of equal
    /// values; without percentiles as of a normal distribution.
    pub fn standing(&self, value: f64) -> Standing {
        let (Some(first), Some(last), true) = (
            self.percentiles.first(),
            self.percentiles.last(),
            self.percentiles.len() >= 2,
        ) else {
            let (mean, deviation) = self.moments.unwrap_or((0.0, 1.0));
            let score = (value - mean) / deviation;
            return Standing::At(50.0 * libm::erfc(-score / std::f64::consts::SQRT_2));
        };
        if value < first.1 {
            return Standing::Below(first.0);
        }
        if value > last.1 {
            return Standing::Above(last.0);
        }
        let same = self.percentiles.iter().filter(|(_, v)| *v == value);
        let (count, sum) = same.fold((0, 0.0), |(n, sum), (percent, _)| (n + 1, sum + percent));
        if count > 0 {
            return Standing::At(sum / f64::from(count));
        }
        let next = self.percentiles.partition_point(|(_, v)| *v < value);
        let ((p0, v0), (p1, v1)) = (self.percentiles[next - 1], self.percentiles[next]);
        Standing::At(p0 + (p1 - p0) * (value - v0) / (v1 - v0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Φ(0) = 1/2, Φ(1) = 0.841344746…, Φ(1.959963985) = 0.975 (tables of the normal distribution).
    #[test]
    fn mean_and_deviation_give_the_normal_distribution() {
        let population = Population::new(Some((10.0, 2.0)), Vec::new()).expect("a population");
        for (value, percent) in [
            (10.0, 50.0),
            (12.0, 84.134_474_606_854_29),
            (8.0, 100.0 - 84.134_474_606_854_29),
            (10.0 + 2.0 * 1.959_963_984_540_054, 97.5),
        ] {
            let Standing::At(found) = population.standing(value) else {
                panic!("within");
            };
            assert!((found - percent).abs() < 1e-12, "{found} {percent}");
        }
    }

    #[test]
    fn between_percentiles_is_a_line_and_beyond_them_nothing_is_known() {
        let percentiles = vec![(10.0, 1.0), (50.0, 3.0), (75.0, 3.0), (90.0, 6.0)];
        let population = Population::new(Some((0.0, 1.0)), percentiles).expect("a population");
        assert_eq!(population.standing(0.5), Standing::Below(10.0));
        assert_eq!(population.standing(1.0), Standing::At(10.0));
        assert_eq!(population.standing(2.0), Standing::At(30.0));
        assert_eq!(population.standing(3.0), Standing::At(62.5));
        assert_eq!(population.standing(4.0), Standing::At(80.0));
        assert_eq!(population.standing(6.5), Standing::Above(90.0));
    }

    #[test]
    fn what_is_no_distribution_is_refused() {
        assert!(Population::new(None, vec![(50.0, 1.0)]).is_err());
        assert!(Population::new(None, vec![(10.0, 2.0), (90.0, 1.0)]).is_err());
        assert!(Population::new(None, vec![(90.0, 1.0), (10.0, 2.0)]).is_err());
        assert!(Population::new(Some((1.0, 0.0)), Vec::new()).is_err());
        assert!(Population::new(Some((f64::NAN, 1.0)), Vec::new()).is_err());
    }
}
