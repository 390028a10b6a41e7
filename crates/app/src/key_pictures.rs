//! Pictures of the key moments of a session: the session is computed again, and drawn at their ticks.

use crate::output::Problem;
use crate::progress::Progress;
use crate::session_file::open;
use microsim_host::assemble::{Installation, locate, probe_renderer, renderer_for};
use microsim_host::picture::{PicturePlan, PictureTimes};
use microsim_host::replay::{ReplayOptions, replay};
use microsim_host::run::RunError;
use microsim_message::LocalText;
use microsim_report::{Pictures, Report};
use std::collections::BTreeMap;
use std::io::ErrorKind;
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

/// No pictures yet: they are drawn once the page is on the disk.
pub fn not_yet() -> Pictures {
    Pictures::Missing(LocalText::new(
        "sie werden nach dem Urteil gezeichnet; endet das Programm vorher, zeichnet sie microsim report SITZUNG --html DATEI --pictures.",
        "they are drawn after the verdict; if the program ends before, microsim report SESSION --html FILE --pictures draws them.",
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

/// Beginning of its name; the number of the process follows.
const SCRATCH: &str = "microsim-pictures-";

impl Scratch {
    fn new(among: &Path) -> Result<Self, String> {
        remove_abandoned(among);
        // What an earlier process of the same number has left is not ours.
        for attempt in 0.. {
            let folder = among.join(format!("{SCRATCH}{}-{attempt}", std::process::id()));
            match std::fs::create_dir(&folder) {
                Ok(()) => return Ok(Self(folder)),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(format!("{}: {error}", folder.display())),
            }
        }
        Err(format!("{}: no free name", among.display()))
    }
}

/// Removes the folders of processes that are no more: they were killed while they drew.
fn remove_abandoned(among: &Path) {
    let processes = Path::new("/proc");
    if !processes.join("self").exists() {
        return;
    }
    for entry in std::fs::read_dir(among).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let process = name
            .strip_prefix(SCRATCH)
            .and_then(|rest| rest.split('-').next()?.parse::<u32>().ok());
        if process.is_some_and(|process| !processes.join(process.to_string()).exists()) {
            // Those of other users cannot be removed, and do not disturb.
            let _ = std::fs::remove_dir_all(entry.path());
        }
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
    let progress = Progress::new();
    let opened = open(session, &progress, "pictures of the key moments are drawn");
    let mut session = opened.map_err(|problem| match problem {
        Problem::Text(text) => text,
        Problem::BrokenPipe => "a closed pipe".to_owned(),
    })?;
    let plan = &session.session().header.plan;
    let renderer = renderer_for(installation, plan, Some(SIZE)).map_err(|e| e.to_string())?;
    let scratch = Scratch::new(&std::env::temp_dir())?;
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
        let mut planned =
            locate(installation, planned).map_err(|e| RunError::Host(e.to_string()))?;
        // It has printed what it prints.
        planned.hosting.silence();
        Ok(planned)
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

#[cfg(test)]
mod tests {
    use super::{SCRATCH, Scratch};

    /// A folder that a process of the same number has left does not block; that of a process that is no more is removed.
    #[test]
    fn what_killed_processes_left_blocks_nothing() {
        let temporary = tempfile::tempdir().expect("a folder");
        let folder = |name: String| {
            let folder = temporary.path().join(name);
            std::fs::create_dir(&folder).expect("a folder");
            folder
        };
        let same = folder(format!("{SCRATCH}{}-0", std::process::id()));
        // No system has processes of such numbers.
        let gone = folder(format!("{SCRATCH}{}", u32::MAX));
        let scratch = Scratch::new(temporary.path()).expect("a folder");
        assert!(scratch.0.is_dir() && scratch.0 != same);
        assert!(same.is_dir() && !gone.exists());
    }
}
