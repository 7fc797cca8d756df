//! Two small manuals, one for each bus, with common suites. Their files are in `tests/fixtures`.

use encspec::suite_yaml::Sources;

/// `device.yaml` of the PROFINET device.
pub const DEVICE: &str = include_str!("../fixtures/small_manual/probe/device.yaml");
/// The cases and rules of the PROFINET device.
pub const TOPIC: &str = include_str!("../fixtures/small_manual/probe/topic.yaml");

/// A manual with every kind of definition for PROFINET, a common suite of each kind, and the bugs of another manual.
const PROFINET: [(&str, &str); 10] = [
    ("probe/device.yaml", DEVICE),
    ("probe/topic.yaml", TOPIC),
    ("probe/procedures.yaml", include_str!("../fixtures/small_manual/probe/procedures.yaml")),
    ("probe/requirements.yaml", include_str!("../fixtures/small_manual/probe/requirements.yaml")),
    ("probe/bugs.yaml", include_str!("../fixtures/small_manual/probe/bugs.yaml")),
    ("probe/shared.yaml", include_str!("../fixtures/small_manual/probe/shared.yaml")),
    ("probe/wide.yaml", include_str!("../fixtures/small_manual/probe/wide.yaml")),
    ("common/shared.yaml", include_str!("../fixtures/small_manual/common/shared.yaml")),
    ("common/wide.yaml", include_str!("../fixtures/small_manual/common/wide.yaml")),
    ("other/bugs.yaml", include_str!("../fixtures/small_manual/other/bugs.yaml")),
];

/// A manual with the definitions that only PROFIBUS has.
const PROFIBUS: [(&str, &str); 3] = [
    ("slave/device.yaml", include_str!("../fixtures/small_slave/slave/device.yaml")),
    ("slave/requirements.yaml", include_str!("../fixtures/small_slave/slave/requirements.yaml")),
    ("slave/topic.yaml", include_str!("../fixtures/small_slave/slave/topic.yaml")),
];

fn sources(files: &[(&str, &'static str)]) -> Sources {
    files.iter().fold(Sources::none(), |sources, (path, text)| sources.with(path, *text))
}

/// The small manual on PROFINET.
pub fn profinet() -> Sources {
    sources(&PROFINET)
}

/// The small manual on PROFIBUS.
pub fn profibus() -> Sources {
    sources(&PROFIBUS)
}

/// The small manual with another file at `path` (below `suites`). A `device.yaml` is loaded with the requirements only.
pub fn with(path: &str, text: String) -> Sources {
    let of_bus = if path.starts_with("slave/") { &PROFIBUS[..] } else { &PROFINET[..] };
    let beside: Vec<_> = match path.strip_suffix("/device.yaml") {
        Some(folder) => {
            of_bus.iter().filter(|(name, _)| *name == format!("{folder}/requirements.yaml")).copied().collect()
        }
        None => of_bus.to_vec(),
    };
    sources(&beside).with(path, text)
}
