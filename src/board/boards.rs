//! The boards: what a project must know of each, as data.

use crate::error::{Error, Result};

/// How the devices of a board are synthesized, placed and packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Lattice ECP5: synth_ecp5, nextpnr-ecp5, ecppack.
    Ecp5,
    /// Gowin GW2A: synth_gowin, nextpnr-himbaechel, gowin_pack.
    Gowin,
}

/// A board of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board {
    /// As on the command line.
    pub name: &'static str,
    pub title: &'static str,
    pub family: Family,
    /// The oscillator, in Hz.
    pub oscillator: u32,
    /// The clock of the core when nothing is said, in Hz.
    pub clock: u32,
    /// The bits of a coordinate when nothing is said.
    pub width: u32,
    pub pins: Pins,
    /// A pressed button, and a lit LED, is 0 at the pin.
    pub button_low: bool,
    pub leds_low: bool,
    /// The device it has when nothing is said comes first.
    pub devices: &'static [Device],
    /// The board as openFPGALoader knows it.
    pub loader: &'static str,
    /// What the README says of the serial line.
    pub serial: &'static str,
}

/// Sites of the package.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pins {
    pub clock: &'static str,
    /// From the FPGA to the computer.
    pub txd: &'static str,
    pub button: &'static str,
    pub led_busy: &'static str,
    pub led_done: &'static str,
    /// Pins that must be 1 for the board to stay on, by name.
    pub high: &'static [(&'static str, &'static str)],
}

/// A device that the board comes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Device {
    /// As on the command line.
    pub name: &'static str,
    /// What nextpnr is told.
    pub nextpnr: &'static str,
    /// 4-input look-up tables, and block RAMs of 16 or 18 kbit.
    pub luts: u32,
    pub blocks: u32,
}

const fn ecp5(name: &'static str, nextpnr: &'static str, luts: u32, blocks: u32) -> Device {
    Device { name, nextpnr, luts, blocks }
}

pub const BOARDS: [Board; 2] = [
    Board {
        name: "ulx3s",
        title: "ULX3S",
        family: Family::Ecp5,
        oscillator: 25_000_000,
        clock: 50_000_000,
        width: 16,
        pins: Pins {
            clock: "G2",
            txd: "L4",
            button: "R1",
            led_busy: "B2",
            led_done: "C2",
            high: &[("wifi_gpio0", "L2")],
        },
        button_low: false,
        leds_low: false,
        devices: &[
            ecp5("85f", "--85k", 83_640, 208),
            ecp5("45f", "--45k", 43_848, 108),
            ecp5("25f", "--25k", 24_288, 56),
            ecp5("12f", "--12k", 24_288, 56),
        ],
        loader: "ulx3s",
        serial: "the USB socket US1 (FT231X), up to 3 Mbaud",
    },
    Board {
        name: "tang-nano-20k",
        title: "Tang Nano 20K",
        family: Family::Gowin,
        oscillator: 27_000_000,
        clock: 54_000_000,
        width: 10,
        pins: Pins { clock: "4", txd: "69", button: "88", led_busy: "15", led_done: "16", high: &[] },
        button_low: false,
        leds_low: true,
        devices: &[Device { name: "gw2ar-18", nextpnr: "GW2AR-LV18QN88C8/I7", luts: 20_736, blocks: 46 }],
        loader: "tangnano20k",
        serial: "the second serial port of the USB socket (BL616)",
    },
];

/// # Errors
/// `Usage`, with the names that there are.
pub fn board(name: &str) -> Result<&'static Board> {
    BOARDS.iter().find(|board| board.name == name).ok_or_else(|| {
        let names: Vec<_> = BOARDS.iter().map(|board| board.name).collect();
        Error::usage(format!("there is no board '{name}'"))
            .help(format!("the boards are {}", names.join(", ")))
    })
}

impl Board {
    /// The device of this name, or the first one.
    ///
    /// # Errors
    /// `Usage`, with the names that there are.
    pub fn device(&self, name: Option<&str>) -> Result<&'static Device> {
        let Some(name) = name else { return Ok(&self.devices[0]) };
        self.devices.iter().find(|device| device.name == name).ok_or_else(|| {
            let names: Vec<_> = self.devices.iter().map(|device| device.name).collect();
            Error::usage(format!("{} does not come with a device '{name}'", self.title))
                .help(format!("it comes with {}", names.join(", ")))
        })
    }
}
