//! A probe against a thin wall: does the wall stay before it?

use microsim_tests::simulated::{simulate, vectors};
use serde_json::Value;
use std::fmt::Write as _;

/// Radius of the probe \[m\], where its lowest point ends, and the height of its axis' lower end above that \[m\].
const RADIUS: f64 = 0.5e-3;
const END: f64 = -2.0e-3;

/// \[m/s\], and \[ms\].
const SPEEDS: [f64; 6] = [0.01, 0.05, 0.2, 0.5, 1.0, 2.0];
const TICKS: [u32; 5] = [1, 2, 4, 8, 16];

/// Displacement of the probe \[m\].
const WAY: f64 = 3.05e-3;

const METHODS: [(&str, &str); 4] = [
    (
        "quasi-static, 1 iteration",
        r#"{name="quasi-static",iterations=1,tolerance=1e-2,must_converge=false}"#,
    ),
    (
        "backward Euler, 1 iteration",
        r#"{name="implicit-euler",iterations=1,tolerance=1e-2,must_converge=false}"#,
    ),
    (
        "SDIRK2, 1 iteration",
        r#"{name="sdirk2",iterations=1,tolerance=1e-2,must_converge=false}"#,
    ),
    (
        "XPBD, 10 iterations",
        r#"{name="xpbd",substeps=1,iterations=10}"#,
    ),
];

/// How many nodes are not where they belong: in the probe, or behind its lowest point within its width; and whether its axis passes
/// through the wall.
fn wrong(document: &Value) -> (usize, bool) {
    let nodes = vectors(document, "/bodies/0/nodes");
    let centre = END + RADIUS;
    let slack = 0.01 * RADIUS;
    let off = |p: &[f64; 3]| (p[0] * p[0] + p[1] * p[1]).sqrt();
    let is_wrong = |p: &&[f64; 3]| {
        let within = off(p) < RADIUS - slack;
        let below = p[2] <= centre;
        let deep = (off(p).powi(2) + (p[2] - centre).powi(2)).sqrt() < RADIUS - slack;
        within && (!below || deep)
    };
    let surface = document["bodies"][0]["surface"]
        .as_array()
        .expect("triangles");
    let pierced = surface.iter().any(|triangle| {
        let corners: [[f64; 3]; 3] =
            std::array::from_fn(|k| nodes[triangle[k].as_u64().expect("an index") as usize]);
        on_axis(&corners).is_some_and(|z| z > END + slack)
    });
    (nodes.iter().filter(is_wrong).count(), pierced)
}

/// The height at which the axis of the probe, x = y = 0, passes through a triangle \[m\].
fn on_axis(corners: &[[f64; 3]; 3]) -> Option<f64> {
    let cross = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[1] - a[1] * b[0];
    let [a, b, c] = corners;
    let shares = [cross(b, c), cross(c, a), cross(a, b)];
    let sum: f64 = shares.iter().sum();
    let inside = sum != 0.0 && shares.iter().all(|share| share / sum >= 0.0);
    inside.then(|| {
        shares
            .iter()
            .zip(corners)
            .map(|(s, p)| s / sum * p[2])
            .sum()
    })
}

fn run(method: &str, speed: f64, tick: u32) -> Result<String, String> {
    let end = WAY / speed;
    let ticks = (end / (1e-3 * f64::from(tick))).ceil() + 1.0;
    let set = [
        format!("method={method}"),
        format!("run.step={tick}ms"),
        format!("run.sample={tick}ms"),
        format!("run.frame={tick}ms"),
        format!("run.duration={}ms", ticks * f64::from(tick)),
        format!(
            "tool.0.motion=[{{time=0,position=[0,0,0.00105]}},{{time={end},position=[0,0,-0.002]}}]"
        ),
    ];
    let mut set = Vec::from(set);
    if method.contains("xpbd") {
        // It needs a law that is a sum of constraints.
        set.push("body.0.material.0.law=neo-hookean-polynomial".to_owned());
    }
    let document = simulate("push-through", &set)?;
    if document["status"] != "ok" {
        return Ok("diverged".to_owned());
    }
    let (nodes, pierced) = wrong(&document);
    Ok(match (nodes, pierced) {
        (0, false) => "✓".to_owned(),
        (nodes, false) => format!("{nodes} nodes"),
        (nodes, true) => format!("pierced, {nodes} nodes"),
    })
}

/// Appends the section.
pub fn measure(text: &mut String) -> Result<(), String> {
    text.push_str(
        "\n## A tool against a thin wall\n\n`push-through`: 10 × 10 × 0.1 mm, held on two sides; the probe starts 1 mm before it and stops 2 mm behind its rest plane. ✓: every \
         node ends on the tool's far side, and the wall is not pierced. Columns: speed of the tool; rows: length of a tick.\n",
    );
    for (name, method) in METHODS {
        let _ = write!(text, "\n**{name}**\n\n| tick |");
        for speed in SPEEDS {
            let _ = write!(text, " {speed} m/s |");
        }
        text.push_str("\n|---|---|---|---|---|---|---|\n");
        for tick in TICKS {
            let _ = write!(text, "| {tick} ms |");
            for speed in SPEEDS {
                let _ = write!(text, " {} |", run(method, speed, tick)?);
            }
            text.push('\n');
        }
    }
    Ok(())
}
