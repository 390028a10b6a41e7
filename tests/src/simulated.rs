//! Scenes run by the built program, and what they give.

use serde_json::Value;

/// Runs `microsim simulate SCENE --json` with these overrides; the error is its standard error.
pub fn simulate(scene: &str, set: &[String]) -> Result<Value, String> {
    let mut command = crate::command(["simulate", scene, "--json"]);
    for set in set {
        command.args(["--set", set]);
    }
    let output = command.output().map_err(|error| error.to_string())?;
    serde_json::from_slice(&output.stdout)
        .map_err(|_| String::from_utf8_lossy(&output.stderr).trim().to_owned())
}

/// A series of numbers.
///
/// # Panics
/// When the document has none at this path.
pub fn series(document: &Value, path: &str) -> Vec<f64> {
    let list = document.pointer(path).and_then(Value::as_array);
    let list = list.unwrap_or_else(|| panic!("no list at {path}"));
    list.iter().filter_map(Value::as_f64).collect()
}

/// The values of a probe over time.
///
/// # Panics
/// When the scene has no such probe.
pub fn probe(document: &Value, name: &str) -> Vec<f64> {
    let probes = document["probes"].as_array().expect("a list of probes");
    let index = probes.iter().position(|probe| probe["name"] == name);
    let index = index.unwrap_or_else(|| panic!("no probe {name}"));
    series(document, &format!("/probes/{index}/values"))
}

/// A list of vectors.
///
/// # Panics
/// When the document has none at this path.
pub fn vectors(document: &Value, path: &str) -> Vec<[f64; 3]> {
    let list = document.pointer(path).and_then(Value::as_array);
    let list = list.unwrap_or_else(|| panic!("no list at {path}"));
    let vector = |v: &Value| std::array::from_fn(|k| v[k].as_f64().unwrap_or(f64::NAN));
    list.iter().map(vector).collect()
}
