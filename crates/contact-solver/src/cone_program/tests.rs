//! The conditions of Signorini and Tresca, which no other solution of the convex problem has, on random contacts; and what has no solution.

use super::*;
use microsim_random::Congruential;

/// A fixed sequence of numbers in −1..1.
fn numbers() -> impl FnMut() -> f64 {
    let mut random = Congruential(7);
    move || random.number()
}

/// Of the largest motion: the tolerance is one of products of force and motion, so where both are next to nothing each is its root, 3e-5,
/// times that of the ratio of the compliances, below 100.
const MOTIONS: f64 = 3e-4;
/// Compliances of contacts by themselves, relative to the others.
const OWN: f64 = 1e-4;

/// Contacts with friction, their forces coupled by a random compliance of so many nodes; motions of about 1, downwards by `depth`.
struct Case {
    compliance: Vec<f64>,
    own: Vec<f64>,
    motions: Vec<f64>,
    cones: Vec<Cone>,
}

fn case(next: &mut impl FnMut() -> f64, contacts: usize, freedoms: usize, depth: f64) -> Case {
    let count = 3 * contacts;
    let half: Vec<f64> = (0..count * freedoms).map(|_| next()).collect();
    let mut compliance = vec![0.0; count * count];
    for i in 0..count {
        for j in 0..count {
            let rows = half[i * freedoms..][..freedoms].iter();
            let pairs = rows.zip(&half[j * freedoms..][..freedoms]);
            compliance[i * count + j] = pairs.map(|(a, b)| a * b).sum();
        }
    }
    let mut motions: Vec<f64> = (0..count).map(|_| next()).collect();
    motions
        .iter_mut()
        .step_by(3)
        .for_each(|motion| *motion -= depth);
    // Some without friction, others with a little and much of it.
    let bounds: Vec<f64> = (0..contacts)
        .map(|k| [0.0, 0.01, 1.0][k % 3] * (1.0 + next().abs()))
        .collect();
    let cones = bounds.into_iter().enumerate();
    Case {
        compliance,
        own: vec![OWN; count],
        motions,
        cones: cones.map(|(k, bound)| Cone::new(3 * k, bound)).collect(),
    }
}

impl Case {
    fn solve(&mut self) -> (bool, Vec<f64>) {
        let guess = vec![0.0; self.motions.len()];
        self.solve_from(guess, InteriorPointOptions::default())
    }

    fn solve_from(
        &mut self,
        mut forces: Vec<f64>,
        options: InteriorPointOptions,
    ) -> (bool, Vec<f64>) {
        let found = ConeProgram::new(options).solve(
            &self.compliance,
            &self.own,
            &self.motions,
            &mut self.cones,
            &mut forces,
        );
        (found, forces)
    }

    /// Both, without coupling: this one and one of pieces that are lighter by this factor.
    fn beside(self, light: Self, factor: f64) -> Self {
        let [own, other] = [&self, &light].map(|case| case.motions.len());
        let count = own + other;
        let mut compliance = vec![0.0; count * count];
        for i in 0..own {
            compliance[i * count..][..own].copy_from_slice(&self.compliance[i * own..][..own]);
        }
        for i in 0..other {
            let entries = light.compliance[i * other..][..other].iter();
            let row = compliance[(own + i) * count + own..].iter_mut();
            row.zip(entries).for_each(|(to, from)| *to = from * factor);
        }
        let lighter = light
            .cones
            .iter()
            .map(|cone| Cone::new(own + cone.first, cone.bound / factor));
        Self {
            compliance,
            own: [self.own, vec![OWN * factor; other]].concat(),
            motions: [self.motions, light.motions].concat(),
            cones: self.cones.into_iter().chain(lighter).collect(),
        }
    }

    /// The motions with these forces.
    fn motions_with(&self, forces: &[f64]) -> Vec<f64> {
        let count = forces.len();
        let row = |i: usize| {
            let pairs = self.compliance[i * count..][..count].iter().zip(forces);
            pairs.map(|(c, f)| c * f).sum::<f64>() + self.own[i] * forces[i] + self.motions[i]
        };
        (0..count).map(row).collect()
    }

    fn check(&mut self) -> [usize; 4] {
        let (found, forces) = self.solve();
        assert!(found);
        let motions = self.motions_with(&forces);
        let reach = self
            .motions
            .iter()
            .fold(0.0, |most: f64, w| most.max(w.abs()));
        let little = MOTIONS * reach;
        let mut kinds = [0; 4];
        for cone in &self.cones {
            let k = cone.first;
            let [x, y] = [motions[k + 1], motions[k + 2]];
            let [a, b] = [forces[k + 1], forces[k + 2]];
            // Signorini: not below the floor, no force above it.
            assert!(
                forces[k] >= 0.0 && motions[k] >= -little,
                "{} {}",
                forces[k],
                motions[k]
            );
            let closed = forces[k] > 0.0;
            assert!(
                !closed || motions[k] <= little,
                "{} N at {} m",
                forces[k],
                motions[k]
            );
            kinds[usize::from(closed)] += 1;
            if cone.bound == 0.0 {
                assert_eq!([a, b], [0.0; 2]);
                assert!(!cone.sticks);
                continue;
            }
            // Tresca: what sticks does not slide, what slides does so straight against all that the bound allows.
            let size = (a * a + b * b).sqrt();
            assert!(size <= cone.bound * (1.0 + 1e-12));
            let slide = (x * x + y * y).sqrt();
            kinds[2 + usize::from(cone.sticks)] += 1;
            if cone.sticks {
                assert!(slide <= little, "sticks and slides by {slide}");
            } else {
                assert!(
                    size >= cone.bound * (1.0 - 1e-12),
                    "{size} of {}",
                    cone.bound
                );
                assert!(
                    (a * x + b * y) <= -size * slide + little * size,
                    "not against it"
                );
            }
        }
        kinds
    }
}

#[test]
fn random_contacts_obey_signorini_and_tresca() {
    let mut next = numbers();
    let mut kinds = [0; 4];
    for contacts in [1, 2, 6, 15] {
        for _ in 0..40 {
            let mut case = case(&mut next, contacts, 3 * contacts, 0.3);
            let found = case.check();
            kinds
                .iter_mut()
                .zip(found)
                .for_each(|(sum, one)| *sum += one);
        }
    }
    // Open, closed, sliding, sticking: each of them many times.
    assert!(kinds.iter().all(|kind| *kind > 50), "{kinds:?}");
}

/// Fewer nodes than contacts hold: only their own compliance decides which has how much.
#[test]
fn contacts_of_the_same_nodes_divide_the_force() {
    let mut next = numbers();
    for _ in 0..40 {
        case(&mut next, 8, 4, 0.5).check();
    }
}

/// A crumb of tissue between jaws that hold a piece: rounding ends the iterations before the tolerance. What is found then are the forces, and
/// not the guess: to a thousandth of the motions.
#[test]
fn forces_are_found_where_rounding_ends_the_iterations() {
    let mut next = numbers();
    let strict = InteriorPointOptions {
        rounding: 0.0,
        ..InteriorPointOptions::default()
    };
    let mut ended = 0;
    for _ in 0..200 {
        let piece = case(&mut next, 7, 21, 0.5);
        let mut case = piece.beside(case(&mut next, 3, 3, 0.5), 1e5);
        let guess = vec![0.0; 30];
        ended += u32::from(!case.solve_from(guess, strict).0);
        let (found, forces) = case.solve();
        assert!(found);
        let motions = case.motions_with(&forces);
        let reach = case.motions.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
        for cone in &case.cones {
            let k = cone.first;
            assert!(forces[k] >= 0.0 && motions[k] >= -1e-3 * reach);
            assert!(forces[k] == 0.0 || motions[k] <= 1e-3 * reach);
        }
    }
    assert!(ended > 0, "no case of it");
}

/// Motions are the same whatever the guess.
#[test]
fn guesses_make_no_difference() {
    let mut next = numbers();
    for _ in 0..200 {
        let mut case = case(&mut next, 7, 21, 0.3);
        let (found, forces) = case.solve();
        assert!(found);
        let most = forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        let mut guess: Vec<f64> = (0..21).map(|_| most * next()).collect();
        for cone in &case.cones {
            guess[cone.first] = if next() > 0.0 { 0.0 } else { most };
            if cone.bound == 0.0 {
                guess[cone.first + 1..][..2].fill(0.0);
            }
        }
        let (found, again) = case.solve_from(guess, InteriorPointOptions::default());
        assert!(found);
        let reach = case.motions.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
        let both = [forces, again].map(|forces| case.motions_with(&forces));
        for (one, other) in both[0].iter().zip(&both[1]) {
            assert!((one - other).abs() <= MOTIONS * reach, "{one} {other}");
        }
    }
}

/// The scale of forces is that of the start: there is none at the end.
#[test]
fn contacts_that_all_open_have_no_force() {
    let mut next = numbers();
    for _ in 0..40 {
        let mut case = case(&mut next, 6, 18, -2.0);
        case.cones.iter_mut().for_each(|cone| cone.bound = 0.0);
        let (found, forces) = case.solve();
        assert!(found);
        // Weakly coupled and a gap of one to three each: no force closes any.
        assert_eq!(forces, vec![0.0; 18]);
        case.check();
    }
}

/// No motion, no force; and no solution where there is no number.
#[test]
fn nothing_to_solve_and_nothing_to_be_solved() {
    let mut next = numbers();
    let mut still = case(&mut next, 3, 9, 0.0);
    still.motions.fill(0.0);
    let (found, forces) = still.solve();
    assert!(
        found && forces.iter().all(|force| force.abs() < 1e-100),
        "{forces:?}"
    );
    for broken in [f64::NAN, f64::INFINITY] {
        let mut case = case(&mut next, 3, 9, 0.5);
        case.motions[3] = broken;
        let mut forces = vec![0.25; 9];
        let found = ConeProgram::new(InteriorPointOptions::default()).solve(
            &case.compliance,
            &case.own,
            &case.motions,
            &mut case.cones,
            &mut forces,
        );
        assert!(!found);
        assert_eq!(forces, vec![0.25; 9], "the guess stays");
    }
}
