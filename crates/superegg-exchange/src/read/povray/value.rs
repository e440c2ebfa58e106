//! Values of POV-Ray's expressions.

use superegg_geom::glam::DVec3;

/// A number, or a vector of 2 to 5 numbers: colours have red, green, blue, filter and transmit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Vector { numbers: [f64; 5], length: usize },
}

impl Value {
    pub(crate) fn vector(v: DVec3) -> Self {
        Self::Vector { numbers: [v.x, v.y, v.z, 0.0, 0.0], length: 3 }
    }

    /// The number; the first component of a vector.
    pub(crate) fn number(self) -> f64 {
        match self {
            Self::Number(number) => number,
            Self::Vector { numbers, .. } => numbers[0],
        }
    }

    /// Five components: a number stands for each of them.
    pub(crate) fn five(self) -> [f64; 5] {
        match self {
            Self::Number(number) => [number; 5],
            Self::Vector { numbers, .. } => numbers,
        }
    }

    /// Three components: a number stands for each of them.
    pub(crate) fn three(self) -> DVec3 {
        DVec3::from_slice(&self.five())
    }

    /// Combines component by component.
    pub(crate) fn with(self, other: Self, combine: impl Fn(f64, f64) -> f64) -> Self {
        let length = match (self, other) {
            (Self::Number(a), Self::Number(b)) => return Self::Number(combine(a, b)),
            (Self::Vector { length, .. }, Self::Number(_))
            | (Self::Number(_), Self::Vector { length, .. }) => length,
            (Self::Vector { length: a, .. }, Self::Vector { length: b, .. }) => a.max(b),
        };
        let (a, b) = (self.five(), other.five());
        let mut numbers = [0.0; 5];
        for index in 0..length {
            numbers[index] = combine(a[index], b[index]);
        }
        Self::Vector { numbers, length }
    }

    /// The component of this name: `.x`, `.red`.
    pub(crate) fn component(self, name: &str) -> Option<f64> {
        let index = match name {
            "x" | "u" | "red" => 0,
            "y" | "v" | "green" => 1,
            "z" | "blue" => 2,
            "t" | "filter" => 3,
            "transmit" => 4,
            _ => return None,
        };
        Some(self.five()[index])
    }
}

/// The colour of a name of POV-Ray's `colors.inc`: the basic ones, and greys in steps of 5 percent.
pub(crate) fn named_color(name: &str) -> Option<Value> {
    let [red, green, blue] = match name {
        "White" => [1.0, 1.0, 1.0],
        "Black" => [0.0, 0.0, 0.0],
        "Red" => [1.0, 0.0, 0.0],
        "Green" => [0.0, 1.0, 0.0],
        "Blue" => [0.0, 0.0, 1.0],
        "Yellow" => [1.0, 1.0, 0.0],
        "Cyan" => [0.0, 1.0, 1.0],
        "Magenta" => [1.0, 0.0, 1.0],
        "Orange" => [1.0, 0.5, 0.0],
        "Gray" | "Grey" => [0.752_941; 3],
        "LightGray" | "LightGrey" => [0.658_824; 3],
        "DimGray" | "DimGrey" => [0.329_412; 3],
        "VLightGray" | "VLightGrey" => [0.8; 3],
        "Brown" => [0.647_059, 0.164_706, 0.164_706],
        "Pink" => [0.737_255, 0.560_784, 0.560_784],
        "Gold" => [0.8, 0.498_039, 0.196_078],
        "Silver" => [0.90, 0.91, 0.98],
        "Navy" => [0.137_255, 0.137_255, 0.556_863],
        "SkyBlue" => [0.196_078, 0.6, 0.8],
        "Turquoise" => [0.678_431, 0.917_647, 0.917_647],
        "Violet" => [0.309_804, 0.184_314, 0.309_804],
        "Maroon" => [0.556_863, 0.137_255, 0.419_608],
        other => {
            let percent = other.strip_prefix("Gray").or_else(|| other.strip_prefix("Grey"))?;
            let percent: u8 = percent.parse().ok().filter(|percent| percent % 5 == 0 && *percent < 100)?;
            [f64::from(percent) / 100.0; 3]
        }
    };
    Some(Value::Vector { numbers: [red, green, blue, 0.0, 0.0], length: 5 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_for_each_component() {
        let v = Value::vector(DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(v.with(Value::Number(2.0), |a, b| a * b).three(), DVec3::new(2.0, 4.0, 6.0));
        assert_eq!(Value::Number(1.5).three(), DVec3::splat(1.5));
        assert_eq!(v.component("z"), Some(3.0));
        assert_eq!(v.component("w"), None);
        assert_eq!(named_color("Gray35").unwrap().three(), DVec3::splat(0.35));
        assert!(named_color("Gray7").is_none() && named_color("mauve").is_none());
    }
}
