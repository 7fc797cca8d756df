//! The bytes of a record.

use suite::device::DeviceRecord;

/// The bytes of a record with these fields set, and all others as in its template.
pub fn octets(record: &DeviceRecord, values: impl Iterator<Item = (usize, i128)>) -> Vec<u8> {
    let mut octets = record.bytes();
    for (field, value) in values {
        put(record, field, value, &mut octets);
    }
    octets
}

/// Writes a number into a field of a record.
pub fn put(record: &DeviceRecord, field: usize, value: i128, octets: &mut [u8]) {
    let Some(field) = record.fields.get(field).filter(|field| field.absent.is_none()) else { return };
    let Some(place) = octets.get_mut(field.octet..field.octet + field.octets) else { return };
    let old = place.iter().fold(0u128, |number, &octet| (number << 8) | u128::from(octet));
    let (low, width) = field.bits.unwrap_or((0, field.octets as u32 * 8));
    let mask = if width >= 128 { u128::MAX } else { ((1u128 << width) - 1) << low };
    let mut number = (old & !mask) | (((value as u128) << low) & mask);
    for octet in place.iter_mut().rev() {
        *octet = number as u8;
        number >>= 8;
    }
}
