//! The 27-node hexahedron: products of quadratic Lagrange polynomials, full integration with 3 × 3 × 3 Gauss points.

/// Values at ξ = −1, 0, 1 of three polynomials, and their slopes.
fn lagrange(x: f64) -> ([f64; 3], [f64; 3]) {
    ([0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)], [x - 0.5, -2.0 * x, x + 0.5])
}

/// Gradients of the 27 shape functions with respect to the element's own coordinates.
fn parent_gradients(at: [f64; 3]) -> [[f64; 3]; 27] {
    let [(a, da), (b, db), (c, dc)] = at.map(lagrange);
    std::array::from_fn(|n| {
        let (i, j, k) = (n / 9, n / 3 % 3, n % 3);
        [da[i] * b[j] * c[k], a[i] * db[j] * c[k], a[i] * b[j] * dc[k]]
    })
}

const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Part of the way from the middle of an element to its surface that counts as just inside.
const INSIDE: f64 = 0.95;

/// Parent gradients at the Gauss points with their weights, and at the nodes.
pub(crate) struct Shape {
    gauss: Vec<([[f64; 3]; 27], f64)>,
    /// At the nodes, and a little inside of them.
    nodes: Vec<[[[f64; 3]; 27]; 2]>,
}

/// What the material does, with Young's modulus 1: Lamé's constants.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lame {
    pub lambda: f64,
    pub mu: f64,
}

impl Lame {
    pub fn new(poisson: f64) -> Self {
        let mu = 0.5 / (1.0 + poisson);
        Self { lambda: 2.0 * mu * poisson / (1.0 - 2.0 * poisson), mu }
    }
}

impl Shape {
    pub fn new() -> Self {
        let mut gauss = Vec::with_capacity(27);
        for (x, u) in GAUSS {
            for (y, v) in GAUSS {
                for (z, w) in GAUSS {
                    gauss.push((parent_gradients([x, y, z]), u * v * w));
                }
            }
        }
        let side = [-1.0, 0.0, 1.0];
        let nodes = (0..27)
            .map(|n| {
                let at = [side[n / 9], side[n / 3 % 3], side[n % 3]];
                [1.0, INSIDE].map(|share| parent_gradients(at.map(|c| c * share)))
            })
            .collect();
        Self { gauss, nodes }
    }

    /// Stiffness of an element: for every pair of nodes a 3 × 3 block, in rows of 27 blocks. None where the element is turned inside out.
    pub fn stiffness(&self, points: &[[f64; 3]; 27], material: Lame) -> Option<Vec<[[f64; 3]; 3]>> {
        let Lame { lambda, mu } = material;
        let mut blocks = vec![[[0.0; 3]; 3]; 27 * 27];
        for (parent, weight) in &self.gauss {
            let (gradients, determinant) = gradients(parent, points);
            if determinant <= 0.0 {
                return None;
            }
            let volume = weight * determinant;
            for (a, ga) in gradients.iter().enumerate() {
                for (b, gb) in gradients.iter().enumerate().skip(a) {
                    let block = &mut blocks[27 * a + b];
                    for i in 0..3 {
                        for j in 0..3 {
                            block[i][j] += volume * ga[i] * gb[j];
                        }
                    }
                }
            }
        }
        for a in 0..27 {
            for b in a..27 {
                let g = blocks[27 * a + b];
                let trace = g[0][0] + g[1][1] + g[2][2];
                for i in 0..3 {
                    for j in 0..3 {
                        let value = lambda * g[i][j] + mu * g[j][i] + if i == j { mu * trace } else { 0.0 };
                        blocks[27 * a + b][i][j] = value;
                        blocks[27 * b + a][j][i] = value;
                    }
                }
            }
        }
        Some(blocks)
    }

    /// Volume of an element.
    pub fn volume(&self, points: &[[f64; 3]; 27]) -> f64 {
        self.gauss.iter().map(|(parent, weight)| weight * gradients(parent, points).1).sum()
    }

    /// Displacement gradient ∂u_i/∂x_j at the nodes of an element; none where the element has no volume.
    pub fn gradients_at_nodes(
        &self,
        points: &[[f64; 3]; 27],
        u: &[[f64; 3]; 27],
    ) -> [Option<[[f64; 3]; 3]>; 27] {
        let largest = self.nodes.iter().map(|[at, _]| gradients(at, points).1).fold(0.0, f64::max);
        std::array::from_fn(|n| {
            // Where an element shrinks to an edge, its gradient is taken just inside.
            let near = self.nodes[n].iter().map(|parent| gradients(parent, points));
            let mut sound = near.filter(|(_, determinant)| *determinant > 0.02 * largest);
            sound.next().map(|(gradients, _)| {
                let mut sum = [[0.0; 3]; 3];
                for (value, gradient) in u.iter().zip(&gradients) {
                    for i in 0..3 {
                        for j in 0..3 {
                            sum[i][j] += value[i] * gradient[j];
                        }
                    }
                }
                sum
            })
        })
    }
}

/// Gradients with respect to (x, Y, Z), and the determinant of the map.
fn gradients(parent: &[[f64; 3]; 27], points: &[[f64; 3]; 27]) -> ([[f64; 3]; 27], f64) {
    let mut j = [[0.0; 3]; 3];
    for (g, p) in parent.iter().zip(points) {
        for row in 0..3 {
            for column in 0..3 {
                j[row][column] += g[row] * p[column];
            }
        }
    }
    let cofactor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        j[r1][c1] * j[r2][c2] - j[r1][c2] * j[r2][c1]
    };
    let inverse: [[f64; 3]; 3] = std::array::from_fn(|r| std::array::from_fn(|c| cofactor(c, r)));
    let determinant = j[0][0] * inverse[0][0] + j[0][1] * inverse[1][0] + j[0][2] * inverse[2][0];
    let all = std::array::from_fn(|n| {
        std::array::from_fn(|i| (0..3).map(|k| inverse[i][k] * parent[n][k]).sum::<f64>() / determinant)
    });
    (all, determinant)
}
