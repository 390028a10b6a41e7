//! Names of people as a terminal can show them.

/// Most characters of a name that are shown.
const MOST: usize = 60;

/// A name on one line that commands no terminal and turns no text around: control characters, line ends, marks of direction and invisible
/// ones are written as numbers, and a long name is cut.
pub fn shown(name: &str) -> String {
    let mut text = String::new();
    for (count, c) in name.chars().enumerate() {
        if count == MOST {
            text.push('…');
            break;
        }
        match is_plain(c) {
            true => text.push(c),
            false => text.extend(c.escape_unicode()),
        }
    }
    text
}

/// The name, or the id of somebody without one.
pub fn name_or_id(name: Option<&str>, id: Option<microsim_store::Id>) -> String {
    match (name, id) {
        (Some(name), _) => shown(name),
        (None, Some(id)) => format!("({})", id.short()),
        (None, None) => "–".to_owned(),
    }
}

fn is_plain(c: char) -> bool {
    let invisible = matches!(c,
        '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}');
    !c.is_control() && !invisible
}

#[cfg(test)]
mod tests {
    use super::shown;

    #[test]
    fn a_name_is_one_harmless_line() {
        assert_eq!(shown("A. Muster"), "A. Muster");
        assert_eq!(shown("Élodie 李 小龍 محمد"), "Élodie 李 小龍 محمد");
        assert_eq!(
            shown("a\nb\u{1b}]0;x\u{7}\0"),
            "a\\u{a}b\\u{1b}]0;x\\u{7}\\u{0}"
        );
        assert_eq!(
            shown("x\u{202e}y\u{2066}z\u{200b}"),
            "x\\u{202e}y\\u{2066}z\\u{200b}"
        );
        assert_eq!(shown("\u{2028}"), "\\u{2028}");
        let long = shown(&"ä".repeat(10_000));
        assert_eq!(long.chars().count(), 61);
        assert!(long.ends_with('…'));
    }
}
