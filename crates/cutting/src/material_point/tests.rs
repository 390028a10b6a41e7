use super::*;
use crate::testing::Random;
use crate::{Blade, Settings, Sheet, Stroke, Topology};
use microsim_mesh::{Block, CellSplit, TetMesh};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

fn place(mesh: &TetMesh, point: &MaterialPoint) -> V3 {
    let corners = mesh.corners(point.element as usize);
    corners.iter().zip(point.weights).map(|(c, w)| c * w).sum()
}

/// Points in every element stay where they are at rest while ten planes go through, and end in an element that they lie in.
#[test]
fn points_stay_in_place_through_cuts() {
    let mut random = Random(11);
    let block = Block {
        center: [0.0; 3],
        size: [3.0; 3],
        cells: [3; 3],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().unwrap();
    for p in &mut mesh.positions {
        *p += random.vector() * 0.1;
    }
    let mut topology = Topology::new(&mesh);
    let mut points = Vec::new();
    for element in 0..mesh.tets.len() as u32 {
        let weights = [0; 4].map(|_| 0.01 + random.number().abs());
        let sum: f64 = weights.iter().sum();
        points.push(MaterialPoint {
            element,
            id: mesh.element_ids[element as usize],
            weights: weights.map(|w| w / sum),
        });
    }
    let places: Vec<V3> = points.iter().map(|p| place(&mesh, p)).collect();
    let mut left = 0;
    for _ in 0..10 {
        let normal = random.vector().normalize();
        let side = normal.cross(&random.vector()).normalize() * 9.0;
        let up = normal.cross(&side);
        let center = random.vector();
        let corners = [-side - up, side - up, -side + up, side + up].map(|p| p + center);
        let sheet = Sheet::quad([corners[0], corners[1]], [corners[2], corners[3]]);
        let positions = mesh.positions.clone();
        let blade = Blade::Sheet {
            sheet: &sheet,
            positions: &positions,
        };
        let settings = Settings::default();
        let cut = topology.cut(&mesh, &mut Stroke::new(), &blade, &settings);
        let cut = cut.unwrap().unwrap();
        let applied = mesh.apply(&cut.edit).unwrap();
        for point in &mut points {
            if point.element == u32::MAX {
                continue;
            }
            if !point.follow(&cut.edit, &applied, positions.len()) {
                point.element = u32::MAX;
                left += 1;
                assert!(cut.lost_volume > 0.0);
            }
        }
    }
    assert!(
        mesh.tets.len() > 3000 && left < 5,
        "{} {left}",
        mesh.tets.len()
    );
    for (point, expected) in points.iter().zip(&places) {
        if point.element == u32::MAX {
            continue;
        }
        assert_eq!(mesh.element_ids[point.element as usize], point.id);
        // Rounding grows with the ratio of element to parent, up to 1e4 in volume.
        assert!((place(&mesh, point) - expected).norm() < 1e-10);
        assert!(point.weights.iter().all(|&w| w > -1e-10), "{point:?}");
    }
}
