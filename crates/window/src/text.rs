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

    /// In both languages.
    pub fn both(self) -> LocalText {
        LocalText::fixed(self.de, self.en)
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
    LEFT_HANDED: "linkshändig: Stufe gespiegelt (H)", "left-handed: level mirrored (H)";
    MIRRORED: "Gespiegelt für Linkshändige: Wo der Text links sagt, ist es rechts.", "Mirrored for left-handed trainees: where the text has left, it is right.";
    LANGUAGE: "English", "Deutsch";
    QUIT: "Beenden", "Quit";
    RECORDS: "Trainierende und Ergebnisse", "Trainees and results";
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
    DRIVER_LOST: "Der Grafiktreiber ist ausgefallen und das Bild wieder da. Die Aufzeichnung ist vollständig.",
        "The graphics driver failed, and the picture is back. The recording is complete.";
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
    KEYS: "Tab: andere Hand · A, D: schließen, öffnen · C: geschlossen halten · Q, E: rollen · Pfeile, W, S: Schritte · Umschalt: fein · +, −, 0: Vergrößerung · I, J, K, L: Bild verschieben · U, O: Schärfe · Esc: Pause", "Tab: other hand · A, D: close, open · C: keep closed · Q, E: roll · arrows, W, S: steps · Shift: fine · +, −, 0: magnification · I, J, K, L: move the view · U, O: focus · Esc: pause";
    FOOT_SWITCH: "Fußschalter", "Foot switch";
    MAGNIFY: "stärker vergrößern", "more magnification";
    REDUCE: "schwächer vergrößern", "less magnification";
    FOCUS_UP: "Schärfe höher", "focus up";
    FOCUS_DOWN: "Schärfe tiefer", "focus down";
    OTHER_HAND: "andere Hand", "other hand";
    HOLD_CLOSED: "geschlossen halten", "keep closed";
    GAMEPAD: "Gamepad", "Gamepad";
    SPACE_MOUSE: "SpaceMouse", "SpaceMouse";
    PLUGGED_IN: "angeschlossen", "plugged in";
    UNPLUGGED: "getrennt; das Instrument bleibt, wo es ist", "unplugged; the instrument stays where it is";
    NOT_READABLE: "ist angeschlossen und nicht lesbar:", "is plugged in and cannot be read:";
    GAMEPAD_HELP: "Linker Stick: Spitze bewegen · rechter Stick: heben, senken, drehen · RT: schließen, LT: fein · LB, RB: rollen · A: geschlossen halten · X, Y: andere Hand · Kreuz: auf, ab: neigen, links, rechts: Vergrößerung · Start: Pause", "Left stick: move the tip · right stick: raise, lower, turn · RT: close, LT: fine · LB, RB: roll · A: keep closed · X, Y: other hand · cross: up, down: tilt, left, right: magnification · Start: pause";
    SPACE_MOUSE_HELP: "Kappe: Spitze und Griff bewegen · linke Taste: andere Hand · rechte Taste: geschlossen halten", "Cap: move tip and handle · left button: other hand · right button: keep closed";
    CONTROLLER_SPEED: "Tempo von Gamepad und SpaceMouse", "Speed of gamepad and SpaceMouse";
    SPEED_OF_RUN: "Rechner", "Computer";
    TICK: "Tick", "tick";
    TO_THE_TICK: "bis zum Tick", "to the tick";
    TO_THE_PICTURE: "bis zum Bild", "to the picture";
    SAMPLES: "Proben", "samples";
    DROPPED: "verworfen", "dropped";
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

    REPLAY: "Wiedergabe", "Replay";
    CLICK_TO_REPLAY: "Ein Klick zeigt den Augenblick in der Wiedergabe", "A click shows the moment in the replay";
    NO_REPLAY: "Die Aufzeichnung kann nicht abgespielt werden", "The session cannot be replayed";
    TO_THE_DEBRIEF: "Zur Auswertung (Esc)", "Back to the debrief (Esc)";
    PLAY: "Abspielen", "Play";
    PAUSE: "Pause", "Pause";
    TO_THE_BEGINNING: "zum Anfang (Pos1)", "to the beginning (Home)";
    TO_THE_END: "zum Ende (Ende)", "to the end (End)";
    ONE_BACK: "einen Tick zurück (Pfeil links)", "one tick back (left arrow)";
    ONE_FORWARD: "einen Tick vor (Pfeil rechts)", "one tick forward (right arrow)";
    EVENT_BEFORE: "zum Ereignis davor (Pfeil auf)", "to the event before (arrow up)";
    EVENT_AFTER: "zum nächsten Ereignis (Pfeil ab)", "to the next event (arrow down)";
    COMPUTED_WITH: "gerechnet mit", "computed at";
    RECORDING_IS_READ: "Die Aufzeichnung wird gelesen und das Gewebe vorbereitet …", "The session is read and the tissue is being prepared …";
    IS_COMPUTED: "Bis dorthin wird neu gerechnet:", "Computed again up to there:";
    NOTHING_RECORDED: "Die Aufzeichnung hat keinen Tick", "The session has no tick";
    SAME_SO_FAR: "Neu gerechnet, bisher gleich: Tick", "Computed again, the same so far: tick";
    SAME_TO_THE_END: "Neu gerechnet, bis zum Ende gleich", "Computed again, the same to the end";
    SAME_AS_FAR: "Neu gerechnet, gleich, soweit sie gelesen werden kann:", "Computed again, the same, as far as it can be read:";
    NOTHING_COMPARED: "Noch ist kein Tick verglichen", "No tick is compared yet";
    OTHER_BUILD: "Plugins eines anderen Builds:", "plugins of another build:";
    DIFFERS_AT: "Weicht ab bei Tick", "Differs at tick";
    NOT_AS_RECORDED: "Was von dort an zu sehen ist, wurde so nicht aufgezeichnet", "What is shown from there on is not what was recorded";
    REPLAY_ENDED: "Die Wiedergabe ist abgebrochen:", "The replay broke off:";
    REPLAY_KEYS: "Leertaste: abspielen, Pause · Pfeil links, rechts: ein Tick · auf, ab: Ereignis davor, danach · Pos1, Ende · 1 bis 5: Tempo · +, −, Rad: Vergrößerung · I, J, K, L, Ziehen: Bild verschieben · U, O: Schärfe · 0: wie in der Stufe · F2: Bildgüte · G: Vergleich · V: Video · Esc: zurück", "Space: play, pause · arrows left, right: one tick · up, down: event before, after · Home, End · 1 to 5: speed · +, −, wheel: magnification · I, J, K, L, drag: move the view · U, O: focus · 0: as in the level · F2: picture quality · G: reference · V: video · Esc: back";

    SETTINGS: "Einstellungen", "Settings";
    LANGUAGE_OF_TEXTS: "Sprache", "Language";
    AUTOMATIC: "automatisch", "automatic";
    DEPTH_OF_FIELD: "Schärfentiefe", "Depth of field";
    IF_HIGH: "bei hoher Bildgüte", "where the quality is high";
    STEREO: "Stereobild", "Stereo picture";
    MONO: "keines", "none";
    SIDE_BY_SIDE: "nebeneinander", "side by side";
    TOP_BOTTOM: "übereinander", "one above the other";
    ROW_INTERLEAVED: "zeilenweise (Polarisation)", "row by row (polarised)";
    RED_CYAN: "rot und türkis (Brille aus Papier)", "red and cyan (glasses of paper)";
    STEREO_BASE: "Abstand der Augen im Objektiv", "Distance of the eyes in the main lens";
    WORKING_DISTANCE: "Arbeitsabstand", "Working distance";
    FULL_SCREEN: "Vollbild", "Full screen";
    PANELS: "Angaben neben dem Bild", "Panels beside the picture";
    AUDIO: "Ton", "Sound";
    AUDIO_OF: "Berührung, Schnitt, Riss, zu große Kraft", "touch, cut, tear, too much force";
    FIELDS_PER_SECOND: " Felder/s", " fields/s";
    VOLUME: "Lautstärke", "Volume";
    STORE_SETTINGS: "Für diese Station speichern", "Store for this station";
    HOLDS_AT_ONCE: "Was geändert ist, gilt sofort, und nach dem Speichern auch für spätere Fenster", "What is changed holds at once, and once it is stored for later windows, too";
    NOT_STORED: "Nicht gespeichert:", "Not stored:";
    STORED_IN: "Gespeichert in", "Stored in";

    ALL_GROUPS: "alle Gruppen", "all groups";
    EVERYBODY: "Alle", "Everybody";
    SEARCH: "Name suchen", "Find a name";
    NEW_NAME: "neuer Name", "new name";
    ADD: "Hinzufügen", "Add";
    SESSIONS: "Aufzeichnungen", "sessions";
    ONE_SESSION: "Aufzeichnung", "session";
    RESULTS: "Ergebnisse", "Results";
    LEARNING: "Lernkurve", "Learning curve";
    COURSES: "Kurse", "Courses";
    DETAILS: "Angaben", "Details";
    COMPARE: "A und B vergleichen", "Compare A and B";
    SHOW_DEBRIEF: "Auswertung", "Debrief";
    TO_THE_LIST: "Zur Liste", "Back to the list";
    MARK_TWO: "Zwei Versuche anklicken", "Click two attempts";
    NO_RESULTS: "noch keine Ergebnisse", "no results yet";
    NOT_SAME_LEVEL: "Nicht dieselbe Stufe: Werte verschiedener Aufgaben stehen nebeneinander", "Not the same level: values of different tasks are side by side";
    OUTSIDE: "! außerhalb der Grenze der Stufe", "! outside the limit of the level";
    BETTER: "besser", "better";
    WORSE: "schlechter", "worse";
    EXPORT_THESE: "Diese exportieren", "Export these";
    EXPORT_GROUP: "Gruppe exportieren", "Export the group";
    WITH_NAMES: "mit Namen", "with names";
    FILE: "Datei (.csv, .parquet)", "File (.csv, .parquet)";
    SESSIONS_ARE_IN: "Aufzeichnungen sind in", "sessions are in";
    ACCEPTABLE: "annehmbar: Fehlerrate", "acceptable: failure rate";
    UNACCEPTABLE: "nicht annehmbar:", "not acceptable:";
    NOT_DECIDED: "noch nicht entschieden", "not decided yet";
    IS_ACCEPTABLE: "annehmbar ab Versuch", "acceptable from attempt";
    IS_UNACCEPTABLE: "nicht annehmbar ab Versuch", "not acceptable from attempt";
    CUSUM_EXPLAINED: "Sinkt mit jedem bestandenen Versuch und steigt mit jedem nicht bestandenen.", "Falls with each attempt that was passed and rises with each that was not.";
    PERCENTILES: "Letzter Versuch in Perzentilen", "Last attempt in percentiles";
    NO_POPULATION: "Keine Vergleichswerte für diese Stufe; sie kommen aus einer CSV-Datei (Kurse und Daten)", "No population for this level; they come from a CSV file (Courses and data)";
    ENROL: "Aufnehmen", "Enrol";
    NO_COURSE: "nimmt an keinem Kurs teil", "takes no course";
    MASTERED_WITH: "beherrscht mit Versuch", "mastered with attempt";
    IS_OPEN: "offen", "open";
    IS_NEXT: "als Nächstes", "next";
    IN_A_ROW: "in Folge", "in a row";
    UNLOCK: "Öffnen", "Unlock";
    NAME: "Name", "Name";
    RENAME: "Umbenennen", "Rename";
    ROLE: "Rolle", "Role";
    ROLE_TRAINEE: "Trainierende", "trainee";
    ROLE_INSTRUCTOR: "Lehrende", "instructor";
    ROLE_OPERATOR: "Bedienung", "operator";
    GROUPS: "Gruppen", "Groups";
    TAKE_OUT: "Entfernen", "Take out";
    PUT_IN: "In die Gruppe", "Put in group";
    REMOVE: "Entfernen", "Remove";
    REMOVE_EXPLAINED: "Anonym: der Name geht, die Ergebnisse bleiben. Gelöscht: alles geht, auch die Dateien.", "Anonymous: the name goes and results stay. Erased: everything goes, files as well.";
    ANONYMISE: "Anonymisieren …", "Anonymise …";
    ERASE: "Löschen …", "Erase …";
    NAME_GOES: "der Name geht, für immer", "the name goes, for good";
    FILES_GO: "Dateien gehen, für immer", "files go, for good";
    FOR_GOOD: "Für immer entfernen", "Remove for good";
    CANCEL: "Abbrechen", "Cancel";

    UPKEEP: "Kurse und Daten", "Courses and data";
    BACK_TO_RECORDS: "Zu den Ergebnissen", "Back to the results";
    NO_COURSES: "noch kein Kurs: unten eine Kursdatei einlesen", "no course yet: read the file of one below";
    CHOOSE_COURSE: "Einen Kurs anklicken", "Click a course";
    IN_ORDER: "Eine Stufe öffnet sich, wenn die davor beherrscht ist", "A level opens when the one before it is mastered";
    ALL_OPEN: "Alle Stufen sind offen", "All levels are open";
    PASSES_IN_A_ROW: "× in Folge bestanden", "passes in a row";
    ONE_PASS: "× bestanden", "pass";
    LEVELS_OF_IT: "Stufen", "levels";
    LEVEL_OF_IT: "Stufe", "level";
    TAKEN_BY: "Teilnehmende Gruppen", "Groups that take it";
    BY_THEMSELVES: "einzeln aufgenommen", "enrolled by themselves";
    NO_GROUP_TAKES_IT: "keine Gruppe", "no group";
    ENROL_GROUP: "Gruppe aufnehmen", "Enrol group";
    REMOVE_COURSE: "Kurs entfernen …", "Remove course …";
    COURSE_GOES: "der Kurs geht, mit Teilnahmen und geöffneten Stufen; Ergebnisse bleiben", "the course goes, with enrolments and unlocked levels; results stay";
    READ_FILE: "Einlesen", "Read in";
    READ_EXPLAINED: "Kurs (.toml), Vergleichswerte (.csv) oder exportierte Daten (.json): Pfad eintippen oder Datei auf das Fenster ziehen", "Course (.toml), population (.csv) or exported data (.json): type its path, or drop the file onto the window";
    PATH_TO_READ: "Pfad einer Datei", "path of a file";
    EXPORT_ALL: "Alles exportieren", "Export all";
    PATH_OF_FOLDER: "noch ein Ordner mit Aufzeichnungen, wenn gewünscht", "one more folder with sessions, if wanted";
    REBUILD: "Neu aufbauen", "Rebuild";
    CHECK_STORE: "Prüfen", "Check";
    REBUILD_EXPLAINED: "Neu aufbauen: Ergebnisse aus allen Aufzeichnungen neu lesen. Prüfen: ist die Datenbank unbeschädigt?", "Rebuild: read the results from all sessions again. Check: is the database intact?";
    NOT_DONE: "Nicht ausgeführt:", "Not done:";
    PASSED_TIME: "vergangen", "passed";
    ABOUT_LEFT: "noch etwa", "left about";
    ONE_AT_A_TIME: "Eine Datei nach der anderen: es liegt nur die erste bereit", "One file at a time: only the first one is ready";
    NOT_UTF8: "Der Pfad ist kein UTF-8-Text", "The path is not UTF-8 text";

    EDIT_LEVEL: "Stufe ändern … (E)", "Change the level … (E)";
    EDITOR: "Stufe ändern: eine Kopie mit anderen Werten", "Change a level: a copy with other values";
    OF_TISSUE: "Gewebe", "Tissue";
    OF_CONTACT: "Berührung", "Contact";
    OF_LIMITS: "Grenzen und Punkte", "Limits and points";
    OF_METRICS: "Wie Messgrößen berechnet werden", "How metrics are computed";
    OF_MODULE: "Eigenes des Moduls (erklärt auf Englisch)", "The module's own";
    NO_NUMBER: "Das ist keine Zahl.", "That is no number.";
    DECIMAL_COMMA: "Das Dezimalzeichen ist ein Punkt.", "The decimal sign is a point.";
    WITHOUT_UNIT: "Die Einheit fehlt:", "The unit is missing:";
    WRONG_UNIT: "Eine andere Einheit als", "Another unit than";
    NOT_WHOLE: "Nur ganze Zahlen.", "Whole numbers only.";
    OUT_OF_RANGE: "Außerhalb des Bereichs", "Outside the range";
    ANY_VALUE: "beliebig", "any";
    WAS: "bisher", "before";
    COPY_NAME: "Name der Kopie", "Name of the copy";
    NAME_RULE: "Kleinbuchstaben, Ziffern, einzelne Bindestriche, vorn ein Buchstabe", "lower-case letters, digits, single hyphens, a letter first";
    STORE_COPY: "Kopie speichern", "Store the copy";
    COPY_STORED: "Gespeichert; sie steht in der Liste bei ihrer Stufe. Ihre Läufe werden aufgezeichnet, nennen die Änderung und zählen nicht als Ergebnisse der Stufe.", "Stored; it stands in the list with its level. Its runs are recorded, name the change, and do not count as results of the level.";
    COPY_NOT_STORED: "Nicht gespeichert:", "Not stored:";
    NOT_A_LEVEL: "So ist es keine Stufe:", "Like this it is no level:";
    MENDED_FIRST: "Erst die markierten Werte berichtigen.", "First mend the values that are marked.";
    DISCARD: "Es ist nicht gespeichert. Noch einmal Esc oder „Zur Auswahl“ verwirft die Änderungen.", "It is not stored. Esc or \"Back to the modules\" once more discards the changes.";
    SHIPPED_STAYS: "Die mitgelieferte Stufe bleibt, wie sie ist. Orte, Größen und Netze ändert man in der Datei selbst.", "The shipped level stays as it is. Places, sizes and meshes are changed in the file itself.";

    REFERENCE: "Vergleich (G)", "Reference (G)";
    REFERENCE_IS: "Violett durchscheinend, zur selben Zeit:", "Translucent violet, at the same time:";
    REFERENCE_IS_READ: "wird gelesen …", "is being read …";
    REFERENCE_ENDED: "zu Ende nach", "over after";
    SAME_TIME: "nur die Instrumente", "its instruments alone";
    NO_REFERENCE: "Kein Vergleich", "No reference";
    NO_REFERENCES: "Für diese Stufe gibt es kein Skript und keinen anderen Lauf.", "There is no script and no other run of this level.";
    FILM: "Video", "Video";
    FILM_KEY: "Video (V)", "Video (V)";
    FROM_HERE: "Ab hier", "From here";
    TO_HERE: "Bis hier", "Up to here";
    ALL_OF_IT: "Alles", "All of it";
    MAKE_FILM: "Aufnehmen", "Make it";
    STOP_FILM: "Anhalten", "Stop";
    FILM_EXPLAINED: "25 Bilder je Sekunde simulierter Zeit, wie sie hier zu sehen sind, ohne andere Sitzungen; beim Verlassen des Abspielens endet die Aufnahme.", "25 pictures in a second of simulated time, as they are seen here without other sessions; it ends when the replay is left.";
    FILM_ENDED: "Die Aufnahme brach ab; die Bilder bis dahin bleiben. Grund:", "It broke off; the pictures so far stay. Reason:";
    FILM_ENDS: "Das Abspielen wurde verlassen: die Aufnahme endet mit dem Bild, das eben gezeichnet wird.", "The replay was left: the video ends with the picture that is drawn now.";
    FILM_STOPPED: "Angehalten.", "Stopped.";
    VIDEO_IS_MADE: "Die Bilder werden zu einer Datei …", "One file is made of the pictures …";
    PICTURES_WRITTEN: "Bilder", "pictures";
    VIEWS: "Einblick in die Rechnung (Strg+1 … 7)", "Look into the computation (Ctrl+1 … 7)";
    CONTROL: "Strg", "Ctrl";
    WIREFRAME: "Netz", "Mesh";
    CAPSULES: "Kapseln der Instrumente", "Capsules of instruments";
    NO_RETURN: "Linien ohne Umkehr", "Lines of no return";
    CONTACTS: "Kontakte und Kräfte", "Contacts and forces";
    STRESS: "Spannung", "Stress";
    ELEMENT_QUALITY: "Güte der Elemente", "Quality of elements";
    REMEDIES: "Abhilfen", "Remedies";
    LEGEND_STRESS: "Spannung nach von Mises", "von Mises stress";
    LEGEND_NO_STRESS: "in keinem Körper eine Spannung", "no stress in any body";
    LEGEND_QUALITY: "schlechtestes Element am Knoten", "worst element at a node";
    LEGEND_REMEDIES: "was die Rechnung brauchte", "what the computation needed";
    REMEDY_INERTIA: "Trägheit zugefügt", "inertia added";
    REMEDY_INVERTED: "Element umgestülpt", "element inside out";
    REMEDY_OVERLAP: "Überlappung aufgelöst", "overlap undone";
    REMEDY_REPEATED: "noch einmal gerechnet", "computed again";
    REMEDY_STIFFENED: "versteift: kürzere Schritte", "stiffened: shorter steps";
    REMEDY_HELD: "gehalten: kein Schritt gelang", "held: no step succeeded";
    REMEDY_NONE: "nichts", "nothing";
    NO_FFMPEG: "Für eine MP4-Datei fehlt das Programm ffmpeg.", "For an MP4 file the program ffmpeg is missing.";
    FFMPEG_FAILED: "ffmpeg machte keine MP4-Datei:", "ffmpeg made no MP4 file:";
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
