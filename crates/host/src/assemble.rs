//! From a module, a level and an input to the plan of a run: which plugins, which parts, why, and what each is told.
//!
//! Only what a scene needs: the run brings source and recorder (and renderer, if pictures are wanted), the module's
//! manifest names the other plugins, the level the objects, bodies and contacts. Nothing else is loaded.

pub use crate::input::check_recording;
use crate::input::{SourceSetup, source_setup};
pub use crate::installation::{Installation, known_metrics};
use crate::loader::file_hash;
use crate::plan::{OwnKind, PlannedPart, PlannedPlugin, PluginKind, RunPlan};
use crate::reason;
use abi_stable::std_types::{ROption, RSlice};
use microsim_message::{LocalText, Setup, SetupFile, encode};
use microsim_settings as settings;
use serde_json::{Value, json};
use settings::{ConfigErrors, Loaded, Manifest};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// Plugin that writes sessions.
const RECORDER: &str = "recorder";
/// Plugin that draws.
const RENDERER: &str = "renderer";

/// Why there is no plan: one or several sentences, each with its file and line where it has one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssembleError(pub String);

impl fmt::Display for AssembleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for AssembleError {}

impl From<ConfigErrors> for AssembleError {
    fn from(errors: ConfigErrors) -> Self {
        Self(errors.to_string())
    }
}

pub(crate) fn refuse<T>(text: impl Into<String>) -> Result<T, AssembleError> {
    Err(AssembleError(text.into()))
}

/// Where the motion comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// A scripted trainee.
    Script(PathBuf),
    /// A CSV file with its TOML, or a session.
    Recording(PathBuf),
    /// A source plugin by its name, without a file.
    Plugin(String),
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Script(path) => write!(f, "script:{}", path.display()),
            Self::Recording(path) => write!(f, "recording:{}", path.display()),
            Self::Plugin(name) => write!(f, "plugin:{name}"),
        }
    }
}

/// What an operator asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Module.
    pub module: String,
    /// Level, from 1.
    pub level: u32,
    /// Motion.
    pub input: Input,
    /// Seed.
    pub seed: u64,
    /// What to leave out: kinds of plugins (`physics`), `friction`, or `lonor`, all cutting; such a run is no result.
    pub without: Vec<String>,
    /// Whether pictures are wanted.
    pub pictures: bool,
    /// The session file to write.
    pub session: PathBuf,
}

/// Makes the plan.
pub fn assemble(installation: &Installation, request: &Request) -> Result<RunPlan, AssembleError> {
    let folder = installation.module(&request.module)?;
    let manifest = &folder.manifest.settings;
    let level = installation.level(&request.module, request.level)?;
    let source = source_setup(installation, request)?;
    let models = tool_models(installation, &level.settings)?;
    let plan = Planner {
        installation,
        request,
        level: &level,
        manifest,
        models,
        source: &source,
    };
    plan.plan(folder)
}

fn tool_models(
    installation: &Installation,
    level: &settings::Level,
) -> Result<BTreeMap<String, Value>, AssembleError> {
    let mut models = BTreeMap::new();
    for slot in &level.tool {
        let path = installation
            .config
            .join("tools")
            .join(format!("{}.toml", slot.model));
        models.insert(
            slot.model.clone(),
            settings::load_tool(&path)?.document.value().clone(),
        );
    }
    Ok(models)
}

struct Planner<'a> {
    installation: &'a Installation,
    request: &'a Request,
    level: &'a Loaded<settings::Level>,
    manifest: &'a Manifest,
    models: BTreeMap<String, Value>,
    source: &'a SourceSetup,
}

fn text(text: &settings::LocalText) -> LocalText {
    LocalText {
        de: text.de.clone(),
        en: text.en.clone(),
    }
}

impl Planner<'_> {
    fn plan(&self, folder: &settings::ModuleFolder) -> Result<RunPlan, AssembleError> {
        let level = &self.level.settings;
        let tick_ns = level.clock.tick_us() * 1000;
        let mut plan = RunPlan {
            module: self.request.module.clone(),
            module_title: text(&self.manifest.title),
            level: self.request.level,
            level_title: text(&level.title),
            level_summary: text(&level.summary),
            seed: self.request.seed,
            tick_ns,
            steps: level.clock.steps,
            hash_every: hash_every(&self.installation.host, tick_ns),
            input: match &self.source.note {
                None => self.request.input.to_string(),
                Some(note) => format!("{} ({note})", self.request.input),
            },
            synthetic: self.source.synthetic.clone(),
            input_digest: self.source.digest(),
            queue_messages: self.installation.host.queue.messages,
            queue_bytes: self.installation.host.queue.bytes,
            model_error: level
                .tuned
                .as_ref()
                .filter(|_| !self.leaves_out("physics"))
                .and_then(|tuned| tuned.error),
            without: self.request.without.clone(),
            plugins: Vec::new(),
            parts: self.parts(),
        };
        let source = self.installation.plugin(&self.source.plugin)?;
        let kind = kind_of(source.settings.kind);
        if kind != PluginKind::Source {
            return refuse(format!(
                "plugin \"{}\" ({}): it is of kind `{}`, an input has to be a `source`",
                source.settings.name,
                source.document.path().display(),
                kind.name()
            ));
        }
        let mut wanted: Vec<(&Loaded<Manifest>, String)> = vec![
            (source, self.source.why.clone()),
            (
                self.installation.plugin(RECORDER)?,
                "every run is recorded".into(),
            ),
            (
                &folder.manifest,
                "the operator asked for this module".into(),
            ),
        ];
        if self.request.pictures {
            wanted.push((
                self.installation.plugin(RENDERER)?,
                "pictures are wanted".into(),
            ));
        }
        for name in &self.manifest.plugins {
            let plugin = self.installation.plugin(name)?;
            let why = format!("module \"{}\" uses it", self.manifest.name);
            match plugin.settings.kind {
                settings::PluginKind::Physics if level.physics.is_none() => {}
                kind if self
                    .request
                    .without
                    .iter()
                    .any(|w| w == kind_of(kind).name()) => {}
                _ => wanted.push((plugin, why)),
            }
        }
        for (manifest, why) in wanted {
            let planned = self.plugin(manifest, why, &plan)?;
            if plan.plugins.iter().any(|p| p.name == planned.name) {
                return refuse(format!("plugin \"{}\" would be loaded twice", planned.name));
            }
            plan.plugins.push(planned);
        }
        plan.plugins
            .sort_by(|a, b| (a.kind, &a.name).cmp(&(b.kind, &b.name)));
        Ok(plan)
    }

    fn plugin(
        &self,
        manifest: &Loaded<Manifest>,
        why: String,
        plan: &RunPlan,
    ) -> Result<PlannedPlugin, AssembleError> {
        let m = &manifest.settings;
        let kind = kind_of(m.kind);
        if m.abi != microsim_abi::ABI_VERSION {
            return refuse(format!(
                "plugin \"{}\" ({}): its manifest says version {} of the plugin contract, this host has version {}",
                m.name,
                manifest.document.path().display(),
                m.abi,
                microsim_abi::ABI_VERSION
            ));
        }
        let folder = manifest
            .document
            .path()
            .parent()
            .map(Path::to_path_buf)
            .unwrap_or_default();
        let library = library(m, manifest);
        let library_hash = file_hash(&library).map_err(|e| {
            AssembleError(format!(
                "plugin \"{}\": its library {} cannot be read: {e}",
                m.name,
                library.display()
            ))
        })?;
        let mut files = Vec::new();
        for file in &m.file {
            let path = folder.join(&file.path);
            let bytes = std::fs::read(&path).map_err(|e| {
                AssembleError(format!(
                    "plugin \"{}\": file {}: {e}",
                    m.name,
                    path.display()
                ))
            })?;
            files.push(SetupFile {
                name: file.name.clone(),
                bytes,
            });
        }
        let (config, more) = self.config(kind)?;
        files.extend(more);
        Ok(PlannedPlugin {
            name: m.name.clone(),
            kind,
            version: m.version.clone(),
            publishes: m.publishes.clone(),
            subscribes: m.subscribes.clone(),
            own_kinds: m
                .message
                .iter()
                .map(|k| OwnKind {
                    name: k.name.clone(),
                    version: k.version as u16,
                    drop_oldest: k.overflow == settings::Overflow::DropOldest,
                })
                .collect(),
            library,
            manifest: manifest.document.text().to_owned(),
            library_hash,
            why,
            setup: Setup {
                name: m.name.clone(),
                seed: plan.seed,
                tick_ns: plan.tick_ns,
                steps: plan.steps,
                level: plan.level,
                config,
                files,
            },
        })
    }

    /// The mesh files that bodies name, under the names by which they do.
    fn mesh_files(&self) -> Result<Vec<SetupFile>, AssembleError> {
        let level = self.level.document.path();
        let folder = level.parent().unwrap_or(Path::new(""));
        let mut files: Vec<SetupFile> = Vec::new();
        for (index, body) in self.level.settings.body.iter().enumerate() {
            for name in body.files() {
                if files.iter().any(|file| file.name == name) {
                    continue;
                }
                let bytes = std::fs::read(folder.join(&name)).map_err(|e| {
                    let key = settings::KeyPath::root().key("body").at(index).key("file");
                    let found = format!("`{name}`, which cannot be read ({e})");
                    let error = self.level.document.error_at(&key, &found, "a mesh file");
                    AssembleError(error.to_string())
                })?;
                files.push(SetupFile { name, bytes });
            }
        }
        Ok(files)
    }

    /// What a kind of plugin is told.
    fn config(&self, kind: PluginKind) -> Result<(Value, Vec<SetupFile>), AssembleError> {
        let level = self.level.document.value();
        let module = self
            .installation
            .module(&self.request.module)?
            .manifest
            .document
            .value();
        let config = match kind {
            PluginKind::Source => {
                return Ok((self.source.config.clone(), self.source.files.clone()));
            }
            PluginKind::Translator => {
                let path = self.installation.config.join("translator.toml");
                let translator = settings::load_translator(&path)?;
                json!({
                    "stale_after": translator.settings.stale_after,
                    "devices": self.device_maps(translator.document.value()),
                    "tools": level["tool"],
                })
            }
            PluginKind::Physics => {
                let config = json!({
                    "physics": level["physics"],
                    "method": level["method"],
                    "bodies": level["body"],
                    "rigid": level["rigid"],
                    "contacts": level["contact"],
                    "friction": !self.leaves_out("friction"),
                    "cuts": if self.leaves_out("lonor") { &Value::Null } else { &level["cut"] },
                    "tools": level["tool"],
                    "models": self.models,
                });
                return Ok((config, self.mesh_files()?));
            }
            PluginKind::Module => json!({
                "tools": level["tool"],
                "models": self.models,
                "limits": level["limit"],
                "metrics": level["metrics"],
                "own_metrics": module["metric"],
                "reasons": module["reason"],
                "module": level["module"],
                "objects": level["object"],
                "bodies": level["body"],
                "rigid": level["rigid"],
            }),
            PluginKind::Objects => json!({ "objects": level["object"], "rigid": level["rigid"] }),
            PluginKind::Renderer => json!({
                "view": level["view"],
                "models": self.models,
                "bodies": level["body"],
                "width": self.installation.host.picture.width,
                "height": self.installation.host.picture.height,
            }),
            PluginKind::Recorder => json!({ "path": self.request.session }),
        };
        Ok((config, Vec::new()))
    }

    /// Which of the source's devices drives which tool: as `config/translator.toml` says, otherwise the tool of the
    /// device's own name.
    fn device_maps(&self, translator: &Value) -> Vec<Value> {
        let listed = translator["device"].as_array().cloned().unwrap_or_default();
        let tools: Vec<&str> = self
            .level
            .settings
            .tool
            .iter()
            .map(|t| t.name.as_str())
            .collect();
        let has_tool = |m: &Value| m["tool"].as_str().is_some_and(|t| tools.contains(&t));
        let identity = |name: &str| {
            json!({
                "name": name, "tool": name, "origin": [0.0, 0.0, 0.0], "field_offset": [0.0, 0.0, 0.0],
                "rotation": [0.0, 0.0, 0.0, 1.0], "tool_rotation": [0.0, 0.0, 0.0, 1.0],
                "scale": 1.0, "opening": "device",
            })
        };
        match &self.source.devices {
            Some(devices) => devices
                .iter()
                .map(|device| {
                    let map = listed.iter().find(|m| m["name"] == device.as_str());
                    map.cloned().unwrap_or_else(|| identity(device))
                })
                .filter(has_tool)
                .collect(),
            None => {
                let mut maps: Vec<Value> = listed.into_iter().filter(has_tool).collect();
                for tool in &tools {
                    if !maps.iter().any(|m| m["tool"] == *tool) {
                        maps.push(identity(tool));
                    }
                }
                maps
            }
        }
    }

    /// Whether something is to be left out.
    fn leaves_out(&self, what: &str) -> bool {
        self.request.without.iter().any(|without| without == what)
    }

    fn parts(&self) -> Vec<PlannedPart> {
        let level = &self.level.settings;
        let part = |what: &str, name: String, why: String| PlannedPart {
            what: what.into(),
            name,
            why,
        };
        let mut parts = Vec::new();
        for tool in &level.tool {
            parts.push(part(
                "tool",
                tool.name.clone(),
                format!("the level gives this slot the model \"{}\"", tool.model),
            ));
        }
        for object in &level.object {
            for name in object.names() {
                parts.push(part("object", name, "the level names it".into()));
            }
        }
        if let (Some(physics), false) = (&level.physics, self.leaves_out("physics")) {
            for thing in &level.rigid {
                parts.push(part(
                    "rigid",
                    thing.name.clone(),
                    "the level names it".into(),
                ));
            }
            for body in &level.body {
                let mesh = match (body.elements(), &body.file) {
                    (Some(elements), _) => format!("{elements} tetrahedra"),
                    (None, file) => {
                        format!("its mesh from {}", file.as_deref().unwrap_or("a file"))
                    }
                };
                parts.push(part(
                    "body",
                    body.name.clone(),
                    format!("the level names it; {mesh}{}", reason::mesh(level)),
                ));
            }
            for pair in &level.contact {
                let name = format!("{} on {}", pair.partner(), pair.body);
                parts.push(part(
                    "contact",
                    name,
                    "the level lists this pair; no other contact is looked for".into(),
                ));
            }
            for pair in level.cut.iter().filter(|_| !self.leaves_out("lonor")) {
                parts.push(part(
                    "cut",
                    format!("{} through {}", pair.tool, pair.body),
                    "the level lists this pair; nothing else is cut".into(),
                ));
            }
            parts.push(part(
                "method",
                self.level.document.value()["method"]["name"]
                    .as_str()
                    .unwrap_or_default()
                    .to_owned(),
                format!(
                    "the level asks for it; gravity {:?} m/s^2{}",
                    physics.gravity,
                    reason::method(level)
                ),
            ));
            let step = level.clock.tick / f64::from(level.clock.steps);
            parts.push(part(
                "step",
                format!("{} ms", step * 1e3),
                reason::step(level),
            ));
        }
        parts
    }
}

fn kind_of(kind: settings::PluginKind) -> PluginKind {
    match kind {
        settings::PluginKind::Source => PluginKind::Source,
        settings::PluginKind::Translator => PluginKind::Translator,
        settings::PluginKind::Physics => PluginKind::Physics,
        settings::PluginKind::Module => PluginKind::Module,
        settings::PluginKind::Objects => PluginKind::Objects,
        settings::PluginKind::Renderer => PluginKind::Renderer,
        settings::PluginKind::Recorder => PluginKind::Recorder,
    }
}

fn hash_every(host: &settings::Host, tick_ns: u64) -> u64 {
    let ticks = host.session.state_hash_every * 1e9 / tick_ns as f64;
    (ticks.round() as u64).max(1)
}

/// The installed plugin for a recorded one, for a replay.
pub fn locate(
    installation: &Installation,
    recorded: &PlannedPlugin,
) -> Result<PlannedPlugin, AssembleError> {
    let manifest = match recorded.kind {
        PluginKind::Module => &installation.module(&recorded.name)?.manifest,
        _ => installation.plugin(&recorded.name)?,
    };
    let library = library(&manifest.settings, manifest);
    let library_hash = file_hash(&library)
        .map_err(|e| AssembleError(format!("library {}: {e}", library.display())))?;
    Ok(PlannedPlugin {
        library,
        library_hash,
        manifest: manifest.document.text().to_owned(),
        ..recorded.clone()
    })
}

/// The renderer for a session that was recorded without one: it looks at the level as it is installed now. Pictures are
/// as wide and high as `size` says \[px\], else as the host's configuration.
pub fn renderer_for(
    installation: &Installation,
    plan: &RunPlan,
    size: Option<u32>,
) -> Result<PlannedPlugin, AssembleError> {
    let folder = installation.module(&plan.module)?;
    let level = installation.level(&plan.module, plan.level)?;
    let models = tool_models(installation, &level.settings)?;
    let request = Request {
        module: plan.module.clone(),
        level: plan.level,
        input: Input::Plugin(String::new()),
        seed: plan.seed,
        without: Vec::new(),
        pictures: true,
        session: PathBuf::new(),
    };
    let source = SourceSetup {
        plugin: String::new(),
        why: String::new(),
        config: Value::Null,
        files: Vec::new(),
        devices: None,
        note: None,
        synthetic: None,
    };
    let planner = Planner {
        installation,
        request: &request,
        level: &level,
        manifest: &folder.manifest.settings,
        models,
        source: &source,
    };
    let why = "pictures of the replay are wanted".into();
    let mut renderer = planner.plugin(installation.plugin(RENDERER)?, why, plan)?;
    if let Some(size) = size {
        renderer.setup.config["width"] = size.into();
        renderer.setup.config["height"] = size.into();
    }
    Ok(renderer)
}

/// Whether pictures work on this machine; otherwise why not.
pub fn probe_renderer(installation: &Installation) -> Result<(), String> {
    let config = json!({
        "view": { "field": 0.02, "centre": [0.0, 0.0, 0.0], "tilt": 0.0 },
        "models": {}, "bodies": [], "width": 16, "height": 16,
    });
    probe(installation, RENDERER, config, Vec::new())
}

/// Loads and initialises one plugin, and nothing more.
pub(crate) fn probe(
    installation: &Installation,
    name: &str,
    config: Value,
    files: Vec<SetupFile>,
) -> Result<(), String> {
    let manifest = installation.plugin(name).map_err(|e| e.to_string())?;
    let setup = Setup {
        name: name.into(),
        seed: 0,
        tick_ns: 1_000_000,
        steps: 1,
        level: 1,
        config,
        files,
    };
    let planned = PlannedPlugin {
        name: name.into(),
        kind: kind_of(manifest.settings.kind),
        version: manifest.settings.version.clone(),
        publishes: Vec::new(),
        subscribes: Vec::new(),
        own_kinds: Vec::new(),
        library: library(&manifest.settings, manifest),
        manifest: manifest.document.text().to_owned(),
        library_hash: String::new(),
        why: String::new(),
        setup,
    };
    let mut object = crate::loader::load(&planned).map_err(|e| e.to_string())?;
    let setup = encode(&planned.setup);
    let result = object
        .initialise(RSlice::from_slice(&setup), ROption::RNone)
        .into_result();
    result.map_err(|fault| fault.text.into_string())
}

/// Where the library of a manifest lies.
fn library(manifest: &Manifest, loaded: &Loaded<Manifest>) -> PathBuf {
    let folder = loaded
        .document
        .path()
        .parent()
        .map(Path::to_path_buf)
        .unwrap_or_default();
    folder.join(format!(
        "{}{}{}",
        std::env::consts::DLL_PREFIX,
        manifest.library,
        std::env::consts::DLL_SUFFIX
    ))
}
