//! Pictures of the key moments of a session: the session is computed again, and drawn at their ticks.

use crate::output::Problem;
use crate::session_file::open;
use microsim_host::assemble::{Installation, locate, probe_renderer, renderer_for};
use microsim_host::picture::{PicturePlan, PictureTimes};
use microsim_host::replay::{ReplayOptions, replay};
use microsim_host::run::RunError;
use microsim_message::LocalText;
use microsim_report::{Pictures, Report};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Width and height \[pixels\].
const SIZE: u32 = 480;

/// No pictures, as nobody asked for them.
pub fn not_asked() -> Pictures {
    Pictures::Missing(LocalText::new(
        "es wurden keine verlangt; microsim report SITZUNG --html DATEI --pictures zeichnet sie.",
        "none were asked for; microsim report SESSION --html FILE --pictures draws them.",
    ))
}

/// The pictures of the key moments, or why there are none.
pub fn key_pictures(
    installation: &Installation,
    session: &Path,
    report: &Report,
    threads: usize,
) -> Pictures {
    draw(installation, session, report, threads).unwrap_or_else(|why| {
        Pictures::Missing(LocalText::new(
            format!("sie ließen sich nicht zeichnen ({why})."),
            format!("they could not be drawn ({why})."),
        ))
    })
}

/// A folder that is gone with this value.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Self, String> {
        let name = format!("microsim-pictures-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        Ok(Self(folder))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        if let Err(error) = std::fs::remove_dir_all(&self.0) {
            tracing::warn!("{}: {error}", self.0.display());
        }
    }
}

fn draw(
    installation: &Installation,
    session: &Path,
    report: &Report,
    threads: usize,
) -> Result<Pictures, String> {
    probe_renderer(installation)?;
    let mut session = open(session).map_err(|problem| match problem {
        Problem::Text(text) => text,
        Problem::BrokenPipe => "a closed pipe".to_owned(),
    })?;
    let plan = &session.session().header.plan;
    let renderer = renderer_for(installation, plan, Some(SIZE)).map_err(|e| e.to_string())?;
    let scratch = Scratch::new()?;
    let wanted = PicturePlan {
        folder: scratch.0.clone(),
        when: PictureTimes::At(report.key_ticks().into_iter().collect()),
    };
    let options = ReplayOptions {
        threads,
        pictures: Some(wanted.clone()),
        renderer: Some(renderer),
    };
    let outcome = replay(&mut session, options, |planned| {
        locate(installation, planned).map_err(|e| RunError::Host(e.to_string()))
    });
    let outcome = outcome.map_err(|e| e.to_string())?;
    if let Some(difference) = outcome.difference {
        return Err(format!(
            "computed again, the session differs at tick {}: {}",
            difference.tick, difference.what
        ));
    }
    if let Some(off) = outcome.pictures.and_then(|pictures| pictures.off) {
        return Err(off);
    }
    let read = |path: &Path| std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()));
    let mut drawn = BTreeMap::new();
    for tick in report.key_ticks() {
        if let Some(file) = wanted.file(tick) {
            drawn.insert(tick, read(&file)?);
        }
    }
    Ok(Pictures::Drawn(drawn))
}
