//! Which variant a device is: the readings that decide, on reference devices with and without permitted variations, and the claims that
//! they refute.

use crate::built_in::{self, manual, manuals};
use crate::on_two_threads::every;
use encspec::description::variant::{
    VariantReading, candidates, order_reading, profibus_readings, profinet_readings, refuted_claim,
};
use encspec::engine::{described, variant_readings};
use encspec::suite::device::{ExpectedNumber, VariantValue, VariantValueSource};
use encspec::suite::model::{Manual, SuiteVariant};
use encspec::{gsd, gsdml};
use rstest::rstest;
use std::sync::Arc;

const SOURCE: VariantValueSource = VariantValueSource::Input(0);

/// The revolutions of a device, 1 for the first variant and 4096 for the second.
fn revolutions(number: i128) -> Option<VariantReading> {
    let expected = vec![ExpectedNumber::OneOf(vec![1]), ExpectedNumber::OneOf(vec![4096])];
    VariantReading::of_number(&VariantValue { name: "P979.revolutions".into(), source: SOURCE, expected }, number)
}

fn position(number: i128) -> Option<VariantReading> {
    let expected = vec![ExpectedNumber::Below(262_144), ExpectedNumber::Below(1 << 30)];
    VariantReading::of_number(&VariantValue { name: "G1_XIST2".into(), source: SOURCE, expected }, number)
}

fn order(text: &str) -> Option<VariantReading> {
    order_reading(&manual("sick-afx60-profinet").device, text)
}

#[rstest]
#[case::nothing_read(vec![], &[0, 1], false)]
#[case::right_order_number(vec![order("AFS60A-S4NB262144")], &[0], false)]
#[case::other_order_number(vec![order("AFM60A-S4NB018X12")], &[1], true)]
#[case::article_number(vec![order("1059004")], &[0, 1], false)]
#[case::small_position(vec![position(17)], &[0, 1], false)]
#[case::large_position(vec![position(262_144)], &[1], true)]
#[case::other_revolutions(vec![revolutions(4096)], &[1], true)]
#[case::revolutions_of_no_variant(vec![revolutions(12)], &[0, 1], false)]
#[case::contradiction(vec![order("AFS60A-S4NB262144"), revolutions(4096)], &[0, 1], false)]
#[case::agreement(vec![order("AFM60A"), revolutions(4096), position(5)], &[1], true)]
fn a_claim_is_refuted_if_nothing_the_device_reports_speaks_for_it(
    #[case] readings: Vec<Option<VariantReading>>,
    #[case] left: &[usize],
    #[case] is_refuted: bool,
) {
    let device = &manual("sick-afx60-profinet").device;
    let readings: Vec<VariantReading> = readings.into_iter().flatten().collect();
    assert_eq!(candidates(device, &readings), left);
    assert_eq!(refuted_claim(device, 0, &readings).is_some(), is_refuted);
}

#[test]
fn a_refuted_claim_has_both_readings_in_one_finding() {
    let device = &manual("sick-afx60-profinet").device;
    let readings = [revolutions(4096), order("AFM60A\u{1b}[2J")].map(|of| of.expect("it decides"));
    let finding = refuted_claim(device, 0, &readings).expect("it is refuted");
    assert_eq!(
        finding.text,
        "The device is not sick-afx60-profinet/afs60, which the bench claims, so nothing was judged: P979.revolutions is 4096; the \
         order number in I&M0 is `AFM60A\\u{1b}[2J`. Write `device: sick-afx60-profinet/afm60`, or test the claimed device."
    );
    assert_eq!(finding.manual.as_deref(), Some("afs60: P979.revolutions: 1; the order number in I&M0: AFS60"));
    assert_eq!(
        finding.device.as_deref(),
        Some("P979.revolutions is 4096; the order number in I&M0 is `AFM60A\\u{1b}[2J`")
    );
    assert_eq!(refuted_claim(device, 1, &readings), None);
}

/// The GSDML and GSD of each reference device mean its variant and no other.
#[test]
fn each_description_means_its_variant() {
    for manual in manuals().iter().filter(|manual| manual.variants.len() > 1) {
        let device = &manual.device;
        for (index, variant) in manual.variants.iter().enumerate() {
            let readings = match device.profibus() {
                None => {
                    let (_, gsdml) = suites::gsdml_for(&device.name, &variant.name).expect("it is shipped");
                    let gsdml: gsdml::Gsdml = gsdml;
                    profinet_readings(device, Some(&gsdml), None)
                }
                Some(_) => {
                    let is_it = |path: &str| path.starts_with(&device.name) && path.contains(&variant.name);
                    let (_, text) = suites::gsd().iter().find(|(path, _)| is_it(path)).expect("it is shipped");
                    profibus_readings(device, Some(&gsd::read(text).expect("it is read")))
                }
            };
            assert_eq!(candidates(device, &readings), [index], "{}/{}", device.name, variant.name);
        }
    }
}

/// Manuals with several variants, with each claimed variant and each variant that the device is.
fn claims() -> Vec<(&'static Manual, &'static SuiteVariant, &'static SuiteVariant)> {
    let manuals = manuals().iter().filter(|manual| manual.variants.len() > 1);
    let pairs = manuals.flat_map(|manual| {
        let of = move |claimed| manual.variants.iter().map(move |is| (manual, claimed, is));
        manual.variants.iter().flat_map(of)
    });
    pairs.collect()
}

/// The finding about a claim, by what the device reports in a connection.
fn finding(manual: &Manual, claimed: &SuiteVariant, is: &SuiteVariant, deviations: &[&str]) -> Option<String> {
    let dut = built_in::model(manual, is, deviations);
    let device = described(manual, &dut).map_or_else(|| Arc::clone(&manual.device), |other| other.device);
    // A live device reports the ident of its access point in record 0xF000, whatever the claim is.
    let mut device = (*device).clone();
    let own = device.variants.iter().position(|variant| *variant == is.name).expect("it is a variant");
    for idents in device.submodules.iter_mut().filter_map(|submodule| submodule.module_idents.as_mut()) {
        let reported = idents[own];
        idents.fill(reported);
    }
    let (requirements, bugs) = (manual.requirements.clone(), manual.bugs.clone());
    let read = Manual {
        device: Arc::new(device),
        requirements,
        bugs,
        variants: Vec::new(),
        unused: Vec::new(),
        also: Vec::new(),
    };
    let readings = variant_readings(&read, claimed, &dut).expect("a model can be read");
    let claimed = manual.variants.iter().position(|variant| variant.name == claimed.name).expect("it is a variant");
    refuted_claim(&manual.device, claimed, &readings).map(|finding| finding.text)
}

#[test]
fn wrong_claims_are_refuted_and_right_ones_are_not() {
    for (manual, claimed, is) in claims() {
        let found = finding(manual, claimed, is, &[]);
        let name = format!("{}: {} claimed as {}", manual.device.name, is.name, claimed.name);
        // No value of a singleturn Sendix proves that it is none with several revolutions.
        let is_open = is.name == "sendix-singleturn";
        assert_eq!(found.is_some(), claimed.name != is.name && !is_open, "{name}: {found:?}");
    }
}

#[test]
fn no_permitted_variation_refutes_a_right_claim() {
    let mut jobs = Vec::new();
    for (manual, claimed, is) in claims().into_iter().filter(|(_, claimed, is)| claimed.name == is.name) {
        let subject = deviations::subject(&manual.device.name).expect("a reference device for every suite");
        jobs.extend(subject.permitted().map(|known| (manual, claimed, is, known.name)));
    }
    assert!(jobs.len() > 300, "{} variations", jobs.len());
    let refuted = every(&jobs, |(manual, claimed, is, name)| {
        finding(manual, claimed, is, &[*name]).map(|text| format!("{} --vary {name}: {text}\n", is.name))
    });
    assert!(refuted.is_empty(), "{}", refuted.concat());
}
