//! The last filter before a PROFIBUS: tokens, FDL status requests and Global_Control may go to every station; all other frames
//! may go only to the device under test.
//!
//! It also withholds frames that the bench gives no consent to. This module must not know why a frame is sent.

use crate::frame_limits::FrameLimits;
use crate::withheld::WithheldFrames;
use results::bench_file::Consents;
use wire::profibus::fdl::{BROADCAST, DataFrame, FdlFrame, RequestFunction};
use wire::profibus::sap::{SapService, SlaveSap};

/// The filter and the frames that it withheld.
///
/// A suite gives a slave other addresses, by its switches or over the bus. So the discovery of the bus decides: an address at
/// which no station was found belongs to the device or to no station; an address of another station is not used.
#[derive(Clone, Debug)]
pub struct Fence {
    device: u8,
    /// The other stations; `None` if not known yet.
    others: Option<Vec<u8>>,
    consent: Consents,
    held_back: WithheldFrames,
    /// What drawn sequences may change, while they run.
    limits: Option<Box<FrameLimits>>,
}

impl Fence {
    /// A filter for the slave at `device`. Until [`set_other_stations`](Self::set_other_stations) is called, frames go to no other address.
    pub fn new(device: u8, consent: Consents) -> Fence {
        Fence { device, others: None, consent, held_back: WithheldFrames::default(), limits: None }
    }

    /// Sets the address of the device, as long as the other stations are not known.
    pub fn set_device(&mut self, device: u8) {
        self.device = device;
    }

    /// Sets the addresses of the other stations.
    pub fn set_other_stations(&mut self, others: Vec<u8>) {
        self.others = Some(others);
    }

    /// The addresses of the other stations; empty if not known yet.
    pub fn other_stations(&self) -> &[u8] {
        self.others.as_deref().unwrap_or_default()
    }

    /// Whether `octets` may be sent; a frame that may not is counted.
    pub fn allows(&mut self, octets: &[u8]) -> bool {
        let Err((to, why)) = self.judge(octets).and_then(|()| self.judge_limits(octets)) else { return true };
        self.held_back.count(why, self.is_device(to));
        false
    }

    /// The limits for drawn sequences, if there are any now.
    pub fn limits_mut(&mut self) -> &mut Option<Box<FrameLimits>> {
        &mut self.limits
    }

    /// Checks a frame by the limits for drawn sequences.
    fn judge_limits(&mut self, octets: &[u8]) -> Result<(), (u8, String)> {
        let Some(limits) = &mut self.limits else { return Ok(()) };
        let has_others = self.others.as_ref().is_none_or(|others| !others.is_empty());
        let to = self.device;
        limits.judge_bytes(octets, has_others).map_err(|why| (to, why))
    }

    /// The withheld frames.
    pub fn withheld_frames(&self) -> &WithheldFrames {
        &self.held_back
    }

    /// Forgets the withheld frames.
    pub fn forget_withheld(&mut self) {
        self.held_back = WithheldFrames::default();
    }

    fn is_device(&self, to: u8) -> bool {
        match &self.others {
            None => to == self.device,
            Some(others) => to != BROADCAST && !others.contains(&to),
        }
    }

    /// Checks a frame; the error has its destination and the reason.
    fn judge(&self, octets: &[u8]) -> Result<(), (u8, String)> {
        let frame = match FdlFrame::parse(octets) {
            Ok(FdlFrame::Data(frame)) => frame,
            // A token reaches only masters, an acknowledgement or invalid bytes reach no slave.
            Ok(FdlFrame::Token { .. } | FdlFrame::ShortAcknowledgement) | Err(_) => return Ok(()),
        };
        let no = |why: String| Err((frame.da, why));
        // An answer goes only to another master, and there is none.
        if frame.fc.requested() == Some(RequestFunction::FDL_STATUS) || !frame.fc.is_request() {
            return Ok(());
        }
        let service = SapService::of(&frame);
        if frame.da == BROADCAST {
            let is_control = service == SapService::Slave(SlaveSap::GLOBAL_CONTROL);
            return if is_control {
                Ok(())
            } else {
                no("a frame to all stations that is not Global_Control".to_owned())
            };
        }
        if !self.is_device(frame.da) {
            return no(format!("a frame to station {}, which is not the device under test", frame.da));
        }
        match self.lacks_consent(&frame, service) {
            Some(why) => no(why),
            None => Ok(()),
        }
    }

    /// The permanent change that a frame to the device would make without consent.
    fn lacks_consent(&self, frame: &DataFrame<'_>, service: SapService) -> Option<String> {
        if service != SapService::Slave(SlaveSap::SET_SLAVE_ADDRESS) {
            return None;
        }
        let new = frame.data.first().copied();
        if let (Some(new), Some(others)) = (new, &self.others)
            && others.contains(&new)
        {
            return Some(format!("a Set_Slave_Address to {new}, which another station has"));
        }
        if !self.consent.set_address {
            return Some("a Set_Slave_Address without the consent set_address".to_owned());
        }
        // Octets: new address, ident (two), No_Add_Chg.
        let locks = frame.data.get(3).is_some_and(|no_change| *no_change != 0);
        (locks && !self.consent.lock_address)
            .then(|| "a Set_Slave_Address that locks the address, without the consent lock_address".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const DEVICE: u8 = 5;
    const OTHER: u8 = 9;

    /// A frame with data of master 2 according to IEC 61158-4-3: SD2, twice the length, SD2, and so on.
    fn frame(to: u8, function: u8, saps: Option<(u8, u8)>, data: &[u8]) -> Vec<u8> {
        let mut body =
            vec![if saps.is_some() { to | 0x80 } else { to }, if saps.is_some() { 0x82 } else { 2 }, function];
        body.extend(saps.into_iter().flat_map(|(dsap, ssap)| [dsap, ssap]));
        body.extend(data);
        let (length, sum) = (body.len() as u8, body.iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet)));
        [&[0x68, length, length, 0x68][..], &body, &[sum, 0x16]].concat()
    }

    fn status(to: u8) -> Vec<u8> {
        vec![0x10, to, 2, 0x49, to.wrapping_add(2).wrapping_add(0x49), 0x16]
    }

    fn fence(set_address: bool) -> Fence {
        let mut fence = Fence::new(DEVICE, Consents { set_address, ..Consents::default() });
        fence.set_other_stations(vec![OTHER]);
        fence
    }

    #[rstest]
    #[case::token(vec![0xDC, 2, 2], true)]
    #[case::is_anybody_there(status(OTHER), true)]
    #[case::global_control(frame(127, 0x46, Some((58, 62)), &[0, 0]), true)]
    #[case::other_to_all(frame(127, 0x46, Some((55, 62)), &[6, 0x16, 0x55, 0]), false)]
    #[case::data_to_all(frame(127, 0x46, None, &[0]), false)]
    #[case::diagnosis(frame(DEVICE, 0x6D, Some((60, 62)), &[]), true)]
    #[case::diagnosis_of_another(frame(OTHER, 0x6D, Some((60, 62)), &[]), false)]
    #[case::parameters_of_another(frame(OTHER, 0x7D, Some((61, 62)), &[0x88, 1, 1, 11, 0, 0, 0]), false)]
    #[case::unused_address(frame(17, 0x6D, Some((60, 62)), &[]), true)]
    #[case::no_frame(vec![0xFF, 1, 2], true)]
    fn only_the_device_is_addressed(#[case] frame: Vec<u8>, #[case] goes: bool) {
        let mut fence = fence(true);
        assert_eq!(fence.allows(&frame), goes, "{:?}", fence.withheld_frames().summary());
        assert_eq!(fence.withheld_frames().summary().is_none(), goes);
        assert_eq!(fence.withheld_frames().withheld(), None, "no frame to the device was withheld");
    }

    #[test]
    fn before_others_are_known_only_the_device_is_addressed() {
        let mut fence = Fence::new(DEVICE, Consents::default());
        assert!(fence.allows(&frame(DEVICE, 0x6D, Some((60, 62)), &[])));
        assert!(fence.allows(&status(17)));
        assert!(!fence.allows(&frame(17, 0x6D, Some((60, 62)), &[])));
        let said = fence.withheld_frames().summary().expect("one was withheld");
        assert_eq!(
            said,
            "1 frame(s) of the harness were withheld; the first: a frame to station 17, which is not the device under test"
        );
    }

    #[rstest]
    #[case(false, 6, false)]
    #[case(true, 6, true)]
    #[case(true, OTHER, false)]
    fn an_address_needs_consent_and_is_never_that_of_another(#[case] given: bool, #[case] new: u8, #[case] goes: bool) {
        let mut fence = fence(given);
        assert_eq!(fence.allows(&frame(126, 0x6D, Some((55, 62)), &[new, 0x16, 0x55, 0])), goes);
        assert_eq!(fence.withheld_frames().withheld().is_none(), goes, "{:?}", fence.withheld_frames().withheld());
    }

    /// IEC 61158-6-3, Set_Slave_Address: any No_Add_Chg but 0 forbids further changes.
    #[rstest]
    #[case(0x00, false, true)]
    #[case(0x01, false, false)]
    #[case(0xFF, false, false)]
    #[case(0x01, true, true)]
    fn locking_an_address_needs_a_consent_of_its_own(
        #[case] no_change: u8,
        #[case] lock_address: bool,
        #[case] goes: bool,
    ) {
        let mut fence = Fence::new(DEVICE, Consents { set_address: true, lock_address, ..Consents::default() });
        fence.set_other_stations(vec![OTHER]);
        assert_eq!(fence.allows(&frame(DEVICE, 0x6D, Some((55, 62)), &[6, 0x16, 0x55, no_change])), goes);
    }
}
