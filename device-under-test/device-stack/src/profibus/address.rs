//! Set_Slave_Address (IEC 61158-6-3): the bus assigns another station address.

use super::application::DpState;
use super::hooks::SlaveStackCheck;
use super::link::ServiceAnswer;
use super::slave::{PoweredSlave, SlaveEnv};
use wire::profibus::address::SetSlaveAddress;

/// The highest address of a slave. 126 is for slaves without an assigned address.
const LAST: u8 = 125;

impl PoweredSlave {
    /// Processes Set_Slave_Address.
    pub(super) fn set_slave_address(&mut self, env: &mut SlaveEnv<'_>, data: &[u8]) -> ServiceAnswer {
        let is_in_wait_prm = self.check(env, SlaveStackCheck::AddressTime, self.state == DpState::WaitPrm);
        let is_served =
            is_in_wait_prm && self.check(env, SlaveStackCheck::AddressService, env.application.takes_address());
        if !is_served {
            return ServiceAnswer::NO_SERVICE;
        }
        let Ok(request) = SetSlaveAddress::parse(data) else { return ServiceAnswer::NO_SERVICE };
        let has_own_ident =
            self.check(env, SlaveStackCheck::AddressIdent(request.ident), request.ident == self.identity.ident);
        if has_own_ident && self.check(env, SlaveStackCheck::NewAddress(request.address), request.address <= LAST) {
            env.application.set_address(env.application_time(), request.address, request.no_change != 0);
            self.address = request.address;
        }
        ServiceAnswer::Taken
    }
}
