//! The beam of `tests/data/reference`: meshes S, M and L, body and sag.

use microsim_mesh::format::{MeshFormat, read_tet_mesh, write_gmsh_2};
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_tests::repository;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Material, State, TissueModel,
    build_model,
};
use nalgebra::Vector3;
use std::path::Path;

/// Names of the meshes.
pub const MESHES: [&str; 3] = ["S", "M", "L"];

/// Cells along the beam of the meshes that quadratic tetrahedra are measured on, one cell high.
pub const FEW: [&str; 5] = ["3", "4", "5", "6", "8"];

/// Their tetrahedra.
pub const TETRAHEDRA: [usize; 3] = [810, 10_290, 51_840];

/// Length, height and depth \[m\].
const SIZE: [f64; 3] = [0.1, 0.02, 0.02];

/// A mesh by its name: S and M from the files of the reference, L as described there, or that of a number of cells, refined.
pub fn mesh(name: &str) -> TetMesh {
    if let Ok(cells) = name.parse() {
        let block = Block {
            center: SIZE.map(|size| size / 2.0),
            size: SIZE,
            cells: [cells, 1, 1],
            split: CellSplit::Kuhn,
        };
        let mesh = block.mesh().expect("a block with positive sizes");
        return mesh.refined().mesh;
    }
    if name == "L" {
        let block = Block {
            center: SIZE.map(|size| size / 2.0),
            size: SIZE,
            cells: [60, 12, 12],
            split: CellSplit::Kuhn,
        };
        return block.mesh().expect("a block with positive sizes");
    }
    let path = repository().join(format!("tests/data/reference/cantilever-{name}.msh"));
    let bytes = std::fs::read(&path).expect("the mesh of the reference");
    read_tet_mesh(MeshFormat::Gmsh, &[&bytes])
        .expect("a mesh")
        .mesh
}

/// Writes the meshes, as the scripts of the other engines read them, and the exact values beside them.
pub fn write_meshes(folder: &Path) -> Result<(), String> {
    let exact = repository().join("tests/peers/exact.json");
    std::fs::copy(&exact, folder.join("exact.json"))
        .map_err(|e| format!("{}: {e}", exact.display()))?;
    for name in MESHES {
        let path = folder.join(format!("cantilever-{name}.msh"));
        std::fs::write(&path, write_gmsh_2(&mesh(name)))
            .map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

/// A body that can be measured.
pub struct Beam {
    /// The body, clamped over the face x = 0.
    pub model: TissueModel,
    /// Gravity along −z.
    pub control: Control,
    end: Vec<usize>,
}

impl Beam {
    /// The beam of the reference.
    pub fn new(mesh: &TetMesh, law: LawName, discretisation: Discretisation) -> Self {
        let material = Material {
            density: 1000.0,
            relaxation_time: 0.0,
            behaviour: Behaviour::Continuum(ContinuumConstants {
                law: law.into(),
                young: 1e5,
                poisson: 0.3,
                discretisation,
                plasticity: None,
            }),
        };
        let clamped: Vec<bool> = mesh
            .positions
            .iter()
            .map(|p| p.x < 1e-6 * SIZE[0])
            .collect();
        let region = mesh.regions.first().copied().unwrap_or(0);
        let model = build_model(mesh, &[(region, material)], &clamped, 0.0, Vec::new())
            .expect("a valid beam");
        let at_end = |node: &usize| mesh.positions[*node].x > SIZE[0] * (1.0 - 1e-6);
        Self {
            end: (0..mesh.positions.len()).filter(at_end).collect(),
            model,
            control: Control {
                gravity: Vector3::new(0.0, 0.0, -9.81),
                ..Control::default()
            },
        }
    }

    /// Mean of the −z displacements of the nodes of the free end \[m\].
    pub fn sag(&self, state: &State) -> f64 {
        let drop = |&node: &usize| self.model.rest_positions()[node].z - state.positions[node].z;
        self.end.iter().map(drop).sum::<f64>() / self.end.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_have_the_tetrahedra_that_the_tables_say() {
        assert_eq!(MESHES.map(|name| mesh(name).tets.len()), TETRAHEDRA);
    }
}
