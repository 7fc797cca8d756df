//! Set_Slave_Address: assigns a station address to a slave over the bus.
//!
//! Source: IEC 61158-6-3, Set_Slave_Add.

use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

/// The new address of a slave.
///
/// Bytes: 0 new address, 1-2 ident number, 3 whether the address may be changed again, then up to 240 bytes that the slave
/// stores (IEC 61158-6-3, Set_Slave_Add request).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetSlaveAddress {
    /// New_Slave_Add, 0 to 125.
    pub address: u8,
    /// Ident_Number; a slave with another ident number rejects the request.
    pub ident: u16,
    /// No_Add_Chg: 0 the address may be changed again; otherwise only after a reset of the slave.
    pub no_change: u8,
    /// Rem_Slave_Data: data that the application of the slave stores.
    pub slave_data: Vec<u8>,
}

impl SetSlaveAddress {
    /// Parses the data of a Set_Slave_Address request; fails only if it has fewer than four bytes.
    pub fn parse(octets: &[u8]) -> Result<SetSlaveAddress> {
        let mut reader = ByteReader::new("Set_Slave_Address", octets);
        Ok(SetSlaveAddress {
            address: reader.u8()?,
            ident: reader.u16()?,
            no_change: reader.u8()?,
            slave_data: reader.rest().to_vec(),
        })
    }

    /// Appends the data.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u8(self.address);
        out.put_u16(self.ident);
        out.put_u8(self.no_change);
        out.put(&self.slave_data);
    }
}
