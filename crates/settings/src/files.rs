//! The kinds of files that there are.

use crate::schema::Schema;
use crate::table::Table;

/// The kinds of file, by the names that the command line uses, each with a sentence about it.
pub const KINDS: [(&str, &str); 16] = [
    (
        "manifest",
        "plugin.toml and module.toml: what a plugin or training module is, needs and declares.",
    ),
    (
        "level",
        "modules/NAME/levels/level<N>.toml: one level of a training module.",
    ),
    (
        "scene",
        "config/scenes/NAME.toml: physics alone, as demonstration, test and benchmark.",
    ),
    (
        "chart",
        "config/chart.toml: the runs that `microsim chart` compares, and what `microsim tune` chooses from.",
    ),
    (
        "tool",
        "config/tools/NAME.toml: the shape of an instrument. Tool frame: origin at the tip, +z from tip to handle.",
    ),
    (
        "vessel",
        "config/vessels/NAME.toml: sizes, materials and residual state of a vessel, each value with its source.",
    ),
    (
        "translator",
        "config/translator.toml: which device drives which tool, and how its frame lies in the field.",
    ),
    (
        "calibration",
        "calibration.toml of a station: tips of instruments and places of trackers, written by `microsim calibrate`.",
    ),
    (
        "openigtlink",
        "config/openigtlink.toml: where trackers that speak OpenIGTLink are, and what their tools are called.",
    ),
    (
        "desktop",
        "config/desktop.toml: how mouse and keyboard move the tools.",
    ),
    (
        "window",
        "config/window.toml: how the window looks; its settings screen writes one for the station.",
    ),
    (
        "recording",
        "The TOML of the same name beside a CSV: what its columns mean.",
    ),
    (
        "script",
        "A scripted trainee: timed poses and openings of each tool.",
    ),
    (
        "trainees",
        "config/trainees.toml: how synthetic trainees move. They test the software and validate nothing.",
    ),
    (
        "course",
        "config/courses/NAME.toml: levels in order, and when the next one opens; `microsim courses add` takes it into the store.",
    ),
    (
        "host",
        "config/host.toml: how the host runs sessions, whatever is trained.",
    ),
];

/// The schema of a kind of file, which a table holds.
pub(crate) fn schema_of<T: Table>(kind: &str) -> Schema {
    let doc = KINDS.iter().find(|(name, _)| *name == kind);
    Schema {
        name: kind.to_owned(),
        doc: doc.map_or_else(String::new, |(_, doc)| (*doc).to_owned()),
        keys: T::keys(),
    }
}
