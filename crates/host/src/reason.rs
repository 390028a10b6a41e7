//! Why the tissue of a level is computed as it is: what the level's file says was measured, in words.

use microsim_settings::Level;

/// How far the mesh is off, what would be allowed, and what locking costs; what follows a sentence. Empty if nothing was measured.
pub fn mesh(level: &Level) -> String {
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
pub fn method(level: &Level) -> String {
    let Some((tuned, cost)) = level.tuned.as_ref().and_then(|t| Some((t, t.cost?))) else {
        return String::new();
    };
    let mut reason = format!("; {} of one core for the tissue alone", percent(cost));
    if !tuned.rejected.is_empty() {
        reason += &format!(
            ", {} other ways were rejected ([tuned] of the level)",
            tuned.rejected.len()
        );
    }
    reason
}

/// How many steps there are in a tick, and how far that is from failing.
pub fn step(level: &Level) -> String {
    let steps = match level.clock.steps {
        1 => "one step in a tick".to_owned(),
        steps => format!("{steps} steps in a tick"),
    };
    match level.tuned.as_ref().and_then(|tuned| tuned.margin) {
        None => steps,
        Some(margin) => format!("{steps}; stable at {margin} times it as well"),
    }
}

/// A share in percent, to two digits.
fn percent(share: f64) -> String {
    let share = 100.0 * share;
    let digits = usize::from(share < 10.0);
    format!("{share:.digits$} %")
}

#[cfg(test)]
mod tests {
    use super::percent;

    #[test]
    fn shares_have_two_digits() {
        assert_eq!(percent(0.0351), "3.5 %");
        assert_eq!(percent(0.372), "37 %");
    }
}
