//! Where the spheres lie and from where each must be touched: by level and seed alone, never by a recording.

use microsim_sdk::tissue::distance;
use microsim_sdk::{Fault, RandomStream};

/// Attempts to find room for one sphere before a level is called too crowded.
const ATTEMPTS: u32 = 10_000;
/// Smallest distance of two centres, in radii: spheres are distinct and can be touched one at a time.
const DISTANCE_IN_RADII: f64 = 2.5;

/// One sphere to touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Centre in the field \[m\].
    pub centre: [f64; 3],
    /// Unit vector from the tip to the handle of a tool at the right angle, field frame.
    pub direction: [f64; 3],
}

/// Places `count` spheres of `radius` \[m\] with centres in the box ±`spread` \[m\], directions uniform in the cone of
/// half angle `direction_max` \[rad\] about the vertical.
pub fn places(
    seed: u64,
    count: usize,
    radius: f64,
    spread: [f64; 3],
    direction_max: f64,
) -> Result<Vec<Place>, Fault> {
    let mut random = RandomStream::new(seed, "touch-spheres.places");
    let mut places: Vec<Place> = Vec::new();
    for _ in 0..count {
        let free = |centre: [f64; 3]| {
            places
                .iter()
                .all(|p| distance(p.centre, centre) >= DISTANCE_IN_RADII * radius)
        };
        let found = (0..ATTEMPTS)
            .map(|_| spread.map(|half| random.between(-half, half)))
            .find(|centre| free(*centre));
        let centre = found.ok_or_else(|| {
            Fault::new(format!(
                "{count} spheres of this size do not fit into `spread`; make it larger"
            ))
        })?;
        // Uniform on the spherical cap: the cosine of the zenith angle is uniform.
        let cosine = random.between(libm::cos(direction_max), 1.0);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let azimuth = random.between(0.0, std::f64::consts::TAU);
        let direction = [sine * libm::cos(azimuth), sine * libm::sin(azimuth), cosine];
        places.push(Place { centre, direction });
    }
    Ok(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_keep_their_distance_box_and_cone() {
        let (radius, spread, cone) = (1e-3, [8e-3, 6e-3, 2e-3], 0.5);
        for seed in 0..200 {
            let places = places(seed, 8, radius, spread, cone).unwrap();
            for (i, place) in places.iter().enumerate() {
                assert!(place.centre.iter().zip(spread).all(|(c, s)| c.abs() <= s));
                assert!((distance(place.direction, [0.0; 3]) - 1.0).abs() < 1e-15);
                assert!(place.direction[2] >= libm::cos(cone));
                for other in &places[..i] {
                    assert!(distance(place.centre, other.centre) >= DISTANCE_IN_RADII * radius);
                }
            }
        }
    }

    #[test]
    fn the_seed_decides_and_a_crowd_is_refused() {
        let of = |seed| places(seed, 4, 1e-3, [8e-3; 3], 0.3).unwrap();
        assert_eq!(of(1), of(1));
        assert_ne!(of(1), of(2));
        assert!(
            places(1, 50, 3e-3, [2e-3; 3], 0.3)
                .unwrap_err()
                .text
                .contains("spread")
        );
    }
}
