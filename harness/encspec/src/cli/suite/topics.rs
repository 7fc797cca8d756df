//! The cases of a new suite: the common suites that any device on its bus can use, and the requirements that they cover.

use std::fmt::Write as _;

/// A file of the suite: its name and its text.
pub(super) type NewFile = (String, String);

/// The manual from which the requirements on any PROFINET IO device are taken.
const ANY_DEVICE: &str = suite_yaml::ANY_DEVICE;

/// What the common suites of PROFINET have to know of a device.
pub(super) struct ConnectedModule<'a> {
    /// The module that they connect.
    pub module: &'a str,
    /// Its submodule with the longest data.
    pub longest: &'a str,
    /// Whether it has outputs and inputs.
    pub has_both: bool,
    /// Whether I&M1 can be written.
    pub has_im1: bool,
}

/// Cases and the requirements that they cover.
type CoveredCases = Vec<(&'static str, Vec<String>)>;
/// Cases that are left out, and why.
type OmittedCases = Vec<(&'static str, &'static str)>;

/// A common suite as the new suite uses it.
struct UsedSuite {
    name: &'static str,
    defaults: String,
    give: String,
    covers: CoveredCases,
    omit: OmittedCases,
}

impl UsedSuite {
    fn file(&self) -> NewFile {
        let mut out = format!("suite: {0}\nuse: {0}\n", self.name);
        if !self.defaults.is_empty() {
            // Writing into a String cannot fail.
            let _ = writeln!(out, "defaults: {{ start: {} }}", self.defaults);
        }
        let _ = writeln!(out, "give: {{ {} }}\ncovers:", self.give);
        for (case, ids) in &self.covers {
            let _ = writeln!(out, "  {case}: [{}]", ids.join(", "));
        }
        if self.omit.is_empty() {
            out.push_str("omit: {}\n");
        } else {
            out.push_str("omit:                                        # Decide: give what is missing, and cover it\n");
            for (case, why) in &self.omit {
                let _ = writeln!(out, "  {case}: {why}");
            }
        }
        (format!("{}.yaml", self.name), out)
    }
}

/// The cases that are used, and those with a reason to leave them out.
fn split(
    cases: impl IntoIterator<Item = (&'static str, Vec<String>, Option<&'static str>)>,
) -> (CoveredCases, OmittedCases) {
    let (mut covers, mut omit) = (Vec::new(), Vec::new());
    for (case, ids, why) in cases {
        match why {
            None => covers.push((case, ids)),
            Some(why) => omit.push((case, why)),
        }
    }
    (covers, omit)
}

const NO_OUTPUTS: &str = "the module has no outputs and inputs at once";
const NO_MIRROR: &str = "a GSDML does not say which inputs show the outputs";

/// The topics and requirements of a device on PROFINET.
pub(super) fn profinet(of: &ConnectedModule<'_>) -> Result<Vec<NewFile>, String> {
    let ConnectedModule { module, longest, has_both, has_im1 } = *of;
    let start = format!("{{ module: {module} }}");
    let no_outputs = (!has_both).then_some(NO_OUTPUTS);
    let ids = |topic: &str, numbers: &[u32]| -> Vec<String> {
        numbers.iter().map(|number| format!("PNIO-{topic}-{number:03}")).collect()
    };
    let one = |topic: &str, cases: &[&'static str]| -> CoveredCases {
        cases.iter().zip(1..).map(|(case, number)| (*case, ids(topic, &[number]))).collect()
    };
    let mut list = Vec::new();
    let mut discovery: CoveredCases = vec![("found-by-its-name", ids("DSC", &[1, 2]))];
    let others = [
        "reports-its-identity",
        "takes-a-name",
        "refuses-bad-names",
        "keeps-its-name",
        "forgets-a-temporary-name",
        "takes-an-address",
        "flashes-on-request",
        "resets-its-communication",
        "reports-its-neighbours",
    ];
    discovery.extend(others.iter().zip(3..).map(|(case, number)| (*case, ids("DSC", &[number]))));
    list.push(UsedSuite {
        name: "protocol-discovery",
        defaults: "none".to_owned(),
        give: format!("vendor: =vendor, module: {module}"),
        covers: discovery,
        omit: Vec::new(),
    });
    let (covers, omit) = split([
        ("starts-up", ids("CON", &[1]), None),
        ("either-byte-order", ids("CON", &[5]), None),
        ("refuses-what-is-not-plugged", ids("CON", &[2]), None),
        ("belongs-to-its-first-controller", ids("CON", &[4]), None),
        ("refuses-other-lengths", ids("CON", &[3]), no_outputs),
    ]);
    list.push(UsedSuite {
        name: "protocol-connect",
        defaults: String::new(),
        give: format!("module: {module}, difference: module_diff.{longest}"),
        covers,
        omit,
    });
    let (covers, omit) = split([
        ("bad-until-ready", ids("CYC", &[1]), None),
        ("keeps-the-cycle", ids("CYC", &[3]), None),
        ("a-short-gap-is-tolerated", ids("CYC", &[7]), None),
        ("a-long-gap-ends-the-connection", ids("CYC", &[8]), None),
        ("outputs-arrive", Vec::new(), Some(NO_MIRROR)),
        ("bad-outputs-are-not-taken", Vec::new(), Some(NO_MIRROR)),
        ("outputs-of-others-are-not-taken", Vec::new(), Some(NO_MIRROR)),
        ("takes-the-outputs", ids("CYC", &[2]), no_outputs),
    ]);
    list.push(UsedSuite {
        name: "protocol-cyclic",
        defaults: String::new(),
        give: format!("module: {module}"),
        covers,
        omit,
    });
    list.push(UsedSuite {
        name: "protocol-errors",
        defaults: start.clone(),
        give: "vendor: =vendor".to_owned(),
        covers: one("ERR", &["wrong-index", "wrong-place", "wrong-access"]),
        omit: Vec::new(),
    });
    let records = [
        "im0-is-readable",
        "im1-keeps-what-is-written",
        "cut-to-the-requested-length",
        "reports-what-is-plugged",
        "unknown-index-is-refused",
        "unknown-index-is-not-written",
        "unknown-place-is-refused",
        "read-only-record-is-not-written",
    ];
    let no_im1 = (!has_im1).then_some("the GSDML lists no I&M1 that can be written");
    let without = |case: &str| no_im1.filter(|_| case == "im1-keeps-what-is-written");
    let (covers, omit) = split(one("REC", &records).into_iter().map(|(case, ids)| (case, ids, without(case))));
    list.push(UsedSuite {
        name: "protocol-records",
        defaults: start,
        give: "vendor: =vendor".to_owned(),
        covers,
        omit,
    });
    list.push(UsedSuite {
        name: "protocol-release",
        defaults: String::new(),
        give: format!("module: {module}"),
        covers: one("REL", &["released-and-connected-again", "aborted-and-connected-again"]),
        omit: Vec::new(),
    });
    list.push(UsedSuite {
        name: "protocol-robustness",
        defaults: String::new(),
        give: format!("vendor: =vendor, module: {module}"),
        covers: one("ROB", &["damaged-cyclic-frame", "damaged-call", "damaged-dcp", "alarm-without-a-connection"]),
        omit: Vec::new(),
    });
    let covered: Vec<&String> = list.iter().flat_map(|used| &used.covers).flat_map(|(_, ids)| ids).collect();
    let requirements = requirements_of_any_device(&|id| covered.iter().any(|known| *known == id))?;
    let mut files: Vec<NewFile> = list.iter().map(UsedSuite::file).collect();
    files.push(("requirements-protocol.yaml".to_owned(), requirements));
    Ok(files)
}

/// The requirements on any PROFINET IO device that are wanted, as the built-in suite has them.
fn requirements_of_any_device(is_wanted: &dyn Fn(&str) -> bool) -> Result<String, String> {
    let sources = suites::sources();
    let path = format!("{ANY_DEVICE}/requirements.yaml");
    let text = sources.files().find(|(known, _)| *known == path).map(|(_, text)| text.to_owned());
    let text = text.ok_or("the requirements on any PROFINET IO device are not built in")?;
    let (head, entries) = text.split_once("requirements:\n").ok_or("the built-in requirements cannot be read")?;
    let mut out = head.lines().filter(|line| !line.starts_with('#')).fold(String::new(), |out, line| out + line + "\n");
    out.insert_str(0, "# Requirements on every PROFINET IO device. Decide: add what the manual says, in files `requirements-TOPIC.yaml`.\n");
    out.push_str("requirements:\n");
    for entry in entries.split("  - id: ").skip(1) {
        let id = entry.lines().next().unwrap_or_default().trim();
        if is_wanted(id) {
            // Writing into a String cannot fail.
            let _ = writeln!(out, "  - id: {}", entry.trim_end());
        }
    }
    Ok(out)
}

/// The topics and requirements of a slave: `module` is what they connect, `rates` are bits per second.
pub(super) fn profibus(module: &str, rates: &[u32], ident: u16) -> Vec<NewFile> {
    let rates = rates.iter().map(|rate| format!("    - {{ rate: {rate} }}\n")).collect::<String>();
    let has_rates = !rates.is_empty();
    let mut used = format!("suite: slave-start-up\nuse: slave-start-up\ngive: {{ module: {module} }}\n{SLAVE_COVERS}");
    if has_rates {
        used.push_str("  rate-of-the-bus: [DP-PRM-005]\n");
    }
    // Writing into a String cannot fail.
    let _ = write!(
        used,
        "rows:\n  refused-parameters:\n    - {{ row: ident, change: {{ ident: 0x{:04X} }}, covers: [DP-PRM-001] }}\n",
        ident ^ 1
    );
    if has_rates {
        let _ = write!(used, "  rate-of-the-bus:\n{rates}");
    }
    used.push_str(SLAVE_OMITS);
    if !has_rates {
        used.push_str("  rate-of-the-bus: the GSD names no rate that encspec knows\n");
    }
    let requirements: Vec<&str> = SLAVE_REQUIREMENTS
        .split_inclusive("level: should\n")
        .filter(|entry| has_rates || !entry.contains("DP-PRM-005"))
        .collect();
    vec![("slave-start-up.yaml".to_owned(), used), ("requirements-protocol.yaml".to_owned(), requirements.concat())]
}

const SLAVE_COVERS: &str = "\
covers:
  watchdog: [DP-PRM-002]
  pause-shorter-than-the-watchdog: [DP-PRM-003]
  without-a-watchdog: [DP-PRM-004]
";

const SLAVE_OMITS: &str = "\
omit:                                        # Decide: give what is missing, and cover it
  other-configuration: a GSD does not say which configurations the slave refuses
  outputs-of-another-length: device.yaml does not declare the role `position` yet
  outputs-missing: a GSD does not say which outputs are no request
  second-master: device.yaml does not declare the role `position` yet
";

const SLAVE_REQUIREMENTS: &str = r#"# Requirements on every PROFIBUS slave. Decide: add what the manual says, in files `requirements-TOPIC.yaml`.
source: profile
channel: startup
requirements:
  - id: DP-PRM-001
    cites: "IEC 61158-6-3, Set_Prm, Ident_Number"
    statement: "A Set_Prm with the ident number of another type of device sets Prm_Fault, and the next valid one clears it."
    level: should
  - id: DP-PRM-002
    cites: "IEC 61158-6-3, Set_Prm, WD_Fact_1 and WD_Fact_2"
    statement: "Without a telegram of its master for the watchdog time the slave leaves data exchange and requests parameters."
    level: should
  - id: DP-PRM-003
    cites: "IEC 61158-6-3, Set_Prm, WD_Fact_1 and WD_Fact_2"
    statement: "A pause that is shorter than the watchdog time has no effect."
    level: should
  - id: DP-PRM-004
    cites: "IEC 61158-6-3, Set_Prm, WD_On"
    statement: "Without a watchdog data exchange continues after a pause of any length."
    level: should
  - id: DP-PRM-005
    cites: "the GSD of the device, baud rates"
    statement: "The slave exchanges data at each rate that its GSD names, without a setting."
    level: should
"#;
