//! Gmsh files from a mesh, in ASCII.

use crate::TetMesh;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::fmt::Write;

/// `mesh` as a version 2.2 file; the physical group of an element is its region. Gmsh itself takes groups up to 2³¹ − 1.
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
    out.into_bytes()
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
    out.into_bytes()
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
