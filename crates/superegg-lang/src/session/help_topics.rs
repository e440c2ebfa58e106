//! Topics of the help that are neither commands nor groups nor settings.

/// A topic, found by any of its words.
pub(crate) struct Topic {
    pub(crate) words: &'static [&'static str],
    pub(crate) title: &'static str,
    /// Lines of two columns, before the commands.
    pub(crate) lines: &'static [(&'static str, &'static str)],
    pub(crate) commands: &'static [&'static str],
    pub(crate) settings: &'static [&'static str],
}

/// The first lines of a new user, and what they do. They can be typed as they stand.
pub(crate) const FIRST_STEPS: &[(&str, &str)] = &[
    ("primitive ball", "makes a sphere, and selects it"),
    ("color orange; exponent 0.4 0.4", "changes what is selected; exponents: 1 round, 0 square, 2 pointed"),
    ("object pair", "makes an object, a group of children"),
    ("addPrimitive ball left", "adds the primitive as a child"),
    ("addPrimitive ball right", "adds it once more; the cursor is on this child"),
    ("translate 2.5 0 0; rotate z 30", "moves the child at the cursor"),
    ("frame; preview", "moves the camera to where all is in sight; draws here"),
    ("render pair.png; save pair", "makes a picture; writes the scene"),
];

/// Every topic.
pub(crate) const TOPICS: &[Topic] = &[
    Topic {
        words: &["material", "materials"],
        title: "Materials: the selected primitive has one",
        lines: &[],
        commands: &[
            "setColor",
            "setAmbient",
            "setDiffuse",
            "setSpecular",
            "setGloss",
            "setShininess",
            "setReflected",
            "setRefracted",
            "setIndex",
            "setFresnel",
            "setAbsorb",
            "setEmission",
            "setRoughness",
            "setMetallic",
            "setPattern",
            "setTexture",
        ],
        settings: &["glossRays", "bounces"],
    },
    Topic {
        words: &["glass", "mirror", "transparency"],
        title: "Mirrors and glass",
        lines: &[
            ("a mirror", "primitive ball; reflected 0.8; diffuse 0.1"),
            ("glass", "primitive ball; refracted 0.9; reflected 1; fresnel on; index 1.5; diffuse 0"),
        ],
        commands: &["setReflected", "setRefracted", "setIndex", "setFresnel", "setAbsorb"],
        settings: &["bounces", "leastWeight", "glossRays"],
    },
    Topic {
        words: &["lights", "lighting", "shadow", "shadows"],
        title: "Lights; without any there is a default one",
        lines: &[("light by way of surfaces, and from the sky", "set light path")],
        commands: &[
            "light",
            "spot",
            "sun",
            "lightRadius",
            "unlight",
            "sky",
            "daylight",
            "environment",
            "background",
            "ambientOcclusion",
            "setEmission",
        ],
        settings: &["light", "lightRays", "exposure"],
    },
    Topic {
        words: &["transform", "transforms", "move"],
        title: "Transforms: of the child at the cursor, or with 'All' of the whole object; in the order written",
        lines: &[],
        commands: &[
            "setCursor",
            "translate",
            "rotate",
            "scale",
            "orient",
            "matrix",
            "translateAll",
            "rotateAll",
            "scaleAll",
            "orientAll",
            "matrixAll",
        ],
        settings: &[],
    },
    Topic {
        words: &["keys", "keyboard", "shortcuts"],
        title: "Keys at the prompt",
        lines: &[
            ("tab", "completes commands, names, files, settings and values"),
            ("right, end", "take over the rest of a command's name"),
            ("up, down", "earlier lines; ctrl-r searches them"),
            (
                "ctrl-a, ctrl-e",
                "to the beginning, to the end of the line; ctrl-w deletes a word, ctrl-u the line before the cursor",
            ),
            ("ctrl-c", "clears the line, stops the command that runs, or on an empty line the renders"),
            ("ctrl-l", "clears the terminal"),
            ("ctrl-d", "leaves, on an empty line"),
            ("in the window", "h shows its keys"),
        ],
        commands: &["key", "unkey"],
        settings: &[],
    },
    Topic {
        words: &["colors", "colours"],
        title: "Colours",
        lines: &[
            ("orange, tomato", "148 names of CSS; tab completes them"),
            ("#ff8000, #f80", "8-bit sRGB values, as in other programs"),
            ("1 0.22 0", "red, green and blue as linear values from 0 to 1; of light also above 1"),
        ],
        commands: &["setColor", "setPattern", "setTexture", "background", "sky"],
        settings: &["encoding"],
    },
    Topic {
        words: &["syntax", "language", "lines"],
        title: "Lines",
        lines: &[
            ("# text", "a comment, to the end of the line"),
            ("one; two", "several commands; the ; ends a word or stands alone"),
            ("SETCOLOR, color", "case does not matter in commands; many have short names"),
            ("\"my file.scn\"", "a file name with blanks"),
            ("samples 16", "the name of a setting stands for 'set samples 16'"),
        ],
        commands: &[],
        settings: &[],
    },
    Topic {
        words: &["quality", "noise-free", "antialiasing", "anti-aliasing"],
        title: "Quality of pictures",
        lines: &[],
        commands: &["render", "preview"],
        settings: &["size", "samples", "noise", "mostSamples", "filter", "lightRays", "glossRays", "bounces"],
    },
    Topic {
        words: &["window", "viewer"],
        title: "The window; in it h shows the keys",
        lines: &[],
        commands: &["view", "interact"],
        settings: &["wireframe", "shading", "normals", "axes", "ioTest", "intersectTest", "lightsTurn"],
    },
];
