//! Forces of the parts of a tool, and ticks that are computed again.

use super::*;
use crate::spec::Jaw;

const HALF: f64 = 2e-3;

/// One iteration, whatever is left of the forces.
const POOR: Newton = Newton {
    iterations: 1,
    tolerance: 1e-6,
    must_converge: false,
};

/// A block of soft tissue without weight, and jaws along y on its sides across x, `gap` \[m\] apart from it.
fn squeezed(newton: Newton, gap: f64) -> SceneSpec {
    let block = Block {
        center: [0.0; 3],
        size: [2.0 * HALF; 3],
        cells: [4; 3],
        split: CellSplit::Kuhn,
    };
    let material = Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Springs(SpringConstants::scaled(25e3, 5e4)),
    };
    let jaw = |name: &str, side: f64, jaw: Jaw| CapsuleSpec {
        name: name.into(),
        jaw: Some(jaw),
        ..CapsuleSpec::new(
            [side * (HALF + 0.5e-3 + gap), -HALF, 0.0],
            [side * (HALF + 0.5e-3 + gap), HALF, 0.0],
            0.5e-3,
        )
    };
    SceneSpec {
        gravity: [0.0; 3],
        tools: vec![ToolSpec {
            name: "forceps".into(),
            capsules: vec![
                jaw("left-tip", 1.0, Jaw::Left),
                jaw("right-tip", -1.0, Jaw::Right),
            ],
            sharpness: 0.0,
            jaw_stiffness: f64::INFINITY,
            irrigation: None,
            motion: Vec::new(),
        }],
        contacts: vec![ContactSpec {
            force_limit: 1e-3,
            ..ContactSpec::new("block", PartnerSpec::Tool("forceps".into()))
        }],
        ..SceneSpec::new(
            vec![BodySpec::new("block", block.mesh().unwrap(), material)],
            Method::ImplicitEuler(newton),
        )
    }
}

fn held(from: [f64; 3], to: [f64; 3]) -> ToolMotion {
    let at = |position: [f64; 3]| Pose {
        position: position.into(),
        ..Pose::identity()
    };
    ToolMotion {
        tool: 0,
        from: at(from),
        to: at(to),
        opening_from: 0.0,
        opening_to: 0.0,
        active: true,
    }
}

/// Jaws that squeeze: by symmetry each pushes with the same force, which is the grip, and the tool as a whole with none.
#[test]
fn opposing_jaws_do_not_cancel_in_the_forces_of_parts() {
    let mut scene = Scene::new(&squeezed(Newton::default(), -0.1e-3)).unwrap();
    let still = held([0.0; 3], [0.0; 3]);
    for _ in 0..20 {
        scene.tick(&[still], 5e-3, 1, &Serial).unwrap();
    }
    let report = scene.tick(&[still], 5e-3, 1, &Serial).unwrap();
    assert!(report.valid && report.repetitions == 0);
    let [contact] = &report.contacts[..] else {
        panic!("{:?}", report.contacts)
    };
    let [left, right] = &contact.parts[..] else {
        panic!("{:?}", contact.parts)
    };
    let names = [left, right].map(|part| scene.part_name(0, part.capsule));
    assert_eq!(names, ["left-tip", "right-tip"]);
    let net = Vector3::from(contact.force_on_tissue);
    let parts = [left, right].map(|part| Vector3::from(part.force_on_tissue));
    // What the sum of two numbers rounds.
    assert!((parts[0] + parts[1] - net).norm() <= 1e-12 * parts[0].norm());
    assert!(parts[0].x < -1e-3 && parts[1].x > 1e-3, "{parts:?}");
    // The mesh is not quite symmetric, and what is left of the forces is 1e-6 of them.
    assert!(net.norm() < 0.05 * parts[0].norm(), "{net} of {}", parts[0]);
    let least = (-parts[0].x).min(parts[1].x);
    assert!(
        (contact.grip_n - least).abs() < 1e-9,
        "{} {least}",
        contact.grip_n
    );
    for (part, side) in [left, right].into_iter().zip([1.0, -1.0]) {
        // Without friction on a flat side the normals are along x, but for the corners.
        let size = Vector3::from(part.force_on_tissue).norm();
        assert!((part.normal_force_n / size - 1.0).abs() < 0.05);
        assert!(
            (part.point[0] * side - HALF).abs() < 0.3e-3,
            "{:?}",
            part.point
        );
        assert!(part.nodes > 0 && part.nodes < contact.nodes);
    }
}

/// Two jaws press a block whose halves are of two regions: on each acts what its jaw does, to the bit, and all of it together is the force
/// on the body. Under one jaw in the middle of a side that the border halves, each region bears half of it.
#[test]
fn forces_of_regions_sum_up_to_that_on_the_body() {
    let halved = |axis: usize| {
        let mut spec = squeezed(Newton::default(), -0.1e-3);
        let body = &mut spec.bodies[0];
        let mesh = &mut body.mesh;
        let is_behind = |tet: &[u32; 4]| {
            let along = tet.iter().map(|&node| mesh.positions[node as usize][axis]);
            along.sum::<f64>() > 0.0
        };
        mesh.regions = mesh
            .tets
            .iter()
            .map(|tet| 4 + u32::from(is_behind(tet)))
            .collect();
        let (_, material) = body.materials[0];
        body.materials = vec![(4, material), (5, material)];
        spec
    };
    let still = held([0.0; 3], [0.0; 3]);
    let contact = |spec: &SceneSpec, motion: ToolMotion| {
        let mut scene = Scene::new(spec).unwrap();
        for _ in 0..20 {
            scene.tick(&[motion], 5e-3, 1, &Serial).unwrap();
        }
        let mut report = scene.tick(&[motion], 5e-3, 1, &Serial).unwrap();
        assert_eq!(report.contacts.len(), 1);
        report.contacts.remove(0)
    };
    let force = |region: &RegionReport| Vector3::from(region.force_on_tissue);

    let across = contact(&halved(0), still);
    let [low, high] = &across.regions[..] else {
        panic!("{:?}", across.regions)
    };
    assert_eq!([low.region, high.region], [4, 5]);
    let [left, right] = &across.parts[..] else {
        panic!("{:?}", across.parts)
    };
    for (region, part) in [(low, right), (high, left)] {
        assert_eq!(region.force_on_tissue, part.force_on_tissue);
        assert_eq!(region.normal_force_n, part.normal_force_n);
        assert_eq!(region.point, part.point);
    }
    assert!(force(low).x > 1e-3 && force(high).x < -1e-3);

    // Both jaws lie along y, over the border.
    let along = contact(&halved(1), still);
    let pushed: f64 = along.parts.iter().map(|part| part.normal_force_n).sum();
    for (contact, regions) in [(&across, 2), (&along, 2)] {
        assert_eq!(contact.regions.len(), regions);
        let sum: Vector3<f64> = contact.regions.iter().map(force).sum();
        let net = Vector3::from(contact.force_on_tissue);
        assert!((sum - net).norm() <= 1e-12 * pushed, "{sum} {net}");
    }
    let halves = along.regions.iter().map(|region| region.normal_force_n);
    for half in halves {
        assert!((half / pushed - 0.5).abs() < 0.05, "{half} of {pushed}");
    }
    let whole = contact(&squeezed(Newton::default(), -0.1e-3), still);
    let [all] = &whole.regions[..] else {
        panic!("{:?}", whole.regions)
    };
    assert_eq!(all.region, 0);
    let net = Vector3::from(whole.force_on_tissue);
    assert!((force(all) - net).norm() <= 1e-12 * all.normal_force_n);
}

/// The sustained force of a constant squeeze is its own from 50 ms on, and the time over the limit is the tick; before, it grows in
/// proportion.
#[test]
fn sustained_forces_are_those_of_the_last_50_ms() {
    let mut scene = Scene::new(&squeezed(Newton::default(), -0.1e-3)).unwrap();
    let still = held([0.0; 3], [0.0; 3]);
    let mut grips = Vec::new();
    for _ in 0..40 {
        let report = scene.tick(&[still], 5e-3, 1, &Serial).unwrap();
        let [contact] = &report.contacts[..] else {
            panic!("{:?}", report.contacts)
        };
        grips.push(contact.grip_n);
        let last = &grips[grips.len().saturating_sub(10)..];
        let mean = last.iter().sum::<f64>() / 10.0;
        assert!((contact.sustained_grip_n / mean - 1.0).abs() < 1e-12);
        let over = contact.sustained_force_n > 1e-3;
        assert_eq!(contact.over_limit_s, if over { 5e-3 } else { 0.0 });
    }
}

/// A blow in one long step with one iteration: the forces mean nothing, also after the one repetition; the ticks that follow are not
/// repeated until one is valid. A scene that must not repeat does not. What is decided goes through a saved state.
#[test]
fn a_tick_whose_forces_mean_nothing_is_repeated_once() {
    let motion = |from: f64, to: f64, active: bool| ToolMotion {
        tool: 0,
        from: pose(from),
        to: pose(to),
        opening_from: 0.0,
        opening_to: 0.0,
        active,
    };
    let blow = motion(-0.5e-3, 40e-3, true);
    let still = motion(40e-3, 40e-3, true);
    let away = motion(40e-3, 40e-3, false);
    let spec = SceneSpec {
        method: Method::ImplicitEuler(POOR),
        ..strip([20, 4, 1], true)
    };
    let mut scene = Scene::new(&spec).unwrap();
    let report = scene.tick(&[blow], 0.05, 1, &Serial).unwrap();
    assert!(!report.valid, "{:?}", report.solver);
    assert_eq!((report.repetitions, report.recoveries.len()), (1, 0));
    // What follows is divided among several ticks.
    assert_eq!(scene.state.placements.pace, 0.25);
    let sustained = |contact: &ContactReport| contact.sustained_force_n;
    assert!(
        report
            .contacts
            .iter()
            .map(sustained)
            .all(|force| force == 0.0)
    );
    let mut other = Scene::new(&spec).unwrap();
    other.restore(&scene.save()).unwrap();
    for scene in [&mut scene, &mut other] {
        let report = scene.tick(&[still], 0.05, 1, &Serial).unwrap();
        assert_eq!(report.repetitions, 0, "{:?}", report.solver);
        let valid = (0..40).any(|_| scene.tick(&[away], 0.05, 1, &Serial).unwrap().valid);
        assert!(valid, "a body that nothing touches comes to rest");
        // Two valid ticks, and the jaws make whole motions again.
        scene.tick(&[away], 0.05, 1, &Serial).unwrap();
        assert_eq!(scene.state.placements.pace, 1.0);
        let report = scene.tick(&[blow], 0.05, 1, &Serial).unwrap();
        assert_eq!((report.valid, report.repetitions), (false, 1));
    }
    assert_eq!(scene.digest(), other.digest());

    let mut once = Scene::new(&SceneSpec {
        repeat_invalid: false,
        ..spec
    })
    .unwrap();
    let report = once.tick(&[blow], 0.05, 1, &Serial).unwrap();
    assert_eq!((report.valid, report.repetitions), (false, 0));
    assert_eq!(once.state.placements.pace, 1.0);
}
