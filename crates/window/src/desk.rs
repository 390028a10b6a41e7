//! Which screen is shown, and what leads from one to the next.

mod shown;

use crate::appearance::{self, Appearance};
use crate::debrief::{self, Next};
use crate::device::{self, Fault, Waker};
use crate::editor::{self, Editor};
use crate::field::Field;
use crate::launcher::{Launcher, Offer, Wanted};
use crate::ledger::Debrief;
use crate::left_films::LeftFilms;
use crate::look;
use crate::memory::{self, GivingBack};
use crate::pedal;
use crate::records::{self, Records};
use crate::replay::{self, Replay};
use crate::shortcut;
use crate::station::{Catalogue, Choice, LevelEntry, ModuleEntry, Station, TraineeEntry};
use crate::steering::{self, Stage};
use crate::text;
use crate::threads;
use crate::training::Training;
use crate::upkeep::{self, Upkeep};
use eframe::egui::{self, Key, RichText, Ui};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup};
use eframe::wgpu;
use microsim_audio::Player;
use microsim_controller::Controllers;
use microsim_settings::{DominantHand, WindowSettings};
use microsim_vocabulary::Language;
use std::fmt;
use std::sync::Arc;
use std::thread::JoinHandle;

/// With what the window opens.
#[derive(Clone, Debug)]
pub struct Opening {
    /// Language of all texts; the operator can change it.
    pub language: Language,
    /// How it looks.
    pub settings: WindowSettings,
    /// A level that is chosen, or begun at once.
    pub choice: Option<Choice>,
    /// Whether it begins at once.
    pub begins: bool,
    /// The dominant hand of who trains, until another one is chosen.
    pub hand: DominantHand,
    /// A recorded session that is shown in its place.
    pub replay: Option<Box<Debrief>>,
    /// Width and height of the window \[points\].
    pub size: [f32; 2],
}

/// Why there is no window, or none any more.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WindowError(Fault);

impl fmt::Display for WindowError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Fault::NotOpened(why) => write!(
                f,
                "no window: {why}; it needs a display (X11, which Wayland desktops have, too) and a graphics driver with Vulkan \
                 (Debian, Ubuntu: apt-get install mesa-vulkan-drivers libvulkan1). `microsim run` works without"
            ),
            Fault::Lost { why, again } => write!(
                f,
                "no window any more: the graphics driver failed ({why}) and the picture could not be had back ({again}); what was recorded is safe"
            ),
        }
    }
}

impl std::error::Error for WindowError {}

/// Shows the window until it is closed.
///
/// # Errors
/// One sentence where there is no display, or no driver, or where a driver fails and the window cannot be opened again.
pub fn open(station: Box<dyn Station>, opening: Opening) -> Result<(), WindowError> {
    if std::env::var_os("DISPLAY").is_none_or(|value| value.is_empty()) {
        return Err(WindowError(Fault::NotOpened(
            "there is no display (DISPLAY is not set)".into(),
        )));
    }
    // Without it ticks are late more often, that is all.
    if let Err(error) = threads::lower_priority() {
        tracing::warn!("drawing has the priority of computing: {error}");
    }
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("MicroSim")
            .with_app_id("microsim")
            .with_inner_size(opening.size)
            .with_fullscreen(opening.settings.full_screen)
            .with_min_inner_size([1000.0, 640.0]),
        renderer: eframe::Renderer::Wgpu,
        // Noise against bands in gradients, of which there are none, at every pixel: on a software driver as much work as a picture.
        dithering: false,
        wgpu_options: sparing(),
        ..Default::default()
    };
    let make = |context: &eframe::CreationContext<'_>| Desk::new(context, station, opening);
    device::run(options, make).map_err(WindowError)
}

/// A device that takes its memory in small blocks: what windows of other sizes needed goes back to the system, where large blocks would stay.
fn sparing() -> WgpuConfiguration {
    let mut options = WgpuConfiguration::default();
    let WgpuSetup::CreateNew(setup) = &mut options.wgpu_setup else {
        unreachable!("eframe opens a device of its own unless it is given one");
    };
    let usual = Arc::clone(&setup.device_descriptor);
    setup.device_descriptor = Arc::new(move |adapter| wgpu::DeviceDescriptor {
        memory_hints: wgpu::MemoryHints::MemoryUsage,
        ..usual(adapter)
    });
    options
}

/// Draws the field with the device of this window.
fn field_of(
    context: &eframe::CreationContext<'_>,
    settings: &WindowSettings,
) -> Result<Field, String> {
    let state = context.wgpu_render_state.as_ref();
    let mut field = Field::new(state.ok_or("the window has no graphics device")?)?;
    field.set(settings);
    Ok(field)
}

enum Screen {
    Launcher,
    Training(Box<Training>),
    /// What came of a run, which may be one of long ago.
    Debrief(Box<Debrief>, Choice),
    /// A run as it was recorded.
    Replay(Box<Replay>, Choice),
    Records(Box<Records>),
    Upkeep,
    Settings(Appearance),
    /// Another copy of a level.
    Editor(Box<Editor>),
    /// Why a level did not begin, or has nothing to show.
    Complaint(String),
}

struct Desk {
    station: Box<dyn Station>,
    language: Language,
    settings: WindowSettings,
    catalogue: Catalogue,
    trainees: Result<Vec<TraineeEntry>, String>,
    launcher: Launcher,
    /// `None` between two devices, when nothing is shown.
    field: Option<Field>,
    /// Has the window drawn when a thread has something new.
    waker: Waker,
    /// Work on the store goes on while other screens are shown.
    upkeep: Upkeep,
    screen: Screen,
    /// The thread of the replay that was left last: it may compute still.
    left: Option<JoinHandle<()>>,
    /// Films of replays that were left.
    left_films: LeftFilms,
    giving_back: GivingBack,
    /// Gamepads and SpaceMice, unless the system had no thread to look for them.
    controllers: Option<Controllers>,
}

impl Desk {
    fn new(
        context: &eframe::CreationContext<'_>,
        station: Box<dyn Station>,
        opening: Opening,
    ) -> Result<Self, String> {
        let field = field_of(context, &opening.settings)?;
        look::apply(&context.egui_ctx);
        let waker = Waker::new(&context.egui_ctx);
        let catalogue = station.catalogue();
        let wake = waker.clone();
        let controllers = Controllers::start(move || wake.wake());
        let controllers = controllers.inspect_err(|why| {
            tracing::warn!("no gamepads and SpaceMice: no thread for them: {why}");
        });
        let mut desk = Self {
            controllers: controllers.ok(),
            trainees: station.trainees(),
            language: opening.language,
            // What is stored is what is shown.
            settings: WindowSettings {
                language: Some(opening.language),
                ..opening.settings
            },
            left: None,
            left_films: LeftFilms::default(),
            giving_back: GivingBack::default(),
            launcher: Launcher::of_hand(opening.hand),
            upkeep: Upkeep::default(),
            waker,
            screen: Screen::Launcher,
            station,
            catalogue,
            field: Some(field),
        };
        if let Some(choice) = opening.choice {
            let place = desk
                .catalogue
                .modules
                .iter()
                .position(|m| m.name == choice.module);
            desk.launcher.module = place.unwrap_or_default();
            desk.launcher.level = choice.level;
            desk.launcher.variant = choice.variant.clone();
            desk.launcher.trainee = choice.trainee.clone();
            if opening.begins {
                desk.begin(choice);
            }
        }
        if let Some(debrief) = opening.replay {
            let choice = desk.choice_of(&debrief);
            desk.replay(debrief, choice, 0);
        }
        Ok(desk)
    }

    fn entries(&self, choice: &Choice) -> Option<(&ModuleEntry, &LevelEntry)> {
        let module = self
            .catalogue
            .modules
            .iter()
            .find(|m| m.name == choice.module)?;
        let is_chosen = |l: &&LevelEntry| (l.number, &l.variant) == (choice.level, &choice.variant);
        let level = module.levels.iter().find(is_chosen)?;
        Some((module, level))
    }

    fn begin(&mut self, choice: Choice) {
        // What ran before has to be closed, so that two runs never compute at once.
        self.screen = Screen::Launcher;
        self.wait_for_left();
        memory::give_back();
        let begun = match self.entries(&choice) {
            None => Err(match &choice.variant {
                None => format!("there is no level {} of {}", choice.level, choice.module),
                Some(name) => format!(
                    "the window does not offer the variant \"{name}\" of level {} of {}",
                    choice.level, choice.module
                ),
            }),
            Some((module, level)) => self.station.begin(&choice).and_then(|session| {
                Training::begin(choice.clone(), module, level, session, self.waker.clone())
            }),
        };
        self.screen = match begun {
            Ok(mut training) => {
                let speed = self.settings.controller_speed;
                let controllers = self.controllers.clone();
                training.controllers = controllers.map(|controllers| (controllers, speed));
                training.pedal = self.settings.pedal;
                if self.settings.audio {
                    let player = Player::open(self.settings.volume, |why| {
                        tracing::info!("no tones: {why}");
                    });
                    training.play_tones(player);
                }
                Screen::Training(Box::new(training))
            }
            Err(why) => Screen::Complaint(why),
        };
    }

    /// Until nothing is computed any more of the replay that was left.
    fn wait_for_left(&mut self) {
        if let Some(left) = self.left.take() {
            // A panic was stated where the replay was shown.
            let _ = left.join();
        }
        self.left_films.wait();
    }

    /// The level of a session, for whoever trains now.
    fn choice_of(&self, debrief: &Debrief) -> Choice {
        let session = &debrief.report.session;
        Choice {
            module: session.module.clone(),
            level: session.level,
            variant: debrief.variant.clone(),
            trainee: self.launcher.trainee.clone(),
            hand: self.launcher.hand,
        }
    }

    /// Shows a session from a tick on, or its debrief with what is wrong with it.
    fn replay(&mut self, debrief: Box<Debrief>, choice: Choice, tick: u64) {
        self.wait_for_left();
        let begun = match self.station.replay(&debrief.session) {
            Ok(recording) => Replay::begin(debrief, recording, tick, self.waker.clone()),
            Err(why) => Err((debrief, why)),
        };
        self.screen = match begun {
            Ok(replay) => Screen::Replay(Box::new(replay), choice),
            Err((mut debrief, why)) => {
                let why = format!("{}: {why}", text::NO_REPLAY.of(self.language));
                if !debrief.complaints.contains(&why) {
                    debrief.complaints.push(why);
                }
                Screen::Debrief(debrief, choice)
            }
        };
    }

    fn show_replay(&mut self, ui: &mut Ui) {
        let Screen::Replay(replay, _) = &mut self.screen else {
            return;
        };
        let panels = self.settings.panels;
        let station = &*self.station;
        let Some(field) = &mut self.field else {
            return;
        };
        match replay.show(ui, field, station, panels, self.language) {
            None => {}
            Some(replay::Outcome::Language) => self.change_language(),
            Some(replay::Outcome::Back) => {
                let shown = std::mem::replace(&mut self.screen, Screen::Launcher);
                if let Screen::Replay(replay, choice) = shown {
                    let (debrief, left, filming) = replay.leave();
                    self.left = left;
                    self.left_films.leave(filming);
                    self.screen = Screen::Debrief(debrief, choice);
                }
                ui.ctx().request_repaint();
            }
        }
    }

    fn show_launcher(&mut self, ui: &mut Ui) {
        let station = &self.station;
        let offer = Offer {
            catalogue: &self.catalogue,
            trainees: &self.trainees,
            locked: &|choice| station.locked(choice),
            pictures: &**station,
        };
        match self.launcher.show(ui, &offer, self.language) {
            None => {}
            Some(Wanted::Language) => self.change_language(),
            Some(Wanted::Records) => self.open_records(),
            Some(Wanted::Settings) => self.screen = Screen::Settings(Appearance::default()),
            Some(Wanted::Edit(choice)) => {
                self.edit(choice);
                ui.ctx().request_repaint();
            }
            Some(Wanted::Quit) => ui.send_viewport_cmd(egui::ViewportCommand::Close),
            Some(Wanted::Begin(choice)) => {
                self.begin(choice);
            }
        }
    }

    fn open_records(&mut self) {
        let trainee = self.launcher.trainee.as_deref();
        let records = Records::new(&*self.station, trainee);
        self.screen = Screen::Records(Box::new(records));
    }

    fn show_settings(&mut self, ui: &mut Ui) {
        let Screen::Settings(appearance) = &mut self.screen else {
            return;
        };
        let mut settings = self.settings;
        match appearance.show(ui, &mut settings, self.language) {
            None => {}
            Some(appearance::Wanted::Changed) => self.set(settings, ui),
            Some(appearance::Wanted::Store) => {
                let stored = self.station.store_settings(&settings);
                appearance.message = Some(match stored {
                    Ok(file) => {
                        let stored_in = text::STORED_IN.of(self.language);
                        (format!("{stored_in} {}", file.display()), false)
                    }
                    Err(why) => {
                        let not_stored = text::NOT_STORED.of(self.language);
                        (format!("{not_stored} {why}"), true)
                    }
                });
            }
            Some(appearance::Wanted::Back) => self.screen = Screen::Launcher,
        }
    }

    fn edit(&mut self, choice: Choice) {
        let Some((module, level)) = self.entries(&choice) else {
            return;
        };
        let titles = (module.title.clone(), level.title.clone());
        self.screen = match Editor::new(&*self.station, choice, titles) {
            Ok(editor) => Screen::Editor(Box::new(editor)),
            Err(why) => Screen::Complaint(why),
        };
    }

    fn show_editor(&mut self, ui: &mut Ui) {
        let Screen::Editor(editor) = &mut self.screen else {
            return;
        };
        match editor.show(ui, &*self.station, self.language) {
            None => {}
            Some(editor::Wanted::Language) => self.change_language(),
            Some(editor::Wanted::Back) => self.screen = Screen::Launcher,
            Some(editor::Wanted::Stored(name)) => {
                self.launcher.variant = Some(name);
                self.catalogue = self.station.catalogue();
            }
        }
    }

    /// From now on it looks like this.
    fn set(&mut self, settings: WindowSettings, ui: &Ui) {
        if settings.full_screen != self.settings.full_screen {
            ui.send_viewport_cmd(egui::ViewportCommand::Fullscreen(settings.full_screen));
        }
        self.language = settings.language.unwrap_or(self.language);
        if let Some(field) = &mut self.field
            && appearance::changes_picture(&self.settings, &settings)
        {
            field.set(&settings);
        }
        self.settings = settings;
    }

    /// The other language, which is stored with the settings if they are.
    fn change_language(&mut self) {
        self.language = other(self.language);
        self.settings.language = Some(self.language);
    }

    /// Keys that a foot switch and buttons of gamepads and SpaceMice stand for.
    fn press_by_controllers(&self, ui: &Ui) {
        let presses = self.controllers.as_ref().map(Controllers::presses);
        let stage = match &self.screen {
            Screen::Training(training) => training.stage(),
            Screen::Replay(..) => Stage::Replay,
            Screen::Launcher => Stage::Before,
            _ => Stage::Other,
        };
        steering::press_keys(ui, &presses.unwrap_or_default(), stage);
        pedal::press_keys(ui, &self.settings.pedal, stage);
    }

    /// Keys that work on every screen.
    fn set_by_keys(&mut self, ui: &Ui) {
        let mut settings = self.settings;
        settings.full_screen ^= ui.input(|input| input.key_pressed(Key::F11));
        settings.panels ^= ui.input(|input| input.key_pressed(Key::F3));
        if settings != self.settings {
            self.set(settings, ui);
        }
    }

    fn open_upkeep(&mut self) {
        self.upkeep.read(&*self.station);
        self.screen = Screen::Upkeep;
    }

    fn show_upkeep(&mut self, ui: &mut Ui) {
        match self.upkeep.show(ui, &*self.station, self.language) {
            None => {}
            Some(upkeep::Wanted::Language) => self.change_language(),
            Some(upkeep::Wanted::Back) => self.open_records(),
        }
    }

    fn show_debrief(&mut self, ui: &mut Ui) {
        let Screen::Debrief(debrief, choice) = &self.screen else {
            return;
        };
        let next = Choice {
            level: choice.level + 1,
            variant: None,
            ..choice.clone()
        };
        let again = choice.clone();
        let has_next = self.entries(&next).is_some();
        match debrief::show(ui, debrief, has_next, self.language) {
            None => {}
            Some(Next::Back) => self.screen = Screen::Launcher,
            Some(Next::Replay(tick)) => {
                let debrief = debrief.clone();
                self.replay(debrief, again, tick);
                ui.ctx().request_repaint();
            }
            Some(wanted) => {
                let choice = if wanted == Next::Again { again } else { next };
                self.launcher.level = choice.level;
                self.launcher.variant = choice.variant.clone();
                self.begin(choice);
            }
        }
    }

    fn show_records(&mut self, ui: &mut Ui) {
        let Screen::Records(records) = &mut self.screen else {
            return;
        };
        match records.show(ui, &*self.station, self.language) {
            None => {}
            Some(records::Wanted::Language) => self.change_language(),
            Some(records::Wanted::Upkeep) => self.open_upkeep(),
            Some(records::Wanted::Back) => {
                // Who is there may have changed.
                self.trainees = self.station.trainees();
                let trainees = self.trainees.iter().flatten();
                let ids: Vec<&String> = trainees.map(|trainee| &trainee.id).collect();
                self.launcher.trainee = self.launcher.trainee.take().filter(|t| ids.contains(&t));
                self.screen = Screen::Launcher;
            }
            Some(records::Wanted::Debrief(debrief)) => {
                let choice = self.choice_of(&debrief);
                self.screen = Screen::Debrief(debrief, choice);
            }
            Some(records::Wanted::Replay(debrief)) => {
                let choice = self.choice_of(&debrief);
                self.replay(debrief, choice, 0);
            }
        }
    }

    fn show_complaint(&mut self, ui: &mut Ui) {
        let Screen::Complaint(why) = &self.screen else {
            return;
        };
        let mut back = false;
        egui::CentralPanel::default().show(ui, |ui| {
            ui.add_space(60.0);
            ui.vertical_centered(|ui| {
                ui.set_max_width(720.0);
                let title = RichText::new(text::NOT_BEGUN.of(self.language));
                ui.label(title.size(20.0).strong().color(look::BAD));
                ui.label(why);
                let text = text::BACK.of(self.language);
                back = shortcut::main_button(ui, text, shortcut::BACK);
            });
        });
        if back {
            self.screen = Screen::Launcher;
        }
    }
}

fn other(language: Language) -> Language {
    match language {
        Language::German => Language::English,
        Language::English => Language::German,
    }
}
