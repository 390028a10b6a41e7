//! How the steps of a tick are divided for fast tools: evenly while a tool is near tissue, and not where none is.

/// A tick in even parts, and the ends of its steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Division {
    /// Of the tick.
    parts: u32,
    /// The part that each step ends with, ascending; the last one is `parts`. Empty where each part is a step: explicit methods have millions.
    ends: Vec<u32>,
}

impl Division {
    /// Steps of equal length; at least one.
    pub fn even(steps: u32) -> Self {
        Self {
            parts: steps.max(1),
            ends: Vec::new(),
        }
    }

    /// So many steps, of which each has as many parts: those in which a tool is near tissue are steps of their own, and those between are one.
    pub fn around(near: &[bool], steps: u32) -> Self {
        let parts = near.len() as u32;
        let of_step = parts / steps.max(1);
        let is_end = |part: u32| {
            let next = near.get(part as usize + 1);
            (part + 1).is_multiple_of(of_step.max(1))
                || near[part as usize]
                || next.is_none_or(|near| *near)
        };
        let ends: Vec<u32> = (0..parts)
            .filter(|part| is_end(*part))
            .map(|part| part + 1)
            .collect();
        if ends.len() == near.len() {
            return Self::even(parts);
        }
        Self { parts, ends }
    }

    /// The same with each step divided into so many.
    pub fn divided(&self, factor: u32) -> Self {
        if self.ends.is_empty() {
            return Self::even(self.parts.saturating_mul(factor));
        }
        let mut ends = Vec::new();
        for step in 0..self.count() {
            let [from, to] = self.step(step);
            ends.extend((1..=factor).map(|k| from.saturating_mul(factor) + (to - from) * k));
        }
        Self {
            parts: self.parts.saturating_mul(factor),
            ends,
        }
    }

    /// Number of steps.
    pub fn count(&self) -> u32 {
        match self.ends.len() as u32 {
            0 => self.parts,
            count => count,
        }
    }

    /// Number of even parts.
    pub fn parts(&self) -> u32 {
        self.parts
    }

    /// From which to which part a step goes.
    pub fn step(&self, step: u32) -> [u32; 2] {
        if self.ends.is_empty() {
            return [step, step + 1];
        }
        let end = |step: u32| self.ends[step as usize];
        [step.checked_sub(1).map_or(0, end), end(step)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(of: &Division) -> Vec<[u32; 2]> {
        (0..of.count()).map(|step| of.step(step)).collect()
    }

    #[test]
    fn parts_without_a_tool_nearby_are_one_step() {
        let even = Division::even(3);
        assert_eq!(steps(&even), [[0, 1], [1, 2], [2, 3]]);
        assert_eq!(
            Division::around(&[true; 3], 1),
            even,
            "near all of the time"
        );
        let far = Division::around(&[false; 6], 1);
        assert_eq!(steps(&far), [[0, 6]]);
        let lands = Division::around(&[false, false, false, true, true, false, false], 1);
        assert_eq!(steps(&lands), [[0, 3], [3, 4], [4, 5], [5, 7]]);
        assert_eq!(lands.parts(), 7);
        // Steps that were asked for stay.
        let two = Division::around(&[false, false, false, false, false, true], 2);
        assert_eq!(steps(&two), [[0, 3], [3, 5], [5, 6]]);
        let halves = two.divided(2);
        assert_eq!(
            steps(&halves),
            [[0, 3], [3, 6], [6, 8], [8, 10], [10, 11], [11, 12]]
        );
        assert_eq!(halves.parts(), 12);
        assert_eq!(Division::even(2).divided(4), Division::even(8));
    }
}
