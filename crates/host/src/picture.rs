//! Pictures: the renderer on a thread of its own, on the latest snapshot, at its own rate. Nothing comes back into the
//! run.

use crate::engine::Engine;
use crate::error::RunError;
use crate::fault::Failure;
use crate::loader::load;
use crate::plan::{PlannedPlugin, PluginKind, RunPlan};
use crate::span;
use abi_stable::std_types::{ROption, RSlice};
use microsim_abi::{Block as AbiBlock, Call, PluginBox};
use microsim_bus::{Block, Frames, kind_id};
use microsim_message::{PictureRequest, encode, push};
use microsim_settings::{RendererConfig, unwritable};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

/// Pictures that may wait to be drawn.
const QUEUE: usize = 4;

/// Which pictures are wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PicturePlan {
    /// Where they are written.
    pub folder: PathBuf,
    /// Of which ticks.
    pub when: PictureTimes,
}

/// The ticks of which there are pictures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PictureTimes {
    /// One in so many, as `frame-000000.png` and so on: the number times this is the tick, also where some are left out.
    Every(u64),
    /// These, as `tick-000000.png` by their ticks.
    At(BTreeSet<u64>),
}

impl PicturePlan {
    /// The file for the picture of a tick; `None` if none is wanted.
    pub fn file(&self, tick: u64) -> Option<PathBuf> {
        let name = match &self.when {
            PictureTimes::Every(every) => tick
                .is_multiple_of(*every)
                .then(|| format!("frame-{:06}.png", tick / every)),
            PictureTimes::At(ticks) => ticks.contains(&tick).then(|| format!("tick-{tick:06}.png")),
        };
        name.map(|name| self.folder.join(name))
    }
}

/// What came of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PictureReport {
    /// Pictures written.
    pub written: u64,
    /// Pictures left out because drawing was slower than a paced run.
    pub left_out: u64,
    /// Why there are no (more) pictures.
    pub off: Option<String>,
}

struct Job {
    tick: u64,
    time_ns: u64,
    tick_ns: u64,
    messages: Vec<u8>,
    blocks: Vec<Block>,
}

/// The picture thread, seen from the tick thread.
pub struct Pictures {
    plan: PicturePlan,
    wanted: Vec<u64>,
    latest: BTreeMap<u64, Vec<u8>>,
    jobs: Option<SyncSender<Job>>,
    thread: Option<JoinHandle<Result<(), Failure>>>,
    written: Arc<AtomicU64>,
    left_out: u64,
    wait: bool,
    /// Whether they show what has to be asked for.
    shows_fields: bool,
}

impl Pictures {
    /// Starts the thread. `wait`: the run waits for slow drawing (as fast as it can) instead of leaving pictures out
    /// (paced).
    pub fn start(
        planned: &PlannedPlugin,
        mut object: PluginBox,
        plan: PicturePlan,
        wait: bool,
    ) -> Result<Self, std::io::Error> {
        std::fs::create_dir_all(&plan.folder)?;
        // A configuration that it cannot read is refused by the renderer, which is asked next.
        let config: Option<RendererConfig> = planned.setup.configuration().ok();
        let (jobs, queue) = sync_channel(QUEUE);
        let setup = encode(&planned.setup);
        let name = planned.name.clone();
        let written = Arc::new(AtomicU64::new(0));
        let count = Arc::clone(&written);
        let thread = std::thread::Builder::new()
            .name("microsim-picture".into())
            .spawn(move || draw(&name, &mut object, &setup, &queue, &count))?;
        Ok(Self {
            plan,
            wanted: planned.subscribes.iter().map(|k| kind_id(k)).collect(),
            latest: BTreeMap::new(),
            jobs: Some(jobs),
            thread: Some(thread),
            written,
            left_out: 0,
            wait,
            shows_fields: config.is_some_and(|config| config.surface_view().is_some()),
        })
    }

    /// Takes over the messages of a tick and asks for a picture where one is due.
    pub fn handle(&mut self, tick: u64, tick_ns: u64, log: &[u8], engine: &mut Engine) {
        let _span = tracing::debug_span!("pictures").entered();
        for frame in Frames::new(log).filter_map(Result::ok) {
            if self.wanted.contains(&frame.header.kind) {
                let mut bytes = Vec::new();
                microsim_bus::frame::push_stamped(&mut bytes, &frame.header, frame.payload);
                self.latest.insert(frame.header.kind, bytes);
            }
        }
        let (Some(jobs), Some(file)) = (&self.jobs, self.plan.file(tick)) else {
            return;
        };
        let mut messages: Vec<u8> = self.latest.values().flatten().copied().collect();
        push(
            &mut messages,
            &PictureRequest {
                file: file.to_string_lossy().into_owned(),
            },
        );
        let mut blocks = engine.blocks();
        if self.shows_fields {
            blocks.extend(engine.fields());
        }
        let job = Job {
            tick,
            time_ns: (tick + 1) * tick_ns,
            tick_ns,
            messages,
            blocks,
        };
        let sent = if self.wait {
            jobs.send(job).map_err(|_| TrySendError::Disconnected(()))
        } else {
            jobs.try_send(job).map_err(|e| match e {
                TrySendError::Full(_) => TrySendError::Full(()),
                TrySendError::Disconnected(_) => TrySendError::Disconnected(()),
            })
        };
        match sent {
            Ok(()) => {}
            Err(TrySendError::Full(())) => self.left_out += 1,
            // The thread has ended with a failure; `finish` returns it.
            Err(TrySendError::Disconnected(())) => self.jobs = None,
        }
    }

    /// Waits for the pictures that are not drawn yet.
    pub fn finish(mut self) -> PictureReport {
        self.jobs = None;
        let off = match self.thread.take().map(JoinHandle::join) {
            None | Some(Ok(Ok(()))) => None,
            Some(Ok(Err(failure))) if failure.unavailable => Some(failure.text),
            Some(Ok(Err(failure))) => Some(failure.to_string()),
            Some(Err(_)) => Some("the picture thread panicked".into()),
        };
        let written = self.written.load(Ordering::Relaxed);
        PictureReport {
            written,
            left_out: self.left_out,
            off,
        }
    }
}

/// Starts the picture thread of a plan, if it has a renderer and pictures are wanted.
pub(crate) fn start_pictures(
    plan: &RunPlan,
    wanted: Option<PicturePlan>,
    wait: bool,
) -> Result<Option<Pictures>, RunError> {
    let renderer = plan.plugins.iter().find(|p| p.kind == PluginKind::Renderer);
    let (Some(wanted), Some(renderer)) = (wanted, renderer) else {
        return Ok(None);
    };
    let folder = wanted.folder.clone();
    Pictures::start(renderer, load(renderer)?.into_plugin(), wanted, wait)
        .map(Some)
        .map_err(|e| RunError::Host(format!("pictures: {}", unwritable(&folder, e))))
}

fn draw(
    name: &str,
    object: &mut PluginBox,
    setup: &[u8],
    queue: &Receiver<Job>,
    written: &AtomicU64,
) -> Result<(), Failure> {
    let failure = |call, tick| move |fault| Failure::from_abi(name, call, tick, fault);
    object
        .initialise(RSlice::from_slice(setup), ROption::RNone)
        .into_result()
        .map_err(failure("initialise", 0))?;
    let mut last = 0;
    for job in queue {
        let blocks: Vec<_> = job
            .blocks
            .iter()
            .map(|b| AbiBlock {
                kind: b.view().kind(),
                words: RSlice::from_slice(b.words()),
            })
            .collect();
        let call = Call {
            tick: job.tick,
            time_ns: job.time_ns,
            tick_ns: job.tick_ns,
            steps: 0,
            messages: RSlice::from_slice(&job.messages),
            blocks: RSlice::from_slice(&blocks),
        };
        let _span = span::of_call("process", PluginKind::Renderer, name).entered();
        object
            .process(call)
            .into_result()
            .map_err(failure("process", job.tick))?;
        written.fetch_add(1, Ordering::Relaxed);
        last = job.tick;
    }
    object.stop().into_result().map_err(failure("stop", last))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(when: PictureTimes, tick: u64) -> Option<String> {
        let plan = PicturePlan {
            folder: PathBuf::from("there"),
            when,
        };
        plan.file(tick).map(|path| path.display().to_string())
    }

    #[test]
    fn pictures_are_named_by_their_place_in_time() {
        assert_eq!(
            named(PictureTimes::Every(25), 50).as_deref(),
            Some("there/frame-000002.png")
        );
        assert_eq!(named(PictureTimes::Every(25), 51), None);
        let at = || PictureTimes::At([7, 9].into());
        assert_eq!(named(at(), 7).as_deref(), Some("there/tick-000007.png"));
        assert_eq!(named(at(), 8), None);
    }
}
