//! The shipped scenes of the carotid: the numbers that stand in their files are those of the tube, here computed again. That the scenes come to
//! them is tested with all others (`crates/scene/tests/shipped_scenes/`).

use crate::law::law_of;
use microsim_settings::{Body, Scene, load_scene};
use microsim_tests::repository;
use microsim_tests::vessel::carotid::{
    INNER_RADIUS, OPENED_RADIUS, OPENING, PRESSURE, STRETCH, layers,
};
use microsim_tests::vessel::flattened_ring::FlattenedRing;
use microsim_tests::vessel::layers::Layer;
use microsim_tests::vessel::radial::Profile;
use microsim_tests::vessel::tube::Tube;
use microsim_tissue::law::{LawName, MaterialLaw};
use std::f64::consts::{PI, TAU};

/// Numbers stand in files with nine digits, of millimetres or less.
const DIGITS: f64 = 1e-8;

fn scene(name: &str) -> Scene {
    let path = repository().join(format!("config/scenes/{name}.toml"));
    load_scene(&path, &[])
        .unwrap_or_else(|errors| panic!("{errors}"))
        .settings
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= DIGITS * expected.abs().max(0.1),
        "{found} {expected}"
    );
}

/// The value that a scene expects of a probe at its end.
fn expected(scene: &Scene, probe: &str) -> f64 {
    let of = scene.expect.iter().find(|expect| expect.probe == probe);
    of.unwrap_or_else(|| panic!("nothing expected of {probe}"))
        .value
}

/// The body is made of these layers, lying as in the profile.
fn assert_body(body: &Body, layers: &[Layer], place: &Profile) {
    assert_near(
        body.inner_radius.unwrap_or_default() * 1e3,
        place.inside.radius * 1e3,
    );
    assert_near(body.axial_stretch, place.inside.along);
    assert_near(body.transmural_pressure, place.inside.pressure);
    for (index, layer) in layers.iter().enumerate() {
        let [inner, outer] = place.radii(index);
        assert_near(body.layer[index].thickness * 1e3, (outer - inner) * 1e3);
        assert_near(TAU - body.layer[index].opening_angle, layer.sector);
        let material = body
            .material
            .iter()
            .find(|of| of.region == Some(index as u32));
        let material = material.expect("a material of the layer");
        assert_near(
            material.youngs_modulus.unwrap_or_default(),
            layer.wall.young(),
        );
        assert_near(
            material.poisson_ratio.unwrap_or_default(),
            layer.wall.poisson(),
        );
        let value = |key| material.parameter(key).ok_or(());
        let law = MaterialLaw::read(LawName::HolzapfelGasserOgden, &value);
        assert_eq!(law, Ok(law_of(&layer.wall)));
        let fibres = material.fibres.expect("fibres");
        assert_near(fibres.angle.unwrap_or_default(), layer.wall.fibre_angle);
    }
}

#[test]
fn the_inflated_carotid_is_that_of_the_tube() {
    let scene = scene("carotid-inflate");
    let layers = layers(0.49, INNER_RADIUS, 0.0);
    let tube = Tube::new(&layers);
    assert_body(&scene.body[0], &layers, &tube.at_stretch(0.0, 1.0));
    assert_eq!(scene.body[0].load[0].pressure, Some(PRESSURE));
    let inflated = tube.at_stretch(PRESSURE, STRETCH);
    let radius = inflated.inside.radius;
    assert_near(
        expected(&scene, "lumen") * 1e3,
        (radius - INNER_RADIUS) * 1e3,
    );
    // Half of the tube is in balance: the clamp, the wall in the middle, and the pressure on what the lumen is wider there.
    let area = PI * (radius * radius - INNER_RADIUS * INNER_RADIUS);
    assert_near(
        expected(&scene, "held") * 1e3,
        (inflated.force - PRESSURE * area) * 1e3,
    );
}

#[test]
fn the_divided_carotid_is_that_of_the_tube() {
    let scene = scene("carotid-divide");
    let layers = layers(0.49, OPENED_RADIUS, OPENING);
    let tube = Tube::new(&layers);
    let place = tube.at_stretch(0.0, STRETCH);
    assert_body(&scene.body[0], &layers, &place);
    let free = tube.at_force(0.0, 0.0);
    // Five millimetres from the clamp, at rest.
    let drawn_back = 5.0 * (1.0 - free.inside.along / STRETCH);
    assert_near(expected(&scene, "drawn-back") * 1e3, drawn_back);
    let widening = (free.inside.radius - place.inside.radius) * 1e3;
    assert_near(expected(&scene, "wide") * 1e3, widening);
}

#[test]
fn the_slit_ring_is_that_of_the_tube() {
    let scene = scene("ring-open");
    let layers = layers(0.49, OPENED_RADIUS, OPENING);
    let tube = Tube::new(&layers);
    let place = tube.at_stretch(0.0, 1.0);
    assert_body(&scene.body[0], &layers, &place);
    let open = tube.slit();
    let (sine, cosine) = libm::sincos(0.5 * open.inside.angle);
    assert_near(
        expected(&scene, "edge") * 1e3,
        open.inside.radius * sine * 1e3,
    );
    let middle = |wall: &Profile| 0.5 * (wall.inside.radius + wall.outer_radius());
    // The middle of the wall stays in its place where the face is held.
    let aside = middle(&place) - middle(&open) + open.inside.radius * cosine + place.inside.radius;
    assert_near(expected(&scene, "edge-aside") * 1e3, aside * 1e3);
}

/// Of its mean radius, as the bars of radius 10 mm leave it: their axes are as far apart as two of them, the height of the ring and its wall.
#[test]
fn the_flattened_tube_is_that_of_the_ring() {
    let scene = scene("tube-flattened");
    let body = &scene.body[0];
    let wall = body.layer[0].thickness;
    let radius = body.inner_radius.unwrap_or_default() + 0.5 * wall;
    let bar = scene.tool[0].capsule[0].radius;
    let last = scene.tool[0].motion.last().expect("it moves");
    let height = 2.0 * (last.position[1] - bar) - wall;
    let ring = FlattenedRing::at_height(height / (2.0 * radius));
    let material = &body.material[0];
    assert_eq!(material.poisson_ratio, Some(0.0));
    let length = body.length.unwrap_or_default();
    let stiffness = material.youngs_modulus.unwrap_or_default() * length * wall.powi(3) / 12.0;
    let force = ring.load * stiffness / (radius * radius);
    assert_near(expected(&scene, "force") * 1e6, force * 1e6);
    assert_near(
        expected(&scene, "width") * 1e3,
        (ring.width - 1.0) * radius * 1e3,
    );
}
