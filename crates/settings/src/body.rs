//! Tetrahedral bodies as levels and scenes describe them: mesh, materials, clamps, couplings, loads, start.
//!
//! Frames: a block or tube is given in the frame of its level or scene, everything else of a body in the body's frame: origin
//! at `centre`, axes parallel. Everything is in SI.

use crate::colour::Colour;
use crate::kinds::{
    LENGTH_MAX, axial_stretch, direction, identifier, list, opening_angle, own_defaults, point,
    quantity, relative_path, size, size3, time, vector, vector3,
};
use crate::material::Material;
use crate::table::{choices, table};
use microsim_vocabulary::{CellSplit, Filling, Finish, Unit, terms};

/// Most tetrahedra of a body: a few gigabytes.
pub const MAX_ELEMENTS: u64 = 5_000_000;

table! {
    /// A tetrahedral body.
    pub struct Body {
        /// Its name.
        name: String = identifier(),
        /// What makes its mesh: `block`, a regular box of tetrahedra; `tube`, the wall of a vessel; `file`, a mesh or
        /// a closed surface that is filled.
        generator: Generator,
        /// Of a block \[m\]: its sides.
        size: Option<[f64; 3]> = size3(),
        /// Of a block: cells along each side; each cell is six tetrahedra, or five.
        cells: Option<[u32; 3]> [1, 500],
        /// Of a tube: name of a file in config/vessels, without its extension. It gives what the body does not state: `axial_stretch`,
        /// `inner_radius`, `toughness`, `thickness`, `opening_angle` and `region` of each layer, whose number and order are those of the
        /// vessel, and the material of each region, with `selective` discretisation. A material with that region and without a law changes
        /// single values. With an `axial_stretch` or `transmural_pressure` of its own the body states `inner_radius` and each `thickness`.
        vessel: Option<String> = identifier(),
        /// Of a tube \[m\]: radius of the lumen.
        inner_radius: Option<f64> = size(),
        /// Of a tube: the layers of its wall, from the inside. Of a block: its layers along z, from below, as thick and of as many cells in
        /// sum as it is; one if left out.
        layer: Vec<Layer> [0, 16],
        /// Of a tube \[m\]: along its axis.
        length: Option<f64> = size(),
        /// Of a tube: cells around it.
        around: Option<u32> [1, 1000],
        /// Of a tube: cells along it.
        along: Option<u32> [1, 1000],
        /// Of a tube: direction of its axis; x if left out.
        axis: Option<[f64; 3]> = direction(),
        /// Of a tube \[rad\]: where its sector begins; 0 if left out.
        arc_start: Option<f64> = quantity(Unit::Angle, -360_f64.to_radians(), 360_f64.to_radians()),
        /// Of a tube \[rad\]: angle of its sector; closed around if left out.
        arc: Option<f64> = quantity(Unit::Angle, 0.1_f64.to_radians(), 359.9_f64.to_radians()),
        /// Of a tube: its length over that of its natural state, in which it has no stress.
        axial_stretch: f64 = axial_stretch() => 1.0,
        /// Of a tube \[Pa\]: pressure inside less that outside with which it is in equilibrium at the start; a load on its inner surface bears it.
        transmural_pressure: f64 = quantity(Unit::Pressure, -1e5, 1e6) => 0.0,
        /// Of a block or tube: how cells are cut, `kuhn` (all alike, if left out), `mirrored` or `five`.
        split: Option<CellSplit>,
        /// Of a file: its path from the folder of this one, which it lies in or below. Tetrahedra: .msh, .vtk, .vtu, .node with .ele; closed
        /// surfaces: .obj, .stl.
        file: Option<String> = relative_path(),
        /// Of a file \[m\]: length of one unit in it; 1 m if left out.
        scale: Option<f64> = quantity(Unit::Length, 1e-9, 1e3),
        /// Of a file with a closed surface \[m\]: size of the cells that fill it.
        fill: Option<f64> = size(),
        /// Of a file with a closed surface: how it is filled, `stuffing` (if left out) or `fitted-lattice`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        filling: Option<Filling>,
        /// Middle of a block or tube, place of the origin of a file, in the frame of the field \[m\]: origin of the
        /// body's frame.
        centre: [f64; 3] = point() => [0.0, 0.0, 0.0],
        /// Regions that get nodes of their own where they meet others: layers that a `coupling` joins, or nothing.
        detached: Vec<u32> [0, 16],
        /// Where its mesh is finer than the generator or file makes it; all of them hold.
        refine: Vec<Refine> [0, 64],
        /// Drag per mass \[1/s\]: a free body loses its speed at this rate.
        drag: f64 = quantity(Unit::Rate, 0.0, 1e5) => 0.0,
        /// Colour in pictures, sRGB.
        colour: Colour => "#c8c8c8",
        /// How its surface answers light in pictures.
        finish: Finish => "moist",
        /// Force per length of a perfectly sharp edge that cuts it (work per area) \[N/m\]; without it no single edge
        /// cuts it.
        toughness: Option<f64> = quantity(Unit::LengthStiffness, 1e-6, 1e6),
        /// How early jaws that close on it pinch it off, from 0, never, like rubber, to 1.
        brittleness: f64 = quantity(Unit::Ratio, 0.0, 1.0) => 0.0,
        /// What its regions are made of.
        material: Vec<Material> [1, 64],
        /// What holds some of its nodes.
        clamp: Vec<Clamp> [0, 64],
        /// What joins regions that have no nodes in common.
        coupling: Vec<Coupling> [0, 16],
        /// What acts on its surface.
        load: Vec<Load> [0, 16],
        /// How it lies and moves at the start, other than at rest; one after the other.
        start: Vec<Start> [0, 16],
    }
}

impl Body {
    /// The files that its mesh is made of, from the folder of this one: two for TetGen, whose nodes have a file of their own.
    pub fn files(&self) -> Vec<String> {
        let Some(file) = &self.file else {
            return Vec::new();
        };
        match file.rsplit_once('.') {
            Some((stem, ending)) if ["node", "ele"].contains(&ending.to_lowercase().as_str()) => {
                vec![format!("{stem}.node"), format!("{stem}.ele")]
            }
            _ => vec![file.clone()],
        }
    }

    /// Number of tetrahedra before any `refine`, if that stands in the settings.
    pub fn elements(&self) -> Option<u64> {
        let cells: u64 = match self.generator {
            Generator::Block => self.cells?.into_iter().map(u64::from).product(),
            Generator::Tube => {
                let through: u64 = self.layer.iter().map(|l| u64::from(l.cells)).sum();
                through * u64::from(self.around?) * u64::from(self.along?)
            }
            Generator::File => return None,
        };
        Some(self.split.unwrap_or_default().tetrahedra() as u64 * cells)
    }
}

terms! {
    /// What makes a mesh.
    pub enum Generator {
        /// A regular box of tetrahedra.
        Block = "block",
        /// A tube of one or several layers.
        Tube = "tube",
        /// A file: tetrahedra, or a closed surface that is filled.
        File = "file",
    }
}

table! {
    /// A layer of the wall of a tube, or of a block.
    #[derive(Copy)]
    pub struct Layer {
        /// Of the layer \[m\].
        thickness: f64 = size(),
        /// Cells through the layer.
        cells: u32 [1, 100],
        /// Region of its elements.
        region: u32 => 0,
        /// What is missing of a full circle when the layer is cut out and slit, and has no stress \[rad\].
        opening_angle: f64 = opening_angle() => 0.0,
    }
}

table! {
    /// A part of a body in which tetrahedra are halved until they are small enough, and around it as far as neighbours have to follow: near a point, a segment
    /// (`point` and `to`), a plane (`point` and `normal`), or a region. In the body's frame and at rest.
    #[derive(Copy)]
    pub struct Refine {
        /// A point, in the body's frame \[m\].
        point: Option<[f64; 3]> = point(),
        /// The other end of a segment from `point` \[m\].
        to: Option<[f64; 3]> = point(),
        /// Normal of a plane through `point`.
        normal: Option<[f64; 3]> = direction(),
        /// Every tetrahedron that reaches closer to the point, segment or plane than this is made small \[m\].
        radius: Option<f64> = size(),
        /// A region of the mesh, instead of a place.
        region: Option<u32>,
        /// Longest edge that a tetrahedron may have there \[m\].
        size: f64 = size(),
    }
}

table! {
    /// Nodes of a body, in its frame and at rest: all, or those that fulfil every condition that is given.
    #[derive(Copy, Default)]
    pub struct Nodes {
        /// Corner with the smallest coordinates of a box, in the body's frame \[m\]; needs `max`.
        min: Option<[f64; 3]> = point(),
        /// Corner with the largest coordinates of the box \[m\]; needs `min`.
        max: Option<[f64; 3]> = point(),
        /// A range of distances from an axis.
        shell: Option<Shell>,
        /// The one node nearest to this point, in the body's frame \[m\].
        nearest: Option<[f64; 3]> = point(),
    }
}

table! {
    /// A range of distances from an axis.
    #[derive(Copy)]
    pub struct Shell {
        /// A point of the axis, in the body's frame \[m\].
        point: [f64; 3] = point() => [0.0, 0.0, 0.0],
        /// Direction of the axis.
        axis: [f64; 3] = direction() => [1.0, 0.0, 0.0],
        /// Smallest and largest distance from it \[m\].
        radius: [f64; 2] = vector(Unit::Length, 2, 0.0, LENGTH_MAX),
    }
}

table! {
    /// Nodes that are held, and how what holds them moves.
    pub struct Clamp {
        /// Which nodes it holds.
        nodes: Nodes,
        /// A point of the axis of rotation, in the body's frame \[m\].
        pivot: [f64; 3] = point() => [0.0, 0.0, 0.0],
        /// Axis of rotation.
        axis: [f64; 3] = direction() => [1.0, 0.0, 0.0],
        /// How it moves: its place at some times, linear in between, from rest at time 0; without it, it stands.
        motion: Vec<MotionKey> [0, 256],
        /// When it lets go \[s\]; never if left out.
        release: Option<f64> = time(0.0, 6e3),
    }
}

table! {
    /// Where a motion is at a time; between two keys it is interpolated linearly.
    #[derive(Copy)]
    pub struct MotionKey {
        /// When \[s\].
        time: f64 = time(0.0, 6e3),
        /// Translation \[m\].
        shift: [f64; 3] = point() => [0.0, 0.0, 0.0],
        /// Right-handed angle about the axis \[rad\].
        angle: f64 = quantity(Unit::Angle, -1e3, 1e3) => 0.0,
    }
}

table! {
    /// What joins the nodes of one region to the surface of another, which has other nodes: it holds, and may break (`break_distance`), slides
    /// with friction (`friction`), or clings and comes off (`strength` with `energy`).
    #[derive(Copy)]
    pub struct Coupling {
        /// Region whose nodes are coupled.
        from: u32,
        /// Region to whose surface they are coupled.
        to: u32,
        /// Force per distance and area \[N/m³\].
        stiffness: f64 = quantity(Unit::AreaStiffness, 1.0, 1e15),
        /// Of one that holds: distance at which a node tears off \[m\]; never if left out.
        break_distance: Option<f64> = size(),
        /// Of one that slides: largest force across the surface over the force with which it is pressed together; the layers stay on each other where
        /// they are pulled apart, too.
        friction: Option<f64> = quantity(Unit::Ratio, 0.0, 10.0),
        /// Of one that slides: force per area across the surface that it takes besides, however it is pressed \[Pa\]: tissue between the layers that holds
        /// up to it and is drawn along beyond.
        shear_strength: f64 = quantity(Unit::Pressure, 0.0, 1e9) => 0.0,
        /// Of one that clings: force per area from which on it softens \[Pa\].
        strength: Option<f64> = quantity(Unit::Pressure, 1.0, 1e9),
        /// Of one that clings: energy per area that it takes off \[J/m²\], at least strength²/(2 stiffness).
        energy: Option<f64> = quantity(Unit::LengthStiffness, 1e-6, 1e6),
    }
}

table! {
    /// A load on part of the surface.
    #[derive(Copy)]
    pub struct Load {
        /// The triangles of the surface all of whose nodes are among these.
        surface: Nodes,
        /// Against the outward normal of the deformed surface \[Pa\].
        pressure: Option<f64> = quantity(Unit::Pressure, -1e9, 1e9),
        /// Force per area at rest that keeps its direction \[Pa\].
        traction: Option<[f64; 3]> = vector3(Unit::Pressure, 1e9),
        /// Time in which it grows to its full value \[s\].
        ramp: f64 = time(0.0, 6e3) => 0.0,
    }
}

table! {
    /// Where nodes are at the start, p = pivot + matrix (p_rest − pivot) + shift, and how fast.
    #[derive(Copy)]
    pub struct Start {
        /// Which nodes; clamped ones stay.
        nodes: Nodes => own_defaults(),
        /// Rows of the matrix in p = pivot + matrix (rest - pivot) + shift.
        matrix: [[f64; 3]; 3] = list(vector3(Unit::Ratio, 1e3), 3, 3) => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        /// Fixed point of the matrix, in the body's frame \[m\].
        pivot: [f64; 3] = point() => [0.0, 0.0, 0.0],
        /// Translation \[m\].
        shift: [f64; 3] = point() => [0.0, 0.0, 0.0],
        /// Velocity \[m/s\].
        velocity: [f64; 3] = vector3(Unit::Speed, 100.0) => [0.0, 0.0, 0.0],
    }
}

choices!(Generator);
