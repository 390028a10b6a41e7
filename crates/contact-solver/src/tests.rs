//! The three solvers on one problem, and what contacts among themselves do with a wrong response.

use crate::energy_line::EnergyLine;
use crate::reduced::Reduced;
use crate::solver::AddProduct;
use crate::vectors::norm_of_free;
use crate::{
    AugmentedLagrangian, Contact, ContactOptions, ContactSet, ContactSolver, GapConstraint,
    GaussSeidel, InteriorPoint, InteriorPointOptions, LinearSystem, NodalCompliance, NodalResponse,
    NodalSystem, SystemResponse, Tolerances,
};
use microsim_sparse::NotPositive;
use nalgebra::{Matrix3, Vector3};

const STIFFNESSES: [f64; 3] = [100.0, 40.0, 250.0];
const FRICTION: f64 = 0.4;

/// Nodes of these stiffnesses \[N/m\] rest on a floor; they are pushed so that one sticks, one slides and one lifts off.
fn pushes() -> [Vector3<f64>; 3] {
    [
        Vector3::new(0.03, 0.0, -0.1),
        Vector3::new(0.03, -0.05, -0.1),
        Vector3::new(0.01, 0.0, 0.1),
    ]
}

fn nodal() -> NodalSystem {
    NodalSystem::new(STIFFNESSES.to_vec())
}

fn misjudged() -> Misjudged {
    Misjudged(nodal(), -1e6)
}

fn contacts() -> Vec<Contact> {
    let on = |node| Contact {
        friction: FRICTION,
        ..Contact::of_node(node, Vector3::z(), 0.0)
    };
    (0..3).map(on).collect()
}

/// Contacts and displacements \[m\].
type Solution = (Vec<Contact>, Vec<Vector3<f64>>);

fn implicit<S>(mut solver: S, system: impl LinearSystem) -> Solution
where
    S: for<'a> ContactSolver<SystemResponse<'a>, Contacts = ContactSet>,
{
    // Coulomb's friction is that of the normal forces of the iteration before.
    iterate(&mut solver, system, 4, f64::INFINITY)
}

/// So many iterations of Newton's method, each with at most so many operations.
fn iterate<S>(
    solver: &mut S,
    mut system: impl LinearSystem,
    iterations: u32,
    most_operations: f64,
) -> Solution
where
    S: for<'a> ContactSolver<SystemResponse<'a>, Contacts = ContactSet>,
{
    let rest = [Vector3::zeros(); 3];
    let mut set = ContactSet::new(3, 1e-2, ContactOptions::default().augmented_lagrangian);
    let mut motion = rest.to_vec();
    set.contacts = contacts();
    for _ in 0..iterations {
        set.linearise(&rest, &rest, false, |node| STIFFNESSES[node]);
        motion.fill(Vector3::zeros());
        let response = SystemResponse {
            system: &mut system,
            forces: &pushes(),
            fixed: &[false; 3],
            tolerances: Tolerances {
                residual: 1e-10,
                changes: 1e-10,
                multipliers: 1e-10,
            },
            most_operations,
        };
        solver.solve(&mut set, response, &mut motion).unwrap();
        set.publish();
    }
    (set.contacts, motion)
}

fn explicit() -> Solution {
    let options = ContactOptions::default().gauss_seidel;
    let mut contacts = contacts();
    let mut compliance = NodalCompliance::default();
    compliance.set(&contacts, |node| 1.0 / STIFFNESSES[node]);
    let pushed = pushes().into_iter().zip(STIFFNESSES);
    let mut motion: Vec<Vector3<f64>> = pushed.map(|(force, k)| force / k).collect();
    let response = NodalResponse {
        compliance: &compliance,
        constraint: GapConstraint::Positions {
            start: &[Vector3::zeros(); 3],
        },
        sweeps: options.sweeps,
    };
    let mut solver = GaussSeidel::new(1e-2, options);
    solver.solve(&mut contacts, response, &mut motion).unwrap();
    (contacts, motion)
}

/// Closed forms: t = −push where |push| ≤ μ λ, else the bound against it; λ = push downwards.
#[test]
fn all_solvers_find_the_closed_form() {
    let options = ContactOptions::default();
    let solutions = [
        implicit(
            AugmentedLagrangian::new(3, options.augmented_lagrangian),
            nodal(),
        ),
        implicit(
            AugmentedLagrangian::new(3, options.augmented_lagrangian),
            misjudged(),
        ),
        implicit(InteriorPoint::new(3, options.interior_point), nodal()),
        explicit(),
    ];
    for (contacts, motion) in solutions {
        for (node, push) in pushes().iter().enumerate() {
            let contact = &contacts[node];
            let normal_force = (-push.z).max(0.0);
            let across = Vector3::new(push.x, push.y, 0.0);
            let bound = FRICTION * normal_force;
            let friction_force = -across * (bound / across.norm()).min(1.0);
            assert!((contact.normal_force - normal_force).abs() < 1e-6, "{node}");
            let error = (contact.friction_force - friction_force).norm();
            // The interior-point method retains a part of the friction force from before, a hundredth of the penalty.
            assert!(error < 2e-4, "{node}: {error} N");
            assert_eq!(contact.is_sliding, across.norm() > bound, "{node}");
            let force = push + contact.force();
            let error = (motion[node] - force / STIFFNESSES[node]).norm();
            assert!(error < 1e-8, "{node}: {error} m");
        }
    }
}

/// Nodes whose responses to forces of contacts come out as a multiple of what they are, as by cancellation in a factor of few digits; all else is right.
struct Misjudged(NodalSystem, f64);

impl LinearSystem for Misjudged {
    fn operations(&self) -> f64 {
        self.0.operations()
    }

    fn is_small(&self) -> bool {
        self.0.is_small()
    }

    fn add_contact(&mut self, contact: &Contact, block: &Matrix3<f64>) -> bool {
        self.0.add_contact(contact, block)
    }

    fn multiply(&self, p: &[Vector3<f64>], q: &mut [Vector3<f64>]) {
        self.0.multiply(p, q);
    }

    fn solve(&mut self, x: &mut [Vector3<f64>], tolerance: f64) -> Result<(), NotPositive> {
        self.0.solve(x, tolerance)
    }

    fn solve_with(
        &mut self,
        add: AddProduct<'_>,
        x: &mut [Vector3<f64>],
        tolerance: f64,
    ) -> Result<(), NotPositive> {
        self.0.solve_with(add, x, tolerance)
    }

    fn set_delassus(&mut self, rows: &[[(u32, Vector3<f64>); 4]], operator: &mut Vec<f64>) -> bool {
        let is_set = self.0.set_delassus(rows, operator);
        operator.iter_mut().for_each(|entry| *entry *= self.1);
        is_set
    }
}

/// A solution that has no operations left takes fewer than a whole one, and further iterations come to the same forces.
#[test]
fn what_is_cut_short_converges_in_more_iterations() {
    let options = ContactOptions::default().augmented_lagrangian;
    let operations = |iterations: u32, most: f64| {
        let mut solver = AugmentedLagrangian::new(3, options);
        let solution = iterate(&mut solver, nodal(), iterations, most);
        (solver.take_operations(), solution)
    };
    let (whole, (expected, _)) = operations(4, f64::INFINITY);
    let (one, _) = operations(1, f64::INFINITY);
    let (cut, _) = operations(1, 0.0);
    assert!(cut < one && one < whole, "{cut}, {one}, {whole}");
    let (_, (contacts, _)) = operations(100, 0.0);
    for (contact, expected) in contacts.iter().zip(&expected) {
        let error = (contact.force() - expected.force()).norm();
        assert!(error < 1e-8, "{error} N");
    }
}

/// A round that does not descend is dropped, and leaves all as it was: displacements, what is left of the forces, multipliers. Responses of the wrong sign, and none at
/// all, give such rounds; the right one does not.
#[test]
fn a_round_that_does_not_descend_changes_nothing() {
    /// Force of each contact in the step before \[N\].
    const GUESS: f64 = 0.05;
    let options = ContactOptions::default().augmented_lagrangian;
    let rest = [Vector3::zeros(); 3];
    let forces = pushes();
    let solve = |factor: f64| {
        let mut set = ContactSet::new(3, 1e-2, options);
        set.contacts = contacts();
        for contact in &mut set.contacts {
            contact.normal_force = GUESS;
        }
        set.linearise(&rest, &rest, false, |node| STIFFNESSES[node]);
        let [mut left, mut inner, mut product] = [forces; 3];
        let mut motion = rest;
        let tolerances = Tolerances {
            residual: 1e-10,
            changes: 1e-10,
            multipliers: 1e-10,
        };
        let mut system = Misjudged(nodal(), factor);
        let most = Reduced::new(options).solve(
            set.parts(),
            (&mut system, &[false; 3], tolerances),
            f64::INFINITY,
            norm_of_free(&forces, &[false; 3]),
            [&mut left, &mut inner, &mut product],
            &mut motion,
        );
        let (_, rows, _) = set.parts();
        let multipliers: Vec<f64> = rows.iter().map(|row| row.multiplier).collect();
        (most.unwrap().is_some(), motion, left, multipliers)
    };
    let unchanged = (false, rest, forces, vec![GUESS; 3]);
    assert_eq!(solve(f64::NAN), unchanged);
    let (is_solved, _, _, multipliers) = solve(1.0);
    assert!(is_solved && multipliers != [GUESS; 3]);
}

/// A node of 100 N/m that is pushed by 1 N against a contact that closes at half of the 10 mm that it would go; the penalty is ten times its stiffness. Lowest is the energy
/// where 1 N = 100 N/m · y + 1000 N/m · (y − 5 mm): at y = 6 N / 1100 N/m.
#[test]
fn an_energy_that_rises_is_lowest_where_the_forces_balance() {
    let options = ContactOptions::default().augmented_lagrangian;
    let rest = [Vector3::zeros()];
    let mut set = ContactSet::new(1, 1e-2, options);
    let lowest = |set: &mut ContactSet, gap: f64| {
        set.contacts = vec![Contact::of_node(0, -Vector3::z(), -gap)];
        set.linearise(&rest, &rest, true, |_| 100.0);
        let (contacts, rows, _) = set.parts();
        let step = [Vector3::z() * 10e-3];
        let [left, product] = [[Vector3::z()], [step[0] * 100.0]];
        let line = EnergyLine::new((contacts, rows), [&rest, &step], [&left, &product]);
        let length = line.lowest(line.slope_at(0.0), 0.0, options.bisections);
        (line.rises(0.0), length)
    };
    let (rises, length) = lowest(&mut set, 5e-3);
    assert!(rises);
    assert!((length * 10e-3 - 6.0 / 1100.0).abs() < 1e-10, "{length}");
    assert_eq!(
        lowest(&mut set, 20e-3),
        (false, 1.0),
        "it closes behind the end"
    );
}

/// Ten nodes on a floor are pushed down by 1 to 10 N, and there is room for six directions: the six that press most have their forces, along the
/// normal alone; the others push as springs of no force yet.
#[test]
fn the_contacts_that_press_most_take_part_where_there_is_no_room_for_all() {
    let stiffness = 1e3;
    let rest = [Vector3::zeros(); 10];
    let options = ContactOptions::default();
    let mut set = ContactSet::new(10, 1e-2, options.augmented_lagrangian);
    set.contacts = (0..10)
        .map(|node| Contact {
            friction: FRICTION,
            ..Contact::of_node(node, Vector3::z(), 0.0)
        })
        .collect();
    set.linearise(&rest, &rest, false, |_| stiffness);
    // Not in the order of their nodes.
    let force = |node: usize| 1.0 + ((7 * node) % 10) as f64;
    let forces: Vec<Vector3<f64>> = (0..10).map(|n| Vector3::z() * -force(n)).collect();
    let mut motion = rest.to_vec();
    let response = SystemResponse {
        system: &mut NodalSystem::new(vec![stiffness; 10]),
        forces: &forces,
        fixed: &[false; 10],
        tolerances: Tolerances {
            residual: 1e-10,
            changes: 1e-10,
            multipliers: 1e-10,
        },
        most_operations: f64::INFINITY,
    };
    let few = InteriorPointOptions {
        directions: 6,
        ..options.interior_point
    };
    let mut solver = InteriorPoint::new(10, few);
    solver.solve(&mut set, response, &mut motion).unwrap();
    set.publish();
    for (node, contact) in set.contacts.iter().enumerate() {
        let expected = if force(node) > 4.5 { force(node) } else { 0.0 };
        // The regularisation of a contact is a thousandth of its compliance over the penalty.
        assert!((contact.normal_force - expected).abs() <= 1e-3 * force(node));
        assert_eq!(contact.friction_force, Vector3::zeros());
        let depth = (force(node) - contact.normal_force) / stiffness;
        assert!((motion[node].z + depth).abs() < 1e-9, "{node}");
    }
}
