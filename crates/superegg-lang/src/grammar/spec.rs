//! What the table of commands says of each: names, arguments, needs.

use superegg_geom::TransformStep;
use superegg_geom::glam::DVec3;
use superegg_scene::Picture;

use crate::diagnostic::Fault;
use crate::grammar::command::Command;

/// Where help lists a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Help, what there is, leaving.
    Session,
    /// Undo and changes by name.
    Editing,
    /// Scene files and folders.
    Files,
    /// Primitives and their surfaces.
    Primitives,
    /// Objects and their children.
    Objects,
    /// Lights, camera, background, depth.
    Scene,
    /// Keys.
    Animation,
    /// Rendering, viewing, tests, settings.
    Pictures,
}

impl Group {
    /// Every group, in the order of help.
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

    /// The one word for it.
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

    /// Its heading.
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
    /// Above the first number, and the second at most.
    AboveTo(f64, f64),
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
            Self::AboveTo(least, most) => least < x && x <= most,
            Self::Whole(least, most) => x.fract() == 0.0 && (f64::from(least)..=f64::from(most)).contains(&x),
        }
    }

    /// The range in signs, for a line of hints; empty for any number.
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

    /// The range in words: "x must be ...".
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

/// What a name is the name of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// Something that need not be there yet.
    New,
    /// A primitive.
    Primitive,
    /// A primitive, made if it is new.
    PrimitiveOrNew,
    /// An object.
    Object,
    /// An object, made if it is new.
    ObjectOrNew,
    /// A primitive or an object.
    Entity,
    /// A child of the selected object.
    Child,
    /// A light.
    Light,
    /// A command.
    Command,
    /// A setting.
    Setting,
    /// A frame that has keys, or the word `all`.
    KeyFrame,
}

/// What an argument is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArgKind {
    /// A number.
    Number(Range),
    /// A name: any word.
    Name(Of),
    /// A file or folder: any word, or any text between double quotes.
    File,
    /// One of these words, in any case.
    Choice(&'static [&'static str]),
    /// The size of a picture, such as 640x480. It may stand anywhere among the arguments.
    Size,
    /// The value of the setting named before it.
    Value,
    /// Any number of names, none included. Only as the last argument.
    Words(Of),
    /// A command of which there can be keys, with its arguments. Only as the last argument, after one other.
    Line,
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
    /// Words that may stand anywhere among the arguments, such as `--history`.
    pub options: &'static [&'static str],
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
        self.all_args().last().is_some_and(|arg| matches!(arg.kind, ArgKind::Words(_) | ArgKind::Line))
    }

    /// Whether another command with its arguments follows.
    pub(crate) fn takes_line(&self) -> bool {
        self.all_args().any(|arg| arg.kind == ArgKind::Line)
    }

    /// Whether there can be keys of it: it sets numbers of the scene. (Of `set`, only where the setting is a number of the scene.)
    pub fn is_keyable(&self) -> bool {
        let is_of_scene = matches!(self.group, Group::Primitives | Group::Objects | Group::Scene);
        let has_number = self.all_args().any(|arg| matches!(arg.kind, ArgKind::Number(_)));
        self.name == "set" || (is_of_scene && has_number)
    }

    /// The numbers of arguments that it may have (without those of a variadic one), growing; some may come twice.
    pub fn counts(&self) -> impl Iterator<Item = usize> {
        self.args.iter().scan(0, |total, part| {
            *total += part.iter().filter(|arg| arg.kind != ArgKind::Size).count();
            Some(*total)
        })
    }

    /// The arguments as help writes them: `NAME x y z [r g b [k]]`.
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
    let message =
        format!("there are no keys of {}: they need numbers that can go over into others", spec.name);
    Fault::new("not-keyable", message)
        .help("keys are of commands such as rotate, setColor, camera or 'set exposure'; for example: key 24 rotate 0 0 1 90")
}

/// Reads the form of a picture's size, WIDTHxHEIGHT; whether a picture may be so large is not looked at.
pub(crate) fn size_form(word: &str) -> Option<(&str, &str)> {
    let (width, height) = word.split_once(['x', 'X'])?;
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    (is_digits(width) && is_digits(height)).then_some((width, height))
}

/// Reads the size of a picture.
///
/// # Errors
/// What is wrong, in words.
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

/// Arguments that fit a command's table row.
pub(crate) struct Args<'a> {
    /// The command's own word.
    pub(crate) spelling: &'a str,
    pub(crate) words: Vec<&'a str>,
    pub(crate) numbers: Vec<f64>,
    pub(crate) size: Option<(u32, u32)>,
    pub(crate) options: Vec<&'static str>,
}

impl Args<'_> {
    pub(crate) fn text(&self, i: usize) -> String {
        self.words[i].to_owned()
    }

    pub(crate) fn optional_text(&self, i: usize) -> Option<String> {
        self.words.get(i).map(|&word| word.to_owned())
    }

    pub(crate) fn texts(&self) -> Vec<String> {
        self.words.iter().map(|&word| word.to_owned()).collect()
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

    pub(crate) fn optional_whole(&self, i: usize) -> Option<u32> {
        self.numbers.get(i).map(|&number| number as u32)
    }

    /// Whether the command's word ends in an exclamation mark: do it even so.
    pub(crate) fn is_forced(&self) -> bool {
        self.spelling.ends_with('!')
    }

    pub(crate) fn has(&self, option: &str) -> bool {
        self.options.contains(&option)
    }

    pub(crate) fn rotation(&self) -> TransformStep {
        TransformStep::Rotate { axis: self.vector(0), angle_deg: self.number(3) }
    }
}
