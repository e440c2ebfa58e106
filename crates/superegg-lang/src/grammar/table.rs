//! The command table.

use std::sync::LazyLock;

use superegg_geom::TransformStep;
use superegg_geom::glam::DVec3;
use superegg_scene::{
    AmbientOcclusion, Camera, Daylight, EnvironmentPicture, Light, LightKind, MAX_DEPTH, MaterialWeight,
    Patches, Texture, TextureChannel, TextureMapping,
};

use crate::grammar::command::{
    ObjectCommand, PrimitiveCommand, Recovery, Request, SceneCommand, SessionCommand,
};
use crate::grammar::spec::{Arg, ArgKind, Build, CommandSpec, Group, NameKind, Range, Shorthand};

const fn number(name: &'static str, range: Range) -> Arg {
    Arg { name, kind: ArgKind::Number(range), shorthand: None }
}

/// The first of three numbers that one word may stand for.
const fn first_number(name: &'static str, range: Range, shorthand: Shorthand) -> Arg {
    Arg { name, kind: ArgKind::Number(range), shorthand: Some(shorthand) }
}

const fn arg(name: &'static str, kind: ArgKind) -> Arg {
    Arg { name, kind, shorthand: None }
}

const fn name(name: &'static str, of: NameKind) -> Arg {
    arg(name, ArgKind::Name(of))
}

const FILE: Arg = arg("FILE", ArgKind::File);
const FOLDER: Arg = arg("FOLDER", ArgKind::File);
/// The option of `save` to write the commands as typed.
const HISTORY_OPTION: &str = "--history";
const COUNT: Arg = number("N", Range::Whole(1, u32::MAX));
const UNIT: Range = Range::Within(0.0, 1.0);
const VECTOR: &[Arg] = &[number("x", Range::Any), number("y", Range::Any), number("z", Range::Any)];
const FACTORS: &[Arg] =
    &[number("x", Range::NonZero), number("y", Range::NonZero), number("z", Range::NonZero)];
const TURN: &[Arg] = &[
    first_number("x", Range::Any, Shorthand::Axis),
    number("y", Range::Any),
    number("z", Range::Any),
    number("degrees", Range::Any),
];
const UP: &[Arg] =
    &[first_number("x", Range::Any, Shorthand::Axis), number("y", Range::Any), number("z", Range::Any)];
const QUATERNION: &[Arg] =
    &[number("w", Range::Any), number("x", Range::Any), number("y", Range::Any), number("z", Range::Any)];
/// An affine map, row by row: the image of x y z is the sums of m11 x + m12 y + m13 z + tx, and so on.
const MATRIX: &[Arg] = &[
    number("m11", Range::Any),
    number("m12", Range::Any),
    number("m13", Range::Any),
    number("tx", Range::Any),
    number("m21", Range::Any),
    number("m22", Range::Any),
    number("m23", Range::Any),
    number("ty", Range::Any),
    number("m31", Range::Any),
    number("m32", Range::Any),
    number("m33", Range::Any),
    number("tz", Range::Any),
];
const COLOR: &[Arg] = &[first_number("r", UNIT, Shorthand::Color), number("g", UNIT), number("b", UNIT)];
const RADIANCE: &[Arg] = &[
    first_number("r", Range::NonNegative, Shorthand::Color),
    number("g", Range::NonNegative),
    number("b", Range::NonNegative),
];
/// Absorption for each channel: no colour, so that no word stands for it.
const ABSORPTION: &[Arg] =
    &[number("r", Range::NonNegative), number("g", Range::NonNegative), number("b", Range::NonNegative)];
const WEIGHT: &[Arg] = &[number("share", UNIT)];

/// A colour after another one.
const SECOND_RADIANCE: &[Arg] = &[
    first_number("r2", Range::NonNegative, Shorthand::Color),
    number("g2", Range::NonNegative),
    number("b2", Range::NonNegative),
];
/// The maximal number of ambient occlusion rays per point.
const MOST_OCCLUSION_SAMPLES: u32 = 65_536;
/// The default fraction of a spot's cone over which its light fades.
const SPOT_SOFT: f64 = 0.2;
/// The default edge length of a checker's cubes.
pub(crate) const CHECKER_SIZE: f64 = 0.5;

/// A command that sets one weight of the selected primitive's material.
macro_rules! weight {
    ($name:literal, $spelling:literal, $weight:ident, $summary:literal, $default:literal) => {
        CommandSpec {
            name: $name,
            spellings: &[$spelling],
            group: Group::Primitives,
            options: &[],
            args: &[WEIGHT],
            summary: $summary,
            default: $default,
            example: concat!($spelling, " 0.4"),
            build: Build::Primitive(|args| {
                PrimitiveCommand::SetWeight(MaterialWeight::$weight, args.number(0))
            }),
        }
    };
}

/// Every command of the language.
///
/// ```
/// use superegg_lang::{COMMANDS, Needs, find_command};
///
/// let index = find_command("INDEX").unwrap();
/// assert_eq!((index.name, index.usage().as_str(), index.needs()), ("setIndex", "index", Needs::Primitive));
/// assert!(COMMANDS.iter().all(|spec| find_command(spec.name).is_some()));
/// ```
pub const COMMANDS: &[CommandSpec] = &[
    CommandSpec {
        name: "help",
        spellings: &["?"],
        group: Group::Session,
        options: &[],
        args: &[&[], &[arg("WORD", ArgKind::Words(NameKind::HelpWord))]],
        summary: "shows the first steps, or explains commands, groups and settings, or searches for a word; 'help all' lists the commands",
        default: "",
        example: "help setColor",
        build: Build::Session(|args| SessionCommand::Help(args.texts())),
    },
    CommandSpec {
        name: "stop",
        spellings: &["quit", "exit"],
        group: Group::Session,
        options: &[],
        args: &[&[], &[arg("JOB", ArgKind::Choice(&["render"]))]],
        summary: "leaves; in a file, ignores the rest. 'stop render' stops the renders in progress instead, and keeps what is done",
        default: "",
        example: "stop",
        build: Build::Request(|args| if args.words.is_empty() { Request::Stop } else { Request::StopRender }),
    },
    CommandSpec {
        name: "info",
        spellings: &["ls"],
        group: Group::Session,
        options: &[],
        args: &[&[], &[arg("NAME", ArgKind::Words(NameKind::Entity))]],
        summary: "lists the scene, or shows the details of the named entities; 'all' and 'selected' are names too",
        default: "",
        example: "info selected",
        build: Build::Session(|args| SessionCommand::Info(args.texts())),
    },
    CommandSpec {
        name: "show",
        spellings: &[],
        group: Group::Session,
        options: &[],
        args: &[&[], &[arg("NAME", ArgKind::Words(NameKind::Entity))]],
        summary: "as info, with the tree of children, the number of instances, and the bounding box",
        default: "what is selected",
        example: "show selected",
        build: Build::Request(|args| Request::Show(args.texts())),
    },
    CommandSpec {
        name: "history",
        spellings: &[],
        group: Group::Session,
        options: &[],
        args: &[&[], &[COUNT]],
        summary: "lists the lines typed in this session, or the last N of them",
        default: "all",
        example: "history 20",
        build: Build::Request(|args| Request::History(args.optional_whole(0))),
    },
    CommandSpec {
        name: "interact",
        spellings: &[],
        group: Group::Pictures,
        options: &[],
        args: &[],
        summary: "gives the keyboard to the viewer",
        default: "",
        example: "interact",
        build: Build::Request(|_| Request::Interact),
    },
    CommandSpec {
        name: "source",
        spellings: &["load", "source!", "load!"],
        group: Group::Files,
        options: &[],
        args: &[&[], &[FILE]],
        summary: "clears the scene, then runs a file; a file with errors changes nothing, but load! keeps its good lines",
        default: "the quicksave",
        example: "source robot.scn",
        build: Build::Request(|args| Request::Source {
            file: args.optional_text(0),
            is_forced: args.is_forced(),
        }),
    },
    CommandSpec {
        name: "new",
        spellings: &[],
        group: Group::Files,
        options: &[],
        args: &[],
        summary: "begins a new scene that belongs to no file; undo restores the one before",
        default: "",
        example: "new",
        build: Build::Request(|_| Request::New),
    },
    CommandSpec {
        name: "include",
        spellings: &[],
        group: Group::Files,
        options: &[],
        args: &[&[FILE]],
        summary: "adds the primitives, objects, lights and keys of a file to the scene; a name that the scene has too must mean the same in both. Settings of the file count where the scene has none of its own",
        default: "",
        example: "include wheel.scn",
        build: Build::Request(|args| Request::Include(args.text(0))),
    },
    CommandSpec {
        name: "save",
        spellings: &["save!"],
        group: Group::Files,
        options: &[HISTORY_OPTION],
        args: &[&[], &[FILE]],
        summary: "writes the scene to a file, or with --history the commands as typed; save! overwrites any file",
        default: "the quicksave; .scn is added to a name without an ending",
        example: "save robot.scn",
        build: Build::Request(|args| Request::Save {
            file: args.optional_text(0),
            is_forced: args.is_forced(),
            as_history: args.has(HISTORY_OPTION),
        }),
    },
    CommandSpec {
        name: "export",
        spellings: &["export!"],
        group: Group::Files,
        options: &[],
        args: &[&[FILE]],
        summary: "writes the selected entity for another program; the ending of the file is the format, as of 'superegg export'. export! overwrites any file",
        default: "",
        example: "export robot.glb",
        build: Build::Request(|args| Request::Export { file: args.text(0), is_forced: args.is_forced() }),
    },
    CommandSpec {
        name: "recover",
        spellings: &[],
        group: Group::Files,
        options: &[],
        args: &[&[], &[arg("WHAT", ArgKind::Choice(&["list", "discard", "restore"]))], &[COUNT]],
        summary: "restores an unsaved session: the last one, or 'recover restore N'; 'recover list' lists them with their numbers, 'recover discard N' discards one, 'recover discard' all, after a question",
        default: "",
        example: "recover",
        build: Build::Request(|args| {
            let what = args.words.first().map(|word| word.to_ascii_lowercase());
            let number = args.optional_whole(0);
            Request::Recover(match what.as_deref() {
                Some("list") => Recovery::List,
                Some("discard") => Recovery::Discard(number),
                _ => Recovery::Restore(number.unwrap_or(1)),
            })
        }),
    },
    CommandSpec {
        name: "pwd",
        spellings: &[],
        group: Group::Files,
        options: &[],
        args: &[],
        summary: "prints the working folder",
        default: "",
        example: "pwd",
        build: Build::Request(|_| Request::PrintFolder),
    },
    CommandSpec {
        name: "cd",
        spellings: &[],
        group: Group::Files,
        options: &[],
        args: &[&[], &[FOLDER]],
        summary: "changes the working folder",
        default: "your home folder",
        example: "cd scenes",
        build: Build::Request(|args| Request::ChangeFolder(args.optional_text(0))),
    },
    CommandSpec {
        name: "dir",
        spellings: &[],
        group: Group::Files,
        options: &[],
        args: &[&[], &[FOLDER]],
        summary: "lists the files in a folder",
        default: "the working folder",
        example: "dir scenes",
        build: Build::Request(|args| Request::ListFolder(args.optional_text(0))),
    },
    CommandSpec {
        name: "undo",
        spellings: &[],
        group: Group::Editing,
        options: &[],
        args: &[&[], &[COUNT]],
        summary: "undoes the last change, or the last N; also a load",
        default: "1",
        example: "undo 3",
        build: Build::Request(|args| Request::Undo(args.optional_whole(0).unwrap_or(1))),
    },
    CommandSpec {
        name: "redo",
        spellings: &[],
        group: Group::Editing,
        options: &[],
        args: &[&[], &[COUNT]],
        summary: "redoes the last undone change, or the last N",
        default: "1",
        example: "redo",
        build: Build::Request(|args| Request::Redo(args.optional_whole(0).unwrap_or(1))),
    },
    CommandSpec {
        name: "delete",
        spellings: &["del"],
        group: Group::Editing,
        options: &[],
        args: &[&[name("NAME", NameKind::Entity)]],
        summary: "deletes a primitive or object, its keys, and every child that refers to it",
        default: "",
        example: "delete ball",
        build: Build::Scene(|args| SceneCommand::Delete(args.text(0))),
    },
    CommandSpec {
        name: "rename",
        spellings: &["ren"],
        group: Group::Editing,
        options: &[],
        args: &[&[name("NAME", NameKind::Entity), name("NEW", NameKind::New)]],
        summary: "gives a primitive or object another name; the aliases of children stay (renameChild)",
        default: "",
        example: "rename ball head",
        build: Build::Scene(|args| SceneCommand::Rename { name: args.text(0), new: args.text(1) }),
    },
    CommandSpec {
        name: "copy",
        spellings: &["cp"],
        group: Group::Editing,
        options: &[],
        args: &[&[name("NAME", NameKind::Entity), name("NEW", NameKind::New)]],
        summary: "copies a primitive or object under another name; the copy of an object that contains itself contains itself",
        default: "",
        example: "copy ball small_ball",
        build: Build::Scene(|args| SceneCommand::Copy { name: args.text(0), new: args.text(1) }),
    },
    CommandSpec {
        name: "clear",
        spellings: &[],
        group: Group::Editing,
        options: &[],
        args: &[&[], &[arg("WHAT", ArgKind::Choice(&["screen"]))]],
        summary: "empties the scene; undo restores it. 'clear screen' empties the terminal instead",
        default: "",
        example: "clear",
        build: Build::Session(|args| {
            if args.words.is_empty() { SessionCommand::Clear } else { SessionCommand::ClearScreen }
        }),
    },
    CommandSpec {
        name: "deselect",
        spellings: &[],
        group: Group::Objects,
        options: &[],
        args: &[],
        summary: "selects neither a primitive nor an object",
        default: "",
        example: "deselect",
        build: Build::Session(|_| SessionCommand::Deselect),
    },
    CommandSpec {
        name: "primitive",
        spellings: &["prm"],
        group: Group::Primitives,
        options: &[],
        args: &[&[name("NAME", NameKind::PrimitiveOrNew)]],
        summary: "selects a primitive; creates it if it is new",
        default: "a new one is a white sphere of radius 1",
        example: "primitive ball",
        build: Build::Session(|args| SessionCommand::SelectPrimitive(args.text(0))),
    },
    CommandSpec {
        name: "setCoeff",
        spellings: &["coeff"],
        group: Group::Primitives,
        options: &[],
        args: &[&[number("x", Range::Positive), number("y", Range::Positive), number("z", Range::Positive)]],
        summary: "sets the semi-axes",
        default: "1 1 1",
        example: "setCoeff 2 1 0.5",
        build: Build::Primitive(|args| PrimitiveCommand::SetRadii(args.vector(0))),
    },
    CommandSpec {
        name: "setExponent",
        spellings: &["exponent", "exp"],
        group: Group::Primitives,
        options: &[],
        args: &[&[number("e", Range::NonNegative), number("n", Range::NonNegative)]],
        summary: "sets the exponents: e shapes the xy plane, n the z direction; 1 is round, 0 square, 2 pointed",
        default: "1 1",
        example: "setExponent 0.1 1",
        build: Build::Primitive(|args| PrimitiveCommand::SetExponents {
            e: args.number(0),
            n: args.number(1),
        }),
    },
    CommandSpec {
        name: "setPatch",
        spellings: &["patch"],
        group: Group::Primitives,
        options: &[],
        args: &[&[number("u", Range::Whole(1, u32::MAX)), number("v", Range::Whole(1, u32::MAX))]],
        summary: "sets the number of patches in the preview: around, and from pole to pole",
        default: "15 15",
        example: "setPatch 30 20",
        build: Build::Primitive(|args| {
            PrimitiveCommand::SetPatches(Patches { u: args.whole(0), v: args.whole(1) })
        }),
    },
    CommandSpec {
        name: "setColor",
        spellings: &["color", "surface"],
        group: Group::Primitives,
        options: &[],
        args: &[COLOR],
        summary: "sets the base colour: linear values, or as every colour in one word of sRGB, #ff8000, #f80 or a CSS name",
        default: "1 1 1",
        example: "setColor 0.8 0.2 0.1",
        build: Build::Primitive(|args| PrimitiveCommand::SetColor(args.vector(0))),
    },
    weight!("setAmbient", "ambient", Ambient, "sets the weight of ambient light", "0.1"),
    weight!(
        "setReflected",
        "reflected",
        Reflected,
        "sets the weight of reflected light; a surface reflects only if this is set",
        "no reflection"
    ),
    weight!(
        "setRefracted",
        "refracted",
        Refracted,
        "sets the weight of transmitted light; a surface transmits only if this is set",
        "no refraction"
    ),
    weight!("setGloss", "gloss", Gloss, "sets the roughness of the highlight: smaller is sharper", "0.3"),
    weight!("setDiffuse", "diffuse", Diffuse, "sets the weight of diffuse light", "0.8"),
    weight!("setSpecular", "specular", Specular, "sets the weight of the highlight", "0.1"),
    CommandSpec {
        name: "setIndex",
        spellings: &["index"],
        group: Group::Primitives,
        options: &[],
        args: &[&[number("index", Range::Within(1.0, 4.0))]],
        summary: "sets the index of refraction: water 1.33, glass 1.5, diamond 2.4",
        default: "1.5",
        example: "setIndex 1.33",
        build: Build::Primitive(|args| PrimitiveCommand::SetIndex(args.number(0))),
    },
    CommandSpec {
        name: "setShininess",
        spellings: &["shininess"],
        group: Group::Primitives,
        options: &[],
        args: &[&[number("exponent", Range::NonNegative)]],
        summary: "sets the exponent of the highlight, instead of the one from gloss",
        default: "2 / gloss^2 - 2",
        example: "setShininess 80",
        build: Build::Primitive(|args| PrimitiveCommand::SetShininess(args.number(0))),
    },
    CommandSpec {
        name: "setEmission",
        spellings: &["emission"],
        group: Group::Primitives,
        options: &[],
        args: &[&[number("emission", Range::NonNegative)]],
        summary: "sets the light that the surface gives off, in multiples of its colour; with 'set light path' it lights other surfaces",
        default: "0",
        example: "setEmission 4",
        build: Build::Primitive(|args| PrimitiveCommand::SetEmission(args.number(0))),
    },
    weight!(
        "setRoughness",
        "roughness",
        Roughness,
        "sets the roughness of the surface for 'set light path': 0 is a mirror under which colour is seen, 1 is matt; index is that of the coat or of rough glass",
        "no facets"
    ),
    weight!(
        "setMetallic",
        "metallic",
        Metallic,
        "sets the part of the surface that is metal for 'set light path', whose colour is that of its reflections",
        "0"
    ),
    CommandSpec {
        name: "setFresnel",
        spellings: &["fresnel"],
        group: Group::Primitives,
        options: &[],
        args: &[&[arg("on|off", ArgKind::Choice(&["on", "off"]))]],
        summary: "scales the reflected weight by the Fresnel reflectance of the index: little at normal incidence, all at grazing angles",
        default: "off",
        example: "setFresnel on",
        build: Build::Primitive(|args| {
            PrimitiveCommand::SetFresnel(args.words[0].eq_ignore_ascii_case("on"))
        }),
    },
    CommandSpec {
        name: "setAbsorb",
        spellings: &["absorb"],
        group: Group::Primitives,
        options: &[],
        args: &[ABSORPTION],
        summary: "sets the absorption inside, per world unit: after a distance d, exp(-r d), exp(-g d), exp(-b d) of the light is left",
        default: "0 0 0",
        example: "setAbsorb 0.1 0.6 0.9",
        build: Build::Primitive(|args| PrimitiveCommand::SetAbsorption(args.vector(0))),
    },
    CommandSpec {
        name: "setPattern",
        spellings: &["pattern"],
        group: Group::Primitives,
        options: &[],
        args: &[
            &[arg("PATTERN", ArgKind::Choice(&["none", "checker", "gradient", "noise", "marble", "wood"]))],
            COLOR,
            &[number("size|x", Range::Any)],
            &[number("y", Range::Any), number("z", Range::Any)],
        ],
        summary: "sets a second colour: 'none', 'checker r g b [size]' in cubes, 'gradient r g b [x y z]' along a direction, 'noise', 'marble' and 'wood r g b [size]' as clouds, veins and rings, in the primitive's own space",
        default: "none; size 0.5, x y z 0 0 1",
        example: "setPattern checker 0.1 0.1 0.1 0.25",
        build: Build::Primitive(|args| PrimitiveCommand::SetPattern {
            word: args.words[0].to_ascii_lowercase(),
            numbers: args.numbers.to_vec(),
        }),
    },
    CommandSpec {
        name: "setTexture",
        spellings: &["texture"],
        group: Group::Primitives,
        options: &[],
        args: &[
            &[arg("color|roughness|bump", ArgKind::Choice(&["color", "roughness", "bump"])), FILE],
            &[number("scale", Range::Positive)],
            &[arg("around|box", ArgKind::Choice(&["around", "box"]))],
            &[number("height", Range::Any)],
        ],
        summary: "sets a picture (.png, .jpg, .hdr) on the surface: 'color' times the colour and the pattern, 'roughness' for 'set light path', or 'bump' as heights up to 'height', which turn the normals that light takes; 'around' once and from pole to pole, or as a 'box' from six sides; FILE 'none' removes it",
        default: "none; scale 1, around, height 0.05",
        example: "setTexture color bricks.png 2 box",
        build: Build::Primitive(|args| PrimitiveCommand::SetTexture {
            channel: TextureChannel::ALL
                .into_iter()
                .find(|channel| args.words[0].eq_ignore_ascii_case(channel.word()))
                .unwrap_or(TextureChannel::Color),
            texture: (args.words[1] != "none").then(|| Texture {
                file: args.text(1).into(),
                mapping: match args.words.get(2) {
                    Some(word) if word.eq_ignore_ascii_case("box") => TextureMapping::Box,
                    _ => TextureMapping::Around,
                },
                scale: args.optional_number(0).unwrap_or(1.0),
                height: args.optional_number(1),
            }),
        }),
    },
    CommandSpec {
        name: "object",
        spellings: &["obj"],
        group: Group::Objects,
        options: &[],
        args: &[&[name("NAME", NameKind::ObjectOrNew)]],
        summary: "selects an object; creates it if it is new",
        default: "a new one is empty",
        example: "object snowman",
        build: Build::Session(|args| SessionCommand::SelectObject(args.text(0))),
    },
    CommandSpec {
        name: "translateAll",
        spellings: &["xall"],
        group: Group::Objects,
        options: &[],
        args: &[VECTOR],
        summary: "moves the whole object, after its earlier transforms",
        default: "",
        example: "translateAll 0 0 -2",
        build: Build::Object(|args| ObjectCommand::TransformWhole(TransformStep::Translate(args.vector(0)))),
    },
    CommandSpec {
        name: "rotateAll",
        spellings: &["rall"],
        group: Group::Objects,
        options: &[],
        args: &[TURN],
        summary: "rotates the whole object about an axis through the origin, right-handed; the axis is x, y, z or three numbers",
        default: "",
        example: "rotateAll z 90",
        build: Build::Object(|args| ObjectCommand::TransformWhole(args.rotation())),
    },
    CommandSpec {
        name: "scaleAll",
        spellings: &["sall"],
        group: Group::Objects,
        options: &[],
        args: &[FACTORS],
        summary: "scales the whole object; a negative factor mirrors",
        default: "",
        example: "scaleAll 2 2 2",
        build: Build::Object(|args| ObjectCommand::TransformWhole(TransformStep::Scale(args.vector(0)))),
    },
    CommandSpec {
        name: "orientAll",
        spellings: &[],
        group: Group::Objects,
        options: &[],
        args: &[QUATERNION],
        summary: "rotates the whole object by a quaternion; it is scaled to unit length",
        default: "",
        example: "orientAll 0.7071 0 0 0.7071",
        build: Build::Object(|args| ObjectCommand::TransformWhole(args.orientation())),
    },
    CommandSpec {
        name: "matrixAll",
        spellings: &[],
        group: Group::Objects,
        options: &[],
        args: &[MATRIX],
        summary: "transforms the whole object by an affine matrix of three rows of four numbers; the last of a row is the translation",
        default: "",
        example: "matrixAll 1 0 0 2 0 1 0 0 0 0.5 1 0",
        build: Build::Object(|args| ObjectCommand::TransformWhole(args.affine())),
    },
    CommandSpec {
        name: "addObject",
        spellings: &["ao"],
        group: Group::Objects,
        options: &[],
        args: &[&[name("NAME", NameKind::Object)], &[name("ALIAS", NameKind::New)]],
        summary: "adds an object, which may be the selected one itself, as a child; the cursor moves to it. For names that are two numbers write addObject: 'ao' with those is ambientOcclusion",
        default: "the alias is the name",
        example: "addObject arm left_arm",
        build: Build::Object(|args| ObjectCommand::AddObject {
            target: args.text(0),
            alias: args.optional_text(1),
        }),
    },
    CommandSpec {
        name: "addPrimitive",
        spellings: &["ap"],
        group: Group::Objects,
        options: &[],
        args: &[&[name("NAME", NameKind::Primitive)], &[name("ALIAS", NameKind::New)]],
        summary: "adds a primitive as a child; the cursor moves to it",
        default: "the alias is the name",
        example: "addPrimitive ball head",
        build: Build::Object(|args| ObjectCommand::AddPrimitive {
            target: args.text(0),
            alias: args.optional_text(1),
        }),
    },
    CommandSpec {
        name: "setCursor",
        spellings: &["cursor", "cur"],
        group: Group::Objects,
        options: &[],
        args: &[&[name("ALIAS", NameKind::Child)]],
        summary: "moves the cursor to a child: translate, rotate and scale act on it",
        default: "the child added last",
        example: "setCursor head",
        build: Build::Object(|args| ObjectCommand::SetCursor(args.text(0))),
    },
    CommandSpec {
        name: "remove",
        spellings: &["rm"],
        group: Group::Objects,
        options: &[],
        args: &[&[name("ALIAS", NameKind::Child)]],
        summary: "removes a child and its keys from the object; the primitive or object it refers to stays",
        default: "",
        example: "remove head",
        build: Build::Object(|args| ObjectCommand::RemoveChild(args.text(0))),
    },
    CommandSpec {
        name: "renameChild",
        spellings: &["renc"],
        group: Group::Objects,
        options: &[],
        args: &[&[name("ALIAS", NameKind::Child), name("NEW", NameKind::New)]],
        summary: "gives a child of the object another alias; its keys follow",
        default: "",
        example: "renameChild head face",
        build: Build::Object(|args| ObjectCommand::RenameChild { alias: args.text(0), new: args.text(1) }),
    },
    CommandSpec {
        name: "hide",
        spellings: &[],
        group: Group::Objects,
        options: &[],
        args: &[&[], &[name("ALIAS", NameKind::Child)]],
        summary: "hides a child of the object: pictures, rays and exports leave it out; unhide brings it back",
        default: "the child at the cursor",
        example: "hide head",
        build: Build::Object(|args| ObjectCommand::Hide(args.optional_text(0))),
    },
    CommandSpec {
        name: "unhide",
        spellings: &[],
        group: Group::Objects,
        options: &[],
        args: &[&[], &[name("ALIAS", NameKind::HiddenChild)]],
        summary: "shows a hidden child of the object again",
        default: "all hidden children",
        example: "unhide head",
        build: Build::Object(|args| ObjectCommand::Unhide(args.optional_text(0))),
    },
    CommandSpec {
        name: "translate",
        spellings: &["xs"],
        group: Group::Objects,
        options: &[],
        args: &[VECTOR],
        summary: "moves the child at the cursor (set by addPrimitive, addObject and setCursor), after its earlier transforms",
        default: "",
        example: "translate 0 0 1.5",
        build: Build::Object(|args| ObjectCommand::TransformChild(TransformStep::Translate(args.vector(0)))),
    },
    CommandSpec {
        name: "rotate",
        spellings: &["rs"],
        group: Group::Objects,
        options: &[],
        args: &[TURN],
        summary: "rotates the child at the cursor about an axis through the origin, right-handed; the axis is x, y, z or three numbers",
        default: "",
        example: "rotate x 30",
        build: Build::Object(|args| ObjectCommand::TransformChild(args.rotation())),
    },
    CommandSpec {
        name: "scale",
        spellings: &["ss"],
        group: Group::Objects,
        options: &[],
        args: &[FACTORS],
        summary: "scales the child at the cursor; a negative factor mirrors",
        default: "",
        example: "scale 1 1 0.5",
        build: Build::Object(|args| ObjectCommand::TransformChild(TransformStep::Scale(args.vector(0)))),
    },
    CommandSpec {
        name: "orient",
        spellings: &[],
        group: Group::Objects,
        options: &[],
        args: &[QUATERNION],
        summary: "rotates the child at the cursor by a quaternion, body to world, about the origin; it is scaled to unit length",
        default: "",
        example: "orient 0.7071 0 0 0.7071",
        build: Build::Object(|args| ObjectCommand::TransformChild(args.orientation())),
    },
    CommandSpec {
        name: "matrix",
        spellings: &[],
        group: Group::Objects,
        options: &[],
        args: &[MATRIX],
        summary: "transforms the child at the cursor by an affine matrix of three rows of four numbers; the last of a row is the translation",
        default: "",
        example: "matrix 1 0 0 2 0 1 0 0 0 0.5 1 0",
        build: Build::Object(|args| ObjectCommand::TransformChild(args.affine())),
    },
    CommandSpec {
        name: "light",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[
            &[
                name("NAME", NameKind::New),
                number("x", Range::Any),
                number("y", Range::Any),
                number("z", Range::Any),
            ],
            RADIANCE,
            &[number("k", Range::NonNegative)],
        ],
        summary: "adds or replaces a point light; its attenuation at distance d is 1 / (1 + k d^2)",
        default: "r g b 1 1 1, k 0; without any light, white at 3 4 5 with k 0.01",
        example: "light lamp 3 4 5 1 0.9 0.7 0.01",
        build: Build::Scene(|args| {
            let light = Light {
                kind: LightKind::Point { position: args.vector(0) },
                radius: 0.0,
                color: args.optional_vector(3).unwrap_or(DVec3::ONE),
                falloff: args.numbers.get(6).copied().unwrap_or(0.0),
            };
            SceneCommand::SetLight(args.text(0), light)
        }),
    },
    CommandSpec {
        name: "spot",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[
            &[
                name("NAME", NameKind::New),
                number("x", Range::Any),
                number("y", Range::Any),
                number("z", Range::Any),
                number("tx", Range::Any),
                number("ty", Range::Any),
                number("tz", Range::Any),
                number("degrees", Range::AboveTo(0.0, 180.0)),
            ],
            RADIANCE,
            &[number("k", Range::NonNegative)],
            &[number("soft", UNIT)],
        ],
        summary: "adds or replaces a spot light that shines from x y z towards tx ty tz, into a cone of this full angle; the light fades towards the rim over the fraction soft of the angle",
        default: "r g b 1 1 1, k 0, soft 0.2",
        example: "spot lamp 0 6 0 0 0 0 40 1 0.9 0.7 0.01 0.3",
        build: Build::Scene(|args| {
            let light = Light {
                kind: LightKind::Spot {
                    position: args.vector(0),
                    target: args.vector(3),
                    cone_deg: args.number(6),
                    soft: args.numbers.get(11).copied().unwrap_or(SPOT_SOFT),
                },
                radius: 0.0,
                color: args.optional_vector(7).unwrap_or(DVec3::ONE),
                falloff: args.numbers.get(10).copied().unwrap_or(0.0),
            };
            SceneCommand::SetLight(args.text(0), light)
        }),
    },
    CommandSpec {
        name: "sun",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[
            &[
                name("NAME", NameKind::New),
                number("x", Range::Any),
                number("y", Range::Any),
                number("z", Range::Any),
            ],
            RADIANCE,
        ],
        summary: "adds or replaces a directional light; x y z is the direction towards it",
        default: "r g b 1 1 1",
        example: "sun noon 1 3 2 1 0.95 0.85",
        build: Build::Scene(|args| {
            let light = Light {
                kind: LightKind::Sun { direction: args.vector(0) },
                radius: 0.0,
                color: args.optional_vector(3).unwrap_or(DVec3::ONE),
                falloff: 0.0,
            };
            SceneCommand::SetLight(args.text(0), light)
        }),
    },
    CommandSpec {
        name: "lightRadius",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[&[name("NAME", NameKind::Light), number("radius", Range::NonNegative)]],
        summary: "makes a light a spherical area light of this radius, with soft shadows; for a sun, the tangent of its angular radius",
        default: "0: hard shadows; light, spot and sun reset it",
        example: "lightRadius lamp 0.5",
        build: Build::Scene(|args| SceneCommand::SetLightRadius {
            name: args.text(0),
            radius: args.number(0),
        }),
    },
    CommandSpec {
        name: "unlight",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[&[name("NAME", NameKind::Light)]],
        summary: "removes a light and its keys",
        default: "",
        example: "unlight lamp",
        build: Build::Scene(|args| SceneCommand::RemoveLight(args.text(0))),
    },
    CommandSpec {
        name: "camera",
        spellings: &[],
        group: Group::Scene,
        options: &[],
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
        summary: "sets the position of the camera and the point it looks at; the field of view is vertical, in degrees",
        default: "0 0 10 0 0 0 60: it looks along -z, and y is up (see cameraUp); fov_deg is 60 unless given",
        example: "camera 6 -8 5 0 0 1 40",
        build: Build::Scene(|args| {
            SceneCommand::SetCamera(Camera {
                position: args.vector(0),
                target: args.vector(3),
                fov_deg: args.numbers.get(6).copied().unwrap_or(Camera::DEFAULT_FOV_DEG),
                ..Camera::default()
            })
        }),
    },
    CommandSpec {
        name: "up",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[UP],
        summary: "sets the direction that is up for camera, sky and floor together, also for those set later: x, y or z, or a direction",
        default: "0 1 0",
        example: "up z",
        build: Build::Scene(|args| SceneCommand::SetUp(args.vector(0))),
    },
    CommandSpec {
        name: "frame",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[&[], &[name("NAME", NameKind::Entity)]],
        summary: "moves the camera, along its line of sight, to where all of a primitive or object is in sight; a scene without lights gets one",
        default: "what is selected",
        example: "frame",
        build: Build::Request(|args| Request::Frame(args.optional_text(0))),
    },
    CommandSpec {
        name: "cameraUp",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[UP],
        summary: "sets the direction that is up in the picture",
        default: "0 1 0, or as up sets it",
        example: "cameraUp 0 0 1",
        build: Build::Scene(|args| SceneCommand::SetCameraUp(args.vector(0))),
    },
    CommandSpec {
        name: "orthographic",
        spellings: &["ortho"],
        group: Group::Scene,
        options: &[],
        args: &[&[number("height", Range::NonNegative)]],
        summary: "makes the camera orthographic; height is that of the picture in world units. 0 makes it perspective again",
        default: "0",
        example: "orthographic 8",
        build: Build::Scene(|args| SceneCommand::SetOrthographic(args.number(0))),
    },
    CommandSpec {
        name: "lens",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[&[number("radius", Range::NonNegative)], &[number("focus", Range::Positive)]],
        summary: "sets the lens radius and the focus distance of the camera, for depth of field. 0 makes it a pinhole again",
        default: "0; focus is the current distance from the camera to its target",
        example: "lens 0.2 9",
        build: Build::Scene(|args| SceneCommand::SetLens {
            radius: args.number(0),
            focus: args.numbers.get(1).copied(),
        }),
    },
    CommandSpec {
        name: "background",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[RADIANCE],
        summary: "sets the colour of rays that hit nothing, in linear values",
        default: "0 0 0",
        example: "background 0.2 0.3 0.5",
        build: Build::Scene(|args| SceneCommand::SetBackground(args.vector(0))),
    },
    CommandSpec {
        name: "sky",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[RADIANCE, SECOND_RADIANCE, UP],
        summary: "sets the sky, which replaces the background: one colour, or a gradient from the horizon to the zenith; x y z is up",
        default: "no sky; r2 g2 b2 as r g b, x y z 0 1 0 or as up sets it",
        example: "sky 0.7 0.8 0.9 0.1 0.2 0.6",
        build: Build::Scene(|args| {
            let horizon = args.vector(0);
            let zenith = args.optional_vector(3).unwrap_or(horizon);
            SceneCommand::SetSky { horizon, zenith, up: args.optional_vector(6) }
        }),
    },
    CommandSpec {
        name: "daylight",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[
            &[number("elevation", Range::Within(0.0, 90.0)), number("turbidity", Range::Within(1.7, 10.0))],
            &[number("azimuth", Range::Any)],
        ],
        summary: "sets sun and sky as light of the surroundings, also as 'sky sun': the sun's elevation in degrees, the haze of the air (2 clear, 6 hazy), and the angle of the sun to the right of the direction -z (y, if z is up)",
        default: "none; azimuth 0",
        example: "daylight 30 3 120",
        build: Build::Scene(|args| {
            SceneCommand::SetDaylight(Daylight {
                elevation_deg: args.number(0),
                turbidity: args.number(1),
                azimuth_deg: args.optional_number(2).unwrap_or(0.0),
            })
        }),
    },
    CommandSpec {
        name: "environment",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[&[FILE], &[number("rotation", Range::Any)], &[number("scale", Range::NonNegative)]],
        summary: "sets a picture of the surroundings (.hdr or .exr, equirectangular), which is seen instead of sky and background and lights the scene by 'set light path'; rotation in degrees turns it to the right",
        default: "none; rotation 0, scale 1",
        example: "environment studio.hdr 90",
        build: Build::Scene(|args| {
            SceneCommand::SetEnvironment(EnvironmentPicture {
                file: args.text(0).into(),
                rotation_deg: args.optional_number(0).unwrap_or(0.0),
                scale: args.optional_number(1).unwrap_or(1.0),
            })
        }),
    },
    CommandSpec {
        name: "unenvironment",
        spellings: &["undaylight"],
        group: Group::Scene,
        options: &[],
        args: &[],
        summary: "removes environment or daylight and their keys: sky or background show again",
        default: "",
        example: "unenvironment",
        build: Build::Scene(|_| SceneCommand::RemoveEnvironment),
    },
    CommandSpec {
        name: "unsky",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[],
        summary: "removes the sky and its keys: the background shows again",
        default: "",
        example: "unsky",
        build: Build::Scene(|_| SceneCommand::RemoveSky),
    },
    CommandSpec {
        name: "floor",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[&[number("height", Range::Any)], &[name("SURFACE", NameKind::Primitive)], UP],
        summary: "adds an infinite floor at this height, with the material of a primitive; x y z is its normal",
        default: "no floor; the material of a new primitive, x y z 0 1 0 or as up sets it",
        example: "floor -1 tiles",
        build: Build::Scene(|args| SceneCommand::SetFloor {
            height: args.number(0),
            surface: args.optional_text(0),
            up: args.optional_vector(1),
        }),
    },
    CommandSpec {
        name: "floorUp",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[UP],
        summary: "sets the normal of the floor",
        default: "0 1 0, or as up sets it; floor resets it",
        example: "floorUp 0 0 1",
        build: Build::Scene(|args| SceneCommand::SetFloorUp(args.vector(0))),
    },
    CommandSpec {
        name: "unfloor",
        spellings: &[],
        group: Group::Scene,
        options: &[],
        args: &[],
        summary: "removes the floor and its keys",
        default: "",
        example: "unfloor",
        build: Build::Scene(|_| SceneCommand::RemoveFloor),
    },
    CommandSpec {
        name: "ambientOcclusion",
        spellings: &["ao"],
        group: Group::Scene,
        options: &[],
        args: &[&[
            number("samples", Range::Whole(0, MOST_OCCLUSION_SAMPLES)),
            number("distance", Range::Positive),
        ]],
        summary: "sets ambient occlusion: the number of rays from each point, and the distance beyond which nothing occludes. 0 samples turn it off; 'ao' with two numbers is this, else addObject",
        default: "off",
        example: "ambientOcclusion 16 2",
        build: Build::Scene(|args| {
            let (samples, distance) = (args.whole(0), args.number(1));
            SceneCommand::SetAmbientOcclusion((samples > 0).then_some(AmbientOcclusion { samples, distance }))
        }),
    },
    CommandSpec {
        name: "setDepth",
        spellings: &["depth"],
        group: Group::Scene,
        options: &[],
        args: &[&[number("levels", Range::Whole(0, MAX_DEPTH))]],
        summary: "sets the recursion depth of objects: the selected one is level 1, primitives of the last level are included",
        default: "25",
        example: "setDepth 8",
        build: Build::Scene(|args| SceneCommand::SetDepth(args.whole(0))),
    },
    CommandSpec {
        name: "key",
        spellings: &[],
        group: Group::Animation,
        options: &[],
        args: &[&[number("FRAME", Range::Any), arg("COMMAND", ArgKind::Line)]],
        summary: "adds a keyframe: the numbers of a command at a frame, for the selected entity and the child at the cursor. Between keys the numbers are interpolated smoothly, and the command runs after all others",
        default: "",
        example: "key 24 rotate 0 0 1 90",
        build: Build::Scene(|args| SceneCommand::SetKey { frame: args.number(0), words: args.texts() }),
    },
    CommandSpec {
        name: "unkey",
        spellings: &[],
        group: Group::Animation,
        options: &[],
        args: &[&[name("FRAME|all", NameKind::KeyFrame)], &[name("COMMAND", NameKind::Command)]],
        summary: "removes the keys at a frame, or all; with COMMAND only those of that command for the selected entity",
        default: "",
        example: "unkey 24 rotate",
        build: Build::Scene(|args| SceneCommand::RemoveKeys {
            frame: args.text(0),
            command: args.optional_text(1),
        }),
    },
    CommandSpec {
        name: "render",
        spellings: &["render!"],
        group: Group::Pictures,
        options: &[],
        args: &[&[], &[FILE], &[arg("WxH", ArgKind::Size)]],
        summary: "ray traces the selected entity into a picture (.png, or .exr for linear values), in the background; 'stop render' stops it and keeps what is done; render! also replaces a read-only picture, and one of another program that has the default name",
        default: "the scene's name with .png, and the size of 'set size'",
        example: "render robot.png 640x480",
        build: Build::Request(|args| Request::Render {
            file: args.optional_text(0),
            size: args.size,
            is_forced: args.is_forced(),
        }),
    },
    CommandSpec {
        name: "preview",
        spellings: &[],
        group: Group::Pictures,
        options: &[],
        args: &[&[], &[number("FRAME", Range::Any)]],
        summary: "ray traces the selected entity into the terminal, at a frame if one is given",
        default: "without keys",
        example: "preview",
        build: Build::Request(|args| Request::Preview(args.numbers.first().copied())),
    },
    CommandSpec {
        name: "view",
        spellings: &[],
        group: Group::Pictures,
        options: &[],
        args: &[],
        summary: "opens the viewer",
        default: "",
        example: "view",
        build: Build::Request(|_| Request::View),
    },
    CommandSpec {
        name: "iotest",
        spellings: &[],
        group: Group::Pictures,
        options: &[],
        args: &[&[], VECTOR],
        summary: "tests whether a point is inside, by the inside-outside function; without a point, tests a grid",
        default: "the grid of 'set ioStep' and 'set ioHalf'",
        example: "iotest 0 0 0.5",
        build: Build::Request(|args| Request::InsideOutside(args.optional_vector(0))),
    },
    CommandSpec {
        name: "intersect",
        spellings: &[],
        group: Group::Pictures,
        options: &[],
        args: &[
            &[],
            &[
                number("ox", Range::Any),
                number("oy", Range::Any),
                number("oz", Range::Any),
                number("dx", Range::Any),
                number("dy", Range::Any),
                number("dz", Range::Any),
            ],
        ],
        summary: "intersects the ray from o along d with the scene: the first hit, and the normal there",
        default: "the central ray of the camera",
        example: "intersect 0 0 10 0 0 -1",
        build: Build::Request(|args| {
            let ray = args.optional_vector(0).zip(args.optional_vector(3));
            Request::Intersect(ray)
        }),
    },
    CommandSpec {
        name: "set",
        spellings: &[],
        group: Group::Pictures,
        options: &[],
        args: &[&[name("SETTING", NameKind::Setting)], &[arg("VALUE", ArgKind::Value)]],
        summary: "changes a setting of the picture, the viewer or the session; 'get' lists them. A line may begin with the setting: samples 16",
        default: "",
        example: "set size 640x480",
        build: Build::Session(|args| match args.optional_text(1) {
            Some(value) => SessionCommand::Set { setting: args.text(0), value },
            None => SessionCommand::Get(vec![args.text(0)]),
        }),
    },
    CommandSpec {
        name: "get",
        spellings: &[],
        group: Group::Pictures,
        options: &[],
        args: &[&[], &[arg("SETTING", ArgKind::Words(NameKind::Setting))]],
        summary: "shows settings with their allowed values",
        default: "all",
        example: "get size",
        build: Build::Session(|args| SessionCommand::Get(args.texts())),
    },
];

/// The only spelling of two commands: addObject and ambientOcclusion. The parser decides by the
/// arguments.
pub(crate) const SHARED_SPELLING: &str = "ao";

/// The command with this spelling; case is ignored. For `ao` it is addObject.
pub fn find_command(word: &str) -> Option<&'static CommandSpec> {
    commands_spelt(word).next()
}

/// Every command with this spelling; case is ignored.
pub(crate) fn commands_spelt(word: &str) -> impl Iterator<Item = &'static CommandSpec> {
    let alike = word.bytes().next().map_or(&[][..], |first| &BY_FIRST_LETTER[usize::from(first)]);
    // Most words are spelt as here, and that is found faster.
    let is_spelt = move |spelling: &str| {
        spelling.len() == word.len() && (spelling == word || spelling.eq_ignore_ascii_case(word))
    };
    alike.iter().filter(move |(spelling, _)| is_spelt(spelling)).map(|(_, spec)| *spec)
}

/// The spellings with their commands, by their first byte in either case: files may have 100,000
/// lines.
static BY_FIRST_LETTER: LazyLock<[Vec<(&str, &CommandSpec)>; 256]> = LazyLock::new(|| {
    let all = || COMMANDS.iter().flat_map(|spec| spec.all_spellings().map(move |spelling| (spelling, spec)));
    std::array::from_fn(|first| {
        let begins = |spelling: &str| spelling.as_bytes()[..1].eq_ignore_ascii_case(&[first as u8]);
        all().filter(|(spelling, _)| begins(spelling)).collect()
    })
});

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn no_two_commands_share_a_spelling() {
        let mut seen = HashSet::new();
        for spelling in COMMANDS.iter().flat_map(CommandSpec::all_spellings) {
            assert!(seen.insert(spelling.to_lowercase()) || spelling == SHARED_SPELLING, "{spelling} twice");
        }
        let shared: Vec<&str> = commands_spelt("AO").map(|spec| spec.name).collect();
        assert_eq!(shared, ["addObject", "ambientOcclusion"]);
    }

    #[test]
    fn words_come_last_and_only_there() {
        for spec in COMMANDS {
            let position =
                spec.all_args().position(|arg| matches!(arg.kind, ArgKind::Words(_) | ArgKind::Line));
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
        assert_eq!(find_command("help").unwrap().usage(), "[WORD ...]");
        assert_eq!(find_command("pwd").unwrap().usage(), "");
        assert_eq!(find_command("stop").unwrap().usage(), "[render]");
    }
}
