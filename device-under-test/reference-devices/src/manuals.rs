//! The manuals, and how the devices of each are built.
//!
//! The contents of a manual are in its model. Here each model gets its stack and its part of the deviations.

use crate::manual::{Bus, Manual, Profibus, Profinet, encoder};
use crate::models::{datalogic_amt58, kuebler_sendix58xx, lika_xac77, plain, sick_a3m60, sick_afx60};
use alloc::boxed::Box;
use device_stack::profinet::StationData;
use device_stack::{profibus, profinet};
use wire::ethernet::Mac;

/// Every manual that has a reference device.
pub static MANUALS: &[&Manual] =
    &[&LIKA_XAC77, &KUEBLER_SENDIX58XX, &SICK_AFX60, &SICK_A3M60, &DATALOGIC_AMT58, &PROFINET_IO];

/// Lika XAC77.
pub static LIKA_XAC77: Manual = Manual {
    name: "lika-xac77-profinet",
    title: "Lika XAC77 absolute encoder",
    variants: &[lika_xac77::FACTS.variants[0].name, lika_xac77::FACTS.variants[1].name],
    facts: Some(&lika_xac77::FACTS),
    bus: Bus::Profinet(Profinet {
        // Manual, 7.3.
        oui: Some([0x10, 0xB9, 0xFE]),
        delivered: |_| StationData::default(),
        build: |variant, deviations, piece| {
            let model = lika_xac77::State::new(deviations.web.clone());
            encoder(&lika_xac77::FACTS, model, variant, deviations, piece)
        },
    }),
};

/// Kübler Sendix 58xx.
pub static KUEBLER_SENDIX58XX: Manual = Manual {
    name: "kuebler-sendix58xx-profinet",
    title: "Kübler Sendix 58xx absolute encoder",
    variants: &[kuebler_sendix58xx::FACTS.variants[0].name, kuebler_sendix58xx::FACTS.variants[1].name],
    facts: Some(&kuebler_sendix58xx::FACTS),
    bus: Bus::Profinet(Profinet {
        oui: None,
        delivered: |_| StationData::default(),
        build: |variant, deviations, piece| {
            encoder(&kuebler_sendix58xx::FACTS, kuebler_sendix58xx::Sendix, variant, deviations, piece)
        },
    }),
};

/// SICK AFS60 and AFM60.
pub static SICK_AFX60: Manual = Manual {
    name: "sick-afx60-profinet",
    title: "SICK AFS60/AFM60 absolute encoders",
    variants: &[sick_afx60::FACTS.variants[0].name, sick_afx60::FACTS.variants[1].name],
    facts: Some(&sick_afx60::FACTS),
    bus: Bus::Profinet(Profinet {
        oui: None,
        delivered: sick_afx60::delivered,
        build: |variant, deviations, piece| {
            let model = sick_afx60::State::new(piece.mac, deviations.sick.clone(), deviations.afx60.clone());
            encoder(&sick_afx60::FACTS, model, variant, deviations, piece)
        },
    }),
};

/// SICK A3M60.
pub static SICK_A3M60: Manual = Manual {
    name: "sick-a3m60-profibus",
    title: "SICK A3M60 Advanced PROFIBUS absolute encoder",
    variants: &[sick_a3m60::FACTS.variants[0].name],
    facts: Some(&sick_a3m60::FACTS),
    bus: Bus::Profibus(Profibus {
        delivered: sick_a3m60::ADDRESS,
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
pub static DATALOGIC_AMT58: Manual = Manual {
    name: "datalogic-amt58-profibus",
    title: "Datalogic AMT58 PROFIBUS-DP absolute encoder",
    variants: &[datalogic_amt58::VARIANTS[0].0, datalogic_amt58::VARIANTS[1].0],
    facts: None,
    bus: Bus::Profibus(Profibus {
        delivered: datalogic_amt58::ADDRESS,
        build: |variant, deviations, shaft, line| {
            let (_, hardware) = datalogic_amt58::VARIANTS.iter().find(|(name, _)| *name == variant)?;
            let (shared, hooks) = (deviations.encoder.clone(), deviations.amt58.clone());
            let encoder = datalogic_amt58::Amt58::new(*hardware, shared, hooks, shaft, line.address);
            Some(Box::new(profibus::DpDevice::new(encoder, line.baud, deviations.slave.clone())))
        },
    }),
};

/// A generic PROFINET IO device, which follows no manual.
pub static PROFINET_IO: Manual = Manual {
    name: "profinet-io",
    title: "Any PROFINET IO device",
    variants: &["plain"],
    facts: None,
    bus: Bus::Profinet(Profinet {
        oui: None,
        delivered: |_| StationData::default(),
        build: |variant, deviations, piece| {
            let mac = Mac(piece.mac);
            let device = plain::Plain::new(piece.mac, piece.station);
            PROFINET_IO
                .variants
                .contains(&variant)
                .then(|| Box::new(profinet::IoDevice::new(device, mac, deviations.stack.clone())) as _)
        },
    }),
};
