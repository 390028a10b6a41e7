//! Films of replays: numbered pictures in a folder beside the session, and one MP4 file of them where the machine has ffmpeg.

use super::AtThisPlace;
use crate::output::Problem;
use crate::replace_file::write_new;
use crate::sessions::{VIDEO, film_beside};
use microsim_settings::{in_words, unwritable};
use microsim_window::{Film, Filmed, Films, Video};
use std::fs::DirBuilder;
use std::io::{ErrorKind, Read};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The program that makes one file of pictures.
const PROGRAM: &str = "ffmpeg";
/// Pictures of the file in a second, as there are in a second of simulated time.
const RATE: &str = "25";
/// Time between two looks whether that program has ended.
const LOOK: Duration = Duration::from_millis(50);
/// Bytes of its complaint that are shown.
const SHOWN: usize = 400;

impl Films for AtThisPlace {
    fn film(&self, session: &Path) -> Result<Box<dyn Film>, String> {
        Ok(Box::new(Folder::new(session, PROGRAM)?))
    }
}

/// A folder that takes pictures.
#[derive(Debug)]
struct Folder {
    path: PathBuf,
    written: u32,
    program: String,
}

impl Folder {
    /// A new one beside a session, for its user alone.
    fn new(session: &Path, program: &str) -> Result<Self, String> {
        for number in 1.. {
            let path = film_beside(session, number);
            match DirBuilder::new().mode(0o700).create(&path) {
                Ok(()) => {
                    return Ok(Self {
                        path,
                        written: 0,
                        program: program.to_owned(),
                    });
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(unwritable(&path, error)),
            }
        }
        Err(format!("{}: no free name for a film", session.display()))
    }

    /// One file of all pictures.
    fn video(&self, is_stopped: &AtomicBool) -> Video {
        if is_stopped.load(Ordering::Relaxed) || self.written == 0 {
            return Video::Stopped;
        }
        let file = self.path.join(VIDEO);
        let started = Command::new(&self.program)
            .args(["-nostdin", "-loglevel", "error", "-n", "-framerate", RATE])
            // In its folder, whose name may hold signs that mean something to it.
            .current_dir(&self.path)
            .args(["-start_number", "0", "-i", "frame-%06d.png"])
            // What every player shows, and what can be looked at before all of it is there.
            .args(["-pix_fmt", "yuv420p", "-movflags", "+faststart"])
            .arg(VIDEO)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = match started {
            Ok(child) => child,
            Err(error) if error.kind() == ErrorKind::NotFound => return Video::NoProgram,
            Err(error) => return Video::Failed(in_words(error).to_string()),
        };
        // It would wait for room in the pipe if nobody read what it complains of.
        let stderr = child.stderr.take();
        let complaint = std::thread::spawn(move || {
            let mut text = Vec::new();
            if let Some(mut stderr) = stderr {
                let _ = stderr.read_to_end(&mut text);
            }
            String::from_utf8_lossy(&text).trim().to_owned()
        });
        let ended = loop {
            match child.try_wait() {
                Ok(Some(status)) => break Ok(status),
                Ok(None) if is_stopped.load(Ordering::Relaxed) => {
                    let _ = child.kill().and_then(|()| child.wait());
                    let _ = std::fs::remove_file(&file);
                    return Video::Stopped;
                }
                Ok(None) => std::thread::sleep(LOOK),
                Err(error) => break Err(in_words(error).to_string()),
            }
        };
        let failed = match ended {
            Ok(status) if status.success() => return Video::Made(file),
            Ok(status) => {
                let complaint = complaint.join().unwrap_or_default();
                match complaint.is_empty() {
                    true => status.to_string(),
                    false => complaint.chars().take(SHOWN).collect(),
                }
            }
            Err(why) => why,
        };
        // What it has begun plays to no end.
        let _ = std::fs::remove_file(&file);
        Video::Failed(failed)
    }
}

impl Drop for Folder {
    /// A folder without a picture is of no use; one with some cannot be removed like this.
    fn drop(&mut self) {
        let _ = std::fs::remove_dir(&self.path);
    }
}

impl Film for Folder {
    fn add(&mut self, png: &[u8]) -> Result<(), String> {
        let file = self.path.join(format!("frame-{:06}.png", self.written));
        write_new(&file, png).map_err(|problem| match problem {
            Problem::Text(text) => text,
            Problem::BrokenPipe => "a closed pipe".to_owned(),
        })?;
        self.written += 1;
        Ok(())
    }

    fn finish(self: Box<Self>, is_stopped: &AtomicBool) -> Filmed {
        Filmed {
            video: self.video(is_stopped),
            pictures: self.written,
            folder: self.path.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use std::sync::Arc;

    /// A program that does what a line of the shell does; `$last` is the file that it is to make.
    fn program(folder: &Path, line: &str) -> String {
        let path = folder.join("makes-films");
        let text = format!("#!/bin/sh\nfor last; do :; done\n{line}\n");
        fs::write(&path, text).expect("a script");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o700)).expect("set");
        path.display().to_string()
    }

    /// Two pictures, and what comes of them.
    fn filmed(folder: &Path, program: &str, is_stopped: &AtomicBool) -> Filmed {
        let mut film = Folder::new(&folder.join("a.session"), program).expect("a folder");
        film.add(b"first").expect("written");
        film.add(b"second").expect("written");
        Box::new(film).finish(is_stopped)
    }

    #[test]
    fn pictures_are_numbered_and_become_one_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let made = program(folder.path(), r#"echo "$@" > "$last""#);
        let film = filmed(folder.path(), &made, &AtomicBool::new(false));
        let place = folder.path().join("a.film-1");
        let expected = Filmed {
            folder: place.clone(),
            pictures: 2,
            video: Video::Made(place.join("film.mp4")),
        };
        assert_eq!(film, expected);
        assert_eq!(
            fs::read(place.join("frame-000000.png")).expect("one"),
            b"first"
        );
        assert_eq!(
            fs::read(place.join("frame-000001.png")).expect("one"),
            b"second"
        );
        let asked = fs::read_to_string(place.join("film.mp4")).expect("its arguments");
        // Names alone: it works in the folder.
        let pictures = "-framerate 25 -start_number 0 -i frame-%06d.png";
        assert!(asked.contains(pictures), "{asked}");
        // Another one has another folder.
        let film = filmed(folder.path(), &made, &AtomicBool::new(false));
        assert_eq!(film.folder, folder.path().join("a.film-2"));
    }

    #[test]
    fn without_the_program_or_when_it_fails_the_pictures_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let film = filmed(folder.path(), "/no/such/program", &AtomicBool::new(false));
        assert_eq!((film.pictures, film.video), (2, Video::NoProgram));
        let fails = program(
            folder.path(),
            r#"touch "$last"; echo "no encoder" >&2; exit 1"#,
        );
        let film = filmed(folder.path(), &fails, &AtomicBool::new(false));
        assert_eq!(film.video, Video::Failed("no encoder".into()));
        let left: Vec<_> = fs::read_dir(&film.folder).expect("a folder").collect();
        assert_eq!(left.len(), 2);
        let empty = Folder::new(&folder.path().join("b.session"), "x").expect("a folder");
        let place = empty.path.clone();
        assert!(place.is_dir());
        drop(empty);
        assert!(!place.exists());
        let why = Folder::new(Path::new("/no/such/a.session"), "x").expect_err("no folder");
        assert!(why.contains("/no/such"), "{why}");
    }

    #[test]
    fn what_is_stopped_is_no_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let slow = program(folder.path(), r#"touch "$last"; exec sleep 60"#);
        let is_stopped = Arc::new(AtomicBool::new(false));
        let place = folder.path().join("a.film-1/film.mp4");
        let (seen, stop) = (place.clone(), Arc::clone(&is_stopped));
        let stopper = std::thread::spawn(move || {
            while !seen.exists() {
                std::thread::sleep(Duration::from_millis(5));
            }
            stop.store(true, Ordering::Relaxed);
        });
        let film = filmed(folder.path(), &slow, &is_stopped);
        stopper.join().expect("no panic");
        assert_eq!(film.video, Video::Stopped);
        assert!(!place.exists());
    }
}
