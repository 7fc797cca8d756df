//! The contents of a GSD that a master or a suite needs.

use wire::profibus::fdl::{BaudRate, BitTimes};

/// A GSD.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Gsd {
    /// `GSD_Revision`.
    pub gsd_revision: u32,
    /// `Vendor_Name`.
    pub vendor: String,
    /// `Model_Name`.
    pub model: String,
    /// `Revision` of the device.
    pub revision: String,
    /// `Ident_Number`.
    pub ident: u16,
    /// The supported baud rates in kbit/s, written as in the keywords (`9.6`, `1.5M`).
    pub bauds: Vec<String>,
    /// `MaxTsdr_*`: the longest time until an answer, in bit times, at each baud rate in bit/s.
    pub max_tsdr: Vec<(BaudRate, BitTimes)>,
    /// `Freeze_Mode_supp`.
    pub freeze: bool,
    /// `Sync_Mode_supp`.
    pub sync: bool,
    /// `Auto_Baud_supp`.
    pub auto_baud: bool,
    /// `Set_Slave_Add_supp`.
    pub set_slave_address: bool,
    /// `Fail_Safe`.
    pub fail_safe: bool,
    /// `DPV1_Slave`.
    pub dpv1: bool,
    /// `WD_Base_1ms_supp`.
    pub watchdog_1ms: bool,
    /// `Ident_Maintenance_supp`.
    pub identification: bool,
    /// `Isochron_Mode_supp`.
    pub isochronous: bool,
    /// `Min_Slave_Intervall` in 100 us: the shortest time between two polls.
    pub min_slave_interval: u32,
    /// `Max_Diag_Data_Len` in bytes, if given.
    pub max_diagnosis: Option<usize>,
    /// `Max_Input_Len` in bytes, if given.
    pub max_inputs: Option<usize>,
    /// `Max_Output_Len` in bytes, if given.
    pub max_outputs: Option<usize>,
    /// `Max_User_Prm_Data_Len`, else `User_Prm_Data_Len`, in bytes.
    pub max_user_octets: Option<usize>,
    /// The user bytes of Set_Prm common to all modules.
    pub parameters: GsdParameters,
    /// The modules in the order of the file.
    pub modules: Vec<GsdModule>,
}

/// A module.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GsdModule {
    pub name: String,
    /// Its identifiers in Chk_Cfg.
    pub cfg: Vec<u8>,
    /// The user bytes that it adds after those of the slave.
    pub parameters: GsdParameters,
}

/// User bytes of Set_Prm: constant bytes and fields.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GsdParameters {
    /// The number of bytes.
    pub octets: usize,
    /// Constant bytes with their offsets; the fields overwrite them.
    pub constants: Vec<(usize, Vec<u8>)>,
    /// The fields with their offsets.
    pub fields: Vec<(usize, GsdField)>,
}

/// A field of the user bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GsdField {
    pub name: String,
    /// Its size or bits.
    pub kind: FieldType,
    pub default: i64,
    /// The lowest and the highest allowed number, if limited.
    pub range: Option<(i64, i64)>,
    /// Its numbers with their texts.
    pub texts: Vec<(i64, String)>,
}

/// The size or bits of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldType {
    /// Whole bytes, signed in two's complement or unsigned.
    Octets {
        /// 1, 2 or 4.
        octets: usize,
        /// Whether it is in two's complement.
        signed: bool,
    },
    /// Bits `low` to `high` of a byte.
    Bits {
        /// The lowest bit.
        low: u8,
        /// The highest bit.
        high: u8,
    },
}

impl FieldType {
    /// How many bytes it occupies.
    pub fn octets(self) -> usize {
        match self {
            FieldType::Octets { octets, .. } => octets,
            FieldType::Bits { .. } => 1,
        }
    }
}

impl Gsd {
    /// The fields of the user bytes with a module, at offsets after the seven bytes of Set_Prm.
    ///
    /// The bytes of a module follow those common to all modules.
    pub fn fields<'g>(&'g self, module: &'g GsdModule) -> impl Iterator<Item = (usize, &'g GsdField)> {
        let before = self.parameters.octets;
        let own = self.parameters.fields.iter().map(|(at, field)| (*at, field));
        own.chain(module.parameters.fields.iter().map(move |(at, field)| (before + at, field)))
    }

    /// The user bytes of Set_Prm with a module and all fields at their defaults.
    pub fn default_octets(&self, module: &GsdModule) -> Vec<u8> {
        let mut octets = vec![0; self.parameters.octets + module.parameters.octets];
        let parts = [(0, &self.parameters), (self.parameters.octets, &module.parameters)];
        for (begin, part) in parts {
            for (at, constant) in &part.constants {
                if let Some(place) = octets.get_mut(begin + at..begin + at + constant.len()) {
                    place.copy_from_slice(constant);
                }
            }
        }
        for (at, field) in self.fields(module) {
            let count = field.kind.octets();
            let Some(place) = octets.get_mut(at..at + count) else { continue };
            match field.kind {
                FieldType::Octets { .. } => place.copy_from_slice(&field.default.to_be_bytes()[8 - count..]),
                FieldType::Bits { low, high } => {
                    let mask = (((2u16 << high) - 1) & !((1u16 << low) - 1)) as u8;
                    place[0] = place[0] & !mask | ((field.default as u8) << low) & mask;
                }
            }
        }
        octets
    }
}
