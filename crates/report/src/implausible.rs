//! Samples that no hand makes: how many of which tool, when, and what of their motion was beyond the limits.

use crate::input::ReportInput;
use crate::number::shown;
use crate::text::in_both;
use microsim_message::{ImplausibleSample, LocalText, MotionLimit, ToolSample};
use serde::{Deserialize, Serialize};

/// The samples of a tool that no hand makes. They were left out: the tool was not tracked at their times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImplausibleRecord {
    /// Tool slot of the level.
    pub tool: String,
    /// How many.
    pub samples: u64,
    /// Sum of the durations of all stretches \[s\].
    pub duration: f64,
    /// The stretches in which they came, in the order of time.
    pub stretches: Vec<ImplausibleStretch>,
}

/// Samples that were left out one after another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImplausibleStretch {
    /// Simulated time since the session began, of the first of them \[s\].
    pub session_time: f64,
    /// How many.
    pub samples: u64,
    /// From the last sample that counted to the next one that does, by the device's clock \[s\]; without such as far as there are samples.
    pub duration: f64,
    /// What of the motion to the first of them was beyond the limits of a hand.
    pub limit: MotionLimit,
    /// The value, in the limit's unit.
    pub value: f64,
    /// The limit itself, in the same unit.
    pub bound: f64,
}

/// Gathers them, tools in the order of their first one.
#[derive(Default)]
pub(crate) struct ImplausibleCollector {
    tools: Vec<Tool>,
}

#[derive(Default)]
struct Tool {
    name: String,
    /// Time of the last sample that counted, by the device's clock.
    counted: Option<f64>,
    /// The stretch that has not ended, and where it began by the device's clock.
    open: Option<(f64, ImplausibleStretch)>,
    stretches: Vec<ImplausibleStretch>,
}

impl Tool {
    fn end(&mut self) {
        self.stretches.extend(self.open.take().map(|open| open.1));
    }
}

impl ImplausibleCollector {
    fn tool(&mut self, name: &str) -> &mut Tool {
        let at = self.tools.iter().position(|tool| tool.name == name);
        let at = at.unwrap_or_else(|| {
            self.tools.push(Tool {
                name: name.to_owned(),
                ..Tool::default()
            });
            self.tools.len() - 1
        });
        &mut self.tools[at]
    }

    pub fn add(&mut self, now: f64, sample: &ImplausibleSample) {
        let tool = self.tool(&sample.tool);
        let counted = tool.counted;
        let (since, stretch) = tool.open.get_or_insert_with(|| {
            let stretch = ImplausibleStretch {
                session_time: now,
                samples: 0,
                duration: 0.0,
                limit: sample.limit,
                // One that overflows is a number all the same, which JSON can state.
                value: sample.value.min(f64::MAX),
                bound: sample.bound,
            };
            (counted.unwrap_or(sample.device_time), stretch)
        });
        stretch.samples += 1;
        stretch.duration = (sample.device_time - *since).max(0.0);
    }

    pub fn add_sample(&mut self, sample: &ToolSample) {
        // One that is not tracked is no end: the translator publishes such for each that it leaves out.
        if !sample.tracked {
            return;
        }
        let tool = self.tool(&sample.tool);
        if let Some((since, stretch)) = &mut tool.open {
            stretch.duration = (sample.time - *since).max(0.0);
        }
        tool.end();
        tool.counted = Some(sample.time);
    }

    pub fn finish(self) -> Vec<ImplausibleRecord> {
        let records = self.tools.into_iter().map(|mut tool| {
            tool.end();
            ImplausibleRecord {
                tool: tool.name,
                samples: tool.stretches.iter().map(|stretch| stretch.samples).sum(),
                duration: tool.stretches.iter().map(|stretch| stretch.duration).sum(),
                stretches: tool.stretches,
            }
        });
        records.filter(|record| record.samples > 0).collect()
    }
}

impl ImplausibleRecord {
    /// How many samples of which tool, over which time.
    pub(crate) fn words(&self, session: &ReportInput) -> LocalText {
        let (tool, time) = (session.tool_name(&self.tool), shown(self.duration, "s"));
        in_both(
            &format!("{}: {} in {}", tool.de, self.samples, time.de),
            &format!("{}: {} in {}", tool.en, self.samples, time.en),
        )
    }
}

impl ImplausibleStretch {
    /// What was beyond which limit.
    pub(crate) fn words(&self) -> LocalText {
        let (de, en) = match self.limit {
            MotionLimit::Speed => ("Geschwindigkeit", "speed"),
            MotionLimit::Acceleration => ("Beschleunigung", "acceleration"),
            MotionLimit::TurnRate => ("Drehgeschwindigkeit", "speed of turning"),
            MotionLimit::OpeningRate => ("Öffnungsänderung", "change of opening"),
        };
        let unit = self.limit.unit();
        let [value, bound] = [self.value, self.bound].map(|number| shown(number, unit));
        in_both(
            &format!("{de} {}, Grenze {}", value.de, bound.de),
            &format!("{en} {}, limit {}", value.en, bound.en),
        )
    }
}

#[cfg(test)]
mod tests {
    use crate::Report;
    use crate::testing::{input, log};
    use microsim_message::{ImplausibleSample, MotionLimit, Pose, ToolSample};

    fn counted(time: f64) -> ToolSample {
        ToolSample {
            tool: "right".into(),
            time,
            tracked: true,
            pose: Pose::default(),
            opening: 0.0,
        }
    }

    fn elsewhere(time: f64) -> ImplausibleSample {
        ImplausibleSample {
            tool: "right".into(),
            device: "stylus".into(),
            device_time: time,
            limit: MotionLimit::Acceleration,
            value: 74.0,
            bound: 10.0,
        }
    }

    fn lost(time: f64) -> ToolSample {
        ToolSample {
            tracked: false,
            ..counted(time)
        }
    }

    /// By hand, with dyadic numbers: one between samples at 100.25 and 100.75 s, two after one at 101 s that nothing follows. Ticks of 1/8 s.
    #[test]
    fn stretches_last_from_what_counted_to_what_counts() {
        let logs = [
            (0, log(&[&counted(100.0), &counted(100.25)])),
            (4, log(&[&lost(100.5), &elsewhere(100.5)])),
            (6, log(&[&counted(100.75), &counted(101.0)])),
            (10, log(&[&lost(101.25), &elsewhere(101.25)])),
            (12, log(&[&lost(101.5), &elsewhere(101.5)])),
        ];
        let report = Report::build(&input(), logs.iter().map(|(tick, log)| (*tick, &log[..])));
        let [record] = &report.implausible[..] else {
            panic!("{:?}", report.implausible);
        };
        assert_eq!((record.samples, record.duration), (3, 1.0));
        let stretches = record.stretches.iter();
        let facts = stretches.map(|s| (s.session_time, s.samples, s.duration, s.value));
        assert_eq!(
            facts.collect::<Vec<_>>(),
            [(0.5, 1, 0.5, 74.0), (1.25, 2, 0.5, 74.0)]
        );
        // No speed across what was left out.
        assert_eq!(report.series[0].segment, [0, 0, 1, 1]);
        let text = report.left_out().expect("there were some");
        assert!(
            text.en.starts_with(
                "The tracker reported 3 samples that no hand makes; they were left out ("
            ),
            "{text:?}"
        );
        assert!(
            text.de.starts_with(
                "Der Tracker meldete 3 Messwerte, die keine Hand macht; sie wurden weggelassen ("
            ),
            "{text:?}"
        );
    }

    #[test]
    fn one_is_one_and_none_is_nothing() {
        let one = log(&[&counted(0.0), &elsewhere(0.25)]);
        let text = Report::build(&input(), [(0, &one[..])]).left_out();
        let text = text.expect("there was one");
        assert!(
            text.en
                .starts_with("The tracker reported 1 sample that no hand makes; it was left out"),
            "{text:?}"
        );
        assert!(
            text.de.starts_with(
                "Der Tracker meldete einen Messwert, den keine Hand macht; er wurde weggelassen"
            ),
            "{text:?}"
        );
        let none = log(&[&counted(0.0), &lost(0.25)]);
        let report = Report::build(&input(), [(0, &none[..])]);
        assert_eq!((report.implausible.len(), report.left_out()), (0, None));
    }
}
