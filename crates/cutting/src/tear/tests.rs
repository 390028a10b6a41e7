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
            &BTreeSet::new(),
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
        let torn = topology.tear(&mesh, &[face], &BTreeSet::new(), &positions, &settings);
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

/// Two elements of a block, one of them inside, rupture: they are gone, nothing else is divided or opened, and what they lay open is their volume over
/// their longest edge. Where a layer of cells ruptures the rest is two parts.
#[test]
fn shreds_are_taken_away_whole() {
    let layer = |mesh: &TetMesh| -> BTreeSet<u32> {
        let middle = |e: &u32| {
            let corners = mesh.corners(*e as usize);
            (corners.iter().map(|p| p.x).sum::<f64>() / 4.0).abs() < 0.5
        };
        (0..mesh.tets.len() as u32).filter(middle).collect()
    };
    for (shreds, parts) in [(BTreeSet::from([3, 40]), 1), (layer(&block()), 2)] {
        let mut mesh = block();
        let mut topology = Topology::new(&mesh);
        let positions = mesh.positions.clone();
        let (old, volume) = (mesh.tets.len(), mesh.volumes().iter().sum::<f64>());
        let (lost, section) = shreds.iter().fold((0.0, 0.0), |(lost, section), &e| {
            let corners = mesh.corners(e as usize);
            let pairs = crate::EDGES.map(|[i, j]| (corners[j] - corners[i]).norm());
            let volume = mesh.volumes()[e as usize];
            (
                lost + volume,
                section + volume / pairs.into_iter().fold(0.0, f64::max),
            )
        });
        let settings = Settings::default();
        let torn = topology.tear(&mesh, &[], &shreds, &positions, &settings);
        let torn = torn.unwrap().expect("they come apart");
        mesh.apply(&torn.edit).unwrap();
        let measures = check(&mesh, &topology).unwrap();
        assert_eq!(
            (measures.parts, mesh.tets.len()),
            (parts, old - shreds.len())
        );
        assert_eq!(torn.pieces.len(), parts - 1);
        assert!((torn.lost_volume - lost).abs() < 1e-12 * volume);
        assert!((mesh.volumes().iter().sum::<f64>() - volume + lost).abs() < 1e-12 * volume);
        assert!(
            (torn.opened[0].area - section).abs() < 1e-12,
            "{:?}",
            torn.opened
        );
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
            &BTreeSet::new(),
            &mesh.positions,
            &settings,
        );
        assert_eq!(refused, Err(Rejected::Face { element, corner }));
    }
    let refused = topology.tear(
        &mesh,
        &[],
        &BTreeSet::new(),
        &mesh.positions[1..],
        &settings,
    );
    assert!(matches!(refused, Err(Rejected::Positions { .. })));
    let unknown = BTreeSet::from([mesh.tets.len() as u32]);
    let refused = topology.tear(&mesh, &[], &unknown, &mesh.positions, &settings);
    assert!(matches!(refused, Err(Rejected::Face { corner: 0, .. })));
    let nothing = topology.tear(&mesh, &[], &BTreeSet::new(), &mesh.positions, &settings);
    assert_eq!(nothing, Ok(None));
}
