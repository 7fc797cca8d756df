//! The signals of one connection: their offsets, names and values.

use super::super::unsigned;
use super::series::Series;
use judge::image::ConnectionImage;
use judge::observe::{CyclicStatus, FrameDirection, ObservedAr};
use judge::view::bits;
use report::page::{Lane, LaneShape};
use std::ops::Range;
use suite::device::DeviceDescription;
use wire::profinet::rt::DataStatus;

/// Upper limit of the lanes of one timeline.
const MOST_LANES: usize = 128;

/// The signals of one connection.
#[derive(Debug, Default)]
pub(super) struct SignalLanes {
    list: Vec<SignalLane>,
    data_status: Series,
}

#[derive(Debug)]
struct SignalLane {
    name: String,
    direction: FrameDirection,
    octets: Range<usize>,
    low: u32,
    width: u32,
    signed: bool,
    series: Series,
}

impl SignalLanes {
    /// The signals and bits of the manual.
    pub fn named(device: &DeviceDescription, image: &ConnectionImage) -> SignalLanes {
        let mut list = Vec::new();
        for (index, signal) in device.signals.iter().enumerate() {
            let Some((direction, octets)) = image.octets_of_signal(index) else { continue };
            let mut add = |name: String, low: u32, width: u32, signed: bool| {
                let octets = octets.clone();
                list.push(SignalLane { name, direction, octets, low, width, signed, series: Series::default() });
            };
            if signal.fields.is_empty() {
                add(signal.name.clone(), 0, signal.width, signal.signed);
            }
            for field in &signal.fields {
                add(format!("{}.{}", signal.name, field.name), field.low, field.width, field.signed);
            }
        }
        // Numbers first: readers look for position and speed.
        list.sort_by_key(|signal| signal.width == 1);
        list.truncate(MOST_LANES);
        SignalLanes { list, ..SignalLanes::default() }
    }

    /// The data of the submodules as numbers, if no manual has names for them.
    pub fn by_place(ar: &ObservedAr) -> SignalLanes {
        let mut list = Vec::new();
        for placed in &ar.submodules {
            let areas = [
                ("inputs", &placed.input, FrameDirection::ToController),
                ("outputs", &placed.output, FrameDirection::ToDevice),
            ];
            for (word, area, direction) in areas {
                let Some(octets) = area.clone().filter(|area| (1..=8).contains(&area.len())) else { continue };
                let name = format!("{word} of slot {} subslot 0x{:04X}", placed.slot, placed.subslot);
                let width = octets.len() as u32 * 8;
                list.push(SignalLane {
                    name,
                    direction,
                    octets,
                    low: 0,
                    width,
                    signed: false,
                    series: Series::default(),
                });
            }
        }
        list.truncate(MOST_LANES);
        SignalLanes { list, ..SignalLanes::default() }
    }

    /// Takes in a cyclic frame.
    pub fn sample(&mut self, at: f64, direction: FrameDirection, data: &[u8], status: &CyclicStatus) {
        if let (CyclicStatus::Apdu(apdu), FrameDirection::ToController) = (status, direction) {
            self.data_status.sample(at, f64::from(u8::from(apdu.data_status == DataStatus::NORMAL)));
        }
        for signal in self.list.iter_mut().filter(|signal| signal.direction == direction) {
            if let Some(octets) = data.get(signal.octets.clone()) {
                signal.series.sample(at, number(octets, signal.low, signal.width, signal.signed));
            }
        }
    }

    /// Ends the values: the connection ended.
    pub fn cut(&mut self) {
        self.list.iter_mut().for_each(|signal| signal.series.cut());
        self.data_status.cut();
    }

    /// The lanes of the signals that changed, and a sentence with those that did not.
    pub fn lanes(self) -> (Vec<Lane>, String) {
        let (mut lanes, mut steady) = (Vec::new(), Vec::new());
        if self.data_status.moved() {
            let shape = LaneShape::Bit(self.data_status.into_spans());
            lanes.push(Lane { name: "data status is good".to_owned(), shape });
        }
        for signal in self.list {
            match (signal.series.moved(), signal.series.value()) {
                (true, _) => {
                    let spans = signal.series.into_spans();
                    let shape = if signal.width == 1 { LaneShape::Bit(spans) } else { LaneShape::Line(spans) };
                    lanes.push(Lane { name: signal.name, shape });
                }
                (false, Some(value)) => steady.push(format!("{} = {value}", signal.name)),
                (false, None) => {}
            }
        }
        let steady = if steady.is_empty() { String::new() } else { format!("Constant: {}", steady.join(", ")) };
        (lanes, steady)
    }
}

/// A bit group of a big-endian number.
fn number(octets: &[u8], low: u32, width: u32, signed: bool) -> f64 {
    bits(unsigned(octets), low, width, signed) as f64
}

#[cfg(test)]
mod tests {
    use super::number;
    use rstest::rstest;

    #[rstest]
    #[case(&[0x12, 0x34], 0, 16, false, 4660.0)]
    #[case(&[0x12, 0x34], 4, 4, false, 3.0)]
    #[case(&[0xFF, 0xFE], 0, 16, true, -2.0)]
    #[case(&[0xFF, 0xFE], 0, 16, false, 65534.0)]
    #[case(&[0x80, 0, 0, 0, 0, 0, 0, 1], 63, 1, false, 1.0)]
    fn bits_become_numbers(
        #[case] octets: &[u8],
        #[case] low: u32,
        #[case] width: u32,
        #[case] signed: bool,
        #[case] is: f64,
    ) {
        assert_eq!(number(octets, low, width, signed), is);
    }
}
