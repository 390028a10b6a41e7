//! Cutting in a scene: what every cut leaves, the decisions at a line of no return with their opposites.

use super::*;
use microsim_cutting::check;
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};

mod hard;
mod methods;
mod saved;

const NEWTON: Newton = Newton {
    iterations: 2,
    tolerance: 1e-2,
    must_converge: false,
};

/// A bar of 6 × 2 × 1 mm along x, clamped at −x.
fn bar(discretisation: Discretisation, relaxation_time: f64) -> BodySpec {
    let block = Block {
        center: [0.0; 3],
        size: [6e-3, 2e-3, 1e-3],
        cells: [12, 4, 2],
        split: CellSplit::Kuhn,
    };
    BodySpec {
        drag: 20.0,
        clamps: vec![ClampSpec {
            nodes: Selection::Box(BoxSpec {
                min: [-3e-3, -1.0, -1.0],
                max: [-3e-3, 1.0, 1.0],
            }),
            motion: None,
            release: None,
        }],
        ..BodySpec::new(
            "bar",
            block.mesh().unwrap(),
            Material {
                density: 1060.0,
                relaxation_time,
                behaviour: Behaviour::Continuum(ContinuumConstants {
                    law: LawName::StableNeoHookean.into(),
                    young: 50e3,
                    poisson: 0.3,
                    discretisation,
                    plasticity: None,
                }),
            },
        )
    }
}

/// A line of no return along y.
fn line(radius: f64, edge: Option<[f64; 3]>) -> CapsuleSpec {
    CapsuleSpec {
        lonor: true,
        edge,
        ..CapsuleSpec::new([0.0, -2e-3, 0.0], [0.0, 2e-3, 0.0], radius)
    }
}

/// A jaw along y up to `end` \[m\], on one `side` of the middle, about a hinge at y = 8 mm.
fn jaw(end: f64, side: f64, jaw: Jaw) -> CapsuleSpec {
    CapsuleSpec {
        a: [0.0, -2e-3, 1.2e-4 * side],
        b: [0.0, end, 1.2e-4 * side],
        joint: Joint::Hinge(Hinge {
            pivot: Vector3::new(0.0, 8e-3, 0.0),
            axis: Vector3::x_axis(),
            angle: -0.15 * side,
        }),
        jaw: Some(jaw),
        ..line(1.2e-4, None)
    }
}

fn tool(name: &str, sharpness: f64, capsules: Vec<CapsuleSpec>) -> ToolSpec {
    ToolSpec {
        name: name.into(),
        capsules,
        sharpness,
        jaw_stiffness: f64::INFINITY,
        irrigation: None,
        motion: Vec::new(),
    }
}

fn cut(tool: &str) -> CutSpec {
    CutSpec::new("bar", tool)
}

fn spec(body: BodySpec, tool: ToolSpec, touches: bool, method: Method) -> SceneSpec {
    let contact = ContactSpec {
        friction: 0.1,
        ..ContactSpec::new(body.name.clone(), PartnerSpec::Tool(tool.name.clone()))
    };
    SceneSpec {
        cuts: vec![cut(&tool.name)],
        bodies: vec![body],
        tools: vec![tool],
        obstacles: Vec::new(),
        contacts: if touches { vec![contact] } else { Vec::new() },
        gravity: [0.0; 3],
        ..SceneSpec::new(Vec::new(), method)
    }
}

/// From one height to another \[m\] at a place x \[m\], with the opening of jaws.
fn down(x: f64, heights: [f64; 2], openings: [f64; 2]) -> ToolMotion {
    let pose = |z| Pose {
        position: Vector3::new(x, 0.0, z),
        ..Pose::identity()
    };
    ToolMotion {
        tool: 0,
        from: pose(heights[0]),
        to: pose(heights[1]),
        opening_from: openings[0],
        opening_to: openings[1],
        active: true,
    }
}

/// A blade from above to below in `ticks` of a millisecond; one entry per tick.
fn through(scene: &mut Scene, x: f64, ticks: usize) -> Vec<TickReport> {
    let steps = scene.required_steps(1e-3);
    let height = |k: usize| 1e-3 - 2e-3 * k as f64 / ticks as f64;
    let tick = |k| {
        let motion = down(x, [height(k), height(k + 1)], [0.0; 2]);
        scene.tick(&[motion], 1e-3, steps, &Serial).unwrap()
    };
    (0..ticks).map(tick).collect()
}

fn area(reports: &[TickReport]) -> f64 {
    let cuts = reports.iter().flat_map(|report| &report.cuts);
    cuts.map(|cut| cut.area).sum()
}

/// Every discretisation and a method of each kind: the bar comes apart into two, nothing is lost, the model is that of the mesh, and what was
/// laid open is the bar's cross section of 2 mm².
#[test]
fn a_blade_leaves_two_pieces_and_loses_nothing() {
    let methods = [
        Method::StoermerVerlet,
        Method::SymplecticEuler,
        Method::ImplicitEuler(NEWTON),
        Method::Sdirk2(NEWTON),
        Method::Xpbd {
            substeps: 10,
            iterations: 1,
        },
    ];
    let cut = Discretisation::ALL
        .into_iter()
        .filter(|one| !one.is_quadratic());
    for (index, discretisation) in cut.enumerate() {
        let method = methods[index % (methods.len() - 1)];
        check_blade(bar(discretisation, 0.0), method);
    }
    let mut springs = bar(Discretisation::Tetrahedra, 0.0);
    springs.materials[0].1.behaviour = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
    check_blade(springs, methods[4]);
}

fn check_blade(body: BodySpec, method: Method) {
    let mut scene = Scene::new(&spec(
        body,
        tool("blade", 0.0, vec![line(5e-5, None)]),
        false,
        method,
    ))
    .unwrap();
    let what = format!(
        "{} {:?}",
        method.name(),
        scene.bodies[0].model.sets()[0].kind()
    );
    let (volume, mass) = scene.body(0).uncut();
    let reports = through(&mut scene, 0.37e-3, 20);
    assert_eq!(scene.body(0).piece_count(), 2, "{what}");
    let pieces: Vec<u32> = reports
        .iter()
        .flat_map(|r| &r.cuts)
        .flat_map(|c| c.pieces.clone())
        .collect();
    assert_eq!(pieces, [1], "{what}");
    // On a flat blade the cut is the cross section, but for nodes that were used: no farther than 0.15 of an edge they are at most that fraction of
    // an edge off the plane, and a slope of 0.3 over an edge lengthens the surface by less than 5 %.
    let opened = area(&reports);
    assert!((opened / 2e-6 - 1.0).abs() < 0.05, "{what}: {opened}");
    for (piece, side) in [(0, -1.0), (1, 1.0)] {
        let of = scene
            .body(0)
            .pieces()
            .iter()
            .zip(scene.body(0).rest_positions());
        let x = of
            .filter(|(p, _)| **p == piece)
            .map(|(_, r)| side * (r.x - 0.37e-3));
        // No node lies further beyond the blade than the part of an edge that snapping allows: half an edge of the grid.
        assert!(x.fold(f64::INFINITY, f64::min) > -0.25e-3, "{what}");
    }
    let of = &scene.bodies[0];
    let measures = check(&of.mesh, of.topology.as_ref().unwrap()).unwrap();
    assert!((measures.volume / volume - 1.0).abs() < 1e-12, "{what}");
    let now: f64 = scene.body(0).masses().iter().sum();
    assert!((now / mass - 1.0).abs() < 1e-12, "{what}");
    let mesh = &of.mesh;
    assert_eq!(of.model.tets(), mesh.tets, "{what}");
    assert_eq!(of.model.rest_positions(), mesh.positions, "{what}");
    assert_eq!(scene.body(0).positions().len(), mesh.positions.len());
    // Both sides of the cut are open, and nothing else.
    let sides = of
        .surface
        .triangles
        .iter()
        .zip(&of.opened)
        .filter(|(_, inner)| **inner);
    let sides: f64 = sides
        .map(|(t, _)| {
            let [a, b, c] = t.map(|node| mesh.positions[node as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        })
        .sum();
    assert!(
        (sides / (2.0 * opened) - 1.0).abs() < 1e-9,
        "{what}: {sides}"
    );
    // Nothing was pushed: what moves has got its energy from rounding alone.
    assert!(
        scene.body(0).energies().total() < 1e-9 * of.energy_scale,
        "{what}: {:?}",
        scene.body(0).energies()
    );
}

/// What a cut has divided is merged once the blade is away: fewer nodes in two pieces, a mesh without flaws of which the model is, the mass of before but for what
/// faces have moved by, 0.08 of an edge over the whole surface at most, and nothing is set in motion.
#[test]
fn what_was_divided_is_merged_when_nothing_touches_it_any_more() {
    let body = bar(Discretisation::Tetrahedra, 0.0);
    let blade = tool("blade", 0.0, vec![line(5e-5, None)]);
    let mut scene = Scene::new(&spec(body, blade, false, Method::ImplicitEuler(NEWTON))).unwrap();
    let whole = scene.body(0).positions().len();
    let (_, mass) = scene.body(0).uncut();
    through(&mut scene, 0.37e-3, 20);
    let divided = scene.body(0).positions().len();
    for _ in 0..40 {
        scene.tick(&[], 10e-3, 1, &Serial).unwrap();
    }
    let nodes = scene.body(0).positions().len();
    assert!(
        4 * (nodes - whole) < 3 * (divided - whole),
        "{whole} {divided} {nodes}"
    );
    assert_eq!(scene.body(0).cut_tally().merged, (divided - nodes) as u64);
    assert_eq!(scene.body(0).piece_count(), 2);
    let of = &scene.bodies[0];
    let measures = check(&of.mesh, of.topology.as_ref().unwrap()).unwrap();
    assert_eq!(measures.parts, 2);
    assert_eq!(of.model.tets(), of.mesh.tets);
    let surface = measures.outer_area + measures.sheets.iter().map(|(area, _)| area).sum::<f64>();
    let moved = 1060.0 * 0.08 * of.model.mean_edge_length() * surface;
    let now: f64 = scene.body(0).masses().iter().sum();
    assert!((now - mass).abs() < moved, "{now} {mass}");
    let energy = scene.body(0).energies().total();
    assert!(energy < 1e-9 * scene.bodies[0].energy_scale, "{energy}");
    let mut again = scene.clone();
    again.restore(&scene.save()).unwrap();
    assert!(again.save() == scene.save());
}

/// In a tick that cuts nothing is merged, though the same tick without the blade merges nodes of an earlier cut.
#[test]
fn nothing_is_merged_in_a_tick_that_cuts() {
    let body = bar(Discretisation::Tetrahedra, 0.0);
    let blade = tool("blade", 0.0, vec![line(5e-5, None)]);
    let mut scene = Scene::new(&spec(body, blade, false, Method::ImplicitEuler(NEWTON))).unwrap();
    through(&mut scene, 0.37e-3, 20);
    // The blade is away: its path is forgotten.
    scene.tick(&[], 1e-3, 1, &Serial).unwrap();
    let mut without = scene.clone();
    without.tick(&[], 0.2, 1, &Serial).unwrap();
    assert!(without.body(0).cut_tally().merged > 0);
    let motion = down(-1.2e-3, [1e-3, 0.0], [0.0; 2]);
    let report = scene.tick(&[motion], 0.2, 1, &Serial).unwrap();
    assert!(!report.cuts.is_empty());
    assert_eq!(scene.body(0).cut_tally().merged, 0);
}

/// A clamp that is cut through holds on both sides; what is held by none falls.
#[test]
fn clamps_and_weight_after_a_cut() {
    let mut body = bar(Discretisation::Tetrahedra, 0.0);
    // The last cells on the left: a cut at x = −2.7 mm goes through what is held.
    body.clamps[0].nodes = Selection::Box(BoxSpec {
        min: [-3e-3, -1.0, -1.0],
        max: [-2.5e-3, 1.0, 1.0],
    });
    let mut of = spec(
        body,
        tool("blade", 0.0, vec![line(5e-5, None)]),
        false,
        Method::ImplicitEuler(NEWTON),
    );
    of.gravity = [0.0, 0.0, -9.81];
    let mut scene = Scene::new(&of).unwrap();
    let free = scene
        .body(0)
        .clamped()
        .iter()
        .filter(|held| !**held)
        .count();
    through(&mut scene, -2.7e-3, 20);
    assert_eq!(scene.body(0).piece_count(), 2);
    // All nodes that the cut made come from held ones.
    assert_eq!(
        scene
            .body(0)
            .clamped()
            .iter()
            .filter(|held| !**held)
            .count(),
        free
    );
    through(&mut scene, 0.1e-3, 20);
    let (mut fallen, mut count) = (0.0, 0);
    for _ in 0..20 {
        scene.tick(&[], 1e-3, 1, &Serial).unwrap();
    }
    for ((piece, now), start) in scene
        .body(0)
        .pieces()
        .iter()
        .zip(scene.body(0).positions())
        .zip(scene.body(0).start_positions())
    {
        if *piece == 2 {
            (fallen, count) = (fallen + now.z - start.z, count + 1);
        }
    }
    // 20 ms and more of free fall, ½ g t² at the least; drag of 20/s takes less than a third.
    assert!(count > 0 && fallen / f64::from(count) < -1.3e-3, "{fallen}");
}

/// Case 1 and 2: a single edge pushes until its force per length is that of the tissue, and then goes through; with its back it only pushes, and
/// tissue that is tougher, or an edge that is blunt, is only pushed as well.
#[test]
fn an_edge_pushes_until_it_cuts() {
    let pressed = |toughness: f64, sharpness: f64, edge: [f64; 3], lonor: bool| {
        let mut body = bar(Discretisation::Tetrahedra, 2e-3);
        body.toughness = toughness;
        let mut held = body.clamps[0].clone();
        held.nodes = Selection::Box(BoxSpec {
            min: [3e-3, -1.0, -1.0],
            max: [3e-3, 1.0, 1.0],
        });
        body.clamps.push(held);
        let knife = tool("knife", sharpness, vec![line(1e-4, Some(edge))]);
        let mut of = spec(body, knife, true, Method::ImplicitEuler(NEWTON));
        if !lonor {
            of.cuts.clear();
        }
        let mut scene = Scene::new(&of).unwrap();
        let (mut force, mut lowest) = (0.0, 0.0);
        for k in 0..60 {
            let height = |k: usize| 0.7e-3 - 4e-5 * k as f64;
            let motion = down(0.3e-3, [height(k), height(k + 1)], [0.0; 2]);
            let report = scene.tick(&[motion], 4e-3, 2, &Serial).unwrap();
            if scene.body(0).piece_count() == 1 && report.cuts.is_empty() {
                for contact in &report.contacts {
                    force = f64::max(force, Vector3::from(contact.force_on_tissue).norm());
                }
                let lows = scene.body(0).positions().iter().map(|p| p.z);
                lowest = lows.fold(lowest, f64::min);
            }
        }
        (scene.body(0).piece_count(), force, lowest)
    };
    let down = [0.0, 0.0, -1.0];
    let (pieces, force, _) = pressed(4.0, 0.8, down, true);
    assert_eq!(pieces, 2);
    // It is cut from 4 / 0.8 N/m over the 2 mm of the bar's width: within what one tick of 0.16 mm adds, and what the ends of the edge bear
    // less than its middle.
    assert!((0.5..1.3).contains(&(force / 10e-3)), "{force}");
    for (toughness, sharpness, edge, lonor) in [
        (4.0, 0.8, [0.0, 0.0, 1.0], true),
        (1e4, 0.8, down, true),
        (4.0, 0.0, down, true),
        (4.0, 0.8, down, false),
    ] {
        let (pieces, _, lowest) = pressed(toughness, sharpness, edge, lonor);
        assert_eq!(pieces, 1, "{toughness} {sharpness} {edge:?} {lonor}");
        assert!(lowest < -1.3e-3, "pushed to {lowest}");
    }
}

/// Case 3: two jaws that meet. Brittle tissue is pinched off by blunt jaws, tissue like rubber is not; sharp jaws cut both.
#[test]
fn jaws_cut_by_sharpness_or_brittleness() {
    let closed = |sharpness: f64, brittleness: f64, lonor: bool| {
        let mut body = bar(Discretisation::Tetrahedra, 5e-3);
        body.brittleness = brittleness;
        let jaws = tool(
            "jaws",
            sharpness,
            vec![jaw(2e-3, 1.0, Jaw::Left), jaw(2e-3, -1.0, Jaw::Right)],
        );
        let mut of = spec(body, jaws, true, Method::ImplicitEuler(NEWTON));
        if !lonor {
            of.cuts.clear();
        }
        let mut scene = Scene::new(&of).unwrap();
        for k in 0..50 {
            // Not to nothing: what lies between must have somewhere to be.
            let opening = |k: usize| 1.0 - 0.96 * k as f64 / 50.0;
            let motion = down(0.3e-3, [0.0; 2], [opening(k), opening(k + 1)]);
            scene.tick(&[motion], 4e-3, 2, &Serial).unwrap();
        }
        scene.body(0).piece_count()
    };
    for (sharpness, brittleness, lonor, pieces) in [
        (0.0, 0.6, true, 2),
        (0.0, 0.0, true, 1),
        (1.0, 0.0, true, 2),
        (1.0, 0.6, false, 1),
    ] {
        let found = closed(sharpness, brittleness, lonor);
        assert_eq!(
            found, pieces,
            "sharpness {sharpness}, brittleness {brittleness}, {lonor}"
        );
    }
}

/// Jaws that closed in air are solid: pushed on the bar they push it, and cut nothing. Opened and closed around it they cut it; opened again, moved on
/// and closed again they cut it again.
#[test]
fn jaws_cut_again_and_not_when_they_were_closed_before() {
    // To the hinge, where jaws of scissors never open.
    let jaws = tool(
        "jaws",
        1.0,
        vec![jaw(8e-3, 1.0, Jaw::Left), jaw(8e-3, -1.0, Jaw::Right)],
    );
    let of = spec(
        bar(Discretisation::Tetrahedra, 5e-3),
        jaws,
        true,
        Method::ImplicitEuler(NEWTON),
    );
    let mut scene = Scene::new(&of).unwrap();
    let mut lead = |x: [f64; 2], z: [f64; 2], opening: [f64; 2], ticks: usize| {
        for k in 0..ticks {
            let at = |range: [f64; 2], k: usize| {
                range[0] + (range[1] - range[0]) * k as f64 / ticks as f64
            };
            let mut motion = down(
                at(x, k),
                [at(z, k), at(z, k + 1)],
                [at(opening, k), at(opening, k + 1)],
            );
            motion.to.position.x = at(x, k + 1);
            scene.tick(&[motion], 4e-3, 2, &Serial).unwrap();
        }
        (
            scene.body(0).piece_count(),
            scene
                .body(0)
                .positions()
                .iter()
                .map(|p| p.z)
                .fold(f64::INFINITY, f64::min),
        )
    };
    let (far, near) = (3e-3, 1.6e-3);
    let (high, low) = (1.5e-3, 0.0);
    let closed = lead([far; 2], [high; 2], [1.0, 0.0], 20);
    assert_eq!(closed.0, 1);
    let (pieces, lowest) = lead([near; 2], [high, low], [0.0; 2], 30);
    assert_eq!(pieces, 1);
    assert!(lowest < -0.7e-3, "pushed to {lowest}");
    lead([near; 2], [low, high], [0.0; 2], 30);
    lead([near, 4.5e-3], [high; 2], [0.0, 1.0], 20);
    lead([4.5e-3; 2], [high, low], [1.0; 2], 20);
    lead([4.5e-3, near], [low; 2], [1.0; 2], 20);
    assert_eq!(lead([near; 2], [low; 2], [1.0, 0.0], 40).0, 2);
    lead([near; 2], [low; 2], [0.0, 1.0], 40);
    lead([near, 0.2e-3], [low; 2], [1.0; 2], 20);
    assert_eq!(lead([0.2e-3; 2], [low; 2], [1.0, 0.0], 40).0, 3);
}

/// A bar that is pulled apart tears where its region may, and holds where it may not.
#[test]
fn tissue_tears_by_strain() {
    let pulled = |tear_strains: Vec<(u32, f64)>| {
        let mut body = bar(Discretisation::Tetrahedra, 2e-3);
        body.tear_strains = tear_strains;
        let mut pull = body.clamps[0].clone();
        pull.nodes = Selection::Box(BoxSpec {
            min: [3e-3, -1.0, -1.0],
            max: [3e-3, 1.0, 1.0],
        });
        pull.motion = Some(MotionSpec {
            pivot: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            keys: vec![MotionKey {
                time: 0.1,
                shift: [6e-3, 0.0, 0.0],
                angle: 0.0,
            }],
        });
        body.clamps.push(pull);
        let mut of = spec(
            body,
            tool("blade", 0.0, vec![line(5e-5, None)]),
            false,
            Method::ImplicitEuler(NEWTON),
        );
        of.cuts.clear();
        let mut scene = Scene::new(&of).unwrap();
        let mut torn_at = None;
        for _ in 0..60 {
            scene.tick(&[], 2e-3, 1, &Serial).unwrap();
            if torn_at.is_none() && scene.body(0).generation() > 0 {
                torn_at = Some(scene.time());
            }
        }
        let of = &scene.bodies[0];
        if let Some(topology) = &of.topology {
            check(&of.mesh, topology).unwrap();
        }
        (torn_at, scene.body(0).energies().elastic())
    };
    let (never, whole) = pulled(Vec::new());
    assert_eq!(never, None);
    assert_eq!(
        pulled(vec![(0, 2.0)]),
        (None, whole),
        "stretched to twice its length"
    );
    let (torn_at, left) = pulled(vec![(0, 0.5)]);
    // The ends neck, so that the strain at the clamps is ahead of the mean one, which is 0.5 at 50 ms.
    let time = torn_at.expect("it tears");
    assert!((0.02..0.052).contains(&time), "{time}");
    // Stretched on to twice the strain that it bears, most of what it would hold whole is gone.
    assert!(left < 0.5 * whole, "{left} of {whole}");
}

#[test]
fn cuts_that_cannot_be_are_refused() {
    let of = |change: fn(&mut SceneSpec)| {
        let body = bar(Discretisation::Tetrahedra, 0.0);
        let mut of = spec(
            body,
            tool("blade", 0.0, vec![line(5e-5, None)]),
            false,
            Method::StoermerVerlet,
        );
        change(&mut of);
        Scene::new(&of).map(|_| ()).unwrap_err().to_string()
    };
    assert!(of(|s| s.cuts[0].tool = "saw".into()).ends_with("no such tool"));
    assert!(of(|s| s.cuts[0].body = "bone".into()).ends_with("no such body"));
    assert!(of(|s| s.cuts.push(s.cuts[0].clone())).ends_with("occurs twice"));
    assert!(of(|s| s.tools[0].capsules[0].lonor = false).contains("no line of no return"));
    let jaws: fn(&mut SceneSpec) = |s| {
        s.tools[0].capsules = vec![jaw(2e-3, 1.0, Jaw::Left), jaw(2e-3, -1.0, Jaw::Right)];
        // Begins where the one before it begins, not where it ends.
        s.tools[0].capsules.push(jaw(4e-3, 1.0, Jaw::Left));
        s.tools[0].capsules.push(jaw(4e-3, -1.0, Jaw::Right));
    };
    assert!(of(jaws).contains("b of one must meet a of the next"));
    let lone: fn(&mut SceneSpec) = |s| s.tools[0].capsules = vec![jaw(2e-3, 1.0, Jaw::Left)];
    assert!(of(lone).contains("as many"));
    assert!(of(|s| s.method = Method::QuasiStatic(NEWTON)).contains("no inertia"));
    let tears: fn(&mut SceneSpec) = |s| {
        s.bodies[0].tear_strains = vec![(0, 0.5)];
        s.method = Method::QuasiStatic(NEWTON);
    };
    assert!(of(tears).contains("no inertia"));
    assert!(of(|s| s.method = Method::ExplicitEuler).contains("held by damping alone"));
    let quadratic: fn(&mut SceneSpec) = |s| {
        s.bodies[0] = bar(Discretisation::Quadratic, 0.0);
        s.bodies[0].mesh = s.bodies[0].mesh.refined().mesh;
    };
    assert!(of(quadratic).contains("quadratic tetrahedra are not cut"));
    assert!(of(|s| s.bodies[0].brittleness = 1.5).contains("brittleness from 0 to 1"));
    assert!(of(|s| s.bodies[0].toughness = 0.0).contains("toughness is above 0"));
    assert!(of(|s| s.tools[0].sharpness = f64::NAN).contains("sharpness from 0 to 1"));
}
