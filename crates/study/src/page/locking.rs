//! Nearly incompressible tissue: the error of each discretisation over Poisson's ratio, as small multiples.

use super::key;
use crate::drawing::{LOCKING_SIZE, LockingCurve, document, locking_plot};
use crate::results::Results;
use crate::row::Against;
use microsim_drawing::escape;
use microsim_drawing::percent;
use std::fmt::Write;

/// The error up to which a discretisation counts as free of locking.
const LOCKED: f64 = 0.05;

/// Scene and mesh with their curves.
struct Multiple {
    title: String,
    mesh: String,
    /// Whether there is no finer mesh of the scene.
    finest: bool,
    curves: Vec<LockingCurve>,
}

impl Results {
    /// The section on locking; empty if no scene has two of Poisson's ratios.
    pub(super) fn locking(&self) -> String {
        let multiples = self.multiples();
        if multiples.is_empty() {
            return String::new();
        }
        let errors: Vec<f64> = multiples
            .iter()
            .flat_map(|m| &m.curves)
            .flat_map(|c| c.points.iter().map(|p| p.1))
            .collect();
        let mut out = String::from(
            "<section id=\"locking\"><h2>Nearly incompressible tissue: which elements lock</h2>\n<p class=\"sentence\">",
        );
        out.push_str(&escape(&self.locking_sentence(&multiples)));
        out.push_str("</p>\n<p class=\"legend\">");
        let mut used: Vec<usize> = multiples
            .iter()
            .flat_map(|m| &m.curves)
            .map(|c| c.series)
            .collect();
        used.sort_unstable();
        used.dedup();
        for series in used {
            let title = &self.chart.material[series].title;
            let _ = write!(
                out,
                "<span class=\"key\">{}{}</span>",
                key(series, ""),
                escape(title)
            );
        }
        out.push_str("</p>\n<div class=\"multiples\">\n");
        for multiple in &multiples {
            let mut body = String::new();
            let heading = [multiple.title.as_str(), multiple.mesh.as_str()];
            locking_plot(&mut body, heading, &multiple.curves, &errors);
            let (width, height) = LOCKING_SIZE;
            let svg = document(width, height, &heading.join(", "), &body, false);
            let _ = writeln!(out, "<figure>{svg}</figure>");
        }
        out.push_str("</div>\n<p class=\"note\">Error of the exact solution on the mesh against the closed form or reference: what the elements do, \
             whatever the solver. All drawings share one scale.</p>\n");
        self.methods_over_ratio(&mut out);
        out.push_str("</section>\n");
        out
    }

    /// One drawing per scene with ratios and per mesh on which at least two of them were solved.
    fn multiples(&self) -> Vec<Multiple> {
        let mut multiples = Vec::new();
        for (scene_index, scene) in self.chart.scene.iter().enumerate() {
            for (resolution, mesh) in scene.resolution.iter().enumerate() {
                let mut curves: Vec<LockingCurve> = Vec::new();
                for (material, of) in self.chart.material.iter().enumerate() {
                    let groups = self.groups.iter().filter(|g| {
                        g.key.scene == scene_index
                            && g.key.resolution == resolution
                            && g.key.material == material
                    });
                    let mut points: Vec<(f64, f64)> = groups
                        .filter_map(|g| {
                            let ratio = scene.variant[g.key.variant].poisson_ratio?;
                            Some((ratio, g.exact_error()?))
                        })
                        .collect();
                    points.sort_by(|a, b| a.0.total_cmp(&b.0));
                    if points.len() > 1 {
                        curves.push(LockingCurve {
                            series: material,
                            points,
                            tip: of.title.clone(),
                        });
                    }
                }
                if !curves.is_empty() {
                    for coarser in multiples
                        .iter_mut()
                        .filter(|m: &&mut Multiple| m.title == scene.title)
                    {
                        coarser.finest = false;
                    }
                    multiples.push(Multiple {
                        title: scene.title.clone(),
                        mesh: format!("mesh {}", mesh.name),
                        finest: true,
                        curves,
                    });
                }
            }
        }
        multiples
    }

    /// Which discretisations stay within the limit everywhere, and how far off the worst is.
    fn locking_sentence(&self, multiples: &[Multiple]) -> String {
        let mut materials: Vec<(usize, f64)> = Vec::new();
        let finest = multiples.iter().filter(|m| m.finest);
        for curve in finest.flat_map(|m| &m.curves) {
            // At the largest ratio.
            let Some((_, error)) = curve.points.last() else {
                continue;
            };
            match materials
                .iter_mut()
                .find(|(series, _)| *series == curve.series)
            {
                Some((_, worst)) => *worst = worst.max(*error),
                None => materials.push((curve.series, *error)),
            }
        }
        materials.sort_by(|a, b| a.1.total_cmp(&b.1));
        let title = |series: usize| self.chart.material[series].title.as_str();
        let free: Vec<&str> = materials
            .iter()
            .filter(|(_, worst)| *worst <= LOCKED)
            .map(|(series, _)| title(*series))
            .collect();
        let mut words = match (&free[..], materials.first()) {
            ([], Some((best, worst))) => format!(
                "At the largest ratio, on the finest mesh of each scene, no discretisation stays within {}; the best, {}, is off by up to {}.",
                percent(LOCKED),
                title(*best),
                percent(*worst)
            ),
            (free, _) => format!(
                "At the largest ratio, on the finest mesh of each scene, {} within {}.",
                match free {
                    [one] => format!("only {one} stays"),
                    more => format!("{} stay", more.join(", ")),
                },
                percent(LOCKED)
            ),
        };
        if let Some((worst, error)) = materials.last() {
            let _ = write!(
                words,
                " The worst is {}, off by up to {}.",
                title(*worst),
                percent(*error)
            );
        }
        words
    }

    /// The smallest error of each method and discretisation at each ratio, on the finest mesh that it ran on.
    fn methods_over_ratio(&self, out: &mut String) {
        let mut columns: Vec<(usize, usize)> = Vec::new();
        for (scene, of) in self.chart.scene.iter().enumerate() {
            let ratios = of
                .variant
                .iter()
                .filter(|v| v.poisson_ratio.is_some())
                .count();
            for (variant, v) in of.variant.iter().enumerate() {
                let run = self
                    .groups
                    .iter()
                    .any(|g| g.key.scene == scene && g.key.variant == variant);
                if ratios > 1 && v.poisson_ratio.is_some() && run {
                    columns.push((scene, variant));
                }
            }
        }
        let rows = || self.groups.iter().flat_map(|g| &g.rows);
        let mut kinds: Vec<(usize, usize)> = Vec::new();
        for row in rows() {
            let kind = (row.key.method, row.key.group.material);
            let column = (row.key.group.scene, row.key.group.variant);
            if columns.contains(&column) && !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        kinds.sort_unstable();
        out.push_str("<details><summary>Smallest error of each method at each ratio</summary><div class=\"wide\"><table><thead><tr><th>Method</th><th>Elements</th>");
        for (scene, variant) in &columns {
            let scene = &self.chart.scene[*scene];
            let _ = write!(
                out,
                "<th class=\"n\">{}<br><small>{}</small></th>",
                escape(&scene.title),
                escape(&scene.variant[*variant].name)
            );
        }
        out.push_str("</tr></thead><tbody>\n");
        for (method, material) in kinds {
            let _ = write!(
                out,
                "<tr><td>{}{}</td><td>{}</td>",
                key(method, ""),
                escape(&self.chart.method[method].title),
                escape(&self.chart.material[material].title)
            );
            for (scene, variant) in &columns {
                let of_cell = rows().filter(|row| {
                    let group = &row.key.group;
                    (row.key.method, group.material) == (method, material)
                        && (group.scene, group.variant) == (*scene, *variant)
                });
                let mut best: Option<(usize, f64)> = None;
                for row in of_cell {
                    let Some(error) = row.error(Against::Reference) else {
                        continue;
                    };
                    let mesh = row.key.group.resolution;
                    if best.is_none_or(|(m, e)| mesh > m || mesh == m && error < e) {
                        best = Some((mesh, error));
                    }
                }
                let cell = best.map_or("–".into(), |(mesh, error)| {
                    format!(
                        "{} <small>{}</small>",
                        percent(error),
                        escape(&self.chart.scene[*scene].resolution[mesh].name)
                    )
                });
                let _ = write!(out, "<td class=\"n\">{cell}</td>");
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</tbody></table></div></details>\n");
    }
}
