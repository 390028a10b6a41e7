//! The one place where calls cross: bytes become types, panics become faults.

use crate::fault::Fault;
use crate::panic::{caught, install_hook};
use crate::parallel::Parallel;
use crate::plugin::{Plugin, Services};
use crate::tick::Tick;
use abi_stable::{
    sabi_trait::TD_Opaque,
    std_types::{ROption, RResult, RSlice, RStr, RVec},
};
use microsim_abi::{
    BlockOut, Call, Fault as AbiFault, FaultKind, Output, ParallelFor, PluginBox, PluginObject,
    PluginObject_TO,
};
use microsim_bus::{BlockView, Frames};
use microsim_message::{Log, Setup, decode, decode_bytes};
use std::mem::ManuallyDrop;

fn guarded<T>(call: impl FnOnce() -> Result<T, Fault>) -> RResult<T, AbiFault> {
    match caught(call) {
        Ok(Ok(value)) => RResult::ROk(value),
        Ok(Err(fault)) => RResult::RErr(fault.to_abi()),
        Err(panic) => {
            let text = panic.into_text().replace('\n', " ");
            RResult::RErr(AbiFault {
                kind: FaultKind::Panic,
                text: text.into(),
            })
        }
    }
}

/// What stands behind the boundary: a plugin that is not called again once it has panicked.
struct Boundary<P> {
    plugin: ManuallyDrop<P>,
    panicked: bool,
}

impl<P> Drop for Boundary<P> {
    fn drop(&mut self) {
        // A panic here has nobody to be reported to, and must not cross.
        let _ = guarded(|| {
            // SAFETY: dropped once, here.
            unsafe { ManuallyDrop::drop(&mut self.plugin) };
            Ok(())
        });
    }
}

impl<P: Plugin> Boundary<P> {
    fn cross<T>(&mut self, call: impl FnOnce(&mut P) -> Result<T, Fault>) -> RResult<T, AbiFault> {
        if self.panicked {
            let text = "called again after a panic".into();
            return RResult::RErr(AbiFault {
                kind: FaultKind::Panic,
                text,
            });
        }
        let result = guarded(|| call(&mut self.plugin));
        self.panicked = matches!(&result, RResult::RErr(f) if f.kind == FaultKind::Panic);
        result
    }
}

impl<P: Plugin> PluginObject for Boundary<P> {
    fn initialise(
        &mut self,
        setup: RSlice<'_, u8>,
        parallel: ROption<ParallelFor>,
    ) -> RResult<(), AbiFault> {
        self.cross(|plugin| {
            let setup: Setup = decode_bytes(setup.as_slice())?;
            let parallel = Parallel::from_host(parallel.into_option());
            plugin.initialise(&setup, Services { parallel })
        })
    }

    fn reset(&mut self) -> RResult<(), AbiFault> {
        self.cross(|plugin| plugin.reset())
    }

    fn process(&mut self, call: Call<'_>) -> RResult<Output, AbiFault> {
        let mut log = Vec::new();
        let result = self.cross(|plugin| {
            let blocks =
                call.blocks.as_slice().iter().map(|b| {
                    BlockView::new(b.words.as_slice()).map_err(|e| Fault::new(e.to_string()))
                });
            let mut tick = Tick {
                index: call.tick,
                time_ns: call.time_ns,
                tick_ns: call.tick_ns,
                steps: call.steps,
                messages: call.messages.as_slice(),
                blocks: blocks.collect::<Result<_, _>>()?,
                out: Vec::new(),
                out_blocks: Vec::new(),
            };
            // What it has said before it failed is not lost with it.
            let done = caught(|| plugin.process(&mut tick));
            if !matches!(done, Ok(Ok(()))) {
                log = logged(&tick.out);
            }
            match done {
                Ok(done) => done?,
                Err(panic) => panic.resume(),
            }
            let blocks = tick.out_blocks.into_iter();
            Ok(Output {
                messages: tick.out.into(),
                blocks: blocks
                    .map(|(kind, words)| BlockOut {
                        kind,
                        words: words.into(),
                    })
                    .collect(),
            })
        });
        match result {
            RResult::RErr(fault) if !log.is_empty() => RResult::RErr(AbiFault {
                text: format!("{} (logged in this tick: {})", fault.text, log.join("; ")).into(),
                ..fault
            }),
            result => result,
        }
    }

    fn save(&mut self) -> RResult<RVec<u8>, AbiFault> {
        self.cross(|plugin| Ok(plugin.save().into()))
    }

    fn restore(&mut self, state: RSlice<'_, u8>) -> RResult<(), AbiFault> {
        self.cross(|plugin| plugin.restore(state.as_slice()))
    }

    fn extension(
        &mut self,
        name: RStr<'_>,
        request: RSlice<'_, u8>,
    ) -> RResult<ROption<RVec<u8>>, AbiFault> {
        self.cross(|plugin| {
            let answer = match name.as_str() {
                microsim_abi::STATE_HASHED => plugin.hashed(),
                name => plugin.extension(name, request.as_slice())?,
            };
            Ok(answer.map(RVec::from).into())
        })
    }

    fn stop(&mut self) -> RResult<(), AbiFault> {
        self.cross(|plugin| plugin.stop())
    }
}

/// The lines of the log among published messages.
fn logged(messages: &[u8]) -> Vec<String> {
    let frames = Frames::new(messages).filter_map(Result::ok);
    let lines = frames.filter_map(|frame| decode::<Log>(&frame)?.ok());
    lines.map(|line| line.text.replace('\n', " ")).collect()
}

/// Constructs a plugin behind the boundary.
pub fn create<P: Plugin>() -> RResult<PluginBox, AbiFault> {
    install_hook();
    guarded(|| {
        let plugin = ManuallyDrop::new(P::new());
        let boundary = Boundary {
            plugin,
            panicked: false,
        };
        Ok(PluginObject_TO::from_value(boundary, TD_Opaque))
    })
}
