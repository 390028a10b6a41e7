//! How far the solver came is recorded, and no verdict stands on a computation that means nothing.

use microsim_tests::changed_levels::{ChangedLevels, crippled};
use microsim_tests::{report_beside, repository, run, scratch};
use serde_json::Value;

fn input(script: &str) -> String {
    let path = repository().join(format!("modules/coordination/scripts/{script}.toml"));
    format!("script:{}", path.display())
}

/// The scripts that pass, on levels with one iteration in 48 ms: neither passed nor failed, and no score.
#[test]
fn a_level_whose_solver_is_crippled_is_not_judged() {
    let levels = ChangedLevels::new("coordination", crippled);
    let folder = scratch();
    for level in 1..=6 {
        let script = format!("level{level}-pass");
        let session = folder.path().join(format!("{script}.session"));
        let args = ["--level", &level.to_string(), "--input", &input(&script)];
        let printed = levels.run(&session, &args);
        assert_eq!(printed["verdict"], "not-judged", "{script}: {printed}");
        assert_eq!(printed["counts"], false, "{script}");
        assert_eq!(printed["score"], Value::Null, "{script}");
        assert_eq!(printed["failed"], serde_json::json!([]), "{script}");
        let invalid = printed["solver"]["invalid"].as_u64().expect("a number");
        assert!(invalid > 1, "{script}: {printed}");
        let report = report_beside(&session);
        assert_eq!(report["verdict"], "not-judged", "{script}");
        assert_eq!(report["reasons"].as_array().map(Vec::len), Some(1));
    }
}

/// One record of the solver per tick, each within its bounds, and the same figures in the report.
#[test]
fn every_tick_tells_how_far_its_solver_came() {
    let folder = scratch();
    let session = folder.path().join("pass.session");
    let printed = run(
        "coordination",
        &session,
        &["--level", "1", "--input", &input("level1-pass")],
    );
    let solver = &printed["solver"];
    assert_eq!(printed["verdict"], "passed");
    assert_eq!(solver["ticks"], printed["ticks"]);
    assert_eq!(
        (&solver["invalid"], &solver["held"]),
        (&0.into(), &0.into())
    );
    let number = |value: &Value| value.as_f64().expect("a number");
    // The level's tolerance is 1e-4 of the forces; most ticks meet it.
    let unconverged = number(&solver["unconverged"]) / number(&solver["ticks"]);
    assert!(unconverged < 0.5 && number(&solver["residual"]["p50"]) <= 1e-4);
    for quantiles in ["residual", "force_residual", "contact_residual"] {
        let [p50, p99, max] = ["p50", "p99", "max"].map(|name| number(&solver[quantiles][name]));
        assert!(0.0 <= p50 && p50 <= p99 && p99 <= max, "{quantiles}");
    }
    assert_eq!(&report_beside(&session)["solver"], solver);
}
