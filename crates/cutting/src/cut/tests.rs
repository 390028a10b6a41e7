mod nodes;

use super::*;
use crate::sheet::Sheet;
use crate::sweep::Sweep;
use crate::{Flaw, Measures, PathPoints, check};
use microsim_mesh::{Block, CellSplit};
use microsim_random::SplitMix64;

type V3 = Vector3<f64>;

fn block(cells: [usize; 3]) -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: cells.map(|n| n as f64),
        cells,
        split: CellSplit::Kuhn,
    };
    block.mesh().unwrap()
}

/// A square around `center` with this normal, far over the body.
fn plane(center: V3, normal: V3) -> Sheet {
    let normal = normal.normalize();
    let side = normal
        .cross(&if normal.x.abs() < 0.7 {
            V3::x()
        } else {
            V3::y()
        })
        .normalize();
    let up = normal.cross(&side);
    let at = |a: f64, b: f64| center + (side * a + up * b) * 40.0;
    Sheet::quad(
        [at(-1.0, -1.0), at(1.0, -1.0)],
        [at(-1.0, 1.0), at(1.0, 1.0)],
    )
}

struct Body {
    mesh: TetMesh,
    topology: Topology,
}

impl Body {
    fn new(mesh: TetMesh) -> Self {
        let topology = Topology::new(&mesh);
        Self { mesh, topology }
    }

    fn cut(&mut self, stroke: &mut Stroke, sheet: &Sheet) -> Option<Cut> {
        let positions = self.mesh.positions.clone();
        let blade = Blade::Sheet {
            sheet,
            positions: &positions,
        };
        let cut = self
            .topology
            .cut(&self.mesh, stroke, &blade, &Settings::default())
            .unwrap();
        if let Some(cut) = &cut {
            self.mesh.apply(&cut.edit).unwrap();
        }
        cut
    }

    fn check(&self) -> Result<Measures, Flaw> {
        check(&self.mesh, &self.topology)
    }
}

/// Root mean square of the distances of points from a plane, from their sums: Σ (n·p − n·c)² = n·(Σ p pᵀ) n − 2 (n·c) n·Σ p + N (n·c)².
fn distance_from(points: &PathPoints, center: &V3, normal: &V3) -> f64 {
    let [xx, yy, zz, xy, xz, yz] = points.products;
    let products = nalgebra::Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let (count, offset) = (f64::from(points.count), normal.dot(center));
    let squares = normal.dot(&(products * normal)) - 2.0 * offset * normal.dot(&points.sum)
        + count * offset * offset;
    (squares.max(0.0) / count).sqrt()
}

#[test]
fn planes_separate_a_block_into_two() {
    let mut random = SplitMix64(3);
    for n in 0..200 {
        let mut mesh = block([3, 3, 3]);
        for p in &mut mesh.positions {
            *p += random.vector() * 0.12;
        }
        let mut body = Body::new(mesh);
        let before = body.check().unwrap();
        let (center, normal) = (random.vector() * 0.5, random.vector());
        let cut = body.cut(&mut Stroke::new(), &plane(center, normal));
        let cut = cut.unwrap();
        assert_eq!(cut.points.count as usize, cut.crossed);
        // A sheet is displaced by 1e-9 of an edge, and the root of a sum of squares near 1 has lost half of its 16 digits.
        assert!(distance_from(&cut.points, &center, &normal.normalize()) < 1e-6);
        let after = body.check().unwrap();
        assert_eq!((after.parts, cut.pieces.len()), (2, 1), "{n} {cut:?}");
        assert!((after.volume / before.volume - 1.0).abs() < 1e-12);
        assert!((after.outer_area / before.outer_area - 1.0).abs() < 1e-12);
        assert!(after.sheets[0].1 < 1e-12);
        assert!((after.sheets[0].0 - 2.0 * cut.opened[0].area).abs() < 1e-12);
        assert_eq!((cut.dropped, cut.joined), (0, 0));
    }
}

impl Body {
    fn sweep(&mut self, stroke: &mut Stroke, sweep: &Sweep) -> Option<Cut> {
        let positions = self.mesh.positions.clone();
        let blade = Blade::Sweep {
            sweeps: std::slice::from_ref(sweep),
            before: &positions,
            now: &positions,
        };
        let cut = self
            .topology
            .cut(&self.mesh, stroke, &blade, &Settings::default())
            .unwrap();
        if let Some(cut) = &cut {
            self.mesh.apply(&cut.edit).unwrap();
        }
        cut
    }
}

/// How far off a plane nodes of blocks with jittered nodes lie at most through which a cut along it goes: the least fraction of the longest edge, the diagonal of a cell and
/// what its ends were jittered by.
const STRAYS: f64 = 0.15 * 2.2;

impl Body {
    /// No element has nodes of the whole mesh on both sides of the plane, but for those through which the cut may go.
    fn check_sides(&self, originals: usize, center: &V3, normal: &V3, what: &str) {
        let height = |node: &u32| (self.mesh.positions[*node as usize] - center).dot(normal);
        for tet in &self.mesh.tets {
            let old = tet.iter().filter(|n| (**n as usize) < originals);
            let heights = old.map(height).filter(|height| height.abs() > STRAYS);
            let mut sides = heights.map(f64::is_sign_positive);
            let first = sides.next();
            assert!(sides.all(|side| Some(side) == first), "{what}");
        }
    }
}

#[test]
fn a_blade_that_passes_step_by_step_separates_as_a_plane_does() {
    let mut random = SplitMix64(4);
    for n in 0..200 {
        let mut mesh = block([3, 3, 3]);
        for p in &mut mesh.positions {
            *p += random.vector() * 0.12;
        }
        let originals = mesh.positions.len();
        let mut body = Body::new(mesh);
        let before = body.check().unwrap();
        let normal = random.vector().normalize();
        let center = random.vector() * 0.5;
        let along = normal.cross(&random.vector()).normalize();
        let across = normal.cross(&along);
        let steps = 5 + random.below(60);
        let at = |t: f64| {
            let middle = center + along * (t * 8.0 - 4.0);
            [middle - across * 6.0, middle + across * 6.0]
        };
        let mut stroke = Stroke::new();
        let mut pieces = 0;
        for step in 0..steps {
            let sweep = Sweep {
                before: at(step as f64 / steps as f64),
                now: at((step + 1) as f64 / steps as f64),
            };
            if let Some(cut) = body.sweep(&mut stroke, &sweep) {
                pieces += cut.pieces.len();
                let after = body.check().unwrap_or_else(|e| panic!("{n} {step} {e:?}"));
                assert!((after.volume / before.volume - 1.0).abs() < 1e-12);
                assert!((after.outer_area / before.outer_area - 1.0).abs() < 1e-12);
                assert!(after.sheets[0].1 < 1e-12);
            }
        }
        assert_eq!((body.check().unwrap().parts, pieces), (2, 1), "{n}");
        body.check_sides(originals, &center, &normal, &format!("{n}"));
    }
}

/// Area, normal and place of a cut against the plane, with steps of an eighth of a cell: nodes stray by the least fraction of an edge
/// (0.15 of √3 and what was jittered) at most, and not on average.
#[test]
fn a_cut_lies_where_the_blade_went() {
    let mut random = SplitMix64(8);
    let mut mesh = block([4, 4, 4]);
    for p in &mut mesh.positions {
        let inside = p.map(|x| if x.abs() < 1.9 { 0.1 } else { 0.0 });
        *p += random.vector().component_mul(&inside);
    }
    let mut body = Body::new(mesh);
    let normal = V3::new(0.2, -0.1, 1.0).normalize();
    let mut stroke = Stroke::new();
    let mut sum = (0.0, V3::zeros(), V3::zeros());
    for step in 0..64 {
        let at = |step: i32| {
            let along = f64::from(step) / 8.0 - 4.0;
            [-3.0, 3.0].map(|y| V3::new(along, y, 0.3 - 0.2 * along + 0.1 * y))
        };
        let sweep = Sweep {
            before: at(step),
            now: at(step + 1),
        };
        if let Some(cut) = body.sweep(&mut stroke, &sweep) {
            let opened = cut.opened[0];
            assert_eq!(cut.opened[0], cut.opened[1]);
            sum.0 += opened.area;
            sum.1 += opened.centroid * opened.area;
            sum.2 += opened.normal * opened.area;
            for face in &cut.edit.cut_faces {
                for node in face.nodes {
                    let height = (body.mesh.positions[node as usize] - V3::z() * 0.3).dot(&normal);
                    assert!(height.abs() < STRAYS, "{height}");
                }
            }
        }
    }
    // A square of 4 over the slope.
    let exact = 16.0 / normal.z;
    // Nodes beside the plane make it rough, and so larger.
    assert!((sum.0 / exact - 1.0).abs() < 0.05, "{} {exact}", sum.0);
    assert!(
        (sum.1 / sum.0 - V3::z() * 0.3).norm() < 0.05,
        "{:?}",
        sum.1 / sum.0
    );
    assert!(sum.2.normalize().cross(&normal).norm() < 0.01);
    assert_eq!(body.check().unwrap().parts, 2);
}

/// A blade that stops halfway leaves one part, with a gap as deep as it went, less than an element; nothing that it did not pass
/// opens. Going on from a state that was saved gives the same edits to the last bit.
#[test]
fn a_blade_under_way_leaves_what_it_has_passed_open() {
    let mut body = Body::new(block([6, 2, 6]));
    let mut saved = Body::new(block([6, 2, 6]));
    let mut strokes = [Stroke::new(), Stroke::new()];
    let mut area = 0.0;
    for step in 0..40 {
        // Down from above, at x = 0.1, right across y; the body reaches from −3 to 3.
        let at = |step: i32| {
            let z = 4.0 - 0.2 * f64::from(step);
            [V3::new(0.1, -2.0, z), V3::new(0.1, 2.0, z + 0.05)]
        };
        let sweep = Sweep {
            before: at(step),
            now: at(step + 1),
        };
        let cut = body.sweep(&mut strokes[0], &sweep);
        saved.topology = Topology::restore(&saved.mesh, &saved.topology.state());
        let again = saved.sweep(&mut strokes[1], &sweep);
        assert_eq!(cut, again);
        assert_eq!(strokes[0], strokes[1]);
        let after = body.check().unwrap();
        if let Some(cut) = cut {
            area += cut.opened[0].area;
        }
        let depth = (3.0 - at(step + 1)[0].z).clamp(0.0, 6.0);
        // Two wide; a cell's diagonal, 1.8 deep, may be in progress, and nodes beside the plane make the surface a little larger.
        assert!(area < 2.0 * depth * 1.05 + 0.1, "{step} {area} {depth}");
        assert!(area > 2.0 * (depth - 1.8), "{step} {area} {depth}");
        // The cut comes to a node when the blade is the least fraction of an edge from it: of a cell's diagonal at most.
        let is_below = |z: f64| at(step + 1).iter().all(|p| p.z < z);
        let parts = [-3.0, -3.0 + 0.15 * 3_f64.sqrt()].map(|z| 1 + usize::from(is_below(z)));
        assert!((parts[0]..=parts[1]).contains(&after.parts), "{step}");
    }
}

#[test]
fn what_is_rejected_changes_nothing() {
    let mut body = Body::new(block([2, 2, 2]));
    let positions = body.mesh.positions.clone();
    let mut lost = positions.clone();
    lost[13] = V3::repeat(f64::NAN);
    let good = Sweep {
        before: [V3::new(0.1, -2.0, -2.0), V3::new(0.1, 2.0, -2.0)],
        now: [V3::new(0.1, -2.0, 2.0), V3::new(0.1, 2.0, 2.0)],
    };
    let point = Sweep {
        before: [V3::x(); 2],
        now: [V3::y(); 2],
    };
    let infinite = Sweep {
        now: [V3::x(), V3::repeat(f64::INFINITY)],
        ..good
    };
    let flat = Sheet::quad([V3::x(), V3::y()], [V3::x(), V3::y()]);
    let cases = [
        (&good, &lost, Rejected::NotFinite),
        (&infinite, &positions, Rejected::NotFinite),
        (&point, &positions, Rejected::NoBlade),
    ];
    let settings = Settings::default();
    let mut stroke = Stroke::new();
    let state = body.topology.state();
    for (sweep, now, why) in cases {
        let blade = Blade::Sweep {
            sweeps: std::slice::from_ref(sweep),
            before: &positions,
            now,
        };
        let found = body
            .topology
            .cut(&body.mesh, &mut stroke, &blade, &settings);
        assert_eq!(found, Err(why));
    }
    let blade = Blade::Sheet {
        sheet: &flat,
        positions: &positions,
    };
    let found = body
        .topology
        .cut(&body.mesh, &mut stroke, &blade, &settings);
    assert_eq!(found, Err(Rejected::NoBlade));
    let short = Blade::Sweep {
        sweeps: &[good],
        before: &positions[1..],
        now: &positions,
    };
    let found = body
        .topology
        .cut(&body.mesh, &mut stroke, &short, &settings);
    assert!(matches!(found, Err(Rejected::Positions { .. })));
    body.mesh.generation = 4;
    let blade = Blade::Sweep {
        sweeps: &[good],
        before: &positions,
        now: &positions,
    };
    let found = body
        .topology
        .cut(&body.mesh, &mut stroke, &blade, &settings);
    assert!(matches!(found, Err(Rejected::Generation { .. })));
    body.mesh.generation = 0;
    assert_eq!(
        (body.topology.state(), stroke.clone()),
        (state, Stroke::new())
    );
    // A blade at rest cuts nothing; neither does one beside the body, nor one inside that meets no edge.
    let small = [V3::new(0.4, 0.3, 0.2), V3::new(0.41, 0.3, 0.2)];
    for (before, now) in [
        (good.before, good.before),
        (good.before, good.before.map(|p| p - V3::z())),
        (small, small.map(|p| p + V3::y() * 0.01)),
    ] {
        assert_eq!(body.sweep(&mut stroke, &Sweep { before, now }), None);
    }
    assert!(body.sweep(&mut stroke, &good).is_some());
}

/// Elements that are flat or inside out now are divided as they are at rest: at the same fractions of their edges.
#[test]
fn flattened_and_inverted_elements_are_cut() {
    let mut random = SplitMix64(9);
    for squeeze in [0.0, -0.3, 1e-12] {
        let mut mesh = block([3, 3, 3]);
        for p in &mut mesh.positions {
            *p += random.vector() * 0.1;
        }
        let mut body = Body::new(mesh);
        let before = body.check().unwrap();
        let positions: Vec<V3> = body
            .mesh
            .positions
            .iter()
            .map(|p| V3::new(p.x, p.y, p.z * squeeze + 0.1 * p.x))
            .collect();
        let sheet = plane(V3::new(0.1, 0.0, 0.0), V3::new(1.0, 0.2, 0.0));
        let blade = Blade::Sheet {
            sheet: &sheet,
            positions: &positions,
        };
        let settings = Settings::default();
        let mut stroke = Stroke::new();
        let cut = body
            .topology
            .cut(&body.mesh, &mut stroke, &blade, &settings);
        let cut = cut.unwrap().unwrap();
        body.mesh.apply(&cut.edit).unwrap();
        let after = body.check().unwrap();
        assert_eq!(after.parts, 2);
        assert!((after.volume / before.volume - 1.0).abs() < 1e-12);
    }
}

/// Snips: every step is a stroke of its own, which knows nothing of those before. They make one cut, without a bridge.
#[test]
fn strokes_that_go_on_from_one_another_make_one_cut() {
    let mut random = SplitMix64(12);
    for n in 0..20 {
        let mut mesh = block([3, 3, 3]);
        for p in &mut mesh.positions {
            *p += random.vector() * 0.12;
        }
        let originals = mesh.positions.len();
        let mut body = Body::new(mesh);
        let normal = random.vector().normalize();
        let center = random.vector() * 0.5;
        let along = normal.cross(&random.vector()).normalize();
        let across = normal.cross(&along) * 6.0;
        let steps = 2 + random.below(40) as i32;
        let at = |step: i32| {
            let middle = center + along * (8.0 * f64::from(step) / f64::from(steps) - 4.0);
            [middle - across, middle + across]
        };
        for step in 0..steps {
            let sweep = Sweep {
                before: at(step),
                now: at(step + 1),
            };
            body.sweep(&mut Stroke::new(), &sweep);
            body.check().unwrap();
        }
        assert_eq!(body.check().unwrap().parts, 2, "{n}");
        body.check_sides(originals, &center, &normal, &format!("{n}"));
    }
}

/// Three planes, one after another, in one step or in many: as many parts as there are combinations of sides among points in the block,
/// and as large; neither a bridge nor a flake. Elements that are cut for the third time are small: the parts are compared to 0.2 % of the
/// body.
#[test]
fn planes_one_after_another_make_exactly_their_parts() {
    for (seed, steps) in (0..4).flat_map(|s| [(s, 1), (s, 20)]) {
        let mut random = SplitMix64(seed);
        let mut mesh = block([5, 5, 5]);
        for p in &mut mesh.positions {
            let inside = p.map(|x| if x.abs() < 2.4 { 0.15 } else { 0.0 });
            *p += random.vector().component_mul(&inside);
        }
        let mut body = Body::new(mesh);
        let mut points: Vec<(V3, u8)> = (0..50_000).map(|_| (random.vector() * 2.5, 0)).collect();
        for _ in 0..3 {
            let normal = random.vector().normalize();
            let center = random.vector() * 1.2;
            let along = normal.cross(&random.vector()).normalize();
            let across = normal.cross(&along) * 10.0;
            for (point, sides) in &mut points {
                *sides = *sides << 1 | u8::from((*point - center).dot(&normal) > 0.0);
            }
            let mut stroke = Stroke::new();
            let at = |step: i32| {
                let middle = center + along * (20.0 * f64::from(step) / f64::from(steps) - 10.0);
                [middle - across, middle + across]
            };
            for step in 0..steps {
                let sweep = Sweep {
                    before: at(step),
                    now: at(step + 1),
                };
                body.sweep(&mut stroke, &sweep);
            }
        }
        let parts = body.check().unwrap().parts;
        points.sort_unstable_by_key(|(_, sides)| *sides);
        let mut expected: Vec<f64> = points
            .chunk_by(|a, b| a.1 == b.1)
            .map(|same| same.len() as f64 / points.len() as f64)
            .collect();
        let mut found = part_volumes(&body);
        // Of 750 elements: what is less than 0.4 of one stays on, and what is less than a whole one may, as cuts go through nodes beside their planes.
        expected.retain(|fraction| *fraction > 0.4 / 750.0);
        assert_eq!(parts, found.len());
        assert!(
            parts <= expected.len(),
            "{seed} {steps} {expected:?} {found:?}"
        );
        for volumes in [&mut expected, &mut found] {
            volumes.retain(|fraction| *fraction > 1.0 / 750.0);
        }
        assert_eq!(
            found.len(),
            expected.len(),
            "{seed} {steps} {expected:?} {found:?}"
        );
        expected.sort_unstable_by(f64::total_cmp);
        found.sort_unstable_by(f64::total_cmp);
        for (a, b) in expected.iter().zip(&found) {
            // The fraction of 50,000 points is right to 3 √(0.25 / 50,000) but for one in 400.
            assert!((a - b).abs() < 0.0067 + 0.005, "{expected:?} {found:?}");
        }
    }
}

/// The parts' volumes over that of the body.
fn part_volumes(body: &Body) -> Vec<f64> {
    let volumes = body.mesh.volumes();
    let mut seen = vec![false; volumes.len()];
    let mut found = Vec::new();
    for start in 0..volumes.len() {
        let mut open = vec![start as u32];
        let mut volume = 0.0;
        while let Some(element) = open.pop() {
            if std::mem::replace(&mut seen[element as usize], true) {
                continue;
            }
            volume += volumes[element as usize];
            open.extend((0..4).filter_map(|k| body.topology.neighbour(element, k)));
        }
        if volume > 0.0 {
            found.push(volume / volumes.iter().sum::<f64>());
        }
    }
    found
}

/// A blade that goes through twice, crosswise, and whose stroke is never ended: as many parts as combinations of sides.
#[test]
fn a_blade_that_comes_back_crosswise_cuts_through_both_times() {
    let mut random = SplitMix64(13);
    for n in 0..10 {
        let mut mesh = block([4, 4, 4]);
        for p in &mut mesh.positions {
            let inside = p.map(|x| if x.abs() < 1.9 { 0.15 } else { 0.0 });
            *p += random.vector().component_mul(&inside);
        }
        let mut body = Body::new(mesh);
        let mut stroke = Stroke::new();
        let mut points: Vec<(V3, u8)> = (0..10_000).map(|_| (random.vector() * 2.0, 0)).collect();
        for _ in 0..2 {
            let normal = random.vector().normalize();
            let center = random.vector() * 0.3;
            let along = normal.cross(&random.vector()).normalize();
            let across = normal.cross(&along) * 6.0;
            for (point, sides) in &mut points {
                *sides = *sides << 1 | u8::from((*point - center).dot(&normal) > 0.0);
            }
            let steps = 20 + random.below(20) as i32;
            let at = |step: i32| {
                let middle = center + along * (10.0 * f64::from(step) / f64::from(steps) - 5.0);
                [middle - across, middle + across]
            };
            for step in 0..steps {
                let sweep = Sweep {
                    before: at(step),
                    now: at(step + 1),
                };
                body.sweep(&mut stroke, &sweep);
            }
        }
        points.sort_unstable_by_key(|(_, sides)| *sides);
        let expected = points.chunk_by(|a, b| a.1 == b.1).count();
        assert_eq!(body.check().unwrap().parts, expected, "{n}");
    }
}
