//! `encspec record`: hex logs, a serial line, and the resulting captures in `dissect` and `replay`.

use crate::common::program::{self, ProgramOutput};
use encspec::observe::ProfibusWords;
use encspec::record::import;
use link::serial::pty;
use link::{Serial, SerialSettings};
use rstest::rstest;
use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use testing::Folder;
use virtual_wire::CaptureReader;
use virtual_wire::capture::{CaptureItem, LinkType};

/// How long a recording may take to write the frames of a line.
const WRITTEN_WITHIN: Duration = Duration::from_secs(60);

/// Exit status, standard output and standard error.
fn encspec(folder: impl AsRef<Path>, arguments: &[&str]) -> (Option<i32>, String, String) {
    let ProgramOutput { status, out, err } = program::encspec(folder, arguments);
    (status, out, err)
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct RecordedPacket {
    nanos: u64,
    octets: Vec<u8>,
    comment: Option<String>,
}

fn packet(nanos: u64, octets: &[u8]) -> RecordedPacket {
    RecordedPacket { nanos, octets: octets.to_vec(), comment: None }
}

/// The packets of a PROFIBUS capture.
fn packets(file: &[u8]) -> Vec<RecordedPacket> {
    let mut reader = CaptureReader::new(file).expect("a capture");
    let mut found = Vec::new();
    while let Some(item) = reader.next() {
        let CaptureItem::Packet(packet) = item else { panic!("the capture is damaged: {item:?}") };
        assert_eq!(packet.link_type, LinkType::PROFIBUS);
        let comment = packet.comment.as_deref().map(str::to_owned);
        found.push(RecordedPacket { nanos: packet.time.as_nanos(), octets: packet.captured.to_vec(), comment });
    }
    found
}

fn imported(log: &str) -> Vec<RecordedPacket> {
    packets(&import(log.as_bytes(), Vec::new(), "a log", None).expect("a good log").0)
}

fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
}

/// The frames that pyprofibus built.
fn golden() -> Vec<Vec<u8>> {
    testing::golden("pyprofibus.txt").into_iter().map(|(_, octets)| octets).collect()
}

/// Frames built by pyprofibus keep their bytes and times through a log, and are dissected.
#[test]
fn the_golden_frames_go_through_a_log() {
    let folder = Folder::new("golden");
    let frames = golden();
    assert!(frames.len() > 20);
    let mut log = String::from("# frames of pyprofibus\n\n");
    for (second, frame) in frames.iter().enumerate() {
        let mark = if second % 2 == 0 { "TX:" } else { "<-" };
        writeln!(log, "{second}.250000001 {mark} {} // {} octets", hex(frame), frame.len()).expect("a string");
    }
    fs::write(folder.join("bus.log"), log).expect("the log");
    let (status, out, err) = encspec(&folder, &["record", "bus.pcapng", "--from-hex", "bus.log"]);
    assert_eq!((status, err.as_str()), (Some(0), ""));
    assert_eq!(out, format!("bus.pcapng: {} frames in {}.000 s\n", frames.len(), frames.len() - 1));
    let times = (0..).map(|second| second * 1_000_000_000 + 250_000_001);
    let expected: Vec<RecordedPacket> = times.zip(&frames).map(|(nanos, octets)| packet(nanos, octets)).collect();
    assert_eq!(packets(&fs::read(folder.join("bus.pcapng")).expect("the capture")), expected);

    let (status, out, _) = encspec(&folder, &["dissect", "bus.pcapng"]);
    assert_eq!(status, Some(0));
    let mut words = ProfibusWords::default();
    for (second, frame) in frames.iter().enumerate() {
        let line = format!(" {second}.250000 {}\n", words.lines(frame)[0]);
        assert!(out.contains(&line), "{line} is not in\n{out}");
    }
}

/// Of a log cut off anywhere, everything before the cut is imported: complete frames as frames, the rest as damage.
#[test]
fn every_prefix_of_a_log_has_its_frames() {
    let (first, second) = ("[10:00:00.5] 68 05 05 68 88 82", "[10:00:00.501] 4D 3B 3E D0 16 DC 02 02\n");
    let log = format!("{first}\n{second}");
    let whole: Vec<u8> = [0x68, 5, 5, 0x68, 0x88, 0x82, 0x4D, 0x3B, 0x3E, 0xD0, 0x16, 0xDC, 2, 2].into();
    for end in 0..=log.len() {
        let Ok((file, counts)) = import(&log.as_bytes()[..end], Vec::new(), "a log", None) else { continue };
        let found = packets(&file);
        let octets: Vec<u8> = found.iter().flat_map(|packet| packet.octets.clone()).collect();
        assert!(whole.starts_with(&octets), "{end}: {octets:02X?}");
        assert_eq!(found.len() as u64, counts.frames + counts.damaged);
        assert_eq!(counts.frames, u64::from(octets.len() >= 11) + u64::from(octets.len() == 14), "{end}");
        assert!(found.first().is_none_or(|packet| packet.nanos == 36_000_500_000_000), "{end}");
    }
    assert_eq!(imported(&log).len(), 2);
}

#[test]
fn noise_is_imported_as_damage() {
    let found = imported("1.0 00 FF 68 05\n1.5 10 02 08 00 0A 16\n2.0 DC 02 02 16\n3.0 E5\n");
    let octets: Vec<&[u8]> = found.iter().map(|packet| &packet.octets[..]).collect();
    let expected: [&[u8]; 5] =
        [&[0x00, 0xFF, 0x68, 0x05], &[0x10, 2, 8, 0, 0x0A, 0x16], &[0xDC, 2, 2], &[0x16], &[0xE5]];
    assert_eq!(octets, expected);
    let damaged: Vec<usize> = (0..5).filter(|at| found[*at].comment.is_some()).collect();
    assert_eq!(damaged, [0, 3]);
    let comment = found[0].comment.as_deref().expect("a comment");
    assert!(comment.starts_with("no frame: PROFIBUS FDL: byte 0"), "{comment}");
}

#[rstest]
#[case::stamp("0.5 E5\n68 05\n", "log.txt:2: `68 05` does not begin with a timestamp; write 12.345678")]
#[case::octet("0.5 E5\n\n# x\n0.6 6G 05\n", "log.txt:4: `6G` is not a byte; bytes are two hexadecimal digits each")]
#[case::kinds("0.5 E5\n10:00:00 E5\n", "log.txt:2: the timestamp is a time of day and that of line 1 seconds; import")]
#[case::no_octets("# nothing\n", "log.txt: no line has any bytes")]
#[case::no_frames("0.5 01 02 03\n", "log.txt: no valid PROFIBUS frame")]
fn an_invalid_log_is_reported_with_its_line(#[case] log: &str, #[case] error: &str) {
    let folder = Folder::new("wrong");
    fs::write(folder.join("log.txt"), log).expect("the log");
    let (status, out, err) = encspec(&folder, &["record", "bus.pcapng", "--from-hex", "log.txt"]);
    assert_eq!((status, out.as_str()), (Some(2), ""), "{err}");
    assert!(err.contains(error), "{err}");
    assert!(!folder.join("bus.pcapng").exists(), "no incomplete capture is left");
}

#[test]
fn twenty_errors_of_a_log_are_listed_and_the_rest_counted() {
    let folder = Folder::new("many");
    fs::write(folder.join("log.txt"), "hello\n".repeat(50)).expect("the log");
    let (_, _, err) = encspec(&folder, &["record", "bus.pcapng", "--from-hex", "log.txt"]);
    assert_eq!(err.lines().count(), 21, "{err}");
    assert!(err.ends_with("30 more errors in log.txt\n"), "{err}");
}

#[rstest]
#[case::nothing(&["record", "a.pcapng"], "--serial <TTY>")]
#[case::baud(&["record", "a.pcapng", "--serial", "/dev/null"], "--baud <RATE>")]
#[case::rate(&["record", "a.pcapng", "--serial", "/dev/null", "--baud", "9601"], "use one of 9600, 19200, 45450")]
#[case::both(&["record", "a.pcapng", "--serial", "/dev/null", "--nic", "eth0", "--baud", "9600"], "cannot be used with")]
#[case::log(&["record", "a.pcapng", "--from-hex", "nowhere.log"], "nowhere.log: cannot be read")]
fn a_usage_error_creates_no_file(#[case] arguments: &[&str], #[case] says: &str) {
    let folder = Folder::new("mistake");
    let (status, _, err) = encspec(&folder, arguments);
    assert_eq!(status, Some(2), "{err}");
    assert!(err.contains(says), "{err}");
    assert_eq!(fs::read_dir(&folder).expect("the folder").count(), 0, "a mistake leaves nothing behind");
}

#[rstest]
#[case::serial(&["record", "a.pcapng", "--serial", "/dev/null", "--baud", "9600"], "is not a serial line")]
#[case::nic(&["record", "a.pcapng", "--nic", "nowhere-at-all"], "nowhere-at-all")]
fn an_unusable_source_creates_no_file(#[case] arguments: &[&str], #[case] says: &str) {
    let folder = Folder::new("nowhere");
    let (status, _, err) = encspec(&folder, arguments);
    assert_eq!(status, Some(3), "{err}");
    assert!(err.contains(says), "{err}");
    assert_eq!(fs::read_dir(&folder).expect("the folder").count(), 0, "a mistake leaves nothing behind");
}

#[test]
fn an_existing_file_is_not_overwritten() {
    let folder = Folder::new("twice");
    fs::write(folder.join("log.txt"), "0.5 E5\n").expect("the log");
    fs::write(folder.join("bus.pcapng"), "precious").expect("a file");
    let (status, _, err) = encspec(&folder, &["record", "bus.pcapng", "--from-hex", "log.txt"]);
    assert_eq!(status, Some(2));
    assert!(err.contains("remove it or choose another name"), "{err}");
    assert_eq!(fs::read_to_string(folder.join("bus.pcapng")).expect("the file"), "precious");
}

/// Records a serial line until Ctrl-C; the file then holds every frame.
#[test]
fn a_serial_line_is_recorded_until_ctrl_c() {
    let folder = Folder::new("line");
    let (mut control, path) = pty::open().expect("a pseudoterminal");
    let line = path.to_str().expect("a path of ASCII").to_owned();
    let mut recording =
        program::command(folder.path(), &["record", "line.pcapng", "--serial", &line, "--baud", "19200"])
            .stdout(Stdio::piped())
            .spawn()
            .expect("the binary");
    let mut said = BufReader::new(recording.stdout.take().expect("a pipe"));
    let mut first = String::new();
    said.read_line(&mut first).expect("UTF-8");
    assert_eq!(first, format!("listening at the serial line {line}\n"));
    let frames = golden();
    let file = folder.join("line.pcapng");
    let size = || fs::read(&file).expect("the capture").len();
    // An enhanced packet block has 32 bytes beside its data, which is padded to a multiple of 4.
    let complete = size() + frames.iter().map(|frame| 32 + frame.len().next_multiple_of(4)).sum::<usize>();
    for frame in &frames {
        control.write_all(frame).expect("the line takes it");
    }
    // The frames are in the file before the recording ends.
    let began = std::time::Instant::now();
    while size() < complete {
        assert!(began.elapsed() < WRITTEN_WITHIN, "the recording has not written all frames");
        std::thread::yield_now();
    }
    assert!(Command::new("kill").args(["-INT", &recording.id().to_string()]).status().expect("kill").success());
    let mut rest = String::new();
    said.read_to_string(&mut rest).expect("UTF-8");
    assert_eq!(recording.wait().expect("an end").code(), Some(0), "{rest}");
    assert!(rest.starts_with(&format!("line.pcapng: {} frames in ", frames.len())), "{rest}");
    let found = packets(&fs::read(&file).expect("the capture"));
    assert_eq!(found.iter().map(|packet| packet.octets.clone()).collect::<Vec<_>>(), frames);
    // Unix times in ascending order.
    assert!(found[0].nanos > 1_700_000_000_000_000_000);
    assert!(found.windows(2).all(|pair| pair[0].nanos <= pair[1].nanos));
    // The recorder sent nothing. Reading ends with an error, since the other end is closed.
    let mut sent = Vec::new();
    assert!(control.read_to_end(&mut sent).is_err() && sent.is_empty(), "{sent:02X?}");
}

#[test]
fn a_listening_line_cannot_send() {
    let (_control, path) = pty::open().expect("a pseudoterminal");
    let mut line = Serial::listen(&path, &SerialSettings::new(19_200)).expect("the other end is open");
    assert!(line.send(&[0xE5]).is_err());
}

#[test]
fn a_silent_line_is_reported() {
    let folder = Folder::new("silent");
    let (_control, path) = pty::open().expect("a pseudoterminal");
    let line = path.to_str().expect("a path of ASCII");
    let (status, out, err) =
        encspec(&folder, &["record", "a.pcapng", "--serial", line, "--baud", "19200", "--duration", "1"]);
    assert_eq!(status, Some(3), "{err}");
    assert!(out.ends_with("a.pcapng: 0 frames in 0.000 s\n"), "{out}");
    assert!(err.contains("nothing received"), "{err}");
}

/// The captures of a run give the same replay report after an export to a hex log and an import.
#[test]
fn a_run_replays_the_same_through_a_hex_log() {
    let folder = Folder::new("replay");
    let run = ["run", "data-exchange", "--dut", "model:datalogic-amt58-profibus/hs5818", "--record", "captures"];
    encspec(&folder, &run);
    let replayed = |file: &str| {
        let (_, out, err) = encspec(&folder, &["replay", file, "--report", "json=-"]);
        assert_eq!(err, "");
        let mut report: serde_json::Value = serde_json::from_str(&out).expect("JSON");
        report["captures"][0]["file"] = serde_json::Value::Null;
        report
    };
    let (mut compared, mut frames) = (0, 0);
    for entry in fs::read_dir(folder.join("captures")).expect("captures").take(3) {
        let capture = entry.expect("an entry").path();
        let found = packets(&fs::read(&capture).expect("the capture"));
        let mut log = String::new();
        for packet in &found {
            let (seconds, nanos) = (packet.nanos / 1_000_000_000, packet.nanos % 1_000_000_000);
            writeln!(log, "{seconds}.{nanos:09} {}", hex(&packet.octets)).expect("a string");
        }
        let (name, again) = (format!("{compared}.log"), format!("{compared}.pcapng"));
        fs::write(folder.join(&name), log).expect("the log");
        let (status, out, err) = encspec(&folder, &["record", &again, "--from-hex", &name]);
        assert_eq!(status, Some(0), "{err}");
        assert!(out.starts_with(&format!("{again}: {} frames in", found.len())), "{out}");
        let original = replayed(&capture.display().to_string());
        assert_eq!(original["captures"][0]["frames"].as_u64(), Some(found.len() as u64), "{original:#}");
        assert_eq!(replayed(&again), original);
        (compared, frames) = (compared + 1, frames + found.len());
    }
    assert!(frames > 100, "only {frames} frames were compared");
}
