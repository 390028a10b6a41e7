//! What is exact on each mesh: `tests/peers/exact.json`, read and made.
//!
//! Sag at rest by Newton's method to 1e-9 of the forces, first peak by Störmer–Verlet at 0.3 of its limit. Where the reference
//! has a value of independent codes, ours is compared with it.

use crate::beam::{Beam, MESHES, mesh};
use crate::measure::{Exact, first_peak};
use microsim_tests::repository;
use microsim_tissue::law::LawName;
use microsim_tissue::{Discretisation, Method, Newton, Serial, State, stability};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Laws of the engines, with their names in the reference; it does not have the last one.
const LAWS: [(LawName, &str); 4] = [
    (LawName::StVenantKirchhoff, "stvk"),
    (LawName::Corotational, "corotational"),
    (LawName::StableNeoHookean, "stable_neo_hookean"),
    (LawName::NeoHookeanPolynomial, "neo_hookean_polynomial"),
];

/// The exact beam stands in the table as this law and this mesh.
pub const BEAM: (&str, &str) = ("beam", "own");

fn path() -> PathBuf {
    repository().join("tests/peers/exact.json")
}

/// The exact values of a law on a mesh, by their names in the table.
pub fn read(law: &str, mesh: &str) -> Exact {
    let text = std::fs::read_to_string(path()).expect("tests/peers/exact.json");
    let table: Value = serde_json::from_str(&text).expect("JSON");
    let value = |key: &str| {
        table[law][mesh][key]
            .as_f64()
            .expect("a number in exact.json")
    };
    Exact {
        rest: value("rest"),
        peak: value("peak"),
        time: value("time"),
    }
}

/// How much less the meshes sag at rest than the exact beam, as shares of its sag.
pub fn of_meshes() -> [f64; 3] {
    let beam = read(BEAM.0, BEAM.1).rest;
    MESHES.map(|mesh| 1.0 - read(LawName::StVenantKirchhoff.name(), mesh).rest / beam)
}

/// The values of independent codes: sag at rest, height and time of the peak; what they have not is `None`.
fn reference() -> Result<impl Fn(&str, &str) -> [Option<f64>; 3], String> {
    let path = repository().join("tests/data/reference/cantilever.json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let table: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
    Ok(move |law: &str, mesh: &str| {
        let peak = format!("/dynamic_first_peak/linear_tetrahedra_{law}/{mesh}");
        let rest = match law {
            "beam" => "/static/quadratic_hexahedra/stvk_refinement_2_3_4/2".into(),
            _ => format!("/static/linear_tetrahedra_{law}/{mesh}"),
        };
        [rest, format!("{peak}/sag_m"), format!("{peak}/time_s")]
            .map(|pointer| table.pointer(&pointer).and_then(Value::as_f64))
    })
}

/// Computes all values, prints how far they are from the reference, and writes them.
pub fn write() -> Result<(), String> {
    let reference = reference()?;
    let mut table = json!({});
    for (law, key) in LAWS {
        for name in MESHES {
            let exact = compute(&Beam::new(&mesh(name), law, Discretisation::Tetrahedra));
            let values = [exact.rest, exact.peak, exact.time];
            for (i, value) in values.into_iter().enumerate() {
                let what = ["rest", "peak", "time"][i];
                table[law.name()][name][what] = json!(value);
                match reference(key, name)[i] {
                    Some(other) => println!(
                        "{key} {name} {what}: {value:.6}, {:+.3} % from the reference",
                        100.0 * (value / other - 1.0)
                    ),
                    None => println!("{key} {name} {what}: {value:.6}, not in the reference"),
                }
            }
        }
    }
    // The limit of fine meshes: linear tetrahedra converge with the square of the cells.
    let fine = &table[LawName::StVenantKirchhoff.name()];
    let limit = |key: &str| {
        let [m, l] = ["M", "L"].map(|name| fine[name][key].as_f64().unwrap_or(f64::NAN));
        let ratio = (60.0f64 / 35.0).powi(2);
        l + (l - m) / (ratio - 1.0)
    };
    // At rest quadratic hexahedra of an independent code say it better.
    let [Some(rest), ..] = reference(BEAM.0, BEAM.1) else {
        return Err("the reference has no sag of quadratic hexahedra".into());
    };
    println!(
        "beam at rest: {rest:.6}, linear tetrahedra tend to {:.6}",
        limit("rest")
    );
    table[BEAM.0][BEAM.1] = json!({ "rest": rest, "peak": limit("peak"), "time": limit("time") });
    let text = serde_json::to_string_pretty(&table).map_err(|e| e.to_string())?;
    std::fs::write(path(), text + "\n").map_err(|e| format!("{}: {e}", path().display()))
}

fn compute(beam: &Beam) -> Exact {
    let newton = Newton {
        iterations: 60,
        tolerance: 1e-9,
        must_converge: true,
    };
    let mut solver = Method::QuasiStatic(newton)
        .solver(&beam.model)
        .expect("a solver");
    let mut state = State::at_rest(&beam.model);
    solver
        .step(&beam.model, &mut state, &beam.control, &[], 1.0, &Serial)
        .expect("an equilibrium");
    let step = stability::stable_step(&beam.model, 0.3);
    let peak = first_peak(beam, &Method::StoermerVerlet, step).expect("a peak");
    Exact {
        rest: beam.sag(&state),
        peak: peak.height,
        time: peak.time,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reference has sags to 1 µm (0.004 %) and times to 0.1 ms (0.08 %), each half of that by rounding and as much again for
    /// the other code's own steps.
    #[test]
    fn what_the_reference_has_agrees_with_it() {
        let reference = reference().unwrap();
        let mut compared = 0;
        for (law, key) in LAWS {
            for mesh in MESHES {
                let ours = read(law.name(), mesh);
                let values = [ours.rest, ours.peak, ours.time];
                for (i, other) in reference(key, mesh).into_iter().enumerate() {
                    let Some(other) = other else { continue };
                    let rounding = [1e-6, 1e-6, 1e-4][i];
                    assert!((values[i] - other).abs() <= rounding, "{key} {mesh} {i}");
                    compared += 1;
                }
            }
        }
        assert!(compared >= 20, "{compared}");
        assert_eq!(
            reference(BEAM.0, BEAM.1)[0],
            Some(read(BEAM.0, BEAM.1).rest)
        );
    }
}
