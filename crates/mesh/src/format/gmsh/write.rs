//! Gmsh files from a mesh, in ASCII: version 2.2, which other programs read too.

use crate::TetMesh;
use crate::format::assemble::DIRECTIONS;
use nalgebra::Vector3;
use std::fmt::Write;

/// `mesh` as a version 2.2 file; the physical group of an element is its region. Gmsh itself takes groups up to 2³¹ − 1.
/// Prestretches are not written.
///
/// ```
/// use microsim_mesh::TetMesh;
/// use microsim_mesh::format::{MeshFormat, read_tet_mesh, write_gmsh_2};
/// use nalgebra::Vector3;
///
/// let corners = vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
/// let mesh = TetMesh::new(corners, vec![[0, 1, 2, 3]], vec![5]);
/// let import = read_tet_mesh(MeshFormat::Gmsh, &[&write_gmsh_2(&mesh)])?;
/// assert_eq!(import.mesh, mesh);
/// # Ok::<(), microsim_mesh::format::FormatError>(())
/// ```
pub fn write_gmsh_2(mesh: &TetMesh) -> Vec<u8> {
    let mut out = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n");
    let _ = writeln!(out, "{}", mesh.positions.len());
    for (index, p) in mesh.positions.iter().enumerate() {
        let _ = writeln!(out, "{} {:?} {:?} {:?}", index + 1, p.x, p.y, p.z);
    }
    let _ = writeln!(out, "$EndNodes\n$Elements\n{}", mesh.tets.len());
    for (index, (tet, region)) in mesh.tets.iter().zip(&mesh.regions).enumerate() {
        let [a, b, c, d] = tet.map(|node| u64::from(node) + 1);
        // Type 4, two tags: physical group and elementary entity, which Gmsh counts from 1.
        let _ = writeln!(
            out,
            "{} 4 2 {region} {} {a} {b} {c} {d}",
            index + 1,
            u64::from(*region) + 1
        );
    }
    out.push_str("$EndElements\n");
    write_directions(mesh, &mut out);
    out.into_bytes()
}

/// The fibre directions, if there are any, as a view for each family; elements are numbered from 1.
fn write_directions(mesh: &TetMesh, out: &mut String) {
    let count = mesh.directions.len();
    for (family, name) in DIRECTIONS.into_iter().enumerate() {
        let directions = || mesh.directions.iter().map(|of| of[family]);
        if directions().all(|of| of == Vector3::zeros()) {
            continue;
        }
        // One text tag, one real tag (the time), three whole ones: time step, components, elements.
        let _ = writeln!(out, "$ElementData\n1\n\"{name}\"\n1\n0\n3\n0\n3\n{count}");
        for (index, a) in directions().enumerate() {
            let _ = writeln!(out, "{} {:?} {:?} {:?}", index + 1, a.x, a.y, a.z);
        }
        out.push_str("$EndElementData\n");
    }
}
