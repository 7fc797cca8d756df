//! The hostile devices: name, sentence, and what happens to which of their frames.

use super::FrameSpoiling::{self, *};
use super::SpoiltFrames;

/// A kind of hostile device.
#[derive(Debug, PartialEq, Eq, Hash)]
pub struct HostileDevice {
    /// Its name in `--dut null:NAME`.
    pub name: &'static str,
    /// What it does.
    pub sentence: &'static str,
    pub is_of_profibus: bool,
    pub frames: SpoiltFrames,
    pub does: FrameSpoiling,
    /// Whether checksums are made right again.
    pub is_sealed: bool,
}

/// A row of PROFINET; checksums are right.
const fn io(name: &'static str, sentence: &'static str, frames: SpoiltFrames, does: FrameSpoiling) -> HostileDevice {
    HostileDevice { name, sentence, is_of_profibus: false, frames, does, is_sealed: true }
}

/// A row of PROFIBUS; checksums are right.
const fn dp(name: &'static str, sentence: &'static str, frames: SpoiltFrames, does: FrameSpoiling) -> HostileDevice {
    HostileDevice { name, sentence, is_of_profibus: true, frames, does, is_sealed: true }
}

const fn unsealed(device: HostileDevice) -> HostileDevice {
    HostileDevice { is_sealed: false, ..device }
}

use SpoiltFrames::{Alarms, All, Arp, Cyclic, Dcp, Diagnosis, Rpc, Telegrams};

/// All hostile devices. Places: DCPDataLength 10, first block 12; UDP 20, RPC 28, its body 108, first block 128; the status of a cyclic
/// frame are its last four bytes; VarPartLen of an alarm 12.
pub static HOSTILE_DEVICES: [HostileDevice; 53] = [
    io("dcp-late", "DCP answers come after three seconds", Dcp, Late(3_000_000)),
    io("rpc-late", "answers to calls come after eight seconds", Rpc, Late(8_000_000)),
    io("dcp-again", "each DCP answer is sent ten times", Dcp, Again(9)),
    io("rpc-flood", "each answer to a call is followed by a hundred copies to all stations", Rpc, Flood(100)),
    io("dcp-flood", "each DCP answer is followed by a thousand copies to all stations", Dcp, Flood(1000)),
    io("arp-flood", "each ARP frame is followed by two thousand copies to all stations", Arp, Flood(2000)),
    io("cyclic-again", "each cyclic frame is sent four times", Cyclic, Again(3)),
    io("cyclic-swapped", "cyclic frames overtake each other", Cyclic, Swapped),
    io("cyclic-lost", "of ten cyclic frames nine are lost", Cyclic, Lost(10)),
    io("counter-stands", "the cycle counter stands still", Cyclic, Put(-4, &[0x12, 0x34])),
    io("counter-random", "the cycle counter is random", Cyclic, Random(-4, 2)),
    io("status-random", "the data status is random", Cyclic, Random(-2, 1)),
    io("transfer-status", "the transfer status says that the frame is wrong", Cyclic, Put(-1, &[0x01])),
    io("status-stop", "the data status says STOP and invalid", Cyclic, Put(-2, &[0x00])),
    io("cyclic-cut", "cyclic frames end behind their FrameID", Cyclic, Cut(20)),
    io("cyclic-zeros", "cyclic frames have only zeros", Cyclic, Filled(0)),
    io("cyclic-ones", "cyclic frames have only ones", Cyclic, Filled(0xFF)),
    io("cyclic-frame-id", "cyclic frames have the FrameID of another connection", Cyclic, Put(0, &[0xBF, 0x00])),
    io("cyclic-bits", "one bit of each cyclic frame is wrong", Cyclic, Flipped),
    io("dcp-length", "DCP says that 65535 bytes follow", Dcp, Put(10, &[0xFF, 0xFF])),
    io("dcp-no-length", "DCP says that nothing follows", Dcp, Put(10, &[0, 0])),
    io("dcp-block-length", "the first DCP block is longer than the frame", Dcp, Put(14, &[0x7F, 0xFF])),
    io("dcp-block-empty", "the first DCP block has no bytes", Dcp, Put(14, &[0, 0])),
    io("dcp-transaction", "DCP answers name another transaction", Dcp, Put(4, &[0xDE, 0xAD, 0xBE, 0xEF])),
    io("dcp-bits", "one bit of each DCP frame is wrong", Dcp, Flipped),
    io("dcp-cut", "DCP answers end in their header", Dcp, Cut(20)),
    io(
        "name-escapes",
        "its name has escape sequences and markup",
        Dcp,
        Named(b"\x1b[2J\x1b[31m<script>alert(1)</script>\"'&\r\n"),
    ),
    io("name-long", "its name has 250 characters", Dcp, Named(&[b'a'; 250])),
    io("name-not-text", "its name is no text", Dcp, Named(&[0xFF, 0xFE, 0x00, 0xC3, 0x28])),
    io("other-device", "it says that it is another device of another vendor", Dcp, Named(b"another-device")),
    io("sender-changes", "each frame comes from another address", All, OtherSender),
    io("sender-is-group", "its frames come from the address of a group", All, GroupSender),
    io("rpc-length", "the body of a call is longer than the datagram", Rpc, Put(102, &[0xFF, 0xFF])),
    io("rpc-counts", "the counts of an answer are huge", Rpc, Put(112, &[0xFF; 12])),
    io("rpc-block-length", "the first block is longer than the answer", Rpc, Put(130, &[0xFF, 0xF0])),
    io("rpc-block-empty", "the first block has no bytes", Rpc, Put(130, &[0, 0])),
    io("rpc-block-type", "the first block is of another kind", Rpc, Put(128, &[0x42, 0x42])),
    io("rpc-fragments", "each answer is a fragment, and the last never comes", Rpc, Put(30, &[0x04])),
    io("rpc-activity", "answers belong to no call", Rpc, Random(68, 16)),
    io("rpc-byte-order", "answers say another byte order than they have", Rpc, Put(32, &[0x77])),
    io("rpc-kind", "answers are of a kind that does not exist", Rpc, Put(29, &[0x3F])),
    io("rpc-cut", "answers end in the header of RPC", Rpc, Cut(70)),
    io("rpc-bits", "one bit of each answer is wrong", Rpc, Flipped),
    io("ip-length", "IP says that the datagram is longer than the frame", Rpc, Put(2, &[0xFF, 0xFF])),
    io("alarm-length", "the content of an alarm is longer than the frame", Alarms, Put(12, &[0xFF, 0xFF])),
    io("alarm-numbers", "the sequence numbers of alarms are random", Alarms, Random(8, 4)),
    dp("dp-late", "telegrams come 20 ms after the request", All, Late(20_000)),
    unsealed(dp("dp-checksum", "the checksum of telegrams is wrong", Telegrams, Put(-2, &[0x5A]))),
    dp("dp-lengths", "the two lengths of a telegram differ", Telegrams, Put(1, &[0xF0])),
    dp("dp-cut", "telegrams end in their header", Telegrams, Cut(6)),
    dp("dp-sender", "telegrams come from another address", Telegrams, Put(5, &[0x55])),
    dp("dp-function", "telegrams have the function code of a request", Telegrams, Put(6, &[0x6D])),
    dp("dp-diagnosis", "the diagnosis is of a slave with an error in its parameters", Diagnosis, Random(9, 6)),
];
