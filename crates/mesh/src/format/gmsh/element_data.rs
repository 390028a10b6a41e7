//! $ElementData: the fibre directions of each element, one view for each family. Views of anything else are skipped.

use super::Reader;
use crate::format::assemble::family_and_rank;
use crate::format::error::FormatError;
use crate::format::scalar::{Encoding, Scalar};
use nalgebra::Vector3;

impl Reader<'_> {
    /// Reads one view, its keyword at the end included.
    pub(super) fn element_data(&mut self) -> Result<(), FormatError> {
        const END: &str = "$EndElementData";
        let texts = self.tags("text tags")?;
        self.scanner.line();
        let mut name = String::new();
        for text in 0..texts {
            let line = self.scanner.line();
            let line = line.ok_or_else(|| self.scanner.ended("a text tag"))?;
            if text == 0 {
                let line = line.trim_ascii();
                name = String::from_utf8_lossy(line).trim_matches('"').to_owned();
            }
        }
        for _ in 0..self.tags("real tags")? {
            self.scanner.number::<f64>("a real tag")?;
        }
        // Time step, components, elements, and perhaps a partition.
        let wholes = self.tags("whole tags")?;
        let mut values = Vec::with_capacity(wholes);
        for _ in 0..wholes {
            values.push(self.scanner.number::<i64>("a whole tag")?);
        }
        let (Some((family, rank)), Some(&[_, 3, count])) =
            (family_and_rank(&name), values.first_chunk())
        else {
            return self.scanner.skip_past(END);
        };
        if self.encoding != Encoding::Ascii {
            self.scanner.line();
        }
        let least = self.least_bytes(4, 28);
        let count = self.scanner.check_count(count, least, "vectors")?;
        let mut directions = Vec::with_capacity(count);
        for _ in 0..count {
            let number = self.int("an element number")?;
            let mut direction = Vector3::zeros();
            for axis in 0..3 {
                direction[axis] = self.scanner.coordinate(self.encoding, Scalar::F64)?;
            }
            directions.push((number, direction));
        }
        let best = &mut self.directions[family];
        if best.as_ref().is_none_or(|best| rank < best.0) {
            *best = Some((rank, directions));
        }
        self.scanner.keyword(END)
    }

    /// A number of tags.
    fn tags(&mut self, what: &str) -> Result<usize, FormatError> {
        let count = self.scanner.number(&format!("the number of {what}"))?;
        self.scanner.check_count(count, 1, what)
    }

    /// Gives the tetrahedra their fibre directions.
    pub(super) fn set_directions(&mut self) {
        for family in 0..self.directions.len() {
            let Some((_, mut directions)) = self.directions[family].take() else {
                continue;
            };
            directions.sort_by_key(|(number, _)| *number);
            for (tet, number) in self.tet_numbers.iter().enumerate() {
                if let Ok(place) = directions.binary_search_by_key(number, |d| d.0) {
                    self.parts.set_direction(tet, family, directions[place].1);
                }
            }
        }
    }
}
