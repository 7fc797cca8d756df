//! Packed capture files: recognised by their first octets, unpacked as they are read, in flat memory.
//!
//! What is wrong with the packing is told with the octet of the packed file at which it showed. This file must not know what a
//! capture is.

use std::fmt;
use std::io::{self, BufRead, BufReader, Chain, Cursor, ErrorKind, Read};

use flate2::bufread::MultiGzDecoder;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

/// Most octets that a packed file may refer back to; `zstd` asks for so much only from level 20 on or with `--long`.
const LONGEST_WINDOW: u64 = 16 * 1024 * 1024;
/// What is read of a packed file at a time, in octets.
const AT_A_TIME: usize = 64 * 1024;

/// A file whose first octets were looked at.
type Begun<R> = Chain<Cursor<Vec<u8>>, R>;

/// The octets of a file as they were before it was packed.
pub(super) enum Unpacked<R: Read> {
    Plain(Begun<R>),
    Gzip(Box<MultiGzDecoder<Counted<R>>>),
    Zstd(Box<Zstd<R>>),
}

/// How a packed file is damaged; it travels as the cause of an [`io::Error`].
#[derive(Debug)]
pub(super) struct PackingDamage {
    /// How many octets of the packed file were taken when it showed.
    pub packed_at: u64,
    /// What is wrong.
    pub what: String,
    /// Whether all octets were there and only their check sum does not agree, so that nobody knows which are wrong.
    pub untrusted: bool,
}

impl fmt::Display for PackingDamage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the packed file is damaged at or before its octet {}: {}", self.packed_at, self.what)
    }
}

impl std::error::Error for PackingDamage {}

impl<R: Read> Unpacked<R> {
    /// Looks at the first octets of `input`, whatever the file is called.
    pub fn new(mut input: R) -> io::Result<Unpacked<R>> {
        let mut begin = Vec::new();
        input.by_ref().take(4).read_to_end(&mut begin)?;
        let is_zstd = match begin.first_chunk::<4>().map(|magic| u32::from_le_bytes(*magic)) {
            // A frame, or one that is to be skipped (RFC 8878, 3.1).
            Some(magic) => magic == 0xFD2F_B528 || magic & 0xFFFF_FFF0 == 0x184D_2A50,
            None => false,
        };
        let is_gzip = begin.starts_with(&[0x1F, 0x8B]);
        let begun = Cursor::new(begin).chain(input);
        if !is_zstd && !is_gzip {
            return Ok(Unpacked::Plain(begun));
        }
        let counted = Counted { input: BufReader::with_capacity(AT_A_TIME, begun), taken: 0 };
        Ok(match is_gzip {
            true => Unpacked::Gzip(Box::new(MultiGzDecoder::new(counted))),
            false => Unpacked::Zstd(Box::new(Zstd::new(counted))),
        })
    }
}

impl<R: Read> Read for Unpacked<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            Unpacked::Plain(input) => input.read(into),
            Unpacked::Gzip(decoder) => decoder.read(into).map_err(|error| {
                let packed_at = decoder.get_ref().taken;
                match error.kind() {
                    ErrorKind::UnexpectedEof => ends_too_soon(packed_at),
                    ErrorKind::InvalidInput | ErrorKind::InvalidData => {
                        let untrusted = error.to_string().contains("checksum");
                        damaged(packed_at, error.to_string(), untrusted)
                    }
                    _ => error,
                }
            }),
            Unpacked::Zstd(decoder) => decoder.read(into),
        }
    }
}

fn ends_too_soon(packed_at: u64) -> io::Error {
    damaged(packed_at, "it ends too soon".to_owned(), false)
}

fn damaged(packed_at: u64, what: String, untrusted: bool) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, PackingDamage { packed_at, what, untrusted })
}

/// Counts the octets that were taken out of the packed file.
pub(super) struct Counted<R: Read> {
    input: BufReader<Begun<R>>,
    taken: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(into)?;
        self.taken += read as u64;
        Ok(read)
    }
}

impl<R: Read> BufRead for Counted<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.input.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        self.taken += count as u64;
        self.input.consume(count);
    }
}

/// The frames of a zstd file, one after the other.
pub(super) struct Zstd<R: Read> {
    input: Counted<R>,
    decoder: FrameDecoder,
    in_frame: bool,
    /// What is wrong, to be told behind what could be unpacked.
    failure: Option<io::Error>,
}

/// An empty raw block that is the last one (RFC 8878, 3.1.1.2), and room for a check sum: it makes the decoder hand out what it
/// keeps to refer back to.
const LAST_BLOCK: [u8; 7] = [1, 0, 0, 0, 0, 0, 0];

impl<R: Read> Zstd<R> {
    fn new(input: Counted<R>) -> Zstd<R> {
        let mut decoder = FrameDecoder::new();
        decoder.set_max_window_size(LONGEST_WINDOW);
        Zstd { input, decoder, in_frame: false, failure: None }
    }

    /// Begins the next frame, passing over what is to be skipped; false at the end of the file.
    fn begin(&mut self) -> io::Result<bool> {
        while !self.input.fill_buf()?.is_empty() {
            match self.decoder.init(&mut self.input) {
                Ok(()) => return Ok(true),
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                    let skipped = io::copy(&mut self.input.by_ref().take(length.into()), &mut io::sink())?;
                    if skipped < u64::from(length) {
                        return Err(ends_too_soon(self.input.taken));
                    }
                }
                Err(error) => return Err(self.wrong(&error)),
            }
        }
        Ok(false)
    }

    fn wrong(&mut self, error: &FrameDecoderError) -> io::Error {
        let at_end = self.input.fill_buf().is_ok_and(<[u8]>::is_empty);
        match error {
            FrameDecoderError::WindowSizeTooBig { requested, .. } => {
                let megabytes = requested.div_ceil(1024 * 1024);
                let what = format!("it is packed with a window of {megabytes} MB: unpack it first (zstd -d --long=31)");
                damaged(self.input.taken, what, false)
            }
            _ if at_end => ends_too_soon(self.input.taken),
            _ => damaged(self.input.taken, error.to_string(), false),
        }
    }

    /// Whether the check sum of the frame, where it has one, agrees.
    fn check(&self) -> io::Result<()> {
        match (self.decoder.get_checksum_from_data(), self.decoder.get_calculated_checksum()) {
            (Some(told), Some(is)) if told != is => {
                Err(damaged(self.input.taken, "its check sum does not agree".to_owned(), true))
            }
            _ => Ok(()),
        }
    }
}

impl<R: Read> Read for Zstd<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        loop {
            if self.failure.is_some() {
                let read = self.decoder.read(into)?;
                return if read > 0 { Ok(read) } else { self.failure.take().map_or(Ok(0), Err) };
            }
            if self.decoder.can_collect() > 0 {
                return self.decoder.read(into);
            }
            if self.in_frame && self.decoder.is_finished() {
                self.in_frame = false;
                self.check()?;
            }
            if !self.in_frame {
                if !self.begin()? {
                    return Ok(0);
                }
                self.in_frame = true;
            }
            let strategy = BlockDecodingStrategy::UptoBlocks(1);
            if let Err(error) = self.decoder.decode_blocks(&mut self.input, strategy) {
                self.failure = Some(self.wrong(&error));
                // It fails where the last block was there already, and then nothing is kept back.
                let _ = self.decoder.decode_blocks(&LAST_BLOCK[..], BlockDecodingStrategy::All);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CaptureReader, Effect, Item, NotACapture};
    use crate::damage::{every_flipped_bit, every_prefix};
    use rstest::rstest;

    /// Two packets in a pcap file, packed by gzip 1.12 -9n.
    const GZIP: &str =
        "1f8b0800000000000203bb7278d3422606160618f8ff9f81819101824140048a19b101a83a981a262c0000c6aa56cc60000000";
    /// The same by zstd 1.5.4.
    const ZSTD: &str =
        "28b52ffd246035010090d4c3b2a102000400ffff00000100140114020800b82420df5259e0e8ed9cc1b23b5c08c005fa2d082e";

    fn octets(hex: &str) -> Vec<u8> {
        let pair = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal");
        (0..hex.len()).step_by(2).map(pair).collect()
    }

    /// The packets, and what of the damage is told.
    type Told = (Vec<Vec<u8>>, Vec<(u64, Effect, String)>);

    fn read(file: &[u8]) -> Told {
        let (mut packets, mut damage) = (Vec::new(), Vec::new());
        let mut reader = match CaptureReader::new(file) {
            Ok(reader) => reader,
            Err(refused) => return (packets, vec![(0, Effect::Missing, refused.to_string())]),
        };
        while let Some(item) = reader.next() {
            match item {
                Item::Packet(packet) => packets.push(packet.captured.to_vec()),
                Item::Damage(found) => damage.push((found.at, found.effect, found.what)),
            }
            assert!(packets.len() + damage.len() < 100, "a small file without an end");
        }
        (packets, damage)
    }

    fn both() -> Vec<Vec<u8>> {
        vec![vec![1; 20], vec![2; 20]]
    }

    #[rstest]
    fn packed_files_are_read_whatever_they_are_called(#[values(GZIP, ZSTD)] packed: &str) {
        assert_eq!(read(&octets(packed)), (both(), vec![]));
    }

    /// Both formats allow files one behind the other; zstd allows more between them that nobody has to read.
    #[test]
    fn packed_parts_follow_each_other() {
        let mut gzip = octets(GZIP);
        gzip.extend(octets(GZIP));
        let (packets, damage) = read(&gzip);
        // The second file header is no record.
        assert_eq!((packets.len(), damage.len()), (4, 1), "{damage:?}");
        let mut zstd = vec![0x5A, 0x2A, 0x4D, 0x18, 2, 0, 0, 0, 7, 7];
        zstd.extend(octets(ZSTD));
        zstd.extend([0x50, 0x2A, 0x4D, 0x18, 0, 0, 0, 0]);
        assert_eq!(read(&zstd), (both(), vec![]));
    }

    #[rstest]
    fn what_ends_too_soon_says_so_with_the_octet(#[values(GZIP, ZSTD)] packed: &str) {
        every_prefix(&octets(packed), |prefix| {
            let (packets, damage) = read(prefix);
            assert!(both().starts_with(&packets));
            assert!(!damage.is_empty() || prefix.len() + 8 >= packed.len() / 2, "{} octets are whole", prefix.len());
        });
        let packed = octets(packed);
        let (packets, damage) = read(&packed[..packed.len() - 1]);
        assert_eq!(packets, both());
        let (at, effect, what) = &damage[0];
        assert_eq!((*at, *effect), (96, Effect::Missing));
        assert!(what.contains("octet") && what.ends_with("it ends too soon"), "{what}");
    }

    /// A flipped bit of the packed octets is never taken for what was captured, except where nobody can tell.
    #[rstest]
    fn a_flipped_bit_is_found(#[values(GZIP, ZSTD)] packed: &str) {
        let mut untrusted = 0;
        every_flipped_bit(&octets(packed), |index, flipped| {
            let (packets, damage) = read(flipped);
            assert!(packets == both() || !damage.is_empty(), "octet {index}: {packets:?}");
            untrusted += usize::from(damage.iter().any(|(_, effect, _)| *effect == Effect::Untrusted));
        });
        assert!(untrusted > 0, "no check sum was looked at");
    }

    #[test]
    fn a_window_that_would_not_fit_is_refused_with_what_to_do() {
        // A frame header with the window descriptor 0x88: 2 to the power of 27, 128 MB.
        let file = [0x28, 0xB5, 0x2F, 0xFD, 0x00, 0x88, 1, 0, 0];
        let refused = CaptureReader::new(&file[..]).expect_err("too large");
        assert!(matches!(refused, NotACapture::Unreadable(_)));
        assert!(refused.to_string().ends_with("a window of 128 MB: unpack it first (zstd -d --long=31)"), "{refused}");
    }
}
