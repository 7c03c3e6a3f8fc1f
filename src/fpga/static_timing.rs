//! Static timing of a routed ECP5: the longest path from clock to clock, from the delays that nextpnr writes (`--sdf`).
//!
//! ```text
//!   (INTERCONNECT cell/port cell/port (min:typ:max) ..)           a routed wire
//!   (IOPATH port port (min:typ:max) ..)                           through a cell; from a clock on: where a path begins
//!   (SETUPHOLD (posedge port) (posedge clock) (setup) (hold))     where it ends
//! ```
//!
//! All in picoseconds; the longest delays count, as in nextpnr's own report. That report is not taken, as it counts
//! [upper halves of carries](Delays::count_upper_halves_as_packed) wrongly; without that correction, what comes out here
//! is the clock of the report.

use std::collections::HashMap;

/// A port of a cell, by its number.
type Pin = u32;

/// The delays of a routed design.
#[derive(Default)]
pub struct Delays<'a> {
    pins: HashMap<(&'a str, &'a str), Pin>,
    /// Cell and port of every pin, with the escapes of the file.
    names: Vec<(&'a str, &'a str)>,
    /// Who drives an input, and how long the wire takes.
    wires: HashMap<Pin, (Pin, i64)>,
    /// The inputs that an output depends on, with the time that it takes.
    ways: HashMap<Pin, Vec<(Pin, i64)>>,
    /// From the clock to an output.
    begins: HashMap<Pin, i64>,
    /// Before the clock at an input.
    ends: HashMap<Pin, i64>,
}

/// The longest path.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Longest {
    pub picoseconds: i64,
    /// Of them, in cells.
    pub logic: i64,
    /// Cell and port of each output on the way, the register that it begins at first.
    pub outputs: Vec<(String, String)>,
    /// The cell that it ends at.
    pub end: String,
}

/// When the latest change comes to an output, and by which of its inputs.
type Arrival = Option<(i64, Option<Pin>)>;

impl<'a> Delays<'a> {
    /// Reads the file; nothing where a line is not as above.
    pub fn parse(text: &'a str) -> Option<Delays<'a>> {
        let mut delays = Delays::default();
        let mut cell = "";
        for line in text.lines().map(str::trim_start) {
            let Some((what, rest)) = line.split_once(' ') else { continue };
            let mut words = rest.split(' ');
            match what {
                "(INSTANCE" => cell = rest.strip_suffix(')')?,
                "(INTERCONNECT" => {
                    let [from, to] = [words.next()?.rsplit_once('/')?, words.next()?.rsplit_once('/')?];
                    let (from, to) = (delays.pin(from), delays.pin(to));
                    delays.wires.insert(to, (from, longest_of(words.next()?)?));
                }
                "(IOPATH" => {
                    let (from, to) = (words.next()?, delays.pin((cell, words.next()?)));
                    let delay = longest_of(words.next()?)?;
                    if is_clock(from) {
                        delays.begins.insert(to, delay);
                    } else {
                        let from = delays.pin((cell, from));
                        delays.ways.entry(to).or_default().push((from, delay));
                    }
                }
                "(SETUPHOLD" => {
                    let port = delays.pin((cell, words.nth(1)?.strip_suffix(')')?));
                    delays.ends.insert(port, longest_of(words.nth(2)?)?);
                }
                _ => {}
            }
        }
        Some(delays)
    }

    fn pin(&mut self, name: (&'a str, &'a str)) -> Pin {
        let names = &mut self.names;
        *self.pins.entry(name).or_insert_with(|| {
            names.push(name);
            names.len() as Pin - 1
        })
    }

    /// A workaround for nextpnr 0.11 (and those before it with `TRELLIS_COMB`): it tells the upper half of a slice of
    /// carry by a mark of its packer, and `--write` leaves the mark out. So in a placement that it has read back, all
    /// halves are lower ones, and every two bits of an adder take 56 ps too much. Here they take what they take in a
    /// design that it has packed itself.
    pub fn count_upper_halves_as_packed(&mut self) {
        for (to, ways) in &mut self.ways {
            let (cell, output) = self.names[*to as usize];
            let through = match output {
                "FCO" => 0,
                "F" => 293,
                _ => continue,
            };
            if cell.ends_with("$CCU2_COMB1") {
                let carries = ways.iter_mut().filter(|(from, _)| self.names[*from as usize].1 == "FCI");
                carries.for_each(|(_, delay)| *delay = (*delay).min(through));
            }
        }
    }

    /// Nothing where there is no path from clock to clock. Of paths as long as each other, the one whose end has the
    /// last name.
    pub fn longest(&self) -> Option<Longest> {
        let mut arrivals = HashMap::new();
        let ends = self.ends.iter().filter_map(|(&end, setup)| {
            let (from, wire) = *self.wires.get(&end)?;
            let (time, _) = self.arrival(from, &mut arrivals)?;
            Some((time + wire + setup, self.names[end as usize], end))
        });
        let (picoseconds, (cell, _), mut input) = ends.max()?;
        let mut routing = 0;
        let mut outputs = vec![];
        loop {
            let (output, wire) = self.wires[&input];
            routing += wire;
            let (cell, port) = self.names[output as usize];
            outputs.push((unescaped(cell), unescaped(port)));
            match arrivals[&output] {
                Some((_, Some(before))) => input = before,
                _ => break,
            }
        }
        outputs.reverse();
        Some(Longest { picoseconds, logic: picoseconds - routing, outputs, end: unescaped(cell) })
    }

    /// Nothing where no clock stands at the begin. The depth is that of the longest chain of cells.
    fn arrival(&self, output: Pin, known: &mut HashMap<Pin, Arrival>) -> Arrival {
        if let Some(arrival) = known.get(&output) {
            return *arrival;
        }
        // Through a loop nothing comes.
        known.insert(output, None);
        let begin = self.begins.get(&output).map(|delay| (*delay, None));
        let ways = self.ways.get(&output).into_iter().flatten().filter_map(|(input, delay)| {
            let (from, wire) = *self.wires.get(input)?;
            let (time, _) = self.arrival(from, known)?;
            Some((time + wire + delay, Some(*input)))
        });
        let arrival = begin.into_iter().chain(ways.collect::<Vec<_>>()).max_by_key(|(time, _)| *time);
        known.insert(output, arrival);
        arrival
    }
}

/// Of registers, block RAMs, multipliers and RAMs in LUTs; a clock that goes into a buffer only passes.
fn is_clock(port: &str) -> bool {
    port == "WCK" || port.starts_with("CLK") && port != "CLKI"
}

/// The last one of `(min:typ:max)`.
fn longest_of(triple: &str) -> Option<i64> {
    let last = triple.trim_end_matches(')').rsplit(':').next()?;
    last.parse::<f64>().ok().map(|delay| delay.round() as i64)
}

fn unescaped(name: &str) -> String {
    let mut plain = String::with_capacity(name.len());
    let mut escaped = false;
    for letter in name.chars() {
        escaped = letter == '\\' && !escaped;
        if !escaped {
            plain.push(letter);
        }
    }
    plain
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Two registers with an adder of two bits between them, and a short way beside it.
    pub const ADDER: &str = r#"(DELAYFILE
  (TIMESCALE 1ps)
  (CELL
    (CELLTYPE "top")
    (INSTANCE )
    (DELAY
      (ABSOLUTE
        (INTERCONNECT reset\$io/O b/M (9000:9000:9000) (9000:9000:9000))
        (INTERCONNECT core.a_TRELLIS_FF_Q/Q core.sum_CCU2C_S0\$CCU2_COMB0/A (500:600:700) (1:1:1))
        (INTERCONNECT core.sum_CCU2C_S0\$CCU2_COMB0/FCO core.sum_CCU2C_S0\$CCU2_COMB1/FCI (0:0:0) (0:0:0))
        (INTERCONNECT core.sum_CCU2C_S0\$CCU2_COMB1/FCO core.more_CCU2C_S0\$CCU2_COMB0/FCI (0:0:0) (0:0:0))
        (INTERCONNECT core.more_CCU2C_S0\$CCU2_COMB0/F b/DI (98:108:118) (98:108:118))
        (INTERCONNECT core.a_TRELLIS_FF_Q/Q b/M (300:300:300) (1:1:1))
      )
    )
  )
  (CELL
    (CELLTYPE "TRELLIS_COMB")
    (INSTANCE core.sum_CCU2C_S0\$CCU2_COMB0)
        (IOPATH A FCO (144:249:355) (144:249:355))
    )
  (CELL
    (CELLTYPE "TRELLIS_COMB")
    (INSTANCE core.sum_CCU2C_S0\$CCU2_COMB1)
        (IOPATH FCI FCO (50:53:56) (50:53:56))
        (IOPATH FCI F (179:253:328) (179:253:328))
    )
  (CELL
    (CELLTYPE "TRELLIS_COMB")
    (INSTANCE core.more_CCU2C_S0\$CCU2_COMB0)
        (IOPATH FCI F (179:253:328) (179:253:328))
    )
  (CELL
    (CELLTYPE "TRELLIS_FF")
    (INSTANCE core.a_TRELLIS_FF_Q)
        (IOPATH CLK Q (329:362:395) (329:362:395))
    )
  (CELL
    (CELLTYPE "TRELLIS_FF")
    (INSTANCE b)
      (SETUPHOLD (posedge DI) (posedge CLK) (0:0:4) (196:213:231))
      (SETUPHOLD (negedge DI) (posedge CLK) (0:0:4) (196:213:231))
      (SETUPHOLD (posedge M) (posedge CLK) (0:0:0) (196:213:231))
    )
)
"#;

    #[test]
    fn the_longest_path_is_that_through_the_adder() {
        let delays = Delays::parse(ADDER).unwrap();
        let longest = delays.longest().unwrap();
        assert_eq!(longest.picoseconds, 395 + 700 + 355 + 56 + 328 + 118 + 4);
        assert_eq!(longest.logic, 395 + 355 + 56 + 328 + 4);
        assert_eq!(longest.end, "b");
        let cells: Vec<_> = longest.outputs.iter().map(|(cell, port)| format!("{cell}.{port}")).collect();
        let expected = [
            "core.a_TRELLIS_FF_Q.Q",
            "core.sum_CCU2C_S0$CCU2_COMB0.FCO",
            "core.sum_CCU2C_S0$CCU2_COMB1.FCO",
            "core.more_CCU2C_S0$CCU2_COMB0.F",
        ];
        assert_eq!(cells, expected);
    }

    #[test]
    fn an_upper_half_passes_its_carry_on_at_once_and_a_lower_one_does_not() {
        let lasts = |text: &str| {
            let mut delays = Delays::parse(text).unwrap();
            let before = delays.longest().unwrap().picoseconds;
            delays.count_upper_halves_as_packed();
            before - delays.longest().unwrap().picoseconds
        };
        assert_eq!(lasts(ADDER), 56);
        assert_eq!(lasts(&ADDER.replace("COMB1", "COMB0x")), 0);
        // Where it is right already, nothing changes.
        assert_eq!(lasts(&ADDER.replace("FCO (50:53:56)", "FCO (0:0:0)")), 0);
        // The sum of an upper half comes a little earlier than that of a lower one.
        let upper = ADDER.replace("more_CCU2C_S0\\$CCU2_COMB0", "more_CCU2C_S0\\$CCU2_COMB1");
        assert_eq!(lasts(&upper), 56 + 328 - 293);
    }

    #[test]
    fn a_loop_ends_and_a_path_without_a_clock_does_not_count() {
        let again = "(INTERCONNECT core.more_CCU2C_S0\\$CCU2_COMB0/F core.more_CCU2C_S0\\$CCU2_COMB0/B (1:1:1) (1:1:1))";
        let through = "(INSTANCE core.more_CCU2C_S0\\$CCU2_COMB0)\n(IOPATH B F (9:9:9) (9:9:9))";
        let text = ADDER.replacen("(INTERCONNECT", &format!("{again}\n(INTERCONNECT"), 1);
        let text = text.replace("(INSTANCE core.more_CCU2C_S0\\$CCU2_COMB0)", through);
        assert_eq!(Delays::parse(&text).unwrap().longest(), Delays::parse(ADDER).unwrap().longest());
        assert_eq!(Delays::parse("(DELAYFILE\n)\n").unwrap().longest(), None);
    }

    #[test]
    fn what_is_no_such_file_is_refused() {
        for text in
            ["(INTERCONNECT a b (1:1:1))", "(IOPATH A F)", "(SETUPHOLD (posedge A) (posedge CLK) (x) (y))"]
        {
            assert!(Delays::parse(text).is_none(), "{text}");
        }
    }

    /// Placed in one go, and read back: corrected, the delays of the second give the clock of the first.
    #[test]
    fn a_placement_that_was_read_back_is_as_fast_as_before() {
        use crate::cosim::Settings;
        use crate::fpga::{Device, cache::Cache, find, harness, synthesis, timing::Timing};
        use crate::hdl::{Builder, Word, verilog};

        let (device, settings) = (Device::named("ecp5-25k").unwrap(), Settings::default());
        let Ok(tools) = find(device, &settings) else {
            eprintln!("skipped: no nextpnr-ecp5 here; 'make fpga-tools' installs it");
            return;
        };
        let m = Builder::new("adder");
        let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(60)));
        m.output("y", m.pipe("y", &a + &b));
        let core = m.finish().unwrap();
        let mut sources = verilog::print(&core, "").unwrap();
        sources.push(harness::harness(&core).unwrap());
        let design = synthesis::Design { sources: &sources, top: harness::NAME, pads: true };
        let cache = Cache::open(&settings, false);
        let made = synthesis::synthesise(&design, device, &tools.yosys, &settings, &cache, &|_| ()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("netlist.json"), made.netlist.text().unwrap()).unwrap();
        let run = |words: &str| {
            let common = "--report report.json --sdf delays.sdf --lpf-allow-unconstrained --timing-allow-fail --seed 1";
            let mut command = std::process::Command::new(&tools.placer.program);
            command.current_dir(folder.path()).args(device.arguments).args(common.split(' '));
            let output = command.args(words.split(' ')).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
            (read("report.json"), read("delays.sdf"))
        };
        let clock = |sdf: &str, corrected: bool| {
            let mut delays = Delays::parse(sdf).unwrap();
            if corrected {
                delays.count_upper_halves_as_packed();
            }
            1e6 / delays.longest().unwrap().picoseconds as f64
        };
        let same = |a: f64, b: f64| (a - b).abs() < 0.02;
        let (report, delays) = run("--json netlist.json --write placed.json");
        let packed = Timing::parse(report.as_bytes()).unwrap().clock_mhz;
        assert!(same(clock(&delays, false), packed) && same(clock(&delays, true), packed), "{packed}");
        let (_, delays) = run("--json placed.json --no-pack --no-place --no-route");
        let as_it_stands = clock(&delays, false);
        assert!(as_it_stands < 0.9 * packed, "{as_it_stands} and {packed}");
        assert!(same(clock(&delays, true), packed));
    }
}
