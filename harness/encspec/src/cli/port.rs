//! Where a device is, as the command line says it: `--nic` or `--socket`.

use super::Stop;
use clap::Args;
use link::{BadAddress, FrameSocket, LinkError, Nic, Port, SocketAddress, Wire, interrupt, privileges};
use live::discover::{Survey, discover, own_mac};
use results::bench_file::LinkSpec;
use std::time::Duration;

/// The network interface or the socket that a command works at.
#[derive(Clone, Debug, Args)]
#[group(required = true, multiple = false)]
pub struct PortArgs {
    /// The network interface
    #[arg(long, value_name = "IF")]
    pub nic: Option<String>,
    /// A socket with Ethernet frames as QEMU's `-netdev stream` has them: HOST:PORT, /PATH, listen:HOST:PORT or listen:/PATH
    #[arg(long, value_name = "ADDRESS")]
    pub socket: Option<String>,
}

impl PortArgs {
    /// Where it is, in the words of the bench file.
    pub fn spec(&self) -> LinkSpec {
        match (&self.nic, &self.socket) {
            (Some(name), _) => LinkSpec::Nic(name.clone()),
            (None, address) => LinkSpec::Socket(address.clone().unwrap_or_default()),
        }
    }

    /// Opens it; a peer that has to come here is waited for up to 30 s.
    pub fn open(&self) -> Result<Box<dyn Port>, Stop> {
        self.with(FrameSocket::open)
    }

    /// Opens it, but does not wait for a peer that has to come here.
    pub fn wait(&self) -> Result<Box<dyn Port>, Stop> {
        self.with(FrameSocket::bind)
    }

    /// Opens it and asks who is there; the survey, and what the place is called.
    pub fn survey(&self, wait: Duration) -> Result<(Survey, String), Stop> {
        interrupt::watch();
        let port = self.open()?;
        let unusable = |error: LinkError| Stop::bench(error.to_string());
        privileges::drop().map_err(unusable)?;
        let (own, place) = (own_mac(port.mac()), port.describe());
        let mut wire = Wire::new(port);
        let survey = discover(&mut wire, own, wait, &mut interrupt::requested).map_err(unusable)?;
        Ok((survey, place))
    }

    fn with(&self, open: fn(&SocketAddress) -> Result<FrameSocket, LinkError>) -> Result<Box<dyn Port>, Stop> {
        let unusable = |error: LinkError| Stop::bench(error.to_string());
        match self.spec() {
            LinkSpec::Nic(name) => Ok(Box::new(Nic::open(&name).map_err(unusable)?)),
            LinkSpec::Socket(address) => {
                let address: SocketAddress =
                    address.parse().map_err(|error: BadAddress| Stop::usage(error.to_string()))?;
                Ok(Box::new(open(&address).map_err(unusable)?))
            }
            LinkSpec::Serial(path) => Err(Stop::usage(format!(
                "the serial line {path} carries no Ethernet frames; name an interface or a socket"
            ))),
        }
    }
}
