//! One tool from place to place, and the script of all tools.

use super::Player;
use super::motions::{self, Disturbance};
use super::stage::{Pose, Stage, Tool};
use microsim_random::SplitMix64;
use nalgebra::Vector3;
use std::fmt::Write as _;

/// Samples a second: those of the shipped scripts. Each is a key, so that a single one can be bad.
const RATE: f64 = 62.5;

/// Jaws that are open no farther are closed completely.
const CLOSED: f64 = 0.01;
/// Jaws that have been open as far can be closed again.
const OPENED: f64 = 0.1;

/// A tool as it is moved.
pub struct Hand<'a> {
    /// The level.
    pub stage: &'a Stage,
    /// The tool.
    pub tool: &'a Tool,
    /// Its place among the tools.
    pub number: usize,
    /// Random numbers of its own.
    pub random: SplitMix64,
    /// Times \[s\] of what the profile is named for.
    pub acts: Vec<f64>,
    keys: Vec<(f64, Pose)>,
}

impl<'a> Hand<'a> {
    fn new(stage: &'a Stage, number: usize, random: SplitMix64) -> Self {
        let tool = &stage.tools[number];
        let start = tool.passing.first().expect("a script has keys").1;
        Self {
            stage,
            tool,
            number,
            random,
            acts: Vec::new(),
            keys: vec![(0.0, start)],
        }
    }

    /// The time at which the motion so far ends \[s\].
    pub fn time(&self) -> f64 {
        self.keys.last().expect("a start").0
    }

    /// The pose at its end.
    pub fn pose(&self) -> Pose {
        self.keys.last().expect("a start").1
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + 0.5 * (self.random.number() + 1.0) * (high - low)
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// A direction, uniform over the sphere.
    pub fn direction(&mut self) -> Vector3<f64> {
        loop {
            let vector = self.random.vector();
            let norm = vector.norm();
            if (0.1..=1.0).contains(&norm) {
                return vector / norm;
            }
        }
    }

    /// Moves to a pose within a time drawn from a range \[s\].
    pub fn go(&mut self, pose: Pose, [shortest, longest]: [f64; 2]) {
        let seconds = self.between(shortest, longest);
        self.keys.push((self.time() + seconds, pose));
    }

    /// Stays for a time drawn from a range \[s\].
    pub fn stay(&mut self, range: [f64; 2]) {
        self.go(self.pose(), range);
    }

    /// Opens or closes within a time drawn from a range \[s\].
    pub fn open(&mut self, opening: f64, range: [f64; 2]) {
        self.go(self.pose().opened(opening), range);
    }

    /// Moves by a distance drawn from a range \[m\], in a random direction, within a time drawn from a range \[s\].
    pub fn drift(&mut self, [least, most]: [f64; 2], range: [f64; 2]) {
        let by = self.direction() * self.between(least, most);
        self.go(self.pose().shifted(by), range);
    }

    /// Notes that what the profile is named for is done at the time to which the motion has come.
    pub fn act(&mut self) {
        self.acts.push(self.time());
    }

    /// A pose at work: one of the script that passes, anywhere along the longest side of the tissue, and a little off across it; near a target
    /// without tissue. Open as for reaching.
    pub fn target(&mut self) -> Pose {
        let number = self.random.below(self.tool.at_work.len() as u64) as usize;
        let pose = self.tool.at_work[number].opened(self.tool.open);
        let draw = self.random.vector();
        let Some([centre, half]) = self.stage.tissue else {
            // A millimetre, the radius of the smallest sphere.
            return pose.shifted(1e-3 * draw);
        };
        let longest = half.imax();
        let mut to = pose.position + 0.3 * half.component_mul(&draw);
        to[longest] = centre[longest] + 0.9 * half[longest] * draw[longest];
        Pose {
            position: to,
            ..pose
        }
    }

    /// Follows the script that passes from its beginning, each key a little off, at a pace.
    pub fn follow(&mut self, pace: f64, error: f64, turn: f64) {
        let tool = self.tool;
        let begin = self.time();
        for (time, pose) in tool.passing.iter().skip(1) {
            let by = error * self.random.vector();
            let turn = turn * self.random.vector();
            self.keys
                .push((begin + time / pace, pose.shifted(by).turned(turn)));
            self.act();
        }
    }

    /// The pose at a time: between its keys with minimum jerk (Flash & Hogan 1985), the opening evenly.
    fn at(&self, time: f64) -> Pose {
        let next = self.keys.partition_point(|(t, _)| *t <= time);
        let (from, pose) = self.keys[next.saturating_sub(1)];
        match self.keys.get(next) {
            Some((until, to)) => {
                let t = (time - from) / (until - from);
                pose.mixed(to, t * t * t * (10.0 + t * (6.0 * t - 15.0)), t)
            }
            None => pose,
        }
    }
}

/// What a player does, as it stands in its script.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// The tool.
    pub tool: String,
    /// Times of what the profile is named for \[s\].
    pub acts: Vec<f64>,
    /// Times at which the jaws have closed completely \[s\].
    pub closures: Vec<f64>,
}

/// The script of a player, and what each tool does in it.
pub fn script(player: &Player, stage: &Stage) -> (String, Vec<Track>) {
    let mut text = format!(
        "# A random player of the soak of hands.\nmodule = \"{}\"\nlevel = {}\nrate = \"{RATE} Hz\"\ninterpolation = \"linear\"\n\
         synthetic = \"random player, profile {}, seed {}\"\n",
        player.module,
        player.level.number,
        player.profile.name(),
        player.seed
    );
    let last = (player.seconds * RATE).ceil() as u32;
    let mut tracks = Vec::new();
    for number in 0..stage.tools.len() {
        let mut hand = Hand::new(stage, number, player.random(1 + number as u64));
        let mut disturbance = motions::move_hand(&mut hand, player);
        let tool = hand.tool;
        let _ = write!(text, "\n[[tool]]\nname = \"{}\"\n", tool.name);
        let (mut was_open, mut closures) = (false, Vec::new());
        for sample in 0..=last {
            let time = f64::from(sample) / RATE;
            let (pose, visible) = disturbance.apply(time, hand.at(time));
            if was_open && pose.opening <= CLOSED {
                closures.push(time);
            }
            was_open = pose.opening > OPENED || (was_open && pose.opening > CLOSED);
            write_key(&mut text, time, &pose, visible);
        }
        let mut acts = match disturbance {
            // Bad samples are what such a player is named for.
            Disturbance::Tracker { bad, .. } => bad,
            _ => hand.acts,
        };
        acts.retain(|time| *time <= player.seconds);
        if !tool.jaws {
            closures.clear();
        }
        tracks.push(Track {
            tool: tool.name.clone(),
            acts,
            closures,
        });
    }
    (text, tracks)
}

/// Positions of a script are within a metre.
const FARTHEST: f64 = 0.99;

fn write_key(text: &mut String, time: f64, pose: &Pose, visible: bool) {
    let mm = pose.position.map(|x| 1e3 * x.clamp(-FARTHEST, FARTHEST));
    let q = pose.orientation.coords;
    let _ = write!(
        text,
        "[[tool.key]]\nt = \"{time:.3} s\"\nposition = [\"{:.5} mm\", \"{:.5} mm\", \"{:.5} mm\"]\norientation = [{:.9}, {:.9}, {:.9}, {:.9}]\nopening = {:.5}\n",
        mm.x, mm.y, mm.z, q.x, q.y, q.z, q.w, pose.opening
    );
    if !visible {
        text.push_str("visible = false\n");
    }
}
