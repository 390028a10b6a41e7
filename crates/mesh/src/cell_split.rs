//! Hexahedral cells cut into six or five tetrahedra (NUMERICS 5).

use microsim_vocabulary::CellSplit;

/// The orders in which the axes are walked, each with whether the path is positively oriented (even permutation).
const WALKS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], true),
    ([0, 2, 1], false),
    ([1, 0, 2], false),
    ([1, 2, 0], true),
    ([2, 0, 1], true),
    ([2, 1, 0], false),
];

/// The corners of the five: in the middle of the cell, and at each corner that it leaves; positively oriented.
const FIVE: [[[usize; 3]; 4]; 5] = [
    [[0, 0, 0], [1, 0, 1], [1, 1, 0], [0, 1, 1]],
    [[1, 0, 0], [1, 1, 0], [0, 0, 0], [1, 0, 1]],
    [[0, 1, 0], [0, 0, 0], [1, 1, 0], [0, 1, 1]],
    [[0, 0, 1], [0, 1, 1], [1, 0, 1], [0, 0, 0]],
    [[1, 1, 1], [1, 0, 1], [0, 1, 1], [1, 1, 0]],
];

/// Whether every second cell along each axis is the mirror image of its neighbour, so that a ring needs an even number.
pub(crate) const fn is_mirrored(split: CellSplit) -> bool {
    match split {
        CellSplit::Kuhn => false,
        CellSplit::Mirrored | CellSplit::Five => true,
    }
}

/// The tetrahedra of the cell between the grid points `cell` and `cell` + 1, as grid points; positive where the grid axes are right-handed.
pub(crate) fn cell_tets(
    split: CellSplit,
    cell: [usize; 3],
) -> impl Iterator<Item = [[usize; 3]; 4]> {
    let mirrored = cell.map(|i| is_mirrored(split) && i % 2 == 1);
    // Each mirrored axis turns the orientation of every element.
    let turned = mirrored.iter().filter(|&&m| m).count() % 2 == 1;
    let at = move |corner: [usize; 3]| {
        [0, 1, 2].map(|axis| cell[axis] + usize::from((corner[axis] == 1) != mirrored[axis]))
    };
    (0..split.tetrahedra()).map(move |index| {
        let (corners, positive) = match split {
            CellSplit::Kuhn | CellSplit::Mirrored => walk(WALKS[index]),
            CellSplit::Five => (FIVE[index], true),
        };
        let mut tet = corners.map(at);
        if positive == turned {
            tet.swap(2, 3);
        }
        tet
    })
}

/// The corners on the path from one end of the space diagonal to the other, and whether they are positively oriented.
fn walk((axes, positive): ([usize; 3], bool)) -> ([[usize; 3]; 4], bool) {
    let mut corners = [[0; 3]; 4];
    for (step, axis) in axes.into_iter().enumerate() {
        corners[step + 1] = corners[step];
        corners[step + 1][axis] = 1;
    }
    (corners, positive)
}
