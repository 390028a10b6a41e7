//! What a source is given: a script, a recording in CSV, or the input samples of a session.

use crate::installation::Installation;
use crate::installed::probe;
use crate::record::Session;
use crate::request::{AssembleError, Input, OPENIGTLINK, Request, refuse};
use microsim_bus::Frames;
use microsim_message::{InputSample, SetupFile, config_value, decode, encode};
use microsim_settings::{self as settings, RecordingConfig, ScriptConfig};
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::path::Path;

/// Plugin that plays scripts.
const SOURCE_SCRIPT: &str = "source-script";
/// Plugin that plays recordings.
const SOURCE_RECORDING: &str = "source-recording";
/// Plugin of mouse and keyboard.
const SOURCE_DESKTOP: &str = "source-desktop";
/// Bytes of a recording's first line that are looked at where it has no column map.
const HEADER_SHOWN: usize = 2000;

/// What a source gets.
pub(crate) struct SourceSetup {
    pub plugin: String,
    pub why: String,
    pub config: Value,
    pub files: Vec<SetupFile>,
    /// Names of the devices that it brings; `None`: not known beforehand.
    pub devices: Option<Vec<String>>,
    /// What the operator must know of the input.
    pub note: Option<String>,
    /// By what a synthetic trainee was made.
    pub synthetic: Option<String>,
    /// Whether the devices are instruments in a trainee's hands; a script, and mouse and keyboard, move in the level's own field.
    pub holds_instruments: bool,
}

impl SourceSetup {
    /// Digest of all that the source is given, but not of where its file lies nor for which level a script was made.
    pub fn digest(&self) -> String {
        let mut config = self.config.clone();
        if let Some(config) = config.as_object_mut() {
            config.remove("name");
            if let Some(script) = config.get_mut("script").and_then(Value::as_object_mut) {
                script.remove("module");
                script.remove("level");
            }
        }
        let given = encode(&(&self.plugin, &config, &self.files));
        blake3::hash(&given).to_hex().to_string()
    }
}

/// The set-up of the source that a request asks for.
pub(crate) fn source_setup(
    installation: &Installation,
    request: &Request,
) -> Result<SourceSetup, AssembleError> {
    let read = |path: &Path| {
        settings::read_regular(path)
            .map_err(|e| AssembleError(format!("input {}: {e}", path.display())))
    };
    match &request.input {
        Input::Plugin(name) if [SOURCE_SCRIPT, SOURCE_RECORDING].contains(&name.as_str()) => {
            refuse(format!(
                "\"{name}\" plays files: give script:FILE or recording:FILE"
            ))
        }
        Input::Plugin(name) if name == SOURCE_DESKTOP => refuse(format!(
            "\"{name}\" is mouse and keyboard of a window: `microsim window` has one"
        )),
        Input::Plugin(name) if name == OPENIGTLINK => tracker(installation, None),
        Input::OpenIgtLink(address) => tracker(installation, Some(address)),
        Input::Desktop => desktop(installation, request),
        Input::Plugin(name) => Ok(SourceSetup {
            plugin: name.clone(),
            why: "the input is asked for by name".into(),
            config: Value::Object(Map::new()),
            files: Vec::new(),
            devices: None,
            note: None,
            synthetic: None,
            holds_instruments: true,
        }),
        Input::Script(given) => {
            // Who listens to an input without running a module looks for it nowhere else.
            let places = match request.module.is_empty() {
                true => Vec::new(),
                false => {
                    let module = installation.module(&request.module)?;
                    vec![module.manifest.document.path().with_file_name("scripts")]
                }
            };
            let path = installation.find(given, &places);
            let script = settings::load_script(&path)?;
            let made_for = match request.module.is_empty() {
                true => None,
                false => script
                    .settings
                    .made_for_another(&request.module, request.level),
            };
            let note = made_for.map(|what| {
                let (path, module, level) = (path.display(), &request.module, request.level);
                tracing::warn!("{path}: made for {what}; this is {module}, level {level}");
                format!("made for {what}")
            });
            Ok(SourceSetup {
                plugin: SOURCE_SCRIPT.into(),
                why: format!("the input is the script {}", path.display()),
                devices: Some(
                    script
                        .settings
                        .tool
                        .iter()
                        .map(|t| t.name.clone())
                        .collect(),
                ),
                files: Vec::new(),
                note,
                synthetic: script.settings.synthetic.clone(),
                holds_instruments: false,
                config: config_value(&ScriptConfig {
                    script: script.settings,
                }),
            })
        }
        Input::Recording(given) => {
            let path = installation.find(given, &[]);
            let bytes = read(&path)?;
            if bytes.starts_with(microsim_session::MAGIC) {
                session_input(&path, &bytes)
            } else {
                csv_input(&path, bytes)
            }
        }
    }
}

/// The set-up that listens to trackers: as openigtlink.toml has it, or as a client of another address.
fn tracker(
    installation: &Installation,
    address: Option<&String>,
) -> Result<SourceSetup, AssembleError> {
    let path = installation.setting("openigtlink.toml");
    let link = settings::load_openigtlink(&path)?.settings;
    let link = match address {
        None => link,
        Some(address) => link
            .client_of(address)
            .map_err(|error| AssembleError(format!("input: {error}")))?,
    };
    let markers = marker_names(installation)?;
    let link = settings::OpenIgtLink {
        marker: link.marker.into_iter().chain(markers).collect(),
        ..link
    };
    let role = link.role.name();
    Ok(SourceSetup {
        plugin: OPENIGTLINK.into(),
        why: format!("the input is a tracker ({role}, {})", link.address),
        config: config_value(&link),
        files: Vec::new(),
        devices: None,
        note: None,
        synthetic: None,
        holds_instruments: true,
    })
}

/// The set-up of mouse and keyboard: a hand for each tool of the level.
fn desktop(installation: &Installation, request: &Request) -> Result<SourceSetup, AssembleError> {
    let variant = request.variant.as_deref();
    let level = installation.variant(&request.module, request.level, variant)?;
    let desktop = settings::load_desktop(&installation.setting("desktop.toml"))?;
    let tools = level.settings.tool.iter().map(|slot| slot.name.clone());
    let tools: Vec<String> = tools.collect();
    let view = level.settings.view;
    Ok(SourceSetup {
        plugin: SOURCE_DESKTOP.into(),
        why: "the input is mouse and keyboard".into(),
        devices: Some(tools.clone()),
        config: config_value(&settings::DesktopConfig {
            desktop: desktop.settings,
            tools,
            centre: view.centre,
            field: view.field,
        }),
        files: Vec::new(),
        note: None,
        synthetic: None,
        holds_instruments: false,
    })
}

/// The devices that are markers of instruments.
fn marker_names(installation: &Installation) -> Result<Vec<String>, AssembleError> {
    let path = installation.config.join("translator.toml");
    let translator = settings::load_translator(&path)?.settings;
    let markers = translator.markers.into_iter().flat_map(|tool| tool.marker);
    Ok(markers.map(|marker| marker.name).collect())
}

/// The set-up that plays a recording of these devices.
fn recording(
    path: &Path,
    config: &RecordingConfig,
    bytes: Vec<u8>,
    devices: Vec<String>,
) -> SourceSetup {
    SourceSetup {
        plugin: SOURCE_RECORDING.into(),
        why: format!("the input is the recording {}", path.display()),
        config: config_value(config),
        files: vec![SetupFile {
            name: "recording".into(),
            bytes,
        }],
        devices: Some(devices),
        note: None,
        synthetic: None,
        holds_instruments: true,
    }
}

fn csv_input(path: &Path, bytes: Vec<u8>) -> Result<SourceSetup, AssembleError> {
    let map_path = settings::recording_map_path(path);
    if !map_path.is_file() {
        let head = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
        let head = String::from_utf8_lossy(&head[..head.len().min(HEADER_SHOWN)]);
        return refuse(settings::recording_map_help(path, &head));
    }
    let map = settings::load_recording_map(path)?;
    let devices = map.settings.device.iter().map(|d| d.name.clone()).collect();
    let config = RecordingConfig::Csv {
        name: path.display().to_string(),
        map: Box::new(map.settings),
    };
    Ok(recording(path, &config, bytes, devices))
}

/// Checks a recording in CSV, its column map and every row, by the plugin that would play it.
pub fn check_recording(installation: &Installation, path: &Path) -> Result<(), AssembleError> {
    let bytes = settings::read_regular(path)
        .map_err(|e| AssembleError(format!("recording {}: {e}", path.display())))?;
    let source = csv_input(path, bytes)?;
    probe(installation, SOURCE_RECORDING, source.config, source.files).map_err(AssembleError)
}

/// The input samples of a recorded session, to be played again.
fn session_input(path: &Path, bytes: &[u8]) -> Result<SourceSetup, AssembleError> {
    let session =
        Session::read(bytes).map_err(|e| AssembleError(format!("{}: {e}", path.display())))?;
    // Each with the time at which it arrived: devices need not have one clock.
    let mut samples: Vec<(f64, InputSample)> = Vec::new();
    let mut devices = BTreeSet::new();
    for (index, tick) in session.ticks.iter().chain(&session.failed_tick) {
        let arrival = (index + 1) as f64 * session.header.plan.tick_ns as f64 * 1e-9;
        let frames = Frames::new(&tick.log).filter_map(Result::ok);
        for sample in frames.filter_map(|f| decode::<InputSample>(&f)) {
            let sample = sample.map_err(|e| AssembleError(format!("{}: {e}", path.display())))?;
            devices.insert(sample.device.clone());
            samples.push((arrival, sample));
        }
    }
    if let Some(checkpoint) = &session.resumed {
        return refuse(format!(
            "{}: it goes on from tick {} of another session, whose input is not in it; play that one",
            path.display(),
            checkpoint.tick
        ));
    }
    let note = session.complaint.map(|complaint| {
        tracing::warn!(
            "{}: {complaint}; what comes before it is played",
            path.display()
        );
        format!("not complete: {complaint}")
    });
    let devices = devices.into_iter().collect();
    let recorded = session.header.plan;
    let in_field = [SOURCE_SCRIPT, SOURCE_DESKTOP];
    let plugins = recorded.plugins.iter();
    let moves_in_field = plugins
        .into_iter()
        .any(|p| in_field.contains(&p.name.as_str()));
    Ok(SourceSetup {
        note,
        synthetic: recorded.synthetic,
        holds_instruments: !moves_in_field,
        ..recording(path, &RecordingConfig::Samples, encode(&samples), devices)
    })
}
