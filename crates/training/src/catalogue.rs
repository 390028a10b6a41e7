//! The metrics that need motion alone: one table, and the ids by which it is used.

use std::borrow::Cow;

use crate::metric::MetricDefinition;
use microsim_vocabulary::{Category, Direction, LocalText};

/// Ids of the motion metrics.
pub mod id {
    /// Running time of the level \[s\].
    pub const TIME: &str = "time";
    /// Path of the tips \[m\].
    pub const PATH_LENGTH: &str = "path-length";
    /// Shortest sensible path over path \[1\].
    pub const ECONOMY: &str = "economy";
    /// Sum of all turns of the tools \[rad\].
    pub const ANGULAR_PATH: &str = "angular-path";
    /// Box around the tip positions \[m³\].
    pub const WORKING_VOLUME: &str = "working-volume";
    /// Fraction of time at rest \[1\].
    pub const IDLE_FRACTION: &str = "idle-fraction";
    /// Number of movements \[1\].
    pub const MOVEMENTS: &str = "movements";
    /// Spectral arc length \[1\].
    pub const SPARC: &str = "sparc";
    /// Log dimensionless jerk \[1\].
    pub const LDLJ: &str = "ldlj";
    /// RMS in the tremor band \[m\].
    pub const TREMOR: &str = "tremor";
    /// Fraction of time in which both tools move \[1\].
    pub const BIMANUAL_FRACTION: &str = "bimanual-fraction";
    /// Correlation of both tools' speeds \[1\].
    pub const SPEED_CORRELATION: &str = "speed-correlation";
    /// Difference of both tools' paths over their sum \[1\].
    pub const PATH_ASYMMETRY: &str = "path-asymmetry";
}

/// Every metric that needs motion alone, in the order in which `motion_metrics` reports them.
pub static MOTION_METRICS: [MetricDefinition; 13] = [
    MetricDefinition {
        id: Cow::Borrowed(id::TIME),
        title: LocalText::fixed("Zeit", "Time"),
        unit: Cow::Borrowed("s"),
        display_unit: Cow::Borrowed("s"),
        display_factor: 1.0,
        decimals: 1,
        direction: Direction::Lower,
        category: Category::Efficiency,
        formula: Cow::Borrowed("time/1"),
        source: Cow::Borrowed("running time of the level without pauses"),
        advice: LocalText::fixed(
            "Legen Sie die Reihenfolge der Schritte fest, bevor Sie beginnen; das Tempo kommt mit dem sicheren Ablauf.",
            "Decide on the order of the steps before you begin; speed comes with a fixed sequence.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::PATH_LENGTH),
        title: LocalText::fixed("Weglänge", "Path length"),
        unit: Cow::Borrowed("m"),
        display_unit: Cow::Borrowed("mm"),
        display_factor: 1e3,
        decimals: 1,
        direction: Direction::Lower,
        category: Category::Efficiency,
        formula: Cow::Borrowed("path-length/1"),
        source: Cow::Borrowed(
            "sum of |p(k+1) - p(k)| inside contiguous segments; correlates with global rating, r = -0.37 (Grober 2003)",
        ),
        advice: LocalText::fixed(
            "Führen Sie die Spitze auf direktem Weg zum Ziel und ruhen Sie nahe am Arbeitsfeld.",
            "Move the tip to the target directly and rest close to the field.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::ECONOMY),
        title: LocalText::fixed("Bewegungsökonomie", "Economy of motion"),
        unit: Cow::Borrowed("1"),
        display_unit: Cow::Borrowed("%"),
        display_factor: 100.0,
        decimals: 0,
        direction: Direction::Higher,
        category: Category::Efficiency,
        formula: Cow::Borrowed("economy/1"),
        source: Cow::Borrowed("shortest sensible path of the level / path length"),
        advice: LocalText::fixed(
            "Sehen Sie zum nächsten Ziel, bevor Sie sich bewegen, und vermeiden Sie Umwege.",
            "Look at the next target before you move, and avoid detours.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::ANGULAR_PATH),
        title: LocalText::fixed("Winkelweg", "Angular path"),
        unit: Cow::Borrowed("rad"),
        display_unit: Cow::Borrowed("°"),
        display_factor: 180.0 / std::f64::consts::PI,
        decimals: 0,
        direction: Direction::Lower,
        category: Category::Handling,
        formula: Cow::Borrowed("angular-path/1"),
        source: Cow::Borrowed("sum of 2 acos|q(k) q(k+1)| inside contiguous segments"),
        advice: LocalText::fixed(
            "Richten Sie das Instrument vor dem Kontakt aus und rollen Sie es zwischen den Fingern, statt die Hand zu drehen.",
            "Align the instrument before contact and roll it between the fingers instead of turning the hand.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::WORKING_VOLUME),
        title: LocalText::fixed("Arbeitsraum", "Working volume"),
        unit: Cow::Borrowed("m³"),
        display_unit: Cow::Borrowed("mm³"),
        display_factor: 1e9,
        decimals: 0,
        direction: Direction::Lower,
        category: Category::Handling,
        formula: Cow::Borrowed("working-volume-box/1"),
        source: Cow::Borrowed("volume of the axis-parallel box around all tip positions"),
        advice: LocalText::fixed(
            "Bleiben Sie mit der Spitze im Arbeitsfeld, auch zwischen zwei Schritten.",
            "Keep the tip within the field, between two steps as well.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::IDLE_FRACTION),
        title: LocalText::fixed("Ruheanteil", "Idle fraction"),
        unit: Cow::Borrowed("1"),
        display_unit: Cow::Borrowed("%"),
        display_factor: 100.0,
        decimals: 0,
        direction: Direction::Lower,
        category: Category::Efficiency,
        formula: Cow::Borrowed("idle-fraction/2"),
        source: Cow::Borrowed(
            "fraction of time with a speed below v0, smoothed so that what is left of tremor is slower; separates attendings from juniors (Lyon 2025)",
        ),
        advice: LocalText::fixed(
            "Planen Sie den nächsten Schritt, während Sie den jetzigen beenden.",
            "Plan the next step while you finish the present one.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::MOVEMENTS),
        title: LocalText::fixed("Anzahl der Bewegungen", "Number of movements"),
        unit: Cow::Borrowed("1"),
        display_unit: Cow::Borrowed(""),
        display_factor: 1.0,
        decimals: 0,
        direction: Direction::Lower,
        category: Category::Efficiency,
        formula: Cow::Borrowed("movements-gauss-hysteresis/1"),
        source: Cow::Borrowed(
            "upward crossings of v_th by the smoothed speed, hysteresis v_th/2 (ICSAD idea); correlates with global rating, r = -0.47 (Grober 2003)",
        ),
        advice: LocalText::fixed(
            "Machen Sie aus mehreren kleinen Korrekturen eine ruhige Bewegung.",
            "Make one calm movement out of several small corrections.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::SPARC),
        title: LocalText::fixed("Glattheit (SPARC)", "Smoothness (SPARC)"),
        unit: Cow::Borrowed("1"),
        display_unit: Cow::Borrowed(""),
        display_factor: 1.0,
        decimals: 2,
        direction: Direction::Higher,
        category: Category::Handling,
        formula: Cow::Borrowed("sparc/2"),
        source: Cow::Borrowed(
            "spectral arc length of the speed, 10 Hz, threshold 0.05 (Balasubramanian 2012/2015), mean over the movements",
        ),
        advice: LocalText::fixed(
            "Beschleunigen und bremsen Sie gleichmäßig, ohne Halt auf dem Weg.",
            "Accelerate and brake evenly, without stops in between.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::LDLJ),
        title: LocalText::fixed("Glattheit (Ruck, LDLJ)", "Smoothness (jerk, LDLJ)"),
        unit: Cow::Borrowed("1"),
        display_unit: Cow::Borrowed(""),
        display_factor: 1.0,
        decimals: 2,
        direction: Direction::Higher,
        category: Category::Handling,
        formula: Cow::Borrowed("ldlj/1"),
        source: Cow::Borrowed("log dimensionless jerk of the speed (Balasubramanian 2015)"),
        advice: LocalText::fixed(
            "Stützen Sie die Hand ab und halten Sie das Instrument locker, damit es nicht ruckt.",
            "Support your hand and hold the instrument lightly, so that it does not jerk.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::TREMOR),
        title: LocalText::fixed("Tremor (8–12 Hz)", "Tremor (8–12 Hz)"),
        unit: Cow::Borrowed("m"),
        display_unit: Cow::Borrowed("µm"),
        display_factor: 1e6,
        decimals: 0,
        direction: Direction::Lower,
        category: Category::Handling,
        formula: Cow::Borrowed("tremor-hann-rms/1"),
        source: Cow::Borrowed(
            "detrended, Hann window, power density of x, y, z summed, root of the integral over 8..12 Hz; 49 µm RMS still (Riviere 1997)",
        ),
        advice: LocalText::fixed(
            "Legen Sie Handkante und Unterarm auf, atmen Sie ruhig und greifen Sie mit weniger Kraft.",
            "Rest the edge of the hand and the forearm, breathe calmly and grip with less force.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::BIMANUAL_FRACTION),
        title: LocalText::fixed("Beidhändiger Anteil", "Bimanual fraction"),
        unit: Cow::Borrowed("1"),
        display_unit: Cow::Borrowed("%"),
        display_factor: 100.0,
        decimals: 0,
        direction: Direction::Higher,
        category: Category::Handling,
        formula: Cow::Borrowed("bimanual-fraction/2"),
        source: Cow::Borrowed(
            "fraction of the common time in which the speeds of both tools, smoothed as for the idle fraction, are at least v0",
        ),
        advice: LocalText::fixed(
            "Lassen Sie die andere Hand mitarbeiten: Sie stellt das Gewebe ein, während die erste sich nähert.",
            "Let the other hand take part: it presents the tissue while the first one approaches.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::SPEED_CORRELATION),
        title: LocalText::fixed("Korrelation der Geschwindigkeiten", "Correlation of speeds"),
        unit: Cow::Borrowed("1"),
        display_unit: Cow::Borrowed(""),
        display_factor: 1.0,
        decimals: 2,
        direction: Direction::Inform,
        category: Category::Handling,
        formula: Cow::Borrowed("speed-correlation/1"),
        source: Cow::Borrowed(
            "Pearson's correlation of the smoothed speeds of both tools over their common time",
        ),
        advice: LocalText::fixed(
            "Üben Sie, beide Hände zugleich zu bewegen und zugleich ruhen zu lassen.",
            "Practise moving both hands together and resting them together.",
        ),
    },
    MetricDefinition {
        id: Cow::Borrowed(id::PATH_ASYMMETRY),
        title: LocalText::fixed("Ungleichheit der Wege", "Asymmetry of paths"),
        unit: Cow::Borrowed("1"),
        display_unit: Cow::Borrowed("%"),
        display_factor: 100.0,
        decimals: 0,
        direction: Direction::Range,
        category: Category::Handling,
        formula: Cow::Borrowed("path-asymmetry/1"),
        source: Cow::Borrowed(
            "|L1 - L2| / (L1 + L2) of the path lengths of both tools; 0 is even, 1 one hand alone",
        ),
        advice: LocalText::fixed(
            "Verteilen Sie die Arbeit auf beide Hände, wie die Aufgabe es verlangt.",
            "Divide the work between both hands as the task demands.",
        ),
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_definition_is_complete_and_unique() {
        for (index, metric) in MOTION_METRICS.iter().enumerate() {
            let texts = [
                &metric.title.de,
                &metric.title.en,
                &metric.advice.de,
                &metric.advice.en,
                &metric.source,
                &metric.unit,
            ];
            assert!(texts.iter().all(|text| !text.is_empty()), "{}", metric.id);
            assert!(
                metric.display_factor.is_finite() && metric.display_factor > 0.0,
                "{}",
                metric.id
            );
            assert!(
                metric
                    .formula
                    .rsplit_once('/')
                    .is_some_and(|(_, version)| version.parse::<u32>().is_ok_and(|v| v > 0)),
                "{}",
                metric.id
            );
            assert!(
                metric.advice.de.ends_with('.') && metric.advice.en.ends_with('.'),
                "{}",
                metric.id
            );
            assert!(
                MOTION_METRICS[..index]
                    .iter()
                    .all(|other| other.id != metric.id),
                "{}",
                metric.id
            );
        }
    }
}
