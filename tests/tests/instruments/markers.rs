//! An instrument with markers drives a tool: pose and opening from a recording of marker positions, permuted and hidden ones counted.

use microsim_host::record::Session;
use microsim_message::{ToolSample, decode};
use microsim_tests::{command, config_with, finish, report_beside, scratch};
use nalgebra::{UnitQuaternion, Vector3};
use std::fmt::Write;
use std::fs;

/// Markers of forceps `[m]`: closed, and open where they move.
const MARKERS: [([f64; 3], [f64; 3]); 5] = [
    ([0.0, 15e-3, 90e-3], [0.0, 15e-3, 90e-3]),
    ([-22e-3, -4e-3, 75e-3], [-22e-3, -4e-3, 75e-3]),
    ([14e-3, -9e-3, 60e-3], [14e-3, -9e-3, 60e-3]),
    ([-3e-3, 0.0, 0.0], [-9e-3, 0.0, 0.0]),
    ([3e-3, 0.0, 0.0], [9e-3, 0.0, 0.0]),
];

/// Where the instrument is at a time, and its opening.
fn truth(time: f64) -> (UnitQuaternion<f64>, Vector3<f64>, f64) {
    let turn =
        UnitQuaternion::from_scaled_axis(Vector3::new(0.3 * libm::sin(time), 0.2, 0.1 * time));
    let place = Vector3::new(0.004 * libm::sin(2.0 * time), 0.003 * time, 0.012);
    (turn, place, 0.5 + 0.4 * libm::sin(3.0 * time))
}

#[test]
fn markers_drive_a_tool() {
    let folder = scratch();
    let at = |name: &str| folder.path().join(name);
    // 2 s at 100 Hz. Names of two markers are exchanged from 0.5 to 1 s, one is hidden from 1 to 1.5 s, three from 1.5 to 1.6 s.
    let mut csv = String::from("t");
    for marker in 1..=5 {
        let _ = write!(csv, ",x{marker},y{marker},z{marker}");
    }
    csv.push('\n');
    for step in 0..200_u32 {
        let time = f64::from(step) * 0.01;
        let (turn, place, opening) = truth(time);
        let _ = write!(csv, "{time:?}");
        for column in 0..5 {
            let marker = match (column, time) {
                (1, 0.5..1.0) => 2,
                (2, 0.5..1.0) => 1,
                (column, _) => column,
            };
            let hidden = ((1.0..1.5).contains(&time) && column == 4)
                || ((1.5..1.6).contains(&time) && column < 3);
            let (closed, open) = MARKERS[marker];
            let own = Vector3::from(closed) * (1.0 - opening) + Vector3::from(open) * opening;
            let seen = (turn * own + place) * 1e3;
            let _ = match hidden {
                true => write!(csv, ",,,"),
                false => write!(csv, ",{:?},{:?},{:?}", seen.x, seen.y, seen.z),
            };
        }
        csv.push('\n');
    }
    fs::write(at("markers.csv"), csv).expect("the recording");
    let mut map = String::from(
        "licence = \"none\"\nsource = \"made by a test\"\n[time]\ncolumn = \"t\"\nunit = \"s\"\n",
    );
    for marker in 1..=5 {
        let _ = write!(
            map,
            "[[device]]\nname = \"right-{marker}\"\nposition = [\"x{marker}\", \"y{marker}\", \"z{marker}\"]\nposition_unit = \"mm\"\n"
        );
    }
    fs::write(at("markers.toml"), map).expect("the column map");
    let mut settings = String::from("[[markers]]\ndevice = \"right\"\nmerge = 0\n");
    for (index, (closed, open)) in MARKERS.iter().enumerate() {
        let _ = write!(
            settings,
            "[[markers.marker]]\nname = \"right-{}\"\nat = {closed:?}\nopen = {open:?}\n",
            index + 1
        );
    }
    let config = config_with(folder.path(), "translator.toml", &settings);
    let mut run = command(["--config".as_ref(), config.as_os_str()]);
    run.args(["run", "touch-spheres", "--json", "--input"]);
    run.arg(format!("recording:{}", at("markers.csv").display()));
    run.arg("--session").arg(at("m.session"));
    let printed = finish(&mut run).expect(0).json();

    let session = Session::read(&fs::read(at("m.session")).expect("a session")).expect("a session");
    let logs = session.ticks.iter().map(|(_, tick)| &tick.log[..]);
    let frames = logs.flat_map(|log| microsim_bus::Frames::new(log).filter_map(Result::ok));
    let samples: Vec<ToolSample> = frames.filter_map(|frame| decode(&frame)?.ok()).collect();
    let tracked: Vec<&ToolSample> = samples.iter().filter(|sample| sample.tracked).collect();
    // All but the ten with two markers.
    assert_eq!(tracked.len(), 190);
    for sample in tracked {
        let (turn, place, opening) = truth(sample.time);
        let off = Vector3::from(sample.pose.position) - place;
        let [x, y, z, w] = sample.pose.orientation;
        let seen = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z));
        // Rounding: coordinates below 0.2 m, levers below 20.
        assert!(
            off.norm() < 1e-12 && seen.angle_to(&turn) < 1e-10,
            "{sample:?}"
        );
        assert!(
            (sample.opening - opening).abs() < 1e-10,
            "{sample:?} {opening}"
        );
    }
    for markers in [
        &printed["markers"][0],
        &report_beside(&at("m.session"))["markers"][0],
    ] {
        assert_eq!(markers["frames"], 200, "{printed}");
        assert_eq!(markers["poses"], 190);
        // Two for half a second; 50 with one hidden and ten with three.
        assert_eq!(markers["permuted"], 100);
        assert_eq!(markers["missing"], 80);
        assert_eq!(markers["losses"]["too few markers are seen"], 10);
    }
    let mut explain = command(["--config".as_ref(), config.as_os_str()]);
    explain.args(["run", "touch-spheres", "--explain", "--input"]);
    explain.arg(format!("recording:{}", at("markers.csv").display()));
    let shown = finish(&mut explain).expect(0).out;
    assert!(shown.contains("pose and opening of 5 markers"), "{shown}");
}
