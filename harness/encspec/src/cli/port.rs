//! The options `--nic`, `--socket` and `--serial`: where the devices are.

use super::CommandError;
use clap::{Args, ValueEnum};
use link::{BadAddress, FrameSocket, LinkError, Nic, Port, SocketAddress, Wire, interrupt, privileges};
use live::discover::{Survey, discover, own_mac};
use results::bench_file::{Driver, LineSpec, LinkSpec};
use std::time::Duration;
use wire::profibus::fdl::BaudRate;

/// A network interface or a socket.
#[derive(Clone, Debug)]
pub struct PortArgs {
    /// Network interface.
    pub nic: Option<String>,
    /// Socket with Ethernet frames.
    pub socket: Option<String>,
}

/// A network interface, a socket or a serial line.
#[derive(Clone, Debug, Args)]
#[group(required = true, multiple = false)]
pub struct SegmentArgs {
    /// Network interface
    #[arg(long, value_name = "IF")]
    nic: Option<String>,
    /// Socket with Ethernet frames as in QEMU's `-netdev stream`: HOST:PORT, /PATH, listen:HOST:PORT or listen:/PATH
    #[arg(long, value_name = "ADDRESS")]
    socket: Option<String>,
    /// Serial line with a PROFIBUS; it listens first, and sends nothing if another station sends
    #[arg(long, value_name = "TTY")]
    serial: Option<String>,
}

/// A segment of either bus.
pub enum DiscoverySegment {
    /// Ethernet frames.
    Port(PortArgs),
    /// A PROFIBUS at the serial line with this path.
    Line(String),
}

impl SegmentArgs {
    /// The segment that is meant.
    pub fn segment(&self) -> DiscoverySegment {
        match &self.serial {
            Some(path) => DiscoverySegment::Line(path.clone()),
            None => DiscoverySegment::Port(PortArgs { nic: self.nic.clone(), socket: self.socket.clone() }),
        }
    }
}

/// What switches the driver of an adapter.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum DriverWord {
    /// The adapter by itself
    Adapter,
    /// The serial port, controlled by the kernel
    Port,
}

/// Settings of a serial line with a PROFIBUS.
#[derive(Clone, Debug, Args)]
pub struct LineArgs {
    /// PROFIBUS: the rate of the bus in bit/s; a pseudoterminal needs none
    #[arg(long, value_name = "RATE", value_parser = baud, requires = "serial")]
    baud: Option<BaudRate>,
    /// PROFIBUS: what switches the driver of the RS-485 adapter; a pseudoterminal needs none
    #[arg(long, value_enum, requires = "serial")]
    driver: Option<DriverWord>,
    /// PROFIBUS: the adapter echoes what is sent
    #[arg(long, requires = "serial")]
    echo: bool,
    /// PROFIBUS: ask the stations even if another station sends; no station on the bus can be disturbed
    #[arg(long, requires = "serial")]
    pub alone: bool,
}

impl LineArgs {
    /// What switches the driver, in the word of a bench file.
    pub fn driver_word(&self) -> Option<&'static str> {
        self.driver.map(|driver| match driver {
            DriverWord::Adapter => "adapter",
            DriverWord::Port => "port",
        })
    }

    /// The settings as a bench file has them.
    pub fn spec(&self) -> LineSpec {
        let driver = self.driver.map(|driver| match driver {
            DriverWord::Adapter => Driver::Adapter,
            DriverWord::Port => Driver::Port,
        });
        LineSpec { baud: self.baud, driver, echo: self.echo, ..LineSpec::default() }
    }
}

/// A standard bit rate of PROFIBUS.
pub fn baud(text: &str) -> Result<BaudRate, String> {
    let known = || BaudRate::STANDARD.iter().map(|rate| rate.0.to_string()).collect::<Vec<_>>().join(", ");
    let rate = text.parse().ok().map(BaudRate).filter(|rate| BaudRate::STANDARD.contains(rate));
    rate.ok_or_else(|| format!("not a PROFIBUS bit rate; use one of {}", known()))
}

impl PortArgs {
    /// The link as a bench file names it.
    pub fn spec(&self) -> LinkSpec {
        match (&self.nic, &self.socket) {
            (Some(name), _) => LinkSpec::Nic(name.clone()),
            (None, address) => LinkSpec::Socket(address.clone().unwrap_or_default()),
        }
    }

    /// Opens the port. With `listen:` it waits up to 30 s for the peer to connect.
    pub fn open(&self) -> Result<Box<dyn Port>, CommandError> {
        self.with(FrameSocket::open)
    }

    /// Opens the port. With `listen:` it does not wait for the peer.
    pub fn wait(&self) -> Result<Box<dyn Port>, CommandError> {
        self.with(FrameSocket::bind)
    }

    /// Opens the port and discovers the stations. Returns the survey and the open port.
    pub fn survey(&self, wait: Duration) -> Result<(Survey, Box<dyn Port>), CommandError> {
        interrupt::watch();
        let port = self.open()?;
        let unusable = |error: LinkError| CommandError::bench(error.to_string());
        privileges::drop().map_err(unusable)?;
        let own = own_mac(port.mac());
        let mut wire = Wire::new(port);
        let survey = discover(&mut wire, own, wait, &mut interrupt::requested).map_err(unusable)?;
        Ok((survey, wire.into_port()))
    }

    fn with(&self, open: fn(&SocketAddress) -> Result<FrameSocket, LinkError>) -> Result<Box<dyn Port>, CommandError> {
        let unusable = |error: LinkError| CommandError::bench(error.to_string());
        match self.spec() {
            LinkSpec::Nic(name) => Ok(Box::new(Nic::open(&name).map_err(unusable)?)),
            LinkSpec::Socket(address) => {
                let address: SocketAddress =
                    address.parse().map_err(|error: BadAddress| CommandError::usage(error.to_string()))?;
                Ok(Box::new(open(&address).map_err(unusable)?))
            }
            LinkSpec::App(_) => Err(CommandError::usage("a program has no wire that could be opened")),
            LinkSpec::Serial(path) => Err(CommandError::usage(format!(
                "the serial line {path} carries no Ethernet frames; use an interface or a socket"
            ))),
        }
    }
}
