//! A run in the test's own process, tick by tick.

use crate::tree;
use microsim_bus::Limits;
use microsim_host::Engine;
use microsim_host::assemble::{Input, Installation, Isolate, Request, assemble};
use microsim_host::engine::{Feed, TickOutput};
use microsim_host::loader::load;
use microsim_host::plan::RunPlan;
use microsim_host::run::RunError;
use microsim_message::{LevelControl, push};
use std::path::PathBuf;

/// The plan of a run on the built tree. `session` is for the recorder, if somebody starts it.
pub fn plan(module: &str, level: u32, input: Input, session: PathBuf) -> RunPlan {
    plan_hosted(Isolate::Guests, module, level, input, session)
}

/// The same with other plugins in a process of their own.
pub fn plan_hosted(
    which: Isolate,
    module: &str,
    level: u32,
    input: Input,
    session: PathBuf,
) -> RunPlan {
    let mut installation = Installation::open(&tree(), None).expect("the built tree");
    installation.guests.which = which;
    let request = Request {
        module: module.into(),
        level,
        variant: None,
        input,
        hand: None,
        seed: 1,
        without: Vec::new(),
        pictures: false,
        session,
    };
    assemble(&installation, &request).expect("a plan")
}

/// An engine at the beginning.
pub fn engine(plan: &RunPlan) -> Engine {
    let started = Engine::new(plan, Limits::default(), None, |planned| {
        load(planned).map(Some).map_err(RunError::from)
    });
    started.expect("the plugins start")
}

/// One tick, as the host does it: the level begins with the first.
pub fn tick(engine: &mut Engine) -> TickOutput {
    let mut control = Vec::new();
    if engine.tick_index() == 0 {
        push(&mut control, &LevelControl::Start);
    }
    let output = engine.tick(Feed::Live { control: &control });
    output.expect("no plugin fails")
}
