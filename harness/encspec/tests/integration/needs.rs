//! What the trials of the built-in suites need from a bench, and the reason if a bench lacks it.

use crate::built_in::manuals;
use encspec::bench_file::{BenchFile, read};
use encspec::engine::needs::{Ability, BenchNeed, ClaimedFeature, Consent, missing, needs, nvm_writes, position_noise};
use encspec::suite::model::{Manual, SuiteVariant, Trial};
use encspec::suite_yaml::load;
use rstest::rstest;

fn lika() -> &'static Manual {
    manuals().iter().find(|manual| manual.device.name == "lika-xac77-profinet").expect("it is shipped")
}

fn variant() -> &'static SuiteVariant {
    &lika().variants[0]
}

fn trial(id: &str) -> &'static Trial {
    variant().trials.iter().find(|trial| trial.id == id).unwrap_or_else(|| panic!("there is no {id}"))
}

fn of(id: &str) -> Vec<BenchNeed> {
    needs(lika(), variant(), trial(id))
}

fn bench(more: &str) -> BenchFile {
    let folder = testing::Folder::new("needs");
    let path = folder.write("bench.yaml", format!("device: lika-xac77-profinet/xac7718\nlink: nic:eth1\n{more}"));
    read(&path, manuals()).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The needs of some XAC77 cases, derived by hand from their steps.
#[rstest]
#[case("preset/absolute", &[BenchNeed::Consent(Consent::PositionReference), BenchNeed::Consent(Consent::NvmWrite(2))])]
#[case("memory/each-save-counts", &[BenchNeed::Stand(Ability::Power), BenchNeed::Consent(Consent::NvmWrite(2))])]
#[case("parameter-values/save-and-confirm", &[BenchNeed::Consent(Consent::NvmWrite(1))])]
#[case("parameter-values/preset-value-byte-by-byte", &[])]
fn a_case_needs_what_its_steps_do(#[case] id: &str, #[case] expected: &[BenchNeed]) {
    let needs = of(id);
    let rest: Vec<&BenchNeed> = needs.iter().filter(|need| !matches!(need, BenchNeed::Claim(_))).collect();
    assert_eq!(rest, expected.iter().collect::<Vec<_>>(), "{id}");
    assert!(
        needs.contains(&BenchNeed::Claim(ClaimedFeature::Name("bf00".to_owned()))),
        "every start-up writes the start record"
    );
}

/// Every trial with a lasting effect has the matching need. Lasting effects are found in the text of the steps, which the scan does
/// not use.
#[test]
fn no_lasting_effect_is_overlooked() {
    let mut found = 0;
    for variant in &lika().variants {
        for trial in &variant.trials {
            let text = all_text(trial);
            let needs = needs(lika(), variant, trial);
            let consents = |consent: fn(&Consent) -> bool| {
                needs.iter().any(|need| matches!(need, BenchNeed::Consent(of) if consent(of)))
            };
            let stands =
                |name: &str| needs.iter().any(|need| matches!(need, BenchNeed::Stand(of) if of.to_string() == name));
            let writes = |name: &str| text.iter().any(|line| line.starts_with("write:") && line.contains(name));
            let sets = |name: &str| text.iter().any(|line| line.contains("set:") && line.contains(name));
            for (there, said, what) in [
                (
                    text.iter().any(|line| line.contains("dcp_reset")),
                    consents(|of| *of == Consent::FactoryReset),
                    "reset",
                ),
                (writes("station.name"), consents(|of| *of == Consent::SetName), "name"),
                (writes("station.ip") || writes("station.mask"), consents(|of| *of == Consent::SetIp), "address"),
                (sets("request_home_position: 1"), consents(|of| *of == Consent::PositionReference), "preset"),
                (sets("request_home_position: 1"), consents(|of| matches!(of, Consent::NvmWrite(_))), "preset is kept"),
                (sets("as_delivered"), stands("device") && consents(|of| *of == Consent::FactoryReset), "delivery"),
                (
                    text.iter().any(|line| line.contains("destination:")),
                    needs.iter().any(|need| matches!(need, BenchNeed::Virtual(_))),
                    "another station",
                ),
                (writes("P971"), consents(|of| matches!(of, Consent::NvmWrite(_))), "save"),
                (sets("power:"), stands("power"), "power"),
                (sets("fault.memory"), stands("fault.memory"), "fault"),
                (sets("shaft.counts"), stands("shaft.counts"), "place"),
            ] {
                assert!(!there || said, "{}: {what} is overlooked: {needs:?}", trial.id);
                found += usize::from(there);
            }
        }
    }
    assert!(found > 100, "only {found} lasting effects were found");
}

/// The needs of single steps, and the reason why a bench with all consents lacks one.
#[rstest]
#[case("set: { device: as_delivered }", &[BenchNeed::Consent(Consent::FactoryReset), BenchNeed::Consent(Consent::SetName), BenchNeed::Stand(Ability::Delivery)], Some("the stand cannot set device"))]
#[case(
    "{ write: { station.name: 'x' }, instead: { destination: \"02 00 00 00 00 99\" }, answer: none }",
    &[BenchNeed::Consent(Consent::SetName), BenchNeed::Virtual("a request to another station")],
    Some("possible on a virtual wire only: a request to another station")
)]
#[case("set: { io.alarm_acknowledge: held }", &[], None)]
#[case("send: { arp_probe: {} }", &[], None)]
#[case("{ send: { record_read: { slot: 0, subslot: 1, index: 0xAFF0, length: 64 } }, as: second }", &[], None)]
#[case("read: { station.mac: any }", &[], None)]
#[case("expect: { lldp: 1, lldp.port: 'port-001' }", &[BenchNeed::DirectCable], Some("a switch does not forward LLDP; connect the device directly and set `direct_cable: true` in the bench file"))]
#[case("send: { lldp: { chassis: 'x', port: 'port-002' } }", &[BenchNeed::DirectCable], Some("a switch does not forward LLDP; connect the device directly and set `direct_cable: true` in the bench file"))]
fn a_step_needs_what_it_does(#[case] step: &str, #[case] expected: &[BenchNeed], #[case] why: Option<&str>) {
    let topic = format!(
        "suite: tried\ncases:\n  - id: tried\n    why: Tries a step.\n    covers: [XAC77-PRK-001]\n    start: none\n    \
         steps:\n      - {step}\n      - read: {{ station.vendor_id: 0x0239 }}\n"
    );
    let sources = suites::sources().with("lika-xac77-profinet/tried.yaml", topic);
    let manuals = load(&sources, Some("lika-xac77-profinet")).unwrap_or_else(|errors| panic!("{errors}"));
    let variant = &manuals[0].variants[0];
    let trial = variant.trials.iter().find(|trial| trial.id == "tried/tried").expect("it was added");
    let needs = needs(&manuals[0], variant, trial);
    assert_eq!(needs, expected);
    assert_eq!(missing(&needs, &bench(ALL), false, 1000).as_deref(), why);
    let cabled = bench(&format!("direct_cable: true\n{ALL}"));
    assert!(!expected.contains(&BenchNeed::DirectCable) || missing(&needs, &cabled, false, 1000).is_none());
    if expected.contains(&BenchNeed::Stand(Ability::Delivery)) {
        let held = bench(&format!("stand: {{ hooks: {{ device: './renew {{value}}' }} }}\n{ALL}"));
        assert_eq!(missing(&needs, &held, false, 1000), None);
    }
}

/// On PROFIBUS the data after the four bytes of CALL are stored as I&M1 to I&M4.
#[rstest]
#[case::read("ds_write: { slot: 0, index: 255, bytes: \"08 00 FD E9\" }", false)]
#[case::class_1("ds_write: { slot: 0, index: 255, bytes: \"08 00 FD E9 20\" }", true)]
#[case::class_2("ms2_write: { slot: 0, index: 255, bytes: \"08 00 FD E9 20\" }", true)]
#[case::another_index("ms2_write: { slot: 0, index: 254, bytes: \"08 00 FD E9 20\" }", false)]
fn a_write_by_call_needs_the_consent_for_identification_data(#[case] service: &str, #[case] is_stored: bool) {
    let topic = format!(
        "suite: tried\ncases:\n  - id: tried\n    why: Tries a step.\n    covers: [A3M60-CFG-001]\n    start: {{ module: IO_04 }}\n    steps:\n      - send: {{ {service} }}\n"
    );
    let sources = suites::sources().with("sick-a3m60-profibus/tried.yaml", topic);
    let manuals = load(&sources, Some("sick-a3m60-profibus")).unwrap_or_else(|errors| panic!("{errors}"));
    let variant = &manuals[0].variants[0];
    let trial = variant.trials.iter().find(|trial| trial.id == "tried/tried").expect("it was added");
    let needs = needs(&manuals[0], variant, trial);
    assert_eq!(needs.contains(&BenchNeed::Consent(Consent::ImRecords)), is_stored, "{needs:?}");
}

fn all_text(trial: &Trial) -> Vec<String> {
    use encspec::suite::model::{TrialStep, Verb};
    fn walk(steps: &[TrialStep], out: &mut Vec<String>) {
        for step in steps {
            match &step.verb {
                Verb::Block { steps, .. } => walk(steps, out),
                Verb::Either(readings) => readings.iter().for_each(|reading| walk(&reading.steps, out)),
                _ => out.push(step.text.trim_start_matches("{ ").to_owned()),
            }
        }
    }
    let mut out = Vec::new();
    trial.parts().into_iter().for_each(|steps| walk(steps, &mut out));
    out
}

const ALL: &str = "consent: { factory_reset: true, set_name: true, set_ip: true, im_records: true, nvm_write: 1000, position_reference: true }\n";

#[rstest]
#[case("preset/absolute", "", Some("the bench gives no consent to `position_reference`"))]
#[case("preset/absolute", "consent: { position_reference: true }\n", Some("the bench gives no consent to `nvm_write`"))]
#[case("preset/absolute", ALL, None)]
#[case("memory/each-save-counts", ALL, Some("the stand cannot set power"))]
#[case("memory/each-save-counts", "stand: { ask: [power] }\nconsent: { nvm_write: 2 }\n", None)]
#[case(
    "memory/each-save-counts",
    "stand: { ask: [power] }\nconsent: { nvm_write: 1 }\n",
    Some("the trial may write the memory 2 times, but only 1 of the 1 writes that the bench allows in a run are left")
)]
#[case(
    "parameter-values/preset-value-byte-by-byte",
    "lacks: [P65000]\n",
    Some("the bench says that the device lacks P65000")
)]
#[case(
    "parameter-values/preset-value-byte-by-byte",
    "telegrams: [telegram_84]\n",
    Some("the bench does not claim telegram_81")
)]
#[case("parameter-values/preset-value-byte-by-byte", "", None)]
#[case(
    "preset/second-preset",
    "stand: { ask: [turn], shaft: [hand] }\nconsent: { position_reference: true, nvm_write: 9 }\n",
    Some("the stand cannot turn the shaft by a given distance; it is only turned by hand")
)]
fn the_missing_need_is_the_reason(#[case] id: &str, #[case] more: &str, #[case] why: Option<&str>) {
    let bench = bench(more);
    assert_eq!(missing(&of(id), &bench, false, bench.consent.nvm_write).as_deref(), why);
}

#[test]
fn the_budget_of_writes_runs_out() {
    let bench = bench("consent: { nvm_write: 5, position_reference: true }\n");
    let needs = of("preset/absolute");
    assert_eq!(nvm_writes(&needs), 2, "it presets twice");
    assert_eq!(missing(&needs, &bench, false, 2), None);
    let why = missing(&needs, &bench, false, 0).expect("nothing is left");
    assert!(why.ends_with("only 0 of the 5 writes that the bench allows in a run are left"), "{why}");
}

#[test]
fn long_waits_need_a_clock_or_the_option_long() {
    let time = std::time::Duration::from_secs;
    let needs = [BenchNeed::Long { waits: time(125), really: time(30) }];
    let why = missing(&needs, &bench(""), false, 0);
    assert_eq!(
        why.as_deref(),
        Some("the trial waits for 125 s; give the stand the ability `clock` or run with --long")
    );
    assert_eq!(missing(&needs, &bench(""), true, 0), None);
    let clock = bench("stand: { hooks: { clock: 'skip {value}' } }\n");
    assert_eq!(missing(&needs, &clock, false, 0), None);
    let needs = [BenchNeed::Long { waits: time(125), really: time(125) }];
    let why = missing(&needs, &clock, false, 0);
    let shortens_nothing = "the trial takes 125 s, and no clock of the stand can shorten it; run with --long";
    assert_eq!(why.as_deref(), Some(shortens_nothing));
    assert_eq!(missing(&needs, &clock, true, 0), None);
}

#[rstest]
#[case("position(±0)", Ability::Turn { shortest: Some(1.0) }, None)]
#[case("position(±0.4)", Ability::Turn { shortest: Some(1.0) }, None)]
#[case("position(±1)", Ability::Turn { shortest: Some(1.0) }, Some("the stand turns the shaft to ±1 steps, which is too coarse for a distance of 1"))]
#[case("position(±20)", Ability::Turn { shortest: Some(1000.0) }, None)]
#[case("speed(±0.5)", Ability::Speed { slowest: Some(60.0) }, None)]
#[case("speed(±0.7)", Ability::Speed { slowest: Some(60.0) }, Some("the stand turns the shaft to ±0.7 rpm, but at 60 rpm checks allow 1 %"))]
#[case("speed(±0.5)", Ability::Moves, None)]
fn a_shaft_is_moved_as_exactly_as_the_stand_can(
    #[case] shaft: &str,
    #[case] ability: Ability,
    #[case] why: Option<&str>,
) {
    let name = if shaft.starts_with("speed") { "shaft.speed" } else { "turn" };
    let bench = bench(&format!("stand: {{ ask: [{name}], shaft: ['{shaft}'] }}\n"));
    assert_eq!(missing(&[BenchNeed::Stand(ability)], &bench, false, 0).as_deref(), why);
}

#[test]
fn a_coarse_stand_adds_to_the_position_noise() {
    let bench = bench("position_noise: 2\nstand: { ask: [turn], shaft: ['position(±2.5)'] }\n");
    assert_eq!(position_noise(&[BenchNeed::Stand(Ability::Turn { shortest: None })], &bench), 5);
    assert_eq!(position_noise(&[BenchNeed::Stand(Ability::Power)], &bench), 2);
}

/// A control channel can do what it offers; as long as it has not been asked, everything is assumed.
#[test]
fn a_control_channel_serves_what_it_offers() {
    let mut bench = bench("stand: { control: /run/encspec/control }\n");
    let speed = [BenchNeed::Stand(Ability::Speed { slowest: Some(1.0) })];
    let led = [BenchNeed::Stand(Ability::Led("bus".to_owned()))];
    assert_eq!(missing(&speed, &bench, false, 0), None);
    assert_eq!(missing(&led, &bench, false, 0), None);
    bench.stand.offers = Some(vec!["power".to_owned(), "led.bus".to_owned()]);
    assert_eq!(missing(&led, &bench, false, 0), None);
    let why = missing(&speed, &bench, false, 0);
    assert_eq!(why.as_deref(), Some("the stand cannot turn the shaft at a given speed"));
}

#[rstest]
#[case("position_reference: [G1_STW.request_home_positon]", "did you mean `G1_STW.request_home_position`?")]
#[case("position_reference: [G1_ZSW.parked]", "unknown output, parameter or record `G1_ZSW.parked`")]
#[case("position_reference: [P922]", "`P922` can only be read")]
#[case("nvm_write: [P971]", "a parameter that is `permanent` writes the memory anyway")]
#[case("nvm_write: [G1_STW, G1_STW]", "`G1_STW` stands twice in nvm_write")]
#[case("factory_reset: []", "factory_reset is empty")]
#[case("nvm_writes: [G1_STW]", "did you mean `nvm_write`?")]
fn an_error_in_changes_is_reported(#[case] line: &str, #[case] part: &str) {
    let path = "lika-xac77-profinet/device.yaml";
    let sources = suites::sources();
    let text = sources.files().find(|(name, _)| *name == path).expect("it is shipped").1;
    let begin = text.find("\nchanges:").expect("it says what changes the device");
    let changed = format!("{}\nchanges: {{ {line} }}\n", &text[..begin]);
    let errors = load(&sources.with(path, changed), Some("lika-xac77-profinet")).expect_err("it does not load");
    assert!(errors.to_string().contains(part), "{errors}");
}
