//! The deliberate bugs of the XAC77, by topic: a name, a sentence, and the knob that it turns.
//!
//! A wrong function that takes more than a line stands in [`super::wrong`]. This room must not hold healthy behaviour:
//! that stands at the seam which reads the knob.

use super::parameters::{COMMISSIONING, MEMORY};
use super::wrong::*;
use crate::application::Severity;
use crate::bugs::{Behaviour, Bug};
use crate::encoder::measuring;
use crate::encoder::{Scaling, Unit};
use crate::profidrive::sensor::Preset;
use crate::profidrive::telegram::Image;
use crate::profidrive::user_parameters::{UserParameters, unit};

macro_rules! bugs {
    ($($name:literal $sentence:literal => |$behaviour:ident| $turn:expr;)*) => {
        &[$(Bug { name: $name, sentence: $sentence, apply: |$behaviour: &mut Behaviour| { $turn; } }),*]
    };
}

/// Every bug that a reference XAC77 can be told to have.
pub static BUGS: &[Bug] = bugs! {
    // Telegrams
    "control-words-swapped" "STW2_ENC and G1_STW are exchanged on reception."
        => |b| b.telegram.control_words = |[a, b]| [b, a];
    "positions-swapped" "G1_XIST1 and G1_XIST2 change places in the telegrams 81 to 83."
        => |b| b.telegram.order = positions_swapped;
    "velocity-before-xist2" "NIST_B stands before G1_XIST2 in the telegrams 83 and 84."
        => |b| b.telegram.order = velocity_before_xist2;
    "xist3-halves-swapped" "The two halves of G1_XIST3 are exchanged."
        => |b| b.telegram.put = xist3_halves_swapped;
    "position-little-endian" "The positions are sent least significant octet first."
        => |b| b.telegram.put = position_little_endian;
    "nist-a-from-upper-half" "NIST_A is the upper half of the 32-bit velocity."
        => |b| b.telegram.put = nist_a_from_upper_half;
    "nist-b-not-sign-extended" "A negative velocity has zeros in the upper half of NIST_B."
        => |b| b.telegram.put = nist_b_not_sign_extended;
    "error-code-in-upper-word" "Error codes stand in the upper half of G1_XIST2."
        => |b| b.telegram.emit = |_, now| Image { g1_xist2: if has_error(&now) { now.g1_xist2 << 16 } else { now.g1_xist2 }, ..now };
    "inputs-bad-with-sensor-error" "The provider status is bad while a sensor error is shown."
        => |b| b.telegram.emit = |_, now| Image { good: !has_error(&now), ..now };

    "reserved-bit-acts" "The reserved bit 10 of G1_STW parks the encoder as bit 14 does."
        => |b| b.telegram.control_words = |[a, b]| [a, b | (b & 0x0400) << 4];
    "status-bit-3-shows-error" "The unused bit 3 of ZSW2_ENC shows that there is an error."
        => |b| b.telegram.emit = |_, now| Image { zsw2_enc: now.zsw2_enc | if has_error(&now) { 0x0008 } else { 0 }, ..now };
    "status-bit-10-shows-motion" "The reserved bit 10 of G1_ZSW shows that the shaft turns."
        => |b| b.telegram.emit = |_, now| Image { g1_zsw: now.g1_zsw | if now.velocity == 0 { 0 } else { 0x0400 }, ..now };
    "xist1-shows-error" "The error code stands in G1_XIST1 as well."
        => |b| b.telegram.emit = |_, now| Image { g1_xist1: if has_error(&now) { now.g1_xist2 } else { now.g1_xist1 }, ..now };

    // Connection
    "any-telegram-accepted" "The ident number of the telegram's submodule is not checked."
        => |b| b.stack.checks_submodule_ident = false;
    "output-length-not-checked" "The length of the outputs is not compared in Connect."
        => |b| b.stack.checks_output_length = false;
    "module-difference-not-reported" "Connect and ApplicationReady do not say that something else is plugged."
        => |b| b.stack.reports_module_diff = false;
    "good-inputs-before-ready" "The inputs are good before ApplicationReady."
        => |b| b.stack.inputs_wait_for_ready = false;
    "outputs-not-watched" "The connection does not end when no outputs come."
        => |b| b.stack.watches_outputs = false;

    // Control by PLC
    "control-by-plc-ignored" "G1_STW is obeyed without Control by PLC."
        => |b| b.control.is_valid = |_, _| true;
    "control-by-plc-needed-in-compatibility-mode" "Control by PLC is demanded in compatibility mode too."
        => |b| b.control.is_valid = |_, by_plc| by_plc;
    "control-requested-always-set" "Bit 9 of ZSW2_ENC is always 1 without compatibility mode."
        => |b| b.control.is_requested = |compatible, _| !compatible;
    "control-requested-never-set" "Bit 9 of ZSW2_ENC is always 0."
        => |b| b.control.is_requested = |_, _| false;
    "control-requested-in-compatibility-mode" "Bit 9 of ZSW2_ENC follows Control by PLC in compatibility mode too."
        => |b| b.control.is_requested = |_, by_plc| by_plc;

    // Signs of life
    "sign-of-life-through-zero" "The sign of life counts 0 to 15."
        => |b| b.life_sign.next = |sign| (sign + 1) % 16;
    "sign-of-life-stops-in-park" "The sign of life of the encoder stands still while it is parked."
        => |b| b.life_sign.counts_while_parked = false;
    "sign-of-life-stops-on-error" "The sign of life of the encoder stands still while it shows an error."
        => |b| b.life_sign.counts_with_error = false;
    "zero-life-sign-is-failure" "A controller that sends 0 all the time raises an error."
        => |b| b.life_sign.begins = |_| true;
    "life-sign-tolerance-off-by-one" "The error comes one failure too early."
        => |b| b.life_sign.tolerated = |number| i32::from(number) - 1;
    "life-sign-255-is-minus-one" "A tolerance of 255 counts as -1."
        => |b| b.life_sign.tolerated = |number| i32::from(number as i8);
    "life-sign-failures-add-up" "Tolerated failures are never forgotten."
        => |b| b.life_sign.good = 0;
    "life-sign-needs-control" "The sign of life of the controller is monitored under Control by PLC only."
        => |b| b.life_sign.watches_without_control = false;
    "life-sign-tolerance-in-v41-mode" "Octet 17 of the start-up record counts without compatibility mode too."
        => |b| b.life_sign.tolerated_without_compatibility = |number| number;

    // Preset
    "relative-preset-assigns" "A relative preset sets the position instead of shifting it."
        => |b| b.measuring.relative = measuring::absolute;
    "second-relative-preset-ignored" "Only the first relative preset has an effect."
        => |b| b.measuring.relative = |preset| preset.value % preset.range;
    "relative-shift-reversed" "A relative preset shifts the position down by its value."
        => |b| b.measuring.relative = relative_shift_reversed;
    "only-first-preset" "Only the first absolute preset has an effect."
        => |b| b.measuring.absolute = |preset| if preset.offset == 0 { measuring::absolute(preset) } else { preset.offset };
    "preset-in-hardware-steps" "The preset value counts steps of the hardware although scaling is on."
        => |b| b.measuring.value = |value, steps, units| value * units / steps;
    "preset-uses-stored-value" "A preset takes P65000 as it was saved and not as it is."
        => |b| b.memory.presets_stored_value = true;
    "preset-adds-instead-of-assigns" "An absolute preset adds its value to the position."
        => |b| b.measuring.absolute = measuring::relative;
    "preset-on-falling-edge" "The preset is carried out when the request is taken back."
        => |b| b.sensor.begins_preset = |before, now| before.home && !now.home;
    "preset-repeats-while-requested" "The preset is carried out again and again while the request is held."
        => |b| b.sensor.begins_preset = |_, now| now.home;
    "mode-change-repeats-preset" "A change of bit 11 during a request carries out another preset."
        => |b| b.sensor.begins_preset = |before, now| now.home && (!before.home || before.relative != now.relative);
    "preset-never-acknowledged" "Bit 12 of G1_ZSW is never set."
        => |b| b.sensor.acknowledges_preset = |_| false;
    "preset-acknowledgement-is-a-pulse" "Bit 12 of G1_ZSW is set for one frame only."
        => |b| b.telegram.emit = |before, now| Image { g1_zsw: now.g1_zsw & !(before.truth.g1_zsw & EXECUTED), ..now };
    "preset-acknowledged-too-early" "The preset is acknowledged before the position is shifted."
        => |b| b.sensor.acknowledges_preset = |preset| preset != Preset::Idle;
    "preset-acknowledge-stays" "The acknowledgement of a preset is never taken back."
        => |b| b.sensor.releases_preset = false;
    "preset-mode-alone-shifts" "Bit 11 of G1_STW carries out a relative preset by itself."
        => |b| (b.sensor.asks_for_preset, b.sensor.begins_preset) = (has_mode, mode_begins);
    "writing-preset-value-presets" "Writing P65000 sets the position at once."
        => |b| b.values.preset_value_presets = true;
    "preset-control-inverted" "G1_XIST1 preset control has the natural polarity: 1 is enabled."
        => |b| b.user_parameters.understand = |user| UserParameters { preset_acts_on_xist1: !user.preset_acts_on_xist1, ..user };
    "preset-control-gates-all-positions" "G1_XIST1 preset control acts on G1_XIST2 and G1_XIST3 as well."
        => |b| b.user_parameters.presets_xist2 = |user| user.preset_acts_on_xist1;
    "preset-without-class-4" "A preset is carried out although class 4 is off."
        => |b| b.user_parameters.presets = |_| true;
    "position-not-reduced" "The sum of position and offset is not reduced to the measuring range."
        => |b| b.measuring.shift = |position, offset, _| position + offset;
    "offset-sign-reversed" "P65001 shows the offset with the opposite sign."
        => |b| b.values.offset = |offset, range| (range - offset) % range;

    // Parking
    "park-clears-position-first" "Positions are 0 one frame before the status bits follow."
        => |b| b.telegram.emit = park_clears_position_first;
    "parking-ignored" "A request to park has no effect."
        => |b| b.telegram.control_words = |[a, b]| [a, b & !PARKED];
    "park-never-ends" "The encoder stays parked when the request is taken back."
        => |b| b.telegram.emit = park_never_ends;
    "speed-while-parked" "The velocity is measured while parked."
        => |b| b.sensor.parking_stops_velocity = false;
    "absolute-value-lost-in-park" "After parking the position has to be requested anew."
        => |b| b.telegram.emit = absolute_value_lost_in_park;
    "unpark-status-first" "The park bit falls one frame before the position is refreshed."
        => |b| b.telegram.emit = unpark_status_first;
    "park-keeps-preset-bit" "The acknowledgement of a preset stays set while parked."
        => |b| b.sensor.parking_ends_preset = false;
    "park-freezes-position" "G1_XIST1 and G1_XIST3 keep their last value while parked."
        => |b| b.telegram.emit = park_freezes_position;
    "errors-while-parked" "New errors are raised while parked."
        => |b| b.sensor.watches_while_parked = true;
    "error-survives-parking" "Parking does not clear an error."
        => |b| b.sensor.parking_clears_errors = false;
    "parks-while-turning" "The encoder parks without an error while the shaft turns."
        => |b| b.sensor.refuses_to_park = false;
    "park-wipes-persistent-error" "An error whose cause is still there does not come back after parking."
        => |b| b.sensor.looks_again_after_parking = false;
    "preset-while-parked" "A preset is carried out while parked."
        => |b| b.sensor.presets_while_parked = true;

    // Errors and their acknowledgement
    "acknowledge-clears-persistent" "Acknowledging hides an error whose cause is still there."
        => |b| b.sensor.clears = |_| true;
    "sensor-error-drops-for-a-frame" "The error bit is 0 for one frame while an acknowledgement is handled."
        => |b| b.telegram.emit = sensor_error_drops_for_a_frame;
    "error-bit-one-frame-late" "The error bit follows its code one frame later."
        => |b| b.telegram.emit = error_bit_one_frame_late;
    "acknowledge-without-answer" "Bit 11 of G1_ZSW is never set."
        => |b| b.telegram.emit = |_, now| Image { g1_zsw: now.g1_zsw & !IN_PROCESS, ..now };
    "acknowledge-answer-stays" "Bit 11 of G1_ZSW is never taken back."
        => |b| b.telegram.emit = |before, now| Image { g1_zsw: now.g1_zsw | before.sent.g1_zsw & IN_PROCESS, ..now };
    "acknowledge-answer-without-request" "Bit 11 of G1_ZSW is set with each error."
        => |b| b.telegram.emit = |_, now| Image { g1_zsw: now.g1_zsw | if has_error(&now) { IN_PROCESS } else { 0 }, ..now };
    "acknowledge-stops-transfer" "An acknowledgement without an error ends the transfer of the position."
        => |b| b.telegram.emit = |_, now| if now.request.acknowledge { without_transfer(now) } else { now };
    "stw2-bit-7-acknowledges" "Bit 7 of STW2_ENC acknowledges errors."
        => |b| b.telegram.control_words = |[a, b]| [a, b | (a & 0x0080) << 8];
    "error-clears-itself" "A latched error goes away with its cause."
        => |b| b.sensor.latches = false;
    "error-needs-request" "The error code is shown only while the position is requested."
        => |b| b.telegram.emit = error_needs_request;
    "life-sign-shown-as-bus-cycle" "A lost sign of life is shown with the code of a missed bus cycle."
        => |b| b.telegram.emit = |_, now| Image { g1_xist2: if has_error(&now) && now.g1_xist2 == 0x0F02 { 0x0F04 } else { now.g1_xist2 }, ..now };

    // G1_XIST2
    "xist2-always-shows-position" "G1_XIST2 shows the position although it is not requested."
        => |b| b.telegram.emit = xist2_always_shows_position;
    "xist2-keeps-last-value" "G1_XIST2 keeps its last value when neither position nor error is shown."
        => |b| b.telegram.emit = xist2_keeps_last_value;
    "xist2-one-frame-late" "G1_XIST2 shows the position of the frame before."
        => |b| b.telegram.emit = xist2_one_frame_late;
    "absolute-value-not-served" "The request for the position in G1_XIST2 has no effect."
        => |b| b.telegram.emit = |_, now| without_transfer(now);
    "absolute-value-never-ends" "The transfer of the position goes on when the request is taken back."
        => |b| b.telegram.emit = absolute_value_never_ends;
    "position-bit-stays-with-error" "Bit 13 of G1_ZSW stays set when an error displaces the position."
        => |b| b.telegram.emit = position_bit_stays_with_error;
    "position-bit-lost-after-error" "After an error the position has to be requested anew."
        => |b| b.telegram.emit = position_bit_lost_after_error;
    "position-unrequested-after-error" "After an error the position is shown although it is not requested."
        => |b| b.telegram.emit = position_unrequested_after_error;

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

    // Start-up record
    "record-length-not-checked" "A record 0xBF00 of another length is accepted."
        => |b| b.user_parameters.checks_length = false;
    "record-taken-once" "Only the first record 0xBF00 after power-up is taken over."
        => |b| b.user_parameters.takes_every_record = false;
    "class-4-always-on" "The class 4 bit is not looked at."
        => |b| b.user_parameters.understand = |user| UserParameters { class_4: true, ..user };
    "code-sequence-ignored" "The position rises clockwise whatever the record says."
        => |b| b.user_parameters.directs = |_| false;
    "code-sequence-without-class-4" "The code sequence acts although class 4 is off."
        => |b| b.user_parameters.directs = |_| true;
    "scaling-without-class-4" "Scaling acts although class 4 is off."
        => |b| b.user_parameters.scales = |user| user.scaling;
    "compatibility-inverted" "Compatibility mode has the natural polarity: 1 is enabled."
        => |b| b.user_parameters.understand = |user| UserParameters { compatible: !user.compatible, ..user };
    "upper-scaling-octets-ignored" "Only the lower 32 bits of the scaling parameters count."
        => |b| b.user_parameters.understand = upper_scaling_octets_ignored;
    "units-and-range-exchanged" "Units per revolution and total range change places."
        => |b| b.user_parameters.understand = units_and_range_exchanged;
    "full-range-refused" "The whole range of the hardware is taken for an impossible one."
        => |b| b.user_parameters.greatest_range = |range| range - 1;
    "default-range-of-one-revolution" "Without scaling the total range is one revolution."
        => |b| b.user_parameters.unscaled = range_of_one_revolution;
    "default-speed-unit-rpm" "Without a record the velocity is given in rpm."
        => |b| b.user_parameters.default = default_speed_unit_rpm;
    "impossible-scaling-accepted" "A ratio that the hardware cannot serve is accepted in silence."
        => |b| b.user_parameters.checks_ratio = false;
    "speed-unit-not-checked" "An unknown velocity unit is taken as steps per second in silence."
        => |b| b.user_parameters.unit = |number| unit(number).or(Some(Unit::PerSecond));

    // Scaling and velocity
    "red-zone-forward-only" "The jump at the physical zero is missing when turning backwards."
        => |b| b.measuring.beyond = red_zone_forward_only;
    "red-zone-one-late" "The jump comes one position later."
        => |b| b.measuring.beyond = red_zone_one_late;
    "speed-overflows" "The 16-bit speed wraps instead of stopping at its limit."
        => |b| b.telegram.put = speed_overflows;
    "speed-units-exchanged" "The two unit codes 1 and 2 are swapped."
        => |b| b.user_parameters.unit = speed_units_exchanged;
    "speed-without-sign" "The velocity is a magnitude."
        => |b| b.telegram.emit = |_, now| Image { velocity: now.velocity.abs(), ..now };
    "speed-in-hardware-steps" "The velocity counts steps of the hardware although scaling is on."
        => |b| b.user_parameters.scales_velocity = |_, hardware| Scaling::hardware(hardware);

    // Memory
    "offset-only-in-ram" "The offset is lost at power-off."
        => |b| b.memory.stores_offset = false;
    "every-write-is-stored" "P65000 goes to memory without P971."
        => |b| b.memory.stores_every_write = true;
    "preset-acknowledged-before-stored" "The preset is acknowledged while the offset is still being written."
        => |b| b.memory.waits_for_store = false;
    "memory-error-swallowed" "A preset whose offset could not be stored is acknowledged."
        => |b| b.memory.heeds_failure = false;
    "p971-takes-any-value" "Any value written to P971 starts a save."
        => |b| b.values.saves = |value| Some(value != 0);
    "p971-confirms-too-early" "P971 reads 0 before the save is done."
        => |b| b.values.save_is_shown = false;
    "save-never-ends" "P971 reads 1 for ever once it was written."
        => |b| b.memory.ends_save = false;
    "scaling-remembered" "The first record 0xBF00 stays in force for good, over a power cycle too."
        => |b| (b.memory.keeps_user_parameters, b.user_parameters.takes_every_record) = (true, false);
    "name-lost-at-power-off" "The station name is lost at power-off."
        => |b| b.memory.stores_name = false;
    "position-restored-from-memory" "After power-up the position is the one before, wherever the shaft is."
        => |b| b.memory.keeps_position = true;
    "memory-fault-ignored-at-power-up" "A memory that cannot be read at power-up is taken for an empty one."
        => |b| b.memory.reports_unreadable = false;

    // Factory reset and station name
    "reset-answered-and-not-done" "A factory reset is answered positively and does not take place."
        => |b| b.stack.executes_reset = false;
    "reset-refused-while-connected" "A factory reset is refused while data are exchanged."
        => |b| b.reset.refused_while_connected = true;
    "reset-keeps-preset-value" "P65000 survives the factory reset."
        => |b| b.reset.keeps_preset_value = true;
    "reset-keeps-offset" "The offset survives the factory reset."
        => |b| b.reset.keeps_offset = true;
    "reset-keeps-name" "The station name survives the factory reset."
        => |b| b.reset.keeps_name = true;
    "reset-keeps-gateway" "The gateway survives the factory reset."
        => |b| b.reset.keeps_gateway = true;
    "name-check-total-length-only" "Only the total length of a name is checked."
        => |b| b.names.checks_labels = false;
    "name-check-ascii-missing" "Octets above 7F are accepted in a name."
        => |b| b.names.is_allowed = |octet| octet.is_ascii_alphanumeric() || octet == b'-' || !octet.is_ascii();
    "digit-first-refused" "A name whose label begins with a digit is refused."
        => |b| b.names.may_begin = |octet| octet != b'-' && !octet.is_ascii_digit();
    "dash-at-the-ends-accepted" "A label may begin and end with a dash."
        => |b| (b.names.may_begin, b.names.may_end) = (|_| true, |_| true);
    "name-prefix-answered" "Whoever looks for the beginning of the name is answered."
        => |b| b.stack.answers_to = |own, asked| own.starts_with(asked);
    "station-type-of-the-stack" "The type of the station is that of a sample application."
        => |b| b.stack.station_type = |_| "SAMPLE DEVICE";
    "mask-ignored" "The subnet mask of a Set is not taken over."
        => |b| b.stack.mask = |current, _| current;

    // Records
    "im0-length-counts-header" "The length in the header of I&M0 counts the header too."
        => |b| b.stack.im0_length = |length| length + 6;
    "im1-accepted" "Writing I&M1 is accepted and lost."
        => |b| b.stack.refuses_missing_im = false;
    "unknown-index-answered" "Unknown records are read as empty ones."
        => |b| b.stack.refuses_unknown_index = false;

    // Diagnosis
    "fault-bits-exchanged" "Memory and commissioning change places in P65001."
        => |b| b.values.faults = fault_bits_exchanged;
    "faults-never-set" "The faults in P65001 are always 0."
        => |b| b.values.faults = |_| 0;
    "faults-show-supported" "The faults in P65001 are those that are supported."
        => |b| b.values.faults = |_| MEMORY.1 | COMMISSIONING.1;
    "one-alarm-for-all" "A second fault replaces the first one in the alarm channel."
        => |b| b.diagnosis.side_by_side = false;
    "alarm-never-disappears" "A channel diagnosis stays when its fault has gone."
        => |b| b.diagnosis.disappear = false;
    "alarm-switch-in-v41-mode" "Alarm channel control acts without compatibility mode too."
        => |b| b.diagnosis.are_sent = |_, alarm_channel| alarm_channel;
    "alarm-switch-inverted" "Alarm channel control has the opposite polarity: 1 is off."
        => |b| b.diagnosis.are_sent = |compatible, alarm_channel| !compatible || !alarm_channel;
    "fault-reported-as-maintenance" "A fault is reported as a need for maintenance."
        => |b| b.diagnosis.severity = Severity::MaintenanceRequired;
};
