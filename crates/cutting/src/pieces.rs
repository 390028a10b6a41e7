//! What comes off: parts that hang together by faces, searched from the cut outwards.
//!
//! Searches start at every element on both sides of what was laid open, all at once, one element each in turn. Two that meet are
//! one. As soon as a single one is left unfinished the others are pieces, so the cost is that of the smaller parts, and of a partial
//! cut that of the way around its edge.

use crate::topology::{NONE, Topology};

/// One search.
#[derive(Default)]
struct Search {
    found: Vec<u32>,
    /// Up to here `found` has been looked at.
    done: usize,
}

/// The parts, other than the largest, that have no way by faces to the rest from `seeds`; each ascending, in the order of their first
/// elements.
pub(crate) fn come_off(topology: &Topology, seeds: impl IntoIterator<Item = u32>) -> Vec<Vec<u32>> {
    let mut searches: Vec<Search> = Vec::new();
    // Search of each element, from 1. Memory that is not looked at costs nothing.
    let mut owner = vec![0_u32; topology.tets.len()];
    for seed in seeds {
        if owner[seed as usize] == 0 {
            searches.push(Search {
                found: vec![seed],
                done: 0,
            });
            owner[seed as usize] = searches.len() as u32;
        }
    }
    let mut root: Vec<usize> = (0..searches.len()).collect();
    let mut alive = root.clone();
    let mut finished: Vec<usize> = Vec::new();
    while alive.len() > 1 {
        let mut k = 0;
        while k < alive.len() && alive.len() > 1 {
            let mut this = alive[k];
            let Some(&element) = searches[this].found.get(searches[this].done) else {
                finished.push(this);
                alive.remove(k);
                continue;
            };
            searches[this].done += 1;
            for other in topology.neighbours[element as usize] {
                if other == NONE {
                    continue;
                }
                let owned = owner[other as usize];
                if owned == 0 {
                    owner[other as usize] = this as u32 + 1;
                    searches[this].found.push(other);
                    continue;
                }
                let theirs = find(&mut root, owned as usize - 1);
                if theirs == this {
                    continue;
                }
                // The longer list takes what the other has found and what it has still to look at.
                let (into, from) = if searches[theirs].found.len() > searches[this].found.len() {
                    (theirs, this)
                } else {
                    (this, theirs)
                };
                let Search { found, done } = std::mem::take(&mut searches[from]);
                let target = &mut searches[into];
                target
                    .found
                    .splice(target.done..target.done, found[..done].iter().copied());
                target.done += done;
                target.found.extend(&found[done..]);
                root[from] = into;
                if let Some(place) = alive.iter().position(|&s| s == from) {
                    alive.remove(place);
                    if place < k {
                        k -= 1;
                    }
                }
                this = into;
            }
            // The search may have become one that stands elsewhere in the list.
            if alive.get(k) == Some(&this) {
                k += 1;
            }
        }
    }
    if alive.is_empty() || searches.is_empty() {
        // All ended: the largest is the body.
        let size = |s: &usize| searches[*s].found.len();
        if let Some(at) = (0..finished.len())
            .rev()
            .max_by_key(|&i| size(&finished[i]))
        {
            finished.remove(at);
        }
    }
    let mut pieces: Vec<Vec<u32>> = finished
        .into_iter()
        .map(|s| {
            let mut piece = std::mem::take(&mut searches[s].found);
            piece.sort_unstable();
            piece
        })
        .collect();
    pieces.sort_unstable();
    pieces
}

fn find(root: &mut [usize], mut s: usize) -> usize {
    while root[s] != s {
        root[s] = root[root[s]];
        s = root[s];
    }
    s
}
