//! Plugins in a process of their own, over the same contract of bytes: what the installation did not bring must not be able to end the host.
//!
//! The host asks, the guest answers; a guest that is silent for longer than its deadline is killed, and one that ends for whatever reason is
//! named. Here: the host's side. Not here: the guest's (`serve`), the bytes (`wire`), opening a library (module `library`).
//!
//! The clock decides only whether a guest has ended, and in which tick: that is an input of a run like the motion of a hand, and
//! recorded. Nothing that is computed depends on it.

mod channel;
mod serve;
mod wire;
mod words;

pub use serve::serve;

use abi_stable::{
    sabi_trait::TD_Opaque,
    std_types::{ROption, RResult, RSlice, RStr, RVec},
};
use channel::{receive_with, send_with};
use microsim_abi::{
    Call, Fault, FaultKind, Output, ParallelFor, PluginBox, PluginObject, PluginObject_TO,
};
use std::io::{ErrorKind, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use wire::{Ask, Message, NO_LIMIT, Reading};
use words::Words;

/// Time for starting a process and opening a library, which a cold disk makes long.
const START: Duration = Duration::from_secs(10);
/// How long a process that has hung up, or was killed, may take to end.
const END: Duration = Duration::from_millis(200);
/// How long the host waits at a time where there is no deadline.
const SLICE: Duration = Duration::from_secs(1);
/// Without a deadline, what a guest still has once the operator has asked for the end.
const GRACE: Duration = Duration::from_millis(500);

const HUNG_UP: &str = "its process closed the channel to the host";

/// How guests run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GuestRules {
    /// The program that serves as a guest's process when it is called with `guest`: MicroSim itself.
    pub program: PathBuf,
    /// Longest time for the answer to one call; `None`: as long as it takes, in a replay, and for a debugger.
    pub deadline: Option<Duration>,
    /// Most memory that a guest may map \[B\]; `None`: as much as it likes, for a debugger.
    pub memory: Option<u64>,
    /// What a guest prints is dropped: where a run is computed once more for its pictures.
    pub silent: bool,
}

/// A plugin in a process of its own.
pub struct Guest {
    rules: GuestRules,
    process: Child,
    channel: UnixStream,
    words: Words,
    ended: Arc<AtomicBool>,
}

impl Guest {
    /// Starts a process, opens the library in it and makes the plugin's object there. The error is the reason for refusing the library.
    pub fn start(
        name: &str,
        library: &Path,
        manifest: &str,
        rules: &GuestRules,
    ) -> Result<Self, String> {
        let (channel, theirs) = UnixStream::pair().map_err(cannot)?;
        let (words, printed) = Words::new(rules.silent).map_err(cannot)?;
        let mut command = Command::new(&rules.program);
        command
            .arg("guest")
            .stdin(OwnedFd::from(theirs))
            // Results of the program itself go to standard output: a guest must not write among them.
            .stdout(printed.try_clone().map_err(cannot)?)
            .stderr(printed);
        let process = command
            .spawn()
            .map_err(|e| format!("no process for it: {}: {e}", rules.program.display()))?;
        // It holds the other ends of the channel and of what is printed.
        drop(command);
        if rules.memory.is_none() {
            let id = process.id();
            tracing::warn!(
                "plugin \"{name}\" is process {id}, without limits: a debugger may be attached"
            );
        }
        let mut guest = Self {
            rules: rules.clone(),
            process,
            channel,
            words,
            ended: Arc::default(),
        };
        let mut load = Message::ask(Ask::Load);
        load.number(rules.memory.unwrap_or(NO_LIMIT));
        load.path(library);
        load.bytes(manifest.as_bytes());
        let longest = rules.deadline.map_or(START, |deadline| deadline.max(START));
        let deadline = rules.memory.map(|_| longest);
        let loaded = guest.ask_within(&load, deadline, |_| Some(()));
        loaded.map_err(|fault| fault.text.into_string())?;
        Ok(guest)
    }

    /// Becomes true when its process has ended.
    pub fn ended(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.ended)
    }

    /// As every other plugin.
    pub fn into_plugin(self) -> PluginBox {
        PluginObject_TO::from_value(self, TD_Opaque)
    }

    fn ask<T>(
        &mut self,
        request: &Message,
        read: impl FnOnce(&mut Reading<'_>) -> Option<T>,
    ) -> RResult<T, Fault> {
        self.ask_within(request, self.rules.deadline, read).into()
    }

    fn ask_within<T>(
        &mut self,
        request: &Message,
        deadline: Option<Duration>,
        read: impl FnOnce(&mut Reading<'_>) -> Option<T>,
    ) -> Result<T, Fault> {
        let reply = self.exchange(&request.0, deadline);
        reply.and_then(|reply| {
            let answer = Reading(&reply).reply(read);
            answer.unwrap_or_else(|| Err(self.end("its process answered with what is no answer")))
        })
    }

    fn exchange(&mut self, request: &[u8], deadline: Option<Duration>) -> Result<Vec<u8>, Fault> {
        let begun = Instant::now();
        let patience = Patience {
            longest: deadline,
            until: deadline.map(|deadline| begun + deadline),
        };
        match patience.exchange(&mut self.channel, request) {
            Ok(Some(reply)) => Ok(reply),
            Ok(None) => Err(self.end(HUNG_UP)),
            Err(error) => Err(match error.kind() {
                ErrorKind::TimedOut => {
                    let waited = deadline.unwrap_or_else(|| begun.elapsed()).as_millis();
                    // Nothing else is known of it, and nobody has to wait for more.
                    self.kill();
                    self.ended_how(
                        None,
                        &format!("its process gave no answer within {waited} ms"),
                    )
                }
                ErrorKind::BrokenPipe | ErrorKind::ConnectionReset => self.end(HUNG_UP),
                _ => self.end(&format!("its process: {error}")),
            }),
        }
    }

    /// Ends a process that should not go on. The fault states how it has ended, or `otherwise` if it had not by itself.
    fn end(&mut self, otherwise: &str) -> Fault {
        let status = self.wait(END);
        self.kill();
        self.ended_how(status, otherwise)
    }

    fn kill(&mut self) {
        // Gone already is as good.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }

    /// How the process, which is gone now, has ended by itself (`status`), or why it was killed.
    fn ended_how(&mut self, status: Option<ExitStatus>, killed: &str) -> Fault {
        self.ended.store(true, Ordering::Relaxed);
        let last = self.words.last(END);
        let how = match status.map(|status| (status.signal(), status.code())) {
            // It may be killed while it is still busy with giving up.
            _ if ran_out_of_memory(&last) => match self.rules.memory {
                Some(limit) => {
                    let limit = limit >> 20;
                    format!("its process ran into its memory limit of {limit} MiB")
                }
                None => "its process got no more memory".to_owned(),
            },
            None => format!("{killed} and was killed"),
            Some((Some(signal), _)) => {
                let signal = signal_name(signal);
                format!("its process was ended by the signal {signal}")
            }
            Some((None, code)) => {
                let code = code.unwrap_or_default();
                format!("its process ended by itself, with exit status {code}")
            }
        };
        let text = match last.lines().last() {
            Some(line) if !line.is_empty() => format!("{how}; the last that it printed: {line}"),
            _ => how,
        };
        Fault {
            kind: FaultKind::Error,
            text: text.into(),
        }
    }

    /// Waits for the end of the process.
    fn wait(&mut self, longest: Duration) -> Option<ExitStatus> {
        let until = Instant::now() + longest;
        loop {
            match self.process.try_wait() {
                Ok(None) if Instant::now() < until => {
                    std::thread::sleep(Duration::from_millis(1));
                }
                Ok(status) => return status,
                Err(_) => return None,
            }
        }
    }
}

/// How long the host waits for a guest.
struct Patience {
    longest: Option<Duration>,
    until: Option<Instant>,
}

impl Patience {
    /// Sends a request and receives the reply; `None`: the guest has hung up.
    fn exchange(
        mut self,
        channel: &mut UnixStream,
        request: &[u8],
    ) -> std::io::Result<Option<Vec<u8>>> {
        let patience = &mut self;
        send_with(request, &mut |bytes| {
            channel.set_write_timeout(Some(patience.left()?))?;
            patience.try_once(channel.write(bytes))
        })?;
        receive_with(&mut |bytes| {
            channel.set_read_timeout(Some(patience.left()?))?;
            patience.try_once(channel.read(bytes))
        })
    }

    /// How long to wait now.
    fn left(&self) -> std::io::Result<Duration> {
        let left = match self.until {
            Some(until) => until.saturating_duration_since(Instant::now()),
            None => SLICE,
        };
        match left.is_zero() {
            true => Err(ErrorKind::TimedOut.into()),
            false => Ok(left),
        }
    }

    /// What came of waiting once; `None`: nothing yet.
    fn try_once(&mut self, done: std::io::Result<usize>) -> std::io::Result<Option<usize>> {
        match done {
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(None),
            Err(error) if error.kind() == ErrorKind::Interrupted => {
                // A signal. Both processes may have been stopped for a while, and that time is not the guest's. The operator may have asked for the
                // end, and must not wait for ever where there is no deadline.
                self.until = Some(Instant::now() + self.longest.unwrap_or(GRACE));
                Ok(None)
            }
            done => done.map(Some),
        }
    }
}

impl Drop for Guest {
    fn drop(&mut self) {
        // It ends when the host hangs up; one that does not is killed.
        let _ = self.channel.shutdown(std::net::Shutdown::Both);
        if self.wait(END).is_none() {
            self.kill();
        }
        self.words.last(END);
    }
}

fn cannot(error: std::io::Error) -> String {
    format!("no process for it: {error}")
}

/// What Rust's standard library prints when it gets no memory, before it aborts.
fn ran_out_of_memory(printed: &str) -> bool {
    printed.contains("memory allocation of ")
}

fn signal_name(signal: i32) -> String {
    let name = signal_hook::low_level::signal_name(signal);
    name.map_or_else(|| signal.to_string(), str::to_owned)
}

fn nothing(_: &mut Reading<'_>) -> Option<()> {
    Some(())
}

impl PluginObject for Guest {
    fn initialise(&mut self, setup: RSlice<'_, u8>, _: ROption<ParallelFor>) -> RResult<(), Fault> {
        let mut message = Message::ask(Ask::Initialise);
        message.bytes(&setup);
        self.ask(&message, nothing)
    }

    fn reset(&mut self) -> RResult<(), Fault> {
        self.ask(&Message::ask(Ask::Reset), nothing)
    }

    fn process(&mut self, call: Call<'_>) -> RResult<Output, Fault> {
        let mut message = Message::ask(Ask::Process);
        message.call(&call);
        self.ask(&message, |reply| reply.output())
    }

    fn save(&mut self) -> RResult<RVec<u8>, Fault> {
        let save = Message::ask(Ask::Save);
        self.ask(&save, |reply| Some(reply.bytes()?.to_vec().into()))
    }

    fn restore(&mut self, state: RSlice<'_, u8>) -> RResult<(), Fault> {
        let mut message = Message::ask(Ask::Restore);
        message.bytes(&state);
        self.ask(&message, nothing)
    }

    fn extension(
        &mut self,
        name: RStr<'_>,
        request: RSlice<'_, u8>,
    ) -> RResult<ROption<RVec<u8>>, Fault> {
        let mut message = Message::ask(Ask::Extension);
        message.bytes(name.as_bytes());
        message.bytes(&request);
        self.ask(&message, |reply| match reply.number()? {
            0 => Some(ROption::RNone),
            _ => Some(ROption::RSome(reply.bytes()?.to_vec().into())),
        })
    }

    fn stop(&mut self) -> RResult<(), Fault> {
        self.ask(&Message::ask(Ask::Stop), nothing)
    }
}
