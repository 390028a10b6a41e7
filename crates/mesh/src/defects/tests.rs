//! Each defect is made by hand in a valid block and must be found where it was put, and nothing else.

use super::*;
use crate::{Block, CellSplit};

fn block() -> TetMesh {
    let mut mesh = Block {
        center: [0.0; 3],
        size: [2e-3; 3],
        cells: [2; 3],
        split: CellSplit::Kuhn,
    }
    .mesh()
    .unwrap();
    mesh.node_ids.iter_mut().for_each(|id| *id += 100);
    mesh.element_ids.iter_mut().for_each(|id| *id += 5000);
    mesh
}

/// The only defect of `mesh`, whose text has all of `parts`.
fn only(mesh: &TetMesh, parts: &[&str]) -> Defect {
    let found = defects(mesh);
    assert_eq!(found.len(), 1, "{found:?}");
    let text = found[0].to_string();
    for part in parts {
        assert!(text.contains(part), "{text:?} does not contain {part:?}");
    }
    found[0].clone()
}

fn add_tet(mesh: &mut TetMesh, tet: [u32; 4]) {
    mesh.tets.push(tet);
    mesh.regions.push(0);
    mesh.element_ids.push(9000);
}

fn add_nodes(mesh: &mut TetMesh, points: &[Vector3<f64>]) -> u32 {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(points);
    let ids = mesh.node_ids.len() as u32 + 100;
    mesh.node_ids.extend((ids..).take(points.len()));
    first
}

#[test]
fn a_sound_mesh_has_no_defect_and_an_empty_one_says_so() {
    assert_eq!(defects(&block()), []);
    let empty = TetMesh::new(vec![], vec![], vec![]);
    only(&empty, &["no tetrahedron", "export"]);
}

#[test]
fn bad_elements_are_named_with_index_and_id() {
    let mut mesh = block();
    mesh.tets[7].swap(0, 1);
    let defect = only(&mesh, &["element 7 (id 5007)", "inverted", "swap"]);
    assert_eq!(defect.severity(), Severity::Error);

    let mut mesh = block();
    let tet = mesh.tets[7];
    add_tet(&mut mesh, [tet[1], tet[2], tet[0], tet[3]]);
    only(
        &mesh,
        &["element 48 (id 9000)", "element 7 (id 5007)", "remove"],
    );

    let mut mesh = block();
    let node = mesh.tets[3][0];
    mesh.tets[3] = [node, 1, 2, node];
    let found = defects(&mesh);
    assert!(
        found.contains(&Defect::RepeatedNode {
            element: Named { index: 3, id: 5003 },
            node: Named {
                index: node,
                id: node + 100
            }
        }),
        "{found:?}"
    );

    let mut mesh = block();
    add_tet(&mut mesh, [0, 1, 2, 27]);
    only(
        &mesh,
        &["element 48 (id 9000) names node 27", "0 to 26", "from 1"],
    );

    // An outer node in the plane of the opposite face: flat, whatever the scale.
    let mut mesh = TetMesh::new(
        vec![
            Vector3::zeros(),
            Vector3::x() * 1e-3,
            Vector3::y() * 1e-3,
            Vector3::new(1e-3, 1e-3, 1e-10),
        ],
        vec![[0, 1, 2, 3]],
        vec![0],
    );
    only(&mesh, &["element 0 (id 0)", "flat"]);
    mesh.positions[3].z = 1e-3;
    assert_eq!(defects(&mesh), []);
}

#[test]
fn bad_nodes_are_named() {
    let mut mesh = block();
    add_nodes(&mut mesh, &[Vector3::repeat(1.0)]);
    only(&mesh, &["node 27 (id 127)", "no element", "remove"]);

    let mut mesh = block();
    mesh.positions[13].y = f64::NAN;
    let defect = only(&mesh, &["node 13 (id 113)", "finite"]);
    assert_eq!(defect.severity(), Severity::Error);

    // A second element at node 26, apart by a millionth of an edge: two parts as well.
    let mut mesh = block();
    let corner = mesh.positions[26] + Vector3::repeat(1e-9);
    let h = 1e-3;
    let n = add_nodes(
        &mut mesh,
        &[
            corner,
            corner + Vector3::x() * h,
            corner + Vector3::y() * h,
            corner + Vector3::z() * h,
        ],
    );
    add_tet(&mut mesh, [n, n + 1, n + 2, n + 3]);
    let found = defects(&mesh);
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!(found[0], Defect::Components { count: 2 });
    assert!(
        matches!(found[1], Defect::CoincidingNodes { nodes, .. } if nodes[0].index == 26 && nodes[1].index == 27)
    );
    assert!(found.iter().all(|d| d.severity() == Severity::Warning));
}

#[test]
fn parts_that_touch_in_a_face_edge_or_node_only_are_found() {
    // Through the boundary face of an element a third owner: take an inner face instead.
    let mut mesh = block();
    let inner = {
        let surface = mesh.surface();
        let boundary: Vec<[u32; 3]> = surface
            .triangles
            .iter()
            .map(|t| {
                let mut t = *t;
                t.sort_unstable();
                t
            })
            .collect();
        FACES
            .iter()
            .map(|f| f.map(|c| mesh.tets[20][c]))
            .find(|f| {
                let mut key = *f;
                key.sort_unstable();
                !boundary.contains(&key)
            })
            .unwrap()
    };
    let apex = {
        let [a, b, c] = inner.map(|i| mesh.positions[i as usize]);
        (a + b + c) / 3.0 - (b - a).cross(&(c - a)).normalize() * 1e-3
    };
    let n = add_nodes(&mut mesh, &[apex]);
    add_tet(&mut mesh, [inner[0], inner[1], inner[2], n]);
    let found = defects(&mesh);
    let count = found
        .iter()
        .filter(|d| matches!(d, Defect::FaceNotManifold { count: 3, .. }))
        .count();
    assert_eq!(count, 1, "{found:?}");

    let h = 1e-3;
    let fan = |shared: usize| {
        // Two tetrahedra opposite each other that share their first nodes.
        let mut points = vec![
            Vector3::zeros(),
            Vector3::x() * h,
            Vector3::y() * h,
            Vector3::z() * h,
        ];
        let mirror = [
            Vector3::zeros(),
            Vector3::x() * (if shared == 2 { h } else { -h }),
            Vector3::y() * -h,
            Vector3::z() * -h,
        ];
        points.extend(&mirror[shared..]);
        let second: Vec<u32> = (0..4)
            .map(|i| if i < shared { i } else { i + 4 - shared } as u32)
            .collect();
        let mut second = [second[0], second[1], second[2], second[3]];
        let [a, b, c, d] = second.map(|i| points[i as usize]);
        if signed_volume(&a, &b, &c, &d) < 0.0 {
            second.swap(2, 3);
        }
        TetMesh::new(points, vec![[0, 1, 2, 3], second], vec![0; 2])
    };
    let defect = only(&fan(1), &["node 0 (id 0)", "2 sheets"]);
    assert_eq!(defect.severity(), Severity::Warning);
    only(&fan(2), &["4 triangles", "nodes 0 (id 0) and 1 (id 1)"]);
}

/// Brute force over all pairs, on points packed so that many are close, across cell borders and the origin.
#[test]
fn close_pairs_agree_with_brute_force() {
    let points: Vec<Vector3<f64>> = (0..200u32)
        .map(|i| {
            let coordinate = |k: u32| f64::from((i * i * 7 + i * k * 13) % 31) * 0.37 - 5.0;
            Vector3::new(coordinate(1), coordinate(2), coordinate(5))
        })
        .collect();
    let mut expected = Vec::new();
    for j in 0..points.len() {
        for i in 0..j {
            let distance = (points[i] - points[j]).norm();
            if distance <= 1.5 {
                expected.push((i as u32, j as u32, distance));
            }
        }
    }
    expected.sort_unstable_by_key(|&(i, j, _)| (i, j));
    assert!(expected.len() > 50);
    assert_eq!(close_pairs(&points, &[true; 200], 1.5), expected);
}

/// Nodes of an interface that are there twice, and the two parts, are a defect only where that is not meant.
#[test]
fn regions_that_are_detached_on_purpose_are_no_defect() {
    let mut mesh = block();
    let upper = mesh.tets.len() / 2;
    mesh.regions[upper..].fill(1);
    let mut mesh = mesh.detached(&[1]).mesh;
    let kinds = |found: &[Defect]| {
        let pairs = found.iter();
        let pairs = pairs.filter(|d| matches!(d, Defect::CoincidingNodes { .. }));
        (pairs.count(), found.len())
    };
    // Nine nodes of the interface, and that there are two parts.
    assert_eq!(kinds(&defects(&mesh)), (9, 10));
    assert_eq!(defects_but_detached(&mesh, &[1]), []);
    assert_eq!(kinds(&defects_but_detached(&mesh, &[5])), (9, 10));
    // One that is there twice in the same region still is.
    let first = mesh.tets[0];
    let place = mesh.positions[first[0] as usize];
    let copy = add_nodes(&mut mesh, &[place]);
    mesh.tets[0][0] = copy;
    assert_eq!(kinds(&defects_but_detached(&mesh, &[1])).0, 1);
}
