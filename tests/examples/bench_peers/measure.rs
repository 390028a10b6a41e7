//! Our runs, measured as `tests/peers/beam.py` measures those of the other engines.

use crate::beam::Beam;
use crate::curve::{FirstPeak, Resting};
use microsim_tissue::{Method, Serial, Solver, State};
use rustix::time::{ClockId, clock_gettime};

/// Exact values \[m\], \[s\].
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    pub rest: f64,
    pub peak: f64,
    pub time: f64,
}

/// A first peak: height \[m\], time \[s\], and CPU time per simulated time until it was over.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    pub height: f64,
    pub time: f64,
    pub cpu_s_per_s: f64,
}

/// Coming to rest: CPU time \[s\] until the sag stays in the band, the sag's error in the end, and the CPU time of making the
/// solver, which contains the analysis of the mesh \[s\].
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    pub cpu_s: Option<f64>,
    pub error: f64,
    pub analysis_s: f64,
}

/// A sag \[m\] that no solution comes near.
const LOST: f64 = 0.2;
/// Between readings of the sag \[s\], for methods with shorter steps.
const SAMPLE: f64 = 0.5e-3;
/// A body that is not at rest by then is given up \[s\].
const NO_REST: f64 = 20.0;
/// A run is repeated until it has taken this CPU time \[s\], at most so often; the fastest counts.
const REPEAT: (f64, usize) = (1.0, 7);

/// A body in motion.
struct Run<'a> {
    beam: &'a Beam,
    solver: Box<dyn Solver>,
    state: State,
    step: f64,
    analysis: f64,
    /// CPU time of the steps so far \[s\].
    cpu: f64,
}

impl<'a> Run<'a> {
    fn new(beam: &'a Beam, method: &Method, step: f64) -> Result<Self, String> {
        let start = cpu_seconds();
        let solver = method.solver(&beam.model).map_err(|e| e.to_string())?;
        Ok(Self {
            beam,
            solver,
            state: State::at_rest(&beam.model),
            step,
            analysis: cpu_seconds() - start,
            cpu: 0.0,
        })
    }

    /// Makes steps, the only part whose time counts; returns the sag.
    fn advance(&mut self, steps: usize) -> Result<f64, String> {
        let Beam { model, control, .. } = self.beam;
        let start = cpu_seconds();
        for _ in 0..steps {
            let state = &mut self.state;
            self.solver
                .step(model, state, control, &[], self.step, &Serial)
                .map_err(|e| e.to_string())?;
        }
        self.cpu += cpu_seconds() - start;
        let sag = self.beam.sag(&self.state);
        if sag.is_finite() && sag.abs() < LOST {
            Ok(sag)
        } else {
            Err("comes apart".into())
        }
    }
}

/// CPU time of this process \[s\].
fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// The first peak.
pub fn first_peak(beam: &Beam, method: &Method, step: f64) -> Result<Peak, String> {
    let mut run = Run::new(beam, method, step)?;
    let steps = ((SAMPLE / step).round() as usize).max(1);
    let mut peak = FirstPeak::new(steps as f64 * step);
    while !peak.read(run.advance(steps)?)? {}
    let [height, time] = peak.top();
    Ok(Peak {
        height,
        time,
        cpu_s_per_s: run.cpu / peak.duration(),
    })
}

/// From release to where the sag is, and then stays, close to the exact one; given up after `cap` seconds of CPU time.
pub fn to_rest(
    beam: &Beam,
    method: &Method,
    step: f64,
    exact: &Exact,
    cap: f64,
) -> Result<Rest, String> {
    let mut run = Run::new(beam, method, step)?;
    let mut resting = Resting::new(step, exact.rest);
    let mut now = 0.0;
    loop {
        let sag = run.advance(1)?;
        now += step;
        let cpu_s = resting.read(sag, run.cpu);
        if cpu_s.is_some() || now > NO_REST || run.cpu > cap {
            return Ok(Rest {
                cpu_s,
                error: resting.error(sag),
                analysis_s: run.analysis,
            });
        }
    }
}

/// A measure repeated; `cost` decides which one is the fastest.
pub fn repeated<T>(
    mut measure: impl FnMut() -> Result<T, String>,
    cost: impl Fn(&T) -> f64,
) -> Result<T, String> {
    let start = cpu_seconds();
    let mut best = measure()?;
    for _ in 1..REPEAT.1 {
        if cpu_seconds() - start > REPEAT.0 {
            break;
        }
        let next = measure()?;
        if cost(&next) < cost(&best) {
            best = next;
        }
    }
    Ok(best)
}
