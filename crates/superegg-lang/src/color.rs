//! Colours in one word: `#ff8000`, `#f80`, or a name of CSS.

use superegg_geom::glam::DVec3;

/// The colour of a word, in linear values; `None` if it is not a colour.
///
/// `#rrggbb`, `#rgb` (each digit twice) and the 148 names of CSS Color Module Level 4 are sRGB
/// values. They become the linear values that the sRGB curve of `set encoding srgb` takes back to
/// the same bytes. Case is ignored.
///
/// ```
/// use superegg_lang::parse_color;
///
/// let orange = parse_color("#ff8000").unwrap();
/// assert_eq!((orange.x, orange.z), (1.0, 0.0));
/// assert!((orange.y - 0.2158605).abs() < 1e-7);
/// assert_eq!(parse_color("Tomato"), parse_color("#ff6347"));
/// assert_eq!(parse_color("#f80"), parse_color("#ff8800"));
/// assert_eq!(parse_color("#ff80"), None);
/// ```
pub fn parse_color(word: &str) -> Option<DVec3> {
    let rgb = match word.strip_prefix('#') {
        Some(digits) => hexadecimal(digits)?,
        None => named(word)?,
    };
    let linear = |shift: u32| linear_of_srgb(f64::from((rgb >> shift) & 0xff) / 255.0);
    Some(DVec3::new(linear(16), linear(8), linear(0)))
}

/// The names of all named colours, in alphabetical order.
pub(crate) fn color_names() -> impl Iterator<Item = &'static str> {
    NAMED.iter().map(|(name, _)| *name)
}

/// Whether the characters after a `#` are a colour.
pub(crate) fn is_hexadecimal(digits: &str) -> bool {
    hexadecimal(digits).is_some()
}

/// Three or six hexadecimal digits as 0xRRGGBB.
fn hexadecimal(digits: &str) -> Option<u32> {
    // The sign that `from_str_radix` allows is not a digit.
    if !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let value = u32::from_str_radix(digits, 16).ok()?;
    match digits.len() {
        6 => Some(value),
        3 => Some(
            [value >> 8, value >> 4 & 0xf, value & 0xf].into_iter().fold(0, |rgb, d| (rgb << 8) | (d * 0x11)),
        ),
        _ => None,
    }
}

fn named(word: &str) -> Option<u32> {
    let lower = word.to_ascii_lowercase();
    let at = NAMED.binary_search_by_key(&lower.as_str(), |(name, _)| name).ok()?;
    Some(NAMED[at].1)
}

/// The sRGB curve (IEC 61966-2-1) from an encoded value, [0, 1], to a linear one.
fn linear_of_srgb(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The named colours of CSS Color Module Level 4, as 0xRRGGBB, in alphabetical order.
const NAMED: [(&str, u32); 148] = [
    ("aliceblue", 0xf0f8ff),
    ("antiquewhite", 0xfaebd7),
    ("aqua", 0x00ffff),
    ("aquamarine", 0x7fffd4),
    ("azure", 0xf0ffff),
    ("beige", 0xf5f5dc),
    ("bisque", 0xffe4c4),
    ("black", 0x000000),
    ("blanchedalmond", 0xffebcd),
    ("blue", 0x0000ff),
    ("blueviolet", 0x8a2be2),
    ("brown", 0xa52a2a),
    ("burlywood", 0xdeb887),
    ("cadetblue", 0x5f9ea0),
    ("chartreuse", 0x7fff00),
    ("chocolate", 0xd2691e),
    ("coral", 0xff7f50),
    ("cornflowerblue", 0x6495ed),
    ("cornsilk", 0xfff8dc),
    ("crimson", 0xdc143c),
    ("cyan", 0x00ffff),
    ("darkblue", 0x00008b),
    ("darkcyan", 0x008b8b),
    ("darkgoldenrod", 0xb8860b),
    ("darkgray", 0xa9a9a9),
    ("darkgreen", 0x006400),
    ("darkgrey", 0xa9a9a9),
    ("darkkhaki", 0xbdb76b),
    ("darkmagenta", 0x8b008b),
    ("darkolivegreen", 0x556b2f),
    ("darkorange", 0xff8c00),
    ("darkorchid", 0x9932cc),
    ("darkred", 0x8b0000),
    ("darksalmon", 0xe9967a),
    ("darkseagreen", 0x8fbc8f),
    ("darkslateblue", 0x483d8b),
    ("darkslategray", 0x2f4f4f),
    ("darkslategrey", 0x2f4f4f),
    ("darkturquoise", 0x00ced1),
    ("darkviolet", 0x9400d3),
    ("deeppink", 0xff1493),
    ("deepskyblue", 0x00bfff),
    ("dimgray", 0x696969),
    ("dimgrey", 0x696969),
    ("dodgerblue", 0x1e90ff),
    ("firebrick", 0xb22222),
    ("floralwhite", 0xfffaf0),
    ("forestgreen", 0x228b22),
    ("fuchsia", 0xff00ff),
    ("gainsboro", 0xdcdcdc),
    ("ghostwhite", 0xf8f8ff),
    ("gold", 0xffd700),
    ("goldenrod", 0xdaa520),
    ("gray", 0x808080),
    ("green", 0x008000),
    ("greenyellow", 0xadff2f),
    ("grey", 0x808080),
    ("honeydew", 0xf0fff0),
    ("hotpink", 0xff69b4),
    ("indianred", 0xcd5c5c),
    ("indigo", 0x4b0082),
    ("ivory", 0xfffff0),
    ("khaki", 0xf0e68c),
    ("lavender", 0xe6e6fa),
    ("lavenderblush", 0xfff0f5),
    ("lawngreen", 0x7cfc00),
    ("lemonchiffon", 0xfffacd),
    ("lightblue", 0xadd8e6),
    ("lightcoral", 0xf08080),
    ("lightcyan", 0xe0ffff),
    ("lightgoldenrodyellow", 0xfafad2),
    ("lightgray", 0xd3d3d3),
    ("lightgreen", 0x90ee90),
    ("lightgrey", 0xd3d3d3),
    ("lightpink", 0xffb6c1),
    ("lightsalmon", 0xffa07a),
    ("lightseagreen", 0x20b2aa),
    ("lightskyblue", 0x87cefa),
    ("lightslategray", 0x778899),
    ("lightslategrey", 0x778899),
    ("lightsteelblue", 0xb0c4de),
    ("lightyellow", 0xffffe0),
    ("lime", 0x00ff00),
    ("limegreen", 0x32cd32),
    ("linen", 0xfaf0e6),
    ("magenta", 0xff00ff),
    ("maroon", 0x800000),
    ("mediumaquamarine", 0x66cdaa),
    ("mediumblue", 0x0000cd),
    ("mediumorchid", 0xba55d3),
    ("mediumpurple", 0x9370db),
    ("mediumseagreen", 0x3cb371),
    ("mediumslateblue", 0x7b68ee),
    ("mediumspringgreen", 0x00fa9a),
    ("mediumturquoise", 0x48d1cc),
    ("mediumvioletred", 0xc71585),
    ("midnightblue", 0x191970),
    ("mintcream", 0xf5fffa),
    ("mistyrose", 0xffe4e1),
    ("moccasin", 0xffe4b5),
    ("navajowhite", 0xffdead),
    ("navy", 0x000080),
    ("oldlace", 0xfdf5e6),
    ("olive", 0x808000),
    ("olivedrab", 0x6b8e23),
    ("orange", 0xffa500),
    ("orangered", 0xff4500),
    ("orchid", 0xda70d6),
    ("palegoldenrod", 0xeee8aa),
    ("palegreen", 0x98fb98),
    ("paleturquoise", 0xafeeee),
    ("palevioletred", 0xdb7093),
    ("papayawhip", 0xffefd5),
    ("peachpuff", 0xffdab9),
    ("peru", 0xcd853f),
    ("pink", 0xffc0cb),
    ("plum", 0xdda0dd),
    ("powderblue", 0xb0e0e6),
    ("purple", 0x800080),
    ("rebeccapurple", 0x663399),
    ("red", 0xff0000),
    ("rosybrown", 0xbc8f8f),
    ("royalblue", 0x4169e1),
    ("saddlebrown", 0x8b4513),
    ("salmon", 0xfa8072),
    ("sandybrown", 0xf4a460),
    ("seagreen", 0x2e8b57),
    ("seashell", 0xfff5ee),
    ("sienna", 0xa0522d),
    ("silver", 0xc0c0c0),
    ("skyblue", 0x87ceeb),
    ("slateblue", 0x6a5acd),
    ("slategray", 0x708090),
    ("slategrey", 0x708090),
    ("snow", 0xfffafa),
    ("springgreen", 0x00ff7f),
    ("steelblue", 0x4682b4),
    ("tan", 0xd2b48c),
    ("teal", 0x008080),
    ("thistle", 0xd8bfd8),
    ("tomato", 0xff6347),
    ("turquoise", 0x40e0d0),
    ("violet", 0xee82ee),
    ("wheat", 0xf5deb3),
    ("white", 0xffffff),
    ("whitesmoke", 0xf5f5f5),
    ("yellow", 0xffff00),
    ("yellowgreen", 0x9acd32),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_order_so_that_each_is_found() {
        assert!(NAMED.windows(2).all(|pair| pair[0].0 < pair[1].0));
        for (name, rgb) in NAMED {
            assert_eq!(parse_color(&name.to_uppercase()), parse_color(&format!("#{rgb:06X}")), "{name}");
            let other = name.replace("gray", "grey");
            assert_eq!(parse_color(&other), parse_color(name), "{other}");
        }
        for (name, rgb) in [
            ("aliceblue", "#f0f8ff"),
            ("green", "#008000"),
            ("lime", "#00ff00"),
            ("rebeccapurple", "#663399"),
            ("slategrey", "#708090"),
            ("white", "#fff"),
            ("yellowgreen", "#9acd32"),
        ] {
            assert!(parse_color(name).is_some() && parse_color(name) == parse_color(rgb), "{name}");
        }
    }

    #[test]
    fn each_byte_comes_back_through_the_curve() {
        for byte in 0..=255_u32 {
            let linear = parse_color(&format!("#{byte:02x}0000")).unwrap().x;
            let encoded =
                if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
            assert_eq!((encoded * 255.0).round() as u32, byte);
        }
    }

    #[test]
    fn other_words_are_no_colours() {
        for word in [
            "",
            "#",
            "#ff",
            "#ff80",
            "#fffff",
            "#ff8000ff",
            "#+f8000",
            "#ggg",
            "transparent",
            "ff8000",
            "größe",
        ] {
            assert_eq!(parse_color(word), None, "{word}");
        }
    }
}
