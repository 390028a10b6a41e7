//! Bodies that name a vessel have what it states, where they do not state it themselves.

use crate::{KNOWN_METRICS, example, manifest};
use microsim_settings::*;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

/// A tree with the example as the vessel `artery`, and a broken one.
fn tree() -> tempfile::TempDir {
    let tree = tempfile::tempdir().expect("a folder");
    let folder = tree.path().join("config/vessels");
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::create_dir_all(tree.path().join("config/scenes")).expect("a folder");
    std::fs::create_dir_all(tree.path().join("modules/x/levels")).expect("a folder");
    std::fs::write(folder.join("artery.toml"), example("vessel")).expect("a file");
    std::fs::write(folder.join("broken.toml"), "doc = 1").expect("a file");
    tree
}

const SCENE: &str = r#"title = { en = "a" }
summary = { en = "b" }
run = { duration = 1, step = 0.01 }
method = { name = "implicit-euler" }
[[body]]
name = "artery"
generator = "tube"
vessel = "artery"
length = "5 mm"
around = 12
along = 10
layer = [{ cells = 2 }, { cells = 1 }]
"#;

fn read(tree: &Path, text: &str, set: &[&str]) -> Result<Body, ConfigErrors> {
    let overrides = set
        .iter()
        .map(|text| Override::parse(text).expect("KEY=VALUE"));
    let file = tree.join("config/scenes/f.toml");
    let overrides: Vec<Override> = overrides.collect();
    let scene = read_scene(text, &file.display().to_string(), &overrides)?;
    Ok(scene.settings.body[0].clone())
}

#[test]
fn a_body_has_what_its_vessel_states() {
    let tree = tree();
    let body = read(tree.path(), SCENE, &[]).expect("the scene is right");
    assert_eq!((body.inner_radius, body.axial_stretch), (Some(0.0005), 1.5));
    assert_eq!(body.toughness, Some(200.0));
    let layers = body.layer.iter();
    let layers: Vec<_> = layers
        .map(|l| (l.thickness, l.cells, l.region, l.opening_angle))
        .collect();
    assert_eq!(layers, [(80e-6, 2, 0, FRAC_PI_2), (40e-6, 1, 1, 0.0)]);
    let [media, adventitia] = body.material[..] else {
        panic!("{:?}", body.material);
    };
    assert_eq!(media.region, Some(0));
    assert_eq!(media.law, Law::Continuum(LawName::HolzapfelGasserOgden));
    let law = ["fibre_stiffness", "fibre_exponent", "fibre_dispersion"];
    assert_eq!(
        law.map(|key| media.parameter(key)),
        [Some(2400.0), Some(0.84), Some(0.1)]
    );
    assert_eq!(media.fibres.and_then(|fibres| fibres.angle), Some(PI / 6.0));
    assert_eq!(
        (media.density, media.relaxation_time),
        (1060.0, Some(0.005))
    );
    assert_eq!(media.discretisation, Some(Discretisation::Selective));
    assert_eq!(adventitia.region, Some(1));
    assert_eq!(adventitia.law, Law::Continuum(LawName::NeoHookean));
    assert_eq!(
        (adventitia.youngs_modulus, adventitia.fibres),
        (Some(1e3), None)
    );

    // A level finds it in the tree, or where it is given.
    let body = SCENE.split_once("[[body]]").expect("a body").1;
    let level = format!(
        "title = {{ de = 'a', en = 'b' }}\nsummary = {{ de = 'a', en = 'b' }}\nclock.tick = '16 ms'\nmodule.rounds = 2\nphysics = {{}}\n\
         method = {{ name = 'implicit-euler' }}\n[[body]]{body}"
    );
    let file = tree.path().join("modules/x/levels/level1.toml");
    std::fs::write(&file, &level).expect("a file");
    let in_tree = load_level(&file, &manifest(), &KNOWN_METRICS).expect("the level is right");
    assert_eq!(in_tree.settings.body[0].material, [media, adventitia]);
    let elsewhere = tree.path().join("config/vessels");
    let given = load_level_with(&file, &manifest(), &KNOWN_METRICS, &elsewhere);
    assert_eq!(given.expect("right").settings, in_tree.settings);
}

#[test]
fn what_a_body_states_itself_holds() {
    let tree = tree();
    let text = SCENE.replace(
        "layer = [{ cells = 2 }, { cells = 1 }]",
        "axial_stretch = 1\ninner_radius = '0.6 mm'\ntransmural_pressure = '2 kPa'\n\
         layer = [{ cells = 2, thickness = '90 um', region = 5 }, { cells = 1, thickness = '45 um', opening_angle = '10 deg' }]\n\
         material = [{ region = 5, youngs_modulus = '12 kPa', viscosity = '3 Pa s', discretisation = 'tetrahedra' },\n\
         { region = 1, density = 1000, law = 'corotational', youngs_modulus = '2 kPa', poisson_ratio = 0.4 }]",
    );
    let body = read(tree.path(), &text, &[]).expect("the scene is right");
    assert_eq!((body.axial_stretch, body.inner_radius), (1.0, Some(0.0006)));
    assert_eq!((body.layer[0].thickness, body.layer[0].region), (90e-6, 5));
    assert_eq!(body.layer[1].opening_angle, 10_f64.to_radians());
    let [media, adventitia] = body.material[..] else {
        panic!("{:?}", body.material);
    };
    assert_eq!((media.region, media.youngs_modulus), (Some(5), Some(12e3)));
    assert_eq!(media.fibre_stiffness, Some(2400.0));
    assert_eq!((media.viscosity, media.relaxation_time), (Some(3.0), None));
    assert_eq!(media.discretisation, Some(Discretisation::Tetrahedra));
    // With a law of its own it is all of the material.
    assert_eq!(adventitia.law, Law::Continuum(LawName::Corotational));
    assert_eq!(
        (adventitia.density, adventitia.discretisation),
        (1000.0, None)
    );
    assert_eq!(body.material.len(), 2);

    // Overrides find what the vessel brought.
    let set = [
        "body.0.material.0.fibre_exponent=2",
        "body.0.inner_radius=0.4mm",
    ];
    let body = read(tree.path(), SCENE, &set).expect("all is right");
    assert_eq!(body.material[0].fibre_exponent, Some(2.0));
    assert_eq!(body.inner_radius, Some(0.0004));
}

#[test]
fn a_vessel_that_cannot_be_used_is_named_with_its_place() {
    let tree = tree();
    let file = tree
        .path()
        .join("config/scenes/f.toml")
        .display()
        .to_string();
    let vessels = tree.path().join("config/scenes/../vessels");
    let path = |name: &str| vessels.join(name).display().to_string();
    for (from, to, set, expected) in [
        (
            "vessel = \"artery\"",
            "vessel = \"vein\"",
            &[][..],
            format!(
                "{file}:8:10: key `body[0].vessel`: found `vein`, which cannot be used ({}: found no such file, expected a vessel \
                 (config/vessels/NAME.toml)), expected the name of a vessel of config/vessels",
                path("vein.toml")
            ),
        ),
        (
            "cells = 2 }, ",
            "cells = 2 }, { cells = 1 }, ",
            &[],
            format!(
                "{file}:8:10: key `body[0].vessel`: found a vessel whose layers the body does not have, expected one `layer` with its `cells` \
                 for each of: media, adventitia"
            ),
        ),
        (
            "generator = \"tube\"",
            "generator = \"block\"\nsize = [0.01, 0.01, 0.01]\ncells = [1, 1, 1]",
            &[],
            format!(
                "{file}:10:10: key `body[0].vessel`: found `vessel`, expected no `vessel`, which a body from a block does not have"
            ),
        ),
        (
            "vessel = \"artery\"",
            "vessel = \"Artery\"",
            &[],
            format!(
                "{file}:8:10: key `body[0].vessel`: found the text `Artery`, expected a name of lower-case letters, digits and single hyphens"
            ),
        ),
        (
            "",
            "",
            &["body.0.vessel=vein"],
            "--set body.0.vessel=vein: key `body[0].vessel`: found `vein`, which cannot be used ("
                .to_owned(),
        ),
        (
            "",
            "",
            &["body.0.vessel=broken"],
            "key `doc`: found `1`, expected a text that is not empty".to_owned(),
        ),
    ] {
        let errors = read(tree.path(), &SCENE.replacen(from, to, 1), set).expect_err(to);
        assert!(
            errors.to_string().contains(&expected),
            "{errors}\n{expected}"
        );
    }
}

/// Another stretch or a pressure makes another vessel of the same sizes: those are stated with it.
#[test]
fn a_state_of_its_own_needs_sizes_of_its_own() {
    let tree = tree();
    let file = tree.path().join("config/scenes/f.toml");
    let found = "a state of the body's own beside sizes of its vessel, which are those at the vessel's `axial_stretch` without pressure";
    let complaint = |place: &str, key: &str, sizes: &str| {
        format!(
            "{place}: key `body[0].{key}`: found {found}, expected the sizes in that state as well: {sizes}"
        )
    };
    let of_file = |place: &str| format!("{}:{place}", file.display());
    let all = "`inner_radius`, `layer[0].thickness`, `layer[1].thickness`";
    let radius = "inner_radius = '0.6 mm'\n";
    let thicknesses =
        "layer = [{ cells = 2, thickness = '90 um' }, { cells = 1, thickness = '50 um' }]\n";
    let (head, layers) = SCENE.split_at(SCENE.find("layer").expect("layers"));
    for (text, set, expected) in [
        (
            format!("{head}transmural_pressure = '13 kPa'\n{layers}"),
            &[][..],
            complaint(&of_file("12:23"), "transmural_pressure", all),
        ),
        (
            format!("{head}axial_stretch = 1.2\n{radius}{layers}"),
            &[],
            complaint(
                &of_file("12:17"),
                "axial_stretch",
                "`layer[0].thickness`, `layer[1].thickness`",
            ),
        ),
        (
            format!("{head}axial_stretch = 1.2\n{thicknesses}"),
            &[],
            complaint(&of_file("12:17"), "axial_stretch", "`inner_radius`"),
        ),
        (
            SCENE.to_owned(),
            &["body.0.transmural_pressure=13kPa"],
            complaint(
                "--set body.0.transmural_pressure=13kPa",
                "transmural_pressure",
                all,
            ),
        ),
        // Without the vessel's it is 1.
        (
            SCENE.to_owned(),
            &["body.0.axial_stretch="],
            complaint(&of_file("8:10"), "axial_stretch", all),
        ),
    ] {
        let errors = read(tree.path(), &text, set).expect_err(&text);
        assert_eq!(errors.to_string(), expected);
    }
    let text = format!("{head}transmural_pressure = '13 kPa'\n{radius}{thicknesses}");
    let body = read(tree.path(), &text, &[]).expect("all of it is stated");
    assert_eq!((body.transmural_pressure, body.axial_stretch), (13e3, 1.5));
}

#[test]
fn shipped_vessels_are_right_and_state_their_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/vessels");
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).expect("the vessels") {
        let path = entry.expect("an entry").path();
        let vessel = load_vessel(&path).unwrap_or_else(|errors| panic!("{errors}"));
        let values = vessel.settings.values();
        // What nobody knows is not hidden: every vessel has judgements, and the source of a measurement has a year.
        assert!(
            values
                .iter()
                .any(|(_, value)| value.basis == Basis::Judgement)
        );
        for (key, value) in values {
            let digits = |word: &str| word.chars().filter(char::is_ascii_digit).count() == 4;
            let year = value
                .source
                .split(|c: char| !c.is_alphanumeric())
                .any(digits);
            assert!(value.basis != Basis::Measured || year, "{key}: {value:?}");
        }
        names.push(
            path.file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned(),
        );
    }
    names.sort();
    let expected = [
        "human-digital-artery",
        "rabbit-carotid",
        "rat-femoral-artery",
        "rat-femoral-vein",
    ];
    assert_eq!(names, expected);
}
