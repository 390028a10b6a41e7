//! The report as one HTML page for people: self-contained, without scripts, in German and English (the reader switches,
//! by the style sheet alone), fit for printing.

mod course;
mod head;
mod metrics;
mod record;

use crate::Report;
use crate::force::ForceSeries;
use crate::plot::{colour_class, force_plot, path_plots, speed_plot};
use crate::text::{bilingual, spans};
use microsim_drawing::PageHead;
use microsim_vocabulary::{Language, LocalText};
use std::collections::BTreeMap;
use std::fmt::Write;

const STYLE: &str = include_str!("style.css");

/// The pictures of the key moments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pictures {
    /// There are none, and why.
    Missing(LocalText),
    /// PNG files by the ticks that they show.
    Drawn(BTreeMap<u64, Vec<u8>>),
}

/// What a page needs besides the report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    /// The language in which it opens; the reader may switch.
    pub language: Language,
    /// The pictures in it.
    pub pictures: Pictures,
}

impl Report {
    /// The page. It loads nothing and runs nothing, and forbids the browser to; all text of the session is escaped.
    pub fn to_html(&self, page: &Page) -> String {
        let (titles, german, english) = match page.language {
            Language::German => (
                [&self.session.module_title.de, &self.session.level_title.de],
                " checked",
                "",
            ),
            Language::English => (
                [&self.session.module_title.en, &self.session.level_title.en],
                "",
                " checked",
            ),
        };
        let head = PageHead {
            title: &format!("MicroSim · {} · {}", titles[0], titles[1]),
            pictures: true,
            styles: &[STYLE],
            ..PageHead::default()
        };
        let mut out = head.to_html();
        let _ = write!(
            out,
            "<input type=\"radio\" name=\"language\" id=\"language-en\" aria-label=\"English\"{english}>\
             <input type=\"radio\" name=\"language\" id=\"language-de\" aria-label=\"Deutsch\"{german}>\n\
             <div class=\"page\">\n"
        );
        head::head(&mut out, self);
        course::pictures(&mut out, self, &page.pictures);
        metrics::with_limit(&mut out, self);
        course::course(&mut out, self);
        plots(&mut out, self);
        metrics::further(&mut out, self);
        metrics::sources(&mut out, self);
        record::input(&mut out, self);
        record::incidents(&mut out, self);
        record::provenance(&mut out, self);
        out.push_str("</div>\n</body>\n</html>\n");
        out
    }
}

/// Opens a section with its heading; the caller closes it.
fn section(out: &mut String, de: &str, en: &str) {
    let _ = write!(out, "<section>\n<h2>{}</h2>\n", bilingual(de, en));
}

fn plots(out: &mut String, report: &Report) {
    if let Some([above, side]) = path_plots(&report.series) {
        section(out, "Geschwindigkeit", "Speed");
        let mean = bilingual("Mittel über eine halbe Sekunde", "mean over half a second");
        let raw = bilingual("von Messwert zu Messwert", "sample to sample");
        let gap = bilingual(
            "Lücke: nicht gemessen, nichts verbunden",
            "gap: nothing measured, nothing connected",
        );
        let _ = write!(
            out,
            "<p class=\"legend\"><span class=\"key line-key\"></span>{mean}\
             <span class=\"key line-key pale-key\"></span>{raw}<span class=\"key gap-key\"></span>{gap}"
        );
        marks_key(out, report);
        let _ = write!(
            out,
            "</p>\n<figure>{}</figure>\n</section>\n",
            speed_plot(report)
        );
        section(out, "Wege im Feld", "Paths in the field");
        out.push_str("<p class=\"legend\">");
        for (k, series) in report.series.iter().enumerate() {
            let _ = write!(
                out,
                "<span class=\"key line-key {}\"></span>{}",
                colour_class(k),
                spans(&report.session.tool_name(&series.tool))
            );
        }
        let _ = write!(
            out,
            "<span class=\"key start-key\"></span>{}<span class=\"key end-key\"></span>{}</p>\n\
             <div class=\"pair\">\n<figure>{above}<figcaption>{}</figcaption></figure>\n\
             <figure>{side}<figcaption>{}</figcaption></figure>\n</div>\n</section>\n",
            bilingual("Beginn", "start"),
            bilingual("Ende", "end"),
            bilingual(
                "Von oben, wie durch das Mikroskop",
                "From above, as through the microscope"
            ),
            bilingual(
                "Von der Seite; oben ist zum Mikroskop hin",
                "From the side; up is towards the microscope"
            ),
        );
    }
    if !report.forces.is_empty() {
        section(out, "Kontaktkraft", "Contact force");
        let mean = || {
            bilingual(
                "Mittel je Takt (Zeitschritt)",
                "mean over a tick (time step)",
            )
        };
        let [bold, pale] = match report.forces.iter().any(ForceSeries::has_sustained) {
            true => [
                bilingual(
                    "Mittel über 50 ms, nach dem bewertet wird",
                    "mean over 50 ms, by which the level is judged",
                ),
                mean(),
            ],
            false => [
                mean(),
                bilingual("größter Wert im Takt", "largest within a tick"),
            ],
        };
        let _ = write!(
            out,
            "<p class=\"legend\"><span class=\"key line-key\"></span>{}\
             <span class=\"key line-key pale-key\"></span>{}<span class=\"key grip-key\"></span>{}",
            bold,
            pale,
            bilingual(
                "Griff: Kraft, mit der beide Backen gegeneinander drücken",
                "grip: force with which both jaws press against each other"
            ),
        );
        marks_key(out, report);
        let _ = write!(
            out,
            "</p>\n<figure>{}</figure>\n</section>\n",
            force_plot(report)
        );
    }
}

/// What the lines across a drawing are.
fn marks_key(out: &mut String, report: &Report) {
    if !report.moments.is_empty() {
        let numbers = bilingual(
            "Nummer wie unter „Was wann geschah“",
            "number as under “What happened when”",
        );
        let _ = write!(out, "<span class=\"key moment-key\"></span>{numbers}");
    }
}

#[cfg(test)]
mod tests;
