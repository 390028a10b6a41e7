//! Fewer points for a drawing. The first and the last always stay; CSV and JSON keep all.

/// Indices of at most `most` (at least 4) of `values`: all if they are few; otherwise both ends, and of each stretch of
/// equal length its smallest and its largest value, so that no peak is lost.
pub fn extremes(values: &[f64], most: usize) -> Vec<usize> {
    let count = values.len();
    if count <= most {
        return (0..count).collect();
    }
    let stretches = (most - 2) / 2;
    let mut chosen = vec![0];
    for k in 0..stretches {
        let stretch = k * count / stretches..(k + 1) * count / stretches;
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let low = stretch.clone().min_by(by_value);
        let high = stretch.max_by(by_value);
        chosen.extend(low.min(high).into_iter().chain(low.max(high)));
    }
    chosen.push(count - 1);
    chosen.dedup();
    chosen
}

/// Indices of at most `most` (at least 2) of `count` points: all if they are few, otherwise evenly spread with both ends.
pub fn evenly(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|k| k * (count - 1) / (most - 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_peaks_stay() {
        let mut values: Vec<f64> = (0..100_000).map(|k| (k % 7) as f64).collect();
        (values[12_345], values[77_777]) = (99.0, -99.0);
        let chosen = extremes(&values, 2000);
        assert!(chosen.len() <= 2000 && chosen.is_sorted_by(|a, b| a < b));
        for index in [0, 12_345, 77_777, 99_999] {
            assert!(chosen.contains(&index), "{index}");
        }
        let chosen = evenly(100_000, 2000);
        assert_eq!(chosen.len(), 2000);
        assert!(chosen.is_sorted_by(|a, b| a < b));
        assert_eq!((chosen[0], chosen[1999]), (0, 99_999));
    }

    #[test]
    fn few_points_all_stay() {
        for count in 0..5 {
            let all: Vec<usize> = (0..count).collect();
            assert_eq!(extremes(&vec![1.0; count], 4), all);
            assert_eq!(evenly(count, 4), all);
        }
    }
}
