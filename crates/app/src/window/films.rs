//! Films of replays: numbered pictures in a folder beside the session, and one MP4 file of them where the machine has ffmpeg.

use super::AtThisPlace;
use crate::output::Problem;
use crate::replace_file::write_new;
use crate::sessions::{VIDEO, film_beside};
use microsim_settings::{in_words, unwritable};
use microsim_window::{Film, Filmed, Films, Video};
use std::ffi::OsString;
use std::fs::DirBuilder;
use std::io::{ErrorKind, Read};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::time::Duration;

/// The program that makes one file of pictures.
const PROGRAM: &str = "ffmpeg";
/// Pictures of the file in a second, as there are in a second of simulated time.
const RATE: &str = "25";
/// Time between two looks whether that program has ended.
const LOOK: Duration = Duration::from_millis(50);
/// Bytes of its complaint that are shown.
const SHOWN: usize = 400;
/// How long its complaint is waited for once it has ended.
const PATIENCE: Duration = Duration::from_secs(1);

impl Films for AtThisPlace {
    fn film(&self, session: &Path) -> Result<Box<dyn Film>, String> {
        Ok(Box::new(Folder::new(session, None)?))
    }
}

/// A folder that takes pictures.
#[derive(Debug)]
struct Folder {
    path: PathBuf,
    written: u32,
    /// Where the program is looked for, in the place of the `PATH` of this process.
    search: Option<OsString>,
}

impl Folder {
    /// A new one beside a session, for its user alone.
    fn new(session: &Path, search: Option<OsString>) -> Result<Self, String> {
        for number in 1.. {
            let path = film_beside(session, number);
            match DirBuilder::new().mode(0o700).create(&path) {
                Ok(()) => {
                    return Ok(Self {
                        path,
                        written: 0,
                        search,
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
        let mut command = Command::new(PROGRAM);
        if let Some(search) = &self.search {
            command.env("PATH", search);
        }
        let started = command
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
        let (sender, complaint) = channel();
        std::thread::spawn(move || {
            let mut text = Vec::new();
            if let Some(mut stderr) = stderr {
                let _ = stderr.read_to_end(&mut text);
            }
            // Nobody waits for it any more where it came too late.
            let _ = sender.send(String::from_utf8_lossy(&text).trim().to_owned());
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
                Err(error) => {
                    let _ = child.kill().and_then(|()| child.wait());
                    break Err(in_words(error).to_string());
                }
            }
        };
        let failed = match ended {
            Ok(status) if status.success() => return Video::Made(file),
            Ok(status) => {
                // What it has started itself may have its standard error, and go on.
                let complaint = complaint.recv_timeout(PATIENCE).unwrap_or_default();
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
    use std::ffi::OsStr;
    use std::fs;
    use std::sync::Arc;
    use std::time::Instant;

    /// A program that does what a line of the shell does; `$last` is the file that it is to make.
    fn program(folder: &Path, line: &str) -> OsString {
        let path = folder.join(PROGRAM);
        let text = format!("#!/bin/sh\nfor last; do :; done\n{line}\n");
        // Written by another process: a child that some other test has forked just then would hold the file open for writing, and it could not be executed.
        let write = "printf %s \"$1\" > \"$2\" && chmod 700 \"$2\"";
        let written = Command::new("sh")
            .args(["-c", write, "sh", &text])
            .arg(&path)
            .status();
        assert!(written.expect("a shell").success());
        // Beside those that a line uses.
        let others = std::env::var_os("PATH").unwrap_or_default();
        let all = std::iter::once(folder.into()).chain(std::env::split_paths(&others));
        std::env::join_paths(all).expect("names without a colon")
    }

    /// Two pictures, and what comes of them.
    fn filmed(folder: &Path, search: &OsStr, is_stopped: &AtomicBool) -> Filmed {
        let search = Some(search.to_owned());
        let mut film = Folder::new(&folder.join("a.session"), search).expect("a folder");
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
        // It reads the pictures in its folder.
        let reads = program(folder.path(), r#"cat frame-*.png > "$last""#);
        let film = filmed(folder.path(), &reads, &AtomicBool::new(false));
        let read = fs::read_to_string(film.folder.join("film.mp4")).expect("pictures");
        assert_eq!(read, "firstsecond");
        // Another one has another folder.
        let film = filmed(folder.path(), &made, &AtomicBool::new(false));
        assert_eq!(film.folder, folder.path().join("a.film-3"));
    }

    #[test]
    fn without_the_program_or_when_it_fails_the_pictures_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let film = filmed(
            folder.path(),
            OsStr::new("/no/such"),
            &AtomicBool::new(false),
        );
        assert_eq!((film.pictures, film.video), (2, Video::NoProgram));
        let fails = program(
            folder.path(),
            r#"touch "$last"; echo "no encoder" >&2; exit 1"#,
        );
        let film = filmed(folder.path(), &fails, &AtomicBool::new(false));
        assert_eq!(film.video, Video::Failed("no encoder".into()));
        let left: Vec<_> = fs::read_dir(&film.folder).expect("a folder").collect();
        assert_eq!(left.len(), 2);
        let empty = Folder::new(&folder.path().join("b.session"), None).expect("a folder");
        let place = empty.path.clone();
        assert!(place.is_dir());
        drop(empty);
        assert!(!place.exists());
        let why = Folder::new(Path::new("/no/such/a.session"), None).expect_err("no folder");
        assert!(why.contains("/no/such"), "{why}");
    }

    /// Stops a film while the program is at work, which leaves a file for its number as soon as it is; that number.
    fn stopped_at_work(folder: &Path, line: &str) -> u32 {
        let number = folder.join("number");
        let slow = format!(
            "touch \"$last\"; echo $$ > '{0}.new'; mv '{0}.new' '{0}'; {line}",
            number.display()
        );
        let slow = program(folder, &slow);
        let is_stopped = Arc::new(AtomicBool::new(false));
        let (seen, stop) = (number.clone(), Arc::clone(&is_stopped));
        let stopper = std::thread::spawn(move || {
            let since = Instant::now();
            while !seen.exists() && since.elapsed() < Duration::from_secs(20) {
                std::thread::sleep(Duration::from_millis(5));
            }
            stop.store(true, Ordering::Relaxed);
        });
        let film = filmed(folder, &slow, &is_stopped);
        stopper.join().expect("no panic");
        assert_eq!(film.video, Video::Stopped);
        assert!(!film.folder.join("film.mp4").exists());
        let number = fs::read_to_string(number).expect("its number");
        number.trim().parse().expect("a number")
    }

    /// A program that hangs, also one that cannot be asked to end, is no process any more when the film has ended: not even one that nobody has waited for.
    #[test]
    fn a_program_that_hangs_is_ended() {
        for line in [
            "exec sleep 600",
            "trap '' TERM INT HUP; while :; do sleep 0.1; done",
        ] {
            let folder = tempfile::tempdir().expect("a folder");
            let process = stopped_at_work(folder.path(), line);
            assert!(!Path::new(&format!("/proc/{process}")).exists(), "{line}");
        }
    }

    /// One that ends and leaves behind another process with its standard error is not waited for until that ends.
    #[test]
    fn what_a_program_leaves_behind_is_not_waited_for() {
        let folder = tempfile::tempdir().expect("a folder");
        let end = folder.path().join("end");
        let line = format!(
            "(while [ ! -e '{}' ]; do sleep 0.1; done) & exit 3",
            end.display()
        );
        let fails = program(folder.path(), &line);
        let film = filmed(folder.path(), &fails, &AtomicBool::new(false));
        match film.video {
            Video::Failed(why) => assert!(why.contains('3'), "{why}"),
            other => panic!("{other:?}"),
        }
        fs::write(&end, "").expect("written");
    }
}
