//! The texts of the window, each in both languages.

use microsim_message::LocalText;
use microsim_vocabulary::Language;

/// A text in both languages.
#[derive(Clone, Copy, Debug)]
pub struct Phrase {
    de: &'static str,
    en: &'static str,
}

impl Phrase {
    /// In a language.
    pub fn of(self, language: Language) -> &'static str {
        match language {
            Language::German => self.de,
            Language::English => self.en,
        }
    }
}

/// A text of a module, level or report in a language.
pub fn local(text: &LocalText, language: Language) -> &str {
    match language {
        Language::German => &text.de,
        Language::English => &text.en,
    }
}

/// A number with the decimal sign of a language.
pub fn number(value: f64, decimals: usize, language: Language) -> String {
    let text = format!("{value:.decimals$}");
    match language {
        Language::German => text.replace('.', ","),
        Language::English => text,
    }
}

macro_rules! phrases {
    ($($name:ident: $de:literal, $en:literal;)*) => {
        $(pub const $name: Phrase = Phrase { de: $de, en: $en };)*

        /// All of them.
        #[cfg(test)]
        pub const ALL: &[(&str, Phrase)] = &[$((stringify!($name), $name)),*];
    };
}

phrases! {
    CHOOSE_MODULE: "Modul wählen", "Choose a module";
    LEVELS: "Stufen", "Levels";
    TRAINEE: "Trainierende Person", "Trainee";
    NOBODY: "niemand (ohne Namen)", "nobody (no name)";
    BEGIN: "Beginnen", "Begin";
    LANGUAGE: "English", "Deutsch";
    QUIT: "Beenden", "Quit";
    LOCKED: "noch gesperrt", "still locked";
    INSTRUMENTS: "Instrumente", "Instruments";
    LEVEL: "Stufe", "Level";
    TASK: "Aufgabe", "Task";
    HINTS: "Was geschah", "What happened";
    TIME: "Zeit", "Time";
    TARGETS: "Ziele", "Targets";
    STARTING: "Das Gewebe wird vorbereitet …", "The tissue is being prepared …";
    MICROSCOPE: "Mikroskop", "Microscope";
    QUALITY: "Bildgüte", "Picture quality";
    LOW: "niedrig", "low";
    MEDIUM: "mittel", "medium";
    HIGH: "hoch", "high";
    START: "Los", "Start";
    PAUSED: "Pause – die Zeit steht", "Paused – time stands";
    RESUME: "Weiter", "Resume";
    RESTART: "Neu beginnen", "Restart";
    ABORT: "Abbrechen", "Abort";
    ACTIVE: "in der Hand", "in hand";
    KEPT_CLOSED: "bleibt geschlossen", "stays closed";
    OPENING: "Öffnung", "Opening";
    HEIGHT: "Höhe", "Height";
    TRACKED: "verfolgt", "tracked";
    OCCLUDED: "verdeckt", "occluded";
    STALE: "veraltet", "stale";
    NEVER_SEEN: "nie gesehen", "never seen";
    MOUSE: "Maus: Spitze bewegen · Rad: heben, senken · links: schließen · rechts ziehen: drehen", "Mouse: move the tip · wheel: raise, lower · left: close · drag right: turn";
    KEYS: "Tab: andere Hand · C: geschlossen halten · Q, E: rollen · Pfeile, W, S: Schritte · Umschalt: fein · +, −, 0: Vergrößerung · I, J, K, L: Bild verschieben · Esc: Pause", "Tab: other hand · C: keep closed · Q, E: roll · arrows, W, S: steps · Shift: fine · +, −, 0: magnification · I, J, K, L: move the view · Esc: pause";
    SPEED_OF_RUN: "Rechner", "Computer";
    TICK: "Tick", "tick";
    PICTURES: "Bilder/s", "pictures/s";
    LATE: "verspätet", "late";
    UNCONVERGED: "nicht auskonvergiert", "not converged";

    PASSED: "BESTANDEN", "PASSED";
    FAILED: "NICHT BESTANDEN", "FAILED";
    NOT_JUDGED: "OHNE URTEIL", "NOT JUDGED";
    ABORTED: "ABGEBROCHEN", "ABORTED";
    INCOMPLETE: "UNVOLLSTÄNDIG", "INCOMPLETE";
    SCORE: "Punkte", "Score";
    CATEGORIES: "Bereiche", "Categories";
    METRICS: "Messgrößen", "Metrics";
    COURSE: "Verlauf", "Course of it";
    TIP_SPEED: "Geschwindigkeit der Spitzen [mm/s]", "Speed of the tips [mm/s]";
    FORCE: "Kraft auf das Gewebe [mN]", "Force on the tissue [mN]";
    AT_MOST: "höchstens", "at most";
    AT_LEAST: "mindestens", "at least";
    AGAIN: "Noch einmal", "Again";
    NEXT_LEVEL: "Nächste Stufe", "Next level";
    BACK: "Zur Auswahl", "Back to the modules";
    SESSION: "Aufzeichnung", "Session";
    NO_PICTURE: "Kein Bild", "No picture";
    NOT_BEGUN: "Die Stufe konnte nicht beginnen", "The level could not begin";
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nobody forgot one language, and no line stands for the other one.
    #[test]
    fn every_text_is_there_in_both_languages() {
        assert!(ALL.len() > 40);
        for (name, phrase) in ALL {
            assert!(
                !phrase.de.trim().is_empty() && !phrase.en.trim().is_empty(),
                "{name}"
            );
        }
        assert_eq!(number(1.25, 2, Language::German), "1,25");
    }
}
