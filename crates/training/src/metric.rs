//! What a metric is, and what a measured one holds. The definitions of motion stand in the catalogue; a module declares
//! its own ones (for example an angle error) with the same types, and both are limited and scored alike.

use std::borrow::Cow;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::text::Text;

/// Which value of a metric is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// Smaller is better.
    LowerIsBetter,
    /// Larger is better.
    HigherIsBetter,
    /// A value in the middle is better than one on either side; the level's limit states where.
    Range,
    /// Neither side is better by itself: shown, never limited.
    Informative,
}

/// The part of the score that a metric belongs to (the categories that users of Eyesi expect, DOMAIN 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Category {
    /// What was to be done, and how well.
    TargetAchievement,
    /// Time and paths.
    Efficiency,
    /// How the instruments were moved.
    InstrumentHandling,
    /// What the tissue had to bear.
    TissueTreatment,
}

impl Category {
    /// All, in the order in which they are shown.
    pub const ALL: [Category; 4] = [
        Category::TargetAchievement,
        Category::Efficiency,
        Category::InstrumentHandling,
        Category::TissueTreatment,
    ];

    /// Name for people.
    pub const fn title(self) -> Text {
        match self {
            Category::TargetAchievement => Text::new("Zielerreichung", "Target achievement"),
            Category::Efficiency => Text::new("Effizienz", "Efficiency"),
            Category::InstrumentHandling => Text::new("Instrumentenführung", "Instrument handling"),
            Category::TissueTreatment => Text::new("Gewebebehandlung", "Tissue treatment"),
        }
    }
}

/// Everything about a metric but its value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MetricDefinition {
    /// Unique name, lower case with hyphens.
    pub id: Cow<'static, str>,
    /// Name for people.
    pub title: Text,
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
    pub advice: Text,
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
    Stated(Text),
}

impl NotApplicable {
    /// The reason in words.
    pub fn text(&self) -> Text {
        match self {
            NotApplicable::NotMeasured => Text::new("nicht gemessen", "not measured"),
            NotApplicable::NoSamples => {
                Text::new("kein Instrument wurde erfasst", "no instrument was tracked")
            }
            NotApplicable::NotTwoHands => Text::new(
                "es wurden nicht genau zwei Instrumente erfasst",
                "not exactly two instruments were tracked",
            ),
            NotApplicable::NotTogether => Text::new(
                "die Instrumente wurden nicht lange genug gleichzeitig erfasst",
                "the instruments were not tracked together for long enough",
            ),
            NotApplicable::NoShortestPath => Text::new(
                "die Aufgabe hat keinen kürzesten Weg",
                "the task has no shortest path",
            ),
            NotApplicable::SegmentTooShort => Text::new(
                "jeder zusammenhängende Abschnitt ist zu kurz",
                "every contiguous stretch is too short",
            ),
            NotApplicable::SampleRateTooLow => {
                Text::new("zu wenige Messwerte je Sekunde", "too few samples a second")
            }
            NotApplicable::NoMotion => Text::new(
                "keine Bewegung, die sich beurteilen lässt",
                "no motion that can be evaluated",
            ),
            NotApplicable::Overflow => Text::new(
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
