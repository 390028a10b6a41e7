//! What levels leave behind in memory: one after the other is begun, shown and aborted, until each module had its turn several times.
//!
//! Nothing else happens meanwhile but that the window has another size now and then: what a quality or a lost device takes is not looked at here.

use crate::account::{resident, slope};
use crate::player::{Player, data_folder};
use crate::{Level, levels};
use microsim_tests::desktop::Display;
use microsim_tests::peers::Peer;
use microsim_tests::scratch;
use std::fmt::Write as _;

/// How often each module has its turn, each time with another level.
const ROUNDS: usize = 6;
/// A level may leave so much behind \[MB\]: a thousand of them, more than a day has, would leave 100 MB.
const BOUND: f64 = 0.1;
/// After one in so many levels the window has another size, and the next time the first one again.
const RESIZED: usize = 4;
const SIZES: [[&str; 2]; 2] = [["1100", "680"], ["1280", "720"]];

/// Resident memory in the launcher \[MB\] of 10⁶ bytes, after each level.
type Rests = Vec<(Level, f64)>;

/// Levels in turn: one of each module, then another one of each.
fn in_turn(levels: &[Level]) -> Vec<Level> {
    let modules = levels.iter().map(|level| level.place + 1).max();
    let of = |(round, place): (usize, usize)| {
        let of_module: Vec<_> = levels.iter().filter(|level| level.place == place).collect();
        let level = of_module.get(round % of_module.len().max(1));
        level.map(|level| (*level).clone())
    };
    (0..ROUNDS)
        .flat_map(|round| (0..modules.unwrap_or_default()).map(move |place| (round, place)))
        .filter_map(of)
        .collect()
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
    for (n, level) in in_turn(&levels()).into_iter().enumerate() {
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
    let points: Vec<_> = rests
        .iter()
        .enumerate()
        .map(|(n, (_, memory))| (n as f64, *memory))
        .collect();
    let (slope, error) = slope(&points).unwrap_or((f64::NAN, f64::NAN));
    let is_good = slope <= BOUND || slope <= 2.0 * error;
    let mut text = format!(
        "# What levels leave behind in memory\n\nCommand: `cargo xtask soak window -- memory`. One process, moved from outside by keys, 1280 × 720 pixels at first, with pictures in low quality by a driver of the processor. \
         {} levels are begun, shown for a second and aborted, one of each module in turn; after every {RESIZED}th the window has another size.\n\n\
         - Slope over the last two thirds: **{slope:+.3} ± {error:.3} MB per level**; it is to be at most {BOUND} MB, or within twice its error.\n\
         - Faults: {}.\n\n| level | resident memory in the launcher after it \\[MB\\] |\n|---|---|\n",
        rests.len(),
        match is_good {
            true => "none",
            false => "levels leave memory behind",
        }
    );
    for (level, memory) in rests {
        let _ = writeln!(text, "| {} {} | {memory:.0} |", level.module, level.number);
    }
    (text, is_good)
}
