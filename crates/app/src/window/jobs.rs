//! Work on the store that goes on beside the window's thread: what the commands do, in words of both languages.

use super::text;
use crate::cli::Place;
use crate::folders::{self, Folders};
use crate::output::Problem;
use crate::upkeep::{self, Rebuilt, Taken};
use microsim_message::LocalText;
use microsim_window::{Done, Job, Work};
use std::path::Path;

/// Files that can be read into a store, for people.
const EXPECTED: &str =
    "a course (.toml), populations (.csv) or what `microsim store export` writes (.json)";

/// Work on the store of a place.
pub struct AtStore {
    /// The place.
    pub place: Place,
    /// What is done.
    pub work: Work,
}

impl Job for AtStore {
    fn run(self: Box<Self>, progress: &mut dyn FnMut(Option<f64>, String)) -> Result<Done, String> {
        let named = |path: &Path| path.display().to_string();
        let done = match &self.work {
            Work::Read(file) => {
                progress(None, named(file));
                read(&self.place, file)
            }
            Work::Export(file) => {
                progress(None, named(file));
                export(&self.place, file)
            }
            Work::Check => {
                progress(None, String::new());
                check(&self.place)
            }
            Work::Rebuild(more) => {
                let mut notes = Vec::new();
                let rebuilt = upkeep::rebuild(
                    &self.place,
                    more.as_slice(),
                    &mut |part, file| progress(Some(part), named(file)),
                    &mut |note| notes.push(note),
                );
                // What is wrong with a store that was put aside holds, however it ended.
                match rebuilt {
                    Ok(rebuilt) => Ok(rebuilt_done(notes, &rebuilt)),
                    Err(Problem::Text(why)) => {
                        notes.push(why);
                        Err(notes.join("; ").into())
                    }
                    Err(problem) => Err(problem),
                }
            }
        };
        done.map_err(text)
    }
}

/// As it is, in both languages.
fn both(sentence: String) -> LocalText {
    LocalText::new(sentence.clone(), sentence)
}

/// A number with the noun that belongs to it.
fn counted(count: i64, one: &str, many: &str) -> String {
    let noun = if count == 1 { one } else { many };
    format!("{count} {noun}")
}

fn read(place: &Place, file: &Path) -> Result<Done, Problem> {
    let extension = file.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("toml") => {
            let (course, missing) = upkeep::take_course(place, file)?;
            let (name, levels) = (&course.name, course.steps.len() as i64);
            let taken = LocalText::new(
                format!(
                    "Der Kurs {name} ist eingelesen, mit {}",
                    counted(levels, "Stufe", "Stufen")
                ),
                format!(
                    "The course {name} is in the store, with {}",
                    counted(levels, "level", "levels")
                ),
            );
            let sentences = std::iter::once(taken).chain(missing.into_iter().map(both));
            Ok(Done {
                is_good: true,
                sentences: sentences.collect(),
            })
        }
        Some("csv" | "json") => {
            let sentence = match upkeep::import(place, file)? {
                Taken::Populations(count) => {
                    let count = count as i64;
                    LocalText::new(
                        counted(
                            count,
                            "Vergleichsreihe ist eingelesen",
                            "Vergleichsreihen sind eingelesen",
                        ),
                        counted(
                            count,
                            "population is in the store",
                            "populations are in the store",
                        ),
                    )
                }
                Taken::Export(added) => LocalText::new(
                    format!(
                        "Neu: {} Trainierende, {}, {} Vergleichsreihen, {} Aufzeichnungen; was da war, ist wie zuvor",
                        added.trainees,
                        counted(added.courses as i64, "Kurs", "Kurse"),
                        added.populations,
                        added.sessions
                    ),
                    format!(
                        "Added: {} trainees, {} courses, {} populations, {} sessions; what was there is as it was",
                        added.trainees, added.courses, added.populations, added.sessions
                    ),
                ),
            };
            Ok(Done {
                is_good: true,
                sentences: vec![sentence],
            })
        }
        _ => Err(format!("{}: expected {EXPECTED}", file.display()).into()),
    }
}

fn export(place: &Place, file: &Path) -> Result<Done, Problem> {
    if file.symlink_metadata().is_ok() {
        return Err(format!(
            "{}: there is a file of this name, and it stays; expected a name that is free",
            file.display()
        )
        .into());
    }
    let tables = Folders::of(place)?.tables();
    if file.parent() == Some(&tables) {
        folders::make(&tables)?;
    }
    let exported = upkeep::export(place, file)?;
    let (trainees, courses, sessions) = (exported.trainees, exported.courses, exported.sessions);
    let shown = file.display();
    let written = LocalText::new(
        format!(
            "{trainees} Trainierende, {} und {sessions} Aufzeichnungen sind in {shown}",
            counted(courses as i64, "Kurs", "Kurse")
        ),
        format!("{trainees} trainees, {courses} courses and {sessions} sessions are in {shown}"),
    );
    let is_good = exported.losses.is_empty();
    let losses = exported.losses.into_iter().map(both);
    Ok(Done {
        is_good,
        sentences: std::iter::once(written).chain(losses).collect(),
    })
}

fn check(place: &Place) -> Result<Done, Problem> {
    let upkeep::Checked { path, problems, .. } = upkeep::check(place)?;
    let path = path.display();
    if problems.is_empty() {
        let sentence = LocalText::new(
            format!("{path} ist unbeschädigt"),
            format!("{path} is intact"),
        );
        return Ok(Done {
            is_good: true,
            sentences: vec![sentence],
        });
    }
    let advice = LocalText::new(
        format!(
            "{path} ist beschädigt: „Alles exportieren“ schreibt, was unbeschädigt ist; „Neu aufbauen“ legt sie beiseite und macht eine neue"
        ),
        format!(
            "{path} is damaged: “Export all” writes what is intact; “Rebuild” puts it aside and makes a new one"
        ),
    );
    let problems = problems.into_iter().map(both);
    Ok(Done {
        is_good: false,
        sentences: std::iter::once(advice).chain(problems).collect(),
    })
}

fn rebuilt_done(notes: Vec<String>, rebuilt: &Rebuilt) -> Done {
    let Rebuilt {
        sessions,
        unfinished,
        ..
    } = rebuilt;
    let mut sentences = vec![LocalText::new(
        format!(
            "{sessions} Aufzeichnungen sind eingetragen, wie ihre Dateien sie zeigen; {unfinished} davon ohne Ende"
        ),
        format!(
            "{sessions} sessions are entered as their files show them, {unfinished} of them without an end"
        ),
    )];
    let others = [
        (
            rebuilt.without_file,
            "bleiben, wie sie waren: ihre Dateien sind nicht da",
            "stay as they were: their files are not there",
        ),
        (
            rebuilt.left_out as i64,
            "bleiben draußen: sie liefen mit --no-store",
            "stay out, as they were run with --no-store",
        ),
        (
            rebuilt.running as i64,
            "laufen noch und tragen sich selbst ein",
            "are running, and enter by themselves",
        ),
    ];
    for (count, de, en) in others.iter().filter(|(count, ..)| *count > 0) {
        sentences.push(LocalText::new(
            format!("{count} {de}"),
            format!("{count} {en}"),
        ));
    }
    let is_good = notes.is_empty() && rebuilt.notes.is_empty();
    let notes = notes.into_iter().chain(rebuilt.notes.iter().cloned());
    sentences.extend(notes.map(both));
    Done { is_good, sentences }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use microsim_store::{Id, Role, Store, Trainee};
    use std::fs;
    use std::path::PathBuf;

    const COURSE: &str = "name = \"two\"\ntitle = { de = \"Zwei\", en = \"Two\" }\n\
        [[step]]\nmodule = \"touch-spheres\"\nlevel = 1\n[[step]]\nmodule = \"touch-spheres\"\nlevel = 2\n";
    const POPULATION: &str =
        "module,level,metric,source,n,mean,sd\ntouch-spheres,1,time,experts,12,30,4.5\n";

    #[derive(Parser)]
    struct Arguments {
        #[command(flatten)]
        place: Place,
    }

    struct Desk {
        folder: tempfile::TempDir,
        place: Place,
    }

    impl Desk {
        fn new() -> Self {
            let folder = tempfile::tempdir().expect("a folder");
            let data = folder.path().join("data");
            fs::create_dir_all(data.join("sessions")).expect("folders");
            let arguments = ["window".as_ref(), "--data".as_ref(), data.as_os_str()];
            let place = Arguments::parse_from(arguments).place;
            Self { folder, place }
        }

        fn file(&self, name: &str, content: &str) -> PathBuf {
            let path = self.folder.path().join(name);
            fs::write(&path, content).expect("a file");
            path
        }

        fn store(&self) -> PathBuf {
            self.folder.path().join("data/store.sqlite")
        }

        fn add(&self, name: &str) {
            let mut store = Store::open(&self.store()).expect("a store");
            let trainee = Trainee {
                id: Id::from_random([7; 16]),
                name: Some(name.into()),
                role: Role::Trainee,
                created: 0,
            };
            store.add_trainee(&trainee).expect("somebody");
        }

        /// What the window is given: good or not, and the sentences in one language.
        fn run(&self, work: Work) -> Result<(bool, String), String> {
            let job = AtStore {
                place: self.place.clone(),
                work,
            };
            let done = Box::new(job).run(&mut |part, _| {
                assert!(part.is_none_or(|part| (0.0..=1.0).contains(&part)));
            })?;
            assert!(done.sentences.iter().all(|s| !s.de.is_empty()));
            let sentences: Vec<String> = done.sentences.iter().map(|s| s.en.to_string()).collect();
            Ok((done.is_good, sentences.join("\n")))
        }

        fn read(&self, file: &Path) -> Result<String, String> {
            let (is_good, sentences) = self.run(Work::Read(file.to_path_buf()))?;
            assert!(is_good, "{sentences}");
            Ok(sentences)
        }
    }

    #[test]
    fn courses_populations_and_exports_are_read() {
        let desk = Desk::new();
        let found = desk
            .read(&desk.file("course.toml", COURSE))
            .expect("a course");
        assert_eq!(found, "The course two is in the store, with 2 levels");
        let table = desk.file("experts.csv", POPULATION);
        let found = desk.read(&table).expect("a population");
        assert_eq!(found, "1 population is in the store");
        desk.add("A. Muster");
        let export = desk.folder.path().join("all.json");
        let (is_good, found) = desk.run(Work::Export(export.clone())).expect("an export");
        let expected = format!(
            "1 trainees, 1 courses and 0 sessions are in {}",
            export.display()
        );
        assert_eq!((is_good, found), (true, expected));

        let other = Desk::new();
        let found = other.read(&export).expect("an export");
        assert!(
            found.starts_with("Added: 1 trainees, 1 courses, 1 populations, 0 sessions"),
            "{found}"
        );
        let store = Store::open_to_read(&other.store())
            .expect("it opens")
            .expect("a store");
        assert_eq!(store.courses().expect("courses")[0].steps.len(), 2);
        assert_eq!(store.populations(None).expect("populations").len(), 1);
    }

    /// File, line and what was expected; the store is as it was.
    #[test]
    fn what_cannot_be_read_changes_nothing() {
        let desk = Desk::new();
        desk.read(&desk.file("course.toml", COURSE))
            .expect("a course");
        let before = fs::read(desk.store()).expect("a store");
        let twice = COURSE.replace("level = 2", "level = 1");
        for (name, content, expected) in [
            (
                "twice.toml",
                twice.as_str(),
                "twice.toml:6:1: key `step[1]`",
            ),
            (
                "one.csv",
                &POPULATION.replace(",1,time", ",one,time"),
                "one.csv:2: column `level`: found \"one\", expected a whole number",
            ),
            (
                "other.json",
                "{}",
                "expected what `microsim store export` writes",
            ),
            (
                "course.txt",
                COURSE,
                "course.txt: expected a course (.toml), populations (.csv)",
            ),
        ] {
            let error = desk.read(&desk.file(name, content)).expect_err(name);
            assert!(error.contains(expected), "{error}");
        }
        let error = desk
            .read(Path::new("/nowhere/course.toml"))
            .expect_err("no file");
        assert!(error.contains("/nowhere/course.toml"), "{error}");
        assert_eq!(fs::read(desk.store()).expect("a store"), before);
    }

    #[test]
    fn an_export_replaces_no_file() {
        let desk = Desk::new();
        desk.add("A. Muster");
        let mine = desk.file("mine.json", "what somebody else has written");
        let error = desk
            .run(Work::Export(mine.clone()))
            .expect_err("a file is there");
        assert!(
            error.contains("mine.json: there is a file of this name"),
            "{error}"
        );
        assert_eq!(
            fs::read(mine).expect("a file"),
            b"what somebody else has written"
        );
        // The folder that is proposed is made.
        let proposed = desk.folder.path().join("data/tables/store.json");
        assert!(
            desk.run(Work::Export(proposed.clone()))
                .expect("an export")
                .0
        );
        assert!(proposed.is_file());
    }

    #[test]
    fn a_damaged_store_is_named_and_replaced() {
        let desk = Desk::new();
        let error = desk.run(Work::Check).expect_err("no store");
        assert!(error.contains("there is no store"), "{error}");
        desk.add("A. Muster");
        let (is_good, found) = desk.run(Work::Check).expect("a store");
        assert!(
            is_good && found.ends_with("store.sqlite is intact"),
            "{found}"
        );
        fs::write(desk.store(), [0x55; 40_000]).expect("written over");
        let (is_good, found) = desk.run(Work::Check).expect("it is looked at");
        assert!(!is_good && found.contains("is damaged"), "{found}");
        let session = desk.file("data/sessions/torn.session", "no session");
        let (is_good, found) = desk.run(Work::Rebuild(None)).expect("rebuilt");
        assert!(!is_good, "{found}");
        for part in [
            "0 sessions are entered",
            "it is put aside as",
            &session.display().to_string(),
        ] {
            assert!(found.contains(part), "{part} in {found}");
        }
        assert!(desk.run(Work::Check).expect("a store").0);
        let missing = Some(desk.folder.path().join("nowhere"));
        let error = desk.run(Work::Rebuild(missing)).expect_err("no folder");
        assert!(
            error.contains("nowhere: expected a folder with sessions"),
            "{error}"
        );
    }
}
