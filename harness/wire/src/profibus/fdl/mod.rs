//! FDL frames (telegrams), from the start delimiter to the end delimiter.
//!
//! This module must not know time: the duration of a frame is counted in bit times. Source: IEC 61158-4-3, DLPDU structure.

mod bits;
mod function;
mod stream;

pub use bits::{BaudRate, BitTimes};
pub use function::{AnswerFunction, FrameCount, FunctionCode, RequestFunction, StationType};
pub use stream::{FdlPiece, Splitter};

use crate::codes::codes;
use crate::error::{Result, WireError};
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

codes! {
    /// The start delimiter: the first byte of a frame, which defines the fields that follow (IEC 61158-4-3, start delimiters).
    pub struct StartDelimiter(u8) {
        0x10 SD1 no_data "A frame of fixed length without data.",
        0x68 SD2 variable_data "A frame of variable length.",
        0xA2 SD3 eight_octets "A frame of fixed length with 8 bytes of data.",
        0xDC SD4 token "The token, passed to the next master.",
        0xE5 SC short_acknowledgement "A short acknowledgement; this byte is the whole frame.",
    }
}

/// The end delimiter (ED): the last byte of a frame of SD1, SD2 or SD3.
pub const END_DELIMITER: u8 = 0x16;
/// The broadcast address.
pub const BROADCAST: u8 = 127;
/// The address of a slave that waits for Set_Slave_Address to assign one.
pub const UNNAMED: u8 = 126;
/// The maximum length of a frame in bytes: SD2, LE, LEr, SD2, 249 bytes, FCS and ED.
pub const LONGEST: usize = 255;
/// The maximum number of bytes after the function code, including address extensions (IEC 61158-4-3, LE: 4 to 249).
pub const MOST_DATA: usize = 246;

const LAYER: &str = "PROFIBUS FDL";
const EXTENDED: u8 = 0x80;

/// The address extension of DA or SA: segment and access point.
///
/// Bytes, if bit 7 of the address is set: bit 7 another byte follows, bit 6 a segment, else an access point (SAP), bits 5-0
/// its number, 0 to 63. The segment precedes the access point (IEC 61158-4-3, DAE and SAE).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Extension {
    /// The segment of the station, 0 to 63.
    pub segment: Option<u8>,
    /// The service access point, 0 to 63; `None` is the default access point.
    pub sap: Option<u8>,
}

impl Extension {
    /// Neither segment nor access point: the default access point.
    pub const NONE: Extension = Extension { segment: None, sap: None };

    /// An access point without segment.
    pub const fn sap(number: u8) -> Extension {
        Extension { segment: None, sap: Some(number) }
    }

    /// Whether there is no address extension.
    #[inline]
    pub fn is_empty(self) -> bool {
        self == Extension::NONE
    }

    /// The length of the address extension in bytes, 0 to 2.
    #[inline]
    pub fn length(self) -> usize {
        usize::from(self.segment.is_some()) + usize::from(self.sap.is_some())
    }

    #[inline]
    fn read(reader: &mut ByteReader<'_>) -> Result<Extension> {
        let first = reader.u8()?;
        let number = Some(first & 0x3F);
        match (first & 0x80 != 0, first & 0x40 != 0) {
            (false, false) => Ok(Extension { segment: None, sap: number }),
            (false, true) => Ok(Extension { segment: number, sap: None }),
            (true, true) => {
                let second = reader.u8()?;
                if second & 0xC0 != 0 {
                    return Err(reader.wrong("address extension", 1, "an access point, 0 to 63", second.into()));
                }
                Ok(Extension { segment: number, sap: Some(second) })
            }
            (true, false) => Err(reader.wrong("address extension", 1, "nothing after an access point", first.into())),
        }
    }

    #[inline]
    fn write(self, out: &mut Vec<u8>) {
        let Extension { segment, sap } = self;
        if let Some(segment) = segment {
            out.put_u8(0x40 | segment & 0x3F | if sap.is_some() { 0x80 } else { 0 });
        }
        if let Some(sap) = sap {
            out.put_u8(sap & 0x3F);
        }
    }
}

/// The format of a frame with a function code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FdlFormat {
    /// SD1: no bytes after the function code.
    NoData,
    /// SD2: 1 to 246 bytes after the function code.
    Variable,
    /// SD3: 8 bytes after the function code.
    EightOctets,
}

/// A frame with a function code: a request, a response or an acknowledgement.
///
/// Bytes of SD1: 0 SD1, 1 DA, 2 SA, 3 FC, 4 FCS, 5 ED. Of SD2: 0 SD2, 1 LE, 2 LEr (the same), 3 SD2, 4 DA, 5 SA, 6 FC, then
/// the extensions of DA and of SA, then data, FCS, ED; LE counts from DA to the last byte of data. Of SD3: 0 SD3, 1 DA, 2 SA,
/// 3 FC, 4-11 extensions and data, 12 FCS, 13 ED. FCS is the sum of the bytes from DA on without carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataFrame<'a> {
    /// The format of the frame.
    pub format: FdlFormat,
    /// DA: the destination address, 0 to 127.
    pub da: u8,
    /// SA: the source address, 0 to 127.
    pub sa: u8,
    /// FC: the function code.
    pub fc: FunctionCode,
    /// DAE: segment and access point of the destination.
    pub destination: Extension,
    /// SAE: segment and access point of the source.
    pub source: Extension,
    /// The data of the service.
    pub data: &'a [u8],
}

impl<'a> DataFrame<'a> {
    /// A frame between two access points, in the shortest format: SD1 without data, SD3 for 8 bytes, else SD2.
    #[inline]
    pub fn new(
        (da, destination): (u8, Extension),
        (sa, source): (u8, Extension),
        fc: FunctionCode,
        data: &'a [u8],
    ) -> DataFrame<'a> {
        let format = match destination.length() + source.length() + data.len() {
            0 => FdlFormat::NoData,
            8 => FdlFormat::EightOctets,
            _ => FdlFormat::Variable,
        };
        DataFrame { format, da, sa, fc, destination, source, data }
    }

    /// Parses the bytes from DA to the end of the data.
    #[inline]
    fn read(mut reader: ByteReader<'a>, format: FdlFormat) -> Result<DataFrame<'a>> {
        let (da, sa) = (reader.u8()?, reader.u8()?);
        let fc = FunctionCode(reader.u8()?);
        let mut extension = |address: u8| match address & EXTENDED {
            0 => Ok(Extension::NONE),
            _ => Extension::read(&mut reader),
        };
        let (destination, source) = (extension(da)?, extension(sa)?);
        let (da, sa) = (da & !EXTENDED, sa & !EXTENDED);
        Ok(DataFrame { format, da, sa, fc, destination, source, data: reader.rest() })
    }

    /// Appends the frame; the caller ensures that the data fit the format and are at most [`MOST_DATA`] bytes.
    pub fn write(&self, out: &mut Vec<u8>) {
        let address = |number: u8, extension: Extension| {
            if extension.is_empty() { number & !EXTENDED } else { number | EXTENDED }
        };
        let length = 3 + self.destination.length() + self.source.length() + self.data.len();
        // SD, LE, LEr, SD, FCS and ED are six bytes at most.
        out.reserve(length + 6);
        match self.format {
            FdlFormat::NoData => out.put_u8(StartDelimiter::SD1.0),
            FdlFormat::EightOctets => out.put_u8(StartDelimiter::SD3.0),
            FdlFormat::Variable => out.put(&[StartDelimiter::SD2.0, length as u8, length as u8, StartDelimiter::SD2.0]),
        }
        let counted = out.len();
        out.put(&[address(self.da, self.destination), address(self.sa, self.source), self.fc.0]);
        self.destination.write(out);
        self.source.write(out);
        out.put(self.data);
        let sum = checksum(out.get(counted..).unwrap_or_default());
        out.put(&[sum, END_DELIMITER]);
    }
}

/// The frame check sequence (FCS): the sum of the bytes modulo 256.
#[inline]
pub fn checksum(octets: &[u8]) -> u8 {
    octets.iter().fold(0, |sum, octet| sum.wrapping_add(*octet))
}

/// A frame of any kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FdlFrame<'a> {
    /// SD1, SD2 or SD3.
    Data(DataFrame<'a>),
    /// SD4. Bytes: 0 SD4, 1 DA, 2 SA; there is no checksum.
    Token {
        /// The master that gets the token, 0 to 126.
        da: u8,
        /// The master that passes it on, 0 to 126.
        sa: u8,
    },
    /// SC: one byte, without addresses and without checksum.
    ShortAcknowledgement,
}

impl<'a> FdlFrame<'a> {
    /// Parses `octets` as exactly one frame.
    ///
    /// Fails at the first invalid field: start delimiter, lengths, checksum, end delimiter, extensions, or bytes after the frame.
    pub fn parse(octets: &'a [u8]) -> Result<FdlFrame<'a>> {
        let mut reader = ByteReader::new(LAYER, octets);
        let start = StartDelimiter(reader.u8()?);
        let frame = match start {
            StartDelimiter::SD1 => FdlFrame::Data(body(&mut reader, FdlFormat::NoData, 3)?),
            StartDelimiter::SD3 => FdlFrame::Data(body(&mut reader, FdlFormat::EightOctets, 11)?),
            StartDelimiter::SD2 => {
                let length = variable_length(&mut reader)?;
                FdlFrame::Data(body(&mut reader, FdlFormat::Variable, length)?)
            }
            StartDelimiter::SD4 => FdlFrame::Token { da: reader.u8()?, sa: reader.u8()? },
            StartDelimiter::SC => FdlFrame::ShortAcknowledgement,
            StartDelimiter(other) => return Err(reader.wrong("SD", 1, "10, 68, A2, DC or E5", other.into())),
        };
        reader.end("nothing after the frame")?;
        Ok(frame)
    }

    /// The length in bytes of the frame that starts with `octets`; `None` if they are too few to determine it.
    ///
    /// Fails if no frame can start with them.
    pub fn length(octets: &[u8]) -> Result<Option<usize>> {
        let mut reader = ByteReader::new(LAYER, octets);
        let Ok(start) = reader.u8() else { return Ok(None) };
        match StartDelimiter(start) {
            StartDelimiter::SD1 => Ok(Some(6)),
            StartDelimiter::SD3 => Ok(Some(14)),
            StartDelimiter::SD4 => Ok(Some(3)),
            StartDelimiter::SC => Ok(Some(1)),
            StartDelimiter::SD2 => match variable_length(&mut reader) {
                Ok(length) => Ok(Some(length + 6)),
                Err(WireError::Short { .. }) => Ok(None),
                Err(error) => Err(error),
            },
            StartDelimiter(other) => Err(reader.wrong("SD", 1, "10, 68, A2, DC or E5", other.into())),
        }
    }

    /// Appends the frame.
    #[inline]
    pub fn write(&self, out: &mut Vec<u8>) {
        match self {
            FdlFrame::Data(frame) => frame.write(out),
            FdlFrame::Token { da, sa } => out.put(&[StartDelimiter::SD4.0, *da, *sa]),
            FdlFrame::ShortAcknowledgement => out.put_u8(StartDelimiter::SC.0),
        }
    }
}

/// Parses LE, LEr and the second SD2; returns LE.
#[inline]
fn variable_length(reader: &mut ByteReader<'_>) -> Result<usize> {
    let length = reader.u8()?;
    if !(4..=249).contains(&length) {
        return Err(reader.wrong("LE", 1, "4 to 249", length.into()));
    }
    let repeated = reader.u8()?;
    if repeated != length {
        return Err(reader.wrong("LEr", 1, "the same as LE", repeated.into()));
    }
    let start = reader.u8()?;
    if StartDelimiter(start) != StartDelimiter::SD2 {
        return Err(reader.wrong("second SD", 1, "68", start.into()));
    }
    Ok(length.into())
}

/// Parses `length` bytes from DA on, FCS and ED.
#[inline]
fn body<'a>(reader: &mut ByteReader<'a>, format: FdlFormat, length: usize) -> Result<DataFrame<'a>> {
    let counted = reader.sub(length)?;
    let sum = reader.u8()?;
    let mut octets = counted;
    if checksum(octets.rest()) != sum {
        return Err(reader.wrong("FCS", 1, "the sum of the bytes from DA on", sum.into()));
    }
    let end = reader.u8()?;
    if end != END_DELIMITER {
        return Err(reader.wrong("ED", 1, "16", end.into()));
    }
    DataFrame::read(counted, format)
}
