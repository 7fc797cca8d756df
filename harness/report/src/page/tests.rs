use super::*;

fn page() -> HtmlPage {
    let span = |from: f64, to: f64, least: f64, most: f64| ValueSpan { from, to, least, most, joined: true };
    let packet = PagePacket {
        head: "packet 7".into(),
        octets: vec![0xC0, 0x01, 0x80],
        parts: vec![
            FramePart { octets: 0..2, name: "frame id".into(), value: "0xC001".into() },
            FramePart { octets: 2..3, name: "IOPS".into(), value: "<good>".into() },
        ],
        mark: Some((2, Some(7))),
    };
    let entry = PageEntry {
        anchor: "finding-1".into(),
        tone: Tone::Bad,
        word: "error".into(),
        head: "the name is '<script>alert(1)</script>'".into(),
        facts: vec![("clause".into(), "3.2 & 3.3".into())],
        packet: Some(packet),
        timelines: Vec::new(),
    };
    let timeline = Timeline {
        heading: "AR 1".into(),
        from: 0.0,
        to: 2.0,
        lanes: vec![
            Lane {
                name: "position".into(),
                shape: LaneShape::Line(vec![span(0.0, 1.0, 0.0, 10.0), span(1.0, 2.0, 5.0, 5.0)]),
            },
            Lane { name: "error".into(), shape: LaneShape::Bit(vec![span(0.5, 1.0, 1.0, 1.0)]) },
        ],
        marks: vec![Mark { at: 1.0, is_finding: true, text: "\"here\"".into(), anchor: Some("finding-1".into()) }],
        steady: String::new(),
    };
    let chapter = Chapter {
        heading: "capture\u{1b}[31m\u{202e}gpj".into(),
        entries: vec![entry],
        timelines: vec![timeline],
        ..Chapter::default()
    };
    HtmlPage {
        title: "t".into(),
        verdict: (Tone::Bad, "1 finding".into()),
        chapters: vec![chapter],
        ..HtmlPage::default()
    }
}

/// Texts of stations are shown and not interpreted; control and bidirectional characters are escaped.
#[test]
fn texts_are_escaped() {
    let text = html(&page());
    assert!(!text.contains("<script>alert"), "{text}");
    assert!(text.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    assert!(text.contains("3.2 &amp; 3.3"));
    assert!(text.contains("&lt;good&gt;"));
    assert!(!text.contains('\u{1b}'));
    assert!(
        !text.contains('\u{202e}') && text.contains("\\u{202e}gpj"),
        "a bidirectional character is not escaped: {text}"
    );
    assert!(text.contains("&quot;here&quot;"));
}

/// The page loads nothing.
#[test]
fn the_page_is_self_contained() {
    let text = html(&page());
    assert!(!text.contains("http://") && !text.contains("https://"), "the page has a link to another site");
    assert!(!text.contains(" src="));
    assert!(!text.contains("<link"));
    assert!(text.contains("default-src 'none'"));
}

/// The marked byte and bit are highlighted, and the mark of the timeline links to them.
#[test]
fn a_mark_leads_to_the_bit() {
    let text = html(&page());
    assert!(text.contains("<mark>80</mark>"));
    assert!(text.contains("byte 2 bit 7 is 1"));
    assert!(text.contains("<a href=\"#finding-1\"><line class=\"finding\" x1=\"5000.00\""));
}

/// A position that rises from 0 to 10 in the first half is drawn from the bottom to the top, then at the middle.
#[test]
fn a_line_is_drawn_to_scale() {
    let text = html(&page());
    assert!(text.contains("d=\"M0 96h2500v-92h2500v46h5000\""), "{text}");
}

/// A long page is packed: the same page is much shorter, and its chapters are inflated to what is written otherwise.
#[test]
fn a_long_page_is_packed() {
    let mut long = page();
    let short = html(&long);
    assert!(!short.contains("id=\"packed\""));
    long.chapters = vec![long.chapters[0].clone(); 300];
    let text = html(&long);
    assert!(text.len() < 100_000, "{}", text.len());
    let packed = text.split("id=\"packed\">").nth(1).and_then(|rest| rest.split('<').next()).expect("it is packed");
    let digits = |letter: u8| match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let bits: Vec<u8> = packed
        .trim_end_matches('=')
        .bytes()
        .flat_map(|letter| (0..6).rev().map(move |bit| digits(letter) >> bit & 1))
        .collect();
    let octets: Vec<u8> = bits.chunks_exact(8).map(|eight| eight.iter().fold(0, |sum, bit| sum << 1 | bit)).collect();
    let mut inflated = String::new();
    std::io::Read::read_to_string(&mut flate2::read::DeflateDecoder::new(octets.as_slice()), &mut inflated)
        .expect("raw deflate");
    assert_eq!(inflated.matches("byte 2 bit 7 is 1").count(), 300);
}
