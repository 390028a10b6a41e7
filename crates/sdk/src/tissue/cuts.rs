//! Cuts assigned to the marks that they belong to: how far from a mark and how askew tissue was cut, and what was cut or tore
//! elsewhere. Everything is measured in the tissue at rest, so that stretching it does not make a cut better.

use super::mark_line::MarkLine;
use super::path::PathSums;
use microsim_message::{PathPoints, TissueCut};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// What was cut in a tick, as seen from a mark.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Cut {
    /// \[m²\]; 0 of what was cut in a tick that was not valid.
    area: f64,
    /// Its centroid, from the mark's middle \[m\].
    place: [f64; 3],
    /// Normal of its plane, of length 1, on the same side of the mark for all.
    normal: [f64; 3],
    /// Distance of its centroid from the plane that the mark asks for \[m\].
    beside: f64,
    /// Cosine of the angle between its plane and the one that the mark asks for.
    cosine: f64,
    /// Where the tool went through the tissue.
    path: PathSums,
}

impl Cut {
    /// Offset of its centroid from the mark's middle along `normal` \[m\].
    fn along(&self, normal: [f64; 3]) -> f64 {
        Vector3::from(self.place).dot(&Vector3::from(normal))
    }
}

/// All cuts of a body so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CutLog {
    marks: Vec<Vec<Cut>>,
    /// Areas that tools opened: at no mark, and in tissue that was held \[m²\].
    elsewhere: f64,
    steadied: f64,
    torn: f64,
}

/// Where a cut belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assignment {
    /// To a mark; `first` if nothing had been cut there before.
    Mark {
        /// Its index.
        index: usize,
        /// Whether it is the first cut there.
        first: bool,
    },
    /// To none.
    Stray,
    /// It tore by itself.
    Tear,
    /// A message without an opening.
    Nothing,
}

/// What is known of all cuts together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutFindings {
    /// Largest over the marks: the distance of a mark's middle from its cut along the normal of its plane, root mean square \[m\]. `None` if
    /// nothing was cut at any.
    pub distance: Option<f64>,
    /// Largest over the marks: the angle between the plane of its cut and the one that the mark's line spans with the tissue's
    /// normal \[rad\]. `None` if nothing was cut at any.
    pub angle: Option<f64>,
    /// Area that tools opened outside of the cuts of all marks \[m²\].
    pub stray: f64,
    /// Area that tore by itself \[m²\].
    pub torn: f64,
    /// Fraction of the area opened by tools that was opened in tissue that was held. `None` if nothing was cut.
    pub steadied: Option<f64>,
}

impl CutLog {
    /// Assigns a cut to the nearest of the marks, if it is within `reach` \[m\] and runs along its line rather than away from it. `steadied` is
    /// asked whether the tissue at the nearest mark was held, by the mark's index, whether or not the cut is assigned to it. Of a cut that was found in a tick that was not
    /// valid only this is known: no finding takes anything from it.
    pub fn assign(
        &mut self,
        cut: &TissueCut,
        marks: &[MarkLine],
        reach: f64,
        steadied: impl FnOnce(usize) -> bool,
    ) -> Assignment {
        self.marks.resize(marks.len(), Vec::new());
        if cut.area <= 0.0 {
            return Assignment::Nothing;
        }
        // What is known of a tick that is not valid is only that something came apart.
        let (area, points) = match cut.valid {
            true => (cut.area, cut.points),
            false => (0.0, PathPoints::default()),
        };
        if cut.tool.is_empty() {
            self.torn += area;
            return Assignment::Tear;
        }
        let away = |mark: &MarkLine| mark.away(cut.rest_centroid);
        let all = marks.iter().enumerate();
        let nearest = all.min_by(|(_, a), (_, b)| away(a).total_cmp(&away(b)));
        if nearest.is_some_and(|(index, _)| steadied(index)) {
            self.steadied += area;
        }
        let is_its_cut = |mark: &MarkLine| away(mark) <= reach && mark.is_cut_by(cut.rest_normal);
        let Some((index, mark)) = nearest.filter(|(_, mark)| is_its_cut(mark)) else {
            self.elsewhere += area;
            return Assignment::Stray;
        };
        let across = Vector3::from(mark.across);
        let cosine = Vector3::from(cut.rest_normal).dot(&across);
        let normal = cut.rest_normal.map(|c| if cosine < 0.0 { -c } else { c });
        let offset = Vector3::from(cut.rest_centroid) - Vector3::from(mark.middle);
        let first = self.marks[index].is_empty();
        self.marks[index].push(Cut {
            area,
            place: offset.into(),
            normal,
            beside: offset.dot(&across).abs(),
            cosine: cosine.abs(),
            path: PathSums::new(&points, mark),
        });
        Assignment::Mark { index, first }
    }

    /// Whether the tissue, once it is apart on both sides of a mark, was cut there: tools have cut at the mark, and opened at least half as much
    /// there as was opened away from all marks or tore by itself. What came apart elsewhere, or tore, is no cut at the mark, nor does a snip there
    /// make it one. What was cut in ticks that were not valid has no area.
    pub fn is_cut_at(&self, mark: usize) -> bool {
        let cuts = self.marks.get(mark).filter(|cuts| !cuts.is_empty());
        cuts.is_some_and(|cuts| {
            let area: f64 = cuts.iter().map(|cut| cut.area).sum();
            area >= 0.5 * (self.elsewhere + self.torn)
        })
    }

    /// What is known so far. The cut of a mark is where most of it was cut: openings whose middle is farther than `width` \[m\] from the
    /// plane of all of them, which has their mean normal and lies where half of their area is on either side, and from the plane that the
    /// mark asks for as well, are stray, so that a good cut does not make up for a wound beside it. The plane of a single one does not
    /// show where it is: that of a small bite is uncertain, and that of a slit beside the mark may pass through it.
    ///
    /// Distance and angle are of the plane nearest to the points at which the tool went through the tissue. Where these are too few for one, as of a snip, it is that of the mean
    /// normal of the openings. How many ticks a cut takes, and where the mesh can be divided, is the computation's matter and not the hand's.
    pub fn findings(&self, width: f64) -> CutFindings {
        let (mut distance, mut angle) = (None, None);
        let (mut at_marks, mut stray) = (0.0, self.elsewhere);
        let worse = |one: Option<f64>, other: f64| Some(one.map_or(other, |one| one.max(other)));
        let is_measured = |cuts: &&Vec<Cut>| cuts.iter().any(|cut| cut.area > 0.0);
        for cuts in self.marks.iter().filter(is_measured) {
            let all: f64 = cuts.iter().map(|cut| cut.area).sum();
            let every: Vec<&Cut> = cuts.iter().collect();
            let normal = sum_of_normals(&every).normalize().into();
            let middle = median(cuts, normal, all);
            let is_near = |cut: &&Cut| {
                let away = (cut.along(normal) - middle).abs();
                away.min(cut.beside) <= width
            };
            let (own, far): (Vec<&Cut>, Vec<&Cut>) = cuts.iter().partition(is_near);
            at_marks += all;
            stray += far.iter().map(|cut| cut.area).sum::<f64>();
            let mut path = PathSums::default();
            own.iter().for_each(|cut| path.merge(&cut.path));
            let (beside, askew) = path.plane().unwrap_or_else(|| opened_plane(&own));
            distance = worse(distance, beside);
            angle = worse(angle, askew);
        }
        let opened = at_marks + self.elsewhere;
        CutFindings {
            distance,
            angle,
            stray,
            torn: self.torn,
            steadied: (opened > 0.0).then(|| self.steadied / opened),
        }
    }
}

/// Distance from the mark's middle \[m\], mean over the area, and angle to the mark's plane \[rad\] of the mean plane of openings.
fn opened_plane(cuts: &[&Cut]) -> (f64, f64) {
    let sum = sum_of_normals(cuts);
    let normal = sum.normalize();
    let over_area =
        |of: &dyn Fn(&Cut) -> f64| cuts.iter().map(|cut| cut.area * of(cut)).sum::<f64>();
    let away = over_area(&|cut| cut.along(normal.into()).abs()) / over_area(&|_| 1.0);
    let cosine = over_area(&|cut| cut.cosine) / sum.norm();
    (away, libm::acos(cosine.min(1.0)))
}

/// The sum of the normals by area \[m²\]. None of them points away from that of the mark, so that it does not vanish.
fn sum_of_normals(cuts: &[&Cut]) -> Vector3<f64> {
    let normals = cuts.iter().map(|cut| cut.area * Vector3::from(cut.normal));
    normals.sum()
}

/// The offset along `normal` on both sides of which half of the area lies; `all` is the whole of it.
fn median(cuts: &[Cut], normal: [f64; 3], all: f64) -> f64 {
    let offsets = cuts.iter().map(|cut| (cut.along(normal), cut.area));
    let mut sorted: Vec<(f64, f64)> = offsets.collect();
    sorted.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut sum = 0.0;
    let middle = sorted.iter().find(|(_, area)| {
        sum += area;
        sum >= 0.5 * all
    });
    middle.map_or(0.0, |(offset, _)| *offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mark along y through the origin.
    fn mark() -> MarkLine {
        MarkLine {
            middle: [0.0; 3],
            along: [0.0, 1.0, 0.0],
            across: [1.0, 0.0, 0.0],
        }
    }

    fn cut(x: f64, area: f64, rest_normal: [f64; 3]) -> TissueCut {
        TissueCut {
            tool: "right".into(),
            area,
            rest_centroid: [x, 0.0, 0.0],
            rest_normal,
            valid: true,
            ..TissueCut::default()
        }
    }

    fn findings(cuts: &[TissueCut]) -> CutFindings {
        let mut log = CutLog::default();
        for cut in cuts {
            log.assign(cut, &[mark()], 1.2e-3, |_| false);
        }
        log.findings(0.4e-3)
    }

    /// A cut of 1.2 mm² at the mark and a snip of 0.3 mm² 1 mm beside it, whichever comes first, and on either side: the mean of both
    /// would be 0.2 mm.
    #[test]
    fn a_good_cut_does_not_make_up_for_a_wound_beside_it() {
        for side in [1.0, -1.0] {
            // A blade may come from either side: the normal's sign means nothing.
            let snip = cut(side * 1e-3, 0.3e-6, [-1.0, 0.0, 0.0]);
            let good = cut(0.0, 1.2e-6, [1.0, 0.0, 0.0]);
            for cuts in [[&snip, &good], [&good, &snip]] {
                let found = findings(&cuts.map(Clone::clone));
                assert_eq!(found.distance, Some(0.0));
                assert!((found.stray - 0.3e-6).abs() < 1e-18, "{}", found.stray);
            }
        }
    }

    /// A mark is cut by a cut at it, also beside a wound; neither by one elsewhere, nor by a snip at the mark after it, nor by a tear.
    #[test]
    fn a_mark_is_cut_by_what_is_cut_there() {
        let (far, good, snip) = (
            cut(4e-3, 1.2e-6, [1.0, 0.0, 0.0]),
            cut(0.0, 1.2e-6, [1.0, 0.0, 0.0]),
            cut(0.0, 0.1e-6, [1.0, 0.0, 0.0]),
        );
        let tear = TissueCut {
            tool: String::new(),
            ..good.clone()
        };
        let is_cut = |cuts: &[&TissueCut]| {
            let mut log = CutLog::default();
            for cut in cuts {
                log.assign(cut, &[mark()], 1.2e-3, |_| false);
            }
            log.is_cut_at(0)
        };
        assert!(is_cut(&[&good]) && is_cut(&[&far, &good]));
        for cuts in [&[][..], &[&far], &[&far, &snip], &[&tear], &[&tear, &snip]] {
            assert!(!is_cut(cuts), "{cuts:?}");
        }
    }

    /// A cut askew at the mark, one beside it and a tear, all in ticks that were not valid: the mark is cut, and nothing is measured. Then a valid one is measured
    /// alone.
    #[test]
    fn cuts_of_ticks_that_mean_nothing_are_in_no_finding() {
        let invalid = |cut: TissueCut| TissueCut {
            valid: false,
            ..cut
        };
        let askew = invalid(cut(0.2e-3, 1e-6, [0.8, 0.6, 0.0]));
        let mut log = CutLog::default();
        let first = log.assign(&askew, &[mark()], 1.2e-3, |_| true);
        assert_eq!(
            first,
            Assignment::Mark {
                index: 0,
                first: true
            }
        );
        let stray = invalid(cut(4e-3, 1e-6, [1.0, 0.0, 0.0]));
        log.assign(&stray, &[mark()], 1.2e-3, |_| true);
        let tear = TissueCut {
            tool: String::new(),
            ..askew
        };
        let torn = log.assign(&tear, &[mark()], 1.2e-3, |_| true);
        assert_eq!(torn, Assignment::Tear);
        let found = log.findings(0.4e-3);
        let none = (found.distance, found.angle, found.steadied);
        assert_eq!(none, (None, None, None));
        assert_eq!((found.stray, found.torn), (0.0, 0.0));
        let good = cut(0.1e-3, 1e-6, [1.0, 0.0, 0.0]);
        log.assign(&good, &[mark()], 1.2e-3, |_| false);
        let found = log.findings(0.4e-3);
        assert_eq!(
            (found.distance, found.steadied, found.stray),
            (Some(0.1e-3), Some(0.0), 0.0)
        );
    }

    /// Nothing is stray, and the distance of the cut is this one \[m\]; tolerance: rounding.
    #[track_caller]
    fn assert_cut(found: CutFindings, distance: f64) {
        let measured = found.distance.expect("a cut");
        assert!((measured - distance).abs() < 1e-15, "{measured}");
        assert_eq!(found.stray, 0.0);
    }

    /// Two bites from both edges, 0.6 mm apart and each 0.3 mm from the mark: neither is far from it. And a whole cut 0.7 mm beside: it
    /// is the cut of this mark, only at the wrong place.
    #[test]
    fn bites_on_both_sides_of_the_mark_and_a_whole_cut_beside_it_are_its_cut() {
        let across = |x: f64| cut(x, 0.4e-6, [1.0, 0.0, 0.0]);
        assert_cut(findings(&[0.3e-3, -0.3e-3].map(across)), 0.3e-3);
        assert_cut(findings(&[0.69e-3, 0.7e-3, 0.71e-3].map(across)), 0.7e-3);
    }

    /// A slit of 1 mm² along the tissue through the middle of the mark: its plane holds the mark's middle and would have the distance 0.
    /// Turned by 0.7 rad, less than half a right angle of 0.785, a plane is still the mark's cut, by 0.87 rad no more; as a bevel by 1.0 and
    /// not by 1.1 rad, before and behind 60°. One at 43° to the surface is a cut, also where it runs nearly as much away from the line.
    #[test]
    fn a_slit_lengthwise_through_the_mark_is_stray() {
        let mut log = CutLog::default();
        let slit = cut(0.0, 1e-6, [0.0, -1.0, 0.0]);
        let assigned = log.assign(&slit, &[mark()], 1.2e-3, |_| false);
        assert_eq!(assigned, Assignment::Stray);
        let found = log.findings(0.4e-3);
        assert_eq!(
            (found.distance, found.angle, found.stray),
            (None, None, 1e-6)
        );
        let turned = |angle| [libm::cos(angle), libm::sin(angle), 0.0];
        let bevel = |angle| [-libm::cos(angle), 0.0, libm::sin(angle)];
        for (normal, stray) in [
            (turned(0.7), 0.0),
            (turned(0.87), 1e-6),
            (bevel(1.0), 0.0),
            (bevel(1.1), 1e-6),
            ([0.49, 0.48, 0.728], 0.0),
        ] {
            assert_eq!(findings(&[cut(0.0, 1e-6, normal)]).stray, stray);
        }
    }

    /// Of two cuts of 1 mm² each the one at the second mark is steadied, whose tissue is held; so is a stray one nearest to it.
    #[test]
    fn a_cut_is_steadied_by_what_holds_the_tissue_at_its_mark() {
        let mut other = mark();
        other.middle = [4e-3, 0.0, 0.0];
        let marks = [mark(), other];
        let mut log = CutLog::default();
        let mut steadied = |x: f64| {
            let cut = cut(x, 1e-6, [1.0, 0.0, 0.0]);
            log.assign(&cut, &marks, 1.2e-3, |index| index == 1);
            log.findings(0.4e-3).steadied
        };
        assert_eq!(steadied(0.0), Some(0.0));
        assert_eq!(steadied(4e-3), Some(0.5));
        assert_eq!(steadied(7e-3), Some(2.0 / 3.0));
    }

    /// A bite at the edge of the mark, 0.9 mm along it, whose plane is askew by asin(0.6) and passes the middle at 0.54 mm. The sum of the
    /// normals is (1.18, 0.06, 0) mm².
    #[test]
    fn a_small_bite_at_the_mark_is_not_stray_for_its_uncertain_plane() {
        let mut bite = cut(0.0, 0.1e-6, [0.8, 0.6, 0.0]);
        bite.rest_centroid[1] = 0.9e-3;
        let found = findings(&[cut(0.0, 1.1e-6, [1.0, 0.0, 0.0]), bite]);
        let size = libm::hypot(1.18, 0.06);
        assert_cut(found, 0.1 / 1.2 * 0.9e-3 * 0.06 / size);
        let angle = found.angle.expect("a cut");
        assert!((angle - libm::atan2(0.06, 1.18)).abs() < 1e-8, "{angle}");
    }

    /// Elements tilt a straight cut to and fro by 14°, one per tick, or all of it is opened in one tick, whose normal is the mean: the same
    /// hand, the same cut.
    #[test]
    fn a_cut_is_as_straight_in_many_ticks_as_in_one() {
        let tilt = 14.0f64.to_radians();
        let normal = |sign: f64| [libm::cos(tilt), 0.0, sign * libm::sin(tilt)];
        let many = [1.0, -1.0, 1.0, -1.0].map(|sign| cut(0.1e-3, 0.3e-6, normal(sign)));
        let one = cut(0.1e-3, 1.2e-6, [1.0, 0.0, 0.0]);
        for cuts in [&many[..], &[one]] {
            let found = findings(cuts);
            assert_cut(found, 0.1e-3);
            // An arc cosine loses half of the digits near 1.
            assert!(found.angle.expect("a cut") < 1e-7, "{found:?}");
        }
    }

    /// A slit of 0.3 mm², 0.8 mm beside the mark and 0.9 mm along it, whose plane passes the mark's middle at a micrometre. The mean normal
    /// of it and of a good cut of 1.2 mm² is (0.990, 0.140, 0), along which it lies at −0.67 mm.
    #[test]
    fn a_slit_beside_the_mark_is_stray_though_its_plane_passes_through_it() {
        let size = libm::sqrt(0.743 * 0.743 + 0.669 * 0.669);
        let mut slit = cut(-0.8e-3, 0.3e-6, [0.743 / size, 0.669 / size, 0.0]);
        slit.rest_centroid[1] = 0.89e-3;
        let found = findings(&[cut(0.0, 1.2e-6, [1.0, 0.0, 0.0]), slit]);
        assert_eq!(found.distance, Some(0.0));
        assert!((found.stray - 0.3e-6).abs() < 1e-18, "{}", found.stray);
    }

    /// Three bites in one plane through the mark's middle, turned by asin(0.6) from its line: the outer ones lie 0.54 mm beside it.
    #[test]
    fn bites_along_one_oblique_plane_are_one_cut() {
        let bites = [-0.9e-3, 0.0, 0.9e-3].map(|along: f64| {
            let mut bite = cut(-0.6 * along, 0.4e-6, [0.8, 0.6, 0.0]);
            bite.rest_centroid[1] = 0.8 * along;
            bite
        });
        assert_cut(findings(&bites), 0.0);
    }

    /// Planes through the mark's middle, turned by asin(0.6) about the tissue's normal, and about the mark's own line (a bevel).
    #[test]
    fn an_oblique_cut_and_a_bevel_count_alike() {
        for normal in [[0.8, 0.6, 0.0], [0.8, 0.0, 0.6], [-0.8, 0.0, 0.6]] {
            let found = findings(&[cut(0.0, 1e-6, normal)]);
            let angle = found.angle.expect("a cut");
            assert!((angle - libm::asin(0.6)).abs() < 1e-12, "{angle}");
            assert_eq!(found.distance, Some(0.0));
        }
    }
}
