//! The chart as one HTML page: self-contained, without scripts, light and dark, fit for printing. Only results go in; machine
//! and date come from the caller.

mod locking;
mod panel;

pub use panel::panel_svg;

use crate::drawing::{STYLE as DRAWING_STYLE, marker};
use crate::results::{ERRORS, Panel, Results};
use crate::row::Status;
use crate::row::real_time;
use microsim_drawing::{PageHead, count, escape, percent, significant};
use std::fmt::Write;

/// Style of every page.
pub(crate) const STYLE: &str = include_str!("page/style.css");

/// What stands on the page beside the results.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PageInfo {
    /// The machine on which times were measured.
    pub machine: String,
    /// The command that makes the page.
    pub command: String,
    /// A date, if one shall be on it.
    pub date: Option<String>,
    /// What a reader must know of the times, such as runs side by side.
    pub notes: Vec<String>,
    /// Runs of the plan that were left out.
    pub left_out: Vec<String>,
}

impl Results {
    /// The page. It loads nothing and runs nothing, and forbids the browser to; all text is escaped.
    pub fn to_html(&self, info: &PageInfo) -> String {
        let panels = self.panels();
        let mut out = open("speed against accuracy", "page", &[DRAWING_STYLE, STYLE]);
        self.head(&mut out, info, &panels);
        self.summary(&mut out, &panels);
        let locking = self.locking();
        if !locking.is_empty() {
            out.push_str(&locking);
        }
        for panel in &panels {
            panel::section(&mut out, panel);
        }
        self.foot(&mut out, info);
        out.push_str("</div>\n</body>\n</html>\n");
        out
    }

    fn head(&self, out: &mut String, info: &PageInfo, panels: &[Panel<'_>]) {
        let rows = || panels.iter().flat_map(|panel| &panel.rows);
        let of = |name: &str| rows().filter(|row| row.status.name() == name).count();
        let _ = write!(
            out,
            "<header><p class=\"brand\">MicroSim</p><h1>Speed against accuracy</h1>\n\
             <p class=\"lead\">How wrong each method is, and what it costs. A point is a run: further down is more exact, further left is \
             faster. Left of the green line a run is faster than real time; the green field is real time with an error below 3 %.</p>\n\
             <dl class=\"facts\"><div><dt>Runs</dt><dd>{}</dd></div><div><dt>Diverged</dt><dd>{}</dd></div>\
             <div><dt>Over budget</dt><dd>{}</dd></div><div><dt>Not applicable</dt><dd>{}</dd></div></dl>\n\
             {}",
            count(rows().count()),
            of("diverged"),
            of("over budget"),
            of("not applicable"),
            machine(info)
        );
        for note in &info.notes {
            let _ = writeln!(out, "<p class=\"warn\">{}</p>", escape(note));
        }
        if !info.left_out.is_empty() {
            let _ = write!(
                out,
                "<details class=\"warn\"><summary>{} of the plan left out for lack of time</summary><ul>",
                match info.left_out.len() {
                    1 => "1 run".into(),
                    many => format!("{many} runs"),
                }
            );
            for text in &info.left_out {
                let _ = write!(out, "<li>{}</li>", escape(text));
            }
            out.push_str("</ul></details>\n");
        }
        out.push_str("<p class=\"legend\">");
        for (index, method) in self.chart.method.iter().enumerate() {
            if rows().any(|row| row.key.method == index) {
                let _ = write!(
                    out,
                    "<span class=\"key\">{}{}</span>",
                    key(index, ""),
                    escape(&method.title)
                );
            }
        }
        if rows().any(|row| self.is_of_the_dissertation(row)) {
            let _ = write!(
                out,
                "<span class=\"key\">{}{}</span>",
                key(0, "dissertation"),
                panel::OF_THE_DISSERTATION
            );
        }
        out.push_str("</p>\n<p class=\"legend small\">Markers grow with the mesh. Filled: elements that stand first in the scene's table of \
             elements; hollow: others. The dark stairs are the runs that no other run beats, with numbers that the tables explain. \
             Point at a marker for its run.</p>\n</header>\n");
    }

    /// All scenes in one table.
    fn summary(&self, out: &mut String, panels: &[Panel<'_>]) {
        out.push_str("<section><h2>Cheapest run for an error of 10, 3 and 1 %</h2>\n<div class=\"wide\"><table class=\"summary\"><thead><tr><th>Scene</th>");
        for error in ERRORS {
            let _ = write!(
                out,
                "<th>{}</th>",
                percent(error)
                    .replace("1.0 %", "1 %")
                    .replace("3.0 %", "3 %")
            );
        }
        out.push_str("<th class=\"n\">Smallest error</th></tr></thead><tbody>\n");
        for panel in panels {
            let against = panel.main_comparison();
            let _ = write!(
                out,
                "<tr><td><a href=\"#{}\">{}</a>{}</td>",
                panel.id(),
                escape(&panel.title()),
                if panel.has_reference() {
                    ""
                } else {
                    "<br><small>against the same mesh</small>"
                }
            );
            for error in ERRORS {
                match panel.cheapest(against, error) {
                    Some(row) => {
                        let cost = row.cost().unwrap_or(f64::NAN);
                        let class = if cost <= 1.0 { "real" } else { "slow" };
                        let _ = write!(
                            out,
                            "<td class=\"{class}\"><b>{}{}</b><br><small>{}, mesh {}, {}</small><br><span>{} s/s · {}</span></td>",
                            key(row.key.method, ""),
                            escape(self.method_title(row)),
                            escape(self.material_title(row)),
                            escape(self.resolution_name(row)),
                            escape(&self.parameters(row)),
                            significant(cost, 2),
                            real_time(cost)
                        );
                    }
                    None => out.push_str("<td class=\"none\">none</td>"),
                }
            }
            match panel.front(against).last() {
                Some(point) => {
                    let _ = writeln!(out, "<td class=\"n\">{}</td></tr>", percent(point.error));
                }
                None => out.push_str("<td class=\"none\">–</td></tr>\n"),
            }
        }
        out.push_str(
            "</tbody></table></div>\n<p class=\"note\">s/s: CPU seconds per simulated second, all threads, loading excluded. Green: real time. \
             Errors are the largest of all measures of the scene, against a closed form or an external reference where there is one. Only runs \
             that were made are named; nothing is interpolated.</p></section>\n",
        );
    }

    fn foot(&self, out: &mut String, info: &PageInfo) {
        out.push_str("<section class=\"foot\"><h2>How to read this</h2>\n<p><b>Against the reference</b> compares with the closed form, or with a converged \
             solution by another code: this error is what a user of the tissue gets, mesh and all. <b>Against the same mesh</b> compares with the exact \
             solution on the same mesh with the same material, made by this program: this error is what the solver alone adds. For scenes that end at rest \
             it is the equilibrium (Newton's method to a residual of 10⁻⁹), for scenes that move it is the motion at a quarter of the largest stable step.</p>\n\
             <p>A first peak is the largest value before the curve has fallen for a stated time. Energy drift is the energy gained over the run as a fraction of \
             the largest kinetic energy. A run that diverged is drawn above the scale where its time was measured, and stays in the table.</p>\n");
        let _ = writeln!(
            out,
            "<p>Made by <code>{}</code>.</p></section>",
            escape(&info.command)
        );
    }
}

/// A page of this program from its beginning; `class` is that of all that stands on it.
pub(crate) fn open(title: &str, class: &str, styles: &[&str]) -> String {
    let head = PageHead {
        title: &format!("MicroSim · {title}"),
        language: Some("en"),
        pictures: false,
        dark: true,
        styles,
    };
    head.to_html() + &format!("<div class=\"{class}\">\n")
}

/// The machine and the date.
pub(crate) fn machine(info: &PageInfo) -> String {
    let date = match &info.date {
        Some(date) => format!(" · {}", escape(date)),
        None => String::new(),
    };
    format!("<p class=\"machine\">{}{date}</p>\n", escape(&info.machine))
}

/// A marker for a legend.
fn key(index: usize, class: &str) -> String {
    let mut path = String::new();
    marker(&mut path, index, (9.0, 9.0), 5.0, class, "");
    format!("<svg class=\"marker\" viewBox=\"0 0 18 18\" aria-hidden=\"true\">{path}</svg>")
}

/// A status in words.
fn status_words(status: &Status) -> String {
    match status {
        Status::Ok => "ok".into(),
        Status::Diverged { time, reason } => {
            format!("diverged at {} ({reason})", microsim_drawing::time(*time))
        }
        Status::OverBudget { time } => {
            format!("over budget, cut off at {}", microsim_drawing::time(*time))
        }
        Status::NotApplicable { reason } => format!("not applicable: {reason}"),
    }
}

#[cfg(test)]
mod tests;
