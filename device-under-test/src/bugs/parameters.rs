//! Bugs of base mode parameter access and the parameters.

use super::Bug;
use crate::encoder::Hardware;
use crate::models::lika_xac77::VARIANTS;

pub(crate) static BUGS: &[Bug] = bugs! {
    // Parameter access
    "unknown-parameter-reads-zero" "Unknown parameters read as 0."
        => |b| b.parameters.number = false;
    "read-only-write-acknowledged" "Writing a read-only parameter is answered positively."
        => |b| b.parameters.access = false;
    "subindex-past-end-reads-zero" "Elements behind the end of an array read as 0."
        => |b| b.parameters.end_of_array = false;
    "subindex-ignored-without-array" "The subindex is not looked at if the parameter is no array."
        => |b| b.parameters.array = false;
    "wrong-type-taken" "A value of another width is taken as it comes."
        => |b| b.parameters.takes = |_, _| true;
    "type-code-refused" "A value is taken with the code of its size only and not with that of its type."
        => |b| b.parameters.takes = |value, parameter| value == parameter;
    "value-count-not-checked" "The number of values is not compared with the number of elements."
        => |b| b.parameters.value_count = false;
    "zero-elements-refused" "A parameter that is no array is refused with 0 elements."
        => |b| b.parameters.zero_elements = false;
    "array-read-from-zero" "A run of elements always begins with subindex 0."
        => |b| b.parameters.first_element = |subindex, count| if count > 1 { 0 } else { subindex };
    "multi-read-answers-first-only" "Of several parameters in a request only the first is answered."
        => |b| b.parameters.answered = 1;
    "reference-always-one" "The response always carries the reference 1."
        => |b| b.parameters.reference = |_| 1;
    "attribute-not-checked" "Any attribute reads the value."
        => |b| b.parameters.attribute = false;
    "axis-not-checked" "Any DO-ID is answered."
        => |b| b.parameters.axis = false;
    "multi-write-stops-at-first-error" "After a refused parameter the others are not written."
        => |b| b.parameters.goes_on_after_error = false;
    "short-request-reads-old-buffer" "Missing octets are taken from the request before."
        => |b| b.parameters.length = false;
    "old-response-repeated" "A response can be read again and again."
        => |b| b.parameters.fetched_once = false;
    "p922-always-81" "P922 reads 81 whatever telegram is in use."
        => |b| b.values.telegram = |_| 81;
    "profile-version-constant" "P965 says version 41 in compatibility mode too."
        => |b| b.values.profile_version = |_| 41;
    "vendor-id-swapped" "The octets of the vendor ID are exchanged in P964 and P975."
        => |b| b.values.vendor = u16::swap_bytes;
    "sensor-format-of-the-other-variant" "P979 gives resolution and revolutions of the other variant."
        => |b| b.values.sensor_format = sensor_format_of_the_other_variant;
    "class-4-always-shown" "P65001 shows class 4 as on, whether it is or not."
        => |b| b.values.operating_status = |bits| bits | 0x02;
    "preset-control-shown-inverted" "P65001 shows G1_XIST1 preset control with the opposite sign."
        => |b| b.values.operating_status = |bits| bits ^ 0x04;
    "parameter-of-16-bits" "Only the lower 16 bits of P65000 are taken."
        => |b| b.values.preset_value = |value| value & 0xFFFF;
    "number-list-misses-one" "P980 leaves out P65001."
        => |b| b.values.listed = 8;
};

fn sensor_format_of_the_other_variant(hardware: Hardware) -> Hardware {
    VARIANTS.iter().map(|variant| variant.hardware).find(|other| *other != hardware).unwrap_or(hardware)
}
