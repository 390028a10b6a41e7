//! What levels leave behind in memory: one of each module is begun, shown and aborted, and all of them again, ten times.
//!
//! What is needed to show a level for the first time in a process (pictures in the launcher, text, pipelines of the driver) stays by intention, and the graphics
//! library retains blocks of up to 32 MiB of which it touches more from level to level, until it has touched all. So what is resident rises at first, with any
//! program; what counts is whether it ends: the last [`COMPARED`] times are compared with as many before them. Of each the least counts, since a block of that
//! pool is there in some launchers and not in others. The program's own allocator gives back what is freed ([`ALLOCATOR`]).
//!
//! Nothing else happens meanwhile but that the window has another size now and then: what a quality or a lost device takes is not looked at here.

use crate::account::resident;
use crate::player::{Player, data_folder};
use crate::{Level, levels};
use microsim_tests::desktop::Display;
use microsim_tests::peers::Peer;
use microsim_tests::scratch;
use std::fmt::Write as _;

/// A level may leave so much behind \[MB\]: a thousand of them, more than a day has, would leave 100 MB.
const BOUND: f64 = 0.1;
/// The level of each module.
const LEVEL: u32 = 2;
/// How often all are gone through, and how many of these times are compared with those before them.
const ROUNDS: usize = 10;
const COMPARED: usize = 3;
/// Settings of glibc's allocator with which what is resident follows what is in use: one heap, blocks from 64 KiB on by themselves.
const ALLOCATOR: [(&str, &str); 3] = [
    ("MALLOC_ARENA_MAX", "1"),
    ("MALLOC_MMAP_THRESHOLD_", "65536"),
    ("MALLOC_TRIM_THRESHOLD_", "65536"),
];
/// After one in so many levels the window has another size, and the next time the first one again.
const RESIZED: usize = 4;
const SIZES: [[&str; 2]; 2] = [["1100", "680"], ["1280", "720"]];

/// Resident memory in the launcher \[MB\] of 10⁶ bytes, after each level.
type Rests = Vec<(Level, f64)>;

pub fn rests() -> Result<Rests, String> {
    let folder = scratch();
    let data = data_folder(folder.path())?;
    let display = Display::open()?;
    let mut window = display.program(&data, ["window", "--lang", "en", "--size", "1280x720"]);
    let window = window
        .envs(ALLOCATOR)
        .spawn()
        .map_err(|error| format!("the program: {error}"))?;
    let window = Peer(window);
    let mut player = Player::new(&display, 1, &data);
    player.focus()?;
    player.wait(3.0);
    let mut rests = Rests::new();
    let mut once = levels();
    once.retain(|level| level.number == LEVEL);
    let all = std::iter::repeat_n(once, ROUNDS).flatten();
    for (n, level) in all.enumerate() {
        let what = format!("{} level {}", level.module, level.number);
        eprintln!("{what}");
        let id = player.focus()?;
        if n % RESIZED == RESIZED - 1 {
            let [width, height] = SIZES[n / RESIZED % SIZES.len()];
            display.ask(&["windowsize", "--sync", &id, width, height])?;
        }
        let seen = player.look_at(level.place, level.number);
        seen.map_err(|why| format!("{what}: {why}"))?;
        let now =
            resident(window.0.id()).ok_or_else(|| format!("{what}: the program has ended"))?;
        rests.push((level, now));
    }
    Ok(rests)
}

/// The page, and whether levels leave nothing behind.
pub fn page(rests: &Rests) -> (String, bool) {
    let count = rests.len() / ROUNDS;
    let rounds: Vec<&[(Level, f64)]> = rests.chunks_exact(count).collect();
    let least = |rounds: &[&[(Level, f64)]]| {
        let memory = rounds.iter().flat_map(|round| round.iter());
        memory.map(|rest| rest.1).fold(f64::INFINITY, f64::min)
    };
    let (before, last) = rounds[ROUNDS - 2 * COMPARED..].split_at(COMPARED);
    let [before, last] = [least(before), least(last)];
    let growth = (last - before) / (count * COMPARED) as f64;
    let is_good = growth <= BOUND;
    let mut text = format!(
        "# What levels leave behind in memory\n\nCommand: `cargo xtask soak window -- memory`. One process, moved from outside by keys, 1280 × 720 pixels at first, with pictures in low quality by a driver of the processor. \
         Level {LEVEL} of each of the {count} modules is begun, shown for a second and aborted, and all of them again, {ROUNDS} times; after every {RESIZED}th level the window has another size. glibc's allocator has one heap and gives back what is freed.\n\n\
         - Least resident memory in the launcher: {last:.1} MB in the last {COMPARED} times, {before:.1} MB in the {COMPARED} before them: **{growth:+.3} MB per level**; it is to be at most {BOUND} MB.\n\
         - Faults: {}.\n\nResident memory in the launcher after each level \\[MB\\]:\n\n| level |",
        match is_good {
            true => "none",
            false => "levels leave memory behind",
        }
    );
    for round in 1..=ROUNDS {
        let _ = write!(text, " {round} |");
    }
    text += "\n|---|";
    text += &"---|".repeat(ROUNDS);
    for (k, (level, _)) in rounds[0].iter().enumerate() {
        let _ = write!(text, "\n| {} {} |", level.module, level.number);
        for round in &rounds {
            let _ = write!(text, " {:.1} |", round[k].1);
        }
    }
    (text + "\n", is_good)
}
