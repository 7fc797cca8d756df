//! Set_Slave_Address (IEC 61158-6-3): the bus assigns another station address.

use super::application::State;
use super::hooks::Check;
use super::link::Answer;
use super::slave::{Env, Slave};
use wire::profibus::address::SetSlaveAddress;

/// The highest address of a slave. 126 is for slaves without an assigned address.
const LAST: u8 = 125;

impl Slave {
    /// Processes Set_Slave_Address.
    pub(super) fn set_slave_address(&mut self, env: &mut Env<'_>, data: &[u8]) -> Answer {
        let is_in_wait_prm = self.check(env, Check::AddressTime, self.state == State::WaitPrm);
        let is_served = is_in_wait_prm && self.check(env, Check::AddressService, env.application.takes_address());
        if !is_served {
            return Answer::NO_SERVICE;
        }
        let Ok(request) = SetSlaveAddress::parse(data) else { return Answer::NO_SERVICE };
        let has_own_ident = self.check(env, Check::AddressIdent(request.ident), request.ident == self.identity.ident);
        if has_own_ident && self.check(env, Check::NewAddress(request.address), request.address <= LAST) {
            env.application.set_address(env.at(), request.address, request.no_change != 0);
            self.address = request.address;
        }
        Answer::Taken
    }
}
