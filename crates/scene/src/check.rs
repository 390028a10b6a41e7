//! Values of a description that no other part checks: finite numbers, axes, times in order, one holder per node.

use crate::error::SceneError;
use crate::spec::{BodySpec, LoadKind, MotionSpec, Selection};

/// Refuses a body with a value that cannot be computed with.
pub(crate) fn check(body: &BodySpec) -> Result<(), SceneError> {
    let wrong = |what, index, reason| SceneError::Value {
        body: body.name.clone(),
        what,
        index,
        reason,
    };
    if !finite(&body.origin) {
        return Err(wrong("origin", 0, NOT_FINITE));
    }
    if body.toughness.is_nan() || body.toughness <= 0.0 || !(0.0..=1.0).contains(&body.brittleness)
    {
        let reason = "toughness is above 0 N/m, brittleness from 0 to 1";
        return Err(wrong("cutting", 0, reason));
    }
    if body
        .tear_strains
        .iter()
        .any(|(_, strain)| strain.is_nan() || *strain <= 0.0)
    {
        return Err(wrong(
            "cutting",
            0,
            "a strain at which tissue tears is above 0",
        ));
    }
    for (index, clamp) in body.clamps.iter().enumerate() {
        let reason = selection(&clamp.nodes).or_else(|| clamp.motion.as_ref().and_then(motion));
        let bad_release = clamp
            .release
            .is_some_and(|time| time.is_nan() || time < 0.0);
        let reason = reason.or(bad_release.then_some("its release is a time of at least 0 s"));
        if let Some(reason) = reason {
            return Err(wrong("clamp", index, reason));
        }
    }
    for (index, load) in body.loads.iter().enumerate() {
        let values = match &load.kind {
            LoadKind::Pressure(pressure) => pressure.is_finite(),
            LoadKind::Traction(traction) => finite(traction),
        };
        let ramp = load.ramp.is_finite() && load.ramp >= 0.0;
        let reason = selection(&load.surface).or((!values || !ramp).then_some(NOT_FINITE));
        if let Some(reason) = reason {
            return Err(wrong("load", index, reason));
        }
    }
    for (index, start) in body.start.iter().enumerate() {
        let rows = start.matrix.iter().all(|row| finite(row));
        let rest = finite(&start.pivot) && finite(&start.shift) && finite(&start.velocity);
        let reason = selection(&start.nodes).or((!rows || !rest).then_some(NOT_FINITE));
        if let Some(reason) = reason {
            return Err(wrong("start", index, reason));
        }
    }
    Ok(())
}

const NOT_FINITE: &str = "a number is not finite, or a time is below 0 s";

fn finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

fn selection(selection: &Selection) -> Option<&'static str> {
    let (numbers, axis) = match selection {
        Selection::All => (true, true),
        // Infinite bounds are fine: a half space.
        Selection::Box(region) => {
            let nan = |values: &[f64; 3]| values.iter().any(|v| v.is_nan());
            (!nan(&region.min) && !nan(&region.max), true)
        }
        Selection::Shell {
            point,
            axis,
            radius,
        } => (
            finite(point) && radius.iter().all(|r| !r.is_nan()),
            direction(axis),
        ),
        Selection::Nearest(point) => (finite(point), true),
    };
    match (numbers, axis) {
        (false, _) => Some(NOT_FINITE),
        (_, false) => Some("an axis is a direction that is not zero"),
        _ => None,
    }
}

fn direction(axis: &[f64; 3]) -> bool {
    finite(axis) && axis.iter().any(|c| *c != 0.0)
}

fn motion(motion: &MotionSpec) -> Option<&'static str> {
    let times = motion.keys.iter().map(|key| key.time);
    let ordered = times.clone().zip(times.clone().skip(1)).all(|(a, b)| a < b);
    let values = motion
        .keys
        .iter()
        .all(|key| finite(&key.shift) && key.angle.is_finite());
    if !direction(&motion.axis) {
        Some("an axis is a direction that is not zero")
    } else if !finite(&motion.pivot) || !values || times.clone().any(|t| !t.is_finite() || t < 0.0)
    {
        Some(NOT_FINITE)
    } else if !ordered {
        Some("the times of a motion ascend")
    } else {
        None
    }
}

/// Refuses a node that is held twice when one of its holders moves: which of them prescribes it would be a matter of chance.
pub(crate) fn check_holders(body: &BodySpec, nodes: &[Vec<u32>]) -> Result<(), SceneError> {
    let moves = |index: usize| body.clamps[index].motion.is_some();
    for (first, of_first) in nodes.iter().enumerate() {
        for (second, of_second) in nodes.iter().enumerate().skip(first + 1) {
            let shared = of_first
                .iter()
                .any(|node| of_second.binary_search(node).is_ok());
            if shared && (moves(first) || moves(second)) {
                return Err(SceneError::HeldTwice {
                    body: body.name.clone(),
                    clamps: [first, second],
                });
            }
        }
    }
    Ok(())
}
