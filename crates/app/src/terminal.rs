//! What standard error is: a terminal whose line can be written over, with colours or without, or something else.

use std::ffi::OsString;
use std::io::IsTerminal;

/// Whether a line can be written over there.
pub fn overwrites() -> bool {
    can_overwrite(std::io::stderr().is_terminal(), std::env::var_os("TERM"))
}

/// Whether colours may be written there.
pub fn has_colours() -> bool {
    overwrites() && are_wanted(std::env::var_os("NO_COLOR"))
}

fn can_overwrite(is_terminal: bool, term: Option<OsString>) -> bool {
    is_terminal && term.is_none_or(|name| name != "dumb")
}

/// By <https://no-color.org>: any value but an empty one turns colours off.
fn are_wanted(no_color: Option<OsString>) -> bool {
    no_color.is_none_or(|value| value.is_empty())
}

#[cfg(test)]
mod tests {
    use super::{are_wanted, can_overwrite};

    /// As <https://no-color.org> has it, and as terminals name themselves.
    #[test]
    fn colours_and_lines_are_as_the_terminal_has_them() {
        assert!(are_wanted(None) && are_wanted(Some("".into())));
        assert!(!are_wanted(Some("1".into())) && !are_wanted(Some("0".into())));
        assert!(can_overwrite(true, Some("xterm".into())) && can_overwrite(true, None));
        assert!(!can_overwrite(true, Some("dumb".into())));
        assert!(!can_overwrite(false, Some("xterm".into())));
    }
}
