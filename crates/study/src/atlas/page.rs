//! The atlas as one HTML page: self-contained, without scripts, light and dark. Only results go in; machine and date come from
//! the caller.

use super::heat_map::{HeatMap, STYLE as HEAT_STYLE, key, ratio_key};
use super::tables::REMEDY_COLUMNS;
use super::{Atlas, Limit, Variation, method_name};
use crate::drawing::STYLE as DRAWING_STYLE;
use crate::page::{PageInfo, STYLE as PAGE_STYLE, machine, open};
use microsim_drawing::escape;
use microsim_drawing::{count, percent, significant, time};
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

impl Atlas {
    /// The page. It loads nothing and runs nothing, and forbids the browser to; all text is escaped.
    pub fn to_html(&self, info: &PageInfo) -> String {
        let styles = [DRAWING_STYLE, PAGE_STYLE, HEAT_STYLE, STYLE];
        let mut out = open("stability atlas", "page atlas", &styles);
        self.head(&mut out, info);
        self.recovery_section(&mut out);
        self.limit_section(&mut out);
        self.prediction_section(&mut out);
        self.large_step_section(&mut out);
        self.remedy_section(&mut out);
        let _ = write!(
            out,
            "<section class=\"foot\"><p>Made by <code>{}</code>.</p></section>\n</div>\n</body>\n</html>\n",
            escape(&info.command)
        );
        out
    }

    fn head(&self, out: &mut String, info: &PageInfo) {
        let (compared, agreeing, worst) = self.agreement();
        let recovered = self
            .recoveries
            .iter()
            .filter(|one| one.outcome.is_recovered())
            .count();
        let _ = write!(
            out,
            "<header><p class=\"brand\">MicroSim</p><h1>Stability atlas</h1>\n\
             <p class=\"lead\">Where the methods fail, and what helps: the largest stable step measured against theory, bad elements, large \
             steps, and a beam that must find back from shapes that no load makes.</p>\n\
             <dl class=\"facts\"><div><dt>Limits measured</dt><dd>{}</dd></div><div><dt>Infinitesimal motions within 3 % of theory</dt><dd>{} of {}</dd></div>\
             <div><dt>Largest difference</dt><dd>{}</dd></div><div><dt>Recoveries</dt><dd>{} of {}</dd></div></dl>\n{}<ul>\n",
            count(self.limits.len()),
            count(agreeing),
            count(compared),
            percent(worst),
            count(recovered),
            count(self.recoveries.len()),
            machine(info)
        );
        for sentence in self.findings() {
            let _ = writeln!(out, "<li>{}</li>", escape(&sentence));
        }
        out.push_str("</ul></header>\n");
    }

    fn recovery_section(&self, out: &mut String) {
        if self.recoveries.is_empty() {
            return;
        }
        out.push_str(
            "<section><h2>Recovery of a damaged beam</h2>\n<p class=\"note\">Beam S (0.1 × 0.02 × 0.02 m, 810 tetrahedra, E = 10⁵ Pa, ν = 0.3) under \
             gravity, drag 20 /s. <b>Tip moved</b>: one node of the tip two lengths upwards. <b>Flattened</b>: all free nodes at half height. \
             <b>Mirrored</b>: all free nodes mirrored about half height, so that every element is inside out. <b>Clamp jumps</b>: one length \
             sideways at once. <b>Clamp turns</b>: 90° at once. Recovered: every node within 3 % of the length of its resting place and nothing \
             inverted, for good, within 1.2 simulated seconds. No containment, no position is set back. s is the fraction of the limit of the step, τ the \
             time of Kelvin–Voigt damping; CPU time is that of all 1.2 s, or until it failed. ×1: one iteration of Newton’s method per step.</p>\n",
        );
        let overview = self.recovery_overview();
        if !overview.rows.is_empty() {
            let _ = writeln!(out, "<h3>{}</h3>", escape(&overview.title));
            out.push_str(&key(&[("good", "all"), ("stuck", "some"), ("bad", "none")]));
            figure(out, &overview);
        }
        let all = self.recovery_figure();
        let _ = writeln!(
            out,
            "<details open><summary>{}</summary>",
            escape(&all.title)
        );
        out.push_str(&key(&[
            ("good", "recovered, and when"),
            ("stuck", "at rest elsewhere"),
            ("bad", "blows up, no step, or still moving"),
            ("slow", "more than 12 CPU s"),
            ("none", "method cannot treat the material"),
        ]));
        figure(out, &all);
        out.push_str("</details></section>\n");
    }

    fn limit_section(&self, out: &mut String) {
        if self.limits.is_empty() {
            return;
        }
        out.push_str(
            "<section><h2>Largest stable step</h2>\n<p class=\"note\">A block of 4 × 2 × 2 cells of 1 cm (E = 10⁵ Pa, ν = 0.3, 1000 kg/m³), clamped at one end, \
             changed in one respect per column. Thin layer, sliver: one layer of cells squeezed, or one node moved towards the opposite face, to that fraction. Measured by bisection with the solver from a disturbance of a billionth of a cell; predicted \
             from the exact eigenvalues and the limits of linear theory. ζ is the damping ratio of the fastest mode. In the columns of offsets the block \
             starts from random offsets of up to that fraction of a cell and makes 2000 steps: there the linear limit is no prediction, and the number \
             is the fraction that remains. “never”: unstable at every step, as predicted. Where fibres carry tension alone, an unstretched body has no linear range, \
             however small the disturbance.</p>\n",
        );
        out.push_str(&ratio_key());
        for map in self
            .limit_figures()
            .iter()
            .filter(|map| !map.rows.is_empty())
        {
            let _ = writeln!(out, "<h3>{}</h3>", escape(&map.title));
            figure(out, map);
        }
        self.limit_details(out);
        out.push_str("</section>\n");
    }

    fn limit_details(&self, out: &mut String) {
        out.push_str(
            "<details><summary>All limits in numbers</summary><div class=\"wide\"><table class=\"runs\"><thead><tr><th>Method</th><th>Block of</th>\
             <th>Variation</th><th class=\"n\">Measured</th><th class=\"n\">Exact</th><th class=\"n\">Gershgorin</th><th class=\"n\">Power iteration</th>\
             <th class=\"n\">k_c of 3.21</th></tr></thead><tbody>\n",
        );
        let step = |value: f64| match value {
            v if v > 0.0 && v.is_finite() => time(v),
            0.0 => "0".into(),
            _ => "–".into(),
        };
        for limit in &self.limits {
            let (what, value) = limit.variation.names();
            let Limit {
                exact,
                gershgorin,
                power,
                ..
            } = *limit;
            let _ = writeln!(
                out,
                "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
                limit.method.name(),
                escape(&limit.substance.name()),
                escape(&format!("{what} {value}")),
                limit.measured.step().map_or("never".into(), time),
                if matches!(limit.variation, Variation::Amplitude(_)) {
                    "–".into()
                } else {
                    step(exact)
                },
                step(gershgorin),
                step(power),
                limit.delingette.map_or("–".into(), step)
            );
        }
        out.push_str("</tbody></table></div></details>\n");
    }

    fn prediction_section(&self, out: &mut String) {
        let maps = self.prediction_figures();
        if maps.iter().all(|map| map.rows.is_empty()) {
            return;
        }
        out.push_str(
            "<section><h2>Cheap predictions</h2>\n<p class=\"note\">What a program can afford at every cut, over the measured limit of Störmer–Verlet. Below 1 is \
             safe, above 1 promises a step that blows up. The power iteration comes from below, so it needs its margin of 10 %. k_c of 3.21 looks \
             at single springs: it knows nothing of volumes, drag and viscosity.</p>\n",
        );
        out.push_str(&ratio_key());
        for map in maps.iter().filter(|map| !map.rows.is_empty()) {
            let _ = writeln!(out, "<h3>{}</h3>", escape(&map.title));
            figure(out, map);
        }
        out.push_str("</section>\n");
    }

    fn large_step_section(&self, out: &mut String) {
        if self.large_steps.is_empty() {
            return;
        }
        out.push_str(
            "<section><h2>Methods without a limit, at large steps</h2>\n<p class=\"note\">The same block without any damping. Left: it swings from a small bend for \
             one period; what is missing of the energy was taken by the method. Right: it makes 400 steps from random offsets; above 1 the method \
             has made energy. The explicit limit lies near 80 steps per period.</p>\n",
        );
        out.push_str(&ratio_key());
        out.push_str("<div class=\"pair\">");
        for map in self
            .large_step_figures()
            .iter()
            .filter(|map| !map.rows.is_empty())
        {
            let _ = writeln!(out, "<div><h3>{}</h3>", escape(&map.title));
            figure(out, map);
            out.push_str("</div>");
        }
        out.push_str("</div>\n<details><summary>In numbers</summary><div class=\"wide\"><table class=\"runs\"><thead><tr><th>Method</th><th>Block of</th><th>Start</th>\
             <th class=\"n\">Steps per period</th><th class=\"n\">Step</th><th class=\"n\">Over explicit limit</th><th class=\"n\">Energy</th><th class=\"n\">One mode alone</th></tr></thead><tbody>\n");
        for run in &self.large_steps {
            let _ = writeln!(
                out,
                "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
                escape(&method_name(&run.method)),
                escape(&run.substance.name()),
                run.start.name(),
                run.per_period,
                time(run.step),
                significant(run.over_limit, 2),
                run.energy.map_or("fails".into(), percent),
                run.predicted.map_or("–".into(), percent)
            );
        }
        out.push_str("</tbody></table></div></details></section>\n");
    }

    fn remedy_section(&self, out: &mut String) {
        if self.remedies.is_empty() {
            return;
        }
        out.push_str(
            "<section><h2>Remedies for bad elements</h2>\n<p class=\"note\">The step is 0.6 of the limit of the good block; then one layer is squeezed or one node moved \
             until an element is a sliver. Mass floor: node masses are raised until Gershgorin’s bound allows the step. Stiffness cap: elements are \
             softened instead. Both change the first frequency of the block, which is stated; a shorter step changes nothing but time.</p>\n\
             <div class=\"wide\"><table><thead><tr>",
        );
        for (index, column) in REMEDY_COLUMNS.iter().enumerate() {
            let class = if (3..5).contains(&index) || index == 7 {
                " class=\"n\""
            } else {
                ""
            };
            let _ = write!(out, "<th{class}>{column}</th>");
        }
        out.push_str("</tr></thead><tbody>\n");
        for (row, one) in self.remedy_rows().iter().zip(&self.remedies) {
            let class = if one.survived { "holds" } else { "fails" };
            let _ = write!(out, "<tr class=\"{class}\">");
            for (index, text) in row.iter().enumerate() {
                let class = if (3..5).contains(&index) || index == 7 {
                    " class=\"n\""
                } else {
                    ""
                };
                let _ = write!(out, "<td{class}>{}</td>", escape(text));
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</tbody></table></div></section>\n");
    }
}

fn figure(out: &mut String, map: &HeatMap) {
    // Never larger than drawn, so that letters have one size on the page.
    let width = map.width();
    let _ = writeln!(
        out,
        "<figure class=\"wide\" style=\"max-width: {width:.0}px\">{}</figure>",
        map.to_svg(false)
    );
}
