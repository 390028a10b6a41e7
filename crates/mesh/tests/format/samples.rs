//! Meshes that the tests write and read.

use microsim_mesh::format::{Import, MeshFormat, read_tet_mesh};
use microsim_mesh::{Block, CellSplit, TetMesh};

/// Two Kuhn cells of six elements each, regions 1 and 2, coordinates that no short decimal holds.
pub fn two_cells() -> TetMesh {
    let block = Block {
        center: [0.1, -0.2, 0.0],
        size: [2.0 / 3.0, 0.1, 1e-7],
        cells: [2, 1, 1],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().unwrap();
    for (element, region) in mesh.regions.iter_mut().enumerate() {
        *region = 1 + element as u32 / 6;
    }
    mesh
}

/// The tube of the two-tubes benchmark, made for this project.
pub fn reference_tube() -> TetMesh {
    let file = include_bytes!("data/tube-9x13x1.msh");
    read_tet_mesh(MeshFormat::Gmsh, &[file]).unwrap().mesh
}

/// Reads one file that must be readable.
pub fn import(format: MeshFormat, file: &[u8]) -> Import {
    read_tet_mesh(format, &[file]).unwrap_or_else(|error| panic!("{format:?}: {error}"))
}

/// Same bits, not only equal numbers (zero has two signs).
#[track_caller]
pub fn assert_same(mesh: &TetMesh, expected: &TetMesh) {
    let bits = |mesh: &TetMesh| -> Vec<u64> {
        mesh.positions
            .iter()
            .flat_map(|p| [p.x.to_bits(), p.y.to_bits(), p.z.to_bits()])
            .collect()
    };
    assert_eq!(bits(mesh), bits(expected));
    assert_eq!(mesh, expected);
}
