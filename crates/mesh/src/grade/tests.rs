//! What local refinement keeps and reaches, in random zones of blocks, tubes and filled surfaces.

use super::*;
use crate::quality::ElementQuality;
use crate::{Arc, Block, CellSplit, Layer, Severity, Tube, defects, signed_volume};
use microsim_random::SplitMix64;
use nalgebra::Matrix3;

const LIMIT: usize = 200_000;

fn block(cells: [usize; 3], split: CellSplit) -> TetMesh {
    let block = Block {
        center: [1e-3, -2e-3, 0.0],
        size: [10e-3, 2e-3, 0.6e-3],
        cells,
        split,
    };
    block.mesh().unwrap()
}

fn tube() -> TetMesh {
    let layer = |region| Layer {
        thickness: 1e-4,
        cells: 1,
        region,
    };
    let tube = Tube {
        center: [0.0; 3],
        axis: [1.0, 0.3, -0.2],
        inner_radius: 5e-4,
        layers: vec![layer(1), layer(2)],
        length: 3e-3,
        around: 12,
        along: 8,
        arc: Arc::Full,
        split: CellSplit::Mirrored,
    };
    tube.mesh().unwrap()
}

/// A block with inner nodes moved about and numbered at random: no lattice to lean on.
fn irregular(random: &mut SplitMix64) -> TetMesh {
    let mut mesh = block([8, 3, 3], CellSplit::Kuhn);
    for p in &mut mesh.positions {
        let inside = (p.y + 2e-3).abs() < 0.9e-3 && p.z.abs() < 0.29e-3;
        if inside {
            *p += random.vector() * 4e-5;
        }
    }
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    for i in (1..order.len()).rev() {
        order.swap(i, random.below(i as u64 + 1) as usize);
    }
    let mut positions = mesh.positions.clone();
    for (from, to) in order.iter().enumerate() {
        positions[*to as usize] = mesh.positions[from];
    }
    let tets = mesh.tets.iter().map(|tet| tet.map(|n| order[n as usize]));
    let regions = (0..mesh.tets.len() as u32).map(|e| e % 3).collect();
    let mut mesh = TetMesh::new(positions, tets.collect(), regions);
    let families = |_| [random.vector().normalize(), random.vector().normalize()];
    mesh.directions = (0..mesh.tets.len()).map(families).collect();
    let prestretch = |_| Matrix3::from_diagonal(&random.vector());
    mesh.prestretches = (0..mesh.tets.len()).map(prestretch).collect();
    mesh
}

/// Some zones within the box around a mesh.
fn gradings(mesh: &TetMesh, random: &mut SplitMix64) -> Vec<Grading> {
    let edge = mesh.mean_edge_length();
    let mut place = || {
        let node = random.below(mesh.positions.len() as u64) as usize;
        let place = mesh.positions[node] + random.vector() * edge;
        (place.into(), random.number().abs(), random.vector())
    };
    let ((a, near, normal), (b, small, _)) = (place(), place());
    let radius = edge * (0.1 + near);
    let zone = match random.below(4) {
        0 => Zone::Ball { center: a, radius },
        1 => Zone::Capsule {
            ends: [a, b],
            radius,
        },
        2 => Zone::Slab {
            point: a,
            normal: normal.into(),
            distance: 0.3 * radius,
        },
        _ => Zone::Region(mesh.regions[random.below(mesh.regions.len() as u64) as usize]),
    };
    let ball = Zone::Ball { center: b, radius };
    vec![
        Grading {
            zone,
            size: edge * (0.5 + small),
        },
        Grading {
            zone: ball,
            size: edge * (0.15 + 0.5 * small),
        },
    ]
}

/// The worst radius ratio among the descendants of an element of so many generations.
fn worst_descendant(mesh: &TetMesh, element: usize, generations: usize) -> f64 {
    let mut positions = mesh.positions.clone();
    let mut parts = vec![Marked::new(mesh.tets[element], &positions)];
    let mut worst = f64::INFINITY;
    for _ in 0..generations {
        let mut next = Vec::with_capacity(2 * parts.len());
        for part in parts {
            let corners = part.nodes.map(|n| positions[n as usize]);
            worst = worst.min(ElementQuality::of(&corners).radius_ratio);
            let [a, b] = part.refinement.map(|n| positions[n as usize]);
            positions.push((a + b) / 2.0);
            next.extend(part.halves(positions.len() as u32 - 1));
        }
        parts = next;
    }
    worst
}

fn cases() -> Vec<(TetMesh, Vec<Grading>)> {
    let mut random = SplitMix64(11);
    let mut cases = Vec::new();
    for case in 0..24 {
        let mesh = match case % 4 {
            0 => block([20, 2, 1], CellSplit::Kuhn),
            1 => block([12, 4, 2], CellSplit::Mirrored),
            2 => tube(),
            _ => irregular(&mut random),
        };
        let gradings = gradings(&mesh, &mut random);
        cases.push((mesh, gradings));
    }
    cases
}

fn as_set(mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    for t in &mut triangles {
        let least = (0..3).min_by_key(|i| t[*i]).unwrap();
        t.rotate_left(least);
    }
    triangles.sort_unstable();
    triangles
}

/// Every element has the volume of its parts, all of them positive; of faces with one element only there are those in which the boundary was divided, so every inner
/// one has two: no node hangs.
#[test]
fn parts_fill_their_elements_and_conform() {
    let mut refined = 0;
    for (mesh, gradings) in cases() {
        let graded = mesh.graded(&gradings, LIMIT).unwrap();
        let mut sums = vec![0.0; mesh.tets.len()];
        for (part, volume) in graded.mesh.volumes().into_iter().enumerate() {
            assert!(volume > 0.0, "{gradings:?}");
            sums[graded.parents[part] as usize] += volume;
        }
        let smallest = mesh.volumes().into_iter().fold(f64::INFINITY, f64::min);
        for (sum, volume) in sums.iter().zip(mesh.volumes()) {
            // Rounding of positions by 2⁻⁵³ of 1e-2 m on faces of about 1e-6 m², some thousand parts.
            assert!((sum - volume).abs() < 1e-9 * smallest, "{sum} {volume}");
        }
        let boundary = graded.faces(&mesh.surface().triangles);
        assert_eq!(as_set(boundary), as_set(graded.mesh.surface().triangles));
        let found = defects(&graded.mesh);
        let errors = found.iter().filter(|d| d.severity() == Severity::Error);
        assert_eq!(errors.count(), 0, "{found:?}");
        refined += usize::from(graded.mesh.tets.len() > 2 * mesh.tets.len());
    }
    assert!(refined > 8, "only {refined} cases refine much");
}

/// Sizes are reached in the zones; what is divided reaches into one or has a neighbour at an edge that is divided; all else is as it was.
#[test]
fn sizes_are_reached_in_the_zones_and_nothing_else_is_divided_but_for_neighbours() {
    let mut untouched = 0;
    for (mesh, gradings) in cases() {
        let graded = mesh.graded(&gradings, LIMIT).unwrap();
        let of = &graded.mesh;
        assert_eq!(of.positions[..mesh.positions.len()], mesh.positions);
        let size = |mesh: &TetMesh, element: usize| {
            Marked::new(mesh.tets[element], &mesh.positions).size(&mesh.positions)
        };
        for element in 0..of.tets.len() {
            for Grading { zone, size: wanted } in &gradings {
                let large = size(of, element) > *wanted;
                assert!(!large || !zone.meets(&of.corners(element), of.regions[element]));
            }
        }
        let mut parts = vec![Vec::new(); mesh.tets.len()];
        for (part, parent) in graded.parents.iter().enumerate() {
            parts[*parent as usize].push(part);
        }
        let divided = |element: usize| parts[element].len() > 1;
        let mut at_edges = BTreeMap::<[u32; 2], usize>::new();
        for element in (0..mesh.tets.len()).filter(|e| divided(*e)) {
            for edge in mesh.element_edges(element) {
                *at_edges.entry(edge).or_default() += 1;
            }
        }
        for (element, own) in parts.iter().enumerate() {
            if !divided(element) {
                assert_eq!(of.tets[own[0]], mesh.tets[element]);
                untouched += 1;
                continue;
            }
            let wanted = gradings.iter().any(|Grading { zone, size: wanted }| {
                size(&mesh, element) > *wanted
                    && zone.meets(&mesh.corners(element), mesh.regions[element])
            });
            let beside = mesh.element_edges(element);
            assert!(wanted || beside.iter().any(|edge| at_edges[edge] > 1));
        }
    }
    assert!(untouched > 100, "{untouched}");
}

/// Parts have shapes of the descendants that their element has, whatever the zone: the worst of ten generations bounds them.
#[test]
fn shapes_are_bounded_by_the_descendants_of_each_element() {
    let mut deep = 0;
    for (mesh, gradings) in cases().into_iter().take(8) {
        let graded = mesh.graded(&gradings, LIMIT).unwrap();
        let mut worst = vec![f64::INFINITY; mesh.tets.len()];
        let mut parts = vec![0; mesh.tets.len()];
        for (part, parent) in graded.parents.iter().enumerate() {
            let quality = ElementQuality::of(&graded.mesh.corners(part)).radius_ratio;
            let worst = &mut worst[*parent as usize];
            *worst = worst.min(quality);
            parts[*parent as usize] += 1;
        }
        for (element, worst) in worst.into_iter().enumerate() {
            if parts[element] > 1 {
                let bound = worst_descendant(&mesh, element, 10);
                assert!(worst >= bound - 1e-9, "{worst} below {bound}");
                deep += usize::from(parts[element] > 64);
            }
        }
    }
    assert!(deep > 0, "no element is divided often");
}

/// Region and fibre direction of the parent; ids are indices; the same bits again.
#[test]
fn parts_keep_region_and_fibres_and_the_same_input_gives_the_same_bits() {
    for (mesh, gradings) in cases() {
        let graded = mesh.graded(&gradings, LIMIT).unwrap();
        for (part, parent) in graded.parents.iter().enumerate() {
            assert_eq!(graded.mesh.regions[part], mesh.regions[*parent as usize]);
            let parent = *parent as usize;
            assert_eq!(graded.mesh.fibres(part), mesh.fibres(parent));
            assert_eq!(graded.mesh.prestretch(part), mesh.prestretch(parent));
        }
        for (new, [a, b]) in graded.middles.iter().enumerate() {
            let node = mesh.positions.len() + new;
            assert!((*a as usize) < node && (*b as usize) < node);
            let at = |n: u32| graded.mesh.positions[n as usize];
            assert_eq!(graded.mesh.positions[node], (at(*a) + at(*b)) * 0.5);
        }
        let again = mesh.graded(&gradings, LIMIT).unwrap();
        let bits = |graded: &Graded| -> Vec<u64> {
            let positions = graded.mesh.positions.iter();
            positions
                .flat_map(|p| [p.x, p.y, p.z].map(f64::to_bits))
                .collect()
        };
        assert_eq!(bits(&graded), bits(&again));
        assert_eq!(graded, again);
    }
}

/// The parts of the end face of a tube make it up: their areas sum up to its own, and they face as it does.
#[test]
fn faces_of_the_mesh_before_are_found_in_their_parts() {
    let mesh = tube();
    let axis = Vector3::new(1.0, 0.3, -0.2).normalize();
    let at_end = |node: u32| (mesh.positions[node as usize].dot(&axis) - 1.5e-3).abs() < 1e-9;
    let end = mesh.surface().within(at_end).triangles;
    let zone = Zone::Ball {
        center: (axis * 1.5e-3).into(),
        radius: 6e-4,
    };
    let graded = mesh
        .graded(&[Grading { zone, size: 1.2e-4 }], LIMIT)
        .unwrap();
    let area = |mesh: &TetMesh, faces: &[[u32; 3]]| -> Vector3<f64> {
        let each = faces.iter().map(|face| {
            let [a, b, c] = face.map(|n| mesh.positions[n as usize]);
            (b - a).cross(&(c - a)) / 2.0
        });
        each.sum()
    };
    let parts = graded.faces(&end);
    assert!(parts.len() > 2 * end.len());
    let [before, after] = [area(&mesh, &end), area(&graded.mesh, &parts)];
    assert!((before - after).norm() < 1e-12 * before.norm());
    assert_eq!(graded.faces(&[]), Vec::<[u32; 3]>::new());
}

/// On the circles the volume grows from that of a prism of 12 sides, (6/π) sin 30° = 0.9549 of the ring, towards the whole; where a coarse wall is thinner than the sagitta of its
/// sides, (1 − cos 15°) = 3.4 % of the radius, elements beside fine ones turn inside out, and that is an error.
#[test]
fn new_nodes_may_be_placed_on_a_curved_wall_unless_that_inverts_elements() {
    let of = |thickness: f64| Tube {
        center: [1e-3, 0.0, 0.0],
        axis: [0.0, 0.0, 1.0],
        inner_radius: 5e-4,
        layers: vec![Layer {
            thickness,
            cells: 1,
            region: 0,
        }],
        length: 2e-3,
        around: 12,
        along: 6,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    let tube = of(1e-4);
    let mesh = tube.mesh().unwrap();
    let everywhere = Grading {
        zone: Zone::Region(0),
        size: 1.2e-4,
    };
    let graded = mesh.graded(&[everywhere], LIMIT).unwrap();
    let placed = graded
        .place_middles(|a, b| tube.between(a, b))
        .unwrap()
        .mesh;
    let exact = std::f64::consts::PI * (0.6f64.powi(2) - 0.5f64.powi(2)) * 1e-6 * 2e-3;
    let share = |mesh: &TetMesh| mesh.volumes().iter().sum::<f64>() / exact;
    assert!((share(&mesh) - 0.9549).abs() < 1e-4, "{}", share(&mesh));
    // Sides of 0.12 mm at most: 27 of them at least, 0.991 of the ring.
    assert!((0.991..1.0).contains(&share(&placed)), "{}", share(&placed));
    for p in &placed.positions {
        let radius = (p - Vector3::new(1e-3, 0.0, 0.0)).xy().norm();
        assert!(
            (0.5e-3 - 1e-12..0.6e-3 + 1e-12).contains(&radius),
            "{radius}"
        );
    }

    let thin = of(5e-6);
    let point = Zone::Ball {
        center: [1.5e-3, 0.0, 0.0],
        radius: 1e-5,
    };
    let graded = thin.mesh().unwrap().graded(
        &[Grading {
            zone: point,
            size: 5e-5,
        }],
        LIMIT,
    );
    let refused = graded
        .unwrap()
        .place_middles(|a, b| thin.between(a, b))
        .unwrap_err();
    assert!(matches!(refused, GradeError::Inverted { .. }));
    assert!(
        refused.to_string().contains("more cells around"),
        "{refused}"
    );
}

/// Without a zone that asks for anything the mesh is as it was.
#[test]
fn sizes_that_are_kept_already_change_nothing() {
    let mesh = tube();
    let zone = Zone::Region(1);
    let graded = mesh.graded(&[Grading { zone, size: 1.0 }], LIMIT).unwrap();
    assert_eq!((&graded.mesh, graded.middles.len()), (&mesh, 0));
    assert_eq!(mesh.graded(&[], LIMIT).unwrap().mesh, mesh);
}

#[test]
fn the_shortest_height_is_that_of_the_flattest_element() {
    let corners = vec![
        Vector3::zeros(),
        Vector3::x(),
        Vector3::y(),
        Vector3::new(0.0, 0.0, 0.1),
    ];
    let mesh = TetMesh::new(corners, vec![[0, 1, 2, 3]], vec![0]);
    // Over the slanted face: 3 V = 0.05 over its area, |(0.1, 0.1, 1)|/2.
    let expected = 0.05 / (0.5 * 1.02f64.sqrt());
    assert!((mesh.shortest_height() - expected).abs() < 1e-15);
    assert_eq!(
        signed_volume(
            &mesh.positions[0],
            &Vector3::x(),
            &Vector3::y(),
            &Vector3::z()
        ),
        1.0 / 6.0
    );
}

#[test]
fn what_is_no_zone_no_size_and_too_many_elements_are_refused() {
    let mesh = tube();
    let refused = |zone, size, limit| {
        let error = mesh.graded(&[Grading { zone, size }], limit).unwrap_err();
        error.to_string()
    };
    let ball = |radius| Zone::Ball {
        center: [0.0; 3],
        radius,
    };
    for radius in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let said = refused(ball(radius), 1e-4, LIMIT);
        assert!(
            said.contains("radius") && said.contains("above 0 m"),
            "{said}"
        );
    }
    for size in [0.0, -1e-4, f64::NAN, f64::INFINITY, 1e-13] {
        let said = refused(ball(1e-3), size, LIMIT);
        assert!(said.contains("of at least 3."), "{said}");
    }
    let said = refused(Zone::Region(7), 1e-4, LIMIT);
    assert!(
        said.contains("region 7") && said.contains("[1, 2]"),
        "{said}"
    );
    let lost = Zone::Capsule {
        ends: [[0.0; 3], [f64::NAN, 0.0, 0.0]],
        radius: 1e-3,
    };
    assert!(refused(lost, 1e-4, LIMIT).contains("finite coordinates"));
    let slab = |normal, distance| Zone::Slab {
        point: [0.0; 3],
        normal,
        distance,
    };
    assert!(refused(slab([0.0; 3], 1e-4), 1e-4, LIMIT).contains("normal"));
    assert!(refused(slab([0.0, 1.0, 0.0], 0.0), 1e-4, LIMIT).contains("distance"));
    let said = refused(Zone::Region(1), 1e-5, 5000);
    assert!(said.contains("expected 5000 at most"), "{said}");
}
