//! The report as one HTML page for people: self-contained, without scripts, in German and English (the reader switches,
//! by the style sheet alone), fit for printing.

mod head;
mod metrics;
mod record;
mod text;

pub use text::{escape, in_both};

use crate::Report;
use crate::plot::{colour_class, force_plot, path_plots, speed_plot};
use std::fmt::Write;
use text::say;

const STYLE: &str = include_str!("style.css");

impl Report {
    /// The page. It loads nothing and runs nothing, and forbids the browser to; all text of the session is escaped.
    pub fn to_html(&self) -> String {
        let mut out = String::from(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n",
        );
        let _ = write!(
            out,
            "<title>MicroSim · {} · {}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
             <input type=\"radio\" name=\"language\" id=\"language-en\" aria-label=\"English\" checked>\
             <input type=\"radio\" name=\"language\" id=\"language-de\" aria-label=\"Deutsch\">\n\
             <div class=\"page\">\n",
            escape(&self.session.module_title.en),
            escape(&self.session.level_title.en)
        );
        head::head(&mut out, self);
        metrics::metrics(&mut out, self);
        plots(&mut out, self);
        record::events(&mut out, self);
        record::input(&mut out, self);
        record::incidents(&mut out, self);
        record::provenance(&mut out, self);
        out.push_str("</div>\n</body>\n</html>\n");
        out
    }
}

/// Opens a section with its heading; the caller closes it.
fn section(out: &mut String, de: &str, en: &str) {
    let _ = write!(out, "<section>\n<h2>{}</h2>\n", say(de, en));
}

fn plots(out: &mut String, report: &Report) {
    if let Some([above, side]) = path_plots(&report.series) {
        section(out, "Geschwindigkeit", "Speed");
        let mean = say("Mittel über eine halbe Sekunde", "mean over half a second");
        let raw = say("von Messwert zu Messwert", "sample to sample");
        let gap = say(
            "Lücke: nicht gemessen, nichts verbunden",
            "gap: nothing measured, nothing joined",
        );
        let event = say(
            "Ereignis, Nummer wie unter „Verlauf“",
            "event, number as under “Course”",
        );
        let _ = write!(
            out,
            "<p class=\"legend\"><span class=\"key line-key\"></span>{mean}\
             <span class=\"key line-key pale-key\"></span>{raw}<span class=\"key gap-key\"></span>{gap}"
        );
        if !report.events.is_empty() {
            let _ = write!(out, "<span class=\"key event-key\"></span>{event}");
        }
        let _ = write!(
            out,
            "</p>\n<figure>{}</figure>\n</section>\n",
            speed_plot(&report.series, &report.events, report.simulated)
        );
        section(out, "Wege im Feld", "Paths in the field");
        out.push_str("<p class=\"legend\">");
        for (k, series) in report.series.iter().enumerate() {
            let _ = write!(
                out,
                "<span class=\"key line-key {}\"></span>{}",
                colour_class(k),
                escape(&series.tool)
            );
        }
        let _ = write!(
            out,
            "<span class=\"key start-key\"></span>{}<span class=\"key end-key\"></span>{}</p>\n\
             <div class=\"pair\">\n<figure>{above}<figcaption>{}</figcaption></figure>\n\
             <figure>{side}<figcaption>{}</figcaption></figure>\n</div>\n</section>\n",
            say("Beginn", "start"),
            say("Ende", "end"),
            say(
                "Von oben, wie durch das Mikroskop",
                "From above, as through the microscope"
            ),
            say(
                "Von der Seite, z zum Betrachter hin",
                "From the side, z towards the viewer"
            ),
        );
    }
    if !report.forces.is_empty() {
        section(out, "Kontaktkraft", "Contact force");
        let colour_of = |tool: &str| {
            let place = report.series.iter().position(|s| s.tool == tool);
            place.unwrap_or(report.series.len())
        };
        let _ = write!(
            out,
            "<p class=\"legend\"><span class=\"key line-key\"></span>{}\
             <span class=\"key line-key pale-key\"></span>{}</p>\n<figure>{}</figure>\n</section>\n",
            say("Mittel je Takt", "mean of a tick"),
            say("größter Wert im Takt", "largest within a tick"),
            force_plot(&report.forces, report.simulated, colour_of)
        );
    }
}

#[cfg(test)]
mod tests;
