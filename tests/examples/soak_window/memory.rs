//! What levels leave behind in memory: each is begun, shown and aborted three times, always all of them in the same order.
//!
//! What a level needs to be shown for the first time in a process (its pictures in the launcher, text, pipelines of the driver) stays by intention, so the first
//! time is not assessed. Afterwards the least of what is resident while all levels are gone through counts, since the graphics library has a block of
//! its pool in some launchers and not in others, of 32 MiB. The program's own allocator gives back what is freed ([`ALLOCATOR`]).
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
/// How often all levels are gone through.
const ROUNDS: usize = 3;
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

/// All levels in turn: the first of each module, then the second of each that has one, and so on.
fn in_turn(mut levels: Vec<Level>) -> Vec<Level> {
    levels.sort_by_key(|level| (level.number, level.place));
    levels
}

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
    let once = in_turn(levels());
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
    let rounds: Vec<&[(Level, f64)]> = rests.chunks(count.max(1)).collect();
    let least: Vec<f64> = rounds
        .iter()
        .map(|round| {
            round
                .iter()
                .map(|rest| rest.1)
                .fold(f64::INFINITY, f64::min)
        })
        .collect();
    let growth = (least[ROUNDS - 1] - least[1]) / (count * (ROUNDS - 2)) as f64;
    let is_good = growth <= BOUND;
    let mut text = format!(
        "# What levels leave behind in memory\n\nCommand: `cargo xtask soak window -- memory`. One process, moved from outside by keys, 1280 × 720 pixels at first, with pictures in low quality by a driver of the processor. \
         {count} levels are begun, shown for a second and aborted, {ROUNDS} times in the same order; after every {RESIZED}th the window has another size. glibc's allocator has one heap and gives back what is freed.\n\n\
         - Least resident memory in the launcher the first, second and third time: {:.1}, {:.1} and {:.1} MB. From the second to the third time: **{growth:+.3} MB per level**; it is to be at most {BOUND} MB.\n\
         - Faults: {}.\n\n| level | resident memory in the launcher after it \\[MB\\], the first time | second | third |\n|---|---|---|---|\n",
        least[0],
        least[1],
        least[2],
        match is_good {
            true => "none",
            false => "levels leave memory behind",
        }
    );
    for (k, (level, _)) in rounds[0].iter().enumerate() {
        let _ = write!(text, "| {} {}", level.module, level.number);
        for round in &rounds[..ROUNDS] {
            let _ = write!(text, " | {:.1}", round[k].1);
        }
        text += " |\n";
    }
    (text, is_good)
}
