//! `microsim list`.

use crate::cli::{ListArgs, Place};
use crate::listing::files_in;
use crate::output::{Exit, Problem, complain, print, print_json};
use crate::session_file::installation;
use microsim_host::assemble::known_metrics;
use microsim_settings as settings;
use microsim_settings::Variant;
use serde_json::{Value, json};
use std::path::Path;

/// The names of those variants that are of a level.
fn variants_of(variants: &[Variant], level: u32) -> Vec<&str> {
    let of_level = variants.iter().filter(|of| of.level == level);
    of_level.map(|of| of.name.as_str()).collect()
}

/// Modules with their levels, scenes, and plugins.
pub fn list(place: &Place, args: &ListArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let mut modules = Vec::new();
    for folder in &installation.tree.modules {
        let manifest = &folder.manifest.settings;
        let (variants, errors) = installation.variants(folder);
        for error in errors {
            complain(error);
        }
        let mut levels = Vec::new();
        for (index, path) in folder.levels.iter().enumerate() {
            let vessels = installation.config.join("vessels");
            match settings::load_level_with(path, manifest, &known_metrics(), &vessels) {
                Ok(level) => levels.push(json!({
                    "level": index + 1,
                    "title": level.settings.title,
                    "summary": level.settings.summary,
                    "variants": variants_of(&variants, index as u32 + 1),
                })),
                Err(errors) => complain(errors),
            }
        }
        modules.push(json!({
            "name": manifest.name,
            "version": manifest.version,
            "title": manifest.title,
            "summary": manifest.summary,
            "plugins": manifest.plugins,
            "levels": levels,
        }));
    }
    let plugins: Vec<_> = installation
        .tree
        .plugins
        .iter()
        .map(|plugin| {
            let kind = plugin.document.value()["kind"].clone();
            let p = &plugin.settings;
            json!({ "name": p.name, "kind": kind, "version": p.version, "title": p.title, "summary": p.summary })
        })
        .collect();
    let mut scenes = Vec::new();
    for path in files_in(&installation.config.join("scenes"), "toml") {
        match settings::load_scene(&path, &[]) {
            Ok(scene) => scenes.push(json!({
                "name": path.file_stem().unwrap_or_default().to_string_lossy(),
                "title": scene.settings.title,
                "summary": scene.settings.summary,
            })),
            Err(errors) => complain(errors),
        }
    }
    let mut vessels = Vec::new();
    for path in files_in(&installation.config.join("vessels"), "toml") {
        match settings::load_vessel(&path) {
            Ok(vessel) => vessels.push(vessel_entry(&path, &vessel.settings)),
            Err(errors) => complain(errors),
        }
    }
    for complaint in &installation.complaints {
        complain(complaint);
    }
    if args.json {
        print_json(
            &json!({ "modules": modules, "scenes": scenes, "vessels": vessels, "plugins": plugins }),
        )?;
        return Ok(Exit::Done);
    }
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    print("Modules")?;
    for module in &modules {
        print(format!(
            "  {:<16} {}",
            text(&module["name"]),
            text(&module["summary"]["en"])
        ))?;
        for level in module["levels"].as_array().into_iter().flatten() {
            print(format!(
                "    level {}  {}",
                level["level"],
                text(&level["title"]["en"])
            ))?;
            let variants = level["variants"].as_array().into_iter().flatten();
            for variant in variants.map(text) {
                print(format!("      --variant {variant}"))?;
            }
        }
    }
    print("Scenes")?;
    for scene in &scenes {
        let (name, title) = (text(&scene["name"]), text(&scene["title"]["en"]));
        print(format!("  {name:<20} {title}"))?;
    }
    print("Vessels")?;
    for vessel in &vessels {
        let (name, title) = (text(&vessel["name"]), text(&vessel["title"]["en"]));
        let values = vessel["values"].as_array().into_iter().flatten();
        let judged = values.clone().filter(|value| value["basis"] == "judgement");
        print(format!(
            "  {name:<20} {title}: {} values, {} of them judgements",
            values.count(),
            judged.count()
        ))?;
    }
    print("Plugins")?;
    for plugin in &plugins {
        let (name, kind) = (text(&plugin["name"]), text(&plugin["kind"]));
        print(format!(
            "  {name:<16} {kind:<11} {}",
            text(&plugin["summary"]["en"])
        ))?;
    }
    Ok(Exit::Done)
}

/// A vessel with all its values, each in SI with its source.
fn vessel_entry(path: &Path, vessel: &settings::Vessel) -> Value {
    let values = vessel.values().into_iter().map(|(key, of)| {
        json!({ "key": key, "value": of.value, "source": of.source, "basis": of.basis })
    });
    json!({
        "name": path.file_stem().unwrap_or_default().to_string_lossy(),
        "title": vessel.title,
        "doc": vessel.doc,
        "values": values.collect::<Vec<_>>(),
    })
}
