//! Session files: reading them for a command, and making a report of one.

use crate::cli::Place;
use crate::output::Problem;
use microsim_host::assemble::Installation;
use microsim_host::plan::{PluginKind, RunPlan};
use microsim_host::record::Session;
use microsim_message::LocalText;
use microsim_report::{Report, ReportInput};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The installation that a command works with.
pub fn installation(place: &Place) -> Result<Installation, Problem> {
    let root = match &place.root {
        Some(root) => root.clone(),
        None => program_folder()?,
    };
    if root.to_str().is_none() {
        return Err(
            "the path of the installation is not UTF-8; move it, or name another with --root"
                .into(),
        );
    }
    if !root.join("plugins").is_dir() {
        return Err(format!(
            "no plugins/ below {}; say with --root where MicroSim is installed (`cargo xtask build` makes target/microsim)",
            root.display()
        )
        .into());
    }
    Ok(Installation::open(&root, place.config.as_deref())?)
}

/// The folder of this program.
pub fn program_folder() -> Result<PathBuf, Problem> {
    let program = std::env::current_exe().map_err(|e| format!("where this program lies: {e}"))?;
    Ok(program.parent().map(Path::to_path_buf).unwrap_or_default())
}

/// Whether a file is a session, whatever its name.
pub fn is_session(path: &Path) -> bool {
    let mut start = [0; microsim_session::MAGIC.len()];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == *microsim_session::MAGIC
}

/// Reads a session file.
pub fn read(path: &Path) -> Result<Session, Problem> {
    let bytes = std::fs::read(path).map_err(|e| format!("session {}: {e}", path.display()))?;
    Ok(Session::read(&bytes).map_err(|e| format!("session {}: {e}", path.display()))?)
}

/// The report of a session.
pub fn report_of(session: &Session, path: &Path) -> Report {
    let plan = &session.header.plan;
    let input = ReportInput {
        version: session.header.version.clone(),
        started: session.header.started,
        trainee: session.header.trainee.clone(),
        module: plan.module.clone(),
        module_title: plan.module_title.clone(),
        level: plan.level,
        level_title: plan.level_title.clone(),
        level_summary: plan.level_summary.clone(),
        seed: plan.seed,
        tick_s: plan.tick_ns as f64 * 1e-9,
        input: match &session.resumed {
            None => plan.input.clone(),
            Some(checkpoint) => format!(
                "{} (from {:.3} s on; what came before is in another session)",
                plan.input,
                checkpoint.tick as f64 * plan.tick_ns as f64 * 1e-9
            ),
        },
        tools: tool_names(plan),
        sharp: sharp_tools(plan),
        bodies: body_names(plan),
        synthetic: plan.synthetic.clone(),
        model_error: plan.model_error,
        realtime: session.header.realtime,
        without: plan.without.clone(),
        state_hash: session
            .end
            .as_ref()
            .map(|end| microsim_host::run::hex(&end.chain)),
        complaint: session.complaint.clone(),
        failures: session.failures.iter().map(ToString::to_string).collect(),
        late_ticks: session.end.as_ref().map_or(0, |end| end.late_ticks),
        session_file: path.display().to_string(),
        replay_command: format!("microsim replay {} --verify", shell_word(path)),
    };
    let ticks = session
        .ticks
        .iter()
        .map(|(tick, record)| (*tick, record.log.as_slice()));
    Report::build(&input, ticks)
}

/// A path as a word of a command line.
fn shell_word(path: &Path) -> String {
    let path = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+:=@%,".contains(c);
    match path.chars().all(plain) {
        true => path,
        false => format!("'{}'", path.replace('\'', r"'\''")),
    }
}

/// What the module of a run was told; nothing without one.
fn module_config(plan: &RunPlan) -> &Value {
    let module = plan.plugins.iter().find(|p| p.kind == PluginKind::Module);
    module.map_or(&Value::Null, |module| &module.setup.config)
}

/// A list of what the module was told.
fn listed<'a>(config: &'a Value, key: &str) -> &'a [Value] {
    config[key]
        .as_array()
        .map(Vec::as_slice)
        .unwrap_or_default()
}

/// The bodies of a run.
fn body_names(plan: &RunPlan) -> Vec<String> {
    let bodies = listed(module_config(plan), "bodies").iter();
    let names = bodies.filter_map(|body| body["name"].as_str());
    names.map(str::to_owned).collect()
}

/// The slots of tools with sharp jaws.
fn sharp_tools(plan: &RunPlan) -> BTreeSet<String> {
    let config = module_config(plan);
    let sharpness = |slot: &Value| {
        let model = slot["model"].as_str().unwrap_or_default();
        config["models"][model]["sharpness"].as_f64()
    };
    let slots = listed(config, "tools").iter();
    let sharp = slots.filter(|slot| sharpness(slot).is_some_and(|sharpness| sharpness > 0.0));
    let names = sharp.filter_map(|slot| slot["name"].as_str());
    names.map(str::to_owned).collect()
}

/// What the tools of a run are called: the titles of their models, with the slot where two have the same model.
fn tool_names(plan: &RunPlan) -> BTreeMap<String, LocalText> {
    let config = module_config(plan);
    let slots = listed(config, "tools");
    let named = slots.iter().filter_map(|slot| {
        let (name, model) = (slot["name"].as_str()?, slot["model"].as_str()?);
        let title = &config["models"][model]["title"];
        let same = slots.iter().filter(|other| other["model"] == model).count();
        let one = |language: &str| -> Option<String> {
            let title = title[language].as_str()?;
            Some(match same {
                1 => title.to_owned(),
                _ => format!("{title} ({name})"),
            })
        };
        let (de, en) = (one("de")?, one("en")?);
        Some((name.to_owned(), LocalText { de, en }))
    });
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::shell_word;
    use std::path::Path;

    #[test]
    fn a_path_is_one_word() {
        assert_eq!(shell_word(Path::new("a/b-1.session")), "a/b-1.session");
        assert_eq!(shell_word(Path::new("my run.session")), "'my run.session'");
        assert_eq!(shell_word(Path::new("it's")), r"'it'\''s'");
    }
}
