//! The description of a slave without a manual, made of its GSD: the `device.yaml` with which the suite for any DP slave runs on it, and
//! that for any DP encoder if it is one.
//!
//! Source: PROFIBUS Guideline 2.122, "Specification for PROFIBUS Device Description and Device Integration, Volume 1: GSD".

use super::encoder::GsdEncoder;
use super::encoder_text::EncoderText;
use super::model::{Gsd, GsdModule};
use plain_text::hex;
use std::fmt::Write;
use wire::profibus::cfg::{Identifier, io_lengths};
use wire::profibus::diag::SlaveDiag;

/// A slave as its GSD describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DescribedSlave {
    /// The description, with the keys of `device.yaml`.
    pub text: String,
    /// The modules of the description that the slave has; the others stand for features that no GSD shows.
    pub claimed: Vec<&'static str>,
    /// Whether it is an encoder with the encoder profile 3.062, for which the suite for any DP encoder is, too.
    pub is_encoder: bool,
}

/// Why a GSD describes no slave that can be tested.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DescribeError {
    /// There is no module with inputs or outputs.
    #[error("the GSD has no module with inputs or outputs")]
    NoModule,
    /// There are several modules, and which the slave has is not known.
    #[error("the GSD has several modules ({0}); name that of the slave under `gsd_module`")]
    SeveralModules(String),
    /// There is no module of the name.
    #[error("the GSD has no module of this name with inputs or outputs; it has {0}")]
    OtherModules(String),
}

/// The bytes of DP-V1 at the begin of the user bytes.
const DPV1: usize = 3;
/// Features whose behaviour no GSD describes: their modules are those of the plain slave, and no slave claims them unseen.
const UNSEEN: [&str; 13] = [
    "mirror",
    "freeze_mode",
    "sync_mode",
    "fail_safe",
    "plain_diagnosis",
    "ms1",
    "ms2",
    "im_class_2",
    "process_alarm",
    "diagnosis_alarm",
    "pull_plug_alarm",
    "alarm_sequence",
    "alarm_access_point",
];

/// Describes a slave by its GSD, with the module of this name, or with its only one.
pub fn describe(gsd: &Gsd, wanted: Option<&str>) -> Result<DescribedSlave, DescribeError> {
    let lengths = |module: &GsdModule| {
        let sums = io_lengths(&Identifier::parse_all(&module.cfg).ok()?);
        (sums.inputs + sums.outputs > 0).then_some(sums)
    };
    let is_wanted = |module: &&GsdModule| wanted.is_none_or(|name| module.name == name);
    let usable = gsd.modules.iter().filter(is_wanted).filter_map(|module| Some((module, lengths(module)?)));
    let names = || gsd.modules.iter().map(|module| module.name.as_str()).collect::<Vec<_>>().join(", ");
    let (module, sums) = match usable.collect::<Vec<_>>().as_slice() {
        [only] => *only,
        [] if wanted.is_some() => return Err(DescribeError::OtherModules(names())),
        [] => return Err(DescribeError::NoModule),
        _ => return Err(DescribeError::SeveralModules(names())),
    };
    let octets = gsd.default_octets(module);
    let encoder = GsdEncoder::of(gsd, module);
    let dpv1 = encoder.as_ref().map_or(DPV1, |of| of.places.operating.min(DPV1));
    let dpv1 = if octets.len() < DPV1 || dpv1 < DPV1 { 0 } else { DPV1 };
    let parts = encoder.as_ref().map(|of| EncoderText::of(of, gsd, dpv1));
    let mut text = String::new();
    let longest = gsd.max_diagnosis.unwrap_or(SlaveDiag::LONGEST).max(SlaveDiag::HEAD);
    // Writing into a String cannot fail.
    let _ = writeln!(
        text,
        "device: dp-slave\nbus: profibus\ntitle: \"{}\"\nidentity: {{ ident: 0x{:04X} }}\naddress: 5\nvariants: [plain]\n\
         timing: {{ reaction: 100ms, start: 5s, power_up: 5s, save: 2s }}\nconstants: {{ ident: 0x{:04X}, freeze: {}, sync: {}, \
         input_octets: {}, output_octets: {}, longest_diagnosis: {longest}, slot_of_the_event: 1, slot_of_the_fault: 2{} }}",
        plain(&gsd.model),
        gsd.ident,
        gsd.ident,
        u8::from(gsd.freeze),
        u8::from(gsd.sync),
        sums.inputs,
        sums.outputs,
        parts.as_ref().map(|of| format!(", {}", of.constants)).unwrap_or_default()
    );
    text.push_str(
        "signals:\n  given: { from: controller, width: 32 }\n  mirrored: { from: device, width: 32 }\n\
         \x20 count: { from: device, width: 16 }\n",
    );
    let of_encoder = encoder.as_ref().and_then(|of| EncoderText::signals_of(of, module));
    let (outputs, inputs) = match of_encoder {
        Some((outputs, inputs)) => (outputs.to_owned(), inputs.to_owned()),
        None => (
            signals(&mut text, "controller", "output", sums.outputs),
            signals(&mut text, "device", "input", sums.inputs),
        ),
    };
    if let Some(parts) = &parts {
        text.push_str(&parts.signals);
    }
    text.push_str("modules:\n");
    let fixes = parts.as_ref().map(|of| format!(", fixes: {{ {} }}", of.fixes(gsd, module))).unwrap_or_default();
    let own = format!(
        "cfg: \"{}\", octets: {{ out: {}, in: {} }}, outputs: [{outputs}], inputs: [{inputs}]{fixes}",
        hex(&module.cfg),
        sums.outputs,
        sums.inputs
    );
    let features = [
        ("data", true),
        ("address_service", gsd.set_slave_address),
        ("watchdog_1ms", gsd.watchdog_1ms),
        ("identification", gsd.identification),
    ];
    for (name, _) in features {
        let _ = writeln!(text, "  {name}: {{ {own} }}");
    }
    for name in UNSEEN {
        let _ = writeln!(
            text,
            "  {name}: {{ cfg: \"B3 D0\", octets: {{ out: 4, in: 6 }}, outputs: [given], inputs: [mirrored, count], \
             from_source: invented }}"
        );
    }
    text.push_str(
        "  short: { cfg: \"B3\", octets: { out: 4, in: 4 }, outputs: [given], inputs: [mirrored], from_source: invented }\n",
    );
    match &parts {
        Some(parts) => text.push_str(&(parts.modules.clone() + &parts.set_prm)),
        None => user_octets(&mut text, &octets, dpv1),
    }
    let lengths: Vec<String> = (SlaveDiag::HEAD..=longest).map(|length| length.to_string()).collect();
    let _ = writeln!(text, "diagnosis:\n  octets: [{}]", lengths.join(", "));
    let flash = parts.as_ref().map_or("", |_| ", flash: the checksum of the stored data is wrong");
    let stand = format!(
        "stand: {{ faults: {{ passing: a fault that comes and goes, standing: a fault before data exchange, \
         unusable: no valid data, \
         event: an event of the process, pulled: a module that is pulled{flash} }} }}\n"
    );
    if let Some(parts) = &parts {
        text.push_str(parts.diagnosis);
        text.push_str(parts.keys);
    }
    text.push_str(&stand);
    let of_slave = features.into_iter().filter(|(_, has)| *has).map(|(name, _)| name);
    let more = encoder.iter().flat_map(|of| of.claimed(gsd));
    Ok(DescribedSlave { text, claimed: of_slave.chain(more).collect(), is_encoder: parts.is_some() })
}

/// Declares a signal for each byte, and lists them.
fn signals(text: &mut String, from: &str, name: &str, octets: usize) -> String {
    let names: Vec<String> = (0..octets).map(|at| format!("{name}_{at}")).collect();
    for name in &names {
        let _ = writeln!(text, "  {name}: {{ from: {from}, width: 8 }}");
    }
    names.join(", ")
}

/// The user bytes of Set_Prm, each with its default.
fn user_octets(text: &mut String, octets: &[u8], dpv1: usize) {
    let (dpv1, user) = octets.split_at(dpv1);
    let _ = write!(text, "set_prm: {{ octets: {}, ", user.len());
    if !dpv1.is_empty() {
        let _ = write!(text, "dpv1: \"{}\", ", hex(dpv1));
    }
    let fields: Vec<String> = user
        .iter()
        .enumerate()
        .map(|(at, default)| format!("byte_{at}: {{ octet: {at}, default: {default} }}"))
        .collect();
    let _ = writeln!(text, "fields: {{ {} }} }}", fields.join(", "));
}

/// A name of a vendor without what YAML would read as something else.
fn plain(name: &str) -> String {
    name.chars()
        .filter(|letter| letter.is_ascii_graphic() || *letter == ' ')
        .filter(|letter| !"\"\\".contains(*letter))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLAVE: &str = "#Profibus_DP\nModel_Name=\"Pump\"\nIdent_Number=0x1234\nFreeze_Mode_supp=1\nSet_Slave_Add_supp=1\n\
        Max_Diag_Data_Len=8\nUser_Prm_Data_Len=5\nUser_Prm_Data=0x80,0,0,7,9\nModule=\"One\" 0x21\nEndModule\n";

    fn described(text: &str, wanted: Option<&str>) -> Result<DescribedSlave, DescribeError> {
        describe(&super::super::read(text).expect("a GSD"), wanted)
    }

    #[test]
    fn what_the_gsd_says_is_in_the_description() {
        let slave = described(SLAVE, None).expect("it has one module");
        assert_eq!(slave.claimed, ["data", "address_service"]);
        for part in [
            "identity: { ident: 0x1234 }",
            "freeze: 1, sync: 0, input_octets: 0, output_octets: 2, longest_diagnosis: 8",
            "  data: { cfg: \"21\", octets: { out: 2, in: 0 }, outputs: [output_0, output_1], inputs: [] }\n",
            "set_prm: { octets: 2, dpv1: \"80 00 00\", fields: { byte_0: { octet: 0, default: 7 }, byte_1: { octet: 1, default: 9 } } }",
            "diagnosis:\n  octets: [6, 7, 8]\n",
        ] {
            assert!(slave.text.contains(part), "{part}\n{}", slave.text);
        }
    }

    #[test]
    fn one_of_several_modules_is_chosen_by_its_name() {
        let two = format!("{SLAVE}Module=\"Two\" 0x11\nEndModule\n");
        assert_eq!(described(&two, None), Err(DescribeError::SeveralModules("One, Two".into())));
        assert_eq!(described(&two, Some("Three")), Err(DescribeError::OtherModules("One, Two".into())));
        let slave = described(&two, Some("Two")).expect("it has this module");
        assert!(slave.text.contains("data: { cfg: \"11\", octets: { out: 0, in: 2 }"), "{}", slave.text);
        assert_eq!(described("#Profibus_DP\nIdent_Number=1\n", None), Err(DescribeError::NoModule));
    }
}
