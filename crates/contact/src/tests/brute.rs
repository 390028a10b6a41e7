use super::*;
use crate::BroadPhaseMethod;
use crate::{ObstacleShape, Partner};
use microsim_geometry::{Pose, closest_on_segment, closest_on_triangle, closest_segments};
use microsim_mesh::{Arc, Layer, Tube};
use nalgebra::UnitQuaternion;

impl Group {
    /// Every feature is near to every other one, and none is left out beside a tool.
    fn comparing_all(mut self) -> Self {
        self.detector.tool_scratch.compares_all = true;
        for body in &mut self.detector.bodies {
            body.tree.margin = f64::INFINITY;
        }
        self
    }

    fn with_broad_phase(mut self, broad_phase: BroadPhaseMethod) -> Self {
        self.detector = self.detector.with_broad_phase(broad_phase);
        self
    }
}

/// Two small bodies that overlap, touch or are apart, a tool and three obstacles; half of the time on a lattice, where features coincide and
/// tetrahedra are flat.
fn scene(random: &mut SplitMix64) -> Group {
    let mut meshes = [block([0.0; 3], [2, 1, 1]), block([0.0; 3], [1, 2, 1])];
    let on_lattice = random.below(2) == 0;
    let size = [0.0, 0.1, 0.4][random.below(3) as usize];
    let snap = |v: V3| {
        if on_lattice {
            v.map(|c| (c * 4.0).round() / 4.0)
        } else {
            v
        }
    };
    for mesh in &mut meshes {
        let shift = random.vector() * 1.5;
        let turn = UnitQuaternion::new(random.vector() * if on_lattice { 0.0 } else { 2.0 });
        for p in &mut mesh.positions {
            *p = snap(turn * *p + shift + random.vector() * size);
        }
    }
    let round = [0.0, 0.1][random.below(2) as usize];
    let obstacles = [
        ObstacleShape::HalfSpace,
        ObstacleShape::Cuboid {
            half_size: [0.5, 0.75, 0.25],
            rounding: round,
        },
        ObstacleShape::Cylinder {
            radius: 0.25,
            half_length: 1.0,
        },
    ];
    let obstacles = obstacles.map(|shape| ObstaclePart {
        shape,
        pose: Pose {
            position: snap(random.vector() * 1.5) - V3::z() * 0.5,
            orientation: UnitQuaternion::new(random.vector() * if on_lattice { 0.0 } else { 2.0 }),
        },
    });
    let mut pairs = vec![
        ContactPair::Bodies {
            body: 0,
            with: 1,
            ends: None,
        },
        ContactPair::Itself { body: 0 },
    ];
    for body in 0..2 {
        pairs.push(ContactPair::Tool { body, tool: 0 });
        pairs.extend((0..3).map(|part| ContactPair::Obstacle { body, part }));
    }
    let mut group = Group::new(&[&meshes[0], &meshes[1]], obstacles.to_vec(), pairs);
    let travel = [0.0, 0.02, 0.02, 0.3, 1.5][random.below(5) as usize];
    for p in &mut group.now {
        *p = snap(*p + random.vector() * travel);
    }
    let tool = |random: &mut SplitMix64| {
        let (a, b) = (random.vector() * 1.5, random.vector() * 1.5);
        let b = if random.below(4) == 0 { a } else { b };
        let travel = random.vector() * travel;
        capsule(snap(a).into(), snap(b).into(), 0.25, snap(travel).into())
    };
    group.tools = vec![Some(vec![tool(random), tool(random)])];
    group.reach = [0.0, 0.1, 0.5][random.below(3) as usize];
    group.fraction = [0.5, 1.0][random.below(2) as usize];
    group
}

fn same(a: &[Point], b: &[Point]) {
    let differ = a.iter().zip(b).find(|(a, b)| a != b);
    assert!(
        a.len() == b.len() && differ.is_none(),
        "{differ:?} {} {}",
        a.len(),
        b.len()
    );
}

/// The same points, to the bit, from every broad phase and from comparing everything with everything; and once more after others.
#[test]
fn detection_equals_brute_force_on_ten_thousand_configurations() {
    let mut random = SplitMix64(5);
    let mut found = [0; 4];
    for round in 0..10_000 {
        let mut group = scene(&mut random);
        let brute = group.clone().comparing_all().find();
        let points = group.find();
        same(&points, &brute);
        let cell_size = [None, Some(1e-2), Some(0.3), Some(10.0)][random.below(4) as usize];
        let broad_phase = match random.below(3) {
            0 => BroadPhaseMethod::AllPairs,
            _ => BroadPhaseMethod::SpatialHash { cell_size },
        };
        same(&group.clone().with_broad_phase(broad_phase).find(), &brute);
        for point in &points {
            let kind = match point.key.partner {
                Partner::Tool { .. } => 0,
                Partner::Obstacle { .. } => 1,
                Partner::Body { .. } if point.first == 1 => 2,
                Partner::Body { .. } => 3,
            };
            found[kind] += 1;
        }
        if round % 8 == 0 {
            group.sides.remember(&points);
            let again = group.find();
            same(&again, &group.comparing_all().find());
        }
    }
    // All kinds occur often.
    assert!(found.iter().all(|&n| n > 2_000), "{found:?}");
}

/// At rest and apart, gaps are the distances of the features, which is written down here once more and without any list.
#[test]
fn gaps_are_the_distances_of_features() {
    let mut random = SplitMix64(6);
    let mut seen = [0; 2];
    for _ in 0..2_000 {
        let mut group = scene(&mut random);
        group.now = group.start.clone();
        for motion in group.tools[0].as_mut().unwrap() {
            motion.end = motion.start;
        }
        group.reach = 0.5;
        let tools = group.tools[0].clone().unwrap();
        for point in group.find() {
            let at = |k: usize| group.now[point.nodes[k] as usize];
            match point.key.partner {
                Partner::Tool { capsule, .. } if point.gap > -0.25 => {
                    let axis = tools[capsule as usize].end;
                    let distance = match point.first {
                        1 => (closest_on_segment(&at(0), &axis.a, &axis.b).point - at(0)).norm(),
                        2 => closest_segments(&at(0), &at(1), &axis.a, &axis.b)
                            .distance_squared()
                            .sqrt(),
                        _ => {
                            let end = [axis.a, axis.b][point.key.second[0] as usize];
                            let corners = [at(0), at(1), at(2)];
                            (closest_on_triangle(&end, &corners).point - end).norm()
                        }
                    };
                    // What leaves a capsule through the near side is counted from the far one.
                    if (point.gap - (distance - 0.25)).abs() > 1e-12 {
                        assert!(distance < 0.25, "{point:?} {distance}");
                    }
                    seen[0] += 1;
                }
                Partner::Body { body } if point.first == 1 && point.gap > 1e-9 => {
                    let p = at(0);
                    if u64::from(body) == u64::from(point.key.body) {
                        continue;
                    }
                    let surface = &group.detector.bodies[body as usize].surface;
                    let nearest = surface.triangles.iter().map(|nodes| {
                        let corners = nodes.map(|node| group.now[node as usize]);
                        (closest_on_triangle(&p, &corners).point - p).norm()
                    });
                    let nearest = nearest.fold(f64::INFINITY, f64::min);
                    assert!((point.gap - nearest).abs() < 1e-12, "{point:?}");
                    seen[1] += 1;
                }
                _ => {}
            }
        }
    }
    assert!(seen.iter().all(|&n| n > 1_000), "{seen:?}");
}

/// Lists that are cached while nodes move little change nothing: two tubes that meet, seen by a detector that saw all steps and by one that
/// sees each for the first time.
#[test]
fn kept_candidates_do_not_change_results() {
    let tube = |x: f64| {
        let tube = Tube {
            center: [x, 0.0, 0.0],
            axis: [1.0, 0.0, 0.0],
            inner_radius: 8e-3,
            layers: vec![Layer {
                thickness: 2e-3,
                cells: 1,
                region: 0,
            }],
            length: 60e-3,
            around: 9,
            along: 13,
            arc: Arc::Full,
            split: CellSplit::Kuhn,
        };
        tube.mesh().expect("a tube")
    };
    let (left, mut right) = (tube(-31e-3), tube(31e-3));
    let turn = UnitQuaternion::from_axis_angle(&V3::x_axis(), 10f64.to_radians());
    for p in &mut right.positions {
        *p = turn * *p + V3::y() * 3e-3;
    }
    let pairs = vec![
        ContactPair::Bodies {
            body: 0,
            with: 1,
            ends: None,
        },
        ContactPair::Itself { body: 1 },
        ContactPair::Tool { body: 0, tool: 0 },
    ];
    let fresh = Group::new(&[&left, &right], Vec::new(), pairs);
    let mut cached = fresh.clone();
    let mut random = SplitMix64(9);
    let mut total = 0;
    for step in 0..200 {
        cached.start = cached.now.clone();
        for (node, p) in cached.now.iter_mut().enumerate() {
            let closing = if node < 252 { 1.0 } else { -1.0 };
            *p += V3::x() * closing * 0.03e-3 + random.vector() * 1e-6;
        }
        let x = -40e-3 + 1e-4 * f64::from(step);
        cached.tools = vec![Some(vec![capsule(
            [x, 0.0, 10.2e-3],
            [x, 5e-3, 10.2e-3],
            1e-3,
            [1e-4, 0.0, 0.0],
        )])];
        cached.reach = [0.0, 1e-3][step as usize % 2];
        let points = cached.find();
        let mut new = Group {
            detector: fresh.detector.clone(),
            ..cached.clone()
        };
        same(&points, &new.find());
        total += points.len();
        cached.sides.remember(&points);
    }
    assert!(total > 3_000, "{total}");
}

/// Numbers that are none, and bodies without volume: no point, or one of numbers.
#[test]
fn what_is_broken_gives_no_point_that_is_not_a_number() {
    let mut random = SplitMix64(10);
    for round in 0..2_000 {
        let mut group = scene(&mut random);
        let count = group.now.len() as u64;
        match round % 4 {
            0 => group.now[random.below(count) as usize].x = f64::NAN,
            1 => group.start[random.below(count) as usize].y = f64::INFINITY,
            2 => group.now.fill(V3::zeros()),
            _ => {
                for p in group.now.iter_mut().chain(&mut group.start) {
                    p.z = 0.0;
                }
            }
        }
        group.find();
    }
}
