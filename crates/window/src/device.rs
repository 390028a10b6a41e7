//! The graphics device under the window: where a driver loses it, the window is opened again with another one, and what it showed goes on.
//!
//! A device cannot be exchanged below a window of eframe, so the window goes and comes back. Whatever computes has threads of its own and notices nothing.

use crate::look;
use eframe::egui::layers::ShapeIdx;
use eframe::egui::{self, LayerId, Ui};
use eframe::{CreationContext, EframeWinitApplication, NativeOptions, UserEvent};
use microsim_gpu::Gpu;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::event::{DeviceEvent, DeviceId, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::platform::run_on_demand::EventLoopExtRunOnDemand as _;
use winit::window::WindowId;

/// A device that is lost this often within [`WHILE`] will be lost again: that is no accident.
const MOST_LOSSES: usize = 3;
const WHILE: Duration = Duration::from_secs(60);

/// Asks for a picture of the window, whichever is open now, from any thread.
#[derive(Clone, Debug, Default)]
pub struct Waker(Arc<Mutex<egui::Context>>);

impl Waker {
    /// For the window of this context.
    pub fn new(context: &egui::Context) -> Self {
        Self(Arc::new(Mutex::new(context.clone())))
    }

    /// From now on that of another window.
    pub fn turn_to(&self, context: &egui::Context) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = context.clone();
    }

    /// Asks for it.
    pub fn wake(&self) {
        let context = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        context.request_repaint();
    }
}

/// What a window shows, and goes on showing with another device.
pub trait Shown {
    /// Lets go of a device that is lost, so that its memory is free before another one is opened.
    fn release(&mut self);

    /// Takes another device, in place of the one that was lost for this reason.
    ///
    /// # Errors
    /// What the driver refuses.
    fn take(&mut self, context: &CreationContext<'_>, why: &str) -> Result<(), String>;

    /// Stops what nobody sees for a while.
    fn pause(&mut self);

    /// Why the device is lost, once it is.
    fn lost(&self) -> Option<String>;

    /// Shows it.
    fn show(&mut self, ui: &mut Ui);
}

/// Why there is no window, or none any more.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The first one did not open.
    NotOpened(String),
    /// The device was lost, and there is no other.
    Lost {
        /// What the driver stated.
        why: String,
        /// What became of another device.
        again: String,
    },
}

/// Shows a window until it is closed; `make` makes what it shows.
///
/// # Errors
/// Why there is no window, or none any more. What was shown is dropped before.
pub fn run<S: Shown>(
    mut options: NativeOptions,
    make: impl FnOnce(&CreationContext<'_>) -> Result<S, String>,
) -> Result<(), Fault> {
    let event_loop = EventLoop::<UserEvent>::with_user_event().build();
    let mut event_loop = event_loop.map_err(|error| Fault::NotOpened(error.to_string()))?;
    let mut make = Some(make);
    let shown = Rc::new(RefCell::new(None::<S>));
    let mut losses = Losses::default();
    let mut lost: Option<String> = None;
    loop {
        let state = Rc::new(RefCell::new(State::default()));
        let create = |context: &CreationContext<'_>| {
            watch(context);
            let mut slot = shown.borrow_mut();
            let made = match (&mut *slot, &lost, make.take()) {
                (Some(shown), Some(why), _) => shown.take(context, why),
                (_, _, Some(make)) => make(context).map(|made| *slot = Some(made)),
                _ => unreachable!("what is shown is made once and lost later"),
            };
            drop(slot);
            state.borrow_mut().refused = made.as_ref().err().cloned();
            made?;
            let (shown, state) = (Rc::clone(&shown), Rc::clone(&state));
            Ok(Box::new(Window { shown, state }) as Box<dyn eframe::App>)
        };
        let mut host = Host {
            window: eframe::create_native(
                "MicroSim",
                options.clone(),
                Box::new(create),
                &event_loop,
            ),
            state: Rc::clone(&state),
        };
        let ended = event_loop.run_app_on_demand(&mut host);
        let_go(host);
        let state = state.take();
        // A window that never showed anything did not open.
        let ended = match (ended, state.refused, state.has_opened) {
            (Err(error), ..) => Err(error.to_string()),
            (Ok(()), Some(why), _) => Err(why),
            (Ok(()), None, false) => Err(unopened()),
            (Ok(()), None, true) => Ok(()),
        };
        let again = match (ended, state.lost, &lost) {
            (Ok(()), None, _) => return Ok(()),
            (Err(error), None, None) => return Err(Fault::NotOpened(error)),
            (Err(error), None, Some(_)) => Some(error),
            (_, Some(why), _) => {
                tracing::warn!("the graphics driver lost its device: {why}");
                shown.borrow_mut().iter_mut().for_each(Shown::release);
                let is_hopeless = losses.add(Instant::now());
                lost = Some(why);
                is_hopeless.then(|| format!("it was lost {MOST_LOSSES} times within a minute"))
            }
        };
        if let Some(again) = again {
            // A run that goes on ends here, and its session is closed.
            drop(shown.take());
            let why = lost.unwrap_or_default();
            return Err(Fault::Lost { why, again });
        }
        if let Some(size) = state.size {
            options.viewport.inner_size = Some(size);
        }
        options.viewport.fullscreen = state.full_screen.or(options.viewport.fullscreen);
    }
}

/// Hands on to a window what happens, until its device is lost: from then on it is not asked for anything any more.
struct Host<'a> {
    window: EframeWinitApplication<'a>,
    state: Rc<RefCell<State>>,
}

impl Host<'_> {
    fn hand_on(
        &mut self,
        event_loop: &ActiveEventLoop,
        event: impl FnOnce(&mut EframeWinitApplication<'_>),
    ) {
        let is_lost = |state: &RefCell<State>| state.borrow().lost.is_some();
        if !is_lost(&self.state) {
            event(&mut self.window);
        }
        if is_lost(&self.state) {
            event_loop.exit();
        }
    }
}

impl ApplicationHandler<UserEvent> for Host<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        self.hand_on(event_loop, |window| window.resumed(event_loop));
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        self.hand_on(event_loop, |window| {
            window.window_event(event_loop, id, event)
        });
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, cause: StartCause) {
        self.hand_on(event_loop, |window| window.new_events(event_loop, cause));
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: UserEvent) {
        self.hand_on(event_loop, |window| window.user_event(event_loop, event));
    }

    fn device_event(&mut self, event_loop: &ActiveEventLoop, id: DeviceId, event: DeviceEvent) {
        self.hand_on(event_loop, |window| {
            window.device_event(event_loop, id, event)
        });
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.hand_on(event_loop, |window| window.about_to_wait(event_loop));
    }

    fn suspended(&mut self, event_loop: &ActiveEventLoop) {
        self.hand_on(event_loop, |window| window.suspended(event_loop));
    }

    fn exiting(&mut self, event_loop: &ActiveEventLoop) {
        self.hand_on(event_loop, |window| window.exiting(event_loop));
    }

    fn memory_warning(&mut self, event_loop: &ActiveEventLoop) {
        self.hand_on(event_loop, |window| window.memory_warning(event_loop));
    }
}

/// Drops a window. wgpu panics where the device was lost between the begin of a picture and its end: it cannot give that picture back. Nothing is wrong then with anything else, so that
/// this panic is neither printed nor handed on.
fn let_go(host: Host<'_>) {
    let is_lost = host.state.borrow().lost.is_some();
    if !is_lost {
        return;
    }
    let printed: Arc<dyn Fn(&PanicHookInfo<'_>) + Send + Sync> = Arc::from(panic::take_hook());
    let (here, others) = (std::thread::current().id(), Arc::clone(&printed));
    panic::set_hook(Box::new(move |info| {
        if std::thread::current().id() != here {
            others(info);
        }
    }));
    let dropped = panic::catch_unwind(AssertUnwindSafe(move || drop(host)));
    panic::set_hook(Box::new(move |info| printed(info)));
    if dropped.is_err() {
        tracing::warn!("the picture that was being drawn on the lost device was left behind");
    }
}

/// Why a window did not open that had a display; eframe writes that into the log alone.
fn unopened() -> String {
    match Gpu::off_screen() {
        Err(error) => error.to_string(),
        Ok(gpu) => format!(
            "the graphics driver of {:?} opened no window (the log has its reason)",
            gpu.adapter_name()
        ),
    }
}

/// When devices were lost.
#[derive(Debug, Default)]
struct Losses(VecDeque<Instant>);

impl Losses {
    /// Whether it is hopeless with this one.
    fn add(&mut self, now: Instant) -> bool {
        self.0.push_back(now);
        self.0.retain(|then| now.duration_since(*then) <= WHILE);
        self.0.len() >= MOST_LOSSES
    }
}

/// Has what the driver complains about outside of the field's pictures in the log, where wgpu would panic: the loss of a device leads to such complaints.
fn watch(context: &CreationContext<'_>) {
    if let Some(state) = &context.wgpu_render_state {
        let complain = |error| tracing::error!("the graphics driver: {error}");
        state.device.on_uncaptured_error(Arc::new(complain));
    }
}

/// Takes all shapes out of the picture that is being made.
fn clear(context: &egui::Context) {
    let mut layers: Vec<LayerId> = context.memory(|memory| memory.layer_ids().collect());
    layers.push(LayerId::background());
    context.graphics_mut(|graphics| {
        for layer in layers {
            if let Some(list) = graphics.get_mut(layer) {
                let count = list.all_entries().len();
                (0..count).for_each(|k| list.reset_shape(ShapeIdx(k)));
            }
        }
    });
}

/// What is known of a window that closes.
#[derive(Debug, Default)]
struct State {
    lost: Option<String>,
    /// Why what is shown could not take the device.
    refused: Option<String>,
    /// Whether anything was shown.
    has_opened: bool,
    size: Option<egui::Vec2>,
    full_screen: Option<bool>,
}

struct Window<S> {
    shown: Rc<RefCell<Option<S>>>,
    state: Rc<RefCell<State>>,
}

impl<S: Shown> eframe::App for Window<S> {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        let mut slot = self.shown.borrow_mut();
        let Some(shown) = &mut *slot else {
            return;
        };
        if shown.lost().is_none() {
            shown.show(ui);
        }
        let mut state = self.state.borrow_mut();
        state.has_opened = true;
        ui.input(|input| {
            let viewport = input.viewport();
            state.size = viewport.inner_rect.map(|rect| rect.size()).or(state.size);
            state.full_screen = viewport.fullscreen.or(state.full_screen);
        });
        if let Some(why) = shown.lost() {
            shown.pause();
            state.lost = Some(why);
            // Nothing is left to be drawn: egui's renderer panics where it has no memory of the device for it.
            clear(ui.ctx());
        }
    }

    fn clear_color(&self, _: &egui::Visuals) -> [f32; 4] {
        look::BACKGROUND.to_normalized_gamma_f32()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Area, Id, Pos2, RawInput, Rect, Shape, vec2};

    /// Texts of panels and of what lies over them.
    #[test]
    fn nothing_is_left_to_be_drawn() {
        let context = egui::Context::default();
        let screen = Rect::from_min_size(Pos2::ZERO, vec2(800.0, 600.0));
        let shapes = |cleared: bool| {
            let input = RawInput {
                screen_rect: Some(screen),
                ..RawInput::default()
            };
            let mut output = context.run_ui(input, |ui| {
                egui::CentralPanel::default().show(ui, |ui| ui.label("below"));
                let area = Area::new(Id::unique("over")).fixed_pos([100.0, 100.0]);
                area.show(ui.ctx(), |ui| ui.label("over"));
                if cleared {
                    clear(ui.ctx());
                }
            });
            output.textures_delta.clear();
            let drawn = output.shapes.iter();
            drawn.filter(|clipped| clipped.shape != Shape::Noop).count()
        };
        // What lies over a panel is drawn from the second picture on.
        shapes(false);
        assert!(shapes(false) >= 3);
        assert_eq!(shapes(true), 0);
    }

    /// Losses that lie apart are accidents.
    #[test]
    fn the_third_loss_within_a_minute_is_hopeless() {
        let start = Instant::now();
        let hopeless = |seconds: &[u64]| {
            let mut losses = Losses::default();
            let add = |after: &u64| losses.add(start + Duration::from_secs(*after));
            seconds.iter().map(add).collect::<Vec<_>>()
        };
        assert_eq!(hopeless(&[0, 30, 60]), [false, false, true]);
        assert_eq!(hopeless(&[0, 30, 61, 90]), [false, false, false, true]);
    }

    /// Threads that compute ask the window that is open now.
    #[test]
    fn a_waker_asks_the_window_that_is_open() {
        let contexts = [egui::Context::default(), egui::Context::default()];
        let is_asked = |context: &egui::Context| context.has_requested_repaint();
        for context in &contexts {
            // The first pictures ask for others.
            for _ in 0..4 {
                context
                    .run_ui(RawInput::default(), |_| ())
                    .textures_delta
                    .clear();
            }
        }
        let waker = Waker::new(&contexts[0]);
        let thread = waker.clone();
        waker.turn_to(&contexts[1]);
        assert!(!is_asked(&contexts[1]));
        thread.wake();
        assert!(!is_asked(&contexts[0]) && is_asked(&contexts[1]));
    }
}
