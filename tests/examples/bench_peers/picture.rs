//! The picture: CPU time against error of the first peak on each mesh, and CPU time to rest against size.
//!
//! An engine is recognised by colour (Okabe and Ito's, which stay apart for colour-blind eyes), form of its markers and a label at
//! each of its lines. A line joins the steps of one method with one set of settings; it is faint where none of them is right.

use crate::beam::{MESHES, TETRAHEDRA};
use crate::labels::LETTER;
use crate::plot::{Frame, LOOKS, Line, decades, grouped};
use crate::row::Row;

const WIDTH: f64 = 1160.0;
const HEIGHT: f64 = 1010.0;
/// Errors below are drawn here.
const LEAST_ERROR: f64 = 1e-4;
const MOST_ERROR: f64 = 1.0;

/// The whole picture.
pub fn svg(rows: &[Row]) -> String {
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"{LETTER}\" fill=\"#222\">
<title>The reference beam: CPU time against error, engine by engine</title>
<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>
<text x=\"70\" y=\"32\" font-size=\"19\" font-weight=\"bold\">The reference beam in other engines and in ours</text>
<text x=\"70\" y=\"52\">One thread. Lower left is better. Errors against the exact solution of the same mesh and law. A line joins the steps of one method; faint ones miss 3 % (peers.md names them).</text>
"
    );
    for (i, mesh) in MESHES.iter().enumerate() {
        let lines = peak_lines(rows, mesh);
        let frame = Frame {
            corner: [70.0 + 560.0 * (i % 2) as f64, 90.0 + 470.0 * (i / 2) as f64],
            title: format!(
                "{mesh}: {} tetrahedra, first peak after release",
                grouped(TETRAHEDRA[i] as f64)
            ),
            axes: [
                "CPU seconds per simulated second",
                "error of height or time, the larger one",
            ],
            x: decades(&lines, 0),
            y: [LEAST_ERROR, MOST_ERROR],
            peaks: true,
        };
        frame.draw(&mut out, &lines);
    }
    let lines = rest_lines(rows);
    let frame = Frame {
        corner: [630.0, 560.0],
        title: "Released, to rest within 1 %: the cheapest run of each engine".into(),
        axes: ["tetrahedra", "CPU seconds in all"],
        x: [300.0, 200_000.0],
        y: decades(&lines, 1),
        peaks: false,
    };
    frame.draw(&mut out, &lines);
    out + "</svg>\n"
}

fn peak_lines<'a>(rows: &'a [Row], mesh: &str) -> Vec<Line<'a>> {
    let mut lines: Vec<Line<'a>> = Vec::new();
    for row in rows.iter().filter(|row| row.mesh == mesh) {
        let (Some(cost), Some(error)) = (row.cpu_s_per_s, row.peak()) else {
            continue;
        };
        let key = [&row.engine, &row.method, &row.settings].map(String::as_str);
        let point = [cost, error];
        match lines.iter_mut().find(|line| line.key == key) {
            Some(line) => line.points.push(point),
            None => lines.push(Line {
                key,
                points: vec![point],
            }),
        }
    }
    for line in &mut lines {
        line.points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
    lines
}

fn rest_lines(rows: &[Row]) -> Vec<Line<'static>> {
    let cheapest = |engine: &str, mesh: &str| {
        let of = rows
            .iter()
            .filter(|row| row.engine == engine && row.mesh == mesh);
        of.filter_map(|row| row.cpu_s_to_rest)
            .min_by(f64::total_cmp)
    };
    let line = |engine: &'static str| Line {
        key: [engine, "", ""],
        points: MESHES
            .iter()
            .zip(TETRAHEDRA)
            .filter_map(|(mesh, count)| Some([count as f64, cheapest(engine, mesh)?]))
            .collect(),
    };
    let lines = LOOKS.iter().map(|look| line(look.0));
    lines.filter(|line| !line.points.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors of 1e-4 and 1 lie on the lower and the upper edge of a panel; a run without a peak is not drawn.
    #[test]
    fn points_lie_where_their_values_say() {
        let row = |cost, error| Row {
            engine: "Drake".into(),
            method: "method".into(),
            mesh: "S".into(),
            cpu_s_per_s: Some(cost),
            peak_error: error,
            peak_time_error: Some(0.0),
            ..Row::default()
        };
        let rows = [
            row(0.1, Some(1.0)),
            row(10.0, Some(-1e-4)),
            row(1.0, Some(0.01)),
            row(1.0, None),
        ];
        let text = svg(&rows);
        assert!(
            text.contains("<polyline points=\"70.0,90.0 310.0,275.0 550.0,460.0\""),
            "{text}"
        );
        assert_eq!(text.matches("Drake: method</text>").count(), 1);
    }
}
