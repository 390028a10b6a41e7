//! What `simulate` and `check` output about numbers that mean less than they seem to.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program.
fn microsim(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_microsim"));
    // Its log is not for the folders of whoever runs the tests.
    command.env("MICROSIM_DATA", env!("CARGO_TARGET_TMPDIR"));
    command.args(words).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A scene in a folder of its own: its `[run]` and `[method]`, and what follows.
fn scene(folder: &Path, run: &str, method: &str, rest: &str) -> PathBuf {
    let path = folder.join("x.toml");
    let text = format!(
        "title = {{de='a', en='b'}}\nsummary = {{de='a', en='b'}}\n[run]\n{run}\n[method]\n{method}\n{rest}"
    );
    std::fs::write(&path, text).expect("a file");
    path
}

/// The document of a run, and the exit status.
fn simulate(path: &Path, set: &[&str]) -> (Value, Option<i32>) {
    let path = path.to_str().expect("UTF-8");
    let set = set.iter().flat_map(|value| ["--set", value]);
    let words: Vec<&str> = ["simulate", path, "--json"]
        .into_iter()
        .chain(set)
        .collect();
    let output = microsim(&words);
    let document = serde_json::from_slice(&output.stdout);
    (
        document.unwrap_or_else(|e| panic!("{e}: {output:?}")),
        output.status.code(),
    )
}

const BEAM: &str = "[[body]]
name = 'b'
generator = 'block'
size = ['60 mm', '6 mm', '4 mm']
cells = [12, 2, 2]
centre = ['30 mm', '3 mm', '2 mm']
material = [{law='stable-neo-hookean', youngs_modulus='200 kPa', poisson_ratio=0.35, density='1000 kg/m^3'}]
clamp = [{nodes = {min=['-31 mm', '-4 mm', '-3 mm'], max=['-29.999 mm', '4 mm', '3 mm']}}]
start = [{velocity=[0, 0, '0.5 m/s']}]
";

/// A beam that swings undamped and alone, for half a minute of guarded midpoint: it ends with more than four times the energy that it began with.
#[test]
fn energy_that_grows_without_work_is_no_good_result() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = "duration='20 s'\nstep='2 ms'\nsample='20 ms'\ngravity=[0, 0, 0]";
    let path = scene(folder.path(), run, "name='guarded-midpoint'", BEAM);
    let (document, status) = simulate(&path, &[]);
    assert_eq!(
        (&document["status"], status),
        (&"gains-energy".into(), Some(1))
    );
    let said = document["warnings"].to_string();
    assert!(
        said.contains("Gains energy though nothing does work on it"),
        "{said}"
    );
    // A method that dissipates, and gravity that does work, are well.
    for set in [
        &["method.name=implicit-euler", "run.duration=1s"][..],
        &["run.gravity=[0, 0, -9.81]", "run.duration=0.5s"],
    ] {
        let (document, status) = simulate(&path, set);
        assert_eq!(
            (&document["status"], status),
            (&"ok".into(), Some(0)),
            "{set:?}"
        );
    }
}

const ROLLER: &str = "[[body]]
name = 'b'
generator = 'tube'
inner_radius = '2 mm'
length = '4 mm'
layer = [{thickness='3 mm', cells=2}]
around = 12
along = 2
axis = [0, 1, 0]
centre = [0, 0, '4.95 mm']
material = [{law='stable-neo-hookean', youngs_modulus='1 MPa', poisson_ratio=0.3, density='1000 kg/m^3', relaxation_time='1 ms'}]
start = [{velocity=['0.2 m/s', 0, 0]}]
[[rigid]]
name = 'floor'
shape = 'plane'
[[contact]]
body = 'b'
rigid = 'floor'
friction = 0.6
[[probe]]
name = 'x'
body = 'b'
quantity = 'centre'
direction = [1, 0, 0]
";

/// With the settings that an implicit method has when none are given: steps that did not converge are computed again with shorter ones.
#[test]
fn what_rolls_with_friction_goes_through_with_default_settings() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene(
        folder.path(),
        "duration='0.1 s'\nstep='2 ms'",
        "name='implicit-euler'",
        ROLLER,
    );
    let (document, status) = simulate(&path, &[]);
    assert_eq!((&document["status"], status), (&"ok".into(), Some(0)));
    let again = document["recoveries"].as_array().expect("a list");
    assert!(
        !again.is_empty()
            && again
                .iter()
                .all(|r| r["what"].to_string().contains("not converged")),
        "{again:?}"
    );
    let x = document["probes"][0]["values"]
        .as_array()
        .and_then(|x| x.last()?.as_f64())
        .expect("x");
    // From 0.2 m/s sliding friction has it roll with two thirds of that or a little more.
    assert!((0.011..0.02).contains(&x), "{x}");
}

/// What cannot be helped by shorter steps has an advice that can be followed: an implicit method is not advised to itself.
#[test]
fn a_step_that_does_not_converge_has_an_advice_for_its_method() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene(
        folder.path(),
        "duration='0.1 s'\nstep='2 ms'",
        "name='implicit-euler'\niterations=1\ntolerance=1e-12",
        ROLLER,
    );
    let output = microsim(&["simulate", path.to_str().expect("UTF-8")]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("--set method.must_converge=false") && !said.contains("an implicit method"),
        "{said}"
    );
    // And it helps.
    let (document, status) = simulate(&path, &["method.must_converge=false"]);
    assert_eq!((&document["status"], status), (&"ok".into(), Some(0)));
}

/// On an unstructured mesh that locks and bends; without running anything.
#[test]
fn check_says_how_far_a_mesh_is_off() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("../study/tests/plate.msh");
    std::fs::copy(mesh, folder.path().join("plate.msh")).expect("a copy");
    let body = |discretisation: &str| {
        format!(
            "[[body]]\nname='plate'\ngenerator='file'\nfile='plate.msh'\nscale='1 mm'\nmaterial=[{{law='neo-hookean', youngs_modulus='100 kPa', poisson_ratio=0.49, density=1000, discretisation='{discretisation}'}}]\nclamp=[{{nodes={{min=['-1 mm', -1, -1], max=['0.001 mm', 1, 1]}}}}]\n"
        )
    };
    let check = |discretisation: &str| {
        let path = scene(
            folder.path(),
            "duration=1\nstep='1 ms'",
            "name='quasi-static'",
            &body(discretisation),
        );
        let output = microsim(&["check", path.to_str().expect("UTF-8")]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        text(&output.stdout)
    };
    let said = check("patch-pressure");
    assert!(
        said.contains("key `body[0]`: body 'plate' moves 35 % as far under its own weight along z"),
        "{said}"
    );
    assert!(
        said.contains("\"selective\" would have 59 %, more needs a finer mesh"),
        "{said}"
    );
    assert!(check("selective").contains("moves 59 % as far"));
}

/// Laws that stiffen are warned of before they diverge at a step that is stable at rest.
#[test]
fn a_step_that_is_stable_at_rest_alone_is_warned_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let warned = |law: &str| {
        let body = BEAM.replace("stable-neo-hookean", law);
        let path = scene(
            folder.path(),
            "duration=1\nstep='50 us'",
            "name='stoermer-verlet'",
            &body,
        );
        let largest = text(&microsim(&["check", path.to_str().expect("UTF-8")]).stdout);
        largest.contains("may diverge at strains from 25 % on")
    };
    for (law, expected) in [
        ("st-venant-kirchhoff", true),
        ("neo-hookean", true),
        ("stable-neo-hookean", false),
        ("corotational", false),
        ("neo-hookean-polynomial", false),
    ] {
        assert_eq!(warned(law), expected, "{law}");
    }
}

/// The inertia that explicit methods need at small elements of a cut has no weight: that is printed, by how much and what helps.
#[test]
fn pieces_that_fall_too_slowly_are_named() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let root = root.to_str().expect("UTF-8");
    let output = microsim(&["--root", root, "simulate", "cut-block"]);
    let said = text(&output.stdout);
    assert!(
        said.contains("Pieces cut from body 'block' fall with 8") && said.contains("% of gravity"),
        "{said}"
    );
}
