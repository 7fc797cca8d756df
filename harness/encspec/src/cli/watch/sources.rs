//! Where the frames of a watch come from. None of the sources can send.

use super::{CommandError, now};
use link::{Clock, LinkError, NicTap, Serial, SerialSettings, pause, privileges, transmitted};
use plain_text::printable;
use station::{Duration, Time};
use std::io;
use std::net::IpAddr;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use virtual_wire::CaptureReader;
use virtual_wire::capture::{CaptureItem, LinkType, NotACapture};
use virtual_wire::record::Joiner;
use watch::LiveWatch;
use wire::profibus::fdl::{BaudRate, BitTimes};

/// How long a source waits for frames before the watch goes on.
const WAIT: Duration = Duration::from_millis(20);
/// So long frames may gather in the kernel, which costs less than taking each one when it comes.
const GATHER: Duration = Duration::from_millis(4);
/// How often an interface or line that is gone is tried again.
const TRY_AGAIN: Duration = Duration::from_millis(500);
/// Packets of standard input that wait to be judged.
const MOST_WAITING: usize = 4_096;
/// Packets of standard input that are judged before signals and outputs are looked after.
const AT_ONCE: usize = 1_024;

/// What came of a look at the source.
#[derive(Debug, Default)]
pub(super) struct Received {
    /// Whether more frames may come.
    pub is_open: bool,
    /// Whether no frame is left for now.
    pub is_drained: bool,
    /// Something to be reported.
    pub note: Option<String>,
}

/// The source of the frames.
pub(super) enum Source {
    Nic(NicSource),
    Serial(Box<SerialSource>),
    Input(Receiver<InputItem>),
}

pub(super) struct NicSource {
    tap: NicTap,
    name: String,
    clock: Clock,
    /// The frames transmitted when the watch began.
    transmitted: Option<u64>,
    is_gone: bool,
}

pub(super) struct SerialSource {
    line: Serial,
    joiner: Joiner,
    /// The bit rate; a pseudoterminal has none.
    rate: Option<BaudRate>,
    clock: Clock,
    /// The time of the host when the clock began.
    begun: Time,
    octets: Vec<u8>,
    last: Time,
    is_gone: bool,
}

pub(super) enum InputItem {
    Packet { time: Time, link: LinkType, octets: Vec<u8>, original: u32 },
    Damage(String),
    NoCapture(NotACapture),
}

fn unusable(error: &LinkError) -> CommandError {
    CommandError::bench(error.to_string())
}

impl Source {
    pub fn open(nic: Option<&str>, serial: Option<&Path>, baud: Option<BaudRate>) -> Result<Source, CommandError> {
        let source = match (nic, serial) {
            (None, None) => None,
            (Some(name), _) => {
                let tap = NicTap::open(name).map_err(|error| unusable(&error))?;
                let transmitted = transmitted::transmitted_frames(name);
                let (name, clock) = (name.to_owned(), Clock::start());
                Some(Source::Nic(NicSource { tap, name, clock, transmitted, is_gone: false }))
            }
            (_, Some(path)) => {
                let rate = baud.unwrap_or(BaudRate(0));
                let line = Serial::listen(path, &SerialSettings::new(rate.0)).map_err(|error| unusable(&error))?;
                let rate = (!line.is_pty()).then_some(rate);
                Some(Source::Serial(Box::new(SerialSource {
                    line,
                    joiner: Joiner::new(rate),
                    rate,
                    clock: Clock::start(),
                    begun: now(),
                    octets: Vec::new(),
                    last: Time::ZERO,
                    is_gone: false,
                })))
            }
        };
        // Files belong to the user, and nothing after this needs a privilege. Threads would keep theirs.
        privileges::drop().map_err(|error| unusable(&error))?;
        Ok(source.unwrap_or_else(|| Source::Input(read_input())))
    }

    pub fn describe(&self) -> String {
        match self {
            Source::Nic(of) => of.tap.describe(),
            Source::Serial(of) => of.line.describe(),
            Source::Input(_) => "standard input".to_owned(),
        }
    }

    pub fn name(&self) -> String {
        match self {
            Source::Nic(of) => of.name.clone(),
            Source::Serial(of) => of.line.describe(),
            Source::Input(_) => "-".to_owned(),
        }
    }

    pub fn link(&self) -> LinkType {
        match self {
            Source::Serial(_) => LinkType::PROFIBUS,
            Source::Nic(_) | Source::Input(_) => LinkType::ETHERNET,
        }
    }

    /// What the times of the frames are worth.
    pub fn time_stamps(&self) -> &'static str {
        match self {
            Source::Nic(_) => {
                "by the kernel when the driver passes a frame on: interrupt coalescing (ethtool -c) and load make frames late and \
                 bundle them, which looks like jitter"
            }
            Source::Serial(_) => {
                "when the driver passes bytes on, less their time at the bit rate: a USB adapter bundles bytes for up to its latency \
                 timer (1 to 16 ms)"
            }
            Source::Input(_) => "those of the capture",
        }
    }

    /// Why this host may send at the interface after all.
    pub fn warnings(&self, metrics: Option<IpAddr>) -> Vec<String> {
        let Source::Nic(of) = self else { return Vec::new() };
        let mut warnings = transmitted::why_it_may_transmit(&of.name);
        if let Some(metrics) = metrics.filter(|metrics| transmitted::addresses(&of.name).contains(metrics)) {
            warnings.push(format!("--metrics {metrics} is an address of {}, at which answers would be sent", of.name));
        }
        warnings
    }

    /// Frames that the interface has transmitted since the watch began.
    pub fn transmitted(&self) -> Option<u64> {
        let Source::Nic(of) = self else { return None };
        Some(transmitted::transmitted_frames(&of.name)?.saturating_sub(of.transmitted?))
    }

    /// The present time of the source; `last` is the time of its last frame.
    pub fn now(&self, last: Time) -> Time {
        match self {
            Source::Nic(_) => now(),
            Source::Serial(of) => of.now(),
            Source::Input(_) => last,
        }
    }

    /// Passes the frames that have arrived to the watch; waits for some a moment.
    pub fn receive(&mut self, watch: &mut LiveWatch<'_>) -> Result<Received, CommandError> {
        match self {
            Source::Nic(of) => Ok(of.receive(watch)),
            Source::Serial(of) => Ok(of.receive(watch)),
            Source::Input(input) => receive_input(input, watch),
        }
    }
}

impl NicSource {
    fn receive(&mut self, watch: &mut LiveWatch<'_>) -> Received {
        let until = self.clock.now() + WAIT;
        if self.is_gone {
            pause(&self.clock, self.clock.now() + TRY_AGAIN);
            if self.tap.recover().is_err() {
                return Received { is_open: true, is_drained: true, note: None };
            }
            self.is_gone = false;
            watch.interrupt();
            let note = Some(format!("{} is back", self.tap.describe()));
            return Received { is_open: true, is_drained: true, note };
        }
        let taken = self.tap.receive(&self.clock, until, &mut |frame| {
            if frame.lost_before > 0 {
                watch.lost(frame.lost_before);
            }
            let time = frame.time.map_or_else(now, |time| Time::ZERO + time);
            watch.frame(time, LinkType::ETHERNET, frame.octets, frame.original as u32);
        });
        match taken {
            Ok(count) => {
                let is_drained = count < NicTap::MOST_AT_ONCE;
                if count > 0 && is_drained {
                    pause(&self.clock, self.clock.now() + GATHER);
                }
                Received { is_open: true, is_drained, note: None }
            }
            Err(error) => {
                self.is_gone = true;
                Received { is_open: true, is_drained: true, note: Some(error.to_string()) }
            }
        }
    }
}

impl SerialSource {
    fn now(&self) -> Time {
        self.begun + self.clock.now().since(Time::ZERO)
    }

    fn receive(&mut self, watch: &mut LiveWatch<'_>) -> Received {
        let mut received = Received { is_open: true, is_drained: true, note: None };
        if self.is_gone {
            if self.line.recover(&self.clock, self.clock.now() + TRY_AGAIN).is_ok() {
                self.is_gone = false;
                watch.interrupt();
                received.note = Some(format!("{} is back", self.line.describe()));
            }
            return received;
        }
        self.octets.clear();
        let taken = self.line.receive(&mut self.octets);
        let time = self.now();
        let mut pass_on = |joined: virtual_wire::record::Joined| {
            watch.frame(joined.begin, LinkType::PROFIBUS, &joined.octets, joined.octets.len() as u32);
        };
        let failure = match taken {
            Ok(true) => {
                let lasts = self.rate.map_or(0, |rate| rate.nanoseconds(BitTimes::of_octets(self.octets.len())));
                // The bytes were sent one after the other before they were received.
                let begin = Time::from_nanos(time.as_nanos().saturating_sub(lasts)).max(self.last);
                self.joiner.push(begin, &self.octets, &mut pass_on);
                self.last = time;
                None
            }
            Ok(false) if self.joiner.silent_at().is_some_and(|silent| time >= silent) => {
                self.joiner.silence(&mut pass_on);
                None
            }
            Ok(false) => self.line.wait(&self.clock, self.clock.now() + WAIT).err(),
            Err(error) => Some(error),
        };
        if let Some(error) = failure {
            self.is_gone = true;
            received.note = Some(error.to_string());
        }
        received
    }
}

/// Reads standard input on a thread of its own, so that a signal is noticed while nothing comes.
fn read_input() -> Receiver<InputItem> {
    let (sender, receiver) = sync_channel(MOST_WAITING);
    let read = move || {
        let mut reader = match CaptureReader::new(io::stdin().lock()) {
            Ok(reader) => reader,
            Err(why) => return drop(sender.send(InputItem::NoCapture(why))),
        };
        while let Some(item) = reader.next() {
            let item = match item {
                CaptureItem::Packet(packet) => InputItem::Packet {
                    time: packet.time,
                    link: packet.link_type,
                    octets: packet.captured.to_vec(),
                    original: packet.original_length,
                },
                CaptureItem::Damage(damage) => InputItem::Damage(format!(
                    "standard input is damaged at byte {}: {}",
                    damage.at,
                    printable(&damage.what)
                )),
            };
            // The watch has ended.
            if sender.send(item).is_err() {
                return;
            }
        }
    };
    thread::spawn(read);
    receiver
}

fn receive_input(input: &Receiver<InputItem>, watch: &mut LiveWatch<'_>) -> Result<Received, CommandError> {
    let mut received = Received { is_open: true, is_drained: false, note: None };
    for _ in 0..AT_ONCE {
        match input.recv_timeout(WAIT) {
            Ok(InputItem::Packet { time, link, octets, original }) => {
                watch.frame(time, link, &octets, original);
                if watch.is_due(time) {
                    break;
                }
            }
            Ok(InputItem::Damage(note)) => {
                watch.interrupt();
                received.note = Some(note);
                break;
            }
            Ok(InputItem::NoCapture(why)) => {
                return Err(CommandError::usage(format!("standard input is no capture: {why}")));
            }
            Err(RecvTimeoutError::Timeout) => {
                received.is_drained = true;
                break;
            }
            Err(RecvTimeoutError::Disconnected) => {
                received.is_open = false;
                break;
            }
        }
    }
    Ok(received)
}
