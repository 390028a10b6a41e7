//! What a metric is, and what a measured one holds. The definitions of motion stand in the catalogue; a module declares
//! its own ones (for example an angle error) with the same types, and both are limited and scored alike.

use std::borrow::Cow;
use std::fmt;

use serde::{Deserialize, Serialize};

use microsim_vocabulary::{Category, Direction, LocalText};

/// Everything about a metric but its value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MetricDefinition {
    /// Unique name, lower case with hyphens.
    pub id: Cow<'static, str>,
    /// Name for people.
    pub title: LocalText,
    /// SI unit of the value; "1" for a number or fraction.
    pub unit: Cow<'static, str>,
    /// Unit in which people read it.
    pub display_unit: Cow<'static, str>,
    /// Value in the display unit = value × factor.
    pub display_factor: f64,
    /// Digits after the point in the display unit.
    pub decimals: u8,
    /// Which side is better.
    pub direction: Direction,
    /// Part of the score that it counts for.
    pub category: Category,
    /// Name and version of the formula: values of different formulas are not comparable.
    pub formula: Cow<'static, str>,
    /// Where the definition comes from.
    pub source: Cow<'static, str>,
    /// What the trainee can do to improve it: one sentence.
    pub advice: LocalText,
}

/// Why a metric has no value. Ordered by how far its computation came: of several segments without a value, the one that
/// came furthest gives the reason.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NotApplicable {
    /// Nothing was reported for it.
    NotMeasured,
    /// No tool was ever tracked.
    NoSamples,
    /// Not exactly two tools were tracked.
    NotTwoHands,
    /// Two tools were tracked, but never at the same time for long enough.
    NotTogether,
    /// The level states no shortest path.
    NoShortestPath,
    /// Every contiguous stretch of motion is too short.
    SegmentTooShort,
    /// Too few samples a second.
    SampleRateTooLow,
    /// Nothing moved, or nothing that differs from an even motion.
    NoMotion,
    /// The numbers are so large that the result overflows.
    Overflow,
    /// A module's own reason.
    Stated(LocalText),
}

impl NotApplicable {
    /// The reason in words.
    pub fn text(&self) -> LocalText {
        match self {
            NotApplicable::NotMeasured => LocalText::fixed("nicht gemessen", "not measured"),
            NotApplicable::NoSamples => {
                LocalText::fixed("kein Instrument wurde erfasst", "no instrument was tracked")
            }
            NotApplicable::NotTwoHands => LocalText::fixed(
                "es wurden nicht genau zwei Instrumente erfasst",
                "not exactly two instruments were tracked",
            ),
            NotApplicable::NotTogether => LocalText::fixed(
                "die Instrumente wurden nicht lange genug gleichzeitig erfasst",
                "the instruments were not tracked together for long enough",
            ),
            NotApplicable::NoShortestPath => LocalText::fixed(
                "die Aufgabe hat keinen kürzesten Weg",
                "the task has no shortest path",
            ),
            NotApplicable::SegmentTooShort => LocalText::fixed(
                "jeder zusammenhängende Abschnitt ist zu kurz",
                "every contiguous stretch is too short",
            ),
            NotApplicable::SampleRateTooLow => {
                LocalText::fixed("zu wenige Messwerte je Sekunde", "too few samples a second")
            }
            NotApplicable::NoMotion => LocalText::fixed(
                "keine Bewegung, die sich beurteilen lässt",
                "no motion that can be evaluated",
            ),
            NotApplicable::Overflow => LocalText::fixed(
                "der Zahlenbereich reicht nicht",
                "the numbers are too large",
            ),
            NotApplicable::Stated(text) => text.clone(),
        }
    }
}

impl fmt::Display for NotApplicable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text().en)
    }
}

/// A measured metric: a number, or the reason why there is none. A metric that cannot be formed is never zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MetricValue {
    /// The value in the SI unit of the definition: a finite number.
    Value(f64),
    /// There is none.
    NotApplicable(NotApplicable),
}

impl MetricValue {
    /// The number, if there is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            MetricValue::Value(value) => Some(*value),
            MetricValue::NotApplicable(_) => None,
        }
    }
}

impl From<Result<f64, NotApplicable>> for MetricValue {
    fn from(result: Result<f64, NotApplicable>) -> Self {
        match result {
            Ok(value) if value.is_finite() => MetricValue::Value(value),
            Ok(_) => MetricValue::NotApplicable(NotApplicable::Overflow),
            Err(reason) => MetricValue::NotApplicable(reason),
        }
    }
}
