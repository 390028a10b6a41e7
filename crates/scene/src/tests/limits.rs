//! What is refused, divided, repeated or rolled back.

use super::*;
use microsim_tissue::elements::{ContinuumPlasticity, Plasticity};
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};

#[test]
fn a_step_beyond_the_limit_is_refused_with_the_number_that_is_enough() {
    let scene = Scene::new(&strip([10, 2, 1], false)).unwrap();
    let required = scene.required_steps(TICK);
    assert_eq!(required, (TICK / scene.body(0).stable_step()).ceil() as u32);
    assert_eq!(scene.check_step(TICK, required), Ok(()));
    let error = scene.check_step(TICK, required - 1).unwrap_err();
    assert!(
        matches!(&error, SceneError::StepTooLong { body, required_steps, .. }
        if body == "strip" && *required_steps == required)
    );
    assert!(
        error
            .to_string()
            .contains(&format!("at least {required} steps per tick")),
        "{error}"
    );
    assert!(matches!(
        scene.check_step(TICK, 0),
        Err(SceneError::StepTooLong { .. })
    ));
    for tick_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            scene.check_step(tick_s, 10),
            Err(SceneError::Tick { .. })
        ));
    }
}

#[test]
fn a_diverging_tick_is_repeated_with_shorter_steps_and_reported() {
    let mut scene = Scene::new(&strip([10, 2, 1], false)).unwrap();
    // hω = 1.2·(0.95..1.05) at the required number: a third of it is beyond 2, twice that is not.
    let steps = scene.required_steps(TICK) / 3;
    let mut recoveries = Vec::new();
    for _ in 0..10 {
        let report = scene.tick(&[], TICK, steps, &Serial).unwrap();
        recoveries.extend(report.recoveries);
    }
    assert!(!recoveries.is_empty());
    assert!(
        recoveries
            .iter()
            .all(|r| r.body == 0 && (r.factor == 2 || r.factor == 4)),
        "{recoveries:?}"
    );
    // The strip never left the neighbourhood of its rest shape: it sags by less than half a millimetre.
    for (p, rest) in scene
        .body(0)
        .positions()
        .iter()
        .zip(scene.body(0).rest_positions())
    {
        assert!((p - rest).norm() < 0.5e-3);
    }
}

#[test]
fn a_tick_that_cannot_be_saved_leaves_the_last_good_state() {
    let mut scene = Scene::new(&strip([10, 2, 1], false)).unwrap();
    run(&mut scene, 0..5, &Serial);
    let good = scene.save();
    let mut failed = None;
    for _ in 0..20 {
        let before = scene.save();
        if let Err(error) = scene.tick(&[], 5.0 * TICK, 4, &Serial) {
            assert_eq!(scene.save(), before);
            failed = Some(error);
            break;
        }
    }
    let failed = failed.expect("steps a hundred times too long");
    assert_eq!((failed.body, failed.body_name.as_str()), (0, "strip"));
    assert!(failed.to_string().contains("strip"));
    scene.restore(&good).unwrap();
    run(&mut scene, 5..6, &Serial);
}

#[test]
fn a_tool_that_jumps_does_not_break_the_strip() {
    for lying in [false, true] {
        let mut scene = Scene::new(&strip([10, 2, 1], lying)).unwrap();
        let steps = scene.required_steps(TICK);
        // Appears inside, jumps through, vanishes, comes back from below, jumps sideways.
        let jumps = [
            (0.4e-3, 0.4e-3),
            (-250e-3, 250e-3),
            (30e-3, -20e-3),
            (1.2e-3, 0.0),
            (-5e-3, 5e-3),
        ];
        for (from, to) in jumps {
            let before = scene.save();
            match scene.tick(&[push(from, to)], TICK, steps, &Serial) {
                Ok(report) => assert!(report.invalid_motions.is_empty()),
                // A probe that drags the strip along at 6 m/s and more may be refused; one that appears in it may not.
                Err(error) => {
                    assert!((to - from).abs() > 0.04, "{from} {to}: {error}");
                    assert_eq!(scene.save(), before);
                }
            }
            assert!(
                scene
                    .body(0)
                    .positions()
                    .iter()
                    .all(|p| p.iter().all(|c| c.is_finite()))
            );
        }
        // Left alone it comes to rest again.
        for _ in 0..80 {
            scene.tick(&[], TICK, steps, &Serial).unwrap();
        }
        let worst = scene
            .body(0)
            .positions()
            .iter()
            .zip(scene.body(0).rest_positions())
            .map(|(p, rest)| (p - rest).norm())
            .fold(0.0, f64::max);
        assert!(worst < 0.5e-3, "lying {lying}: {worst}");
    }
}

#[test]
fn a_fast_tool_gets_more_substeps_only_near_the_body() {
    let mut scene = Scene::new(&strip([4, 1, 1], false)).unwrap();
    let steps = scene.required_steps(TICK);
    let mut substeps = |from: f64, to: f64| {
        let report = scene.tick(&[push(from, to)], TICK, steps, &Serial).unwrap();
        (report.substeps, report.many_substeps, report.jumped.len())
    };
    assert_eq!(substeps(-0.3e-3, -0.2e-3), (1, false, 0));
    // 0.125 mm per step is allowed: 5 solver's steps' worth of that per step needs 5 sub-steps.
    let travel = 5.0 * 0.125e-3 * f64::from(steps);
    assert_eq!(substeps(-0.3e-3 - travel, -0.3e-3), (5, false, 0));
    assert_eq!(
        substeps(-100e-3 - travel, -100e-3),
        (1, false, 0),
        "far away"
    );
    assert_eq!(substeps(-0.3e-3 - 4.0 * travel, -0.3e-3), (20, true, 0));
    // Further than a hand gets: it is not moved through what lies between.
    assert_eq!(substeps(-0.3e-3 - 52.0 * travel, -0.3e-3), (1, false, 1));
}

#[test]
fn motions_that_cannot_be_used_are_named() {
    let mut scene = Scene::new(&strip([4, 1, 1], false)).unwrap();
    let good = push(0.0, 0.1e-3);
    let mut unknown = good;
    unknown.tool = 3;
    let mut broken = good;
    broken.to.position.x = f64::NAN;
    let inactive = ToolMotion {
        active: false,
        ..good
    };
    let report = scene
        .tick(&[broken, unknown, good, good], TICK, 200, &Serial)
        .unwrap();
    assert_eq!(report.invalid_motions, [0, 1, 3]);
    assert_eq!(report.contacts.len(), 1);
    let report = scene.tick(&[inactive], TICK, 200, &Serial).unwrap();
    assert_eq!(
        (report.contacts.len(), report.invalid_motions.len()),
        (0, 0)
    );
}

#[test]
fn impossible_scenes_are_refused_with_the_part_that_is_wrong() {
    let good = strip([4, 1, 1], false);
    type Case = (fn(&mut SceneSpec), &'static str);
    let cases: [Case; 24] = [
        (
            |s| s.bodies.push(s.bodies[0].clone()),
            "each body needs a name of its own, 'strip'",
        ),
        (
            |s| s.tools[0].name.clear(),
            "each tool needs a name of its own, ''",
        ),
        (
            |s| s.bodies[0].materials[0].1.density = -1.0,
            "body 'strip': material of region 0: density is -1, allowed is > 0 kg/m³",
        ),
        (
            |s| s.bodies[0].mesh.tets[3].swap(0, 1),
            "element 3 has the rest volume",
        ),
        (
            |s| {
                s.bodies[0].clamps[1].nodes = Selection::Box(BoxSpec {
                    min: [1.0; 3],
                    max: [2.0; 3],
                })
            },
            "clamp 1 of body 'strip' holds nothing",
        ),
        (
            |s| s.tools[0].capsules.clear(),
            "tool 'probe' needs at least one capsule",
        ),
        (
            |s| s.tools[0].capsules[0].radius = 0.0,
            "capsule 0 of tool 'probe'",
        ),
        (
            |s| {
                s.tools[0].capsules[0].joint = Joint::Hinge(Hinge {
                    pivot: Vector3::zeros(),
                    axis: Vector3::y_axis(),
                    angle: f64::NAN,
                });
            },
            "capsule 0 of tool 'probe'",
        ),
        (|s| s.contacts[0].body = "vessel".into(), "no such body"),
        (
            |s| s.contacts[0].with = PartnerSpec::Tool("knife".into()),
            "contact of body 'strip' with 'knife': no such tool",
        ),
        (
            |s| s.contacts[0].with = PartnerSpec::Obstacle("table".into()),
            "no such obstacle",
        ),
        (
            |s| {
                s.contacts[0].with = PartnerSpec::Body {
                    name: "strip".into(),
                    end_planes: false,
                };
            },
            "a body and itself are no two bodies",
        ),
        (
            |s| {
                s.bodies.push(BodySpec {
                    name: "other".into(),
                    ..s.bodies[0].clone()
                });
                s.contacts[0].with = PartnerSpec::Body {
                    name: "other".into(),
                    end_planes: true,
                };
            },
            "end planes are those of two bodies from the generator of tubes",
        ),
        (
            |s| s.contacts[0].friction = -0.1,
            "friction is a number of at least 0",
        ),
        (
            |s| s.contacts[0].force_limit = f64::NAN,
            "the limit of the force",
        ),
        (|s| s.contacts.push(s.contacts[0].clone()), "occurs twice"),
        (
            |s| {
                let key = |time| ToolKeySpec {
                    time,
                    pose: Pose::identity(),
                    opening: 0.0,
                };
                s.tools[0].motion = vec![key(1.0), key(0.5)];
            },
            "key 1 of the motion of tool 'probe'",
        ),
        (
            |s| {
                s.obstacles.push(ObstacleSpec {
                    name: "table".into(),
                    parts: Vec::new(),
                });
            },
            "obstacle 'table' needs parts",
        ),
        (
            |s| s.method = Method::ExplicitEuler,
            "explicit-euler cannot enforce non-penetration",
        ),
        (
            |s| {
                s.bodies[0].clamps[0].motion = Some(MotionSpec {
                    pivot: [0.0; 3],
                    axis: [0.0; 3],
                    keys: Vec::new(),
                });
            },
            "clamp 0 of body 'strip': an axis",
        ),
        (
            |s| {
                let key = |time| MotionKey {
                    time,
                    shift: [0.0; 3],
                    angle: 0.0,
                };
                s.bodies[0].clamps[1].motion = Some(MotionSpec {
                    pivot: [0.0; 3],
                    axis: [0.0, 0.0, 1.0],
                    keys: vec![key(1.0), key(1.0)],
                });
            },
            "the times of a motion ascend",
        ),
        (
            |s| {
                let mut twin = s.bodies[0].clamps[0].clone();
                twin.release = Some(1.0);
                twin.motion = Some(MotionSpec {
                    pivot: [0.0; 3],
                    axis: [0.0, 0.0, 1.0],
                    keys: Vec::new(),
                });
                s.bodies[0].clamps.push(twin);
            },
            "clamps 0 and 2 of body 'strip' have a common node",
        ),
        (
            |s| s.bodies[0].clamps[0].release = Some(f64::NAN),
            "clamp 0 of body 'strip': its release",
        ),
        (|s| s.gravity[1] = f64::NAN, "gravity"),
    ];
    for (spoil, expected) in cases {
        let mut spec = good.clone();
        spoil(&mut spec);
        let text = Scene::new(&spec).unwrap_err().to_string();
        assert!(
            text.contains(expected),
            "'{text}' does not say '{expected}'"
        );
    }
}

/// A strip of springs, and one of a continuum, that yields and hardens under the probe: its stable step shrinks, what a continuum has dissipated grows, and
/// a saved scene goes on with the same bits.
#[test]
fn a_hardening_body_needs_more_steps_and_is_saved_exactly() {
    let mut springs = SpringConstants::scaled(25e3, 5e4);
    springs.plasticity = Some(Plasticity {
        yield_strain: 0.0,
        creep_rate: 200.0,
        max_strain: 1.0,
        hardening: 500.0,
        max_stiffening: 20.0,
    });
    let continuum = ContinuumConstants {
        law: LawName::StableNeoHookean.into(),
        young: 25e3,
        poisson: 0.3,
        discretisation: Discretisation::Selective,
        plasticity: Some(ContinuumPlasticity {
            yield_strain: 0.0,
            yield_growth: 0.1,
            creep_rate: Some(200.0),
            max_strain: 1.0,
            hardening: 500.0,
            max_stiffening: 20.0,
        }),
    };
    hardens_and_is_saved(Behaviour::Springs(springs), false);
    hardens_and_is_saved(Behaviour::Continuum(continuum), true);
}

fn hardens_and_is_saved(behaviour: Behaviour, dissipates: bool) {
    let mut spec = strip([8, 2, 1], false);
    spec.bodies[0].materials[0].1.behaviour = behaviour;
    let mut scene = Scene::new(&spec).unwrap();
    let steps = scene.required_steps(TICK);
    let at_rest = scene.body(0).stable_step();
    let push = |scene: &mut Scene, k: usize| {
        let motion = push(depth(k), depth(k + 1));
        scene.tick(&[motion], TICK, steps, &Serial).unwrap()
    };
    let reports: Vec<_> = (0..30).map(|k| push(&mut scene, k)).collect();
    let stiffened = reports.iter().any(|report| report.stiffened);
    assert!(stiffened && scene.body(0).stable_step() < at_rest);
    assert_eq!(scene.body(0).energies().dissipated > 0.0, dissipates);

    let mut copy = Scene::new(&spec).unwrap();
    copy.restore(&scene.save()).unwrap();
    for k in 30..34 {
        assert_eq!(push(&mut scene, k), push(&mut copy, k));
    }
    assert_eq!(scene.save(), copy.save());
}

/// A grip holds the nodes under the probe: the tool cannot move them, and no force on them is counted.
#[test]
fn a_tool_does_not_move_what_a_grip_holds() {
    let mut spec = strip([8, 2, 1], false);
    spec.bodies[0].clamps.push(ClampSpec {
        nodes: Selection::Box(BoxSpec {
            min: [-9e-3, -1.0, -1.0],
            max: [9e-3, 1.0, 1.0],
        }),
        motion: None,
        release: Some(1.0),
    });
    spec.gravity = [0.0; 3];
    let mut scene = Scene::new(&spec).unwrap();
    let steps = scene.required_steps(TICK);
    for k in 0..8 {
        let motion = push(depth(k), depth(k + 1));
        let report = scene.tick(&[motion], TICK, steps, &Serial).unwrap();
        assert!(
            report
                .contacts
                .iter()
                .all(|c| c.force_on_tissue == [0.0; 3])
        );
    }
    for (p, rest) in scene
        .body(0)
        .positions()
        .iter()
        .zip(scene.body(0).rest_positions())
    {
        assert!((p - rest).norm() < 1e-15, "{p} {rest}");
    }
}
