//! Records of the kernel: `struct input_event` on 64-bit systems.

use crate::code::{EV_ABS, EV_KEY, EV_REL, EV_SYN, SYN_DROPPED, SYN_REPORT};

/// Length of a record: two times of 8 bytes, type, code, value.
pub const LENGTH: usize = 24;

/// What a record states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A button is pressed or released.
    Button(u16, bool),
    /// The deflection of an axis that is zero in reports without it.
    Relative(u16, i32),
    /// The value of an axis from now on.
    Absolute(u16, i32),
    /// The report is complete.
    Complete,
    /// Records were lost: what is up to the end of this report is void.
    Lost,
    /// Of no meaning here.
    Other,
}

/// The record that these bytes are.
pub fn parse(bytes: &[u8; LENGTH]) -> Event {
    let half = |at: usize| u16::from_ne_bytes([bytes[at], bytes[at + 1]]);
    let (kind, code) = (half(16), half(18));
    let value = i32::from_ne_bytes([bytes[20], bytes[21], bytes[22], bytes[23]]);
    match kind {
        EV_KEY => match value {
            // 2 repeats a key that is held.
            0 | 1 => Event::Button(code, value == 1),
            _ => Event::Other,
        },
        EV_REL => Event::Relative(code, value),
        EV_ABS => Event::Absolute(code, value),
        EV_SYN => match code {
            SYN_REPORT => Event::Complete,
            SYN_DROPPED => Event::Lost,
            _ => Event::Other,
        },
        _ => Event::Other,
    }
}

/// The bytes that the kernel writes for a record.
#[cfg(test)]
pub fn bytes(kind: u16, code: u16, value: i32) -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    bytes[0..8].copy_from_slice(&1_700_000_000_i64.to_ne_bytes());
    bytes[8..16].copy_from_slice(&123_456_i64.to_ne_bytes());
    bytes[16..18].copy_from_slice(&kind.to_ne_bytes());
    bytes[18..20].copy_from_slice(&code.to_ne_bytes());
    bytes[20..24].copy_from_slice(&value.to_ne_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record written by hand, little-endian as x86-64 is: 16 bytes of time, EV_ABS (3), ABS_RY (4), −2.
    #[test]
    fn records_are_read_as_the_kernel_writes_them() {
        let mut written = [0xaa; LENGTH];
        written[16..].copy_from_slice(&[3, 0, 4, 0, 0xfe, 0xff, 0xff, 0xff]);
        assert_eq!(parse(&written), Event::Absolute(4, -2));
        for (kind, code, value, event) in [
            (EV_KEY, 0x130, 1, Event::Button(0x130, true)),
            (EV_KEY, 0x130, 0, Event::Button(0x130, false)),
            (EV_KEY, 0x130, 2, Event::Other),
            (EV_REL, 5, -350, Event::Relative(5, -350)),
            (EV_SYN, SYN_REPORT, 0, Event::Complete),
            (EV_SYN, SYN_DROPPED, 0, Event::Lost),
            (EV_SYN, 1, 0, Event::Other),
            (4, 4, 589_825, Event::Other),
        ] {
            assert_eq!(parse(&bytes(kind, code, value)), event);
        }
    }
}
