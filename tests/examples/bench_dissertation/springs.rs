//! Sections 3.4, 4.1 and 4.2: what springs, areas and volumes are as a material, and what they cost beside a continuum.

use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_tests::simulated::{probe, simulate};
use microsim_tissue::homogenise::{EffectiveStiffness, homogenise};
use microsim_tissue::{
    Behaviour, Coefficients, KindConstants, Material, SpringConstants, SpringForm, build_model,
};
use nalgebra::Vector3;
use std::fmt::Write as _;

/// Young's modulus that is aimed at \[Pa\].
const YOUNG: f64 = 20e3;

/// Edge of the cube \[m\].
const SIDE: f64 = 10e-3;

/// Cells along the edge of the mesh for which constants are chosen, and of the finer one.
const CELLS: [usize; 2] = [4, 8];

/// Measures and describes it.
pub fn measure(text: &mut String) -> Result<crate::Drawings, String> {
    moduli(text)?;
    beside_a_continuum(text)?;
    Ok(Vec::new())
}

fn cube(cells: usize, split: CellSplit) -> Result<TetMesh, String> {
    let block = Block {
        center: [0.0; 3],
        size: [SIDE; 3],
        cells: [cells; 3],
        split,
    };
    block.mesh().map_err(|e| e.to_string())
}

/// The stiffness of a cube of such springs.
fn stiffness(mesh: &TetMesh, form: SpringForm) -> Result<EffectiveStiffness, String> {
    let material = Material {
        density: 1e3,
        relaxation_time: 0.0,
        behaviour: Behaviour::Springs(SpringConstants {
            form,
            plasticity: None,
        }),
    };
    let free = vec![false; mesh.positions.len()];
    let model = build_model(mesh, &[(0, material)], &free, 0.0, Vec::new());
    let model = model.map_err(|e| e.to_string())?;
    Ok(homogenise(
        &mesh.positions,
        model.sets(),
        SIDE * SIDE * SIDE,
    ))
}

fn constants(length: f64, area: f64, volume: f64) -> KindConstants {
    let of = |stiffness| Coefficients {
        stiffness,
        damping: 0.0,
    };
    KindConstants {
        length: of(length),
        area: of(area),
        volume: of(volume),
    }
}

/// Young's modulus and Poisson's ratio of each form, on the mesh for which its constants were chosen and on others.
fn moduli(text: &mut String) -> Result<(), String> {
    let [coarse, fine] = CELLS;
    let chosen_on = cube(coarse, CellSplit::Kuhn)?;
    let edge = SIDE / coarse as f64;
    let element = edge * edge * edge / 6.0;
    // k of springs so that the mean over all directions has Young's modulus: it is proportional to k.
    let scale = |form: &dyn Fn(f64) -> SpringForm| -> Result<f64, String> {
        let (young, _) = stiffness(&chosen_on, form(1.0))?.isotropic();
        Ok(YOUNG / young)
    };
    let plain = |k: f64| SpringForm::Plain(constants(k, 0.0, 0.0));
    let normalised = |k: f64| SpringForm::Normalised(constants(k, 0.0, 0.0));
    let (k_plain, k_normalised) = (scale(&plain)?, scale(&normalised)?);
    let scaled = |k: f64| {
        SpringForm::Scaled(microsim_tissue::SpringModuli {
            stretch: k,
            area: 0.0,
            volume: 0.0,
        })
    };
    let k_scaled = scale(&scaled)?;
    // As much against a change of volume as Young's modulus; of areas half of it.
    let with_volumes = SpringForm::Plain(constants(k_plain, 0.0, YOUNG / element));
    let versatile = SpringForm::Normalised(constants(
        k_normalised,
        0.5 * YOUNG * element,
        YOUNG * element,
    ));
    let forms = [
        (format!("plain (4.1), {k_plain:.3} N/m"), plain(k_plain)),
        ("plain with volumes (4.1, 4.2)".into(), with_volumes),
        (
            format!("normalised (3.5), {:.2} µJ", 1e6 * k_normalised),
            normalised(k_normalised),
        ),
        (
            "normalised with areas and volumes (3.5 to 3.7, THMG04)".into(),
            versatile,
        ),
        (
            format!("scaled, {:.1} kPa", 1e-3 * k_scaled),
            scaled(k_scaled),
        ),
        (
            "fitted to ν = 0.3".into(),
            SpringForm::Fitted {
                young: YOUNG,
                poisson: 0.3,
            },
        ),
        (
            "fitted to ν = 0.45".into(),
            SpringForm::Fitted {
                young: YOUNG,
                poisson: 0.45,
            },
        ),
    ];
    let _ = writeln!(
        text,
        "\n## 3.4, 4.1, 4.2: springs, areas and volumes\n\nWhat Young's modulus E and Poisson's ratio ν each really has: a cube of 10 mm under small strains (`homogenise` of the crate tissue; a stretch that is \
         simulated follows below). Constants are those of springs that have E = 20 kPa in the mean over all directions on {coarse} cells, all alike; with volumes and areas, these are added. The dissertation gives no \
         constants. Deviation: the largest of E along axes, face and space diagonals from 20 kPa. Springs alone have ν = 1/4 in the mean (Cauchy), whatever is aimed at; plain and normalised constants are those of \
         one mesh: on cells of half the size the same k is another material.\n\n\
         | form | cells | E, mean | ν, mean | E along an axis | a face diagonal | a space diagonal | the other one | deviation |\n|---|---|---|---|---|---|---|---|---|"
    );
    let meshes = [
        (format!("{coarse}, all alike"), chosen_on),
        (format!("{fine}, all alike"), cube(fine, CellSplit::Kuhn)?),
        (
            format!("{coarse}, mirrored"),
            cube(coarse, CellSplit::Mirrored)?,
        ),
        (format!("{coarse}, five"), cube(coarse, CellSplit::Five)?),
    ];
    for (form_name, form) in forms {
        for (mesh_name, mesh) in &meshes {
            let stiffness = stiffness(mesh, form)?;
            let (young, poisson) = stiffness.isotropic();
            let along = |x: f64, y: f64, z: f64| {
                let n = Vector3::new(x, y, z);
                format!("{:.1} kPa", 1e-3 * stiffness.along(&n, &n).0)
            };
            let _ = writeln!(
                text,
                "| {form_name} | {mesh_name} | {:.1} kPa | {poisson:.3} | {} | {} | {} | {} | {:.0} % |",
                1e-3 * young,
                along(1.0, 0.0, 0.0),
                along(1.0, 1.0, 0.0),
                along(1.0, 1.0, 1.0),
                along(1.0, -1.0, 1.0),
                100.0 * stiffness.error(YOUNG),
            );
        }
    }
    Ok(())
}

/// A scene of the chart, what it measures there, and the value that is exact.
struct Case {
    scene: &'static str,
    title: &'static str,
    probe: &'static str,
    exact: f64,
    /// Overrides of every run, and those of explicit methods with their step.
    set: &'static [&'static str],
    explicit: &'static [&'static str],
}

const CASES: [Case; 3] = [
    Case {
        scene: "stretch",
        title: "uniaxial stretch by 30 %, 4 × 4 × 4 cells (closed form)",
        probe: "half-length",
        exact: 1.5e-3,
        set: &[],
        explicit: &["run.step=50us", "run.duration=1", "body.0.drag=300"],
    },
    Case {
        scene: "cantilever",
        title: "cantilever, 15 × 3 × 3 cells (quadratic hexahedra of an independent code)",
        probe: "sag",
        exact: 34.43e-3,
        set: &["body.0.cells=[15,3,3]", "body.0.drag=45"],
        explicit: &["run.step=100us", "run.sample=10ms"],
    },
    Case {
        scene: "tube-pressure",
        title: "tube under pressure, 4 cells through the wall (Lamé)",
        probe: "lumen",
        exact: 1.966_666_666_666_666_8e-6,
        set: &[
            "body.0.around=24",
            "body.0.along=2",
            "body.0.layer.0.cells=4",
        ],
        explicit: &[
            "run.step=5us",
            "run.duration=0.2",
            "run.sample=1ms",
            "body.0.drag=2000",
        ],
    },
];

/// Materials beside one another: name, overrides.
const MATERIALS: [(&str, &[&str]); 4] = [
    (
        "springs, fitted",
        &[
            "body.0.material.0.law=springs",
            "body.0.material.0.form=fitted",
        ],
    ),
    (
        "springs, fitted, mirrored cells",
        &[
            "body.0.material.0.law=springs",
            "body.0.material.0.form=fitted",
            "body.0.split=mirrored",
        ],
    ),
    (
        "continuum, linear tetrahedra",
        &["body.0.material.0.discretisation=tetrahedra"],
    ),
    (
        "continuum, selective",
        &["body.0.material.0.discretisation=selective"],
    ),
];

/// Methods: name, overrides, and whether they take the steps of explicit ones.
const METHODS: [(&str, &str, bool); 3] = [
    (
        "velocity Verlet, lagged (3.19, 3.20)",
        "method={name=\"velocity-verlet-lagged\"}",
        true,
    ),
    ("Störmer–Verlet", "method={name=\"stoermer-verlet\"}", true),
    (
        "implicit Euler",
        "method={name=\"implicit-euler\",must_converge=false}",
        false,
    ),
];

/// Errors and costs of springs and of continua, on the same meshes.
fn beside_a_continuum(text: &mut String) -> Result<(), String> {
    let _ = writeln!(
        text,
        "\nSprings beside a continuum, at ν = 0.3, on the same meshes: error of what is measured at rest against the exact value, and CPU s to get there. Explicit methods take \
         steps of 50, 100 and 5 µs, and drag that brings them to rest."
    );
    for case in CASES {
        let _ = writeln!(
            text,
            "\n{}:\n\n| material | method | error | CPU s |\n|---|---|---|---|",
            case.title
        );
        for (material, of_material) in MATERIALS {
            for (method, of_method, explicit) in METHODS {
                let mut set: Vec<String> = case.set.iter().map(|&s| s.to_owned()).collect();
                set.push("run.end=time".into());
                set.push("run.rest_speed=".into());
                set.push(of_method.to_owned());
                set.extend(of_material.iter().map(|&s| s.to_owned()));
                if explicit {
                    set.extend(case.explicit.iter().map(|&s| s.to_owned()));
                }
                let document = simulate(case.scene, &set)?;
                let found = match document["diverged"].is_null() {
                    true => {
                        let value = probe(&document, case.probe).last().copied();
                        let error = value.map(|value| value / case.exact - 1.0);
                        error.map_or("–".into(), |e| format!("{:+.2} %", 100.0 * e))
                    }
                    false => "diverges".into(),
                };
                let cpu = document["cpu_s"].as_f64().unwrap_or(f64::NAN);
                let _ = writeln!(text, "| {material} | {method} | {found} | {cpu:.2} |");
            }
        }
    }
    Ok(())
}
