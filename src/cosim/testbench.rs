//! Prints the testbench (Verilog, for every simulator) and the harness (C++, for Verilator's speed).
//!
//! ```text
//! Dut ──► Bench (names, widths, formats) ──► testbenches/stream_testbench.v
//!                                       └──► testbenches/verilator_harness.cpp
//! ```

use super::workarounds::FIELD_BITS;
use super::{Dut, Port, vectors, workarounds};
use crate::Result;
use askama::Template;

/// Clocks that reset is held.
pub(super) const RESET_CLOCKS: u64 = 4;
/// Clocks after the last beat in which no further one may come.
pub(super) const DRAIN_CLOCKS: u64 = 64;

/// The self-checking testbench, Verilog-2005; its module is called as [`testbench_name`] says.
pub fn testbench(dut: &Dut) -> Result<String> {
    dut.check()?;
    Ok(render(&StreamTestbench { bench: Bench::of(dut) }))
}

/// The name of the testbench's module; its file is this name with `.v`.
pub fn testbench_name(dut: &Dut) -> String {
    format!("{}_testbench", dut.top)
}

/// The C++ harness of the model that Verilator makes with `--prefix Vdut`.
pub(super) fn harness(dut: &Dut) -> Result<String> {
    dut.check()?;
    Ok(render(&VerilatorHarness { bench: Bench::of(dut) }))
}

/// The templates only read fields and write into a string, which cannot fail.
fn render(template: &impl Template) -> String {
    // askama leaves out the newline at the end of a template.
    template.render().expect("writing into a string does not fail") + "\n"
}

/// One signal of a stream beside its handshake.
struct Signal {
    name: String,
    width: u32,
    /// `[7:0] ` before the name in a declaration; empty for `tlast`.
    range: String,
    /// Where it starts within a beat of the harness, in 32-bit words.
    word: u32,
}

impl Signal {
    fn new(name: String, width: u32, word: u32) -> Self {
        let range = if name == "tlast" { String::new() } else { format!("[{}:0] ", width - 1) };
        Signal { name, width, range, word }
    }
}

/// One stream as the templates want it; the signals stand in the order of the vector files.
struct Stream {
    signals: Vec<Signal>,
    /// 32-bit words of a beat in the harness.
    words: u32,
    keep: bool,
    keep_bits: u32,
    /// Bits of each field of `tdata`, highest first.
    data_fields: Vec<(u32, u32)>,
}

impl Stream {
    fn of(port: &Port) -> Self {
        let wanted = [
            ("tlast", u32::from(port.last)),
            ("tuser", port.user),
            ("tkeep", port.keep_bits()),
            ("tdata", port.data),
        ];
        let mut words = 0;
        let mut signals = Vec::new();
        for (name, width) in wanted.into_iter().filter(|&(_, width)| width > 0) {
            signals.push(Signal::new(name.into(), width, words));
            words += width.div_ceil(32);
        }
        let data_fields = vectors::data_fields(port).collect();
        Stream { signals, words, keep: port.keep, keep_bits: port.keep_bits(), data_fields }
    }

    /// Numbers on a line of the vector file.
    fn fields(&self) -> usize {
        self.signals.len() - 1 + self.data_fields.len()
    }
    /// `%h %h %h`, for reading and writing a line.
    fn format(&self) -> String {
        vec!["%h"; self.fields()].join(" ")
    }
    /// `, x_tlast, x_tuser, x_tdata`: what belongs to [`Stream::format`] when writing.
    fn arguments(&self, prefix: &str) -> String {
        self.list(prefix, |&(lsb, width)| format!("tdata[{lsb} +: {width}]"))
    }
    /// The same when reading, where a cut `tdata` goes into registers of its own.
    fn scanned(&self, prefix: &str) -> String {
        self.list(prefix, |&(lsb, _)| workarounds::scanned_part(lsb))
    }
    fn list(&self, prefix: &str, part: impl Fn(&(u32, u32)) -> String) -> String {
        let names = self.signals.iter().map(|signal| signal.name.as_str());
        let names = names.filter(|&name| name != "tdata" || !self.cut()).map(String::from);
        let parts = self.data_fields.iter().filter(|_| self.cut()).map(part);
        names.chain(parts).map(|name| format!(", {prefix}{name}")).collect()
    }
    /// Whether `tdata` is cut into several fields.
    fn cut(&self) -> bool {
        self.data_fields.len() > 1
    }
    /// The registers for the fields of a cut `tdata`.
    fn parts(&self) -> Vec<Signal> {
        let cut = self.data_fields.iter().filter(|_| self.cut());
        cut.map(|&(lsb, width)| Signal::new(workarounds::scanned_part(lsb), width, 0)).collect()
    }
    /// `{x_tdata_4096, x_tdata_0}`: a cut `tdata` from its registers.
    fn joined(&self, prefix: &str) -> String {
        let parts: Vec<_> = self.parts().iter().map(|part| format!("{prefix}{}", part.name)).collect();
        format!("{{{}}}", parts.join(", "))
    }
    /// The columns of the vector file, for its reader.
    fn columns(&self) -> String {
        let names: Vec<_> = self.signals.iter().map(|signal| signal.name.as_str()).collect();
        let cut = if self.cut() { " (in parts, highest first)" } else { "" };
        names.join(" ") + cut
    }
    /// Room for a received line: 16 digits of the clock, all digits, all spaces.
    fn line_characters(&self) -> u32 {
        32 + self.words * 8 + 2 * self.fields() as u32
    }
}

/// What both templates print.
struct Bench {
    name: String,
    top: String,
    input: Stream,
    output: Stream,
    latency_beat: u64,
    latency_clocks: Option<u64>,
    reset_clocks: u64,
    drain_clocks: u64,
    field_bits: u32,
}

impl Bench {
    fn of(dut: &Dut) -> Self {
        Bench {
            name: testbench_name(dut),
            top: dut.top.clone(),
            input: Stream::of(&dut.input),
            output: Stream::of(&dut.output),
            latency_beat: dut.latency.map_or(0, |latency| latency.beat),
            latency_clocks: dut.latency.map(|latency| latency.clocks),
            reset_clocks: RESET_CLOCKS,
            drain_clocks: DRAIN_CLOCKS,
            field_bits: FIELD_BITS,
        }
    }
    fn streams(&self) -> [(&str, &Stream); 2] {
        [("input", &self.input), ("output", &self.output)]
    }
}

#[derive(Template)]
#[template(path = "stream_testbench.v")]
struct StreamTestbench {
    bench: Bench,
}

#[derive(Template)]
#[template(path = "verilator_harness.cpp")]
struct VerilatorHarness {
    bench: Bench,
}
