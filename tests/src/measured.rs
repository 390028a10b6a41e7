//! CPU time and memory of the program, as the kernel counts them.

use rustix::time::{ClockId, clock_gettime};
use std::fs;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Pause between two looks at a running process.
const LOOK: Duration = Duration::from_millis(5);

/// Clock ticks of the kernel per second in `/proc`: 100 on every Linux (`USER_HZ`).
const HERTZ: f64 = 100.0;

/// CPU time of this thread so far \[s\].
pub fn thread_time() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// What a command cost.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// CPU time of all threads \[s\].
    pub cpu: f64,
    /// Largest resident memory \[MB\], of 10⁶ bytes.
    pub memory: f64,
}

/// Runs a command to its end, its output thrown away.
///
/// # Panics
/// If it does not end with status 0, or this is no Linux.
pub fn cost(command: &mut Command) -> Cost {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null());
    let mut child = quiet.spawn().expect("the program starts");
    let folder = format!("/proc/{}", child.id());
    let mut memory = 0.0;
    let cpu = loop {
        let (cpu, has_ended) = cpu_time(child.id()).expect("a Linux");
        if has_ended {
            break cpu;
        }
        let status = fs::read_to_string(format!("{folder}/status")).unwrap_or_default();
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let peak = peak.and_then(|peak| peak.trim().strip_suffix(" kB")?.parse::<f64>().ok());
        memory = peak.map_or(memory, |kib| kib * 1024.0 / 1e6);
        std::thread::sleep(LOOK);
    };
    let status = child.wait().expect("the program ends");
    assert!(status.success(), "{command:?}: {status}");
    Cost { cpu, memory }
}

/// CPU time of all threads of a process that this one started and has not waited for \[s\], and whether it has ended. What has ended is not
/// reaped until then, so that its times can still be read. `None` where this is no Linux.
pub fn cpu_time(process: u32) -> Option<(f64, bool)> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // Behind the name, which stands in parentheses: the state is the third field, user and system time the 14th and 15th.
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |n: usize| fields.get(n - 3)?.parse::<f64>().ok();
    Some(((ticks(14)? + ticks(15)?) / HERTZ, *fields.first()? == "Z"))
}
