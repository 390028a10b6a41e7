//! Training: the state of a level, the metrics of a motion, the score.
//!
//! Here: what a trainee's tool did ([`MotionLog`]), what it is measured by ([`motion_metrics`], [`MOTION_METRICS`]), how
//! measurements become a verdict and a score ([`Rules`]), and the states that a level goes through ([`LevelMachine`],
//! [`Dwell`]). Modules call that; the report only reads the results. Over many attempts: learning curves ([`CusumPlan`]), when a level is mastered
//! ([`mastered_with`]), and where a value stands in a population ([`Population`]).
//!
//! Not here: files, messages, clocks, threads, and everything about one module's task. Times enter as arguments.
//!
//! Same bits everywhere: transcendental functions come from `libm`, sums run in a fixed order, the Fourier transform is
//! our own ([`fft`]). Units are SI; `display_unit` of a [`MetricDefinition`] is for people.

#![forbid(unsafe_code)]

mod catalogue;
mod cusum;
mod dwell;
pub mod fft;
mod level;
mod mastery;
mod measure;
mod metric;
mod motion;
mod parameter;
mod population;
mod score;
pub mod signal;
pub mod smoothness;
pub mod tremor;

pub use catalogue::{MOTION_METRICS, id};
pub use cusum::{CusumCurve, CusumDecision, CusumPlan};
pub use dwell::{Dwell, DwellError, DwellState};
pub use level::{
    LevelError, LevelEvent, LevelMachine, LevelPhase, LevelState, REASON_ABORTED,
    REASON_TARGETS_MISSED, Target,
};
pub use mastery::{mastered_with, passes_in_a_row};
pub use measure::{Measurement, motion_metrics};
pub use metric::{MetricDefinition, MetricValue, NotApplicable};
pub use microsim_vocabulary::{Category, Direction, LocalText};
pub use motion::{MotionBytesError, MotionError, MotionLog, path_length, rotation_angle};
pub use parameter::{MetricParameters, Parameter, ParameterError};
pub use population::{Population, Standing};
pub use score::{Assessment, CategoryScore, Limit, LimitError, Rules, ScoreRecord, TargetCount};
pub use tremor::tremor_rms;
