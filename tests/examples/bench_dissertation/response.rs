//! Section 4.3, figures 4.14 to 4.16: five bodies fall on one another, with each response to contact.

use microsim_tests::simulated::{series, simulate};
use serde_json::Value;
use std::fmt::Write as _;

/// Bodies and pairs of the scene `five-bodies`.
const BODIES: usize = 5;
const PAIRS: usize = 16;

/// Simulated time \[s\], and from when on all should rest.
pub const DURATION: f64 = 2.0;
const AT_REST: f64 = 1.5;

/// Stiffnesses of penalties \[N/m\]: Young's modulus times the mean edge of the blocks, as stiff as what is pressed on, and more.
const STIFFNESSES: [f64; 3] = [60.0, 600.0, 6000.0];

/// Penalties in the order of the dissertation, by their depth.
const PENALTIES: [(&str, &str); 2] = [
    ("nearest surface point", "depth=nearest"),
    ("consistent depth", "depth=consistent"),
];

/// What it ends with, and ours.
const OTHERS: [(&str, &[&str]); 3] = [
    (
        "target force, nearest surface point",
        &["response=target-force", "depth=nearest"],
    ),
    (
        "target force, consistent depth (figure 4.16)",
        &["response=target-force", "depth=consistent"],
    ),
    (
        "constraints, along the whole step",
        &["response=constraint"],
    ),
];

/// The overrides of a run.
pub fn settings(stiffness: Option<f64>, keys: &[&str]) -> Vec<String> {
    let mut set = vec![
        "method={name=\"velocity-verlet-lagged\"}".to_owned(),
        "run.step=0.1ms".to_owned(),
        "run.end=time".to_owned(),
        "run.rest_speed=".to_owned(),
        "run.containment=false".to_owned(),
        format!("run.duration={DURATION}"),
    ];
    // Explicit steps would have to follow a longer relaxation; drag takes its place.
    for body in 0..BODIES {
        set.push(format!("body.{body}.material.0.relaxation_time=0.1ms"));
        set.push(format!("body.{body}.drag=5"));
    }
    for pair in 0..PAIRS {
        set.push(format!("contact.{pair}.friction=0"));
        set.extend(keys.iter().map(|key| format!("contact.{pair}.{key}")));
        set.extend(stiffness.map(|stiffness| format!("contact.{pair}.stiffness={stiffness}")));
    }
    set
}

/// Measures and describes it.
pub fn measure(text: &mut String) -> Result<crate::Drawings, String> {
    let _ = writeln!(
        text,
        "\n## 4.3: response\n\nThe scene `five-bodies` with the dissertation's integrator (`velocity-verlet-lagged`, steps of 0.1 ms), without friction, {DURATION} s. A penalty is a spring to the surface midway between; \
         60 N/m is Young's modulus times an edge. Nodes inside are found after the step, as in the dissertation, but for constraints, which see the whole step, and edges. The dissertation reports that with penalties and the \
         nearest surface point the run breaks off (figure 4.15), that with consistent depth it goes on and vibrates at times, and that target forces hold (figure 4.16) but for edges that cross. Deepest: of any node, at any time. \
         Crossings: edges through faces of the other surface at the end. At rest: mean kinetic energy after {AT_REST} s, over the weight of all times a tenth of an edge (0.4 mm).\n\n\
         | response | lives | deepest | nodes inside, largest share | crossings | at rest | CPU s per s |\n|---|---|---|---|---|---|---|"
    );
    for (depth, key) in PENALTIES {
        for stiffness in STIFFNESSES {
            let name = format!("penalty of {stiffness} N/m, {depth}");
            let set = settings(Some(stiffness), &["response=penalty", key]);
            row(text, &name, &set)?;
        }
    }
    for (name, keys) in OTHERS {
        row(text, name, &settings(None, keys))?;
    }
    Ok(Vec::new())
}

/// Runs the scene and adds a row.
fn row(text: &mut String, name: &str, set: &[String]) -> Result<(), String> {
    let document = simulate("five-bodies", set)?;
    let number = |path: &str| document.pointer(path).and_then(Value::as_f64);
    let lives = match number("/diverged/time") {
        Some(time) => format!("{time:.2} s"),
        None => "to its end".into(),
    };
    let largest = |path: &str| series(&document, path).into_iter().fold(0.0, f64::max);
    let times = series(&document, "/series/t");
    let late = times.iter().position(|t| *t >= AT_REST);
    let rest = late.map_or("–".into(), |from| {
        let kinetic = &series(&document, "/series/kinetic_J")[from..];
        let mean = kinetic.iter().sum::<f64>() / kinetic.len() as f64;
        format!("{:.1e}", mean / (masses(&document) * 9.81 * 0.4e-3))
    });
    let crossings = document["crossings"].as_u64().unwrap_or_default();
    let cost = number("/cpu_s").zip(number("/simulated_s"));
    let _ = writeln!(
        text,
        "| {name} | {lives} | {:.2} mm | {:.1} % | {crossings} | {rest} | {} |",
        1e3 * largest("/series/max_depth_m"),
        100.0 * largest("/series/inside_share"),
        cost.map_or("–".into(), |(cpu, simulated)| format!(
            "{:.1}",
            cpu / simulated
        )),
    );
    Ok(())
}

/// Mass of all bodies \[kg\].
fn masses(document: &Value) -> f64 {
    (0..BODIES)
        .flat_map(|body| series(document, &format!("/bodies/{body}/masses")))
        .sum()
}
