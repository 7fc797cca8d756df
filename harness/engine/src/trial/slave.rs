//! The addresses of a PROFIBUS slave during a trial that may change them, and the ident number that it reported.

use judge::observe::Address;

/// The addresses of the slave under test.
#[derive(Clone, Debug)]
pub struct SlaveAddresses {
    /// The address on the bench.
    pub address: u8,
    /// The ident number that it reported.
    pub ident: Option<u16>,
    /// All addresses at which it may be after the actions of the trial.
    possible: Vec<u8>,
    /// The addresses that the trial has assigned by Set_Slave_Address.
    assigned: Vec<u8>,
}

impl SlaveAddresses {
    /// A slave at the address of the bench, with unknown ident number.
    pub fn new(address: u8) -> SlaveAddresses {
        SlaveAddresses { address, ident: None, possible: vec![address], assigned: Vec::new() }
    }

    /// Remembers an address that the trial requests or assigns.
    pub fn remember(&mut self, address: u8) {
        if address < 127 && !self.possible.contains(&address) {
            self.possible.push(address);
        }
    }

    /// Remembers an address that the trial assigns by Set_Slave_Address.
    pub fn assign(&mut self, address: u8) {
        self.remember(address);
        self.assigned.push(address);
    }

    /// All addresses at which it may be.
    pub fn possible(&self) -> &[u8] {
        &self.possible
    }

    /// Whether the trial has assigned this address by Set_Slave_Address.
    pub fn was_assigned(&self, address: u8) -> bool {
        self.assigned.contains(&address)
    }

    /// Whether it may be at this address.
    pub fn is_at(&self, address: Address) -> bool {
        matches!(address, Address::Fdl(address) if self.possible.contains(&address))
    }

    /// The identity that it reported, for the report.
    pub fn identity(&self) -> Option<String> {
        self.ident.map(|ident| format!("ident 0x{ident:04X} at station {}", self.address))
    }
}
