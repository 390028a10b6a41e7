//! The smallest set of faces between two parts: a maximum flow along shortest paths (Edmonds and Karp 1972).

use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Of the network: everything beyond it on one side.
const SOURCE: u32 = u32::MAX;

/// And on the other.
const SINK: u32 = u32::MAX - 1;

/// A network of elements, joined by faces.
#[derive(Default)]
pub(crate) struct Flow {
    /// What may still flow from one element to another.
    rest: BTreeMap<u32, BTreeMap<u32, u32>>,
}

impl Flow {
    /// Joins `from` to `to`, in this direction.
    pub(crate) fn join(&mut self, from: u32, to: u32, capacity: u32) {
        *self.rest.entry(from).or_default().entry(to).or_default() += capacity;
        self.rest.entry(to).or_default().entry(from).or_default();
    }

    /// Joins the source to an element.
    pub(crate) fn add_source(&mut self, element: u32, capacity: u32) {
        self.join(SOURCE, element, capacity);
    }

    /// Joins an element to the sink.
    pub(crate) fn add_sink(&mut self, element: u32, capacity: u32) {
        self.join(element, SINK, capacity);
    }

    /// The elements on the source's side of a cut of least capacity; `None` where that is `most` or more, or where nothing flows.
    pub(crate) fn source_side(mut self, most: u32) -> Option<BTreeSet<u32>> {
        let mut total = 0_u32;
        loop {
            let mut before = BTreeMap::from([(SOURCE, SOURCE)]);
            let mut open = VecDeque::from([SOURCE]);
            while let Some(element) = open.pop_front()
                && !before.contains_key(&SINK)
            {
                for (&other, &rest) in self.rest.get(&element).into_iter().flatten() {
                    if rest > 0 && !before.contains_key(&other) {
                        before.insert(other, element);
                        open.push_back(other);
                    }
                }
            }
            if !before.contains_key(&SINK) {
                let side = before.into_keys().filter(|&e| e != SOURCE).collect();
                return (total > 0).then_some(side);
            }
            let mut path = Vec::new();
            let mut at = SINK;
            while at != SOURCE {
                path.push([before[&at], at]);
                at = before[&at];
            }
            let rest = |flow: &Self, [a, b]: [u32; 2]| flow.rest[&a][&b];
            let most_here = path
                .iter()
                .map(|&pair| rest(&self, pair))
                .min()
                .unwrap_or(0);
            for [a, b] in path {
                self.add(a, b, -i64::from(most_here));
                self.add(b, a, i64::from(most_here));
            }
            total = total.saturating_add(most_here);
            if total >= most {
                return None;
            }
        }
    }

    fn add(&mut self, from: u32, to: u32, amount: i64) {
        let rest = self.rest.entry(from).or_default().entry(to).or_default();
        *rest = u32::try_from(i64::from(*rest) + amount).unwrap_or(u32::MAX);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two elements between source and sink in a row, beside a passage through a third: the cut goes where it is cheapest.
    #[test]
    fn a_cut_takes_the_least_capacity() {
        let mut flow = Flow::default();
        flow.add_source(0, 4);
        flow.add_source(2, 2);
        for (a, b, capacity) in [(0, 1, 1), (0, 2, 1)] {
            flow.join(a, b, capacity);
            flow.join(b, a, capacity);
        }
        flow.add_sink(1, 4);
        flow.add_sink(2, 1);
        // 0–1 and 2–sink: 2; every other cut has 3 or more.
        assert_eq!(flow.source_side(3), Some(BTreeSet::from([0, 2])));
    }

    #[test]
    fn what_costs_too_much_or_is_not_joined_has_no_cut() {
        let mut flow = Flow::default();
        flow.add_source(0, 5);
        flow.add_sink(0, 5);
        assert_eq!(flow.source_side(5), None);
        let mut flow = Flow::default();
        flow.add_source(0, 5);
        flow.add_sink(1, 5);
        assert_eq!(flow.source_side(5), None);
    }
}
