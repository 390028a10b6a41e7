//! Where the tools are: samples of tracked devices from a recording or a script, and their translation into the field; and how
//! synthetic trainees would move them.
//!
//! Pure: bytes, values and times in, values out. No files, no clocks, no sockets; the settings that it needs come in as
//! plain structs from whoever reads the configuration.
//!
//! # Frames and units
//! Lengths are in metres, times in seconds, orientations unit quaternions in the order x, y, z, w. A quaternion `a_from_b`
//! takes the components of a vector in frame b to those in frame a.
//!
//! | frame | what |
//! |---|---|
//! | device | the axes and origin of a tracker or recording; positions of [`InputSample`](microsim_message::InputSample) are in it |
//! | body | fixed to the handle that the tracker follows; a sample's orientation is `device_from_body` |
//! | field | the operating field, in which tools and tissue meet; poses of [`ToolSample`](microsim_message::ToolSample) are in it |
//! | tool | fixed to a tool, as its model was drawn; a pose's orientation is `field_from_tool` |

#![forbid(unsafe_code)]

mod calibration;
mod csv_recording;
mod desktop;
mod filter;
mod markers;
mod random;
mod rigid;
mod rotation;
mod script;
mod statistics;
mod trainee;
mod translator;

pub use calibration::{
    Dwell, LEAST_POSES, LEAST_SPREAD, LEAST_WIDTH, Pair, Pivot, PivotError, Registration,
    RegistrationError, dwells, pivot, register,
};
pub use csv_recording::{
    Column, ColumnMap, CsvError, CsvProblem, DeviceColumns, MAX_SAMPLES, OpeningColumn, Recording,
    read_csv,
};
pub use desktop::{DesktopHand, DesktopHandState, DesktopLimits, HandAngles};
pub use filter::{Filtered, OneEuro};
pub use markers::{
    FEWEST_MARKERS, MOST_MARKERS, MarkedInstrument, Marker, MarkerFit, MarkerLoss, MarkerModel,
    MarkerPoint, MarkerProblem,
};
pub use microsim_vocabulary::{Interpolation, ToolStatus};
pub use rotation::{NORM_TOLERANCE, QuaternionError, fixed_unit};
pub use script::{Keyframe, Script, ScriptError, ScriptProblem, ScriptTrack};
pub use statistics::{DEFAULT_GAP_INTERVALS, RawStatistics, distance};
pub use trainee::{Profile, Trainee};
pub use translator::{
    Clutch, Excess, HandLimits, Mapping, MappingProblem, MotionState, Opening, Refusal,
    SampleFault, StateMismatch, TrackedTool, Translator, TranslatorError, TranslatorState,
};
