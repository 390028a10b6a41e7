//! Percentiles of measurements.

/// The value below which `share` (0…1) of the values lie, by nearest rank; NaN without values.
pub fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted
        .get(rank.saturating_sub(1))
        .copied()
        .unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::percentile;

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
