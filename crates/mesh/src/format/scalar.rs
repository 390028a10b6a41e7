//! Numbers as bytes: the types that mesh files use, in both byte orders.

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Endian {
    /// Lowest byte first.
    Little,
    /// Highest byte first.
    Big,
}

/// How a file writes its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// As decimal text between white space.
    Ascii,
    /// As bytes.
    Binary(Endian),
}

/// Type of a stored number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// The values of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Numbers {
    /// Of a whole-number type.
    Whole(Vec<i64>),
    /// Of a floating-point type.
    Real(Vec<f64>),
}

impl Scalar {
    /// Size \[bytes\].
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Whether it is a floating-point type.
    pub(super) fn is_real(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// The whole number in `bytes`, which are [`size`](Self::size) many; numbers beyond 64 signed bits are cut to the
    /// largest, which no count or index of a file can be.
    pub(super) fn whole(self, bytes: &[u8], endian: Endian) -> i64 {
        let mut low = [0; 8];
        for (k, slot) in low.iter_mut().enumerate().take(bytes.len()) {
            *slot = match endian {
                Endian::Little => bytes[k],
                Endian::Big => bytes[bytes.len() - 1 - k],
            };
        }
        let value = u64::from_le_bytes(low);
        match self {
            Self::I8 => i64::from(value as i8),
            Self::I16 => i64::from(value as i16),
            Self::I32 => i64::from(value as i32),
            Self::I64 => value as i64,
            Self::U8 | Self::U16 | Self::U32 | Self::U64 => {
                i64::try_from(value).unwrap_or(i64::MAX)
            }
            Self::F32 | Self::F64 => self.real(bytes, endian) as i64,
        }
    }

    /// The number in `bytes`, which are [`size`](Self::size) many.
    pub(super) fn real(self, bytes: &[u8], endian: Endian) -> f64 {
        match (self, endian, bytes) {
            (Self::F32, Endian::Little, &[a, b, c, d]) => {
                f64::from(f32::from_le_bytes([a, b, c, d]))
            }
            (Self::F32, Endian::Big, &[a, b, c, d]) => f64::from(f32::from_be_bytes([a, b, c, d])),
            (Self::F64, Endian::Little, &[a, b, c, d, e, f, g, h]) => {
                f64::from_le_bytes([a, b, c, d, e, f, g, h])
            }
            (Self::F64, Endian::Big, &[a, b, c, d, e, f, g, h]) => {
                f64::from_be_bytes([a, b, c, d, e, f, g, h])
            }
            (Self::F32 | Self::F64, ..) => f64::NAN,
            _ => self.whole(bytes, endian) as f64,
        }
    }

    /// All numbers in `bytes`.
    pub(super) fn decode(self, bytes: &[u8], endian: Endian) -> Numbers {
        let items = bytes.chunks_exact(self.size());
        if self.is_real() {
            Numbers::Real(items.map(|item| self.real(item, endian)).collect())
        } else {
            Numbers::Whole(items.map(|item| self.whole(item, endian)).collect())
        }
    }
}

impl Numbers {
    /// How many.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Whole(values) => values.len(),
            Self::Real(values) => values.len(),
        }
    }

    /// As floating-point numbers.
    pub(super) fn into_reals(self) -> Vec<f64> {
        match self {
            Self::Whole(values) => values.into_iter().map(|value| value as f64).collect(),
            Self::Real(values) => values,
        }
    }

    /// As whole numbers, if they are.
    pub(super) fn into_wholes(self) -> Option<Vec<i64>> {
        match self {
            Self::Whole(values) => Some(values),
            Self::Real(values) => values
                .into_iter()
                .map(|value| (value as i64 as f64 == value).then_some(value as i64))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two's complement and IEEE 754 by hand: −2 is all ones but the last bit, 1.5 is 3FC0… (single) or 3FF8… (double).
    #[test]
    fn bytes_are_numbers_in_both_orders() {
        let cases: [(Scalar, &[u8], f64); 8] = [
            (Scalar::I8, &[0xFE], -2.0),
            (Scalar::U8, &[0xFE], 254.0),
            (Scalar::I16, &[0xFF, 0xFE], -2.0),
            (Scalar::U16, &[0x01, 0x02], 258.0),
            (Scalar::I32, &[0xFF, 0xFF, 0xFF, 0xFE], -2.0),
            (Scalar::U64, &[0, 0, 0, 0, 0, 0, 1, 2], 258.0),
            (Scalar::F32, &[0x3F, 0xC0, 0, 0], 1.5),
            (Scalar::F64, &[0x3F, 0xF8, 0, 0, 0, 0, 0, 0], 1.5),
        ];
        for (scalar, big, value) in cases {
            let little: Vec<u8> = big.iter().rev().copied().collect();
            assert_eq!(scalar.size(), big.len());
            assert_eq!(scalar.real(big, Endian::Big), value);
            assert_eq!(scalar.real(&little, Endian::Little), value);
            assert_eq!(scalar.whole(big, Endian::Big), value as i64);
        }
        assert_eq!(Scalar::U64.whole(&[0xFF; 8], Endian::Little), i64::MAX);
        assert_eq!(Scalar::I64.whole(&[0xFF; 8], Endian::Little), -1);
        assert_eq!(Numbers::Real(vec![1.0, 1.5]).into_wholes(), None);
        assert_eq!(Numbers::Real(vec![f64::NAN]).into_wholes(), None);
    }
}
