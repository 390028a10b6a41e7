//! Laws, discretisations, methods and meshes.

use crate::{Unit, terms};

terms! {
    /// The material laws of continua.
    pub enum LawName {
        /// St Venant–Kirchhoff elasticity.
        StVenantKirchhoff = "st-venant-kirchhoff",
        /// Compressible neo-Hookean elasticity with a logarithm.
        NeoHookean = "neo-hookean",
        /// Corotational linear elasticity.
        Corotational = "corotational",
        /// Stable neo-Hookean elasticity (Smith, de Goes, Kim 2018).
        StableNeoHookean = "stable-neo-hookean",
        /// Neo-Hookean elasticity without a logarithm: it is finite for inverted elements.
        NeoHookeanPolynomial = "neo-hookean-polynomial",
        /// Compressible Mooney–Rivlin elasticity (Ciarlet & Geymonat 1982).
        MooneyRivlin = "mooney-rivlin",
        /// Neo-Hookean elasticity with one family of fibres (Qiu & Pence 1997).
        TransverselyIsotropic = "transversely-isotropic",
        /// Arterial walls: two families of dispersed fibres in a neo-Hookean matrix (Holzapfel, Gasser & Ogden 2000; Gasser et al. 2006; with
        /// full invariants Nolan et al. 2014).
        HolzapfelGasserOgden = "holzapfel-gasser-ogden",
        /// The same with fibres of the isochoric deformation, which swell under tension: for comparison.
        HolzapfelGasserOgdenIsochoric = "holzapfel-gasser-ogden-isochoric",
    }
}

impl LawName {
    /// Whether explicit methods at their largest step hold it at strains of 25 to 40 %. Others stiffen, become unstable under strong
    /// compression (St Venant–Kirchhoff), or have no energy for inverted elements (those with a logarithm).
    pub const fn is_stable_in_large_strain(self) -> bool {
        match self {
            Self::StVenantKirchhoff
            | Self::NeoHookean
            | Self::MooneyRivlin
            | Self::TransverselyIsotropic
            | Self::HolzapfelGasserOgden
            | Self::HolzapfelGasserOgdenIsochoric => false,
            Self::Corotational | Self::StableNeoHookean | Self::NeoHookeanPolynomial => true,
        }
    }

    /// How many families of fibres it has, each with a direction in every element.
    pub const fn families(self) -> usize {
        match self {
            Self::TransverselyIsotropic => 1,
            Self::HolzapfelGasserOgden | Self::HolzapfelGasserOgdenIsochoric => 2,
            Self::StVenantKirchhoff
            | Self::NeoHookean
            | Self::Corotational
            | Self::StableNeoHookean
            | Self::NeoHookeanPolynomial
            | Self::MooneyRivlin => 0,
        }
    }

    /// Whether the volumetric part of its energy is a function of J = det F alone, so that a change of shape at constant volume, as plastic flow
    /// is one, leaves it as it is. Those of St Venant–Kirchhoff and the corotational law are functions of a trace of the strain.
    pub const fn is_volumetric_of_j(self) -> bool {
        match self {
            Self::StVenantKirchhoff | Self::Corotational => false,
            Self::NeoHookean
            | Self::StableNeoHookean
            | Self::NeoHookeanPolynomial
            | Self::MooneyRivlin
            | Self::TransverselyIsotropic
            | Self::HolzapfelGasserOgden
            | Self::HolzapfelGasserOgdenIsochoric => true,
        }
    }

    /// The keys in files of what the law needs beside E and ν, with their units.
    pub const fn parameters(self) -> &'static [(&'static str, Unit)] {
        match self {
            Self::MooneyRivlin => &[("c01_fraction", Unit::Ratio)],
            Self::TransverselyIsotropic => &[("fibre_ratio", Unit::Ratio)],
            Self::HolzapfelGasserOgden | Self::HolzapfelGasserOgdenIsochoric => &[
                ("fibre_stiffness", Unit::Pressure),
                ("fibre_exponent", Unit::Ratio),
                ("fibre_dispersion", Unit::Ratio),
            ],
            Self::StVenantKirchhoff
            | Self::NeoHookean
            | Self::Corotational
            | Self::StableNeoHookean
            | Self::NeoHookeanPolynomial => &[],
        }
    }
}

terms! {
    /// How the tetrahedra of a mesh carry a continuum.
    ///
    /// Linear tetrahedra are too stiff in bending, and lock when the tissue is nearly incompressible: more volumes want to be preserved
    /// than nodes can move (NUMERICS 1.6). Fraction of the right static sag of the cantilever there (quadratic hexahedra, 34.43, 33.87
    /// and 33.7 mm) with the neo-Hookean law at ν = 0.3 / 0.45 / 0.49, largest explicit step on M at ν = 0.49:
    ///
    /// | | S, 3 cells high | M, 7 cells high | step |
    /// |---|---|---|---|
    /// | tetrahedra | 73 / 53 / 25 % | 93 / 84 / 58 % | 42 µs |
    /// | edge-smoothed | 98 / 91 / 74 % | 100 / 99 / 95 % | 47 µs |
    /// | node-smoothed | 116 / 114 / 112 % | 104 / 104 / 103 % | 54 µs |
    /// | selective | 101 / 97 / 93 % | 101 / 100 / 99 % | 54 µs |
    /// | nodal-pressure | 80 / 77 / 73 % | 96 / 94 / 93 % | 53 µs |
    /// | patch-pressure | 81 / 80 / 79 % | 96 / 95 / 95 % | |
    ///
    /// The other laws differ by less than 1 % (the last row is that of the stable neo-Hookean law). Take selective where it can be paid
    /// for, and patch-pressure with implicit methods in real time: its matrices couple hardly more nodes than those of tetrahedra. A
    /// static solution of M takes 1.5 (ν = 0.3) to 2.5 times (0.49) as long as with tetrahedra, with nodal-pressure 3.5 to 5 times, with
    /// selective 4 to 7 times (`microsim chart --quick`; `cargo xtask bench kernels` and `bench solvers` have the parts).
    ///
    /// For bodies that are not cut there are quadratic tetrahedra, which need far fewer cells. The same with theirs:
    ///
    /// | | 4 × 1 × 1 cells, 81 nodes | 8 × 2 × 2, 425 nodes | those of S, 1519 nodes |
    /// |---|---|---|---|
    /// | quadratic | 96 / 87 / 79 % | 99 / 96 / 93 % | 100 / 99 / 98 % |
    /// | quadratic-pressure | 99 / 103 / 103 % | 100 / 100 / 100 % | 100 / 100 / 100 % |
    ///
    /// Released at ν = 0.3, 5 × 1 × 1 cells of quadratic-pressure reach the first peak of the exact beam within 0.7 % in height and in time, at
    /// 0.017 s of one core per second (implicit midpoint, one iteration, steps of 10 ms); edge-smoothed on S within 1.9 and 0.9 % at 0.19 s.
    pub enum Discretisation {
        /// The tetrahedra themselves.
        Tetrahedra = "tetrahedra",
        /// Domains around edges (ES-FEM-T4). Right in bending, locks late.
        EdgeSmoothed = "edge-smoothed",
        /// Domains around nodes (NS-FEM-T4). Does not lock, but is too soft: no mode without energy, yet a crowd of short waves with
        /// hardly any. In a free block of 4 × 3 × 3 cells the 14 lowest modes lie between 46 and 61 Hz, the lowest with
        /// tetrahedra is at 80, around edges at 63 Hz.
        NodeSmoothed = "node-smoothed",
        /// The part of μ around edges, the part of λ around nodes (selective ES/NS-FEM-T4; Onishi, Amaya 2014). Neither locks nor
        /// has soft short waves.
        Selective = "selective",
        /// The part of μ in tetrahedra, the part of λ around nodes: the pressure of the averaged volume of a node (after Bonet &
        /// Burton 1998; their volume is the mean of the volumes, here it is that of the mean deformation gradient). Does not lock,
        /// but stays as stiff in bending as tetrahedra without pressure.
        NodalPressure = "nodal-pressure",
        /// The part of μ in tetrahedra, the part of λ in patches of about five around a common edge: one pressure for each, of the volume
        /// of the mean deformation gradient (after the patches of de Souza Neto et al. 2005). Does not lock: there are fewer patches than
        /// nodes. As stiff in bending as nodal-pressure. After a cut the patches that it touched are formed again.
        PatchPressure = "patch-pressure",
        /// Quadratic tetrahedra of ten nodes, four points of quadrature each: the mesh is refined once, and the eight parts of each of its
        /// tetrahedra are one element. Masses, surface, contact, loads and stresses are those of the parts; on a tube they are curved. Right in bending with
        /// one cell through the height, locks late. For bodies that are not cut.
        Quadratic = "quadratic",
        /// Quadratic tetrahedra in which of the part of λ only as much as λ = μ is at the points of quadrature, and the rest is that of the mean
        /// deformation gradient: one more pressure per element. Does not lock, and is never so soft as with all of λ averaged, which sags 9 to
        /// 13 % too far with one cell through the height. Up to ν = 1/4 it is quadratic itself. For bodies that are not cut.
        QuadraticPressure = "quadratic-pressure",
    }
}

impl Discretisation {
    /// Whether the volumes of single tetrahedra make the body too stiff at this Poisson's ratio: from there on the cantilever S,
    /// of quadratic ones that of 4 × 1 × 1 cells, loses at least 7 % of its sag to them.
    pub fn locks(self, poisson: f64) -> bool {
        match self {
            Self::Tetrahedra => poisson >= 0.4,
            Self::EdgeSmoothed | Self::Quadratic => poisson >= 0.45,
            Self::NodeSmoothed
            | Self::Selective
            | Self::NodalPressure
            | Self::PatchPressure
            | Self::QuadraticPressure => false,
        }
    }

    /// Whether the volumetric part of the energy, or some of it, is integrated over other domains than the isochoric part.
    pub const fn is_split(self) -> bool {
        match self {
            Self::Selective
            | Self::NodalPressure
            | Self::PatchPressure
            | Self::QuadraticPressure => true,
            Self::Tetrahedra | Self::EdgeSmoothed | Self::NodeSmoothed | Self::Quadratic => false,
        }
    }

    /// Whether its elements are the tetrahedra of a mesh that is refined once: of ten nodes each.
    pub const fn is_quadratic(self) -> bool {
        matches!(self, Self::Quadratic | Self::QuadraticPressure)
    }
}

terms! {
    /// The integrators and solvers of the equations of motion.
    pub enum MethodName {
        /// Störmer–Verlet in its joint form, drag by the exact factor.
        StoermerVerlet = "stoermer-verlet",
        /// Explicit Euler (3.12, 3.13).
        ExplicitEuler = "explicit-euler",
        /// Symplectic Euler.
        SymplecticEuler = "symplectic-euler",
        /// Velocity Verlet in its standard form, drag by the exact factor.
        VelocityVerlet = "velocity-verlet",
        /// Velocity Verlet as a loop with stored values of the step before (3.19, 3.20 as printed), drag from the old velocity.
        VelocityVerletLagged = "velocity-verlet-lagged",
        /// Backward Euler.
        ImplicitEuler = "implicit-euler",
        /// Implicit midpoint. Without damping large swings slowly gain energy.
        ImplicitMidpoint = "implicit-midpoint",
        /// Implicit midpoint that drops speed where a tetrahedron is distorted. Without damping large swings slowly gain energy: 4.4 times in 28 s
        /// of a beam that swings by half of its length, at steps of 1 ms.
        GuardedMidpoint = "guarded-midpoint",
        /// Second-order L-stable Runge–Kutta method of two implicit stages.
        Sdirk2 = "sdirk2",
        /// Static equilibrium at the end of each step.
        QuasiStatic = "quasi-static",
        /// Position-based dynamics with compliance.
        Xpbd = "xpbd",
    }
}

impl MethodName {
    /// The keys in files of the parameters that the method has.
    pub const fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::ImplicitEuler
            | Self::ImplicitMidpoint
            | Self::GuardedMidpoint
            | Self::Sdirk2
            | Self::QuasiStatic => &["iterations", "tolerance", "must_converge", "repeat_invalid"],
            Self::Xpbd => &["iterations", "substeps"],
            Self::StoermerVerlet
            | Self::ExplicitEuler
            | Self::SymplecticEuler
            | Self::VelocityVerlet
            | Self::VelocityVerletLagged => &[],
        }
    }
}

terms! {
    /// How the cells of a mesh generator are cut into six tetrahedra each: along one space diagonal, one tetrahedron per order in
    /// which the three axes are walked from its start to its end.
    #[derive(Default)]
    pub enum CellSplit {
        /// Every cell alike (Kuhn, Freudenthal). Fits any number of cells, also around a ring, but all diagonals point in
        /// one direction: the mesh is not isotropic.
        Kuhn = "kuhn" default,
        /// Every second cell along each axis is the mirror image of its neighbour, so that the diagonals alternate and no
        /// direction is preferred. A ring needs an even number of cells.
        Mirrored = "mirrored",
        /// Five tetrahedra: one in the middle of the cell and four at its corners, mirrored as well. Of a wall with fibres linear elements are most
        /// accurate so. A ring needs an even number of cells.
        Five = "five",
    }
}

terms! {
    /// How a closed surface is filled with tetrahedra.
    #[derive(Default)]
    pub enum Filling {
        /// A body-centred lattice cut along the surface (isosurface stuffing): the boundary lies on the surface, and the angles of elements are bounded.
        Stuffing = "stuffing" default,
        /// A lattice of cubes of five tetrahedra whose boundary is moved onto the surface step by step (dissertation 3.3): fewer elements, flatter ones at
        /// the surface, and off it at sharp edges.
        FittedLattice = "fitted-lattice",
    }
}

impl CellSplit {
    /// Number of tetrahedra of a cell.
    pub const fn tetrahedra(self) -> usize {
        match self {
            Self::Kuhn | Self::Mirrored => 6,
            Self::Five => 5,
        }
    }
}

terms! {
    /// What had to be done about a node of a body, or about an element at it, so that the body could be computed.
    pub enum Remedy {
        /// It has more inertia than mass, so that the step is stable there.
        Inertia = "inertia",
        /// An element at it is turned inside out, and comes back.
        Inverted = "inverted",
        /// An overlap from before a step was undone at it.
        Overlap = "overlap",
        /// Its body diverged, and the tick was computed again with shorter steps.
        Repeated = "repeated",
        /// Its body has become so stiff that its steps are shorter than at rest.
        Stiffened = "stiffened",
        /// Its body diverged in every try, and is held at its last good state.
        Held = "held",
    }
}

impl Remedy {
    /// The bit that stands for it where there may be several.
    pub const fn bit(self) -> u32 {
        1 << self as u32
    }
}
