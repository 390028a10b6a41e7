//! `microsim calibrate`: tips of instruments and places of trackers, into the calibration of this station.

use crate::cli::{CalibrateCommand, ListenArgs, PivotArgs, Place, WorkspaceArgs};
use crate::date;
use crate::folders::Folders;
use crate::listen::{device_of, listen, translator, without_markers};
use crate::output::{Exit, Problem, print, print_json};
use crate::replace_file::replace;
use crate::session_file::installation;
use microsim_host::assemble::Installation;
use microsim_message::{InputSample, Pose};
use microsim_settings::{
    Calibration, TipCalibration, WorkspaceCalibration, load_calibration, read_regular, unwritable,
};
use microsim_tracking::{Dwell, Pair, Pivot, Registration, dwells, pivot, register};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// How long a live source is listened to where nothing else is asked for \[s\].
const SECONDS: f64 = 20.0;

/// Calibrates.
pub fn calibrate(place: &Place, command: &CalibrateCommand) -> Result<Exit, Problem> {
    match command {
        CalibrateCommand::Pivot(args) => calibrate_pivot(place, args),
        CalibrateCommand::Workspace(args) => calibrate_workspace(place, args),
    }
}

/// The calibration file of this station.
fn file(place: &Place) -> Result<PathBuf, Problem> {
    Ok(Folders::of(place)?.calibration())
}

/// Changes the calibration of this station.
fn write(path: &Path, change: impl FnOnce(&mut Calibration)) -> Result<(), Problem> {
    let mut calibration = load_calibration(path).map_err(|e| e.to_string())?;
    change(&mut calibration);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| unwritable(folder, e))?;
    }
    replace(path, calibration.to_toml().as_bytes())
}

/// What a residual means.
fn verdict(rms: f64, limit: f64, beyond: &str) -> String {
    match () {
        () if rms <= limit / 3.0 => "good".into(),
        () if rms <= limit => format!("usable, limit {:.2} mm", 1e3 * limit),
        () => format!("beyond the limit of {:.2} mm: {beyond}", 1e3 * limit),
    }
}

/// What came of a calibration: words or JSON, and the exit status.
fn conclude(
    as_json: bool,
    is_good: bool,
    written: Option<&Path>,
    lines: &[String],
    mut document: Value,
) -> Result<Exit, Problem> {
    if as_json {
        document["good"] = json!(is_good);
        document["written"] = json!(written);
        print_json(&document)?;
    } else {
        print(lines.join("\n"))?;
        match (written, is_good) {
            (Some(path), _) => print(format!("Written to {}", path.display()))?,
            (None, true) => print("Nothing is written")?,
            (None, false) => print("Nothing is written; calibrate again")?,
        }
    }
    Ok(if is_good { Exit::Done } else { Exit::Negative })
}

fn calibrate_pivot(place: &Place, args: &PivotArgs) -> Result<Exit, Problem> {
    let installation = installation(place)?;
    let translator = translator(&installation)?;
    let samples = listen(&installation, &args.listen, SECONDS)?.samples;
    let samples = without_markers(&translator, samples)?;
    let device = device_of(&translator, &args.tool, &samples);
    let of_device: Vec<&InputSample> = samples
        .iter()
        .map(|(_, sample)| sample)
        .filter(|sample| sample.device == device)
        .collect();
    if of_device.is_empty() {
        return Err(nothing_of(&device, &samples).into());
    }
    let poses: Vec<Pose> = of_device
        .iter()
        .filter(|s| s.visible)
        .map(|s| s.pose)
        .collect();
    let found = pivot(&poses).map_err(|e| format!("device \"{device}\": {e}"))?;
    let is_good = found.rms <= args.limit;
    let path = file(place)?;
    let written = is_good && !args.dry_run;
    if written {
        let tip = TipCalibration {
            device: device.clone(),
            tip: found.tip,
            residual: found.rms,
            error: found.tip_error(),
            spread: found.spread,
            poses: u32::try_from(poses.len()).unwrap_or(u32::MAX),
            date: today(),
        };
        write(&path, |calibration| calibration.set_tip(tip))?;
    }
    let hidden = of_device.len() - poses.len();
    let lines = pivot_lines(&device, &found, args.limit, hidden);
    let document = json!({
        "device": device, "tip_m": found.tip, "centre_m": found.centre, "poses": poses.len(), "not_visible": hidden,
        "residual_rms_m": found.rms, "residual_largest_m": found.worst(), "sigma_m": found.sigma,
        "tip_error_m": found.tip_error(), "spread_rad": found.spread, "limit_m": args.limit,
    });
    conclude(
        args.json,
        is_good,
        written.then_some(&*path),
        &lines,
        document,
    )
}

/// Why there is nothing to calibrate.
fn nothing_of(device: &str, samples: &[(f64, InputSample)]) -> String {
    let names: BTreeSet<&str> = samples
        .iter()
        .map(|(_, sample)| &sample.device[..])
        .collect();
    let names: Vec<&str> = names.into_iter().collect();
    match names.is_empty() {
        true => "nothing came; `microsim devices` shows what an input sends".into(),
        false => format!(
            "no sample of device \"{device}\" came; there are: {}",
            names.join(", ")
        ),
    }
}

/// The residuals of a fit \[m\], and what they mean.
fn residual_line(rms: f64, worst: f64, limit: f64, beyond: &str) -> String {
    format!(
        "  residual   {:.3} mm root mean square, {:.3} mm at most: {}",
        1e3 * rms,
        1e3 * worst,
        verdict(rms, limit, beyond)
    )
}

fn pivot_lines(device: &str, found: &Pivot, limit: f64, hidden: usize) -> Vec<String> {
    let [x, y, z] = found.tip.map(|x| 1e3 * x);
    let beyond = "the tip did not stand still, or the tracker jitters";
    let seen = match hidden {
        0 => String::new(),
        n => format!(", {n} samples without a pose"),
    };
    vec![
        format!(
            "{device}: {} poses, spread by {:.0}°{seen}",
            found.residuals.len(),
            found.spread.to_degrees()
        ),
        format!("  tip        ({x:.3}, {y:.3}, {z:.3}) mm in the frame of the handle"),
        residual_line(found.rms, found.worst(), limit, beyond),
        format!(
            "  error      {:.3} mm (standard error of the tip)",
            1e3 * found.tip_error()
        ),
    ]
}

fn calibrate_workspace(place: &Place, args: &WorkspaceArgs) -> Result<Exit, Problem> {
    let path = file(place)?;
    let (pairs, heard) = match (&args.pairs, &args.points) {
        (Some(file), _) => (read_pairs(file)?, Vec::new()),
        (None, Some(points)) => touched(place, args, &path, points)?,
        (None, None) => return Err("give --pairs or --points".into()),
    };
    let devices = match args.devices.is_empty() {
        true => heard,
        false => args.devices.clone(),
    };
    let found = register(&pairs, args.scale).map_err(|e| e.to_string())?;
    let centre = middle(&pairs);
    let error = found.target_error(centre);
    let is_good = found.rms <= args.limit;
    let written = is_good && !args.dry_run;
    if written {
        let space = WorkspaceCalibration {
            devices: devices.clone(),
            rotation: found.rotation,
            translation: found.translation,
            scale: found.scale,
            residual: found.rms,
            error,
            points: u32::try_from(pairs.len()).unwrap_or(u32::MAX),
            date: today(),
        };
        write(&path, |calibration| calibration.set_workspace(space))?;
    }
    let lines = workspace_lines(&devices, &found, args.limit, error);
    let document = json!({
        "devices": devices, "rotation": found.rotation, "translation_m": found.translation, "scale": found.scale,
        "points": pairs.len(), "residuals_m": found.residuals, "residual_rms_m": found.rms, "sigma_m": found.sigma,
        "error_in_the_middle_m": error, "limit_m": args.limit,
    });
    conclude(
        args.json,
        is_good,
        written.then_some(&*path),
        &lines,
        document,
    )
}

/// The mean of the points in the field.
fn middle(pairs: &[Pair]) -> [f64; 3] {
    let count = pairs.len().max(1) as f64;
    std::array::from_fn(|i| pairs.iter().map(|pair| pair.field[i]).sum::<f64>() / count)
}

fn workspace_lines(
    devices: &[String],
    found: &Registration,
    limit: f64,
    error: f64,
) -> Vec<String> {
    let [x, y, z] = found.translation.map(|x| 1e3 * x);
    let [qx, qy, qz, qw] = found.rotation;
    let beyond = "a point was touched beside its place, or the list has another order";
    let mut lines = vec![
        format!("{}: {} points", devices.join(", "), found.residuals.len()),
        format!("  rotation   ({qx:.5}, {qy:.5}, {qz:.5}, {qw:.5})"),
        format!(
            "  translation ({x:.3}, {y:.3}, {z:.3}) mm, scale {:.5}",
            found.scale
        ),
        residual_line(found.rms, found.worst(), limit, beyond),
        format!(
            "  error      {:.3} mm expected in the middle of the points",
            1e3 * error
        ),
    ];
    for (index, residual) in found.residuals.iter().enumerate() {
        lines.push(format!("  point {:<4} {:.3} mm", index + 1, 1e3 * residual));
    }
    lines
}

/// Pairs of points that a tip has touched, and the devices that the input sends.
fn touched(
    place: &Place,
    args: &WorkspaceArgs,
    calibration: &Path,
    points: &Path,
) -> Result<(Vec<Pair>, Vec<String>), Problem> {
    let (Some(input), Some(tool)) = (&args.input, &args.tool) else {
        return Err("give --input and --tool with --points".into());
    };
    let field = read_columns(points, ["x", "y", "z"])?;
    let installation = installation(place)?;
    let listened = ListenArgs {
        input: input.clone(),
        seconds: args.seconds,
    };
    // Time for every point and the motion to it.
    let default = field.len() as f64 * (args.dwell + 4.0);
    let (device, samples) = samples_of(&installation, &listened, tool, default)?;
    let path = tip_path(calibration, &device, &samples)?;
    let found = dwells(&path, args.still, args.dwell);
    if found.len() != field.len() {
        return Err(wrong_number(&found, field.len(), args).into());
    }
    let pairs = found.iter().zip(&field).map(|(dwell, field)| Pair {
        device: dwell.position,
        field: field.map(|x| 1e-3 * x),
    });
    let devices: BTreeSet<String> = samples.iter().map(|(_, s)| s.device.clone()).collect();
    Ok((pairs.collect(), devices.into_iter().collect()))
}

/// The device of a tool, and what came while it was listened.
fn samples_of(
    installation: &Installation,
    args: &ListenArgs,
    tool: &str,
    default: f64,
) -> Result<(String, Vec<(f64, InputSample)>), Problem> {
    let translator = translator(installation)?;
    let samples = listen(installation, args, default)?.samples;
    let samples = without_markers(&translator, samples)?;
    let device = device_of(&translator, tool, &samples);
    match samples.iter().any(|(_, sample)| sample.device == device) {
        true => Ok((device, samples)),
        false => Err(nothing_of(&device, &samples).into()),
    }
}

/// Times of arrival \[s\] and positions of a tip in the frame of its device \[m\]; none where it was not seen.
type TipPath = Vec<(f64, Option<[f64; 3]>)>;

/// Where the tip of a device was, in its frame.
fn tip_path(
    calibration: &Path,
    device: &str,
    samples: &[(f64, InputSample)],
) -> Result<TipPath, Problem> {
    let calibration = load_calibration(calibration).map_err(|e| e.to_string())?;
    let tip = calibration.tip.iter().find(|tip| tip.device == device);
    let Some(tip) = tip else {
        return Err(format!(
            "the tip of device \"{device}\" is not known; `microsim calibrate pivot {device}` comes first"
        )
        .into());
    };
    let of_device = samples.iter().filter(|(_, sample)| sample.device == device);
    let place = |sample: &InputSample| {
        let [x, y, z, w] = sample.pose.orientation;
        let turn = nalgebra::Unit::try_new(nalgebra::Quaternion::new(w, x, y, z), 0.5)?;
        let lever = turn * nalgebra::Vector3::from(tip.tip);
        Some(std::array::from_fn(|i| sample.pose.position[i] + lever[i]))
    };
    let path = of_device.map(|(_, sample)| {
        let place = place(sample).filter(|_| sample.visible);
        (sample.device_time, place)
    });
    Ok(path.collect())
}

fn wrong_number(found: &[Dwell], expected: usize, args: &WorkspaceArgs) -> String {
    let places = found.iter().map(|dwell| {
        let [x, y, z] = dwell.position.map(|x| 1e3 * x);
        format!(
            "  at {:.1} s for {:.1} s: ({x:.1}, {y:.1}, {z:.1}) mm",
            dwell.start,
            dwell.end - dwell.start
        )
    });
    let places: Vec<String> = places.collect();
    format!(
        "the tip stood still at {} places, expected {expected}, one for each point; it has to stay within {:.1} mm for {:.1} s (--still, --dwell)\n{}",
        found.len(),
        1e3 * args.still,
        args.dwell,
        places.join("\n")
    )
}

/// Pairs from a file in mm.
fn read_pairs(path: &Path) -> Result<Vec<Pair>, Problem> {
    let names = [
        "device_x", "device_y", "device_z", "field_x", "field_y", "field_z",
    ];
    let rows = read_columns(path, names)?;
    let pair = |[a, b, c, d, e, f]: [f64; 6]| Pair {
        device: [a, b, c].map(|x| 1e-3 * x),
        field: [d, e, f].map(|x| 1e-3 * x),
    };
    Ok(rows.into_iter().map(pair).collect())
}

/// Columns of numbers from a CSV file with a header.
fn read_columns<const N: usize>(path: &Path, names: [&str; N]) -> Result<Vec<[f64; N]>, Problem> {
    let name = path.display();
    let bytes = read_regular(path).map_err(|e| format!("{name}: {e}"))?;
    let text = String::from_utf8(bytes).map_err(|e| format!("{name}: {e}"))?;
    parse_columns(&text, names).map_err(|(line, what)| format!("{name}:{line}: {what}").into())
}

/// The same from a text; what is wrong comes with its line.
fn parse_columns<const N: usize>(
    text: &str,
    names: [&str; N],
) -> Result<Vec<[f64; N]>, (usize, String)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty());
    let expected = || format!("expected a header with the columns {}", names.join(", "));
    let Some((_, header)) = lines.next() else {
        return Err((1, expected()));
    };
    let header: Vec<&str> = header.split(',').map(str::trim).collect();
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        let found = header.iter().position(|column| *column == name);
        *place = found.ok_or_else(|| (1, format!("there is no column {name}; {}", expected())))?;
    }
    let mut rows = Vec::new();
    for (index, line) in lines {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let mut row = [0.0; N];
        for ((value, place), name) in row.iter_mut().zip(places).zip(names) {
            let field = fields.get(place).copied().unwrap_or_default();
            let number = field
                .parse::<f64>()
                .ok()
                .filter(|number| number.is_finite());
            let wrong = || {
                (
                    index + 1,
                    format!("{name}: expected a number of millimetres, found `{field}`"),
                )
            };
            *value = number.ok_or_else(wrong)?;
        }
        rows.push(row);
    }
    Ok(rows)
}

/// The date, UTC.
fn today() -> String {
    date::iso(date::now()).chars().take(10).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name_and_faults_have_their_line() {
        let names = ["x", "y"];
        let text = "\u{feff}name, y , x\na,2,1\n\nb,-4,3.5\n";
        assert_eq!(
            parse_columns(text, names),
            Ok(vec![[1.0, 2.0], [3.5, -4.0]])
        );
        let line = |text| parse_columns::<2>(text, names).map_err(|(line, _)| line);
        assert_eq!(line(""), Err(1));
        assert_eq!(line("x,z\n1,2\n"), Err(1));
        assert_eq!(line("x,y\n1,2\n1\n"), Err(3));
        assert_eq!(line("x,y\n1,nan\n"), Err(2));
    }
}
