//! When a level is mastered: so many passes in a row (the rule of Mimic and LapMentor, DOMAIN 2).

/// Index of the attempt with which a level was mastered, attempts in their order; `None`: it is not. What follows does not take it back.
pub fn mastered_with(passes: impl IntoIterator<Item = bool>, needed: u32) -> Option<usize> {
    let mut row = 0;
    for (attempt, passed) in passes.into_iter().enumerate() {
        row = if passed { row + 1 } else { 0 };
        if row >= needed.max(1) {
            return Some(attempt);
        }
    }
    None
}

/// Passes in a row at the end of the attempts.
pub fn passes_in_a_row(passes: &[bool]) -> usize {
    passes.iter().rev().take_while(|passed| **passed).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_passes_in_a_row_master_a_level() {
        let (yes, no) = (true, false);
        assert_eq!(mastered_with([], 1), None);
        assert_eq!(mastered_with([no, yes], 1), Some(1));
        assert_eq!(mastered_with([yes, no, yes, no, yes], 2), None);
        assert_eq!(mastered_with([yes, no, yes, yes, no], 2), Some(3));
        assert_eq!(passes_in_a_row(&[yes, no, yes, yes]), 2);
        assert_eq!(passes_in_a_row(&[yes, no]), 0);
    }
}
