//! Tools between where a hand holds them and where tissue, and one another, let them be.

use super::*;
use crate::placement::Placements;
use crate::tool::Tool;
use microsim_geometry::{Hinge, Joint};
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};

/// Of the tip of a jaw \[N/m\].
const STIFFNESS: f64 = 500.0;

/// From hinge to tip \[m\], radius \[m\], and turn of each jaw per unit of opening \[rad\].
const LENGTH: f64 = 15e-3;
const THIN: f64 = 0.25e-3;
const TURN: f64 = 0.1;

/// Thickness of the block between the jaws \[m\].
const THICK: f64 = 0.6e-3;

/// Jaws along −y from a hinge at y = `LENGTH`, that open along z.
fn forceps(name: &str) -> ToolSpec {
    let jaw = |side: f64, jaw| CapsuleSpec {
        joint: Joint::Hinge(Hinge {
            pivot: Vector3::new(0.0, LENGTH, THIN * side),
            axis: Vector3::x_axis(),
            angle: -TURN * side,
        }),
        jaw: Some(jaw),
        ..CapsuleSpec::new([0.0, 0.0, THIN * side], [0.0, LENGTH, THIN * side], THIN)
    };
    ToolSpec {
        name: name.into(),
        capsules: vec![jaw(1.0, Jaw::Left), jaw(-1.0, Jaw::Right)],
        sharpness: 0.0,
        jaw_stiffness: STIFFNESS,
        irrigation: None,
        motion: Vec::new(),
    }
}

/// A block of soft tissue, held at its far side, between the jaws of forceps.
fn gripped() -> SceneSpec {
    let block = Block {
        center: [0.0; 3],
        size: [3e-3, 2e-3, THICK],
        cells: [6, 4, 2],
        split: CellSplit::Kuhn,
    };
    let law = ContinuumConstants {
        law: LawName::StableNeoHookean.into(),
        young: 50e3,
        poisson: 0.4,
        discretisation: Discretisation::Tetrahedra,
        plasticity: None,
    };
    let material = Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(law),
    };
    let clamp = ClampSpec {
        nodes: Selection::Box(BoxSpec {
            min: [-1.0, -1e-3, -1.0],
            max: [1.0, -1e-3, 1.0],
        }),
        motion: None,
        release: None,
    };
    let body = BodySpec {
        clamps: vec![clamp],
        ..BodySpec::new("block", block.mesh().unwrap(), material)
    };
    let contact = ContactSpec {
        friction: 0.3,
        ..ContactSpec::new("block", PartnerSpec::Tool("forceps".into()))
    };
    SceneSpec {
        tools: vec![forceps("forceps")],
        contacts: vec![contact],
        gravity: [0.0; 3],
        ..SceneSpec::new(
            vec![body],
            Method::QuasiStatic(Newton {
                iterations: 4,
                tolerance: 1e-3,
                must_converge: false,
            }),
        )
    }
}

/// With the tip so far from the middle of the field, and the opening.
fn at(y: f64, opening: [f64; 2]) -> ToolMotion {
    let pose = Pose {
        position: Vector3::new(0.1e-3, y, 0.03e-3),
        ..Pose::identity()
    };
    ToolMotion {
        tool: 0,
        from: pose,
        to: pose,
        opening_from: opening[0],
        opening_to: opening[1],
        active: true,
    }
}

/// Closes in so many ticks from 0.5, and then stays closed.
fn closing(tick: usize, ticks: usize) -> [f64; 2] {
    [tick, tick + 1].map(|k| 0.5 * (1.0 - k as f64 / ticks as f64).max(0.0))
}

/// Both tips move by l α per unit of opening: twice the energy of a spring of that stretch.
#[test]
fn both_tips_give_the_stiffness_of_the_opening() {
    let scene = Scene::new(&gripped()).unwrap();
    let expected = 2.0 * STIFFNESS * (LENGTH * TURN) * (LENGTH * TURN);
    let found = scene.tools[0].jaw_stiffness;
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    let rigid = ToolSpec {
        jaw_stiffness: f64::INFINITY,
        irrigation: None,
        ..forceps("rigid")
    };
    assert_eq!(Tool::new(&rigid).unwrap().jaw_stiffness, f64::INFINITY);
}

/// Forceps that are closed completely squeeze what is between them: every tick is computed, and the jaws are in equilibrium with what they press. Steps of four iterations
/// leave the moment of a single one uncertain by 3 % where the tissue slips between the jaws (seen with four and with sixteen steps in a tick), so equilibrium is that of the
/// mean over twenty ticks, within three times what then remains of it.
#[test]
fn what_is_between_jaws_that_close_completely_is_squeezed() {
    // Bent by half the thickness of the block at most, and what it takes to turn them where they touch.
    let most = 1.5 * STIFFNESS * 0.5 * THICK;
    for ticks in [4, 30] {
        let mut scene = Scene::new(&gripped()).unwrap();
        let (mut stands, mut last) = (0, 0.0);
        let (mut bent, mut moment) = (0.0, 0.0);
        for tick in 0..ticks + 40 {
            let report = scene.tick(&[at(-0.4e-3, closing(tick, ticks))], TICK, 4, &Serial);
            let report = report.unwrap_or_else(|diverged| panic!("tick {tick}: {diverged}"));
            stands += usize::from(report.stands);
            let parts = report.contacts.iter().flat_map(|contact| &contact.parts);
            last = parts.map(|part| 0.5 * part.normal_force_n).sum();
            assert!(last < most, "{ticks}, tick {tick}: {last} N of {most} N");
            if tick >= ticks + 20 {
                let placement = scene.state.placements.tools[0].unwrap();
                assert!(placement.opening > 0.05, "{placement:?}");
                bent += scene.tools[0].jaw_stiffness * (placement.opening - placement.target);
                moment += placement.moment;
            }
        }
        assert!(last > 0.1 * most, "{last} N of {most} N");
        assert!(
            (bent / moment - 1.0).abs() < 0.02,
            "{ticks}: {bent} J, {moment} J, stands {stands}"
        );
        assert!(stands <= 2, "{ticks}: {stands}");
    }
}

/// Jaws that tissue hardly bends leave a tenth of the opening at which they began to press it, which is stated, and by what its force bends them; a hand that trembles squeezes it no further. It is let go when they open.
#[test]
fn stiff_jaws_do_not_squeeze_tissue_to_nothing() {
    let mut spec = gripped();
    spec.tools[0].jaw_stiffness = 1e5;
    let mut scene = Scene::new(&spec).unwrap();
    let tick = |scene: &mut Scene, opening, heights: [f64; 2]| {
        let mut motion = at(-0.4e-3, opening);
        [motion.from.position.z, motion.to.position.z] = heights;
        let report = scene.tick(&[motion], TICK, 4, &Serial);
        let report = report.unwrap();
        let placement = scene.state.placements.tools[0].unwrap();
        (report, 2.0 * LENGTH * TURN * placement.opening)
    };
    for k in 0..50 {
        let trembles = [k, k + 1].map(|k| if k % 2 == 0 { 0.06e-3 } else { 0.0 });
        let (_, left) = tick(&mut scene, closing(k, 30), trembles);
        assert!(left > 0.09 * THICK, "tick {k}: {left} m");
    }
    for _ in 0..10 {
        tick(&mut scene, [0.0, 0.0], [0.06e-3, 0.06e-3]);
    }
    let (report, left) = tick(&mut scene, [0.0, 0.0], [0.06e-3, 0.06e-3]);
    assert!(report.valid && !report.contacts.is_empty());
    assert!(left < 0.12 * THICK, "{left} m");
    let mut after = None;
    for k in 0..30 {
        let opens = [k, k + 1].map(|k| f64::from(k) / 30.0);
        after = Some(tick(&mut scene, opens, [0.06e-3, 0.06e-3]).0);
    }
    assert!(after.unwrap().contacts.is_empty());
}

/// Jaws that close on what they hold within a tick, and open again in the next, take shorter steps: nothing is repeated, and they hold it with the force of before, as the
/// tissue is elastic; a tenth of it is left to what slips under friction. The steps are those of the distance by which the tips close, 2 l α per unit of opening.
#[test]
fn jaws_that_twitch_hold_what_they_held() {
    let method = Method::ImplicitEuler(Newton {
        iterations: 8,
        tolerance: 1e-3,
        must_converge: false,
    });
    let mut scene = Scene::new(&SceneSpec {
        method,
        ..gripped()
    })
    .unwrap();
    let edge = scene.bodies[0].model.mean_edge_length();
    let held = 0.15;
    // The force between the jaws at the end, and the sub-steps of the last tick.
    let mut follow = |openings: &[[f64; 2]]| {
        let mut end = (0.0, 0);
        for openings in openings {
            let report = scene.tick(&[at(-0.4e-3, *openings)], TICK, 1, &Serial);
            let report = report.unwrap();
            assert!(
                report.recoveries.is_empty() && !report.stands,
                "{openings:?}"
            );
            let parts = report.contacts.iter().flat_map(|contact| &contact.parts);
            end = (
                parts.map(|part| 0.5 * part.normal_force_n).sum(),
                report.substeps,
            );
        }
        end
    };
    let closes = (0..30).map(|k| [k, k + 1].map(|k| 0.5 + (held - 0.5) * f64::from(k) / 30.0));
    follow(&closes.collect::<Vec<_>>());
    let rest = [[held; 2]; 40];
    let (before, _) = follow(&rest);
    let (_, substeps) = follow(&[[held, 0.0]]);
    let steps = |by: f64| (2.0 * LENGTH * TURN * by / (0.25 * edge)).ceil() as u32;
    assert_eq!(substeps, steps(held));
    follow(&[[0.0, held]]);
    let (after, _) = follow(&rest);
    // Nor where they have let it go before they close, with fewer steps as long as they are away from it.
    follow(&[[held, 0.5]]);
    let (_, substeps) = follow(&[[0.5, 0.0]]);
    assert!((2..=steps(0.5)).contains(&substeps), "{substeps}");
    follow(&[[0.0, held]]);
    assert!(before > 1e-3, "{before} N");
    assert!((after / before - 1.0).abs() < 0.1, "{before} N, {after} N");
}

/// Without any force a tool is where the hand holds it, to the bit.
#[test]
fn a_tool_that_touches_nothing_is_where_it_is_held() {
    let mut scene = Scene::new(&gripped()).unwrap();
    for tick in 0..6 {
        let motion = at(5e-3, closing(tick, 6));
        scene.tick(&[motion], TICK, 4, &Serial).unwrap();
        let placement = scene.state.placements.tools[0].unwrap();
        assert!(placement.is_free);
        assert_eq!(
            (placement.pose, placement.opening),
            (motion.to, motion.opening_to)
        );
    }
}

/// A scene that is saved while jaws are bent goes on as if it had not been.
#[test]
fn bent_jaws_are_saved() {
    let mut scene = Scene::new(&gripped()).unwrap();
    let mut other = scene.clone();
    for tick in 0..20 {
        let motion = at(-0.4e-3, closing(tick, 10));
        scene.tick(&[motion], TICK, 4, &Serial).unwrap();
        if tick == 9 {
            other.restore(&scene.save()).unwrap();
        } else if tick > 9 {
            other.tick(&[motion], TICK, 4, &Serial).unwrap();
        }
    }
    assert!(!scene.state.placements.tools[0].unwrap().is_free);
    assert_eq!(scene.digest(), other.digest());
}

/// Two rods, one along x and one along y, without any tissue near.
fn rods() -> Scene {
    let rod = |name: &str, end: [f64; 3]| ToolSpec {
        name: name.into(),
        capsules: vec![CapsuleSpec::new(end.map(|x| -x), end, 0.2e-3)],
        jaw_stiffness: f64::INFINITY,
        irrigation: None,
        sharpness: 0.0,
        motion: Vec::new(),
    };
    let mut spec = gripped();
    spec.tools_touch = true;
    spec.tools = vec![
        forceps("forceps"),
        rod("along", [5e-3, 0.0, 0.0]),
        rod("across", [0.0, 5e-3, 0.0]),
    ];
    Scene::new(&spec).unwrap()
}

/// The height of a rod \[m\].
fn height(scene: &Scene, tool: usize) -> f64 {
    scene.state.placements.tools[tool].unwrap().pose.position.z
}

/// However fast they are, and wherever the hands go, rods stay on the side on which they were, as near as they are thick, and part again.
#[test]
fn tools_do_not_pass_through_each_other() {
    for speed in [0.05e-3, 0.7e-3, 9e-3] {
        let mut scene = rods();
        let place = |tool: usize, from: f64, to: f64| {
            let pose = |z: f64| Pose {
                position: Vector3::new(0.3e-3, 0.2e-3, 20e-3 + z),
                ..Pose::identity()
            };
            ToolMotion {
                tool,
                from: pose(from),
                to: pose(to),
                opening_from: 0.0,
                opening_to: 0.0,
                active: true,
            }
        };
        let mut touched = 0;
        let ticks = (4e-3 / speed) as usize + 2;
        let path = |k: usize| 2e-3 - speed * k as f64;
        for k in 0..2 * ticks {
            // Down through the other one, and back.
            let [from, to] = [k, k + 1].map(|k| path(k.min(2 * ticks - k)));
            let motions = [place(1, 0.0, 0.0), place(2, from, to)];
            let report = scene.tick(&motions, TICK, 4, &Serial).unwrap();
            touched += usize::from(report.touching == [[1, 2]]);
            let gap = height(&scene, 2) - height(&scene, 1);
            assert!(gap > 0.4e-3 - 1e-9, "speed {speed}, tick {k}: {gap}");
        }
        assert!(touched >= 2, "{touched}");
        assert!(
            scene
                .state
                .placements
                .tools
                .iter()
                .flatten()
                .all(|p| p.is_free)
        );
    }
}

/// A probe that is pushed 3 mm into a block on a floor, by a hand of at most 80 mN: the force stays near that of the hand once the hand has felt it,
/// the probe stays behind, and it is back with the hand when that goes back. Without a limit the block is squeezed to nothing.
#[test]
fn a_hand_pushes_no_harder_than_it_does() {
    let most = 0.08;
    let push = |hand_force: f64| {
        let mut spec = gripped();
        spec.hand_force = hand_force;
        spec.bodies[0].clamps[0].nodes = Selection::Box(BoxSpec {
            min: [-1.0, -1.0, -1.0],
            max: [1.0, 1.0, -THICK / 2.0 + 1e-9],
        });
        let probe = CapsuleSpec::new([0.0; 3], [0.0, LENGTH, 0.0], THIN);
        spec.tools = vec![ToolSpec {
            name: spec.tools[0].name.clone(),
            capsules: vec![probe],
            sharpness: 0.0,
            jaw_stiffness: f64::INFINITY,
            irrigation: None,
            motion: Vec::new(),
        }];
        let mut scene = Scene::new(&spec).unwrap();
        let above = |z: f64| Pose {
            position: Vector3::new(0.0, 0.0, z),
            ..Pose::identity()
        };
        let mut last = above(1.2e-3);
        let mut forces = Vec::new();
        let mut behind = 0.0f64;
        for tick in 1..=120 {
            let way = 3e-3 * (1.0 - (f64::from(tick) / 60.0 - 1.0).abs());
            let now = above(1.2e-3 - way);
            let motion = ToolMotion {
                tool: 0,
                from: last,
                to: now,
                opening_from: 0.0,
                opening_to: 0.0,
                active: true,
            };
            last = now;
            // What is squeezed to nothing has no solution.
            let Ok(report) = scene.tick(&[motion], TICK, 1, &Serial) else {
                return (forces, f64::INFINITY);
            };
            let force = report
                .contacts
                .first()
                .map_or(0.0, |contact| Vector3::from(contact.force_on_tissue).norm());
            forces.push(force);
            let placed = scene.state.placements.tools[0].unwrap().pose.position.z;
            behind = behind.max(placed - now.position.z);
        }
        let end = scene.state.placements.tools[0].unwrap().pose;
        assert_eq!(end, last, "back with the hand");
        (forces, behind)
    };
    let (forces, behind) = push(most);
    let above: Vec<_> = forces.iter().filter(|force| **force > 1.2 * most).collect();
    assert!(above.len() <= 2, "{above:?}");
    assert!(forces.iter().any(|force| *force > 0.8 * most) && behind > 1e-3);
    assert!(behind.is_finite(), "{forces:?}");
    let (free, never) = push(f64::INFINITY);
    let largest = free.iter().fold(0.0, |most: f64, force| most.max(*force));
    assert!(largest > 2.0 * most && never == f64::INFINITY, "{largest}");
}

/// The budget of a tick that may take so much \[s\], with any mean.
fn budget(work: f64) -> WorkBudget {
    WorkBudget {
        tick: work / TICK,
        mean: f64::INFINITY,
    }
}

/// A tool that is too fast for the budget of a tick is followed as far as that goes, and arrives at its target.
#[test]
fn a_fast_tool_is_followed_within_the_budget() {
    let mut spec = gripped();
    // Of steps that take a third of a millisecond, as the block has 288 elements, at most two in four fifths of half of it.
    spec.budget = Some(budget(2e-3));
    let mut scene = Scene::new(&spec).unwrap();
    let place = |y: f64| at(y, [0.6; 2]).to;
    let motion = |from: f64, to: f64| ToolMotion {
        from: place(from),
        to: place(to),
        ..at(from, [0.6; 2])
    };
    let report = scene
        .tick(&[motion(3e-3, -1e-3)], TICK, 1, &Serial)
        .unwrap();
    assert!(report.over_budget && report.substeps == 2, "{report:?}");
    let placement = |scene: &Scene| scene.state.placements.tools[0].unwrap();
    let first = placement(&scene).pose.position.y;
    assert!(first > 1e-3 && first < 3e-3, "{first}");
    let mut ticks = 0;
    while !placement(&scene).is_free {
        let report = scene
            .tick(&[motion(-1e-3, -1e-3)], TICK, 1, &Serial)
            .unwrap();
        assert!(report.substeps <= 2);
        ticks += 1;
        assert!(ticks < 60);
    }
    assert_eq!(placement(&scene).pose, place(-1e-3));
    assert!(ticks > 1);
}

/// Tools that are slowed down to a quarter take the sub-steps of a quarter of their motion.
#[test]
fn a_slowed_tool_takes_substeps_for_its_part_of_the_motion() {
    let substeps = |pace: f64, way: f64| {
        let mut scene = Scene::new(&gripped()).unwrap();
        scene.state.placements.pace = pace;
        let mut motion = at(1e-3, [0.6; 2]);
        motion.to = at(1e-3 - way, [0.6; 2]).to;
        scene.tick(&[motion], TICK, 1, &Serial).unwrap().substeps
    };
    let (whole, quarter) = (substeps(1.0, 4e-3), substeps(0.25, 4e-3));
    assert!(whole > quarter, "{whole}, {quarter}");
    assert_eq!(quarter, substeps(1.0, 1e-3));
}

/// Jaws that are pushed over the block in one tick, in a scene with such a budget \[s\].
fn pushed_over(work: f64, must_converge: bool) -> (Scene, ToolMotion) {
    let mut spec = gripped();
    spec.budget = Some(budget(work));
    let Method::QuasiStatic(newton) = &mut spec.method else {
        panic!("{}", spec.method.name());
    };
    newton.must_converge = must_converge;
    if must_converge {
        // Jaws that are pushed so roughly give residuals of a tenth.
        newton.tolerance = 0.2;
    }
    let motion = ToolMotion {
        to: at(-1e-3, [0.18; 2]).to,
        ..at(1.5e-3, [0.18; 2])
    };
    (Scene::new(&spec).unwrap(), motion)
}

/// Sub-steps are planned by what an iteration takes without contact. Jaws that are pushed over the block meet so many contacts that iterations take more: they stop before
/// another one would take what the step for the rest of the tick needs, and so leave all of the half of the budget that is for a repetition. They go on in the next tick.
#[test]
fn tools_stop_where_the_work_exceeds_the_budget() {
    const WORK: f64 = 4e-3;
    let (mut scene, motion) = pushed_over(WORK, false);
    let [start, end] = [motion.from, motion.to].map(|pose| pose.position.y);
    let report = scene.tick(&[motion], TICK, 1, &Serial).unwrap();
    assert!(report.over_budget, "{report:?}");
    let (steps, substeps) = (report.solver.steps, report.substeps);
    assert!(1 < steps && steps < substeps, "{steps} of {substeps}");
    let iteration = report.work / f64::from(report.solver.iterations);
    assert!(report.work < 0.5 * WORK + iteration, "{report:?}");
    // All steps but the last one were on the way.
    let place = |scene: &Scene| scene.state.placements.tools[0].unwrap();
    let reached = (start - place(&scene).pose.position.y) / (start - end);
    let planned = f64::from(steps - 1) / f64::from(substeps);
    assert!(
        reached > 0.0 && reached <= planned,
        "{reached} of {planned}"
    );
    assert!(!place(&scene).is_free);
    let rests = ToolMotion {
        from: motion.to,
        ..motion
    };
    for _ in 0..20 {
        scene.tick(&[rests], TICK, 1, &Serial).unwrap();
    }
    assert_eq!(place(&scene).pose.position.y, end);
}

/// Jaws that go to and fro over the block without a rest take the work of a tick in one tick after the other, and with a mean budget no more than that in the mean, but for
/// the burst and a tick that may take its whole budget.
#[test]
fn jaws_that_never_rest_take_the_mean_budget() {
    const TICKS: u32 = 160;
    const WORK: f64 = 8e-3;
    const MEAN: f64 = 1e-3;
    const BURST: f64 = 0.1;
    let work = |mean: f64| {
        let (mut scene, there) = pushed_over(WORK, false);
        scene.budget = Some(WorkBudget {
            mean: mean / TICK,
            ..budget(WORK)
        });
        let there = ToolMotion {
            to: at(0.5e-3, [0.18; 2]).to,
            ..there
        };
        let back = ToolMotion {
            from: there.to,
            to: there.from,
            ..there
        };
        let motions = [there, back].into_iter().cycle().take(TICKS as usize);
        let ticks = motions.map(|motion| scene.tick(&[motion], TICK, 1, &Serial).unwrap());
        ticks.map(|of| of.work).sum::<f64>() / f64::from(TICKS)
    };
    let most = MEAN + (BURST + WORK) / f64::from(TICKS);
    let (free, bound) = (work(f64::INFINITY), work(MEAN));
    assert!(free > 1.5 * most, "{free} s");
    assert!(bound <= most, "{bound} s");
}

/// A step that must converge takes what it needs, so it is no reason to stop.
#[test]
fn tools_whose_steps_must_converge_do_not_stop() {
    let (mut scene, motion) = pushed_over(4e-3, true);
    let report = scene.tick(&[motion], TICK, 1, &Serial).unwrap();
    assert_eq!(report.solver.steps, report.substeps, "{report:?}");
}

/// A quarter of the motion after a tick without meaning and a quarter of that after each that stood; from there it doubles, up to a quarter while ticks mean nothing, and to all of it
/// after valid ones.
#[test]
fn the_pace_of_instruments_comes_back_by_doubling() {
    let mut placements = Placements::new(0);
    placements.ease();
    assert_eq!(placements.pace, 0.25);
    (0..3).for_each(|_| placements.slow_down());
    assert_eq!(placements.pace, 1.0 / 64.0);
    placements.ease();
    assert_eq!(placements.pace, 1.0 / 32.0);
    (0..4).for_each(|_| placements.ease());
    assert_eq!(placements.pace, 0.25);
    (0..3).for_each(|_| placements.speed_up());
    assert_eq!(placements.pace, 1.0);
}
