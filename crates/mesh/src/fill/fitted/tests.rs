use super::*;
use crate::defects;
use crate::fill::tests::{cuboid, moved, sphere, torus};
use proptest::prelude::*;
use std::f64::consts::PI;

/// What holds for every surface: a mesh that fits together, no height below the floor, the Euler characteristic of the
/// boundary that of the surface.
fn check(surface: &TriangleSurface, fitted: &Fitted, cell: f64, euler: i64) {
    assert_eq!(defects(&fitted.mesh), []);
    for element in 0..fitted.mesh.tets.len() {
        let height = least_height(&fitted.mesh.corners(element));
        assert!(height >= LEAST_HEIGHT * cell, "{}", height / cell);
    }
    let boundary = fitted.mesh.surface().triangles;
    let edges = edge_uses(&boundary).len() as i64;
    let mut nodes: Vec<u32> = boundary.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    assert_eq!(nodes.len() as i64 - edges + boundary.len() as i64, euler);
    let boxes: Vec<Aabb> = (0..surface.triangles.len())
        .map(|t| Aabb::of(&surface.corners(t)))
        .collect();
    let grid = BoxGrid::new(&boxes);
    for node in nodes {
        let at = fitted.mesh.positions[node as usize];
        let mut least = f64::INFINITY;
        grid.search_nearest(&at, |t| {
            let closest = closest_on_triangle(&at, &surface.corners(t as usize)).point;
            let distance = (closest - at).norm();
            least = least.min(distance);
            distance
        });
        assert!(least <= fitted.farthest * (1.0 + 1e-12));
    }
}

/// On smooth surfaces the volume lacks what chords of the longest edge (√2 cells, stretched by a third at most) cut off: (1.9 h)²/(8 R)
/// deep, times the area. Single nodes stay off where elements with all nodes on the boundary would be flat.
#[test]
fn smooth_surfaces_are_reached() {
    let cases = [
        ("sphere", sphere(1e-2, 24), 1e-2, 4.0 * PI * 1e-4, 2),
        (
            "torus",
            torus(1e-2, 4e-3, 96, 48),
            4e-3,
            4.0 * PI * PI * 4e-5,
            0,
        ),
    ];
    for (name, surface, radius, area, euler) in cases {
        let surface = moved(surface, [1.0, 2.0, 3.0], 0.7, [0.1, -0.2, 0.05]);
        for cell in [radius / 3.0, radius / 5.0] {
            if name == "torus" && cell < radius / 4.0 {
                continue;
            }
            let fitted = fit_lattice(&surface, cell).unwrap();
            check(&surface, &fitted, cell, euler);
            let volume: f64 = fitted.mesh.volumes().iter().sum();
            let error = (volume - surface.volume()).abs();
            let bound = area * (1.9 * cell).powi(2) / (8.0 * radius);
            assert!(error < bound, "{name}: {error} {bound}");
        }
    }
}

/// A box of whole cells along the axes is the lattice itself, and nothing moves.
#[test]
fn a_box_of_whole_cells_is_met_exactly() {
    let surface = moved(cuboid([1e-2, 6e-3, 8e-3]), [1.0, 0.0, 0.0], 0.0, [0.0; 3]);
    let fitted = fit_lattice(&surface, 1e-3).unwrap();
    assert_eq!(fitted.mesh.tets.len(), 10 * 6 * 8 * 5);
    let volume: f64 = fitted.mesh.volumes().iter().sum();
    assert!((volume / 4.8e-7 - 1.0).abs() < 1e-9);
    assert!(fitted.farthest < 1e-15);
}

#[test]
fn what_is_thinner_than_its_cells_is_refused() {
    let surface = moved(cuboid([1e-2, 1e-2, 1e-5]), [1.0, 0.0, 0.0], 0.3, [0.0; 3]);
    let fitted = fit_lattice(&surface, 1e-3).map(|fitted| fitted.farthest);
    let error = fitted.unwrap_err();
    assert!(matches!(error, FillError::Coarse { .. }), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn turned_boxes_have_sound_meshes(
        axis in [-1.0..1.0, -1.0..1.0, 0.1..1.0f64],
        angle in 0.0..3.0f64,
        size in [2.0..8.0f64, 2.0..8.0, 2.0..8.0],
    ) {
        let surface = moved(cuboid(size.map(|s| s * 1e-3)), axis, angle, [0.01, 0.02, -0.03]);
        let cell = 0.8e-3;
        let fitted = fit_lattice(&surface, cell).unwrap();
        check(&surface, &fitted, cell, 2);
        prop_assert!(fitted.farthest < FARTHEST * cell);
    }
}
