//! Names, settings and services that only PROFIBUS has, or that mean something else there.

use super::super::keys::KeySet;
use super::super::request_keys::parameter_request;
use super::{Sentences, ServiceEntry};

/// Further names that every device on PROFIBUS has; those of `diag` come from the tables of the wire.
pub(super) const NAMES: Sentences = &[
    ("io.outputs", "the output data as bytes"),
    ("io.inputs", "the input data as bytes"),
    ("io.global_control", "whether the clock of isochronous mode comes: running, stopped"),
    ("io.clock_offset", "by how much it comes late"),
    ("io.diagnosis_pending", "the answer with the inputs had high priority: a new diagnosis is to be fetched"),
    ("diag.length", "bytes of the last diagnosis"),
    ("diag.bytes", "the diagnosis as bytes"),
    ("diag.ident", "the ident number in it"),
    ("diag.master", "the address of the master in it; 255 for none"),
    ("diag.errors", "a set of words for the codes in its blocks"),
    ("diag.alarm_type", "the type of the first alarm of DP-V1 in it; 0 without an alarm"),
    ("diag.alarm_slot", "the slot of that alarm"),
    ("diag.alarm_change", "bits 0 and 1 of its specifier: 1 appears, 2 disappears, 3 disappears and others remain"),
    ("diag.alarm_specifier", "the specifier of that alarm, which Alarm_Ack returns"),
    (
        "device",
        "as_delivered: one as it was delivered takes its place, with nothing stored, at the address that it comes with",
    ),
    ("cfg.bytes", "the identifiers in the answer to Get_Cfg"),
    ("station.address", "the station address at which a device of the right ident number answers"),
    ("answer.set_prm", "the last answer to Set_Prm"),
    ("answer.chk_cfg", "the last answer to Chk_Cfg"),
    ("bench.station", "the station address that the device has on the bench"),
    ("bench.free_station", "a station address that no station has"),
    ("bench.second", "the station address of the second master"),
];

key_set! {
    pub(crate) slave_connection "a connection on PROFIBUS" {
        module may Name, "The module.";
        cycle may Time, "The time from one Data_Exchange to the next; by default that of the bench, else 4ms.";
        watchdog may TimeOrNone, "The time without a master after which the slave gives up, or `none`; by default that of the bench, else 1s.";
        baud may Whole(0, 0xFFFF_FFFF), "The transmission rate of the bus in bits per second; by default that of the bench.";
        isochronous may Time, "The time from one clock of isochronous mode to the next, which is the cycle then.";
        instead may StartInstead, "What is changed against the right start-up.";
    }
}

key_set! {
    pub(crate) data_set "the position of a data set" {
        slot may Whole(0, 0xFF), "Slot of the data set.";
        index may Whole(0, 0xFF), "Its index.";
    }
}

/// What can be changed in a parameter request: all but the position of its record, which a data set has not.
pub(crate) static PARAMETER_REQUEST: KeySet = KeySet {
    name: "slave_parameter_request",
    what: "instead in a parameter request on PROFIBUS",
    keys: &[
        &parameter_request::reference,
        &parameter_request::request,
        &parameter_request::do_id,
        &parameter_request::count,
        &parameter_request::attribute,
        &parameter_request::elements,
        &parameter_request::subindex,
        &parameter_request::format,
        &parameter_request::values,
        &parameter_request::length,
        &parameter_request::bytes,
        &data_set::slot,
        &data_set::index,
    ],
    choices: &[],
};

/// The services of `send`.
pub(super) static SERVICES: &[ServiceEntry] = &[
    (
        &set_slave_address::KEYS,
        "Gives a station address; `lock` is 0 by default, `length` cuts or lengthens the data with zeros.",
    ),
    (
        &global_control::KEYS,
        "One Global_Control with these bits; `group` is a mask of groups, 0 and so all of them by default; there is no answer.",
    ),
    (&fdl_status::KEYS, "Asks whether there is a station."),
    (&slave_diag::KEYS, "Requests the diagnosis."),
    (&get_cfg::KEYS, "Requests the configuration."),
    (&set_prm::KEYS, "Set_Prm with these bytes, all of them."),
    (&chk_cfg::KEYS, "Chk_Cfg with these bytes, by default the identifiers of the module in use."),
    (&data_exchange::KEYS, "One Data_Exchange with these outputs, by default zeros."),
    (&access_point::KEYS, "A request to any access point but that of Set_Slave_Address, from one of the master."),
    (&read_inputs::KEYS, "RD_Inp."),
    (&read_outputs::KEYS, "RD_Outp."),
    (&ds_read::KEYS, "DS_Read over MS1."),
    (&ds_write::KEYS, "DS_Write over MS1."),
    (&alarm_ack::KEYS, "Alarm_Ack over MS1: acknowledges an alarm of the diagnosis."),
    (
        &im_read::KEYS,
        "I&M0, I&M1 and so on, over MS1: CALL by index 255; the answer is the record without the header of CALL.",
    ),
    (&ms2_im_read::KEYS, "The same over MS2."),
    (&ms2_initiate::KEYS, "Initiate: opens the connection of a class 2 master, which the master then keeps alive."),
    (&ms2_read::KEYS, "DS_Read over MS2."),
    (&ms2_write::KEYS, "DS_Write over MS2."),
    (&ms2_abort::KEYS, "Abort: closes the MS2 connection."),
    (&broken::KEYS, "A damaged frame, by its word."),
];

key_set! {
    pub(crate) set_slave_address "set_slave_address" {
        new must Scalar, "The new station address.";
        ident must Whole(0, 0xFFFF), "The ident number.";
        lock may Whole(0, 0xFF), "No_Add_Chg, 0 by default.";
        length may Whole(0, 0xFFFF_FFFF), "The length to which the data are cut or lengthened with zeros.";
    }
}

key_set! {
    pub(crate) global_control "global_control" {
        clear may Whole(0, 1), "The bit clear.";
        unfreeze may Whole(0, 1), "The bit unfreeze.";
        freeze may Whole(0, 1), "The bit freeze.";
        unsync may Whole(0, 1), "The bit unsync.";
        sync may Whole(0, 1), "The bit sync.";
        group may Whole(0, 0xFF), "A mask of groups, 0 and so all of them by default.";
    }
}

key_set! {
    pub(crate) fdl_status "fdl_status" {
    }
}

key_set! {
    pub(crate) slave_diag "slave_diag" {
    }
}

key_set! {
    pub(crate) get_cfg "get_cfg" {
    }
}

key_set! {
    pub(crate) set_prm "set_prm" {
        bytes must Octets, "The data.";
    }
}

key_set! {
    pub(crate) chk_cfg "chk_cfg" {
        bytes may Octets, "The data.";
    }
}

key_set! {
    pub(crate) data_exchange "data_exchange" {
        bytes may Octets, "The data.";
    }
}

key_set! {
    pub(crate) access_point "access_point" {
        sap must Whole(0, 63), "The access point of the slave.";
        source may Whole(0, 63), "The access point of the master, 62 by default.";
        bytes may Octets, "The data, by default none.";
    }
}

key_set! {
    pub(crate) read_inputs "read_inputs" {
    }
}

key_set! {
    pub(crate) read_outputs "read_outputs" {
    }
}

key_set! {
    pub(crate) ds_read "ds_read" {
        slot must Whole(0, 0xFF), "The slot.";
        index must Whole(0, 0xFF), "The index.";
        length must Whole(0, 0xFF), "How many bytes are read at most.";
    }
}

key_set! {
    pub(crate) ds_write "ds_write" {
        slot must Whole(0, 0xFF), "The slot.";
        index must Whole(0, 0xFF), "The index.";
        bytes must Octets, "The data.";
    }
}

key_set! {
    pub(crate) im_read "im_read" {
        slot must Whole(0, 0xFF), "The slot.";
        record must Whole(0, 199), "The record: 0 for I&M0.";
    }
}

key_set! {
    pub(crate) ms2_im_read "ms2_im_read" {
        slot must Whole(0, 0xFF), "The slot.";
        record must Whole(0, 199), "The record: 0 for I&M0.";
    }
}

key_set! {
    pub(crate) alarm_ack "alarm_ack" {
        slot must Scalar, "The slot of the alarm.";
        alarm_type must Scalar, "The type of the alarm.";
        specifier must Scalar, "The specifier of the alarm: the sequence number in bits 3 to 7.";
        own_access_point may Whole(0, 1), "Whether it goes to access point 50, which only acknowledges alarms, instead of 51.";
    }
}

key_set! {
    pub(crate) ms2_initiate "ms2_initiate" {
        send_timeout may Time, "Send_Timeout, in steps of 10ms; 1s by default.";
        features may OctetsOf(2), "Features_Supported, 01 00 by default: reading and writing.";
        profile_features may OctetsOf(2), "Profile_Features_Supported, 00 00 by default.";
        profile may Whole(0, 0xFFFF), "Profile_Ident_Number, 0 by default.";
        s_type may Whole(0, 0xFF), "S_Type, 0 by default.";
        s_addr may Octets, "S_Addr, 00 00 by default: API and SCL.";
        d_type may Whole(0, 0xFF), "D_Type, 0 by default.";
        d_addr may Octets, "D_Addr, 00 00 by default: API and SCL.";
    }
}

key_set! {
    pub(crate) ms2_read "ms2_read" {
        slot must Whole(0, 0xFF), "The slot.";
        index must Whole(0, 0xFF), "The index.";
        length must Whole(0, 0xFF), "How many bytes are read at most.";
    }
}

key_set! {
    pub(crate) ms2_write "ms2_write" {
        slot must Whole(0, 0xFF), "The slot.";
        index must Whole(0, 0xFF), "The index.";
        bytes must Octets, "The data.";
    }
}

key_set! {
    pub(crate) ms2_abort "ms2_abort" {
        subnet may Whole(0, 0xFF), "Subnet, 0 by default: none is given.";
        reason may Whole(0, 0xFF), "Instance in bits 4 and 5, reason in bits 0 to 3; 0x20 by default: the user.";
    }
}

key_set! {
    pub(crate) broken "broken" {
        frame must Name, "The word of the damaged frame.";
    }
}
