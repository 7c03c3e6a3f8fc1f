//! `simulate MESH`: a mesh through the hardware, in every simulator, compared bit for bit with the reference.
//!
//! The arguments become [`Settings`]; what is contradictory is refused before any work begins.

mod names;
mod netlist;
mod result;
mod run;
mod strip_picture;
mod strips;
mod targets;

pub use names::{Colour, FamilyName, Scheme, SimulatorName};
pub use run::is_mismatch;

use super::{
    output::{self, FormatArg},
    strip_options::{StripOutput, StripUnits},
    values::{FINEST_LEVEL, Numbers, Registers, USUAL_MAX_LEVEL},
};
use crate::cores::loop_fd::{Columns, Parameters};
use crate::{
    cosim::Stall,
    error::{Error, Result},
    fixed::{Format, Precision, Rounding},
};
use std::{path::PathBuf, time::Duration};
use targets::{in_a_folder, named};

/// Evaluate a mesh's subdivision surface in simulated hardware and check every bit of it
///
/// Each patch of the surface goes through the generated core in each simulator, and what comes out is compared with
/// the integer reference and with the exact limit surface. The exit status is 1 when a single bit differs.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, next_line_help = false)]
#[command(group(clap::ArgGroup::new("source").required(true)))]
pub struct Args {
    /// The control mesh: OBJ, OFF, PLY, STL or SGI Inventor
    #[arg(group = "source")]
    pub mesh: Option<PathBuf>,

    /// A built-in shape in place of a mesh; 'subdiv-rtl shapes' lists them
    #[arg(long, value_name = "NAME", group = "source")]
    pub shape: Option<String>,

    /// Split polygons into triangles; without it they are refused
    #[arg(long, conflicts_with = "shape")]
    pub triangulate: bool,

    /// The subdivision scheme
    #[arg(long, value_enum, default_value_t)]
    pub scheme: Scheme,

    /// Subdivision level: each triangle becomes 4^N, 0 to 10
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = level())]
    pub level: u32,

    #[command(flatten)]
    pub core: Core,

    #[command(flatten)]
    pub units: StripUnits,

    #[command(flatten)]
    pub strip_output: StripOutput,

    #[command(flatten)]
    pub run: Run,

    #[command(flatten)]
    pub keep: Keep,

    #[command(flatten)]
    pub format: FormatArg,
}

/// The hardware.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Core")]
pub struct Core {
    /// Format of the control points: i integer bits with the sign, f fraction bits [default: the widest fraction
    /// that fits in 24 bits]
    #[arg(long, value_name = "Qi.f")]
    pub coordinates: Option<Format>,

    /// Fraction bits of the vertices [default: those of the coordinates]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..Format::WIDEST as i64))]
    pub output_fraction: Option<u32>,

    /// Catmull-Clark: keep this many more fraction bits on every level [default: 6 a level, exact]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=42))]
    pub guard: Option<u32>,

    /// Catmull-Clark: the largest valence the core is made for, 4 to 16 [default: that of the mesh]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=16))]
    pub max_valence: Option<u32>,

    /// The finest level the core is made for [default: Loop 8, or the level if that is finer; strips the level]
    #[arg(long, value_name = "N", value_parser = level())]
    pub max_level: Option<u32>,

    /// The coarsest level the core is made for; only meshes without irregular vertices can do without level 0
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = level())]
    pub min_level: u32,

    /// Registers of each coordinate
    #[arg(long, value_name = "COUNT", value_enum, default_value_t)]
    pub registers: Registers,

    /// Emit wide adders in chunks of this many bits, each a clock behind the one below (Loop)
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(4..=128))]
    pub chunk: Option<u32>,

    /// Compute this many neighbouring strips at once, from columns that they share (Loop)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=Parameters::MOST_LANES as i64))]
    pub lanes: Option<u32>,

    /// Where the columns of a strip come from: shared (both run) or buffered (one runs, a memory keeps the one before; of
    /// one lane) (Loop)
    #[arg(long, value_name = "FORM", default_value_t)]
    pub columns: Columns,

    #[command(flatten)]
    pub numbers: Numbers,
}

/// How it is run.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Simulation")]
pub struct Run {
    /// Where to run it; several with commas or by repeating the option
    #[arg(long, value_name = "NAME", value_enum, value_delimiter = ',', default_value = "builtin")]
    #[arg(default_value_if("netlist", clap::builder::ArgPredicate::IsPresent, "verilator"))]
    pub simulator: Vec<SimulatorName>,

    /// Simulate the netlist that Yosys makes of the core for a family of FPGAs, with the models of its cells; in
    /// Verilator if not said otherwise
    #[arg(long, value_name = "FAMILY", value_enum)]
    pub netlist: Option<FamilyName>,

    /// When the consumer is not ready: none, random, random:PERCENT, bursts, or one-in-N
    #[arg(long, value_name = "PATTERN", default_value_t = Stall::None)]
    pub back_pressure: Stall,

    /// When the producer has nothing to offer, as for --back-pressure
    #[arg(long, value_name = "PATTERN", default_value_t = Stall::None)]
    pub input_gaps: Stall,

    /// Where the random patterns begin
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    /// Stop a compiler or simulator that takes longer
    #[arg(long, value_name = "SECONDS", default_value_t = 600, value_parser = clap::value_parser!(u64).range(1..))]
    pub timeout: u64,
}

/// What is kept of it.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Results")]
pub struct Keep {
    /// Write the fine mesh: .obj, .ply or .stl
    #[arg(short, long, value_name = "FINE.obj")]
    pub output: Option<PathBuf>,

    /// Draw the fine mesh
    #[arg(long, value_name = "FINE.png")]
    pub picture: Option<PathBuf>,

    /// Draw it as a mirror under parallel lines of light, which show the smoothness of its normals
    #[arg(long, requires = "picture")]
    pub reflection_lines: bool,

    /// Draw the control mesh over it
    #[arg(long, requires = "picture")]
    pub control_mesh: bool,

    /// What the colours of the picture show
    #[arg(long, value_enum, value_name = "WHAT", default_value_t, requires = "picture")]
    pub colour: Colour,

    /// Write the waveform of the whole run, by the built-in simulator
    #[arg(long, value_name = "FILE")]
    pub vcd: Option<PathBuf>,

    /// Keep what the simulators worked on in this folder
    #[arg(long, value_name = "DIR")]
    pub keep: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  subdiv-rtl simulate --shape blob
  subdiv-rtl simulate bunny.obj --level 6 --simulator all -o fine.obj --picture fine.png
  subdiv-rtl simulate --shape torus --coordinates Q2.14 --back-pressure random:30 --seed 7
  subdiv-rtl simulate --shape torus --level 2 --max-level 2 --coordinates Q4.4 --netlist ecp5
  subdiv-rtl simulate --shape icosahedron --format json | jq .error_lsb";

fn level() -> impl clap::builder::TypedValueParser<Value = u32> {
    clap::value_parser!(u32).range(0..=i64::from(FINEST_LEVEL))
}

/// What to simulate, complete and checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    pub source: Source,
    pub triangulate: bool,
    pub scheme: Scheme,
    pub level: u32,
    /// Nothing: the widest fraction that fits in 24 bits.
    pub coordinates: Option<Format>,
    /// Nothing: that of the coordinates.
    pub output_fraction: Option<u32>,
    pub max_level: u32,
    pub min_level: u32,
    pub registers: Registers,
    /// Bits of a chunk with skewed carry; nothing: whole words.
    pub chunk: Option<u32>,
    /// Strips at once.
    pub lanes: Option<u32>,
    pub columns: Columns,
    pub precision: Precision,
    /// Guard bits of the strip core; nothing: exact.
    pub guard: Option<u32>,
    /// The most levels of the strip core; nothing: the level.
    pub strip_levels: Option<u32>,
    pub units: StripUnits,
    pub strip_output: StripOutput,
    /// The largest valence of the strip core; nothing: that of the mesh.
    pub max_valence: Option<u32>,
    pub rounding: Option<Rounding>,
    pub simulators: Simulators,
    /// Nothing: the Verilog itself.
    pub netlist: Option<FamilyName>,
    pub back_pressure: Stall,
    pub input_gaps: Stall,
    pub seed: u64,
    /// For each run of a compiler or simulator.
    pub timeout: Duration,
    pub fine_mesh: Option<PathBuf>,
    pub picture: Option<Picture>,
    pub vcd: Option<PathBuf>,
    pub keep: Option<PathBuf>,
    pub format: output::Format,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    File(PathBuf),
    Shape(String),
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Simulators {
    /// Each of these must be there: no pair equal, in the order of [`SimulatorName`], neither `All` nor `Installed`.
    Named(Vec<SimulatorName>),
    /// Those that are there.
    Installed,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    pub file: PathBuf,
    pub reflection_lines: bool,
    pub control_mesh: bool,
    pub colour: Colour,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    run::run(&args.settings()?)
}

impl Args {
    /// Checks what can be checked before any work.
    ///
    /// # Errors
    /// `Usage` for a level that the core is not made for, two sources of simulators that contradict each other, and
    /// files that would not be written in the end for their names.
    pub fn settings(&self) -> Result<Settings> {
        let source = match (&self.mesh, &self.shape) {
            (Some(file), None) => Source::File(file.clone()),
            (None, Some(name)) => Source::Shape(name.clone()),
            _ => {
                return Err(
                    Error::usage("one mesh is simulated at a time").help("give a file, or --shape NAME")
                );
            }
        };
        let max_level = self.core.max_level.unwrap_or(USUAL_MAX_LEVEL.max(self.level));
        if self.level > max_level {
            let what = format!("level {} of a core that ends at level {max_level}", self.level);
            return Err(Error::usage(what).help("lower --level or raise --max-level"));
        }
        if self.scheme == Scheme::Loop && self.keep.colour == Colour::Strips {
            return Err(Error::usage("triangles go patch by patch, not in strips")
                .help("choose --colour patches, or --scheme catmull-clark"));
        }
        if self.level < self.core.min_level {
            let what = format!("level {} of a core that begins at level {}", self.level, self.core.min_level);
            return Err(Error::usage(what).help("raise --level or lower --min-level"));
        }
        let precision = match self.scheme {
            Scheme::Loop => self.core.numbers.precision()?,
            // The rounding is that of new vertices; nothing else is meant for strips.
            Scheme::CatmullClark if Numbers { rounding: None, ..self.core.numbers } == Numbers::default() => {
                Precision::Exact
            }
            Scheme::CatmullClark => {
                return Err(Error::usage("fraction bits of differences, of which strips have none")
                    .help("with --scheme catmull-clark, give --guard N"));
            }
        };
        let fine_mesh = self.keep.output.clone();
        for file in [&fine_mesh, &self.keep.picture, &self.keep.vcd].into_iter().flatten() {
            in_a_folder(file)?;
        }
        named(fine_mesh.as_deref(), "fine mesh", &["obj", "ply", "stl"])?;
        named(self.keep.picture.as_deref(), "picture", &["png"])?;
        let picture = self.keep.picture.as_ref().map(|file| Picture {
            file: file.clone(),
            reflection_lines: self.keep.reflection_lines,
            control_mesh: self.keep.control_mesh,
            colour: self.keep.colour,
        });
        Ok(Settings {
            source,
            triangulate: self.triangulate,
            scheme: self.scheme,
            level: self.level,
            coordinates: self.core.coordinates,
            output_fraction: self.core.output_fraction,
            max_level,
            min_level: self.core.min_level,
            registers: self.core.registers,
            chunk: self.core.chunk,
            lanes: self.core.lanes,
            columns: self.core.columns,
            precision,
            guard: self.core.guard,
            strip_levels: self.core.max_level,
            units: self.units.clone(),
            strip_output: self.strip_output.clone(),
            max_valence: self.core.max_valence,
            rounding: self.core.numbers.rounding,
            simulators: simulators(&self.run.simulator, self.run.netlist.is_some())?,
            netlist: self.run.netlist,
            back_pressure: self.run.back_pressure,
            input_gaps: self.run.input_gaps,
            seed: self.run.seed,
            timeout: Duration::from_secs(self.run.timeout),
            fine_mesh,
            picture,
            vcd: self.keep.vcd.clone(),
            keep: self.keep.keep.clone(),
            format: self.format.format,
        })
    }
}

/// A netlist is for external simulators: `all` leaves ours out.
fn simulators(names: &[SimulatorName], netlist: bool) -> Result<Simulators> {
    if netlist && names.contains(&SimulatorName::Builtin) {
        return Err(Error::usage("the built-in simulator runs the core itself, not its netlist")
            .help("choose --simulator verilator, icarus or all, or leave out --netlist"));
    }
    if names.contains(&SimulatorName::Installed) {
        if names.iter().any(|name| *name != SimulatorName::Installed) {
            return Err(Error::usage("simulators are named beside 'installed'")
                .help("name those that must be there, or say 'installed' alone"));
        }
        return Ok(Simulators::Installed);
    }
    let all = [SimulatorName::Builtin, SimulatorName::Verilator, SimulatorName::Icarus];
    let every = names.contains(&SimulatorName::All);
    let mut wanted: Vec<SimulatorName> =
        names.iter().copied().filter(|name| *name != SimulatorName::All).collect();
    wanted.extend(all.into_iter().filter(|name| every && !(netlist && *name == SimulatorName::Builtin)));
    wanted.sort();
    wanted.dedup();
    Ok(Simulators::Named(wanted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Args as _, FromArgMatches};

    fn command() -> clap::Command {
        Args::augment_args(clap::Command::new("simulate"))
    }

    fn parse(words: &str) -> Result<Args, clap::Error> {
        let words = ["simulate"].into_iter().chain(words.split_whitespace());
        Args::from_arg_matches(&command().try_get_matches_from(words)?)
    }

    fn settings(words: &str) -> Settings {
        parse(words).unwrap().settings().unwrap()
    }

    #[test]
    fn the_options_are_consistent() {
        command().debug_assert();
    }

    #[test]
    fn one_mesh_is_needed_and_no_more() {
        assert_eq!(settings("bunny.obj").source, Source::File("bunny.obj".into()));
        assert_eq!(settings("--shape blob").source, Source::Shape("blob".into()));
        assert!(parse("").is_err());
        assert!(parse("bunny.obj --shape blob").is_err());
    }

    #[test]
    fn the_core_is_made_fine_enough() {
        assert_eq!(settings("a.obj").max_level, 8);
        assert_eq!(settings("a.obj --level 10").max_level, 10);
        assert_eq!(settings("a.obj --level 2 --max-level 2").max_level, 2);
        assert!(parse("a.obj --level 3 --max-level 2").unwrap().settings().is_err());
        assert!(parse("a.obj --level 11").is_err());
    }

    #[test]
    fn reduced_numbers_are_for_the_differences_of_loop() {
        let precision = |words: &str| settings(&format!("a.obj {words}")).precision.to_string();
        assert_eq!(precision("--fraction 17"), "17 half-up");
        assert_eq!(precision("--fractions 7,11,15,18,18 --rounding floor"), "7,11,15,18,18 floor");
        for words in
            ["--fractions 7,11", "--fractions 3,2,2,2,2", "--rounding up", "--fraction 7 --fractions 7"]
        {
            assert!(parse(&format!("a.obj {words}")).is_err(), "{words}");
        }
        for words in ["--saturate", "--fraction 7 --scheme catmull-clark", "--min-level 6"] {
            let refused = parse(&format!("a.obj {words}")).unwrap().settings();
            assert_eq!(refused.unwrap_err().exit_status(), 2, "{words}");
        }
    }

    #[test]
    fn simulators_are_a_set() {
        use SimulatorName::{Builtin, Icarus, Verilator};
        let chosen = |words: &str| settings(&format!("a.obj {words}")).simulators;
        assert_eq!(chosen(""), Simulators::Named(vec![Builtin]));
        assert_eq!(
            chosen("--simulator icarus,builtin --simulator icarus"),
            Simulators::Named(vec![Builtin, Icarus])
        );
        assert_eq!(chosen("--simulator all,icarus"), Simulators::Named(vec![Builtin, Verilator, Icarus]));
        assert_eq!(chosen("--netlist ecp5"), Simulators::Named(vec![Verilator]));
        assert_eq!(chosen("--netlist ecp5 --simulator all"), Simulators::Named(vec![Verilator, Icarus]));
        assert!(parse("a.obj --netlist ecp5 --simulator builtin").unwrap().settings().is_err());
        assert_eq!(chosen("--simulator installed"), Simulators::Installed);
        assert!(parse("a.obj --simulator installed,icarus").unwrap().settings().is_err());
    }

    #[test]
    fn files_that_cannot_be_written_are_refused_at_once() {
        assert_eq!(settings("a.obj -o fine.STL").fine_mesh, Some("fine.STL".into()));
        for words in ["a.obj -o fine.off", "a.obj -o fine", "a.obj --picture fine.jpg"] {
            assert_eq!(parse(words).unwrap().settings().unwrap_err().exit_status(), 2, "{words}");
        }
    }

    #[test]
    fn strips_are_shown_of_quads_only() {
        let colour = "a.obj --picture a.png --colour strips";
        assert_eq!(parse(colour).unwrap().settings().unwrap_err().exit_status(), 2);
        assert!(settings(&format!("{colour} --scheme catmull-clark")).picture.is_some());
    }

    #[test]
    fn options_of_the_picture_need_one() {
        for option in ["--reflection-lines", "--control-mesh", "--colour error"] {
            assert!(parse(&format!("a.obj {option}")).is_err(), "{option}");
            assert!(settings(&format!("a.obj --picture a.png {option}")).picture.is_some(), "{option}");
        }
    }
}
