//! The last filter before the wire: a frame goes only to the device under test or is part of discovery.
//!
//! It also withholds frames that the bench gives no consent to, so that an error in any other module changes nothing. This module
//! must not know why a frame is sent.

use super::frame_limits::FrameLimits;
use super::withheld::WithheldFrames;
use results::bench_file::Consents;
use wire::datagram::Ipv4;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::http;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, Dcp, DcpBody, DcpValue, Element, ResetMode, ServiceId};
use wire::profinet::rt::{FrameId, FrameKind};

/// The filter and the frames that it withheld.
#[derive(Clone, Debug)]
pub struct Guard {
    device: Option<Mac>,
    consent: Consents,
    /// The paths of the web pages whose forms make the device wait for other firmware.
    firmware_pages: Vec<String>,
    /// Name and address that the device had before the run.
    initial: Option<(Vec<u8>, IpParameter)>,
    held_back: WithheldFrames,
    /// What drawn sequences may change, while they run.
    limits: Option<Box<FrameLimits>>,
}

impl Guard {
    /// A filter that passes discovery, and frames to `device` once it is known.
    pub fn new(device: Option<Mac>, consent: Consents, firmware_pages: Vec<String>) -> Guard {
        Guard { device, consent, firmware_pages, initial: None, held_back: WithheldFrames::default(), limits: None }
    }

    /// Lets pass what puts back the name and the address that the device had before the run, whatever the consents are.
    pub fn allow_initial(&mut self, name: Vec<u8>, ip: IpParameter) {
        self.initial = Some((name, ip));
    }

    /// Whether `frame` may be sent; a frame that may not is counted.
    pub fn allows(&mut self, frame: &[u8]) -> bool {
        let limited = |limits: &mut Option<Box<FrameLimits>>| limits.as_mut()?.judge_frame(frame).err();
        match self.objection(frame).or_else(|| limited(&mut self.limits)) {
            None => true,
            Some(why) => {
                let of_device = self.device.is_some_and(|device| frame.starts_with(&device.0));
                self.held_back.count(why, of_device);
                false
            }
        }
    }

    /// The limits for drawn sequences, if there are any now.
    pub fn limits_mut(&mut self) -> &mut Option<Box<FrameLimits>> {
        &mut self.limits
    }

    /// The withheld frames.
    pub fn withheld_frames(&self) -> &WithheldFrames {
        &self.held_back
    }

    /// Forgets the withheld frames.
    pub fn forget_withheld(&mut self) {
        self.held_back = WithheldFrames::default();
    }

    fn objection(&self, frame: &[u8]) -> Option<String> {
        let to = frame.get(..6).and_then(|octets| octets.try_into().ok()).map(Mac)?;
        if Some(to) == self.device {
            return self.no_consent(frame);
        }
        let Ok((header, payload)) = FrameHeader::parse(frame) else {
            return Some(format!("an unreadable frame to {to}"));
        };
        let is_discovery = match header.ether_type {
            EtherType::PROFINET => {
                to == Mac::DCP_MULTICAST
                    && FrameId::peek(payload).is_ok_and(|id| id.kind() == FrameKind::DcpIdentifyRequest)
            }
            EtherType::LLDP => to == Mac::LLDP_MULTICAST,
            EtherType::ARP => to == Mac::BROADCAST,
            _ => false,
        };
        (!is_discovery).then(|| format!("a frame to {to}, which is not the device under test"))
    }

    /// The permanent change that a frame to the device would make without consent.
    fn no_consent(&self, frame: &[u8]) -> Option<String> {
        let (header, payload) = FrameHeader::parse(frame).ok()?;
        if header.ether_type == EtherType::IPV4 {
            return self.no_consent_to_page(payload);
        }
        if header.ether_type != EtherType::PROFINET || FrameId::peek(payload).ok()?.kind() != FrameKind::DcpGetSet {
            return None;
        }
        let dcp = Dcp::parse(payload).ok()?;
        let DcpBody::Blocks(blocks) = &dcp.body else { return None };
        if dcp.service_id != ServiceId::SET {
            return None;
        }
        blocks.iter().find_map(|block| {
            let qualifier = BlockQualifier(block.word.unwrap_or_default());
            let element = block.value.element();
            let is_initial = self.initial.as_ref().is_some_and(|(name, ip)| match &block.value {
                DcpValue::NameOfStation(value) => value == name,
                DcpValue::IpParameter(value) => value == ip,
                _ => false,
            });
            if is_initial {
                return None;
            }
            let (what, consent) = match element {
                Element::NAME_OF_STATION => ("set_name", self.consent.set_name),
                Element::IP_PARAMETER | Element::FULL_IP_SUITE if qualifier.is_permanent() => {
                    ("set_ip", self.consent.set_ip)
                }
                Element::RESET_TO_FACTORY if qualifier.reset_mode() == ResetMode::FACTORY_IMAGE => {
                    return Some("a reset that restores the firmware, which is never sent to a live device".to_owned());
                }
                Element::FACTORY_RESET | Element::RESET_TO_FACTORY => ("factory_reset", self.consent.factory_reset),
                _ => return None,
            };
            let word = element.word().unwrap_or("an unknown element");
            (!consent).then(|| format!("a DCP Set of {word} without the consent {what}"))
        })
    }
}

impl Guard {
    /// Why a TCP packet may not pass: it does not go to the web server, or submits a form without consent.
    fn no_consent_to_page(&self, packet: &[u8]) -> Option<String> {
        let packet = Ipv4::parse(packet).ok().filter(|packet| packet.protocol == Ipv4::TCP)?;
        let segment = packet.payload;
        let port = segment.get(2..4).map(|octets| u16::from_be_bytes([octets[0], octets[1]]));
        if port != Some(http::PORT) || packet.is_fragment() {
            return Some("a packet over TCP that is not for the web server".to_owned());
        }
        let data = segment.get(12).and_then(|offset| segment.get(usize::from(offset >> 4) * 4..))?;
        if data.is_empty() || data.starts_with(b"GET ") {
            return None;
        }
        let Some(path) = data.strip_prefix(b"POST ").filter(|path| path.contains(&b' ')) else {
            // A fragment of a request, whose effect cannot be determined.
            let all = self.consent.nvm_write > 0 && (self.consent.firmware || self.firmware_pages.is_empty());
            return (!all)
                .then(|| "a fragment of a request for a web page without the consents for all forms".to_owned());
        };
        let is_path = |known: &&String| path.strip_prefix(known.as_bytes()).is_some_and(|rest| rest.starts_with(b" "));
        match self.firmware_pages.iter().find(is_path) {
            Some(_) if self.consent.firmware => None,
            Some(path) => Some(format!("the form of {path} without the consent firmware")),
            None if self.consent.nvm_write > 0 => None,
            None => Some("the form of a web page without the consent nvm_write".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;
    use std::net::Ipv4Addr;
    use wire::profinet::dcp::DcpBlock;

    const DEVICE: Mac = Mac([2, 0, 0, 0, 1, 0]);
    const OTHER: Mac = Mac([2, 0, 0, 0, 1, 1]);
    const OURS: Mac = Mac([2, 0, 0, 0, 0, 1]);

    fn guard(device: Option<Mac>, consent: Consents) -> Guard {
        Guard::new(device, consent, vec!["/upgrade.htm".to_owned()])
    }

    fn dcp(to: Mac, dcp: &Dcp) -> Vec<u8> {
        let mut frame = Vec::new();
        dcp.write_frame(to, OURS, &mut frame);
        frame
    }

    fn set(qualifier: BlockQualifier, value: DcpValue) -> Dcp {
        Dcp::set(7, vec![DcpBlock::set(qualifier, value)])
    }

    fn with(change: impl Fn(&mut Consents)) -> Consents {
        let mut consent = Consents::default();
        change(&mut consent);
        consent
    }

    #[test]
    fn discovery_goes_to_all_stations_and_the_rest_to_the_device_only() {
        let mut guard = guard(Some(DEVICE), Consents::default());
        assert!(guard.allows(&dcp(Mac::DCP_MULTICAST, &Dcp::identify(1, 1, vec![DcpValue::AllSelector]))));
        assert!(guard.allows(&dcp(DEVICE, &Dcp::get(2, vec![Element::DEVICE_ID]))));
        assert_eq!(guard.withheld_frames().summary(), None);
        assert!(!guard.allows(&dcp(OTHER, &Dcp::get(2, vec![Element::DEVICE_ID]))));
        // A Set to all stations must never be sent.
        let name = set(BlockQualifier::PERMANENT, DcpValue::NameOfStation(b"all-alike".to_vec()));
        assert!(!guard.allows(&dcp(Mac::DCP_MULTICAST, &name)));
        assert!(!guard.allows(&[0xff; 20]));
        let said = guard.withheld_frames().summary().expect("three frames were withheld");
        assert_eq!(guard.withheld_frames().withheld(), None, "no frame to the device was withheld");
        assert!(said.starts_with("3 frame(s)") && said.contains(&OTHER.to_string()), "{said}");
    }

    #[test]
    fn the_initial_name_and_address_need_no_consent() {
        let mut guard = guard(Some(DEVICE), Consents::default());
        let ip = |last| IpParameter {
            address: Ipv4Addr::new(192, 168, 0, last),
            mask: Ipv4Addr::new(255, 255, 0, 0),
            gateway: Ipv4Addr::new(192, 168, 0, 1),
        };
        guard.allow_initial(b"pump-7".to_vec(), ip(7));
        let name = |name: &[u8]| set(BlockQualifier::PERMANENT, DcpValue::NameOfStation(name.to_vec()));
        let address = |last| set(BlockQualifier::PERMANENT, DcpValue::IpParameter(ip(last)));
        assert!(guard.allows(&dcp(DEVICE, &name(b"pump-7"))) && guard.allows(&dcp(DEVICE, &address(7))));
        assert!(!guard.allows(&dcp(DEVICE, &name(b"pump-8"))) && !guard.allows(&dcp(DEVICE, &address(8))));
        assert!(!guard.allows(&dcp(OTHER, &name(b"pump-7"))), "only to the device");
        let reset = Dcp::set(7, vec![DcpBlock::set(BlockQualifier(8), DcpValue::FactoryReset)]);
        assert!(!guard.allows(&dcp(DEVICE, &reset)));
    }

    #[test]
    fn before_the_device_is_known_only_discovery_passes() {
        let mut guard = guard(None, Consents::default());
        assert!(!guard.allows(&dcp(DEVICE, &Dcp::get(2, vec![Element::DEVICE_ID]))));
        assert!(guard.allows(&dcp(Mac::DCP_MULTICAST, &Dcp::identify(1, 1, vec![DcpValue::AllSelector]))));
    }

    #[rstest]
    #[case::name(set(BlockQualifier::TEMPORARY, DcpValue::NameOfStation(vec![])), with(|of| of.set_name = true))]
    #[case::ip(set(BlockQualifier::PERMANENT, DcpValue::IpParameter(IpParameter::NONE)), with(|of| of.set_ip = true))]
    #[case::reset(set(BlockQualifier::TEMPORARY, DcpValue::FactoryReset), with(|of| of.factory_reset = true))]
    #[case::reset_to(Dcp::reset_to_factory(7, ResetMode::COMMUNICATION), with(|of| of.factory_reset = true))]
    fn permanent_changes_need_consent(#[case] request: Dcp, #[case] consent: Consents) {
        assert!(!guard(Some(DEVICE), Consents::default()).allows(&dcp(DEVICE, &request)));
        assert!(guard(Some(DEVICE), consent).allows(&dcp(DEVICE, &request)));
    }

    #[test]
    fn a_temporary_address_needs_no_consent_and_a_firmware_reset_is_always_refused() {
        let mut guard = guard(Some(DEVICE), with(|of| of.factory_reset = true));
        let address = IpParameter { address: Ipv4Addr::new(192, 168, 0, 10), ..IpParameter::NONE };
        assert!(guard.allows(&dcp(DEVICE, &set(BlockQualifier::TEMPORARY, DcpValue::IpParameter(address)))));
        assert!(!guard.allows(&dcp(DEVICE, &Dcp::reset_to_factory(7, ResetMode::FACTORY_IMAGE))));
    }

    /// A frame with TCP: headers without options, checksums not computed.
    fn segment(port: u16, data: &[u8]) -> Vec<u8> {
        let mut frame = Vec::new();
        FrameHeader::new(DEVICE, OURS, EtherType::IPV4).write(&mut frame);
        frame.extend([0x45, 0]);
        frame.extend((40 + data.len() as u16).to_be_bytes());
        frame.extend([0, 0, 0, 0, 64, 6, 0, 0, 192, 168, 0, 1, 192, 168, 0, 10]);
        frame.extend([0xC0, 0x30]);
        frame.extend(port.to_be_bytes());
        frame.extend([0, 0, 0, 1, 0, 0, 0, 1, 0x50, 0x18, 0x10, 0, 0, 0, 0, 0]);
        frame.extend(data);
        frame
    }

    #[rstest]
    #[case::page(80, "GET /upgrade.htm HTTP/1.1", Consents::default(), true)]
    #[case::nothing_yet(80, "", Consents::default(), true)]
    #[case::other_port(8080, "GET / HTTP/1.1", Consents::default(), false)]
    #[case::form(80, "POST /preset.htm HTTP/1.1", Consents::default(), false)]
    #[case::form_with_consent(80, "POST /preset.htm HTTP/1.1", with(|of| of.nvm_write = 1), true)]
    #[case::upgrade(80, "POST /upgrade.htm HTTP/1.1", with(|of| of.nvm_write = 1), false)]
    #[case::piece(80, "POST /upg", with(|of| of.nvm_write = 1), false)]
    #[case::other_piece(80, "rade.htm HTTP/1.1", with(|of| of.nvm_write = 1), false)]
    #[case::piece_with_all_consents(80, "POST /upg", with(|of| (of.nvm_write, of.firmware) = (1, true)), true)]
    #[case::upgrade_with_consent(80, "POST /upgrade.htm HTTP/1.1", with(|of| of.firmware = true), true)]
    fn tcp_reaches_only_the_web_server_and_forms_need_consent(
        #[case] port: u16,
        #[case] data: &str,
        #[case] consent: Consents,
        #[case] goes: bool,
    ) {
        let mut guard = guard(Some(DEVICE), consent);
        assert_eq!(guard.allows(&segment(port, data.as_bytes())), goes, "{:?}", guard.withheld_frames().summary());
        assert_eq!(guard.withheld_frames().withheld().is_none(), goes);
    }
}
