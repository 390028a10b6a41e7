//! Text on the page: escaped, and in both languages.

use microsim_message::LocalText;

/// Text as it may stand in an element or a quoted attribute.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(c),
        }
    }
    out
}

/// A text of the page itself.
pub fn in_both(de: &str, en: &str) -> LocalText {
    LocalText {
        de: de.into(),
        en: en.into(),
    }
}

/// A text as elements, of which the page shows the chosen language; escaped.
pub fn spans(text: &LocalText) -> String {
    if text.de == text.en {
        return escape(&text.en);
    }
    format!(
        "<span lang=\"de\">{}</span><span lang=\"en\">{}</span>",
        escape(&text.de),
        escape(&text.en)
    )
}

/// A text of the page itself as elements.
pub fn say(de: &str, en: &str) -> String {
    spans(&in_both(de, en))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_is_text() {
        assert_eq!(
            escape("<a href=\"x\" id='y'>&"),
            "&lt;a href=&quot;x&quot; id=&#39;y&#39;&gt;&amp;"
        );
        assert_eq!(say("a", "a"), "a");
        assert_eq!(
            say("<de>", "<en>"),
            "<span lang=\"de\">&lt;de&gt;</span><span lang=\"en\">&lt;en&gt;</span>"
        );
    }
}
