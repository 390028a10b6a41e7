//! Writes a page made of invented data, to look at: `demo_page FILE [passed|failed|incomplete]`.

use microsim_message::{
    CategoryScore, ContactForce, ContactForces, InputSample, LevelEvent, LevelPhase, LevelState,
    LimitRecord, LocalText, Log, LogLevel, MetricRecord, Pose, ToolSample, ToolState, ToolStates,
    ToolStatus, TrainingResult, push,
};
use microsim_report::{Language, Page, Pictures, Report, ReportInput};

const TICK: f64 = 0.02;

fn text(de: &str, en: &str) -> LocalText {
    LocalText::new(de.to_owned(), en.to_owned())
}

/// Two hands for a minute: reaching from target to target, a little tremor, the left one hidden now and then.
fn tick(tick: u64) -> Vec<u8> {
    let t = tick as f64 * TICK;
    let mut log = Vec::new();
    let mut tools = Vec::new();
    for (k, tool) in ["right", "left"].into_iter().enumerate() {
        let side = 1.0 - 2.0 * k as f64;
        let visible = k == 0 && !(21.0..24.0).contains(&t) || k == 1 && t % 17.0 > 1.4;
        let reach = (t * 0.8 + k as f64).sin().powi(3);
        let position = [
            side * 4e-3 + 3e-3 * reach + 4e-5 * (t * 60.0).sin(),
            3e-3 * (t * 0.37).sin() * (t * 0.11).cos() + 4e-5 * (t * 57.0).cos(),
            1.5e-3 + 1.4e-3 * (t * 0.8 + k as f64).cos().abs(),
        ];
        let pose = Pose {
            position,
            ..Pose::default()
        };
        let device = format!("stylus-{tool}");
        push(
            &mut log,
            &InputSample {
                device,
                device_time: 512.0 + t,
                visible,
                pose,
                opening: None,
            },
        );
        push(
            &mut log,
            &ToolSample {
                tool: tool.into(),
                time: 512.0 + t,
                tracked: visible,
                pose,
                opening: 0.0,
            },
        );
        tools.push(ToolState {
            tool: tool.into(),
            model: "forceps".into(),
            status: if visible {
                ToolStatus::Tracked
            } else {
                ToolStatus::Occluded
            },
            pose,
            opening: 0.0,
        });
    }
    push(&mut log, &ToolStates { tools });
    let push_depth = (t * 0.8).sin();
    if push_depth > 0.6 {
        let force = 0.09 * (push_depth - 0.6) * (1.2 + 0.3 * (t * 9.0).sin());
        push(
            &mut log,
            &ContactForces {
                contacts: vec![ContactForce {
                    partner: "right".into(),
                    body: "strip".into(),
                    force: [0.0, 0.0, -force],
                    peak_force: 1.3 * force,
                    impulse: force * TICK,
                    point: [0.0; 3],
                    depth: 2e-5,
                    indentation: 5e-4,
                    ..ContactForce::default()
                }],
                ..ContactForces::default()
            },
        );
    }
    if tick % 530 == 260 {
        let number = tick / 530 + 1;
        push(
            &mut log,
            &LevelEvent {
                id: "target-done".into(),
                time: t,
                text: text(
                    &format!("Kugel {number} getroffen und gehalten."),
                    &format!("Sphere {number} touched and held."),
                ),
            },
        );
        push(
            &mut log,
            &LevelState {
                phase: LevelPhase::Running,
                running: t,
                targets_done: number as u32,
                targets: 5,
            },
        );
    }
    log
}

fn metric(
    id: &str,
    title: LocalText,
    (unit, factor): (&str, f64),
    value: Option<f64>,
    (min, max): (Option<f64>, Option<f64>),
    advice: LocalText,
) -> MetricRecord {
    let limited = min.is_some() || max.is_some();
    let within = value
        .filter(|_| limited)
        .map(|v| min.is_none_or(|min| v >= min) && max.is_none_or(|max| v <= max));
    MetricRecord {
        id: id.into(),
        title,
        unit: "SI".into(),
        display_unit: unit.into(),
        display_factor: factor,
        direction: match (min, max) {
            (None, None) => "informative",
            (Some(_), _) => "higher-is-better",
            _ => "lower-is-better",
        }
        .into(),
        category: "efficiency".into(),
        formula: format!("{id}/1"),
        source: "invented for this page".into(),
        advice,
        value,
        not_applicable: value
            .is_none()
            .then(|| text("zu wenige Messwerte je Sekunde", "too few samples a second")),
        limit: limited.then(|| LimitRecord {
            min,
            max,
            source: "set by judgement".into(),
            provisional: id != "time",
            decides: id != "tremor",
        }),
        within,
        score: within.map(|within| if within { 84.0 } else { 31.0 }),
    }
}

fn result(passed: bool) -> TrainingResult {
    let force = if passed { 0.043 } else { 0.0571 };
    TrainingResult {
        passed,
        aborted: false,
        not_judged: vec![],
        failed: if passed {
            vec![]
        } else {
            vec!["pushed-too-hard".into()]
        },
        reasons: if passed {
            vec![]
        } else {
            vec![text(
                "Das Instrument hat mit mehr als 50 mN auf das Gewebe gedrückt.",
                "The instrument pressed on the tissue with more than 50 mN.",
            )]
        },
        duration: 58.3,
        targets_done: 5,
        targets: 5,
        metrics: vec![
            metric(
                "time",
                text("Zeit", "Time"),
                ("s", 1.0),
                Some(58.3),
                (None, Some(90.0)),
                text(
                    "Legen Sie die Reihenfolge der Schritte fest, bevor Sie beginnen.",
                    "Decide on the order of the steps before you begin.",
                ),
            ),
            metric(
                "peak-force",
                text("Größte Kraft", "Peak force"),
                ("mN", 1e3),
                Some(force),
                (None, Some(0.05)),
                text(
                    "Nähern Sie sich langsam und lassen Sie das Gewebe nachgeben.",
                    "Approach slowly and let the tissue give way.",
                ),
            ),
            metric(
                "sparc",
                text("Glattheit (SPARC)", "Smoothness (SPARC)"),
                ("", 1.0),
                Some(-2.31),
                (Some(-3.0), None),
                text(
                    "Beschleunigen und bremsen Sie gleichmäßig.",
                    "Speed up and slow down evenly.",
                ),
            ),
            metric(
                "tremor",
                text("Tremor (8–12 Hz)", "Tremor (8–12 Hz)"),
                ("µm", 1e6),
                None,
                (None, Some(8e-5)),
                text(
                    "Lege Handkante und Unterarm auf.",
                    "Rest the edge of the hand and the forearm.",
                ),
            ),
            metric(
                "path-length",
                text("Weglänge", "Path length"),
                ("mm", 1e3),
                Some(0.2874),
                (None, None),
                text(
                    "Führen Sie die Spitze auf direktem Weg zum Ziel.",
                    "Take the tip to the target directly.",
                ),
            ),
        ],
        categories: vec![
            CategoryScore {
                id: "target-achievement".into(),
                title: text("Zielerreichung", "Target achievement"),
                score: 100.0,
            },
            CategoryScore {
                id: "efficiency".into(),
                title: text("Effizienz", "Efficiency"),
                score: 84.0,
            },
            CategoryScore {
                id: "tissue-treatment".into(),
                title: text("Gewebebehandlung", "Tissue treatment"),
                score: if passed { 76.0 } else { 31.0 },
            },
        ],
        score: if passed { 86.7 } else { 71.7 },
    }
}

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "report.html".into());
    let ending = arguments.next().unwrap_or_else(|| "failed".into());
    let mut ticks: Vec<(u64, Vec<u8>)> = (0..2920).map(|k| (k, tick(k))).collect();
    let mut input = ReportInput {
        version: "0.1.0".into(),
        started: 1_760_000_000,
        trainee: Some("Dr. A. Beispiel".into()),
        module: "push-strip".into(),
        module_title: text("Gewebe eindrücken", "Push the strip"),
        level: 1,
        level_title: text("Langsam und flach", "Slow and shallow"),
        level_summary: text(
            "Drücken Sie den Streifen bis zur Marke, ohne ihn zu verletzen.",
            "Push the strip down to the mark without hurting it.",
        ),
        seed: 42,
        tick_s: TICK,
        input: "script:scripts/level1.toml".into(),
        state_hash: Some("9f2c4be07a5d1e3386c0d4".into()),
        session_file: "demo.session".into(),
        replay_command: "microsim replay demo.session --verify".into(),
        ..ReportInput::default()
    };
    if ending == "incomplete" {
        ticks.truncate(1700);
        input.state_hash = None;
        input.complaint = Some("the file ends in the middle of a record, at byte 81234".into());
        input.without = vec!["physics".into()];
        let log = Log {
            level: LogLevel::Warn,
            text: "the device reports at 50 Hz, 60 Hz are needed for tremor".into(),
        };
        ticks[9].1.extend({
            let mut out = Vec::new();
            push(&mut out, &log);
            out
        });
    } else {
        push(&mut ticks[2919].1, &result(ending == "passed"));
    }
    let report = Report::build(&input, ticks.iter().map(|(tick, log)| (*tick, &log[..])));
    let page = Page {
        language: Language::English,
        pictures: Pictures::Missing(text("die Daten sind erfunden.", "the data are invented.")),
    };
    std::fs::write(file, report.to_html(&page))
}
