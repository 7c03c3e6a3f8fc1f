//! The finishing stage of cc-strip by itself in the built-in simulator, beside its reference, and windows for it.

use std::rc::Rc;

use subdiv_rtl::cores::cc_strip::finish::{self, Finished, Kind, Parameters, finish};
use subdiv_rtl::cores::cc_strip::view_ports::{self, view};
use subdiv_rtl::fixed::{Range, Rounding};
use subdiv_rtl::hdl::{Builder, Flat, Integers, Module, Simulator, Word};
use subdiv_rtl::model::cc_strip::around::Three;
use subdiv_rtl::model::cc_strip::level::LevelColumn;
use subdiv_rtl::model::cc_strip::{CcStrip, OutputColumn, Parameters as Reference, normals};
use subdiv_rtl::surface::catmull_clark::numbers::Numbers;
use subdiv_rtl::surface::catmull_clark::quad_mesh::QuadMesh;
use subdiv_rtl::surface::catmull_clark::rings::{Boundary, Rings};
use subdiv_rtl::surface::catmull_clark::strips::records::{Outside, positioned};
use subdiv_rtl::surface::catmull_clark::strips::{Method, cut};

use crate::cc_meshes::Random;

/// What a stage is tested with.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub width: u32,
    pub levels: [u32; 2],
    pub numbers: Numbers,
    pub max_valence: u32,
    /// Fraction bits of the output beyond those of the input.
    pub extra_fraction: i32,
    pub limit: bool,
    /// What normals, their extra fraction bits, and those of unit vectors.
    pub normals: Option<(Kind, i32, Option<u32>)>,
}

/// Fraction bits of the input: any number that leaves room for coarser outputs.
pub const FRACTION: i32 = 16;

impl Case {
    pub fn reference(&self) -> CcStrip {
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

    pub fn parameters(&self) -> Parameters {
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
pub fn module(p: Parameters) -> (Rc<Module>, u32) {
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
pub struct Stage {
    pub case: Case,
    pub parameters: Parameters,
    pub reference: CcStrip,
    pub simulator: Simulator<Integers>,
    pub latency: u32,
    pub random: Random,
}

impl Stage {
    pub fn new(case: Case) -> Self {
        Self::of(case, Flat::new(&module(case.parameters()).0).unwrap())
    }

    /// A stage whose design has been tampered with.
    pub fn of(case: Case, flat: Flat) -> Self {
        let parameters = case.parameters();
        let latency = module(parameters).1;
        let mut simulator = Simulator::new(flat, Integers);
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
            None => {
                let noise = i128::from(self.random.coordinate(self.case.width));
                noise << numbers.fraction(self.case.levels[1])
            }
        }
    }

    pub fn offer(&mut self, three: &Three, level: u32) {
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

    pub fn advance(&mut self, advance: bool) {
        let id = self.simulator.flat.input("advance").unwrap();
        self.simulator.set(id, advance.into());
        self.simulator.settle();
        self.simulator.edge(false).unwrap();
        self.simulator.settle();
    }

    /// The first result that differs.
    fn difference(&self, expected: &OutputColumn) -> Option<String> {
        let output = |what: &str, row: usize, axis: &str| {
            let id = self.simulator.flat.output(&format!("{what}_{row}_{axis}_out"));
            *self.simulator.get(id.unwrap()) as i64
        };
        assert_eq!(expected.normals.is_empty(), self.case.normals.is_none());
        for (what, rows) in [("position", &expected.vertices), ("normal", &expected.normals)] {
            for (row, vector) in rows.iter().enumerate() {
                let found = finish::AXES.map(|axis| output(what, row, axis));
                if found != *vector {
                    let case = self.case;
                    return Some(format!("{what} of row {row}: {found:?} for {vector:?} in {case:?}"));
                }
            }
        }
        None
    }

    /// Windows of one level through the stage; the first result that differs.
    pub fn run(&mut self, level: u32, windows: &[[LevelColumn; 3]]) -> Result<(), String> {
        self.run_levels(&windows.iter().map(|window| (level, window)).collect::<Vec<_>>())
    }

    /// Windows with their levels through the stage, one a clock but for stalls; the first result that differs.
    pub fn run_levels(&mut self, windows: &[(u32, &[LevelColumn; 3])]) -> Result<(), String> {
        let mut expected: Vec<OutputColumn> = vec![];
        let mut next = 0;
        while next < windows.len() + self.latency as usize {
            // Nothing moves in a stall, whatever is offered.
            let stalled = self.random.below(4) == 0;
            let at = if stalled { self.random.below(windows.len()) } else { next.min(windows.len() - 1) };
            let (level, [previous, column, after]) = windows[at];
            let three = Three { previous: Some(previous), column, next: Some(after) };
            self.offer(&three, level);
            self.advance(!stalled);
            if !stalled {
                expected.push(self.reference.finish(level, next, three));
                next += 1;
            }
            if let Some(expected) = next.checked_sub(self.latency as usize).and_then(|at| expected.get(at))
                && let Some(difference) = self.difference(expected)
            {
                return Err(difference);
            }
        }
        Ok(())
    }
}

/// The finest windows of all strips of a mesh.
pub fn windows(reference: &CcStrip, mesh: &QuadMesh, level: u32) -> Vec<[LevelColumn; 3]> {
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
pub fn random_window(case: &Case, level: u32, random: &mut Random) -> [LevelColumn; 3] {
    let shift = case.numbers.fraction(level);
    let fine = (1 << shift) - 1;
    // Far apart, or so close that normals are small; where carries run far, or not.
    let (near, ones) = (random.below(3) == 0, random.below(3) == 0);
    let reach = random.below(shift as usize + case.width as usize - 1);
    let base = [0; 3].map(|_: i128| i128::from(random.coordinate(case.width)) << shift);
    let point = |random: &mut Random| {
        [0, 1, 2].map(|axis| {
            let low = (random.bits() >> 1) as i128 & fine;
            let low = if ones { fine ^ (low & -(low & 1)) & 7 } else { low };
            let high = i128::from(random.coordinate(case.width)) << shift;
            let close = base[axis] + (random.bits() as i128 & ((1 << reach) - 1));
            let wanted = if near { close } else { high + low };
            // The largest number of the format is that of the input: the hull never grows.
            wanted.min(((1 << (case.width - 1)) - 1) << shift)
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

pub fn case() -> Case {
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
