//! `microsim replay`.

use crate::cli::{Place, ReplayArgs};
use crate::output::{Exit, Problem, print, print_json};
use crate::progress::Progress;
use crate::run::{picture_plan, refuse_old_pictures};
use crate::session_file::{find, installation, open};
use crate::station;
use crate::views;
use microsim_host::assemble::{Installation, differences, locate, renderer_for};
use microsim_host::plan::PluginKind;
use microsim_host::record::{Session, Signatures, hex};
use microsim_host::replay::{ReplayOptions, ReplayOutcome, replay as recompute};
use microsim_host::run::RunError;
use microsim_session::Station;
use serde_json::json;
use std::path::Path;

/// Recomputes a session in this process.
pub fn replay(place: &Place, args: &ReplayArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let path = find(place, &args.session);
    let progress = Progress::new();
    let mut reader = open(&path, &progress, "the session is computed again")?;
    let named = |e: &dyn std::fmt::Display| format!("session {}: {e}", path.display());
    reader
        .session()
        .check_recomputable()
        .map_err(|e| named(&e))?;
    let plan = &reader.session().header.plan;
    let pictures = args
        .frames
        .as_ref()
        .map(|folder| picture_plan(&installation, folder, args.frame_rate, plan.tick_ns));
    let draws = plan.plugins.iter().any(|p| p.kind == PluginKind::Renderer);
    views::check(&args.view)?;
    let renderer = match pictures.is_some() && (!draws || !args.view.is_empty()) {
        true => {
            let mut renderer = renderer_for(&installation, plan, None)?;
            renderer.show(&args.view)?;
            Some(renderer)
        }
        false => None,
    };
    args.frames.as_deref().map_or(Ok(()), refuse_old_pictures)?;
    let options = ReplayOptions {
        threads: args.threads.into(),
        pictures,
        renderer,
    };
    let outcome = recompute(&mut reader, options, |planned| {
        locate(&installation, planned).map_err(|e| RunError::Host(e.to_string()))
    })?;
    progress.clear();
    for name in &outcome.rebuilt {
        tracing::warn!("plugin \"{name}\" is not the build that made this recording");
    }
    let session = reader.session();
    let finding = Finding::new(&installation, args, station::this(place), session, &outcome)?;
    if args.json {
        print_json(&finding.json(&path, session, &outcome))?;
    } else {
        finding.print(session, &outcome)?;
        if let Some(pictures) = &outcome.pictures {
            print(crate::run::picture_line(pictures, args.frames.as_deref()))?;
        }
    }
    Ok(if args.verify && !finding.verified {
        Exit::Negative
    } else {
        Exit::Done
    })
}

/// What a replay shows of a session, one statement apart from the other.
struct Finding {
    /// Every tick on file was computed again, to the bit.
    recomputed: bool,
    /// In what its settings differ from those of the installed level.
    other_settings: Vec<String>,
    /// Every byte is as a trusted station signed it.
    unchanged: bool,
    /// Who signed it, whether trusted or not, and whether to its end.
    signatures: (Signatures, bool),
    /// This station, or why it is not known.
    this: Result<Option<Station>, String>,
    verified: bool,
}

impl Finding {
    fn new(
        installation: &Installation,
        args: &ReplayArgs,
        this: Result<Option<Station>, String>,
        session: &Session,
        outcome: &ReplayOutcome,
    ) -> Result<Self, Problem> {
        // What is missing at the end of a killed session was never promised; wrong bytes, or nothing at all, prove nothing.
        let recomputed = outcome.ticks > 0 && !session.damaged && outcome.difference.is_none();
        // A verdict of other limits or other tissue is none of this level, however exactly it is computed again.
        let other_settings = differences(installation, &session.header.plan)
            .unwrap_or_else(|error| vec![error.to_string()]);
        let trusted = |station: &Station| {
            this.as_ref().is_ok_and(|this| *this == Some(*station))
                || args
                    .station
                    .iter()
                    .any(|text| station.has_fingerprint(text))
        };
        let is_trusted = match &session.signatures {
            Signatures::Whole(station) | Signatures::Until(station, _) => trusted(station),
            Signatures::Missing | Signatures::Broken => false,
        };
        let whole = matches!(session.signatures, Signatures::Whole(_));
        let unchanged = whole && is_trusted && session.complaint.is_none();
        let signed_well = match args.station.is_empty() {
            true => session.signatures != Signatures::Broken,
            false => unchanged,
        };
        Ok(Self {
            verified: recomputed && other_settings.is_empty() && signed_well,
            recomputed,
            other_settings,
            unchanged,
            signatures: (session.signatures, is_trusted),
            this,
        })
    }

    fn json(&self, path: &Path, session: &Session, outcome: &ReplayOutcome) -> serde_json::Value {
        let (state, station, until) = match self.signatures.0 {
            Signatures::Missing => ("missing", None, None),
            Signatures::Broken => ("broken", None, None),
            Signatures::Whole(station) => ("whole", Some(station), None),
            Signatures::Until(station, tick) => ("until", Some(station), Some(tick)),
        };
        let resumed = session.resumed.as_ref().map(|checkpoint| {
            json!({ "tick": checkpoint.tick, "state_hash": hex(&checkpoint.state_hash) })
        });
        let difference = outcome.difference.as_ref();
        let ended = session.failures.iter().find(|failure| failure.ended);
        json!({
            "session": path,
            "ticks": outcome.ticks,
            "verified": self.verified,
            "recomputed": self.recomputed,
            "other_settings": self.other_settings,
            "unchanged": self.unchanged,
            "signature": {
                "state": state,
                "station": station.map(|station| station.to_string()),
                "trusted": self.signatures.1,
                "until_tick": until,
            },
            "resumed": resumed,
            "guest_ended": ended.map(|f| json!({ "plugin": f.plugin, "tick": f.tick })),
            "first_difference": difference.map(|d| json!({ "tick": d.tick, "what": d.what })),
            "state_hash": outcome.state_hash,
            "recorded_hash": outcome.recorded_hash,
            "complaint": session.complaint,
            "rebuilt": outcome.rebuilt,
            "pictures": outcome.pictures.as_ref().map(|p| json!({ "written": p.written, "off": p.off })),
        })
    }

    fn print(&self, session: &Session, outcome: &ReplayOutcome) -> Result<(), Problem> {
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
        if let Some(failure) = session.failures.iter().find(|failure| failure.ended) {
            print(format!("As recorded, not computed: {failure}"))?;
        }
        if let Some(checkpoint) = &session.resumed {
            print(format!(
                "It goes on at tick {} of another session, whose state hash there has to be {}",
                checkpoint.tick,
                hex(&checkpoint.state_hash)
            ))?;
        }
        if !self.other_settings.is_empty() {
            print(format!(
                "Recorded with other settings than those of this installation, so that the verdict is not that of its level: {}",
                self.other_settings.join(", ")
            ))?;
        }
        print(self.origin())
    }

    /// What the signatures show, in one sentence.
    fn origin(&self) -> String {
        let this = match &self.this {
            Ok(Some(this)) => format!("this one is {this}"),
            Ok(None) => "this one has no key".to_owned(),
            Err(why) => format!("of this one nothing is known: {why}"),
        };
        match self.signatures {
            (Signatures::Missing, _) => "Not signed: its origin is not proven".to_owned(),
            (Signatures::Broken, _) => {
                "Changed after it was signed: a signature does not fit, and its origin is not proven"
                    .to_owned()
            }
            (Signatures::Whole(station), true) if self.unchanged => {
                format!("Unchanged since station {station} signed it")
            }
            (Signatures::Until(station, tick), true) => format!(
                "As station {station} signed it up to tick {tick}; what follows has no signature, as it was cut off"
            ),
            (Signatures::Whole(station) | Signatures::Until(station, _), _) => format!(
                "Signed by station {station}, which is not trusted here ({this}; `--station` names others): its origin is not proven"
            ),
        }
    }
}
