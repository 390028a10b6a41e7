//! `microsim simulate` and `microsim check` on scenes and meshes, as a user calls them.

use microsim_mesh::format::{MeshFormat, read_tet_mesh};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/scenes")
}

/// Runs the program; the first word is the command.
fn microsim(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_microsim"));
    command.args(words).output().expect("the program starts")
}

fn simulate(scene: &str, words: &[&str]) -> Output {
    let scene = scenes().join(scene).with_extension("toml");
    let scene = scene.to_str().expect("a path in UTF-8");
    microsim(&[&["simulate", scene][..], words].concat())
}

/// The document on standard output, which holds nothing else.
fn document(scene: &str, words: &[&str]) -> Value {
    let output = simulate(scene, &[words, &["--json"]].concat());
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn length(value: &Value) -> usize {
    value.as_array().expect("a list").len()
}

#[test]
fn the_document_is_complete_and_consistent() {
    let run = document("drop", &["--set", "run.duration=20ms"]);
    assert_eq!(run["status"], "ok");
    assert_eq!(run["method"], "stoermer-verlet");
    // 20 ms in steps of 50 µs.
    assert_eq!(
        (run["steps"].as_u64(), run["threads"].as_u64()),
        (Some(400), Some(1))
    );
    assert!((run["dt"].as_f64().expect("a step") - 50e-6).abs() < 1e-15);
    assert!((run["simulated_s"].as_f64().expect("a time") - 0.02).abs() < 1e-12);
    assert!(run["cpu_s"].as_f64().is_some_and(|s| s > 0.0));
    assert_eq!(run["state_hash"].as_str().map(str::len), Some(64));

    // 3 × 3 × 3 cells: 64 nodes, 162 tetrahedra, 6 · 9 · 2 triangles.
    let body = &run["bodies"][0];
    assert_eq!(body["name"], "cube");
    assert_eq!(body["material"][0]["law"], "stable-neo-hookean");
    for list in ["rest", "start", "nodes", "velocities", "masses"] {
        assert_eq!(length(&body[list]), 64, "{list}");
    }
    assert_eq!(
        (length(&body["tets"]), length(&body["surface"])),
        (162, 108)
    );
    let mass: f64 = body["masses"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(Value::as_f64)
        .sum();
    assert!((mass / (1060.0 * 1e-6) - 1.0).abs() < 1e-12, "{mass}");
    assert!(
        body["volume"]
            .as_f64()
            .is_some_and(|v| (v / 1e-6 - 1.0).abs() < 0.2)
    );
    assert!(body["energy"]["kinetic"].as_f64().is_some_and(|e| e > 0.0));
    // It starts drawn out by a tenth.
    let (rest, start) = (&body["rest"][0][0], &body["start"][0][0]);
    let drawn = start.as_f64().expect("x") / rest.as_f64().expect("x");
    assert!((drawn - 1.1).abs() < 1e-12, "{drawn}");

    // 20 samples after the one at the start.
    for series in ["t", "kinetic_J", "elastic_J", "dissipated_J"] {
        assert_eq!(length(&run["series"][series]), 21, "{series}");
    }
    assert_eq!(length(&run["probes"][0]["values"]), 21);
    assert_eq!(
        (&run["probes"][0]["name"], &run["probes"][0]["unit"]),
        (&"fall".into(), &"m".into())
    );
    assert_eq!(run["expectations"][0]["expected"], 0.04905);
}

/// 10,290 tetrahedra are enough for parallel parts.
#[test]
fn threads_do_not_change_a_bit() {
    let large = [
        "--set",
        "body.0.cells=[35,7,7]",
        "--set",
        "run.duration=5ms",
    ];
    let hash = |threads| {
        document(
            "cantilever-dynamic",
            &[&large[..], &["--threads", threads]].concat(),
        )["state_hash"]
            .clone()
    };
    assert_eq!(hash("1"), hash("3"));
}

#[test]
fn what_diverged_is_said_and_marked() {
    let far = ["--set", "run.step=1ms"];
    let refused = simulate("cantilever-dynamic", &far);
    assert_eq!(refused.status.code(), Some(2));
    let said = text(&refused.stderr);
    let parts = [
        "--set run.step=1ms: key `run.step`",
        "1000.000 us",
        "body 'beam'",
        "shorter step",
    ];
    assert!(parts.iter().all(|part| said.contains(part)), "{said}");

    let output = simulate(
        "cantilever-dynamic",
        &[&far[..], &["--any-step", "--json"]].concat(),
    );
    assert_eq!(output.status.code(), Some(1));
    let run: Value = serde_json::from_slice(&output.stdout).expect("a document");
    assert_eq!(
        (&run["status"], &run["diverged"]["body"]),
        (&"diverged".into(), &"beam".into())
    );
    assert!(run["diverged"]["step"].as_u64().is_some());
    // The last good state is shown: every number is one.
    let nodes = run["bodies"][0]["nodes"].as_array().expect("a list");
    assert!(
        nodes
            .iter()
            .flat_map(|p| p.as_array().expect("a point"))
            .all(Value::is_f64)
    );
    assert_eq!(run["expectations"][0]["met"], false);
}

#[test]
fn a_missed_expectation_is_a_verdict_only_on_request() {
    let wrong = [
        "--set",
        "expect.0.value=\"50 mm\"",
        "--set",
        "run.duration=20ms",
    ];
    let output = simulate("drop", &wrong);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("MISSED"));
    assert_eq!(
        simulate("drop", &[&wrong[..], &["--require"]].concat())
            .status
            .code(),
        Some(1)
    );
    assert_eq!(simulate("drop", &["--require"]).status.code(), Some(0));
}

/// A verdict is one whether or not somebody reads on, and an undamped beam does not rest.
#[test]
fn a_verdict_does_not_depend_on_its_readers() {
    let restless = [
        "--set",
        "run.end=rest",
        "--set",
        "run.rest_speed=1um/s",
        "--set",
        "run.duration=5ms",
    ];
    let output = simulate("cantilever-dynamic", &[&restless[..], &["--json"]].concat());
    assert_eq!(output.status.code(), Some(1));
    let run: Value = serde_json::from_slice(&output.stdout).expect("a document");
    assert_eq!(run["status"], "not-at-rest");
    assert_eq!(run["set"][1], "run.rest_speed=1um/s");
    assert_eq!(run["run"]["duration"], 0.005);

    let scene = scenes().join("cantilever-dynamic.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_microsim"));
    command.arg("simulate").arg(scene).args(restless);
    let mut child = command
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    assert_eq!(child.wait().expect("an end").code(), Some(1));
}

/// A folder is walked, a scene is known wherever it lies, and a missing file is called that.
#[test]
fn check_walks_folders_and_knows_scenes_by_their_tables() {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("deep");
    std::fs::create_dir(&inner).expect("a folder");
    std::fs::copy(scenes().join("drop.toml"), inner.join("mine.toml")).expect("a copy");
    let check = |path: &Path| {
        let output = microsim(&["check", path.to_str().expect("UTF-8")]);
        (output.status.code(), text(&output.stdout))
    };
    let (code, said) = check(folder.path());
    assert!(code == Some(0) && said.contains("1 checked"), "{said}");
    let (code, said) = check(&folder.path().join("nothing.toml"));
    assert!(
        code == Some(1) && said.contains("nothing.toml: no such file"),
        "{said}"
    );
}

#[test]
fn meshes_are_written_for_paraview() {
    let folder = tempfile::tempdir().expect("a folder");
    let (vtu, json) = (folder.path().join("frames"), folder.path().join("run.json"));
    let words = [
        "--set",
        "run.duration=20ms",
        "--vtu",
        vtu.to_str().expect("UTF-8"),
        "--json",
        json.to_str().expect("UTF-8"),
    ];
    let output = simulate("drop", &words);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    // Every 5 ms from 0 to 20 ms.
    let list = std::fs::read_to_string(vtu.join("drop.pvd")).expect("a list");
    assert_eq!(list.matches("<DataSet").count(), 5, "{list}");
    let times = list.split("timestep=\"").skip(1);
    let times: Vec<f64> = times
        .map(|rest| rest.split('"').next().expect("a time"))
        .map(|time| time.parse().expect("a number"))
        .collect();
    let last = std::fs::read(vtu.join("drop-cube-00004.vtu")).expect("a frame");
    for field in [
        "displacement [m]",
        "velocity [m/s]",
        "volume ratio",
        "von Mises stress [Pa]",
        "Cauchy stress [Pa]\" NumberOfComponents=\"6\"",
        "Green strain\" NumberOfComponents=\"6\"",
        "region",
    ] {
        assert!(text(&last).contains(field), "{field}");
    }
    let mesh = read_tet_mesh(MeshFormat::Vtu, &[&last])
        .expect("a mesh")
        .mesh;
    let run: Value = serde_json::from_slice(&std::fs::read(json).expect("a file")).expect("JSON");
    // To the bit those of the series: a sample per millisecond.
    let series = run["series"]["t"].as_array().expect("a list");
    let every_fifth = series.iter().step_by(5).filter_map(Value::as_f64);
    assert_eq!(times, every_fifth.collect::<Vec<_>>());
    for (point, node) in mesh
        .positions
        .iter()
        .zip(run["bodies"][0]["nodes"].as_array().expect("a list"))
    {
        let node: Vec<f64> = node
            .as_array()
            .expect("a point")
            .iter()
            .filter_map(Value::as_f64)
            .collect();
        assert_eq!([point.x, point.y, point.z].as_slice(), node);
    }
}

#[test]
fn a_scene_is_found_by_its_name_or_the_names_are_told() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let root = root.to_str().expect("UTF-8");
    let output = microsim(&["--root", root, "simulate", "tube-sag"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let output = microsim(&["--root", root, "simulate", "tube-sags"]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(
        said.contains("tube-sags") && said.contains("vessel-pull"),
        "{said}"
    );
}

/// A scene in a folder `scenes` of its own, with what stands for its only body.
fn scene_file(folder: &Path, body: &str) -> PathBuf {
    let scenes = folder.join("scenes");
    std::fs::create_dir_all(&scenes).expect("a folder");
    let path = scenes.join("x.toml");
    let text = format!(
        "title = {{de='a', en='b'}}\nsummary = {{de='a', en='b'}}\nrun = {{duration=1, step='1 ms'}}\nmethod = {{name='stoermer-verlet'}}\n[[body]]\nname = 'body'\n{body}\n"
    );
    std::fs::write(&path, text).expect("a file");
    path
}

const MATERIAL: &str =
    "material = [{density=1000, law='corotational', youngs_modulus='1 kPa', poisson_ratio=0.3}]";

/// Each is found without running, with the line of the scene and what helps.
#[test]
fn check_finds_bad_meshes_materials_and_steps() {
    let folder = tempfile::tempdir().expect("a folder");
    let check = |path: &Path| {
        let output = microsim(&["check", path.to_str().expect("UTF-8")]);
        (output.status.code(), text(&output.stdout))
    };
    // A tetrahedron of 10 mm, and what is done to it: nodes and elements of TetGen.
    let nodes = "0 0 0 0\n1 0.01 0 0\n2 0 0.01 0\n3 0 0 0.01\n";
    let cases = [
        (
            format!("4 3 0 0\n{nodes}"),
            "1 4 0\n0 0 1 2 3\n",
            Some(0),
            "0 with problems",
        ),
        (
            format!("5 3 0 0\n{nodes}4 1 1 1\n"),
            "1 4 0\n0 0 1 2 3\n",
            Some(1),
            "belongs to no element",
        ),
        (
            format!("4 3 0 0\n{nodes}"),
            "2 4 0\n0 0 1 2 3\n1 1 2 3 0\n",
            Some(1),
            "same nodes",
        ),
        (
            format!("5 3 0 0\n{nodes}4 0.01 0.01 0\n"),
            "2 4 0\n0 0 1 2 3\n1 0 1 2 4\n",
            Some(1),
            "is flat",
        ),
        (
            "4 3 0 0\n0 0 0 0\n1 nan 0 0\n2 0 0.01 0\n3 0 0 0.01\n".to_owned(),
            "1 4 0\n0 0 1 2 3\n",
            Some(1),
            "x.toml:8:8: key `body[0].file`",
        ),
        (
            format!("4 3 0 0\n{nodes}"),
            "1 4 0\n0 0 1 2\n",
            Some(1),
            "`mesh.node`: .ele file",
        ),
    ];
    let file = format!("generator = 'file'\nfile = 'mesh.node'\n{MATERIAL}");
    // Slow enough for the coarse body of 1 kPa: c = √(E/ρ) ≈ 1 m/s, 10 mm, so the limit is some milliseconds.
    let path = scene_file(folder.path(), &file);
    for (node, ele, code, said) in cases {
        std::fs::write(folder.path().join("scenes/mesh.node"), node).expect("a file");
        std::fs::write(folder.path().join("scenes/mesh.ele"), ele).expect("a file");
        let (found, text) = check(&path);
        assert!(
            found == code && text.contains(said),
            "{said}: {found:?} {text}"
        );
    }
    // The mesh alone is named, too.
    let (code, text) = check(&folder.path().join("scenes/mesh.node"));
    assert!(
        code == Some(1) && text.contains("mesh.node: .ele file"),
        "{text}"
    );

    let block = |size: &str, material: &str| {
        format!(
            "generator = 'block'\nsize = [{size}, {size}, {size}]\ncells = [2, 2, 2]\nmaterial = [{{density=1000, {material}}}]"
        )
    };
    let stiff = "law='corotational', youngs_modulus='1 GPa', poisson_ratio=0.3";
    let lock = "law='corotational', youngs_modulus='1 kPa', poisson_ratio=0.45";
    let lost = "region=7, law='corotational', youngs_modulus='1 kPa', poisson_ratio=0.3";
    let zero = "law='corotational', youngs_modulus=0, poisson_ratio=0.3";
    let full = "law='corotational', youngs_modulus='1 kPa', poisson_ratio=0.5";
    for (material, code, said) in [
        (
            stiff,
            Some(1),
            "x.toml:3:25: key `run.step`: a step of 1000.000 us is beyond",
        ),
        (lock, Some(0), "warning: "),
        (
            lost,
            Some(1),
            "key `body[0].material[0].region`: the mesh has no region 7, only [0]",
        ),
        (
            zero,
            Some(1),
            "key `body[0].material[0].youngs_modulus`: found `0`",
        ),
        (
            full,
            Some(1),
            "key `body[0].material[0].poisson_ratio`: found `0.5`",
        ),
    ] {
        let (found, text) = check(&scene_file(folder.path(), &block("0.1", material)));
        assert!(
            found == code && text.contains(said),
            "{said}: {found:?} {text}"
        );
    }
}

/// Time and probes of the table are those of the document, to the bit; a folder that is refused leaves an older table as it was.
#[test]
fn probes_are_written_as_a_table() {
    let folder = tempfile::tempdir().expect("a folder");
    let (csv, json) = (
        folder.path().join("run.csv"),
        folder.path().join("run.json"),
    );
    let words = [
        "--set",
        "run.duration=20ms",
        "--csv",
        csv.to_str().expect("UTF-8"),
        "--json",
        json.to_str().expect("UTF-8"),
    ];
    let output = simulate("drop", &words);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("Series of the probes in "));
    let table = std::fs::read_to_string(&csv).expect("a table");
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("time [s],fall [m],drift [m]"));
    let rows: Vec<Vec<f64>> = lines
        .map(|line| {
            line.split(',')
                .map(|cell| cell.parse().expect("a number"))
                .collect()
        })
        .collect();
    let run: Value = serde_json::from_slice(&std::fs::read(&json).expect("a file")).expect("JSON");
    let column = |values: &Value| -> Vec<f64> {
        let values = values.as_array().expect("a list").iter();
        values.filter_map(Value::as_f64).collect()
    };
    let columns = [
        column(&run["series"]["t"]),
        column(&run["probes"][0]["values"]),
        column(&run["probes"][1]["values"]),
    ];
    assert_eq!(rows.len(), 21);
    for (sample, row) in rows.iter().enumerate() {
        assert_eq!(*row, columns.each_ref().map(|column| column[sample]));
    }

    std::fs::write(folder.path().join("frame-000001.png"), "an older picture").expect("a file");
    let pictures = folder.path().to_str().expect("UTF-8");
    let refused = simulate("drop", &[&words[..4], &["--frames", pictures]].concat());
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
    assert_eq!(std::fs::read_to_string(&csv).expect("a table"), table);
    // A file in the place of the folder of meshes is found after the table's name was looked at.
    let file = json.to_str().expect("UTF-8");
    let refused = simulate("drop", &[&words[..4], &["--vtu", file]].concat());
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
    assert_eq!(std::fs::read_to_string(&csv).expect("a table"), table);
}

/// A scene in English alone runs; without an English text it is refused. A mesh above the folder of its scene is refused with the reason.
#[test]
fn scenes_need_no_german_and_their_meshes_lie_below_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("mine.toml");
    let said = |text_of_scene: &str| {
        std::fs::write(&scene, text_of_scene).expect("a file");
        let output = microsim(&["check", scene.to_str().expect("UTF-8")]);
        let said = text(&output.stdout) + &text(&output.stderr);
        (output.status.code(), said)
    };
    let shipped = std::fs::read_to_string(scenes().join("drop.toml")).expect("a scene");
    let without = |language: &str| {
        let start = format!("{language} = \"");
        let lines = shipped.lines().filter(|line| !line.starts_with(&start));
        lines.collect::<Vec<_>>().join("\n")
    };
    let (code, out) = said(&without("de"));
    assert_eq!(code, Some(0), "{out}");
    let (code, out) = said(&without("en"));
    assert!(code == Some(1) && out.contains("`title.en`"), "{out}");

    let bad = "[run]\nduration = \"1 s\"\n[[body]]\nname = \"b\"\ngenerator = \"file\"\nfile = \"../mesh.msh\"\n";
    let (code, out) = said(bad);
    let reason = "a path below this folder, with `/` and without `..`";
    assert!(code == Some(1) && out.contains(reason), "{out}");
}

#[test]
fn layers_of_a_mesh_file_that_are_detached_on_purpose_are_no_warning() {
    let block = microsim_mesh::Block {
        center: [0.0; 3],
        size: [2e-3; 3],
        cells: [2; 3],
        split: microsim_mesh::CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block");
    let upper = mesh.tets.len() / 2;
    mesh.regions[upper..].fill(1);
    let folder = tempfile::tempdir().expect("a folder");
    let check = |mesh: &microsim_mesh::TetMesh, body: &str| {
        let file = microsim_mesh::format::write_gmsh_2(mesh);
        std::fs::write(folder.path().join("block.msh"), file).expect("a file");
        let scene = folder.path().join("layers.toml");
        let text_of_scene = format!(
            "no_stated_error = \"a test\"\n[title]\nen = \"Layers\"\n[summary]\nen = \"Layers\"\n[run]\nduration = \"1 s\"\nstep = \"0.1 s\"\nsample = \"0.1 s\"\n[method]\nname = \"quasi-static\"\n[[body]]\nname = \"block\"\ngenerator = \"file\"\nfile = \"block.msh\"\n{body}\n[[body.material]]\nlaw = \"stable-neo-hookean\"\nyoungs_modulus = \"100 kPa\"\npoisson_ratio = 0.3\ndensity = 1060\n[[body.clamp]]\nnodes = {{ min = [\"-1 mm\", \"-1 mm\", \"-1 mm\"], max = [\"1 mm\", \"1 mm\", \"-1 mm\"] }}\n[[body.coupling]]\nfrom = 1\nto = 0\nstiffness = \"1e9 N/m^3\"\n"
        );
        std::fs::write(&scene, text_of_scene).expect("a file");
        let output = microsim(&["check", scene.to_str().expect("UTF-8")]);
        let out = text(&output.stdout) + &text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{out}");
        out
    };
    let meant = check(&mesh, "detached = [1]");
    assert!(
        !meant.contains("lie in one place") && !meant.contains("falls into"),
        "{meant}"
    );
    // A file whose regions have nodes of their own although nobody wants them detached.
    let found = check(&mesh.detached(&[1]).mesh, "");
    assert!(
        found.contains("lie in one place") && found.contains("falls into"),
        "{found}"
    );
}
