//! Host and core in one go: all strips of a mesh, put together by the numbers of the fine vertices.
//!
//! ```text
//!   strips + rings --> records --> CcStrip --> columns --> QuadAssembly: positions, cracks, missing vertices
//! ```

use super::CcStrip;
use crate::error::Result;
use crate::surface::catmull_clark::assembly::QuadAssembly;
use crate::surface::catmull_clark::fine_grid::QuadGrid;
use crate::surface::catmull_clark::quad_mesh::QuadMesh;
use crate::surface::catmull_clark::rings::Rings;
use crate::surface::catmull_clark::strips::Strip;
use crate::surface::catmull_clark::strips::records::positioned;

impl CcStrip {
    /// Renders the strips of a mesh.
    ///
    /// # Errors
    /// As [`CcStrip::for_each_column`], and a fine mesh of more than 2^32 vertices.
    pub fn render<'a>(
        &self,
        mesh: &'a QuadMesh,
        rings: &Rings,
        strips: &[Strip],
        levels: u32,
    ) -> Result<QuadAssembly<'a>> {
        let mut assembly = QuadAssembly::new(QuadGrid::new(mesh, levels)?);
        for (strip, records) in strips.iter().zip(positioned(mesh, rings, strips)) {
            let grid = *assembly.grid();
            let put = |column: super::OutputColumn| {
                for (row, &position) in column.vertices.iter().enumerate() {
                    assembly.put(strip.fine_vertex(&grid, column.index, row), position);
                }
            };
            self.for_each_column(levels, &records, |_, _, _| {}, put)?;
        }
        Ok(assembly)
    }
}
