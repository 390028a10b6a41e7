//! What metrics are compared and grouped by.

use crate::{LocalText, terms};

terms! {
    /// Which values of a metric are better.
    pub enum Direction {
        /// Lower values are better.
        Lower = "lower",
        /// Higher values are better.
        Higher = "higher",
        /// A value in the middle is better than one on either side; the limit of the level states where.
        Range = "range",
        /// Neither side is better by itself: it only informs.
        Inform = "inform",
    }
}

terms! {
    /// Which part of the score a metric belongs to (the categories that users of Eyesi expect, DOMAIN 2).
    pub enum Category {
        /// Target achievement: what was to be done, and how well.
        Target = "target",
        /// Efficiency: time and paths.
        Efficiency = "efficiency",
        /// Instrument handling: how the instruments were moved.
        Handling = "handling",
        /// Tissue treatment: what the tissue had to bear.
        Tissue = "tissue",
        /// Microscope: whether what is worked on is seen.
        Microscope = "microscope",
    }
}

impl Category {
    /// Its title for people.
    pub const fn title(self) -> LocalText {
        match self {
            Self::Target => LocalText::fixed("Zielerreichung", "Target achievement"),
            Self::Efficiency => LocalText::fixed("Effizienz", "Efficiency"),
            Self::Handling => LocalText::fixed("Instrumentenführung", "Instrument handling"),
            Self::Tissue => LocalText::fixed("Gewebebehandlung", "Tissue treatment"),
            Self::Microscope => LocalText::fixed("Mikroskop", "Microscope"),
        }
    }
}
