//! Every number and figure of the dissertation with a section: what is printed, what comes out by the same method and by ours, and where it is measured.
//!
//! Where something is measured by a command of its own the row leads there.

use crate::Drawings;
use microsim_mesh::{Arc, CellSplit, Layer, TetMesh, Tube};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Edges of a tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Describes it.
pub fn list(text: &mut String) -> Result<Drawings, String> {
    let six = counts(&tube([9, 13], CellSplit::Kuhn)?);
    let five = counts(&tube([8, 13], CellSplit::Five)?);
    let rows = [
        (
            "3.1: 25 pictures a second, all in them",
            "no time of a whole picture".into(),
            "ticks of 16 ms, of which a level may take 11 ms; pictures beside them".into(),
            "`cargo xtask bench coordination`, `soak matrix`; [bench_coordination.md](bench_coordination.md), [picture.md](picture.md)",
        ),
        (
            "3.3, figure 3.2: five tetrahedra in a cell",
            "no number".into(),
            format!("a tube of 8 × 13 cells of five has {five}"),
            "section 3.3 below",
        ),
        (
            "3.5: bounds of steps (3.21, 3.22), no figure of them",
            "no number".into(),
            "limits of every integrator, law and element measured against predicted ones, with (3.21)".into(),
            "`microsim atlas`; [atlas.md](atlas/atlas.md); scenes `euler-diverges`, `euler-damped`, `lagged-diverges`",
        ),
        (
            "4.3: tubes of 252 nodes and 702 tetrahedra",
            format!("9 around, 13 along, six in a cell: {six}"),
            "the same".into(),
            "section 4.3 below, scene `two-tubes`",
        ),
        (
            "figures 4.12, 4.13: time over tetrahedra, and over the cell of the hash",
            "curves without numbers".into(),
            "tables and drawings".into(),
            "section 4.3 below",
        ),
        (
            "figures 4.14 to 4.16: five bodies",
            "pictures without numbers".into(),
            "table and pictures".into(),
            "section 4.3 below, scene `five-bodies`",
        ),
        (
            "appendix B: parts of a cut tetrahedron",
            "A 2, B 3, C 5, D 3 + 1 (the tip is not listed), E 6; five where diagonals of D are cyclic".into(),
            "A 2, B 3, C 5, D 4, E 6; opposite edges 4; cyclic diagonals do not occur, as the smaller node of a quad decides (nine else, not five)".into(),
            "`cargo test -p microsim-cutting pattern`",
        ),
        (
            "5.1: box of 42 × 35 × 27 cm for the hands",
            "the box of the translator".into(),
            "mapped to the field with scale and clutch".into(),
            "`config/translator.toml`, [filters.md](filters.md)",
        ),
        (
            "5.2.2: modules (trimming, diagonal cut, dilatation, the hot wire, pushing)",
            "no result of a trainee".into(),
            "each with levels, scripts that pass and fail, and scores".into(),
            "`modules/*/README.md`, [matrix.md](matrix.md)",
        ),
    ];
    let _ = writeln!(
        text,
        "\n## Its numbers and figures\n\n| printed | by the same method | ours | measured by |\n|---|---|---|---|"
    );
    for (printed, same, ours, command) in rows {
        let _ = writeln!(text, "| {printed} | {same} | {ours} | {command} |");
    }
    Ok(Vec::new())
}

fn counts(mesh: &TetMesh) -> String {
    let edges: BTreeSet<[u32; 2]> = mesh
        .tets
        .iter()
        .flat_map(|tet| EDGES.map(|[i, j]| [tet[i].min(tet[j]), tet[i].max(tet[j])]))
        .collect();
    format!(
        "{} nodes, {} tetrahedra, {} edges, {} triangles of its surface",
        mesh.positions.len(),
        mesh.tets.len(),
        edges.len(),
        mesh.surface().triangles.len()
    )
}

/// The dissertation's tube, of so many cells around and along.
pub fn tube([around, along]: [usize; 2], split: CellSplit) -> Result<TetMesh, String> {
    let tube = Tube {
        inner_radius: 8e-3,
        layers: vec![Layer {
            thickness: 2e-3,
            cells: 1,
            region: 0,
        }],
        length: 60e-3,
        around,
        along,
        axis: [1.0, 0.0, 0.0],
        center: [0.0; 3],
        arc: Arc::Full,
        split,
    };
    tube.mesh().map_err(|e| e.to_string())
}
