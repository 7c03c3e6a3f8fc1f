//! Designs for the tests of boards.

use subdiv_rtl::board::boards::board;
use subdiv_rtl::board::simulate::{Received, Session};
use subdiv_rtl::board::{Design, Pace, Settings};
use subdiv_rtl::cores::loop_fd::{Parameters, RegisterForm};
use subdiv_rtl::hdl::Flat;
use subdiv_rtl::mesh;
use subdiv_rtl::surface::control_mesh::ControlMesh;

pub const QUICK: Pace = Pace::QUICK;

/// A shape on the ULX3S.
pub fn design(shape: &str, level: u32, coordinates: &str) -> Design {
    design_on("ulx3s", shape, level, coordinates)
}

pub fn design_on(name: &str, shape: &str, level: u32, coordinates: &str) -> Design {
    let format = coordinates.parse().unwrap();
    let found = mesh::shape(shape).unwrap();
    Design::new(settings(name, shape, level, format), &control(&found, format)).unwrap()
}

/// One triangle, so that a frame is short.
pub fn triangle(level: u32) -> Design {
    small(level, vec![[0, 1, 2]])
}

/// Two triangles: at level 2 patches of different levels follow each other in no simple order.
pub fn two_triangles(level: u32) -> Design {
    small(level, vec![[0, 1, 2], [2, 1, 3]])
}

fn small(level: u32, triangles: Vec<[u32; 3]>) -> Design {
    let format = "Q4.4".parse().unwrap();
    let positions = [[-99, 3, 0], [80, -50, 7], [0, 127, -128], [100, 90, 3]];
    let used = 2 + triangles.len();
    let mesh = ControlMesh::new(positions[..used].to_vec(), triangles).unwrap();
    Design::new(settings("ulx3s", "none", level, format), &mesh).unwrap()
}

fn control(mesh: &mesh::Mesh, format: subdiv_rtl::fixed::Format) -> ControlMesh {
    let positions = mesh::quantise(mesh, format).unwrap().positions;
    ControlMesh::new(positions, mesh.triangles().unwrap()).unwrap()
}

fn settings(name: &str, shape: &str, level: u32, format: subdiv_rtl::fixed::Format) -> Settings {
    let board = board(name).unwrap();
    Settings {
        board,
        device: board.device(None).unwrap(),
        parameters: Parameters::new(format, format.fraction, level, RegisterForm::Minimal20).unwrap(),
        level,
        baud: 115_200,
        clock: board.clock,
        mesh: format!("--shape {shape}"),
    }
}

/// The top at a pace, with an undisturbed line and the button up.
pub fn run(design: &Design, pace: Pace) -> Received {
    let top = Flat::new(&design.top(pace).unwrap()).unwrap();
    let (clocks_per_bit, bytes) = (pace.clocks_per_bit, design.expected().len());
    Session { top: &top, clocks_per_bit, pressed: &[], bytes, to_the_end: true, disturb: &|_, line| line }
        .run()
        .unwrap()
}
