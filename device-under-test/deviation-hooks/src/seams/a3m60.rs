//! Deviations at the hooks of the A3M60, and its user bytes in Set_Prm.

use super::Deviations;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use device_stack::profibus::SlaveHooks;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::profidrive::telegram::SignalImage;
use reference_devices::models::sick_a3m60::hooks::{A3m60Check, A3m60Event, A3m60Hooks, A3m60Memory, VendorWrite};
use reference_devices::models::sick_a3m60::set_prm::{OCTETS, UserByteFields};
use reference_devices::models::sick_a3m60::status::SensorStatusWords;
use reference_devices::models::sick_a3m60::{A3m60State, IsochronousTimes};
use station::StandAction;
use wire::profibus::prm::{Dpv1Status3, PrmBlock, PrmBlockType, SetPrm};

hooks! { A3m60: A3m60Hooks
    /// Changes a decision, given the check and the decision of the encoder.
    check(check: A3m60Check) -> bool;
    /// Changes the settings in force after a Set_Prm without user bytes.
    delivered() -> UserByteFields;
    /// Changes the positions of the address switches.
    switches() -> [u32; 2];
    /// Changes the shaft position that the sensor reads.
    place(encoder: &PoweredEncoder<'_, A3m60State>) -> i64;
    /// Changes the times of isochronous operation.
    times() -> Option<IsochronousTimes>;
    /// Changes S_STAT-A and S_STAT-B.
    status(encoder: &PoweredEncoder<'_, A3m60State>) -> SensorStatusWords;
    /// Changes the error numbers of the diagnosis blocks.
    diagnosis(encoder: &PoweredEncoder<'_, A3m60State>) -> Vec<u8>;
    /// Changes the fault code that is sent instead of the position.
    fault_code(encoder: &PoweredEncoder<'_, A3m60State>) -> Option<i32>;
    /// Changes the signals of a frame.
    image(encoder: &PoweredEncoder<'_, A3m60State>) -> SignalImage;
    /// Changes what is written to a vendor parameter.
    write(write: &mut VendorWrite, memory: &mut A3m60Memory<'_>);
    /// Changes the contents of the memory at an event.
    happens(event: A3m60Event, memory: &mut A3m60Memory<'_>);
}

impl Deviations {
    /// Tracks a value of an A3M60 for deviations at other hooks; the value starts as `first` and is updated by `track`.
    pub fn track<T: Copy + 'static>(
        &mut self,
        first: T,
        mut note: impl FnMut(&PoweredEncoder<'_, A3m60State>, SensorStatusWords, T) -> T + 'static,
    ) -> Rc<Cell<T>> {
        let tracked = Rc::new(Cell::new(first));
        let updated = tracked.clone();
        self.a3m60.status(move |encoder, words| {
            updated.set(note(encoder, words, updated.get()));
            words
        });
        tracked
    }

    /// Tracks S_STAT-A and S_STAT-B.
    pub fn track_status(&mut self) -> Rc<Cell<SensorStatusWords>> {
        self.track(SensorStatusWords::default(), |_, words, _| words)
    }

    /// Tracks whether the stand has raised the fault of this name.
    pub fn track_fault(&mut self, name: &'static str) -> Rc<Cell<bool>> {
        struct FaultTracker(&'static str, Rc<Cell<bool>>);

        impl SlaveHooks for FaultTracker {
            fn act(&mut self, action: &StandAction<'_>) {
                match *action {
                    StandAction::Fault(name, present) if name == self.0 => self.1.set(present),
                    _ => {}
                }
            }
        }

        let tracked = Rc::new(Cell::new(false));
        self.slave.add(FaultTracker(name, tracked.clone()));
        tracked
    }

    /// Changes the parsed user bytes of an A3M60.
    pub fn fields(&mut self, mut change: impl FnMut(UserByteFields) -> UserByteFields + 'static) {
        self.slave.parameters(move |parameters| with_fields(parameters, &mut change));
    }

    /// Changes the user bytes of an A3M60.
    pub fn user_octets(&mut self, mut change: impl FnMut(&mut Vec<u8>) + 'static) {
        self.slave.parameters(move |parameters| with_user_octets(parameters, &mut change));
    }
}

/// Changes the user bytes of a Set_Prm: those in their own block, or those before the blocks.
pub fn with_user_octets(parameters: &mut SetPrm, change: &mut dyn FnMut(&mut Vec<u8>)) {
    let Some(head) = parameters.dpv1() else { return };
    let after_dpv1 = parameters.user_after_dpv1().to_vec();
    let is_structured = head.status_3.has(Dpv1Status3::PRM_STRUCTURE);
    parameters.user.truncate(3);
    let blocks = PrmBlock::parse_all(&after_dpv1).ok().filter(|_| is_structured);
    let of_user = |block: &PrmBlock| block.kind == PrmBlockType::USER_PRM_DATA;
    if let Some(mut blocks) = blocks.filter(|blocks| blocks.iter().any(of_user)) {
        for block in &mut blocks {
            if of_user(block) {
                change(&mut block.data);
            }
            block.write(&mut parameters.user);
        }
        return;
    }
    let (octets, blocks) = after_dpv1.split_at(after_dpv1.len().min(OCTETS));
    let is_followed_by_blocks = PrmBlock::parse_all(blocks).is_ok();
    let (mut octets, blocks) =
        if is_followed_by_blocks { (octets.to_vec(), blocks) } else { (after_dpv1.clone(), &[][..]) };
    change(&mut octets);
    parameters.user.extend(octets);
    parameters.user.extend_from_slice(blocks);
}

/// Changes the parsed user bytes of a Set_Prm if their number is right.
pub fn with_fields(parameters: &mut SetPrm, change: &mut dyn FnMut(UserByteFields) -> UserByteFields) {
    with_user_octets(parameters, &mut |octets| {
        if let Some(fields) = UserByteFields::parse(octets).filter(|_| octets.len() == OCTETS) {
            put_fields(octets, &change(fields));
        }
    });
}

fn put_fields(octets: &mut [u8], fields: &UserByteFields) {
    let UserByteFields { switches, units, range, failures, speed_unit, nominator, divisor, samples } = *fields;
    octets[..2].copy_from_slice(&switches);
    octets[2..6].copy_from_slice(&units.to_be_bytes());
    octets[6..10].copy_from_slice(&range.to_be_bytes());
    octets[10..12].copy_from_slice(&[failures, speed_unit]);
    octets[12..16].copy_from_slice(&nominator.to_be_bytes());
    octets[16..20].copy_from_slice(&divisor.to_be_bytes());
    octets[20] = samples;
}
