//! Draws one scene with everything that a training picture holds, for looking at it and for its time per frame:
//! `cargo run --release -p microsim-render --example gallery -- PICTURE.png`

use microsim_gpu::Gpu;
use microsim_render::{Finish, Item, Picture, Renderer, Shape, View};
use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;
use std::time::Instant;

const STEEL: [f32; 3] = [0.80, 0.82, 0.85];
/// Height of the mat \[m\]; the plane of focus is at zero.
const MAT: f64 = -2.0e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("which PNG file shall the picture be written to?")?;
    let gpu = Gpu::off_screen()?;
    let mut renderer = Renderer::new(&gpu)?;
    let mut items = Vec::new();
    mat(&mut items);
    targets(&mut items);
    forceps(&mut items);
    strip(&mut items);
    let view = View {
        centre: [0.0; 3],
        field_diameter: 25.0e-3,
        working_distance: 0.2,
        tilt: 0.0,
    };
    let picture = Picture {
        background: [0.02, 0.03, 0.04],
        ..Picture::new((800, 800), view, items)
    };
    let image = renderer.draw(&picture)?;
    image.write_png(Path::new(&path))?;

    let mut milliseconds = Vec::new();
    for _ in 0..31 {
        let start = Instant::now();
        renderer.draw(&picture)?;
        milliseconds.push(1e3 * start.elapsed().as_secs_f64());
    }
    milliseconds.sort_by(f64::total_cmp);
    let (best, median) = (milliseconds[0], milliseconds[milliseconds.len() / 2]);
    println!(
        "{path}: {median:.1} ms a frame (best {best:.1} ms) on {}",
        gpu.adapter_name()
    );
    Ok(())
}

/// A dark mat with a line every 5 mm.
fn mat(items: &mut Vec<Item>) {
    let half = 40.0e-3;
    let cloth = Shape::Box {
        half: [half, half, 1.0e-3],
    };
    items.push(Item::new(
        cloth,
        [0.0, 0.0, MAT - 1.0e-3],
        [0.08, 0.29, 0.32],
        Finish::Matte,
    ));
    for number in -4..=4 {
        let offset = 5.0e-3 * f64::from(number);
        for (half, place) in [
            ([0.03e-3, half, 0.01e-3], [offset, 0.0, MAT]),
            ([half, 0.03e-3, 0.01e-3], [0.0, offset, MAT]),
        ] {
            items.push(Item::new(
                Shape::Box { half },
                place,
                [0.13, 0.36, 0.39],
                Finish::Matte,
            ));
        }
    }
}

/// Six spheres of different heights; one is being held (ring), one shows the direction that it wants to be touched from.
fn targets(items: &mut Vec<Item>) {
    let colours = [
        [0.95, 0.30, 0.25],
        [0.98, 0.62, 0.15],
        [0.95, 0.88, 0.25],
        [0.45, 0.85, 0.35],
        [0.30, 0.65, 0.98],
        [0.75, 0.45, 0.95],
    ];
    for (number, colour) in colours.into_iter().enumerate() {
        let angle = PI * (1.06 + 0.176 * number as f64);
        let height = [0.8, 3.5, 0.8, 2.2, 0.8, 2.8][number] * 1e-3;
        let place = [
            8.2e-3 * libm::cos(angle),
            2.5e-3 + 9.5e-3 * libm::sin(angle),
            MAT + height,
        ];
        items.push(Item::new(
            Shape::Sphere { radius: 0.8e-3 },
            place,
            colour,
            Finish::Moist,
        ));
        let post = Shape::Cylinder {
            radius: 0.12e-3,
            height,
        };
        items.push(Item::new(
            post,
            [place[0], place[1], MAT],
            [0.35, 0.37, 0.38],
            Finish::Matte,
        ));
        if number == 3 {
            let ring = Shape::Ring {
                radius: 1.25e-3,
                tube: 0.09e-3,
                fraction: 0.65,
            };
            items.push(Item::new(ring, place, [0.95, 0.97, 0.95], Finish::Matte));
        }
        if number == 1 {
            // Comes in from the upper left, 40° over the mat, and ends on the sphere.
            let arrow = Shape::Arrow {
                radius: 0.12e-3,
                length: 2.6e-3,
            };
            let turn = 65.0 * PI / 180.0;
            items.push(Item {
                orientation: [0.0, libm::sin(turn), 0.0, libm::cos(turn)],
                opacity: 0.85,
                ..Item::new(
                    arrow,
                    [place[0] - 2.8e-3, place[1], place[2] + 2.4e-3],
                    colour,
                    Finish::Matte,
                )
            });
        }
    }
}

/// Two jaws in a V, 0.25 mm wide at the tips, that leave the field at the lower right.
fn forceps(items: &mut Vec<Item>) {
    let tip = [3.4e-3, -5.6e-3, MAT + 3.3e-3];
    let (along, rise) = (-35.0 * PI / 180.0, 30.0 * PI / 180.0);
    for side in [-1.0, 1.0] {
        let point = |distance: f64, apart: f64| {
            let (ahead, beside) = (distance * libm::cos(rise), side * apart);
            [
                tip[0] + ahead * libm::cos(along) - beside * libm::sin(along),
                tip[1] + ahead * libm::sin(along) + beside * libm::cos(along),
                tip[2] + distance * libm::sin(rise),
            ]
        };
        for (a, b, radius_a, radius_b) in [
            (point(0.0, 0.5e-3), point(7.0e-3, 1.1e-3), 0.125e-3, 0.35e-3),
            (
                point(7.0e-3, 1.1e-3),
                point(60.0e-3, 4.5e-3),
                0.35e-3,
                1.2e-3,
            ),
        ] {
            items.push(Item::new(
                Shape::Taper {
                    a,
                    b,
                    radius_a,
                    radius_b,
                },
                [0.0; 3],
                STEEL,
                Finish::Metal,
            ));
        }
    }
}

/// A moist strip between two clamps, pushed down by a capsule.
fn strip(items: &mut Vec<Item>) {
    let (half_length, half_width, half_height) = (5.5e-3, 1.4e-3, 0.5e-3);
    let centre = [0.0, 5.6e-3, MAT + 3.0e-3];
    let dent = |x: f64| {
        -1.3e-3
            * libm::exp(-libm::pow((x - 0.8e-3) / 1.5e-3, 2.0))
            * (1.0 - libm::pow(x / half_length, 2.0))
    };
    let (columns, rows) = (88, 16_u32);
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for column in 0..=columns {
        let x = half_length * (2.0 * f64::from(column) / f64::from(columns) - 1.0);
        for row in 0..rows {
            // A rounded rectangle (superellipse) around the strip's axis.
            let angle = 2.0 * PI * f64::from(row) / f64::from(rows);
            let round = |value: f64| value.signum() * value.abs().sqrt();
            let (y, z) = (
                half_width * round(libm::cos(angle)),
                half_height * round(libm::sin(angle)),
            );
            positions.push([x as f32, y as f32, (z + dent(x)) as f32]);
            let next = (row + 1) % rows;
            if column < columns {
                let (a, b) = (column * rows + row, column * rows + next);
                triangles.push([a, a + rows, b]);
                triangles.push([b, a + rows, b + rows]);
            }
        }
    }
    items.push(Item::new(
        Shape::Mesh {
            positions,
            triangles,
        },
        centre,
        [0.88, 0.45, 0.44],
        Finish::Moist,
    ));
    for side in [-1.0, 1.0] {
        let clamp = Shape::Box {
            half: [0.7e-3, 2.0e-3, 0.9e-3],
        };
        let place = [side * (half_length + 0.1e-3), centre[1], centre[2]];
        items.push(Item::new(clamp, place, [0.55, 0.58, 0.62], Finish::Metal));
    }
    let tip = [
        0.8e-3,
        centre[1],
        centre[2] + dent(0.8e-3) + half_height + 0.45e-3,
    ];
    let push = Shape::Taper {
        a: tip,
        b: [tip[0] - 18.0e-3, tip[1] + 22.0e-3, tip[2] + 25.0e-3],
        radius_a: 0.4e-3,
        radius_b: 1.0e-3,
    };
    items.push(Item::new(push, [0.0; 3], STEEL, Finish::Metal));
}
