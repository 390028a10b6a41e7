//! What every page begins with, and text on it.

/// Text as it may stand in an element or a quoted attribute of HTML and SVG.
///
/// ```
/// assert_eq!(microsim_drawing::escape("a < b & c"), "a &lt; b &amp; c");
/// ```
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// The head of a page that is one file: it loads nothing and runs nothing, and forbids the browser to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PageHead<'a> {
    /// Title of the page; escaped here.
    pub title: &'a str,
    /// Language of the whole page (`en`); `None` where its elements state their own.
    pub language: Option<&'a str>,
    /// Whether it holds pictures, as data in the page itself.
    pub pictures: bool,
    /// Whether its style has colours for a dark screen.
    pub dark: bool,
    /// Its style sheets, one after the other.
    pub styles: &'a [&'a str],
}

impl PageHead<'_> {
    /// From the document type up to the opening of the body.
    pub fn to_html(&self) -> String {
        let language = match self.language {
            Some(language) => format!(" lang=\"{}\"", escape(language)),
            None => String::new(),
        };
        let scheme = match self.dark {
            true => "<meta name=\"color-scheme\" content=\"light dark\">\n",
            false => "",
        };
        let pictures = match self.pictures {
            true => " img-src data:;",
            false => "",
        };
        format!(
            "<!DOCTYPE html>\n<html{language}>\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n{scheme}\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';{pictures} style-src 'unsafe-inline'\">\n\
             <title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n",
            escape(self.title),
            self.styles.concat()
        )
    }
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
    }

    #[test]
    fn a_page_forbids_what_it_does_not_need() {
        let head = PageHead {
            title: "<b>",
            ..PageHead::default()
        };
        let plain = head.to_html();
        assert!(plain.contains("<title>&lt;b&gt;</title>") && plain.contains("default-src 'none'"));
        assert!(!plain.contains("img-src") && !plain.contains("color-scheme"));
        let pictures = PageHead {
            pictures: true,
            ..head
        };
        assert!(
            pictures
                .to_html()
                .contains("default-src 'none'; img-src data:; style-src")
        );
    }
}
