//! The window.

use super::value::{parse_hand, parse_input, parse_level};
use clap::Args;
use microsim_host::assemble::Input;
use microsim_settings::DominantHand;
use std::path::PathBuf;

/// Smallest window that has room for all of a screen.
const LEAST: [f32; 2] = [1000.0, 640.0];

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  microsim window
  microsim window coordination --level 2 --trainee \"A. Muster\" --lang de
  microsim window coordination --level 4 --input script:level4-pass.toml

  microsim window --replay NAME                        # the session that a run has named

Mouse and keyboard move the instruments (config/desktop.toml). A run is recorded as every other, replays to the bit, and enters the store. A replay computes a session again, tick by tick, compares it with what was recorded, and stores nothing.")]
pub struct WindowArgs {
    /// Module to begin with, as `microsim list` shows it; without one the window shows all of them
    pub module: Option<String>,
    /// Level, from 1
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = parse_level)]
    pub level: u32,
    /// Variant of that level, as `microsim list` shows it, which takes its place in this window
    #[arg(long, value_name = "NAME", requires = "module")]
    pub variant: Option<String>,
    /// Who trains: name or id of a trainee in the store
    #[arg(long, value_name = "NAME")]
    pub trainee: Option<String>,
    /// What moves the instruments: desktop (mouse and keyboard), openigtlink://HOST:PORT (a tracker), script:FILE, recording:FILE or plugin:NAME
    #[arg(long, value_name = "SOURCE", default_value = "desktop", value_parser = parse_window_input)]
    pub input: Input,
    /// Dominant hand of who trains, which the window can change: for the left one levels are shown mirrored [default: `dominant` of config/translator.toml]
    #[arg(long, value_name = "HAND", value_parser = parse_hand)]
    pub hand: Option<DominantHand>,
    /// Session to replay: its file, or the name under which a run has recorded it
    #[arg(long, value_name = "SESSION", conflicts_with_all = ["module", "input"])]
    pub replay: Option<PathBuf>,
    /// Language of all texts [default: `report.language` of config/host.toml]
    #[arg(long, value_name = "LANGUAGE", value_parser = ["de", "en"])]
    pub lang: Option<String>,
    /// Width and height of the window
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub size: [f32; 2],
}

impl Default for WindowArgs {
    fn default() -> Self {
        Self {
            module: None,
            level: 1,
            variant: None,
            trainee: None,
            input: Input::Desktop,
            hand: None,
            replay: None,
            lang: None,
            size: [1280.0, 720.0],
        }
    }
}

fn parse_window_input(text: &str) -> Result<Input, String> {
    match text {
        "desktop" => Ok(Input::Desktop),
        text => parse_input(text).map_err(|problem| format!("{problem}, or desktop")),
    }
}

fn parse_size(text: &str) -> Result<[f32; 2], String> {
    let [width, height] = LEAST;
    let expected = format!("expected WIDTHxHEIGHT, at least {width}x{height}, such as 1920x1080");
    let sides = text.split_once('x').and_then(|(width, height)| {
        let [width, height] = [width, height].map(|side| side.parse::<u16>().ok());
        Some([f32::from(width?), f32::from(height?)])
    });
    let fits = |sides: &[f32; 2]| sides[0] >= width && sides[1] >= height;
    sides.filter(fits).ok_or(expected)
}

#[cfg(test)]
mod tests {
    use super::parse_size;

    #[test]
    fn a_window_has_room_for_its_screens() {
        assert_eq!(parse_size("1920x1080"), Ok([1920.0, 1080.0]));
        for bad in [
            "",
            "1920",
            "1920x",
            "x1080",
            "640x480",
            "1920x1080x2",
            "-1x900",
            "99999x900",
        ] {
            assert!(
                parse_size(bad).is_err_and(|e| e.contains("at least 1000x640")),
                "{bad}"
            );
        }
    }
}
