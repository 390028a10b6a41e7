//! Both hands, key by key, in the frame of a vessel.

use crate::frame::{Frame, Local};
use std::fmt::Write;
use std::path::Path;

/// Directions across a vessel by their angle to the flat opening's width \[rad\].
pub const ALONG_THE_SLIT: f64 = 0.0;
pub const ACROSS_THE_SLIT: f64 = std::f64::consts::FRAC_PI_2;

/// Towards the handle of the forceps: behind the vessel, and so far above it that they pass the clamp. Their jaws lie nearly along the vessel, so that they
/// have all of the tuft between them.
pub const FORCEPS: Local = [-0.9, 0.4, 0.0];

/// Where a tool is.
#[derive(Clone, Copy)]
pub struct Held {
    /// Of the tip, in the vessel's frame \[mm\].
    pub place: Local,
    pub opening: f64,
}

/// A script in the making.
pub struct Hands<'a> {
    frame: &'a Frame,
    doc: &'a str,
    pub time: f64,
    pub dilator: Held,
    /// Angle of its jaws to the slit \[rad\].
    pub turn: f64,
    pub forceps: Option<Held>,
    keys: [String; 2],
}

impl<'a> Hands<'a> {
    pub fn new(frame: &'a Frame, doc: &'a str, dilator: Held, forceps: Option<Held>) -> Self {
        let mut hands = Self {
            frame,
            doc,
            time: 0.0,
            dilator,
            turn: ALONG_THE_SLIT,
            forceps,
            keys: [String::new(), String::new()],
        };
        hands.key(0.0);
        hands
    }

    /// Both tools are where they are now after `seconds`.
    pub fn key(&mut self, seconds: f64) {
        self.time += seconds;
        let jaws = [0.0, libm::sin(self.turn), libm::cos(self.turn)];
        let dilator = (self.dilator, self.frame.tool([1.0, 0.0, 0.0], jaws));
        let forceps = |held| (held, self.frame.tool(FORCEPS, [0.0, 0.0, 1.0]));
        for (keys, tool) in self
            .keys
            .iter_mut()
            .zip([Some(dilator), self.forceps.map(forceps)])
        {
            let Some((held, [qx, qy, qz, qw])) = tool else {
                continue;
            };
            let [x, y, z] = self.frame.field(held.place);
            let _ = write!(
                keys,
                "\n[[tool.key]]\nt = \"{:.3} s\"\nposition = [\"{x:.4} mm\", \"{y:.4} mm\", \"{z:.4} mm\"]\norientation = [{qx:.12}, {qy:.12}, {qz:.12}, {qw:.12}]\nopening = {}\n",
                self.time, held.opening,
            );
        }
    }

    /// Writes the script of a level whose tools have these slots: the dilator's first.
    pub fn write(self, folder: &Path, level: u32, slots: [&str; 2], name: &str) {
        let mut text = format!(
            "# {}\n# Written by the example write_dilatation_scripts of this module.\nmodule = \"dilatation\"\nlevel = {level}\nrate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n",
            self.doc
        );
        for (slot, keys) in slots
            .iter()
            .zip(self.keys)
            .filter(|(_, keys)| !keys.is_empty())
        {
            let _ = write!(text, "\n[[tool]]\nname = \"{slot}\"\n{keys}");
        }
        let file = folder.join(format!("level{level}-{name}.toml"));
        std::fs::write(file, text).expect("the scripts folder can be written");
    }
}
