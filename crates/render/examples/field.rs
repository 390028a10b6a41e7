//! Draws a recorded state of the field and measures the time: `cargo run --release -p microsim-render --example field -- STATE.json PICTURE.png [QUALITY [WIDTH HEIGHT]]`

#[path = "../tests/fixture/mod.rs"]
mod fixture;

use microsim_gpu::Gpu;
use microsim_render::{Quality, Renderer, StereoLayout};
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    match draw() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("field: {error}");
            ExitCode::from(2)
        }
    }
}

fn draw() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [state, file, rest @ ..] = arguments.as_slice() else {
        return Err("STATE.json PICTURE.png [QUALITY [WIDTH HEIGHT [LAYOUT]]]".into());
    };
    let quality = rest
        .first()
        .map_or(Some(Quality::Medium), |name| Quality::of_name(name));
    let quality = quality.ok_or("quality: low, medium or high")?;
    let size = match rest {
        [_, width, height, ..] => (width.parse()?, height.parse()?),
        _ => (1280, 720),
    };
    let mut picture = fixture::picture(&std::fs::read_to_string(state)?, size);
    picture.stereo.layout = match rest.get(3).map(String::as_str) {
        None => StereoLayout::Mono,
        Some("side-by-side") => StereoLayout::SideBySide,
        Some("top-bottom") => StereoLayout::TopBottom,
        Some("row-interleaved") => StereoLayout::RowInterleaved,
        Some("red-cyan") => StereoLayout::RedCyan,
        Some(other) => return Err(format!("no layout {other}").into()),
    };
    let gpu = Gpu::off_screen()?;
    let mut renderer = Renderer::of_quality(&gpu, quality)?;
    renderer.draw(&picture)?.write_png(Path::new(file))?;
    let (mut whole, mut encoded) = (Vec::new(), Vec::new());
    let before = cpu_ms()?;
    for _ in 0..40 {
        let start = Instant::now();
        renderer.render(&picture)?;
        encoded.push(1e3 * start.elapsed().as_secs_f64());
        while renderer.is_busy()? {
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
        whole.push(1e3 * start.elapsed().as_secs_f64());
    }
    let cpu = (cpu_ms()? - before) / whole.len() as f64;
    for times in [&mut whole, &mut encoded] {
        times.sort_by(f64::total_cmp);
    }
    println!(
        "{file}: {} {:.1} ms a picture (best {:.1}, p99 {:.1}), {:.1} ms of it encoding, {cpu:.1} CPU ms, on {}",
        quality.name(),
        whole[20],
        whole[0],
        whole[39],
        encoded[20],
        gpu.adapter_name()
    );
    Ok(())
}

/// Time that this process has computed [ms], in hundredths of a second.
fn cpu_ms() -> Result<f64, Box<dyn Error>> {
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    let (_, after) = stat.rsplit_once(')').ok_or("no process")?;
    let fields: Vec<&str> = after.split_whitespace().collect();
    let ticks = fields[11].parse::<f64>()? + fields[12].parse::<f64>()?;
    Ok(10.0 * ticks)
}
