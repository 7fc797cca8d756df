//! The compiled suites are what the files beside this one say.

use super::{SHIPPED, sources};
use std::path::Path;
use std::time::Duration;
use suite::compiled;
use suite::model::Manual;
use suite_yaml::{ANY_DEVICE, BenchTimes, Sources, load};

/// The suites as the files have them, shown as in a checkout.
fn files() -> Sources {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    Sources::folder(here).expect("the folder can be read").shown_in(Path::new("suites"))
}

fn loaded(sources: &Sources) -> Vec<Manual> {
    load(sources, None).unwrap_or_else(|errors| panic!("{errors}"))
}

#[test]
fn each_manual_is_compiled_and_no_other() {
    let names: Vec<&str> = SHIPPED.manuals.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, files().manuals());
}

/// Neither the order in which hash maps give their entries nor the folder of the build shows in the octets.
#[test]
fn the_files_compile_to_the_octets_that_are_built_in() {
    for _ in 0..2 {
        for (manual, (name, octets)) in loaded(&files()).iter().zip(&SHIPPED.manuals) {
            assert_eq!(manual.device.name, *name);
            assert!(compiled::write(manual).expect("octets") == *octets, "{name}");
        }
    }
}

#[test]
fn nothing_is_lost_between_octets_and_manual() {
    for (name, octets) in &SHIPPED.manuals {
        let manual = compiled::read(octets).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(compiled::write(&manual).expect("octets") == *octets, "{name}");
    }
}

#[test]
fn a_manual_that_was_read_is_the_one_that_was_compiled() {
    for (read, made) in loaded(&sources()).iter().zip(&loaded(&files())) {
        assert_eq!(format!("{:?}", read.device), format!("{:?}", made.device));
        assert_eq!(format!("{:?}", read.requirements), format!("{:?}", made.requirements));
        assert_eq!(format!("{:?}", read.bugs), format!("{:?}", made.bugs));
        assert_eq!(read.unused, made.unused);
        assert_eq!(read.variants.len(), made.variants.len());
        for (read, made) in read.variants.iter().zip(&made.variants) {
            assert_eq!((&read.name, &read.paths, &read.types), (&made.name, &made.paths, &made.types));
            assert_eq!(format!("{:?}", read.names), format!("{:?}", made.names));
            assert_eq!(format!("{:?}", read.rules), format!("{:?}", made.rules));
            assert_eq!(format!("{:?}", read.derived), format!("{:?}", made.derived));
            assert_eq!(read.trials.len(), made.trials.len());
            for (read, made) in read.trials.iter().zip(&made.trials) {
                assert!(format!("{read:?}") == format!("{made:?}"), "{}", made.id);
            }
        }
    }
}

#[test]
fn whatever_changes_a_text_has_its_manual_compiled_again() {
    let broken = sources().with("lika-xac77-profinet/rules.yaml", "rules: [");
    assert!(load(&broken, Some("lika-xac77-profinet")).is_err());
    assert!(load(&broken, Some(ANY_DEVICE)).is_ok());
    let broken = sources().with("common/parking.yaml", "common: [");
    assert!(load(&broken, Some("lika-xac77-profinet")).is_err());
    let broken = sources().with_description(Path::new("mine.yaml"), "title: [");
    assert!(load(&broken, Some(ANY_DEVICE)).is_err());
}

#[test]
fn the_times_of_a_bench_are_compiled_in() {
    let times = BenchTimes { cycle: Some(Duration::from_millis(4)), patience: Some(3), ..BenchTimes::default() };
    let manuals = load(&sources().on_bench(times), Some(ANY_DEVICE)).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(manuals[0].device.timing.patience, 3);
}
