//! What a device is, by what it has.

use crate::capabilities::Capabilities;
use crate::code::{RX, RY, RZ, SOUTH, X, Y, Z};

/// What is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A gamepad.
    Gamepad,
    /// A cap with six axes.
    SpaceMouse,
}

/// 3Dconnexion, whose devices are nothing but such caps.
const CONNEXION: u16 = 0x256f;
/// Logitech, which made them before; it makes other devices as well.
const LOGITECH: u16 = 0x046d;
/// What Logitech's numbers of them begin with.
const LOGITECH_CAPS: u16 = 0xc600;

/// The kind of a device; `None` of keyboards, mice and all others.
pub fn kind(of: &Capabilities) -> Option<Kind> {
    // Motion sensors of a gamepad are a device of their own, which has axes and no button.
    if of.buttons.contains(&SOUTH) && of.absolute.contains(&X) && of.absolute.contains(&Y) {
        return Some(Kind::Gamepad);
    }
    let is_cap =
        of.vendor == CONNEXION || (of.vendor == LOGITECH && of.product & 0xff00 == LOGITECH_CAPS);
    let all = [X, Y, Z, RX, RY, RZ];
    let six = |axes: &[u16]| all.iter().all(|axis| axes.contains(axis));
    (is_cap && (six(&of.relative) || six(&of.absolute))).then_some(Kind::SpaceMouse)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(vendor: u16, product: u16) -> Capabilities {
        Capabilities {
            vendor,
            product,
            ..Capabilities::default()
        }
    }

    #[test]
    fn devices_are_known_by_what_they_have() {
        let xbox = Capabilities {
            buttons: vec![SOUTH, 0x131],
            absolute: vec![X, Y, Z, RX, RY, RZ],
            ..device(0x045e, 0x02ea)
        };
        assert_eq!(kind(&xbox), Some(Kind::Gamepad));
        let sensors = Capabilities {
            absolute: vec![X, Y, Z, RX, RY, RZ],
            ..device(0x054c, 0x09cc)
        };
        assert_eq!(kind(&sensors), None);
        let cap = Capabilities {
            buttons: vec![0x100, 0x101],
            relative: vec![X, Y, Z, RX, RY, RZ],
            ..device(LOGITECH, 0xc626)
        };
        assert_eq!(kind(&cap), Some(Kind::SpaceMouse));
        let mouse = Capabilities {
            buttons: vec![0x110],
            relative: vec![X, Y, 8],
            ..device(LOGITECH, 0xc077)
        };
        assert_eq!(kind(&mouse), None);
        // The receiver of a cap has a mouse and a keyboard as well.
        let receiver = Capabilities {
            vendor: CONNEXION,
            ..mouse
        };
        assert_eq!(kind(&receiver), None);
        let newer = Capabilities {
            absolute: vec![X, Y, Z, RX, RY, RZ],
            ..device(CONNEXION, 0xc635)
        };
        assert_eq!(kind(&newer), Some(Kind::SpaceMouse));
    }
}
