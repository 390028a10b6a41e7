//! What levels leave behind in memory: each is begun, shown and aborted once, and then each once more in the same order.
//!
//! Only the second time is assessed: what a level needs to be shown for the first time in a process (its pictures in the launcher, text, pipelines of the driver) stays by intention.
//! Nothing else happens meanwhile but that the window has another size now and then: what a quality or a lost device takes is not looked at here.

use crate::account::{resident, slope};
use crate::player::{Player, data_folder};
use crate::{Level, levels};
use microsim_tests::desktop::Display;
use microsim_tests::peers::Peer;
use microsim_tests::scratch;
use std::fmt::Write as _;

/// A level may leave so much behind \[MB\]: a thousand of them, more than a day has, would leave 100 MB.
const BOUND: f64 = 0.1;
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
        .spawn()
        .map_err(|error| format!("the program: {error}"))?;
    let window = Peer(window);
    let mut player = Player::new(&display, 1, &data);
    player.focus()?;
    player.wait(3.0);
    let mut rests = Rests::new();
    let once = in_turn(levels());
    for (n, level) in once.iter().chain(&once).cloned().enumerate() {
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
    let (first, second) = rests.split_at(rests.len() / 2);
    let points: Vec<_> = second
        .iter()
        .enumerate()
        .map(|(n, (_, memory))| (n as f64, *memory))
        .collect();
    let (slope, error) = slope(&points).unwrap_or((f64::NAN, f64::NAN));
    let is_good = slope <= BOUND || slope <= 2.0 * error;
    let mut text = format!(
        "# What levels leave behind in memory\n\nCommand: `cargo xtask soak window -- memory`. One process, moved from outside by keys, 1280 × 720 pixels at first, with pictures in low quality by a driver of the processor. \
         {} levels are begun, shown for a second and aborted, and then all of them once more in the same order; after every {RESIZED}th the window has another size.\n\n\
         - Slope over the second time: **{slope:+.3} ± {error:.3} MB per level**; it is to be at most {BOUND} MB, or within twice its error.\n\
         - Faults: {}.\n\n| level | resident memory in the launcher after it \\[MB\\], the first time | the second time |\n|---|---|---|\n",
        first.len(),
        match is_good {
            true => "none",
            false => "levels leave memory behind",
        }
    );
    for ((level, once), (_, twice)) in first.iter().zip(second) {
        let _ = writeln!(
            text,
            "| {} {} | {once:.1} | {twice:.1} |",
            level.module, level.number
        );
    }
    (text, is_good)
}
