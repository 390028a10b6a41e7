//! Plug-ins, messages, tools and appearance.

use crate::terms;

terms! {
    /// Kind of a plug-in. The order is that of a tick; the last two only observe.
    pub enum PluginKind {
        /// Publishes samples of devices.
        Source = "source",
        /// Turns samples of devices into poses of tools.
        Translator = "translator",
        /// Computes bodies and forces.
        Physics = "physics",
        /// Runs the task, measures and scores: a training module.
        Module = "module",
        /// Holds the virtual objects.
        Objects = "objects",
        /// Draws pictures.
        Renderer = "renderer",
        /// Writes the session.
        Recorder = "recorder",
    }
}

impl PluginKind {
    /// Observers receive messages, but nothing in the run depends on them: no state, no place on the bus.
    pub const fn is_observer(self) -> bool {
        matches!(self, Self::Renderer | Self::Recorder)
    }

    /// Whether one may run in a process of its own: those that publish little, and compute on one thread.
    pub const fn can_be_isolated(self) -> bool {
        matches!(self, Self::Source | Self::Translator | Self::Module)
    }
}

terms! {
    /// What happens when the queue of a subscriber is full.
    pub enum Overflow {
        /// For events: nothing may be lost, so the publication is refused and its sender is at fault.
        Refuse = "refuse",
        /// For states: the oldest message of the same kind in that queue makes room, and the loss is counted.
        DropOldest = "drop-oldest",
    }
}

terms! {
    /// How well the pose of a tool is known. "Connected" is not "tracked": a tool whose pose is old or missing never looks
    /// fine.
    pub enum ToolStatus {
        /// The last valid sample is recent, and the device has not reported since then that it does not see the instrument.
        Tracked = "tracked",
        /// Samples are recent, but the device was not visible, their values were refused, or for too long none was of a motion
        /// that a hand makes; the pose is the last valid one.
        Occluded = "occluded",
        /// No valid sample has arrived yet.
        NeverSeen = "never-seen",
        /// No sample has arrived for too long.
        Stale = "stale",
    }
}

terms! {
    /// What of a motion can be beyond the limits of a hand.
    pub enum MotionLimit {
        /// Speed of the tip \[m/s\].
        Speed = "speed",
        /// Acceleration of the tip \[m/s²\].
        Acceleration = "acceleration",
        /// Speed of turning \[rad/s\].
        TurnRate = "turn-rate",
        /// Change of the opening per time \[1/s\], from 0 closed to 1 open.
        OpeningRate = "opening-rate",
    }
}

impl MotionLimit {
    /// The unit of its values.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Speed => "m/s",
            Self::Acceleration => "m/s²",
            Self::TurnRate => "rad/s",
            Self::OpeningRate => "1/s",
        }
    }
}

terms! {
    /// How a scripted tool moves between two keyframes.
    #[derive(Default)]
    pub enum Interpolation {
        /// From rest to rest, as a hand does: s = 10τ³ − 15τ⁴ + 6τ⁵ (Flash & Hogan 1985).
        MinimumJerk = "minimum-jerk" default,
        /// At constant speed, which jumps in every keyframe.
        Linear = "linear",
    }
}

terms! {
    /// How a surface reflects light.
    #[derive(Default)]
    pub enum Finish {
        /// Diffuse, without highlight: cloth, silicone, painted targets.
        Matte = "matte" default,
        /// Diffuse with a small sharp highlight and a bright rim: tissue under irrigation.
        Moist = "moist",
        /// Mirrors its surroundings, tinted by its colour: instruments.
        Metal = "metal",
    }
}

terms! {
    /// How much is done for a picture.
    #[derive(Default)]
    pub enum PictureQuality {
        /// The most that the machine draws 25 times in a second.
        Automatic = "automatic" default,
        /// For drivers without a graphics card.
        Low = "low",
        /// Smooth edges, soft shadows, relief.
        Medium = "medium",
        /// More of each, a finer surface and depth of field.
        High = "high",
    }
}

terms! {
    /// How the pictures of both eyes lie in the window.
    #[derive(Default)]
    pub enum EyeLayout {
        /// One picture, from between the eyes.
        Mono = "mono" default,
        /// The left eye's in the left half.
        SideBySide = "side-by-side",
        /// The left eye's in the upper half.
        TopBottom = "top-bottom",
        /// The left eye's in every second row from the first: screens with polarised rows.
        RowInterleaved = "row-interleaved",
        /// The left eye's in red, the right eye's in green and blue.
        RedCyan = "red-cyan",
    }
}

/// Kind of the messages by which a trainee sets the microscope.
pub const MICROSCOPE_VIEW: &str = "microscope.view";
terms! {
    /// Keys that a foot switch may send: those of a keyboard that have no other meaning under the microscope.
    pub enum PedalKey {
        /// B.
        B = "B",
        /// D.
        D = "D",
        /// F.
        F = "F",
        /// M.
        M = "M",
        /// P.
        P = "P",
        /// T.
        T = "T",
        /// X.
        X = "X",
        /// Y.
        Y = "Y",
        /// Z.
        Z = "Z",
        /// 6.
        Digit6 = "6",
        /// 7.
        Digit7 = "7",
        /// 8.
        Digit8 = "8",
        /// 9.
        Digit9 = "9",
        /// F1.
        F1 = "F1",
        /// F7.
        F7 = "F7",
        /// F12.
        F12 = "F12",
        /// F13.
        F13 = "F13",
        /// F14.
        F14 = "F14",
        /// F15.
        F15 = "F15",
        /// F16.
        F16 = "F16",
        /// F17.
        F17 = "F17",
        /// F18.
        F18 = "F18",
        /// F19.
        F19 = "F19",
        /// F20.
        F20 = "F20",
        /// F21.
        F21 = "F21",
        /// F22.
        F22 = "F22",
        /// F23.
        F23 = "F23",
        /// F24.
        F24 = "F24",
        /// PageUp.
        PageUp = "PageUp",
        /// PageDown.
        PageDown = "PageDown",
        /// Insert.
        Insert = "Insert",
        /// Delete.
        Delete = "Delete",
        /// Backspace.
        Backspace = "Backspace",
    }
}

terms! {
    /// What is laid over a picture to see what is computed.
    pub enum DebugView {
        /// The edges of the surfaces of bodies.
        Wireframe = "wireframe",
        /// The capsules of tools, which are what touches tissue.
        Capsules = "capsules",
        /// The lines of no return of tools.
        NoReturn = "no-return",
        /// Where bodies are touched: forces and depths.
        Contacts = "contacts",
        /// Surfaces in the colours of von Mises stress.
        Stress = "stress",
        /// Surfaces in the colours of the quality of elements.
        Quality = "quality",
        /// Surfaces in the colours of what had to be done so that they could be computed.
        Remedies = "remedies",
    }
}

impl DebugView {
    /// Whether it colours the surfaces of bodies, as only one at a time can.
    pub const fn colours_surfaces(self) -> bool {
        matches!(self, Self::Stress | Self::Quality | Self::Remedies)
    }
}
