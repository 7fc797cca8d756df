//! Lines of hex logs: a timestamp, bytes, and text that is ignored.
//!
//! ```text
//! # a comment
//! 12.345678 68 05 05 68 83 02 6D 3E 3C 6C 16
//! [2026-11-22 10:00:00.123456] TX: 10 02 01 49 4C 16   // another
//! 10:00:00.125 <- E5 |.|
//! 12345ms;RX;0x68,0x05,0x05,0x68
//! ```
//!
//! A byte is two hexadecimal digits, with or without separators. Direction marks and text in round brackets are ignored. Any
//! other word is an error, since it might be a mistyped byte.

use super::stamp::{TimestampKind, stamp};
use station::{Duration, Time};

/// A time of day that goes back by more than this belongs to the next day.
const HALF_A_DAY: Duration = Duration::from_secs(43_200);
const DAY: Duration = Duration::from_secs(86_400);
/// Direction marks, which are ignored.
const MARKS: &[&str] = &[
    "rx", "tx", "r", "t", "s", "w", "m", "i", "o", "in", "out", "recv", "received", "receive", "send", "sent", "read",
    "write", "written", "master", "slave", "host", "device", "request", "response", "req", "res", "rsp", "ind", "con",
];

/// Contiguous bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Start time of the first byte.
    pub begin: Time,
    /// The bytes.
    pub octets: Vec<u8>,
}

/// Reads a log line by line; it stores what its timestamps count from.
#[derive(Clone, Debug, Default)]
pub struct HexLog {
    /// What the first timestamp counts from, and its line number.
    kind: Option<(TimestampKind, usize)>,
    /// Number of midnights passed.
    days: u32,
    last: Time,
}

impl HexLog {
    /// The bytes of line `number`, from 1; `None` if it has none. The error says what is wrong and what to do.
    pub fn line(&mut self, number: usize, text: &str) -> Result<Option<Chunk>, String> {
        let text = text.trim_start_matches('\u{feff}').trim();
        if text.is_empty() || text.starts_with(';') || is_comment(text) {
            return Ok(None);
        }
        let Some((kind, time, rest)) = stamp(text) else {
            let begin: String = text.chars().take(24).collect();
            return Err(format!(
                "`{begin}` does not begin with a timestamp; write 12.345678, 10:00:00.123456 or 2026-11-22 10:00:00.123456 \
                 before the bytes, or # before a comment"
            ));
        };
        let (first, line) = *self.kind.get_or_insert((kind, number));
        if first != kind {
            return Err(format!(
                "the timestamp is {} and that of line {line} {}; import them separately",
                kind.word(),
                first.word()
            ));
        }
        let begin = if kind == TimestampKind::TimeOfDay { self.unrolled(time) } else { time };
        let octets = octets(rest)?;
        Ok((!octets.is_empty()).then_some(Chunk { begin, octets }))
    }

    /// A time of day plus all midnights passed.
    fn unrolled(&mut self, time: Time) -> Time {
        if self.last.since(time + DAY * self.days) > HALF_A_DAY {
            self.days += 1;
        }
        self.last = time + DAY * self.days;
        self.last
    }
}

fn is_comment(text: &str) -> bool {
    text.starts_with('#') || text.starts_with("//")
}

/// The bytes after a timestamp.
fn octets(text: &str) -> Result<Vec<u8>, String> {
    let mut octets = Vec::new();
    let mut rest = text;
    loop {
        rest = rest.trim_start_matches(|c: char| c.is_whitespace() || ",;:[]<>-=→←".contains(c));
        match rest.chars().next() {
            None => return Ok(octets),
            _ if is_comment(rest) => return Ok(octets),
            // The same bytes as text.
            Some('|') if !octets.is_empty() => return Ok(octets),
            Some('|') => rest = &rest[1..],
            Some('(') => {
                let Some((_, after)) = rest.split_once(')') else {
                    return Err("a round bracket is open; close it after the text to ignore".to_owned());
                };
                rest = after;
            }
            Some(_) => {
                let is_end = |c: char| c.is_whitespace() || ",;:[]<>-=→←|()".contains(c);
                // A lone closing bracket is a word, so that the loop always advances.
                let end = rest.char_indices().skip(1).find(|(_, c)| is_end(*c)).map_or(rest.len(), |(at, _)| at);
                let (word, after) = rest.split_at(end);
                if !MARKS.iter().any(|mark| mark.eq_ignore_ascii_case(word)) {
                    of_word(word, &mut octets)?;
                }
                rest = after;
            }
        }
    }
}

/// Appends the bytes of a word.
fn of_word(word: &str, octets: &mut Vec<u8>) -> Result<(), String> {
    let bare = ["0x", "0X", "\\x"].into_iter().find_map(|prefix| word.strip_prefix(prefix)).unwrap_or(word);
    let digits = bare.strip_suffix(['h', 'H']).unwrap_or(bare).as_bytes();
    let before = octets.len();
    for pair in digits.chunks(2) {
        let octet = match pair {
            [high, low] => digit(*high).zip(digit(*low)).map(|(high, low)| high << 4 | low),
            _ => None,
        };
        octets.extend(octet);
        if octet.is_none() {
            break;
        }
    }
    if digits.is_empty() || octets.len() - before < digits.len().div_ceil(2) {
        return Err(format!(
            "`{word}` is not a byte; bytes are two hexadecimal digits each; write text to ignore after # or in (round \
             brackets)"
        ));
    }
    Ok(())
}

fn digit(character: u8) -> Option<u8> {
    char::from(character).to_digit(16).and_then(|digit| u8::try_from(digit).ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const GET_CFG: [u8; 11] = [0x68, 0x05, 0x05, 0x68, 0x83, 0x02, 0x6D, 0x3B, 0x3E, 0x6B, 0x16];

    #[rstest]
    #[case("12.345678 68 05 05 68 83 02 6D 3B 3E 6B 16")]
    #[case("12.345678 68:05:05:68:83:02:6d:3b:3e:6b:16")]
    #[case("12.345678 68-05-05-68-83-02-6D-3B-3E-6B-16 # Get_Cfg")]
    #[case("12.345678 680505688302 6D3B3E6B16 // Get_Cfg")]
    #[case("12.345678,TX,0x68,0x05,0x05,0x68,0x83,0x02,0x6D,0x3B,0x3E,0x6B,0x16")]
    #[case("12.345678;68h 05h 05h 68h 83h 02h 6Dh 3Bh 3Eh 6Bh 16h")]
    #[case("[12.345678] M->S: 68 05 05 68 83 02 6D 3B 3E 6B 16")]
    #[case("[12.345678] [RX] (11) --> 68 05 05 68 83 02 6D 3B 3E 6B 16")]
    #[case("12.345678 | Master | 68 05 05 68 83 02 6D 3B 3E 6B 16 |h..h..m;>k.|")]
    #[case("\u{feff}12.345678 \\x68 \\x05 05 68 83 02 6D 3B 3E 6B 16\r")]
    #[case("12.345678 \u{2190} 68 05 05 68 83 02 6D 3B 3E 6B 16")]
    #[case("12345.678ms > 68 05 05 68 83 02 6D 3B 3E 6B 16")]
    fn lines_are_read(#[case] line: &str) {
        let chunk = HexLog::default().line(1, line);
        let expected = Chunk { begin: Time::from_nanos(12_345_678_000), octets: GET_CFG.to_vec() };
        assert_eq!(chunk, Ok(Some(expected)));
    }

    #[rstest]
    #[case("")]
    #[case("   \t")]
    #[case("# captured at the machine")]
    #[case("// 12.345 68")]
    #[case("; 12.345 68")]
    #[case("12.345678")]
    #[case("12.345678 RX # nothing")]
    fn lines_without_bytes_are_left_out(#[case] line: &str) {
        assert_eq!(HexLog::default().line(1, line), Ok(None));
    }

    #[rstest]
    #[case("68 05 05 68", "`68 05 05 68` does not begin with a timestamp; write 12.345678")]
    #[case("=== log of PuTTY ===", "or # before a comment")]
    #[case("12.3 6", "`6` is not a byte; bytes are two hexadecimal digits each")]
    #[case("12.3 68 055", "`055` is not a byte")]
    #[case("12.3 68 O5", "`O5` is not a byte")]
    #[case("12.3 68 05 diagnosis", "`diagnosis` is not a byte")]
    #[case("12.3 68 0x", "`0x` is not a byte")]
    #[case("12.3 68 05 (8", "a round bracket is open; close it")]
    #[case("12.3 68 )", "`)` is not a byte")]
    #[case("12.3 68 +5", "`+5` is not a byte")]
    fn wrong_lines_say_what_to_do(#[case] line: &str, #[case] message: &str) {
        let error = HexLog::default().line(1, line).expect_err("a wrong line");
        assert!(error.contains(message), "{error}");
    }

    #[test]
    fn timestamps_of_two_kinds_do_not_mix() {
        let mut log = HexLog::default();
        log.line(1, "12.5 E5").expect("a line");
        let error = log.line(4, "10:00:00 E5").expect_err("another kind");
        assert_eq!(error, "the timestamp is a time of day and that of line 1 seconds; import them separately");
    }

    #[test]
    fn times_of_day_continue_after_midnight() {
        let mut log = HexLog::default();
        let mut seconds =
            |line: &str| log.line(1, line).expect("a line").expect("bytes").begin.as_nanos() / 1_000_000_000;
        assert_eq!(seconds("23:59:59 E5"), 86_399);
        assert_eq!(seconds("00:00:01 E5"), 86_401);
        // A small step back is not a new day.
        assert_eq!(seconds("00:00:00 E5"), 86_400);
        assert_eq!(seconds("23:59:59 E5"), 2 * 86_400 - 1);
        assert_eq!(seconds("00:00:00 E5"), 2 * 86_400);
    }

    /// The reader does not panic, wherever a line is cut and whichever bit flips.
    #[test]
    fn every_prefix_and_every_flipped_bit_is_survived() {
        let lines = [
            "[2026-11-22 10:00:00.123456+01:30] TX: (11) 68 05 05 68 83 02 6D 3B 3E 6B 16 |h..h..m;>k.| # \u{e4}",
            "22.11.2026 10:00:00,5;RX;0x68,\\x05 \u{2192} 05h // x",
            "12345.678ms > 680505688302",
        ];
        for line in lines {
            for (end, _) in line.char_indices() {
                let octets = HexLog::default().line(1, &line[..end]).ok().flatten().map(|chunk| chunk.octets);
                let whole = HexLog::default().line(1, line).expect("a line").expect("bytes").octets;
                // A prefix never has other bytes than the whole line.
                assert!(octets.is_none_or(|octets| whole.starts_with(&octets)), "{}", &line[..end]);
            }
            for bit in 0..line.len() * 8 {
                let mut flipped = line.as_bytes().to_vec();
                flipped[bit / 8] ^= 1 << (bit % 8);
                let _ = HexLog::default().line(1, &String::from_utf8_lossy(&flipped));
            }
        }
    }
}
