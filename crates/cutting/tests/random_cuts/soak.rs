//! Random cuts, with everything checked after every step. The test takes a sample, the example as many as it is asked for.

use crate::bodies::{Body, Kind};
use microsim_cutting::{
    Blade, Cut, Rejected, Settings, Sheet, Stroke, Sweep, TopologyChange, check,
};
use microsim_random::SplitMix64;
use nalgebra::{Matrix3, Vector3};

type V3 = Vector3<f64>;

/// What was cut and how it went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    pub bodies: usize,
    pub strokes: usize,
    pub edits: usize,
    pub divided: usize,
    pub crossed: usize,
    pub clamped: usize,
    pub followed: usize,
    pub joined: usize,
    pub snapped: usize,
    pub dropped: usize,
    pub pieces: usize,
    /// Rest volume taken away as crumbs over that of the bodies, summed.
    pub lost: f64,
    /// Smallest rest volume of an element over the mean of its body.
    pub least_volume: f64,
    /// Largest number of elements of a body.
    pub largest: usize,
    /// Strokes of a blade that passed right through, looked at for bridges.
    pub complete: usize,
}

/// A path of a blade through a body of size 1, in the frame of the body at rest.
struct Path {
    center: V3,
    along: V3,
    across: V3,
    normal: V3,
    half_length: f64,
    half_width: f64,
    /// Turn of the blade about its path from the middle to the end, and height of a wave.
    twist: f64,
    wave: f64,
}

impl Path {
    fn random(random: &mut SplitMix64, complete: bool, plane: bool) -> Self {
        let normal = random.vector().normalize();
        let along = normal.cross(&random.vector()).normalize();
        let bounded = |random: &mut SplitMix64| 0.2 + 0.8 * random.number().abs();
        Self {
            center: random.vector() * 0.35,
            along,
            across: normal.cross(&along),
            normal,
            half_length: if complete { 2.0 } else { bounded(random) },
            half_width: if complete { 2.0 } else { 0.6 * bounded(random) },
            twist: if plane { 0.0 } else { random.number() },
            wave: if plane { 0.0 } else { 0.15 * random.number() },
        }
    }

    /// The point at −1..1 along and across.
    fn at(&self, t: f64, s: f64) -> V3 {
        // Sine and cosine of the twist's angle by its half's tangent.
        let half = 0.5 * self.twist * t;
        let (c, d) = (
            (1.0 - half * half) / (1.0 + half * half),
            2.0 * half / (1.0 + half * half),
        );
        let across = self.across * c + self.normal * d;
        let lift = self.wave * 4.0 * t * (1.0 - t * t);
        self.center
            + self.along * (self.half_length * t)
            + across * (self.half_width * s)
            + self.normal * lift
    }

    fn blade(&self, t: f64) -> [V3; 2] {
        [self.at(t, -1.0), self.at(t, 1.0)]
    }
}

/// A swing of the whole tissue: affine, so that what is plane at rest is plane now.
struct Swing {
    linear: Matrix3<f64>,
    shift: V3,
}

impl Swing {
    fn random(random: &mut SplitMix64) -> Self {
        Self {
            linear: Matrix3::from_fn(|_, _| 0.3 * random.number()),
            shift: random.vector(),
        }
    }

    fn at(&self, time: f64, place: &V3) -> V3 {
        let swing = 4.0 * time * (1.0 - time);
        place + self.linear * place * swing + self.shift * swing
    }

    /// Tissue and blade move on straight lines from A x to A' x and from A b to A' b'. Halfway the blade is off the
    /// plane through b and b' by (A' − A)(b' − b) / 4, and by up to 1 / (1 − 0.9) as much in the tissue's own frame, as the linear part is
    /// up to 0.9 off the identity; typical is less than 2.
    fn off(&self, times: [f64; 2], blade: impl Fn(usize) -> [V3; 2]) -> f64 {
        let [from, to] = times.map(|t| 4.0 * t * (1.0 - t));
        let (p, q) = (blade(0), blade(1));
        let path = (q[0] - p[0]).norm().max((q[1] - p[1]).norm());
        (self.linear * (to - from)).norm() * path / 4.0 * 3.0
    }
}

/// What else follows the bodies; `()` is nothing.
pub trait Watch {
    /// A new body, not yet cut.
    fn begins(&mut self, _: &Body) {}

    /// Its mesh has been cut, and is valid.
    fn edited(&mut self, _: &Body, _: &Cut) -> Result<(), String> {
        Ok(())
    }
}

impl Watch for () {}

/// Cuts one body several times; one in eight up to `most` times.
pub fn cut_body(
    change: TopologyChange,
    seed: u64,
    most: u64,
    summary: &mut Summary,
    watch: &mut impl Watch,
) -> Result<usize, String> {
    let mut random = SplitMix64(seed);
    let kind = [Kind::Block, Kind::Block, Kind::Tube, Kind::Filled][random.below(4) as usize];
    let mut body = Body::new(kind, &mut random);
    if random.below(4) == 0 {
        // Down to small elements, with crumbs.
        body.settings = Settings {
            least_edge: 0.01,
            least_volume: 1e-4,
            flake_volume: 0.0,
            flake_thickness: 0.0,
            crumb_volume: 1e-2,
            ..Settings::default()
        };
    }
    body.settings.change = change;
    let strokes = if random.below(8) == 0 {
        most
    } else {
        1 + random.below(4)
    };
    summary.bodies += 1;
    watch.begins(&body);
    for number in 0..strokes {
        let manner = random.below(5);
        let complete = random.below(3) > 0;
        let plane = random.below(2) == 0;
        let path = Path::random(&mut random, complete, plane);
        let mut stroke = Stroke::new();
        let before = body.mesh.tets.len();
        let left_before = summary.snapped + summary.followed;
        // How far the blade may leave its plane in the frame of the tissue, within a step.
        let mut off = 0.0_f64;
        let context =
            |e: String| format!("seed {seed} stroke {number} ({kind:?}, manner {manner}): {e}");
        match manner {
            0 | 1 => {
                let rows = if plane { 1 } else { 12 };
                let sheet = Sheet::grid(rows, rows, |u, v| path.at(2.0 * u - 1.0, 2.0 * v - 1.0));
                let positions = body.mesh.positions.clone();
                let blade = Blade::Sheet {
                    sheet: &sheet,
                    positions: &positions,
                };
                body.step(&mut stroke, &blade, summary, watch)
                    .map_err(context)?;
            }
            _ => {
                let steps = 2 + random.below(24);
                let swing = Swing::random(&mut random);
                // Some blades turn back on their path for a while.
                let back = if random.below(3) == 0 {
                    random.below(steps)
                } else {
                    steps
                };
                let mut times = vec![0.0];
                for step in 1..=steps {
                    if step == back {
                        times.push((step as f64 - 2.5) / steps as f64);
                    }
                    times.push(step as f64 / steps as f64);
                }
                // Some are drawn back and set in again.
                let snips = random.below(3) == 0;
                for (k, pair) in times.windows(2).enumerate() {
                    if snips && random.below(3) == 0 {
                        let at = k as f64 / times.len() as f64;
                        let at = if manner == 2 { 0.0 } else { at };
                        let places = body.mesh.positions.iter().map(|p| swing.at(at, p));
                        let places: Vec<V3> = places.collect();
                        let ended = body.end(&mut stroke, &places, summary, watch);
                        ended.map_err(|e| context(format!("drawn back at step {k}: {e}")))?;
                        stroke = Stroke::new();
                    }
                    // Manner 2: the tissue rests.
                    let fraction = |k: usize| {
                        if manner == 2 {
                            0.0
                        } else {
                            k as f64 / times.len() as f64
                        }
                    };
                    let [from, to] = [fraction(k), fraction(k + 1)];
                    let sweep = Sweep {
                        before: path.blade(2.0 * pair[0] - 1.0).map(|p| swing.at(from, &p)),
                        now: path.blade(2.0 * pair[1] - 1.0).map(|p| swing.at(to, &p)),
                    };
                    off = off.max(swing.off([from, to], |t| path.blade(2.0 * pair[t] - 1.0)));
                    let [before, now] = [from, to].map(|time| {
                        let places = body.mesh.positions.iter();
                        places.map(|p| swing.at(time, p)).collect::<Vec<_>>()
                    });
                    let blade = Blade::Sweep {
                        sweeps: &[sweep],
                        before: &before,
                        now: &now,
                    };
                    let result = body.step(&mut stroke, &blade, summary, watch);
                    result.map_err(|e| context(format!("step {k} of {}: {e}", times.len())))?;
                }
            }
        }
        let rest = body.mesh.positions.clone();
        body.end(&mut stroke, &rest, summary, watch)
            .map_err(context)?;
        summary.strokes += 1;
        if complete && plane {
            summary.complete += 1;
            // The first stroke separates edges exactly but for those that are too short to be divided or crossed near an end, and those at nodes that it has parted
            // already, where it strays by half an edge at most. Later on flakes stay on, on lips that may be oblique: of an edge, half as long again.
            let snapped = match (number, summary.snapped + summary.followed - left_before) {
                // What is taken away reaches as far as the elements that were cut.
                _ if change == TopologyChange::Remove => 1.5 * body.longest_edge(),
                // Nothing is divided: a tip of less than half an edge may stay on.
                (0, 0) if change == TopologyChange::SplitAtFaces => 0.5 * body.longest_edge(),
                (0, 0) => 0.0,
                (0, _) => 0.5 * body.longest_edge(),
                _ => 1.5 * body.longest_edge(),
            };
            let tolerance = snapped + off;
            body.separated(&path.center, &path.normal, tolerance, number == 0)
                .map_err(context)?;
        }
        summary.largest = summary.largest.max(body.mesh.tets.len());
        if body.mesh.tets.len() > 6 * before + 4000 {
            return Err(format!(
                "seed {seed}: from {before} to {} elements in a stroke",
                body.mesh.tets.len()
            ));
        }
    }
    Ok(strokes as usize)
}

impl Body {
    fn step(
        &mut self,
        stroke: &mut Stroke,
        blade: &Blade,
        summary: &mut Summary,
        watch: &mut impl Watch,
    ) -> Result<(), String> {
        let cut = self.topology.cut(&self.mesh, stroke, blade, &self.settings);
        match cut {
            // A blade may pass through all elements of a small body in one step.
            Err(Rejected::NothingLeft) => Ok(()),
            Err(error) => Err(error.to_string()),
            Ok(None) => Ok(()),
            Ok(Some(cut)) => self.made(&cut, summary, watch),
        }
    }

    /// What still waits in a stroke that ends is cut.
    fn end(
        &mut self,
        stroke: &mut Stroke,
        positions: &[V3],
        summary: &mut Summary,
        watch: &mut impl Watch,
    ) -> Result<(), String> {
        let Self {
            mesh,
            topology,
            settings,
            ..
        } = self;
        let cut = topology.conclude_stroke(mesh, stroke, positions, settings);
        cut.map_or(Ok(()), |cut| self.made(&cut, summary, watch))
    }

    /// Makes a cut and checks all that is left.
    fn made(
        &mut self,
        cut: &Cut,
        summary: &mut Summary,
        watch: &mut impl Watch,
    ) -> Result<(), String> {
        let settings = self.settings;
        let before = self.measures.clone();
        self.mesh.apply(&cut.edit).map_err(|e| e.to_string())?;
        let now = check(&self.mesh, &self.topology).map_err(|e| format!("{e:?}"))?;
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs().max(b.abs());
        if !close(now.volume + cut.lost_volume, before.volume) {
            return Err(format!(
                "volume {} + {} from {}",
                now.volume, cut.lost_volume, before.volume
            ));
        }
        if cut.edit.removed.is_empty() {
            // Nothing opens but what the blade made: the rest of the surface is what it was.
            if !close(now.outer_area, before.outer_area) {
                return Err(format!(
                    "surface {} from {}",
                    now.outer_area, before.outer_area
                ));
            }
            for (k, (area, rest)) in now.sheets.iter().enumerate() {
                let (area_before, rest_before) = before.sheets.get(k).copied().unwrap_or_default();
                if (rest - rest_before).abs() > 1e-11 * now.outer_area {
                    return Err(format!("sheet {k}: sides differ by {rest}"));
                }
                // A later sheet only adds to those before it what they had left together.
                if *area < area_before * (1.0 - 1e-12) {
                    return Err(format!("sheet {k}: area {area} from {area_before}"));
                }
            }
        }
        // Of an earlier piece nothing may be left where elements are taken away.
        let removes = settings.change == TopologyChange::Remove;
        let (least, most) = (before.parts, before.parts + cut.pieces.len());
        if now.parts > most || (!removes && now.parts != most.max(least)) {
            return Err(format!(
                "{} parts from {}, {} pieces",
                now.parts,
                before.parts,
                cut.pieces.len()
            ));
        }
        let least = now.least_volume / self.topology.mean_volume();
        if least
            < settings
                .least_volume
                .min(before.least_volume / self.topology.mean_volume())
                * (1.0 - 1e-9)
        {
            return Err(format!("an element of {least} of the mean volume"));
        }
        self.follow_surface(&cut.surface)?;
        self.check_fibres()?;
        summary.edits += 1;
        summary.divided += cut.divided;
        summary.crossed += cut.crossed;
        summary.clamped += cut.clamped;
        summary.followed += cut.followed;
        summary.joined += cut.joined;
        summary.snapped += cut.snapped;
        summary.dropped += cut.dropped;
        summary.pieces += cut.pieces.len();
        summary.lost += cut.lost_volume / now.volume;
        summary.least_volume = summary.least_volume.min(least);
        self.measures = now;
        watch.edited(self, cut)
    }
}

/// At least `strokes` strokes, up to `most` in a body.
pub fn run(
    strokes: usize,
    seed: u64,
    most: u64,
    watch: &mut impl Watch,
    report: impl FnMut(&Summary),
) -> Result<Summary, String> {
    run_with(
        TopologyChange::default(),
        strokes,
        seed,
        most,
        watch,
        report,
    )
}

/// The same with another change of topology.
pub fn run_with(
    change: TopologyChange,
    strokes: usize,
    seed: u64,
    most: u64,
    watch: &mut impl Watch,
    mut report: impl FnMut(&Summary),
) -> Result<Summary, String> {
    let mut summary = Summary {
        least_volume: f64::INFINITY,
        ..Summary::default()
    };
    let mut body = 0;
    while summary.strokes < strokes {
        let seed = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(body);
        cut_body(change, seed, most, &mut summary, watch)?;
        body += 1;
        report(&summary);
    }
    Ok(summary)
}
