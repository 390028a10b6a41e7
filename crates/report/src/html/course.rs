//! What happened, in pictures and in a list.

use super::{Pictures, section};
use crate::moment::{key_moments, kind_class, line_kind, lines};
use crate::number::shown;
use crate::text::{bilingual, spans};
use crate::{MomentKind, Report};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Pictures on a page.
const MOST_PICTURES: usize = 12;
/// Where there are fewer, the longest times without one get a picture in between, up to this many …
const FILLED_UP: usize = 8;
/// … and no time shorter than this \[s\].
const LONG: f64 = 1.0;
/// Lines of the list; the JSON form has all moments.
const MOST_MOMENTS: usize = 80;

impl Report {
    /// The ticks of which a page shows pictures, ascending: those of the key moments, and some between where nothing is reported for long.
    pub fn key_ticks(&self) -> Vec<u64> {
        let chosen = key_moments(&self.moments, MOST_PICTURES);
        let mut ticks: BTreeSet<u64> = chosen.into_iter().map(|(_, tick)| tick).collect();
        while ticks.len() < FILLED_UP {
            let next = ticks.iter().skip(1);
            let gaps = ticks.iter().zip(next).map(|(a, b)| (b - a, *a));
            match gaps.max() {
                Some((gap, from)) if gap as f64 * self.session.tick_s >= LONG => {
                    ticks.insert(from + gap / 2);
                }
                _ => break,
            }
        }
        ticks.into_iter().collect()
    }
}

/// The key moments with their pictures.
pub fn pictures(out: &mut String, report: &Report, pictures: &Pictures) {
    if report.moments.is_empty() {
        return;
    }
    section(out, "Bilder der Sitzung", "Pictures of the session");
    match pictures {
        Pictures::Missing(reason) => {
            let _ = writeln!(
                out,
                "<p class=\"note\">{} {}</p>",
                bilingual(
                    "Diese Seite hat keine Bilder:",
                    "This page has no pictures:"
                ),
                spans(reason)
            );
        }
        Pictures::Drawn(drawn) => {
            out.push_str("<div class=\"gallery\">\n");
            let chosen = key_moments(&report.moments, MOST_PICTURES);
            let numbered = lines(&report.moments);
            for (tick, png) in drawn {
                let of_it = |at: &usize| chosen.contains(&(*at, *tick));
                let lines: Vec<String> = numbered
                    .iter()
                    .enumerate()
                    .flat_map(|(k, line)| line.clone().filter(of_it).map(move |at| (k, at)))
                    .map(|(k, at)| {
                        let moment = &report.moments[at];
                        format!("{} {}", number(k, moment.kind), spans(&moment.text))
                    })
                    .collect();
                let _ = writeln!(
                    out,
                    "<figure><img alt=\"\" src=\"data:image/png;base64,{}\"><figcaption><time>{}</time>{}</figcaption></figure>",
                    base64(png),
                    spans(&shown(*tick as f64 * report.session.tick_s, "s")),
                    lines.join("<br>")
                );
            }
            out.push_str("</div>\n");
        }
    }
    out.push_str("</section>\n");
}

/// What happened, with the numbers that mark it in the drawings.
pub fn course(out: &mut String, report: &Report) {
    if report.moments.is_empty() {
        return;
    }
    section(out, "Was wann geschah", "What happened when");
    out.push_str("<ol class=\"moments\">\n");
    let lines = lines(&report.moments);
    for (k, line) in lines.iter().enumerate().take(MOST_MOMENTS) {
        let moments = &report.moments[line.clone()];
        let texts: Vec<String> = moments.iter().map(|moment| spans(&moment.text)).collect();
        let _ = writeln!(
            out,
            "<li>{}<time>{}</time><span>{}</span></li>",
            number(k, line_kind(moments)),
            spans(&shown(moments[0].session_time, "s")),
            texts.join("<br>")
        );
    }
    out.push_str("</ol>\n");
    if let Some(more @ 1..) = lines.len().checked_sub(MOST_MOMENTS) {
        let _ = writeln!(
            out,
            "<p class=\"note\">… {more} {}</p>",
            bilingual("weitere", "more")
        );
    }
    out.push_str("</section>\n");
}

/// The number of a line on the colour of a kind.
fn number(line: usize, kind: MomentKind) -> String {
    format!("<b class=\"disc {}\">{}</b>", kind_class(kind), line + 1)
}

/// Bytes as text (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |k: usize| u32::from(three.get(k).copied().unwrap_or_default());
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            out.push(match k <= three.len() {
                true => char::from(LETTERS[(bits >> (18 - 6 * k) & 63) as usize]),
                false => '=',
            });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::base64;
    use crate::Report;
    use crate::testing::{input, log};
    use microsim_message::{LevelPhase, LevelState};

    /// Begin in tick 0 and end in tick 79 of 1/8 s, nothing between: halved where it is longest, the later one first.
    #[test]
    fn long_times_get_pictures_in_between() {
        let running = LevelState {
            phase: LevelPhase::Running,
            ..LevelState::default()
        };
        let first = log(&[&running]);
        let ticks = |end| Report::build(&input(), [(0, &first[..]), (end, &[][..])]).key_ticks();
        assert_eq!(ticks(79), [0, 19, 29, 39, 49, 59, 69, 79]);
        // Halves of 14 ticks are shorter than a second.
        assert_eq!(ticks(14), [0, 7, 14]);
        assert_eq!(ticks(7), [0, 7]);
    }

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn bytes_as_text() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
