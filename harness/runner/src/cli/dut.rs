//! What `--dut` and `--device` say: which devices are tested.

use super::live::Asked;
use crate::bench_file::{Claim, LinkSpec};
use crate::engine::{DutKind, DutSpec, Nobody};
use crate::suite::expr::nearest;
use crate::suite::model::Manual;
use std::path::{Path, PathBuf};

/// The devices that a command line names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Devices {
    /// Devices of this process.
    pub here: Vec<DutSpec>,
    /// Devices outside of it.
    pub live: Vec<Asked>,
}

/// The devices that `duts` (`--dut`) and `device` (`--device`) name; the reference device of every manual and variant where
/// nothing is said. A manual without a variant stands for all of its variants.
///
/// Fails with one sentence if something is unknown, or if it is not said what a device is.
pub fn devices(duts: &[String], device: Option<&str>, bugs: &[String], manuals: &[Manual]) -> Result<Devices, String> {
    let known: Vec<Known<'_>> =
        manuals.iter().map(|of| (of.device.name.as_str(), of.device.variants.as_slice())).collect();
    let model = DutKind::Model { bugs: bugs.to_vec() };
    let claimed = device.map(|device| claim(device, &known)).transpose()?;
    let mut devices = Devices::default();
    let mut add = |kind: &DutKind, who: &[(&str, &str)]| {
        for (manual, variant) in who {
            let spec = DutSpec { manual: (*manual).to_owned(), variant: (*variant).to_owned(), kind: kind.clone() };
            if !devices.here.contains(&spec) {
                devices.here.push(spec);
            }
        }
    };
    if duts.is_empty() {
        let every = || known.iter().flat_map(|(manual, variants)| variants.iter().map(|of| (*manual, of.as_str())));
        add(&model, &claimed.clone().unwrap_or_else(|| every().collect()));
    }
    for dut in duts {
        match (dut.split_once(':'), &claimed) {
            (Some(("model", what)), None) => add(&model, &claim(what, &known)?),
            (Some(("model", _)), Some(_)) => {
                return Err(format!("`--dut {dut}` says already what the device is: leave `--device` out"));
            }
            (Some(("null", what)), claimed) => {
                let kind = DutKind::Nobody(nobody(what)?);
                let Some(claimed) = claimed else {
                    return Err(format!("`--dut {dut}` needs `--device MANUAL[/VARIANT]`: what it claims to be"));
                };
                add(&kind, claimed);
            }
            (Some((kind, address)), claimed) if LinkSpec::of(kind, address).is_some() => {
                let Some(link) = LinkSpec::of(kind, address) else { return Err(unknown(dut)) };
                let claim = match claimed.as_deref() {
                    Some([(manual, variant)]) => Claim { manual: (*manual).to_owned(), variant: (*variant).to_owned() },
                    Some([(manual, _), ..]) => {
                        return Err(format!(
                            "{manual} has several variants: say which one `--dut {dut}` is, MANUAL/VARIANT"
                        ));
                    }
                    _ => return Err(format!("`--dut {dut}` needs `--device MANUAL/VARIANT`: what it claims to be")),
                };
                devices.live.push(Asked::Link(link, claim));
            }
            _ if Path::new(dut).extension().is_some_and(|end| end == "yaml" || end == "yml") => {
                if claimed.is_some() {
                    return Err(format!("the bench file {dut} says what the device is: leave `--device` out"));
                }
                devices.live.push(Asked::File(PathBuf::from(dut)));
            }
            _ => return Err(unknown(dut)),
        }
    }
    if !bugs.is_empty() && (!devices.live.is_empty() || devices.here.iter().any(|spec| spec.bugs().is_empty())) {
        return Err("only reference devices (`--dut model:...`) can be told to have a bug".into());
    }
    Ok(devices)
}

/// A manual and its variants.
type Known<'a> = (&'a str, &'a [String]);

/// The manual and the variants that `MANUAL[/VARIANT]` names.
pub(super) fn claim<'a>(what: &str, known: &[Known<'a>]) -> Result<Vec<(&'a str, &'a str)>, String> {
    let (manual, variant) = what.split_once('/').map_or((what, None), |(manual, variant)| (manual, Some(variant)));
    let Some((manual, variants)) = known.iter().find(|(known, _)| *known == manual) else {
        return Err(suggest("device", manual, known.iter().map(|(manual, _)| *manual)));
    };
    let every: Vec<&str> = variants.iter().map(String::as_str).collect();
    match variant {
        None => Ok(every.into_iter().map(|variant| (*manual, variant)).collect()),
        Some(wanted) => match every.iter().find(|variant| **variant == wanted) {
            Some(variant) => Ok(vec![(*manual, *variant)]),
            None => Err(suggest(&format!("variant of {manual}"), wanted, every)),
        },
    }
}

fn nobody(what: &str) -> Result<Nobody, String> {
    what.parse().map_err(|_| suggest("kind of null device", what, Nobody::WORDS))
}

fn unknown(dut: &str) -> String {
    let kinds = ["model:", "null:", "nic:", "serial:", "socket:"];
    let kind = dut.split_once(':').map_or(dut, |(kind, _)| kind);
    let meant =
        nearest(&format!("{kind}:"), kinds).map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"));
    format!(
        "`{dut}` is no device under test; write model:MANUAL[/VARIANT], nic:IF, socket:ADDRESS, serial:TTY, a bench file or null:KIND{meant}"
    )
}

/// A sentence about an unknown word, with the nearest one or all of them.
pub(super) fn suggest<'a>(what: &str, word: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    match nearest(word, known.clone()) {
        Some(meant) => format!("unknown {what} `{word}`; did you mean `{meant}`?"),
        None => format!("unknown {what} `{word}`; there are {}", known.into_iter().collect::<Vec<_>>().join(", ")),
    }
}
