//! Section 4.3, figures 4.14 to 4.16: five bodies fall on one another, with each response to contact.

use microsim_tests::simulated::{series, simulate};
use std::fmt::Write as _;

/// Bodies and pairs of the scene `five-bodies`.
const BODIES: usize = 5;
const PAIRS: usize = 16;

/// Simulated time \[s\], and from when on all should rest.
const DURATION: f64 = 2.0;
const AT_REST: f64 = 1.5;

/// Young's modulus times the mean edge of the blocks \[N/m\]: a penalty as stiff as what it presses on.
const STIFFNESS: f64 = 60.0;

/// A response, as it is named in the page, with its keys of a pair.
type Response = (&'static str, Option<f64>, &'static [&'static str]);

/// The order of the dissertation's story.
const RESPONSES: [Response; 6] = [
    (
        "penalty, nearest surface point (figure 4.15)",
        Some(STIFFNESS),
        &["response=penalty", "depth=nearest"],
    ),
    (
        "penalty ten times as stiff, nearest surface point",
        Some(10.0 * STIFFNESS),
        &["response=penalty", "depth=nearest"],
    ),
    (
        "penalty, consistent depth",
        Some(STIFFNESS),
        &["response=penalty", "depth=consistent"],
    ),
    (
        "penalty ten times as stiff, consistent depth",
        Some(10.0 * STIFFNESS),
        &["response=penalty", "depth=consistent"],
    ),
    (
        "target force, consistent depth (figure 4.16)",
        None,
        &["response=target-force", "depth=consistent"],
    ),
    (
        "constraints, along the whole step",
        None,
        &["response=constraint"],
    ),
];

/// The overrides of a run.
fn settings(stiffness: Option<f64>, keys: &[&str]) -> Vec<String> {
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
pub fn measure(text: &mut String) -> Result<Vec<(&'static str, String)>, String> {
    let _ = writeln!(
        text,
        "\n## 4.3: response\n\nThe scene `five-bodies` with the dissertation's integrator (`velocity-verlet-lagged`, steps of 0.1 ms), without friction, {DURATION} s. A penalty is a spring to the surface half-way between, \
         of {STIFFNESS} N/m (Young's modulus times an edge). Nodes inside are found after the step, as in the dissertation, but for constraints, which see the whole step, and edges. The dissertation states of penalties that the run \
         breaks off, with consistent depth that it lives and vibrates at times, and of target forces that they hold but for edges. At rest: mean kinetic energy after {AT_REST} s, over the \
         weight of all times a tenth of an edge (0.4 mm).\n\n| response | lives | deepest | nodes inside, largest share | at rest | CPU s per s |\n|---|---|---|---|---|---|"
    );
    for (name, stiffness, keys) in RESPONSES {
        let document = simulate("five-bodies", &settings(stiffness, keys))?;
        let number = |path: &str| document.pointer(path).and_then(serde_json::Value::as_f64);
        let lives = match number("/diverged/time") {
            Some(time) => format!("{time:.3} s"),
            None => "all".into(),
        };
        let times = series(&document, "/series/t");
        let late = times.iter().position(|t| *t >= AT_REST);
        let largest = |path: &str| series(&document, path).into_iter().fold(0.0, f64::max);
        let weight = masses(&document) * 9.81;
        let rest = late.map_or("–".into(), |from| {
            let kinetic = &series(&document, "/series/kinetic_J")[from..];
            let mean = kinetic.iter().sum::<f64>() / kinetic.len() as f64;
            format!("{:.2e}", mean / (weight * 0.4e-3))
        });
        let cost = number("/cpu_s").zip(number("/simulated_s"));
        let _ = writeln!(
            text,
            "| {name} | {lives} | {:.2} mm | {:.1} % | {rest} | {} |",
            1e3 * largest("/series/max_depth_m"),
            100.0 * largest("/series/inside_share"),
            cost.map_or("–".into(), |(cpu, simulated)| format!(
                "{:.1}",
                cpu / simulated
            )),
        );
    }
    Ok(Vec::new())
}

/// Mass of all bodies \[kg\].
fn masses(document: &serde_json::Value) -> f64 {
    (0..BODIES)
        .flat_map(|body| series(document, &format!("/bodies/{body}/masses")))
        .sum()
}
