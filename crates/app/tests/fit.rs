//! `microsim fit` as a user calls it; that constants come back is tested in the crate `fit`.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn table(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/fit");
    folder.join(name)
}

fn fit(data: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_microsim"));
    command.arg("fit").arg(data).args(words);
    command.output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The material of `--out`, of text and of JSON is the same, and a scene takes it.
#[test]
fn the_material_that_is_written_can_be_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("material.toml");
    let out_name = out.to_str().expect("a path in UTF-8");
    let data = table("transversely-isotropic.csv");
    let law = [
        "--law",
        "transversely-isotropic",
        "--set",
        "fibres.angle=0deg",
    ];
    let run = fit(&data, &[&law[..], &["--out", out_name]].concat());
    assert!(run.status.success(), "{run:?}");
    let material = std::fs::read_to_string(&out).expect("it is written");
    assert!(text(&run.stdout).contains(&material), "{run:?}");
    // The example of a tube, as only that has an axis of its own.
    let body = "name = \"tube\"\ngenerator = \"tube\"\ninner_radius = 0.001\nlayer = [{ thickness = 0.001, cells = 1 }]\n\
                length = 0.01\naround = 8\nalong = 4\n";
    let scene = format!(
        "title = {{ en = 'a' }}\nsummary = {{ en = 'b' }}\nrun = {{ duration = 1, step = 0.01 }}\nmethod = {{ name = 'implicit-euler' }}\n\
         [[body]]\n{body}{material}"
    );
    let read = microsim_settings::read_scene(&scene, "f.toml", &[]).expect("a scene");
    let material_read = read.settings.body[0].material[0];
    // The assumed 0.49 of Poisson's ratio would lock.
    let selective = Some(microsim_settings::Discretisation::Selective);
    assert_eq!(material_read.discretisation, selective);

    let run = fit(&data, &[&law[..], &["--json"]].concat());
    let document: Value = serde_json::from_slice(&run.stdout).expect("JSON alone");
    assert_eq!(document["toml"], material.as_str());
    let value = |key: &str| {
        let constants = document["constants"].as_array().expect("a list");
        let constant = constants.iter().find(|constant| constant["key"] == key);
        constant.expect(key)["value"].as_f64()
    };
    assert_eq!(value("youngs_modulus"), material_read.youngs_modulus);
    assert_eq!(value("fibre_ratio"), material_read.fibre_ratio);
    assert_eq!(value("poisson_ratio"), Some(0.49));
    assert_eq!(document["constants"][1]["determination"], "assumed");
    assert_eq!(document["goodness"][0]["stresses"], 60);

    // What is there already stays.
    let again = fit(&data, &[&law[..], &["--out", out_name]].concat());
    assert_eq!(again.status.code(), Some(2));
}

#[test]
fn what_cannot_be_fitted_is_refused_with_what_was_expected() {
    let folder = tempfile::tempdir().expect("a folder");
    let bad = folder.path().join("bad.csv");
    std::fs::write(&bad, "stretch_1,cauchy_1 [kPa]\n1.1,zwei\n").expect("a file");
    let data = table("mooney-rivlin.csv");
    let name = data.display();
    for (data, words, expected) in [
        (
            &bad,
            &["--law", "neo-hookean"][..],
            format!(
                "{}:2: column `cauchy_1 [kPa]`: found `zwei`, expected a stress, or nothing where it was not measured",
                bad.display()
            ),
        ),
        (
            &data,
            &["--law", "mooney-rivlin", "--set", "c01_fraction=2"],
            "--set c01_fraction=2: c01_fraction: found `2`, expected a number from 0 to 1"
                .to_owned(),
        ),
        (
            &data,
            &["--law", "neo-hookean", "--set", "youngs_modulus=1kPa"],
            format!("{name}: every constant is given: there is nothing to fit"),
        ),
        (
            &data,
            &[
                "--law",
                "mooney-rivlin",
                "--set",
                "c01_fraction=0",
                "--set",
                "c01_fraction=1",
            ],
            "--set c01_fraction=1: found c01_fraction a second time, expected each constant once"
                .to_owned(),
        ),
        (
            &data,
            &["--law", "hooke"],
            "expected one of st-venant-kirchhoff,".to_owned(),
        ),
    ] {
        let run = fit(data, words);
        assert_eq!(run.status.code(), Some(2), "{run:?}");
        assert!(text(&run.stderr).contains(&expected), "{run:?}");
    }
}
