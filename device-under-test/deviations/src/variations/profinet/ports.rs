//! The ports of a PROFINET device: medium and rate. The manuals of the encoders print theirs, so only the generic device varies.

use crate::needs::Need;
use crate::seams::stack::Stack;
use crate::tables::Group;
use alloc::vec::Vec;
use reference_devices::manuals::PROFINET_IO;
use wire::lldp::Tlv;
use wire::profinet::blocks::physical::{MultipleBlock, PortDataReal};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&PROFINET_IO)],
    deviations: permitted! {
        "ports-of-fibre" "The ports are 100BASE-FX, without autonegotiation."
            "IEC 61158-6-10, MAUType and MediaType: as the port is built; its GSDML lists them"
            => |d| medium(&mut d.stack, Medium { mau_type: 18, media_type: 2, negotiates: false });
        "link-of-a-gigabit" "The link has 1 Gbit/s."
            "IEC 61158-6-10, MAUType: as the port is built; its GSDML lists them"
            => |d| medium(&mut d.stack, Medium { mau_type: 30, media_type: 1, negotiates: true });
    },
}];

#[derive(Clone, Copy)]
struct Medium {
    /// RFC 4836, dot3MauType.
    mau_type: u16,
    /// 1 copper, 2 fibre.
    media_type: u32,
    negotiates: bool,
}

fn medium(stack: &mut Stack, is: Medium) {
    stack.lldp(move |lldp| {
        for tlv in &mut lldp.tlvs {
            if let Tlv::MacPhy { autonegotiation, mau_type, .. } = tlv {
                *mau_type = is.mau_type;
                *autonegotiation = if is.negotiates { *autonegotiation } else { 0 };
            }
        }
        true
    });
    stack.record(move |index, data| match index {
        0x802A => of_port(data, is),
        0xF841 => {
            let Ok(blocks) = MultipleBlock::parse_record(data) else { return };
            data.clear();
            for mut block in blocks {
                of_port(&mut block.blocks, is);
                block.write(data);
            }
        }
        _ => {}
    });
}

/// Changes a PDPortDataReal; an unlinked port has the MAU type 0.
fn of_port(data: &mut Vec<u8>, is: Medium) {
    let Ok(mut port) = PortDataReal::parse(data) else { return };
    port.media_type = is.media_type;
    if port.mau_type != 0 {
        port.mau_type = is.mau_type;
    }
    data.clear();
    port.write(data);
}
