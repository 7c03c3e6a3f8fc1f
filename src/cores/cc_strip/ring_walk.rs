//! The fan unit of a registered core that sends columns in slices: it walks around one end of a column after the
//! other, a neighbour a clock.
//!
//! ```text
//! step q      0      1     2    3    ..   d-1     (3 of valence 3)
//! neighbour   inner  left  a_1  a_2  ..   right   inner
//! diagonal    inner  inner x_1  x_2  ..   after   inner         the one before the neighbour; that of step 0 is
//!             right  left                         right         the one behind the last
//!
//! face_q  = S + n_{q-1} + x_q + n_q                x' = face / 4
//! spoke_q = face_q + face_{q+1} + 4 (S + n_q)      a' = spoke / 16, left' is that of step 2, right' that of d - 2
//! T       = sum of 6 n_q + x_q - 7 S               V' = S + kappa_d T, four bits of kappa_d a clock
//! ```
//!
//! The window must stand until all neighbours have been looked at; control sees to that. What is made of one column
//! is kept until the next walk is as far.

use std::rc::Rc;

use super::fan::{End, kappa64, names};
use super::sending::axis_word;
use super::wait::Waits;
use super::{Parameters, VALENCE_BITS};
use crate::cores::loop_fd::AXES;
use crate::error::Result;
use crate::fixed::{Range, Rounding};
use crate::hdl::{Builder, Module, Placed, Relation, Signal, Word};

/// The times of a walk.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    /// Clocks for an end: a neighbour each, and not fewer than a product takes.
    pub steps: u32,
    /// Digits of four bits of the table's entries.
    digits: u32,
}

impl Times {
    pub fn of(parameters: Parameters) -> Times {
        let digits = (parameters.replacement_bits() + 1).div_ceil(4);
        Times { steps: parameters.max_valence.max(digits), digits }
    }

    /// Clocks for which the window stands from the first one on.
    pub fn clocks(self) -> u32 {
        2 * self.steps + 1
    }

    /// The clock in which both ends are done.
    fn done(self) -> u32 {
        2 * self.steps + self.digits + 16
    }

    /// The clock from which on left and right may be kept: those of the walk before have been fetched then.
    fn sides(self) -> u32 {
        self.digits + 12
    }

    /// The clock of the strobes of the fan: the next level has walked around the column before, and not yet around
    /// this one.
    fn fans(self) -> u32 {
        self.steps + self.digits + 17
    }
}

/// Which end and which neighbour a walk is at.
struct Steps {
    number: Signal,
    bottom: Signal,
    active: Signal,
}

impl Steps {
    /// What no walk has set yet stands for nothing: no reset.
    fn new(m: &Builder, name: &str, start: &Signal, steps: u32) -> Steps {
        let time = start.time().unwrap_or(0);
        let register = |what: &str, word: Word| m.register_at(format!("{name}_{what}"), word, None, time);
        let number = register("step", Word::range(0, i128::from(steps) - 1));
        let [bottom, active] = ["bottom", "active"].map(|what| register(what, Word::bit()));
        // Known in the step before.
        let last = register("ends", Word::bit());
        m.on(start, &last, m.bit(false));
        m.always(&last, m.is(&number, i128::from(steps) - 2));
        let zero = m.constant(0, number.word());
        m.on(start, &number, &zero);
        m.on(&last, &number, &zero);
        m.always(&number, m.wrap(&number + 1, number.word()));
        m.on(start, &active, m.bit(true));
        m.on(&(&last & &bottom), &active, m.bit(false));
        m.on(start, &bottom, m.bit(false));
        m.on(&last, &bottom, m.bit(true));
        Steps { number, bottom, active }
    }

    fn at(&self, m: &Builder, step: u32) -> Signal {
        &self.active & m.is(&self.number, step.into())
    }
}

/// What a walk makes, of the clock of the rows that it belongs to.
pub struct Walked {
    /// Of both ends: the replaced vertex, and what lies left and right of it, where there is a finer level.
    pub ends: [Vec<Signal>; 2],
}

impl Walked {
    pub fn of(placed: &Placed, outside: bool) -> Walked {
        let whole = ["vertex", "left", "right"];
        let names = if outside { &whole[..] } else { &whole[..1] };
        Walked {
            ends: End::BOTH
                .map(|end| names.iter().map(|name| placed.out(&format!("{}_{name}", end.name()))).collect()),
        }
    }
}

/// Names of the strobes of the fan's entries a_i and x_i, with i from 2 on, at both ends.
pub fn strobes(parameters: Parameters) -> Vec<String> {
    let of = |end: &End| {
        let end = end.name();
        (2..=parameters.outside_neighbours()).map(move |i| format!("{end}_fan_{i}"))
    };
    End::BOTH.iter().flat_map(of).collect()
}

/// What says whose a fan is that leaves a level: nothing where all coordinates have a unit; `fan_axis` for a next level
/// where they take turns too; else every coordinate has strobes of its own, whose names end so.
pub fn strobe_endings(parameters: Parameters, level: u32) -> Vec<String> {
    match parameters.in_turn(level) && !parameters.in_turn(level + 1) {
        true => AXES.iter().map(|axis| format!("_{axis}")).collect(),
        false => vec![String::new()],
    }
}

/// The outputs of a fan that leaves a level by itself.
pub fn fan_outputs(parameters: Parameters, level: u32) -> Vec<String> {
    let endings = strobe_endings(parameters, level);
    let strobes = strobes(parameters);
    let strobes = strobes.iter().flat_map(|s| endings.iter().map(move |ending| format!("{s}{ending}")));
    let axis = parameters.in_turn(level + 1).then(|| "fan_axis".to_string());
    strobes.chain(["fan_a".to_string(), "fan_x".into()]).chain(axis).collect()
}

/// The unit for columns of a level. Inputs: `walk` (the vertex column begins to leave); a clock later the window: for
/// both ends the places of [`names`], as `top_..` and `bottom_..`; and their valences. Outputs: what [`Walked`] has;
/// and, where there is a finer level, the fan (see [`fan_outputs`]). Where coordinates take turns, `axis` says whose walk
/// begins, and for so long as the window is looked at.
pub fn build(parameters: Parameters, level: u32) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("ring_walk_{level}"));
    m.purpose(format!("Walks around the ends of a column of level {level}: replaces them and their fans."));
    m.parameter("max_valence", parameters.max_valence);
    let times = Times::of(parameters);
    let outside = level + 1 < parameters.levels;
    let word = parameters.word(level);
    let start = m.input("walk", Word::bit());
    let axis = (parameters.in_turn(level) && outside).then(|| m.input("axis", axis_word()));
    let ends = End::BOTH.map(|end| {
        let name = |place: String| m.input_at(format!("{}_{place}", end.name()), word, 1);
        names(parameters).into_iter().map(name).collect::<Vec<Signal>>()
    });
    let valences =
        End::BOTH.map(|end| m.input(format!("{}_valence", end.name()), Word::unsigned(VALENCE_BITS)));

    // Where the walk is.
    let walk = Steps::new(&m, "walk", &start, times.steps);
    // Valences stand from before the first step on; the number of the last step of a ring is one less.
    let word_of_step = Word::unsigned((times.steps - 1).ilog2() + 1);
    let ends_of = valences.map(|valence| {
        let name = format!("{}_less_1", valence.name().unwrap_or_default());
        m.restart(&m.pipe(name, m.wrap(&valence - 1, word_of_step)), 0)
    });
    let ends_at = m.pipe("ends_at", m.select(&walk.bottom, &ends_of[1], &ends_of[0]));
    let number = m.pipe("number", m.wrap(&walk.number, word_of_step));
    let active = m.pipe("active", &walk.active);
    let bottom = m.pipe("at_bottom", &walk.bottom);
    // Known of both ends in the step before.
    let of_end = |name: &str, is: &dyn Fn(&Signal) -> Signal| {
        let [top, low] =
            [0, 1].map(|end| m.pipe(format!("{}_{name}", End::BOTH[end].name()), is(&ends_of[end])));
        m.wire(name, m.select(&bottom, &low, &top))
    };
    let at_right =
        of_end("at_right", &|ends| m.compare(Relation::Equal, m.wrap(&walk.number, word_of_step), ends));
    let passed = m.register_at("passed", Word::bit(), None, 1);
    let counts = m.pipe("counts", &active & !&passed);
    let step = |step: u32| &active & m.is(&number, step.into());
    let first = m.pipe("first_step", step(0));
    let last = m.wire("at_last_step", step(times.steps - 1));
    m.on(&m.delay(&start, 1), &passed, m.bit(false));
    m.on(&last, &passed, m.bit(false));
    m.on(&at_right, &passed, m.bit(true));
    let last = m.pipe("last_step", &last);
    // The places of a ring in their order, the last one right, whatever the valence.
    let count = parameters.max_valence;
    let index = Word::unsigned((count - 1).ilog2() + 1);
    let again = of_end("again", &|ends| &m.is(ends, 2) & &m.is(&walk.number, 3));
    let place = m.select(&at_right, m.constant(i128::from(count) - 1, index), m.wrap(&number, index));
    let place = m.select(&again, m.constant(0, index), &place);
    let place = m.pipe("place", m.wrap(&place, index));

    // The window is looked at two clocks after its own.
    let seen = |signal: &Signal| m.restart(signal, 3);
    let around = |end: &[Signal]| -> [Vec<Signal>; 2] {
        let [left, _, right, inner_left, inner, inner_right, before, after] = &end[..8] else {
            return [vec![], vec![]];
        };
        let neighbours = [inner, left].into_iter().chain(end[8..].iter().step_by(2)).chain([right]);
        let diagonals =
            [inner_right, inner_left, before].into_iter().chain(end[9..].iter().step_by(2)).chain([after]);
        [neighbours.map(seen).collect(), diagonals.map(seen).collect()]
    };
    let [top, low] = [around(&ends[0]), around(&ends[1])];
    let choose = |name: &str, which: usize| {
        let all: Vec<Signal> = top[which].iter().chain(&low[which]).cloned().collect();
        let half = top[which].len();
        // Four at a time, each with bits of its own.
        let parts = all[..half].chunks(4).chain(all[half..].chunks(4));
        let chosen: Vec<Signal> = parts
            .enumerate()
            .map(|(part, signals)| {
                let bits = [0, 1].map(|at| {
                    (signals.len() > 1 << at)
                        .then(|| m.copy(format!("{name}_{part}_bit_{at}"), m.slice(&place, at, 1)))
                });
                m.pipe(format!("{name}_of_{part}"), binary(&m, &bits, signals))
            })
            .collect();
        let high: Vec<Option<Signal>> = (2..index.width())
            .map(|at| Some(m.copy(format!("{name}_bit_{at}"), m.at_time(&m.slice(&place, at, 1), 3))))
            .collect();
        let by_end = chosen.chunks(chosen.len() / 2).map(|parts| binary(&m, &high, parts));
        let by_end: Vec<Signal> = by_end.collect();
        let at_bottom = m.copy(format!("{name}_bottom"), m.at_time(&bottom, 3));
        m.pipe(name, m.select(&at_bottom, &by_end[1], &by_end[0]))
    };
    let neighbour = choose("neighbour", 0);
    let diagonal = choose("diagonal", 1);
    let centre = m.select(&m.at_time(&bottom, 3), seen(&ends[1][1]), seen(&ends[0][1]));
    let centre = m.at_time(&m.pipe("centre", &centre), 5);

    // T, modulo its width while it is being added up.
    let sixfold = m.pipe("sixfold", 4 * &neighbour + 2 * &neighbour);
    let sevenfold = m.pipe("sevenfold", 8 * &centre - &centre);
    let less = m.pipe("less", &diagonal - &sevenfold);
    let term = m.signal(&sixfold + &less);
    let zero = m.constant(0, Word { range: Range::point(0), ..term.word() });
    let term = m.pipe("term", m.select(&counts, &term, &zero));
    let spread = (word.range.max - word.range.min) * 7 * i128::from(parameters.max_valence);
    let total_word = Word { range: Range::new(-spread, spread), ..word };
    let width = total_word.width();
    let now = term.time().unwrap_or(0);
    let sum = m.register_at("sum", Word::modular(width).fraction(word.fraction), None, now);
    m.always(&sum, m.select(&m.at_time(&first, now), m.modulo(&term, width), &sum + &term));
    let sum = m.restart(&sum, now + 1);
    let complete = m.at_time(&last, now + 1);
    let kept = |name: &str, when: &Signal, value: &Signal| {
        let time = value.time().unwrap_or(0);
        let register = m.register_at(name, value.word(), None, time);
        m.on(&m.at_time(when, time), &register, value);
        m.restart(&register, time + 1)
    };
    let total = kept("total", &last, &m.claim("total_of_ring", &sum, total_word, Some(&complete)));
    // The centre stays as long as the walk is around it.
    let caught = (now + 6).saturating_sub(times.steps).max(centre.time().unwrap_or(0));
    let kept_centre = kept("centre_of_ring", &last, &m.at_time(&centre, caught));

    // kappa T from the lowest digit on; what is below the point is dropped as soon as it is.
    let bits = parameters.replacement_bits();
    let begins = m.at_time(&last, now + 2);
    let of_kappa = m.at_time(&ends_at, now - 1);
    let table = Word::unsigned(4 * times.digits);
    let mut entry = m.constant(kappa64(4, bits), table);
    for d in (3..=parameters.max_valence).filter(|d| *d != 4) {
        let here = m.pipe(format!("is_of_valence_{d}"), m.is(&of_kappa, i128::from(d) - 1));
        entry = m.select(&here, m.constant(kappa64(d, bits), table), &entry);
    }
    let kappa = m.register_at("kappa", table, None, now + 2);
    // The table lies far from what it is for.
    let entry = m.pipe("entry", m.wrap(&entry, table));
    m.on(&begins, &kappa, m.pipe("entry_to_use", &entry));
    let rest = m.rescale(&m.round(&kappa, 4, Rounding::Floor), 0);
    m.always(&kappa, m.wrap(&rest, table));
    let kappa = m.restart(&kappa, now + 3);
    let thrice = m.pipe("thrice", 2 * &total + &total);
    let once = m.at_time(&total, now + 3);
    let none = m.constant(0, Word { range: Range::point(0), ..word });
    let digit = |name: &str, low: u32| {
        let bits = [0, 1].map(|at| Some(m.slice(&kappa, low + at, 1)));
        let twice = m.signal(2 * &once);
        m.pipe(name, binary(&m, &bits, &[none.clone(), once.clone(), twice, thrice.clone()]))
    };
    let times_digit = m.pipe("times_digit", 4 * &digit("times_high", 2) + &digit("times_low", 0));
    // The next adder is the widest one: it has what it adds beside it.
    let times_digit = m.pipe("digit_to_add", &times_digit);
    let now = times_digit.time().unwrap_or(0);
    let dropped = 4 * (times.digits - 1);
    let half = match parameters.rounding {
        Rounding::Floor => 0,
        _ => 1i128 << (parameters.drop() + bits - 1),
    };
    let product_word = Word { range: total_word.range * 16 + Range::new(0, half), ..word };
    let product = m.register_at("product", product_word, None, now);
    let begins = m.at_time(&begins, now - 1);
    let begins = m.pipe("product_begins", &begins);
    let half = m.constant(half, Word { range: Range::point(half), ..word });
    let before = m.rescale(&m.round(&product, 4, Rounding::Floor), word.fraction);
    // Without a half to begin with, the choice is behind the adder, where synthesis finds room for it.
    m.always(
        &product,
        match parameters.rounding {
            Rounding::Floor => m.select(&begins, &times_digit, &before + &times_digit),
            _ => m.signal(&m.select(&begins, &half, &before) + &times_digit),
        },
    );
    let later = now + times.digits;
    let product = m.restart(&product, later);
    let ready = m.at_time(&begins, later);
    let second = kept("centre_of_product", &begins, &m.restart(&kept_centre, now));
    let scale = 6 + bits - dropped;
    let point = m.pipe("replaced", &product + (&m.restart(&second, later) << scale));
    let hull = word.range * (1i128 << scale) + Range::new(0, half_of(&parameters, bits, dropped));
    let point =
        m.claim("replacement", &point, Word { range: hull, ..point.word() }, Some(&m.delay(&ready, 1)));
    let point = m.rescale(&point, word.fraction + scale as i32);
    let vertex = m.round(&point, parameters.drop() + bits - dropped, Rounding::Floor);
    let new_word = parameters.word(level + 1);
    let fit = |signal: &Signal| m.wrap(m.rescale(signal, new_word.fraction), new_word);
    let vertex = fit(&vertex);
    let low = m.at_time(&walk.bottom, later);
    let vertices = [(!&low, "top"), (low.clone(), "bottom")].map(|(here, end)| {
        let when = m.pipe(format!("{end}_is_replaced"), &ready & &here);
        kept(&format!("{end}_replaced"), &when, &vertex)
    });

    // Both ends leave together.
    let done = m.delay(&start, times.done());
    let fetch = |name: String, signal: &Signal| {
        let fetched = kept(&name, &done, &m.restart(signal, times.done()));
        m.output(name, &fetched);
    };
    for (end, vertex) in End::BOTH.iter().zip(&vertices) {
        fetch(format!("{}_vertex", end.name()), vertex);
    }
    if !outside {
        return m.finish();
    }

    // The faces and the spokes, which the next level sees.
    let previous = |signal: &Signal| {
        m.restart(
            &m.pipe(format!("{}_before", signal.name().unwrap_or_default()), signal),
            signal.time().unwrap_or(0),
        )
    };
    let neighbour_before = previous(&neighbour);
    let pair = m.pipe("neighbours", &neighbour_before + &neighbour);
    let corner = m.pipe("corners", &centre + &diagonal);
    let face = m.pipe("face", &pair + &corner);
    let edge = m.pipe("edge", &centre + &neighbour_before);
    let last_face = previous(&face);
    let faces = m.pipe("faces", &last_face + &face);
    let spoke = m.pipe("spoke", &faces + 4 * &edge);
    let round = |name: &str, sum: &Signal| {
        let fine = m.rescale(sum, word.fraction + 6);
        let rounded = m.round(&fine, parameters.drop(), parameters.rounding);
        let free = parameters.drop() == 0 || parameters.rounding == Rounding::Floor;
        let rounded = if free { rounded } else { m.pipe(name, &rounded) };
        m.wire(format!("new_{name}"), fit(&rounded))
    };
    let stream = vec![
        ("a".to_string(), round("spoke_rounded", &m.signal(4 * &spoke))),
        (
            "x".to_string(),
            round("face_rounded", &m.signal(16 * &m.at_time(&last_face, spoke.time().unwrap_or(0)))),
        ),
    ];
    let waits = Waits::new(&m, parameters);
    let late = waits.until("side_slot", &stream, times.sides());
    let stream: Vec<(String, Signal)> = ["fan_a".to_string(), "fan_x".into()].into_iter().zip(late).collect();

    // Where the stream is, a step further than the place that it brings.
    let before = times.sides() - 1;
    let sides = Steps::new(&m, "sides", &m.delay(&start, before), times.steps);
    let at_right: Signal = m.at_time(&m.pipe("right_comes", &active & &at_right), before);
    let at_left = sides.at(&m, 3);
    for (end, here) in End::BOTH.iter().zip([!&sides.bottom, sides.bottom.clone()]) {
        for (side, when) in [("left", &at_left), ("right", &at_right)] {
            let name = format!("{}_{side}", end.name());
            let when = m.pipe(format!("{name}_comes"), when & &here);
            let caught = kept(&format!("{name}_caught"), &when, &stream[0].1);
            fetch(name, &caught);
        }
    }
    let stream: Vec<Signal> = waits.until("fan_slot", &stream, times.fans());
    let fans = Steps::new(&m, "fans", &m.delay(&start, times.fans() - 1), times.steps);
    let out = times.done() + 1;
    let axis_of_fan = axis.map(|axis| {
        let clock = times.fans() - 1;
        waits.until("fan_axis_slot", &[("axis_of_fan".into(), axis)], clock).remove(0)
    });
    if let Some(axis) = axis_of_fan.as_ref().filter(|_| parameters.in_turn(level + 1)) {
        m.output("fan_axis", m.restart(&m.pipe("fan_axis", axis), out));
    }
    for end in End::BOTH {
        let here = if end == End::Top { !&fans.bottom } else { fans.bottom.clone() };
        for i in 2..=parameters.outside_neighbours() {
            let here = fans.at(&m, i as u32 + 2) & &here;
            for (of_axis, ending) in (0..).zip(strobe_endings(parameters, level)) {
                let own = axis_of_fan.as_ref().filter(|_| !ending.is_empty());
                let here = own.map_or(here.clone(), |axis| &here & m.is(axis, of_axis));
                let strobe = m.pipe(format!("strobe_{}_{i}{ending}", end.name()), &here);
                m.output(format!("{}_fan_{i}{ending}", end.name()), m.restart(&strobe, out));
            }
        }
    }
    m.output("fan_a", m.restart(&stream[0], out));
    m.output("fan_x", m.restart(&stream[1], out));
    m.finish()
}

/// Half a unit in the last place of a replaced vertex, as it was added to the product.
fn half_of(parameters: &Parameters, bits: u32, dropped: u32) -> i128 {
    match (parameters.rounding, (parameters.drop() + bits).checked_sub(dropped + 1)) {
        (Rounding::Floor, _) | (_, None) => 0,
        (_, Some(power)) => 1 << power,
    }
}

/// The signal with the number that the bits make; bits that are not there are 0.
fn binary(m: &Builder, bits: &[Option<Signal>], signals: &[Signal]) -> Signal {
    let mut signals = signals.to_vec();
    for bit in bits.iter().flatten() {
        let pair = |pair: &[Signal]| match pair {
            [zero, one] => m.select(bit, one, zero),
            _ => pair[0].clone(),
        };
        signals = signals.chunks(2).map(pair).collect();
    }
    signals[0].clone()
}
