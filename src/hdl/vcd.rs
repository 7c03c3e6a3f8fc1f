//! Waveforms of the built-in simulator, in the VCD format of IEEE 1364: one time unit is half a clock,
//! so the clock itself can be drawn.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::flat::Flat;
use super::simulate::{Integers, Simulator};
use crate::fixed::Range;

/// An open waveform with what was last written of each signal.
pub struct Waveform {
    file: BufWriter<File>,
    /// (node, code, width) of each named signal.
    signals: Vec<(usize, String, u32)>,
    last: Vec<Option<i128>>,
}

impl Waveform {
    /// Writes the header: one scope for each instance, one variable for each named signal.
    pub fn create(path: &Path, flat: &Flat, top: &str) -> io::Result<Waveform> {
        let mut file = BufWriter::new(File::create(path)?);
        writeln!(file, "$timescale 1ns $end")?;
        writeln!(file, "$scope module {top} $end\n$var wire 1 {CLOCK} aclk $end")?;
        let mut named: Vec<(&str, usize)> =
            flat.nodes.iter().enumerate().filter_map(|(i, n)| Some((n.path.as_deref()?, i))).collect();
        // Signals of one instance stand together, and instances in the order of their names.
        named.sort_by_key(|(path, index)| (scopes(path), *index));
        let mut open: Vec<&str> = vec![];
        let mut signals = vec![];
        for (path, index) in named {
            let wanted = scopes(path);
            let shared = open.iter().zip(&wanted).take_while(|(a, b)| a == b).count();
            for _ in shared..open.len() {
                writeln!(file, "$upscope $end")?;
            }
            for scope in &wanted[shared..] {
                writeln!(file, "$scope module {scope} $end")?;
            }
            open = wanted;
            let (name, width) =
                (path.rsplit('.').next().unwrap_or(path), flat.nodes[index].node.word.width());
            let code = code(signals.len() + 1);
            writeln!(file, "$var wire {width} {code} {name} $end")?;
            signals.push((index, code, width));
        }
        for _ in 0..=open.len() {
            writeln!(file, "$upscope $end")?;
        }
        writeln!(file, "$enddefinitions $end")?;
        let last = vec![None; signals.len()];
        Ok(Waveform { file, signals, last })
    }

    /// The settled values of clock `number`.
    pub fn sample(&mut self, number: u64, simulator: &Simulator<Integers>) -> io::Result<()> {
        writeln!(self.file, "#{}\n1{CLOCK}", 2 * number)?;
        for ((index, code, width), last) in self.signals.iter().zip(&mut self.last) {
            let value = simulator.value_at(*index);
            if *last != Some(value) {
                *last = Some(value);
                match width {
                    1 => writeln!(self.file, "{}{code}", value & 1)?,
                    _ => writeln!(self.file, "b{:b} {code}", Range::unsigned(*width).wrap(value))?,
                }
            }
        }
        writeln!(self.file, "#{}\n0{CLOCK}", 2 * number + 1)
    }

    pub fn finish(mut self) -> io::Result<()> {
        self.file.flush()
    }
}

const CLOCK: &str = "!";

/// The instances on the way to a signal.
fn scopes(path: &str) -> Vec<&str> {
    let mut parts: Vec<&str> = path.split('.').collect();
    parts.pop();
    parts
}

/// A short code of printable characters.
fn code(mut number: usize) -> String {
    let mut text = String::new();
    loop {
        text.push(char::from(b'!' + (number % 94) as u8));
        number /= 94;
        if number == 0 {
            return text;
        }
    }
}
