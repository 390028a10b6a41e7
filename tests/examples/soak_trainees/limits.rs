//! Limits of a level as they were frozen before any of its trainees was scored, and which of them the level has no more.

use microsim_tests::{repository, tree};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// The limits that a study plays a level with.
pub struct Limits {
    /// Text of the frozen `[[limit]]` tables; `None` where none were frozen, and the level's own count.
    pub frozen: Option<String>,
    /// Metrics that were limited then and are not now.
    pub taken_off: Vec<String>,
    /// Reasons against a run that come of such metrics alone.
    reasons: Vec<String>,
    /// Metrics whose limit is another one now.
    pub moved: Vec<String>,
}

/// Bounds and reason of each limited metric; a reference value is no limit.
type Bounds = BTreeMap<String, ([Option<Value>; 2], String)>;

impl Limits {
    /// Of a level. An error where a file cannot be read.
    pub fn of(module: &str, level: u32) -> Result<Self, String> {
        let read = |path: &std::path::Path| {
            std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
        };
        let name = format!("tests/data/frozen_limits/{module}-{level}.toml");
        let path = repository().join(name);
        let frozen = path.exists().then(|| read(&path)).transpose()?;
        let level = format!("modules/{module}/levels/level{level}.toml");
        let shipped = read(&tree().join(level))?;
        Self::compared(frozen, &shipped)
    }

    /// Of the texts of the frozen limits and of the level.
    pub fn compared(frozen: Option<String>, shipped: &str) -> Result<Self, String> {
        let now = bounds(shipped)?;
        let then = bounds(frozen.as_deref().unwrap_or(shipped))?;
        let still = |reason: &str| now.values().any(|(_, now)| now == reason);
        let off = || then.iter().filter(|(metric, _)| !now.contains_key(*metric));
        let reasons = off().map(|(_, (_, reason))| reason);
        let moved = then
            .iter()
            .filter(|(metric, (then, _))| now.get(*metric).is_some_and(|(now, _)| now != then));
        Ok(Self {
            taken_off: off().map(|(metric, _)| metric.clone()).collect(),
            reasons: reasons.filter(|reason| !still(reason)).cloned().collect(),
            moved: moved.map(|(metric, _)| metric.clone()).collect(),
            frozen,
        })
    }

    /// Whether the level has the limits that it is played with.
    pub fn are_shipped(&self) -> bool {
        self.taken_off.is_empty() && self.moved.is_empty()
    }

    /// The verdict of a run with these reasons against it, were it not for the metrics that are not limited any more.
    pub fn verdict_now<'a>(&self, verdict: &'a str, failed: &str) -> &'a str {
        let mut reasons = failed.split_whitespace().peekable();
        let is_gone = |reason: &str| self.reasons.iter().any(|gone| gone == reason);
        match verdict {
            "failed" if reasons.peek().is_some() && reasons.all(is_gone) => "passed",
            other => other,
        }
    }
}

fn bounds(level: &str) -> Result<Bounds, String> {
    let table: Table = level.parse().map_err(|e| format!("limits: {e}"))?;
    let limits = table.get("limit").and_then(Value::as_array);
    let bound = |limit: &Value| {
        let bounds = ["min", "max"].map(|key| limit.get(key).cloned());
        let text = |key: &str| limit.get(key)?.as_str().map(str::to_owned);
        let metric = text("metric")?;
        let reason = text("reason").unwrap_or_else(|| metric.clone());
        let decides = limit.get("decides") != Some(&Value::Boolean(false));
        let is_limit = decides && bounds.iter().any(Option::is_some);
        is_limit.then_some((metric, (bounds, reason)))
    };
    Ok(limits.into_iter().flatten().filter_map(bound).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two metrics have one reason: it counts until both are gone. A reference value is no limit.
    #[test]
    fn reasons_count_until_no_limit_has_them() {
        let limit =
            |metric: &str, rest: &str| format!("[[limit]]\nmetric = \"{metric}\"\n{rest}\n");
        let hard = "reason = \"too-hard\"";
        let frozen = [
            limit("peak-force", &format!("max = \"40 mN\"\n{hard}")),
            limit("excess-time", &format!("max = \"0.5 s\"\n{hard}")),
            limit("torn", "max = \"0.4 mm^2\""),
            limit("time", "max = \"60 s\""),
        ];
        let shipped = [
            limit("excess-time", &format!("max = \"0.5 s\"\n{hard}")),
            limit("torn", "max = \"0.4 mm^2\"\ndecides = false"),
            limit("time", "max = \"70 s\""),
        ];
        let limits = Limits::compared(Some(frozen.concat()), &shipped.concat()).expect("limits");
        assert_eq!(limits.taken_off, ["peak-force", "torn"]);
        assert_eq!(limits.moved, ["time"]);
        assert_eq!(limits.verdict_now("failed", "torn"), "passed");
        assert_eq!(limits.verdict_now("failed", "too-hard torn"), "failed");
        assert_eq!(limits.verdict_now("not-judged", ""), "not-judged");
        let own = Limits::compared(None, &shipped.concat()).expect("limits");
        assert!(own.are_shipped());
    }
}
