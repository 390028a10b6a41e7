//! A course: levels of modules in order, and when the next one opens.

use crate::check::items;
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{english_text, identifier};
use crate::table::{choices, table};
use microsim_vocabulary::{LocalText, terms};
use std::path::Path;

table! {
    /// A course.
    pub struct Course {
        /// Its name, by which commands know it.
        name: String = identifier(),
        /// What people call it.
        title: LocalText = english_text(),
        /// When a level opens.
        unlock: Unlock => "in-order",
        /// Passes in a row after which a level is mastered, where the step states no other number.
        passes: u32 [1, 100] => 2,
        /// Its levels in their order.
        step: Vec<CourseStep> [1, 1000],
    }
}

table! {
    /// A level of a course.
    pub struct CourseStep {
        /// Module.
        module: String = identifier(),
        /// Level of the module.
        level: u32 [1, 999],
        /// Passes in a row after which it is mastered.
        passes: Option<u32> [1, 100],
    }
}

terms! {
    /// When a level of a course opens.
    pub enum Unlock {
        /// When the one before it is mastered.
        InOrder = "in-order",
        /// All are open from the beginning.
        AllOpen = "all-open",
    }
}

choices! { Unlock }

/// Reads a course from a text; `file` is the name that complaints use.
pub fn read_course(text: &str, file: &str) -> Result<Loaded<Course>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Course>("course"))?;
    let steps: Vec<(usize, String, u64)> = items(reading.value(), "step")
        .filter_map(|(at, step)| {
            Some((
                at,
                step["module"].as_str()?.to_owned(),
                step["level"].as_u64()?,
            ))
        })
        .collect();
    for (n, (at, module, level)) in steps.iter().enumerate() {
        let same = |earlier: &(usize, String, u64)| earlier.1 == *module && earlier.2 == *level;
        if steps[..n].iter().any(same) {
            reading.complain(
                &KeyPath::root().key("step").at(*at),
                &format!("level {level} of `{module}` a second time"),
                "a level that no other `step` has",
            );
        }
    }
    reading.finish()
}

/// Reads the course at `path`.
pub fn load_course(path: &Path) -> Result<Loaded<Course>, ConfigErrors> {
    let text = load_text(path, "a course (config/courses/NAME.toml)")?;
    read_course(&text, &path.display().to_string())
}
