//! The section `stand` of a bench file: control channel, hooks, operator, shaft.

use super::command::CommandLine;
use super::keys::{HOOKS, bench_stand};
use super::{ShaftAbility, StandSpec};
use std::path::Path;
use suite::device::DeviceDescription;
use suite_yaml::error::{Mistake, Mistakes, Read};
use suite_yaml::keys::{Key, Keyed};
use suite_yaml::yaml::Node;

/// Reads the section; without a device the names after a dot are not checked.
pub(super) fn stand(
    node: &Node,
    folder: &Path,
    device: Option<&DeviceDescription>,
    mistakes: &Mistakes,
) -> Read<StandSpec> {
    let keyed = Keyed::new(node, &bench_stand::KEYS)?;
    let control =
        keyed.get(&bench_stand::control).map(|node| node.text("a socket")).transpose()?.map(|path| folder.join(path));
    let mut spec = StandSpec { control, folder: folder.to_owned(), ..StandSpec::default() };
    for (key, line) in keyed.get(&bench_stand::hooks).map_or(Ok(&[][..]), |node| node.entries("hooks"))? {
        spec.hooks.extend(mistakes.keep(hook(key, line, device)));
    }
    for item in keyed.get(&bench_stand::ask).map_or(Ok(&[][..]), |node| node.items("ask"))? {
        spec.ask.extend(mistakes.keep(ask_name(item, &spec, device)));
    }
    if let Some(node) = keyed.get(&bench_stand::shaft) {
        spec.shaft = shaft(node)?;
    }
    check_shaft(keyed, &spec, mistakes);
    if keyed.node.mapping().is_some_and(<[_]>::is_empty) {
        return Err(node.wrong("`stand` is empty").help("remove it if the bench has no stand"));
    }
    Ok(spec)
}

fn hook(key: &Node, line: &Node, device: Option<&DeviceDescription>) -> Read<(String, String)> {
    let name = stand_name(key, device)?;
    let text = line.text("a command")?;
    let command = CommandLine::parse(text).map_err(|why| line.wrong(why))?;
    let placeholders = command.placeholders();
    let required: &[&str] = match name.split('.').next() {
        Some("led" | "counter" | "renew") => &[],
        Some("turn") => &["value", "unit"],
        Some("shaft") if name == "shaft.acceleration" => &["value", "acceleration"],
        _ => &["value"],
    };
    if let Some(missing) = required.iter().find(|required| !placeholders.contains(required)) {
        return Err(line.wrong(format!("the command of `{name}` does not use `{{{missing}}}`")).help(sentence(name)));
    }
    let allowed = |given: &&str| required.contains(given) || (name == "turn" && **given == *"rpm");
    if let Some(odd) = placeholders.iter().find(|given| !allowed(given)) {
        return Err(line.wrong(format!("`{name}` has no placeholder `{{{odd}}}`")).help(sentence(name)));
    }
    Ok((name.to_owned(), text.to_owned()))
}

fn ask_name(item: &Node, spec: &StandSpec, device: Option<&DeviceDescription>) -> Read<String> {
    let name = stand_name(item, device)?;
    if matches!(name.split('.').next(), Some("led" | "counter" | "clock")) {
        return Err(item.wrong(format!("an operator cannot serve `{name}`")).help("use a hook"));
    }
    if spec.hooks.iter().any(|(hook, _)| hook == name) {
        return Err(item.wrong(format!("`{name}` already has a hook")));
    }
    if spec.ask.iter().any(|asked| asked == name) {
        return Err(item.wrong(format!("`{name}` is listed twice in ask")));
    }
    Ok(name.to_owned())
}

/// A name of [`HOOKS`] that the device has.
fn stand_name<'n>(node: &'n Node, device: Option<&DeviceDescription>) -> Read<&'n str> {
    let name = node.text("a name of the stand")?;
    let mut names: Vec<String> = Vec::new();
    for (hook, _) in HOOKS {
        let Some(kind) = hook.strip_suffix("NAME") else {
            names.push((*hook).to_owned());
            continue;
        };
        match device {
            None if name.strip_prefix(kind).is_some_and(|rest| !rest.is_empty()) => return Ok(name),
            None => names.push((*hook).to_owned()),
            Some(device) => names.extend(declared(device, kind).iter().map(|name| format!("{kind}{name}"))),
        }
    }
    if names.iter().any(|known| known == name) && !name.ends_with("NAME") {
        Ok(name)
    } else {
        Err(Mistake::unknown(node.spot, "name of the stand", name, names.iter().map(String::as_str)))
    }
}

/// The names that a device declares with this prefix.
fn declared<'d>(device: &'d DeviceDescription, kind: &str) -> Vec<&'d str> {
    let stand = &device.stand;
    let names = |list: &'d [(String, String)]| list.iter().map(|(name, _)| name.as_str()).collect();
    match kind {
        "fault." => names(&stand.faults),
        "button." => names(&stand.buttons),
        "counter." => names(&stand.counters),
        "switch." => stand.switches.iter().map(|switch| switch.name.as_str()).collect(),
        _ => stand.leds.iter().map(|(name, _)| name.as_str()).collect(),
    }
}

fn sentence(name: &str) -> &'static str {
    let kind = name.split_once('.').map_or(name, |(kind, _)| kind);
    let same = |hook: &str| hook == name || hook.strip_suffix(".NAME") == Some(kind);
    HOOKS.iter().find(|(hook, _)| same(hook)).map_or("", |(_, sentence)| sentence)
}

const SHAFT_WORDS: [&str; 4] = ["hand", "position", "speed", "uncoupled"];

fn shaft(node: &Node) -> Read<ShaftAbility> {
    let mut shaft = ShaftAbility::default();
    for item in node.items("shaft")? {
        let text = item.text("an ability")?;
        let twice = || item.wrong(format!("`{text}` is listed twice in shaft"));
        if let Some(flag) = match text {
            "hand" => Some(&mut shaft.hand),
            "uncoupled" => Some(&mut shaft.uncoupled),
            _ => None,
        } {
            if std::mem::replace(flag, true) {
                return Err(twice());
            }
            continue;
        }
        let (word, exactly) = text.strip_suffix(')').and_then(|text| text.split_once('(')).unwrap_or((text, ""));
        let place = match word {
            "position" => &mut shaft.position,
            "speed" => &mut shaft.speed,
            _ => return Err(Mistake::unknown(item.spot, "ability of the shaft", word, SHAFT_WORDS)),
        };
        let number = exactly.strip_prefix('\u{b1}').or_else(|| exactly.strip_prefix("+/-"));
        let number = number.and_then(|number| expression::number(number.trim()).ok()).map(expression::Number::to_f64);
        let unit = if word == "position" { "hardware steps" } else { "revolutions per minute" };
        let Some(number) = number.filter(|number| (0.0..=1e9).contains(number)) else {
            return Err(item
                .wrong(format!("the accuracy is missing in `{text}`"))
                .help(format!("write `{word}(\u{b1}2)` with a number of {unit}; `+/-` can be used for \u{b1}")));
        };
        if place.replace(number).is_some() {
            return Err(twice());
        }
    }
    if shaft == ShaftAbility::default() { Err(node.wrong("shaft is empty").help("remove the key")) } else { Ok(shaft) }
}

/// Checks that the abilities of the shaft and the names that serve it match.
fn check_shaft(keyed: Keyed<'_>, spec: &StandSpec, mistakes: &Mistakes) {
    let served = |name: &str| spec.hooks.iter().any(|(hook, _)| hook == name) || spec.ask.iter().any(|ask| ask == name);
    let wrong = |key: &Key, message: &str, help: &str| {
        mistakes.note(keyed.key(key).unwrap_or(keyed.node).wrong(message).help(help));
    };
    let at = |name: &str| {
        let hooked = spec.hooks.iter().any(|(hook, _)| hook == name);
        if hooked { &bench_stand::hooks } else { &bench_stand::ask }
    };
    let controlled = spec.control.is_some();
    let turned = served("turn") || served("shaft.counts");
    let shaft = &spec.shaft;
    if shaft.position.is_some() && !turned && !controlled {
        wrong(&bench_stand::shaft, "no hook positions the shaft", "add a hook for `turn` or `shaft.counts`");
    }
    if shaft.speed.is_some() && !served("shaft.speed") && !controlled {
        wrong(&bench_stand::shaft, "no hook turns the shaft at a speed", "add a hook for `shaft.speed`");
    }
    if shaft.hand && !served("turn") {
        wrong(&bench_stand::shaft, "no operator is asked to turn the shaft by hand", "write `ask: [turn]`");
    }
    if served("turn") && shaft.position.is_none() && !shaft.hand {
        wrong(at("turn"), "the accuracy of `turn` is missing", "add `shaft: [position(\u{b1}2)]`, in hardware steps");
    }
    if served("shaft.counts") && shaft.position.is_none() {
        let help = "add `shaft: [position(\u{b1}2)]`, in hardware steps";
        wrong(at("shaft.counts"), "the accuracy of `shaft.counts` is missing", help);
    }
    if served("shaft.speed") && shaft.speed.is_none() {
        let help = "add `shaft: [speed(\u{b1}0.5)]`, in revolutions per minute";
        wrong(at("shaft.speed"), "the accuracy of `shaft.speed` is missing", help);
    }
}
