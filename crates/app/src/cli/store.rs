//! Commands on the store: trainees, courses, results.

use super::value::{parse_date, parse_level, parse_role, table_path, utf8_path};
use clap::{Args, Subcommand};
use microsim_store::Role;
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
#[command(
    after_help = "WHO is a name or an id. Sessions and reports hold the id alone, and the name stands in the store. Roles are labels: there are no
passwords, and whoever can write the store can do all of it.

Examples:
  microsim trainees add \"A. Muster\" --group 2026
  microsim trainees export \"A. Muster\" a-muster
  microsim trainees erase \"A. Muster\" --yes"
)]
pub enum TraineesCommand {
    /// List trainees with roles, groups and numbers of sessions
    List(TraineeListArgs),
    /// Add a trainee
    Add(TraineeAddArgs),
    /// Give a trainee another name
    Rename(TraineeRenameArgs),
    /// Set the role of a trainee
    Role(TraineeRoleArgs),
    /// Put trainees into a group or take them out; without options list its members
    Group(GroupArgs),
    /// Write all that is stored of a trainee into a new folder: rows as JSON, results as CSV, sessions with their reports
    Export(TraineeExportArgs),
    /// Remove a trainee with all sessions, reports, pictures, checkpoints and rows; without --yes only list them
    Erase(TraineeGoneArgs),
    /// Remove the name of a trainee alone; id, sessions and results stay
    Anonymise(TraineeGoneArgs),
}

#[derive(Debug, Args)]
pub struct TraineeListArgs {
    /// Members of this group only
    #[arg(long, value_name = "GROUP")]
    pub group: Option<String>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct TraineeAddArgs {
    /// The name; no two trainees have the same
    pub name: String,
    /// operator, instructor or trainee: a label
    #[arg(long, value_name = "ROLE", default_value = "trainee", value_parser = parse_role)]
    pub role: Role,
    /// Group to put them into, which is made if there is none; may be given several times
    #[arg(long, value_name = "GROUP")]
    pub group: Vec<String>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct TraineeRenameArgs {
    /// Name or id
    pub who: String,
    /// The new name
    pub name: String,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct TraineeRoleArgs {
    /// Name or id
    pub who: String,
    /// operator, instructor or trainee: a label
    #[arg(value_parser = parse_role)]
    pub role: Role,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct GroupArgs {
    /// Name of the group
    pub group: String,
    /// Put this trainee in; may be given several times
    #[arg(long, value_name = "WHO")]
    pub add: Vec<String>,
    /// Take this trainee out; may be given several times
    #[arg(long, value_name = "WHO")]
    pub remove: Vec<String>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct TraineeExportArgs {
    /// Name or id
    pub who: String,
    /// Folder to make; it must not exist
    #[arg(value_parser = utf8_path)]
    pub folder: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct TraineeGoneArgs {
    /// Name or id
    pub who: String,
    /// Do it; without this nothing is removed
    #[arg(long)]
    pub yes: bool,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Subcommand)]
#[command(
    after_help = "A level is mastered with so many passes in a row; what does not count as a result neither continues nor ends a row. `run` does not
refuse a level that is not open, but names it.

Examples:
  microsim courses add config/courses/first-steps.toml
  microsim courses enrol first-steps --group 2026
  microsim courses progress first-steps --trainee \"A. Muster\""
)]
pub enum CoursesCommand {
    /// List the courses
    List(JsonArgs),
    /// Show the levels of a course, and who takes it
    Show(NameArgs),
    /// Take a course from its file into the store, in the place of one of the same name
    Add(CourseAddArgs),
    /// Remove a course; results stay
    Remove(NameArgs),
    /// Enrol a trainee or a group, or take them out
    Enrol(CourseEnrolArgs),
    /// Open a level for a trainee, whatever is mastered
    Unlock(CourseUnlockArgs),
    /// Show what is mastered, open and next
    Progress(CourseProgressArgs),
}

#[derive(Debug, Args)]
pub struct JsonArgs {
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct NameArgs {
    /// Name of the course
    pub course: String,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CourseAddArgs {
    /// File (`microsim schema course`)
    #[arg(value_parser = utf8_path)]
    pub file: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CourseEnrolArgs {
    /// Name of the course
    pub course: String,
    /// Name or id of a trainee
    #[arg(
        long,
        value_name = "WHO",
        required_unless_present = "group",
        conflicts_with = "group"
    )]
    pub trainee: Option<String>,
    /// Name of a group: all who are in it at any time
    #[arg(long, value_name = "GROUP")]
    pub group: Option<String>,
    /// Take them out instead
    #[arg(long)]
    pub remove: bool,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CourseUnlockArgs {
    /// Name of the course
    pub course: String,
    /// Module
    pub module: String,
    /// Level
    #[arg(value_parser = parse_level)]
    pub level: u32,
    /// Name or id of the trainee
    #[arg(long, value_name = "WHO")]
    pub trainee: String,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CourseProgressArgs {
    /// Name of the course
    pub course: String,
    /// Name or id of one trainee [default: all who take the course]
    #[arg(long, value_name = "WHO")]
    pub trainee: Option<String>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "With --trainee, --module and --level together the learning curve is shown too: a CUSUM of the results that count, which falls by s with
each pass and rises by 1-s with each fail, for failure rates of 5 % (acceptable) and 15 % (not), errors of 10 %.

The table of --export has one row for each metric of each session, in SI. Texts that a spreadsheet would take for formulas have an apostrophe
before them in CSV.

Examples:
  microsim results --trainee \"A. Muster\"
  microsim results --compare 3f2a9c01 9c01aa37
  microsim results --group 2026 --since 2026-10-01 --export group.csv"
)]
pub struct ResultsArgs {
    /// Of this trainee: name or id
    #[arg(long, value_name = "WHO")]
    pub trainee: Option<String>,
    /// Of the members of this group
    #[arg(long, value_name = "GROUP")]
    pub group: Option<String>,
    /// Of this module
    #[arg(long, value_name = "MODULE")]
    pub module: Option<String>,
    /// Of this level
    #[arg(long, value_name = "N", value_parser = parse_level)]
    pub level: Option<u32>,
    /// Since the beginning of this day, YYYY-MM-DD (UTC)
    #[arg(long, value_name = "DATE", value_parser = parse_date)]
    pub since: Option<i64>,
    /// Compare two sessions, metric by metric: the beginnings of their ids, or their files
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["trainee", "group", "module", "level", "since", "export"])]
    pub compare: Vec<String>,
    /// Write the results as a table, .csv or .parquet
    #[arg(long, value_name = "FILE", value_parser = table_path)]
    pub export: Option<PathBuf>,
    /// Leave the column of names empty in that table
    #[arg(long, requires = "export")]
    pub no_names: bool,
    /// Print one JSON document
    ///
    /// Keys: results, learning_curve; with --compare a, b, same_level, score_difference, metrics; with --export sessions, file
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Subcommand)]
#[command(
    after_help = "Sessions and their results come back from the session files (`rebuild`). Names, roles, groups, courses, unlocked levels, populations and results
whose sessions are gone come back from an `export` alone.

The CSV of a population that `import` takes has the columns module, level, metric, source, n, mean, sd, and for each percentile one such as p10, in the
SI unit of the metric; cells may be empty."
)]
pub enum StoreCommand {
    /// Read sessions again and enter what they show; a damaged store is put aside, and what of it is intact taken over
    Rebuild(RebuildArgs),
    /// Write everything in the store to a JSON file, of a damaged one what can be read
    Export(StoreFileArgs),
    /// Add what is missing from such a file, or a population from CSV; what is there stays as it is
    Import(StoreFileArgs),
    /// Check the file; exit status 1 if it is damaged
    Check(JsonArgs),
    /// Write the file again without what was deleted
    Vacuum(JsonArgs),
}

#[derive(Debug, Args)]
pub struct RebuildArgs {
    /// More folders with sessions, besides that of the user and those that the store knows
    #[arg(value_parser = utf8_path)]
    pub folders: Vec<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct StoreFileArgs {
    /// File
    #[arg(value_parser = utf8_path)]
    pub file: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}
