//! The keys of a body, which levels and scenes share.

use crate::body::{Generator, Law, SpringForm};
use crate::schema::{Form, Key, Kind};
use microsim_vocabulary::{CellSplit, Discretisation, Finish, Unit};
use serde_json::json;

/// Largest coordinate and size \[m\].
pub const LENGTH_MAX: f64 = 1.0;
/// Smallest size of anything: a micrometre \[m\].
pub(crate) const LENGTH_MIN: f64 = 1e-6;

/// The keys of a body.
pub(crate) fn body_keys() -> Vec<Key> {
    let cells = |max| Kind::Integer { min: 1, max };
    let side_cells = Kind::List {
        of: Box::new(cells(500)),
        min: 3,
        max: 3,
    };
    let materials = Kind::List {
        of: Box::new(Kind::Table(material_keys())),
        min: 1,
        max: 64,
    };
    vec![
        Key::required("name", Kind::Name(Form::Identifier), "Its name."),
        Key::required(
            "generator",
            Kind::choice(&Generator::NAMES),
            "What makes its mesh: `block`, a regular box of tetrahedra; `tube`, the wall of a vessel; `file`, a mesh or a closed surface that is filled.",
        ),
        Key::optional("size", size3(), "Of a block: its sides."),
        Key::optional(
            "cells",
            side_cells,
            "Of a block: cells along each side; each cell is six tetrahedra.",
        ),
        Key::optional("inner_radius", size(), "Of a tube: radius of the lumen."),
        Key::list(
            "layer",
            Kind::Table(layer_keys()),
            16,
            "Of a tube: the layers of its wall, from the inside.",
        ),
        Key::optional("length", size(), "Of a tube: along its axis."),
        Key::optional("around", cells(1000), "Of a tube: cells around it."),
        Key::optional("along", cells(1000), "Of a tube: cells along it."),
        Key::optional(
            "axis",
            Kind::Direction,
            "Of a tube: direction of its axis; x if left out.",
        ),
        Key::optional(
            "arc_start",
            Kind::quantity(Unit::Angle, -360_f64.to_radians(), 360_f64.to_radians()),
            "Of a tube: where its sector begins; 0 if left out.",
        ),
        Key::optional(
            "arc",
            Kind::quantity(Unit::Angle, 0.1_f64.to_radians(), 359.9_f64.to_radians()),
            "Of a tube: angle of its sector; closed around if left out.",
        ),
        Key::optional(
            "split",
            Kind::choice(&CellSplit::NAMES),
            "Of a block or tube: how cells are cut, `kuhn` (all alike, if left out) or `mirrored`.",
        ),
        Key::optional(
            "file",
            Kind::Name(Form::RelativePath),
            "Of a file: its path from the folder of this one. Tetrahedra: .msh, .vtk, .vtu, .node with .ele; closed surfaces: .obj, .stl.",
        ),
        Key::optional(
            "scale",
            Kind::quantity(Unit::Length, 1e-9, 1e3),
            "Of a file: length of one unit in it; 1 m if left out.",
        ),
        Key::optional(
            "fill",
            size(),
            "Of a file with a closed surface: size of the cells that fill it.",
        ),
        Key::with_default(
            "centre",
            point(),
            "Middle of a block or tube, place of the origin of a file, in the frame of the field: origin of the body's frame.",
            json!([0.0, 0.0, 0.0]),
        ),
        Key::with_default(
            "drag",
            Kind::quantity(Unit::Rate, 0.0, 1e5),
            "Drag per mass: a free body loses its speed at this rate.",
            0.0,
        ),
        Key::with_default(
            "colour",
            Kind::Colour,
            "Colour in pictures, sRGB.",
            "#c8c8c8",
        ),
        Key::with_default(
            "finish",
            Kind::choice(&Finish::NAMES),
            "How its surface answers light in pictures.",
            "moist",
        ),
        Key::optional(
            "toughness",
            Kind::quantity(Unit::LengthStiffness, 1e-6, 1e6),
            "Force per length of a perfectly sharp edge that cuts it (work per area); without it no single edge cuts it.",
        ),
        Key::with_default(
            "brittleness",
            Kind::quantity(Unit::Ratio, 0.0, 1.0),
            "How early jaws that close on it pinch it off, from 0, never, like rubber, to 1.",
            0.0,
        ),
        Key::required("material", materials, "What its regions are made of."),
        Key::list(
            "clamp",
            Kind::Table(clamp_keys()),
            64,
            "What holds some of its nodes.",
        ),
        Key::list(
            "coupling",
            Kind::Table(coupling_keys()),
            16,
            "What joins regions that share no nodes: soft and two-sided.",
        ),
        Key::list(
            "load",
            Kind::Table(load_keys()),
            16,
            "What acts on its surface.",
        ),
        Key::list(
            "start",
            Kind::Table(start_keys()),
            16,
            "How it lies and moves at the start, other than at rest; one after the other.",
        ),
    ]
}

fn layer_keys() -> Vec<Key> {
    vec![
        Key::required("thickness", size(), "Of the layer."),
        Key::required(
            "cells",
            Kind::Integer { min: 1, max: 100 },
            "Cells through the layer.",
        ),
        Key::with_default("region", region(), "Region of its elements.", 0),
    ]
}

/// The keys of a selection of nodes.
pub(crate) fn nodes_keys() -> Vec<Key> {
    let radius = Kind::Vector {
        unit: Unit::Length,
        len: 2,
        min: 0.0,
        max: LENGTH_MAX,
    };
    let shell = vec![
        Key::with_default(
            "point",
            point(),
            "A point of the axis, in the body's frame.",
            json!([0.0, 0.0, 0.0]),
        ),
        Key::with_default(
            "axis",
            Kind::Direction,
            "Direction of the axis.",
            json!([1.0, 0.0, 0.0]),
        ),
        Key::required("radius", radius, "Smallest and largest distance from it."),
    ];
    vec![
        Key::optional(
            "min",
            point(),
            "Corner with the smallest coordinates of a box, in the body's frame; needs `max`.",
        ),
        Key::optional(
            "max",
            point(),
            "Corner with the largest coordinates of the box; needs `min`.",
        ),
        Key::optional(
            "shell",
            Kind::Table(shell),
            "A range of distances from an axis.",
        ),
        Key::optional(
            "nearest",
            point(),
            "The one node nearest to this point, in the body's frame.",
        ),
    ]
}

fn clamp_keys() -> Vec<Key> {
    let motion = vec![
        Key::required("time", time(0.0, 6e3), "When."),
        Key::with_default("shift", point(), "Translation.", json!([0.0, 0.0, 0.0])),
        Key::with_default(
            "angle",
            Kind::quantity(Unit::Angle, -1e3, 1e3),
            "Right-handed angle about the axis.",
            0.0,
        ),
    ];
    vec![
        Key::required("nodes", Kind::Table(nodes_keys()), "Which nodes it holds."),
        Key::with_default(
            "pivot",
            point(),
            "A point of the axis of rotation, in the body's frame.",
            json!([0.0, 0.0, 0.0]),
        ),
        Key::with_default(
            "axis",
            Kind::Direction,
            "Axis of rotation.",
            json!([1.0, 0.0, 0.0]),
        ),
        Key::list(
            "motion",
            Kind::Table(motion),
            256,
            "How it moves: its place at some times, linear in between, from rest at time 0; without it, it stands.",
        ),
        Key::optional(
            "release",
            time(0.0, 6e3),
            "When it lets go; never if left out.",
        ),
    ]
}

fn coupling_keys() -> Vec<Key> {
    vec![
        Key::required("from", region(), "Region whose nodes are coupled."),
        Key::required("to", region(), "Region to whose surface they are coupled."),
        Key::required(
            "stiffness",
            Kind::quantity(Unit::AreaStiffness, 1.0, 1e15),
            "Force per distance and area.",
        ),
        Key::optional(
            "break_distance",
            size(),
            "Distance at which a node tears off; never if left out.",
        ),
    ]
}

fn load_keys() -> Vec<Key> {
    let pressure = Kind::quantity(Unit::Pressure, -1e9, 1e9);
    vec![
        Key::required(
            "surface",
            Kind::Table(nodes_keys()),
            "The triangles of the surface all of whose nodes are among these.",
        ),
        Key::optional(
            "pressure",
            pressure,
            "Against the outward normal of the deformed surface.",
        ),
        Key::optional(
            "traction",
            Kind::vector3(Unit::Pressure, 1e9),
            "Force per area at rest that keeps its direction.",
        ),
        Key::with_default(
            "ramp",
            time(0.0, 6e3),
            "Time in which it grows to its full value.",
            0.0,
        ),
    ]
}

fn start_keys() -> Vec<Key> {
    let row = Kind::vector3(Unit::Ratio, 1e3);
    let matrix = Kind::List {
        of: Box::new(row),
        min: 3,
        max: 3,
    };
    vec![
        Key::with_default(
            "nodes",
            Kind::Table(nodes_keys()),
            "Which nodes; clamped ones stay.",
            json!({}),
        ),
        Key::with_default(
            "matrix",
            matrix,
            "Rows of the matrix in p = pivot + matrix (rest - pivot) + shift.",
            json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        ),
        Key::with_default(
            "pivot",
            point(),
            "Fixed point of the matrix, in the body's frame.",
            json!([0.0, 0.0, 0.0]),
        ),
        Key::with_default("shift", point(), "Translation.", json!([0.0, 0.0, 0.0])),
        Key::with_default(
            "velocity",
            Kind::vector3(Unit::Speed, 100.0),
            "Velocity.",
            json!([0.0, 0.0, 0.0]),
        ),
    ]
}

fn material_keys() -> Vec<Key> {
    let modulus =
        |name, min, doc| Key::optional(name, Kind::quantity(Unit::Pressure, min, 1e11), doc);
    let constant = |name, doc: &str, [plain, normalised]: [Unit; 2]| {
        let (plain, normalised) = (plain.symbol(), normalised.symbol());
        let kind = Kind::Dependent(format!(
            "a constant in {plain} (`plain`) or {normalised} (`normalised`)"
        ));
        Key::optional(name, kind, doc)
    };
    let share = |max| Kind::quantity(Unit::Ratio, 0.0, max);
    let plasticity = vec![
        Key::required(
            "yield_strain",
            share(100.0),
            "Strain from which on the rest size flows.",
        ),
        Key::required(
            "creep_rate",
            Kind::quantity(Unit::Rate, 0.0, 1e6),
            "Rate of the flow.",
        ),
        Key::required("max_strain", share(100.0), "Largest plastic strain."),
        Key::with_default(
            "hardening",
            share(1e6),
            "Growth of the stiffness per plastic strain.",
            0.0,
        ),
        Key::with_default(
            "max_stiffening",
            Kind::quantity(Unit::Ratio, 1.0, 1e6),
            "Largest factor of the stiffness.",
            1.0,
        ),
    ];
    vec![
        Key::optional(
            "region",
            region(),
            "Region of the mesh; all that no other material names if left out.",
        ),
        Key::required(
            "density",
            Kind::quantity(Unit::Density, 1.0, 20_000.0),
            "Mass per volume.",
        ),
        Key::required(
            "law",
            Kind::Choice(Law::all().map(|law| law.name().to_owned()).collect()),
            "`springs` along edges with area and volume forces, or a law of a continuum.",
        ),
        Key::optional(
            "tear_strain",
            Kind::quantity(Unit::Ratio, 0.01, 100.0),
            "Strain across a plane at which it tears by itself; without it never.",
        ),
        Key::optional(
            "relaxation_time",
            time(0.0, 600.0),
            "Kelvin-Voigt damping: a strain rate resists as that strain times this time.",
        ),
        Key::optional(
            "viscosity",
            Kind::quantity(Unit::Viscosity, 0.0, 1e9),
            "Kelvin-Voigt damping in uniaxial stretch, instead of `relaxation_time` (their ratio is the modulus).",
        ),
        modulus(
            "youngs_modulus",
            1.0,
            "Young's modulus of a continuum, or that springs are `fitted` to.",
        ),
        Key::optional(
            "poisson_ratio",
            Kind::quantity(Unit::Ratio, -0.99, 0.4999),
            "Poisson's ratio of a continuum, or that springs are `fitted` to; below 0.5, which is incompressible.",
        ),
        Key::optional(
            "discretisation",
            Kind::choice(&Discretisation::NAMES),
            "How the mesh carries a continuum; `tetrahedra` if left out. From a Poisson's ratio of 0.4 on, `selective`, `patch-pressure` or `nodal-pressure` keep it from locking.",
        ),
        Key::optional(
            "form",
            Kind::choice(&SpringForm::NAMES),
            "What the constants of springs mean: `scaled` moduli (if left out), `plain` constants of equations 4.1 and 4.2, `normalised` ones of 3.5 to 3.8, or moduli `fitted` to Young's.",
        ),
        modulus(
            "stretch_modulus",
            0.0,
            "Of `scaled` springs, against a change of length.",
        ),
        modulus(
            "area_modulus",
            0.0,
            "Of `scaled` springs, against a change of area.",
        ),
        modulus(
            "volume_modulus",
            0.0,
            "Of `scaled` springs, against a change of volume.",
        ),
        constant(
            "length_stiffness",
            "Of `plain` or `normalised` springs: stiffness of each edge.",
            [Unit::LengthStiffness, Unit::Energy],
        ),
        constant(
            "area_stiffness",
            "Of `plain` or `normalised` springs: stiffness of each triangle.",
            [Unit::AreaStiffness, Unit::Energy],
        ),
        constant(
            "volume_stiffness",
            "Of `plain` or `normalised` springs: stiffness of each tetrahedron.",
            [Unit::VolumeStiffness, Unit::Energy],
        ),
        constant(
            "length_damping",
            "Of `plain` or `normalised` springs: damping of each edge.",
            [Unit::LengthDamping, Unit::Action],
        ),
        constant(
            "area_damping",
            "Of `plain` or `normalised` springs: damping of each triangle.",
            [Unit::AreaDamping, Unit::Action],
        ),
        constant(
            "volume_damping",
            "Of `plain` or `normalised` springs: damping of each tetrahedron.",
            [Unit::VolumeDamping, Unit::Action],
        ),
        Key::optional(
            "plasticity",
            Kind::Table(plasticity),
            "Plastic flow of springs.",
        ),
    ]
}

pub(crate) fn point() -> Kind {
    Kind::vector3(Unit::Length, LENGTH_MAX)
}

pub(crate) fn size() -> Kind {
    Kind::quantity(Unit::Length, LENGTH_MIN, LENGTH_MAX)
}

pub(crate) fn size3() -> Kind {
    Kind::Vector {
        unit: Unit::Length,
        len: 3,
        min: LENGTH_MIN,
        max: LENGTH_MAX,
    }
}

fn region() -> Kind {
    Kind::Integer {
        min: 0,
        max: i64::from(u32::MAX),
    }
}

fn time(min: f64, max: f64) -> Kind {
    Kind::quantity(Unit::Time, min, max)
}
