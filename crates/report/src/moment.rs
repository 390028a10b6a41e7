//! What happened when: grips, cuts, tears, pieces that come off, too much force, and what the module reports.
//!
//! Found from the messages alone. What happens tick after tick is one moment; it has ended when it has not happened for
//! [`PAUSE`]. Where a module reports something of the same kind at the same time (an event whose id has the word of the
//! kind in it, such as `stray-cut`), its words are more precise, and of the two they stay.

use crate::ReportInput;
use crate::number::shown;
use crate::text::in_both;
use microsim_message::{
    ContactForces, GRIP_MIN, LevelEvent, LevelPhase, LevelState, LocalText, TissueCut,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;

/// Time without anything of a kind that separates two moments of it \[s\].
const PAUSE: f64 = 0.25;

/// What kind of moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MomentKind {
    /// The level begins.
    Begin,
    /// A tool gets tissue between its jaws.
    Grip,
    /// A tool cuts.
    Cut,
    /// Tissue tears by itself.
    Tear,
    /// A body comes apart.
    PieceOff,
    /// A force beyond the limit of its pair.
    ExcessForce,
    /// The largest force of the session.
    LargestForce,
    /// An event of the module.
    Event,
    /// The session ends.
    End,
}

impl MomentKind {
    /// The words of which one is in the ids of a module's events that report the same. Tissue that comes apart where a target is reached
    /// does so as it should.
    fn words(self) -> &'static [&'static str] {
        match self {
            Self::Grip => &["grip"],
            Self::Cut => &["cut"],
            Self::Tear => &["tear"],
            Self::PieceOff => &["piece", "target"],
            Self::ExcessForce => &["excess"],
            Self::Begin | Self::LargestForce | Self::Event | Self::End => &[],
        }
    }
}

/// The class of the style sheet that gives a kind its colour.
pub(crate) fn kind_class(kind: MomentKind) -> &'static str {
    match kind {
        MomentKind::Begin | MomentKind::End => "k-bound",
        MomentKind::Grip => "k-grip",
        MomentKind::Cut | MomentKind::PieceOff => "k-cut",
        MomentKind::Tear => "k-tear",
        MomentKind::ExcessForce | MomentKind::LargestForce => "k-force",
        MomentKind::Event => "k-event",
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// What kind.
    pub kind: MomentKind,
    /// Simulated time since the session began \[s\].
    pub session_time: f64,
    /// The tick that shows it best: of what lasts, the last one.
    pub tick: u64,
    /// One sentence.
    pub text: LocalText,
    /// Id of the module's event.
    pub event: Option<String>,
}

/// Something that may last.
struct Lasting {
    /// Its place in the list.
    at: usize,
    /// When it happened last \[s\].
    last: f64,
}

/// Gathers the moments.
pub(crate) struct MomentCollector<'a> {
    session: &'a ReportInput,
    moments: Vec<Moment>,
    /// What goes on: kind, tool and body; of events their ids and texts.
    lasting: BTreeMap<(MomentKind, String, String), Lasting>,
    /// The largest force so far \[N\], its tick, its time \[s\], tool and body.
    largest: Option<(f64, u64, f64, String, String)>,
    running: bool,
}

impl<'a> MomentCollector<'a> {
    pub fn new(session: &'a ReportInput) -> Self {
        Self {
            session,
            moments: Vec::new(),
            lasting: BTreeMap::new(),
            largest: None,
            running: false,
        }
    }

    pub fn add_state(&mut self, tick: u64, now: f64, state: &LevelState) {
        if state.phase == LevelPhase::Running && !self.running {
            self.running = true;
            let text = in_both("Beginn", "Start");
            self.add(MomentKind::Begin, tick, now, text, None);
        }
    }

    pub fn add_event(&mut self, tick: u64, now: f64, event: &LevelEvent) {
        let key = (
            MomentKind::Event,
            event.id.clone(),
            event.text.en.to_string(),
        );
        if self.goes_on(&key, now).is_none() {
            self.begins(key, now);
            let (text, id) = (event.text.clone(), Some(event.id.clone()));
            self.add(MomentKind::Event, tick, now, text, id);
        }
    }

    pub fn add_forces(&mut self, tick: u64, now: f64, forces: &ContactForces) {
        for contact in &forces.contacts {
            let (tool, body) = (&contact.partner, &contact.body);
            if contact.grip_force >= GRIP_MIN && !self.session.sharp.contains(tool) {
                self.happens(MomentKind::Grip, tick, now, tool, body);
            }
            if contact.time_over_limit > 0.0 {
                self.happens(MomentKind::ExcessForce, tick, now, tool, body);
            }
            // Sessions of before have no sustained forces.
            let force = match contact.sustained_force > 0.0 {
                true => contact.sustained_force,
                false => contact.peak_force,
            };
            if force > self.largest.as_ref().map_or(0.0, |largest| largest.0) {
                self.largest = Some((force, tick, now, tool.clone(), body.clone()));
            }
        }
    }

    pub fn add_cut(&mut self, tick: u64, now: f64, cut: &TissueCut) {
        let kind = match cut.tool.is_empty() {
            true => MomentKind::Tear,
            false => MomentKind::Cut,
        };
        self.happens(kind, tick, now, &cut.tool, &cut.body);
        if !cut.pieces.is_empty() {
            self.happens(MomentKind::PieceOff, tick, now, &cut.tool, &cut.body);
        }
    }

    /// All moments in the order of time, with the end after the last tick.
    pub fn finish(mut self, ticks_end: u64, end: f64) -> Vec<Moment> {
        if let Some((force, tick, now, tool, body)) = self.largest.take() {
            let millinewtons = shown(force * 1e3, "mN");
            let (tool, body) = (self.session.tool_name(&tool), self.session.body_name(&body));
            let text = LocalText::new(
                format!(
                    "Größte Kraft: {}, {} auf {}",
                    millinewtons.de, tool.de, body.de
                ),
                format!(
                    "Largest force: {}, {} on {}",
                    millinewtons.en, tool.en, body.en
                ),
            );
            self.add(MomentKind::LargestForce, tick, now, text, None);
        }
        if let Some(last) = ticks_end.checked_sub(1) {
            let text = in_both("Ende", "End");
            self.add(MomentKind::End, last, end, text, None);
        }
        let mut moments = without_doubles(self.moments);
        moments.sort_by(|a, b| a.session_time.total_cmp(&b.session_time));
        moments
    }

    fn add(
        &mut self,
        kind: MomentKind,
        tick: u64,
        session_time: f64,
        text: LocalText,
        event: Option<String>,
    ) {
        self.moments.push(Moment {
            kind,
            session_time,
            tick,
            text,
            event,
        });
    }

    /// The moment that happens still, if it does.
    fn goes_on(&mut self, key: &(MomentKind, String, String), now: f64) -> Option<usize> {
        let lasting = self.lasting.get_mut(key)?;
        let still = now - lasting.last <= PAUSE;
        lasting.last = now;
        still.then_some(lasting.at)
    }

    /// The moment that is added next begins.
    fn begins(&mut self, key: (MomentKind, String, String), now: f64) {
        let at = self.moments.len();
        self.lasting.insert(key, Lasting { at, last: now });
    }

    fn happens(&mut self, kind: MomentKind, tick: u64, now: f64, tool: &str, body: &str) {
        let key = (kind, tool.to_owned(), body.to_owned());
        if let Some(at) = self.goes_on(&key, now) {
            // A grip is seen at once; a cut when it is done.
            if kind != MomentKind::Grip {
                self.moments[at].tick = tick;
            }
            return;
        }
        self.begins(key, now);
        let LocalText { de, en } = self.session.tool_name(tool);
        let body = self.session.body_name(body);
        let text = match kind {
            MomentKind::Grip => in_both(
                &format!("{de} schließt sich um {}", body.de),
                &format!("{en} closes on {}", body.en),
            ),
            MomentKind::Cut => in_both(
                &format!("{de} schneidet {}", body.de),
                &format!("{en}: a cut in {}", body.en),
            ),
            MomentKind::Tear => in_both(
                &format!("{} reißt", body.de),
                &format!("The {} tears", body.en),
            ),
            MomentKind::PieceOff => in_both(
                &format!("{} ist durchtrennt", body.de),
                &format!("The {} has come apart", body.en),
            ),
            _ => in_both(
                &format!("Zu viel Kraft: {de} auf {}", body.de),
                &format!("Too much force: {en} on {}", body.en),
            ),
        };
        self.add(kind, tick, now, text, None);
    }
}

/// What the messages show is dropped where the module reports the same within [`PAUSE`]: the nearest of its events takes over kind and tick, of
/// several kinds the most telling one and of several ticks the last.
fn without_doubles(mut moments: Vec<Moment>) -> Vec<Moment> {
    let mut doubles = Vec::new();
    for (at, shown) in moments.iter().enumerate() {
        let words = shown.kind.words();
        let apart = |reported: &Moment| (reported.session_time - shown.session_time).abs();
        let same = moments.iter().enumerate().filter(|(_, reported)| {
            let id = reported.event.as_deref().unwrap_or_default();
            id.split('-').any(|part| words.contains(&part)) && apart(reported) <= PAUSE
        });
        let reported = same.min_by(|(_, a), (_, b)| apart(a).total_cmp(&apart(b)));
        doubles.extend(reported.map(|(reported, _)| (at, reported)));
    }
    let rank = |kind| TELLING.iter().position(|telling| *telling == kind);
    for &(shown, reported) in &doubles {
        let Moment { kind, tick, .. } = moments[shown];
        let reported = &mut moments[reported];
        if reported.kind == MomentKind::Event || rank(kind) < rank(reported.kind) {
            reported.kind = kind;
        }
        reported.tick = reported.tick.max(tick);
    }
    let mut at = 0..moments.len();
    moments.retain(|_| {
        let at = at.next();
        !doubles.iter().any(|(shown, _)| Some(*shown) == at)
    });
    moments
}

/// The lines of the list: moments of the same time are one, with one number. Ranges of `moments`, which are in the order of time.
pub(crate) fn lines(moments: &[Moment]) -> Vec<Range<usize>> {
    let mut from = 0;
    let same = moments.chunk_by(|a, b| a.session_time == b.session_time);
    same.map(|line| {
        let range = from..from + line.len();
        from = range.end;
        range
    })
    .collect()
}

/// Kinds, the most telling ones first.
const TELLING: [MomentKind; 9] = [
    MomentKind::Begin,
    MomentKind::End,
    MomentKind::PieceOff,
    MomentKind::Cut,
    MomentKind::Tear,
    MomentKind::LargestForce,
    MomentKind::Event,
    MomentKind::Grip,
    MomentKind::ExcessForce,
];

/// The kind that gives a line its colour: the most telling one.
pub(crate) fn line_kind(line: &[Moment]) -> MomentKind {
    let mut kinds = TELLING.into_iter();
    let found = kinds.find(|kind| line.iter().any(|moment| moment.kind == *kind));
    found.unwrap_or(MomentKind::Event)
}

/// Those of which a page shows pictures: at most `most` pictures, the most telling kinds first, of each kind the first ones; in the
/// order of time. Moments within [`PAUSE`] of each other have one picture. Indices into `moments`, each with the tick of its picture.
pub(crate) fn key_moments(moments: &[Moment], most: usize) -> Vec<(usize, u64)> {
    let mut chosen: Vec<(usize, u64)> = Vec::new();
    // Tick and time of each.
    let mut pictures: Vec<(u64, f64)> = Vec::new();
    // The first of each kind before the second of any.
    let of = |kind: MomentKind| {
        let all = moments.iter().enumerate();
        all.filter(move |(_, m)| m.kind == kind).map(|(at, _)| at)
    };
    for rank in 0..moments.len() {
        for at in TELLING.iter().filter_map(|kind| of(*kind).nth(rank)) {
            let Moment {
                tick, session_time, ..
            } = moments[at];
            let near =
                |(of, time): &&(u64, f64)| *of == tick || (time - session_time).abs() <= PAUSE;
            if let Some((picture, _)) = pictures.iter().find(near) {
                chosen.push((at, *picture));
            } else if pictures.len() < most {
                pictures.push((tick, session_time));
                chosen.push((at, tick));
            }
        }
    }
    chosen.sort_unstable();
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Report;
    use crate::testing::{contact, input, log, text};

    fn kinds(report: &Report) -> Vec<(MomentKind, f64, u64)> {
        let moments = report.moments.iter();
        moments.map(|m| (m.kind, m.session_time, m.tick)).collect()
    }

    fn squeezed(force: [f64; 3], over_limit: f64) -> ContactForces {
        let mut contact = contact("left", "strip", force);
        contact.grip_force = 0.01;
        contact.peak_force = force[2];
        contact.time_over_limit = over_limit;
        ContactForces {
            contacts: vec![contact],
            ..ContactForces::default()
        }
    }

    fn cut(tool: &str, pieces: &[u32]) -> TissueCut {
        TissueCut {
            body: "strip".into(),
            tool: tool.into(),
            pieces: pieces.to_vec(),
            ..TissueCut::default()
        }
    }

    /// Ticks of 1/8 s: with one tick between them two grips are one, with three between them they are two. A cut of two ticks is one,
    /// at its first tick and best seen at its last; the largest force is in tick 5.
    #[test]
    fn what_lasts_is_one_moment() {
        let running = LevelState {
            phase: LevelPhase::Running,
            ..LevelState::default()
        };
        let reported = LevelEvent {
            id: "target-done".into(),
            time: 1.0,
            text: text("Done."),
        };
        let ticks = [
            (0, log(&[&running])),
            (1, log(&[&squeezed([0.0, 0.0, 0.01], 0.0)])),
            (3, log(&[&squeezed([0.0, 0.0, 0.02], 0.0)])),
            (4, log(&[&cut("right", &[])])),
            (
                5,
                log(&[&cut("right", &[1]), &squeezed([0.0, 0.0, 0.05], 0.1)]),
            ),
            (9, log(&[&squeezed([0.0, 0.0, 0.01], 0.0), &cut("", &[])])),
            (10, log(&[&reported])),
            (11, log(&[&reported])),
        ];
        let report = Report::build(&input(), ticks.iter().map(|(tick, log)| (*tick, &log[..])));
        assert_eq!(
            kinds(&report),
            [
                (MomentKind::Begin, 0.0, 0),
                (MomentKind::Grip, 0.125, 1),
                (MomentKind::Cut, 0.5, 5),
                (MomentKind::PieceOff, 0.625, 5),
                (MomentKind::ExcessForce, 0.625, 5),
                (MomentKind::LargestForce, 0.625, 5),
                (MomentKind::Grip, 1.125, 9),
                (MomentKind::Tear, 1.125, 9),
                (MomentKind::Event, 1.25, 10),
                (MomentKind::End, 1.5, 11),
            ]
        );
        assert!(
            report.moments[5].text.en.contains("50.0\u{a0}mN"),
            "{:?}",
            report.moments[5]
        );
    }

    /// What the module reports of the same kind at the same time takes the place of what the messages show; moments of one time are one
    /// line of the list, in the colour of the most telling; a sharp tool does not grip.
    #[test]
    fn a_moment_is_told_once() {
        let reported = |id: &str| LevelEvent {
            id: id.into(),
            time: 0.0,
            text: text(id),
        };
        let mut both = squeezed([0.0, 0.0, 0.01], 0.1);
        let mut other = both.contacts[0].clone();
        other.partner = "right".into();
        both.contacts.push(other);
        let ticks = [
            (
                1,
                log(&[&both, &reported("grip"), &reported("excess-force")]),
            ),
            (
                5,
                log(&[
                    &cut("right", &[1]),
                    &reported("stray-cut"),
                    &reported("target-done"),
                ]),
            ),
        ];
        let session = ReportInput {
            sharp: ["right".to_owned()].into(),
            bodies: vec!["strip".into()],
            ..input()
        };
        let report = Report::build(&session, ticks.iter().map(|(tick, log)| (*tick, &log[..])));
        let kinds: Vec<_> = report
            .moments
            .iter()
            .map(|m| (m.kind, m.session_time, &m.text.en[..]))
            .collect();
        assert_eq!(
            kinds,
            [
                (MomentKind::Grip, 0.125, "grip"),
                (MomentKind::ExcessForce, 0.125, "excess-force"),
                (
                    MomentKind::LargestForce,
                    0.125,
                    "Largest force: 10.0\u{a0}mN, left on tissue"
                ),
                (MomentKind::Cut, 0.625, "stray-cut"),
                (MomentKind::PieceOff, 0.625, "target-done"),
                (MomentKind::End, 0.75, "End"),
            ]
        );
        let lines = lines(&report.moments);
        assert_eq!(lines, [0..3, 3..5, 5..6]);
        assert_eq!(line_kind(&report.moments[0..3]), MomentKind::LargestForce);
        assert_eq!(line_kind(&report.moments[3..5]), MomentKind::PieceOff);
    }

    /// Ticks of 1/8 s. Two tools cut one tick after the other, and the module reports each: every cut goes to the event of its
    /// own time, whose picture is of its last tick. An event of a cut that has freed a piece is of the more telling kind.
    #[test]
    fn a_moment_is_told_by_the_nearest_event_and_by_its_most_telling_kind() {
        let reported = |id: &str| LevelEvent {
            id: id.into(),
            time: 0.0,
            text: text(id),
        };
        let ticks = [
            (3, log(&[&cut("left", &[]), &reported("cut")])),
            (4, log(&[&cut("right", &[]), &reported("stray-cut")])),
            (5, log(&[&cut("right", &[])])),
            (9, log(&[&cut("left", &[1]), &reported("cut-piece")])),
        ];
        let report = Report::build(&input(), ticks.iter().map(|(tick, log)| (*tick, &log[..])));
        assert_eq!(
            kinds(&report),
            [
                (MomentKind::Cut, 0.375, 3),
                (MomentKind::Cut, 0.5, 5),
                (MomentKind::PieceOff, 1.125, 9),
                (MomentKind::End, 1.25, 9),
            ]
        );
    }

    /// Six grips and one cut in four pictures: begin and end do not fall out for grips, and the first grip comes before the second.
    #[test]
    fn the_most_telling_moments_are_chosen() {
        let moment = |kind, tick| Moment {
            kind,
            session_time: tick as f64,
            tick,
            text: text("-"),
            event: None,
        };
        let mut moments: Vec<Moment> = (1..7).map(|t| moment(MomentKind::Grip, t)).collect();
        moments.insert(0, moment(MomentKind::Begin, 0));
        moments.push(moment(MomentKind::Cut, 8));
        moments.push(moment(MomentKind::End, 9));
        let key = |moments: &[Moment], most| -> Vec<usize> {
            key_moments(moments, most)
                .iter()
                .map(|(at, _)| *at)
                .collect()
        };
        assert_eq!(key(&moments, 4), [0, 1, 7, 8]);
        assert_eq!(key(&moments, 5), [0, 1, 2, 7, 8]);
        assert_eq!(key(&moments, 99).len(), 9);
        // What happens in the same tick, or almost, is in the same picture.
        moments.push(moment(MomentKind::LargestForce, 8));
        moments.push(moment(MomentKind::Tear, 82));
        moments[10].session_time = 8.2;
        assert_eq!(
            key_moments(&moments, 4),
            [(0, 0), (1, 1), (7, 8), (8, 9), (9, 8), (10, 8)]
        );
    }
}
