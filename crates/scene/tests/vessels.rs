//! The vessels of `config/vessels` as bodies: they are built with their residual state, begin in equilibrium and stay there.

use microsim_scene::{End, Runner, Scene, SceneSpec, Serial, scene_spec};
use microsim_settings::{self as settings, Vessel, load_vessel, read_scene_with};
use microsim_tissue::Behaviour;
use microsim_tissue::vessel_wall::{VesselWall, WallLayer};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/vessels")
}

fn vessel(name: &str) -> Vessel {
    let path = folder().join(name).with_extension("toml");
    load_vessel(&path).expect("it is right").settings
}

/// A piece of a vessel between two clamps, for 50 ms.
fn piece(name: &str, vessel: &Vessel) -> (settings::Scene, SceneSpec) {
    let layers = vec!["{ cells = 1 }"; vessel.layer.len()].join(", ");
    let length = 6.0 * vessel.inner_radius.value;
    let ends = [-0.5 * length, 0.5 * length].map(|x| {
        format!(
            "[[body.clamp]]\nnodes = {{ min = [{x:?}, -0.01, -0.01], max = [{x:?}, 0.01, 0.01] }}\n"
        )
    });
    let text = format!(
        "title = {{ en = 'a' }}\nsummary = {{ en = 'b' }}\nrun = {{ duration = 0.05, step = 0.01, gravity = [0, 0, 0] }}\n\
         method = {{ name = 'implicit-euler' }}\n[[body]]\nname = 'piece'\ngenerator = 'tube'\nvessel = '{name}'\nlength = {length:?}\n\
         around = 12\nalong = 6\nlayer = [{layers}]\n{}",
        ends.concat()
    );
    let read = read_scene_with(&text, "f.toml", &[], &folder());
    let read = read.unwrap_or_else(|errors| panic!("{errors}")).settings;
    let none = &mut |_: &Path| Err(std::io::ErrorKind::NotFound.into());
    let spec = scene_spec(&read, none).unwrap_or_else(|error| panic!("{name}: {error}"));
    (read, spec.spec)
}

#[test]
fn every_vessel_lies_still_between_its_clamps() {
    let mut files = std::fs::read_dir(folder())
        .expect("the vessels")
        .map(|entry| entry.expect("an entry").path())
        .collect::<Vec<_>>();
    files.sort();
    assert!(!files.is_empty());
    for file in files {
        let name = file.file_stem().and_then(|stem| stem.to_str());
        let name = name.expect("a name in UTF-8");
        let vessel = vessel(name);
        let (read, spec) = piece(name, &vessel);
        let scene = Scene::new(&spec).unwrap_or_else(|error| panic!("{name}: {error}"));
        let start = scene.body(0).positions().to_vec();
        let mut runner =
            Runner::new(&read, scene).unwrap_or_else(|error| panic!("{name}: {error}"));
        runner.run(&Serial, &mut |_| true);
        assert!(!matches!(runner.end(), Some(End::Diverged(_))), "{name}");
        let moved = start.iter().zip(runner.scene().body(0).positions());
        let moved = moved.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        // The equilibrium of the start has a residual of 1e-9 of the forces; steps leave no more than 1e-4 of them by their own tolerance.
        assert!(moved < 1e-4 * vessel.inner_radius.value, "{name}: {moved}");
    }
}

/// The open wall that the sizes of the rabbit's carotid were derived from comes back: inner radius 1.43 mm (Holzapfel, Gasser & Ogden 2000),
/// from the compressible wall within what its volume changes by. Its mean stress is about 10 kPa, its bulk modulus, E/(3 (1 − 2ν)), 149 kPa: 7 %
/// of the volume and, of three directions, 2.3 % of a length, in the media; the softer adventitia bears little.
#[test]
fn the_open_wall_of_the_rabbit_s_carotid_comes_back() {
    let vessel = vessel("rabbit-carotid");
    let (_, mut spec) = piece("rabbit-carotid", &vessel);
    let materials = spec.bodies.remove(0).materials;
    let mut inner = vessel.inner_radius.value;
    let layers = vessel
        .layer
        .iter()
        .zip(materials)
        .map(|(layer, (_, material))| {
            let Behaviour::Continuum(constants) = material.behaviour else {
                panic!("a continuum");
            };
            let outer = inner + layer.thickness.value;
            let radii = [inner, outer];
            inner = outer;
            let (sine, cosine) = layer.fibre_angle.as_ref().expect("fibres").value.sin_cos();
            WallLayer {
                radii,
                constants,
                directions: [sine, -sine].map(|sine| Vector3::new(0.0, cosine, sine)),
                opening_angle: layer.opening_angle.value,
            }
        });
    let wall = VesselWall {
        layers: layers.collect(),
        axial_stretch: vessel.axial_stretch.value,
        pressure: 0.0,
    };
    let stretches = wall.stretches().expect("a residual state");
    let closing = TAU / (TAU - vessel.layer[0].opening_angle.value);
    let inner = vessel.inner_radius.value;
    let open = closing * inner / stretches.at(inner)[1];
    assert!((open / 1.43e-3 - 1.0).abs() < 0.023, "{open}");
}
