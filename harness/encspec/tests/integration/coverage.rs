//! Coverage is earned: each covered requirement has a bug that makes it fail, and what no live device can show is known by name.

use crate::built_in::manuals;
use encspec::engine::needs::{BenchNeed, missing, needs};
use encspec::suite::model::Manual;
use encspec::suite::reach::{Reach, of_requirements};
use rstest::rstest;
use std::collections::BTreeSet;
use std::time::Duration;
use testing::Folder;
use wire::profibus::fdl::BaudRate;

/// `bugs::each_bug_shows_in_each_case_and_each_requirement_that_names_it` proves that the results fail.
#[test]
fn each_covered_requirement_is_broken_by_a_bug() {
    let blind: Vec<&str> = manuals().iter().flat_map(covered_without_a_bug).collect();
    assert!(blind.is_empty(), "no bug makes these fail, so nothing shows that their checks can: {blind:?}");
}

fn covered_without_a_bug(manual: &Manual) -> Vec<&str> {
    let broken: BTreeSet<usize> = manual.bugs.iter().flat_map(|bug| bug.breaks.iter().copied()).collect();
    let covered = of_requirements(manual).into_iter().enumerate().filter(|(_, reach)| reach.is_some());
    covered
        .filter(|(index, _)| !broken.contains(index) && manual.suite_of_requirement(*index).is_none())
        .filter_map(|(index, _)| manual.requirements.get(index))
        .map(|of| of.id.as_str())
        .collect()
}

/// What only a virtual wire shows: requests of another station, and what only a link shows that times bits.
#[test]
fn what_no_live_bench_shows_is_known() {
    for manual in manuals() {
        let name = manual.device.name.as_str();
        let never: Vec<&str> = manual
            .requirements
            .iter()
            .zip(of_requirements(manual))
            .enumerate()
            .filter(|(index, (_, reach))| {
                matches!(reach, Some(Reach::Never(_))) && manual.suite_of_requirement(*index).is_none()
            })
            .map(|(_, (of, _))| of.id.as_str())
            .collect();
        match name {
            "sick-a3m60-profibus" => assert!(never.len() <= A3M60_NEVER, "{name}: {} are {never:?}", never.len()),
            // The delay of the answers in bit times, and what isochronous mode or a fast bus says.
            "dp-slave" => {
                let rates = (6..=10).map(|rate| format!("DPS-RAT-{rate:03}"));
                let delays = (12..=13).map(|delay| format!("DPS-LNK-{delay:03}"));
                assert_eq!(never, delays.chain(rates).collect::<Vec<_>>());
            }
            "lika-xac77-profinet" => assert_eq!(never, ["XAC77-DCP-009"]),
            "profinet-io" => assert_eq!(never, ["PNIO-STN-014"]),
            _ => assert!(never.is_empty(), "{name}: {never:?}"),
        }
    }
}

/// Requirements on isochronous mode, which a kernel cannot clock, and one on a cycle of 1 ms.
const A3M60_NEVER: usize = 35;

/// A trial that is said to run nowhere is not applicable on any bench, and one that takes no stand lacks no ability of one.
#[test]
fn the_reach_agrees_with_what_a_bench_says() {
    for manual in manuals() {
        let bus = if manual.device.bus.kind().is_profibus() { "serial:/dev/ttyUSB0" } else { "nic:eth1" };
        let bench = bench(&format!("device: {}/{}\nlink: {bus}\n", manual.device.name, manual.device.variants[0]));
        for variant in &manual.variants {
            for trial in &variant.trials {
                let needs = needs(manual, variant, trial);
                let why = missing(&needs, &bench, true, 1000).unwrap_or_default();
                let is_of_stand = why.starts_with("the stand cannot");
                match Reach::of(&needs) {
                    Reach::NoStand => assert!(!is_of_stand, "{}: {why}", trial.id),
                    Reach::WithStand => assert!(!why.is_empty(), "{}", trial.id),
                    Reach::Never(never) => assert!(!why.is_empty(), "{}: {never}", trial.id),
                }
            }
        }
    }
}

/// A case that says the rate of the bus runs on a line of this rate, if a kernel keeps its times.
#[rstest]
#[case::same(93_750, "line: { baud: 93750 }\n", None)]
#[case::another(
    93_750,
    "line: { baud: 19200 }\n",
    Some("the line has 19200 bit/s; run it on a bus with `baud: 93750`")
)]
#[case::none_said(93_750, "", Some("link cannot time bits"))]
#[case::too_fast(1_500_000, "line: { baud: 1500000 }\n", Some("link cannot time bits"))]
fn a_rate_is_that_of_the_line(#[case] rate: u32, #[case] line: &str, #[case] why: Option<&str>) {
    let bench = bench(&format!("device: sick-a3m60-profibus/a3m60\nlink: serial:/dev/ttyUSB0\n{line}"));
    let needs = [BenchNeed::Rate(BaudRate(rate)), BenchNeed::Long { waits: Duration::ZERO, really: Duration::ZERO }];
    assert_eq!(missing(&needs, &bench, true, 0).as_deref(), why);
}

fn bench(text: &str) -> encspec::bench_file::BenchFile {
    let folder = Folder::new("coverage");
    let path = folder.write("bench.yaml", text);
    encspec::bench_file::read(&path, manuals()).unwrap_or_else(|errors| panic!("{errors}"))
}
