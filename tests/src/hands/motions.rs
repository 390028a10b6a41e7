//! How each profile moves a hand.
//!
//! Ranges are set by judgement, so that each profile does what it is named for; those of calm ones are of the size of published hands where
//! they are stated (`crates/DOMAIN.md`, 1), those of others are far beyond on purpose.

use super::hand::Hand;
use super::stage::Pose;
use super::{Player, Profile};
use microsim_random::SplitMix64;
use nalgebra::Vector3;

const MM: f64 = 1e-3;

/// How long blades that snip stay closed \[s\].
const CLOSED: f64 = 0.032;

/// How far above the tissue tools move on from place to place \[m\].
const ABOVE: [f64; 2] = [3.0 * MM, 7.0 * MM];

/// Moves a hand until the end of its player's script; gives what disturbs its samples.
pub fn move_hand(hand: &mut Hand<'_>, player: &Player) -> Disturbance {
    // Every tool of a player takes the same of both ways.
    let mut common = player.random(0);
    let follows = |share: u64, common: &mut SplitMix64| common.below(share) == 0;
    match player.profile {
        Profile::Calm if follows(2, &mut common) => hand.follow(1.0, 0.05 * MM, 0.01),
        Profile::Jittery if follows(2, &mut common) => hand.follow(1.0, 0.05 * MM, 0.01),
        Profile::Outliers if follows(2, &mut common) => hand.follow(1.0, 0.05 * MM, 0.01),
        Profile::Clumsy if follows(3, &mut common) => hand.follow(1.3, 0.7 * MM, 0.15),
        _ => {}
    }
    while hand.time() < player.seconds {
        match player.profile {
            Profile::Calm | Profile::Jittery | Profile::Outliers => touch(hand),
            Profile::Clumsy => fumble(hand),
            Profile::Violent => thrust(hand),
            Profile::Closing => close(hand),
            Profile::Stabbing => stab(hand),
            Profile::Dragging => drag(hand),
            Profile::Snipping => snip(hand),
            Profile::Swapping => cross(hand, &mut common),
        }
    }
    match player.profile {
        Profile::Jittery => Disturbance::tremor(hand),
        Profile::Outliers => Disturbance::tracker(hand, player.seconds),
        _ => Disturbance::None,
    }
}

/// To above a new place; the place.
fn approach(hand: &mut Hand<'_>, time: [f64; 2]) -> Pose {
    let target = hand.target();
    let above = hand.between(ABOVE[0], ABOVE[1]);
    hand.go(target.back(above), time);
    target
}

/// Reaches for a place, grips, cuts or presses a little there, lets go.
fn touch(hand: &mut Hand<'_>) {
    let target = approach(hand, [0.5, 1.0]);
    hand.go(target, [0.5, 1.0]);
    hand.act();
    if hand.tool.jaws {
        hand.open(hand.tool.grip, [0.5, 1.0]);
        hand.drift([0.0, 0.5 * MM], [0.5, 1.0]);
        hand.stay([0.2, 1.0]);
        hand.open(hand.tool.open, [0.3, 0.6]);
    } else {
        hand.go(target.back(-0.3 * MM), [0.3, 0.8]);
        hand.stay([0.2, 1.0]);
    }
    let above = hand.between(ABOVE[0], ABOVE[1]);
    hand.go(hand.pose().back(above), [0.4, 0.8]);
}

/// Comes from anywhere, misses, turns, closes anyhow, and goes on.
fn fumble(hand: &mut Hand<'_>) {
    let turn = hand.random.vector() * 0.35;
    let miss = hand.random.vector() * (1.5 * MM);
    let target = approach(hand, [0.2, 0.6]).shifted(miss).turned(turn);
    hand.go(target, [0.2, 0.6]);
    hand.act();
    for _ in 0..1 + hand.random.below(3) {
        let opening = hand.between(0.0, 1.0);
        hand.open(opening, [0.1, 0.5]);
        hand.drift([0.2 * MM, 2.0 * MM], [0.1, 0.6]);
    }
    if hand.chance(0.5) {
        // Without letting go first.
        hand.go(hand.pose().back(2.0 * MM), [0.2, 0.5]);
    }
    hand.open(hand.tool.open, [0.1, 0.3]);
}

/// Through the tissue, closed at once, away with it, and across.
fn thrust(hand: &mut Hand<'_>) {
    let target = approach(hand, [0.15, 0.4]);
    let depth = hand.between(1.0 * MM, 5.0 * MM);
    hand.go(target.back(-depth), [0.03, 0.1]);
    hand.act();
    hand.open(0.0, [0.03, 0.1]);
    hand.drift([4.0 * MM, 12.0 * MM], [0.05, 0.2]);
    hand.stay([0.0, 0.3]);
    hand.open(hand.tool.open, [0.03, 0.1]);
    hand.go(target.back(-0.5 * depth), [0.1, 0.2]);
    hand.drift([3.0 * MM, 8.0 * MM], [0.05, 0.2]);
}

/// Closed completely on tissue, and moved so; the next place is close by.
fn close(hand: &mut Hand<'_>) {
    let target = approach(hand, [0.3, 0.6]);
    hand.go(target, [0.3, 0.6]);
    if !hand.tool.jaws {
        hand.stay([0.5, 1.5]);
        return;
    }
    for _ in 0..1 + hand.random.below(4) {
        hand.open(0.0, [0.05, 0.5]);
        hand.act();
        hand.stay([0.2, 1.5]);
        hand.drift([0.2 * MM, 1.5 * MM], [0.2, 0.8]);
        hand.open(hand.tool.open, [0.1, 0.4]);
        let near = hand.random.vector() * MM;
        hand.go(target.shifted(near), [0.1, 0.4]);
    }
}

/// In and out at one to three times a second, with the jaws closed or not.
fn stab(hand: &mut Hand<'_>) {
    let opening = if hand.chance(0.7) {
        0.0
    } else {
        hand.tool.open
    };
    let target = approach(hand, [0.3, 0.6]).opened(opening);
    let half = 0.5 / hand.between(1.0, 3.0);
    for _ in 0..3 + hand.random.below(5) {
        let near = target.shifted(hand.random.vector() * MM);
        let depth = hand.between(0.3 * MM, 3.0 * MM);
        hand.go(near.back(-depth), [half, half]);
        hand.act();
        let above = hand.between(1.0 * MM, 4.0 * MM);
        hand.go(near.back(above), [half, half]);
    }
}

/// Grips or presses, drags to the side, and lets go there or after coming back.
fn drag(hand: &mut Hand<'_>) {
    let target = approach(hand, [0.3, 0.6]);
    hand.go(target, [0.3, 0.6]);
    if hand.tool.jaws {
        let share = if hand.chance(0.3) {
            0.0
        } else {
            hand.between(0.5, 1.0)
        };
        hand.open(share * hand.tool.grip, [0.2, 0.4]);
    } else {
        let depth = hand.between(0.3 * MM, 1.0 * MM);
        hand.go(target.back(-depth), [0.2, 0.4]);
    }
    let from = hand.pose();
    hand.drift([2.0 * MM, 8.0 * MM], [0.3, 1.2]);
    hand.act();
    hand.stay([0.0, 0.4]);
    if hand.chance(0.5) {
        hand.go(from, [0.3, 1.0]);
    }
    hand.open(hand.tool.open, [0.1, 0.3]);
}

/// Opens and closes one to eight times a second while it moves from one place to another.
fn snip(hand: &mut Hand<'_>) {
    if !hand.tool.jaws {
        return touch(hand);
    }
    let from = approach(hand, [0.3, 0.6]);
    let to = hand.target();
    hand.go(from.opened(1.0), [0.3, 0.6]);
    let rate = hand.between(1.0, 8.0);
    let half = 0.5 / rate;
    let count = (rate * hand.between(2.0, 4.0)) as u32;
    for snip in 1..=count {
        let way = f64::from(snip) / f64::from(count);
        let place = from.mixed(&to, way, way).opened(1.0);
        let place = place.shifted(hand.random.vector() * (0.3 * MM));
        // Closed for two samples, so that one of them is.
        let closing = (half - CLOSED).max(0.5 * half);
        hand.go(place.opened(0.0), [closing, closing]);
        hand.act();
        hand.stay([half - closing, half - closing]);
        hand.go(place, [half, half]);
    }
}

/// Both tools to one place, each from its own side, then each to the other's side; `common` is the same for both.
fn cross(hand: &mut Hand<'_>, common: &mut SplitMix64) {
    let unit = |random: &mut SplitMix64| 0.5 * (random.number() + 1.0);
    let [reach, pass, rest] = [(); 3].map(|()| 0.3 + 0.7 * unit(common));
    let along = common.number();
    let place = match hand.stage.tissue {
        Some([centre, half]) => {
            let mut place = centre;
            place[half.imax()] += 0.7 * half.max() * along;
            place
        }
        None => Vector3::zeros(),
    };
    // The first tool comes from the left, the second from the right.
    let side = if hand.number.is_multiple_of(2) {
        -1.0
    } else {
        1.0
    };
    let aside = Vector3::x() * (side * 4.0 * MM);
    let target = hand.target();
    let at = Pose {
        position: place,
        ..target
    };
    hand.go(at.shifted(aside), [reach, reach]);
    hand.go(at, [pass, pass]);
    hand.act();
    // Both grip or cut where they meet.
    let opening = hand.tool.grip;
    hand.open(opening, [0.2, 0.2]);
    hand.go(at.shifted(-aside).opened(opening), [pass, pass]);
    hand.stay([rest, rest]);
    hand.open(hand.tool.open, [0.2, 0.2]);
    // And back through each other.
    hand.go(at.shifted(aside), [pass, pass]);
    hand.act();
}

/// What is wrong with the samples of a tool.
#[derive(Clone, Debug)]
pub enum Disturbance {
    /// Nothing.
    None,
    /// Tremor, and noise of each sample.
    Tremor {
        /// Frequency \[Hz\], phase \[rad\] and amplitude \[m\] of each wave.
        waves: Vec<(f64, Vector3<f64>, Vector3<f64>)>,
        /// Of the noise.
        random: SplitMix64,
        /// Of its positions \[m\].
        noise: f64,
    },
    /// Bad samples.
    Tracker {
        /// What happens when.
        faults: Vec<Fault>,
        /// Times of bad samples, jumps and gaps so far \[s\].
        bad: Vec<f64>,
    },
}

/// A fault of a tracker.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    /// When it begins \[s\].
    from: f64,
    /// How long it lasts \[s\].
    lasts: f64,
    /// Where the tool seems to be, from where it is \[m\].
    by: Vector3<f64>,
    /// How it seems to be turned \[rad\].
    turn: Vector3<f64>,
    /// Instead of the opening.
    opening: Option<f64>,
    /// Whether it is seen.
    visible: bool,
}

impl Disturbance {
    /// Up to 0.5 mm at 6 to 12 Hz, ten times the 49 µm of a hand at rest (Riviere 1997), and up to 0.1 mm of noise.
    fn tremor(hand: &mut Hand<'_>) -> Self {
        let size = hand.between(0.05 * MM, 0.5 * MM);
        let wave = |hand: &mut Hand<'_>| {
            let frequency = hand.between(6.0, 12.0);
            let phase = hand.random.vector() * std::f64::consts::PI;
            let amplitude = hand.random.vector() * (0.6 * size);
            (frequency, phase, amplitude)
        };
        Self::Tremor {
            waves: (0..3).map(|_| wave(hand)).collect(),
            noise: hand.between(0.0, 0.1 * MM),
            random: hand.random.clone(),
        }
    }

    /// One fault in 0.5 to 2 s: mostly a single sample 1 mm to 0.5 m off, else a jump that stays for up to half a second, or a gap.
    fn tracker(hand: &mut Hand<'_>, seconds: f64) -> Self {
        let mut faults = Vec::new();
        let mut time = hand.between(0.5, 2.0);
        while time < seconds {
            // Each size from 1 mm to 0.5 m as often as any other, on a logarithmic scale.
            let size = MM * libm::exp(hand.between(0.0, libm::log(500.0)));
            let by = hand.direction() * size;
            let kind = hand.between(0.0, 1.0);
            let turn = if kind < 0.3 {
                hand.random.vector()
            } else {
                Vector3::zeros()
            };
            let jump = kind > 0.8;
            let opening = (kind < 0.15).then(|| hand.between(0.0, 1.0).round());
            faults.push(Fault {
                from: time,
                lasts: if jump { hand.between(0.05, 0.5) } else { 1e-3 },
                by: if jump {
                    by * (20.0 * MM / size).min(1.0)
                } else {
                    by
                },
                turn,
                opening,
                visible: kind < 0.9,
            });
            time += hand.between(0.5, 2.0);
        }
        Self::Tracker {
            faults,
            bad: Vec::new(),
        }
    }

    /// The sample at a time, and whether the tool is seen. Times grow from call to call.
    pub fn apply(&mut self, time: f64, pose: Pose) -> (Pose, bool) {
        match self {
            Self::None => (pose, true),
            Self::Tremor {
                waves,
                random,
                noise,
            } => {
                let mut by = random.vector() * *noise;
                for (frequency, phase, amplitude) in waves.iter() {
                    let angle = 2.0 * std::f64::consts::PI * *frequency * time;
                    by += phase
                        .map(|phase| libm::sin(angle + phase))
                        .component_mul(amplitude);
                }
                // At 20 mm from the tip, where instruments are held: a tenth of a millimetre is 0.3°.
                let turn = random.vector() * (by.norm() / (20.0 * MM));
                let opening = pose.opening + 0.02 * random.number();
                (pose.shifted(by).turned(turn).opened(opening), true)
            }
            Self::Tracker { faults, bad } => {
                // The first sample from the beginning of a fault on has it, and all until its end.
                let begun = faults.iter().take_while(|fault| fault.from <= time).count();
                let Some(fault) = begun.checked_sub(1).map(|last| faults[last]) else {
                    return (pose, true);
                };
                let is_new = bad.len() < begun;
                if is_new {
                    bad.resize(begun, time);
                } else if time > fault.from + fault.lasts {
                    return (pose, true);
                }
                let pose = pose.shifted(fault.by).turned(fault.turn);
                let opening = fault.opening.unwrap_or(pose.opening);
                (pose.opened(opening), fault.visible)
            }
        }
    }
}
