//! `config/translator.toml`: which device drives which tool, and how its frame lies in the field.
//!
//! A device point p becomes the field point `field_offset + scale · rotation (p − origin)`; a device orientation q becomes
//! the tool's orientation `rotation · q · tool_rotation`. A device that is not listed drives the tool of its own name, with
//! its poses taken as they are.
//!
//! All devices are in hands: a sample that is beyond the limits of `hand` is left out. Each default is far above what a hand does under the microscope and far
//! below what a tracker that errs reports:
//!
//! | | default | recorded surgery | why |
//! |---|---|---|---|
//! | speed | 1 m/s | 0.17 m/s | a judgement: six times the recorded one |
//! | acceleration | 10 m/s² | 2.5 m/s² | a judgement: four times the recorded one, jitter included |
//! | turn rate | 30 rad/s | 2.5 rad/s | a judgement: twelve times the recorded one |
//! | opening rate | 17 1/s | – | a movement takes 1/9.2 s at least, the bandwidth of impulses of acceleration and deceleration of hands (Draper 1994, IEEE Trans. Syst. Man Cybern. 24:931); 1.875 of its mean speed are its largest with minimum jerk (Flash & Hogan 1985) |
//!
//! Recorded are the 3,466 samples of `assets/recordings/cataract-stylus`, by difference quotients inside its segments.

use crate::check::{items, texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{identifier, own_defaults, quantity, ratio, rotation, time, vector, vector3};
use crate::schema::Kind;
use crate::table::{Setting, choices, table};
use microsim_tracking::{
    HandLimits, MarkedInstrument, Marker, MarkerModel, MarkerProblem, OneEuro,
};
use microsim_vocabulary::{Unit, terms};
use serde::{Deserialize, Serialize};
use std::path::Path;

table! {
    /// What the translator knows of the devices.
    pub struct Translator {
        /// A tool whose last sample is older is stale \[s\].
        stale_after: f64 = time(0.001, 10.0) => 0.1,
        /// What no hand goes beyond: samples that do are left out.
        hand: Hand => own_defaults(),
        /// The trainee's dominant hand. Levels are made for right-handed people: with `left` they are shown mirrored, and of instruments the devices of the slots `left` and `right` change places.
        dominant: DominantHand => "right",
        /// Devices that do not simply drive the tool of their own name.
        device: Vec<DeviceMap> [0, 32],
        /// Devices that move in a box of the tracker, which becomes a part of the field.
        tracking_box as "box": Vec<TrackingBox> [0, 32],
        /// Instruments whose pose and opening come from the positions of their markers.
        markers: Vec<MarkerTool> [0, 32],
        /// Devices that hold the tips of tools while they are pressed, so that a hand can go back to the middle of its space.
        clutch: Vec<ClutchMap> [0, 8],
        /// Devices whose motion is filtered; without an entry none is.
        filter: Vec<Filter> [0, 32],
    }
}

terms! {
    /// A hand.
    #[derive(Default)]
    pub enum DominantHand {
        /// The right one, for which levels are made.
        Right = "right" default,
        /// The left one.
        Left = "left",
    }
}

table! {
    /// The space in which a tracker sees a device: its centre comes to lie where `field_offset` of the device is, and its width becomes that of the field. The device
    /// has no keys `origin` and `scale` then.
    pub struct TrackingBox {
        /// The device.
        device: String = identifier(),
        /// Width, depth and height; those of the first prototype of such a simulator by default \[m\].
        size: [f64; 3] = vector(Unit::Length, 3, 0.01, 10.0) => [0.42, 0.35, 0.27],
        /// Its middle in the frame of the device \[m\].
        centre: [f64; 3] = vector3(Unit::Length, 10.0) => [0.0, 0.0, 0.0],
        /// What its width is in the field: what a microscope shows at five times by default \[m\].
        field_width: f64 = quantity(Unit::Length, 1e-4, 10.0) => 0.038,
    }
}

table! {
    /// An instrument with markers. Each marker is a device of the source, of which the position counts.
    pub struct MarkerTool {
        /// The device that they make up, as other tables name it.
        device: String = identifier(),
        /// Largest root mean square residual of a fit \[m\].
        tolerance: f64 = quantity(Unit::Length, 1e-6, 0.01) => 5e-4,
        /// Markers nearer than this may be seen as one point between them \[m\].
        merge: f64 = quantity(Unit::Length, 0.0, 0.1) => 3e-3,
        /// The markers.
        marker: Vec<MarkerPlace> [3, 8],
    }
}

table! {
    /// A marker in the frame of the handle.
    pub struct MarkerPlace {
        /// The device of the source that it is.
        name: String = identifier(),
        /// Where it is when the instrument is closed \[m\].
        at: [f64; 3] = vector3(Unit::Length, 1.0),
        /// Where it is when the instrument is open, if it moves \[m\].
        open: Option<[f64; 3]> = vector3(Unit::Length, 1.0),
    }
}

table! {
    /// A clutch: pressed while the device is seen, and its opening, if it has one, is at least one half.
    pub struct ClutchMap {
        /// The device, a pedal for example.
        device: String = identifier(),
        /// Slots of the tools whose tips stand while it is pressed.
        tool: Vec<String> [1, 8],
    }
}

table! {
    /// A one-euro filter. A steady motion comes out later by 1/(2 pi f) with f = min_cutoff + beta speed: by 53 ms at rest with the defaults, by 20 ms at 50 mm/s.
    /// It takes tremor away, which metrics then do not find.
    #[derive(Copy)]
    pub struct FilterParameters {
        /// Cutoff at rest \[Hz\].
        min_cutoff: f64 = quantity(Unit::Frequency, 0.01, 1000.0) => 3.0,
        /// By how much the cutoff rises with the speed of the position: Hz per m/s.
        beta: f64 = ratio(1e6) => 100.0,
        /// By how much it rises with the speed of turning: Hz per rad/s.
        turn_beta: f64 = ratio(1e6) => 3.0,
        /// Cutoff of the speeds \[Hz\].
        derivative_cutoff: f64 = quantity(Unit::Frequency, 0.01, 1000.0) => 1.0,
        /// How far ahead poses are predicted, positions and orientations, as if they went on steadily; at most as long as `stale_after`. 0 is off \[s\].
        predict: f64 = time(0.0, 0.2) => 0.0,
    }
}

table! {
    /// The filter of a device.
    pub struct Filter {
        /// The device.
        device: String = identifier(),
        /// How it is filtered.
        parameters: FilterParameters => own_defaults(),
    }
}

choices! { DominantHand }

impl FilterParameters {
    /// The filter of these parameters.
    pub fn one_euro(&self) -> OneEuro {
        OneEuro {
            min_cutoff: self.min_cutoff,
            beta: self.beta,
            turn_beta: self.turn_beta,
            derivative_cutoff: self.derivative_cutoff,
            predict_s: self.predict,
        }
    }
}

impl TrackingBox {
    /// Length in the field per length of the box.
    pub fn scale(&self) -> f64 {
        self.field_width / self.size[0]
    }
}

impl MarkerTool {
    /// The instrument, which takes samples of its markers.
    ///
    /// # Errors
    /// If the markers determine no pose.
    pub fn instrument(&self) -> Result<MarkedInstrument, MarkerProblem> {
        let names = self
            .marker
            .iter()
            .map(|marker| marker.name.clone())
            .collect();
        Ok(MarkedInstrument::new(&self.device, names, self.model()?))
    }

    /// The markers as the fit takes them.
    ///
    /// # Errors
    /// If they determine no pose.
    pub fn model(&self) -> Result<MarkerModel, MarkerProblem> {
        let marker = |place: &MarkerPlace| Marker {
            closed: place.at,
            open: place.open.unwrap_or(place.at),
        };
        let markers = self.marker.iter().map(marker).collect();
        MarkerModel::new(markers, self.tolerance, self.merge)
    }
}

table! {
    /// What no hand goes beyond, in the device's frame, before any scale. Samples may be off by the errors stated here; those of a hand at
    /// rest are never beyond a limit for that.
    #[derive(Copy)]
    pub struct Hand {
        /// Largest speed of the tip \[m/s\].
        speed: f64 = quantity(Unit::Speed, 0.01, 1000.0) => 1.0,
        /// Largest acceleration of the tip \[m/s²\].
        acceleration: f64 = quantity(Unit::Acceleration, 0.1, 1e6) => 10.0,
        /// Largest speed of turning \[rad/s\].
        turn_rate: f64 = quantity(Unit::AngularSpeed, 0.1, 1e4) => 30.0,
        /// Largest change of the opening per time, from 0 closed to 1 open \[1/s\].
        opening_rate: f64 = quantity(Unit::Rate, 0.1, 1e4) => 17.0,
        /// Largest error of a position, jitter and rounding: a dozen times the 20 µm of a tracker made for such simulators (CatAR) \[m\].
        position_error: f64 = quantity(Unit::Length, 0.0, 0.1) => 2.5e-4,
        /// Largest error of an orientation \[rad\].
        turn_error: f64 = quantity(Unit::Angle, 0.0, 1.0) => 0.05,
        /// Largest error of an opening.
        opening_error: f64 = ratio(1.0) => 0.02,
        /// Samples elsewhere that are consistent with each other for this long count: the instrument is there \[s\].
        accept_after: f64 = time(0.001, 10.0) => 0.1,
    }
}

impl Hand {
    /// The limits as the translator compares samples with them.
    pub fn limits(&self) -> HandLimits {
        HandLimits {
            speed: self.speed,
            acceleration: self.acceleration,
            turn_rate: self.turn_rate,
            opening_rate: self.opening_rate,
            position_error: self.position_error,
            turn_error: self.turn_error,
            opening_error: self.opening_error,
            accept_after_s: self.accept_after,
        }
    }
}

table! {
    /// How one device drives one tool.
    pub struct DeviceMap {
        /// As the source names it.
        name: String = identifier(),
        /// Slot of the tool that it drives.
        tool: String = identifier(),
        /// Device point that comes to lie on `field_offset`, in the device frame \[m\].
        origin: [f64; 3] = vector3(Unit::Length, 10.0) => [0.0, 0.0, 0.0],
        /// Where that point lies in the field frame \[m\].
        field_offset: [f64; 3] = vector3(Unit::Length, 10.0) => [0.0, 0.0, 0.0],
        /// Rotation [x, y, z, w] that turns device directions into field directions.
        rotation: [f64; 4] = rotation() => [0.0, 0.0, 0.0, 1.0],
        /// Rotation [x, y, z, w] that turns tool directions into directions of the device's moving part.
        tool_rotation: [f64; 4] = rotation() => [0.0, 0.0, 0.0, 1.0],
        /// Field lengths per device length.
        scale: f64 = quantity(Unit::Ratio, 0.001, 1000.0) => 1.0,
        /// Where the opening comes from: the device, or always `closed`, `open` or this fraction.
        opening: OpeningSource => "device",
    }
}

/// Where the opening of a tool comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum OpeningSource {
    /// From the device or always at an end.
    Named(OpeningName),
    /// Always this fraction of the full opening.
    Fixed(f64),
}

terms! {
    /// Openings that have a name.
    pub enum OpeningName {
        /// As the device reports it.
        Device = "device",
        /// Always 0.
        Closed = "closed",
        /// Always 1.
        Open = "open",
    }
}

impl OpeningSource {
    /// The opening that holds whatever the device reports, from 0 closed to 1 open; `None` if the device reports it.
    pub fn fixed(self) -> Option<f64> {
        match self {
            OpeningSource::Named(OpeningName::Device) => None,
            OpeningSource::Named(OpeningName::Closed) => Some(0.0),
            OpeningSource::Named(OpeningName::Open) => Some(1.0),
            OpeningSource::Fixed(opening) => Some(opening),
        }
    }
}

impl Setting for OpeningSource {
    fn kind() -> Kind {
        let names = OpeningName::NAMES.map(str::to_owned).to_vec();
        Kind::ChoiceOr(names, Box::new(ratio(1.0)))
    }
}

/// Reads the translator's file from a text; `file` is the name that complaints use.
pub fn read_translator(text: &str, file: &str) -> Result<Loaded<Translator>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Translator>("translator"))?;
    let root = KeyPath::root();
    for (list, field) in [
        ("device", "name"),
        ("device", "tool"),
        ("box", "device"),
        ("markers", "device"),
        ("clutch", "device"),
        ("filter", "device"),
    ] {
        let names = texts(reading.value(), list, field);
        unique(&mut reading, &root, &names, list, field);
    }
    check_boxes(&mut reading);
    check_markers(&mut reading);
    check_clutches(&mut reading);
    check_predictions(&mut reading);
    reading.finish()
}

/// A device in a box has neither an origin nor a scale of its own: the box states both.
fn check_boxes(reading: &mut Reading) {
    let boxes = texts(reading.value(), "box", "device");
    for (index, name) in texts(reading.value(), "device", "name") {
        if !boxes.iter().any(|(_, device)| *device == name) {
            continue;
        }
        for field in ["origin", "scale"] {
            let key = KeyPath::root().key("device").at(index).key(field);
            if reading.is_written(&key) {
                let expected = format!("no `{field}`, which the box of `{name}` states");
                reading.complain(&key, &format!("`{field}`"), &expected);
            }
        }
    }
}

/// A clutch drives no tool, and is no marker of one: pressing it would move what it holds.
fn check_clutches(reading: &mut Reading) {
    let drives: Vec<String> = ["device", "markers"]
        .into_iter()
        .zip(["name", "device"])
        .flat_map(|(list, field)| texts(reading.value(), list, field))
        .map(|(_, device)| device)
        .collect();
    let markers = items(reading.value(), "markers");
    let markers = markers.flat_map(|(_, tool)| texts(tool, "marker", "name"));
    let markers: Vec<String> = markers.map(|(_, name)| name).collect();
    for (index, device) in texts(reading.value(), "clutch", "device") {
        let found = match (drives.contains(&device), markers.contains(&device)) {
            (true, _) => format!("`{device}`, which drives a tool"),
            (_, true) => format!("`{device}`, which is a marker of a tool"),
            _ => continue,
        };
        let key = KeyPath::root().key("clutch").at(index).key("device");
        reading.complain(&key, &found, "a device of its own, such as a pedal");
    }
    let clutches: Vec<ClutchMap> = items(reading.value(), "clutch")
        .filter_map(|(_, clutch)| serde_json::from_value(clutch.clone()).ok())
        .collect();
    for (index, clutch) in clutches.iter().enumerate() {
        // A device that is not listed drives the tool of its own name.
        if clutch.tool.contains(&clutch.device) {
            let found = format!("`{}`, which drives the tool of its own name", clutch.device);
            let key = KeyPath::root().key("clutch").at(index).key("device");
            reading.complain(&key, &found, "a device of its own, such as a pedal");
        }
    }
}

/// A tool is not shown further ahead than it may be unseen: one whose samples cease would go on for longer than anybody takes it for tracked.
fn check_predictions(reading: &mut Reading) {
    let Some(stale_after) = reading.value()["stale_after"].as_f64() else {
        return;
    };
    let predicted: Vec<(usize, f64)> = items(reading.value(), "filter")
        .filter_map(|(at, filter)| Some((at, filter["parameters"]["predict"].as_f64()?)))
        .filter(|(_, predict)| *predict > stale_after)
        .collect();
    for (at, predict) in predicted {
        let key = KeyPath::root().key("filter").at(at);
        let expected = format!(
            "at most {:.0} ms, after which a tool without samples is stale (`stale_after`)",
            1e3 * stale_after
        );
        let found = format!("{:.0} ms", 1e3 * predict);
        reading.complain(&key.key("parameters").key("predict"), &found, &expected);
    }
}

/// Each marker is one device, of one instrument, and they determine a pose.
fn check_markers(reading: &mut Reading) {
    let root = KeyPath::root();
    let mut names: Vec<String> = Vec::new();
    let mut complaints = Vec::new();
    for (tool, entry) in items(reading.value(), "markers") {
        let key = root.key("markers").at(tool);
        for (marker, name) in texts(entry, "marker", "name") {
            let key = key.key("marker").at(marker).key("name");
            if names.contains(&name) {
                let found = format!("`{name}` a second time");
                complaints.push((key, found, "each device as one marker".to_owned()));
            }
            names.push(name);
        }
        if let Ok(tool) = serde_json::from_value::<MarkerTool>(entry.clone())
            && let Err(problem) = tool.model()
        {
            let expected = "three to eight markers that do not lie on a line".to_owned();
            complaints.push((key.key("marker"), problem.to_string(), expected));
        }
    }
    for (key, found, expected) in complaints {
        reading.complain(&key, &found, &expected);
    }
}

/// Reads the translator's file at `path`.
pub fn load_translator(path: &Path) -> Result<Loaded<Translator>, ConfigErrors> {
    let text = load_text(
        path,
        "the map from devices to tools (config/translator.toml)",
    )?;
    read_translator(&text, &path.display().to_string())
}
