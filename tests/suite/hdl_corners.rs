//! Corners of the language: shifts past the end, ports of different times, choices that are none, constants in odd
//! places; each in the built-in simulator and in the text that is printed.

use std::rc::Rc;

use subdiv_rtl::fixed::Rounding;
use subdiv_rtl::hdl::{Builder, Cell, Counts, Flat, Integers, Module, Relation, Simulator, Word, verilog};

/// The output y for these inputs, after that many clocks of them.
fn y(module: &Rc<Module>, inputs: &[(&str, i128)], clocks: usize) -> i128 {
    let mut simulator = Simulator::new(Flat::new(module).unwrap(), Integers);
    for &(name, value) in inputs {
        simulator.set(simulator.flat.input(name).unwrap(), value);
    }
    simulator.settle();
    for _ in 0..clocks {
        simulator.edge(false).unwrap();
        simulator.settle();
    }
    *simulator.get(simulator.flat.output("y").unwrap())
}

fn text(module: &Rc<Module>) -> String {
    verilog::print(module, "a test").unwrap().into_iter().map(|file| file.text).collect()
}

fn refused(m: Builder) -> String {
    m.finish().map(|_| ()).expect_err("the module must be refused").what
}

#[test]
fn a_word_that_loses_all_its_bits_is_a_constant_or_its_sign() {
    let modes = [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven];
    for (word, mode, drop) in [Word::unsigned(4), Word::signed(4)]
        .into_iter()
        .flat_map(|word| modes.map(|mode| (word, mode)))
        .flat_map(|(word, mode)| (1..=9).map(move |drop| (word, mode, drop)))
    {
        let m = Builder::new("m");
        let a = m.input("a", word);
        let rounded = m.round(&a, drop, mode);
        assert_eq!(rounded.word().fraction, -(drop as i32));
        m.output("y", &rounded);
        let module = m.finish().unwrap();
        for value in word.range.min..=word.range.max {
            assert_eq!(
                Some(y(&module, &[("a", value)], 0)),
                mode.apply(value, drop),
                "{value} {mode} {drop}"
            );
        }
        if drop > 5 && (mode != Rounding::Floor || !word.is_signed()) {
            assert!(text(&module).contains("assign y = 1'd0;"), "{word} {mode} {drop}\n{}", text(&module));
        }
    }
    let m = Builder::new("m");
    let a = m.input("a", Word::unsigned(4));
    m.output("y", m.round(&a, 500, Rounding::HalfUp));
    assert!(refused(m).contains("500 bits dropped of m.a"));
}

/// Exact rounding keeps its obligation, so it stays a cell; what it gives is nothing of the word.
#[test]
fn an_exact_shift_past_the_end_prints_zero_and_not_the_highest_bit() {
    let m = Builder::new("m");
    let a = m.input("a", Word::unsigned(4));
    m.output("y", m.round(&a, 5, Rounding::Exact));
    let text = text(&m.finish().unwrap());
    assert!(text.contains("assign y = 1'd0;") && !text.contains("a[3]"), "{text}");
}

#[test]
fn the_ports_of_a_memory_wait_for_their_latest_signal() {
    let m = Builder::new("m");
    let bits = Word::unsigned(2);
    let [address, at] = ["address", "at"].map(|name| m.input(name, bits));
    let (enable, data) = (m.input("enable", Word::bit()), m.input("data", Word::unsigned(8)));
    let memory = m.memory("memory", 4, Word::unsigned(8), vec![10, 11, 12, 13]);
    let late = m.pipe("late", m.pipe("sooner", &data));
    memory.write(&enable, &address, &late);
    let read = memory.read("word", &at, Some(&m.pipe("later", &enable)));
    // The address waits a clock for the enable, and the word comes a clock after both.
    assert_eq!(read.time(), Some(2));
    m.output("y", &read);
    let module = m.finish().unwrap();
    let write = module.memories[0].write.as_ref().unwrap();
    let times = [write.enable, write.address, write.data].map(|id| module.node(id).time);
    assert_eq!(times, [Some(2); 3]);

    let mut simulator = Simulator::new(Flat::new(&module).unwrap(), Integers);
    // In clock t the address is t and the data 100 + t: they belong together.
    for clock in 0..8 {
        for (name, value) in
            [("address", clock % 4), ("data", 100 + clock), ("enable", 1), ("at", (clock + 2) % 4)]
        {
            simulator.set(simulator.flat.input(name).unwrap(), value);
        }
        simulator.settle();
        if clock >= 6 {
            // The address of two clocks ago, clock % 4; the newest data there is that of four clocks ago.
            assert_eq!(*simulator.get(simulator.flat.output("y").unwrap()), 100 + clock - 4, "clock {clock}");
        }
        simulator.edge(false).unwrap();
    }
}

#[test]
fn a_word_at_a_constant_address_is_of_the_clock_after() {
    let m = Builder::new("m");
    let memory = m.memory("memory", 4, Word::unsigned(8), vec![10, 11, 12, 13]);
    assert_eq!(memory.read("word", &m.constant(2, Word::unsigned(2)), None).time(), Some(1));
}

#[test]
fn a_module_with_a_bus_goes_into_no_other() {
    let m = Builder::new("inner");
    let lanes = m.input_bus("lanes", 8, &[("a", Word::signed(8))]);
    m.output("y", &lanes[0]);
    let inner = m.finish().unwrap();
    let m = Builder::new("outer");
    let a = m.input("a", Word::signed(8));
    m.output("y", m.instance("one", &inner, &[("lanes_a", &a)]).out("y"));
    assert_eq!(refused(m), "instance one of inner, which has the bus port lanes");
}

#[test]
fn a_memory_that_nobody_reads_is_not_printed_nor_counted_and_needs_no_clock() {
    let m = Builder::new("m");
    let (a, address) = (m.input("a", Word::unsigned(8)), m.input("address", Word::unsigned(2)));
    let memory = m.memory("memory", 4, Word::unsigned(8), vec![]);
    memory.write(&m.bit(true), &address, &a);
    memory.read("lost", &address, None);
    m.output("y", &a);
    let module = m.finish().unwrap();
    let text = text(&module);
    assert!(!text.contains("memory") && !text.contains("aclk"), "{text}");
    assert!(text.contains("unused = &{1'b0, address}"), "{text}");
    assert_eq!((Counts::of(&module).memories, Counts::of(&module).registers), (0, 0));
}

#[test]
fn a_choice_with_a_constant_condition_is_the_choice() {
    let m = Builder::new("m");
    let (a, b) = (m.input("a", Word::signed(8)), m.input("b", Word::signed(8)));
    assert_eq!(m.select(&m.bit(true), &a, &b).name().as_deref(), Some("a"));
    assert_eq!(m.select(&m.bit(false), &a, &b).name().as_deref(), Some("b"));
    // The word stays that of the choice between both, as its width may be relied upon.
    let wide = m.input("wide", Word::signed(12));
    let chosen = m.select(&m.bit(true), &a, &wide);
    assert_eq!(chosen.word(), Word::signed(12));
    m.output("y", &chosen);
    let module = m.finish().unwrap();
    assert!(!module.nodes.iter().any(|node| matches!(node.cell, Cell::Select { .. })));
    assert_eq!(y(&module, &[("a", -100), ("b", 1), ("wide", 2000)], 0), -100);
}

#[test]
fn a_reset_or_contents_outside_of_the_range_are_refused() {
    let word = Word::range(-3, 9);
    let m = Builder::new("m");
    m.register_reset("state", word, 10);
    assert_eq!(refused(m), "register m.state is sQ5.0 [-3, 9], but its reset is 10");
    let m = Builder::new("m");
    let a = m.input("a", word);
    m.pipe_reset("stage", &a, -4);
    assert!(refused(m).contains("m.stage"));
    let m = Builder::new("m");
    m.memory("rom", 2, word, vec![10]);
    assert!(refused(m).contains("memory rom"));
}

/// 8 x - 8 x + y is y; its word has no room for the terms that cancel.
#[test]
fn terms_that_cancel_leave_no_empty_part_select() {
    let m = Builder::new("m");
    let (a, b) = (m.input("a", Word::bit()), m.input("b", Word::bit()));
    m.output("y", m.signal(8 * &a + &b - 8 * &a));
    let module = m.finish().unwrap();
    assert_eq!(module.node(module.outputs[0].node).word, Word::bit());
    assert!(!text(&module).contains("a["), "{}", text(&module));
    assert_eq!(y(&module, &[("a", 1), ("b", 1)], 0), 1);
}

/// Bits of a constant are a constant, at the width and the place where they are used.
#[test]
fn constants_behind_wiring_are_printed_in_the_width_of_their_use() {
    let m = Builder::new("m");
    let a = m.input("a", Word::unsigned(6));
    let bits = m.slice(&m.constant(0b1100, Word::unsigned(4)), 2, 2);
    m.output("y", m.signal(&a + 4 * &bits));
    let module = m.finish().unwrap();
    assert!(text(&module).contains("7'd12"), "{}", text(&module));
    assert_eq!(y(&module, &[("a", 1)], 0), 13);
}

/// Verilog compares two signed operands as signed ones, and takes a signed index as a negative one.
#[test]
fn unsigned_uses_of_signed_nets_are_printed_as_unsigned() {
    let m = Builder::new("m");
    let (a, b) = (m.input("a", Word::signed(2)), m.input("b", Word::signed(2)));
    let [low, high] = [&a, &b].map(|s| m.wrap(s, Word::unsigned(2)));
    let memory = m.memory("memory", 4, Word::unsigned(8), vec![1, 2, 3, 4]);
    m.output("word", memory.read("read", &low, None));
    m.output("y", m.compare(Relation::Less, &low, &high));
    let module = m.finish().unwrap();
    let text = text(&module);
    assert!(text.contains("memory[$unsigned(a)]") && text.contains("$unsigned(a) < b"), "{text}");
    // -1 is 3, and 1 is 1.
    assert_eq!(y(&module, &[("a", 1), ("b", -1)], 0), 1);
}
