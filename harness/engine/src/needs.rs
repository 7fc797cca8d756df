//! Whether a bench has what a trial needs ([`suite::needs`]).
//!
//! This is checked before anything is sent, so a trial that a bench cannot serve changes nothing. This module runs no step and
//! knows no link.

pub use suite::needs::{Ability, BenchNeed, CANNOT_TIME_BITS, ClaimedFeature, Consent, LONG, needs, of_step};

use results::bench_file::{BenchFile, StandSpec};
use std::slice;
use std::time::Duration;
use wire::profibus::fdl::BaudRate;

/// A trial that waits at least this long, even with a clock of the stand, runs on a live bench only with `--long`.
const VERY_LONG: Duration = Duration::from_secs(120);

/// The upper limit of the memory writes in these needs.
pub fn nvm_writes(needs: &[BenchNeed]) -> u32 {
    let writes = needs.iter().map(|need| match need {
        BenchNeed::Consent(Consent::NvmWrite(writes)) => *writes,
        _ => 0,
    });
    writes.fold(0, u32::saturating_add)
}

/// By how many steps a position may be off in a trial with these needs: the noise of the bench, plus the accuracy of the stand if
/// it turns the shaft.
pub fn position_noise(needs: &[BenchNeed], bench: &BenchFile) -> u32 {
    let moves = needs.iter().any(|need| matches!(need, BenchNeed::Stand(Ability::Turn { .. } | Ability::Place)));
    let exactly = bench.stand.position().unwrap_or(0.0).ceil();
    if moves { bench.position_noise.saturating_add(exactly as u32) } else { bench.position_noise }
}

/// Why a trial with these needs is not applicable on this bench; `None` if nothing is missing.
///
/// `long`: trials that wait for minutes are allowed. `nvm_left`: how many memory writes the run may still make.
pub fn missing(needs: &[BenchNeed], bench: &BenchFile, long: bool, nvm_left: u32) -> Option<String> {
    needs.iter().find_map(|need| match need {
        BenchNeed::Stand(ability) => cannot(ability, &bench.stand),
        BenchNeed::Consent(consent) => withheld(*consent, bench, nvm_left),
        BenchNeed::Claim(claim) => disclaimed(claim, bench),
        BenchNeed::Page(name) => Some(format!(
            "the manual does not describe the web page {name}; describe it under `pages` in the bench file"
        )),
        BenchNeed::DirectCable if bench.direct_cable => None,
        BenchNeed::DirectCable => Some("a switch does not forward LLDP; connect the device directly and set `direct_cable: true` in the bench file".to_owned()),
        BenchNeed::BitTiming | BenchNeed::Virtual(_) => need.never_live(),
        BenchNeed::Rate(rate) => need.never_live().or_else(|| has_another_rate(*rate, bench)),
        BenchNeed::Long { .. } if long => None,
        BenchNeed::Long { really, .. } if *really >= VERY_LONG => Some(format!(
            "the trial takes {} s, and no clock of the stand can shorten it; run with --long",
            really.as_secs()
        )),
        BenchNeed::Long { .. } if bench.stand.serves("clock") => None,
        BenchNeed::Long { waits, .. } => Some(format!(
            "the trial waits for {} s; give the stand the ability `clock` or run with --long",
            waits.as_secs()
        )),
    })
}

/// The lines of the bench file, or options, without which a trial with these needs is not applicable; without duplicates.
pub fn missing_lines(needs: &[BenchNeed], bench: &BenchFile, long: bool, nvm_left: u32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for need in needs.iter().filter(|need| missing(slice::from_ref(need), bench, long, nvm_left).is_some()) {
        if let Some(line) = need.bench_line().filter(|line| !lines.contains(line)) {
            lines.push(line);
        }
    }
    lines
}

/// Why the stand cannot do it.
fn cannot(ability: &Ability, stand: &StandSpec) -> Option<String> {
    let name = ability.to_string();
    let by_hand = if stand.shaft.hand { "; it is only turned by hand" } else { "" };
    match ability {
        Ability::Moves if stand.shaft.hand || stand.position().is_some() || stand.speed().is_some() => None,
        Ability::Moves => Some("the stand cannot move the shaft".to_owned()),
        Ability::Turn { shortest } => match (stand.position(), shortest) {
            (None, _) => Some(format!("the stand cannot turn the shaft by a given distance{by_hand}")),
            // With half of this accuracy a step would still be within the allowed tolerance.
            (Some(exactly), Some(shortest)) if exactly * 2.0 >= *shortest && exactly > 0.0 => Some(format!(
                "the stand turns the shaft to \u{b1}{exactly} steps, which is too coarse for a distance of {shortest}"
            )),
            (Some(_), _) => {
                (!stand.serves("turn")).then(|| "the stand cannot turn the shaft by a given distance".to_owned())
            }
        },
        Ability::Place => {
            let can = stand.position().is_some() && stand.serves("shaft.counts");
            (!can).then(|| format!("the stand cannot turn the shaft to a given position{by_hand}"))
        }
        Ability::Speed { slowest } => match (stand.speed(), slowest) {
            (Some(exactly), Some(slowest)) if exactly * 100.0 > *slowest => {
                Some(format!("the stand turns the shaft to \u{b1}{exactly} rpm, but at {slowest} rpm checks allow 1 %"))
            }
            (Some(_), _) if stand.serves("shaft.speed") => None,
            _ => Some(format!("the stand cannot turn the shaft at a given speed{by_hand}")),
        },
        Ability::Led(_) => (!stand.serves(&name)).then(|| format!("the stand cannot read {name}")),
        Ability::Counter(_) => (!stand.serves(&name)).then(|| format!("the stand cannot read {name}")),
        _ => (!stand.serves(&name)).then(|| format!("the stand cannot set {name}")),
    }
}

/// Why the line does not have this rate; a pseudoterminal has none unless its bench file says so.
fn has_another_rate(rate: BaudRate, bench: &BenchFile) -> Option<String> {
    match bench.line.baud {
        Some(of) if of == rate => None,
        Some(of) => Some(format!("the line has {} bit/s; run it on a bus with `baud: {}`", of.0, rate.0)),
        None => Some(CANNOT_TIME_BITS.to_owned()),
    }
}

/// Why the bench does not allow it.
fn withheld(consent: Consent, bench: &BenchFile, nvm_left: u32) -> Option<String> {
    let given = &bench.consent;
    let (word, given) = match consent {
        Consent::FactoryReset => ("factory_reset", given.factory_reset),
        Consent::SetName => ("set_name", given.set_name),
        Consent::SetIp => ("set_ip", given.set_ip),
        Consent::SetAddress => ("set_address", given.set_address),
        Consent::LockAddress => ("lock_address", given.lock_address),
        Consent::PositionReference => ("position_reference", given.position_reference),
        Consent::Firmware => ("firmware", given.firmware),
        Consent::Overstress => ("overstress", given.overstress),
        Consent::Alone => ("alone", given.alone),
        Consent::ImRecords => ("im_records", given.im_records),
        Consent::NvmWrite(_) if given.nvm_write == 0 => ("nvm_write", false),
        Consent::NvmWrite(writes) if writes > nvm_left => {
            let all = given.nvm_write;
            return Some(format!(
                "the trial may write the memory {writes} times, but only {nvm_left} of the {all} writes that the bench allows in a run are left"
            ));
        }
        Consent::NvmWrite(_) => return None,
    };
    (!given).then(|| format!("the bench gives no consent to `{word}`"))
}

/// Why the bench says that the device does not have it.
fn disclaimed(claim: &ClaimedFeature, bench: &BenchFile) -> Option<String> {
    match claim {
        ClaimedFeature::Module(name) => {
            let claimed = bench.telegrams.as_ref().is_none_or(|list| list.contains(name));
            (!claimed).then(|| format!("the bench does not claim {name}"))
        }
        ClaimedFeature::Name(name) => {
            let lacks = bench.lacks.contains(name);
            lacks.then(|| format!("the bench says that the device lacks {name}"))
        }
    }
}
