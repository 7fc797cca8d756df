//! The keys of `instead`: what can be changed in a request and in a start-up.

use super::keys::{Shape, WordChoices};
use suite::model::SoughtStation;

/// Whom `who` of a DCP identify means.
pub(super) static SOUGHT: WordChoices<SoughtStation> = WordChoices(&[
    ("all", SoughtStation::All),
    ("own_name", SoughtStation::OwnName),
    ("own_id", SoughtStation::OwnId),
    ("other_vendor", SoughtStation::OtherVendor),
    ("other_device", SoughtStation::OtherDevice),
    ("own_type", SoughtStation::OwnType),
    ("other_type", SoughtStation::OtherType),
    ("own_id_other_type", SoughtStation::OwnIdOtherType),
]);

key_set! {
    pub(crate) parameter_request "instead in a parameter request" {
        reference may Whole(0, 0xFF), "Reference of the request.";
        request may Whole(0, 0xFF), "Request id.";
        do_id may Whole(0, 0xFF), "Drive object (axis).";
        count may Whole(0, 0xFF), "Number of parameters in the header.";
        attribute may Whole(0, 0xFF), "Attribute of each address.";
        elements may Whole(0, 0xFF), "Number of elements of each address.";
        subindex may Whole(0, 0xFFFF), "Subindex of each address.";
        format may Scalar, "Format of each value, by its word or number; the value is cut or lengthened to it.";
        values may Whole(0, 0xFF), "Number of values in the header of each parameter.";
        length may Whole(0, 0xFFFF_FFFF), "Length of the whole request, cut or lengthened with zeros.";
        bytes may Octets, "The whole request.";
        slot may Whole(0, 0xFFFF), "Slot in which the parameter access point is addressed.";
        subslot may Whole(0, 0xFFFF), "Its subslot.";
        api may Whole(0, 0xFFFF_FFFF), "Its API.";
    }
}

key_set! {
    pub(crate) record_request "instead in a request for a record" {
        slot may Whole(0, 0xFFFF), "Slot of the record.";
        subslot may Whole(0, 0xFFFF), "Its subslot.";
        api may Whole(0, 0xFFFF_FFFF), "Its API.";
        index may Whole(0, 0xFFFF), "Its index.";
        length may Whole(0, 0xFFFF_FFFF), "The requested number of bytes; of a write: its data, cut or lengthened with zeros.";
        bytes may Octets, "The data that is written.";
    }
}

key_set! {
    pub(crate) station_request "instead in a request to the station" {
        value may Octets, "The bytes of the value.";
        qualifier may Whole(0, 0xFFFF), "The block qualifier.";
        destination may OctetsOf(6), "The MAC address of another station to which the write goes; on the virtual wire only.";
    }
}

key_set! {
    pub(crate) connect_request "instead in a connection" {
        output_length may Whole(0, 0xFFFF), "Bytes of output data in the expected configuration.";
        input_length may Whole(0, 0xFFFF), "Bytes of input data in the expected configuration.";
        module_ident may Whole(0, 0xFFFF_FFFF), "Ident of the module.";
        submodule_ident may Whole(0, 0xFFFF_FFFF), "Ident of the telegram's submodule.";
        api may Whole(0, 0xFFFF_FFFF), "API of the telegram's submodule.";
        station_name may Scalar, "Name in the Connect request.";
        rt_class may Whole(1, 3), "RT class of both IOCRs: 1, 2 or 3.";
        slot may Whole(0, 0xFFFF), "Slot in which the module is expected.";
        dap_ident may Whole(0, 0xFFFF_FFFF), "Ident of the module in slot 0.";
        byte_order may Only("little"), "`little`: the RPC headers are little-endian.";
        ip may Only("none"), "`none`: no address is given; the device is called where it is.";
        fields may NonEmptyMap(&Shape::Whole(0, 0xFFFF_FFFF_FFFF)), "Fields of the Connect request that have other values, by their words.";
        parameter_pause may Time, "How long the controller waits before it sends the end of the parameters, also after a plug or release.";
        access_point may Only("none"), "`none`: the submodule of slot 0 is not expected, as by a controller that shares the device.";
        network may Only("expected"), "`expected`: the interface and the ports are expected as well, by their idents under `network`.";
        access may Only("supervisor"), "`supervisor`: the connection of a supervisor for records only, without cyclic data.";
    }
}

/// What `lock` in `instead` can say: the word, Lock_Req, Unlock_Req.
pub(super) static LOCKS: WordChoices<(bool, bool)> = WordChoices(&[
    ("lock", (true, false)),
    ("unlock", (false, true)),
    ("both", (true, true)),
    ("neither", (false, false)),
]);

key_set! {
    pub(crate) slave_request "instead in a connection on PROFIBUS" {
        set_prm may OctetsOrNone, "`none`, or the whole Set_Prm as bytes.";
        user_octets may Octets, "The bytes of Set_Prm after the seven that every slave has, including those of DP-V1.";
        dpv1 may OctetsOf(3), "The three bytes of DP-V1.";
        chk_cfg may OctetsOrNone, "`none`, or the identifiers as bytes.";
        ident may Whole(0, 0xFFFF), "Ident number in Set_Prm.";
        lock may Word(&LOCKS), "Lock, unlock, both, neither: what Set_Prm requests.";
        freeze_req may Whole(1, 1), "1: Set_Prm requests freeze mode.";
        sync_req may Whole(1, 1), "1: Set_Prm requests sync mode.";
        watchdog_factors may Between(2, 2, &Whole(0, 0xFF)), "The two factors of the watchdog.";
        min_tsdr may Whole(0, 0xFF), "The least time until an answer, in bit times.";
        groups may Whole(0, 0xFF), "The groups that the slave belongs to, as a mask.";
        output_length may Whole(0, 0xFFFF), "Bytes of outputs that are sent in Data_Exchange.";
        input_length may Whole(0, 0xFFFF), "Bytes of inputs that are taken in Data_Exchange.";
    }
}
