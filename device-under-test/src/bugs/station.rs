//! Bugs of connections, names, factory reset and records.

use super::Bug;

pub(crate) static BUGS: &[Bug] = bugs! {
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
};
