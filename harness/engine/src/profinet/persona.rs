//! Applies a persona to a connection: its values replace the defaults of the controller.

use controllers::profinet_io::{ArConfig, ConnectPart, StartUpMode};
use suite::model::ConnectionStart;
use suite::persona::{Persona, PersonaBlock};
use wire::profinet::blocks::connect::RtClass;

/// Applies a persona to a connection: its values replace the defaults of the controller.
///
/// A cycle or watchdog given by the case stays.
pub fn apply_persona(persona: &Persona, start: &ConnectionStart, connection: &mut ArConfig) {
    let put = |field: &mut u16, value: Option<u16>| *field = value.unwrap_or(*field);
    if let Some(name) = &persona.station_name {
        connection.station_name = Some(name.clone().into_bytes());
    }
    if let Some(advanced) = persona.advanced {
        connection.startup = if advanced { StartUpMode::Advanced } else { StartUpMode::Legacy };
    }
    connection.little_endian = persona.little_endian.unwrap_or(connection.little_endian);
    if let Some(order) = &persona.order {
        connection.order = order.iter().map(|block| part(*block)).collect();
    }
    connection.extra_blocks.clone_from(&persona.extra);
    connection.write_multiple = persona.write_multiple.unwrap_or(connection.write_multiple);
    if let Some(class) = persona.class {
        connection.rt_class = RtClass(class.rt);
        (connection.frame_id_in, connection.frame_id_out) = (class.frame_id_in, class.frame_id_out);
    }
    connection.vlan = persona.tagged.unwrap_or(connection.vlan);
    put(&mut connection.iocr_tag, persona.tags[0]);
    put(&mut connection.alarm_tags.0, persona.tags[1]);
    put(&mut connection.alarm_tags.1, persona.tags[2]);
    connection.iocr_references = persona.iocr_references.unwrap_or(connection.iocr_references);
    connection.alarm_reference = persona.alarm_reference.or(connection.alarm_reference);
    put(&mut connection.rta_timeout_factor, persona.rta_timeout);
    put(&mut connection.rta_retries, persona.rta_retries);
    put(&mut connection.max_alarm_data_length, persona.max_alarm);
    put(&mut connection.activity_timeout_factor, persona.activity_timeout);
    connection.args_maximum = persona.args_max.or(connection.args_maximum);
    connection.same_uuid = persona.reconnect.is_some_and(|again| again.same_uuid);
    if let Some(cycle) = persona.cycle.filter(|_| start.cycle.is_none()) {
        (connection.send_clock_factor, connection.reduction_ratio) = (cycle.send_clock, cycle.reduction);
        (connection.phase_in, connection.phase_out) = (cycle.phase_in, cycle.phase_out);
    }
    match (start.watchdog, persona.factors) {
        (Some(watchdog), _) => {
            let cycles = watchdog.as_nanos() / connection.cycle().as_nanos().max(1);
            connection.watchdog_factor = u16::try_from(cycles.max(1)).unwrap_or(u16::MAX);
            connection.data_hold_factor = connection.watchdog_factor;
        }
        (None, Some(factors)) => (connection.watchdog_factor, connection.data_hold_factor) = factors,
        (None, None) => {}
    }
}

fn part(block: PersonaBlock) -> ConnectPart {
    match block {
        PersonaBlock::Inputs => ConnectPart::Inputs,
        PersonaBlock::Outputs => ConnectPart::Outputs,
        PersonaBlock::Submodules => ConnectPart::Submodules,
        PersonaBlock::Alarms => ConnectPart::Alarms,
        PersonaBlock::Extra => ConnectPart::Extra,
    }
}
