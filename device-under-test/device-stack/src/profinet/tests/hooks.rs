//! One deviation at each hook of the stack, observed by a controller.

use super::bench::*;
use super::toy::ToyIoApplication;
use super::{personas, requirements};
use crate::attached::Attached;
use crate::profinet::{
    DiagnosisChange, PluggableSubmodule, RecordAccess, StackCheck, StackHooks, StackView, StationData, StationLoad,
};
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::RefCell;
use rstest::rstest;
use wire::ethernet::Mac;
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::dcp::DcpValue;
use wire::profinet::rpc::RpcHeader;
use wire::profinet::status::RecordError;

/// Runs a device and returns whether it meets one requirement.
type HookTrial = fn(&mut StackBench) -> bool;

fn deviating(hooks: impl StackHooks + 'static) -> StackBench {
    StackBench::with(ToyIoApplication::new(), Attached::new(Rc::new(RefCell::new(hooks))))
}

/// Flips the decisions for which the function returns `Some`.
struct FlippedChecks(fn(StackCheck<'_>) -> Option<bool>);

impl StackHooks for FlippedChecks {
    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        (self.0)(check).unwrap_or(verdict)
    }
}

#[rstest]
#[case::addressed(|check: StackCheck<'_>| matches!(check, StackCheck::Addressed(_)).then_some(true), requirements::sets_for_other_devices_are_ignored)]
#[case::asked_name(|check: StackCheck<'_>| matches!(check, StackCheck::IdentifyName(..)).then_some(true), requirements::whole_name_is_compared)]
#[case::asked_all(|check: StackCheck<'_>| (check == StackCheck::IdentifyAll).then_some(false), requirements::answers_after_a_reset)]
#[case::input_length(|check: StackCheck<'_>| matches!(check, StackCheck::OutputLength(_)).then_some(true), requirements::output_length_is_compared)]
#[case::inputs_ready(|check: StackCheck<'_>| (check == StackCheck::InputsReady).then_some(true), requirements::inputs_are_bad_at_first)]
#[case::takes_outputs(|check: StackCheck<'_>| (check == StackCheck::TakesOutputs).then_some(false), requirements::outputs_have_a_consumer_status)]
#[case::provider_status(|check: StackCheck<'_>| matches!(check, StackCheck::ProviderStatus(_)).then_some(true), requirements::bad_status_makes_outputs_bad)]
#[case::too_long(|check: StackCheck<'_>| (check == StackCheck::RecordTooLong).then_some(false), requirements::record_is_cut)]
#[case::connection_limit(|check: StackCheck<'_>| matches!(check, StackCheck::ConnectionLimit { .. }).then_some(false), requirements::connections_come_and_go)]
#[case::class_3(|check: StackCheck<'_>| matches!(check, StackCheck::IocrField(_, 7)).then_some(true), requirements::class_3_is_refused)]
#[case::advanced(|check: StackCheck<'_>| matches!(check, StackCheck::ArField(_, 9)).then_some(false), personas::advanced)]
#[case::phase(|check: StackCheck<'_>| matches!(check, StackCheck::IocrField(_, 12)).then_some(false), personas::second_phase)]
#[case::ignored_block(|check: StackCheck<'_>| matches!(check, StackCheck::IgnoredBlock(_)).then_some(false), personas::fast_start_up)]
#[case::frame_id(|check: StackCheck<'_>| matches!(check, StackCheck::FrameId(_)).then_some(false), personas::proposed_frame_id)]
#[case::replaces(|check: StackCheck<'_>| (check == StackCheck::ReplacesConnection).then_some(false), personas::again_with_the_same_uuid)]
#[case::ends(|check: StackCheck<'_>| matches!(check, StackCheck::Ends(_)).then_some(false), personas::a_reset_ends_the_connection)]
#[case::outputs_end(|check: StackCheck<'_>| (check == StackCheck::OutputsEnd).then_some(false), personas::outputs_end_with_the_connection)]
#[case::plugged(|check: StackCheck<'_>| matches!(check, StackCheck::Plugged(_)).then_some(false), personas::has_im0)]
fn a_check_is_flipped(#[case] decides: fn(StackCheck<'_>) -> Option<bool>, #[case] meets_it: HookTrial) {
    assert!(!meets_it(&mut deviating(FlippedChecks(decides))));
}

/// Deviates at the seam of this name only.
struct DeviatingSeam(&'static str);

impl StackHooks for DeviatingSeam {
    fn received_frames(&mut self, _: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        if self.0 == "received_frames" { Vec::new() } else { frames }
    }

    fn sent_frame(&mut self, view: &StackView<'_>, frame: &mut Vec<u8>) {
        assert_eq!(view.mac, if self.0 == "mac" { Mac([0, 0, 0, 0, 0, 9]) } else { DEVICE });
        if self.0 == "sent_frame" {
            frame.clear();
        }
    }

    fn call(&mut self, _: &StackView<'_>, _: &RpcHeader, body: &mut Vec<u8>) {
        if self.0 == "call" {
            body.clear();
        }
    }

    fn access(&mut self, access: &mut RecordAccess) {
        if self.0 == "access" {
            access.slot = 99;
        }
    }

    fn read(&mut self, _: RecordAccess, result: &mut Result<Vec<u8>, RecordError>) {
        if self.0 == "read" {
            *result = Ok(Vec::new());
        }
    }

    fn written(&mut self, _: RecordAccess, _: &[u8], result: &mut Result<(), RecordError>) {
        if self.0 == "written" {
            *result = Ok(());
        }
    }

    fn element(&mut self, value: DcpValue) -> DcpValue {
        match value {
            DcpValue::NameOfStation(_) if self.0 == "element" => DcpValue::NameOfStation(Vec::new()),
            other => other,
        }
    }

    fn mac(&mut self, mac: Mac) -> Mac {
        if self.0 == "mac" { Mac([0, 0, 0, 0, 0, 9]) } else { mac }
    }

    fn load_station(&mut self, start: StationLoad, station: &mut StationData) {
        if self.0 == "load" && start == StationLoad::PowerUp {
            station.ip = [0; 4];
        }
    }

    fn set_station(&mut self, before: &StationData, _: &mut StationData, stored: &mut StationData) {
        if self.0 == "set" {
            stored.mask = before.mask;
        }
    }

    fn plugs(&mut self, plugs: &mut Vec<PluggableSubmodule>) {
        if self.0 == "plugs" {
            plugs.clear();
        }
    }

    fn difference(&mut self, all: &ModuleDiffBlock, differing: &mut Option<ModuleDiffBlock>) {
        if self.0 == "difference" {
            *differing = Some(all.clone()).filter(|_| differing.is_none());
        }
    }

    fn data_hold_time(&mut self, agreed: station::Duration) -> station::Duration {
        if self.0 == "data_hold_time" { agreed * 1000 } else { agreed }
    }

    fn diagnosis(&mut self, _: &mut DiagnosisChange, is_noted: bool) -> bool {
        is_noted && self.0 != "diagnosis"
    }

    fn aborts(&mut self, aborts: bool) -> bool {
        aborts || self.0 == "aborts"
    }
}

#[rstest]
#[case("received_frames", requirements::filter_by_type_matches)]
#[case("sent_frame", requirements::filter_by_type_matches)]
#[case("access", personas::has_im0)]
#[case("read", requirements::unknown_index_is_refused)]
#[case("written", requirements::missing_im_is_refused)]
#[case("element", requirements::reports_its_name)]
#[case("mac", requirements::has_its_own_mac)]
#[case("load", requirements::uses_the_stored_address)]
#[case("set", requirements::mask_is_taken)]
#[case("plugs", personas::has_im0)]
#[case("difference", personas::nothing_differs)]
#[case("data_hold_time", requirements::missing_outputs_are_detected)]
#[case("diagnosis", requirements::problem_is_indicated)]
fn a_seam_is_used(#[case] seam: &'static str, #[case] meets_it: HookTrial) {
    assert!(meets_it(&mut deviating(DeviatingSeam("none"))), "no deviation");
    assert!(!meets_it(&mut deviating(DeviatingSeam(seam))), "a deviation");
}

#[test]
fn a_deviation_can_end_all_connections() {
    let mut bench = deviating(DeviatingSeam("aborts"));
    assert!(bench.connect(&full_connect()).0.is_ok());
    assert!(super::connection::abort(&bench.take()).is_some());
}

#[test]
fn a_deviation_can_change_a_call() {
    let mut bench = deviating(DeviatingSeam("call"));
    let header = bench.header(wire::profinet::rpc::Opnum::CONNECT);
    let (answer, _) = bench.call(&header, &[0; 20]).unwrap();
    assert_eq!(answer.packet_type, wire::profinet::rpc::PacketType::FAULT);
}
