//! Tone curves: from linear light of any brightness to linear values from 0 to 1.

use superegg_scene::Tone;

/// Exposure and tone mapping.
#[derive(Clone, Copy)]
pub(crate) struct ToneCurve {
    /// The factor of the exposure.
    pub(crate) gain: f32,
    pub(crate) tone: Tone,
}

impl ToneCurve {
    /// Applies both to a linear colour. The result may exceed [0, 1].
    pub(crate) fn apply(self, [r, g, b]: [f32; 3]) -> [f32; 3] {
        let exposed = [r * self.gain, g * self.gain, b * self.gain];
        match self.tone {
            Tone::None => exposed,
            Tone::Reinhard => reinhard(exposed),
            Tone::Filmic => exposed.map(filmic),
            Tone::Aces => aces(exposed),
            Tone::Agx => agx(exposed),
        }
    }
}

/// The luminance that [`reinhard`] maps to white.
const REINHARD_WHITE: f32 = 4.0;

/// Scales a colour so that its luminance x becomes x (1 + x / w^2) / (1 + x) (Reinhard et al. 2002,
/// equation 4). The hue does not change.
fn reinhard(color: [f32; 3]) -> [f32; 3] {
    let [r, g, b] = color;
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let scale = (1.0 + luminance / (REINHARD_WHITE * REINHARD_WHITE)) / (1.0 + luminance);
    // The scale is NaN for infinite light, which stays infinite and so white.
    if luminance > 0.0 && scale > 0.0 { color.map(|value| value * scale) } else { color }
}

/// The fit of Narkowicz (2015) to the ACES film curve, for one channel.
fn filmic(value: f32) -> f32 {
    // The squares of large values would overflow; the curve is constant there.
    let x = value.clamp(0.0, 1e6);
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

/// Values above this are white in every curve, and their squares would overflow.
const BRIGHTEST: f32 = 1e6;

/// The product of a matrix, given by rows, and a colour.
fn product(rows: [[f32; 3]; 3], [r, g, b]: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * r + row[1] * g + row[2] * b)
}

/// The fit of Stephen Hill to the reference rendering and display transforms of ACES 1.0, from linear Rec. 709 to the
/// same (in BakingLab by M. Pettineo and D. Neubelt, MIT licence). Bright colours turn white, since the curve applies to
/// mixed channels.
fn aces(color: [f32; 3]) -> [f32; 3] {
    const INTO: [[f32; 3]; 3] =
        [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    const OUT: [[f32; 3]; 3] =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let curve =
        |x: f32| (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081);
    product(OUT, product(INTO, color.map(|x| x.clamp(0.0, BRIGHTEST))).map(curve))
}

/// AgX of Troy Sobotka in the approximation of Benjamin Wrensch (MIT licence): mixed channels, sixteen and a half stops
/// of their logarithm, a polynomial, and the channels unmixed. Its values are encoded by a power of 2.2, which is undone
/// here.
fn agx(color: [f32; 3]) -> [f32; 3] {
    const INTO: [[f32; 3]; 3] = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_655, 0.078_433_6, 0.879_143],
    ];
    const OUT: [[f32; 3]; 3] = [
        [1.196_879, -0.098_020_88, -0.099_029_74],
        [-0.052_896_85, 1.151_903_1, -0.098_961_18],
        [-0.052_971_635, -0.098_043_45, 1.151_073_7],
    ];
    const STOPS: [f32; 2] = [-12.473_93, 4.026_069];
    let contrast = |x: f32| {
        let (x2, x4) = (x * x, x * x * x * x);
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232
    };
    let curve =
        |x: f32| contrast((x.max(1e-10).log2().clamp(STOPS[0], STOPS[1]) - STOPS[0]) / (STOPS[1] - STOPS[0]));
    let mixed = product(INTO, color.map(|x| x.clamp(0.0, BRIGHTEST)));
    product(OUT, mixed.map(curve)).map(|x| x.max(0.0).powf(2.2))
}
