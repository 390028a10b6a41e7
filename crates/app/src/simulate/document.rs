//! The JSON document of a run.

use crate::scene_file::SceneFile;
use microsim_scene::{ContactPartner, End, Runner, Scene};
use microsim_session::digest;
use microsim_settings as settings;
use nalgebra::Vector3;
use serde_json::{Map, Value, json};
use settings::Override;
use std::path::PathBuf;

/// What the document holds besides the run itself.
#[derive(Debug)]
pub struct Result {
    /// The scene as it was asked for.
    pub given: PathBuf,
    /// The values that took the place of those of the file.
    pub set: Vec<Override>,
    /// What was left out.
    pub without: Vec<String>,
    /// CPU time of all threads from the first step to the last \[s\].
    pub cpu_s: f64,
    /// A chain over the physics digests of all samples.
    pub physics_digest: [u8; 32],
    /// Threads.
    pub threads: u16,
}

/// Everything about a run.
pub fn document(file: &SceneFile, result: &Result) -> Value {
    let runner = &file.runner;
    let (scene, settings) = (runner.scene(), &file.loaded.settings);
    let (status, diverged) = match runner.end() {
        Some(End::Diverged(diverged)) => (
            "diverged",
            json!({
                "step": file.step_of(diverged),
                "body": diverged.body_name,
                "time": diverged.time,
                "what": diverged.what.to_string(),
            }),
        ),
        _ if runner.energy_growth().is_some() => ("gains-energy", Value::Null),
        _ if file.restless() => ("not-at-rest", Value::Null),
        _ => ("ok", Value::Null),
    };
    let mut warnings = file.warnings.clone();
    if file.restless() {
        warnings.push(file.restless_sentence());
    }
    warnings.extend(file.run_sentences());
    let bodies = (0..scene.body_count()).map(|body| of_body(file, body));
    let series = runner.series();
    json!({
        "scene": result.given,
        "set": result.set.iter().map(Override::text).collect::<Vec<_>>(),
        "without": result.without,
        "run": file.loaded.document.value()["run"],
        "method": scene.method().name(),
        "method_settings": file.loaded.document.value()["method"],
        "dt": runner.step(),
        "steps": runner.steps(),
        "simulated_s": scene.time(),
        "cpu_s": result.cpu_s,
        "threads": result.threads,
        "status": status,
        "diverged": diverged,
        "came_to_rest": runner.end() == Some(&End::Rest),
        "recoveries": runner.recoveries().iter().map(|(time, recovery)| json!({
            "time": time,
            "body": scene.body(recovery.body).name(),
            "what": recovery.what.to_string(),
            "factor": recovery.factor,
        })).collect::<Vec<_>>(),
        "most_substeps": runner.remarks().most_substeps,
        "unconverged": runner.remarks().unconverged,
        "stiffened": runner.remarks().stiffened.map(|stiffened| json!({
            "ticks": stiffened.ticks,
            "since": stiffened.since,
            "shortest_step": stiffened.shortest_step,
        })),
        "jumps": runner.remarks().jumps.iter().map(|(time, tool)| json!({
            "time": time,
            "tool": scene.tool_name(*tool),
        })).collect::<Vec<_>>(),
        "warnings": warnings,
        "physics_digest": hex(&result.physics_digest),
        "state_hash": hex(&digest([scene.save().as_slice()])),
        "bodies": bodies.collect::<Vec<_>>(),
        "series": series_of(runner),
        "contacts": contacts(runner),
        "crossings": crossings(scene),
        "cut": cut(runner),
        "probes": settings.probe.iter().zip(&series.probes).map(|(probe, values)| json!({
            "name": probe.name,
            "body": probe.body,
            "unit": probe.quantity.unit().symbol(),
            "values": values,
        })).collect::<Vec<_>>(),
        "expectations": expectations(runner, settings),
    })
}

fn series_of(runner: &Runner) -> Value {
    let series = runner.series();
    let mut entries = Map::new();
    for (key, value) in [
        ("t", json!(series.time)),
        ("kinetic_J", json!(series.kinetic)),
        ("elastic_J", json!(series.elastic)),
        ("dissipated_J", json!(series.dissipated)),
        ("momentum_kg_m_s", json!(series.momentum)),
    ] {
        entries.insert(key.to_owned(), value);
    }
    if runner.scene().pair_count() > 0 {
        entries.insert("inside_share".to_owned(), json!(series.inside_fraction));
        entries.insert("max_depth_m".to_owned(), json!(series.max_depth));
    }
    Value::Object(entries)
}

/// The forces between two that touch.
fn contacts(runner: &Runner) -> Vec<Value> {
    let scene = runner.scene();
    let series = runner.series().contacts.iter().enumerate();
    let entries = series.map(|(pair, series)| {
        let (body, with) = scene.pair(pair);
        let kind = match with {
            ContactPartner::Tool(_) => "tool",
            ContactPartner::Obstacle(_) => "rigid",
            ContactPartner::Body(_) => "body",
            ContactPartner::Itself => "self",
        };
        json!({
            "body": scene.body(body).name(),
            "with": scene.partner_name(with),
            "kind": kind,
            "force_N": series.force,
            "peak_N": series.peak,
            "over_limit_s": series.over_limit,
            "stick_share": series.stick_fraction,
            "grip_N": series.grip,
            "grip_pressure_Pa": series.grip_pressure,
        })
    });
    entries.collect()
}

/// What was cut; nothing of a scene that cuts nothing.
fn cut(runner: &Runner) -> Value {
    let scene = runner.scene();
    if !scene.has_cuts() {
        return Value::Null;
    }
    let bodies = || 0..scene.body_count();
    let tallies = || bodies().map(|body| scene.body(body).cut_tally());
    let mass: f64 = bodies().flat_map(|body| scene.body(body).masses()).sum();
    let start_mass: f64 = bodies().map(|body| scene.body(body).uncut().1).sum();
    let remarks = runner.remarks();
    let named = |body, tool: Option<usize>| {
        let tool = tool.map(|tool| scene.tool_name(tool));
        json!({"body": scene.body(body).name(), "tool": tool})
    };
    json!({
        "divided": tallies().map(|tally| tally.divided).sum::<u64>(),
        "rejected": tallies().map(|tally| tally.rejected).sum::<u64>(),
        "lost_volume_m3": tallies().map(|tally| tally.lost_volume).sum::<f64>(),
        "merged_nodes": tallies().map(|tally| tally.merged).sum::<u64>(),
        "lost_mass_kg": start_mass - mass,
        "added_inertia_kg": bodies().flat_map(|body| scene.body(body).model().added_inertia()).sum::<f64>(),
        "start_volume_m3": bodies().map(|body| scene.body(body).uncut().0).sum::<f64>(),
        "start_mass_kg": start_mass,
        "cuts": remarks.cuts.iter().map(|(time, cut)| json!({
            "time": time,
            "of": named(cut.body, cut.tool),
            "divided": cut.divided,
            "area_m2": cut.area,
            "rest_centroid": cut.rest_centroid,
            "rest_normal": cut.rest_normal,
            "centroid": cut.centroid,
            "normal": cut.normal,
            "force_N": cut.force_n,
            "pieces": cut.pieces,
        })).collect::<Vec<_>>(),
        "rejections": remarks.rejected.iter().map(|(time, cut)| json!({
            "time": time,
            "of": named(cut.body, Some(cut.tool)),
            "why": cut.why,
        })).collect::<Vec<_>>(),
    })
}

/// Edges of surfaces through triangles of other bodies that they touch, now.
fn crossings(scene: &Scene) -> usize {
    let pairs = (0..scene.pair_count()).map(|pair| match scene.pair(pair) {
        (body, ContactPartner::Body(other)) => scene.crossings(body, other),
        _ => 0,
    });
    pairs.sum()
}

fn of_body(file: &SceneFile, body: usize) -> Value {
    let scene = file.runner.scene();
    let described = &file.loaded.document.value()["body"][body];
    let energies = scene.body(body).energies();
    json!({
        "name": scene.body(body).name(),
        "material": described["material"],
        "colour": described["colour"],
        "finish": described["finish"],
        "rest": points(scene.body(body).rest_positions()),
        "start": points(scene.body(body).start_positions()),
        "nodes": points(scene.body(body).positions()),
        "velocities": points(scene.body(body).velocities()),
        "tets": scene.body(body).tets(),
        "regions": scene.body(body).mesh().regions,
        "surface": scene.body(body).surface().triangles,
        "inner": scene.body(body).opened(),
        "piece": scene.body(body).pieces(),
        "masses": scene.body(body).masses(),
        "clamped": scene.body(body).model().clamped(),
        "volume": scene.body(body).volume(),
        "energy": {
            "kinetic": energies.kinetic,
            "length": energies.length,
            "area": energies.area,
            "volume": energies.volume,
            "strain": energies.strain,
            "coupling": energies.coupling,
            "dissipated": energies.dissipated,
        },
    })
}

fn expectations(runner: &Runner, settings: &settings::Scene) -> Vec<Value> {
    let verdicts = runner.verdicts();
    let verdicts = verdicts.iter().map(|verdict| {
        let expect = &settings.expect[verdict.expect];
        let probe = settings
            .probe
            .iter()
            .find(|probe| probe.name == expect.probe);
        let unit = probe.map(|probe| expect.what.unit(probe.quantity));
        let mut entry = Map::new();
        for (key, value) in [
            ("probe", json!(expect.probe)),
            ("what", json!(expect.what.name())),
            ("unit", json!(unit.map(|unit| unit.symbol()))),
            ("expected", json!(expect.value)),
            ("scale", json!(expect.scale.unwrap_or(expect.value.abs()))),
            ("found", json!(verdict.found)),
            ("error", json!(verdict.error)),
            ("tolerance", json!(expect.tolerance)),
            ("met", json!(verdict.met)),
            ("regression", json!(expect.regression)),
            ("source", json!(expect.source)),
        ] {
            entry.insert(key.to_owned(), value);
        }
        Value::Object(entry)
    });
    verdicts.collect()
}

fn points(points: &[Vector3<f64>]) -> Vec<[f64; 3]> {
    points.iter().map(|p| [p.x, p.y, p.z]).collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
