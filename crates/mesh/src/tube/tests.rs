use super::*;
use crate::defects;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// The tube of dissertation 4.1 (NUMERICS 5).
fn dissertation() -> Tube {
    Tube {
        center: [0.03, 0.0, 0.0],
        axis: [1.0, 0.0, 0.0],
        inner_radius: 8e-3,
        layers: vec![Layer {
            thickness: 2e-3,
            cells: 1,
            region: 0,
        }],
        length: 0.06,
        around: 9,
        along: 13,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    }
}

/// V − E + F − T of the solid, V − E + F of its boundary.
fn euler(mesh: &TetMesh) -> (i64, i64) {
    let surface = mesh.surface();
    let faces = (4 * mesh.tets.len() + surface.triangles.len()) / 2;
    let solid = mesh.positions.len() as i64 - mesh.edges().len() as i64 + faces as i64
        - mesh.tets.len() as i64;
    let mut edges = BTreeMap::new();
    for t in &surface.triangles {
        for k in 0..3 {
            let (i, j) = (t[k], t[(k + 1) % 3]);
            *edges.entry([i.min(j), i.max(j)]).or_insert(0i32) += if i < j { 1 } else { -1 };
        }
    }
    assert!(
        edges.values().all(|&sum| sum == 0),
        "the boundary is not closed"
    );
    let boundary = surface.nodes.len() as i64 - edges.len() as i64 + surface.triangles.len() as i64;
    (solid, boundary)
}

/// Counts of NUMERICS 5. The smallest elements have their base on the inner polygon: volumes as 8 : 9 (mean radius).
#[test]
fn the_tube_of_the_dissertation_has_its_counts() {
    let mesh = dissertation().mesh().unwrap();
    assert_eq!((mesh.positions.len(), mesh.tets.len()), (252, 702));
    assert_eq!(mesh.edges().len(), 1206);
    assert_eq!(mesh.surface().triangles.len(), 504);
    assert_eq!(euler(&mesh), (0, 0));
    let volumes = mesh.volumes();
    let mean = volumes.iter().sum::<f64>() / 702.0;
    let min = volumes.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((min / mean - 8.0 / 9.0).abs() < 1e-12, "{}", min / mean);
}

#[test]
fn impossible_tubes_are_refused() {
    let good = dissertation();
    let layer = good.layers[0];
    let cases = [
        (
            Tube {
                center: [f64::NAN, 0.0, 0.0],
                ..good.clone()
            },
            "center",
        ),
        (
            Tube {
                axis: [0.0; 3],
                ..good.clone()
            },
            "axis",
        ),
        (
            Tube {
                inner_radius: 0.0,
                ..good.clone()
            },
            "inner_radius",
        ),
        (
            Tube {
                length: f64::INFINITY,
                ..good.clone()
            },
            "length",
        ),
        (
            Tube {
                layers: vec![],
                ..good.clone()
            },
            "layer 0",
        ),
        (
            Tube {
                layers: vec![layer, Layer { cells: 0, ..layer }],
                ..good.clone()
            },
            "layer 1",
        ),
        (
            Tube {
                layers: vec![Layer {
                    thickness: -1.0,
                    ..layer
                }],
                ..good.clone()
            },
            "layer 0",
        ),
        (
            Tube {
                around: 2,
                ..good.clone()
            },
            "at least 3",
        ),
        (
            Tube {
                along: 0,
                ..good.clone()
            },
            "0 along",
        ),
        (
            Tube {
                along: usize::MAX,
                ..good.clone()
            },
            "at most",
        ),
        (
            Tube {
                arc: Arc::Sector {
                    start: 0.0,
                    angle: 7.0,
                },
                ..good.clone()
            },
            "7.0 rad",
        ),
        (
            Tube {
                arc: Arc::Sector {
                    start: 0.0,
                    angle: 3.5,
                },
                around: 1,
                ..good.clone()
            },
            "1 around",
        ),
        (
            Tube {
                split: CellSplit::Mirrored,
                ..good.clone()
            },
            "even numbers, not 9",
        ),
        (
            Tube {
                split: CellSplit::Five,
                ..good.clone()
            },
            "even numbers, not 9",
        ),
    ];
    for (tube, part) in cases {
        let text = tube.mesh().unwrap_err().to_string();
        assert!(text.contains(part), "{text:?} does not contain {part:?}");
    }
    // Open around, an odd number of mirrored cells is fine.
    let open = Tube {
        arc: Arc::Sector {
            start: 0.0,
            angle: 2.0,
        },
        split: CellSplit::Mirrored,
        ..good
    };
    assert!(open.mesh().is_ok());
}

#[test]
fn sides_of_a_tube_have_their_areas_and_directions() {
    let tube = Tube {
        around: 12,
        ..dissertation()
    };
    let mesh = tube.mesh().unwrap();
    // Polygon of 12: chord 2 r sin(π/12), area of the ring 12/2 sin(π/6) (R² − r²).
    let chord = 2.0 * libm::sin(PI / 12.0);
    let ring = 3.0 * (100.0 - 64.0) * 1e-6;
    let cases = [
        (TubeSide::Inner, 12.0 * chord * 8e-3 * 0.06, 2 * 12 * 13),
        (TubeSide::Outer, 12.0 * chord * 10e-3 * 0.06, 2 * 12 * 13),
        (TubeSide::Start, ring, 24),
        (TubeSide::End, ring, 24),
    ];
    for (side, expected, count) in cases {
        let surface = tube.side(&mesh, side);
        assert_eq!(surface.triangles.len(), count);
        let area: f64 = surface.node_areas(&mesh.positions).iter().sum();
        assert!((area / expected - 1.0).abs() < 1e-12, "{side:?} {area}");
        for (triangle, vector) in surface
            .triangles
            .iter()
            .zip(surface.area_vectors(&mesh.positions))
        {
            let centroid = triangle
                .iter()
                .map(|&n| mesh.positions[n as usize])
                .sum::<Vector3<f64>>()
                / 3.0;
            let radial = Vector3::new(0.0, centroid.y, centroid.z);
            let outward = match side {
                TubeSide::Inner => -vector.dot(&radial),
                TubeSide::Outer => vector.dot(&radial),
                TubeSide::Start => -vector.x,
                TubeSide::End => vector.x,
            };
            assert!(outward > 0.0, "{side:?}");
        }
    }
}

fn tubes() -> impl Strategy<Value = Tube> {
    (
        [-1.0..1.0f64, -1.0..1.0, -1.0..1.0],
        prop::collection::vec((0.1..1.0f64, 1..4usize), 1..4),
        0.2..2.0f64,
        0.3..5.0f64,
        3..12usize,
        1..6usize,
        prop::option::of((-7.0..7.0f64, 0.1..6.2f64)),
        prop::sample::select(CellSplit::ALL.to_vec()),
    )
        .prop_filter_map(
            "an axis too short",
            |(axis, layers, inner_radius, length, around, along, sector, split)| {
                let axis_length = Vector3::from(axis).norm();
                (axis_length > 0.1).then(|| {
                    let closed = sector.is_none();
                    Tube {
                        center: [0.3, -0.2, 0.1],
                        axis,
                        inner_radius,
                        layers: layers
                            .iter()
                            .enumerate()
                            .map(|(i, &(thickness, cells))| Layer {
                                thickness,
                                cells,
                                region: 10 + i as u32,
                            })
                            .collect(),
                        length,
                        around: if split != CellSplit::Kuhn && closed {
                            2 * around
                        } else {
                            around
                        },
                        along,
                        arc: sector
                            .map_or(Arc::Full, |(start, angle)| Arc::Sector { start, angle }),
                        split,
                    }
                })
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    /// A ring of cells is a solid torus (Euler number 0, of its boundary 0), a sector a ball (1 and 2). The volume of a
    /// layer between the radii a < b is that of its polygon prism, n/2 sin(φ/n) (b² − a²) L, to round-off: coordinates
    /// up to about 5 with cells down to about 0.01 lose up to 2e-16 · 5/0.01 ≈ 1e-13 per element, 1e-11 with room.
    #[test]
    fn any_tube_is_closed_positive_and_has_the_volume_of_its_prism(tube in tubes()) {
        let mesh = tube.mesh().unwrap();
        prop_assert_eq!(defects(&mesh), []);
        let expected = if tube.arc == Arc::Full { (0, 0) } else { (1, 2) };
        prop_assert_eq!(euler(&mesh), expected);

        let angle = match tube.arc {
            Arc::Full => 2.0 * PI,
            Arc::Sector { angle, .. } => angle,
        };
        let n = tube.around as f64;
        let volumes = mesh.volumes();
        prop_assert!(volumes.iter().all(|&v| v > 0.0));
        let mut a = tube.inner_radius;
        for layer in &tube.layers {
            let b = a + layer.thickness;
            let expected = n / 2.0 * libm::sin(angle / n) * (b * b - a * a) * tube.length;
            let volume: f64 = volumes.iter().zip(&mesh.regions).filter(|(_, r)| **r == layer.region).map(|(v, _)| v).sum();
            prop_assert!((volume / expected - 1.0).abs() < 1e-11, "{} {}", volume, expected);
            a = b;
        }

        // Every node on one of the exact radii about the axis, between the ends.
        let [_, _, axis] = tube.frame();
        for p in &mesh.positions {
            let from_center = p - Vector3::from(tube.center);
            let along = from_center.dot(&axis);
            prop_assert!(along.abs() <= tube.length / 2.0 * (1.0 + 1e-14) + 1e-15);
            let radius = (from_center - axis * along).norm();
            prop_assert!(tube.radii().iter().any(|r| (radius / r - 1.0).abs() < 1e-13));
        }
    }

    /// The frame is a rotation of (y, z, x), and it is that exactly for the axis x.
    #[test]
    fn the_frame_is_orthonormal_and_right_handed(axis in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0]) {
        prop_assume!(Vector3::from(axis).norm() > 1e-3);
        let [a, b, c] = Tube { axis, ..dissertation() }.frame();
        prop_assert!((a.cross(&b) - c).norm() < 1e-14 && (a.norm() - 1.0).abs() < 1e-15);
        prop_assert_eq!(dissertation().frame(), [Vector3::y(), Vector3::z(), Vector3::x()]);
    }
}
