//! The parts of a level in words: what is computed, and why it is computed as it is.

use crate::error::KeyPath;
use crate::level::Level;

/// A part of a level, for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LevelPart {
    /// `body`, `object`, `rigid`, `contact`, `cut`, `method`, `step`, `tool`.
    pub what: &'static str,
    /// Its name.
    pub name: String,
    /// Why it is there, one sentence.
    pub why: String,
}

fn part(what: &'static str, name: impl Into<String>, why: impl Into<String>) -> LevelPart {
    LevelPart {
        what,
        name: name.into(),
        why: why.into(),
    }
}

/// The parts of a level, but for what a run leaves out: `physics` or `lonor`.
pub fn level_parts(level: &Level, without: &[String]) -> Vec<LevelPart> {
    let leaves_out = |what: &str| without.iter().any(|without| without == what);
    let mut parts = Vec::new();
    for tool in &level.tool {
        let why = format!("the level gives this slot the model \"{}\"", tool.model);
        parts.push(part("tool", &tool.name, why));
    }
    for object in &level.object {
        for name in object.names() {
            parts.push(part("object", name, "the level names it"));
        }
    }
    if let (Some(physics), false) = (&level.physics, leaves_out("physics")) {
        for obstacle in &level.rigid {
            parts.push(part("rigid", &obstacle.name, "the level names it"));
        }
        for body in &level.body {
            let mesh = match (body.elements(), &body.file) {
                (Some(elements), _) => format!("{elements} tetrahedra"),
                (None, file) => format!("its mesh from {}", file.as_deref().unwrap_or("a file")),
            };
            let refined = match body.refine.len() {
                0 => String::new(),
                1 => ", finer in one place".to_owned(),
                places => format!(", finer in {places} places"),
            };
            let reason = mesh_reason(level);
            let why = format!("the level names it; {mesh}{refined}{reason}");
            parts.push(part("body", &body.name, why));
        }
        for pair in &level.contact {
            let name = format!("{} on {}", pair.partner(), pair.body);
            let why = "the level lists this pair; no other contact is looked for";
            parts.push(part("contact", name, why));
        }
        for pair in level.cut.iter().filter(|_| !leaves_out("lonor")) {
            let name = format!("{} through {}", pair.tool, pair.body);
            parts.push(part(
                "cut",
                name,
                "the level lists this pair; nothing else is cut",
            ));
        }
        let why = format!(
            "the level asks for it; gravity {:?} m/s^2{}",
            physics.gravity,
            method_reason(level)
        );
        let method = level.method.map_or("", |method| method.name.name());
        parts.push(part("method", method, why));
        let step = level.clock.tick / f64::from(level.clock.steps);
        parts.push(part(
            "step",
            format!("{} ms", step * 1e3),
            step_reason(level),
        ));
    }
    parts
}

impl Level {
    /// The relative error of the tissue that the level states as measured.
    pub fn model_error(&self) -> Option<f64> {
        self.tuned.as_ref()?.error
    }

    /// The files that the level names, relative to its own, with the keys that name them.
    pub fn files(&self) -> Vec<(KeyPath, String)> {
        let key = |index| KeyPath::root().key("body").at(index).key("file");
        let bodies = self.body.iter().enumerate();
        let files = bodies.flat_map(|(index, body)| {
            let files = body.files().into_iter();
            files.map(move |file| (key(index), file))
        });
        files.collect()
    }

    /// The files of models and textures that objects name, with the keys that name them.
    pub fn object_files(&self) -> Vec<(KeyPath, String)> {
        let objects = self.object.iter().enumerate();
        let files = objects.flat_map(|(index, object)| {
            let key = KeyPath::root().key("object").at(index);
            let files = object.files().into_iter();
            files.map(move |(name, file)| (key.key(name), file.to_owned()))
        });
        files.collect()
    }
}

/// How far the mesh is off, what would be allowed, and what locking costs; what follows a sentence. Empty if nothing was measured.
fn mesh_reason(level: &Level) -> String {
    let Some((tuned, error)) = level.tuned.as_ref().and_then(|t| Some((t, t.error?))) else {
        return String::new();
    };
    let mut reason = format!("; off by {}", percent(error));
    if let Some(accuracy) = &level.accuracy {
        reason += &format!(", {} are allowed", percent(accuracy.error));
    }
    if let Some(locking) = tuned.locking {
        reason += &format!(
            "; linear tetrahedra, which lock, would be off by {}",
            percent(locking)
        );
    }
    if let Some(command) = &tuned.command {
        reason += &format!(" (`{command}`)");
    }
    reason
}

/// What the method costs; what follows a sentence. Empty if nothing was measured.
fn method_reason(level: &Level) -> String {
    let Some((tuned, cost)) = level.tuned.as_ref().and_then(|t| Some((t, t.cost?))) else {
        return String::new();
    };
    let mut reason = format!("; {} of one core for the tissue alone", percent(cost));
    if !tuned.rejected.is_empty() {
        reason += &format!(
            ", {} other methods were rejected ([tuned] of the level)",
            tuned.rejected.len()
        );
    }
    reason
}

/// How many steps there are in a tick, and how far that is from failing.
fn step_reason(level: &Level) -> String {
    let steps = match level.clock.steps {
        1 => "one step in a tick".to_owned(),
        steps => format!("{steps} steps in a tick"),
    };
    match level.tuned.as_ref().and_then(|tuned| tuned.margin) {
        None => steps,
        Some(margin) => format!("{steps}; stable at {margin} times it as well"),
    }
}

/// A ratio in percent, to two digits.
fn percent(ratio: f64) -> String {
    let percent = 100.0 * ratio;
    let digits = usize::from(percent < 10.0);
    format!("{percent:.digits$} %")
}

#[cfg(test)]
mod tests {
    use super::percent;

    #[test]
    fn ratios_have_two_digits() {
        assert_eq!(percent(0.0351), "3.5 %");
        assert_eq!(percent(0.372), "37 %");
    }
}
