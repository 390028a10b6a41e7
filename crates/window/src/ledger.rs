//! What the window needs of the store of a station: trainees, groups, courses, results.

use microsim_message::LocalText;
use microsim_report::{Report, Verdict};
use std::path::{Path, PathBuf};

/// What somebody may be called; a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Runs the station.
    Operator,
    /// Teaches.
    Instructor,
    /// Trains.
    Trainee,
}

/// Somebody in the store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Person {
    /// Id.
    pub id: String,
    /// The name, or the beginning of the id of somebody without one.
    pub name: String,
    /// The role.
    pub role: Role,
    /// Groups that they are in.
    pub groups: Vec<String>,
    /// Number of their sessions.
    pub sessions: u64,
}

/// Which results are meant; all of them if nothing is stated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Of a trainee, by id.
    pub trainee: Option<String>,
    /// Of the members of a group.
    pub group: Option<String>,
}

/// A session with its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// Id of the session.
    pub id: String,
    /// When it began, as it is shown.
    pub started: String,
    /// Name of the module.
    pub module: String,
    /// Title of the module.
    pub title: LocalText,
    /// Level.
    pub level: u32,
    /// The verdict.
    pub verdict: Verdict,
    /// Points.
    pub score: Option<f64>,
    /// How long the level ran \[s\].
    pub duration: f64,
    /// Whose it is.
    pub who: String,
}

/// A value of two sessions.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedRow {
    /// What it is.
    pub title: LocalText,
    /// Unit in which it is shown; empty if it has none.
    pub unit: String,
    /// The values in this unit.
    pub values: [Option<f64>; 2],
    /// Whether they are outside the limit of the level.
    pub outside: [bool; 2],
    /// Whether the second is better; `None` if they are equal or no side is better.
    pub is_better: Option<bool>,
}

/// Two sessions side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The sessions.
    pub attempts: [Attempt; 2],
    /// Whether they are of the same level.
    pub same_level: bool,
    /// What both have.
    pub rows: Vec<ComparedRow>,
}

/// What came of a run.
#[derive(Clone, Debug)]
pub struct Debrief {
    /// Its report.
    pub report: Report,
    /// The variant of its level that was trained.
    pub variant: Option<String>,
    /// The session file.
    pub session: PathBuf,
    /// The page of the report.
    pub page: PathBuf,
    /// What went wrong without ending it, one sentence each.
    pub complaints: Vec<String>,
}

/// On which side of a percentile a value is known to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Percentile {
    /// At it.
    At(f64),
    /// Below the lowest that is known.
    Below(f64),
    /// Above the highest that is known.
    Above(f64),
}

/// A value among those of a population.
#[derive(Clone, Debug, PartialEq)]
pub struct StandingRow {
    /// What it is.
    pub title: LocalText,
    /// Unit in which it is shown.
    pub unit: String,
    /// The value in this unit.
    pub value: f64,
    /// Whose values the population has.
    pub source: String,
    /// How many they are.
    pub size: u32,
    /// Where the value stands.
    pub percentile: Percentile,
}

/// How somebody has learned a level.
#[derive(Clone, Debug, PartialEq)]
pub struct Learning {
    /// CUSUM after each attempt that counts.
    pub values: Vec<f64>,
    /// At or below this the failure rate is the acceptable one, at or above that the unacceptable one.
    pub limits: [f64; 2],
    /// Those rates.
    pub rates: [f64; 2],
    /// With which attempt, from 1, it was decided, and whether it is acceptable.
    pub decision: Option<(usize, bool)>,
    /// Values of the last attempt in populations.
    pub standings: Vec<StandingRow>,
}

/// How far a level of a course is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepState {
    /// With this attempt, from 1.
    Mastered(usize),
    /// Can be trained.
    Open,
    /// One before it is not mastered.
    Locked,
}

/// A level of a course.
#[derive(Clone, Debug, PartialEq)]
pub struct CourseStep {
    /// Name of the module.
    pub module: String,
    /// Title of the module.
    pub title: LocalText,
    /// Level.
    pub level: u32,
    /// How far it is.
    pub state: StepState,
    /// Whether it is the next one.
    pub is_next: bool,
    /// Passes in a row, and how many of them are needed.
    pub row: [usize; 2],
    /// Attempts that were passed, and all of them.
    pub attempts: [usize; 2],
}

/// A course that somebody takes.
#[derive(Clone, Debug, PartialEq)]
pub struct CourseProgress {
    /// Its name.
    pub name: String,
    /// Its title.
    pub title: LocalText,
    /// Its levels, in order.
    pub steps: Vec<CourseStep>,
}

/// A level of a course as it stands in the store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CourseLevel {
    /// Title of its module.
    pub title: LocalText,
    /// Level.
    pub level: u32,
    /// Passes in a row with which it is mastered.
    pub passes: u32,
}

/// A course of the store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CourseEntry {
    /// Its name.
    pub name: String,
    /// Its title.
    pub title: LocalText,
    /// Whether a level opens with the one before it; else all are open.
    pub in_order: bool,
    /// Its levels, in order.
    pub levels: Vec<CourseLevel>,
    /// Groups that take it.
    pub groups: Vec<String>,
    /// Ids of those who take it by themselves.
    pub trainees: Vec<String>,
}

/// Who takes a course.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Participant {
    /// A trainee, by id.
    Trainee(String),
    /// All members of a group.
    Group(String),
}

/// What is done to the store as a whole, beside the window's thread.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Work {
    /// A file is read into the store: a course (`.toml`), populations (`.csv`) or an export of a store (`.json`).
    Read(PathBuf),
    /// All that is in the store is written to a file that is not there yet.
    Export(PathBuf),
    /// The file of the store is checked.
    Check,
    /// All sessions are read again, and what they show is entered; those below one more folder as well.
    Rebuild(Option<PathBuf>),
}

/// What came of work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Done {
    /// Whether nothing is wrong with what was found.
    pub is_good: bool,
    /// Sentences, one at least.
    pub sentences: Vec<LocalText>,
}

/// Work that has not begun yet.
pub trait Job: Send {
    /// Does it. `progress` takes the part that is done, from 0 to 1, where that is known, and what is being done.
    ///
    /// # Errors
    /// Why it could not be done: what was expected, with file and line where it is in a file. What was in the store is in it as before.
    fn run(self: Box<Self>, progress: &mut dyn FnMut(Option<f64>, String)) -> Result<Done, String>;
}

/// What is changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// Somebody new, in a group if one is stated.
    Add {
        /// The name.
        name: String,
        /// The group.
        group: Option<String>,
    },
    /// Another name.
    Rename {
        /// Whose.
        id: String,
        /// The name.
        name: String,
    },
    /// Another role.
    Role {
        /// Whose.
        id: String,
        /// The role.
        role: Role,
    },
    /// Into a group or out of it; a group is made if there is none.
    Group {
        /// Who.
        id: String,
        /// The group.
        group: String,
        /// Whether they are in it then.
        member: bool,
    },
    /// Into a course or out of it.
    Enrol {
        /// Who.
        who: Participant,
        /// The course.
        course: String,
        /// Whether they take it then.
        takes: bool,
    },
    /// A course goes; results stay.
    RemoveCourse {
        /// The course.
        course: String,
    },
    /// A level of a course is open, whatever is mastered.
    Unlock {
        /// For whom.
        id: String,
        /// The course.
        course: String,
        /// Module of the level.
        module: String,
        /// The level.
        level: u32,
    },
    /// The name goes; id, sessions and results stay.
    Anonymise {
        /// Whose.
        id: String,
    },
    /// Everything of somebody goes.
    Erase {
        /// Of whom.
        id: String,
    },
}

/// The records of a station. Each error is one sentence for people.
pub trait Ledger {
    /// Everybody in the store.
    ///
    /// # Errors
    /// Why the store cannot be read; a store that is not there yet has nobody.
    fn people(&self) -> Result<Vec<Person>, String>;

    /// The courses, by name.
    ///
    /// # Errors
    /// Why the store cannot be read.
    fn courses(&self) -> Result<Vec<CourseEntry>, String>;

    /// Names of all groups, sorted.
    ///
    /// # Errors
    /// Why the store cannot be read.
    fn groups(&self) -> Result<Vec<String>, String>;

    /// Sessions, the newest first.
    ///
    /// # Errors
    /// Why the store cannot be read.
    fn attempts(&self, of: &Selection) -> Result<Vec<Attempt>, String>;

    /// Two sessions, by their ids.
    ///
    /// # Errors
    /// Why the store cannot be read.
    fn compare(&self, ids: [&str; 2]) -> Result<Comparison, String>;

    /// How a trainee has learned a level.
    ///
    /// # Errors
    /// Why the store cannot be read.
    fn learning(&self, trainee: &str, module: &str, level: u32) -> Result<Learning, String>;

    /// The courses that a trainee takes.
    ///
    /// # Errors
    /// Why the store cannot be read.
    fn progress(&self, trainee: &str) -> Result<Vec<CourseProgress>, String>;

    /// What came of a session.
    ///
    /// # Errors
    /// Why its file cannot be read.
    fn debrief(&self, id: &str) -> Result<Debrief, String>;

    /// Where a table is written if nobody states another file.
    fn table(&self) -> PathBuf;

    /// Writes results as a table, `.csv` or `.parquet`; returns the number of sessions in it.
    ///
    /// # Errors
    /// Why it cannot be written.
    fn export(&self, of: &Selection, file: &Path, names: bool) -> Result<usize, String>;

    /// Numbers of the sessions and files that go when somebody is erased.
    ///
    /// # Errors
    /// Why the store cannot be read.
    fn belongings(&self, trainee: &str) -> Result<[usize; 2], String>;

    /// Changes the store.
    ///
    /// # Errors
    /// Why it cannot be changed; nothing is changed then.
    fn change(&self, change: &Change) -> Result<(), String>;

    /// A file for an export of the store if nobody states another.
    fn export_file(&self) -> PathBuf;

    /// Work on the store, which begins when it is run.
    fn job(&self, work: &Work) -> Box<dyn Job>;
}
