//! The formats of parameter values.

use crate::codes::codes;

codes! {
    /// The format of the values of a parameter; unknown numbers are preserved.
    ///
    /// 0x01 to 0x38 are data types of the bus, 0x40 to 0x44 formats without a data type, 0x71 to 0x7C data types of the profile.
    /// Source: PROFIdrive profile, base mode parameter access and its table of data types.
    pub struct ParameterFormat(u8) {
        0x01 BOOLEAN boolean "A boolean in one byte.",
        0x02 INTEGER8 integer8 "A signed number of 8 bits.",
        0x03 INTEGER16 integer16 "A signed number of 16 bits.",
        0x04 INTEGER32 integer32 "A signed number of 32 bits.",
        0x05 UNSIGNED8 unsigned8 "A number of 8 bits.",
        0x06 UNSIGNED16 unsigned16 "A number of 16 bits.",
        0x07 UNSIGNED32 unsigned32 "A number of 32 bits.",
        0x08 FLOAT32 float32 "A floating-point number of 32 bits.",
        0x09 VISIBLE_STRING visible_string "A string of characters; the number of values is its length.",
        0x0A OCTET_STRING octet_string "A string of bytes; the number of values is its length.",
        0x0C TIME_OF_DAY time_of_day "Milliseconds of the day and days since 1984, 6 bytes.",
        0x0D TIME_DIFFERENCE time_difference "Milliseconds and days, 6 bytes.",
        0x0F FLOAT64 float64 "A floating-point number of 64 bits.",
        0x32 DATE date "Milliseconds, minutes, hours, days, months and years, 7 bytes.",
        0x34 TIME_OF_DAY_WITHOUT_DATE time_of_day_without_date "Milliseconds of the day, 4 bytes.",
        0x35 TIME_DIFFERENCE_WITH_DATE time_difference_with_date "Milliseconds and days, 6 bytes.",
        0x36 TIME_DIFFERENCE_WITHOUT_DATE time_difference_without_date "Milliseconds, 4 bytes.",
        0x37 INTEGER64 integer64 "A signed number of 64 bits.",
        0x38 UNSIGNED64 unsigned64 "A number of 64 bits.",
        0x40 ZERO zero "No values: the parameter was changed.",
        0x41 BYTE byte "Values of one byte.",
        0x42 WORD word "Values of two bytes.",
        0x43 DOUBLE_WORD double_word "Values of four bytes.",
        0x44 ERROR error "An error number instead of values, optionally with a subindex.",
        0x71 N2 n2 "A normalised value of 16 bits.",
        0x72 N4 n4 "A normalised value of 32 bits.",
        0x73 V2 v2 "A sequence of 16 bits.",
        0x74 L2 l2 "Four nibbles.",
        0x75 R2 r2 "A reciprocal time constant of 16 bits.",
        0x76 T2 t2 "A time constant of 16 bits.",
        0x77 T4 t4 "A time constant of 32 bits.",
        0x78 D2 d2 "A time constant of 16 bits between 0 and 2.",
        0x79 E2 e2 "A fixed-point value of 16 bits.",
        0x7A C4 c4 "A fixed-point value of 32 bits.",
        0x7B X2 x2 "A normalised value of 16 bits whose normalisation is given elsewhere.",
        0x7C X4 x4 "A normalised value of 32 bits whose normalisation is given elsewhere.",
    }
}

impl ParameterFormat {
    /// The width of one value in bytes; `None` for an unknown format.
    ///
    /// 1 for strings, whose values are bytes; 2 for [`ParameterFormat::ERROR`], whose values are words; 0 for [`ParameterFormat::ZERO`].
    pub fn width(self) -> Option<usize> {
        Some(match self.0 {
            0x40 => 0,
            0x01 | 0x02 | 0x05 | 0x09 | 0x0A | 0x41 => 1,
            0x03 | 0x06 | 0x42 | 0x44 | 0x71 | 0x73..=0x76 | 0x78 | 0x79 | 0x7B => 2,
            0x04 | 0x07 | 0x08 | 0x34 | 0x36 | 0x43 | 0x72 | 0x77 | 0x7A | 0x7C => 4,
            0x0C | 0x0D | 0x35 => 6,
            0x32 => 7,
            0x0F | 0x37 | 0x38 => 8,
            _ => return None,
        })
    }

    /// Whether the most significant bit of a value is its sign.
    pub fn is_signed(self) -> bool {
        matches!(self.0, 0x02..=0x04 | 0x37 | 0x71 | 0x72 | 0x79..=0x7C)
    }
}
