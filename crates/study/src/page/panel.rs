//! A scene on the page: the answer in a sentence, two drawings, tables.

use super::{key, status_words};
use crate::drawing::{SCATTER_SIZE, ScatterPoint, Zone, document, scatter};
use crate::results::{ERRORS, Panel};
use crate::row::real_time;
use crate::row::{Against, Row, Status};
use microsim_drawing::escape;
use microsim_drawing::{percent, significant};
use std::fmt::Write;

/// The section of a scene.
pub fn section(out: &mut String, panel: &Panel<'_>) {
    // One drawing would be blown up to the width of two.
    let class = match comparisons(panel).len() {
        1 => " class=\"one\"",
        _ => "",
    };
    let _ = write!(
        out,
        "<section id=\"{}\"><h2>{}</h2>\n<p class=\"sentence\">{}</p>\n<figure{class}>{}</figure>\n",
        panel.id(),
        escape(&panel.title()),
        escape(&panel.sentence()),
        panel_svg(panel, false)
    );
    out.push_str("<div class=\"pair\">\n");
    for against in comparisons(panel) {
        answers(out, panel, against);
    }
    out.push_str("</div>\n");
    materials(out, panel);
    all_runs(out, panel);
    if let Some(source) = &panel.variant.source {
        let _ = write!(out, "<p class=\"note\">Reference: {}</p>", escape(source));
    }
    out.push_str("</section>\n");
}

/// Both comparisons, or only that with the same mesh.
fn comparisons(panel: &Panel<'_>) -> Vec<Against> {
    Against::ALL
        .into_iter()
        .filter(|against| *against == Against::SameMesh || panel.has_reference())
        .collect()
}

fn heading(against: Against) -> &'static str {
    match against {
        Against::Reference => "Against the reference",
        Against::SameMesh => "Against the exact solution on the same mesh",
    }
}

/// The drawings of a scene; `alone` for a file of its own, with style and legend.
pub fn panel_svg(panel: &Panel<'_>, alone: bool) -> String {
    let mut body = String::new();
    let comparisons = comparisons(panel);
    let first = panel.rows.first().map(|row| row.key.group.material);
    for (k, against) in comparisons.iter().enumerate() {
        let mut points = Vec::new();
        let mut front = Vec::new();
        let on_front = panel.front(*against);
        for (index, row) in panel.rows.iter().enumerate() {
            let Some((zone, cost)) = zone(row, *against) else {
                continue;
            };
            if let Some(place) = on_front.iter().position(|p| p.index == index) {
                front.push((place, points.len()));
            }
            points.push(ScatterPoint {
                cost,
                error: row.error(*against).unwrap_or(f64::NAN),
                series: row.key.method,
                size: row.key.group.resolution,
                hollow: first != Some(row.key.group.material),
                dissertation: panel.results.is_of_the_dissertation(row),
                tip: tip(panel, row),
                zone,
            });
        }
        front.sort_unstable();
        let front: Vec<usize> = front.into_iter().map(|(_, point)| point).collect();
        scatter(
            &mut body,
            SCATTER_SIZE.0 * k as f64,
            heading(*against),
            &points,
            &front,
        );
    }
    let width = SCATTER_SIZE.0 * comparisons.len() as f64;
    let mut height = SCATTER_SIZE.1;
    if alone {
        height += legend(&mut body, panel, width, height);
    }
    document(width, height, &panel.title(), &body, alone)
}

/// Where a run is drawn, and at which cost; `None` for a run without a cost.
fn zone(row: &Row, against: Against) -> Option<(Zone, f64)> {
    let cost = row.cost()?;
    match row.status {
        Status::Ok => row.error(against).map(|_| (Zone::Inside, cost)),
        Status::Diverged { .. } => Some((Zone::Diverged, cost)),
        Status::OverBudget { .. } => Some((Zone::OverBudget, cost)),
        Status::NotApplicable { .. } => None,
    }
}

fn tip(panel: &Panel<'_>, row: &Row) -> String {
    let mut words = panel.results.describe(row);
    for (against, name) in [
        (Against::Reference, "reference"),
        (Against::SameMesh, "same mesh"),
    ] {
        if let Some(error) = row.error(against) {
            let _ = write!(words, "\nerror against the {name}: {}", percent(error));
        }
    }
    if let Some(cost) = row.cost() {
        let _ = write!(
            words,
            "\n{} CPU s per simulated s, {}",
            significant(cost, 2),
            real_time(cost)
        );
    }
    if row.status != Status::Ok {
        let _ = write!(words, "\n{}", status_words(&row.status));
    }
    words
}

/// What the colour of the dissertation stands for.
pub(super) const OF_THE_DISSERTATION: &str =
    "springs by a method of the dissertation, whatever its form";

/// Methods below the drawings of a file of its own; gives the height that it needs.
fn legend(out: &mut String, panel: &Panel<'_>, width: f64, top: f64) -> f64 {
    let methods = panel.results.chart.method.iter().enumerate();
    let mut present: Vec<(usize, &str, &str)> = methods
        .filter(|(index, _)| panel.rows.iter().any(|row| row.key.method == *index))
        .map(|(index, method)| (index, "", method.title.as_str()))
        .collect();
    let dissertation = |row: &&Row| panel.results.is_of_the_dissertation(row);
    if panel.rows.iter().any(dissertation) {
        present.push((0, "dissertation", OF_THE_DISSERTATION));
    }
    let (mut x, mut y) = (84.0, top + 14.0);
    for (index, class, title) in present {
        // A little more than any letter of this size takes.
        let wide = 30.0 + 7.2 * title.chars().count() as f64;
        if x + wide > width && x > 84.0 {
            (x, y) = (84.0, y + 22.0);
        }
        crate::drawing::marker(out, index, (x, y - 4.0), 5.0, class, "");
        let _ = write!(
            out,
            "<text x=\"{:.1}\" y=\"{y:.1}\">{}</text>",
            x + 12.0,
            escape(title)
        );
        x += wide;
    }
    y + 16.0 - top
}

/// Front and cheapest runs.
fn answers(out: &mut String, panel: &Panel<'_>, against: Against) {
    let results = panel.results;
    let front = panel.front(against);
    let _ = writeln!(
        out,
        "<div class=\"wide\"><h3>{}</h3><table><thead><tr><th></th><th>Run</th><th class=\"n\">Error</th><th class=\"n\">CPU s/s</th></tr></thead><tbody>",
        heading(against)
    );
    for (k, point) in front.iter().enumerate() {
        let row = panel.rows[point.index];
        let class = if point.cost <= 1.0 { "real" } else { "slow" };
        let _ = writeln!(
            out,
            "<tr class=\"{class}\"><td><span class=\"disc\">{}</span></td><td><b>{}{}</b><br><small>{}, mesh {}, {}</small></td><td class=\"n\">{}</td><td class=\"n cost\">{}</td></tr>",
            k + 1,
            key(row.key.method, ""),
            escape(results.method_title(row)),
            escape(results.material_title(row)),
            escape(results.resolution_name(row)),
            escape(&results.parameters(row)),
            percent(point.error),
            significant(point.cost, 2)
        );
    }
    out.push_str("</tbody></table>\n<p class=\"cheapest\">Cheapest for ");
    let answers: Vec<String> = ERRORS
        .iter()
        .map(|&error| {
            let found = front.iter().position(|point| point.error <= error);
            let answer = match found {
                Some(k) => format!("<span class=\"disc\">{}</span>", k + 1),
                None => "none".into(),
            };
            format!(
                "{} %: {answer}",
                significant(100.0 * error, 2).trim_end_matches(".0")
            )
        })
        .collect();
    let _ = writeln!(out, "{}</p></div>", answers.join(" · "));
}

/// What mesh and elements do, whatever the solver.
fn materials(out: &mut String, panel: &Panel<'_>) {
    if !panel.has_reference() {
        return;
    }
    let of_panel = |key: &crate::plan::GroupKey| {
        key.scene == panel.scene_index && key.variant == panel.variant_index
    };
    let groups: Vec<_> = panel
        .results
        .groups
        .iter()
        .filter(|g| of_panel(&g.key))
        .collect();
    let mut materials: Vec<usize> = groups.iter().map(|g| g.key.material).collect();
    let mut meshes: Vec<usize> = groups.iter().map(|g| g.key.resolution).collect();
    let mut seen = Vec::new();
    materials.retain(|m| {
        !seen.contains(m) && {
            seen.push(*m);
            true
        }
    });
    meshes.sort_unstable();
    meshes.dedup();
    out.push_str("<details><summary>Error of the elements alone, with an exact solver</summary><div class=\"wide\"><table><thead><tr><th>Elements</th>");
    for mesh in &meshes {
        let elements = groups
            .iter()
            .find(|g| g.key.resolution == *mesh && g.elements > 0);
        let _ = write!(
            out,
            "<th class=\"n\">{}<br><small>{} tetrahedra</small></th>",
            escape(&panel.scene.resolution[*mesh].name),
            microsim_drawing::count(elements.map_or(0, |g| g.elements))
        );
    }
    out.push_str("</tr></thead><tbody>\n");
    for material in materials {
        let _ = write!(
            out,
            "<tr><td>{}</td>",
            escape(&panel.results.chart.material[material].title)
        );
        for mesh in &meshes {
            let group = groups
                .iter()
                .find(|g| g.key.material == material && g.key.resolution == *mesh);
            let cell = group.and_then(|g| g.exact_error()).map(percent);
            let why = group
                .and_then(|g| g.exact_failure.as_deref())
                .unwrap_or_default();
            let _ = write!(
                out,
                "<td class=\"n\" title=\"{}\">{}</td>",
                escape(why),
                cell.unwrap_or_else(|| "–".into())
            );
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody></table></div></details>\n");
}

fn all_runs(out: &mut String, panel: &Panel<'_>) {
    let _ = write!(
        out,
        "<details><summary>All {} runs</summary><div class=\"wide\"><table class=\"runs\"><thead><tr><th>Method</th><th>Elements</th><th>Mesh</th><th>Parameters</th>",
        panel.rows.len()
    );
    for measure in &panel.scene.measure {
        let _ = write!(
            out,
            "<th class=\"n\">{}<br><small>error reference · mesh</small></th>",
            escape(&measure.title)
        );
    }
    let drift = panel.rows.iter().any(|row| row.energy_drift.is_some());
    if drift {
        out.push_str("<th class=\"n\">Energy drift</th>");
    }
    out.push_str("<th class=\"n\">CPU s/s</th><th class=\"n\">Iterations</th><th>Status</th></tr></thead><tbody>\n");
    for row in &panel.rows {
        let results = panel.results;
        let _ = write!(
            out,
            "<tr class=\"{}\"><td>{}{}</td><td>{}</td><td>{}</td><td>{}</td>",
            if row.status == Status::Ok {
                ""
            } else {
                "failed"
            },
            key(row.key.method, ""),
            escape(results.method_title(row)),
            escape(results.material_title(row)),
            escape(results.resolution_name(row)),
            escape(&results.parameters(row))
        );
        for measure in &row.measures {
            let error = |against| measure.error(against).map_or("–".into(), percent);
            let _ = write!(
                out,
                "<td class=\"n\">{} · {}</td>",
                error(Against::Reference),
                error(Against::SameMesh)
            );
        }
        if drift {
            let text = row
                .energy_drift
                .map_or("–".into(), |d| format!("{} %", significant(100.0 * d, 2)));
            let _ = write!(out, "<td class=\"n\">{text}</td>");
        }
        let text = |value: Option<f64>| value.map_or("–".into(), |v| significant(v, 2));
        let _ = writeln!(
            out,
            "<td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td></tr>",
            text(row.cost()),
            text(row.iterations),
            escape(&status_words(&row.status))
        );
    }
    out.push_str("</tbody></table></div></details>\n");
}
