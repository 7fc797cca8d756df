//! Files and streams: descriptions of devices, suites, bench files, logs, the application protocol and frames of QEMU.

use crate::{MANUALS, PROFIBUS, PROFINET, SUITES, trials};
use application_protocol::ApplicationAnswer;
use description::{gsd as gsd_file, gsdml as gsdml_file};
use link::StreamFrames;
use results::bench_file as bench;
use std::path::PathBuf;
use std::sync::LazyLock;
use suite_yaml::Checker;
use virtual_wire::record::import;

/// The answers of a program that is an application without a network.
pub fn application(data: &[u8]) {
    let Ok(answer) = serde_json::from_slice::<ApplicationAnswer>(data) else { return };
    let text = serde_json::to_string(&answer).expect("an answer is JSON");
    let again: ApplicationAnswer = serde_json::from_str(&text).expect("what was written is read");
    assert_eq!(again, answer);
}

static BENCH_FILE: LazyLock<PathBuf> =
    LazyLock::new(|| std::env::temp_dir().join(format!("encspec-fuzz-{}.yaml", std::process::id())));

/// Bench files.
pub fn bench_file(data: &[u8]) {
    std::fs::write(&*BENCH_FILE, data).expect("a folder for temporary files");
    match bench::read(&BENCH_FILE, &MANUALS) {
        Ok(bench) => drop(std::hint::black_box(bench)),
        Err(errors) => assert!(!errors.to_string().is_empty()),
    }
}

/// GSD files: reading, showing, and what they say of a device of a manual, of any slave and of any encoder.
pub fn gsd(data: &[u8]) {
    let Ok(description) = gsd_file::read_octets(data) else { return };
    std::hint::black_box(gsd_file::show(&description));
    let device = &trials(PROFIBUS).0.device;
    std::hint::black_box(gsd_file::compare(device, 0, &description));
    let _ = std::hint::black_box(gsd_file::describe(&description, None));
    std::hint::black_box(gsd_file::overlay(&mut device.as_ref().clone(), Some(&description), &[]));
}

/// GSDML files, in any encoding: reading, showing, and what they say of a device of a manual.
pub fn gsdml(data: &[u8]) {
    let Ok(description) = gsdml_file::read_octets(data) else { return };
    std::hint::black_box(gsdml_file::show(&description));
    let device = &trials(PROFINET).0.device;
    std::hint::black_box(gsdml_file::compare(device, 0, Some(&description), None));
}

/// Logs of bytes in hexadecimal, as adapters for PROFIBUS write them.
pub fn hex_log(data: &[u8]) {
    let _ = std::hint::black_box(import(data, Vec::new(), "fuzz", None));
}

/// The frames up to the end or to an invalid length, when the bytes of a stream arrive in pieces.
fn stream_frames(octets: &[u8], piece: usize) -> (Vec<Vec<u8>>, bool) {
    let (mut stream, mut frames, mut frame) = (StreamFrames::default(), Vec::new(), Vec::new());
    for piece in octets.chunks(piece) {
        stream.push(piece);
        loop {
            match stream.next(&mut frame) {
                Ok(true) => frames.push(frame.clone()),
                Ok(false) => break,
                Err(_) => return (frames, true),
            }
        }
    }
    (frames, false)
}

/// The frames in a stream of QEMU, which arrive in pieces of any size: the first byte says how large.
pub fn qemu(data: &[u8]) {
    let Some((piece, octets)) = data.split_first() else { return };
    let pieces = stream_frames(octets, usize::from(*piece).max(1));
    assert_eq!(pieces, stream_frames(octets, octets.len().max(1)));
}

/// The files of a suite; the first byte says which.
const SUITE_FILES: [&str; 8] = ["device", "requirements", "bugs", "rules", "preset", "procedures", "masks", "parking"];

static CHECKER: LazyLock<Checker> =
    LazyLock::new(|| Checker::unchecked(&SUITES, PROFINET).unwrap_or_else(|errors| panic!("{errors}")));

/// The files of a suite.
pub fn suite(data: &[u8]) {
    let Some((which, text)) = data.split_first() else { return };
    let text = String::from_utf8_lossy(text);
    let file = SUITE_FILES[usize::from(*which) % SUITE_FILES.len()];
    if let Err(errors) = CHECKER.check(&format!("{PROFINET}/{file}.yaml"), &text) {
        assert!(!errors.to_string().is_empty());
    }
}
