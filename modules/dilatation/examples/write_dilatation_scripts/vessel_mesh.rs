//! Meshes of vessel ends that hang shut: the wall of a tube that is flat at its open end and round where it is held, with loose adventitia on its upper side and a tuft of
//! it that can be gripped. Region 0 is media, region 1 adventitia.

use crate::frame::Frame;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write;

/// Sizes in millimetres; cells are hexahedra that are cut into six tetrahedra each.
#[derive(Clone, Copy)]
pub struct VesselEnd {
    /// Radius of the lumen where it is round.
    pub radius: f64,
    /// Thickness of the media.
    pub wall: f64,
    /// Height over width of the lumen at the open end; its circumference is that of the round one.
    pub flat: f64,
    /// Length, and the part of it from the opening that is as flat as the opening.
    pub length: f64,
    pub flat_length: f64,
    /// Thickness of the adventitia, and height of its tuft.
    pub adventitia: f64,
    pub tuft: f64,
    pub around: usize,
    pub along: usize,
    /// Cells through the media.
    pub through: usize,
}

/// Part of the length, from the opening, where the adventitia begins and ends, and so of its tuft: in cells of eight.
const ADVENTITIA: [usize; 2] = [2, 5];
const TUFT: [usize; 2] = [2, 3];

/// Cells through the tuft.
const TUFT_CELLS: usize = 2;

/// Corners of the polygon by which lengths of ellipses are found.
const FINE: usize = 20_000;

impl VesselEnd {
    /// Place and outward normal of a corner of the lumen's section, upwards and across, at a distance from the opening.
    fn corner(&self, i: usize, along: f64) -> ([f64; 2], [f64; 2]) {
        let part = ((along - self.flat_length) / (self.length - self.flat_length)).clamp(0.0, 1.0);
        let flat = self.flat + (1.0 - self.flat) * part * part * (3.0 - 2.0 * part);
        // An ellipse of the half axes 1 and `flat` from its widest place on, by equal lengths.
        let at = |k: usize| {
            let angle = 2.0 * PI * k as f64 / FINE as f64;
            (flat * libm::sin(angle), libm::cos(angle), angle)
        };
        let mut lengths = vec![0.0];
        for k in 1..=FINE {
            let ((a, b, _), (c, d, _)) = (at(k - 1), at(k));
            lengths.push(lengths[k - 1] + libm::hypot(c - a, d - b));
        }
        let wanted = lengths[FINE] * i as f64 / self.around as f64;
        let k = lengths
            .partition_point(|length| *length <= wanted)
            .clamp(1, FINE);
        let step = (wanted - lengths[k - 1]) / (lengths[k] - lengths[k - 1]);
        let angle = 2.0 * PI * (k as f64 - 1.0 + step) / FINE as f64;
        let scale = 2.0 * PI * self.radius / lengths[FINE];
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let normal = [sine, flat * cosine];
        let size = libm::hypot(normal[0], normal[1]);
        (
            [scale * flat * sine, scale * cosine],
            normal.map(|c| c / size),
        )
    }

    /// Where a node lies: around, along from the opening, outwards from the lumen.
    fn node(&self, [i, j, k]: [usize; 3]) -> [f64; 3] {
        let along = self.length * j as f64 / self.along as f64;
        let (place, normal) = self.corner(i, along);
        let through = self.through;
        let out = match k <= through {
            true => self.wall * k as f64 / through as f64,
            false => self.wall + self.adventitia,
        };
        // The tuft stands upright.
        let up = self.tuft * k.saturating_sub(through + 1) as f64 / TUFT_CELLS as f64;
        [
            -along,
            place[0] + out * normal[0] + up,
            place[1] + out * normal[1],
        ]
    }

    /// Half of the height of the lumen at the open end \[mm\].
    pub fn half_height(&self) -> f64 {
        self.corner(self.around / 4, 0.0).0[0]
    }

    /// Each cell by its first corner, with its region.
    fn cells(&self) -> Vec<([usize; 3], u32)> {
        let (top, through) = (self.around / 4, self.through);
        let fine = |of: usize| of * self.along / 8;
        let mut cells = Vec::new();
        for j in 0..self.along {
            for i in 0..self.around {
                cells.extend((0..through).map(|k| ([i, j, k], 0)));
                // A quarter of the circumference on either side of the top, and a twelfth.
                let from_top = if i < top { top - i } else { i + 1 - top };
                let within = |range: [usize; 2], width: usize| {
                    (fine(range[0])..fine(range[1])).contains(&j) && from_top * width <= self.around
                };
                if within(ADVENTITIA, 4) {
                    cells.push(([i, j, through], 1));
                }
                if within(TUFT, 12) {
                    cells.extend((1..=TUFT_CELLS).map(|k| ([i, j, through + k], 1)));
                }
            }
        }
        cells
    }

    /// Middle of the tuft in the vessel's frame \[mm\].
    pub fn tuft_place(&self) -> [f64; 3] {
        let middle = (TUFT[0] + TUFT[1]) * self.along / 16;
        let top = self.node([self.around / 4, middle, self.through + 1]);
        let along = 0.5 * (TUFT[0] + TUFT[1]) as f64 / 8.0 * self.length;
        [-along, top[1] + 0.5 * self.tuft, 0.0]
    }

    /// A legacy VTK file in millimetres, in the frame of the field.
    pub fn vtk(&self, frame: &Frame) -> String {
        let mut rows: BTreeMap<[usize; 3], usize> = BTreeMap::new();
        let (mut places, mut tets) = (Vec::new(), Vec::new());
        for (first, region) in self.cells() {
            // Kuhn's six tetrahedra: along the edges of the cell, in every order of its directions.
            for order in [
                [0, 1, 2],
                [1, 2, 0],
                [2, 0, 1],
                [0, 2, 1],
                [2, 1, 0],
                [1, 0, 2],
            ] {
                let mut corner = first;
                let mut tet = Vec::new();
                for step in 0..4 {
                    let node = [corner[0] % self.around, corner[1], corner[2]];
                    let row = *rows.entry(node).or_insert_with(|| {
                        places.push(frame.field(self.node(node)));
                        places.len() - 1
                    });
                    tet.push(row);
                    if let Some(direction) = order.get(step) {
                        corner[*direction] += 1;
                    }
                }
                tets.push((tet, region));
            }
        }
        for (tet, _) in &mut tets {
            let edges = [1, 2, 3].map(|k| [0, 1, 2].map(|c| places[tet[k]][c] - places[tet[0]][c]));
            let [a, b, c]: [[f64; 3]; 3] = edges;
            let volume = a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
            if volume < 0.0 {
                tet.swap(2, 3);
            }
        }
        let mut text = format!(
            "# vtk DataFile Version 3.0\nVessel end, in mm; written by the example write_dilatation_scripts of this module\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
            places.len()
        );
        for [x, y, z] in &places {
            let _ = writeln!(text, "{x:.6} {y:.6} {z:.6}");
        }
        let _ = writeln!(text, "CELLS {} {}", tets.len(), 5 * tets.len());
        for (tet, _) in &tets {
            let _ = writeln!(text, "4 {} {} {} {}", tet[0], tet[1], tet[2], tet[3]);
        }
        let _ = writeln!(text, "CELL_TYPES {}", tets.len());
        text += &"10\n".repeat(tets.len());
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
