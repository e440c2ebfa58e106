//! The quantities that `--columns` assigns to columns.

use super::layout::{Layout, Position, Powers, Rotation, Size};

/// A quantity of a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Position,
    SemiAxes,
    Diameters,
    Radius,
    Diameter,
    Exponents,
    Blockiness,
    Quaternion,
    /// Angles about these axes (0 = x), in degrees or radians.
    Euler([usize; 3], bool),
    Color,
    Id,
}

/// The quantities, for messages.
pub(super) const LIST: &str = "position (x,y,z), semi-axes (a,b,c), diameters (3), radius (1), diameter (1), exponents (e,n), \
                    blockiness (n1,n2), quaternion (w,x,y,z), euler-zyx-deg or -rad (3 angles; any axes), \
                    color (r,g,b of 0..1 or 0..255), id (1)";

impl Quantity {
    /// The quantity of a name.
    pub(super) fn by_name(name: &str) -> Option<Self> {
        Some(match name {
            "position" => Self::Position,
            "semi-axes" => Self::SemiAxes,
            "diameters" => Self::Diameters,
            "radius" => Self::Radius,
            "diameter" => Self::Diameter,
            "exponents" => Self::Exponents,
            "blockiness" => Self::Blockiness,
            "quaternion" => Self::Quaternion,
            "color" => Self::Color,
            "id" => Self::Id,
            _ => return Self::euler(name),
        })
    }

    /// Angles about three axes, each other than the one before: `euler-zyx-deg`.
    fn euler(name: &str) -> Option<Self> {
        let (axes, unit) = name.strip_prefix("euler-")?.split_once('-')?;
        let degrees = match unit {
            "deg" => true,
            "rad" => false,
            _ => return None,
        };
        let axes: Option<Vec<usize>> = axes.chars().map(|axis| "xyz".find(axis)).collect();
        let axes: [usize; 3] = axes?.try_into().ok()?;
        (axes[0] != axes[1] && axes[1] != axes[2]).then_some(Self::Euler(axes, degrees))
    }

    /// The number of its columns.
    pub(super) fn count(self) -> usize {
        match self {
            Self::Radius | Self::Diameter | Self::Id => 1,
            Self::Exponents | Self::Blockiness => 2,
            Self::Position | Self::SemiAxes | Self::Diameters | Self::Euler(..) | Self::Color => 3,
            Self::Quaternion => 4,
        }
    }

    /// A property that two quantities of one map may not both give.
    pub(super) fn subject(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::SemiAxes | Self::Diameters | Self::Radius | Self::Diameter => "size",
            Self::Exponents | Self::Blockiness => "exponents",
            Self::Quaternion | Self::Euler(..) => "rotation",
            Self::Color => "colour",
            Self::Id => "id",
        }
    }
}

/// Sets the columns of a quantity, as many as it has.
pub(super) fn set(layout: &mut Layout, quantity: Quantity, columns: &[usize]) {
    match (quantity, columns) {
        (Quantity::Position, &[x, y, z]) => layout.position = Position::Plain([x, y, z]),
        (Quantity::SemiAxes, &[a, b, c]) => layout.size = Size::SemiAxes([a, b, c]),
        (Quantity::Diameters, &[a, b, c]) => layout.size = Size::Diameters([a, b, c]),
        (Quantity::Radius, &[radius]) => layout.size = Size::Radius(radius),
        (Quantity::Diameter, &[diameter]) => layout.size = Size::Diameter(diameter),
        (Quantity::Exponents, &[e, n]) => layout.powers = Powers::Exponents([e, n]),
        (Quantity::Blockiness, &[n1, n2]) => layout.powers = Powers::Blockiness([n1, n2]),
        (Quantity::Quaternion, &[w, x, y, z]) => layout.rotation = Rotation::Quaternion([w, x, y, z]),
        (Quantity::Euler(axes, degrees), &[a, b, c]) => {
            layout.rotation = Rotation::Euler { columns: [a, b, c], axes, degrees };
        }
        (Quantity::Color, &[r, g, b]) => layout.color = Some([r, g, b]),
        (Quantity::Id, &[id]) => layout.id = Some(id),
        (_, _) => {}
    }
}
