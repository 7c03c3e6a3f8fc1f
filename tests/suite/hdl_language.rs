//! The language: what a module computes, how wide it comes out, what it refuses and in which words.
//!
//! ```text
//! Builder ──► finish ──► Module ──► Flat ──► Simulator<Integers>      what it computes
//!    │                     └─────► text       └► Simulator<LinearForms>  what it proves
//!    └─► the first mistake: signal, format, range, source line
//! ```

use std::rc::Rc;

use subdiv_rtl::fixed::{Form, Range, Rounding};
use subdiv_rtl::hdl::linear::Value;
use subdiv_rtl::hdl::{
    Builder, Counts, Flat, Integers, LinearForms, Module, Relation, Signal, Simulator, Sum, Word, verilog,
};
use subdiv_rtl::{Error, Kind};

/// A module in the built-in simulator, its ports by name.
struct Bench(Simulator<Integers>);

impl Bench {
    fn new(m: Builder) -> Bench {
        let mut simulator = Simulator::new(Flat::new(&m.finish().unwrap()).unwrap(), Integers);
        simulator.settle();
        Bench(simulator)
    }

    fn put(&mut self, name: &str, value: i128) {
        let input = self.0.flat.input(name).unwrap();
        self.0.set(input, value);
        self.0.settle();
    }

    fn get(&self, name: &str) -> i128 {
        *self.0.get(self.0.flat.output(name).unwrap())
    }

    fn edge(&mut self, reset: bool) {
        self.0.edge(reset).unwrap();
        self.0.settle();
    }

    /// The output y for the numbers at a and b.
    fn y(&mut self, a: i128, b: i128) -> i128 {
        self.put("a", a);
        self.put("b", b);
        self.get("y")
    }
}

/// A module `m` with the inputs a and b.
fn two_inputs(a: Word, b: Word) -> (Builder, Signal, Signal) {
    let m = Builder::new("m");
    let (a, b) = (m.input("a", a), m.input("b", b));
    (m, a, b)
}

/// The mistake for which the module is refused.
fn mistake(m: Builder) -> Error {
    let error = m.finish().expect_err("the module must be refused");
    assert_eq!(error.kind, Kind::Usage);
    error
}

#[track_caller]
fn says(error: &Error, words: &[&str]) {
    for word in words {
        assert!(error.what.contains(word), "'{word}' is missing in: {error}");
    }
}

/// What does not hold when the inputs of the module are any numbers of their words.
fn unproved(module: &Rc<Module>) -> Vec<Error> {
    let flat = Flat::new(module).unwrap();
    let ranges: Vec<Range> = flat.inputs.iter().map(|(_, id)| flat.node(*id).word.range).collect();
    assert!(ranges.iter().all(|range| *range == ranges[0]), "the inputs are of one group");
    let inputs: Vec<_> = flat.inputs.iter().map(|(_, id)| *id).collect();
    let mut prover = Simulator::new(flat, LinearForms::<2>::new(vec![ranges[0]]));
    for (index, input) in inputs.into_iter().enumerate() {
        prover.set(input, Value::Form(Form::variable(0, index)));
    }
    prover.settle();
    prover.domain.failures
}

// ---- widths -------------------------------------------------------------------------------------------

#[test]
fn a_mask_costs_its_bits_and_not_one_for_each_adder() {
    let m = Builder::new("m");
    let p: Vec<Signal> = (0..7).map(|i| m.input(format!("p{i}"), Word::signed(8))).collect();
    // The weights of a Loop vertex of valence 6, 10 + 6 * 1 = 16: four bits, however the sum is cut.
    let ring = p[1..].iter().fold(Sum::from(0), |sum, q| sum + q);
    let partial = m.wire("partial", ring);
    let whole = m.wire("whole", 10 * &p[0] + &partial);
    assert_eq!((whole.width(), whole.word().range), (12, Range::signed(8) * 16));
    // What is added and taken away again costs nothing.
    let back = m.wire("back", &whole - &partial - 9 * &p[0]);
    assert_eq!(back.word(), Word::signed(8));
}

#[test]
fn a_word_too_wide_to_be_proved_is_refused() {
    let (m, a, _) = two_inputs(Word::signed(100), Word::bit());
    m.output("y", &a << 30);
    says(&mistake(m), &["is wider than 120"]);
}

// ---- formats ------------------------------------------------------------------------------------------

#[test]
fn binary_points_must_agree_and_the_message_says_who_where_and_how() {
    let (m, a, b) = two_inputs(Word::signed(8).fraction(4), Word::unsigned(6).fraction(3));
    let line = line!() + 1;
    m.output("y", &a + &b);
    let error = mistake(m);
    says(&error, &["m.a (sQ4.4 [-128, 127])", "m.b (uQ3.3 [0, 63])", "the binary points differ"]);
    assert_eq!(error.place, Some(format!("{}:{line}", file!())));
    assert!(error.help.unwrap().contains("rescale"));
}

#[test]
fn choices_and_comparisons_need_one_binary_point_too() {
    let words = (Word::signed(8).fraction(4), Word::signed(8));
    let (m, a, b) = two_inputs(words.0, words.1);
    m.output("y", m.compare(Relation::Less, &a, &b));
    says(&mistake(m), &["m.a (sQ4.4 [-128, 127])", "m.b (sQ8.0 [-128, 127])"]);
    let (m, a, b) = two_inputs(words.0, words.1);
    m.output("y", m.select(&m.bit(true), &a, &b));
    says(&mistake(m), &["m.a (sQ4.4 [-128, 127])", "m.b (sQ8.0 [-128, 127])"]);
}

#[test]
fn the_first_mistake_is_the_one_reported() {
    let (m, a, b) = two_inputs(Word::signed(8).fraction(4), Word::signed(8));
    let line = line!() + 1;
    m.output("bits", m.slice(&b, 6, 4));
    m.output("sum", &a + &b);
    let error = mistake(m);
    says(&error, &["bits 6 to 9 of m.b"]);
    assert_eq!(error.place, Some(format!("{}:{line}", file!())));
}

#[test]
fn bits_that_are_not_there_are_refused() {
    let (m, a, _) = two_inputs(Word::signed(8), Word::bit());
    m.output("y", m.slice(&a, 6, 4));
    says(&mistake(m), &["bits 6 to 9 of m.a", "sQ8.0"]);
}

#[test]
fn a_constant_outside_of_its_word_is_refused() {
    let m = Builder::new("m");
    m.output("y", m.constant(16, Word::unsigned(4)));
    says(&mistake(m), &["constant 16", "uQ4.0 [0, 15]"]);
}

// ---- time ---------------------------------------------------------------------------------------------

#[test]
fn latencies_are_balanced_by_delays_that_are_shared() {
    let (m, a, b) = two_inputs(Word::signed(8), Word::signed(8));
    let late = m.pipe("late", m.pipe("early", &b));
    m.output("sum", &a + &late);
    m.output("difference", &late - &a);
    let module = m.finish().unwrap();
    assert!(module.outputs.iter().all(|output| module.latency(output) == 2));
    // Two stages of b, and a delayed twice, once for both sums.
    assert_eq!(Counts::of(&module).registers, 4);
    let mut bench = Bench(Simulator::new(Flat::new(&module).unwrap(), Integers));
    let mut sums = vec![];
    for clock in 0..5 {
        bench.put("a", clock);
        bench.put("b", 10 * clock);
        sums.push((bench.get("sum"), bench.get("difference")));
        bench.edge(false);
    }
    assert_eq!(sums[2..], [(0, 0), (11, 9), (22, 18)]);
}

#[test]
fn a_strict_module_refuses_signals_of_two_clocks_and_names_both() {
    let (m, a, b) = two_inputs(Word::signed(8), Word::signed(8));
    m.strict_latency();
    let late = m.pipe("late", &b);
    m.output("y", &a + &late);
    says(&mistake(m), &["m.a is of clock 0", "m.late of clock 1"]);
}

// ---- state --------------------------------------------------------------------------------------------

#[test]
fn a_register_that_cannot_hold_its_value_is_refused_with_both_ranges() {
    let (m, a, _) = two_inputs(Word::signed(8), Word::bit());
    let r = m.register("r", Word::range(-100, 100));
    let line = line!() + 1;
    m.always(&r, &a);
    m.output("y", &r);
    let error = mistake(m);
    says(&error, &["m.r is sQ8.0 [-100, 100]", "m.a that it takes is sQ8.0 [-128, 127]"]);
    assert_eq!(error.place, Some(format!("{}:{line}", file!())));
}

#[test]
fn what_is_never_driven_is_refused() {
    let m = Builder::new("m");
    m.output("y", m.forward("w", Word::bit()));
    says(&mistake(m), &["m.w is never driven"]);
    let m = Builder::new("m");
    m.output("y", m.register("r", Word::bit()));
    says(&mistake(m), &["m.r is never given a value"]);
}

#[test]
fn a_combinational_loop_names_the_signals_on_it() {
    let (m, a, b) = two_inputs(Word::bit(), Word::bit());
    let back = m.forward("back", Word::bit());
    let inner = m.wire("inner", &a & &back);
    let outer = m.wire("outer", &b | &inner);
    m.drive(&back, &outer);
    m.output("y", &outer);
    let error = Flat::new(&m.finish().unwrap()).expect_err("a loop");
    says(&error, &["combinational loop", "inner", "outer"]);
}

#[test]
fn a_register_takes_reset_before_its_clauses_and_the_first_clause_that_applies() {
    let (m, a, b) = two_inputs(Word::bit(), Word::bit());
    let r = m.register_reset("r", Word::unsigned(4), 9);
    m.on(&a, &r, m.constant(3, r.word()));
    m.on(&b, &r, m.constant(5, r.word()));
    m.output("y", &r);
    let mut bench = Bench::new(m);
    let mut seen = vec![];
    for (reset, a, b) in [(true, 1, 1), (false, 0, 0), (false, 0, 1), (false, 1, 1), (false, 0, 0)] {
        bench.y(a, b);
        bench.edge(reset);
        seen.push(bench.get("y"));
    }
    assert_eq!(seen, [9, 9, 5, 3, 3]);
}

#[test]
fn a_memory_is_read_before_it_is_written_and_holds_while_not_enabled() {
    let m = Builder::new("m");
    let [write, read] = ["write", "read"].map(|name| m.input(name, Word::bit()));
    let (address, data) = (m.input("address", Word::unsigned(2)), m.input("data", Word::signed(8)));
    let memory = m.memory("memory", 4, Word::signed(8), vec![-1, -2, -3, -4]);
    memory.write(&write, &address, &data);
    m.output("y", memory.read("word", &address, Some(&read)));
    let mut bench = Bench::new(m);
    let mut seen = vec![];
    for (write, read, address, data) in
        [(0, 1, 2, 50), (1, 1, 2, 60), (0, 1, 2, 70), (1, 0, 1, 80), (0, 1, 1, 90)]
    {
        for (name, value) in [("write", write), ("read", read), ("address", address), ("data", data)] {
            bench.put(name, value);
        }
        bench.edge(false);
        seen.push(bench.get("y"));
    }
    assert_eq!(seen, [-3, -3, 60, 60, 80]);
}

#[test]
fn a_word_that_is_written_cannot_be_read_where_reads_and_writes_are_apart() {
    let m = Builder::new("m");
    let [from, to] = ["from", "to"].map(|name| m.input(name, Word::unsigned(2)));
    let memory = m.memory("memory", 4, Word::signed(8), vec![-1, -2, -3, -4]).apart();
    memory.write(&m.bit(true), &to, &m.input("data", Word::signed(8)));
    m.output("y", memory.read("word", &from, None));
    let flat = Flat::new(&m.finish().unwrap()).unwrap();
    let [from, to, data] = ["from", "to", "data"].map(|name| flat.input(name).unwrap());
    let mut simulator = Simulator::new(flat, LinearForms::<1>::new(vec![]));
    let mut read = |word, written| {
        [(from, word), (to, written), (data, 5)]
            .into_iter()
            .for_each(|(input, value)| simulator.set(input, Value::Integer(value)));
        simulator.settle();
        simulator.edge(false).unwrap();
        simulator.settle();
        *simulator.get(simulator.flat.output("y").unwrap())
    };
    assert_eq!(read(1, 2), Value::Integer(-2));
    assert_eq!(read(2, 3), Value::Integer(5));
    assert_eq!(read(0, 0), Value::Unknown);
}

#[test]
fn a_rom_gives_its_contents_one_clock_after_the_address() {
    let (m, a, _) = two_inputs(Word::unsigned(2), Word::bit());
    let rom = m.memory("rom", 4, Word::signed(4), vec![3, -8, 7, 0]);
    let word = rom.read("word", &a, None);
    assert_eq!(word.time(), Some(1));
    m.output("y", &word);
    let mut bench = Bench::new(m);
    let words = [0, 1, 2, 3].map(|address| {
        bench.put("a", address);
        bench.edge(false);
        bench.get("y")
    });
    assert_eq!(words, [3, -8, 7, 0]);
}

#[test]
fn an_address_or_contents_outside_of_a_memory_are_refused() {
    let (m, a, _) = two_inputs(Word::unsigned(3), Word::bit());
    m.output("y", m.memory("rom", 5, Word::bit(), vec![]).read("word", &a, None));
    says(&mistake(m), &["memory rom has 5 words", "m.a is uQ3.0 [0, 7]"]);
    let m = Builder::new("m");
    m.memory("rom", 1, Word::signed(4), vec![8]);
    says(&mistake(m), &["memory rom", "sQ4.0 [-8, 7]"]);
}

#[test]
fn a_state_machine_is_in_one_state_and_makes_the_first_move_that_applies() {
    let (m, go, stop) = two_inputs(Word::bit(), Word::bit());
    let states = ["idle", "running", "done"];
    let mut machine = m.state_machine("phase", &states);
    states.iter().for_each(|state| m.output(*state, machine.is(state)));
    machine.go("idle", &go, "running");
    machine.go("running", &stop, "done");
    machine.go("running", &go, "idle");
    machine.go("done", &m.bit(true), "idle");
    machine.finish();
    let mut bench = Bench::new(m);
    bench.edge(true);
    let mut visited = vec![];
    for (go, stop) in [(0, 1), (1, 1), (0, 0), (1, 0), (1, 0), (1, 1), (0, 0)] {
        bench.put("a", go);
        bench.put("b", stop);
        bench.edge(false);
        let active: Vec<_> = states.into_iter().filter(|state| bench.get(state) == 1).collect();
        assert_eq!(active.len(), 1, "{active:?}");
        visited.push(active[0]);
    }
    assert_eq!(visited, ["idle", "running", "running", "idle", "running", "done", "idle"]);
}

// ---- numbers ------------------------------------------------------------------------------------------

#[test]
fn every_rounding_is_that_of_the_specification() {
    for mode in Rounding::TOTAL.into_iter().chain([Rounding::Exact]) {
        for drop in 0..=4 {
            let (m, a, _) = two_inputs(Word::signed(8).fraction(4), Word::bit());
            let rounded = m.round(&a, drop, mode);
            assert_eq!(rounded.word().fraction, 4 - drop as i32);
            m.output("y", &rounded);
            let mut bench = Bench::new(m);
            for value in -128..128 {
                if let Some(expected) = mode.apply(value, drop) {
                    assert_eq!(bench.y(value, 0), expected, "{mode} of {value} by {drop} bits");
                }
            }
        }
    }
}

#[test]
fn saturation_gives_the_nearest_number_of_the_range() {
    let (m, a, _) = two_inputs(Word::signed(8), Word::bit());
    let y = m.saturate(&a, Range::new(-5, 20));
    assert_eq!(y.word(), Word::range(-5, 20));
    m.output("y", &y);
    let mut bench = Bench::new(m);
    (-128..128).for_each(|value| assert_eq!(bench.y(value, 0), value.clamp(-5, 20)));
}

#[test]
fn signed_and_unsigned_numbers_are_compared_chosen_and_multiplied_as_numbers() {
    let (m, a, b) = two_inputs(Word::unsigned(4), Word::signed(4));
    let least = m.select(&m.compare(Relation::Less, &a, &b), &a, &b);
    assert_eq!(least.word().range, Range::new(-8, 15));
    m.output("least", &least);
    for (name, relation) in
        [("le", Relation::LessOrEqual), ("eq", Relation::Equal), ("ne", Relation::NotEqual)]
    {
        m.output(name, m.compare(relation, &a, &b));
    }
    let product = m.product(m.rescale(&a, 3), m.rescale(&b, 2));
    assert_eq!((product.word().range, product.word().fraction), (Range::new(-120, 105), 5));
    m.output("y", &product);
    let mut bench = Bench::new(m);
    for (a, b) in (0..16).flat_map(|a| (-8..8).map(move |b| (a, b))) {
        assert_eq!(bench.y(a, b), a * b);
        let seen = ["least", "le", "eq", "ne"].map(|name| bench.get(name));
        assert_eq!(seen, [a.min(b), (a <= b).into(), (a == b).into(), (a != b).into()], "{a}, {b}");
    }
}

// ---- modular words and the proof ----------------------------------------------------------------------

#[test]
fn a_modular_word_wraps_and_its_high_bits_cannot_be_read_without_a_claim() {
    let wrapped = |m: &Builder, a: &Signal, b: &Signal| m.modulo(m.signal(a + b), 8);
    let uses: [fn(&Builder, &Signal) -> Signal; 3] =
        [|m, s| m.is(s, 3), |m, s| m.round(s, 2, Rounding::HalfUp), |m, s| m.product(s, s)];
    for reads in uses {
        let (m, a, b) = two_inputs(Word::signed(8), Word::signed(8));
        m.output("y", reads(&m, &m.wire("s", wrapped(&m, &a, &b))));
        let error = mistake(m);
        says(&error, &["m.s"]);
        assert!(error.help.as_ref().is_some_and(|help| help.contains("claim")), "{error}");

        let (m, a, b) = two_inputs(Word::signed(8), Word::signed(8));
        let claimed = m.claim("c", wrapped(&m, &a, &b), Word::signed(8), None);
        m.output("y", reads(&m, &claimed));
        assert!(m.finish().is_ok());
    }
    let (m, a, b) = two_inputs(Word::signed(8), Word::signed(8));
    m.output("y", wrapped(&m, &a, &b));
    assert_eq!(Bench::new(m).y(100, 100), 200 - 256);
}

#[test]
fn a_claim_that_does_not_hold_is_refused_with_both_ranges() {
    let claim = |bound: i128| {
        let (m, a, b) = two_inputs(Word::range(-8, 8), Word::range(-8, 8));
        let sum = m.modulo(m.signal(&a - 2 * &b), 8);
        m.output("y", m.claim("c", &sum, Word::range(-bound, bound), None));
        unproved(&m.finish().unwrap())
    };
    assert_eq!(claim(24), []);
    says(&claim(23)[0], &["c: its range is [-24, 24], but [-23, 23] is claimed"]);
}

#[test]
fn a_claim_beyond_the_modulus_is_refused() {
    let (m, a, b) = two_inputs(Word::range(-8, 8), Word::range(-8, 8));
    let sum = m.modulo(m.signal(&a - 2 * &b), 5);
    m.output("y", m.claim("c", &sum, Word::range(-24, 24), None));
    // Five bits hold -16 to 15, the sum is anything from -24 to 24.
    says(&unproved(&m.finish().unwrap())[0], &["[-24, 24]", "[-16, 15]"]);
}

#[test]
fn exact_rounding_is_proved_or_refused() {
    let exact = |weight: i128| {
        let (m, a, b) = two_inputs(Word::signed(6), Word::signed(6));
        m.output("y", m.round(4 * &a + weight * &b, 2, Rounding::Exact));
        unproved(&m.finish().unwrap())
    };
    assert_eq!(exact(12), []);
    says(&exact(6)[0], &["the lowest 2 bits are not all zero"]);
}

// ---- text ---------------------------------------------------------------------------------------------

#[test]
fn reserved_words_and_repeated_names_are_printed_under_others() {
    let m = Builder::new("reg");
    let a = m.input("edge", Word::bit());
    let (first, second) = (m.wire("w", !&a), m.pipe("w", &a));
    m.output("output", &first & &second);
    m.output("y", &first ^ &second);
    let inner = m.finish().unwrap();
    let m = Builder::new("top");
    let a = m.input("a", Word::bit());
    m.output("y", m.instance("begin", &inner, &[("edge_2", &a)]).out("y"));
    let files = verilog::print(&m.finish().unwrap(), "").unwrap();
    assert_eq!(files.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["reg_2.v", "top.v"]);
    for name in ["module reg_2 (", " edge_2", " w;", " w_2", " output_2"] {
        assert!(files[0].text.contains(name), "'{name}' is missing in\n{}", files[0].text);
    }
    assert!(files[1].text.contains("reg_2 begin_2 ("), "{}", files[1].text);
}

fn second_difference() -> String {
    let m = Builder::new("second_difference");
    m.purpose("y = a - 2 b + c, one clock later.");
    m.parameter("width", 8);
    let [a, b, c] = ["a", "b", "c"].map(|name| m.input(name, Word::signed(8).fraction(4)));
    m.output("y", m.pipe("y", &a - 2 * &b + &c));
    let files = verilog::print(&m.finish().unwrap(), "the command").unwrap();
    files[0].text.replace(env!("CARGO_PKG_VERSION"), "VERSION")
}

#[test]
fn the_text_of_a_module_is_this_one_on_every_run() {
    assert_eq!(second_difference(), include_str!("hdl_text/second_difference.v"));
    assert_eq!(second_difference(), second_difference());
}
