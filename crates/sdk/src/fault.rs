//! Why a plugin cannot do what it was asked.

use microsim_abi::{Fault as AbiFault, FaultKind};
use microsim_message::DecodeError;
use microsim_training::DwellError;
use std::fmt;

/// The error of a plugin: one sentence for a person, and whether it is only that something is missing on this machine.
///
/// ```
/// use microsim_sdk::Fault;
///
/// let fault = Fault::new("the level needs a [[tool]]");
/// assert!(!fault.unavailable);
/// assert_eq!(fault.to_string(), "the level needs a [[tool]]");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// One sentence.
    pub text: String,
    /// Something that the plugin needs is not on this machine; the host goes on without it where it can.
    pub unavailable: bool,
}

impl Fault {
    /// The plugin cannot go on.
    pub fn new(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            unavailable: false,
        }
    }

    /// Something that the plugin needs is not on this machine; the text names it.
    pub fn unavailable(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            unavailable: true,
        }
    }

    pub(crate) fn to_abi(&self) -> AbiFault {
        let kind = if self.unavailable {
            FaultKind::Unavailable
        } else {
            FaultKind::Error
        };
        AbiFault {
            kind,
            text: self.text.as_str().into(),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl std::error::Error for Fault {}

impl From<DecodeError> for Fault {
    fn from(error: DecodeError) -> Self {
        Self::new(error.to_string())
    }
}

impl From<DwellError> for Fault {
    fn from(error: DwellError) -> Self {
        Self::new(error.to_string())
    }
}

impl From<serde_json::Error> for Fault {
    fn from(error: serde_json::Error) -> Self {
        Self::new(format!("set-up does not fit this plugin: {error}"))
    }
}
