//! Parses `--dut` and `--device`: which devices are tested.

use super::CommandError;
use super::live::LiveTarget;
use engine::{DutKind, DutSpec, NullPeer};
use plain_text::nearest;
use results::bench_file::{DeviceClaim, LinkSpec};
use std::path::{Path, PathBuf};
use suite::model::Manual;
use suite_yaml::{Sources, load};

/// The devices that a command line names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Devices {
    /// Reference devices and null devices, which run in this process.
    pub here: Vec<DutSpec>,
    /// Live devices.
    pub live: Vec<LiveTarget>,
    /// Manuals that nothing runs because no device is named and they have no reference device.
    pub without_model: Vec<String>,
}

/// Whether a reference device is built in for a manual.
pub(super) fn has_model(manual: &Manual) -> bool {
    deviations::subject(&manual.device.name).is_ok()
}

/// Fails if a manual has no reference device.
fn check_model(manual: &Manual) -> Result<(), String> {
    if has_model(manual) {
        return Ok(());
    }
    let name = &manual.device.name;
    Err(format!(
        "{name} has no reference device; name a live device with --dut: a bench file, nic:IF, socket:ADDRESS, serial:TTY or app:COMMAND"
    ))
}

/// The devices that `duts` (`--dut`) and `device` (`--device`) name. Without either, the reference devices of every manual and
/// variant. A manual without a variant means all of its variants.
///
/// # Errors
///
/// If a name is unknown, or if `--device` is missing or not allowed.
pub fn devices(
    duts: &[String],
    device: Option<&str>,
    deviations: &[String],
    manuals: &[Manual],
) -> Result<Devices, String> {
    let model = DutKind::Model { deviations: deviations.to_vec() };
    let claimed = device.map(|device| claim(device, manuals)).transpose()?;
    let mut devices = Devices::default();
    let mut add = |kind: &DutKind, claims: &[(&Manual, &str)]| {
        for (manual, variant) in claims {
            let manual = manual.device.name.clone();
            let spec = DutSpec { manual, variant: (*variant).to_owned(), kind: kind.clone() };
            if !devices.here.contains(&spec) {
                devices.here.push(spec);
            }
        }
    };
    let mut without_model = Vec::new();
    match &claimed {
        _ if !duts.is_empty() => {}
        Some(claimed) => {
            claimed.iter().try_for_each(|(manual, _)| check_model(manual))?;
            add(&model, claimed);
        }
        None => {
            let (built, others): (Vec<&Manual>, Vec<&Manual>) = manuals.iter().partition(|manual| has_model(manual));
            without_model.extend(others.iter().map(|manual| manual.device.name.clone()));
            let every = built.iter().flat_map(|of| of.device.variants.iter().map(|variant| (*of, variant.as_str())));
            add(&model, &every.collect::<Vec<_>>());
        }
    }
    for dut in duts {
        match (dut.split_once(':'), &claimed) {
            (Some(("model", what)), None) => {
                let claimed = claim(what, manuals)?;
                claimed.iter().try_for_each(|(manual, _)| check_model(manual))?;
                add(&model, &claimed);
            }
            (Some(("model", _)), Some(_)) => {
                return Err(format!("`--dut {dut}` already says what the device is; remove `--device`"));
            }
            (Some(("null", what)), claimed) => {
                let kind = DutKind::Null(null_device_kind(what)?);
                let Some(claimed) = claimed else {
                    return Err(format!(
                        "`--dut {dut}` needs `--device MANUAL[/VARIANT]`, the device that it claims to be"
                    ));
                };
                if let DutKind::Null(NullPeer::WrongIdentity | NullPeer::DiesAfter(_)) = kind
                    && let Some((manual, _)) = claimed.iter().find(|(manual, _)| !has_model(manual))
                {
                    let name = &manual.device.name;
                    return Err(format!(
                        "`--dut {dut}` is made of a reference device, and {name} has none; use null:absent"
                    ));
                }
                add(&kind, claimed);
            }
            (Some((kind, address)), claimed) if LinkSpec::of(kind, address).is_some() => {
                let Some(link) = LinkSpec::of(kind, address) else { return Err(unknown_dut(dut)) };
                let claim = match claimed.as_deref() {
                    Some([(manual, variant)]) => {
                        DeviceClaim { manual: manual.device.name.clone(), variant: (*variant).to_owned() }
                    }
                    Some([(manual, _), ..]) => {
                        return Err(format!(
                            "{} has several variants; name the one of `--dut {dut}`: `--device {0}/VARIANT`",
                            manual.device.name
                        ));
                    }
                    _ => {
                        return Err(format!(
                            "`--dut {dut}` needs `--device MANUAL/VARIANT`, the device that it claims to be"
                        ));
                    }
                };
                devices.live.push(LiveTarget::Link(link, claim));
            }
            _ if Path::new(dut).extension().is_some_and(|end| end == "yaml" || end == "yml") => {
                if claimed.is_some() {
                    return Err(format!("the bench file {dut} already says what the device is; remove `--device`"));
                }
                devices.live.push(LiveTarget::File(PathBuf::from(dut)));
            }
            _ => return Err(unknown_dut(dut)),
        }
    }
    let has_no_deviations = |spec: &DutSpec| spec.deviations().is_empty();
    if !deviations.is_empty() && (!devices.live.is_empty() || devices.here.iter().any(has_no_deviations)) {
        return Err("only reference devices (`--dut model:...`) can have a bug or a variation".into());
    }
    devices.without_model = without_model;
    Ok(devices)
}

/// The manual and the variants that `MANUAL[/VARIANT]` names.
pub(super) fn claim<'a>(what: &str, manuals: &'a [Manual]) -> Result<Vec<(&'a Manual, &'a str)>, String> {
    let (name, variant) = what.split_once('/').map_or((what, None), |(name, variant)| (name, Some(variant)));
    let Some(manual) = manuals.iter().find(|of| of.device.name == name) else {
        let known: Vec<&str> = manuals.iter().map(|of| of.device.name.as_str()).collect();
        return Err(suggest("device", name, known));
    };
    let every: Vec<(&Manual, &str)> = manual.device.variants.iter().map(|of| (manual, of.as_str())).collect();
    let Some(name_of_variant) = variant else { return Ok(every) };
    let variants = manual.device.variants.iter().map(String::as_str);
    match every.into_iter().find(|(_, variant)| *variant == name_of_variant) {
        Some(claimed) => Ok(vec![claimed]),
        None => Err(suggest(&format!("variant of {name}"), name_of_variant, variants)),
    }
}

/// The manuals that judge captures and live traffic: all, the one of `MANUAL[/VARIANT]`, or that with one variant only.
pub(super) fn claimed_manuals(sources: &Sources, device: Option<&str>) -> Result<Vec<Manual>, CommandError> {
    let name = device.map(|device| device.split_once('/').map_or(device, |(name, _)| name));
    let mut manuals = load(sources, name)?;
    let Some(device) = device else { return Ok(manuals) };
    let claimed = claim(device, &manuals).map_err(CommandError::usage)?;
    let claimed: Vec<String> = claimed.into_iter().map(|(_, variant)| variant.to_owned()).collect();
    for manual in &mut manuals {
        manual.variants.retain(|of| claimed.contains(&of.name));
    }
    Ok(manuals)
}

fn null_device_kind(what: &str) -> Result<NullPeer, String> {
    what.parse().map_err(|_| suggest("kind of null device", what, NullPeer::words()))
}

fn unknown_dut(dut: &str) -> String {
    let kinds = ["model:", "null:", "nic:", "serial:", "socket:", "app:"];
    let kind = dut.split_once(':').map_or(dut, |(kind, _)| kind);
    let meant =
        nearest(&format!("{kind}:"), kinds).map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"));
    format!(
        "`{dut}` is not a device under test; write model:MANUAL[/VARIANT], nic:IF, socket:ADDRESS, serial:TTY, app:COMMAND, null:KIND or \
         a bench file{meant}"
    )
}

/// An error message about an unknown word. It suggests the nearest known word, or lists all.
pub(super) fn suggest<'a>(what: &str, word: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    match nearest(word, known.clone()) {
        Some(meant) => format!("unknown {what} `{word}`; did you mean `{meant}`?"),
        None => format!("unknown {what} `{word}`; available: {}", known.into_iter().collect::<Vec<_>>().join(", ")),
    }
}
