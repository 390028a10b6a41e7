//! Sessions for the tests of this crate.

use crate::ReportInput;
use microsim_message::{
    CategoryScore, ContactForce, ContactForces, ImplausibleSample, InputSample, InputTiming,
    LevelEvent, LevelState, LimitRecord, LocalText, Log, MarkerTracking, MetricRecord, SolverTick,
    TissueCut, TissueRecovery, ToolSample, ToolStates, TrainingResult, push,
};

/// A message of any kind, as an item of a list.
pub trait AnyMessage {
    /// Appends it as a frame.
    fn push(&self, out: &mut Vec<u8>);
}

macro_rules! any_message {
    ($($kind:ty)*) => {
        $(impl AnyMessage for $kind {
            fn push(&self, out: &mut Vec<u8>) {
                push(out, self);
            }
        })*
    };
}

any_message!(ImplausibleSample InputSample InputTiming MarkerTracking ToolSample ToolStates ContactForces SolverTick TissueCut TissueRecovery LevelState LevelEvent TrainingResult Log);

/// The frames of messages.
pub fn log(messages: &[&dyn AnyMessage]) -> Vec<u8> {
    let mut out = Vec::new();
    for message in messages {
        message.push(&mut out);
    }
    out
}

/// The same text in both languages.
pub fn text(text: &str) -> LocalText {
    LocalText::new(text.to_owned(), text.to_owned())
}

/// A plain session with ticks of 1/8 s.
pub fn input() -> ReportInput {
    ReportInput {
        version: "0.1.0".into(),
        started: 1_700_000_000,
        module: "touch-spheres".into(),
        module_title: text("Touch spheres"),
        level: 2,
        level_title: text("Small spheres"),
        level_summary: text("Touch each sphere."),
        tick_s: 0.125,
        input: "script:demo.toml".into(),
        state_hash: Some("c0ffee".into()),
        session_file: "demo.session".into(),
        replay_command: "microsim replay demo.session --verify".into(),
        ..ReportInput::default()
    }
}

/// A metric in metres, shown in millimetres, with an upper limit \[m\].
pub fn metric(id: &str, value: Option<f64>, max: Option<f64>) -> MetricRecord {
    let within = max.and_then(|max| value.map(|value| value <= max));
    MetricRecord {
        id: id.into(),
        title: text(id),
        unit: "m".into(),
        display_unit: "mm".into(),
        display_factor: 1e3,
        direction: "lower-is-better".into(),
        category: "efficiency".into(),
        formula: format!("{id}/1"),
        source: "a source".into(),
        advice: text("Take the direct path."),
        value,
        not_applicable: value.is_none().then(|| text("no instrument was tracked")),
        limit: max.map(|max| LimitRecord {
            min: None,
            max: Some(max),
            source: "a guess".into(),
            provisional: true,
            decides: true,
        }),
        within,
        score: within.map(|within| if within { 100.0 } else { 0.0 }),
    }
}

/// A result that failed for the given reasons, with three metrics: one within its limit, one not, one not applicable.
pub fn failed_result(failed: &[&str]) -> TrainingResult {
    TrainingResult {
        passed: false,
        aborted: false,
        not_judged: vec![],
        failed: failed.iter().map(|id| id.to_string()).collect(),
        reasons: failed
            .iter()
            .map(|id| text(&format!("Reason {id}.")))
            .collect(),
        duration: 12.5,
        targets_done: 3,
        targets: 5,
        metrics: vec![
            metric("path-length", Some(0.25), Some(0.5)),
            metric("depth", Some(0.75), Some(0.5)),
            metric("tremor", None, Some(0.5)),
        ],
        categories: vec![CategoryScore {
            id: "efficiency".into(),
            title: text("Efficiency"),
            score: 50.0,
        }],
        score: 50.0,
    }
}

/// A tick that is solved.
pub fn solver_tick() -> SolverTick {
    SolverTick {
        steps: 1,
        unconverged: 0,
        iterations: 1,
        residual: 0.0,
        force_residual: 0.0,
        contact_residual: 0.0,
        backtracks: 0,
        contact_failures: 0,
        repetitions: 0,
        ruptured: 0,
        tools_stood: false,
        over_budget: false,
        tool_contacts: 0,
        valid: true,
    }
}

/// A contact of a tool with a body \[N\].
pub fn contact(tool: &str, body: &str, force: [f64; 3]) -> ContactForce {
    ContactForce {
        partner: tool.into(),
        body: body.into(),
        force,
        peak_force: 8.0,
        impulse: 0.0,
        point: [0.0; 3],
        depth: 1e-4,
        indentation: 0.0,
        ..ContactForce::default()
    }
}
