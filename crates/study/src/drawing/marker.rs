//! Markers: each series has a form of its own besides its colour.

use std::fmt::Write;

/// Corners of an upright cross.
const CROSS: [(f64, f64); 12] = [
    (-0.45, -1.3),
    (0.45, -1.3),
    (0.45, -0.45),
    (1.3, -0.45),
    (1.3, 0.45),
    (0.45, 0.45),
    (0.45, 1.3),
    (-0.45, 1.3),
    (-0.45, 0.45),
    (-1.3, 0.45),
    (-1.3, -0.45),
    (-0.45, -0.45),
];

/// A marker of series `index` at a place; `radius` is that of a disc of about the same area.
pub fn marker(
    out: &mut String,
    index: usize,
    (x, y): (f64, f64),
    radius: f64,
    class: &str,
    tip: &str,
) {
    let r = radius;
    let polygon = |corners: &[(f64, f64)]| {
        let mut path = String::new();
        for (k, (dx, dy)) in corners.iter().enumerate() {
            let command = if k == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{command}{:.2} {:.2}", x + dx * r, y + dy * r);
        }
        path.push('Z');
        path
    };
    // Regular polygons by their corners on a circle of the radius given.
    let regular = |sides: usize, size: f64, turn: f64, inner: f64| {
        let corners: Vec<(f64, f64)> = (0..sides)
            .map(|k| {
                let angle = std::f64::consts::TAU * (k as f64 / sides as f64) + turn;
                let size = if k % 2 == 1 { size * inner } else { size };
                (size * libm::sin(angle), -size * libm::cos(angle))
            })
            .collect();
        polygon(&corners)
    };
    let pi = std::f64::consts::PI;
    let path = match index % super::SERIES {
        0 => format!(
            "M{:.2} {y:.2}a{r:.2} {r:.2} 0 1 0 {:.2} 0a{r:.2} {r:.2} 0 1 0 {:.2} 0Z",
            x - r,
            2.0 * r,
            -2.0 * r
        ),
        1 => regular(4, 1.25, pi / 4.0, 1.0),
        2 => regular(3, 1.45, 0.0, 1.0),
        3 => regular(4, 1.35, 0.0, 1.0),
        4 => regular(3, 1.45, pi, 1.0),
        5 => regular(10, 1.6, 0.0, 0.45),
        6 => polygon(&CROSS),
        7 => regular(6, 1.2, 0.0, 1.0),
        8 => regular(3, 1.45, pi / 2.0, 1.0),
        9 => regular(8, 1.7, 0.0, 0.4),
        11 => regular(3, 1.45, -pi / 2.0, 1.0),
        _ => polygon(&CROSS.map(|(x, y)| {
            // Turned by an eighth.
            let half = std::f64::consts::FRAC_1_SQRT_2;
            ((x - y) * half, (x + y) * half)
        })),
    };
    let tip = if tip.is_empty() {
        String::new()
    } else {
        format!("<title>{}</title>", microsim_drawing::escape(tip))
    };
    let series = index % super::SERIES;
    let _ = write!(
        out,
        "<path class=\"mark series-{series} {class}\" d=\"{path}\">{tip}</path>"
    );
}
