//! What happened, in pictures and in a list.

use super::text::{say, spans};
use super::{Pictures, section};
use crate::moment::{key_moments, line_kind, lines};
use crate::number::shown;
use crate::{MomentKind, Report};
use std::fmt::Write;

/// Pictures on a page.
const MOST_PICTURES: usize = 12;
/// Lines of the list; the JSON form has all moments.
const MOST_MOMENTS: usize = 80;

/// The class of the style sheet that gives a kind its colour.
pub(crate) fn kind_class(kind: MomentKind) -> &'static str {
    match kind {
        MomentKind::Begin | MomentKind::End => "k-bound",
        MomentKind::Grip => "k-grip",
        MomentKind::Cut | MomentKind::PieceOff => "k-cut",
        MomentKind::Tear => "k-tear",
        MomentKind::ExcessForce | MomentKind::LargestForce => "k-force",
        MomentKind::Event => "k-event",
    }
}

impl Report {
    /// The ticks of the key moments, of which a page shows pictures, ascending.
    pub fn key_ticks(&self) -> Vec<u64> {
        let chosen = key_moments(&self.moments, MOST_PICTURES);
        let mut ticks: Vec<u64> = chosen.into_iter().map(|(_, tick)| tick).collect();
        ticks.sort_unstable();
        ticks.dedup();
        ticks
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
                say(
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
                if lines.is_empty() {
                    continue;
                }
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
    section(out, "Verlauf", "Course");
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
            say("weitere", "more")
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
