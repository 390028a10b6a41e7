//! From a module, a level and an input to the plan of a run: which plugins, which parts, why, and what each is given.
//!
//! Only what a scene needs: the run brings source and recorder (and renderer, if pictures are wanted), the module's
//! manifest names the other plugins, the level the objects, bodies and contacts. Nothing else is loaded.

pub use crate::assets::{ASSETS, Assets};
pub use crate::input::check_recording;
pub use crate::installation::{
    Guests, HASHES, Installation, Isolate, OF_STATION, Places, known_metrics,
};
pub use crate::installed::{check_library, locate};
pub use crate::request::{AssembleError, Input, Request};

use crate::input::{SourceSetup, source_setup};
use crate::installed::{RunSetup, planned, probe};
use crate::plan::{PlannedPart, PlannedPlugin, PluginKind, RunPlan};
use crate::request::refuse;
use microsim_message::{MarkerTracking, Message, SetupFile, TISSUE_ELEMENTS, config_value};
use microsim_settings as settings;
use microsim_vocabulary::LocalText;
use serde_json::Value;
use settings::{
    Calibration, DominantHand, Level, Loaded, Manifest, ModuleConfig, ModuleFolder, ObjectsConfig,
    PhysicsConfig, RecorderConfig, RendererConfig, ToolModels, Trainee, Translator,
    TranslatorConfig, translator_parts,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Plugin that writes sessions.
const RECORDER: &str = "recorder";
/// Plugin that draws.
const RENDERER: &str = "renderer";

/// Makes the plan.
pub fn assemble(installation: &Installation, request: &Request) -> Result<RunPlan, AssembleError> {
    let module = installation.module(&request.module)?;
    let level = installation.variant(&request.module, request.level, request.variant.as_deref())?;
    let planner = Planner {
        installation,
        request,
        module,
        models: tool_models(installation, &level.settings)?,
        assets: Assets::read(&asset_folders(installation, module), &level)?,
        level,
        source: source_setup(installation, request)?,
        calibration: calibration(installation)?,
    };
    planner.plan()
}

/// What was calibrated on this station.
pub fn calibration(installation: &Installation) -> Result<Calibration, AssembleError> {
    match &installation.calibration {
        Some(path) => Ok(settings::load_calibration(path)?),
        None => Ok(Calibration::default()),
    }
}

/// In what a recorded plan differs from the one that this installation would make for the same level: one line each, none if a verdict of
/// that plan is a verdict of the installed level. The input, and its devices, are the recorded ones.
pub fn differences(
    installation: &Installation,
    recorded: &RunPlan,
) -> Result<Vec<String>, AssembleError> {
    let given = |kind| recorded.plugins.iter().find(|p| p.kind == kind);
    let Some(source) = given(PluginKind::Source) else {
        return Ok(vec!["no source was recorded".into()]);
    };
    let translator = given(PluginKind::Translator);
    let translator = translator.and_then(|t| t.setup.configuration::<TranslatorConfig>().ok());
    // What was calibrated belongs to the input, as the devices do.
    let calibration = translator.as_ref().map(|config| config.calibration.clone());
    let (hand, mirrored) = hand_of(recorded);
    let devices = translator.map(|config| config.devices.into_iter().map(|d| d.name).collect());
    let request = Request {
        module: recorded.module.clone(),
        level: recorded.level,
        variant: recorded.variant.clone(),
        input: Input::Plugin(source.name.clone()),
        hand: Some(hand),
        seed: recorded.seed,
        without: recorded.without.clone(),
        pictures: false,
        session: std::path::PathBuf::new(),
    };
    let level = installation.variant(&request.module, request.level, request.variant.as_deref())?;
    let module = installation.module(&request.module)?;
    let planner = Planner {
        installation,
        request: &request,
        module,
        models: tool_models(installation, &level.settings)?,
        assets: Assets::read(&asset_folders(installation, module), &level)?,
        level,
        source: SourceSetup {
            plugin: source.name.clone(),
            why: String::new(),
            config: source.setup.config.clone(),
            files: Vec::new(),
            devices,
            note: None,
            synthetic: None,
            holds_instruments: mirrored,
        },
        calibration: calibration.unwrap_or_default(),
    };
    Ok(compare(recorded, &planner.plan()?))
}

fn compare(recorded: &RunPlan, installed: &RunPlan) -> Vec<String> {
    let mut found = Vec::new();
    let mut note = |same: bool, what: &str| {
        if !same {
            found.push(what.to_owned());
        }
    };
    note(
        recorded.tick_ns == installed.tick_ns,
        "the length of a tick",
    );
    note(recorded.steps == installed.steps, "the steps in a tick");
    note(
        recorded.module_title == installed.module_title,
        "the title of the module",
    );
    note(
        recorded.level_title == installed.level_title,
        "the title of the level",
    );
    note(
        recorded.level_summary == installed.level_summary,
        "what the level asks for",
    );
    note(
        recorded.model_error == installed.model_error,
        "the stated model error",
    );
    note(
        recorded.changed_files == installed.changed_files,
        "which files of the level are not as installed",
    );
    let computed = |plan: &RunPlan| -> Vec<PlannedPlugin> {
        let plugins = plan.plugins.iter().filter(|p| !p.kind.is_observer());
        plugins.cloned().collect()
    };
    let (recorded, installed) = (computed(recorded), computed(installed));
    let names = |plugins: &[PlannedPlugin]| -> Vec<String> {
        plugins.iter().map(|p| p.name.clone()).collect()
    };
    note(
        names(&recorded) == names(&installed),
        "which plugins compute",
    );
    for plugin in installed.iter().filter(|p| p.kind != PluginKind::Source) {
        if let Some(other) = recorded.iter().find(|p| p.name == plugin.name) {
            let what = format!("the settings of {}", plugin.name);
            note(other.setup == plugin.setup, &what);
        }
    }
    found
}

/// The shapes of the tools of a level.
fn tool_models(installation: &Installation, level: &Level) -> Result<ToolModels, AssembleError> {
    let mut models = ToolModels::new();
    for slot in &level.tool {
        let path = installation.tool_file(&slot.model);
        models.insert(slot.model.clone(), settings::load_tool(&path)?.settings);
    }
    Ok(models)
}

/// Where files of models and textures of a module are looked for.
pub fn asset_folders(installation: &Installation, module: &ModuleFolder) -> Vec<PathBuf> {
    let own = module.manifest.document.path().with_file_name(ASSETS);
    vec![own, installation.root.join(ASSETS)]
}

struct Planner<'a> {
    installation: &'a Installation,
    request: &'a Request,
    module: &'a ModuleFolder,
    level: Arc<Loaded<Level>>,
    models: ToolModels,
    assets: Assets,
    source: SourceSetup,
    calibration: Calibration,
}

impl Planner<'_> {
    fn plan(&self) -> Result<RunPlan, AssembleError> {
        let level = &self.level.settings;
        let manifest = &self.module.manifest.settings;
        let host = &self.installation.host;
        let tick_ns = level.clock.tick_us() * 1000;
        let physics = !self.request.leaves_out(PluginKind::Physics.name());
        let tools = level
            .tool
            .iter()
            .map(|slot| self.installation.tool_file(&slot.model));
        let vessels = level.body.iter().filter_map(|body| body.vessel.as_ref());
        let vessels = vessels.map(|name| self.installation.vessel_file(name));
        let changed_files = self.installation.changed(
            self.module,
            &self.level.document.path(),
            tools
                .chain(vessels)
                .chain(self.assets.paths.iter().cloned()),
        )?;
        let mut plan = RunPlan {
            module: self.request.module.clone(),
            module_title: manifest.title.clone(),
            level: self.request.level,
            variant: self.request.variant.clone(),
            level_title: title_of(&level.title, self.request.variant.as_deref()),
            level_summary: level.summary.clone(),
            seed: self.request.seed,
            tick_ns,
            steps: level.clock.steps,
            hash_every: hash_every(host, tick_ns),
            input: match &self.source.note {
                None => self.request.input.to_string(),
                Some(note) => format!("{} ({note})", self.request.input),
            },
            synthetic: self.source.synthetic.clone(),
            input_digest: self.source.digest(),
            queue_messages: host.queue.messages,
            queue_bytes: host.queue.bytes,
            model_error: level.model_error().filter(|_| physics),
            changed_files,
            without: self.request.without.clone(),
            plugins: Vec::new(),
            parts: settings::level_parts(level, &self.request.without)
                .into_iter()
                .map(PlannedPart::from)
                .collect(),
        };
        let run = RunSetup {
            seed: plan.seed,
            tick_ns,
            steps: plan.steps,
            level: plan.level,
        };
        for (plugin, why) in self.wanted()? {
            let Some((config, files)) = self.config(plugin.settings.kind)? else {
                continue;
            };
            let mut planned = planned(self.installation, plugin, why, run, config, files)?;
            if planned.kind == PluginKind::Translator {
                let (translator, config) = self.translator()?;
                if !config.markers.is_empty() {
                    planned.publishes.push(MarkerTracking::KIND.into());
                }
                let path = self.installation.calibration.as_deref();
                let parts = translator_parts(&translator, &config, path.unwrap_or(Path::new("")));
                plan.parts.extend(parts.into_iter().map(PlannedPart::from));
            }
            if plan.plugins.iter().any(|p| p.name == planned.name) {
                return refuse(format!("plugin \"{}\" would be loaded twice", planned.name));
            }
            plan.plugins.push(planned);
        }
        plan.plugins
            .sort_by(|a, b| (a.kind, &a.name).cmp(&(b.kind, &b.name)));
        Ok(plan)
    }

    /// The plugins of the run, and why.
    fn wanted(&self) -> Result<Vec<(&Loaded<Manifest>, String)>, AssembleError> {
        let source = self.installation.plugin(&self.source.plugin)?;
        let kind = source.settings.kind;
        if kind != PluginKind::Source {
            return refuse(format!(
                "plugin \"{}\" ({}): it is of kind `{}`, an input has to be a `source`",
                source.settings.name,
                source.document.path().display(),
                kind.name()
            ));
        }
        let mut wanted = vec![
            (source, self.source.why.clone()),
            (
                self.installation.plugin(RECORDER)?,
                "every run is recorded".to_owned(),
            ),
            (
                &self.module.manifest,
                "the operator asked for this module".to_owned(),
            ),
        ];
        if self.request.pictures {
            let renderer = self.installation.plugin(RENDERER)?;
            wanted.push((renderer, "pictures are wanted".to_owned()));
        }
        let manifest = &self.module.manifest.settings;
        for name in &manifest.plugins {
            let plugin = self.installation.plugin(name)?;
            if !self.request.leaves_out(plugin.settings.kind.name()) {
                wanted.push((plugin, format!("module \"{}\" uses it", manifest.name)));
            }
        }
        Ok(wanted)
    }

    /// What a kind of plugin is given, and the files that it names; `None` where the level has nothing for it.
    fn config(&self, kind: PluginKind) -> Result<Option<(Value, Vec<SetupFile>)>, AssembleError> {
        let level = &self.level.settings;
        let config = match kind {
            PluginKind::Source => {
                return Ok(Some((
                    self.source.config.clone(),
                    self.source.files.clone(),
                )));
            }
            PluginKind::Translator => {
                let (_, config) = self.translator()?;
                config_value(&config)
            }
            PluginKind::Physics => {
                let Some(config) = PhysicsConfig::new(level, &self.models) else {
                    return Ok(None);
                };
                let subscribed = &self.module.manifest.settings.subscribes;
                let config = PhysicsConfig {
                    elements: subscribed.iter().any(|kind| kind == TISSUE_ELEMENTS),
                    friction: !self.request.leaves_out("friction"),
                    cutting: !self.request.leaves_out("lonor"),
                    ..config
                };
                return Ok(Some((config_value(&config), self.level_files()?)));
            }
            PluginKind::Module => {
                let manifest = &self.module.manifest.settings;
                config_value(&ModuleConfig::new(level, manifest, &self.models))
            }
            PluginKind::Objects => config_value(&ObjectsConfig::new(level, self.assets.digests())),
            PluginKind::Renderer => {
                let size = &self.installation.host.picture;
                let size = (size.width, size.height);
                let mut config = RendererConfig::new(level, &self.models, size);
                config.caption = caption(self.request.variant.as_deref());
                let (_, translator) = self.translator()?;
                config.mirrored = translator.dominant == DominantHand::Left;
                return Ok(Some((config_value(&config), self.assets.files.clone())));
            }
            PluginKind::Recorder => config_value(&RecorderConfig {
                path: self.request.session.clone(),
            }),
        };
        Ok(Some((config, Vec::new())))
    }

    /// The translator's file, and what the translator is given of it.
    fn translator(&self) -> Result<(Translator, TranslatorConfig), AssembleError> {
        let path = self.installation.setting("translator.toml");
        let translator = settings::load_translator(&path)?.settings;
        let devices = self.source.devices.as_deref();
        let tools = &self.level.settings.tool;
        let trainee = Trainee {
            dominant: self.request.hand.unwrap_or(translator.dominant),
            holds_instruments: self.source.holds_instruments,
        };
        let config = TranslatorConfig::new(&translator, &self.calibration, devices, tools, trainee);
        Ok((translator, config))
    }

    /// The files that the level names, under the names by which it does.
    fn level_files(&self) -> Result<Vec<SetupFile>, AssembleError> {
        let folder = self.module.level_folder();
        let mut files: Vec<SetupFile> = Vec::new();
        for (key, name) in self.level.settings.files() {
            if files.iter().any(|file| file.name == name) {
                continue;
            }
            let bytes = settings::read_regular(&folder.join(&name)).map_err(|e| {
                let found = format!("`{name}`, which cannot be read ({e})");
                let error = self.level.document.error_at(&key, &found, "a mesh file");
                AssembleError(error.to_string())
            })?;
            files.push(SetupFile { name, bytes });
        }
        Ok(files)
    }
}

fn hash_every(host: &settings::Host, tick_ns: u64) -> u64 {
    let ticks = host.session.state_hash_every * 1e9 / tick_ns as f64;
    (ticks.round() as u64).max(1)
}

/// The title of a level, with the variant of it that is run.
pub fn title_of(title: &LocalText, variant: Option<&str>) -> LocalText {
    match variant {
        None => title.clone(),
        Some(name) => LocalText::new(
            format!("{} (Variante {name})", title.de),
            format!("{} (variant {name})", title.en),
        ),
    }
}

/// The renderer for a session that was recorded without one: it looks at the level as it is installed now, at the level itself where its variant is no longer there. Pictures are
/// as wide and high as `size` \[px\], else as the host's configuration.
pub fn renderer_for(
    installation: &Installation,
    plan: &RunPlan,
    size: Option<u32>,
) -> Result<PlannedPlugin, AssembleError> {
    let variant = plan.variant.as_deref();
    let level = match installation.variant(&plan.module, plan.level, variant) {
        Err(why) if variant.is_some() => {
            tracing::warn!("pictures look as the level itself does: {why}");
            installation.variant(&plan.module, plan.level, None)?
        }
        level => level?,
    };
    let models = tool_models(installation, &level.settings)?;
    let picture = &installation.host.picture;
    let size = size.map_or((picture.width, picture.height), |size| (size, size));
    let mut config = RendererConfig::new(&level.settings, &models, size);
    config.caption = caption(plan.variant.as_deref());
    config.mirrored = hand_of(plan).0 == DominantHand::Left;
    let module = installation.module(&plan.module)?;
    let assets = Assets::read(&asset_folders(installation, module), &level)?;
    let run = RunSetup {
        seed: plan.seed,
        tick_ns: plan.tick_ns,
        steps: plan.steps,
        level: plan.level,
    };
    let why = "pictures of the replay are wanted".into();
    let renderer = installation.plugin(RENDERER)?;
    planned(
        installation,
        renderer,
        why,
        run,
        config_value(&config),
        assets.files,
    )
}

/// The dominant hand of whom a plan was made for, and whether poses of devices are mirrored for it.
pub fn hand_of(plan: &RunPlan) -> (DominantHand, bool) {
    let mut plugins = plan.plugins.iter();
    let translator = plugins.find(|plugin| plugin.kind == PluginKind::Translator);
    let config = translator.and_then(|t| t.setup.configuration::<TranslatorConfig>().ok());
    config.map_or_else(Default::default, |config| {
        (config.dominant, config.mirrored)
    })
}

/// What pictures of a variant have in their corner, as they look like those of its level.
fn caption(variant: Option<&str>) -> Option<String> {
    variant.map(|name| format!("variant {name}"))
}

/// Whether pictures work on this machine; otherwise why not.
pub fn probe_renderer(installation: &Installation) -> Result<(), String> {
    let config = RendererConfig {
        view: settings::View {
            field: 0.02,
            centre: [0.0; 3],
            tilt: 0.0,
        },
        models: ToolModels::new(),
        bodies: Vec::new(),
        width: 16,
        height: 16,
        caption: None,
        mirrored: false,
        views: Vec::new(),
    };
    probe(installation, RENDERER, config_value(&config), Vec::new())
}
