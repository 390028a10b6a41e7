//! The frame of a training module: set up, hear, judge, conclude, save and restore. A module says what is asked for
//! ([`Exercise`]); [`Training`] makes a plugin of it.

use crate::{Course, Fault, ModuleConfig, Plugin, Services, Setup, Tick};
use microsim_message::{decode_bytes, encode};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt;

/// What a level of a training module asks for. The value itself does not change in a run; what evolves is its state.
pub trait Exercise: fmt::Debug + Send + Sized + 'static {
    /// All that evolves besides the course; equal states give equal bytes.
    type State: fmt::Debug + Serialize + DeserializeOwned + Send;

    /// From the set-up of a level, with the ids of its targets.
    fn new(setup: &Setup, config: &ModuleConfig) -> Result<(Self, Vec<String>), Fault>;

    /// The state before the first tick.
    fn start(&self) -> Result<Self::State, Fault>;

    /// What is to be seen from the first tick on, published once, before the first [`Exercise::judge`]; nothing unless a module says so.
    fn show(&self, _tick: &mut Tick<'_>) {}

    /// One tick, in every phase of the level, up to its end: see [`Course::running`].
    fn judge(
        &self,
        state: &mut Self::State,
        course: &mut Course,
        tick: &mut Tick<'_>,
    ) -> Result<(), Fault>;

    /// Asked once, when the level ends: which reasons speak against a pass that only then are known.
    fn reasons(&self, state: &Self::State, course: &mut Course);
}

#[derive(Debug)]
struct Level<E: Exercise> {
    exercise: E,
    course: Course,
    /// Whether [`Exercise::show`] has been called.
    shown: bool,
    state: E::State,
}

/// The plugin of an [`Exercise`].
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
            course: Course::new(&config, targets)?,
            shown: false,
            state: exercise.start()?,
            exercise,
        });
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        let level = self.level()?;
        level.course.reset()?;
        level.shown = false;
        level.state = level.exercise.start()?;
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let Level {
            exercise,
            course,
            shown,
            state,
        } = self.level()?;
        if !std::mem::replace(shown, true) {
            exercise.show(tick);
        }
        course.hear(tick)?;
        if !course.finished() {
            exercise.judge(state, course, tick)?;
        }
        course.conclude(tick, |course| exercise.reasons(state, course))
    }

    fn save(&self) -> Vec<u8> {
        let parts = self.level.as_ref().map(|level| {
            let course = serde_bytes::ByteBuf::from(level.course.save());
            (course, level.shown, &level.state)
        });
        encode(&parts)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let parts: Option<(serde_bytes::ByteBuf, bool, E::State)> = decode_bytes(state)?;
        if let (Some(level), Some((course, shown, state))) = (&mut self.level, parts) {
            level.course.restore(&course)?;
            level.shown = shown;
            level.state = state;
        }
        Ok(())
    }
}
