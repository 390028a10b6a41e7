//! A text in the two languages of the simulator.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// The same sentence in German and in English.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Text {
    /// German.
    pub de: Cow<'static, str>,
    /// English.
    pub en: Cow<'static, str>,
}

impl Text {
    /// A text known when the program is built.
    pub const fn new(de: &'static str, en: &'static str) -> Self {
        Text {
            de: Cow::Borrowed(de),
            en: Cow::Borrowed(en),
        }
    }
}
