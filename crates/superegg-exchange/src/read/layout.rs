//! The columns of a text file: which numbers of a row make a particle, and how they are understood.
//! Indices are those of the columns of the file.

/// The columns of a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Position {
    Plain([usize; 3]),
    /// Fractions of the edges of the simulation box.
    Scaled([usize; 3]),
}

/// The columns of a size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Size {
    SemiAxes([usize; 3]),
    Diameters([usize; 3]),
    Radius(usize),
    Diameter(usize),
    /// No column: points, shown as spheres.
    Point,
}

/// The columns of exponents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Powers {
    /// No column: e = n = 1.
    Round,
    /// e, n.
    Exponents([usize; 2]),
    /// n1, n2: n = 2/n1, e = 2/n2.
    Blockiness([usize; 2]),
    /// OVITO's phi, theta: e, n; 0 stands for 1.
    Roundness([usize; 2]),
}

/// The columns of a rotation from body to world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rotation {
    /// No column.
    Identity,
    /// w, x, y, z.
    Quaternion([usize; 4]),
    /// Three angles about `axes` (0 = x, 1 = y, 2 = z): R = R_first(a) R_second(b) R_third(c).
    Euler { columns: [usize; 3], axes: [usize; 3], degrees: bool },
}

/// The columns of a text file.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// The names of all columns.
    pub(super) names: Vec<String>,
    pub(super) id: Option<usize>,
    pub(super) position: Position,
    pub(super) size: Size,
    pub(super) powers: Powers,
    pub(super) rotation: Rotation,
    /// Red, green, blue.
    pub(super) color: Option<[usize; 3]>,
    /// Further columns that are kept.
    pub(super) extra: Vec<usize>,
    /// Whether rows of size 0 without rotation are points among the ellipsoids, and left out.
    pub(super) skips_points: bool,
}

impl Layout {
    /// The columns whose numbers are needed.
    pub(super) fn wanted(&self) -> Vec<bool> {
        let mut wanted = vec![false; self.names.len()];
        let mut want = |columns: &[usize]| columns.iter().for_each(|&column| wanted[column] = true);
        want(self.id.as_slice());
        want(&self.extra);
        if let Some(columns) = &self.color {
            want(columns);
        }
        match &self.position {
            Position::Plain(columns) | Position::Scaled(columns) => want(columns),
        }
        match &self.size {
            Size::SemiAxes(columns) | Size::Diameters(columns) => want(columns),
            Size::Radius(column) | Size::Diameter(column) => want(&[*column]),
            Size::Point => {}
        }
        match &self.powers {
            Powers::Round => {}
            Powers::Exponents(columns) | Powers::Blockiness(columns) | Powers::Roundness(columns) => {
                want(columns);
            }
        }
        match &self.rotation {
            Rotation::Identity => {}
            Rotation::Quaternion(columns) => want(columns),
            Rotation::Euler { columns, .. } => want(columns),
        }
        wanted
    }

    /// The names of columns, for messages: "'x', 'y', 'z'".
    pub(super) fn list(&self, columns: &[usize]) -> String {
        let names: Vec<String> = columns.iter().map(|&column| format!("'{}'", self.names[column])).collect();
        names.join(", ")
    }

    /// How the columns are understood, in one line.
    pub(super) fn reading(&self) -> String {
        let list = |columns: &[usize]| {
            let names: Vec<&str> = columns.iter().map(|&column| self.names[column].as_str()).collect();
            names.join(" ")
        };
        let size = match &self.size {
            Size::SemiAxes(columns) => format!("semi-axes from {}", list(columns)),
            Size::Diameters(columns) => format!("semi-axes as half of the diameters {}", list(columns)),
            Size::Radius(column) => format!("spheres of the radius {}", self.names[*column]),
            Size::Diameter(column) => format!("spheres of half of the diameter {}", self.names[*column]),
            Size::Point => "points as spheres".to_owned(),
        };
        let powers = match &self.powers {
            Powers::Round => String::new(),
            Powers::Exponents([e, n]) => {
                format!("; exponents e = {}, n = {}", self.names[*e], self.names[*n])
            }
            Powers::Blockiness([n1, n2]) => {
                format!("; exponents e = 2/{}, n = 2/{}", self.names[*n2], self.names[*n1])
            }
            Powers::Roundness([phi, theta]) => {
                format!("; exponents e = {}, n = {} (0 as 1)", self.names[*phi], self.names[*theta])
            }
        };
        let rotation = match &self.rotation {
            Rotation::Identity => String::new(),
            Rotation::Quaternion(columns) => format!("; rotation w x y z from {}", list(columns)),
            Rotation::Euler { columns, axes, degrees } => {
                let [a, b, c] = axes.map(|axis| ["x", "y", "z"][axis]);
                let unit = if *degrees { "degrees" } else { "radians" };
                format!("; rotation R{a} R{b} R{c} by {} in {unit}", list(columns))
            }
        };
        let scaled = match &self.position {
            Position::Plain(_) => String::new(),
            Position::Scaled(columns) => format!("; positions {} as fractions of the box", list(columns)),
        };
        format!("{size}{powers}{rotation}{scaled}")
    }
}

/// The names of columns, to be looked up.
#[derive(Clone, Copy)]
pub(super) struct Names<'a>(pub(super) &'a [String]);

impl Names<'_> {
    /// The column of a name: exactly as written, or else in any case.
    pub(super) fn one(self, name: &str) -> Option<usize> {
        let exact = self.0.iter().position(|held| held == name);
        exact.or_else(|| self.0.iter().position(|held| held.eq_ignore_ascii_case(name)))
    }

    /// The columns of names, if all are there.
    pub(super) fn all<const N: usize>(self, names: [&str; N]) -> Option<[usize; N]> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.one(name)?;
        }
        Some(columns)
    }

    /// The columns of the first list of names of which all are there.
    pub(super) fn any<const N: usize>(self, lists: &[[&str; N]]) -> Option<[usize; N]> {
        lists.iter().find_map(|names| self.all(*names))
    }

    /// The further columns that the options ask for.
    ///
    /// # Errors
    /// A message with the names of the file for any other name.
    pub(super) fn extra(self, names: &[String], all: bool) -> Result<Vec<usize>, (String, String)> {
        let mut columns: Vec<usize> = if all { (0..self.0.len()).collect() } else { Vec::new() };
        for name in names {
            let Some(column) = self.one(name) else {
                let message = format!("there is no such column; the file has: {}", self.0.join(", "));
                return Err((name.clone(), message));
            };
            if !columns.contains(&column) {
                columns.push(column);
            }
        }
        Ok(columns)
    }
}
