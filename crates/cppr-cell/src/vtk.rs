//! The bent cell as a legacy VTK file, for ParaView and the like: the whole cell, its displacement and its strain.
//!
//! The quarter that was solved is mirrored about x = 0 and Z = 0. Every 27-node element is written as eight hexahedra between its nodes.

use crate::cell::{Cell, CellError, MESHES};
use crate::peak::strains;
use std::fmt::Write;

/// Of a 27-node element (x, then η, then q): the corners of its first small hexahedron, in VTK's order.
const CORNERS: [usize; 8] = [0, 9, 12, 3, 1, 10, 13, 4];
/// Of the same, the nodes at which the eight start.
const STARTS: [usize; 8] = [0, 1, 3, 4, 9, 10, 12, 13];

/// κ_Z ρ̄ with which the cell is drawn.
const BEND: f64 = 0.01;

impl Cell {
    /// The cell bent about Z without force along the tube, as the text of a VTK file: points (x, Y, Z) in mm, `displacement` in mm and
    /// the axial strain `strain` for an outer fibre strain κ_Z ρ̄ of 1 %.
    ///
    /// # Errors
    /// As [`Cell::stiffness`].
    pub fn bent_vtk(&self) -> Result<String, CellError> {
        self.check()?;
        let (mesh, solution) = self.solve(&MESHES[1])?;
        let [stretch, bending, ..] = &solution.fields;
        let offset = -solution.stiffness[1] / solution.stiffness[0];
        let field: Vec<[f64; 3]> = bending
            .iter()
            .zip(stretch)
            .map(|(b, s)| std::array::from_fn(|i| BEND * (b[i] + offset * s[i])))
            .collect();
        let strain = strains(&mesh, &field);
        let count = mesh.nodes.len();
        let millimetres = self.scale() * 1e3;
        let mirrors = [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
        let mut text =
            String::from("# vtk DataFile Version 3.0\nnotch cell, mm\nASCII\nDATASET UNSTRUCTURED_GRID\n");
        let all = |text: &mut String, values: &[[f64; 3]]| {
            for [x, z] in mirrors {
                for v in values {
                    let _ = writeln!(
                        text,
                        "{} {} {}",
                        x * v[0] * millimetres,
                        v[1] * millimetres,
                        z * v[2] * millimetres
                    );
                }
            }
        };
        let _ = writeln!(text, "POINTS {} double", 4 * count);
        all(&mut text, &mesh.nodes);
        let cells = 4 * 8 * mesh.elements.len();
        let _ = writeln!(text, "CELLS {cells} {}", 9 * cells);
        for copy in 0..4 {
            for element in &mesh.elements {
                for start in STARTS {
                    let nodes = CORNERS.map(|c| (element[start + c] as usize + copy * count).to_string());
                    let _ = writeln!(text, "8 {}", nodes.join(" "));
                }
            }
        }
        let _ = writeln!(text, "CELL_TYPES {cells}\n{}POINT_DATA {}", "12\n".repeat(cells), 4 * count);
        text.push_str("VECTORS displacement double\n");
        all(&mut text, &field);
        text.push_str("SCALARS strain double 1\nLOOKUP_TABLE default\n");
        for _ in mirrors {
            for strain in &strain {
                let _ = writeln!(text, "{}", strain.map_or(0.0, |s| s[(0, 0)]));
            }
        }
        Ok(text)
    }
}
