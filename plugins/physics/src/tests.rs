//! The plugin alone, in-process, on a level of a module.

use super::*;
use microsim_sdk::message::config_value;
use microsim_sdk::tissue::{BodyForces, BodyShape};
use microsim_sdk::{BlockView, Published, TestHost, name_id};
use microsim_settings::{
    Direction, KnownMetric, ToolModels, Unit, load_level, load_manifest, load_tool,
};
use std::path::PathBuf;

const TICK_NS: u64 = 8_000_000;

/// The physics of the first level of push-strip.
fn physics() -> TestHost<Physics> {
    physics_with(|_| {})
}

/// The same with a configuration that is changed.
fn physics_with(change: impl FnOnce(&mut PhysicsConfig)) -> TestHost<Physics> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let module = root.join("modules/push-strip");
    let manifest = load_manifest(&module.join("module.toml")).expect("a manifest");
    let time = KnownMetric {
        id: "time",
        unit: Unit::Time,
        direction: Direction::Lower,
    };
    let level = load_level(
        &module.join("levels/level1.toml"),
        &manifest.settings,
        &[time],
    );
    let level = level.expect("a level").settings;
    let mut models = ToolModels::new();
    for slot in &level.tool {
        let shape = load_tool(&root.join(format!("config/tools/{}.toml", slot.model)));
        models.insert(slot.model.clone(), shape.expect("a tool").settings);
    }
    let mut config = PhysicsConfig::new(&level, &models).expect("physics");
    change(&mut config);
    let setup = Setup {
        name: "physics".into(),
        seed: 1,
        tick_ns: TICK_NS,
        steps: level.clock.steps,
        level: 1,
        config: config_value(&config),
        files: Vec::new(),
    };
    let publishes = [
        "tissue.snapshot",
        "tissue.rest",
        "tissue.elements",
        "contact.forces",
        "tissue.recovery",
        "tissue.cut",
        "tissue.solver",
    ];
    TestHost::new(&publishes, &["tool.states"], &[], setup).expect("a plugin that starts")
}

/// The block of a kind that was published.
fn block<'a>(published: &'a Published, kind: &str) -> Option<BlockView<'a>> {
    let views = published
        .blocks()
        .iter()
        .map(|words| BlockView::new(words).expect("a block"));
    views.into_iter().find(|view| view.kind() == name_id(kind))
}

/// Lowest and highest node \[m\].
fn heights(view: &BlockView<'_>) -> [f64; 2] {
    let positions = view.f64s("position").expect("positions");
    let z = positions.chunks(3).map(|p| p[2]);
    [
        z.clone().fold(f64::INFINITY, f64::min),
        z.fold(f64::NEG_INFINITY, f64::max),
    ]
}

/// The level states a block 2 mm thick with its centre at the origin: at rest it lies so, though by the first snapshot it has sagged. It is
/// published in the first tick alone, again after a reset.
#[test]
fn a_body_at_rest_is_known_though_the_first_snapshot_has_moved() {
    let mut host = physics();
    for _ in 0..2 {
        let first = host.tick().expect("a tick");
        let rest = block(&first, "tissue.rest").expect("at rest");
        let now = block(&first, "tissue.snapshot").expect("a snapshot");
        for (z, stated) in heights(&rest).into_iter().zip([-1e-3, 1e-3]) {
            assert!((z - stated).abs() < 1e-12, "{z}");
        }
        assert!(heights(&now)[0] < -1e-3 - 1e-6, "{:?}", heights(&now));
        let shape = BodyShape::of(&rest).expect("nodes and surface");
        let corner = shape.nearest_node([6e-3, 2e-3, 1e-3]).expect("nodes");
        let places = [Some(shape), BodyShape::of(&now)].map(|s| s.and_then(|s| s.place(corner)));
        assert!(
            places[0].is_some() && places[0] == places[1],
            "it is clamped"
        );

        let second = host.tick().expect("a tick");
        assert!(block(&second, "tissue.rest").is_none());
        assert!(block(&second, "tissue.snapshot").is_some());
        host.reset().expect("a reset");
    }
}

/// The level states a block of 12 x 4 x 2 mm of one region, which sags: its volume at rest is that of its sides, and something of it is stretched. Nodes lie at rest
/// where the block of the body at rest has them. Without being asked for nothing is published.
#[test]
fn what_is_known_of_elements_is_published_where_it_is_asked_for() {
    let first = physics().tick().expect("a tick");
    assert!(block(&first, "tissue.elements").is_none());
    let mut host = physics_with(|config| config.elements = true);
    let first = host.tick().expect("a tick");
    let [elements, rest, now] = ["tissue.elements", "tissue.rest", "tissue.snapshot"]
        .map(|kind| block(&first, kind).expect("a block"));
    let of = |view: &BlockView<'_>| (view.name(), view.generation(), view.time_ns());
    assert_eq!(of(&elements), of(&now));
    assert_eq!(elements.f64s("rest"), rest.f64s("position"));
    let triangles = now.u32s("triangle").expect("triangles").len() / 3;
    let regions = elements.u32s("triangle_region").expect("regions");
    assert_eq!(regions, vec![0; triangles]);
    let volumes = elements.f64s("volume").expect("volumes");
    let volume: f64 = volumes.iter().sum();
    assert!((volume / 96e-9 - 1.0).abs() < 1e-12, "{volume}");
    assert_eq!(elements.u32s("region"), Some(&vec![0; volumes.len()][..]));
    let stretches = elements.f64s("stretch").expect("stretches");
    assert_eq!(stretches.len(), volumes.len());
    let largest = stretches.iter().copied().fold(0.0, f64::max);
    assert!(largest > 1.0 + 1e-6 && largest < 1.1, "{largest}");
}

/// A probe is pushed onto the strip, which is of one region: part and region bear what the contact does, along the path down.
#[test]
fn a_contact_tells_its_force_by_part_and_by_region() {
    let mut host = physics();
    let mut pushed = 0;
    for tick in 0..24 {
        let position = [0.2e-3, 0.1e-3, 3e-3 - 0.125e-3 * f64::from(tick)];
        let pose = message::Pose {
            position,
            ..message::Pose::default()
        };
        host.send_tools(&[("right", pose)]);
        let published = host.tick().expect("a tick");
        let Some(forces) = published.last::<ContactForces>() else {
            continue;
        };
        let on = BodyForces::of(&forces, "strip");
        for contact in &forces.contacts {
            let region = on.region(0).expect("the region of a block");
            let parts = contact.parts.iter();
            let parts: Vec<_> = parts.map(|part| on.part("right", &part.part)).collect();
            for axis in 0..3 {
                let of_parts: f64 = parts.iter().flatten().map(|part| part.force[axis]).sum();
                let bound = 1e-12 * region.normal_force;
                assert!((region.force[axis] - contact.force[axis]).abs() <= bound);
                assert!((of_parts - contact.force[axis]).abs() <= bound);
            }
            pushed += usize::from(region.force[2] < -1e-3);
        }
    }
    assert!(pushed > 0, "nothing was pushed");
}

/// What pictures of the computation show is there for whoever asks, one value for each node of the snapshot. The strip is a continuum that sags: it bears stress, in elements of a block
/// that are cut as Kuhn does, whose ratio is 0.7174 (see the crate `mesh`), a little bent. Nothing of it is published, and asking changes no state.
#[test]
fn fields_are_there_for_whoever_asks() {
    let mut host = physics();
    let published = host.tick().expect("a tick");
    assert!(block(&published, TISSUE_FIELDS).is_none());
    let state = host.save().expect("a state");
    let answer = host.extension(TISSUE_FIELDS, &[]).expect("an answer");
    assert_eq!(host.save().expect("a state"), state);
    let words: Vec<Vec<u64>> = decode_bytes(&answer.expect("an ability")).expect("blocks");
    let [words] = words.as_slice() else {
        panic!("one body");
    };
    let fields = BlockView::new(words).expect("a block");
    let now = block(&published, "tissue.snapshot").expect("a snapshot");
    assert_eq!(
        (fields.name(), fields.generation()),
        (now.name(), now.generation())
    );
    let nodes = now.u32s("node_id").expect("nodes").len();
    let quality = fields.f64s("quality").expect("of elements");
    assert_eq!(quality.len(), nodes);
    assert!(
        quality.iter().all(|q| (0.5..0.75).contains(q)),
        "{quality:?}"
    );
    assert_eq!(fields.u32s("remedy"), Some(&vec![0; nodes][..]));
    let stresses = fields.f64s("von_mises").expect("of a continuum");
    assert_eq!(stresses.len(), nodes);
    assert!(stresses.iter().any(|stress| *stress > 0.0));
    assert_eq!(host.extension("nothing", &[]).expect("an answer"), None);
}
