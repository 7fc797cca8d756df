//! Where a slave of PROFIBUS is in a trial that may give it other addresses, and who it said that it is.

use judge::observe::Address;

/// Where the slave under test is.
#[derive(Clone, Debug)]
pub struct SlaveAt {
    /// The address that the bench gives it.
    pub address: u8,
    /// The ident number that it said.
    pub ident: Option<u16>,
    /// Every address at which it may be after what the trial did.
    met: Vec<u8>,
    /// Those of them that the trial has told it to take by the bus.
    told: Vec<u8>,
}

impl SlaveAt {
    /// A slave at the address of the bench, not asked yet.
    pub fn new(address: u8) -> SlaveAt {
        SlaveAt { address, ident: None, met: vec![address], told: Vec::new() }
    }

    /// Remembers an address at which the trial looks for the slave, or that it gives it.
    pub fn meet(&mut self, address: u8) {
        if address < 127 && !self.met.contains(&address) {
            self.met.push(address);
        }
    }

    /// Remembers an address that the trial tells the slave to take by the bus.
    pub fn tell(&mut self, address: u8) {
        self.meet(address);
        self.told.push(address);
    }

    /// Every address at which it may be.
    pub fn met(&self) -> &[u8] {
        &self.met
    }

    /// Whether the trial has told it to take this address by the bus.
    pub fn was_told(&self, address: u8) -> bool {
        self.told.contains(&address)
    }

    /// Whether it may be at this address.
    pub fn is_at(&self, address: Address) -> bool {
        matches!(address, Address::Fdl(address) if self.met.contains(&address))
    }

    /// Who it said that it is, for the report.
    pub fn identity(&self) -> Option<String> {
        self.ident.map(|ident| format!("ident 0x{ident:04X} at station {}", self.address))
    }
}
