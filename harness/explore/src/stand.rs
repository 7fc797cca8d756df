//! What a stand does in a sequence: shaft, faults, supply, buttons, power.

use crate::draw::Draw;
use suite::device::DeviceDescription;

/// The names of a stand with their values.
pub(crate) struct StandChoices {
    pub has_shaft: bool,
    pub faults: Vec<String>,
    pub buttons: Vec<String>,
    /// Voltage and temperature: the name, what each trial finds, the lowest and the highest value.
    pub supplies: Vec<(&'static str, f64, [f64; 2])>,
}

/// How far supply and temperature go beyond a printed limit, or from what a trial finds where none is printed, in percent.
const BEYOND: f64 = 0.1;

impl StandChoices {
    pub fn of(device: &DeviceDescription) -> StandChoices {
        let names = &device.stand;
        let range = |name: &'static str, home: Option<f64>, [low, high]: [Option<f64>; 2]| {
            let home = home?;
            let (low, high) = (low.unwrap_or(home), high.unwrap_or(home));
            Some((name, home, [(low - low.abs() * BEYOND).floor(), (high + high.abs() * BEYOND).ceil()]))
        };
        let supplies = [
            range("supply.voltage", names.voltage, names.permitted_voltage),
            range("supply.temperature", names.temperature, names.permitted_temperature),
        ];
        StandChoices {
            has_shaft: device.signals.iter().any(|signal| signal.position_in.is_some()),
            faults: names.faults.iter().map(|(name, _)| format!("fault.{name}")).collect(),
            buttons: names.buttons.iter().map(|(name, _)| format!("button.{name}")).collect(),
            supplies: supplies.into_iter().flatten().collect(),
        }
    }
}

/// A speed in revolutions per minute.
pub(crate) fn speed(draw: &mut Draw) -> i64 {
    let size = *draw.one(&[0, 1, 10, 60, 300, 1000, 3000, 6000, 9500]).unwrap_or(&0);
    if draw.chance(50) { size } else { -size }
}
