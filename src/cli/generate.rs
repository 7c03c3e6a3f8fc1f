//! `generate CORE`: Verilog with everything that belongs to it.
//!
//! The arguments and the configuration file become [`Settings`]; what is not said has a default.

use super::{
    aim::{self, Aimed},
    board,
    config::Config,
    output,
    progress::{self, Progress},
    strip_options::{StripOutput, StripUnits},
    values::{FINEST_LEVEL, Numbers, Registers, USUAL_MAX_LEVEL},
};
use crate::{
    cores::{
        cc_strip,
        loop_fd::{Columns, Parameters},
    },
    error::Result,
    fixed::{Format, Fractions, Precision, Rounding},
    package,
};
use std::path::PathBuf;

/// Write a core: Verilog, testbench, FuseSoC core file, file list and manifest
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    pub core: Core,
}

#[derive(Debug, clap::Subcommand)]
pub enum Core {
    /// The forward-difference engine for regular patches of Loop surfaces
    ///
    /// In come the 12 control points of a patch and its level, out come the vertices of its triangle strips, two each
    /// clock, exact up to one final rounding. Before anything is written the core is proved: it is run with exact
    /// linear forms in place of numbers, and what comes out must be the mask of the surface.
    LoopFd(Aimed<LoopFd>),
    /// The sliding window for quad strips of Catmull-Clark surfaces
    ///
    /// In come the columns of a strip of quads with what lies around them, out come the columns of the fine strip. Every
    /// level is proved for every valence before anything is written.
    CcStrip(Aimed<CcStrip>),
    Board(Box<board::Args>),
}

// Options of the core. (A comment for the documentation would become the help.)
#[derive(Debug, clap::Args)]
pub struct CcStrip {
    /// Format of the control points: i integer bits with the sign, f fraction bits
    #[arg(long, value_name = "Qi.f", default_value = "Q12.12")]
    pub coordinates: Format,

    /// Fraction bits of the vertices [default: those of the coordinates]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..Format::WIDEST as i64))]
    pub output_fraction: Option<u32>,

    /// The most that a strip can be subdivided at run time, 1 to 7
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=7))]
    pub max_level: u32,

    /// The largest valence of a vertex, 4 to 16
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(4..=16))]
    pub max_valence: u32,

    /// Keep this many more fraction bits on every level [default: 6 a level, exact]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=42))]
    pub guard: Option<u32>,

    /// How new vertices are rounded: half-up, half-even, floor or truncate [default: half-up]
    #[arg(long, value_name = "MODE")]
    pub rounding: Option<Rounding>,

    /// Fraction bits of the table for irregular vertices [default: those of the coordinates and 13]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(8..=52))]
    pub table: Option<u32>,

    #[command(flatten)]
    pub unit: StripUnits,

    #[command(flatten)]
    pub result: StripOutput,

    /// Write without the proof; the manifest says so
    #[arg(long)]
    pub no_proof: bool,

    /// Write into a folder that holds other files too
    #[arg(long)]
    pub force: bool,

    /// The folder to write to [default: cc-strip]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

impl CcStrip {
    /// The core that the options ask for.
    ///
    /// # Errors
    /// Parameters that no core has.
    pub fn parameters(&self) -> Result<cc_strip::Parameters> {
        let plain = cc_strip::Parameters {
            output_fraction: self.output_fraction.unwrap_or(self.coordinates.fraction),
            precision: self.guard.map_or(cc_strip::Precision::Exact, cc_strip::Precision::Guard),
            rounding: self.rounding.unwrap_or(Rounding::HalfUp),
            table_bits: self.table.unwrap_or(self.coordinates.width() + 13),
            ..cc_strip::Parameters::exact(self.coordinates, self.max_level, self.max_valence)
        };
        self.result.on(self.unit.on(plain)).check()
    }
}

// Options of the core. (A comment for the documentation would become the help.)
#[derive(Debug, Default, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct LoopFd {
    /// Format of the control points: i integer bits with the sign, f fraction bits [default: Q12.12]
    #[arg(long, value_name = "Qi.f")]
    pub coordinates: Option<Format>,

    /// Fraction bits of the vertices [default: those of the coordinates]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..Format::WIDEST as i64))]
    pub output_fraction: Option<u32>,

    /// The finest level the core can be asked for at run time, 0 to 10 [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=FINEST_LEVEL as i64))]
    pub max_level: Option<u32>,

    /// The coarsest level; reduced differences of fine levels are narrower [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=FINEST_LEVEL as i64))]
    pub min_level: Option<u32>,

    /// Registers of each coordinate [default: 20]
    #[arg(long, value_name = "COUNT")]
    pub registers: Option<Registers>,

    /// Emit wide adders in chunks of this many bits, each a clock behind the one below: the carry no longer limits
    /// the clock
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(4..=128))]
    pub chunk: Option<u32>,

    /// Compute this many neighbouring strips at once, from columns that they share: 2 N triangles a clock
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=Parameters::MOST_LANES as i64))]
    pub lanes: Option<u32>,

    /// Where the columns of a strip come from: shared (both run) or buffered (one runs, a memory keeps the one before; of
    /// one lane) [default: shared]
    #[arg(long, value_name = "FORM")]
    pub columns: Option<Columns>,

    #[command(flatten)]
    pub numbers: Numbers,

    /// Write without the proof; the manifest says so
    #[arg(long, overrides_with = "proof")]
    pub no_proof: bool,

    /// Prove, where the configuration says otherwise
    #[arg(long, hide_short_help = true, overrides_with = "no_proof")]
    pub proof: bool,

    /// Take defaults for these options from a TOML file, with the names of the options as keys
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,

    /// Write into a folder that holds other files too
    #[arg(long)]
    pub force: bool,

    /// The folder to write to [default: loop-fd]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  subdiv-rtl generate loop-fd
  subdiv-rtl generate loop-fd --coordinates Q1.17 --max-level 5 -o rtl/small
  subdiv-rtl generate loop-fd --max-level 5 --fractions 8,12,14,17,18
  subdiv-rtl generate loop-fd --min-level 8 --lanes 1 --clock 300MHz --device ecp5-85k
  subdiv-rtl generate loop-fd --config core.toml

where core.toml has any of these lines:
  coordinates = \"Q12.12\"
  output-fraction = 12
  max-level = 8
  min-level = 0
  registers = 20
  fraction = 17                # or fractions = \"8,12,14,17,18\"
  rounding = \"half-up\"
  saturate = false
  chunk = 14
  lanes = 1
  columns = \"shared\"
  proof = true
  output = \"rtl/loop-fd\"     # from the folder of the configuration";

/// Runs the subcommand.
///
/// # Errors
/// Those of the settings; a core that cannot be built; a refuted proof; a folder that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let (package, folder, force) = match &args.core {
        Core::LoopFd(Aimed { core, aim }) => {
            let settings = core.settings()?;
            let parameters = match aim.goal()? {
                Some(goal) => aim::loop_fd(settings.parameters()?, goal)?,
                None => settings.parameters()?,
            };
            let _shown = working(settings.proof);
            (package::loop_fd::package(parameters, settings.proof)?, settings.folder, settings.force)
        }
        Core::CcStrip(Aimed { core, aim }) => {
            let parameters = match aim.goal()? {
                Some(goal) => aim::cc_strip(core, goal)?,
                None => core.parameters()?,
            };
            let folder = core.output.clone().unwrap_or(PathBuf::from("cc-strip"));
            let _shown = working(!core.no_proof);
            (package::cc_strip::package(parameters, !core.no_proof)?, folder, core.force)
        }
        Core::Board(board) => (board.package()?, board.folder(), board.force),
    };
    package.write(&folder, force)?;
    if let Some((clocks, between)) = package.latency {
        progress::note(format!("latency: {clocks} clocks from {between}"));
    }
    if let Some(estimate) = &package.estimate {
        progress::note(format!("estimate: {estimate}"));
    }
    let paths = package.files.iter().map(|(path, _)| format!("{}\n", folder.join(path).display()));
    output::print(&paths.collect::<String>())
}

fn working(proof: bool) -> Progress {
    Progress::waiting(if proof { "proving the core" } else { "building the core" })
}

/// What to generate, complete and checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    pub coordinates: Format,
    pub output_fraction: u32,
    pub max_level: u32,
    pub min_level: u32,
    pub registers: Registers,
    pub precision: Precision,
    pub chunk: Option<u32>,
    pub lanes: Option<u32>,
    pub columns: Columns,
    /// Whether to prove the core before it is written.
    pub proof: bool,
    /// Whether to write into a folder that holds other files.
    pub force: bool,
    pub folder: PathBuf,
}

impl Settings {
    /// The core that the options ask for.
    ///
    /// # Errors
    /// Parameters that no core has.
    pub fn parameters(&self) -> Result<Parameters> {
        Parameters::new(self.coordinates, self.output_fraction, self.max_level, self.registers.form())?
            .with_min_level(self.min_level)?
            .with_precision(self.precision)?
            .with_chunk(self.chunk)?
            .with_lanes(self.lanes)?
            .with_columns(self.columns)
    }
}

impl LoopFd {
    /// The command line beats the file, the file beats the default.
    ///
    /// # Errors
    /// Those of the configuration file.
    pub fn settings(&self) -> Result<Settings> {
        const KEYS: [&str; 14] = [
            "coordinates",
            "output-fraction",
            "max-level",
            "min-level",
            "registers",
            "fraction",
            "fractions",
            "rounding",
            "saturate",
            "chunk",
            "lanes",
            "columns",
            "proof",
            "output",
        ];
        let file = self.config.as_ref().map(|file| Config::read(file, &KEYS)).transpose()?;
        let file = file.as_ref();

        let coordinates = or_file(self.coordinates, file, |file| file.text("coordinates"))?
            .unwrap_or(Format { integer: 12, fraction: 12 });
        let whole = |key: &'static str, limit: u32| {
            let wanted = format!("a whole number from 0 to {limit}");
            let take = move |number: i64| u32::try_from(number).ok().filter(|number| *number <= limit);
            move |file: &Config| file.whole(key, &wanted, take)
        };
        let fraction = whole("output-fraction", Format::WIDEST - 1);
        let registers = |file: &Config| file.whole("registers", "23, 22, 20 or 19", Registers::from_count);
        let proof = (self.proof || self.no_proof).then_some(self.proof);
        let one = or_file(self.numbers.fraction, file, whole("fraction", Fractions::MOST))?;
        let each = or_file(self.numbers.fractions, file, |file| file.text("fractions"))?;
        // Fractions on the command line are instead of those of the file, of whichever kind they are.
        let said = self.numbers.fraction.is_some() || self.numbers.fractions.is_some();
        let numbers = Numbers {
            fraction: if said { self.numbers.fraction } else { one },
            fractions: if said { self.numbers.fractions } else { each },
            rounding: or_file(self.numbers.rounding, file, |file| file.text("rounding"))?,
            saturate: or_file(self.numbers.saturate.then_some(true), file, |file| file.truth("saturate"))?
                .unwrap_or(false),
        };
        Ok(Settings {
            coordinates,
            output_fraction: or_file(self.output_fraction, file, fraction)?.unwrap_or(coordinates.fraction),
            max_level: or_file(self.max_level, file, whole("max-level", FINEST_LEVEL))?
                .unwrap_or(USUAL_MAX_LEVEL),
            min_level: or_file(self.min_level, file, whole("min-level", FINEST_LEVEL))?.unwrap_or(0),
            registers: or_file(self.registers, file, registers)?.unwrap_or_default(),
            precision: numbers.precision()?,
            chunk: or_file(self.chunk, file, |file| {
                file.whole("chunk", "4 to 128", |bits| {
                    u32::try_from(bits).ok().filter(|b| (4..=128).contains(b))
                })
            })?,
            lanes: or_file(self.lanes, file, |file| {
                let most = Parameters::MOST_LANES;
                file.whole("lanes", &format!("1 to {most}"), |lanes| {
                    u32::try_from(lanes).ok().filter(|lanes| (1..=most).contains(lanes))
                })
            })?,
            columns: or_file(self.columns, file, |file| file.text("columns"))?.unwrap_or_default(),
            proof: or_file(proof, file, |file| file.truth("proof"))?.unwrap_or(true),
            force: self.force,
            folder: or_file(self.output.clone(), file, |file| file.path("output"))?
                .unwrap_or(PathBuf::from("loop-fd")),
        })
    }
}

/// The value from the command line, else that of the file. The file's value is read in any case, so that its
/// mistakes do not hide behind an option.
fn or_file<T>(
    said: Option<T>,
    file: Option<&Config>,
    read: impl FnOnce(&Config) -> Result<Option<T>>,
) -> Result<Option<T>> {
    let written = file.map(read).transpose()?.flatten();
    Ok(said.or(written))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Args as _, FromArgMatches};
    use std::fs;

    fn command() -> clap::Command {
        LoopFd::augment_args(clap::Command::new("loop-fd"))
    }

    fn parse(words: &str) -> Result<LoopFd, clap::Error> {
        let words = ["loop-fd"].into_iter().chain(words.split_whitespace());
        LoopFd::from_arg_matches(&command().try_get_matches_from(words)?)
    }

    #[test]
    fn the_options_are_consistent() {
        Args::augment_args(clap::Command::new("generate")).debug_assert();
    }

    #[test]
    fn what_is_not_said_has_a_default() {
        let settings = parse("").unwrap().settings().unwrap();
        let coordinates = Format { integer: 12, fraction: 12 };
        let folder = PathBuf::from("loop-fd");
        let registers = Registers::WithoutDoubles;
        let (output_fraction, max_level, min_level, proof, force) = (12, 8, 0, true, false);
        let precision = Precision::Exact;
        assert_eq!(
            settings,
            Settings {
                coordinates,
                output_fraction,
                max_level,
                min_level,
                registers,
                precision,
                chunk: None,
                lanes: None,
                columns: Columns::Shared,
                proof,
                force,
                folder
            }
        );
    }

    #[test]
    fn fractions_of_the_command_line_stand_in_for_those_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("core.toml");
        fs::write(&file, "fraction = 9\nrounding = \"floor\"\nsaturate = true\n").unwrap();
        let with =
            |words: &str| parse(&format!("--config {} {words}", file.display())).unwrap().settings().unwrap();
        assert_eq!(with("").precision.to_string(), "9 floor saturate");
        assert_eq!(with("--fractions 1,2,3,4,5").precision.to_string(), "1,2,3,4,5 floor saturate");
        assert_eq!(with("--rounding half-up").precision.to_string(), "9 half-up saturate");
        fs::write(&file, "fraction = 9\nfractions = \"1,2,3,4,5\"\n").unwrap();
        let both = parse(&format!("--config {}", file.display())).unwrap().settings();
        assert_eq!(both.unwrap_err().exit_status(), 2);
        assert_eq!(parse("--saturate").unwrap().settings().unwrap_err().exit_status(), 2);
    }

    #[test]
    fn the_outputs_have_the_fraction_of_the_coordinates() {
        let settings = parse("--coordinates Q2.20").unwrap().settings().unwrap();
        assert_eq!(settings.output_fraction, 20);
    }

    #[test]
    fn the_command_line_beats_the_file_and_the_file_beats_the_default() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("core.toml");
        fs::write(&file, "max-level = 3\nregisters = 19\nproof = false\noutput = \"rtl\"\n").unwrap();
        let with =
            |words: &str| parse(&format!("--config {} {words}", file.display())).unwrap().settings().unwrap();
        let from_file = with("");
        assert_eq!(
            (from_file.max_level, from_file.registers, from_file.proof),
            (3, Registers::Distance, false)
        );
        assert_eq!((from_file.folder, from_file.output_fraction), (folder.path().join("rtl"), 12));
        let said = with("--max-level 7 --registers 23 --proof -o here");
        assert_eq!((said.max_level, said.registers, said.proof), (7, Registers::Published, true));
        assert_eq!(said.folder, PathBuf::from("here"));
    }

    #[test]
    fn a_mistake_in_the_file_does_not_hide_behind_an_option() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("core.toml");
        fs::write(&file, "max-level = 11\n").unwrap();
        let said = parse(&format!("--config {} --max-level 7", file.display())).unwrap();
        assert_eq!(said.settings().unwrap_err().what, "'max-level' must be a whole number from 0 to 10");
    }

    #[test]
    fn columns_are_those_of_the_command_line_or_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("core.toml");
        fs::write(&file, "columns = \"buffered\"\n").unwrap();
        let with = |words: &str| parse(&format!("--config {} {words}", file.display())).unwrap().settings();
        let buffered = with("").unwrap().parameters().unwrap();
        assert_eq!((buffered.columns, buffered.lanes), (Columns::Buffered, Some(1)));
        let shared = with("--columns shared").unwrap().parameters().unwrap();
        assert_eq!((shared.columns, shared.lanes), (Columns::Shared, None));
        for words in ["--lanes 2", "--fraction 9", "--registers 19"] {
            assert_eq!(with(words).unwrap().parameters().unwrap_err().exit_status(), 2, "{words}");
        }
        fs::write(&file, "columns = \"both\"\n").unwrap();
        assert_eq!(with("").unwrap_err().exit_status(), 2);
    }

    #[test]
    fn the_last_of_proof_and_no_proof_counts() {
        assert!(!parse("--proof --no-proof").unwrap().settings().unwrap().proof);
        assert!(parse("--no-proof --proof").unwrap().settings().unwrap().proof);
    }

    #[test]
    fn values_that_no_core_has_are_refused() {
        for words in [
            "--max-level 11",
            "--registers 21",
            "--coordinates 12.12",
            "--output-fraction 32",
            "--columns both",
        ] {
            assert_eq!(parse(words).unwrap_err().exit_code(), 2, "{words}");
        }
    }
}
