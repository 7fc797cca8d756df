//! Raw Ethernet on a network interface through `pnet_datalink`, for systems without Linux packet sockets.
//!
//! The arrival time is the time at which this process read the frame; 802.1Q tags are as the system delivers them.

use std::fmt;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, sync_channel};
use std::time::Instant;

use pnet_datalink::{self as datalink, Channel, Config, DataLinkSender};

use crate::interfaces::{escaped, interface_names};
use crate::sys::pause;
use crate::{Clock, LinkError, Port};
use station::{Duration, Time};

/// The number of frames that the queue between the reading thread and [`Port::receive`] holds.
const WAITING: usize = 4096;
/// The read timeout of the reading thread: it outlives the port by at most this.
const LINGERS: Duration = Duration::from_millis(200);
/// How often [`Port::recover`] checks whether the interface is back.
const LOOK_AGAIN: Duration = Duration::from_millis(20);

type ChannelFrame = Result<(Instant, Vec<u8>), io::Error>;

/// A network interface in promiscuous mode: sends frames with any source address and receives frames for any destination.
pub struct PortableNic {
    name: String,
    mac: Option<[u8; 6]>,
    open: Option<OpenChannel>,
}

struct OpenChannel {
    sender: Box<dyn DataLinkSender>,
    arrived: Receiver<ChannelFrame>,
    closed: Arc<AtomicBool>,
}

impl Drop for OpenChannel {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
    }
}

impl fmt::Debug for PortableNic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Nic").field("name", &self.name).finish_non_exhaustive()
    }
}

impl PortableNic {
    /// Opens the interface `name`, which must exist and be up; the process needs the privilege for raw Ethernet.
    pub fn open(name: &str) -> Result<PortableNic, LinkError> {
        let label = escaped(name);
        let interface = datalink::interfaces().into_iter().find(|known| known.name == name);
        let Some(interface) = interface else {
            return Err(LinkError::Unusable(format!("there is no interface {label}: {}", interface_names())));
        };
        if !interface.is_up() {
            let advice = format!("the interface {label} is down: bring it up first");
            return Err(LinkError::Unusable(advice));
        }
        let trouble = |why: &dyn fmt::Display| {
            LinkError::Unusable(format!("the interface {label} cannot be opened: {why}; raw Ethernet needs root"))
        };
        let settings = Config { read_timeout: Some(LINGERS), promiscuous: true, ..Config::default() };
        let (sender, mut receiver) = match datalink::channel(&interface, settings) {
            Ok(Channel::Ethernet(sender, receiver)) => (sender, receiver),
            Ok(_) => return Err(trouble(&"it carries no Ethernet frames")),
            Err(error) => return Err(trouble(&error)),
        };
        let closed = Arc::new(AtomicBool::new(false));
        let (sink, arrived) = sync_channel(WAITING);
        let stop = Arc::clone(&closed);
        let read = move || {
            while !stop.load(Ordering::Relaxed) {
                let taken = match receiver.next() {
                    Ok(frame) => Ok((Instant::now(), frame.to_vec())),
                    Err(error) if idle(&error) => continue,
                    Err(error) => Err(error),
                };
                let last = taken.is_err();
                // When the queue is full the frame is lost, as in a full socket buffer.
                let _ = sink.try_send(taken);
                if last {
                    return;
                }
            }
        };
        std::thread::Builder::new().name(format!("read {label}")).spawn(read).map_err(|error| trouble(&error))?;
        let mac = interface.mac.map(|mac| mac.octets());
        Ok(PortableNic { name: name.to_string(), mac, open: Some(OpenChannel { sender, arrived, closed }) })
    }

    fn gone(&mut self, why: &dyn fmt::Display) -> LinkError {
        self.open = None;
        LinkError::Gone(format!("{} has failed: {why}; bring it up again", self.describe()))
    }
}

fn idle(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

impl Port for PortableNic {
    fn send(&mut self, frame: &[u8]) -> Result<(), LinkError> {
        let Some(open) = &mut self.open else { return Err(self.gone(&"it was lost")) };
        match open.sender.send_to(frame, None) {
            Some(Err(error)) if !idle(&error) => Err(self.gone(&error)),
            _ => Ok(()),
        }
    }

    fn receive(&mut self, clock: &Clock, until: Time, into: &mut Vec<u8>) -> Result<Option<Time>, LinkError> {
        let Some(open) = &mut self.open else { return Err(self.gone(&"it was lost")) };
        let waiting = match open.arrived.try_recv() {
            Err(TryRecvError::Empty) => match open.arrived.recv_timeout(clock.remaining(until)) {
                Err(RecvTimeoutError::Timeout) => return Ok(None),
                Err(RecvTimeoutError::Disconnected) => None,
                Ok(arrived) => Some(arrived),
            },
            Err(TryRecvError::Disconnected) => None,
            Ok(arrived) => Some(arrived),
        };
        match waiting {
            Some(Ok((when, frame))) => {
                into.clear();
                into.extend_from_slice(&frame);
                Ok(Some(clock.at(when)))
            }
            Some(Err(error)) => Err(self.gone(&error)),
            None => Err(self.gone(&"the reading thread has ended")),
        }
    }

    fn recover(&mut self, clock: &Clock, until: Time) -> Result<(), LinkError> {
        loop {
            match PortableNic::open(&self.name) {
                Ok(again) => {
                    *self = again;
                    return Ok(());
                }
                Err(error) if clock.remaining(until).is_zero() => return Err(LinkError::Gone(error.to_string())),
                Err(_) => pause(clock, until.min(clock.now() + LOOK_AGAIN)),
            }
        }
    }

    fn mac(&self) -> Option<[u8; 6]> {
        self.mac
    }

    fn describe(&self) -> String {
        format!("the interface {}", escaped(&self.name))
    }
}
