//! The mesh of a vessel's end: a media, and an adventitia around it that ends before the end but for tongues that hang over it. Lengths in mm; the vessel lies along x, with
//! its free end at 0 and what is held at positive x.

use std::fmt::Write;

/// Cells around the vessel.
pub const AROUND: usize = 10;

/// Tetrahedra of a cell with these corners, by bits for the three directions: five, of which every other cell has the mirrored ones.
const FIVE: [[usize; 4]; 5] = [
    [0b000, 0b110, 0b101, 0b011],
    [0b100, 0b000, 0b110, 0b101],
    [0b010, 0b000, 0b110, 0b011],
    [0b001, 0b000, 0b101, 0b011],
    [0b111, 0b110, 0b101, 0b011],
];

/// A vessel's end.
pub struct VesselEnd {
    /// Radii of the inside of the media, of the surface between the layers, and of the outside of the adventitia.
    pub radii: [f64; 3],
    /// Where the sections lie, from the held end on; the media ends at the one at 0.
    pub sections: &'static [f64],
    /// How many cells along the vessel the adventitia has but for its tongues.
    pub covered: usize,
    /// Columns of cells in the middle of a tongue, each of which is three columns wide; column 0 is on top, and they are counted to the far side.
    pub tongues: &'static [usize],
}

impl VesselEnd {
    fn cells(&self, layer: usize, column: usize) -> usize {
        let all = self.sections.len() - 1;
        let of_tongue = |middle: &usize| {
            let apart = (column + AROUND - middle) % AROUND;
            apart.min(AROUND - apart) <= 1
        };
        match layer {
            0 => all - self.sections.iter().filter(|x| **x < 0.0).count(),
            _ if self.tongues.iter().any(of_tongue) => all,
            _ => self.covered,
        }
    }

    /// The file, with the region of each tetrahedron: 0 of the media, 1 of the adventitia.
    pub fn vtk(&self) -> String {
        let (mut places, mut keys): (Vec<[f64; 3]>, Vec<[usize; 3]>) = (Vec::new(), Vec::new());
        let mut node = |ring: usize, section: usize, corner: usize| {
            let key = [ring, section, corner % AROUND];
            if let Some(known) = keys.iter().position(|of| *of == key) {
                return known;
            }
            let side = 2.0 * std::f64::consts::PI / AROUND as f64;
            let angle = (key[2] as f64 - 0.5) * side;
            let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
            let radius = self.radii[ring];
            places.push([self.sections[section], radius * sine, radius * cosine]);
            keys.push(key);
            keys.len() - 1
        };
        let mut tets: Vec<([usize; 4], usize)> = Vec::new();
        for layer in 0..2 {
            for column in 0..AROUND {
                for section in 0..self.cells(layer, column) {
                    let mirrored = (layer + column + section) % 2;
                    let mut corner = |bits: usize| {
                        let [along, around, through] = [bits >> 2 & 1, bits >> 1 & 1, bits & 1];
                        let along = along ^ mirrored;
                        node(layer + through, section + along, column + around)
                    };
                    for bits in FIVE {
                        tets.push((bits.map(&mut corner), layer));
                    }
                }
            }
        }
        for (tet, _) in &mut tets {
            if volume(tet.map(|corner| places[corner])) < 0.0 {
                tet.swap(2, 3);
            }
        }
        let mut text = format!(
            "# vtk DataFile Version 3.0\nVessel end, in mm; written by the example write_trim_sharp_scripts of this module\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
            places.len()
        );
        for [x, y, z] in &places {
            let _ = writeln!(text, "{x:.6} {y:.6} {z:.6}");
        }
        let _ = writeln!(text, "CELLS {} {}", tets.len(), 5 * tets.len());
        for ([a, b, c, d], _) in &tets {
            let _ = writeln!(text, "4 {a} {b} {c} {d}");
        }
        let _ = writeln!(text, "CELL_TYPES {}", tets.len());
        text.push_str(&"10\n".repeat(tets.len()));
        let _ = write!(
            text,
            "CELL_DATA {}\nSCALARS region int 1\nLOOKUP_TABLE default\n",
            tets.len()
        );
        for (_, region) in &tets {
            let _ = writeln!(text, "{region}");
        }
        text
    }
}

/// Six times the volume of a tetrahedron.
fn volume([a, b, c, d]: [[f64; 3]; 4]) -> f64 {
    let from_a = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - a[k]);
    let [u, v, w] = [b, c, d].map(from_a);
    u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
}
