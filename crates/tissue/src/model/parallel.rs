//! The parts of a large body, in which forces are computed in parallel.

use crate::elements::Elements;
use std::ops::Range;
use std::sync::Arc;

/// Bodies with at least this many tetrahedra compute forces in parallel parts. Below it, handing work to threads (13–21 µs
/// with rayon, measured) costs more than it saves.
pub(super) const PARALLEL_ELEMENTS: usize = 4096;

/// Parts of a parallel body. It depends on the model alone, never on the number of threads.
const PARALLEL_PARTS: usize = 8;

/// What one part of a parallel loop over the elements computes.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Elements of each set.
    pub elements: Vec<Range<usize>>,
    /// The run of nodes that they touch.
    pub nodes: Range<u32>,
}

/// Cuts every set in runs of equal size.
pub(super) fn parts(tets: usize, nodes: usize, sets: &[Arc<dyn Elements>]) -> Vec<Part> {
    if tets < PARALLEL_ELEMENTS {
        let elements = sets.iter().map(|set| 0..set.count()).collect();
        return vec![Part {
            elements,
            nodes: 0..nodes as u32,
        }];
    }
    let part = |index: usize| {
        let elements: Vec<Range<usize>> = sets
            .iter()
            .map(|set| {
                let bound = |index: usize| set.count() * index / PARALLEL_PARTS;
                bound(index)..bound(index + 1)
            })
            .collect();
        let touched = || {
            let runs = sets.iter().zip(&elements);
            runs.flat_map(|(set, run)| run.clone().flat_map(|e| set.nodes(e).iter().copied()))
        };
        let nodes = touched().min().unwrap_or(0)..touched().max().map_or(0, |node| node + 1);
        Part { elements, nodes }
    };
    (0..PARALLEL_PARTS).map(part).collect()
}

/// Follows an edit: `placed` are the places of each set where there are other elements now. Runs stay where they are but for the
/// last one; once it has grown to twice its size at the start all are cut again, which takes a time that goes with the body.
pub(super) fn follow(
    all: &mut Vec<Part>,
    tets: usize,
    nodes: usize,
    sets: &[Arc<dyn Elements>],
    placed: &[&[u32]],
) {
    let grown = |last: &Part| {
        let mut runs = sets.iter().zip(&last.elements);
        runs.any(|(set, run)| {
            let (count, length) = (set.count(), set.count().checked_sub(run.start));
            length.is_none_or(|length| length * PARALLEL_PARTS > 2 * count + PARALLEL_ELEMENTS)
        })
    };
    if all.len() == 1 || all.last().is_none_or(grown) {
        *all = parts(tets, nodes, sets);
        return;
    }
    for (set, (elements, placed)) in sets.iter().zip(placed).enumerate() {
        if let Some(last) = all.last_mut() {
            last.elements[set].end = elements.count();
        }
        for &place in *placed {
            let part = all.partition_point(|part| part.elements[set].end <= place as usize);
            let window = &mut all[part].nodes;
            for &node in elements.nodes(place as usize) {
                // A part without elements has no window yet.
                *window = match window.start == window.end {
                    true => node..node + 1,
                    false => window.start.min(node)..window.end.max(node + 1),
                };
            }
        }
    }
    for part in all {
        part.nodes.end = part.nodes.end.min(nodes as u32);
        part.nodes.start = part.nodes.start.min(part.nodes.end);
    }
}
