//! The series of a session as one tidy table: `microsim report SESSION --table FILE`.

use crate::output::Problem;
use crate::replace_file::replace_by;
use microsim_report::Report;
use microsim_table::{Cell, Column, Format, Kind, TableError, TableWriter};
use std::io::Write;
use std::path::Path;

/// A row is one number or one event: tools first, then forces, then events, each in the order of time. `with` is the body that a tool
/// touches; `part` the segment of a motion, or the contact; `valid` is false for forces of ticks that mean nothing.
const COLUMNS: [Column; 9] = [
    Column {
        name: "time_s",
        kind: Kind::Real,
    },
    Column {
        name: "source",
        kind: Kind::Text,
    },
    Column {
        name: "with",
        kind: Kind::Text,
    },
    Column {
        name: "part",
        kind: Kind::Integer,
    },
    Column {
        name: "quantity",
        kind: Kind::Text,
    },
    Column {
        name: "unit",
        kind: Kind::Text,
    },
    Column {
        name: "value",
        kind: Kind::Real,
    },
    Column {
        name: "valid",
        kind: Kind::Flag,
    },
    Column {
        name: "text",
        kind: Kind::Text,
    },
];

/// Writes the table in the place of what is at `path`.
pub fn write(report: &Report, format: Format, path: &Path) -> Result<(), Problem> {
    replace_by(path, |file| {
        let table = TableWriter::new(format, &COLUMNS, std::io::BufWriter::new(file));
        let mut table = table.map_err(std::io::Error::other)?;
        rows(report, &mut table).map_err(std::io::Error::other)?;
        table.finish().map_err(std::io::Error::other)?.flush()
    })
}

fn rows<W: Write + Send>(report: &Report, table: &mut TableWriter<W>) -> Result<(), TableError> {
    for motion in &report.series {
        for (k, [x, y, z]) in motion.position.iter().enumerate() {
            let numbers = [
                ("x", "m", Some(*x)),
                ("y", "m", Some(*y)),
                ("z", "m", Some(*z)),
                ("speed", "m/s", motion.speed[k]),
            ];
            for (quantity, unit, value) in numbers {
                table.row(&[
                    Cell::Real(motion.time[k]),
                    Cell::Text(&motion.tool),
                    Cell::Empty,
                    Cell::Integer(motion.segment[k].into()),
                    Cell::Text(quantity),
                    Cell::Text(unit),
                    value.into(),
                    Cell::Flag(true),
                    Cell::Empty,
                ])?;
            }
        }
    }
    for force in &report.forces {
        for (k, time) in force.time.iter().enumerate() {
            let numbers = [
                ("force", "N", force.force[k]),
                ("peak-force", "N", force.peak[k]),
                ("sustained-force", "N", force.sustained[k]),
                ("grip", "N", force.grip[k]),
                ("depth", "m", force.depth[k]),
                ("indentation", "m", force.indentation[k]),
            ];
            for (quantity, unit, value) in numbers {
                table.row(&[
                    Cell::Real(*time),
                    Cell::Text(&force.tool),
                    Cell::Text(&force.body),
                    Cell::Integer(force.contact[k].into()),
                    Cell::Text(quantity),
                    Cell::Text(unit),
                    Cell::Real(value),
                    Cell::Flag(force.valid[k]),
                    Cell::Empty,
                ])?;
            }
        }
    }
    for event in &report.events {
        table.row(&[
            Cell::Real(event.session_time),
            Cell::Text(&report.session.module),
            Cell::Empty,
            Cell::Empty,
            Cell::Text(&event.id),
            Cell::Empty,
            Cell::Empty,
            Cell::Flag(true),
            Cell::Text(&event.text.en),
        ])?;
    }
    Ok(())
}
