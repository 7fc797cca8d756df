//! Start parameters at other places than in the tables of a reference device, as the description of another vendor may have them.
//!
//! The device itself keeps its layout: what a controller sends is put into the places of the device before anything else sees it.

use super::slave::SlaveDeviations;
use alloc::vec;
use alloc::vec::Vec;
use device_stack::profinet::RecordAccess;
use encoder_profile::hooks::{EncoderHooks, EncoderView, RecordOctets};
use wire::profibus::prm::{Dpv1Status3, PrmBlock, PrmBlockType, SetPrm};
use wire::profibus::sap::SlaveSap;

/// Where a parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In whole bytes: the offset of the first one, and their number.
    Bytes(usize, usize),
    /// In one bit: the offset of its byte, and its number.
    Bit(usize, u32),
}

/// The bytes of start parameters in the tables of a device.
#[derive(Clone, Copy, Debug)]
pub struct StartTable {
    /// The index of their record; without one they are the user bytes of Set_Prm after those of DP-V1.
    pub record: Option<u16>,
    /// The number of bytes.
    pub octets: usize,
    /// The places of the parameters.
    pub places: &'static [Place],
}

/// A layout of start parameters that is not that of the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartLayout {
    /// The number of bytes of the device's own layout.
    own_octets: usize,
    /// The bytes before any parameter is set. What is no parameter of the manual has to be sent like this.
    pub default: Vec<u8>,
    /// The places of each parameter: in the device, and in this layout.
    pub places: Vec<(Place, Place)>,
}

impl StartTable {
    /// A layout in another order, with gaps, more bytes, and bits in other bytes; the same for a seed on every machine.
    pub fn elsewhere(&self, seed: u64) -> StartLayout {
        let mut numbers = Numbers(seed);
        let is_bit = |place: &&Place| matches!(place, Place::Bit(..));
        let bits = self.places.iter().filter(is_bit).count();
        let bit_bytes = if bits == 0 { 0 } else { bits.div_ceil(8) + numbers.below(2) };
        // Blocks of whole bytes: those of a parameter, and those in which the bits are.
        let whole = self.places.iter().filter(|place| !is_bit(place)).copied();
        let mut blocks: Vec<Option<Place>> = whole.map(Some).chain(vec![None; bit_bytes]).collect();
        numbers.shuffle(&mut blocks);
        let (mut places, mut free_bits) = (Vec::new(), Vec::new());
        let mut at = numbers.below(4);
        for block in blocks {
            match block {
                Some(own @ Place::Bytes(_, count)) => {
                    places.push((own, Place::Bytes(at, count)));
                    at += count;
                }
                Some(Place::Bit(..)) | None => {
                    free_bits.extend((0..8).map(|bit| Place::Bit(at, bit)));
                    at += 1;
                }
            }
            at += numbers.below(3);
        }
        numbers.shuffle(&mut free_bits);
        places.extend(self.places.iter().filter(is_bit).copied().zip(free_bits));
        let default = (0..at + numbers.below(3)).map(|_| numbers.next() as u8).collect();
        StartLayout { own_octets: self.octets, default, places }
    }
}

impl StartLayout {
    /// What was sent in this layout, in that of the device. Bytes of another number than this layout has are still as many too few or
    /// too many, and so are those whose other parameters are not as the description has them.
    fn own(&self, sent: &[u8]) -> Vec<u8> {
        let mut own = vec![0; self.own_octets];
        if sent.len() != self.default.len() {
            let octets = (self.own_octets + sent.len()).saturating_sub(self.default.len());
            own.resize(octets.max(1), 0);
            return own;
        }
        let mut rest = sent.to_vec();
        for (to, from) in &self.places {
            copy(sent, *from, &mut own, *to);
            copy(&self.default, *from, &mut rest, *from);
        }
        if rest != self.default {
            own.push(0);
        }
        own
    }

    /// Adds this layout to a device with the tables `of`; it has to be the first of all deviations.
    pub(super) fn attach(self, of: StartTable, encoder: &mut super::encoder::Encoder, slave: &mut SlaveDeviations) {
        match of.record {
            Some(index) => encoder.add_first(OwnRecord { index, layout: self }),
            None => slave.request_first(SlaveSap::SET_PRM, move |data| {
                if let Ok(mut parameters) = SetPrm::parse(data) {
                    self.change(&mut parameters);
                    data.clear();
                    parameters.write(data);
                }
                true
            }),
        }
    }

    /// Changes the user bytes after those of DP-V1, in a block or before all blocks.
    fn change(&self, parameters: &mut SetPrm) {
        let Some(dpv1) = parameters.dpv1() else { return };
        let after = parameters.user_after_dpv1();
        let is_structured = dpv1.status_3.has(Dpv1Status3::PRM_STRUCTURE);
        let blocks = is_structured.then(|| PrmBlock::parse_all(after).ok()).flatten();
        let is_user = |block: &PrmBlock| block.kind == PrmBlockType::USER_PRM_DATA;
        let mut changed = dpv1.octets().to_vec();
        match blocks.filter(|blocks| blocks.iter().any(is_user)) {
            Some(blocks) => {
                for mut block in blocks {
                    if is_user(&block) {
                        block.data = self.own(&block.data);
                    }
                    block.write(&mut changed);
                }
            }
            None if after.is_empty() => {}
            None => {
                let (user, blocks) = after.split_at(after.len().min(self.default.len()));
                changed.extend(self.own(user));
                changed.extend(blocks);
            }
        }
        parameters.user = changed;
    }
}

/// Puts a parameter of `sent` into its place in `own`; both places are of one size.
fn copy(sent: &[u8], from: Place, own: &mut [u8], to: Place) {
    match (from, to) {
        (Place::Bytes(from, count), Place::Bytes(to, _)) => {
            let octets = sent.iter().skip(from).take(count);
            own.iter_mut().skip(to).zip(octets).for_each(|(own, octet)| *own = *octet);
        }
        (Place::Bit(from, bit), Place::Bit(to, own_bit)) => {
            let is_set = sent.get(from).is_some_and(|octet| octet >> bit & 1 != 0);
            let octet = own.get_mut(to).into_iter();
            octet.for_each(|octet| *octet = *octet & !(1 << own_bit) | u8::from(is_set) << own_bit);
        }
        (Place::Bytes(..), Place::Bit(..)) | (Place::Bit(..), Place::Bytes(..)) => {}
    }
}

/// Gives the encoder its record in the layout of its own tables.
struct OwnRecord {
    index: u16,
    layout: StartLayout,
}

impl EncoderHooks for OwnRecord {
    fn write_record(&mut self, _: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
        octets.map(|octets| if access.index == self.index { self.layout.own(&octets) } else { octets })
    }
}

/// Numbers that look random: SplitMix64.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number below `limit`.
    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }

    fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            let other = self.below(last + 1);
            items.swap(last, other);
        }
    }
}
