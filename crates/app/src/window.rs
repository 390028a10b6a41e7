//! `microsim window`, and `microsim` alone: the station behind the operator's window.

mod copies;
mod films;
mod jobs;
mod ledger;
mod level_pictures;
mod recorded;
mod references;

use crate::cli::{Place, WindowArgs};
use crate::folders::{self, Folders};
use crate::key_pictures::not_asked;
use crate::log;
use crate::names::shown;
use crate::output::{Exit, Problem, complain};
use crate::records::{self, Attempt, RunRecord};
use crate::replace_file::replace;
use crate::report::write_beside;
use crate::session_file::{find, installation, read_around, report_of};
use crate::station;
use microsim_host::assemble::{Input, Installation, Request, assemble, renderer_for, title_of};
use microsim_host::plan::{PluginKind, RunPlan};
use microsim_host::run::{Operator, Realtime, RunOptions, RunOutcome, run};
use microsim_message::{LocalText, SetupFile};
use microsim_report::{Language, Page};
use microsim_settings::{
    self as settings, Desktop, DesktopConfig, ModuleFolder, RendererConfig, Variant, WindowSettings,
};
use microsim_store::Id;
use microsim_window::{
    Catalogue, Choice, Debrief, LevelEntry, LiveSession, ModuleEntry, Opening, Recording, Station,
    ToolEntry, TraineeEntry,
};
use recorded::Recorded;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, SystemTime};

/// The file of how the window looks.
const FILE: &str = "window.toml";
/// The metric of the largest sustained force of a tool on tissue, in all modules that have it.
const PEAK_FORCE: &str = "peak-force";

/// Shows the window until it is closed.
pub fn window(place: &Place, args: &WindowArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let file = installation.setting(FILE);
    let settings = settings::load_window(&file)
        .map_err(|e| e.to_string())?
        .settings;
    let language = args.lang.as_deref().and_then(Language::from_name);
    let language = language.or(settings.language);
    let language = language.unwrap_or(installation.host.report.language);
    let hand = match args.hand {
        Some(hand) => hand,
        None => {
            let translator = settings::load_translator(&installation.setting("translator.toml"));
            translator.map_err(|e| e.to_string())?.settings.dominant
        }
    };
    let trainee = args.trainee.as_deref().map(|name| {
        let store = records::must_read(place)?;
        Ok::<_, Problem>(records::find(&store, name)?.id.to_string())
    });
    let trainee = trainee.transpose()?;
    let choice = args.module.as_ref().map(|module| {
        installation.variant(module, args.level, args.variant.as_deref())?;
        Ok::<_, Problem>(Choice {
            module: module.clone(),
            level: args.level,
            variant: args.variant.clone(),
            trainee: trainee.clone(),
            hand,
        })
    });
    let replay = args.replay.as_deref().map(|session| {
        let session = find(place, session);
        let opened = Recorded::new(&installation, &session);
        let debrief = opened.and_then(|_| recorded::debrief(session));
        debrief.map_err(|problem| cannot_replay(problem, language))
    });
    let opening = Opening {
        language,
        hand,
        settings,
        choice: choice.transpose()?,
        begins: args.module.is_some(),
        replay: replay.transpose()?.map(Box::new),
        size: args.size,
    };
    let station = AtThisPlace {
        place: place.clone(),
        installation,
        input: args.input.clone(),
        variant: args
            .module
            .clone()
            .zip(args.variant.clone())
            .map(|(module, variant)| (module, args.level, variant)),
    };
    microsim_window::open(Box::new(station), opening)?;
    Ok(Exit::Done)
}

/// Why a session cannot be replayed, in the language of the window that would have shown it.
fn cannot_replay(problem: Problem, language: Language) -> Problem {
    let what = match language {
        Language::German => "die Aufzeichnung kann nicht abgespielt werden",
        Language::English => "the session cannot be replayed",
    };
    match problem {
        Problem::Text(why) => Problem::Text(format!("{what}: {why}")),
        problem => problem,
    }
}

/// The installation and the folders of the user.
struct AtThisPlace {
    place: Place,
    installation: Installation,
    input: Input,
    /// A variant that is offered besides those that were made here: of a module, its level, its name.
    variant: Option<(String, u32, String)>,
}

impl AtThisPlace {
    /// The variants of a level that are offered: others are for tests of methods.
    fn offered(&self, module: &ModuleFolder) -> Vec<Variant> {
        let asked = self.variant.as_ref();
        let (mut variants, _) = self.installation.variants(module);
        variants.retain(|of| {
            let is_asked = asked.is_some_and(|(name, level, variant)| {
                *name == module.manifest.settings.name && (*level, variant) == (of.level, &of.name)
            });
            is_asked || self.installation.is_made_here(of)
        });
        variants
    }

    fn level_entry(
        &self,
        module: &str,
        number: u32,
        variant: Option<&str>,
    ) -> Result<LevelEntry, String> {
        let level = self
            .installation
            .variant(module, number, variant)
            .map_err(|e| e.to_string())?;
        let level = &level.settings;
        let tool = |slot: &settings::ToolSlot| {
            let tool = settings::load_tool(&self.installation.tool_file(&slot.model));
            let tool = tool.map_err(|e| e.to_string())?;
            Ok::<_, String>(ToolEntry {
                slot: slot.name.clone(),
                title: tool.settings.title,
            })
        };
        Ok(LevelEntry {
            number,
            variant: variant.map(str::to_owned),
            title: title_of(&level.title, variant),
            summary: level.summary.clone(),
            tools: level.tool.iter().map(tool).collect::<Result<_, _>>()?,
        })
    }
}

impl Station for AtThisPlace {
    fn catalogue(&self) -> Catalogue {
        let mut catalogue = Catalogue {
            modules: Vec::new(),
            complaints: self
                .installation
                .complaints
                .iter()
                .map(ToString::to_string)
                .collect(),
        };
        for module in &self.installation.tree.modules {
            let manifest = &module.manifest.settings;
            let mut entry = ModuleEntry {
                name: manifest.name.clone(),
                title: manifest.title.clone(),
                summary: manifest.summary.clone(),
                levels: Vec::new(),
            };
            let variants = self.offered(module);
            for number in 1..=module.levels.len() as u32 {
                let of_level = variants.iter().filter(|of| of.level == number);
                let of_level = of_level.map(|of| Some(&of.name[..]));
                for variant in std::iter::once(None).chain(of_level) {
                    match self.level_entry(&manifest.name, number, variant) {
                        Ok(level) => entry.levels.push(level),
                        Err(why) => catalogue.complaints.push(why),
                    }
                }
            }
            let (_, wrong) = self.installation.variants(module);
            let wrong = wrong.iter().map(ToString::to_string);
            catalogue.complaints.extend(wrong);
            catalogue.modules.push(entry);
        }
        catalogue
    }

    fn trainees(&self) -> Result<Vec<TraineeEntry>, String> {
        let listed = || {
            let Some(store) = records::open_to_read(&self.place)? else {
                return Ok(Vec::new());
            };
            let trainees = store.trainees(None)?.into_iter();
            let named = trainees.filter_map(|listed| {
                let trainee = listed.trainee;
                let name = trainee.name?;
                Some(TraineeEntry {
                    id: trainee.id.to_string(),
                    name: shown(&name),
                })
            });
            Ok::<_, Problem>(named.collect())
        };
        listed().map_err(text)
    }

    fn locked(&self, choice: &Choice) -> Option<LocalText> {
        let trainee = choice.trainee.as_deref()?;
        // A store that cannot be read locks nothing; `trainees` has said why it cannot.
        let store = records::open_to_read(&self.place).ok().flatten()?;
        let trainee = Id::parse(trainee)?;
        let closed = records::closed_courses(&store, trainee, &choice.module, choice.level);
        let next = closed.ok()?.into_iter().next()?;
        Some(LocalText::new(
            format!(
                "Kurs {}: zuerst {}, Stufe {}",
                next.course, next.module, next.level
            ),
            format!(
                "course {}: {}, level {}, comes first",
                next.course, next.module, next.level
            ),
        ))
    }

    fn begin(&self, choice: &Choice) -> Result<Box<dyn LiveSession>, String> {
        let begun = || {
            let session = new_session(&self.place, choice)?;
            let variant = &choice.variant;
            let plan = assemble(
                &self.installation,
                &Request {
                    module: choice.module.clone(),
                    level: choice.level,
                    variant: variant.clone(),
                    input: self.input.clone(),
                    hand: Some(choice.hand),
                    seed: 1,
                    without: Vec::new(),
                    pictures: false,
                    session: session.clone(),
                },
            )?;
            let level =
                self.installation
                    .variant(&choice.module, choice.level, variant.as_deref())?;
            let mut limits = level.settings.limit.iter();
            let renderer = renderer_for(&self.installation, &plan, None)?;
            let picture: RendererConfig = renderer.setup.configuration()?;
            let attempt = Attempt {
                module: &choice.module,
                level: choice.level,
                trainee: choice.trainee.as_deref(),
                // Another task than that of this number.
                no_store: variant.is_some(),
            };
            Ok::<_, Problem>(LevelAtDesk {
                desktop: match self.input {
                    Input::Desktop => Some(desktop(&plan)?),
                    _ => None,
                },
                record: RunRecord::begin(&self.place, &attempt, &session)?,
                place: self.place.clone(),
                realtime: Realtime {
                    tolerance: Duration::from_secs_f64(self.installation.host.late.tolerance),
                    give_up: Duration::from_secs_f64(self.installation.host.late.give_up),
                },
                language: self.installation.host.report.language,
                picture,
                force_limit: limits
                    .find(|limit| limit.metric == PEAK_FORCE)
                    .and_then(|limit| limit.max),
                files: renderer.setup.files,
                plan,
                session,
            })
        };
        match begun() {
            Ok(session) => Ok(Box::new(session)),
            Err(problem) => Err(text(problem)),
        }
    }

    fn store_settings(&self, settings: &WindowSettings) -> Result<PathBuf, String> {
        if self.place.config.is_some() {
            return Err(format!(
                "the window was opened with --config, which ignores settings of this station ({FILE})"
            ));
        }
        let folder = Folders::of(&self.place)?.config;
        folders::make(&folder)?;
        let file = folder.join(FILE);
        replace(&file, settings.text().as_bytes()).map_err(text)?;
        Ok(file)
    }

    fn replay(&self, session: &Path) -> Result<Box<dyn Recording>, String> {
        let recorded = Recorded::new(&self.installation, session).map_err(text)?;
        Ok(Box::new(recorded))
    }
}

fn text(problem: Problem) -> String {
    match problem {
        Problem::Text(text) => text,
        Problem::BrokenPipe => "broken pipe".into(),
    }
}

/// What the source of a plan has of mouse and keyboard.
fn desktop(plan: &RunPlan) -> Result<Desktop, Problem> {
    let source = plan.plugins.iter().find(|p| p.kind == PluginKind::Source);
    let source = source.ok_or("the plan has no source")?;
    let config: DesktopConfig = source.setup.configuration()?;
    Ok(config.desktop)
}

/// A new name in the folder of sessions.
fn new_session(place: &Place, choice: &Choice) -> Result<PathBuf, Problem> {
    let folder = Folders::of(place)?.sessions();
    folders::make(&folder)?;
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let now = now.unwrap_or_default().as_millis();
    let variant = choice.variant.as_ref().map(|name| format!(".{name}"));
    let (module, variant) = (&choice.module, variant.unwrap_or_default());
    let (level, process) = (choice.level, std::process::id());
    Ok(folder.join(format!(
        "{module}-level{level}{variant}-{now}-{process}.session"
    )))
}

/// A level that is about to be trained at this place.
struct LevelAtDesk {
    place: Place,
    plan: RunPlan,
    session: PathBuf,
    record: RunRecord,
    realtime: Realtime,
    language: Language,
    picture: RendererConfig,
    files: Vec<SetupFile>,
    desktop: Option<Desktop>,
    force_limit: Option<f64>,
}

impl LiveSession for LevelAtDesk {
    fn picture(&self) -> &RendererConfig {
        &self.picture
    }

    fn files(&self) -> &[SetupFile] {
        &self.files
    }

    fn force_limit(&self) -> Option<f64> {
        self.force_limit
    }

    fn desktop(&self) -> Option<&Desktop> {
        self.desktop.as_ref()
    }

    fn run(
        &mut self,
        stop: &AtomicBool,
        operator: &mut dyn Operator,
    ) -> Result<RunOutcome, String> {
        let options = RunOptions {
            threads: 1,
            realtime: Some(self.realtime),
            pictures: None,
            resume: None,
            stop_at: None,
            stop,
            operator: Some(operator),
            trainee: self.record.trainee.map(|id| id.to_string()),
            session_id: Some(self.record.id.to_string()),
            unlisted: false,
            key: station::key(&self.place)
                .inspect_err(|why| complain(format!("the recording is not signed: {why}")))
                .ok(),
            progress: &mut |_, _| {},
        };
        run(&self.plan, options).map_err(|e| e.to_string())
    }

    fn finish(self: Box<Self>, outcome: &RunOutcome) -> Result<Debrief, String> {
        let mut complaints = outcome.complaints.clone();
        if let Some(failure) = &outcome.failure {
            tracing::error!(target: log::FILE, "{failure}");
            complaints.push(failure.to_string());
        }
        let session = &self.session;
        let recorded = read_around(session).map_err(text)?;
        let report = report_of(&recorded, session).map_err(text)?;
        if let Some(Err(why)) = self.record.enter(&recorded, &report, session, &[]) {
            complaints.push(why);
        }
        let page = Page {
            language: self.language,
            pictures: not_asked(),
        };
        let page = write_beside(&report, &page, session).map_err(|problem| {
            format!(
                "{}; the session is safe in {}",
                text(problem),
                session.display()
            )
        })?;
        Ok(Debrief {
            report,
            variant: self.plan.variant,
            session: self.session,
            page,
            complaints,
        })
    }
}
