//! Numbers of the kernel (`linux/input-event-codes.h`).

/// End of a report, or lost records.
pub const EV_SYN: u16 = 0;
/// A button.
pub const EV_KEY: u16 = 1;
/// An axis of which a SpaceMouse states the deflection in each report in which it is not zero.
pub const EV_REL: u16 = 2;
/// An axis that states its value when it changes.
pub const EV_ABS: u16 = 3;

/// The end of a report.
pub const SYN_REPORT: u16 = 0;
/// Records before this one were lost.
pub const SYN_DROPPED: u16 = 3;

/// To the right; the others of the first six follow.
pub const X: u16 = 0;
/// Towards the user.
pub const Y: u16 = 1;
/// Down; of gamepads the left trigger, or the right stick to the right.
pub const Z: u16 = 2;
/// About x; of gamepads the right stick to the right.
pub const RX: u16 = 3;
/// About y; of gamepads the right stick towards the user.
pub const RY: u16 = 4;
/// About z; of gamepads the right trigger, or the right stick towards the user.
pub const RZ: u16 = 5;
/// Right trigger of gamepads whose right stick is z and rz.
pub const GAS: u16 = 9;
/// Left trigger of these.
pub const BRAKE: u16 = 10;
/// The cross of a gamepad, to the right.
pub const HAT_X: u16 = 16;
/// The cross of a gamepad, towards the user.
pub const HAT_Y: u16 = 17;

/// First button of a device of no other kind: left one of a SpaceMouse.
pub const BUTTON_0: u16 = 0x100;
/// Its right one.
pub const BUTTON_1: u16 = 0x101;
/// Lower button of a gamepad: A, cross.
pub const SOUTH: u16 = 0x130;
/// X of most gamepads with letters (which is to the left), triangle.
pub const NORTH: u16 = 0x133;
/// Y of those (which is the upper one), square.
pub const WEST: u16 = 0x134;
/// Left shoulder.
pub const LEFT_SHOULDER: u16 = 0x136;
/// Right shoulder.
pub const RIGHT_SHOULDER: u16 = 0x137;
/// Left trigger as a button.
pub const LEFT_TRIGGER: u16 = 0x138;
/// Right trigger as a button.
pub const RIGHT_TRIGGER: u16 = 0x139;
/// Start, menu, options.
pub const START: u16 = 0x13b;
/// The cross of a gamepad as four buttons: up, down, left, right.
pub const CROSS: [u16; 4] = [0x220, 0x221, 0x222, 0x223];
