//! Texts for people and the languages that they are in.

use crate::terms;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A text for people, in both languages of the program.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalText {
    /// German.
    pub de: Cow<'static, str>,
    /// English.
    pub en: Cow<'static, str>,
}

impl LocalText {
    /// A text known when the program is built.
    pub const fn fixed(de: &'static str, en: &'static str) -> Self {
        Self {
            de: Cow::Borrowed(de),
            en: Cow::Borrowed(en),
        }
    }

    /// A text from its two languages.
    pub fn new(de: impl Into<Cow<'static, str>>, en: impl Into<Cow<'static, str>>) -> Self {
        Self {
            de: de.into(),
            en: en.into(),
        }
    }
}

terms! {
    /// A language of pages.
    pub enum Language {
        /// German.
        German = "de",
        /// English.
        English = "en",
    }
}
