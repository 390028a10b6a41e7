//! The devices that are there. Each is read in a thread of its own; another one looks once a second for those that were plugged in.

use crate::capabilities::{self, Capabilities};
use crate::device::{Kind, kind};
use crate::event::{LENGTH, parse};
use crate::layout::{Press, held, presses};
use crate::motion::{Integral, Motion};
use crate::probe::{Kernel, Probe};
use crate::report::{Outcome, Reports, State};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread;
use std::time::{Duration, Instant};

#[cfg(test)]
mod tests;

/// Between two looks for devices.
const LOOK: Duration = Duration::from_secs(1);
/// How long a deflection holds of a device that never states that it has ended \[s\]: some twenty of its reports.
const HOLDS: f64 = 0.25;

/// Whether a device is there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Seen {
    /// It is read.
    Here,
    /// It was unplugged.
    Gone,
    /// It is there and cannot be read: why, and what to do about it.
    Refused(String),
}

/// A device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Presence {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// Whether it is there.
    pub seen: Seen,
}

/// What is known of a device.
struct Known {
    presence: Presence,
    /// Name of its file, while it is read.
    file: Option<String>,
    integral: Integral,
}

/// What threads and window have in common.
struct Shared {
    begin: Instant,
    known: Mutex<Vec<Known>>,
    presses: Mutex<Vec<Press>>,
    wake: Box<dyn Fn() + Send + Sync>,
}

/// A panic of another thread leaves data that can be read all the same.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Since it began \[s\].
    fn now(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    /// Enters a device, or one that is there again; its place.
    fn enter(&self, name: &str, kind: Kind, seen: Seen, file: Option<&str>) -> usize {
        let mut known = lock(&self.known);
        let is_same =
            |of: &Known| of.file.is_none() && of.presence.name == name && of.presence.kind == kind;
        let place = known.iter().position(is_same).unwrap_or_else(|| {
            known.push(Known {
                presence: Presence {
                    name: name.to_owned(),
                    kind,
                    seen: Seen::Gone,
                },
                file: None,
                integral: Integral::default(),
            });
            known.len() - 1
        });
        let is_new = known[place].presence.seen != seen;
        known[place].presence.seen = seen;
        known[place].file = file.map(str::to_owned);
        drop(known);
        if is_new {
            (self.wake)();
        }
        place
    }
}

/// All gamepads and SpaceMice of this machine. Clones are of the same devices.
#[derive(Clone)]
pub struct Controllers(Arc<Shared>);

impl std::fmt::Debug for Controllers {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Controllers")
            .field(&self.presences())
            .finish()
    }
}

impl Controllers {
    /// Begins to look for devices. `wake` is called from other threads when a button is pressed and when a device comes or goes.
    ///
    /// # Errors
    /// If the system has no thread for it.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let folders = Folders {
            devices: "/dev/input".into(),
            published: "/sys/class/input".into(),
        };
        Self::look_in(folders, Arc::new(Kernel), LOOK, wake)
    }

    fn look_in(
        folders: Folders,
        probe: Arc<dyn Probe>,
        look: Duration,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            begin: Instant::now(),
            known: Mutex::default(),
            presses: Mutex::default(),
            wake: Box::new(wake),
        });
        let searched = Arc::downgrade(&shared);
        let search = move || {
            let mut others = BTreeSet::new();
            while let Some(shared) = searched.upgrade() {
                folders.search(&shared, &probe, &mut others);
                drop(shared);
                thread::sleep(look);
            }
        };
        thread::Builder::new()
            .name("controllers".into())
            .spawn(search)?;
        Ok(Self(shared))
    }

    /// What all of them asked for since it was taken or left out last.
    pub fn take(&self) -> Motion {
        let mut known = lock(&self.0.known);
        let now = self.0.now();
        let motions = known.iter_mut().map(|known| known.integral.take(now));
        motions.fold(Motion::default(), Motion::and)
    }

    /// Leaves out what motions they asked for.
    pub fn skip(&self) {
        let mut known = lock(&self.0.known);
        let now = self.0.now();
        known.iter_mut().for_each(|known| known.integral.skip(now));
    }

    /// The buttons that were pressed since it was asked last, in their order.
    pub fn presses(&self) -> Vec<Press> {
        std::mem::take(&mut *lock(&self.0.presses))
    }

    /// The devices that are or were there.
    pub fn presences(&self) -> Vec<Presence> {
        let known = lock(&self.0.known);
        known.iter().map(|known| known.presence.clone()).collect()
    }
}

/// Where devices are.
struct Folders {
    /// Files of records, `event0`, `event1`, …
    devices: PathBuf,
    /// What is published of each, in folders of the same names.
    published: PathBuf,
}

impl Folders {
    /// Looks once; `others` are files of devices of no use here.
    fn search(&self, shared: &Arc<Shared>, probe: &Arc<dyn Probe>, others: &mut BTreeSet<String>) {
        let entries = std::fs::read_dir(&self.devices).into_iter().flatten();
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let names: BTreeSet<String> = names.filter(|name| name.starts_with("event")).collect();
        others.retain(|other| names.contains(other));
        for name in names.difference(&others.clone()) {
            let is_read = |known: &Known| known.file.as_ref() == Some(name);
            if lock(&shared.known).iter().any(is_read) {
                continue;
            }
            let published = self.published.join(name).join("device");
            let Some(capabilities) = capabilities::read(&published) else {
                continue;
            };
            match kind(&capabilities) {
                None => {
                    others.insert(name.clone());
                }
                Some(kind) => {
                    let file = self.devices.join(name);
                    if let Err(why) = open(shared, probe, &file, name, kind, &capabilities) {
                        shared.enter(&capabilities.name, kind, Seen::Refused(why), None);
                    }
                }
            }
        }
        // What could not be read and is no longer there.
        let published = names.difference(others).filter_map(|name| {
            let published = self.published.join(name).join("device");
            Some(capabilities::read(&published)?.name)
        });
        let published: BTreeSet<String> = published.collect();
        for known in lock(&shared.known).iter_mut() {
            let is_refused = matches!(known.presence.seen, Seen::Refused(_));
            if is_refused && !published.contains(&known.presence.name) {
                known.presence.seen = Seen::Gone;
            }
        }
    }
}

/// What to do about an error.
fn complaint(path: &Path, error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::PermissionDenied => format!(
            "{} may not be read: add the user to the group `input` (usermod -aG input NAME) and log in again",
            path.display()
        ),
        _ => format!("{}: {error}", path.display()),
    }
}

/// Opens a device and reads it from now on.
fn open(
    shared: &Arc<Shared>,
    probe: &Arc<dyn Probe>,
    path: &Path,
    name: &str,
    kind: Kind,
    capabilities: &Capabilities,
) -> Result<(), String> {
    let device = File::open(path).map_err(|error| complaint(path, &error))?;
    let state = probe.probe(&device, capabilities);
    let state = state.map_err(|error| complaint(path, &error))?;
    let state = State::new(capabilities, state);
    let place = shared.enter(&capabilities.name, kind, Seen::Here, Some(name));
    let reader = Reader {
        shared: Arc::downgrade(shared),
        probe: Arc::clone(probe),
        capabilities: capabilities.clone(),
        place,
        kind,
        state,
    };
    let thread = thread::Builder::new().name("controller".into());
    let started = thread.spawn(move || reader.read(device));
    started.map_err(|error| format!("no thread for it: {error}"))?;
    Ok(())
}

/// Reads one device.
struct Reader {
    shared: Weak<Shared>,
    probe: Arc<dyn Probe>,
    capabilities: Capabilities,
    place: usize,
    kind: Kind,
    state: State,
}

impl Reader {
    /// Until it is unplugged, or nobody asks any more.
    fn read(mut self, mut device: File) {
        let mut reports = Reports::default();
        let mut record = [0; LENGTH];
        let mut pressed = presses(self.kind, &self.state);
        let mut until = [None; 2];
        while device.read_exact(&mut record).is_ok() {
            let Some(shared) = self.shared.upgrade() else {
                return;
            };
            match reports.take(parse(&record), &mut self.state) {
                Outcome::Incomplete => continue,
                Outcome::Complete(reported) => {
                    for (until, _) in until.iter_mut().zip(reported).filter(|(_, is)| *is) {
                        *until = Some(shared.now() + HOLDS);
                    }
                }
                Outcome::Lost => match self.probe.probe(&device, &self.capabilities) {
                    Ok(found) => self.state.find(found),
                    Err(_) => break,
                },
            }
            let mut held = held(self.kind, &self.state);
            if self.state.is_relative {
                held.until = until;
            }
            let now_pressed = presses(self.kind, &self.state);
            let new = now_pressed.iter().filter(|press| !pressed.contains(press));
            let new: Vec<Press> = new.copied().collect();
            pressed = now_pressed;
            let now = shared.now();
            lock(&shared.known)[self.place].integral.hold(held, now);
            if !new.is_empty() {
                lock(&shared.presses).extend(new);
                (shared.wake)();
            }
        }
        if let Some(shared) = self.shared.upgrade() {
            let now = shared.now();
            let mut known = lock(&shared.known);
            let known_here = &mut known[self.place];
            known_here.integral.let_go(now);
            known_here.file = None;
            known_here.presence.seen = Seen::Gone;
            drop(known);
            (shared.wake)();
        }
    }
}
