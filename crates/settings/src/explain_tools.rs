//! What becomes of tracked motion before the tools have it, in words: only what is configured or calibrated.

use crate::calibration::{TipCalibration, WorkspaceCalibration};
use crate::explain::LevelPart;
use crate::plugin_config::TranslatorConfig;
use crate::translator::{DominantHand, Filter, MarkerTool, TrackingBox, Translator};
use std::path::Path;

/// Speed for which a delay is stated beside that at rest \[m/s\].
const MOVING: f64 = 0.05;

/// The parts of a translator that are not there by themselves; `calibration` is the file that calibrations come from.
/// What `translator` states of the trainee's hand and of boxes is in the maps of `config`.
pub fn translator_parts(
    translator: &Translator,
    config: &TranslatorConfig,
    calibration: &Path,
) -> Vec<LevelPart> {
    let part = |what, name: &str, why| LevelPart {
        what,
        name: name.to_owned(),
        why,
    };
    let mut parts = Vec::new();
    if config.dominant == DominantHand::Left {
        let why = match config.mirrored {
            true => {
                "pictures and poses are mirrored; the devices of the slots left and right have changed places"
            }
            false => "pictures are mirrored; the input moves in the level's own field",
        };
        parts.push(part("hand", "left", why.to_owned()));
    }
    for device in &config.devices {
        let boxes = translator.tracking_box.iter();
        for space in boxes.filter(|space| space.device == device.name) {
            parts.push(part("box", &device.name, box_words(space)));
        }
        if let Some(tip) = config.tip(&device.name) {
            parts.push(part("tip", &device.name, tip_words(tip, calibration)));
        }
        if let Some(space) = config.workspace(&device.name) {
            let words = workspace_words(space, calibration);
            parts.push(part("workspace", &device.name, words));
        }
    }
    for tool in &config.markers {
        parts.push(part("markers", &tool.device, marker_words(tool)));
    }
    for clutch in &config.clutches {
        let why = format!(
            "config/translator.toml lists it; holds {}",
            clutch.tool.join(", ")
        );
        parts.push(part("clutch", &clutch.device, why));
    }
    for filter in &config.filters {
        parts.push(part("filter", &filter.device, filter_words(filter)));
    }
    parts
}

fn millimetres(vector: [f64; 3]) -> String {
    let [x, y, z] = vector.map(|x| format!("{:.2}", 1e3 * x));
    format!("({x}, {y}, {z}) mm")
}

fn box_words(space: &TrackingBox) -> String {
    let [width, depth, height] = space.size.map(|side| 100.0 * side);
    format!(
        "config/translator.toml lists it; {width:.1} × {depth:.1} × {height:.1} cm, of which the width is {:.1} mm in the field, scale {:.4}",
        1e3 * space.field_width,
        space.scale()
    )
}

fn tip_words(tip: &TipCalibration, file: &Path) -> String {
    format!(
        "{} has its tip at {} of the handle, to {:.3} mm (residual {:.3} mm, {} poses, {})",
        file.display(),
        millimetres(tip.tip),
        1e3 * tip.error,
        1e3 * tip.residual,
        tip.poses,
        tip.date
    )
}

fn workspace_words(space: &WorkspaceCalibration, file: &Path) -> String {
    format!(
        "{} has its frame registered, to {:.3} mm (residual {:.3} mm, {} points, scale {:.4}, {})",
        file.display(),
        1e3 * space.error,
        1e3 * space.residual,
        space.points,
        space.scale,
        space.date
    )
}

fn marker_words(tool: &MarkerTool) -> String {
    format!(
        "config/translator.toml lists it; pose and opening of {} markers, residual up to {:.2} mm",
        tool.marker.len(),
        1e3 * tool.tolerance
    )
}

fn filter_words(filter: &Filter) -> String {
    let one_euro = filter.parameters.one_euro();
    let [rest, moving] = [0.0, MOVING].map(|speed| 1e3 * one_euro.delay(speed));
    let predicted = match one_euro.predict_s > 0.0 {
        true => format!(", predicted {:.0} ms ahead", 1e3 * one_euro.predict_s),
        false => String::new(),
    };
    format!(
        "config/translator.toml lists it; one-euro filter, motion comes out {rest:.0} ms later at rest, {moving:.0} ms at {:.0} mm/s{predicted}",
        1e3 * MOVING
    )
}
