//! Text on the page: escaped, and in both languages.

use microsim_drawing::escape;
use microsim_message::LocalText;

/// A text of the page itself.
pub fn in_both(de: &str, en: &str) -> LocalText {
    LocalText::new(de.to_owned(), en.to_owned())
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
pub fn bilingual(de: &str, en: &str) -> String {
    spans(&in_both(de, en))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_is_text() {
        assert_eq!(bilingual("a", "a"), "a");
        assert_eq!(
            bilingual("<de>", "<en>"),
            "<span lang=\"de\">&lt;de&gt;</span><span lang=\"en\">&lt;en&gt;</span>"
        );
    }
}
