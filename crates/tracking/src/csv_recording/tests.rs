use microsim_message::Pose;

use super::*;

fn names<const N: usize>(names: [&str; N]) -> [String; N] {
    names.map(str::to_owned)
}

/// The map of the recording that is shipped.
fn stylus_map() -> ColumnMap {
    ColumnMap {
        delimiter: b',',
        time: Column {
            name: "t_s".to_owned(),
            factor: 1.0,
        },
        devices: vec![DeviceColumns {
            device: "stylus".to_owned(),
            position: names(["x_mm", "y_mm", "z_mm"]),
            position_factor: 1e-3,
            orientation: Some(names(["qx", "qy", "qz", "qw"])),
            opening: None,
            visible: None,
        }],
        gap_s: None,
    }
}

/// Two devices without orientation, all options in use.
fn pair_map() -> ColumnMap {
    let device = |side: &str| DeviceColumns {
        device: side.to_owned(),
        position: ["x", "y", "z"].map(|axis| format!("{side}_{axis}")),
        position_factor: 1.0,
        orientation: None,
        opening: Some(OpeningColumn {
            name: format!("{side}_grip"),
            closed: 200.0,
            open: 100.0,
        }),
        visible: Some(format!("{side}_seen")),
    };
    ColumnMap {
        delimiter: b';',
        time: Column {
            name: "ms".to_owned(),
            factor: 1e-3,
        },
        devices: vec![device("left"), device("right")],
        gap_s: Some(0.5),
    }
}

const HEADER: &str = "t_s,x_mm,y_mm,z_mm,qx,qy,qz,qw\n";
const PAIR_HEADER: &str =
    "ms;left_x;left_y;left_z;left_grip;left_seen;right_x;right_y;right_z;right_grip;right_seen\n";

/// The figures stand in DOMAIN section 4 and in the shipped recording's notice (3466 samples, 62.5 Hz, 98.3 s, path
/// 1109.963 mm over 12 segments), each to its printed digits.
#[test]
fn shipped_recording_has_the_published_figures() {
    let bytes = include_bytes!("../../../../assets/recordings/cataract-stylus/stylus.csv");
    let recording = read_csv(bytes, "stylus.csv", &stylus_map()).unwrap();
    let statistics = recording.statistics("stylus");
    assert_eq!(statistics.samples, 3466);
    assert_eq!(statistics.segments, 12);
    assert_eq!(statistics.gaps, 11);
    assert_eq!(format!("{:.3}", statistics.path_m * 1e3), "1109.963");
    assert_eq!(format!("{:.1}", statistics.rate_hz.unwrap()), "62.5");
    assert_eq!(format!("{:.1}", statistics.duration_s), "98.3");
}

#[test]
fn units_opening_and_visibility() {
    let csv = format!(
        "\u{feff}{PAIR_HEADER}\
         0; 1;2;3;200;1; 4;5;6;150;true\n\
         10;1;2;3;50;1;;;;;1\n\
         20;nan;;;;0;4;5;6;;TRUE\n"
    );
    let recording = read_csv(csv.as_bytes(), "pair.csv", &pair_map()).unwrap();
    let sample = |device: &str, device_time, position, opening| InputSample {
        device: device.into(),
        device_time,
        visible: true,
        pose: Pose {
            position,
            ..Pose::default()
        },
        opening,
    };
    assert_eq!(
        recording.samples,
        [
            sample("left", 0.0, [1.0, 2.0, 3.0], Some(0.0)),
            sample("right", 0.0, [4.0, 5.0, 6.0], Some(0.5)),
            // 50 lies beyond what means open.
            sample("left", 0.01, [1.0, 2.0, 3.0], Some(1.0)),
            InputSample::not_visible("right", 0.01),
            InputSample::not_visible("left", 0.02),
            sample("right", 0.02, [4.0, 5.0, 6.0], None),
        ]
    );
    assert_eq!(recording.samples_of("right").count(), 3);
    assert_eq!(recording.statistics("right").gaps, 1);
    assert_eq!(recording.statistics("nobody").samples, 0);
}

#[test]
fn quaternion_is_scaled_to_norm_one_within_the_tolerance() {
    let csv = format!("{HEADER}0,1,2,3,0,0,0.6003,0.8004\n");
    let recording = read_csv(csv.as_bytes(), "near.csv", &stylus_map()).unwrap();
    // The norm is 1.0005, so the components are 0.6 and 0.8 up to rounding.
    let [x, y, z, w] = recording.samples[0].pose.orientation;
    assert_eq!((x, y), (0.0, 0.0));
    assert!((z - 0.6).abs() <= 2.0 * f64::EPSILON && (w - 0.8).abs() <= 2.0 * f64::EPSILON);
}

/// Each bad file with the whole text of its error.
#[test]
fn bad_files_are_refused_with_place_and_expectation() {
    let good = "0,1,2,3,0,0,0,1\n";
    let cases: [(String, &str); 17] = [
        (
            String::new(),
            "bad.csv:1: the file is empty, expected a header with the names of the columns",
        ),
        (
            HEADER.into(),
            "bad.csv:1: the header is followed by no sample",
        ),
        (
            "t_s,x_mm,y,z_mm,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n".into(),
            "bad.csv:1: column \"y_mm\" is missing; the header has t_s, x_mm, y, z_mm, qx, qy, qz, qw",
        ),
        (
            "t_s,x_mm,y_mm,z_mm,qx,qy,qz,qw,x_mm\n".into(),
            "bad.csv:1: column \"x_mm\" stands in the header more than once",
        ),
        (
            format!("{HEADER}{good}0.1,1,2,3,0,0,0\n"),
            "bad.csv:3: expected 8 fields as in the header, found 7",
        ),
        (
            format!("{HEADER}{good}0.1,1,2,3,0,0,0,1,9\n"),
            "bad.csv:3: expected 8 fields as in the header, found 9",
        ),
        (
            format!("{HEADER}{good}0.1,1,NaN,3,0,0,0,1\n"),
            "bad.csv:3: column \"y_mm\": expected a finite number, found \"NaN\"",
        ),
        (
            format!("{HEADER}{good}0.1,1,2,-inf,0,0,0,1\n"),
            "bad.csv:3: column \"z_mm\": expected a finite number, found \"-inf\"",
        ),
        (
            format!("{HEADER}{good}nan,1,2,3,0,0,0,1\n"),
            "bad.csv:3: column \"t_s\": expected a finite number, found \"nan\"",
        ),
        (
            format!("{HEADER}{good}0.1,1,2,1e999,0,0,0,1\n"),
            "bad.csv:3: column \"z_mm\": expected a finite number, found \"1e999\"",
        ),
        (
            format!("{HEADER}{good}0.1,1,2,3 mm,0,0,0,1\n"),
            "bad.csv:3: column \"z_mm\": expected a number such as -1.25, found \"3 mm\"",
        ),
        (
            format!("{HEADER}{good}0.1,1,2,3,0,0,,1\n"),
            "bad.csv:3: column \"qz\": expected a number such as -1.25, found \"\"",
        ),
        (
            format!("{HEADER}0.1,1,2,3,0,0,0,1\n{good}"),
            "bad.csv:3: time 0 s does not come after 0.1 s of the row before",
        ),
        (
            format!("{HEADER}{good}{good}"),
            "bad.csv:3: time 0 s does not come after 0 s of the row before",
        ),
        (
            format!("{HEADER}{good}0.1,1,2,3,0,0,0,0\n"),
            "bad.csv:3: device \"stylus\": quaternion is zero, expected a unit quaternion",
        ),
        (
            format!("{HEADER}{good}0.1,1,2,3,0,0,0.5,0\n"),
            "bad.csv:3: device \"stylus\": quaternion has norm 0.5, expected 1 within 0.001",
        ),
        (
            format!("{HEADER}{good}0.1,1,,3,0,0,0,1\n"),
            "bad.csv:3: device \"stylus\": expected all position fields to be filled, or all empty if it was not \
             visible",
        ),
    ];
    for (csv, expected) in cases {
        let error = read_csv(csv.as_bytes(), "bad.csv", &stylus_map()).unwrap_err();
        assert_eq!(error.to_string(), expected, "{csv}");
    }

    let csv = format!("{PAIR_HEADER}0;1;2;3;200;yes;4;5;6;150;1\n");
    let error = read_csv(csv.as_bytes(), "bad.csv", &pair_map()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "bad.csv:2: column \"left_seen\": expected 1, 0, true or false, found \"yes\""
    );
}

/// The line in a message is that of an editor, whatever ends the lines and whether some are empty.
#[test]
fn line_numbers_are_those_of_the_file() {
    for csv in [
        format!("{HEADER}0,1,2,3,0,0,0,1\n\n\n1,1,2,3,0,0,0,x\n"),
        format!("{HEADER}0,1,2,3,0,0,0,1\n\n\n1,1,2,3,0,0,0,x").replace('\n', "\r\n"),
        format!("\n\n{HEADER}0,1,2,3,0,0,0,1\n1,1,2,3,0,0,0,x"),
        format!(
            "\u{feff}{HEADER}\"0\",1,2,3,0,0,0,1\n1,1,2,3,0,0,0,1\n2,1,2,3,0,0,0,1\n3,1,2,3,0,0,0,x"
        ),
    ] {
        let error = read_csv(csv.as_bytes(), "bad.csv", &stylus_map()).unwrap_err();
        assert_eq!(error.line, 5, "{csv:?}: {error}");
    }
}

#[test]
fn too_many_samples_are_refused() {
    let csv = format!("{HEADER}0,1,2,3,0,0,0,1\n1,1,2,3,0,0,0,1\n2,1,2,3,0,0,0,1\n");
    assert!(read_up_to(3, csv.as_bytes(), "long.csv", &stylus_map()).is_ok());
    let error = read_up_to(2, csv.as_bytes(), "long.csv", &stylus_map()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "long.csv:4: more than 10000000 samples (rows times devices)"
    );
}

/// Any bytes give a recording or an error, without panic.
#[test]
fn binary_bytes_are_an_error() {
    let bytes: Vec<u8> = (0..=255).collect();
    let error = read_csv(&bytes, "bad.csv", &stylus_map()).unwrap_err();
    assert!(
        matches!(error.problem, CsvProblem::MissingColumn { .. }),
        "{error}"
    );
    let mut csv = HEADER.as_bytes().to_vec();
    csv.extend_from_slice(b"0,\xff\xfe,2,3,0,0,0,1\n");
    let error = read_csv(&csv, "bad.csv", &stylus_map()).unwrap_err();
    assert_eq!(error.line, 2);
    assert!(
        matches!(error.problem, CsvProblem::NotANumber { .. }),
        "{error}"
    );
}

/// The required million rows: all read, in memory that is a small multiple of the file's.
#[test]
fn a_million_rows() {
    const ROWS: usize = 1_000_000;
    let mut csv = HEADER.to_owned();
    for row in 0..ROWS {
        csv.push_str(&format!(
            "{row}.125,15.990268,-83.824997,15.166950,0,0,0.6,0.8\n"
        ));
    }
    let recording = read_csv(csv.as_bytes(), "long.csv", &stylus_map()).unwrap();
    assert_eq!(recording.samples.len(), ROWS);
    assert_eq!(recording.samples[ROWS - 1].device_time, 999_999.125);
    let memory = recording.samples.capacity() * size_of::<InputSample>();
    assert!(
        memory <= 4 * csv.len(),
        "{memory} bytes for a file of {}",
        csv.len()
    );
}
