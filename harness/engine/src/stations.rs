//! The stations of the harness on the wire: controllers on PROFINET, masters on PROFIBUS, with one interface for both.
//!
//! This module must not know trials, nor what the device under test is.

use controllers::outputs::CyclicOutputs;
use controllers::profibus_dp::{ConnectionState, ProfibusMaster};
use controllers::profinet_io::{ArState, Controller};
use judge::observe::Address;
use station::{Station, Time};
use wire::ethernet::Mac;
use wire::profibus::statistics::BusStatistics;

/// The stations of the harness on one wire, first and second.
pub enum HarnessStations {
    Controllers(Vec<Controller>),
    Masters(Vec<ProfibusMaster>),
}

impl HarnessStations {
    /// The controller with this index; `None` on PROFIBUS.
    pub fn controller(&self, which: usize) -> Option<&Controller> {
        match self {
            HarnessStations::Controllers(controllers) => controllers.get(which),
            HarnessStations::Masters(_) => None,
        }
    }

    /// Like [`controller`](Self::controller), for requests.
    pub fn controller_mut(&mut self, which: usize) -> Option<&mut Controller> {
        match self {
            HarnessStations::Controllers(controllers) => controllers.get_mut(which),
            HarnessStations::Masters(_) => None,
        }
    }

    /// The master with this index; `None` on PROFINET.
    pub fn master(&self, which: usize) -> Option<&ProfibusMaster> {
        match self {
            HarnessStations::Masters(masters) => masters.get(which),
            HarnessStations::Controllers(_) => None,
        }
    }

    /// Like [`master`](Self::master), for requests.
    pub fn master_mut(&mut self, which: usize) -> Option<&mut ProfibusMaster> {
        match self {
            HarnessStations::Masters(masters) => masters.get_mut(which),
            HarnessStations::Controllers(_) => None,
        }
    }

    /// Whether the station has a connection or is about to have one.
    pub fn is_connected(&self, which: usize) -> bool {
        match self {
            HarnessStations::Controllers(all) => all.get(which).is_some_and(|of| of.state() != ArState::None),
            HarnessStations::Masters(all) => all.get(which).is_some_and(|of| of.state() != ConnectionState::None),
        }
    }

    /// Whether cyclic data are exchanged.
    pub fn exchanges(&self, which: usize) -> bool {
        match self {
            HarnessStations::Controllers(all) => all.get(which).is_some_and(|of| of.state() == ArState::Data),
            HarnessStations::Masters(all) => all.get(which).is_some_and(|of| of.state() == ConnectionState::Exchange),
        }
    }

    /// How many cycles of the present connection have begun.
    pub fn cycles_begun(&self) -> u64 {
        match self {
            HarnessStations::Controllers(all) => all.first().map_or(0, Controller::cycles_sent),
            HarnessStations::Masters(all) => all.first().map_or(0, ProfibusMaster::cycles_sent),
        }
    }

    /// How many cycles of the present connection have ended; on PROFINET this is a frame sent.
    pub fn cycles_done(&self) -> u64 {
        match self {
            HarnessStations::Controllers(all) => all.first().map_or(0, Controller::cycles_sent),
            HarnessStations::Masters(all) => all.first().map_or(0, ProfibusMaster::cycles_done),
        }
    }

    /// What the masters measured on their bus; `None` on PROFINET.
    pub fn bus_statistics(&self) -> Option<BusStatistics> {
        match self {
            HarnessStations::Controllers(_) => None,
            HarnessStations::Masters(all) => {
                let mut statistics = BusStatistics::default();
                all.iter().for_each(|master| statistics.merge(master.statistics()));
                Some(statistics)
            }
        }
    }

    /// The cyclic outputs of the first station.
    pub fn outputs_mut(&mut self) -> Option<&mut CyclicOutputs> {
        match self {
            HarnessStations::Controllers(all) => all.first_mut().map(Controller::outputs_mut),
            HarnessStations::Masters(all) => all.first_mut().map(ProfibusMaster::outputs_mut),
        }
    }

    /// The addresses of all stations.
    pub fn addresses(&self) -> Vec<Address> {
        match self {
            HarnessStations::Controllers(all) => all.iter().map(|of| Address::Mac(of.settings().mac)).collect(),
            HarnessStations::Masters(all) => all.iter().map(|of| Address::Fdl(of.settings().address)).collect(),
        }
    }

    /// The controllers; empty on PROFIBUS.
    pub fn controllers_mut(&mut self) -> &mut [Controller] {
        match self {
            HarnessStations::Controllers(all) => all,
            HarnessStations::Masters(_) => &mut [],
        }
    }

    /// The masters; empty on PROFINET.
    pub fn masters_mut(&mut self) -> &mut [ProfibusMaster] {
        match self {
            HarnessStations::Masters(all) => all,
            HarnessStations::Controllers(_) => &mut [],
        }
    }

    /// Calls `work` with each station.
    pub fn with_each(&mut self, mut work: impl FnMut(&mut dyn Station)) {
        match self {
            HarnessStations::Controllers(all) => all.iter_mut().for_each(|station| work(station)),
            HarnessStations::Masters(all) => all.iter_mut().for_each(|station| work(station)),
        }
    }

    /// Calls `work` with all stations, the device between the first and the second.
    pub fn with_device<R>(&mut self, device: &mut dyn Station, work: impl FnOnce(&mut [&mut dyn Station]) -> R) -> R {
        match self {
            HarnessStations::Controllers(all) => match all.as_mut_slice() {
                [first] => work(&mut [first, device]),
                [first, second] => work(&mut [first, device, second]),
                _ => work(&mut [device]),
            },
            HarnessStations::Masters(all) => match all.as_mut_slice() {
                [first] => work(&mut [first, device]),
                [first, second] => work(&mut [first, device, second]),
                _ => work(&mut [device]),
            },
        }
    }

    /// The next time at which one of them has something to do.
    pub fn deadline(&self) -> Option<Time> {
        match self {
            HarnessStations::Controllers(all) => all.iter().filter_map(Station::deadline).min(),
            HarnessStations::Masters(all) => all.iter().filter_map(Station::deadline).min(),
        }
    }
}

/// The sender address in a frame, on the bus of the address `of`.
pub fn sender(frame: &[u8], of: Address) -> Option<Address> {
    match of {
        Address::Mac(_) => frame.get(6..12)?.try_into().ok().map(|mac| Address::Mac(Mac(mac))),
        Address::Fdl(_) => {
            let at = match frame.first()? {
                0x68 => 5,
                0x10 | 0xA2 | 0xDC => 2,
                _ => return None,
            };
            frame.get(at).map(|sender| Address::Fdl(sender & 0x7F))
        }
    }
}
