//! The parts of a row of the command table: names, arguments, ranges.

use std::borrow::Cow;

use smallvec::SmallVec;
use superegg_geom::TransformStep;
use superegg_geom::glam::{DAffine3, DMat3, DQuat, DVec3};
use superegg_scene::Picture;

use crate::color::parse_color;
use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::command::{
    Command, Needs, ObjectCommand, PrimitiveCommand, Request, SceneCommand, SessionCommand,
};

/// The section of the help that lists a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Help, contents of the scene, leaving.
    Session,
    /// Undo and redo, and changes by name.
    Editing,
    /// Scene files and folders.
    Files,
    /// Primitives and their materials.
    Primitives,
    /// Objects and their children.
    Objects,
    /// Lights, camera, environment, recursion depth.
    Scene,
    /// Keys.
    Animation,
    /// Rendering, viewing, tests, settings.
    Pictures,
}

impl Group {
    /// Every group, in the order of the help.
    pub const ALL: [Self; 8] = [
        Self::Session,
        Self::Files,
        Self::Editing,
        Self::Primitives,
        Self::Objects,
        Self::Scene,
        Self::Animation,
        Self::Pictures,
    ];

    /// The word for the group: `help WORD` lists it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Session => "session",
            Self::Files => "files",
            Self::Editing => "editing",
            Self::Primitives => "primitives",
            Self::Objects => "objects",
            Self::Scene => "scene",
            Self::Animation => "animation",
            Self::Pictures => "pictures",
        }
    }

    /// The heading of the group.
    pub fn title(self) -> &'static str {
        match self {
            Self::Session => "Session",
            Self::Files => "Files",
            Self::Editing => "Editing",
            Self::Primitives => "Primitives",
            Self::Objects => "Objects",
            Self::Scene => "Light, camera, scene",
            Self::Animation => "Animation",
            Self::Pictures => "Pictures and tests",
        }
    }
}

/// The allowed numbers of an argument.
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
    /// From the first number to the second, both included.
    Within(f64, f64),
    /// Between the numbers, neither included.
    Between(f64, f64),
    /// Above the first number and at most the second.
    AboveTo(f64, f64),
    /// A whole number, both ends included.
    Whole(u32, u32),
}

impl Range {
    /// Whether the range contains a finite number.
    pub fn contains(self, x: f64) -> bool {
        match self {
            Self::Any => true,
            Self::Positive => x > 0.0,
            Self::NonNegative => x >= 0.0,
            Self::NonZero => x != 0.0,
            Self::Within(least, most) => (least..=most).contains(&x),
            Self::Between(least, most) => least < x && x < most,
            Self::AboveTo(least, most) => least < x && x <= most,
            Self::Whole(least, most) => x.fract() == 0.0 && (f64::from(least)..=f64::from(most)).contains(&x),
        }
    }

    /// The range in symbols, for hints: `>0`, `0..1`; empty for [`Range::Any`].
    pub fn brief(self) -> String {
        match self {
            Self::Any => String::new(),
            Self::Positive => ">0".to_owned(),
            Self::NonNegative => ">=0".to_owned(),
            Self::NonZero => "not 0".to_owned(),
            Self::Within(least, most) | Self::Between(least, most) | Self::AboveTo(least, most) => {
                format!("{least}..{most}")
            }
            Self::Whole(least, u32::MAX) => format!("{least}, {}, ...", least + 1),
            Self::Whole(least, most) => format!("{least}, {} .. {most}", least + 1),
        }
    }

    /// The range in words, to follow "must be": `above 0`.
    pub fn describe(self) -> String {
        match self {
            Self::Any => "any number".to_owned(),
            Self::Positive => "above 0".to_owned(),
            Self::NonNegative => "0 or above".to_owned(),
            Self::NonZero => "other than 0".to_owned(),
            Self::Within(least, most) => format!("from {least} to {most}"),
            Self::Between(least, most) => format!("above {least} and below {most}"),
            Self::AboveTo(least, most) => format!("above {least}, and {most} at most"),
            Self::Whole(least, most) => format!("a whole number from {least} to {most}"),
        }
    }
}

/// The kind of thing that a name argument names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NameKind {
    /// A new name.
    New,
    /// A primitive.
    Primitive,
    /// A primitive; created if it is new.
    PrimitiveOrNew,
    /// An object.
    Object,
    /// An object; created if it is new.
    ObjectOrNew,
    /// A primitive or an object.
    Entity,
    /// A child of the selected object.
    Child,
    /// A hidden child of the selected object.
    HiddenChild,
    /// A light.
    Light,
    /// A command.
    Command,
    /// A word that the help explains.
    HelpWord,
    /// A setting.
    Setting,
    /// A frame that has keys, or the word `all`.
    KeyFrame,
}

/// The type of an argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArgKind {
    /// A number.
    Number(Range),
    /// A name: any word.
    Name(NameKind),
    /// A file or folder: any word, or any text between double quotes.
    File,
    /// One of these words; case is ignored.
    Choice(&'static [&'static str]),
    /// An image size, for example 640x480, at any position among the arguments.
    Size,
    /// The value of the setting that the previous argument names.
    Value,
    /// Zero or more names. Only as the last argument.
    Words(NameKind),
    /// A keyable command with its arguments. Only as the second and last argument.
    Line,
}

/// One argument.
#[derive(Clone, Copy, Debug)]
pub struct Arg {
    /// The name of the argument in the help.
    pub name: &'static str,
    /// The type of the argument.
    pub kind: ArgKind,
    /// The words that may stand for this number and the next two.
    pub shorthand: Option<Shorthand>,
}

/// A kind of word that stands for three numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shorthand {
    /// A colour: `#ff8000`, `#f80`, or a name of CSS.
    Color,
    /// An axis: `x`, `y` or `z`, or with a sign `-x`, `-y` or `-z`.
    Axis,
}

impl Shorthand {
    /// The numbers of a word; `None` if the word is none of this kind.
    pub(crate) fn numbers_of(self, word: &str) -> Option<DVec3> {
        match self {
            Self::Color => parse_color(word),
            Self::Axis => {
                let axes = [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)];
                let (sign, letter) = match word.strip_prefix('-') {
                    Some(letter) => (-1.0, letter),
                    None => (1.0, word.strip_prefix('+').unwrap_or(word)),
                };
                let axis = axes.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(letter))?.1;
                // Adding 0 turns -0 into 0.
                Some(sign * axis + DVec3::ZERO)
            }
        }
    }
}

/// How a command is made from its arguments. The variant says what the command needs to be
/// selected.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Build {
    Session(fn(&Args<'_>) -> SessionCommand),
    Scene(fn(&Args<'_>) -> SceneCommand),
    Primitive(fn(&Args<'_>) -> PrimitiveCommand),
    Object(fn(&Args<'_>) -> ObjectCommand),
    Request(fn(&Args<'_>) -> Request),
}

impl Build {
    pub(crate) fn command(self, args: &Args<'_>) -> Command {
        match self {
            Self::Session(build) => Command::Session(build(args)),
            Self::Scene(build) => Command::Scene(build(args)),
            Self::Primitive(build) => Command::Primitive(build(args)),
            Self::Object(build) => Command::Object(build(args)),
            Self::Request(build) => Command::Request(build(args)),
        }
    }

    fn needs(self) -> Needs {
        match self {
            Self::Session(_) | Self::Scene(_) | Self::Request(_) => Needs::Nothing,
            Self::Primitive(_) => Needs::Primitive,
            Self::Object(_) => Needs::Object,
        }
    }
}

/// One row of the command table: the names of a command, its arguments, its help.
#[derive(Debug)]
pub struct CommandSpec {
    /// The full name.
    pub name: &'static str,
    /// The other spellings; case is ignored in all.
    pub spellings: &'static [&'static str],
    /// The section of the help.
    pub group: Group,
    /// Options, for example `--history`, at any position among the arguments.
    pub options: &'static [&'static str],
    /// The arguments, in parts. The first part is required; each later part is optional, together
    /// with all after it.
    pub args: &'static [&'static [Arg]],
    /// The effect of the command, in one line.
    pub summary: &'static str,
    /// The default value, in words, or "".
    pub default: &'static str,
    /// A valid line.
    pub example: &'static str,
    /// Makes the command from arguments that fit `args`.
    pub(crate) build: Build,
}

impl CommandSpec {
    /// The selection that the command needs.
    pub fn needs(&self) -> Needs {
        self.build.needs()
    }

    /// The name and the other spellings.
    pub fn all_spellings(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.name).chain(self.spellings.iter().copied())
    }

    /// All arguments, required or not.
    pub fn all_args(&self) -> impl Iterator<Item = &'static Arg> {
        self.args.iter().copied().flatten()
    }

    /// Whether the last argument takes any number of words.
    pub fn is_variadic(&self) -> bool {
        self.all_args().last().is_some_and(|arg| matches!(arg.kind, ArgKind::Words(_) | ArgKind::Line))
    }

    /// Whether the last argument is another command with its arguments.
    pub(crate) fn takes_line(&self) -> bool {
        self.all_args().any(|arg| matches!(arg.kind, ArgKind::Line))
    }

    /// Whether the command can have keys: it sets numbers of the scene. For `set` this also depends
    /// on the setting.
    pub fn is_keyable(&self) -> bool {
        let is_of_scene = matches!(self.group, Group::Primitives | Group::Objects | Group::Scene);
        let has_number = self.all_args().any(|arg| matches!(arg.kind, ArgKind::Number(_)));
        self.name == "set" || (is_of_scene && has_number)
    }

    /// The arguments that have a position: all but an image size.
    pub(crate) fn positional_args(&self) -> impl Iterator<Item = &'static Arg> {
        self.all_args().filter(|arg| !matches!(arg.kind, ArgKind::Size))
    }

    /// Whether a word is an option, or an image size that the command takes: these may stand at any
    /// position.
    pub(crate) fn is_position_free(&self, word: &str) -> bool {
        self.options.iter().any(|option| option.eq_ignore_ascii_case(word))
            || (size_form(word).is_some() && self.all_args().any(|arg| arg.kind == ArgKind::Size))
    }

    /// The numbers that a word at a position stands for, if it is a shorthand there.
    pub(crate) fn shorthand_at(&self, position: usize, word: &str) -> Option<DVec3> {
        self.positional_args().nth(position)?.shorthand?.numbers_of(word)
    }

    /// The position of the argument that follows these words.
    pub(crate) fn position_after<'w>(&self, words: impl IntoIterator<Item = &'w str>) -> usize {
        words.into_iter().filter(|word| !self.is_position_free(word)).fold(0, |position, word| {
            position + if self.shorthand_at(position, word).is_some() { 3 } else { 1 }
        })
    }

    /// The allowed counts of arguments, without those of a variadic one, in rising order; some may
    /// repeat.
    pub fn counts(&self) -> impl Iterator<Item = usize> {
        self.args.iter().scan(0, |total, part| {
            *total += part.iter().filter(|arg| !matches!(arg.kind, ArgKind::Size)).count();
            Some(*total)
        })
    }

    /// The arguments as in the help: `NAME x y z [r g b [k]]`.
    pub fn usage(&self) -> String {
        let mut words = self.options.iter().map(|option| format!("[{option}]")).collect::<Vec<_>>().join(" ");
        for (depth, part) in self.args.iter().enumerate() {
            for (i, arg) in part.iter().enumerate() {
                let open = if depth > 0 && i == 0 { "[" } else { "" };
                let dots = if matches!(arg.kind, ArgKind::Words(_) | ArgKind::Line) { " ..." } else { "" };
                let gap = if words.is_empty() { "" } else { " " };
                let name = match arg.kind {
                    ArgKind::Choice(choices) => choices.join("|"),
                    _ => arg.name.to_owned(),
                };
                words.push_str(&format!("{gap}{open}{name}{dots}"));
            }
        }
        words.push_str(&"]".repeat(self.args.len().saturating_sub(1)));
        words
    }
}

/// The fault of a key for a command that has no numbers to interpolate.
pub(crate) fn not_keyable(spec: &CommandSpec) -> Fault {
    let message = format!("{} cannot have keys: only commands that set numbers of the scene can", spec.name);
    Fault::new(FaultCode::NotKeyable, message)
        .help("keys are of commands such as rotate, setColor, camera or 'set exposure'; for example: key 24 rotate 0 0 1 90")
}

/// Splits WIDTHxHEIGHT into its digits. Does not check that an image can be so large.
pub(crate) fn size_form(word: &str) -> Option<(&str, &str)> {
    let (width, height) = word.split_once(['x', 'X'])?;
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    (is_digits(width) && is_digits(height)).then_some((width, height))
}

/// Reads an image size, WIDTHxHEIGHT.
///
/// # Errors
/// A message that says what is wrong.
pub fn parse_size(word: &str) -> Result<(u32, u32), String> {
    let (width, height) = size_form(word).ok_or("a size is WIDTHxHEIGHT, such as 1280x960")?;
    match (width.parse(), height.parse()) {
        (Ok(width), Ok(height)) if Picture::is_size(width, height) => Ok((width, height)),
        _ => Err(format!(
            "width and height must be 1 to {}, and {} pixels at most",
            Picture::LONGEST_SIDE,
            Picture::MOST_PIXELS
        )),
    }
}

/// Arguments that fit the row of their command.
pub(crate) struct Args<'a> {
    /// The spelling of the command in the line.
    pub(crate) spelling: &'a str,
    pub(crate) words: SmallVec<[Cow<'a, str>; 2]>,
    pub(crate) numbers: SmallVec<[f64; 12]>,
    pub(crate) size: Option<(u32, u32)>,
    pub(crate) options: Vec<&'static str>,
}

impl<'a> Args<'a> {
    /// The arguments of a command without any.
    pub(crate) fn none(spelling: &'a str) -> Self {
        Self { spelling, words: SmallVec::new(), numbers: SmallVec::new(), size: None, options: Vec::new() }
    }

    pub(crate) fn text(&self, i: usize) -> String {
        self.words[i].clone().into_owned()
    }

    pub(crate) fn optional_text(&self, i: usize) -> Option<String> {
        self.words.get(i).map(|word| word.clone().into_owned())
    }

    pub(crate) fn texts(&self) -> Vec<String> {
        self.words.iter().map(|word| word.clone().into_owned()).collect()
    }

    pub(crate) fn number(&self, i: usize) -> f64 {
        self.numbers[i]
    }

    pub(crate) fn vector(&self, i: usize) -> DVec3 {
        DVec3::from_slice(&self.numbers[i..i + 3])
    }

    pub(crate) fn optional_vector(&self, i: usize) -> Option<DVec3> {
        (self.numbers.len() >= i + 3).then(|| self.vector(i))
    }

    pub(crate) fn whole(&self, i: usize) -> u32 {
        self.numbers[i] as u32
    }

    pub(crate) fn optional_number(&self, i: usize) -> Option<f64> {
        self.numbers.get(i).copied()
    }

    pub(crate) fn optional_whole(&self, i: usize) -> Option<u32> {
        self.numbers.get(i).map(|&number| number as u32)
    }

    /// Whether the spelling ends in an exclamation mark, as `load!`.
    pub(crate) fn is_forced(&self) -> bool {
        self.spelling.ends_with('!')
    }

    pub(crate) fn has(&self, option: &str) -> bool {
        self.options.contains(&option)
    }

    pub(crate) fn rotation(&self) -> TransformStep {
        TransformStep::Rotate { axis: self.vector(0), angle_deg: self.number(3) }
    }

    /// The numbers w x y z as a quaternion.
    pub(crate) fn orientation(&self) -> TransformStep {
        let v = self.vector(1);
        TransformStep::Orient(DQuat::from_xyzw(v.x, v.y, v.z, self.number(0)))
    }

    /// Twelve numbers, row by row, as an affine map.
    pub(crate) fn affine(&self) -> TransformStep {
        let column = |i: usize| DVec3::new(self.number(i), self.number(i + 4), self.number(i + 8));
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        TransformStep::Affine(Box::new(DAffine3 { matrix3, translation: column(3) }))
    }
}
