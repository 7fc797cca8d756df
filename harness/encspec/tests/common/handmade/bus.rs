//! Hand-made PROFIBUS frames of a master and a slave.

use station::{Duration, Time};
use virtual_wire::PcapngWriter;
use virtual_wire::capture::LinkType;
use wire::profibus::fdl::{
    AnswerFunction, DataFrame, Extension, FdlFrame, FrameCount, FunctionCode, RequestFunction, StationType,
};

pub const MASTER: u8 = 2;
pub const SLAVE: u8 = 5;
/// The first seven bytes of Set_Prm as in the AMT58 manual, with another watchdog: ident 0x1655, watchdog 100 ms, locked.
pub const SET_PRM: [u8; 7] = [0x88, 0x0A, 0x01, 0x0B, 0x16, 0x55, 0x00];
pub const UNLOCK: [u8; 7] = [0x40, 0x00, 0x00, 0x0B, 0x16, 0x55, 0x00];
/// Two words of outputs and two of inputs.
pub const CHK_CFG: [u8; 2] = [0xE1, 0xD1];
pub const NEW: [u8; 6] = [0x02, 0x05, 0x00, 0xFF, 0x16, 0x55];
pub const GOOD: [u8; 6] = [0x00, 0x0C, 0x00, MASTER, 0x16, 0x55];
pub const WRONG: [u8; 6] = [0x42, 0x05, 0x00, 0xFF, 0x16, 0x55];

/// Frames in sequence, 1 ms apart.
#[derive(Default)]
pub struct BusFrames {
    pub frames: Vec<(Time, Vec<u8>)>,
    pub count: Option<FrameCount>,
    pub pause: Duration,
}

impl BusFrames {
    pub fn send(&mut self, frame: &FdlFrame<'_>) {
        let last = self.frames.last().map_or(Time::ZERO, |(time, _)| *time);
        let mut octets = Vec::new();
        frame.write(&mut octets);
        let pause = std::mem::take(&mut self.pause);
        self.frames.push((last + Duration::from_millis(1) + pause, octets));
    }

    pub fn ask(&mut self, sap: Option<u8>, data: &[u8]) {
        let count = self.count.map_or(FrameCount::First, FrameCount::next);
        self.count = Some(count);
        self.ask_with(count, sap, data);
    }

    pub fn ask_with(&mut self, count: FrameCount, sap: Option<u8>, data: &[u8]) {
        let extension = |number: Option<u8>| number.map_or(Extension::NONE, Extension::sap);
        let fc = FunctionCode::request(RequestFunction::SRD_HIGH, count);
        let ends = ((SLAVE, extension(sap)), (MASTER, extension(sap.map(|_| 62))));
        self.send(&FdlFrame::Data(DataFrame::new(ends.0, ends.1, fc, data)));
    }

    /// A request from another access point of the master than the one of cyclic services.
    pub fn ask_from(&mut self, sap: Option<u8>, from: u8, data: &[u8]) {
        let count = self.count.map_or(FrameCount::First, FrameCount::next);
        self.count = Some(count);
        let slave = sap.map_or(Extension::NONE, Extension::sap);
        let fc = FunctionCode::request(RequestFunction::SRD_HIGH, count);
        self.send(&FdlFrame::Data(DataFrame::new((SLAVE, slave), (MASTER, Extension::sap(from)), fc, data)));
    }

    /// An answer to another access point of the master.
    pub fn answer_to(&mut self, sap: Option<u8>, to: u8, data: &[u8]) {
        let slave = sap.map_or(Extension::NONE, Extension::sap);
        let fc = FunctionCode::answer(AnswerFunction::DATA_LOW, StationType::SLAVE);
        self.send(&FdlFrame::Data(DataFrame::new((MASTER, Extension::sap(to)), (SLAVE, slave), fc, data)));
    }

    /// A request from another master.
    pub fn ask_of(&mut self, master: u8, sap: Option<u8>, data: &[u8]) {
        let extension = |number: Option<u8>| number.map_or(Extension::NONE, Extension::sap);
        let fc = FunctionCode::request(RequestFunction::SRD_HIGH, FrameCount::First);
        let ends = ((SLAVE, extension(sap)), (master, extension(sap.map(|_| 62))));
        self.send(&FdlFrame::Data(DataFrame::new(ends.0, ends.1, fc, data)));
    }

    pub fn answer(&mut self, function: AnswerFunction, sap: Option<u8>, data: &[u8]) {
        let extension = |number: Option<u8>| number.map_or(Extension::NONE, Extension::sap);
        let fc = FunctionCode::answer(function, StationType::SLAVE);
        let ends = ((MASTER, extension(sap.map(|_| 62))), (SLAVE, extension(sap)));
        self.send(&FdlFrame::Data(DataFrame::new(ends.0, ends.1, fc, data)));
    }

    pub fn diagnosis(&mut self, octets: &[u8]) {
        self.ask(Some(60), &[]);
        self.answer(AnswerFunction::DATA_LOW, Some(60), octets);
    }

    pub fn acknowledged(&mut self, sap: u8, data: &[u8]) {
        self.ask(Some(sap), data);
        self.send(&FdlFrame::ShortAcknowledgement);
    }

    pub fn start(&mut self) {
        self.diagnosis(&NEW);
        self.acknowledged(61, &SET_PRM);
        self.acknowledged(62, &CHK_CFG);
        self.diagnosis(&GOOD);
    }

    pub fn exchange(&mut self, times: u8) {
        for number in 0..times {
            self.ask(None, &[0, 0, 0, number]);
            self.answer(AnswerFunction::DATA_LOW, None, &[1, 2, 3, number]);
        }
    }

    pub fn token(&mut self) {
        self.send(&FdlFrame::Token { da: MASTER, sa: MASTER });
    }

    /// The frames as a capture file.
    pub fn capture(&self) -> Vec<u8> {
        let mut writer = PcapngWriter::new(Vec::new(), "made by a test").expect("a vector takes all");
        let interface = writer.interface("bus", LinkType::PROFIBUS).expect("a vector takes all");
        for (time, octets) in &self.frames {
            writer.packet(interface, *time, octets, None).expect("a vector takes all");
        }
        writer.finish().expect("a vector takes all")
    }
}
