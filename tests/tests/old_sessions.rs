//! Sessions of earlier versions: a replay is refused with the version that it needs, the report is shown.

use flate2::read::GzDecoder;
use microsim_tests::{microsim, repository, scratch};
use serde_json::Value;
use std::fs::File;
use std::io::Read;
use std::path::PathBuf;

/// A recorded session, unpacked.
fn unpacked(folder: &tempfile::TempDir, name: &str) -> PathBuf {
    let packed = repository().join(format!("tests/data/old-sessions/{name}.session.gz"));
    let mut bytes = Vec::new();
    GzDecoder::new(File::open(&packed).expect("a recorded session"))
        .read_to_end(&mut bytes)
        .expect("gzip");
    let path = folder.path().join(format!("{name}.session"));
    std::fs::write(&path, bytes).expect("written");
    path
}

/// The report of a session that must not be replayed.
fn report(name: &str, version: &str) -> Value {
    let folder = scratch();
    let session = unpacked(&folder, name);
    let path = session.to_str().expect("UTF-8");
    let refused = microsim(["replay", "--verify", path]).expect(2);
    let sentence =
        format!("recorded with MicroSim {version}, which recomputes it; this is MicroSim");
    assert!(refused.err.contains(&sentence), "{}", refused.err);
    let said = microsim(["report", path]).expect(0);
    assert!(said.out.contains("score"), "{}", said.out);
    microsim(["report", "--json", path]).expect(0).json()
}

fn metric(report: &Value, id: &str) -> Option<f64> {
    let metrics = report["metrics"].as_array().expect("a list");
    let metric = metrics.iter().find(|metric| metric["id"] == id);
    metric.expect("a metric")["value"].as_f64()
}

/// The values that version 0.1.0 printed for the same files.
#[test]
fn a_run_without_tissue() {
    let report = report("format1-touch-spheres-level1", "0.1.0 (record format 1)");
    assert_eq!(report["verdict"], "failed");
    assert_eq!(report["score"], 0.0);
    assert_eq!(report["failed"], serde_json::json!(["targets-missed"]));
    assert_eq!(metric(&report, "time"), Some(3.008));
    assert_eq!(metric(&report, "path-length"), Some(0.002));
    assert_eq!(metric(&report, "angle-error"), None);
}

/// From before sessions were signed.
#[test]
fn a_run_of_the_version_before_signatures() {
    let report = report("format2-touch-spheres-level1", "0.2.0 (record format 2)");
    assert_eq!(report["verdict"], "failed");
    assert_eq!(report["failed"], serde_json::json!(["targets-missed"]));
    assert_eq!(metric(&report, "time"), Some(3.008));
    assert_eq!(
        report["session"]["state_hash"],
        "78431548232a4c33b52548df797186db71e8abb9494b3668369b111946a7d632"
    );
    assert_eq!(report["session"]["complaint"], Value::Null);
}

/// From before state hashes were those of running digests.
#[test]
fn a_run_of_the_version_before_running_digests() {
    let report = report("format3-touch-spheres-level1", "0.3.0 (record format 3)");
    assert_eq!(report["verdict"], "failed");
    assert_eq!(metric(&report, "time"), Some(3.008));
    assert_eq!(
        report["session"]["state_hash"],
        "ab1d3375828b7459df97f54d35b077088198dba726b0d3680f1b38f17e5cc831"
    );
    assert_eq!(report["session"]["complaint"], Value::Null);
}

/// With forces, whose fields have other names since.
#[test]
fn a_run_with_tissue() {
    let report = report("format1-push-strip-level1", "0.1.0 (record format 1)");
    assert_eq!(report["failed"], serde_json::json!(["not-deep-enough"]));
    assert_eq!(metric(&report, "peak-force"), Some(0.0023174940540785123));
    let force = &report["forces"][0];
    assert_eq!(force["tool"], "right");
    let largest = |key: &str| {
        let values = force[key].as_array().expect("a series").iter();
        values.filter_map(Value::as_f64).fold(0.0, f64::max)
    };
    assert_eq!(largest("force"), 0.0023174940540785123);
    assert_eq!(largest("peak"), 0.0023175191697616406);
    assert_eq!(report["session"]["tools"]["right"]["en"], "Probe");
    assert_eq!(report["session"]["bodies"], serde_json::json!(["strip"]));
}
