//! Which names there are, for suggestions.

use super::super::dialect;
use super::Names;
use suite::device::DiagnosisName;

impl Names<'_> {
    /// Every constant, start parameter and derived value.
    pub(super) fn values(&self, visit: &mut dyn FnMut(&str)) {
        self.described.constants.iter().for_each(|(name, _)| visit(name));
        self.described.derived.iter().for_each(|(name, _)| visit(name));
        let starts = self.device().records.iter().filter(|record| record.start);
        starts.flat_map(|record| &record.fields).for_each(|field| visit(&field.name));
    }

    /// Every name there is, for suggestions.
    pub(in super::super) fn known(&self, visit: &mut dyn FnMut(&str)) {
        let device = self.device();
        for signal in &device.signals {
            visit(&signal.name);
            signal.fields.iter().for_each(|field| visit(&format!("{}.{}", signal.name, field.name)));
        }
        for record in device.records.iter().filter(|_| device.profibus().is_none()) {
            record.fields.iter().for_each(|field| visit(&format!("{}.{}", record.name, field.name)));
        }
        for parameter in &device.parameters {
            visit(&format!("P{}", parameter.number));
            parameter.elements.iter().for_each(|(name, _)| visit(&format!("P{}.{name}", parameter.number)));
            for (of, fields) in &parameter.bits {
                let dot = if of.is_empty() { "" } else { "." };
                fields.iter().for_each(|field| visit(&format!("P{}{dot}{of}.{}", parameter.number, field.name)));
            }
        }
        let stand = &device.stand;
        stand.faults.iter().for_each(|(name, _)| visit(&format!("fault.{name}")));
        stand.buttons.iter().for_each(|(name, _)| visit(&format!("button.{name}")));
        stand.switches.iter().for_each(|switch| visit(&format!("switch.{}", switch.name)));
        stand.leds.iter().for_each(|(name, _)| visit(&format!("led.{name}")));
        stand.counters.iter().for_each(|(name, _)| visit(&format!("counter.{name}")));
        let shown = device.pages.iter().flat_map(|page| &page.shows);
        shown.for_each(|value| visit(&format!("page.{}", value.name)));
        device.roles.iter().for_each(|(name, _)| visit(&format!("role.{name}")));
        if let Some(slave) = device.profibus() {
            DiagnosisName::words().for_each(|(word, _)| visit(&format!("diag.{word}")));
            slave.diagnosis.fields.iter().for_each(|field| visit(&format!("diag.{}", field.name)));
        }
        visit("timing.patience");
        device.timing.ours.iter().for_each(|known| visit(&format!("timing.{}", known.name)));
        device.timing.tolerances.iter().for_each(|known| visit(&format!("tolerance.{}", known.name)));
        device.timing.printed.iter().for_each(|known| visit(&format!("printed.{}", known.name)));
        dialect::of(device.bus.kind()).built_in_names().for_each(|(name, _)| visit(name));
        self.values(visit);
    }
}
