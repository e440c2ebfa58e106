//! The parameters of one superquadric as other programs name and order them. docs/formats.md says
//! where the conventions come from.

use superegg_geom::Exponents;
use superegg_geom::glam::{DQuat, DVec3, EulerRot};

/// How a program writes a superquadric.
#[derive(Clone, Copy, Debug)]
pub struct Convention {
    /// The name of the convention.
    pub name: &'static str,
    sizes: Sizes,
    exponents: ExponentPair,
    rotation: RotationNumbers,
    /// Whether the rotation leads from world to body.
    from_world: bool,
    order: Order,
}

/// The order of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// Sizes, exponents, rotation, centre.
    SizesFirst,
    /// Exponents, sizes, rotation, centre.
    ExponentsFirst,
    /// Sizes, exponents, centre, rotation.
    RotationLast,
}

#[derive(Clone, Copy, Debug)]
enum Sizes {
    SemiAxes([&'static str; 3]),
    Diameters([&'static str; 3]),
}

#[derive(Clone, Copy, Debug)]
enum ExponentPair {
    /// e, n.
    EastNorth([&'static str; 2]),
    /// n, e.
    NorthEast([&'static str; 2]),
    /// 2/n, 2/e.
    Blockiness([&'static str; 2]),
}

#[derive(Clone, Copy, Debug)]
enum RotationNumbers {
    /// A quaternion, w first.
    Scalar([&'static str; 4]),
    /// A quaternion, w last.
    ScalarLast([&'static str; 4]),
    /// Angles in radians: R = R_A R_B R_C.
    Euler(EulerRot, [&'static str; 3]),
}

const ABC: Sizes = Sizes::SemiAxes(["a", "b", "c"]);
const A123: Sizes = Sizes::SemiAxes(["a1", "a2", "a3"]);
const SHAPE_XYZ: [&str; 3] = ["shapex", "shapey", "shapez"];
const WXYZ: RotationNumbers = RotationNumbers::Scalar(["qw", "qx", "qy", "qz"]);
const NORTH_EAST: ExponentPair = ExponentPair::NorthEast(["e1", "e2"]);

/// The conventions, ours first.
pub const CONVENTIONS: [Convention; 14] = [
    own("superegg"),
    own("povray"),
    Convention {
        sizes: Sizes::SemiAxes(SHAPE_XYZ),
        exponents: ExponentPair::Blockiness(["blockiness1", "blockiness2"]),
        rotation: RotationNumbers::Scalar(["quat1", "quat2", "quat3", "quat4"]),
        ..own("liggghts")
    },
    Convention {
        sizes: Sizes::Diameters(SHAPE_XYZ),
        exponents: ExponentPair::Blockiness(["block1", "block2"]),
        rotation: RotationNumbers::Scalar(["quatw", "quati", "quatj", "quatk"]),
        ..own("lammps")
    },
    Convention {
        exponents: ExponentPair::EastNorth(["phi", "theta"]),
        rotation: RotationNumbers::ScalarLast(["qx", "qy", "qz", "qw"]),
        ..own("ovito")
    },
    Convention {
        sizes: Sizes::Diameters(["axis1", "axis2", "axis3"]),
        exponents: ExponentPair::EastNorth(["phi", "theta"]),
        ..own("mercurydpm")
    },
    Convention {
        sizes: Sizes::SemiAxes(["rx", "ry", "rz"]),
        exponents: ExponentPair::EastNorth(["eps1", "eps2"]),
        rotation: RotationNumbers::Scalar(["q0", "q1", "q2", "q3"]),
        ..own("sudodem")
    },
    Convention {
        sizes: A123,
        exponents: NORTH_EAST,
        rotation: RotationNumbers::Euler(EulerRot::ZYX, ["eul_z", "eul_y", "eul_x"]),
        order: Order::ExponentsFirst,
        ..own("ems")
    },
    Convention { exponents: NORTH_EAST, ..own("superdec") },
    Convention { sizes: A123, exponents: NORTH_EAST, from_world: true, ..own("superquadric-parsing") },
    Convention {
        sizes: A123,
        exponents: NORTH_EAST,
        rotation: RotationNumbers::Euler(EulerRot::ZYZ, ["eul_z", "eul_y", "eul_z2"]),
        order: Order::RotationLast,
        ..own("superquadric-lib")
    },
    Convention {
        sizes: A123,
        exponents: ExponentPair::NorthEast(["eps1", "eps2"]),
        rotation: RotationNumbers::Euler(EulerRot::XYZ, ["roll", "pitch", "yaw"]),
        ..own("sage")
    },
    Convention { exponents: ExponentPair::NorthEast(["phi_roundness", "theta_roundness"]), ..own("vtk") },
    Convention { exponents: ExponentPair::NorthEast(["phi_roundness", "theta_roundness"]), ..own("pyvista") },
];

/// Our convention under a name.
const fn own(name: &'static str) -> Convention {
    Convention {
        name,
        sizes: ABC,
        exponents: ExponentPair::EastNorth(["e", "n"]),
        rotation: WXYZ,
        from_world: false,
        order: Order::SizesFirst,
    }
}

impl Convention {
    /// The convention of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        CONVENTIONS.into_iter().find(|convention| convention.name == name)
    }

    /// The parameters of a superquadric under their names: sizes, exponents, rotation, and the centre as
    /// x, y, z.
    ///
    /// ```
    /// use superegg_exchange::write::convention::Convention;
    /// use superegg_geom::glam::{DQuat, DVec3};
    /// use superegg_geom::{Exponents, ShapeError};
    ///
    /// let exponents = Exponents::new(1.0, 0.25)?;
    /// let liggghts = Convention::by_name("liggghts").unwrap();
    /// let parameters = liggghts.parameters(DVec3::ONE, exponents, DQuat::IDENTITY, DVec3::X);
    /// assert_eq!(parameters[3..5], [("blockiness1", 8.0), ("blockiness2", 2.0)]);
    /// # Ok::<(), ShapeError>(())
    /// ```
    pub fn parameters(
        &self,
        radii: DVec3,
        exponents: Exponents,
        rotation: DQuat,
        center: DVec3,
    ) -> Vec<(&'static str, f64)> {
        let sizes = match self.sizes {
            Sizes::SemiAxes(names) => named(names, radii.to_array()),
            Sizes::Diameters(names) => named(names, (2.0 * radii).to_array()),
        };
        let (e, n) = (exponents.e(), exponents.n());
        let exponents = match self.exponents {
            ExponentPair::EastNorth(names) => named(names, [e, n]),
            ExponentPair::NorthEast(names) => named(names, [n, e]),
            ExponentPair::Blockiness(names) => named(names, [2.0 / n, 2.0 / e]),
        };
        let rotation = if self.from_world { rotation.inverse() } else { rotation };
        let [x, y, z, w] = rotation.to_array();
        let rotation = match self.rotation {
            RotationNumbers::Scalar(names) => named(names, [w, x, y, z]),
            RotationNumbers::ScalarLast(names) => named(names, [x, y, z, w]),
            RotationNumbers::Euler(order, names) => named(names, rotation.to_euler(order).into()),
        };
        let center = named(["x", "y", "z"], center.to_array());
        match self.order {
            Order::SizesFirst => [sizes, exponents, rotation, center],
            Order::ExponentsFirst => [exponents, sizes, rotation, center],
            Order::RotationLast => [sizes, exponents, center, rotation],
        }
        .concat()
    }
}

fn named<const N: usize>(names: [&'static str; N], numbers: [f64; N]) -> Vec<(&'static str, f64)> {
    names.into_iter().zip(numbers).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_make_the_shape_again() {
        let (radii, center) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0));
        let exponents = Exponents::new(0.5, 1.25).unwrap();
        let rotation = DQuat::from_xyzw(0.1, -0.5, 0.3, 0.7).normalize();
        for convention in CONVENTIONS {
            let parameters = convention.parameters(radii, exponents, rotation, center);
            let number = |name| parameters.iter().find(|(known, _)| *known == name).unwrap().1;
            let (factor, names) = match convention.sizes {
                Sizes::SemiAxes(names) => (1.0, names),
                Sizes::Diameters(names) => (2.0, names),
            };
            assert_eq!(names.map(number), (factor * radii).to_array());
            let again = match convention.rotation {
                RotationNumbers::Scalar(names) => {
                    let [w, x, y, z] = names.map(number);
                    DQuat::from_xyzw(x, y, z, w)
                }
                RotationNumbers::ScalarLast(names) => DQuat::from_array(names.map(number)),
                RotationNumbers::Euler(order, names) => {
                    let [first, second, third] = names.map(number);
                    DQuat::from_euler(order, first, second, third)
                }
            };
            let again = if convention.from_world { again.inverse() } else { again };
            assert!(again.dot(rotation).abs() > 1.0 - 1e-12, "{convention:?}");
            assert_eq!(["x", "y", "z"].map(number), center.to_array());
        }
        // The orders of the files of these programs.
        for (name, order) in [
            ("ems", "e1 e2 a1 a2 a3 eul_z eul_y eul_x x y z"),
            ("superquadric-lib", "a1 a2 a3 e1 e2 x y z eul_z eul_y eul_z2"),
            ("superegg", "a b c e n qw qx qy qz x y z"),
        ] {
            let convention = Convention::by_name(name).unwrap();
            let parameters = convention.parameters(radii, exponents, rotation, center);
            let names: Vec<&str> = parameters.iter().map(|(name, _)| *name).collect();
            assert_eq!(names.join(" "), order);
        }
        assert!(Convention::by_name("nobody").is_none());
    }
}
