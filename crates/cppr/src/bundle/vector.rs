//! Vectors of three and rotations, over the numbers of the kernel.

use super::number::Number;

pub(crate) fn cross<S: Number>(a: [S; 3], b: [S; 3]) -> [S; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn dot<S: Number>(a: [S; 3], b: [S; 3]) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn sum<S: Number>(a: [S; 3], b: [S; 3]) -> [S; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// The first column of the rotation of a quaternion (w, x, y, z) of any length.
pub(crate) fn first_column<S: Number>(q: &[S; 4]) -> [S; 3] {
    let &[w, x, y, z] = q;
    let two = S::constant(2.0) / (w * w + x * x + y * y + z * z);
    [S::constant(1.0) - (y * y + z * z) * two, (x * y + w * z) * two, (x * z - w * y) * two]
}

/// Columns of the rotation of a quaternion (w, x, y, z) of any length.
pub(crate) fn columns<S: Number>(q: [S; 4]) -> [[S; 3]; 3] {
    let [w, x, y, z] = q;
    let one = S::constant(1.0);
    let two = S::constant(2.0) / (w * w + x * x + y * y + z * z);
    let (xx, yy, zz) = (x * x * two, y * y * two, z * z * two);
    let (xy, xz, yz) = (x * y * two, x * z * two, y * z * two);
    let (wx, wy, wz) = (w * x * two, w * y * two, w * z * two);
    [[one - yy - zz, xy + wz, xz - wy], [xy - wz, one - xx - zz, yz + wx], [xz + wy, yz - wx, one - xx - yy]]
}
