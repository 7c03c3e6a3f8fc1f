//! The work of `simulate`: mesh, core, simulators, comparison, and the surface put together again.

use std::mem::take;
use std::path::PathBuf;
use std::rc::Rc;

use glam::DVec3;

use super::result::{self, Found, Verdict};
use super::{Colour, Picture, Scheme, Settings, SimulatorName, Simulators, Source, netlist, strips};
use crate::cli::progress::Progress;
use crate::cores::loop_fd::{Parameters, build};
use crate::cosim::loop_bench::{self, LoopBench};
use crate::cosim::{self, Beat, Builtin, Clocked, Dut, External, Model, Outcome, Simulator, Stimulus, Tool};
use crate::error::{Error, Kind, Result};
use crate::fixed::Format;
use crate::hdl::{Module, verilog};
use crate::mesh::{self, FineMesh, Mesh, Topology};
use crate::package;
use crate::report::picture::{self, Colouring, Finish, Normals, Options, Scene, Wire};
use crate::surface::assembly::Assembly;
use crate::surface::control_mesh::ControlMesh;
use crate::surface::error_bound::{Accuracy, error_bound_lsb};
use crate::surface::limit_oracle::LimitOracle;
use crate::surface::precision;
use crate::surface::table::Table;

/// Runs everything and prints the result. Files are written only when all is right; an error of kind
/// `Mismatch` when a bit differs.
pub fn run(settings: &Settings) -> Result<()> {
    if settings.scheme == Scheme::CatmullClark {
        return strips::run(settings);
    }
    let (mesh, notes) = load(settings)?;
    let coordinates = match settings.coordinates {
        Some(format) => format,
        None => mesh::widest_format(&mesh, 24)?,
    };
    let quantised = mesh::quantise(&mesh, coordinates)?;
    let control = ControlMesh::new(quantised.positions.clone(), mesh.triangles()?)?;

    let output_fraction = settings.output_fraction.unwrap_or(coordinates.fraction);
    let parameters =
        Parameters::new(coordinates, output_fraction, settings.max_level, settings.registers.form())?
            .with_min_level(settings.min_level)?
            .with_precision(settings.precision)?
            .with_chunk(settings.chunk)?
            .with_lanes(settings.lanes)?
            .with_columns(settings.columns)?;
    let core = build(parameters)?;
    let mut bench = LoopBench::new(&core, parameters, &control, settings.level)?;
    let Runs { outcomes, netlist } = simulate(settings, &core, parameters, &mut bench)?;

    let drawn = draw(settings, &bench, &control, &outcomes)?;
    let oracle = LimitOracle::new(&control, settings.level)?;
    let extra = loop_bench::extra_fraction(parameters);
    let positions = drawn.positions();
    let mut error = positions.as_ref().map(|p| oracle.error(p, extra)).transpose()?;
    if let Some(error) = &mut error {
        // Where patches disagree, every position counts.
        for (vertex, position) in drawn.other_positions() {
            error.max = error.max.max(oracle.vertex_error(vertex, position, extra));
        }
        error.at_most_half &= error.max <= 0.5;
    }
    let accuracy = Accuracy {
        width: coordinates.width(),
        extra_fraction: extra,
        level: settings.level,
        table_bits: Table::for_width(coordinates.width())?.bits(),
        largest_irregular_valence: control.largest_irregular_valence(),
    };

    let found = Found {
        settings,
        mesh: &mesh,
        notes,
        rounding: quantised.rounding,
        parameters,
        bench: &bench,
        drawn: &drawn,
        error,
        bound: bound(parameters, &accuracy),
        outcomes: &outcomes,
        netlist: netlist.as_ref(),
    };
    let verdict = result::verdict(&found);
    if let (Verdict::Right, Some(positions)) = (&verdict, positions) {
        let format = Format { integer: coordinates.integer, fraction: output_fraction };
        let surface = Surface { positions, format, oracle: &oracle, extra };
        surface.write(settings, &bench, &drawn, &mesh)?;
    }
    result::print(&found, &verdict)?;
    match verdict {
        Verdict::Right => Ok(()),
        Verdict::Wrong(error) => Err(error),
    }
}

/// The proven bound on the error of a vertex: what irregular vertices and the format of the differences add
/// to the final rounding.
fn bound(parameters: Parameters, accuracy: &Accuracy) -> f64 {
    let exact = error_bound_lsb(accuracy);
    match parameters.precision.reduced() {
        None => exact,
        Some(reduced) => exact - 0.5 + precision::total_lsb(reduced, accuracy.level, accuracy.extra_fraction),
    }
}

/// The control mesh, checked, with what there is to say about it.
pub(super) fn load(settings: &Settings) -> Result<(Mesh, Vec<String>)> {
    let mesh = match &settings.source {
        Source::File(path) => mesh::read(path)?,
        Source::Shape(name) => mesh::shape(name)?,
    };
    let mesh = if settings.triangulate { mesh.triangulated() } else { mesh };
    if settings.scheme == Scheme::Loop {
        mesh.triangles()?;
        Topology::new(&mesh)?.check_valences(&mesh, 3..=MAX_VALENCE, 2..=MAX_VALENCE)?;
    }
    let notes = mesh.notes.clone();
    Ok((mesh, notes))
}

/// Every simulator that was asked for, in turn.
fn simulate(
    settings: &Settings,
    core: &Rc<Module>,
    parameters: Parameters,
    bench: &mut LoopBench,
) -> Result<Runs> {
    let sources = verilog::print(core, &package::loop_fd::command(parameters))?;
    let dut = loop_bench::device(core, &sources);
    let mut stimulus = stimulus(settings, take(&mut bench.input), take(&mut bench.expected));
    stimulus.expected_clocks = Some(bench.clocks(core, &stimulus).total);
    run_all(settings, core, &dut, stimulus)
}

/// Vectors under the stalls that were asked for.
pub(super) fn stimulus(settings: &Settings, input: Vec<Beat>, expected: Vec<Beat>) -> Stimulus {
    Stimulus {
        back_pressure: settings.back_pressure,
        gaps: settings.input_gaps,
        seed: settings.seed,
        ..Stimulus::new(input, expected)
    }
}

/// The verdict of every simulator, and the netlist that they ran where it was not the core itself.
pub(super) struct Runs {
    pub outcomes: Vec<Outcome>,
    pub netlist: Option<netlist::Facts>,
}

/// The verdict of every simulator that was asked for.
pub(super) fn run_all(
    settings: &Settings,
    core: &Rc<Module>,
    dut: &Dut,
    mut stimulus: Stimulus,
) -> Result<Runs> {
    let simulators = simulators(settings, core)?;
    let (gates, netlist) = netlist::of(settings, dut)?.unzip();
    let dut = gates.as_ref().unwrap_or(dut);

    let mut outcomes = vec![];
    for simulator in &simulators {
        let _shown = Progress::waiting(format!("simulating with {}", simulator.name()));
        stimulus.vcd = Some(waveform(settings, simulator.name()));
        outcomes.push(simulator.run(dut, &stimulus)?);
    }
    Ok(Runs { outcomes, netlist })
}

/// Where the waveform around a mismatch goes.
fn waveform(settings: &Settings, simulator: &str) -> PathBuf {
    let name = format!("mismatch-{simulator}.vcd");
    settings.keep.as_ref().map_or_else(|| PathBuf::from(&name), |folder| folder.join(&name))
}

/// The largest valence of the look-up tables.
const MAX_VALENCE: u32 = 32;

type Runner = Box<dyn Simulator>;

fn simulators(settings: &Settings, core: &Rc<Module>) -> Result<Vec<Runner>> {
    let tools = cosim::Settings {
        keep: settings.keep.clone(),
        timeout: settings.timeout,
        compile_fast: settings.netlist.is_some(),
        ..cosim::Settings::default()
    };
    let make = |name: &SimulatorName| -> Runner {
        match name {
            SimulatorName::Verilator => Box::new(External::new(Tool::Verilator, tools.clone())),
            SimulatorName::VerilatorTestbench => {
                Box::new(External::new(Tool::VerilatorTestbench, tools.clone()))
            }
            SimulatorName::Icarus => Box::new(External::new(Tool::Icarus, tools.clone())),
            _ => {
                let (core, vcd) = (core.clone(), settings.vcd.clone());
                Box::new(Builtin::new(move || {
                    let mut model = Model::new(&core)?;
                    model.trace(vcd.as_deref(), 0)?;
                    Ok(model)
                }))
            }
        }
    };
    match &settings.simulators {
        Simulators::Named(names) => {
            let runners: Vec<Runner> = names.iter().map(make).collect();
            // A missing tool is told before any work, not after half of it.
            runners.iter().try_for_each(|runner| runner.version().map(drop))?;
            Ok(runners)
        }
        Simulators::Installed => {
            let all = [SimulatorName::Builtin, SimulatorName::Verilator, SimulatorName::Icarus];
            let wanted =
                all.iter().filter(|name| settings.netlist.is_none() || **name != SimulatorName::Builtin);
            Ok(wanted.map(make).filter(|runner| runner.version().is_ok()).collect())
        }
    }
}

/// The surface from what the hardware sent: from every simulator, so that a crack in any of them shows.
fn draw<'a>(
    settings: &Settings,
    bench: &LoopBench,
    control: &'a ControlMesh,
    outcomes: &[Outcome],
) -> Result<Assembly<'a>> {
    let mut drawn = None;
    for outcome in outcomes {
        let assembly = bench.assemble(control, settings.level, &outcome.received)?;
        // The first one with a crack or a gap, else the first one.
        let worse = assembly.cracks() > 0 || assembly.missing() > 0;
        if drawn.is_none() || worse {
            drawn = Some(assembly);
            if worse {
                break;
            }
        }
    }
    drawn.ok_or_else(|| Error::usage("no simulator was chosen").help("use --simulator builtin"))
}

/// A complete fine mesh.
struct Surface<'a> {
    positions: Vec<[i64; 3]>,
    format: Format,
    oracle: &'a LimitOracle,
    extra: i32,
}

impl Surface<'_> {
    fn write(&self, settings: &Settings, bench: &LoopBench, drawn: &Assembly, control: &Mesh) -> Result<()> {
        if let Some(path) = &settings.fine_mesh {
            let faces = drawn.grid().triangles().collect();
            let fine = FineMesh { format: self.format, positions: self.positions.clone(), faces };
            mesh::write(path, &fine)?;
        }
        if let Some(picture) = &settings.picture {
            let _shown = Progress::waiting("drawing the picture");
            let image = self.picture(picture, bench, drawn, control)?;
            crate::files::write_whole(&picture.file, &image)?;
        }
        Ok(())
    }

    fn picture(
        &self,
        wanted: &Picture,
        bench: &LoopBench,
        drawn: &Assembly,
        control: &Mesh,
    ) -> Result<Vec<u8>> {
        let unit = self.format.lsb();
        let positions: Vec<DVec3> =
            self.positions.iter().map(|p| DVec3::from_array(p.map(|x| x as f64 * unit))).collect();
        let (triangles, owners) = bench.triangles(drawn.grid());
        let patches: Vec<picture::Patch> =
            owners.iter().map(|&(depth, number)| picture::Patch { depth, number }).collect();
        let errors: Vec<f64> = match wanted.colour {
            Colour::Error => {
                let error = |(id, p): (usize, &[i64; 3])| self.oracle.vertex_error(id, *p, self.extra);
                self.positions.iter().enumerate().map(error).collect()
            }
            _ => vec![],
        };
        let edges = control_edges(control);
        let scene = Scene {
            positions: &positions,
            triangles: &triangles,
            normals: Normals::Smooth,
            colouring: match wanted.colour {
                Colour::Plain => Colouring::Plain,
                Colour::Error => {
                    Colouring::Values { values: &errors, range: [0.0, 0.5625], title: "error (lsb)" }
                }
                // Strips were refused with the arguments.
                Colour::Patches | Colour::Strips => Colouring::Patches(&patches),
            },
            control: wanted.control_mesh.then_some(Wire { positions: &control.positions, edges: &edges }),
        };
        let finish = if wanted.reflection_lines { Finish::ReflectionLines } else { Finish::Studio };
        Ok(picture::render(&scene, &Options { finish, ..Options::default() })?.png())
    }
}

/// Each edge of the control mesh once.
pub(super) fn control_edges(mesh: &Mesh) -> Vec<[u32; 2]> {
    let sides =
        mesh.faces.iter().flat_map(|face| (0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]]));
    let mut edges: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// Whether an error means that hardware and reference disagree.
pub fn is_mismatch(error: &Error) -> bool {
    error.kind == Kind::Mismatch
}
