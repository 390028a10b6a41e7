//! What comes off: parts that hang together by faces, searched from the cut outwards.
//!
//! Searches start at every element on both sides of what was laid open, all at once, one element each in turn. Two that meet are
//! one. As soon as of those that were one part before a single one is left unfinished the others are pieces, so the cost is
//! that of the smaller parts, and of a partial cut that of the path around its edge.

use crate::topology::{NONE, Topology};
use std::collections::BTreeMap;

/// One search.
#[derive(Default)]
struct Search {
    found: Vec<u32>,
    /// Up to here `found` has been looked at.
    done: usize,
}

/// The parts that have come off as the two elements of each of `pairs` came apart, each ascending, in the order of their first
/// elements. Of what was one part the largest is not listed.
pub(crate) fn come_off(topology: &Topology, pairs: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut searches = Searches::new(topology, pairs);
    while searches.round(topology) {}
    searches.pieces()
}

struct Searches {
    searches: Vec<Search>,
    /// Search of each element, from 1. Memory that is not looked at costs nothing.
    owner: Vec<u32>,
    /// Searches that have become one.
    same: Groups,
    /// Searches in what was one part before.
    part: Groups,
    /// Number of unfinished searches in each part, by its root.
    unfinished: Vec<usize>,
    alive: Vec<usize>,
    finished: Vec<usize>,
}

impl Searches {
    fn new(topology: &Topology, pairs: &[[u32; 2]]) -> Self {
        let mut searches: Vec<Search> = Vec::new();
        let mut owner = vec![0_u32; topology.tets.len()];
        for &seed in pairs.iter().flatten() {
            if owner[seed as usize] == 0 {
                searches.push(Search {
                    found: vec![seed],
                    done: 0,
                });
                owner[seed as usize] = searches.len() as u32;
            }
        }
        let count = searches.len();
        let mut part = Groups::new(count);
        for pair in pairs {
            let [a, b] = pair.map(|e| owner[e as usize] as usize - 1);
            part.join(a, b);
        }
        let mut unfinished = vec![0; count];
        for search in 0..count {
            unfinished[part.root(search)] += 1;
        }
        Self {
            searches,
            owner,
            same: Groups::new(count),
            part,
            unfinished,
            alive: (0..count).collect(),
            finished: Vec::new(),
        }
    }

    /// Lets every search look at one more element; false when nothing is left to find out.
    fn round(&mut self, topology: &Topology) -> bool {
        let mut any = false;
        for search in std::mem::take(&mut self.alive) {
            if self.same.root(search) != search {
                continue;
            }
            let part = self.part.root(search);
            if self.unfinished[part] <= 1 {
                // Another part may turn out to be the same as this.
                self.alive.push(search);
                continue;
            }
            any = true;
            let this = &mut self.searches[search];
            let Some(&element) = this.found.get(this.done) else {
                self.unfinished[part] -= 1;
                self.finished.push(search);
                continue;
            };
            this.done += 1;
            let mut into = search;
            for other in topology.neighbours[element as usize] {
                if other != NONE {
                    into = self.meet(into, other);
                }
            }
            // One that it has become part of takes its own turn.
            if into == search {
                self.alive.push(search);
            }
        }
        any
    }

    /// The search `this` has come to an element; returns the search that it is from now on.
    fn meet(&mut self, this: usize, element: u32) -> usize {
        let owner = &mut self.owner[element as usize];
        if *owner == 0 {
            *owner = this as u32 + 1;
            self.searches[this].found.push(element);
            return this;
        }
        let other = self.same.root(*owner as usize - 1);
        if other == this {
            return this;
        }
        let (one, two) = (self.part.root(this), self.part.root(other));
        let sum = if one == two {
            self.unfinished[one]
        } else {
            self.unfinished[one] + self.unfinished[two]
        };
        self.part.join(one, two);
        let root = self.part.root(one);
        self.unfinished[root] = sum - 1;
        // The longer list takes what the other has found, and what that has still to look at.
        let (into, from) = if self.searches[other].found.len() > self.searches[this].found.len() {
            (other, this)
        } else {
            (this, other)
        };
        let Search { found, done } = std::mem::take(&mut self.searches[from]);
        let target = &mut self.searches[into];
        let at = target.done;
        target.found.splice(at..at, found[..done].iter().copied());
        target.done += done;
        target.found.extend(&found[done..]);
        self.same.point(from, into);
        into
    }

    fn pieces(mut self) -> Vec<Vec<u32>> {
        // Where all searches of a part have ended the largest is what is left of it.
        let mut largest: BTreeMap<usize, usize> = BTreeMap::new();
        for &search in &self.finished {
            let part = self.part.root(search);
            if self.unfinished[part] > 0 {
                continue;
            }
            let size = |s: usize| self.searches[s].found.len();
            let best = largest.entry(part).or_insert(search);
            if size(search) > size(*best) {
                *best = search;
            }
        }
        let rest: Vec<usize> = largest.into_values().collect();
        let finished = self.finished.into_iter().filter(|s| !rest.contains(s));
        let mut pieces: Vec<Vec<u32>> = finished
            .map(|s| {
                let mut piece = std::mem::take(&mut self.searches[s].found);
                piece.sort_unstable();
                piece
            })
            .collect();
        pieces.sort_unstable();
        pieces
    }
}

/// Disjoint groups of the numbers below a bound (union–find).
struct Groups {
    parent: Vec<usize>,
}

impl Groups {
    fn new(count: usize) -> Self {
        Self {
            parent: (0..count).collect(),
        }
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.root(i), self.root(j));
        self.point(i.max(j), i.min(j));
    }

    /// Puts the group with root `from` under `into`.
    fn point(&mut self, from: usize, into: usize) {
        self.parent[from] = into;
    }
}
