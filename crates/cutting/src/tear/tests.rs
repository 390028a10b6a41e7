use super::*;
use crate::check;
use microsim_mesh::{Block, CellSplit, Side};
use nalgebra::Vector3;

/// Faces between elements on both sides of the plane z = 0, which is one between cells.
fn layer(mesh: &TetMesh, topology: &Topology) -> Vec<(u32, u8)> {
    let above = |e: u32| mesh.corners(e as usize).iter().map(|p| p.z).sum::<f64>() > 0.0;
    let mut faces = Vec::new();
    for element in 0..mesh.tets.len() as u32 {
        for corner in 0..4 {
            let other = topology.neighbour(element, corner);
            if !above(element) && other.is_some_and(above) {
                faces.push((element, corner as u8));
            }
        }
    }
    faces
}

fn block() -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: [3.0, 2.0, 2.0],
        cells: [3, 2, 2],
        split: CellSplit::Kuhn,
    };
    block.mesh().unwrap()
}

/// The layers of cells come apart along their 3 × 2 squares: 12 nodes are doubled, the area is 6. From whichever side faces are given,
/// positive is the upper one.
#[test]
fn a_layer_tears_off_along_its_faces() {
    for turned in [0, 1, 2, 3] {
        let is_turned = |k: usize| match turned {
            0 => false,
            1 => true,
            _ => k % 2 == turned % 2,
        };
        tear_layer(is_turned);
    }
}

fn tear_layer(is_turned: impl Fn(usize) -> bool) {
    let mut mesh = block();
    let mut topology = Topology::new(&mesh);
    let mut faces = layer(&mesh, &topology);
    for (k, (element, corner)) in faces.iter_mut().enumerate() {
        if is_turned(k)
            && let Some(other) = topology.neighbour(*element, *corner as usize)
        {
            *corner = topology.back(*element, other) as u8;
            *element = other;
        }
    }
    let positions = mesh.positions.clone();
    let cut = topology
        .tear(
            &mesh,
            &faces,
            &BTreeMap::new(),
            &positions,
            &Settings::default(),
        )
        .unwrap()
        .unwrap();
    let old = mesh.tets.len();
    mesh.apply(&cut.edit).unwrap();
    let measures = check(&mesh, &topology).unwrap();
    assert_eq!(
        (measures.parts, mesh.tets.len(), cut.edit.nodes.len()),
        (2, old, 12)
    );
    assert!((cut.opened[0].area - 6.0).abs() < 1e-12);
    assert!((cut.opened[0].normal - Vector3::z()).norm() < 1e-12);
    assert_eq!(cut.edit.cut_faces.len(), 2 * faces.len());
    for face in &cut.edit.cut_faces {
        let corners = mesh.corners(face.element as usize);
        let lower = corners.iter().all(|p| p.z <= 0.0);
        assert_eq!(face.side == Side::Negative, lower);
    }
    assert_eq!(cut.pieces.len(), 1);
    assert_eq!(cut.pieces[0].len(), old / 2);
}

/// One face after another: what hangs together in between stays closed, and in the end all is open. A topology rebuilt from its
/// state goes on alike.
#[test]
fn faces_torn_one_by_one_add_up() {
    let mut mesh = block();
    let mut topology = Topology::new(&mesh);
    let (mut pieces, mut edits) = (0, 0);
    loop {
        let mut faces = layer(&mesh, &topology);
        faces.retain(|&(e, k)| topology.marks[e as usize][k as usize] == 0);
        let Some(&face) = faces.get(faces.len() / 2) else {
            break;
        };
        let positions = mesh.positions.clone();
        let settings = Settings::default();
        let torn = topology.tear(&mesh, &[face], &BTreeMap::new(), &positions, &settings);
        if let Some(cut) = torn.unwrap() {
            mesh.apply(&cut.edit).unwrap();
            pieces += cut.pieces.len();
            edits += 1;
        }
        check(&mesh, &topology).unwrap();
        topology = Topology::restore(&mesh, &topology.state());
    }
    let measures = check(&mesh, &topology).unwrap();
    assert_eq!((measures.parts, pieces), (2, 1));
    assert!(edits > 3);
}

/// An element inside of a block ruptures, one at its surface that hangs on one side alone, and a layer of cells, along x: they are gone, and nothing else is divided or opened. What
/// they held together is the volume over the extent, nothing, and the section of 2 × 2. Without the layer the rest is two parts.
#[test]
fn shreds_are_taken_away_whole() {
    let mesh = block();
    let topology = Topology::new(&mesh);
    let elements = || 0..mesh.tets.len() as u32;
    let inner = |e: u32| {
        (0..4)
            .filter(|&k| topology.neighbour(e, k).is_some())
            .count()
    };
    let inside = elements().find(|&e| inner(e) == 4).expect("one inside");
    let center = |e: u32| mesh.corners(e as usize).iter().sum::<Vector3<f64>>() / 4.0;
    let section = |e: u32| -> f64 {
        let places = mesh.corners(e as usize).map(|p| p.x);
        let [least, most] = [f64::min, f64::max].map(|of| places.into_iter().reduce(of).unwrap());
        mesh.volumes()[e as usize] / (most - least)
    };
    // Its faces along x are at the end of the block, so that what holds it is behind alone.
    let at_end = |e: &u32| {
        let faces = (0..4).filter(|&k| topology.neighbour(*e, k).is_some());
        let mut normals = faces.map(|k| {
            let [a, b, c] = topology.face(*e, k).map(|n| mesh.positions[n as usize]);
            (b - a).cross(&(c - a)).x
        });
        center(*e).x > 1.0 && normals.all(|x| x < 1e-12)
    };
    let at_end = elements().find(at_end).expect("one at the end");
    let layer: Vec<u32> = elements().filter(|&e| center(e).x.abs() < 0.5).collect();
    for (shreds, parts, area) in [
        (vec![inside], 1, section(inside)),
        (vec![at_end], 1, 0.0),
        (layer, 2, 4.0),
    ] {
        let mut mesh = block();
        let mut topology = Topology::new(&mesh);
        let positions = mesh.positions.clone();
        let (old, volumes) = (mesh.tets.len(), mesh.volumes());
        let lost: f64 = shreds.iter().map(|&e| volumes[e as usize]).sum();
        // Of either sign, one after the other.
        let along = |e: u32| Vector3::x() * if e.is_multiple_of(2) { 1.0 } else { -1.0 };
        let fibres = shreds.iter().map(|&e| (e, [along(e); 2])).collect();
        let settings = Settings::default();
        let torn = topology.tear(&mesh, &[], &fibres, &positions, &settings);
        let torn = torn.unwrap().expect("they come apart");
        mesh.apply(&torn.edit).unwrap();
        let measures = check(&mesh, &topology).unwrap();
        assert_eq!(
            (measures.parts, mesh.tets.len()),
            (parts, old - shreds.len())
        );
        assert_eq!(torn.pieces.len(), parts - 1);
        assert!((torn.lost_volume - lost).abs() < 1e-12);
        let left = volumes.iter().sum::<f64>() - lost;
        assert!((mesh.volumes().iter().sum::<f64>() - left).abs() < 1e-12);
        for opened in torn.opened {
            assert!((opened.area - area).abs() < 1e-12, "{opened:?}, not {area}");
        }
    }
}

/// Of a piece of a shred and a whole element the shred goes, whichever of them is the first.
#[test]
fn a_shred_goes_where_it_is_half_of_a_piece() {
    for shred in [0, 1] {
        let positions = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ];
        let positions: Vec<Vector3<f64>> = positions.map(Vector3::from).to_vec();
        let mut mesh = TetMesh::new(
            positions.clone(),
            vec![[0, 1, 2, 3], [0, 2, 1, 4]],
            vec![0; 2],
        );
        let mut topology = Topology::new(&mesh);
        let fibres = BTreeMap::from([(shred, [Vector3::z(); 2])]);
        let torn = topology.tear(&mesh, &[], &fibres, &positions, &Settings::default());
        let torn = torn.unwrap().expect("they come apart");
        mesh.apply(&torn.edit).unwrap();
        assert_eq!((mesh.tets.len(), mesh.positions.len()), (1, 4));
        check(&mesh, &topology).unwrap();
    }
}

#[test]
fn what_is_not_an_inner_face_is_refused() {
    let mesh = block();
    let mut topology = Topology::new(&mesh);
    let settings = Settings::default();
    let outer = (0..4).find(|&k| topology.neighbour(0, k).is_none());
    let outer = outer.unwrap() as u8;
    for (element, corner) in [(0, outer), (0, 4), (mesh.tets.len() as u32, 0)] {
        let refused = topology.tear(
            &mesh,
            &[(element, corner)],
            &BTreeMap::new(),
            &mesh.positions,
            &settings,
        );
        assert_eq!(refused, Err(Rejected::Face { element, corner }));
    }
    let refused = topology.tear(
        &mesh,
        &[],
        &BTreeMap::new(),
        &mesh.positions[1..],
        &settings,
    );
    assert!(matches!(refused, Err(Rejected::Positions { .. })));
    let unknown = BTreeMap::from([(mesh.tets.len() as u32, [Vector3::x(); 2])]);
    let refused = topology.tear(&mesh, &[], &unknown, &mesh.positions, &settings);
    assert!(matches!(refused, Err(Rejected::Face { corner: 0, .. })));
    let nothing = topology.tear(&mesh, &[], &BTreeMap::new(), &mesh.positions, &settings);
    assert_eq!(nothing, Ok(None));
}
