//! How many sequences a minute one core runs on each reference device and compares with another one.

use encspec_explore::bench::ExploreBench;
use encspec_explore::campaign::{Campaign, CampaignOptions};
use encspec_explore::learn::LearnedReference;
use engine::{DutKind, DutSpec};
use std::time::Instant;

/// Sequences of each device.
const SEQUENCES: u64 = 200;

fn main() {
    let sources = suites::sources();
    let manuals = suite_yaml::load(&sources, None).unwrap_or_else(|errors| panic!("{errors}"));
    for manual in &manuals {
        let Some(variant) = manual.device.variants.first() else { continue };
        let kind = DutKind::Model { deviations: Vec::new() };
        let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.clone(), kind };
        let bench = ExploreBench::new(&sources, manual, variant).expect("a bench");
        let reference = LearnedReference::new(&dut).expect("a reference device");
        let options = CampaignOptions { seed: 1, sequences: Some(SEQUENCES), ..CampaignOptions::default() };
        let began = Instant::now();
        let result = Campaign::new(&bench, &dut, Some(reference), &options).run(&mut |_| {}).expect("a result");
        let minutes = began.elapsed().as_secs_f64() / 60.0;
        println!("{dut}: {:.0} sequences a minute, {} frames", SEQUENCES as f64 / minutes, result.frames);
    }
}
