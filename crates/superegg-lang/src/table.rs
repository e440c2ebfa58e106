//! The one table of commands.

use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, TransformStep};
use superegg_scene::{Camera, Light, MAX_DEPTH, MaterialShare, Patches};

use crate::command::Command;

/// Where help lists a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Files, help, leaving.
    Session,
    /// Primitives and their surfaces.
    Primitives,
    /// Objects and their children.
    Objects,
    /// Lights, camera, background, depth.
    Scene,
}

/// What must be selected for a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing.
    Nothing,
    /// A primitive.
    Primitive,
    /// An object.
    Object,
}

/// The numbers that an argument may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Any finite number.
    Any,
    /// Above 0.
    Positive,
    /// 0 or above.
    NonNegative,
    /// Any but 0.
    NonZero,
    /// Between two numbers, both included.
    Within(f64, f64),
    /// Between two numbers, neither included.
    Between(f64, f64),
    /// A whole number between two, both included.
    Whole(u32, u32),
}

impl Range {
    /// Whether a finite number is in the range.
    pub fn contains(self, x: f64) -> bool {
        match self {
            Self::Any => true,
            Self::Positive => x > 0.0,
            Self::NonNegative => x >= 0.0,
            Self::NonZero => x != 0.0,
            Self::Within(least, most) => (least..=most).contains(&x),
            Self::Between(least, most) => least < x && x < most,
            Self::Whole(least, most) => x.fract() == 0.0 && (f64::from(least)..=f64::from(most)).contains(&x),
        }
    }

    /// The range in words: "x must be ...".
    pub fn describe(self) -> String {
        match self {
            Self::Any => "any number".to_owned(),
            Self::Positive => "above 0".to_owned(),
            Self::NonNegative => "0 or above".to_owned(),
            Self::NonZero => "other than 0".to_owned(),
            Self::Within(least, most) => format!("from {least} to {most}"),
            Self::Between(least, most) => format!("above {least} and below {most}"),
            Self::Whole(least, most) => format!("a whole number from {least} to {most}"),
        }
    }
}

/// What an argument is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArgKind {
    /// A number.
    Number(Range),
    /// A name: any word.
    Name,
    /// A file: any word.
    File,
    /// Any number of words, none included. Only as the last argument.
    Words,
}

/// One argument.
#[derive(Clone, Copy, Debug)]
pub struct Arg {
    /// What help calls it.
    pub name: &'static str,
    /// What it may be.
    pub kind: ArgKind,
}

/// One command: what it is called, what it takes, what it does.
#[derive(Debug)]
pub struct CommandSpec {
    /// The full name.
    pub name: &'static str,
    /// The other spellings.
    pub spellings: &'static [&'static str],
    /// Where help lists it.
    pub group: Group,
    /// What must be selected.
    pub needs: Needs,
    /// The arguments, in parts: the first part is required, and each further one may be left out with all that follow.
    pub args: &'static [&'static [Arg]],
    /// What it does, in one line.
    pub summary: &'static str,
    /// What holds where a scene does not say it, or "".
    pub default: &'static str,
    /// A line that can be typed.
    pub example: &'static str,
    /// The command from arguments that fit `args`.
    pub(crate) build: fn(&Args<'_>) -> Command,
}

impl CommandSpec {
    /// The name and the other spellings.
    pub fn all_spellings(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.name).chain(self.spellings.iter().copied())
    }

    /// All arguments, required or not.
    pub fn all_args(&self) -> impl Iterator<Item = &'static Arg> {
        self.args.iter().copied().flatten()
    }

    /// Whether any number of words may follow.
    pub fn is_variadic(&self) -> bool {
        self.all_args().last().is_some_and(|arg| arg.kind == ArgKind::Words)
    }

    /// The numbers of arguments that it may have (without those of a variadic one).
    pub fn counts(&self) -> Vec<usize> {
        let mut counts = Vec::new();
        let mut total = 0;
        for part in self.args {
            total += part.len();
            counts.push(total);
        }
        counts
    }

    /// The arguments as help writes them: `NAME x y z [r g b [k]]`.
    pub fn usage(&self) -> String {
        let mut words = String::new();
        for (depth, part) in self.args.iter().enumerate() {
            for (i, arg) in part.iter().enumerate() {
                let open = if depth > 0 && i == 0 { "[" } else { "" };
                let dots = if arg.kind == ArgKind::Words { " ..." } else { "" };
                let gap = if words.is_empty() { "" } else { " " };
                words.push_str(&format!("{gap}{open}{}{dots}", arg.name));
            }
        }
        words.push_str(&"]".repeat(self.args.len().saturating_sub(1)));
        words
    }
}

/// Arguments that fit a command's table row.
pub(crate) struct Args<'a> {
    pub(crate) words: Vec<&'a str>,
    pub(crate) numbers: Vec<f64>,
}

impl Args<'_> {
    fn text(&self, i: usize) -> String {
        self.words[i].to_owned()
    }

    fn optional_text(&self, i: usize) -> Option<String> {
        self.words.get(i).map(|&word| word.to_owned())
    }

    fn texts(&self) -> Vec<String> {
        self.words.iter().map(|&word| word.to_owned()).collect()
    }

    fn number(&self, i: usize) -> f64 {
        self.numbers[i]
    }

    fn vector(&self, i: usize) -> DVec3 {
        DVec3::from_slice(&self.numbers[i..i + 3])
    }

    fn optional_vector(&self, i: usize) -> Option<DVec3> {
        (self.numbers.len() >= i + 3).then(|| self.vector(i))
    }

    fn whole(&self, i: usize) -> u32 {
        self.numbers[i] as u32
    }

    fn rotation(&self) -> TransformStep {
        TransformStep::Rotate { axis: self.vector(0), angle_deg: self.number(3) }
    }
}

const fn number(name: &'static str, range: Range) -> Arg {
    Arg { name, kind: ArgKind::Number(range) }
}

const NAME: Arg = Arg { name: "NAME", kind: ArgKind::Name };
const ALIAS: Arg = Arg { name: "ALIAS", kind: ArgKind::Name };
const FILE: Arg = Arg { name: "FILE", kind: ArgKind::File };
const UNIT: Range = Range::Within(0.0, 1.0);
const VECTOR: &[Arg] = &[number("x", Range::Any), number("y", Range::Any), number("z", Range::Any)];
const FACTORS: &[Arg] =
    &[number("x", Range::NonZero), number("y", Range::NonZero), number("z", Range::NonZero)];
const TURN: &[Arg] = &[
    number("x", Range::Any),
    number("y", Range::Any),
    number("z", Range::Any),
    number("degrees", Range::Any),
];
const COLOR: &[Arg] = &[number("r", UNIT), number("g", UNIT), number("b", UNIT)];
const RADIANCE: &[Arg] =
    &[number("r", Range::NonNegative), number("g", Range::NonNegative), number("b", Range::NonNegative)];
const SHARE: &[Arg] = &[number("share", UNIT)];

/// A command that sets one share of the selected primitive's material.
macro_rules! share {
    ($name:literal, $spelling:literal, $share:ident, $summary:literal, $default:literal) => {
        CommandSpec {
            name: $name,
            spellings: &[$spelling],
            group: Group::Primitives,
            needs: Needs::Primitive,
            args: &[SHARE],
            summary: $summary,
            default: $default,
            example: concat!($spelling, " 0.4"),
            build: |args| Command::SetShare(MaterialShare::$share, args.number(0)),
        }
    };
}

/// Every command of the language.
pub const COMMANDS: &[CommandSpec] = &[
    CommandSpec {
        name: "help",
        spellings: &[],
        group: Group::Session,
        needs: Needs::Nothing,
        args: &[&[], &[Arg { name: "COMMAND", kind: ArgKind::Words }]],
        summary: "lists the commands, or explains those named",
        default: "",
        example: "help setColor",
        build: |args| Command::Help(args.texts()),
    },
    CommandSpec {
        name: "stop",
        spellings: &["quit", "exit"],
        group: Group::Session,
        needs: Needs::Nothing,
        args: &[],
        summary: "leaves; in a file, the rest of it is not read",
        default: "",
        example: "stop",
        build: |_| Command::Stop,
    },
    CommandSpec {
        name: "info",
        spellings: &["ls"],
        group: Group::Session,
        needs: Needs::Nothing,
        args: &[&[], &[Arg { name: "NAME", kind: ArgKind::Words }]],
        summary: "lists what there is, or shows the details of what is named; 'all' and 'selected' are names too",
        default: "",
        example: "info selected",
        build: |args| Command::Info(args.texts()),
    },
    CommandSpec {
        name: "interact",
        spellings: &[],
        group: Group::Session,
        needs: Needs::Nothing,
        args: &[],
        summary: "hands the keyboard to the viewer",
        default: "",
        example: "interact",
        build: |_| Command::Interact,
    },
    CommandSpec {
        name: "source",
        spellings: &["load"],
        group: Group::Session,
        needs: Needs::Nothing,
        args: &[&[], &[FILE]],
        summary: "clears the scene, then runs a file",
        default: "the quicksave, data/quicksave.scn",
        example: "source robot.scn",
        build: |args| Command::Source(args.optional_text(0)),
    },
    CommandSpec {
        name: "save",
        spellings: &[],
        group: Group::Session,
        needs: Needs::Nothing,
        args: &[&[], &[FILE]],
        summary: "writes the scene to a file, as commands",
        default: "the quicksave, data/quicksave.scn",
        example: "save robot.scn",
        build: |args| Command::Save(args.optional_text(0)),
    },
    CommandSpec {
        name: "deselect",
        spellings: &[],
        group: Group::Session,
        needs: Needs::Nothing,
        args: &[],
        summary: "selects nothing",
        default: "",
        example: "deselect",
        build: |_| Command::Deselect,
    },
    CommandSpec {
        name: "primitive",
        spellings: &["prm"],
        group: Group::Primitives,
        needs: Needs::Nothing,
        args: &[&[NAME]],
        summary: "selects a primitive, making it if it is new",
        default: "a new one is a white sphere of radius 1",
        example: "primitive ball",
        build: |args| Command::Primitive(args.text(0)),
    },
    CommandSpec {
        name: "setCoeff",
        spellings: &["coeff"],
        group: Group::Primitives,
        needs: Needs::Primitive,
        args: &[&[number("x", Range::Positive), number("y", Range::Positive), number("z", Range::Positive)]],
        summary: "sets the semi-axes",
        default: "1 1 1",
        example: "setCoeff 2 1 0.5",
        build: |args| Command::SetRadii(args.vector(0)),
    },
    CommandSpec {
        name: "setExponent",
        spellings: &["exponent", "exp"],
        group: Group::Primitives,
        needs: Needs::Primitive,
        args: &[&[number("e", Range::Positive), number("n", Range::Positive)]],
        summary: "sets the exponents: e shapes the xy plane, n the z direction; 1 is round, near 0 square, 2 pointed",
        default: "1 1",
        example: "setExponent 0.1 1",
        build: |args| Command::SetExponents(Exponents { e: args.number(0), n: args.number(1) }),
    },
    CommandSpec {
        name: "setPatch",
        spellings: &["patch"],
        group: Group::Primitives,
        needs: Needs::Primitive,
        args: &[&[number("u", Range::Whole(1, u32::MAX)), number("v", Range::Whole(1, u32::MAX))]],
        summary: "sets how many patches the preview has around and from pole to pole",
        default: "15 15",
        example: "setPatch 30 20",
        build: |args| Command::SetPatches(Patches { u: args.whole(0), v: args.whole(1) }),
    },
    CommandSpec {
        name: "setColor",
        spellings: &["color", "surface"],
        group: Group::Primitives,
        needs: Needs::Primitive,
        args: &[COLOR],
        summary: "sets the base colour, in linear values",
        default: "1 1 1",
        example: "setColor 0.8 0.2 0.1",
        build: |args| Command::SetColor(args.vector(0)),
    },
    share!("setAmbient", "ambient", Ambient, "sets the share of ambient light", "0.1"),
    share!(
        "setReflected",
        "reflected",
        Reflected,
        "sets the share of mirrored light; only what is set mirrors",
        "nothing is mirrored"
    ),
    share!(
        "setRefracted",
        "refracted",
        Refracted,
        "sets the share of light let through; only what is set does so",
        "nothing is let through"
    ),
    share!("setGloss", "gloss", Gloss, "sets the roughness of the highlight: smaller is sharper", "0.3"),
    share!("setDiffuse", "diffuse", Diffuse, "sets the diffuse share", "0.8"),
    share!("setSpecular", "specular", Specular, "sets the share of the highlight", "0.1"),
    CommandSpec {
        name: "setIndex",
        spellings: &["index"],
        group: Group::Primitives,
        needs: Needs::Primitive,
        args: &[&[number("index", Range::Within(1.0, 4.0))]],
        summary: "sets the index of refraction: water 1.33, glass 1.5, diamond 2.4",
        default: "1.5",
        example: "setIndex 1.33",
        build: |args| Command::SetIndex(args.number(0)),
    },
    CommandSpec {
        name: "setShininess",
        spellings: &["shininess"],
        group: Group::Primitives,
        needs: Needs::Primitive,
        args: &[&[number("exponent", Range::NonNegative)]],
        summary: "sets the exponent of the highlight, instead of what gloss gives",
        default: "2 / gloss^2 - 2",
        example: "setShininess 80",
        build: |args| Command::SetShininess(args.number(0)),
    },
    CommandSpec {
        name: "object",
        spellings: &["obj"],
        group: Group::Objects,
        needs: Needs::Nothing,
        args: &[&[NAME]],
        summary: "selects an object, making it if it is new",
        default: "a new one is empty",
        example: "object snowman",
        build: |args| Command::Object(args.text(0)),
    },
    CommandSpec {
        name: "translateAll",
        spellings: &["xall"],
        group: Group::Objects,
        needs: Needs::Object,
        args: &[VECTOR],
        summary: "moves the object as a whole, after all that was done to it before",
        default: "",
        example: "translateAll 0 0 -2",
        build: |args| Command::TransformWhole(TransformStep::Translate(args.vector(0))),
    },
    CommandSpec {
        name: "rotateAll",
        spellings: &["rall"],
        group: Group::Objects,
        needs: Needs::Object,
        args: &[TURN],
        summary: "turns the object as a whole about an axis through the origin, right-handed",
        default: "",
        example: "rotateAll 0 0 1 90",
        build: |args| Command::TransformWhole(args.rotation()),
    },
    CommandSpec {
        name: "scaleAll",
        spellings: &["sall"],
        group: Group::Objects,
        needs: Needs::Object,
        args: &[FACTORS],
        summary: "scales the object as a whole; a negative factor mirrors",
        default: "",
        example: "scaleAll 2 2 2",
        build: |args| Command::TransformWhole(TransformStep::Scale(args.vector(0))),
    },
    CommandSpec {
        name: "addObject",
        spellings: &["ao"],
        group: Group::Objects,
        needs: Needs::Object,
        args: &[&[NAME], &[ALIAS]],
        summary: "adds an object, which may be the selected one itself, as a child; the cursor moves to it",
        default: "the alias is the name",
        example: "addObject arm left_arm",
        build: |args| Command::AddObject { target: args.text(0), alias: args.optional_text(1) },
    },
    CommandSpec {
        name: "addPrimitive",
        spellings: &["ap"],
        group: Group::Objects,
        needs: Needs::Object,
        args: &[&[NAME], &[ALIAS]],
        summary: "adds a primitive as a child; the cursor moves to it",
        default: "the alias is the name",
        example: "addPrimitive ball head",
        build: |args| Command::AddPrimitive { target: args.text(0), alias: args.optional_text(1) },
    },
    CommandSpec {
        name: "setCursor",
        spellings: &["cursor", "cur"],
        group: Group::Objects,
        needs: Needs::Object,
        args: &[&[ALIAS]],
        summary: "chooses the child that translate, rotate and scale move",
        default: "the child added last",
        example: "setCursor head",
        build: |args| Command::SetCursor(args.text(0)),
    },
    CommandSpec {
        name: "translate",
        spellings: &["xs"],
        group: Group::Objects,
        needs: Needs::Object,
        args: &[VECTOR],
        summary: "moves the child at the cursor, after all that was done to it before",
        default: "",
        example: "translate 0 0 1.5",
        build: |args| Command::TransformChild(TransformStep::Translate(args.vector(0))),
    },
    CommandSpec {
        name: "rotate",
        spellings: &["rs"],
        group: Group::Objects,
        needs: Needs::Object,
        args: &[TURN],
        summary: "turns the child at the cursor about an axis through the origin, right-handed",
        default: "",
        example: "rotate 1 0 0 30",
        build: |args| Command::TransformChild(args.rotation()),
    },
    CommandSpec {
        name: "scale",
        spellings: &["ss"],
        group: Group::Objects,
        needs: Needs::Object,
        args: &[FACTORS],
        summary: "scales the child at the cursor; a negative factor mirrors",
        default: "",
        example: "scale 1 1 0.5",
        build: |args| Command::TransformChild(TransformStep::Scale(args.vector(0))),
    },
    CommandSpec {
        name: "light",
        spellings: &[],
        group: Group::Scene,
        needs: Needs::Nothing,
        args: &[
            &[NAME, number("x", Range::Any), number("y", Range::Any), number("z", Range::Any)],
            RADIANCE,
            &[number("k", Range::NonNegative)],
        ],
        summary: "adds or replaces a light; at distance d it has fallen to 1 / (1 + k d^2)",
        default: "r g b 1 1 1, k 0; without any light, white at 3 4 5 with k 0.01",
        example: "light lamp 3 4 5 1 0.9 0.7 0.01",
        build: |args| {
            let light = Light {
                position: args.vector(0),
                color: args.optional_vector(3).unwrap_or(DVec3::ONE),
                falloff: args.numbers.get(6).copied().unwrap_or(0.0),
            };
            Command::SetLight(args.text(0), light)
        },
    },
    CommandSpec {
        name: "unlight",
        spellings: &[],
        group: Group::Scene,
        needs: Needs::Nothing,
        args: &[&[NAME]],
        summary: "takes a light away",
        default: "",
        example: "unlight lamp",
        build: |args| Command::RemoveLight(args.text(0)),
    },
    CommandSpec {
        name: "camera",
        spellings: &[],
        group: Group::Scene,
        needs: Needs::Nothing,
        args: &[
            &[
                number("px", Range::Any),
                number("py", Range::Any),
                number("pz", Range::Any),
                number("tx", Range::Any),
                number("ty", Range::Any),
                number("tz", Range::Any),
            ],
            &[number("fov_deg", Range::Between(0.0, 180.0))],
        ],
        summary: "places the camera and the point it looks at; the field of view is vertical, in degrees",
        default: "0 0 10 0 0 0 60; fov_deg is 60 unless given",
        example: "camera 6 -8 5 0 0 1 40",
        build: |args| {
            Command::SetCamera(Camera {
                position: args.vector(0),
                target: args.vector(3),
                fov_deg: args.numbers.get(6).copied().unwrap_or(Camera::DEFAULT_FOV_DEG),
                ..Camera::default()
            })
        },
    },
    CommandSpec {
        name: "cameraUp",
        spellings: &[],
        group: Group::Scene,
        needs: Needs::Nothing,
        args: &[VECTOR],
        summary: "sets the direction that goes up in the picture",
        default: "0 1 0",
        example: "cameraUp 0 0 1",
        build: |args| Command::SetCameraUp(args.vector(0)),
    },
    CommandSpec {
        name: "background",
        spellings: &[],
        group: Group::Scene,
        needs: Needs::Nothing,
        args: &[RADIANCE],
        summary: "sets the colour where nothing is, in linear values",
        default: "0 0 0",
        example: "background 0.2 0.3 0.5",
        build: |args| Command::SetBackground(args.vector(0)),
    },
    CommandSpec {
        name: "setDepth",
        spellings: &["depth"],
        group: Group::Scene,
        needs: Needs::Nothing,
        args: &[&[number("levels", Range::Whole(0, MAX_DEPTH))]],
        summary: "sets how deep objects are opened: the selected one is level 1, primitives of the last level included",
        default: "25",
        example: "setDepth 8",
        build: |args| Command::SetDepth(args.whole(0)),
    },
];

/// The command with this spelling, in any case.
pub fn find_command(word: &str) -> Option<&'static CommandSpec> {
    COMMANDS.iter().find(|spec| spec.all_spellings().any(|spelling| spelling.eq_ignore_ascii_case(word)))
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::parser::parse_line;

    #[test]
    fn no_two_commands_share_a_spelling() {
        let mut seen = HashSet::new();
        for spelling in COMMANDS.iter().flat_map(CommandSpec::all_spellings) {
            assert!(seen.insert(spelling.to_lowercase()), "{spelling} twice");
        }
    }

    #[test]
    fn every_row_is_complete_and_its_example_parses_to_itself() {
        for spec in COMMANDS {
            assert!(!spec.summary.is_empty() && !spec.summary.ends_with('.'), "{}", spec.name);
            let parsed = parse_line(spec.example).unwrap().unwrap();
            assert_eq!(parsed.spec.name, spec.name, "{}", spec.example);
            for spelling in spec.all_spellings() {
                assert_eq!(find_command(&spelling.to_uppercase()).unwrap().name, spec.name);
            }
        }
    }

    #[test]
    fn words_come_last_and_only_there() {
        for spec in COMMANDS {
            let position = spec.all_args().position(|arg| arg.kind == ArgKind::Words);
            assert!(position.is_none_or(|p| p + 1 == spec.all_args().count()), "{}", spec.name);
        }
    }

    #[test]
    fn every_course_command_is_there_with_its_spellings() {
        let course = "help stop quit exit info ls interact source load save deselect Primitive primitive prm setCoeff coeff \
            setExponent exponent exp setPatch patch setColor color surface setAmbient ambient setReflected reflected setRefracted \
            refracted setGloss gloss setDiffuse diffuse setSpecular specular Object object obj translateAll rotateAll scaleAll xall \
            rall sall addObject addPrimitive ao ap setCursor cursor cur translate rotate scale xs rs ss";
        for word in course.split_whitespace() {
            assert!(find_command(word).is_some(), "{word}");
        }
    }

    #[test]
    fn usage_shows_what_may_be_left_out() {
        assert_eq!(find_command("light").unwrap().usage(), "NAME x y z [r g b [k]]");
        assert_eq!(find_command("help").unwrap().usage(), "[COMMAND ...]");
        assert_eq!(find_command("stop").unwrap().usage(), "");
    }
}
