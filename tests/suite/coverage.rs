//! Verilator's line and toggle coverage of the emitted `loop-fd`: every point is hit, or explained.
//!
//! ```text
//! hard packets x stalls ─► emitted Verilog in Verilator ─► points never hit ─┐
//! coverage_loop_fd.txt ─► rules (file, points, reason) ──────────────────────┴─► they must match both ways
//! ```
//!
//! A point that no rule explains is an error, and so is a rule that explains nothing (any more). Lines and
//! branches cannot be explained away: all of them are to be hit.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use subdiv_rtl::cores::loop_fd::{self, Parameters, RegisterForm};
use subdiv_rtl::cosim::loop_bench::device;
use subdiv_rtl::cosim::loop_trial::LoopTrial;
use subdiv_rtl::cosim::{Coverage, CoveragePoint, External, Settings, Simulator, Stall, Stimulus, Tool};
use subdiv_rtl::hdl::verilog;

/// A core that is covered: coordinates, output fraction, maximum level, registers, and the stalls.
struct Design(&'static str, u32, u32, RegisterForm, &'static [(Stall, Stall)]);

const DESIGNS: [Design; 3] = [
    Design("Q4.8", 8, 3, RegisterForm::Minimal20, &STALLS),
    Design("Q4.8", 8, 3, RegisterForm::Relative19, &STALLS),
    // One patch of level 8 has 33 thousand beats: once is enough for its counters.
    Design("Q12.12", 12, 8, RegisterForm::Minimal20, &[(Stall::None, Stall::Bursts)]),
];

/// Input gaps and back-pressure: none, and every kind on either side.
const STALLS: [(Stall, Stall); 5] = [
    (Stall::None, Stall::None),
    (Stall::Random { percent: 40 }, Stall::Bursts),
    (Stall::OneIn(5), Stall::Random { percent: 40 }),
    (Stall::Bursts, Stall::OneIn(3)),
    // Long enough to fill the FIFO.
    (Stall::None, Stall::OneIn(40)),
];

/// Why some points of a file cannot be hit.
struct Rule {
    line: usize,
    file: String,
    /// Names of signals with their bits; `*` stands for any characters.
    points: Vec<String>,
    used: BTreeSet<String>,
}

/// `file: point point ...: reason`, continued on indented lines; `#` begins a comment.
fn rules(text: &str) -> Vec<Rule> {
    let mut joined: Vec<(usize, String)> = vec![];
    for (number, line) in text.lines().enumerate().filter(|(_, l)| !l.starts_with('#') && !l.is_empty()) {
        match joined.last_mut() {
            Some((_, before)) if line.starts_with(' ') => *before += &format!(" {}", line.trim()),
            _ => joined.push((number + 1, line.into())),
        }
    }
    let rule = |(line, text): (usize, String)| {
        let cells: Vec<&str> = text.splitn(3, ": ").collect();
        let [file, points, reason] = cells[..] else { panic!("line {line}: file, points, reason: {text}") };
        assert!(reason.len() > 20, "line {line}: a reason is a sentence");
        let points = points.split_whitespace().map(String::from).collect();
        Rule { line, file: file.into(), points, used: BTreeSet::new() }
    };
    joined.into_iter().map(rule).collect()
}

fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, tail)) => name.strip_prefix(head).is_some_and(|rest| {
            (0..=rest.len()).any(|at| rest.get(at..).is_some_and(|rest| matches(tail, rest)))
        }),
    }
}

/// The points that no rule explains; notes the patterns that explain one.
fn unexplained<'a>(missed: impl Iterator<Item = &'a CoveragePoint>, rules: &mut [Rule]) -> Vec<String> {
    let mut left = vec![];
    for point in missed {
        let mut explained = false;
        for rule in rules.iter_mut().filter(|rule| point.kind == "toggle" && rule.file == point.file) {
            for pattern in rule.points.iter().filter(|pattern| matches(pattern, &point.name)) {
                rule.used.insert(pattern.clone());
                explained = true;
            }
        }
        if !explained {
            left.push(point.to_string());
        }
    }
    left
}

/// The patterns that have explained nothing.
fn stale(rules: &[Rule]) -> Vec<String> {
    let unused = |rule: &Rule| -> Vec<String> {
        let unused = rule.points.iter().filter(|pattern| !rule.used.contains(*pattern));
        unused.map(|pattern| format!("line {}: {} {pattern}", rule.line, rule.file)).collect()
    };
    rules.iter().flat_map(unused).collect()
}

/// The coverage of a design over all stalls, with every bit and clock of the outputs checked on the way.
fn measure(design: &Design, simulator: &External) -> Coverage {
    let Design(coordinates, fraction, max_level, registers, stalls) = *design;
    let parameters = Parameters::new(coordinates.parse().unwrap(), fraction, max_level, registers).unwrap();
    let core = loop_fd::build(parameters).unwrap();
    let files = verilog::print(&core, "subdiv-rtl generate loop-fd").unwrap();
    let dut = device(&core, &files);
    let mut coverage = Coverage::default();
    for (seed, (gaps, back_pressure)) in stalls.iter().copied().enumerate() {
        let seed = seed as u64 + 1;
        let trial = LoopTrial::random(&core, parameters, seed).unwrap();
        let stimulus = Stimulus::new(trial.input.clone(), trial.expected.clone());
        let mut stimulus = Stimulus { gaps, back_pressure, seed, ..stimulus };
        stimulus.expected_clocks = Some(trial.clocks(&core, &stimulus).total);
        let outcome = simulator.run(&dut, &stimulus).unwrap();
        assert_eq!(outcome.failures, [], "gaps {gaps}, back-pressure {back_pressure}");
        println!(
            "  gaps {gaps}, back-pressure {back_pressure}: {} beats, {} clocks, build {:.1} s, run {:.1} s",
            outcome.beats, outcome.clocks, outcome.build_seconds, outcome.run_seconds
        );
        coverage.merge(&outcome.coverage.unwrap());
    }
    coverage
}

/// For each kind of point, how many there are and how many were hit.
fn figures(coverage: &Coverage) -> String {
    let mut kinds: BTreeMap<&str, (u64, u64)> = BTreeMap::new();
    for (point, hits) in coverage.points() {
        let (all, hit) = kinds.entry(&point.kind).or_default();
        (*all, *hit) = (*all + 1, *hit + u64::from(hits > 0));
    }
    let kinds: Vec<_> = kinds.iter().map(|(kind, (all, hit))| format!("{kind} {hit} of {all}")).collect();
    kinds.join(", ")
}

#[test]
fn every_point_of_the_emitted_core_is_hit_or_explained() {
    let cache = Some(Path::new(env!("CARGO_TARGET_TMPDIR")).join("coverage"));
    let settings = Settings { coverage: true, cache, ..Settings::default() };
    let simulator = External::new(Tool::Verilator, settings);
    if let Err(missing) = simulator.version() {
        println!("skipped: {missing}");
        return;
    }
    let mut rules = rules(include_str!("coverage_loop_fd.txt"));
    let mut left = vec![];
    for design in &DESIGNS {
        let Design(coordinates, _, max_level, registers, _) = design;
        println!("{coordinates}, maximum level {max_level}, {registers} registers");
        let coverage = measure(design, &simulator);
        let unexplained = unexplained(coverage.missed(), &mut rules);
        let explained = coverage.missed().count() - unexplained.len();
        println!("  hit: {}; explained {explained}; open {}", figures(&coverage), unexplained.len());
        left.extend(unexplained);
    }
    left.sort();
    left.dedup();
    assert!(left.is_empty(), "never hit, and not explained:\n{}", left.join("\n"));
    assert_eq!(stale(&rules), Vec::<String>::new(), "explained, but hit or not there");
}

fn point(kind: &str, name: &str) -> CoveragePoint {
    let (file, hierarchy) = ("a.v".to_string(), "TOP".to_string());
    CoveragePoint { file, line: 1, column: 1, kind: kind.into(), name: name.into(), hierarchy }
}

#[test]
fn a_rule_explains_its_file_and_its_bits_and_nothing_else() {
    let text = "# why\na.v: sum[0] n*_d1[1]: these bits\n  can never be anything but zero\n";
    let check = |kind, name| unexplained([point(kind, name)].iter(), &mut rules(text)).is_empty();
    assert!(check("toggle", "sum[0]") && check("toggle", "n20_d1[1]"));
    assert!(!check("toggle", "sum[1]") && !check("toggle", "n20_d2[1]") && !check("line", "sum[0]"));
    let elsewhere = CoveragePoint { file: "b.v".into(), ..point("toggle", "sum[0]") };
    assert_eq!(unexplained([elsewhere].iter(), &mut rules(text)).len(), 1);
}

#[test]
fn a_rule_that_explains_nothing_is_found() {
    let mut rules = rules("a.v: sum[0] sum[1]: these bits can never be anything but zero\n");
    unexplained([point("toggle", "sum[0]")].iter(), &mut rules);
    assert_eq!(stale(&rules), ["line 1: a.v sum[1]"]);
}
