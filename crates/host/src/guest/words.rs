//! What a guest prints: it goes to the host's standard error once, and the last of it may be the reason for the end of its process.

use std::io::{PipeReader, PipeWriter, Read, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Bytes of the end that are remembered.
const REMEMBERED: usize = 2048;

/// What a guest has printed.
pub struct Words {
    last: Arc<Mutex<Vec<u8>>>,
    reader: JoinHandle<()>,
}

impl Words {
    /// A pipe to be printed into. `silent`: nothing of it is shown.
    pub fn new(silent: bool) -> std::io::Result<(Self, PipeWriter)> {
        let (pipe, printed) = std::io::pipe()?;
        let last = Arc::default();
        let reader = {
            let last = Arc::clone(&last);
            let read = move || forward(pipe, silent, &last);
            std::thread::Builder::new()
                .name("guest".into())
                .spawn(read)?
        };
        Ok((Self { last, reader }, printed))
    }

    /// The last that was printed, once the guest has ended; a process that it has left behind is waited for no longer than `longest`.
    pub fn last(&self, longest: Duration) -> String {
        let until = Instant::now() + longest;
        while !self.reader.is_finished() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        String::from_utf8_lossy(&last).trim_end().to_owned()
    }
}

fn forward(mut pipe: PipeReader, silent: bool, last: &Mutex<Vec<u8>>) {
    let mut bytes = [0; 4096];
    while let Ok(n @ 1..) = pipe.read(&mut bytes) {
        if !silent {
            // Nobody reads it: then it is lost, and the run goes on.
            let _ = std::io::stderr().write_all(&bytes[..n]);
        }
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        last.extend_from_slice(&bytes[..n]);
        let surplus = last.len().saturating_sub(REMEMBERED);
        last.drain(..surplus);
    }
}
