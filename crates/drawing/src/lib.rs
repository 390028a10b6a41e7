//! Parts of drawings and pages for people: axes with round numbers, numbers as text, SVG and HTML.
//!
//! Reports of sessions and charts of methods are put together from these. Everything is strings in memory; equal input
//! gives equal text. What is not here: what is drawn, its colours and its style sheets, and files.
#![forbid(unsafe_code)]

mod axis;
mod number;
mod page;
mod svg;

pub use axis::{LogAxis, Ticks, ValueAxis, value_range};
pub use number::{count, exponent, fixed, percent, significant, time};
pub use page::{PageHead, escape};
pub use svg::{Anchor, broken_line, localised_text, text};
