//! Which point is which marker, and what follows for the instrument.

use super::fit::{Correspondence, Fitted, fit, width};
use super::{FEWEST_MARKERS, MarkerModel};
use nalgebra::Vector3;
use std::fmt;

/// Most points that are looked at; more are left out and counted as unknown.
const MOST_POINTS: usize = 16;
/// Most partial assignments that are tried: those of eight markers with distances that differ are some hundreds.
const MOST_TRIED: usize = 20_000;
/// How far an opening may be beyond closed and open: errors of points make it so.
const BEYOND: f64 = 0.25;

/// A point that a tracker sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkerPoint {
    /// Which marker it is by its name; `None` for a point without one.
    pub marker: Option<usize>,
    /// In the frame of the device `[m]`.
    pub position: [f64; 3],
}

/// An instrument as its markers show it.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerFit {
    /// Origin of the handle's frame in that of the device `[m]`.
    pub position: [f64; 3],
    /// `device_from_handle`, unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// 0 closed to 1 open; `None` where the points do not determine it.
    pub opening: Option<f64>,
    /// Root mean square residual `[m]`.
    pub rms: f64,
    /// Markers that are seen, merged ones included.
    pub seen: usize,
    /// Markers that are not.
    pub missing: usize,
    /// Markers that are seen as one point with another one.
    pub merged: usize,
    /// Points with the name of another marker.
    pub permuted: usize,
    /// Points that are no marker.
    pub unknown: usize,
    /// JᵀJ of the fit.
    pub(crate) information: nalgebra::SMatrix<f64, 7, 7>,
}

/// Why there is no pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkerLoss {
    /// Fewer than three points, or those that there are lie on a line.
    TooFew,
    /// No assignment of the points has a residual within the tolerance.
    NoFit,
    /// Several assignments fit as well, and place the instrument differently.
    Ambiguous,
}

impl fmt::Display for MarkerLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooFew => "too few markers are seen",
            Self::NoFit => "the markers do not lie as those of the instrument",
            Self::Ambiguous => "the markers that are seen fit the instrument in more than one pose",
        })
    }
}

/// Where a marker is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Missing,
    Point(usize),
    /// In one point with the marker of this index, which comes before it.
    With(usize),
}

/// An assignment that fits.
#[derive(Clone, Debug)]
struct Candidate {
    places: Vec<Place>,
    fitted: Fitted,
    points: usize,
    permuted: usize,
}

struct Search<'a> {
    model: &'a MarkerModel,
    points: &'a [MarkerPoint],
    places: Vec<Place>,
    is_used: Vec<bool>,
    tried: usize,
    /// Points that the best ones explain.
    most: usize,
    candidates: Vec<Candidate>,
}

impl MarkerModel {
    /// Pose and opening from points.
    ///
    /// # Errors
    /// [`MarkerLoss`] where they show none.
    pub fn locate(&self, points: &[MarkerPoint]) -> Result<MarkerFit, MarkerLoss> {
        let finite = |point: &&MarkerPoint| point.position.iter().all(|x| x.is_finite());
        let usable: Vec<MarkerPoint> = points
            .iter()
            .filter(finite)
            .take(MOST_POINTS)
            .copied()
            .collect();
        if usable.len() < FEWEST_MARKERS {
            return Err(MarkerLoss::TooFew);
        }
        let mut search = Search {
            model: self,
            points: &usable,
            places: Vec::with_capacity(self.count()),
            is_used: vec![false; usable.len()],
            tried: 0,
            most: FEWEST_MARKERS,
            candidates: Vec::new(),
        };
        search.descend();
        if search.tried > MOST_TRIED {
            return Err(MarkerLoss::Ambiguous);
        }
        let most = search.most;
        let mut candidates = search.candidates;
        candidates.retain(|candidate| candidate.points == most);
        let best = self.choose(candidates)?;
        Ok(self.describe(&best, points.len()))
    }

    /// The candidate that counts.
    fn choose(&self, mut candidates: Vec<Candidate>) -> Result<Candidate, MarkerLoss> {
        candidates.sort_by(|a, b| a.fitted.rms.total_cmp(&b.fitted.rms));
        let Some(best) = candidates.first().cloned() else {
            return Err(MarkerLoss::NoFit);
        };
        // Residuals of points without errors are rounding, and no factor of them means anything.
        let limit = 2.0 * best.fitted.rms + 1e-3 * self.tolerance;
        let close = candidates.iter().skip(1).filter(|c| c.fitted.rms <= limit);
        let rivals: Vec<&Candidate> = close.filter(|c| self.differ(&best, c)).collect();
        if rivals.is_empty() {
            return Ok(best);
        }
        // Names decide where they agree with one alone.
        let mut named = std::iter::once(&best)
            .chain(rivals)
            .filter(|c| c.permuted == 0);
        match (named.next(), named.next()) {
            (Some(one), None) => Ok(one.clone()),
            _ => Err(MarkerLoss::Ambiguous),
        }
    }

    /// Whether two assignments place the instrument differently: by more than what the tolerance allows anyhow.
    fn differ(&self, a: &Candidate, b: &Candidate) -> bool {
        let place = |candidate: &Candidate, marker: &super::Marker| {
            let fitted = &candidate.fitted;
            fitted.place(marker.at(fitted.opening.unwrap_or(0.5)))
        };
        let squares = self
            .markers
            .iter()
            .map(|m| (place(a, m) - place(b, m)).norm_squared());
        (squares.sum::<f64>() / self.count() as f64).sqrt() > 2.0 * self.tolerance
    }

    fn describe(&self, best: &Candidate, points: usize) -> MarkerFit {
        let fitted = &best.fitted;
        let count = |is: fn(&Place) -> bool| best.places.iter().filter(|place| is(place)).count();
        let missing = count(|place| *place == Place::Missing);
        let with = count(|place| matches!(place, Place::With(_)));
        MarkerFit {
            position: fitted.translation.into(),
            orientation: fitted.quaternion().coords.into(),
            opening: fitted.opening.map(|opening| opening.clamp(0.0, 1.0)),
            rms: fitted.rms,
            seen: self.count() - missing,
            missing,
            merged: 2 * with,
            permuted: best.permuted,
            unknown: points - best.points,
            information: fitted.information,
        }
    }

    /// Points and the places where they belong.
    fn correspondences(&self, places: &[Place], points: &[MarkerPoint]) -> Vec<Correspondence> {
        let mut all = Vec::new();
        for (index, place) in places.iter().enumerate() {
            let Place::Point(point) = place else {
                continue;
            };
            let with = places.iter().position(|place| *place == Place::With(index));
            let own = &self.markers[index];
            let (mut closed, mut motion) = (Vector3::from(own.closed), own.motion());
            if let Some(with) = with {
                let other = &self.markers[with];
                closed = (closed + Vector3::from(other.closed)) * 0.5;
                motion = (motion + other.motion()) * 0.5;
            }
            all.push(Correspondence {
                closed,
                motion,
                point: points[*point].position.into(),
            });
        }
        all
    }

    /// The fit of an assignment, if there is one within the tolerance: with the opening where the points determine it, without where no marker that moves is among
    /// them.
    fn fit(&self, places: &[Place], points: &[MarkerPoint]) -> Option<Fitted> {
        let all = self.correspondences(places, points);
        let own: Vec<_> = all.iter().map(|c| c.closed + c.motion * 0.5).collect();
        if width(&own) < 5.0 * self.tolerance {
            return None;
        }
        let within = |fitted: &Fitted| fitted.rms <= self.tolerance;
        let moves = all.iter().any(|c| c.motion != Vector3::zeros());
        if !moves {
            return fit(&all, Some(0.5)).filter(within);
        }
        let free = fit(&all, None)?;
        // Known to a quarter where points are off by the tolerance.
        if free.opening_reach() >= 4.0 * self.tolerance {
            let opening = free.opening.unwrap_or(0.5);
            let is_one = (-BEYOND..=1.0 + BEYOND).contains(&opening);
            return Some(free).filter(|fitted| is_one && within(fitted));
        }
        // The markers that do not move alone.
        let still: Vec<_> = all
            .into_iter()
            .filter(|c| c.motion == Vector3::zeros())
            .collect();
        let own: Vec<_> = still.iter().map(|c| c.closed).collect();
        if still.len() < FEWEST_MARKERS || width(&own) < 5.0 * self.tolerance {
            return None;
        }
        fit(&still, Some(0.5)).filter(within)
    }
}

impl Search<'_> {
    /// Tries all places of the next marker.
    fn descend(&mut self) {
        self.tried += 1;
        if self.tried > MOST_TRIED {
            return;
        }
        let marker = self.places.len();
        let used = self.is_used.iter().filter(|used| **used).count();
        if used + (self.model.count() - marker) < self.most {
            return;
        }
        if marker == self.model.count() {
            self.finish(used);
            return;
        }
        for point in 0..self.points.len() {
            if !self.is_used[point] && self.agrees(marker, point) {
                self.is_used[point] = true;
                self.places.push(Place::Point(point));
                self.descend();
                self.places.pop();
                self.is_used[point] = false;
            }
        }
        for other in 0..marker {
            let is_free = !self.places.contains(&Place::With(other));
            let is_point = matches!(self.places[other], Place::Point(_));
            if is_free && is_point && self.model.distances(marker, other).0 <= self.model.merge {
                self.places.push(Place::With(other));
                self.descend();
                self.places.pop();
            }
        }
        self.places.push(Place::Missing);
        self.descend();
        self.places.pop();
    }

    /// Whether a point can be a marker as to its distances from those that are placed.
    fn agrees(&self, marker: usize, point: usize) -> bool {
        // Each point is off by a multiple of the tolerance at most, as the sum of squares is bounded; a merged one by half the distance of its markers as well.
        let slack = 2.0 * self.model.tolerance * (self.model.count() as f64).sqrt()
            + 0.5 * self.model.merge;
        let here = Vector3::from(self.points[point].position);
        let mut placed = self.places.iter().enumerate();
        placed.all(|(other, place)| match place {
            Place::Point(there) => {
                let (least, most) = self.model.distances(marker, other);
                let distance = (here - Vector3::from(self.points[*there].position)).norm();
                (least - slack..=most + slack).contains(&distance)
            }
            _ => true,
        })
    }

    fn finish(&mut self, used: usize) {
        let Some(fitted) = self.model.fit(&self.places, self.points) else {
            return;
        };
        if used > self.most {
            self.most = used;
            self.candidates.clear();
        }
        let wrong = |(marker, place): (usize, &Place)| match place {
            Place::Point(point) => self.points[*point].marker.is_some_and(|named| {
                // A merged point may have either name.
                named != marker && self.places.get(named) != Some(&Place::With(marker))
            }),
            _ => false,
        };
        self.candidates.push(Candidate {
            permuted: self
                .places
                .iter()
                .enumerate()
                .filter(|(marker, place)| wrong((*marker, place)))
                .count(),
            places: self.places.clone(),
            fitted,
            points: used,
        });
    }
}
