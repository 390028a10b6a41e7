//! `microsim replay`.

use crate::cli::{Place, ReplayArgs};
use crate::output::{Exit, Problem, print, print_json};
use crate::run::{picture_plan, refuse_old_pictures};
use crate::session_file::{installation, read};
use microsim_host::assemble::{differences, locate};
use microsim_host::replay::{ReplayOptions, replay as recompute};
use microsim_host::run::RunError;
use serde_json::json;

/// Recomputes a session in this process.
pub fn replay(place: &Place, args: &ReplayArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let mut session = read(&args.session)?;
    session
        .check_recomputable()
        .map_err(|e| format!("session {}: {e}", args.session.display()))?;
    let plan = &session.header.plan;
    let pictures = args
        .frames
        .as_ref()
        .map(|folder| picture_plan(&installation, folder, args.frame_rate, plan.tick_ns));
    if pictures.is_some()
        && !plan
            .plugins
            .iter()
            .any(|p| p.kind == microsim_host::plan::PluginKind::Renderer)
    {
        let renderer = microsim_host::assemble::renderer_for(&installation, plan, None)?;
        session.header.plan.plugins.push(renderer);
    }
    args.frames.as_deref().map_or(Ok(()), refuse_old_pictures)?;
    let options = ReplayOptions {
        threads: args.threads.into(),
        pictures,
    };
    let outcome = recompute(&session, options, |planned| {
        locate(&installation, planned).map_err(|e| RunError::Host(e.to_string()))
    })?;
    for name in &outcome.rebuilt {
        tracing::warn!("plugin \"{name}\" is not the build that made this recording");
    }
    // What is missing at the end of a killed session was never promised; wrong bytes, or nothing at all, prove nothing.
    let recomputed = outcome.ticks > 0 && !session.damaged && outcome.difference.is_none();
    // A verdict of other limits or other tissue is none of this level, however exactly it is computed again.
    let other_settings = differences(&installation, &session.header.plan)
        .unwrap_or_else(|error| vec![error.to_string()]);
    let verified = recomputed && other_settings.is_empty();
    if args.json {
        print_json(&json!({
            "session": args.session,
            "ticks": outcome.ticks,
            "verified": verified,
            "recomputed": recomputed,
            "other_settings": other_settings,
            "first_difference": outcome.difference.as_ref().map(|d| json!({ "tick": d.tick, "what": d.what })),
            "state_hash": outcome.state_hash,
            "recorded_hash": outcome.recorded_hash,
            "complaint": session.complaint,
            "rebuilt": outcome.rebuilt,
            "pictures": outcome.pictures.as_ref().map(|p| json!({ "written": p.written, "off": p.off })),
        }))?;
    } else {
        if let Some(complaint) = &session.complaint {
            print(format!("The recording is not complete: {complaint}"))?;
        }
        match &outcome.difference {
            None if outcome.ticks == 0 => print("There is no tick to replay")?,
            None => print(format!(
                "Replayed {} ticks to the bit{}; state hash {}",
                outcome.ticks,
                if session.complaint.is_some() {
                    ", all that can be read"
                } else {
                    ""
                },
                outcome.state_hash
            ))?,
            Some(difference) => print(format!(
                "The replay first differs at tick {} ({:.3} s): {}",
                difference.tick,
                (difference.tick + 1) as f64 * session.header.plan.tick_ns as f64 * 1e-9,
                difference.what
            ))?,
        }
        if !other_settings.is_empty() {
            print(format!(
                "Recorded with other settings than those of this installation, so that the verdict is not that of its level: {}",
                other_settings.join(", ")
            ))?;
        }
        if let Some(pictures) = &outcome.pictures {
            print(crate::run::picture_line(pictures, args.frames.as_deref()))?;
        }
    }
    Ok(if args.verify && !verified {
        Exit::Negative
    } else {
        Exit::Done
    })
}
