//! Marks: objects of the level that lie on tissue and move with it, and their colours.

use crate::fault::Fault;
use crate::tick::Tick;
use microsim_message::{Colour, ObjectSet};
use microsim_settings::Object;

/// Objects of a level whose name starts so are marks.
const MARK: &str = "mark-";

/// What marks show.
pub mod colour {
    use super::Colour;

    /// Not its turn yet.
    pub const WAITING: Colour = [0.55, 0.58, 0.60];
    /// To be done now.
    pub const CURRENT: Colour = [0.95, 0.50, 0.10];
    /// As it should be.
    pub const HOLDING: Colour = [0.98, 0.85, 0.15];
    /// Too far.
    pub const TOO_FAR: Colour = [0.85, 0.12, 0.12];
    /// Done.
    pub const DONE: Colour = [0.20, 0.70, 0.25];

    /// Of what is asked for now: done, as it should be, or neither.
    pub fn of(done: bool, holds: bool) -> Colour {
        match (done, holds) {
            (true, _) => DONE,
            (false, true) => HOLDING,
            (false, false) => CURRENT,
        }
    }
}

/// The marks among the objects of a level, in its order. A fault where there is none.
pub fn mark_places(objects: &[Object]) -> Result<Vec<Object>, Fault> {
    let marks = objects.iter().filter(|o| o.name.starts_with(MARK));
    let marks: Vec<Object> = marks.cloned().collect();
    if marks.is_empty() {
        return Err(Fault::new(format!(
            "the level needs an object whose name starts with \"{MARK}\""
        )));
    }
    Ok(marks)
}

/// Shows a mark where it lies.
pub fn show_mark(tick: &mut Tick<'_>, name: &str, colour: Colour) {
    tick.publish(&ObjectSet {
        name: name.to_owned(),
        active: Some(true),
        colour: Some(colour),
        pose: None,
    });
}

/// Lets an object or rigid obstacle show a colour if it is another one than `shown`, which it becomes.
pub fn show_colour(shown: &mut Colour, tick: &mut Tick<'_>, name: &str, colour: Colour) {
    if *shown != colour {
        *shown = colour;
        mark_colour(tick, name, colour);
    }
}

/// Lets an object or rigid obstacle show a colour.
pub fn mark_colour(tick: &mut Tick<'_>, name: &str, colour: Colour) {
    tick.publish(&ObjectSet {
        name: name.to_owned(),
        colour: Some(colour),
        ..ObjectSet::default()
    });
}
