//! The bugs of a reference AMT58, and of the DP encoder without a manual that is built like it, by topic.

mod addresses;
mod configuration;
pub mod diagnosis;
mod leds;
pub mod offset_state;
mod parameters;
mod preset_state;
mod presets;
mod red_zone;
mod scaling;
pub mod values;

use super::{Group, presets as shared_presets};
use crate::needs::Need;
use reference_devices::manuals::{DATALOGIC_AMT58, DP_ENCODER};

const AMT58: &[Need] = &[Need::OfEither(&DATALOGIC_AMT58, &DP_ENCODER)];

/// The groups, by topic.
pub static GROUPS: &[Group] = &[
    Group { needs: AMT58, deviations: addresses::BUGS },
    Group { needs: AMT58, deviations: configuration::BUGS },
    Group { needs: AMT58, deviations: diagnosis::BUGS },
    Group { needs: AMT58, deviations: leds::BUGS },
    Group { needs: AMT58, deviations: parameters::BUGS },
    Group { needs: AMT58, deviations: presets::BUGS },
    Group { needs: AMT58, deviations: shared_presets::ANYHOW },
    Group { needs: AMT58, deviations: red_zone::BUGS },
    Group { needs: AMT58, deviations: scaling::BUGS },
    Group { needs: AMT58, deviations: values::BUGS },
];
