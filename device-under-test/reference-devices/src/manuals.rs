//! The manuals, and how the devices of each are built.
//!
//! The contents of a manual are in its model. Here each model gets its stack and its part of the deviations.

use crate::manual::{DeviceManual, ManualBus, Profibus, Profinet, encoder};
use crate::models::{
    datalogic_amt58, generic_dp_encoder, generic_io, generic_profidrive_encoder, generic_slave, kuebler_sendix58xx,
    lika_xac77, sick_a3m60, sick_afx60,
};
use alloc::boxed::Box;
use device_stack::profinet::StationData;
use device_stack::{profibus, profinet};
use wire::ethernet::Mac;

/// Every manual that has a reference device.
pub static MANUALS: &[&DeviceManual] = &[
    &LIKA_XAC77,
    &KUEBLER_SENDIX58XX,
    &SICK_AFX60,
    &SICK_A3M60,
    &DATALOGIC_AMT58,
    &PROFINET_IO,
    &DP_SLAVE,
    &DP_ENCODER,
    &PROFIDRIVE_ENCODER,
];

/// Lika XAC77.
pub static LIKA_XAC77: DeviceManual = DeviceManual {
    name: "lika-xac77-profinet",
    title: "Lika XAC77 absolute encoder",
    variants: &[lika_xac77::FACTS.variants[0].name, lika_xac77::FACTS.variants[1].name],
    facts: Some(&lika_xac77::FACTS),
    bus: ManualBus::Profinet(Profinet {
        // Manual, 7.3.
        oui: Some([0x10, 0xB9, 0xFE]),
        factory_station: |_| StationData::default(),
        build: |variant, deviations, piece| {
            let model = lika_xac77::Xac77State::new(deviations.web.clone());
            encoder(&lika_xac77::FACTS, model, variant, deviations, piece)
        },
    }),
};

/// Kübler Sendix 58xx.
pub static KUEBLER_SENDIX58XX: DeviceManual = DeviceManual {
    name: "kuebler-sendix58xx-profinet",
    title: "Kübler Sendix 58xx absolute encoder",
    variants: &[kuebler_sendix58xx::FACTS.variants[0].name, kuebler_sendix58xx::FACTS.variants[1].name],
    facts: Some(&kuebler_sendix58xx::FACTS),
    bus: ManualBus::Profinet(Profinet {
        oui: None,
        factory_station: |_| StationData::default(),
        build: |variant, deviations, piece| {
            encoder(&kuebler_sendix58xx::FACTS, kuebler_sendix58xx::Sendix::default(), variant, deviations, piece)
        },
    }),
};

/// SICK AFS60 and AFM60.
pub static SICK_AFX60: DeviceManual = DeviceManual {
    name: "sick-afx60-profinet",
    title: "SICK AFS60/AFM60 absolute encoders",
    variants: &[sick_afx60::FACTS.variants[0].name, sick_afx60::FACTS.variants[1].name],
    facts: Some(&sick_afx60::FACTS),
    bus: ManualBus::Profinet(Profinet {
        oui: None,
        factory_station: sick_afx60::delivered,
        build: |variant, deviations, piece| {
            let model = sick_afx60::Afx60State::new(piece.mac, deviations.sick.clone(), deviations.afx60.clone());
            encoder(&sick_afx60::FACTS, model, variant, deviations, piece)
        },
    }),
};

/// SICK A3M60.
pub static SICK_A3M60: DeviceManual = DeviceManual {
    name: "sick-a3m60-profibus",
    title: "SICK A3M60 Advanced PROFIBUS absolute encoder",
    variants: &[sick_a3m60::FACTS.variants[0].name],
    facts: Some(&sick_a3m60::FACTS),
    bus: ManualBus::Profibus(Profibus {
        factory_address: sick_a3m60::ADDRESS,
        build: |variant, deviations, shaft, line| {
            let variant = sick_a3m60::FACTS.variants.iter().find(|known| known.name == variant)?;
            let (shared, hooks) = (deviations.sick.clone(), deviations.a3m60.clone());
            let encoder = deviations.encoder.clone();
            let encoder = sick_a3m60::Encoder::new(variant, encoder, shared, hooks, shaft, line.address);
            Some(Box::new(profibus::DpDevice::new(encoder, line.baud, deviations.slave.clone())))
        },
    }),
};

/// Datalogic AMT58.
pub static DATALOGIC_AMT58: DeviceManual = DeviceManual {
    name: "datalogic-amt58-profibus",
    title: "Datalogic AMT58 PROFIBUS-DP absolute encoder",
    variants: &[datalogic_amt58::VARIANTS[0].0, datalogic_amt58::VARIANTS[1].0],
    facts: None,
    bus: ManualBus::Profibus(Profibus {
        factory_address: datalogic_amt58::ADDRESS,
        build: |variant, deviations, shaft, line| {
            let (_, hardware) = datalogic_amt58::VARIANTS.iter().find(|(name, _)| *name == variant)?;
            let (shared, hooks) = (deviations.encoder.clone(), deviations.amt58.clone());
            let encoder =
                datalogic_amt58::Amt58::new(datalogic_amt58::IDENT, *hardware, shared, hooks, shaft, line.address);
            Some(Box::new(profibus::DpDevice::new(encoder, line.baud, deviations.slave.clone())))
        },
    }),
};

/// A generic PROFINET IO device, which follows no manual.
pub static PROFINET_IO: DeviceManual = DeviceManual {
    name: "profinet-io",
    title: "Any PROFINET IO device",
    variants: &["plain"],
    facts: None,
    bus: ManualBus::Profinet(Profinet {
        oui: None,
        factory_station: |_| StationData::default(),
        build: |variant, deviations, piece| {
            let mac = Mac(piece.mac);
            let device = generic_io::GenericIoDevice::new(piece.mac, piece.station);
            PROFINET_IO
                .variants
                .contains(&variant)
                .then(|| Box::new(profinet::IoDevice::new(device, mac, deviations.stack.clone())) as _)
        },
    }),
};

/// A generic encoder of the encoder profile on PROFINET, which follows no manual.
pub static PROFIDRIVE_ENCODER: DeviceManual = DeviceManual {
    name: "profidrive-encoder",
    title: "Any PROFIdrive encoder on PROFINET",
    variants: &[generic_profidrive_encoder::FACTS.variants[0].name],
    facts: Some(&generic_profidrive_encoder::FACTS),
    bus: ManualBus::Profinet(Profinet {
        oui: None,
        factory_station: |_| StationData::default(),
        build: |variant, deviations, piece| {
            let model = generic_profidrive_encoder::GenericEncoder { mac: piece.mac };
            encoder(&generic_profidrive_encoder::FACTS, model, variant, deviations, piece)
        },
    }),
};

/// A generic DP slave, which follows no manual.
pub static DP_SLAVE: DeviceManual = DeviceManual {
    name: "dp-slave",
    title: "Any DP slave",
    variants: &["plain"],
    facts: None,
    bus: ManualBus::Profibus(Profibus {
        factory_address: generic_slave::ADDRESS,
        build: |variant, deviations, _, line| {
            let slave = generic_slave::GenericSlave::new(line.address);
            DP_SLAVE
                .variants
                .contains(&variant)
                .then(|| Box::new(profibus::DpDevice::new(slave, line.baud, deviations.slave.clone())) as _)
        },
    }),
};

/// A generic DP encoder of the encoder profile 3.062, which follows no manual.
pub static DP_ENCODER: DeviceManual = DeviceManual {
    name: "dp-encoder",
    title: "Any DP encoder",
    variants: &["plain"],
    facts: None,
    bus: ManualBus::Profibus(Profibus {
        factory_address: generic_slave::ADDRESS,
        build: |variant, deviations, shaft, line| {
            let encoder =
                generic_dp_encoder::new(deviations.encoder.clone(), deviations.amt58.clone(), shaft, line.address);
            DP_ENCODER
                .variants
                .contains(&variant)
                .then(|| Box::new(profibus::DpDevice::new(encoder, line.baud, deviations.slave.clone())) as _)
        },
    }),
};
