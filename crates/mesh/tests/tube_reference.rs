//! The tube generator against a mesh that was made independently of it (tests/data/README.md).

use microsim_mesh::{Arc, CellSplit, Layer, TetMesh, Tube};
use nalgebra::Vector3;

/// Nodes and tetrahedra of a Gmsh 2.2 text file whose numbers count from 1 without gaps.
fn parse(text: &str) -> (Vec<Vector3<f64>>, Vec<[u32; 4]>) {
    let section = |name: &str| {
        let body = text.split(&format!("${name}\n")).nth(1).unwrap();
        let lines = body.split(&format!("$End{name}")).next().unwrap();
        lines.lines().skip(1).map(|line| {
            line.split_whitespace()
                .map(|word| word.parse().unwrap())
                .collect::<Vec<f64>>()
        })
    };
    let positions = section("Nodes")
        .map(|row| Vector3::new(row[1], row[2], row[3]))
        .collect();
    let tets = section("Elements")
        .map(|row| {
            // Number, type 4 (tetrahedron), two tags, nodes.
            assert_eq!((row[1], row[2]), (4.0, 2.0));
            [5, 6, 7, 8].map(|column| row[column] as u32 - 1)
        })
        .collect();
    (positions, tets)
}

fn sorted(tets: &[[u32; 4]]) -> Vec<[u32; 4]> {
    let mut tets: Vec<_> = tets
        .iter()
        .map(|tet| {
            let mut tet = *tet;
            tet.sort_unstable();
            tet
        })
        .collect();
    tets.sort_unstable();
    tets
}

/// The same nodes in the same order, to the twelve digits of the file, and the same tetrahedra.
fn compare(mesh: &TetMesh, text: &str) {
    let (positions, tets) = parse(text);
    assert_eq!(mesh.positions.len(), positions.len());
    for (ours, theirs) in mesh.positions.iter().zip(&positions) {
        for axis in 0..3 {
            // Half a unit of the twelfth digit: at most 5e-12 of the number; 1e-17 m where the file has a rounded zero.
            let tolerance = 5.1e-12 * theirs[axis].abs() + 1e-17;
            assert!(
                (ours[axis] - theirs[axis]).abs() < tolerance,
                "{ours} {theirs}"
            );
        }
    }
    assert_eq!(sorted(&mesh.tets), sorted(&tets));
}

#[test]
fn the_tube_of_9_by_13_by_1_is_that_of_the_reference() {
    let layer = Layer {
        thickness: 2e-3,
        cells: 1,
        region: 0,
    };
    let tube = Tube {
        center: [0.03, 0.0, 0.0],
        axis: [1.0, 0.0, 0.0],
        inner_radius: 8e-3,
        layers: vec![layer],
        length: 0.06,
        around: 9,
        along: 13,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    compare(&tube.mesh().unwrap(), include_str!("data/tube-9x13x1.msh"));
}
