use super::*;
use crate::quality::extremes;
use crate::{defects, signed_volume};
use nalgebra::{Rotation3, Unit};
use proptest::prelude::*;
use std::f64::consts::PI;

/// A closed grid of `n` × `m` quadrilaterals, closed around in both directions: a torus about z.
pub(super) fn torus(major: f64, minor: f64, n: u32, m: u32) -> TriangleSurface {
    let mut surface = TriangleSurface::default();
    for i in 0..n {
        let u = 2.0 * PI * f64::from(i) / f64::from(n);
        for j in 0..m {
            let v = 2.0 * PI * f64::from(j) / f64::from(m);
            let radius = major + minor * libm::cos(v);
            surface.positions.push(Vector3::new(
                radius * libm::cos(u),
                radius * libm::sin(u),
                minor * libm::sin(v),
            ));
            let node = |a: u32, b: u32| (i + a) % n * m + (j + b) % m;
            surface.triangles.push([node(0, 0), node(1, 0), node(1, 1)]);
            surface.triangles.push([node(0, 0), node(1, 1), node(0, 1)]);
        }
    }
    surface
}

/// A sphere about the origin: the faces of an octahedron cut into n² triangles, pushed out.
pub(super) fn sphere(radius: f64, n: i32) -> TriangleSurface {
    let mut index = std::collections::BTreeMap::new();
    let mut surface = TriangleSurface::default();
    let mut node = |p: [i32; 3]| -> u32 {
        *index.entry(p).or_insert_with(|| {
            let place = Vector3::from(p.map(f64::from));
            surface.positions.push(place * (radius / place.norm()));
            surface.positions.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|axis| 1 - 2 * (octant >> axis & 1));
        let turned = sign.iter().product::<i32>() < 0;
        let mut add = |corners: [[i32; 2]; 3]| {
            let mut t =
                corners.map(|[i, j]| node([sign[0] * i, sign[1] * j, sign[2] * (n - i - j)]));
            if turned {
                t.swap(1, 2);
            }
            triangles.push(t);
        };
        for i in 0..n {
            for j in 0..n - i {
                add([[i, j], [i + 1, j], [i, j + 1]]);
                if i + j + 1 < n {
                    add([[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
                }
            }
        }
    }
    surface.triangles = triangles;
    surface
}

pub(super) fn cuboid(size: [f64; 3]) -> TriangleSurface {
    let positions = (0..8)
        .map(|bits| Vector3::from_fn(|axis, _| size[axis] * (f64::from(bits >> axis & 1) - 0.5)))
        .collect();
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles = faces
        .iter()
        .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
        .collect();
    TriangleSurface {
        positions,
        triangles,
    }
}

pub(super) fn moved(
    mut surface: TriangleSurface,
    axis: [f64; 3],
    angle: f64,
    shift: [f64; 3],
) -> TriangleSurface {
    let rotation = Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::from(axis)), angle);
    for p in &mut surface.positions {
        *p = rotation * *p + Vector3::from(shift);
    }
    surface
}

/// What every filling promises; returns the volume and the largest distance of a corner, edge middle or centroid of the
/// boundary from the surface.
fn check(surface: &TriangleSurface, mesh: &TetMesh, h: f64) -> (f64, f64) {
    assert_eq!(defects(mesh), []);
    let [_, min, max] = extremes(mesh);
    assert!(min >= MIN_DIHEDRAL && max <= MAX_DIHEDRAL);
    let boxes: Vec<Aabb> = (0..surface.triangles.len())
        .map(|t| Aabb::of(&surface.corners(t)))
        .collect();
    let grid = BoxGrid::new(&boxes);
    let distance = |p: &Vector3<f64>| {
        let mut least = f64::INFINITY;
        grid.search_nearest(p, |t| {
            let corners = surface.corners(t as usize);
            let distance = (closest_on_triangle(p, &corners).point - p).norm();
            least = least.min(distance);
            distance
        });
        least
    };
    let boundary = mesh.surface();
    let mut largest = 0.0f64;
    let mut enclosed = 0.0;
    for t in &boundary.triangles {
        let [a, b, c] = t.map(|n| mesh.positions[n as usize]);
        assert!((b - a).norm() <= 1.72 * h);
        assert!(distance(&a) < 1e-8 * h, "{}", distance(&a) / h);
        for p in [
            (a + b) / 2.0,
            (b + c) / 2.0,
            (c + a) / 2.0,
            (a + b + c) / 3.0,
        ] {
            largest = largest.max(distance(&p));
        }
        enclosed += signed_volume(&mesh.positions[0], &a, &b, &c);
    }
    let volume: f64 = mesh.volumes().iter().sum();
    // Nothing overlaps: the sum of the elements is what the boundary encloses. Rounding of a sum of n equal terms, and
    // of the terms themselves.
    let rounding = f64::EPSILON * mesh.tets.len() as f64 + 1e-12;
    assert!((enclosed / volume - 1.0).abs() < rounding);
    (volume, largest)
}

/// Bounds of the module's doc for smooth surfaces; the surfaces themselves are within their sagitta of the sphere and
/// torus, so their own volumes are the reference. Halving h divides the error of the volume by about four.
#[test]
fn smooth_surfaces_are_met_to_second_order() {
    let cases = [
        ("sphere", sphere(1e-2, 24), 1e-2, 4.0 * PI * 1e-4),
        (
            "torus",
            torus(1e-2, 4e-3, 96, 48),
            4e-3,
            4.0 * PI * PI * 4e-5,
        ),
    ];
    for (name, surface, radius, area) in cases {
        let surface = moved(surface, [1.0, 2.0, 3.0], 0.7, [0.1, -0.2, 0.05]);
        let reference = surface.volume();
        let mut errors = Vec::new();
        for h in [radius / 3.0, radius / 6.0] {
            let mesh = fill(&surface, h).unwrap();
            let (volume, distance) = check(&surface, &mesh, h);
            let bound = h * h / (2.0 * radius);
            assert!(distance < bound, "{name} {h}: {distance} {bound}");
            assert!((volume - reference).abs() < bound * area);
            errors.push((volume - reference).abs());
        }
        assert!(errors[0] / errors[1] > 2.5, "{name}: {errors:?}");
    }
}

#[test]
fn sharp_edges_become_chamfers_of_a_cell() {
    let size = [1e-2, 8e-3, 6e-3];
    let surface = moved(cuboid(size), [1.0, -2.0, 0.5], 0.6, [0.0; 3]);
    let edges = 4.0 * size.iter().sum::<f64>();
    for h in [2e-3, 1e-3] {
        let mesh = fill(&surface, h).unwrap();
        let (volume, distance) = check(&surface, &mesh, h);
        assert!(distance < h);
        let error = surface.volume() - volume;
        assert!(error > 0.0 && error < 0.2 * edges * h * h, "{error}");
    }
}

/// Faces on lattice planes: nothing to approximate. Coordinates round at 1e-16 of the size, cells are a tenth of it.
#[test]
fn a_box_of_whole_cells_is_met_exactly() {
    let size = [1e-2, 6e-3, 8e-3];
    let surface = moved(cuboid(size), [1.0, 0.0, 0.0], 0.0, [0.3, 0.2, -0.1]);
    let h = 1e-3;
    let mesh = fill(&surface, h).unwrap();
    let (volume, distance) = check(&surface, &mesh, h);
    assert!((volume / size.iter().product::<f64>() - 1.0).abs() < 1e-9 && distance < 1e-8 * h);
}

#[test]
fn a_cavity_stays_empty_and_an_inward_surface_is_turned() {
    let outer = sphere(1e-2, 12);
    let mut hollow = outer.clone();
    let hole = sphere(5e-3, 8);
    let first = outer.positions.len() as u32;
    hollow.positions.extend(&hole.positions);
    hollow.triangles.extend(
        hole.triangles
            .iter()
            .map(|[a, b, c]| [a + first, c + first, b + first]),
    );
    let h = 1.5e-3;
    let mesh = fill(&hollow, h).unwrap();
    let (volume, _) = check(&hollow, &mesh, h);
    // Error of the spheres as in the test above: area times h²/2R.
    let bound = 4.0 * PI * (1e-4 * h * h / 2e-2 + 2.5e-5 * h * h / 1e-2);
    assert!((volume - hollow.volume()).abs() < bound);

    let mut inward = hollow.clone();
    inward.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let turned = fill(&inward, h).unwrap();
    assert_eq!(turned.tets.len(), mesh.tets.len());

    // The hole outward: wound around twice there.
    let mut twice = outer;
    twice.positions.extend(&hole.positions);
    twice
        .triangles
        .extend(hole.triangles.iter().map(|t| t.map(|v| v + first)));
    let error = fill(&twice, h).unwrap_err();
    assert!(
        matches!(error, FillError::Overlap { winding: 2, .. }),
        "{error}"
    );
    assert!(error.to_string().contains("turn an inner shell inward"));
}

#[test]
fn what_cannot_be_filled_says_why_and_where() {
    let good = sphere(1e-2, 8);
    let mut open = good.clone();
    open.triangles.remove(7);
    let text = fill(&open, 2e-3).unwrap_err().to_string();
    assert!(
        text.contains("close the hole") && text.contains("triangle"),
        "{text}"
    );

    for cell_size in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-6] {
        let error = fill(&good, cell_size).unwrap_err();
        let FillError::CellSize { least, .. } = error else {
            panic!("{error}")
        };
        assert!(least > 5e-5 && least < 4e-4 && lattice_around(&good, least).is_ok());
    }

    // A plate of a fifth of a cell: torn or lost, wherever the lattice lies.
    let plate = moved(cuboid([2e-2, 2e-2, 4e-4]), [1.0, 0.5, 0.2], 0.5, [0.0; 3]);
    let text = fill(&plate, 2e-3).unwrap_err().to_string();
    assert!(text.contains("use smaller cells"), "{text}");

    // Far too coarse cells: nothing inside.
    let error = fill(&good, 1.0).unwrap_err();
    assert!(matches!(error, FillError::Coarse { .. }), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]

    #[test]
    fn any_box_is_filled_as_promised(size in [0.8..3.0f64, 0.8..3.0, 0.8..3.0], axis in [0.1..1.0f64, -1.0..1.0, -1.0..1.0],
                                     angle in prop_oneof![Just(0.0), 0.0..3.0f64], h in 0.2..0.4f64) {
        let surface = moved(cuboid(size), axis, angle, [0.5, 0.0, -0.3]);
        let mesh = fill(&surface, h).unwrap();
        let (volume, _) = check(&surface, &mesh, h);
        prop_assert!(volume < surface.volume() * (1.0 + 1e-12));
    }
}
