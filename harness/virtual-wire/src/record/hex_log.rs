//! Lines of hex logs: a timestamp, octets, and what is passed over.
//!
//! ```text
//! # a comment
//! 12.345678 68 05 05 68 83 02 6D 3E 3C 6C 16
//! [2026-11-22 10:00:00.123456] TX: 10 02 01 49 4C 16   // another
//! 10:00:00.125 <- E5 |.|
//! 12345ms;RX;0x68,0x05,0x05,0x68
//! ```
//!
//! Octets are two hexadecimal digits each, with or without something between them. What looks like an octet is one, what is
//! known as a mark of a direction or stands in round brackets is passed over, and nothing else is: a word that is neither is a
//! mistake, since it might be an octet that was mistyped.

use super::stamp::{Kind, stamp};
use station::{Duration, Time};

/// A time of day that goes back by more than this is one of the next day.
const HALF_A_DAY: Duration = Duration::from_secs(43_200);
const DAY: Duration = Duration::from_secs(86_400);
/// Words that say who sent: they are passed over.
const MARKS: &[&str] = &[
    "rx", "tx", "r", "t", "s", "w", "m", "i", "o", "in", "out", "recv", "received", "receive", "send", "sent", "read",
    "write", "written", "master", "slave", "host", "device", "request", "response", "req", "res", "rsp", "ind", "con",
];

/// Octets that came in one go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// When the first of them began.
    pub begin: Time,
    /// The octets.
    pub octets: Vec<u8>,
}

/// Reads a log line by line; it remembers what its timestamps count from.
#[derive(Clone, Debug, Default)]
pub struct HexLog {
    /// What the first timestamp counts from, and its line.
    kind: Option<(Kind, usize)>,
    /// How often midnight went by.
    days: u32,
    last: Time,
}

impl HexLog {
    /// The octets of a line, `number` from 1; none where it has none. An error says what is wrong and what to do.
    pub fn line(&mut self, number: usize, text: &str) -> Result<Option<Chunk>, String> {
        let text = text.trim_start_matches('\u{feff}').trim();
        if text.is_empty() || text.starts_with(';') || is_comment(text) {
            return Ok(None);
        }
        let Some((kind, time, rest)) = stamp(text) else {
            let begin: String = text.chars().take(24).collect();
            return Err(format!(
                "`{begin}` begins with no timestamp; write 12.345678, 10:00:00.123456 or 2026-11-22 10:00:00.123456 \
                 in front of the octets, or # in front of a comment"
            ));
        };
        let (first, line) = *self.kind.get_or_insert((kind, number));
        if first != kind {
            return Err(format!(
                "the timestamp is {} and that of line {line} {}; import them one by one",
                kind.word(),
                first.word()
            ));
        }
        let begin = if kind == Kind::TimeOfDay { self.unrolled(time) } else { time };
        let octets = octets(rest)?;
        Ok((!octets.is_empty()).then_some(Chunk { begin, octets }))
    }

    /// A time of day behind all midnights that went by.
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

/// The octets behind a timestamp.
fn octets(text: &str) -> Result<Vec<u8>, String> {
    let mut octets = Vec::new();
    let mut rest = text;
    loop {
        rest = rest.trim_start_matches(|c: char| c.is_whitespace() || ",;:[]<>-=→←".contains(c));
        match rest.chars().next() {
            None => return Ok(octets),
            _ if is_comment(rest) => return Ok(octets),
            // The same octets as text.
            Some('|') if !octets.is_empty() => return Ok(octets),
            Some('|') => rest = &rest[1..],
            Some('(') => {
                let Some((_, behind)) = rest.split_once(')') else {
                    return Err("a round bracket is open; close it behind what is to be passed over".to_owned());
                };
                rest = behind;
            }
            Some(_) => {
                let is_end = |c: char| c.is_whitespace() || ",;:[]<>-=→←|()".contains(c);
                // A closing bracket of its own is a word, so that something is taken each time.
                let end = rest.char_indices().skip(1).find(|(_, c)| is_end(*c)).map_or(rest.len(), |(at, _)| at);
                let (word, behind) = rest.split_at(end);
                if !MARKS.iter().any(|mark| mark.eq_ignore_ascii_case(word)) {
                    of_word(word, &mut octets)?;
                }
                rest = behind;
            }
        }
    }
}

/// Appends the octets of a word.
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
            "`{word}` is no octet; octets are two hexadecimal digits each, and what is to be passed over stands behind # \
             or in (round brackets)"
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
    fn lines_without_octets_are_passed_over(#[case] line: &str) {
        assert_eq!(HexLog::default().line(1, line), Ok(None));
    }

    #[rstest]
    #[case("68 05 05 68", "`68 05 05 68` begins with no timestamp; write 12.345678")]
    #[case("=== log of PuTTY ===", "or # in front of a comment")]
    #[case("12.3 6", "`6` is no octet; octets are two hexadecimal digits each")]
    #[case("12.3 68 055", "`055` is no octet")]
    #[case("12.3 68 O5", "`O5` is no octet")]
    #[case("12.3 68 05 diagnosis", "`diagnosis` is no octet")]
    #[case("12.3 68 0x", "`0x` is no octet")]
    #[case("12.3 68 05 (8", "a round bracket is open; close it")]
    #[case("12.3 68 )", "`)` is no octet")]
    #[case("12.3 68 +5", "`+5` is no octet")]
    fn wrong_lines_say_what_to_do(#[case] line: &str, #[case] told: &str) {
        let error = HexLog::default().line(1, line).expect_err("a wrong line");
        assert!(error.contains(told), "{error}");
    }

    #[test]
    fn timestamps_of_two_kinds_do_not_mix() {
        let mut log = HexLog::default();
        log.line(1, "12.5 E5").expect("a line");
        let error = log.line(4, "10:00:00 E5").expect_err("another kind");
        assert_eq!(error, "the timestamp is a time of day and that of line 1 seconds; import them one by one");
    }

    #[test]
    fn midnight_goes_by() {
        let mut log = HexLog::default();
        let mut seconds =
            |line: &str| log.line(1, line).expect("a line").expect("octets").begin.as_nanos() / 1_000_000_000;
        assert_eq!(seconds("23:59:59 E5"), 86_399);
        assert_eq!(seconds("00:00:01 E5"), 86_401);
        // A little disorder is none of the days.
        assert_eq!(seconds("00:00:00 E5"), 86_400);
        assert_eq!(seconds("23:59:59 E5"), 2 * 86_400 - 1);
        assert_eq!(seconds("00:00:00 E5"), 2 * 86_400);
    }

    /// Nothing stops the reader, wherever a line is cut and whichever bit of it flips.
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
                let whole = HexLog::default().line(1, line).expect("a line").expect("octets").octets;
                // A prefix never has other octets than the whole line.
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
