//! Set_Slave_Address (IEC 61158-6-3): another station address over the bus.

use super::application::State;
use super::hooks::Check;
use super::link::Answer;
use super::slave::{Env, Slave};
use wire::profibus::address::SetSlaveAddress;

/// The highest address of a slave: 126 is for those that wait for one.
const LAST: u8 = 125;

impl Slave {
    /// Takes another address.
    pub(super) fn set_slave_address(&mut self, env: &mut Env<'_>, data: &[u8]) -> Answer {
        let is_time = self.check(env, Check::AddressTime, self.state == State::WaitPrm);
        let may = is_time && self.check(env, Check::AddressService, env.application.takes_address());
        let (true, Ok(request)) = (may, SetSlaveAddress::parse(data)) else {
            return Answer::NO_SERVICE;
        };
        let is_meant = self.check(env, Check::AddressIdent(request.ident), request.ident == self.identity.ident);
        if is_meant && self.check(env, Check::NewAddress(request.address), request.address <= LAST) {
            env.application.set_address(env.at(), request.address, request.no_change != 0);
            self.address = request.address;
        }
        Answer::Taken
    }
}
