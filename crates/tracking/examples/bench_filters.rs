//! `cargo xtask bench filters`: what one-euro filters leave of tremor, and by how much later motion comes out. The same figures on every machine.
//!
//! A hand at rest trembles with 50 µm root mean square (16 sines at 8 to 12 Hz with random phases, DOMAIN 1), seen by a tracker at 100 Hz; the same hand moves steadily. What is left of the
//! tremor is the root mean square behind the filter over that before it; the delay is what the steady motion comes out later by.

use microsim_drawing::{Anchor, LogAxis, ValueAxis, fixed, text};
use microsim_tracking::OneEuro;
use std::f64::consts::PI;
use std::fmt::Write as _;

const RATE: f64 = 100.0;
const SECONDS: f64 = 40.0;
/// Before it the filter has not come to its steady state.
const SETTLED: f64 = 10.0;
const TREMOR: f64 = 50e-6;
const CUTOFFS: [f64; 7] = [0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0];
const BETAS: [f64; 4] = [0.0, 30.0, 100.0, 300.0];
/// Those of a `[[filter]]` that states nothing else.
const DEFAULT: (f64, f64) = (3.0, 100.0);
const SPEEDS: [f64; 3] = [0.0, 0.01, 0.05];
const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// Sines of which it is stated by how much they are off \[Hz\]: slow and fast motions of a hand.
const SINES: [f64; 3] = [0.25, 0.5, 1.0];

/// What a filter does.
struct Row {
    cutoff: f64,
    beta: f64,
    /// What is left of tremor, at rest and at each speed.
    left: [f64; 3],
    /// By how much motion comes out later at each speed but the first \[s\].
    late: [f64; 2],
}

fn tremor(time: f64) -> f64 {
    let mut state = 9_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let amplitude = TREMOR * (2.0_f64 / 16.0).sqrt();
    let mut sum = 0.0;
    for _ in 0..16 {
        let (frequency, phase) = (8.0 + 4.0 * next(), 2.0 * PI * next());
        sum += amplitude * libm::sin(2.0 * PI * frequency * time + phase);
    }
    sum
}

/// The same tremor as an angle about z \[rad\]: what is left of it over what it was, at rest.
fn left_of_angle(filter: &OneEuro) -> f64 {
    let mut memory = None;
    let (mut left, mut before) = (0.0, 0.0);
    for step in 0..(RATE * SECONDS) as u32 {
        let time = f64::from(step) / RATE;
        let half = 0.5 * tremor(time);
        let turned = [0.0, 0.0, libm::sin(half), libm::cos(half)];
        let (_, seen) = filter.step(&mut memory, time, [0.0; 3], turned, 1.0);
        if time >= SETTLED {
            let angle = 2.0 * libm::atan2(seen[2], seen[3]);
            left += angle * angle;
            before += 4.0 * half * half;
        }
    }
    (left / before).sqrt()
}

/// Root mean square of tremor behind a filter over that before it, and by how much the motion is late.
fn run(filter: &OneEuro, speed: f64) -> (f64, f64) {
    let (mut with, mut without) = (None, None);
    let (mut left, mut before, mut late, mut count) = (0.0, 0.0, 0.0, 0.0);
    for step in 0..(RATE * SECONDS) as u32 {
        let time = f64::from(step) / RATE;
        let shake = tremor(time);
        let place = speed * time;
        let (seen, _) = filter.step(&mut with, time, [place + shake, 0.0, 0.0], UPRIGHT, 1.0);
        let (smooth, _) = filter.step(&mut without, time, [place, 0.0, 0.0], UPRIGHT, 1.0);
        if time < SETTLED {
            continue;
        }
        // Of the motion with tremor less the motion: what is left of it.
        left += (seen[0] - smooth[0]) * (seen[0] - smooth[0]);
        before += shake * shake;
        late += if speed > 0.0 {
            time - smooth[0] / speed
        } else {
            0.0
        };
        count += 1.0;
    }
    ((left / before).sqrt(), late / count)
}

fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for beta in BETAS {
        for cutoff in CUTOFFS {
            let filter = OneEuro {
                min_cutoff: cutoff,
                beta,
                turn_beta: 0.0,
                derivative_cutoff: 1.0,
                predict_s: 0.0,
            };
            let runs = SPEEDS.map(|speed| run(&filter, speed));
            rows.push(Row {
                cutoff,
                beta,
                left: runs.map(|(left, _)| left),
                late: [runs[1].1, runs[2].1],
            });
        }
    }
    rows
}

/// What prediction does to the filter with the cutoff of the defaults at all speeds, for which there is a closed form.
fn predictions() -> String {
    let plain = OneEuro {
        min_cutoff: DEFAULT.0,
        beta: 0.0,
        turn_beta: 0.0,
        derivative_cutoff: 1.0,
        predict_s: 0.0,
    };
    let mut table = format!(
        "\n## Prediction\n\n\
         Off in all of the above, and in all shipped settings. `predict` lets poses go on steadily for a time: a steady motion comes out earlier by it, all others are off. Error: of a sine, of its amplitude, with the \
         filter of {} Hz at all speeds (beta 0); \"tremor\" is what stands behind filter and prediction of the tremor before them, at rest. Angles go on with the rate of the last filtered turn, positions with the \
         low-passed velocity (`derivative_cutoff`), which is less exact for fast motions and leaves tremor smaller. An angle that is predicted by the delay of the filter is that of no filter.\n\n\
         | predict [ms] | delay of a steady motion [ms] | tremor of a position | of an angle | {} |\n|---|---|---|---|{}\n",
        DEFAULT.0,
        SINES
            .map(|f| format!("error of a position at {f} Hz | of an angle"))
            .join(" | "),
        "---|---|".repeat(SINES.len())
    );
    let delay = plain.delay(0.0);
    for predict_s in [0.0, 0.01, 0.02, delay, 0.1] {
        let filter = OneEuro { predict_s, ..plain };
        let (left, _) = run(&filter, 0.0);
        let (_, late) = run(&filter, 0.05);
        let errors = SINES.map(|frequency| {
            let [position, angle] = filter.sine_error(frequency, 1.0 / RATE);
            format!("{:.1} % | {:.1} %", 100.0 * position, 100.0 * angle)
        });
        let _ = writeln!(
            table,
            "| {:.1} | {:.1} | {:.1} % | {:.1} % | {} |",
            1e3 * predict_s,
            1e3 * if late.abs() < 1e-9 { 0.0 } else { late },
            100.0 * left,
            100.0 * left_of_angle(&filter),
            errors.join(" | ")
        );
    }
    table
}

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 360.0;
const LEFT: f64 = 70.0;
const TOP: f64 = 30.0;
const COLOURS: [&str; 4] = ["#34495e", "#2471a3", "#1e8449", "#b9770e"];

/// Delay at 10 mm/s against what is left of tremor at rest.
fn drawing(rows: &[Row]) -> String {
    let delays = rows.iter().map(|row| 1e3 * row.late[0]);
    let x = LogAxis::around(delays, 1.0, (LEFT, LEFT + WIDTH));
    let y = ValueAxis::from_zero(100.0, (TOP + HEIGHT, TOP));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#888\"/>\n",
        LEFT + WIDTH + 30.0,
        TOP + HEIGHT + 60.0
    );
    for (value, is_named) in x.ticks() {
        let at = x.at(value);
        let _ = writeln!(
            out,
            "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{TOP}\" y2=\"{}\" stroke=\"#eee\"/>",
            TOP + HEIGHT
        );
        if is_named {
            text(
                &mut out,
                (at, TOP + HEIGHT + 18.0),
                "",
                Anchor::Middle,
                &LogAxis::label(value),
            );
        }
    }
    let ticks = y.ticks(50.0);
    for value in ticks.values {
        let at = y.at(value);
        text(
            &mut out,
            (LEFT - 6.0, at + 4.0),
            "",
            Anchor::End,
            &fixed(value, ticks.decimals),
        );
    }
    text(
        &mut out,
        (LEFT + 0.5 * WIDTH, TOP + HEIGHT + 42.0),
        "",
        Anchor::Middle,
        "delay of a motion of 10 mm/s [ms]",
    );
    text(
        &mut out,
        (LEFT, TOP - 10.0),
        "",
        Anchor::Start,
        "tremor of 8 to 12 Hz that is left at rest [%]; shipped: no filter, 100 %, no delay",
    );
    for (index, beta) in BETAS.into_iter().enumerate() {
        let points: Vec<String> = rows
            .iter()
            .filter(|row| row.beta == beta)
            .map(|row| {
                format!(
                    "{:.1},{:.1}",
                    x.at(1e3 * row.late[0]),
                    y.at(100.0 * row.left[0])
                )
            })
            .collect();
        let colour = COLOURS[index];
        let _ = writeln!(
            out,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\"/>",
            points.join(" ")
        );
        let at = TOP + 20.0 + 18.0 * index as f64;
        let _ = writeln!(
            out,
            "<line x1=\"{}\" x2=\"{}\" y1=\"{at}\" y2=\"{at}\" stroke=\"{colour}\" stroke-width=\"3\"/>",
            LEFT + WIDTH - 150.0,
            LEFT + WIDTH - 130.0
        );
        text(
            &mut out,
            (LEFT + WIDTH - 122.0, at + 4.0),
            "",
            Anchor::Start,
            &format!("beta {beta} Hz per m/s"),
        );
    }
    for row in rows {
        let is_default = (row.cutoff, row.beta) == DEFAULT;
        let (cx, cy) = (x.at(1e3 * row.late[0]), y.at(100.0 * row.left[0]));
        let (radius, fill) = if is_default {
            (6.0, "#c0392b")
        } else {
            (2.5, "#222")
        };
        let _ = writeln!(
            out,
            "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{radius}\" fill=\"{fill}\"/>"
        );
        if is_default {
            text(
                &mut out,
                (cx + 10.0, cy - 8.0),
                "",
                Anchor::Start,
                "defaults of a [[filter]]",
            );
        }
    }
    out + "</svg>\n"
}

fn page(rows: &[Row]) -> String {
    let mut page = String::from(
        "# One-euro filters: delay against tremor\n\n\
         A hand at rest trembles with 50 µm root mean square at 8 to 12 Hz, a tracker sees it at 100 Hz; it then moves steadily. \"Left\" is the root mean square of the tremor behind the filter over \
         that before it, the delay is what the steady motion comes out later by; `derivative_cutoff` is 1 Hz. Shipped settings have no filter: all of the tremor is left, as metrics measure it, \
         and nothing is late. In bold are the defaults of a `[[filter]]` of `config/translator.toml` that states nothing else.\n\n\
         ![delay against tremor that is left, with the defaults marked](filters.svg)\n\n\
         | min_cutoff [Hz] | beta [Hz per m/s] | left at rest | left at 10 mm/s | left at 50 mm/s | delay at rest, 1/(2π min_cutoff) [ms] | delay at 10 mm/s [ms] | delay at 50 mm/s [ms] |\n\
         |---|---|---|---|---|---|---|---|\n\
         | no filter | | 100 % | 100 % | 100 % | 0 | 0 | 0 |\n",
    );
    for row in rows {
        let bold = if (row.cutoff, row.beta) == DEFAULT {
            "**"
        } else {
            ""
        };
        let left = row
            .left
            .map(|left| format!("{bold}{:.1} %{bold}", 100.0 * left));
        let late = [1.0 / (2.0 * PI * row.cutoff), row.late[0], row.late[1]];
        let late = late.map(|late| format!("{bold}{:.1}{bold}", 1e3 * late));
        let _ = writeln!(
            page,
            "| {bold}{}{bold} | {bold}{}{bold} | {} | {} |",
            row.cutoff,
            row.beta,
            left.join(" | "),
            late.join(" | ")
        );
    }
    page
}

fn main() -> std::io::Result<()> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/results");
    let rows = rows();
    let page = page(&rows) + &predictions();
    println!("{page}");
    std::fs::write(format!("{folder}/filters.svg"), drawing(&rows))?;
    std::fs::write(format!("{folder}/filters.md"), page)
}
