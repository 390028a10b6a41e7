//! The other end: what runs in the process of a guest.

use super::channel::{receive, send};
use super::wire::{Ask, Message, NO_LIMIT, Reading, optional};
use crate::library;
use abi_stable::std_types::{ROption, RSlice, RString};
use microsim_abi::{Fault, FaultKind, PluginBox};
use rustix::process::{Resource, Rlimit, Signal, set_parent_process_death_signal, setrlimit};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;

/// Serves the host that has started this process, until it hangs up. The channel is standard input, of which the plugin reads nothing.
pub fn serve() -> std::io::Result<()> {
    // Before anything else: a guest that loops must not outlive its host.
    set_parent_process_death_signal(Some(Signal::KILL))?;
    let channel = std::io::stdin().as_fd().try_clone_to_owned()?;
    rustix::stdio::dup2_stdin(std::fs::File::open("/dev/null")?)?;
    let mut channel = UnixStream::from(channel);
    // Somebody has called it by hand.
    channel.peer_addr()?;
    let mut plugin = None;
    while let Some(request) = receive(&mut channel)? {
        let reply = answer(&mut plugin, &request)
            .ok_or_else(|| std::io::Error::other("the host has asked for something unknown"))?;
        send(&mut channel, &reply.0)?;
    }
    Ok(())
}

fn error(text: impl Into<RString>) -> Fault {
    Fault {
        kind: FaultKind::Error,
        text: text.into(),
    }
}

/// The reply to one request; `None`: it is none.
fn answer(plugin: &mut Option<PluginBox>, request: &[u8]) -> Option<Message> {
    let mut request = Reading(request);
    let ask = Ask::of(request.number()?)?;
    if ask == Ask::Load {
        let memory = request.number()?;
        let path = PathBuf::from(request.text()?);
        let manifest = request.text()?;
        let loaded = limit(memory).and_then(|()| library::open(&path, manifest));
        return Some(Message::reply(loaded.map_err(error), |_, loaded| {
            *plugin = Some(loaded);
        }));
    }
    let plugin = plugin.as_mut()?;
    let nothing = |_: &mut Message, ()| ();
    Some(match ask {
        Ask::Load => return None,
        Ask::Initialise => {
            // The host's parallel loop is a callback, and none crosses to a guest.
            let setup = RSlice::from_slice(request.bytes()?);
            Message::reply(
                plugin.initialise(setup, ROption::RNone).into_result(),
                nothing,
            )
        }
        Ask::Reset => Message::reply(plugin.reset().into_result(), nothing),
        Ask::Process => {
            let output = request.call(|call| plugin.process(call))?;
            Message::reply(output.into_result(), |message, output| {
                message.output(&output)
            })
        }
        Ask::Save => Message::reply(plugin.save().into_result(), |message, state| {
            message.bytes(&state)
        }),
        Ask::Restore => {
            let state = RSlice::from_slice(request.bytes()?);
            Message::reply(plugin.restore(state).into_result(), nothing)
        }
        Ask::Extension => {
            let name = request.text()?;
            let asked = RSlice::from_slice(request.bytes()?);
            Message::reply(plugin.extension(name.into(), asked).into_result(), optional)
        }
        Ask::Stop => Message::reply(plugin.stop().into_result(), nothing),
    })
}

/// Limits what this process may map \[B\]; no dump of it is written, which would take longer than the host waits.
fn limit(memory: u64) -> Result<(), String> {
    let set = |resource, most| {
        let limit = Rlimit {
            current: Some(most),
            maximum: Some(most),
        };
        setrlimit(resource, limit).map_err(|e| format!("the limits of its process: {e}"))
    };
    match memory {
        NO_LIMIT => Ok(()),
        memory => {
            set(Resource::Core, 0)?;
            set(Resource::As, memory)
        }
    }
}
