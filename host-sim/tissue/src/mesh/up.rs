//! Direction of a file that points up in the scene.

use serde::{Deserialize, Serialize};

/// Axis of a mesh file that becomes the scene's z, up. The others follow in cyclic order, so that a
/// right-handed frame stays one.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub enum Up {
    /// The file's x: the scene's x, y, z are its y, z, x.
    #[serde(rename = "x")]
    X,
    /// The file's -x: the scene's x, y, z are its y, -z, -x.
    #[serde(rename = "-x")]
    MinusX,
    /// The file's y: the scene's x, y, z are its z, x, y.
    #[serde(rename = "y")]
    Y,
    /// The file's -y: the scene's x, y, z are its z, -x, -y.
    #[serde(rename = "-y")]
    MinusY,
    /// The file's z: the file is not turned.
    #[default]
    #[serde(rename = "z")]
    Z,
    /// The file's -z: the scene's x, y, z are its x, -y, -z.
    #[serde(rename = "-z")]
    MinusZ,
}

impl Up {
    /// A position of the file in the scene's axes.
    #[must_use]
    pub fn turned(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::X => [y, z, x],
            Self::MinusX => [y, -z, -x],
            Self::Y => [z, x, y],
            Self::MinusY => [z, -x, -y],
            Self::Z => [x, y, z],
            Self::MinusZ => [x, -y, -z],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Up;

    #[test]
    fn each_axis_becomes_z_and_no_frame_is_mirrored() {
        let axes = [
            (Up::X, [1.0, 0.0, 0.0]),
            (Up::MinusX, [-1.0, 0.0, 0.0]),
            (Up::Y, [0.0, 1.0, 0.0]),
            (Up::MinusY, [0.0, -1.0, 0.0]),
            (Up::Z, [0.0, 0.0, 1.0]),
            (Up::MinusZ, [0.0, 0.0, -1.0]),
        ];
        for (up, axis) in axes {
            assert_eq!(up.turned(axis), [0.0, 0.0, 1.0], "{up:?}");
            let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| up.turned(e));
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            assert_eq!(cross, c, "{up:?}");
        }
    }
}
