//! TetGen's pair of text files: `.node` (points) and `.ele` (tetrahedra). Lists count from 0 or from 1; what follows a `#`
//! is a comment.

use super::Import;
use super::assemble::Parts;
use super::error::{FormatError, Place};
use super::scanner::quoted;
use nalgebra::Vector3;
use std::collections::BTreeMap;

const NODE: &str = ".node";
const ELE: &str = ".ele";

/// The mesh in the two files.
pub(super) fn read(node: &[u8], ele: &[u8]) -> Result<Import, FormatError> {
    let mut parts = Parts::default();
    let nodes = nodes(node, &mut parts).map_err(|error| error.in_file(NODE))?;
    elements(ele, &nodes, &mut parts).map_err(|error| error.in_file(ELE))?;
    parts.finish()
}

/// The index of each node by its number.
fn nodes(file: &[u8], parts: &mut Parts) -> Result<BTreeMap<i64, u32>, FormatError> {
    let mut lines = Lines::new(file);
    let mut head = lines.next("the numbers of points, dimensions, attributes and markers")?;
    let count: usize = head.number("the number of points")?;
    let dimension: i64 = head.number("the dimension, 3")?;
    if dimension != 3 {
        return Err(head.error(format!("dimension {dimension}"), "3"));
    }
    let attributes: usize = head.number_or(0)?;
    let mut nodes = BTreeMap::new();
    for index in 0..count {
        let mut line = lines.next(&format!("point {} of {count}", index + 1))?;
        let number: i64 = line.number("the number of a point")?;
        let mut position = Vector3::zeros();
        for axis in 0..3 {
            position[axis] = line.coordinate()?;
        }
        if nodes.insert(number, index as u32).is_some() {
            return Err(line.error(
                format!("point number {number} a second time"),
                "every number once",
            ));
        }
        parts.positions.push(position);
    }
    lines.end("points")?;
    if attributes > 0 {
        parts
            .notes
            .push(format!("left out: {attributes} attributes of each point"));
    }
    Ok(nodes)
}

fn elements(file: &[u8], nodes: &BTreeMap<i64, u32>, parts: &mut Parts) -> Result<(), FormatError> {
    let mut lines = Lines::new(file);
    let mut head = lines.next("the numbers of tetrahedra, nodes of each and attributes")?;
    let count: usize = head.number("the number of tetrahedra")?;
    let corners: usize = head.number_or(4)?;
    if corners != 4 {
        return Err(head.error(
            format!("{corners} nodes per tetrahedron"),
            "4: run TetGen without -o2, which writes tetrahedra of second order",
        ));
    }
    let attributes: usize = head.number_or(0)?;
    let mut fractions = 0;
    for index in 0..count {
        let mut line = lines.next(&format!("tetrahedron {} of {count}", index + 1))?;
        line.number::<i64>("the number of a tetrahedron")?;
        let mut tet = [0; 4];
        for slot in &mut tet {
            let number: i64 = line.number("the number of a point")?;
            *slot = *nodes.get(&number).ok_or_else(|| {
                line.error(
                    format!("point number {number}"),
                    "the number of one of the points in the .node file",
                )
            })?;
        }
        let region = if attributes == 0 {
            0.0
        } else {
            line.number::<f64>("an attribute of a tetrahedron")?
        };
        // Attributes may be any number; regions are counted. The cast saturates, so it is exact only where it fits.
        let whole = region as u32;
        if f64::from(whole) != region {
            fractions += 1;
        }
        parts.tets.push(tet);
        parts.regions.push(whole);
    }
    lines.end("tetrahedra")?;
    if fractions > 0 {
        parts.regions.fill(0);
        parts.notes.push(format!(
            "{fractions} attributes of tetrahedra are not 0, 1, 2, …: none is used, every region is 0"
        ));
    }
    if attributes > 1 {
        parts.notes.push(format!(
            "the first of {attributes} attributes of the tetrahedra is their region, the others are left out"
        ));
    }
    Ok(())
}

/// The lines of a file that are neither empty nor a comment.
struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    fn new(rest: &'a [u8]) -> Self {
        Self { rest, number: 0 }
    }

    fn find(&mut self) -> Option<Line<'a>> {
        while !self.rest.is_empty() {
            let length = self.rest.iter().position(|&b| b == b'\n');
            let (line, rest) = self
                .rest
                .split_at(length.map_or(self.rest.len(), |length| length + 1));
            self.rest = rest;
            self.number += 1;
            let comment = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
            let text = line[..comment].trim_ascii();
            if !text.is_empty() {
                return Some(Line {
                    rest: text,
                    number: self.number,
                });
            }
        }
        None
    }

    /// The next line.
    fn next(&mut self, expected: &str) -> Result<Line<'a>, FormatError> {
        self.find().ok_or_else(|| {
            FormatError::new(
                Place::Line(self.number.max(1)),
                "the end of the file",
                expected,
            )
        })
    }

    /// Nothing may follow the list.
    fn end(&mut self, what: &str) -> Result<(), FormatError> {
        match self.find() {
            None => Ok(()),
            Some(line) => Err(line.error(
                quoted(line.rest),
                format!("no more {what} than the file says"),
            )),
        }
    }
}

/// The words of a line.
struct Line<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Line<'a> {
    fn error(&self, found: impl Into<String>, expected: impl Into<String>) -> FormatError {
        FormatError::new(Place::Line(self.number), found, expected)
    }

    fn word(&mut self) -> Option<&'a [u8]> {
        let text = self.rest.trim_ascii_start();
        let length = text
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(text.len());
        let (word, rest) = text.split_at(length);
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    fn parse<T: std::str::FromStr>(&self, word: &[u8], expected: &str) -> Result<T, FormatError> {
        std::str::from_utf8(word)
            .ok()
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| self.error(quoted(word), expected))
    }

    fn number<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, FormatError> {
        match self.word() {
            Some(word) => self.parse(word, expected),
            None => Err(self.error("the end of the line", expected)),
        }
    }

    /// A count that may be left out at the end of the first line.
    fn number_or(&mut self, default: usize) -> Result<usize, FormatError> {
        match self.word() {
            Some(word) => self.parse(word, "a count"),
            None => Ok(default),
        }
    }

    fn coordinate(&mut self) -> Result<f64, FormatError> {
        let value: f64 = self.number("a coordinate")?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.error(format!("{value}"), "a finite coordinate"))
        }
    }
}
