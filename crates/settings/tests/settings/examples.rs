//! Full examples give the values that they state, and the files that the project ships are right.

use crate::{KNOWN_METRICS, example, manifest};
use microsim_settings::*;
use std::path::{Path, PathBuf};

/// The folder that holds `config` and `assets`.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn a_level_is_read_in_si() {
    let level = read_level(example("level"), "level1.toml", &manifest(), &KNOWN_METRICS);
    let level = level.expect("the example is right").settings;
    assert_eq!(level.clock.tick_us(), 8000);
    assert_eq!(level.view.tilt, 15_f64.to_radians());
    let names = ["sphere-1", "sphere-2", "sphere-3", "sphere-4"];
    assert_eq!(level.object[0].names(), names);
    assert_eq!(level.object[0].shape, Shape::Sphere { radius: 0.0012 });
    assert_eq!(level.object[0].position, [0.001, 0.0, 0.002]);
    assert_eq!(String::from(level.object[0].colour), "#c04030");
    let half_size = [0.01, 0.01, 0.0005];
    assert_eq!(level.object[1].shape, Shape::Box { half_size });
    // Defaults of an object.
    assert_eq!(level.object[1].orientation, [0.0, 0.0, 0.0, 1.0]);
    assert!(level.object[1].active && level.object[1].finish == Finish::Matte);
    let capsule = Shape::Capsule {
        radius: 0.0005,
        length: 0.004,
    };
    assert_eq!(level.object[2].shape, capsule);
    let (radius, tube) = (0.002, 0.0001);
    assert_eq!(level.object[3].shape, Shape::Ring { radius, tube });
    let model = Shape::Model {
        model: "mat.glb".into(),
        scale: 1e-3,
        texture: Some("weave.png".into()),
    };
    assert_eq!(level.object[4].shape, model);
    assert_eq!(
        level.object[4].files(),
        [("model", "mat.glb"), ("texture", "weave.png")]
    );
    assert_eq!(level.body[0].cells, Some([20, 4, 2]));
    assert_eq!(level.body[0].elements(), Some(6 * 20 * 4 * 2));
    assert_eq!(level.body[1].elements(), Some(6 * 12 * 40 * 3));
    let five = Body {
        split: Some(CellSplit::Five),
        ..level.body[1].clone()
    };
    assert_eq!(five.elements(), Some(5 * 12 * 40 * 3));
    assert_eq!(level.body[0].material[0].stretch_modulus, Some(25e3));
    let held = level.body[0].clamp[0].nodes;
    assert_eq!(held.min, Some([-0.011, -0.003, -0.002]));
    let gravity = level.physics.expect("there is a body").gravity;
    assert_eq!(gravity, [0.0, 0.0, -9.81]);
    // In the unit of the metric: seconds, radians.
    assert_eq!(level.limit[0].max, Some(120.0));
    assert_eq!(level.limit[1].max, Some(15_f64.to_radians()));
    assert_eq!(level.limit[1].min, Some(0.0));
    assert_eq!(level.module["dwell"], 2.0);
    assert_eq!(level.module["rounds"], 3);
    assert_eq!(
        level.module["approach"],
        serde_json::json!([0.0, 0.001, 0.002])
    );
}

#[test]
fn a_scene_is_read_in_si() {
    let scene = read_scene(example("scene"), "scene.toml", &[]);
    let scene = scene.expect("the example is right").settings;
    assert_eq!(
        (scene.run.end, scene.run.rest_speed),
        (End::Rest, Some(1e-6))
    );
    assert_eq!(scene.method.name, MethodName::ImplicitEuler);
    let vessel = &scene.body[1];
    assert_eq!(vessel.layer[1].thickness, 40e-6);
    // The constants of plain springs in N/m, N/m³, N/m⁵; the viscosity in Pa s.
    let springs = &vessel.material[1];
    assert_eq!(springs.length_stiffness, Some(20.0));
    assert_eq!(springs.volume_stiffness, Some(1e12));
    assert_eq!(springs.length_damping, Some(0.002));
    assert_eq!(vessel.material[0].viscosity, Some(20.0));
    assert_eq!(vessel.coupling[0].stiffness, 2e9);
    let grip = &scene.body[0].clamp[1];
    assert_eq!(grip.motion[0].angle, std::f64::consts::FRAC_PI_2);
    // Directions have length 1; values stand in the unit of what is expected.
    assert_eq!(grip.axis, [0.0, 1.0, 0.0]);
    assert_eq!(
        (scene.expect[0].value, scene.expect[1].value),
        (0.0345, 0.15)
    );
}

#[test]
fn overrides_are_held_to_the_schema_and_named() {
    let read = |texts: &[&str]| {
        let overrides: Result<Vec<Override>, String> =
            texts.iter().map(|text| Override::parse(text)).collect();
        read_scene(example("scene"), "f.toml", &overrides.expect("KEY=VALUE"))
    };
    let scene = read(&[
        "run.step=5ms",
        "body.0.cells=[35,7,7]",
        "body.1.material.0.poisson_ratio = 0.49",
        "method.name=sdirk2",
        "expect.0.value=\"30 mm\"",
    ]);
    let scene = scene.expect("all is right").settings;
    assert_eq!(scene.run.step, 0.005);
    assert_eq!(scene.body[0].cells, Some([35, 7, 7]));
    assert_eq!(scene.body[1].material[0].poisson_ratio, Some(0.49));
    assert_eq!(scene.method.name, MethodName::Sdirk2);
    assert_eq!(scene.expect[0].value, 0.03);

    for (texts, expected) in [
        (
            ["run.step=5mm", "method.iterations=7"],
            "--set run.step=5mm: key `run.step`: found the text `5mm` (a length), expected a time from 1 ns to 600 s (a number in s, or a text in s, min, ms, us or ns)",
        ),
        (
            ["method.iterations=7", "method.substeps=2"],
            "--set method.substeps=2: key `method.substeps`: found `substeps`, expected no `substeps`, which implicit-euler does not have",
        ),
        (
            ["method.iterations=7", "expect.0.value=1s"],
            "--set expect.0.value=1s: key `expect[0].value`: found the text `1s` (a time), expected a length (a number in m, or a text in m, cm, mm, um or nm)",
        ),
    ] {
        let errors = read(&texts).map(drop).expect_err("one is wrong");
        assert_eq!(errors.to_string(), expected);
    }
}

#[test]
fn a_mesh_file_of_tetgen_is_two_files() {
    let scene = read_scene(example("scene"), "scene.toml", &[]);
    let mut body = scene.expect("the example is right").settings.body.remove(2);
    assert_eq!(body.files(), ["meshes/organ.stl"]);
    body.file = Some("a.b/organ.ELE".to_owned());
    assert_eq!(body.files(), ["a.b/organ.node", "a.b/organ.ele"]);
    body.file = None;
    assert_eq!(body.files(), [""; 0]);
}

#[test]
fn a_small_level_is_filled_with_defaults() {
    let text = "title = {de='a', en='b'}\nsummary = {de='a', en='b'}\nclock.tick = '16 ms'\nmodule.rounds = 2\n";
    let level = read_level(text, "level1.toml", &manifest(), &[]);
    let level = level.expect("nothing else is required").settings;
    assert_eq!(level.clock.steps, 1);
    assert_eq!(level.view.field, 0.025);
    // Lower end of the published speed of fine work, 0.1 to 0.5 mm/s (PMC3559009).
    assert_eq!(level.metrics.idle_speed, 0.0001);
    assert_eq!(level.physics, None);
    // Default of the manifest, in SI.
    assert_eq!(level.module["dwell"], 1.0);
    assert_eq!(
        level.module["approach"],
        serde_json::json!([0.0, 0.0, 0.005])
    );
}

#[test]
fn a_script_gives_orientations() {
    let script = read_script(example("script"), "script.toml");
    let script = script.expect("the example is right").settings;
    let [first, second] = script.tool[0].key.as_slice() else {
        panic!("two keys");
    };
    // (0, −1, 1)/√2 is z turned by 45° about x: q = (sin 22.5°, 0, 0, cos 22.5°) = (0.38268…, 0, 0, 0.92387…).
    let expected = [0.3826834323650898, 0.0, 0.0, 0.9238795325112867];
    for (a, b) in first.0.orientation.iter().zip(expected) {
        assert!((a - b).abs() <= 4.0 * f64::EPSILON, "{first:?}");
    }
    assert_eq!(second.0.opening, 0.5);
    assert!(!second.0.visible);
}

#[test]
fn openings_come_from_where_the_file_says() {
    let translator = read_translator(example("translator"), "f.toml");
    let devices = translator.expect("the example is right").settings.device;
    assert_eq!(devices[0].opening.fixed(), Some(0.25));
    assert_eq!(devices[1].opening.fixed(), Some(1.0));

    let map = read_recording_map(example("recording"), "f.toml");
    let map = map.expect("the example is right").settings;
    assert_eq!(map.delimiter_byte(), b';');
    let opening = map.device[0].opening.as_ref().expect("a column");
    // From closed = 100 to open = 0.
    let values = [120.0, 100.0, 25.0, 0.0].map(|value| opening.opening(value));
    assert_eq!(values, [0.0, 0.0, 0.75, 1.0]);
}

#[test]
fn shipped_files_are_right() {
    let config = root().join("config");
    let host = load_host(&config.join("host.toml")).expect("host");
    // The file states each default, so it reads as the empty one.
    let empty = read_host("", "f.toml").expect("all has defaults");
    assert_eq!(host.settings, empty.settings);

    let translator = load_translator(&config.join("translator.toml")).expect("translator");
    let stylus = &translator.settings.device[0];
    // Farthest corner of the recording's box (x −73..25, y −88..−16, z −22..85 mm) in the field of ±11 mm.
    for (axis, (low, high)) in [(-0.073, 0.025), (-0.088, -0.016), (-0.022, 0.085)]
        .iter()
        .enumerate()
    {
        for end in [low, high] {
            let field = stylus.scale * (end - stylus.origin[axis]);
            assert!(field.abs() <= 0.011, "axis {axis}: {field}");
        }
    }

    let trainees = load_trainees(&config.join("trainees.toml")).expect("trainees");
    let names = trainees.settings.profile.iter().map(|p| p.name.as_str());
    assert_eq!(names.collect::<Vec<_>>(), ["expert", "novice"]);

    let course = load_course(&config.join("courses/first-steps.toml")).expect("a course");
    let steps = course
        .settings
        .step
        .iter()
        .map(|s| (s.module.as_str(), s.level));
    let expected = [
        ("touch-spheres", 1),
        ("guide-path", 1),
        ("push-strip", 1),
        ("push-strip", 2),
    ];
    assert_eq!(steps.collect::<Vec<_>>(), expected);

    for name in ["dilator", "forceps", "micro-scissors", "probe"] {
        let tool = load_tool(&config.join(format!("tools/{name}.toml")))
            .expect(name)
            .settings;
        // The tip is where the parts end: none reaches below it, one touches its plane.
        let lowest = tool.capsule.iter().map(|c| c.a[2].min(c.b[2]) - c.radius);
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        assert!(lowest.abs() <= 1e-9 * 0.025, "{name}: {lowest}");
    }

    for entry in std::fs::read_dir(config.join("scenes")).expect("scenes") {
        let path = entry.expect("an entry").path();
        let scene = load_scene(&path, &[]).map(|scene| scene.settings);
        let scene = scene.unwrap_or_else(|errors| panic!("{errors}"));
        // That it diverges is what such a scene expects.
        let expects = !scene.expect.is_empty() || scene.run.end == End::Divergence;
        assert!(expects, "{}", path.display());
    }

    let csv = root().join("assets/recordings/cataract-stylus/stylus.csv");
    let map = load_recording_map(&csv).expect("map").settings;
    let header = std::fs::read_to_string(&csv).expect("the recording");
    let header: Vec<&str> = header
        .lines()
        .next()
        .expect("a header")
        .split(',')
        .collect();
    let device = &map.device[0];
    let named = [&map.time.column]
        .into_iter()
        .chain(&device.position)
        .chain(device.quaternion.iter().flatten());
    for column in named {
        assert!(header.contains(&column.as_str()), "{column}");
    }
    assert_eq!(Unit::Length.to_si(1.0, &device.position_unit), Some(0.001));
}

#[test]
fn a_recording_without_map_is_told_how_to_write_it() {
    let help = recording_map_help(
        Path::new("rec/hand.csv"),
        "t_s,x_mm,y_mm,z_mm,qx,qy,qz,qw\r",
    );
    let start = "rec/hand.csv: a recording needs a column map, the file rec/hand.toml beside it.\n\
                 Its header is: t_s, x_mm, y_mm, z_mm, qx, qy, qz, qw\n";
    assert!(help.starts_with(start), "{help}");
    // The example in it is a map that can be read, with the columns and units of the header.
    let (_, example) = help.split_once("\n\n").expect("an example");
    let map = read_recording_map(example, "hand.toml")
        .expect("the example is right")
        .settings;
    assert_eq!(
        (map.time.column.as_str(), map.time.unit.as_str()),
        ("t_s", "s")
    );
    assert_eq!(map.device[0].position, ["x_mm", "y_mm", "z_mm"]);
    assert_eq!(map.device[0].position_unit, "mm");
    let quaternion = map.device[0].quaternion.as_ref().expect("a quaternion");
    assert_eq!(quaternion, &["qx", "qy", "qz", "qw"]);

    // Other habits, and headings that say nothing.
    for (header, delimiter, time, x, unit) in [
        (
            "Time [ms];pos_x;pos_y;pos_z",
            ";",
            ("Time [ms]", "ms"),
            "pos_x",
            "m",
        ),
        ("t_min\tx_um", "\t", ("t_min", "min"), "x_um", "um"),
        ("a,b,c\"d", ",", ("t", "s"), "x", "m"),
        ("", ",", ("t", "s"), "x", "m"),
    ] {
        let help = recording_map_help(Path::new("hand.csv"), header);
        let (_, example) = help.split_once("\n\n").expect("an example");
        let map = read_recording_map(example, "hand.toml")
            .expect("readable")
            .settings;
        assert_eq!(map.delimiter, delimiter);
        assert_eq!((map.time.column.as_str(), map.time.unit.as_str()), time);
        assert_eq!(map.device[0].position[0], x);
        assert_eq!(map.device[0].position_unit, unit);
    }
}

#[test]
fn a_document_keeps_its_text_and_its_places() {
    let loaded = read_tool(example("tool"), "config/tools/x.toml").expect("the example is right");
    let document = &loaded.document;
    assert_eq!(document.text(), example("tool"));
    let key = KeyPath::root().key("capsule").at(1).key("radius");
    let error = document.error_at(&key, "a thin jaw", "a thick one");
    let line = 1
        + example("tool")
            .lines()
            .position(|line| line.contains("right-arm"))
            .expect("there")
        + 4;
    let expected = format!(
        "config/tools/x.toml:{line}:10: key `capsule[1].radius`: found a thin jaw, expected a thick one"
    );
    assert_eq!(error.to_string(), expected);
}

/// A variant of a level is the same task: what differs is how bodies are made, touched, cut and advanced.
#[test]
fn variants_are_the_tasks_of_their_levels() {
    let (tree, _) = discover(&root());
    let mut count = 0;
    for folder in &tree.modules {
        let load = |path: &Path| -> toml::Table {
            let text = std::fs::read_to_string(path).expect("a level");
            toml::from_str(&text).expect("TOML")
        };
        for variant in &folder.variants {
            let [level, own] =
                [&folder.levels[variant.level as usize - 1], &variant.path].map(|p| load(p));
            for table in [
                "view", "tool", "object", "rigid", "limit", "metrics", "module",
            ] {
                assert_eq!(
                    own.get(table),
                    level.get(table),
                    "{table} of {}",
                    variant.path.display()
                );
            }
            assert_eq!(own["clock"]["tick"], level["clock"]["tick"]);
            assert_ne!(own["title"], level["title"], "its title shows what it is");
            count += 1;
        }
    }
    assert_eq!(count, 2);
}
