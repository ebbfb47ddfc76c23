//! Principal strains of largest magnitude at the nodes of a mesh, from the mean of the elements that share a node.

use crate::element::Shape;
use crate::mesh::Mesh;
use crate::system::{Field, Solution};
use cppr::design::PeakStrain;
use nalgebra::Matrix3;

/// Strain tensor at every node, where it is known.
pub(crate) fn strains(mesh: &Mesh, field: &Field) -> Vec<Option<Matrix3<f64>>> {
    let shape = Shape::new();
    let mut sums = vec![(Matrix3::zeros(), 0.0); mesh.nodes.len()];
    for element in &mesh.elements {
        let points = element.map(|n| mesh.nodes[n as usize]);
        let u = element.map(|n| field[n as usize]);
        for (node, gradient) in element.iter().zip(shape.gradients_at_nodes(&points, &u)) {
            if let Some(g) = gradient {
                let strain = Matrix3::from_fn(|i, j| 0.5 * (g[i][j] + g[j][i]));
                let sum = &mut sums[*node as usize];
                sum.0 += strain;
                sum.1 += 1.0;
            }
        }
    }
    sums.into_iter().map(|(sum, count)| (count > 0.0).then(|| sum / count)).collect()
}

/// Greatest and least principal strain of the whole mesh.
fn extremes(strains: &[Option<Matrix3<f64>>]) -> [f64; 2] {
    strains
        .iter()
        .flatten()
        .map(Matrix3::symmetric_eigenvalues)
        .fold([0.0_f64; 2], |[most, least], values| [most.max(values.max()), least.min(values.min())])
}

/// Peaks per unit strain of the beam about the effective centroid at Y = `offset` (outer radii).
pub(crate) fn peak_strain(mesh: &Mesh, solution: &Solution, offset: f64) -> PeakStrain {
    let [stretch, bending, sideways, twist] = &solution.fields;
    // No force along the tube: the axis is stretched by κ_Z D.
    let free: Field =
        bending.iter().zip(stretch).map(|(b, s)| std::array::from_fn(|i| b[i] + offset * s[i])).collect();
    let of = |field: &Field| extremes(&strains(mesh, field));
    let either = |[most, least]: [f64; 2]| most.max(-least);
    PeakStrain {
        bending_z: of(&free),
        stretch: of(stretch),
        bending_y: either(of(sideways)),
        twist: either(of(twist)),
    }
}
