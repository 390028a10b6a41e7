//! Listening to an input without running a module: as long as is asked for, until its end, or until Ctrl-C.

use crate::cli::ListenArgs;
use crate::output::Problem;
use crate::progress::Progress;
use crate::run::ENDING;
use microsim_host::assemble::{Input, Installation};
use microsim_host::listen::Listener;
use microsim_message::InputSample;
use microsim_settings::{Translator, load_translator};
use microsim_tracking::MarkedInstrument;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What came.
#[derive(Debug, Default)]
pub struct Listened {
    /// In the order of their arrival, each with when it arrived since the start \[s\].
    pub samples: Vec<(f64, InputSample)>,
    /// Samples that the source dropped.
    pub dropped: u64,
    /// How long it was listened \[s\].
    pub duration: f64,
}

/// Most samples that are taken: an hour of nine devices at 300 Hz.
const MOST_SAMPLES: usize = 10_000_000;

/// Listens. A live source is listened to for `default` seconds where nothing else is asked for.
pub fn listen(
    installation: &Installation,
    args: &ListenArgs,
    default: f64,
) -> Result<Listened, Problem> {
    let mut listener = Listener::open(installation, &args.input)?;
    let is_live = matches!(args.input, Input::Plugin(_) | Input::OpenIgtLink(_));
    let seconds = match (args.seconds, is_live) {
        (Some(seconds), _) => seconds,
        (None, true) => default,
        (None, false) => f64::INFINITY,
    };
    let stop = Arc::new(AtomicBool::new(false));
    for signal in ENDING {
        signal_hook::flag::register_conditional_shutdown(signal, 2, Arc::clone(&stop))?;
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    let progress = Progress::new();
    let mut listened = Listened::default();
    let start = Instant::now();
    while !stop.load(Ordering::Relaxed) && listened.duration < seconds {
        let heard = listener.tick().map_err(|failure| failure.to_string())?;
        listened.dropped += heard.dropped;
        listened.duration += listener.tick_s();
        let now = listened.duration;
        listened
            .samples
            .extend(heard.samples.into_iter().map(|sample| (now, sample)));
        if listened.samples.len() > MOST_SAMPLES {
            return Err(format!(
                "more than {MOST_SAMPLES} samples came; listen for a shorter time"
            )
            .into());
        }
        if heard.ended {
            break;
        }
        if is_live {
            let part = seconds.is_finite().then_some(now / seconds);
            progress.show(part, || format!("{} samples", listened.samples.len()));
            let due = start + Duration::from_secs_f64(now);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    }
    progress.clear();
    for failure in listener.stop() {
        crate::output::complain(failure);
    }
    Ok(listened)
}

/// What the translator's file states.
pub fn translator(installation: &Installation) -> Result<Translator, Problem> {
    let path = installation.setting("translator.toml");
    Ok(load_translator(&path).map_err(|e| e.to_string())?.settings)
}

/// The device of a tool among those that sent something: one that the translator's file lists for it, or the one of its own name.
pub fn device_of(translator: &Translator, tool: &str, samples: &[(f64, InputSample)]) -> String {
    let listed = translator.device.iter();
    let listed = listed.filter(|device| device.tool == tool || device.name == tool);
    let mut names = listed.map(|device| &device.name[..]).chain([tool]);
    let has_come = |name: &&str| samples.iter().any(|(_, sample)| sample.device == *name);
    names.find(has_come).unwrap_or(tool).to_owned()
}

/// Samples in which markers have become the devices that they make up.
pub fn without_markers(
    translator: &Translator,
    samples: Vec<(f64, InputSample)>,
) -> Result<Vec<(f64, InputSample)>, Problem> {
    let instruments = translator.markers.iter().map(|tool| tool.instrument());
    let mut instruments: Vec<MarkedInstrument> = instruments.collect::<Result<_, _>>()?;
    if instruments.is_empty() {
        return Ok(samples);
    }
    let mut all = Vec::new();
    let mut complete = Vec::new();
    let mut last = 0.0;
    for (arrival, sample) in samples {
        last = arrival;
        let mut taken = instruments.iter_mut();
        if !taken.any(|instrument| instrument.add(&sample, &mut complete)) {
            all.push((arrival, sample));
        }
        all.extend(complete.drain(..).map(|(sample, _)| (arrival, sample)));
    }
    let rest = instruments.iter_mut().filter_map(MarkedInstrument::finish);
    all.extend(rest.map(|(sample, _)| (last, sample)));
    Ok(all)
}
