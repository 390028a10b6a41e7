//! Sections 3.3 and 4.1: tetrahedra of generators, of a background lattice fitted to a surface, and of our filling.

use crate::overview::tube;
use microsim_mesh::{
    Block, CellSplit, ElementQuality, TetMesh, TriangleSurface, fill, fit_lattice,
};
use microsim_tests::measured::thread_time;
use nalgebra::Vector3;
use std::fmt::Write as _;

/// A closed surface to be filled, by name, and the size of its cells \[m\].
struct Body {
    name: &'static str,
    surface: TriangleSurface,
    cell: f64,
}

/// A mesh in the table.
struct Row {
    how: &'static str,
    mesh: TetMesh,
    /// CPU time \[s\].
    time: f64,
    /// The largest distance of a node of the boundary from the surface \[m\], where that is not zero by construction.
    farthest: Option<f64>,
}

/// Measures and describes it.
pub fn measure(text: &mut String) -> Result<crate::Drawings, String> {
    let _ = writeln!(
        text,
        "\n## 3.3, 4.1: meshes\n\nThe dissertation cuts cells into five tetrahedra and names a fit of such cells to a closed surface by moving their nodes (Müller and Teschner 2003); its tubes have six in a cell \
         (702 = 9 · 13 · 6). *Fitted lattice* is that fit (`filling = \"fitted-lattice\"` of a body from a surface, `fit_lattice` of the crate mesh), *stuffing* is what bodies from surfaces have otherwise (Labelle and \
         Shewchuk 2007). Radius ratio: 1 for the regular tetrahedron, 0 for a flat one. Volume: its error against that of the surface. Off: the largest distance of a node of the boundary from the surface, in cells. \
         The dissertation gives no numbers for meshes.\n\n\
         | body | mesh | tetrahedra | radius ratio, least | mean | dihedral angles | volume | off | CPU |\n|---|---|---|---|---|---|---|---|---|"
    );
    for split in [CellSplit::Kuhn, CellSplit::Mirrored, CellSplit::Five] {
        let start = thread_time();
        let mesh = tube([10, 13], split)?;
        let how = match split {
            CellSplit::Kuhn => "generator, six, all alike",
            CellSplit::Mirrored => "generator, six, mirrored",
            CellSplit::Five => "generator, five, alternating",
        };
        let time = thread_time() - start;
        let row = Row {
            how,
            mesh,
            time,
            farthest: None,
        };
        describe(text, "tube, 10 around", &row, None, 0.0);
    }
    for body in bodies()? {
        let start = thread_time();
        let fitted = fit_lattice(&body.surface, body.cell).map_err(|e| e.to_string())?;
        let time = thread_time() - start;
        let row = Row {
            how: "fitted lattice",
            mesh: fitted.mesh,
            time,
            farthest: Some(fitted.farthest),
        };
        describe(
            text,
            body.name,
            &row,
            Some(body.surface.volume()),
            body.cell,
        );
        let start = thread_time();
        let mesh = fill(&body.surface, body.cell).map_err(|e| e.to_string())?;
        let time = thread_time() - start;
        let row = Row {
            how: "stuffing",
            mesh,
            time,
            farthest: None,
        };
        describe(
            text,
            body.name,
            &row,
            Some(body.surface.volume()),
            body.cell,
        );
    }
    Ok(Vec::new())
}

fn describe(text: &mut String, body: &str, row: &Row, volume: Option<f64>, cell: f64) {
    let (mut least, mut sum, mut angles) = (f64::INFINITY, 0.0, [f64::INFINITY, 0.0f64]);
    for element in 0..row.mesh.tets.len() {
        let quality = ElementQuality::of(&row.mesh.corners(element));
        least = least.min(quality.radius_ratio);
        sum += quality.radius_ratio;
        angles = [
            angles[0].min(quality.dihedral_min),
            angles[1].max(quality.dihedral_max),
        ];
    }
    let count = row.mesh.tets.len();
    let own: f64 = row.mesh.volumes().iter().sum();
    let error = volume.map_or("–".into(), |volume| {
        format!("{:+.2} %", 100.0 * (own / volume - 1.0))
    });
    let farthest = row
        .farthest
        .map_or("0".into(), |far| format!("{:.2}", far / cell));
    let _ = writeln!(
        text,
        "| {body} | {} | {count} | {least:.2} | {:.2} | {:.0}° to {:.0}° | {error} | {farthest} | {:.1} ms |",
        row.how,
        sum / count as f64,
        angles[0].to_degrees(),
        angles[1].to_degrees(),
        1e3 * row.time,
    );
}

/// A sphere, a tube and a box that is not along the axes.
fn bodies() -> Result<Vec<Body>, String> {
    let boundary = |mesh: &TetMesh| TriangleSurface {
        triangles: mesh.surface().triangles,
        positions: mesh.positions.clone(),
    };
    let block = |size: [f64; 3], cells: [usize; 3]| {
        let block = Block {
            center: [0.0; 3],
            size,
            cells,
            split: CellSplit::Kuhn,
        };
        block.mesh().map_err(|e| e.to_string())
    };
    let mut sphere = boundary(&block([2.0; 3], [12; 3])?);
    for p in &mut sphere.positions {
        // A cube pushed out to a sphere; inner nodes are not of the surface.
        let largest = p.amax();
        if largest > 0.0 {
            *p *= 10e-3 * largest / p.norm();
        }
    }
    let mut turned = boundary(&block([20e-3, 12e-3, 8e-3], [1; 3])?);
    let rotation = nalgebra::Rotation3::new(Vector3::new(0.3, -0.2, 0.5));
    turned.positions.iter_mut().for_each(|p| *p = rotation * *p);
    let tube = boundary(&tube([48, 40], CellSplit::Kuhn)?);
    Ok(vec![
        Body {
            name: "sphere, radius of 5 cells",
            surface: sphere,
            cell: 2e-3,
        },
        Body {
            name: "tube, wall of 2 cells",
            surface: tube,
            cell: 1e-3,
        },
        Body {
            name: "box, turned",
            surface: turned,
            cell: 2e-3,
        },
    ])
}
