//! What can go wrong with a picture.

use std::fmt;

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RenderError {
    /// A side is zero or larger than the adapter can draw.
    Size {
        /// Width that was asked for \[pixels\].
        width: u32,
        /// Height that was asked for \[pixels\].
        height: u32,
        /// Largest side of this adapter \[pixels\].
        max: u32,
    },
    /// The view has impossible numbers.
    View {
        /// Which, and what is allowed.
        reason: &'static str,
    },
    /// An item has impossible numbers.
    Item {
        /// Its place in the picture's list.
        index: usize,
        /// Which, and what is allowed.
        reason: &'static str,
    },
    /// A body has impossible numbers.
    Tissue {
        /// Its place in the picture's list.
        index: usize,
        /// Which, and what is allowed.
        reason: &'static str,
    },
    /// The driver refused or failed.
    Device {
        /// Its message.
        reason: String,
    },
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { width, height, max } => {
                write!(
                    f,
                    "a picture of {width} × {height} pixels cannot be drawn; each side must be 1 to {max}"
                )
            }
            Self::View { reason } => write!(f, "view of the picture: {reason}"),
            Self::Item { index, reason } => write!(f, "item {index} of the picture: {reason}"),
            Self::Tissue { index, reason } => write!(f, "body {index} of the picture: {reason}"),
            Self::Device { reason } => write!(f, "the graphics driver failed: {reason}"),
        }
    }
}

impl std::error::Error for RenderError {}
