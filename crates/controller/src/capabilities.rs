//! What the system publishes of a device, readable by everybody (`/sys/class/input/eventN/device`).

use std::fs;
use std::path::Path;

/// What a device is and has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// Its name.
    pub name: String,
    /// Who made it.
    pub vendor: u16,
    /// What of that maker.
    pub product: u16,
    /// Its buttons and keys.
    pub buttons: Vec<u16>,
    /// Axes that state changes or deflections.
    pub relative: Vec<u16>,
    /// Axes that state values.
    pub absolute: Vec<u16>,
}

/// Reads them; `None` if the device is gone.
pub fn read(device: &Path) -> Option<Capabilities> {
    let text = |name: &str| fs::read_to_string(device.join(name)).ok();
    let number = |name: &str| u16::from_str_radix(text(name)?.trim(), 16).ok();
    let bits = |name: &str| Some(set_bits(&text(name)?));
    Some(Capabilities {
        name: text("name")?.trim().to_owned(),
        vendor: number("id/vendor")?,
        product: number("id/product")?,
        buttons: bits("capabilities/key")?,
        relative: bits("capabilities/rel")?,
        absolute: bits("capabilities/abs")?,
    })
}

/// The numbers of the bits that are set in words of 64 bits, the highest first.
fn set_bits(words: &str) -> Vec<u16> {
    let mut set = Vec::new();
    for (place, word) in words.split_whitespace().rev().enumerate() {
        let word = u64::from_str_radix(word, 16).unwrap_or_default();
        let bits = (0..64).filter(|bit| word >> bit & 1 == 1);
        set.extend(bits.filter_map(|bit| u16::try_from(64 * place as u64 + bit).ok()));
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the kernel has them of an Xbox gamepad: BTN_SOUTH (0x130) to BTN_THUMBR (0x13e) but 0x132, 0x135, 0x138 and 0x139; axes 0 to 5, 16 and 17.
    #[test]
    fn bits_are_numbered_from_the_end() {
        let buttons = [
            0x130, 0x131, 0x133, 0x134, 0x136, 0x137, 0x13a, 0x13b, 0x13c, 0x13d, 0x13e,
        ];
        assert_eq!(set_bits("7cdb000000000000 0 0 0 0\n"), buttons);
        assert_eq!(set_bits("3003f\n"), [0, 1, 2, 3, 4, 5, 16, 17]);
        assert_eq!(set_bits("0\n"), []);
    }
}
