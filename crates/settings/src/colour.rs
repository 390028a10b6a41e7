//! Colours as files write them.

use serde::{Deserialize, Serialize};

/// A colour in sRGB, 8 bits each, written `#rrggbb`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Colour {
    /// Red.
    pub red: u8,
    /// Green.
    pub green: u8,
    /// Blue.
    pub blue: u8,
}

impl Colour {
    /// Its three parts, each 0..1.
    pub fn srgb(self) -> [f64; 3] {
        [self.red, self.green, self.blue].map(|part| f64::from(part) / 255.0)
    }
}

impl TryFrom<String> for Colour {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.strip_prefix('#')
            .filter(|digits| digits.len() == 6)
            .and_then(|digits| u32::from_str_radix(digits, 16).ok())
            .map(|rgb| {
                let [_, red, green, blue] = rgb.to_be_bytes();
                Colour { red, green, blue }
            })
            .ok_or_else(|| format!("`{text}` is no colour"))
    }
}

impl From<Colour> for String {
    fn from(colour: Colour) -> Self {
        format!("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_keep_their_bytes() {
        let colour = Colour::try_from("#c0ff01".to_owned()).expect("a colour");
        assert_eq!((colour.red, colour.green, colour.blue), (0xc0, 0xff, 0x01));
        assert_eq!(String::from(colour), "#c0ff01");
        for wrong in ["c0ff01", "#c0ff0", "#c0ff0g", "#+0ff01x"] {
            assert!(Colour::try_from(wrong.to_owned()).is_err(), "{wrong}");
        }
    }
}
