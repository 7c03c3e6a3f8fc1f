//! The finishing stage of cc-strip by itself in the built-in simulator: limit positions, normals and unit vectors,
//! bit for bit against the reference, on windows of real meshes and on random extreme ones.

mod cc_meshes;

use cc_meshes::{Random, of_shape};
use std::process::Command;
use std::rc::Rc;
use subdiv_rtl::cores::cc_strip::finish::{self, Finished, Kind, Parameters, finish};
use subdiv_rtl::cores::cc_strip::view_ports::{self, view};
use subdiv_rtl::fixed::{Range, Rounding};
use subdiv_rtl::hdl::{Builder, Flat, Integers, Module, Simulator, Word, verilog};
use subdiv_rtl::model::cc_strip::around::Three;
use subdiv_rtl::model::cc_strip::level::LevelColumn;
use subdiv_rtl::model::cc_strip::{CcStrip, OutputColumn, Parameters as Reference, normals};
use subdiv_rtl::surface::catmull_clark::numbers::Numbers;
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};
use subdiv_rtl::surface::catmull_clark::strips::records::{Outside, positioned};
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};

/// What a stage is tested with.
#[derive(Clone, Copy, Debug)]
struct Case {
    width: u32,
    levels: [u32; 2],
    numbers: Numbers,
    max_valence: u32,
    /// Fraction bits of the output beyond those of the input.
    extra_fraction: i32,
    limit: bool,
    /// What normals, their extra fraction bits, and those of unit vectors.
    normals: Option<(Kind, i32, Option<u32>)>,
}

/// Fraction bits of the input: any number that leaves room for coarser outputs.
const FRACTION: i32 = 16;

impl Case {
    fn reference(&self) -> CcStrip {
        let normals = self.normals.map(|(kind, extra_fraction, unit)| normals::Normals {
            kind: match kind {
                Kind::Faces => normals::Kind::Faces,
                Kind::Limit => normals::Kind::Limit,
            },
            extra_fraction,
            unit,
        });
        CcStrip::new(Reference {
            max_levels: self.levels[1],
            numbers: self.numbers,
            max_valence: self.max_valence,
            extra_fraction: self.extra_fraction,
            limit: self.limit,
            normals,
            ..Reference::exact(self.width)
        })
        .unwrap()
    }

    fn parameters(&self) -> Parameters {
        let extra = self.numbers.fraction(self.levels[1]);
        // A fraction that is rounded away can carry into one more bit.
        let carry = u32::from(self.extra_fraction < 0);
        Parameters {
            word: Word::from(Range::signed(self.width) * (1i128 << extra)).fraction(FRACTION + extra as i32),
            output: Word::signed((self.width as i32 + self.extra_fraction) as u32 + carry)
                .fraction(FRACTION + self.extra_fraction),
            rounding: Rounding::HalfUp,
            levels: self.levels,
            max_valence: self.max_valence,
            limit: self.limit.then_some(self.width + 13),
            normals: self.normals.map(|(kind, extra, unit)| finish::Normals {
                kind,
                point_fraction: (FRACTION + extra) as u32,
                unit,
            }),
        }
    }
}

/// A module around the stage: the views and `advance` in, positions and normals out.
fn module(p: Parameters) -> (Rc<Module>, u32) {
    let m = Builder::new("finishing_stage");
    m.purpose("The finishing stage by itself.");
    let advance = m.input("advance", Word::bit());
    let views = finish::AXES.map(|axis| view(&m, p, &format!("{axis}_"), p.word));
    let [x, y, z] = &views;
    let Finished { positions, normals, latency } = finish(&m, &p, [x, y, z], &advance).unwrap();
    for (what, rows) in [("position", positions), ("normal", normals)] {
        for (row, vector) in rows.iter().enumerate() {
            for (axis, signal) in finish::AXES.iter().zip(vector) {
                m.output(format!("{what}_{row}_{axis}_out"), signal);
            }
        }
    }
    (m.finish().unwrap(), latency)
}

/// The stage in the simulator.
struct Stage {
    case: Case,
    parameters: Parameters,
    reference: CcStrip,
    simulator: Simulator<Integers>,
    latency: u32,
    random: Random,
}

impl Stage {
    fn new(case: Case) -> Self {
        let parameters = case.parameters();
        let (module, latency) = module(parameters);
        let mut simulator = Simulator::new(Flat::new(&module).unwrap(), Integers);
        simulator.scramble(7);
        Stage { case, parameters, reference: case.reference(), simulator, latency, random: Random(5) }
    }

    /// The number at a port of the view of one axis; noise where the stage must not look.
    fn port(&mut self, name: &str, three: &Three, axis: usize, level: u32) -> i128 {
        let (Some(p), c, Some(n)) = (three.previous, three.column, three.next) else { panic!("a guard") };
        let columns = [p, c, n];
        // The exact format has fewer fraction bits at a coarser level; the stage has those of its finest.
        let numbers = self.case.numbers;
        let shift = numbers.fraction(self.case.levels[1]) - numbers.fraction(level);
        let number = |s: &str| s.rsplit('_').next().unwrap().parse::<usize>().unwrap();
        let found = if let Some(place) = name.strip_prefix("row_") {
            columns[number(&place[..1])].rows.get(number(place))
        } else {
            let end = usize::from(name.starts_with("bottom"));
            let outside = &c.outside[end];
            let place = name.split_once('_').unwrap().1;
            let entry = |i: usize| outside.fan.get(i);
            match place.split('_').next().unwrap() {
                "outer" => Some(columns[number(place)].outer(end)),
                "inner" => Some(columns[number(place)].inner(end)),
                "before" => Some(&p.outside[end].right),
                "after" => Some(&n.outside[end].left),
                "a" => entry(2 * number(place) - 2),
                "x" => entry(2 * number(place) - 3),
                other => panic!("{other}"),
            }
        };
        match found {
            Some(point) => point[axis] << shift,
            None => i128::from(self.random.coordinate(self.case.width)),
        }
    }

    fn offer(&mut self, three: &Three, level: u32) {
        let mut values = vec![];
        for (axis, prefix) in finish::AXES.iter().enumerate() {
            for (name, kind) in view_ports::names(self.parameters) {
                let value = match kind {
                    view_ports::Kind::Point => self.port(&name, three, axis, level),
                    view_ports::Kind::IsBottom => (name == format!("is_bottom_{}", 1 << level)).into(),
                    view_ports::Kind::Valence => {
                        three.column.outside[usize::from(name.starts_with("bottom"))].valence.into()
                    }
                };
                values.push((format!("{prefix}_{name}"), value));
            }
        }
        for (name, value) in values {
            let id = self.simulator.flat.input(&name).unwrap();
            self.simulator.set(id, value);
        }
    }

    fn advance(&mut self, advance: bool) {
        let id = self.simulator.flat.input("advance").unwrap();
        self.simulator.set(id, advance.into());
        self.simulator.settle();
        self.simulator.edge(false).unwrap();
        self.simulator.settle();
    }

    fn check(&self, expected: &OutputColumn) {
        let output = |what: &str, row: usize, axis: &str| {
            let id = self.simulator.flat.output(&format!("{what}_{row}_{axis}_out"));
            *self.simulator.get(id.unwrap()) as i64
        };
        assert_eq!(expected.normals.is_empty(), self.case.normals.is_none());
        for (what, rows) in [("position", &expected.vertices), ("normal", &expected.normals)] {
            for (row, vector) in rows.iter().enumerate() {
                let found = finish::AXES.map(|axis| output(what, row, axis));
                assert_eq!(found, *vector, "{:?}: {what} of row {row}", self.case);
            }
        }
    }

    /// Windows of one level through the stage, one a clock but for stalls; returns how many were compared.
    fn run(&mut self, level: u32, windows: &[[LevelColumn; 3]]) -> usize {
        let mut expected: Vec<OutputColumn> = vec![];
        let mut next = 0;
        while next < windows.len() + self.latency as usize {
            // Nothing moves in a stall, whatever is offered.
            let window = &windows[next.min(windows.len() - 1)];
            let [previous, column, after] = window;
            let three = Three { previous: Some(previous), column, next: Some(after) };
            self.offer(&three, level);
            let stalled = self.random.below(4) == 0;
            self.advance(!stalled);
            if stalled {
                continue;
            }
            expected.push(self.reference.finish(level, next, three));
            next += 1;
            if next >= self.latency as usize {
                self.check(&expected[next - self.latency as usize]);
            }
        }
        windows.len()
    }
}

/// The finest windows of all strips of a mesh.
fn windows(reference: &CcStrip, mesh: &QuadMesh, level: u32) -> Vec<[LevelColumn; 3]> {
    let rings = Rings::new(mesh, Boundary::Ghosts).unwrap();
    let mut windows = vec![];
    for strip in positioned(mesh, &rings, &cut(mesh, Method::Natural)) {
        let levels = reference.levels(level, &strip).unwrap();
        let columns: Vec<LevelColumn> = levels[level as usize].iter().flatten().cloned().collect();
        let output = reference.columns(level, &strip).unwrap();
        // What the whole reference puts out is what its stage makes of the windows.
        for (window, output) in columns.windows(3).zip(&output) {
            let [p, c, n] = window else { panic!("three columns") };
            let three = Three { previous: Some(p), column: c, next: Some(n) };
            assert_eq!(reference.finish(level, output.index, three), *output);
            windows.push([p.clone(), c.clone(), n.clone()]);
        }
    }
    windows
}

/// A window of random, often extreme, points around ends of any valence.
fn random_window(case: &Case, level: u32, random: &mut Random) -> [LevelColumn; 3] {
    let shift = case.numbers.fraction(level);
    let point = |random: &mut Random| {
        [0; 3].map(|_: i128| {
            let low = (random.bits() >> 1) as i128 & ((1 << shift) - 1);
            let high = i128::from(random.coordinate(case.width));
            // The largest number of the format is that of the input: the hull never grows.
            ((high << shift) + low).min(((1 << (case.width - 1)) - 1) << shift)
        })
    };
    let valences = [0; 2].map(|_: u32| 3 + random.below(case.max_valence as usize - 2) as u32);
    let column = |random: &mut Random| LevelColumn {
        rows: (0..=1 << level).map(|_| point(random)).collect(),
        outside: valences.map(|valence| Outside {
            valence,
            fan: (0..(2 * valence as usize).saturating_sub(7)).map(|_| point(random)).collect(),
            left: point(random),
            right: point(random),
            gap: None,
        }),
    };
    let mut window = [0; 3].map(|_| column(random));
    for (end, valence) in valences.into_iter().enumerate() {
        // The one outside face of valence 3 lies between both neighbouring columns.
        if valence == 3 {
            window[2].outside[end].left = window[0].outside[end].right;
        }
    }
    window
}

fn case() -> Case {
    Case {
        width: 16,
        levels: [1, 3],
        numbers: Numbers::Exact,
        max_valence: 8,
        extra_fraction: 0,
        limit: true,
        normals: None,
    }
}

#[test]
fn windows_of_meshes_are_finished_as_the_reference_does() {
    let normals = [
        None,
        Some((Kind::Faces, 4, None)),
        Some((Kind::Limit, 2, None)),
        Some((Kind::Faces, 6, Some(14))),
        Some((Kind::Limit, 5, Some(14))),
    ];
    for name in ["cube-quads", "torus-quads", "blob-quads", "double-torus-quads"] {
        let mesh = of_shape(name);
        for (normals, numbers) in
            normals.into_iter().flat_map(|n| [(n, Numbers::Exact), (n, Numbers::Guard(6))])
        {
            let limit = normals.is_none_or(|(kind, ..)| kind == Kind::Limit);
            let mut stage = Stage::new(Case { numbers, limit, normals, max_valence: 10, ..case() });
            for level in 1..=3 {
                let mut windows = windows(&stage.reference, &mesh, level);
                windows.truncate(60);
                assert!(stage.run(level, &windows) > 5);
            }
        }
    }
}

#[test]
fn extreme_windows_are_finished_as_the_reference_does() {
    let cases = [
        case(),
        Case { width: 24, levels: [2, 2], max_valence: 16, extra_fraction: 12, ..case() },
        Case { width: 8, levels: [1, 1], max_valence: 4, extra_fraction: -3, ..case() },
        Case { width: 32, levels: [1, 2], numbers: Numbers::Guard(5), extra_fraction: -10, ..case() },
        Case { limit: false, normals: Some((Kind::Faces, 11, None)), max_valence: 16, ..case() },
        Case { width: 24, normals: Some((Kind::Limit, 3, None)), max_valence: 16, ..case() },
        Case { width: 32, normals: Some((Kind::Limit, -6, Some(16))), ..case() },
        Case { width: 12, normals: Some((Kind::Faces, 0, Some(8))), levels: [1, 4], ..case() },
        Case { width: 4, normals: Some((Kind::Faces, 0, Some(14))), levels: [1, 1], ..case() },
    ];
    for case in cases {
        let mut stage = Stage::new(case);
        let mut random = Random(u64::from(case.width));
        for level in case.levels[0]..=case.levels[1] {
            let windows: Vec<_> = (0..200).map(|_| random_window(&case, level, &mut random)).collect();
            stage.run(level, &windows);
        }
    }
}

/// A point of all equal coordinates has no normal: zero stays zero.
#[test]
fn flat_windows_have_no_normal() {
    for kind in [Kind::Faces, Kind::Limit] {
        let case = Case { normals: Some((kind, 4, Some(14))), ..case() };
        let mut stage = Stage::new(case);
        let mut random = Random(3);
        let mut window = random_window(&case, 2, &mut random);
        for column in &mut window {
            column.rows.iter_mut().for_each(|p| *p = [5 << 12; 3]);
            for outside in &mut column.outside {
                *outside = outside.map(&mut |_| [5 << 12; 3]);
            }
        }
        stage.run(2, &[window.clone()]);
        let [p, c, n] = &window;
        let three = Three { previous: Some(p), column: c, next: Some(n) };
        assert!(stage.reference.finish(2, 0, three).normals.iter().flatten().all(|&x| x == 0));
    }
}

/// Counterclockwise quads of a convex solid: normals point away from its middle.
#[test]
fn normals_point_outwards() {
    let mesh = of_shape("cube-quads");
    for kind in [Kind::Faces, Kind::Limit] {
        let stage = Stage::new(Case { normals: Some((kind, 4, Some(14))), ..case() });
        for [p, c, n] in &windows(&stage.reference, &mesh, 3) {
            let output = stage.reference.finish(3, 0, Three { previous: Some(p), column: c, next: Some(n) });
            for (v, normal) in output.vertices.iter().zip(&output.normals) {
                let along: i64 = v.iter().zip(normal).map(|(v, n)| v * n).sum();
                let length = v.iter().map(|v| (v * v) as f64).sum::<f64>().sqrt();
                let cosine = along as f64 / length / 16384.0;
                assert!(cosine > 0.8, "{kind:?}: {v:?} {normal:?}");
            }
        }
    }
}

#[test]
fn what_a_stage_cannot_do_is_refused_with_a_remedy() {
    let good = case().parameters();
    let normals = |kind, point_fraction, unit| Some(finish::Normals { kind, point_fraction, unit });
    let bad = [
        Parameters { rounding: Rounding::Exact, ..good },
        Parameters { output: Word::signed(16).fraction(FRACTION + 40), ..good },
        // -1/2^16 of 16 bits becomes 13 bits: the largest number is rounded up.
        Parameters { output: Word::signed(13).fraction(FRACTION - 3), ..good },
        Parameters { normals: normals(Kind::Faces, 40, None), ..good },
        Parameters { normals: normals(Kind::Limit, FRACTION as u32 + 14, None), ..good },
        Parameters { normals: normals(Kind::Faces, FRACTION as u32, Some(7)), ..good },
        Parameters { normals: normals(Kind::Faces, FRACTION as u32, Some(17)), ..good },
    ];
    assert!(good.check().is_ok());
    for parameters in bad {
        let error = parameters.check().unwrap_err();
        assert!(error.help.is_some(), "{error:?}");
    }
    let exact = Reference { width: 16, ..Reference::exact(16) };
    let normals = |kind, extra_fraction, unit| Some(normals::Normals { kind, extra_fraction, unit });
    for (normals, rims) in [
        (normals(normals::Kind::Faces, 0, None), true),
        (normals(normals::Kind::Limit, 14, None), false),
        (normals(normals::Kind::Faces, 43, None), false),
        (normals(normals::Kind::Faces, -15, None), false),
        (normals(normals::Kind::Faces, 0, Some(17)), false),
    ] {
        let error = CcStrip::new(Reference { normals, rims, ..exact }).unwrap_err();
        assert!(error.help.is_some(), "{error:?}");
    }
}

/// The tools, each with the command that must say nothing.
const COMMANDS: [(&str, &str); 3] = [
    ("verilator", "verilator --lint-only -Wall --top-module finishing_stage *.v"),
    ("iverilog", "iverilog -g2005 -Wall -s finishing_stage -o /dev/null *.v"),
    ("yosys", "yosys -q -p 'read_verilog *.v; hierarchy -check -top finishing_stage; proc; check -assert'"),
];

#[test]
fn the_printed_stage_is_silent_in_every_tool() {
    let cases = [
        case(),
        Case {
            levels: [2, 2],
            max_valence: 4,
            limit: false,
            normals: Some((Kind::Faces, 4, None)),
            ..case()
        },
        Case { levels: [1, 2], extra_fraction: -2, normals: Some((Kind::Limit, 3, Some(14))), ..case() },
        Case { levels: [1, 1], limit: false, normals: Some((Kind::Limit, 0, None)), ..case() },
        Case { width: 4, levels: [1, 1], normals: Some((Kind::Faces, 0, Some(9))), ..case() },
    ];
    for case in cases {
        let folder = tempfile::tempdir().unwrap();
        for file in verilog::print(&module(case.parameters()).0, "test").unwrap() {
            std::fs::write(folder.path().join(file.name), file.text).unwrap();
        }
        for (tool, command) in COMMANDS {
            if Command::new(tool).arg("-V").output().is_err() {
                println!("skipped: {tool} is not installed");
                continue;
            }
            let output =
                Command::new("sh").args(["-c", command]).current_dir(folder.path()).output().unwrap();
            let said = [output.stdout, output.stderr].concat();
            let said = String::from_utf8_lossy(&said);
            assert!(output.status.success() && said.trim().is_empty(), "{case:?}: {command}\n{said}");
        }
    }
}
