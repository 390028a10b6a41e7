//! The frame of a training module: set up, handle messages, update, conclude, save and restore. A module states what is asked for
//! ([`Exercise`]); [`Training`] makes a plugin of it.

use crate::fault::Fault;
use crate::level_run::LevelRun;
use crate::plugin::{Plugin, Services};
use crate::tick::Tick;
use microsim_message::Setup;
use microsim_message::{decode_bytes, encode};
use microsim_settings::ModuleConfig;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt;

/// What a level of a training module asks for: its targets, and when each is reached.
///
/// ```
/// use microsim_sdk::message::{LocalText, ToolStates};
/// use microsim_sdk::{Exercise, Fault, LevelRun, ModuleConfig, Setup, Tick, Training};
///
/// /// Passed as soon as the tip of a tool is above the field.
/// #[derive(Debug)]
/// struct Lift;
///
/// impl Exercise for Lift {
///     type State = ();
///
///     fn new(_: &Setup, _: &ModuleConfig) -> Result<(Self, Vec<String>), Fault> {
///         Ok((Self, vec!["lifted".into()]))
///     }
///
///     fn start(&self) -> Result<(), Fault> {
///         Ok(())
///     }
///
///     fn update(&self, _: &mut (), run: &mut LevelRun, tick: &mut Tick<'_>) -> Result<(), Fault> {
///         let tools = tick.latest::<ToolStates>()?.unwrap_or_default().tools;
///         let lifted = tools.iter().any(|tool| tool.pose.position[2] > 5e-3);
///         if run.is_running() && lifted {
///             run.target_done(tick, "lifted", LocalText::fixed("Angehoben", "Lifted"))?;
///         }
///         Ok(())
///     }
///
///     fn reasons(&self, _: &(), _: &mut LevelRun) {}
/// }
///
/// /// What `export_plugin!` makes a library of, and [`TestHost`](crate::TestHost) runs.
/// type Module = Training<Lift>;
/// # let _ = std::any::type_name::<Module>();
/// ```
///
/// In a tick [`Training`] lets the run handle controls and tool samples, calls `update`, and publishes the result once all targets are
/// reached, the time is over or the input ends.
///
/// The value itself does not change in a run; what evolves is its state.
pub trait Exercise: fmt::Debug + Send + Sized + 'static {
    /// All that evolves besides the run of the level; `()` if nothing does. It is saved and restored: equal states give equal bytes.
    type State: fmt::Debug + Serialize + DeserializeOwned + Send;

    /// From the set-up of a level, with the ids of its targets: the level is passed when all are reached and no reason speaks against it. A
    /// fault names what is wrong with the level.
    fn new(setup: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault>;

    /// The state before the first tick.
    fn start(&self) -> Result<Self::State, Fault>;

    /// What is to be seen from the first tick on, published once, before the first [`Exercise::update`]; nothing by default.
    fn show(&self, _tick: &mut Tick<'_>) {}

    /// One tick: reads messages ([`Tick::latest`], [`Tick::messages`]) and reports to `run` what was reached and measured
    /// ([`LevelRun::target_done`], [`LevelRun::measure`], [`LevelRun::event`]). Called in every phase up to the end of the level, before
    /// its start and in pauses too: see [`LevelRun::is_running`].
    fn update(
        &self,
        state: &mut Self::State,
        run: &mut LevelRun,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault>;

    /// Called once, when the level ends: adds reasons against a pass that are known only then ([`LevelRun::add_reason`]).
    fn reasons(&self, state: &Self::State, run: &mut LevelRun);
}

#[derive(Debug)]
struct Level<E: Exercise> {
    exercise: E,
    run: LevelRun,
    /// Whether [`Exercise::show`] has been called.
    shown: bool,
    state: E::State,
}

/// The plugin of an [`Exercise`], for [`export_plugin!`](crate::export_plugin) and [`TestHost`](crate::TestHost).
#[derive(Debug)]
pub struct Training<E: Exercise> {
    level: Option<Level<E>>,
}

impl<E: Exercise> Training<E> {
    fn level(&mut self) -> Result<&mut Level<E>, Fault> {
        let level = self.level.as_mut();
        level.ok_or_else(|| Fault::new("not initialised"))
    }
}

impl<E: Exercise> Plugin for Training<E> {
    fn new() -> Self {
        Self { level: None }
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: ModuleConfig = setup.configuration()?;
        let (exercise, targets) = E::new(setup, &config)?;
        self.level = Some(Level {
            run: LevelRun::new(&config, targets)?,
            shown: false,
            state: exercise.start()?,
            exercise,
        });
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        let level = self.level()?;
        level.run.reset()?;
        level.shown = false;
        level.state = level.exercise.start()?;
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let Level {
            exercise,
            run,
            shown,
            state,
        } = self.level()?;
        if !std::mem::replace(shown, true) {
            exercise.show(tick);
        }
        run.handle(tick)?;
        if !run.is_finished() {
            exercise.update(state, run, tick)?;
        }
        run.conclude(tick, |run| exercise.reasons(state, run))
    }

    fn save(&self) -> Vec<u8> {
        let parts = self.level.as_ref().map(|level| {
            let run = serde_bytes::ByteBuf::from(level.run.save());
            (run, level.shown, &level.state)
        });
        encode(&parts)
    }

    fn hashed(&self) -> Option<Vec<u8>> {
        let parts = self.level.as_ref().map(|level| {
            let run = serde_bytes::ByteBuf::from(level.run.hashed());
            (run, level.shown, &level.state)
        });
        Some(encode(&parts))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let parts: Option<(serde_bytes::ByteBuf, bool, E::State)> = decode_bytes(state)?;
        if let (Some(level), Some((run, shown, state))) = (&mut self.level, parts) {
            level.run.restore(&run)?;
            level.shown = shown;
            level.state = state;
        }
        Ok(())
    }
}
