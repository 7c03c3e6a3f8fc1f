//! The picture of a fine mesh of quads, and what its colours show.

use glam::DVec3;

use super::run::control_edges;
use super::{Colour, Picture};
use crate::error::Result;
use crate::fixed::Format;
use crate::mesh::Mesh;
use crate::report::picture::{self, Colouring, Finish, Normals, Options, Patch, Scene, Wire};
use crate::surface::catmull_clark::fine_grid::QuadGrid;
use crate::surface::catmull_clark::patches::patches;
use crate::surface::catmull_clark::strips::Strip;

/// What is drawn. Positions and errors are those of the vertices of the fine grid.
pub struct Drawn<'a> {
    pub grid: &'a QuadGrid<'a>,
    pub strips: &'a [Strip],
    pub control: &'a Mesh,
    pub positions: &'a [[i64; 3]],
    pub format: Format,
    /// The distance of a vertex from where it belongs, in units of the last place.
    pub error: &'a dyn Fn(usize) -> f64,
}

/// The picture as a PNG file.
///
/// # Errors
/// What cannot be drawn: nothing at all.
pub fn draw(drawn: &Drawn, wanted: &Picture) -> Result<Vec<u8>> {
    let point = |p: &[i64; 3]| DVec3::from_array(p.map(|x| x as f64 * drawn.format.lsb()));
    let positions: Vec<DVec3> = drawn.positions.iter().map(point).collect();
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    let triangles: Vec<[u32; 3]> = drawn.grid.quads().flat_map(halves).collect();
    let (mut errors, mut patch_of, mut strip_of) = (vec![], vec![], vec![]);
    match wanted.colour {
        Colour::Plain => {}
        Colour::Error => errors = (0..positions.len()).map(drawn.error).collect(),
        Colour::Patches => {
            let depth = |depth: u32| depth.min(u8::MAX.into()) as u8;
            let patches = patches(drawn.grid);
            let twice = patches.iter().flat_map(|p| [Patch { depth: depth(p.depth), number: p.number }; 2]);
            patch_of = twice.collect();
        }
        Colour::Strips => strip_of = strips_of(drawn),
    }
    let edges = control_edges(drawn.control);
    let scene = Scene {
        positions: &positions,
        triangles: &triangles,
        normals: Normals::Smooth,
        colouring: match wanted.colour {
            Colour::Plain => Colouring::Plain,
            Colour::Error => {
                Colouring::Values { values: &errors, range: [0.0, 0.5625], title: "error (lsb)" }
            }
            Colour::Patches => Colouring::Patches(&patch_of),
            Colour::Strips => Colouring::Strips(&strip_of),
        },
        control: wanted.control_mesh.then_some(Wire { positions: &drawn.control.positions, edges: &edges }),
    };
    let finish = if wanted.reflection_lines { Finish::ReflectionLines } else { Finish::Studio };
    Ok(picture::render(&scene, &Options { finish, ..Options::default() })?.png())
}

/// The strip of each triangle: two a fine quad, 4^L of those a quad.
fn strips_of(drawn: &Drawn) -> Vec<u32> {
    let mut of_quad = vec![0; drawn.grid.mesh().quads().len()];
    for (strip, number) in drawn.strips.iter().zip(0..) {
        strip.quads().for_each(|quad| of_quad[quad as usize] = number);
    }
    let triangles = 2usize << (2 * drawn.grid.level());
    of_quad.iter().flat_map(|&strip| std::iter::repeat_n(strip, triangles)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh;
    use crate::surface::catmull_clark::quad_mesh::QuadMesh;
    use crate::surface::catmull_clark::strips::{Method, cut};
    use std::collections::BTreeSet;

    #[test]
    fn every_colouring_is_another_picture() {
        let format = Format { integer: 2, fraction: 12 };
        let control = mesh::shape("cube-quads").unwrap();
        let quantised = mesh::quantise(&control, format).unwrap();
        let quads = quantised.faces.iter().map(|f| [f[0], f[1], f[2], f[3]]).collect();
        let quads = QuadMesh::new(quantised.positions.clone(), quads).unwrap();
        let grid = QuadGrid::new(&quads, 0).unwrap();
        let strips = cut(&quads, Method::Natural);
        let error = |vertex: usize| vertex as f64 / 16.0;
        let drawn = Drawn {
            grid: &grid,
            strips: &strips,
            control: &control,
            positions: &quantised.positions,
            format,
            error: &error,
        };
        let of = strips_of(&drawn);
        assert_eq!((of.len(), of.iter().collect::<BTreeSet<_>>().len()), (12, strips.len()));
        let picture = |colour| Picture {
            file: "cube.png".into(),
            reflection_lines: false,
            control_mesh: false,
            colour,
        };
        let images: BTreeSet<Vec<u8>> = [Colour::Plain, Colour::Error, Colour::Patches, Colour::Strips]
            .into_iter()
            .map(|colour| draw(&drawn, &picture(colour)).unwrap())
            .collect();
        assert_eq!(images.len(), 4);
    }
}
