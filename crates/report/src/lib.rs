//! The report of a session: JSON, CSV and one self-contained HTML page.
//!
//! Here: reading the messages of a session into a [`Report`] and writing it for people and programs. Not here: scores,
//! verdicts and limits, which are the training's and only shown; files and clocks. Everything is strings in memory, and
//! equal sessions give equal strings.
//!
//! - [`Report`]: what a session holds; its JSON form has the field names of the struct.
//! - `device`, `motion`, `force`: what is read from the raw input, the tools and the contacts.
//! - `solver`: how far the solver of the tissue came.
//! - `implausible`: samples that no hand makes.
//! - `moment`: what happened when.
//! - `input`: what is known besides the messages.
//! - `table`: CSV. `html`: the page. `text`: its texts in both languages. `plot`: its drawings. `number`: how numbers are shown.
//!
//! # Times
//! All series and the `session_time` of lines are on one axis, the simulated time since the session began \[s\]. A message
//! belongs to the beginning of its tick. The samples of a tool keep the distances of the device's own clock; that clock is
//! laid on the axis by the tool's first sample.

#![forbid(unsafe_code)]

mod arrival;
mod build;
mod device;
mod force;
mod html;
mod implausible;
mod input;
mod marker;
mod moment;
mod motion;
mod number;
mod plot;
mod report;
mod solver;
mod table;
#[cfg(test)]
mod testing;
mod text;

pub use arrival::{ArrivalRecord, TimeSpread};
pub use build::ReportBuilder;
pub use device::DeviceRecord;
pub use force::ForceSeries;
pub use html::{Page, Pictures};
pub use implausible::{ImplausibleRecord, ImplausibleStretch};
pub use input::ReportInput;
pub use marker::MarkerRecord;
pub use microsim_vocabulary::Language;
pub use moment::{Moment, MomentKind};
pub use motion::{ToolPresence, ToolSeries};
pub use report::{EventRecord, MetricEntry, RecoveryRecord, Report, Verdict, Warning};
pub use solver::{Quantiles, SolverRecord};
