use super::*;
use crate::{Blade, Settings, Sheet, Stroke, TopologyState, check};
use microsim_mesh::{Block, CellSplit};
use microsim_random::Congruential;

fn block() -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: [6.0, 5.0, 4.0],
        cells: [6, 5, 4],
        split: CellSplit::Kuhn,
    };
    block.mesh().unwrap()
}

/// Cuts along a rectangle of which sides are twice `reach`.
fn cut(
    mesh: &mut TetMesh,
    topology: &mut Topology,
    center: Vector3<f64>,
    sides: [Vector3<f64>; 2],
    reach: f64,
) {
    let [along, across] = sides.map(|v| v.normalize() * reach);
    let corner = |s: f64, t: f64| center + along * s + across * t;
    let sheet = Sheet::quad(
        [corner(-1.0, -1.0), corner(1.0, -1.0)],
        [corner(-1.0, 1.0), corner(1.0, 1.0)],
    );
    let positions = mesh.positions.clone();
    let blade = Blade::Sheet {
        sheet: &sheet,
        positions: &positions,
    };
    let made = topology.cut(mesh, &mut Stroke::new(), &blade, &Settings::default());
    if let Some(cut) = made.unwrap() {
        mesh.apply(&cut.edit).unwrap();
    }
}

/// The largest distance of corners, middles of edges and centroids of the triangles of a surface from those of another.
fn farthest(mesh: &TetMesh, surface: &[[u32; 3]], from: &[[Vector3<f64>; 3]]) -> f64 {
    let mut farthest = 0.0_f64;
    for triangle in surface {
        let [a, b, c] = triangle.map(|node| mesh.positions[node as usize]);
        let points = [
            a,
            (a + b) / 2.0,
            (b + c) / 2.0,
            (c + a) / 2.0,
            (a + b + c) / 3.0,
        ];
        for point in points {
            let distances = from
                .iter()
                .map(|t| (closest_on_triangle(&point, t).point - point).norm());
            farthest = farthest.max(distances.fold(f64::INFINITY, f64::min));
        }
    }
    farthest
}

/// Merges until nothing can be, each time without moving any face by more than twice what is allowed at a node: more than one fan of faces may meet at one. Returns the number of merges.
fn coarsen(mesh: &mut TetMesh, topology: &mut Topology, first: u32) -> usize {
    let mut merged = 0;
    loop {
        let positions = mesh.positions.clone();
        let nodes = first..mesh.positions.len() as u32;
        let Some(made) = topology.coarsen(mesh, &positions, nodes) else {
            return merged;
        };
        let topology_before = Topology::restore(mesh, &TopologyState::default());
        let before: BTreeSet<_> = topology_before
            .surface()
            .into_iter()
            .map(|t| (t.element, t.nodes))
            .collect();
        let removed = &made.surface.removed;
        let old: Vec<_> = topology_before
            .surface()
            .iter()
            .map(|t| t.nodes.map(|n| mesh.positions[n as usize]))
            .collect();
        let gone: Vec<[u32; 3]> = removed.iter().map(|t| t.nodes).collect();
        let before_edit = mesh.clone();
        mesh.apply(&made.edit).unwrap();
        let added: Vec<[u32; 3]> = made.surface.added.iter().map(|t| t.nodes).collect();
        let new: Vec<_> = topology
            .surface()
            .iter()
            .map(|t| t.nodes.map(|n| mesh.positions[n as usize]))
            .collect();
        let moved = farthest(mesh, &added, &old).max(farthest(&before_edit, &gone, &new));
        assert!(moved <= 2.0 * SURFACE * topology.mean_edge, "{moved}");
        let after: BTreeSet<_> = topology
            .surface()
            .into_iter()
            .map(|t| (t.element, t.nodes))
            .collect();
        let list = |all: &[crate::SurfaceTriangle]| -> BTreeSet<_> {
            all.iter().map(|t| (t.element, t.nodes)).collect()
        };
        assert_eq!(
            &(&before - &list(&made.surface.removed)) | &list(&made.surface.added),
            after
        );
        merged += made.merged;
    }
}

/// Random planes through a block: what is left is a valid mesh of the same parts and, as planes are flat, with the same faces: by the measures of both.
#[test]
fn planes_stay_where_they_are_and_need_fewer_nodes() {
    let mut random = Congruential(7);
    let (mut before, mut after) = (0, 0);
    for _ in 0..5 {
        let mut mesh = block();
        let first = mesh.positions.len() as u32;
        let mut topology = Topology::new(&mesh);
        for _ in 0..2 {
            let sides = [random.vector(), random.vector()];
            cut(&mut mesh, &mut topology, random.vector(), sides, 20.0);
        }
        let fine = check(&mesh, &topology).unwrap();
        before += mesh.positions.len() - first as usize;
        let merged = coarsen(&mut mesh, &mut topology, first);
        let coarse = check(&mesh, &topology).unwrap();
        after += mesh.positions.len() - first as usize;
        assert!(merged > 0);
        assert_eq!(coarse.parts, fine.parts);
        // Each merge moves a face by at most `SURFACE` edges of 1 over the triangles at a node.
        let area: f64 = fine.outer_area + fine.sheets.iter().map(|(area, _)| area).sum::<f64>();
        assert!(
            (coarse.volume - fine.volume).abs() < SURFACE * area,
            "{} {}",
            coarse.volume,
            fine.volume
        );
        // Within half the square of a slope of twice that, an area is what it was.
        let slope = 2.0 * SURFACE;
        for (fine, coarse) in fine.sheets.iter().zip(&coarse.sheets) {
            assert!(
                (fine.0 - coarse.0).abs() < 0.5 * slope * slope * fine.0,
                "{fine:?} {coarse:?}"
            );
        }
    }
    assert!(4 * after < 3 * before, "{before} {after}");
}

/// Cuts that end inside, one after the other, with merges after each: the mesh has no flaw, and a plane through the whole block parts it all the same.
#[test]
fn cuts_go_on_in_what_was_merged() {
    let mut random = Congruential(11);
    let mut merged = 0;
    for _ in 0..4 {
        let mut mesh = block();
        let first = mesh.positions.len() as u32;
        let mut topology = Topology::new(&mesh);
        for _ in 0..4 {
            let sides = [random.vector(), random.vector()];
            cut(&mut mesh, &mut topology, random.vector() * 2.0, sides, 2.0);
            check(&mesh, &topology).unwrap();
            merged += coarsen(&mut mesh, &mut topology, first);
            check(&mesh, &topology).unwrap();
        }
        let sides = [Vector3::new(0.1, 1.0, 0.05), Vector3::new(-0.05, 0.1, 1.0)];
        cut(
            &mut mesh,
            &mut topology,
            Vector3::new(0.3, 0.0, 0.0),
            sides,
            20.0,
        );
        let parts = check(&mesh, &topology).unwrap().parts;
        assert!(parts >= 2, "{parts}");
        merged += coarsen(&mut mesh, &mut topology, first);
        assert_eq!(check(&mesh, &topology).unwrap().parts, parts);
    }
    assert!(merged > 200, "{merged}");
}
