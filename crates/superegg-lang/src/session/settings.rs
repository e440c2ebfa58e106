//! Settings, for the commands `set` and `get`. Image settings belong to the scene, the others to
//! the session.

use superegg_scene::{Encoding, Filter, LightModel, Picture, Shading, Theme, Tone, ViewSettings};

use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::spec::{Range, parse_size};
use crate::parse::number::{format_number, parse_number};
use crate::parse::parser::help_for_setting;
use crate::suggest::Suggestions;
use crate::text::{line_width, one_of, shorten, two_columns};

/// How `preview` draws in the terminal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PreviewStyle {
    /// The best that the terminal supports.
    #[default]
    Auto,
    /// Half-block characters in true colour.
    Blocks,
    /// The kitty graphics protocol.
    Kitty,
    /// Sixel graphics.
    Sixel,
    /// Characters without colour.
    Plain,
}

/// The settings of a session. Loading does not change them, and they are not saved with a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Settings of the viewer, and the grid of the inside-outside test.
    pub view: ViewSettings,
    /// Render threads; 0 for one per core.
    pub threads: u32,
    /// How `preview` draws.
    pub preview: PreviewStyle,
    /// The width that texts are wrapped to, in columns of the terminal.
    pub columns: u16,
}

impl Default for Settings {
    fn default() -> Self {
        Self { view: ViewSettings::default(), threads: 0, preview: PreviewStyle::default(), columns: 80 }
    }
}

/// The type of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingKind {
    /// On or off.
    Switch,
    /// A number.
    Number(Range),
    /// One of these words; case is ignored.
    Choice(&'static [&'static str]),
    /// An image size.
    Size,
}

impl SettingKind {
    /// The allowed values, in words.
    pub fn describe(self) -> String {
        match self {
            Self::Switch => "on or off".to_owned(),
            Self::Number(range) => range.describe(),
            Self::Choice(choices) => one_of(choices),
            Self::Size => "WIDTHxHEIGHT in pixels".to_owned(),
        }
    }
}

/// A value of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value {
    Switch(bool),
    Number(f64),
    /// An index into the choices.
    Choice(usize),
    Size(u32, u32),
}

/// One setting.
#[derive(Debug)]
pub struct SettingSpec {
    /// The name.
    pub name: &'static str,
    /// The type.
    pub kind: SettingKind,
    /// The meaning of the setting, in one line.
    pub summary: &'static str,
    /// Whether the setting belongs to the scene and is saved with it.
    pub is_of_scene: bool,
    get: fn(&Picture, &Settings) -> Value,
    set: fn(&mut Picture, &mut Settings, Value),
}

impl SettingSpec {
    /// The default value.
    pub(crate) fn default_text(&self) -> String {
        value_text((self.get)(&Picture::default(), &Settings::default()), self.kind)
    }

    /// A value that is not the default one.
    pub(crate) fn example_text(&self) -> String {
        let default = self.default_text();
        match self.kind {
            SettingKind::Switch => if default == "on" { "off" } else { "on" }.to_owned(),
            SettingKind::Choice(choices) => choices
                .iter()
                .find(|choice| **choice != default)
                .map_or(default, |choice| (*choice).to_owned()),
            SettingKind::Size => "640x480".to_owned(),
            SettingKind::Number(range) => {
                let numbers = ["16", "1", "0.5", "0.01"];
                let is_allowed = |text: &str| {
                    text != default && parse_number(text).is_ok_and(|number| range.contains(number))
                };
                numbers.into_iter().find(|text| is_allowed(text)).unwrap_or(&default).to_owned()
            }
        }
    }

    /// The value, as `set` reads it.
    pub fn value(&self, picture: &Picture, settings: &Settings) -> String {
        value_text((self.get)(picture, settings), self.kind)
    }
}

/// A setting of the viewer that is on or off.
macro_rules! switch {
    ($name:literal, $field:ident, $summary:literal) => {
        SettingSpec {
            name: $name,
            kind: SettingKind::Switch,
            summary: $summary,
            is_of_scene: false,
            get: |_, settings| Value::Switch(settings.view.$field),
            set: |_, settings, value| {
                if let Value::Switch(on) = value {
                    settings.view.$field = on;
                }
            },
        }
    };
}

/// A number of the grid of the inside-outside test. Once it is set the grid no longer suits the scene.
macro_rules! grid_number {
    ($name:literal, $field:ident, $range:expr, $summary:literal) => {
        SettingSpec {
            name: $name,
            kind: SettingKind::Number($range),
            summary: $summary,
            is_of_scene: false,
            get: |_, settings| Value::Number(settings.view.$field),
            set: |_, settings, value| {
                if let Value::Number(number) = value {
                    settings.view.$field = number;
                    settings.view.io_fit = false;
                }
            },
        }
    };
}

/// A setting of the image that is a number.
macro_rules! picture_number {
    ($name:literal, $field:ident as $type:ty, $range:expr, $summary:literal) => {
        SettingSpec {
            name: $name,
            kind: SettingKind::Number($range),
            summary: concat!($summary, "; saved with the scene"),
            is_of_scene: true,
            get: |picture, _| Value::Number(f64::from(picture.$field)),
            set: |picture, _, value| {
                if let Value::Number(number) = value {
                    picture.$field = number as $type;
                }
            },
        }
    };
}

/// A setting of the image that is on or off.
macro_rules! picture_switch {
    ($name:literal, $field:ident, $summary:literal) => {
        SettingSpec {
            name: $name,
            kind: SettingKind::Switch,
            summary: concat!($summary, "; saved with the scene"),
            is_of_scene: true,
            get: |picture, _| Value::Switch(picture.$field),
            set: |picture, _, value| {
                if let Value::Switch(on) = value {
                    picture.$field = on;
                }
            },
        }
    };
}

/// A setting that is one of a few values, each with its word: `$field` is its field in a `Picture`
/// or a `Settings`.
macro_rules! choice {
    ($name:literal, $is_of_scene:literal, |$picture:ident, $settings:ident| $field:expr, $summary:literal,
     $($word:literal => $value:expr),+) => {
        SettingSpec {
            name: $name,
            kind: SettingKind::Choice(&[$($word),+]),
            summary: $summary,
            is_of_scene: $is_of_scene,
            get: |$picture, $settings| {
                Value::Choice([$($value),+].iter().position(|value| *value == $field).unwrap_or(0))
            },
            set: |$picture, $settings, value| {
                if let Value::Choice(at) = value {
                    $field = [$($value),+][at];
                }
            },
        }
    };
}

/// Every setting.
pub const SETTINGS: &[SettingSpec] = &[
    SettingSpec {
        name: "size",
        kind: SettingKind::Size,
        summary: "width and height of the picture; saved with the scene",
        is_of_scene: true,
        get: |picture, _| Value::Size(picture.width, picture.height),
        set: |picture, _, value| {
            if let Value::Size(width, height) = value {
                (picture.width, picture.height) = (width, height);
            }
        },
    },
    picture_number!("samples", samples as u32, Range::Whole(1, Picture::MOST_SAMPLES), "samples per pixel"),
    picture_number!(
        "noise",
        noise as f64,
        Range::Within(0.0, 1.0),
        "noise threshold: if above 0, a pixel takes more samples until the standard error of its value, 0 to 1, is below this"
    ),
    picture_number!(
        "mostSamples",
        most_samples as u32,
        Range::Whole(1, Picture::MOST_SAMPLES),
        "the maximal samples per pixel for noise"
    ),
    choice!("filter", true, |picture, _settings| picture.filter, "the reconstruction filter; saved with the scene",
        "box" => Filter::Box, "tent" => Filter::Tent, "gaussian" => Filter::Gaussian,
        "blackman" => Filter::Blackman, "mitchell" => Filter::Mitchell),
    picture_number!(
        "exposure",
        exposure as f64,
        Range::Within(-32.0, 32.0),
        "exposure in stops: linear values are multiplied by 2^exposure"
    ),
    choice!("tone", true, |picture, _settings| picture.tone, "the tone mapping operator; saved with the scene",
        "none" => Tone::None, "reinhard" => Tone::Reinhard, "filmic" => Tone::Filmic, "aces" => Tone::Aces, "agx" => Tone::Agx),
    choice!("encoding", true, |picture, _settings| picture.encoding, "the transfer function of the file; saved with the scene",
        "srgb" => Encoding::Srgb, "linear" => Encoding::Linear),
    choice!("bits", true, |picture, _settings| picture.bits, "bits per channel of a PNG file; saved with the scene",
        "8" => 8, "16" => 16),
    picture_switch!("dither", dither, "8 bits are dithered, so that gradients have no bands"),
    picture_number!(
        "farDepth",
        far_depth as f64,
        Range::NonNegative,
        "the depth of pixels without a hit in an .exr, which programs that scale pictures need; 0 is infinity"
    ),
    picture_switch!(
        "cryptomatte",
        cryptomatte,
        "an .exr also has Cryptomatte: how much of each pixel every instance and every object covers, with their names"
    ),
    picture_switch!(
        "denoise",
        denoise,
        "the finished picture is denoised by Open Image Denoise, a library that must be installed"
    ),
    picture_switch!("transparent", transparent, "the background is transparent"),
    choice!("light", true, |picture, _settings| picture.light_model,
        "light straight from the lights, or path: by any number of surfaces and from the sky; saved with the scene",
        "course" => LightModel::Course, "path" => LightModel::Path),
    picture_number!(
        "bounces",
        bounces as u32,
        Range::Whole(0, 256),
        "the maximal number of reflections and refractions of a path, after which it sees the sky; with light path, paths end at random"
    ),
    picture_number!(
        "leastWeight",
        least_weight as f64,
        Range::Within(0.0, 1.0),
        "rays whose weight in their pixel is below this are not traced"
    ),
    picture_number!(
        "lightRays",
        light_rays as u32,
        Range::Whole(1, 4096),
        "shadow rays to each area light, for each hit point"
    ),
    picture_number!(
        "glossRays",
        gloss_rays as u32,
        Range::Whole(0, 4096),
        "glossy reflection rays for each hit point; 0 makes reflections sharp"
    ),
    SettingSpec {
        name: "threads",
        kind: SettingKind::Number(Range::Whole(0, 1024)),
        summary: "render threads; 0 is one per core",
        is_of_scene: false,
        get: |_, settings| Value::Number(f64::from(settings.threads)),
        set: |_, settings, value| {
            if let Value::Number(threads) = value {
                settings.threads = threads as u32;
            }
        },
    },
    choice!("preview", false, |_picture, settings| settings.preview, "how 'preview' draws in the terminal",
        "auto" => PreviewStyle::Auto, "blocks" => PreviewStyle::Blocks, "kitty" => PreviewStyle::Kitty,
        "sixel" => PreviewStyle::Sixel, "plain" => PreviewStyle::Plain),
    switch!("lightsTurn", lights_turn, "in the viewer, the lights turn with the arcball (key b)"),
    choice!("shading", false, |_picture, settings| settings.view.shading, "in the viewer, shading per pixel or per vertex (key m)",
        "phong" => Shading::Phong, "gouraud" => Shading::Gouraud),
    switch!("wireframe", wireframe, "in the viewer, edges instead of surfaces (key t)"),
    switch!("normals", normals, "in the viewer, normals at the vertices (key n)"),
    switch!("axes", axes, "in the viewer, the axes and the positions of the lights"),
    switch!("ioTest", io_test, "in the viewer, the inside-outside test (key o)"),
    switch!("ioOutside", io_outside, "in the viewer, the points outside of that test too (key u)"),
    switch!(
        "ioFit",
        io_fit,
        "in the viewer, the grid of that test suits the scene; the next four settings end this"
    ),
    grid_number!("ioStep", io_step, Range::Positive, "the spacing of the grid of the inside-outside test"),
    grid_number!("ioHalf", io_half, Range::NonNegative, "the half extent of that grid along each axis"),
    grid_number!(
        "ioJitter",
        io_jitter,
        Range::NonNegative,
        "in the viewer, the random offset of its points along each axis"
    ),
    grid_number!("ioRadius", io_radius, Range::Positive, "in the viewer, the radius of its marks"),
    switch!("intersectTest", intersect_test, "in the viewer, the intersection test (key i)"),
    choice!("theme", false, |_picture, settings| settings.view.theme,
        "in the viewer, the colours of menus and panels; kept for later sessions",
        "system" => Theme::System, "light" => Theme::Light, "dark" => Theme::Dark),
    SettingSpec {
        name: "course",
        kind: SettingKind::Switch,
        summary: "the viewer as in the course program: both tests, its grid, the patches of setPatch; kept for later sessions",
        is_of_scene: false,
        get: |_, settings| Value::Switch(settings.view.course),
        set: |_, settings, value| {
            if let Value::Switch(on) = value {
                let view = if on { ViewSettings::COURSE } else { ViewSettings::default() };
                settings.view = ViewSettings { theme: settings.view.theme, ..view };
            }
        },
    },
];

/// The setting of this name; case is ignored.
pub(crate) fn find_setting(name: &str) -> Option<&'static SettingSpec> {
    SETTINGS.iter().find(|spec| spec.name.eq_ignore_ascii_case(name))
}

/// Whether the setting of this name accepts a value.
pub(crate) fn can_be(name: &str, word: &str) -> bool {
    find_setting(name).is_some_and(|spec| read(spec.kind, word).is_some())
}

/// Changes a setting and returns its row.
///
/// # Errors
/// An unknown setting (word 1 of the command), or a value outside its range (word 2).
pub(crate) fn set(
    picture: &mut Picture,
    settings: &mut Settings,
    name: &str,
    word: &str,
) -> Result<&'static SettingSpec, (usize, Fault)> {
    let spec = find_setting(name).ok_or_else(|| (1, unknown_setting(name)))?;
    let value = read(spec.kind, word).ok_or_else(|| {
        let message = match (spec.kind, parse_size(word)) {
            (SettingKind::Size, Err(why)) => format!("{} cannot be {}: {why}", spec.name, shorten(word)),
            _ => format!("{} must be {}, not {}", spec.name, spec.kind.describe(), shorten(word)),
        };
        // Where the setting is kept does not help.
        let what = spec.summary.split("; saved with").next().unwrap_or_default();
        let value = value_text((spec.get)(picture, settings), spec.kind);
        let help = format!("{what}; for example: set {} {value}", spec.name);
        (2, Fault::new(FaultCode::OutOfRange, message).help(help))
    })?;
    (spec.set)(picture, settings, value);
    Ok(spec)
}

/// The named settings with their values and help; all if none is named.
///
/// # Errors
/// The index in `names` of an unknown setting, and the fault.
pub(crate) fn list(
    picture: &Picture,
    settings: &Settings,
    names: &[String],
) -> Result<String, (usize, Fault)> {
    let found: Result<Vec<&SettingSpec>, _> = names
        .iter()
        .enumerate()
        .map(|(i, name)| find_setting(name).ok_or_else(|| (i, unknown_setting(name))))
        .collect();
    let mut specs = found?;
    if names.is_empty() {
        specs = SETTINGS.iter().collect();
    }
    let line = |spec: &&SettingSpec| {
        let value = value_text((spec.get)(picture, settings), spec.kind);
        two_columns(
            &format!("{:<14} {value}", spec.name),
            &format!("{} ({})", spec.summary, spec.kind.describe()),
            line_width(settings.columns),
        )
    };
    Ok(specs.iter().map(line).collect::<Vec<_>>().join("\n"))
}

/// The `set` commands for the settings of the scene that differ from their defaults.
pub(crate) fn lines_of_scene(picture: &Picture) -> impl Iterator<Item = String> {
    let settings = Settings::default();
    SETTINGS.iter().filter(|spec| spec.is_of_scene).filter_map(move |spec| {
        let value = (spec.get)(picture, &settings);
        let is_default = value == (spec.get)(&Picture::default(), &settings);
        (!is_default).then(|| format!("set {} {}", spec.name, value_text(value, spec.kind)))
    })
}

/// The image settings of `added` where `own` has the default, and else the default.
pub(crate) fn merged(own: &Picture, added: &Picture) -> Picture {
    let (default, mut unused) = (Picture::default(), Settings::default());
    let mut merged = default;
    for spec in SETTINGS.iter().filter(|spec| spec.is_of_scene) {
        if (spec.get)(own, &unused) == (spec.get)(&default, &unused) {
            let value = (spec.get)(added, &unused);
            (spec.set)(&mut merged, &mut unused, value);
        }
    }
    merged
}

fn unknown_setting(name: &str) -> Fault {
    let help = help_for_setting(name).unwrap_or_else(|| {
        let names = SETTINGS.iter().map(|spec| spec.name);
        Suggestions::Given.did_you_mean(name, names, "'get' lists the settings")
    });
    Fault::new(FaultCode::UnknownSetting, format!("there is no setting '{}'", shorten(name))).help(help)
}

fn read(kind: SettingKind, word: &str) -> Option<Value> {
    let word_is = |words: &[&str]| words.iter().any(|known| known.eq_ignore_ascii_case(word));
    match kind {
        SettingKind::Switch if word_is(&["on", "yes", "true", "1"]) => Some(Value::Switch(true)),
        SettingKind::Switch if word_is(&["off", "no", "false", "0"]) => Some(Value::Switch(false)),
        SettingKind::Switch => None,
        SettingKind::Number(range) => {
            // Adding 0 turns -0 into 0, as which it is saved.
            parse_number(word)
                .ok()
                .filter(|number| range.contains(*number))
                .map(|number| Value::Number(number + 0.0))
        }
        SettingKind::Choice(choices) => {
            choices.iter().position(|choice| choice.eq_ignore_ascii_case(word)).map(Value::Choice)
        }
        SettingKind::Size => parse_size(word).ok().map(|(width, height)| Value::Size(width, height)),
    }
}

fn value_text(value: Value, kind: SettingKind) -> String {
    match (value, kind) {
        (Value::Switch(on), _) => if on { "on" } else { "off" }.to_owned(),
        (Value::Number(number), _) => format_number(number),
        (Value::Choice(at), SettingKind::Choice(choices)) => choices[at].to_owned(),
        (Value::Choice(at), _) => at.to_string(),
        (Value::Size(width, height), _) => format!("{width}x{height}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_tells_what_it_was_set_to_and_refuses_the_rest() {
        for spec in SETTINGS {
            let (mut picture, mut settings) = (Picture::default(), Settings::default());
            let words: Vec<&str> = match spec.kind {
                SettingKind::Switch => vec!["off", "on"],
                SettingKind::Number(range) if range.contains(2.0) => vec!["3", "2"],
                SettingKind::Number(_) => vec!["0.25", "1"],
                SettingKind::Choice(choices) => choices.to_vec(),
                SettingKind::Size => vec!["7x9", "640x480"],
            };
            for word in words {
                set(&mut picture, &mut settings, &spec.name.to_uppercase(), word).unwrap();
                assert_eq!(value_text((spec.get)(&picture, &settings), spec.kind), word, "{}", spec.name);
            }
            let before = (picture, settings);
            for bad in ["", "maybe", "-99", "nan", "0x0", "1e999"] {
                let (word, fault) = set(&mut picture, &mut settings, spec.name, bad).unwrap_err();
                assert!(word == 2 && fault.message.contains(spec.name) && fault.help.is_some());
            }
            assert_eq!((picture, settings), before);
        }
        let (mut picture, mut settings) = (Picture::default(), Settings::default());
        assert_eq!(set(&mut picture, &mut settings, "sizes", "1x1").unwrap_err().0, 1);
    }

    #[test]
    fn a_setting_that_is_a_command_names_the_command() {
        for (name, help) in [
            ("depth", "did you mean the command 'setDepth'? setDepth levels, for example: setDepth 8"),
            (
                "background",
                "did you mean the command 'background'? background r g b, for example: background",
            ),
            ("sizes", "did you mean 'size'?"),
            ("fps", "'get' lists the settings"),
        ] {
            let found = unknown_setting(name).help.unwrap();
            assert!(found.starts_with(help), "{name}: {found}");
        }
    }
}
