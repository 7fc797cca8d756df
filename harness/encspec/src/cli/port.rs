//! The options `--nic` and `--socket`: where the devices are.

use super::CommandError;
use clap::Args;
use link::{BadAddress, FrameSocket, LinkError, Nic, Port, SocketAddress, Wire, interrupt, privileges};
use live::discover::{Survey, discover, own_mac};
use results::bench_file::LinkSpec;
use std::time::Duration;

/// A network interface or a socket.
#[derive(Clone, Debug, Args)]
#[group(required = true, multiple = false)]
pub struct PortArgs {
    /// Network interface
    #[arg(long, value_name = "IF")]
    pub nic: Option<String>,
    /// Socket with Ethernet frames as in QEMU's `-netdev stream`: HOST:PORT, /PATH, listen:HOST:PORT or listen:/PATH
    #[arg(long, value_name = "ADDRESS")]
    pub socket: Option<String>,
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

    /// Opens the port and discovers the stations. Returns the survey and a description of the port.
    pub fn survey(&self, wait: Duration) -> Result<(Survey, String), CommandError> {
        interrupt::watch();
        let port = self.open()?;
        let unusable = |error: LinkError| CommandError::bench(error.to_string());
        privileges::drop().map_err(unusable)?;
        let (own, place) = (own_mac(port.mac()), port.describe());
        let mut wire = Wire::new(port);
        let survey = discover(&mut wire, own, wait, &mut interrupt::requested).map_err(unusable)?;
        Ok((survey, place))
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
            LinkSpec::Serial(path) => Err(CommandError::usage(format!(
                "the serial line {path} carries no Ethernet frames; use an interface or a socket"
            ))),
        }
    }
}
