//! Writers of the formats that are only read: what the tests feed to the readers, in the shortest form that reads back to the same bits.

use microsim_mesh::{TetMesh, TriangleSurface};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::fmt::Write;

/// `mesh` as an ASCII file of version 4.2, which every reader knows; regions as the cell array "region".
pub fn write_vtk_legacy(mesh: &TetMesh) -> Vec<u8> {
    let mut out = String::from(
        "# vtk DataFile Version 4.2\nMicroSim mesh\nASCII\nDATASET UNSTRUCTURED_GRID\n",
    );
    let _ = writeln!(out, "POINTS {} double", mesh.positions.len());
    for p in &mesh.positions {
        let _ = writeln!(out, "{:?} {:?} {:?}", p.x, p.y, p.z);
    }
    let cells = mesh.tets.len();
    let _ = writeln!(out, "CELLS {cells} {}", 5 * cells);
    for [a, b, c, d] in &mesh.tets {
        let _ = writeln!(out, "4 {a} {b} {c} {d}");
    }
    let _ = writeln!(out, "CELL_TYPES {cells}");
    out.push_str(&"10\n".repeat(cells));
    let _ = writeln!(
        out,
        "CELL_DATA {cells}\nSCALARS region unsigned_int\nLOOKUP_TABLE default"
    );
    for region in &mesh.regions {
        let _ = writeln!(out, "{region}");
    }
    for (family, name) in families(mesh) {
        let _ = writeln!(out, "VECTORS {name} double");
        for a in mesh.directions.iter().map(|of| of[family]) {
            let _ = writeln!(out, "{:?} {:?} {:?}", a.x, a.y, a.z);
        }
    }
    out.into_bytes()
}

/// `mesh` as the `.node` and the `.ele` file, counted from 0; the attribute of a tetrahedron is its region.
pub fn write_tetgen(mesh: &TetMesh) -> [Vec<u8>; 2] {
    let mut node = format!("{} 3 0 0\n", mesh.positions.len());
    for (index, p) in mesh.positions.iter().enumerate() {
        let _ = writeln!(node, "{index} {:?} {:?} {:?}", p.x, p.y, p.z);
    }
    let mut ele = format!("{} 4 1\n", mesh.tets.len());
    for (index, (tet, region)) in mesh.tets.iter().zip(&mesh.regions).enumerate() {
        let [a, b, c, d] = tet;
        let _ = writeln!(ele, "{index} {a} {b} {c} {d} {region}");
    }
    [node.into_bytes(), ele.into_bytes()]
}

/// `surface` as an `.obj` file.
pub fn write_obj(surface: &TriangleSurface) -> Vec<u8> {
    let mut out = String::new();
    for p in &surface.positions {
        let _ = writeln!(out, "v {:?} {:?} {:?}", p.x, p.y, p.z);
    }
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|vertex| u64::from(vertex) + 1);
        let _ = writeln!(out, "f {a} {b} {c}");
    }
    out.into_bytes()
}

/// `surface` as an ASCII file. The corners read back to the same bits; vertices that no triangle uses are lost, as the
/// format has none.
pub fn write_stl_ascii(surface: &TriangleSurface) -> Vec<u8> {
    let mut out = String::from("solid MicroSim\n");
    for triangle in &surface.triangles {
        let corners = triangle.map(|vertex| surface.positions[vertex as usize]);
        let n = normal(&corners);
        let _ = writeln!(
            out,
            "facet normal {:?} {:?} {:?}\nouter loop",
            n.x, n.y, n.z
        );
        for p in corners {
            let _ = writeln!(out, "vertex {:?} {:?} {:?}", p.x, p.y, p.z);
        }
        out.push_str("endloop\nendfacet\n");
    }
    out.push_str("endsolid MicroSim\n");
    out.into_bytes()
}

/// `surface` as a binary file, which holds single precision only.
pub fn write_stl_binary(surface: &TriangleSurface) -> Vec<u8> {
    let mut out = vec![0; 80];
    out.extend_from_slice(&(surface.triangles.len() as u32).to_le_bytes());
    for triangle in &surface.triangles {
        let corners = triangle.map(|vertex| surface.positions[vertex as usize]);
        let [a, b, c] = corners;
        for vector in [normal(&corners), a, b, c] {
            for axis in 0..3 {
                out.extend_from_slice(&(vector[axis] as f32).to_le_bytes());
            }
        }
        out.extend_from_slice(&[0, 0]);
    }
    out
}

/// Unit normal by the right-hand rule; zero for a flat triangle.
fn normal([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a)
        .cross(&(c - a))
        .try_normalize(0.0)
        .unwrap_or_else(Vector3::zeros)
}

/// `mesh` as a version 4.1 file: one volume per region with that physical group (none for region 0). Elements keep their
/// order, so a volume has as many blocks as there are runs of its region.
pub fn write_gmsh_4(mesh: &TetMesh) -> Vec<u8> {
    let volumes = volumes(mesh);
    let mut out = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n");
    let _ = writeln!(out, "0 0 0 {}", volumes.len());
    for (region, volume) in &volumes {
        let [low, high] = volume.bounds;
        let _ = write!(
            out,
            "{} {:?} {:?} {:?} {:?} {:?} {:?}",
            volume.tag, low.x, low.y, low.z, high.x, high.y, high.z
        );
        let groups = if *region == 0 {
            String::from("0")
        } else {
            format!("1 {region}")
        };
        let _ = writeln!(out, " {groups} 0");
    }

    // All nodes in one block of the first volume.
    let nodes = mesh.positions.len();
    let _ = writeln!(
        out,
        "$EndEntities\n$Nodes\n1 {nodes} {} {nodes}",
        nodes.min(1)
    );
    let _ = writeln!(out, "3 1 0 {nodes}");
    for index in 1..=nodes {
        let _ = writeln!(out, "{index}");
    }
    for p in &mesh.positions {
        let _ = writeln!(out, "{:?} {:?} {:?}", p.x, p.y, p.z);
    }

    let elements = mesh.tets.len();
    let blocks = mesh.regions.chunk_by(|a, b| a == b);
    let _ = writeln!(
        out,
        "$EndNodes\n$Elements\n{} {elements} {} {elements}",
        blocks.clone().count(),
        elements.min(1)
    );
    let mut element = 0;
    for block in blocks {
        let _ = writeln!(out, "3 {} 4 {}", volumes[&block[0]].tag, block.len());
        for tet in &mesh.tets[element..element + block.len()] {
            element += 1;
            let [a, b, c, d] = tet.map(|node| u64::from(node) + 1);
            let _ = writeln!(out, "{element} {a} {b} {c} {d}");
        }
    }
    out.push_str("$EndElements\n");
    for (family, name) in families(mesh) {
        // One text tag, one real tag, three whole ones: time step, components, elements.
        let head = format!("$ElementData\n1\n\"{name}\"\n1\n0\n3\n0\n3\n");
        let _ = writeln!(out, "{head}{}", mesh.directions.len());
        for (index, a) in mesh.directions.iter().map(|of| of[family]).enumerate() {
            let _ = writeln!(out, "{} {:?} {:?} {:?}", index + 1, a.x, a.y, a.z);
        }
        out.push_str("$EndElementData\n");
    }
    out.into_bytes()
}

/// The families of fibres that a mesh has, and the names of their directions.
fn families(mesh: &TetMesh) -> impl Iterator<Item = (usize, &'static str)> {
    let named = ["fibre_direction", "fibre_direction_2"]
        .into_iter()
        .enumerate();
    let has = |family: usize| mesh.directions.iter().any(|of| of[family].norm() > 0.0);
    named.filter(move |(family, _)| has(*family))
}

/// The geometric entity of a region.
struct Volume {
    /// Its number, from 1.
    tag: usize,
    /// Lowest and highest corner of its box.
    bounds: [Vector3<f64>; 2],
}

fn volumes(mesh: &TetMesh) -> BTreeMap<u32, Volume> {
    let mut volumes: BTreeMap<u32, Volume> = BTreeMap::new();
    for (tet, region) in mesh.tets.iter().zip(&mesh.regions) {
        for &node in tet {
            let p = mesh.positions[node as usize];
            let volume = volumes.entry(*region).or_insert(Volume {
                tag: 0,
                bounds: [p, p],
            });
            let [low, high] = volume.bounds;
            volume.bounds = [low.inf(&p), high.sup(&p)];
        }
    }
    for (index, volume) in volumes.values_mut().enumerate() {
        volume.tag = index + 1;
    }
    volumes
}
