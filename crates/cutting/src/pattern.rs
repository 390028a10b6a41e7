//! Patterns: how a tetrahedron is divided whose edges are crossed (appendix B with the corrections of NUMERICS 4).
//!
//! Six patterns in canonical position cover all 41 sets of edges that do not hold all three of a face; a permutation of
//! the corners brings a tetrahedron there. On the faces everything depends on that face alone: which of its edges are
//! crossed, and on each quad the diagonal that starts at the corner with the smaller id (NUMERICS 4.8). So neighbours fit
//! without knowing of each other, and no inner node is ever needed.

use std::sync::LazyLock;

/// The six edges of a tetrahedron as pairs of corners.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// A set of the six edges: bit k for `EDGES[k]`.
pub type EdgeSet = u8;

/// A node of a divided tetrahedron: of the edge between two corners the copy nearer to the first; twice the same corner
/// is that corner.
pub type PatternNode = [u8; 2];

const fn corner(i: u8) -> PatternNode {
    [i, i]
}
const A: PatternNode = corner(0);
const B: PatternNode = corner(1);
const C: PatternNode = corner(2);
const D: PatternNode = corner(3);
const AC: PatternNode = [0, 2];
const CA: PatternNode = [2, 0];
const AD: PatternNode = [0, 3];
const DA: PatternNode = [3, 0];
const BC: PatternNode = [1, 2];
const CB: PatternNode = [2, 1];
const BD: PatternNode = [1, 3];
const DB: PatternNode = [3, 1];
const CD: PatternNode = [2, 3];
const DC: PatternNode = [3, 2];

/// Tetrahedra of a pattern, and when they are there.
pub struct Row {
    /// Pairs of corners of which the first has the smaller id: then the diagonal between their edges starts at it.
    pub when: &'static [[usize; 2]],
    /// The tetrahedra, positive for a positive parent.
    pub tets: &'static [[PatternNode; 4]],
}

/// A pattern in canonical position.
pub struct Pattern {
    /// Its letter.
    pub name: char,
    /// The crossed edges.
    pub crossed: &'static [[usize; 2]],
    /// Its tetrahedra: all rows whose condition holds.
    pub rows: &'static [Row],
}

/// Appendix B, corrected, with the missing F (NUMERICS 4.1–4.6). Of D and E those rows that the rule for diagonals can ask
/// for.
pub static PATTERNS: [Pattern; 6] = [
    Pattern {
        name: 'A',
        crossed: &[[0, 3]],
        rows: &[Row {
            when: &[],
            tets: &[[A, B, C, AD], [DA, B, C, D]],
        }],
    },
    Pattern {
        name: 'B',
        crossed: &[[0, 3], [1, 3]],
        rows: &[
            Row {
                when: &[],
                tets: &[[DA, DB, C, D]],
            },
            Row {
                when: &[[0, 1]],
                tets: &[[A, B, C, BD], [A, BD, C, AD]],
            },
            Row {
                when: &[[1, 0]],
                tets: &[[A, B, C, AD], [AD, B, C, BD]],
            },
        ],
    },
    Pattern {
        name: 'C',
        crossed: &[[0, 3], [1, 3], [1, 2]],
        rows: &[
            Row {
                when: &[],
                tets: &[[A, CB, C, AD]],
            },
            Row {
                when: &[[0, 1]],
                tets: &[[A, B, BC, BD], [A, BD, BC, AD]],
            },
            Row {
                when: &[[1, 0]],
                tets: &[[A, B, BC, AD], [B, BD, BC, AD]],
            },
            Row {
                when: &[[3, 2]],
                tets: &[[DA, DB, CB, D], [DA, CB, C, D]],
            },
            Row {
                when: &[[2, 3]],
                tets: &[[C, DB, D, DA], [C, DB, DA, CB]],
            },
        ],
    },
    Pattern {
        name: 'D',
        crossed: &[[0, 3], [1, 3], [2, 3]],
        rows: &[
            Row {
                when: &[],
                tets: &[[DA, DB, DC, D]],
            },
            Row {
                when: &[[0, 1], [2, 1]],
                tets: &[[A, B, C, BD]],
            },
            Row {
                when: &[[1, 0], [1, 2]],
                tets: &[[B, AD, BD, CD]],
            },
            Row {
                when: &[[0, 1], [1, 2]],
                tets: &[[B, BD, CD, A]],
            },
            Row {
                when: &[[1, 0], [2, 1]],
                tets: &[[B, BD, C, AD]],
            },
            Row {
                when: &[[0, 2], [1, 2]],
                tets: &[[A, B, C, CD]],
            },
            Row {
                when: &[[2, 0], [2, 1]],
                tets: &[[C, AD, BD, CD]],
            },
            Row {
                when: &[[2, 0], [1, 2]],
                tets: &[[C, CD, AD, B]],
            },
            Row {
                when: &[[2, 1], [0, 2]],
                tets: &[[C, CD, A, BD]],
            },
            Row {
                when: &[[1, 0], [2, 0]],
                tets: &[[A, B, C, AD]],
            },
            Row {
                when: &[[0, 1], [0, 2]],
                tets: &[[A, AD, BD, CD]],
            },
            Row {
                when: &[[0, 1], [2, 0]],
                tets: &[[A, AD, BD, C]],
            },
            Row {
                when: &[[0, 2], [1, 0]],
                tets: &[[A, AD, B, CD]],
            },
        ],
    },
    // The diagonal of the cut itself is AC–BD on both sides, so that volumes add up where it is not plane (NUMERICS 4.5).
    Pattern {
        name: 'E',
        crossed: &[[0, 3], [1, 3], [0, 2], [1, 2]],
        rows: &[
            Row {
                when: &[[0, 1]],
                tets: &[[B, A, BD, BC], [AD, A, AC, BD], [BC, AC, A, BD]],
            },
            Row {
                when: &[[1, 0]],
                tets: &[[AD, A, AC, B], [BD, AD, AC, B], [B, AC, BD, BC]],
            },
            Row {
                when: &[[2, 3]],
                tets: &[[C, D, DA, DB], [CA, DA, DB, C], [C, CA, CB, DB]],
            },
            Row {
                when: &[[3, 2]],
                tets: &[[C, CA, CB, D], [CA, D, DA, DB], [CB, DB, D, CA]],
            },
        ],
    },
    Pattern {
        name: 'F',
        crossed: &[[0, 3], [1, 2]],
        rows: &[Row {
            when: &[],
            tets: &[
                [A, B, BC, AD],
                [A, CB, C, AD],
                [DA, B, BC, D],
                [DA, CB, C, D],
            ],
        }],
    },
];

/// Where a set of edges stands: its pattern, and the corner of the tetrahedron for each corner of the pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Position {
    pattern: usize,
    corners: [usize; 4],
    /// Whether the permutation is odd: then every child is reflected.
    odd: bool,
}

/// Number of the edge between two corners.
pub fn edge_between(i: usize, j: usize) -> usize {
    match (i.min(j), i.max(j)) {
        (0, k) => k - 1,
        (1, k) => k + 1,
        _ => 5,
    }
}

/// Position of each of the 64 sets.
static POSITIONS: LazyLock<[Option<Position>; 64]> = LazyLock::new(|| {
    let mut positions = [None; 64];
    for corners in permutations() {
        let inversions = (0..4)
            .flat_map(|j| (0..j).map(move |i| (i, j)))
            .filter(|&(i, j)| corners[i] > corners[j]);
        let odd = inversions.count() % 2 == 1;
        for (pattern, data) in PATTERNS.iter().enumerate() {
            let set = data.crossed.iter().fold(0, |set, &[i, j]| {
                set | 1 << edge_between(corners[i], corners[j])
            });
            let place: &mut Option<Position> = &mut positions[set];
            // An even permutation where there is one.
            if place.is_none_or(|p| p.odd && !odd) {
                *place = Some(Position {
                    pattern,
                    corners,
                    odd,
                });
            }
        }
    }
    positions
});

/// The 24 orders of four corners.
fn permutations() -> impl Iterator<Item = [usize; 4]> {
    (0..256).filter_map(|code: usize| {
        let order = [code / 64, code / 16 % 4, code / 4 % 4, code % 4];
        (1..4)
            .all(|i| !order[..i].contains(&order[i]))
            .then_some(order)
    })
}

/// The children of a tetrahedron whose edges in `set` are crossed, positive where it is positive; `ids` are those of its
/// corners. Empty for a set that no pattern is for.
pub fn divide(set: EdgeSet, ids: [u32; 4]) -> Vec<[PatternNode; 4]> {
    let Some(Position {
        pattern,
        corners,
        odd,
    }) = POSITIONS[set as usize]
    else {
        return Vec::new();
    };
    let rows = PATTERNS[pattern].rows.iter().filter(|row| {
        let holds = |&[i, j]: &[usize; 2]| ids[corners[i]] < ids[corners[j]];
        row.when.iter().all(holds)
    });
    rows.flat_map(|row| row.tets)
        .map(|tet| {
            let mut child =
                tet.map(|[near, far]| [corners[near as usize] as u8, corners[far as usize] as u8]);
            if odd {
                child.swap(2, 3);
            }
            child
        })
        .collect()
}

#[cfg(test)]
mod tests;
