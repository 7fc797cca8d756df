//! Deviations of the PROFINET stack in the options of DCP: what it reads, sets and finds.

use super::dcp_options_state::{AddressReturns, OnlyFirstBlock, StartsAndStopsIgnored};
use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::late::FrameTopic;
use crate::seams::stack::{Stack, change_dcp, dcp};
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::StackCheck;
use reference_devices::manuals;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockError, BlockInfo, Dcp, DcpBlock, DcpValue, Element, ServiceId, ServiceType};

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Of(&manuals::PROFINET_IO)], deviations: BUGS }];

const BUGS: &[Deviation] = bugs! {
    // Get
    "addresses-not-read" "DCP Get refuses the MAC address and the IP parameters."
        => |d| refuses_get(&mut d.stack, |element| element.option == 1);
    "identity-not-read" "DCP Get refuses type, IDs, role and options of the station."
        => |d| refuses_get(&mut d.stack, |element| matches!(element, Element::VENDOR | Element::DEVICE_ID | Element::DEVICE_ROLE | Element::DEVICE_OPTIONS));
    "name-not-read" "DCP Get refuses the name of the station."
        => |d| refuses_get(&mut d.stack, |element| element == Element::NAME_OF_STATION);
    "instance-not-read" "DCP Get refuses the DeviceInstance."
        => |d| refuses_get(&mut d.stack, |element| element == Element::DEVICE_INSTANCE);
    "initiative-not-read" "DCP Get refuses the DeviceInitiative."
        => |d| refuses_get(&mut d.stack, |element| element == Element::DEVICE_INITIATIVE);
    "only-first-element-read" "The response to a DCP Get has only its first block."
        => |d| answers(&mut d.stack, ServiceId::GET, |blocks| blocks.truncate(1));
    "unknown-elements-read-empty" "DCP Get answers elements that the device does not have with an empty value."
        => |d| answers(&mut d.stack, ServiceId::GET, |blocks| blocks.iter_mut().for_each(|block| {
            if let DcpValue::Response { element, .. } = block.value {
                *block = DcpBlock::report(BlockInfo::NONE, DcpValue::Raw { element, octets: Vec::new() });
            }
        }));
    "one-block-error-for-all" "Every element that DCP refuses has the BlockError for local reasons."
        => |d| answers(&mut d.stack, ServiceId::GET, |blocks| blocks.iter_mut().for_each(|block| {
            if let DcpValue::Response { error, .. } = &mut block.value {
                *error = BlockError::LOCAL_REASONS;
            }
        }));

    // Set
    "every-set-answered-positively" "DCP Set answers every element positively, known or not."
        => |d| answers(&mut d.stack, ServiceId::SET, |blocks| blocks.iter_mut().for_each(|block| {
            if let DcpValue::Response { error, .. } = &mut block.value {
                *error = BlockError::OK;
            }
        }));
    "only-first-block-set" "Of a DCP Set with several blocks only the first is carried out and answered."
        => |d| d.stack.add(OnlyFirstBlock);
    "signal-ends-connection" "DCP Signal ends the connections."
        => |d| d.stack.abort_at(is_signal);
    "second-signal-refused" "A DCP Signal is refused while the LED still flashes."
        => |d| {
            let mut signals = 0;
            d.stack.check(move |check, right| match check {
                StackCheck::Signal(_) => {
                    signals += 1;
                    right && signals < 2
                }
                _ => right,
            });
        };
    "reset-keeps-address" "The reset of the communication parameters keeps the IP address."
        => |d| d.stack.add(AddressReturns::default());

    // Addresses
    "group-addresses-taken" "Addresses of multicast, broadcast, loopback and the reserved classes are accepted."
        => |d| takes_address(&mut d.stack, |ip| {
            ip.address.is_multicast() || ip.address.is_loopback() || ip.address.octets()[0] >= 240 || ip.address.octets()[0] == 0
        });
    "edges-of-subnet-taken" "The first and the last address of a subnet are accepted."
        => |d| takes_address(&mut d.stack, |ip| {
            let (address, mask) = (u32::from(ip.address), u32::from(ip.mask));
            !ip.address.is_unspecified() && (address & !mask == 0 || address & !mask == !mask)
        });
    "any-mask-taken" "Subnet masks with gaps, and those without a host, are accepted."
        => |d| takes_address(&mut d.stack, |ip| {
            let mask = u32::from(ip.mask);
            mask.leading_ones() != mask.count_ones() || !(1..=30).contains(&mask.count_ones())
        });
    "any-gateway-taken" "A gateway that the device cannot reach is accepted."
        => |d| takes_address(&mut d.stack, |ip| {
            let (address, mask, gateway) = (u32::from(ip.address), u32::from(ip.mask), u32::from(ip.gateway));
            gateway & mask != address & mask || gateway & !mask == 0 || gateway & !mask == !mask
        });
    "gateway-needed" "An address without a gateway is refused."
        => |d| refuses_address(&mut d.stack, |ip| ip.gateway.is_unspecified());
    "own-gateway-refused" "An address that is its own gateway is refused."
        => |d| refuses_address(&mut d.stack, |ip| ip.gateway == ip.address);
    "only-class-c-taken" "Only subnet masks of 24 bits are accepted."
        => |d| refuses_address(&mut d.stack, |ip| u32::from(ip.mask).count_ones() != 24);

    // Identify
    "id-filter-ignored" "A DCP Identify for vendor ID and device ID is answered by any station."
        => |d| ignores_filter(&mut d.stack, |value| matches!(value, DcpValue::DeviceId { .. }));
    "type-filter-ignored" "A DCP Identify for a type of station is answered by any station."
        => |d| ignores_filter(&mut d.stack, |value| matches!(value, DcpValue::Vendor(_)));
    "role-filter-ignored" "A DCP Identify for a role or an instance is answered by any station."
        => |d| ignores_filter(&mut d.stack, |value| matches!(value, DcpValue::DeviceRole { .. } | DcpValue::DeviceInstance { .. }));
    "unknown-filter-ignored" "Filters of a DCP Identify that the device does not know are ignored."
        => |d| ignores_filter(&mut d.stack, |value| matches!(value, DcpValue::Raw { .. }));
    "second-filter-ignored" "Only the first filter of a DCP Identify counts."
        => |d| requests(&mut d.stack, ServiceId::IDENTIFY, |blocks| blocks.truncate(1));
    "found-by-name-only" "A DCP Identify for anything but all stations, a name or an alias is not answered."
        => |d| d.stack.filter_frames(|_, frame| identify(frame).is_none_or(|request| request.blocks().iter().all(|block| {
            matches!(block.value, DcpValue::NameOfStation(_) | DcpValue::AliasName(_) | DcpValue::AllSelector)
        })));
    "name-compared-without-case" "DCP Identify compares names without regard to case."
        => |d| d.stack.check(|check, right| match check {
            StackCheck::IdentifyName(name, requested) => name.eq_ignore_ascii_case(requested),
            _ => right,
        });
    "identify-answered-too-late" "A DCP Identify is answered after 500 ms, whatever delay it allows."
        => |d| d.late.sent(|topic| (topic == FrameTopic::Identify).then_some(Duration::from_millis(500)));
    "identified-without-role" "The response to a DCP Identify has no role."
        => |d| lacks(&mut d.stack, Element::DEVICE_ROLE);
    "identified-without-options" "The response to a DCP Identify has no list of options."
        => |d| lacks(&mut d.stack, Element::DEVICE_OPTIONS);
    "identified-without-address" "The response to a DCP Identify has no IP parameters."
        => |d| lacks(&mut d.stack, Element::IP_PARAMETER);
    "identified-without-type" "The response to a DCP Identify has no type of station."
        => |d| lacks(&mut d.stack, Element::VENDOR);

    // Transactions
    "transaction-applied-at-once" "What is set within a DCP transaction is used before its Stop."
        => |d| d.stack.add(StartsAndStopsIgnored);
    "transaction-open-to-all" "Any station can set within a DCP transaction of another one."
        => |d| d.stack.set(StackCheck::TransactionOwner, true);
    "transaction-never-ends" "A DCP transaction without a Stop never ends."
        => |d| d.stack.set(StackCheck::TransactionEnds, false);
};

fn refuses_get(stack: &mut Stack, is_refused: fn(Element) -> bool) {
    stack.sent_frame(move |_, frame| {
        change_dcp(frame, |of, blocks| {
            if (of.service_id, of.service_type) != (ServiceId::GET, ServiceType::RESPONSE) {
                return;
            }
            for block in blocks.iter_mut().filter(|block| is_refused(block.value.element())) {
                *block = DcpBlock::outcome(block.value.element(), BlockError::SUBOPTION_NOT_SUPPORTED);
            }
        });
    });
}

/// Changes the blocks of each response to this service.
fn answers(stack: &mut Stack, service: ServiceId, change: fn(&mut Vec<DcpBlock>)) {
    stack.sent_frame(move |_, frame| {
        change_dcp(frame, |of, blocks| {
            if (of.service_id, of.service_type) == (service, ServiceType::RESPONSE) {
                change(blocks);
            }
        });
    });
}

/// Changes the blocks of each request of this service.
fn requests(stack: &mut Stack, service: ServiceId, change: impl Fn(&mut Vec<DcpBlock>) + 'static) {
    stack.received_frames(move |_, mut frames| {
        for frame in &mut frames {
            change_dcp(frame, |of, blocks| {
                if (of.service_id, of.service_type) == (service, ServiceType::REQUEST) {
                    change(blocks);
                }
            });
        }
        frames
    });
}

/// Answers a DCP Identify as if these filters were for all stations.
fn ignores_filter(stack: &mut Stack, is_ignored: fn(&DcpValue) -> bool) {
    requests(stack, ServiceId::IDENTIFY, move |blocks| {
        for block in blocks.iter_mut().filter(|block| is_ignored(&block.value)) {
            *block = DcpBlock::plain(DcpValue::AllSelector);
        }
    });
}

/// Leaves an element out of each response to a DCP Identify.
fn lacks(stack: &mut Stack, element: Element) {
    stack.sent_frame(move |_, frame| {
        change_dcp(frame, |of, blocks| {
            if (of.service_id, of.service_type) == (ServiceId::IDENTIFY, ServiceType::RESPONSE) {
                blocks.retain(|block| block.value.element() != element);
            }
        });
    });
}

fn takes_address(stack: &mut Stack, is_taken: fn(&IpParameter) -> bool) {
    stack.check(move |check, right| match check {
        StackCheck::Address(ip) => right || is_taken(&ip),
        _ => right,
    });
}

fn refuses_address(stack: &mut Stack, is_refused: fn(&IpParameter) -> bool) {
    stack.check(move |check, right| match check {
        StackCheck::Address(ip) if ip != IpParameter::NONE => right && !is_refused(&ip),
        _ => right,
    });
}

/// The DCP Identify in a frame.
fn identify(frame: &[u8]) -> Option<Dcp> {
    dcp(frame).map(|(_, dcp)| dcp).filter(|dcp| dcp.service_id == ServiceId::IDENTIFY)
}

fn is_signal(_: &device_stack::profinet::StackView<'_>, frame: &[u8]) -> bool {
    dcp(frame).is_some_and(|(_, dcp)| dcp.blocks().iter().any(|block| matches!(block.value, DcpValue::Signal(_))))
}
