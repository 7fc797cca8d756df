//! The text form of MAC addresses, and the response delay that DCP derives from one.

use encspec_wire::ethernet::{Mac, Vlan};
use encspec_wire::profinet::dcp::response_delay_steps;
use rstest::rstest;

#[rstest]
#[case("00:0e:cf:a1:b2:0c", Some([0x00, 0x0e, 0xcf, 0xa1, 0xb2, 0x0c]))]
#[case("00-0E-CF-A1-B2-0C", Some([0x00, 0x0e, 0xcf, 0xa1, 0xb2, 0x0c]))]
#[case("", None)]
#[case("00:0e:cf:a1:b2", None)]
#[case("00:0e:cf:a1:b2:0c:00", None)]
#[case("0:e:cf:a1:b2:c", None)]
#[case("+0:0e:cf:a1:b2:0c", None)]
#[case("g0:0e:cf:a1:b2:0c", None)]
#[case("000ecfa1b20c", None)]
fn an_address_is_parsed_from_text(#[case] text: &str, #[case] octets: Option<[u8; 6]>) {
    assert_eq!(text.parse().ok(), octets.map(Mac));
    if let Some(octets) = octets {
        assert_eq!(Mac(octets).to_string(), text.to_lowercase().replace('-', ":"));
    }
}

#[rstest]
#[case(Mac::BROADCAST, true)]
#[case(Mac::DCP_MULTICAST, true)]
#[case(Mac::LLDP_MULTICAST, true)]
#[case(Mac([0x02, 0, 0, 0, 0, 1]), false)]
fn multicast_and_unicast_addresses_differ(#[case] mac: Mac, #[case] group: bool) {
    assert_eq!(mac.is_group(), group);
}

#[rstest]
#[case(0xc123, 6, false, 0x123)]
#[case(0x3fff, 1, true, 0xfff)]
#[case(0x0000, 0, false, 0)]
fn a_tag_holds_priority_eligibility_and_id(
    #[case] control: u16,
    #[case] priority: u8,
    #[case] drop_eligible: bool,
    #[case] id: u16,
) {
    let tag = Vlan { control, ..Vlan::RT };
    assert_eq!((tag.priority(), tag.drop_eligible(), tag.id()), (priority, drop_eligible, id));
}

/// The address 28:63:36:86:59:82 ends in 0x5982, which is 22914.
#[rstest]
#[case(0, 0)]
#[case(1, 0)]
#[case(2, 0)]
#[case(100, 14)]
#[case(6400, 3714)]
fn the_response_delay_depends_on_the_address(#[case] factor: u16, #[case] steps: u16) {
    assert_eq!(response_delay_steps(Mac([0x28, 0x63, 0x36, 0x86, 0x59, 0x82]), factor), steps);
}
