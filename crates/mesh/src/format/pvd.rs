//! ParaView's `.pvd`: which file shows which moment.

use std::fmt::Write;

/// One file of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PvdEntry<'a> {
    /// Time that the file shows \[s\].
    pub time: f64,
    /// Number of the body, where several are shown at once.
    pub part: u32,
    /// Path of the `.vtu` file from the folder of the `.pvd`, with forward slashes.
    pub file: &'a str,
}

/// The collection of `entries`, in their order.
///
/// ```
/// use microsim_mesh::format::{PvdEntry, write_pvd};
///
/// let entry = PvdEntry { time: 0.1, part: 0, file: "frames/1.vtu" };
/// let file = String::from_utf8(write_pvd(&[entry]))?;
/// assert!(file.contains("timestep=\"0.1\"") && file.contains("frames/1.vtu"));
/// # Ok::<(), std::string::FromUtf8Error>(())
/// ```
pub fn write_pvd(entries: &[PvdEntry<'_>]) -> Vec<u8> {
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for entry in entries {
        let file = quick_xml::escape::escape(entry.file);
        let _ = writeln!(
            out,
            "<DataSet timestep=\"{:?}\" group=\"\" part=\"{}\" file=\"{file}\"/>",
            entry.time, entry.part
        );
    }
    out.push_str("</Collection>\n</VTKFile>\n");
    out.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_keep_time_order_and_names() {
        let text = String::from_utf8(write_pvd(&[
            PvdEntry {
                time: 0.0,
                part: 0,
                file: "a&b/0.vtu",
            },
            PvdEntry {
                time: 0.1,
                part: 1,
                file: "1.vtu",
            },
        ]))
        .unwrap();
        let first = text.find("timestep=\"0.0\" group=\"\" part=\"0\" file=\"a&amp;b/0.vtu\"");
        let second = text.find("timestep=\"0.1\" group=\"\" part=\"1\" file=\"1.vtu\"");
        assert!(first.is_some() && first < second, "{text}");
    }
}
