//! Hexahedral cells cut into six tetrahedra (NUMERICS 5).

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

/// The six tetrahedra of the cell between the grid points `cell` and `cell` + 1, as grid points; positive where the
/// grid axes are right-handed.
pub(crate) fn cell_tets(split: CellSplit, cell: [usize; 3]) -> [[[usize; 3]; 4]; 6] {
    let mirrored = cell.map(|i| split == CellSplit::Mirrored && i % 2 == 1);
    // Each mirrored axis turns the orientation of every path.
    let turned = mirrored.iter().filter(|&&m| m).count() % 2 == 1;
    WALKS.map(|(axes, positive)| {
        let mut corner = [0, 1, 2].map(|axis| cell[axis] + usize::from(mirrored[axis]));
        let mut tet = [corner; 4];
        for (step, axis) in axes.into_iter().enumerate() {
            corner[axis] = if mirrored[axis] {
                cell[axis]
            } else {
                cell[axis] + 1
            };
            tet[step + 1] = corner;
        }
        if positive == turned {
            tet.swap(2, 3);
        }
        tet
    })
}
