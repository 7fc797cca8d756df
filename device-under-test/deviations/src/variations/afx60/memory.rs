//! Saving, and what survives power-off and factory reset.

use crate::needs::Need;
use crate::seams::Deviations;
use crate::tables::Group;
use alloc::rc::Rc;
use core::cell::RefCell;
use core::time::Duration;
use encoder_profile::hooks::RetainedEncoderData;
use reference_devices::manuals;
use reference_devices::models::sick_afx60::ServiceLog;
use reference_devices::models::sick_afx60::hooks::Afx60Event;

/// The variations.
pub const GROUP: Group = Group {
    needs: &[Need::Of(&manuals::SICK_AFX60)],
    deviations: permitted! {
        "saves-at-once" "A save takes 5 ms."
            "3.5.4, Table 33 (971) and 5.4.1, Table 46 print no time for a save"
            => |d| saves_in(d, Duration::from_millis(5));
        "saves-slowly" "A save takes 4 s."
            "3.5.4, Table 33 (971) and 5.4.1, Table 46 print no time for a save"
            => |d| saves_in(d, Duration::from_secs(4));
        "log-saved-now-and-then" "The service log is saved every 20 s; what it counted since then is lost at power-off, except for power-ups."
            "3.5.5, Table 34 (1002 to 1004) and 5.4.1, Table 46 bits 3 and 2 do not print when the log is saved"
            => |d| log_saved_now_and_then(d);
        "reset-keeps-the-offset" "The reset to factory settings keeps the offset of the presets."
            "5.5: factory settings; whether the stored offset is one is not printed"
            => |d| d.encoder.reset(|view, _, left| RetainedEncoderData { offset: view.measuring.offset, ..left });
    },
};

fn saves_in(d: &mut Deviations, takes: Duration) {
    d.encoder.preset_value_takes(move |_| takes);
    d.afx60.save_takes(move |_| takes);
}

fn log_saved_now_and_then(d: &mut Deviations) {
    const EVERY: Duration = Duration::from_secs(20);
    let saved = Rc::new(RefCell::new(None));
    let current = saved.clone();
    d.afx60.logged(move |now, log: &ServiceLog| {
        let mut saved = current.borrow_mut();
        let is_due = saved.as_ref().is_none_or(|(at, _)| now.since(*at) >= EVERY);
        if is_due {
            *saved = Some((now, log.clone()));
        }
    });
    d.afx60.kept(move |event, _, mut retained| {
        match event {
            Afx60Event::PowerDown { .. } => {
                if let Some((_, log)) = saved.borrow_mut().take() {
                    let ups = [retained.log.absolute.log.power_ups, retained.log.relative.log.power_ups];
                    retained.log = log;
                    [retained.log.absolute.log.power_ups, retained.log.relative.log.power_ups] = ups;
                }
            }
            Afx60Event::LogReset | Afx60Event::Reset => *saved.borrow_mut() = None,
            Afx60Event::PowerUp | Afx60Event::Start => {}
        }
        retained
    });
}
