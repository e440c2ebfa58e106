//! Vectors of f32 lanes with operators, roots, logarithms and powers of two; masks of lanes.

#![allow(
    clippy::manual_memcpy,
    clippy::needless_range_loop,
    clippy::redundant_closure,
    clippy::redundant_closure_for_method_calls,
    reason = "only what is written out is inlined for the lanes of the machine"
)]

use std::f32::consts::LOG2_E;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use pulp::Simd;

#[cfg(target_arch = "x86_64")]
use crate::arch::{avx2, avx512};

/// `K` registers of f32 lanes, default: 1. The operations on several registers are independent of each other, which hides
/// the latency of each.
#[derive(Clone, Copy)]
pub struct Lanes<S: Simd, const K: usize = 1> {
    simd: S,
    registers: [S::f32s; K],
}

/// A truth value for each lane.
#[derive(Clone, Copy)]
pub struct Mask<S: Simd, const K: usize = 1> {
    simd: S,
    registers: [S::m32s; K],
}

impl<S: Simd> Lanes<S> {
    /// One register.
    #[inline(always)]
    pub fn new(simd: S, register: S::f32s) -> Self {
        Self { simd, registers: [register] }
    }

    /// The register itself.
    #[inline(always)]
    pub fn register(self) -> S::f32s {
        self.registers[0]
    }

    /// Another register of the same width.
    #[inline(always)]
    pub fn with(self, register: S::f32s) -> Self {
        Self::new(self.simd, register)
    }

    /// Writes the lanes of a mask side by side (stream compaction), and undefined numbers after them up to the length of a
    /// register. Without AVX-512 it writes the register unchanged. [`Mask::packed`] is the number of lanes written.
    #[inline(always)]
    pub fn pack(self, mask: Mask<S>, to: &mut [f32]) {
        let to = &mut to[..S::F32_LANES];
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = avx512(self.simd) {
            let x = pulp::bytemuck::cast(self.registers[0]);
            let packed = v4.avx512f._mm512_maskz_compress_ps(mask.bits() as u16, x);
            return to.copy_from_slice(&pulp::bytemuck::cast::<_, [f32; 16]>(packed));
        }
        to.copy_from_slice(pulp::bytemuck::cast_slice(std::slice::from_ref(&self.registers[0])));
    }

    /// Reads the lanes of a mask that [`Self::pack`] has written, back into their own positions.
    #[inline(always)]
    pub fn unpack(simd: S, mask: u32, from: &[f32]) -> Self {
        let from = &from[..S::F32_LANES];
        let mut register = simd.splat_f32s(0.0);
        pulp::bytemuck::cast_slice_mut(std::slice::from_mut(&mut register)).copy_from_slice(from);
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = avx512(simd) {
            let x = pulp::bytemuck::cast(register);
            register = pulp::bytemuck::cast(v4.avx512f._mm512_maskz_expand_ps(mask as u16, x));
        }
        Self::new(simd, register)
    }
}

impl<S: Simd, const K: usize> Lanes<S, K> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, x: f32) -> Self {
        Self { simd, registers: [simd.splat_f32s(x); K] }
    }

    /// Loads the `K` registers of a slice from register `i` on. The slice has a multiple of `S::F32_LANES` numbers; a
    /// remainder is not read.
    #[inline(always)]
    pub fn load(simd: S, from: &[f32], i: usize) -> Self {
        let from = S::as_simd_f32s(from).0;
        let mut registers = [from[i]; K];
        for k in 1..K {
            registers[k] = from[i + k];
        }
        Self { simd, registers }
    }

    /// Stores into the `K` registers of a slice from register `i` on.
    #[inline(always)]
    pub fn store(self, to: &mut [f32], i: usize) {
        let to = S::as_mut_simd_f32s(to).0;
        for k in 0..K {
            to[i + k] = self.registers[k];
        }
    }

    /// Joins `K` single registers.
    #[inline(always)]
    pub fn join(parts: [Lanes<S>; K]) -> Self {
        let mut registers = [parts[0].registers[0]; K];
        for k in 1..K {
            registers[k] = parts[k].registers[0];
        }
        Self { simd: parts[0].simd, registers }
    }

    /// Register `k`.
    #[inline(always)]
    pub fn part(self, k: usize) -> Lanes<S> {
        Lanes { simd: self.simd, registers: [self.registers[k]] }
    }

    /// The same number in every lane, of the same width as `self`.
    #[inline(always)]
    pub fn all(self, x: f32) -> Self {
        Self::splat(self.simd, x)
    }

    #[inline(always)]
    fn each(mut self, of: impl Fn(S, S::f32s) -> S::f32s) -> Self {
        for register in &mut self.registers {
            *register = of(self.simd, *register);
        }
        self
    }

    #[inline(always)]
    fn zip(mut self, other: Self, of: impl Fn(S, S::f32s, S::f32s) -> S::f32s) -> Self {
        for k in 0..K {
            self.registers[k] = of(self.simd, self.registers[k], other.registers[k]);
        }
        self
    }

    #[inline(always)]
    fn compare(self, other: Self, of: impl Fn(S, S::f32s, S::f32s) -> S::m32s) -> Mask<S, K> {
        let mut registers = [of(self.simd, self.registers[0], other.registers[0]); K];
        for k in 1..K {
            registers[k] = of(self.simd, self.registers[k], other.registers[k]);
        }
        Mask { simd: self.simd, registers }
    }

    /// `self * a + b`, fused where the machine can.
    #[inline(always)]
    pub fn mul_add(mut self, a: Self, b: Self) -> Self {
        for k in 0..K {
            self.registers[k] = self.simd.mul_add_e_f32s(self.registers[k], a.registers[k], b.registers[k]);
        }
        self
    }

    /// The absolute value.
    #[inline(always)]
    pub fn abs(self) -> Self {
        self.each(|simd, x| simd.abs_f32s(x))
    }

    /// The square root of numbers >= 0.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.each(|simd, x| simd.sqrt_f32s(x))
    }

    /// The smaller of two.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, |simd, a, b| simd.min_f32s(a, b))
    }

    /// The larger of two.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |simd, a, b| simd.max_f32s(a, b))
    }

    /// True where `self < other`.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask<S, K> {
        self.compare(other, |simd, a, b| simd.less_than_f32s(a, b))
    }

    /// True where `self <= other`.
    #[inline(always)]
    pub fn le(self, other: Self) -> Mask<S, K> {
        self.compare(other, |simd, a, b| simd.less_than_or_equal_f32s(a, b))
    }

    /// The least of the lanes.
    #[inline(always)]
    pub fn least(self) -> f32 {
        let mut least = f32::INFINITY;
        for register in self.registers {
            least = least.min(self.simd.reduce_min_f32s(register));
        }
        least
    }

    /// The largest of the lanes.
    #[inline(always)]
    pub fn largest(self) -> f32 {
        -(-self).least()
    }

    /// 1 / x for |x| in [1e-30, 1e30], relative error below 1e-4; by one fast instruction with AVX-512.
    #[inline(always)]
    pub fn recip_rough(self) -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = avx512(self.simd) {
            return self
                .each(|_, x| pulp::bytemuck::cast(v4.avx512f._mm512_rcp14_ps(pulp::bytemuck::cast(x))));
        }
        self.all(1.0) / self
    }

    /// 1 / x for |x| in [1e-30, 1e30], to two units of the last place.
    #[inline(always)]
    pub fn recip(self) -> Self {
        let rough = self.recip_rough();
        (-self).mul_add(rough, self.all(1.0)).mul_add(rough, rough)
    }

    /// 1 / sqrt x for x in [1e-38, 1e38], to three units of the last place.
    #[inline(always)]
    pub fn rsqrt(self) -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = avx512(self.simd) {
            let rough =
                self.each(|_, x| pulp::bytemuck::cast(v4.avx512f._mm512_rsqrt14_ps(pulp::bytemuck::cast(x))));
            // One step of Newton's for 1 / y^2 = x.
            let rest = (-(self * rough)).mul_add(rough, self.all(1.0));
            return (rough * self.all(0.5)).mul_add(rest, rough);
        }
        self.all(1.0) / self.sqrt()
    }

    /// The square root of a finite number, relative error below 1e-4. For x < 1e-30, also negative, a number in [0, 1e-15].
    #[inline(always)]
    pub fn root_rough(self) -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = avx512(self.simd) {
            let x = self.max(self.all(1e-30));
            let inverse =
                x.each(|_, x| pulp::bytemuck::cast(v4.avx512f._mm512_rsqrt14_ps(pulp::bytemuck::cast(x))));
            return x * inverse;
        }
        self.max(self.all(0.0)).sqrt()
    }

    /// `self` with the sign of `other`, for `self` >= 0.
    #[inline(always)]
    pub fn with_sign_of(self, other: Self) -> Self {
        self.zip(other, |simd, x, other| {
            let sign = simd.and_u32s(simd.transmute_u32s_f32s(other), simd.splat_u32s(0x8000_0000));
            simd.transmute_f32s_u32s(simd.or_u32s(simd.transmute_u32s_f32s(x), sign))
        })
    }

    /// 1 with the sign of this.
    #[inline(always)]
    pub fn with_unit_sign(self) -> Self {
        self.all(1.0).with_sign_of(self)
    }

    /// `self` with its sign turned where `other` is negative.
    #[inline(always)]
    pub fn times_sign_of(self, other: Self) -> Self {
        self.zip(other, |simd, x, other| {
            let sign = simd.and_u32s(simd.transmute_u32s_f32s(other), simd.splat_u32s(0x8000_0000));
            simd.transmute_f32s_u32s(simd.xor_u32s(simd.transmute_u32s_f32s(x), sign))
        })
    }

    /// k and m of x = 2^k m with m in [3/4, 3/2), for a normal x below 2^127.
    #[inline(always)]
    fn exponent_and_mantissa(self) -> (Self, Self) {
        // Adding this carries into the exponent from 3/2 on.
        const TO_SPLIT: u32 = 0x3f80_0000 - 0x3f40_0000;
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = avx512(self.simd) {
            use core::arch::x86_64::{_MM_MANT_NORM_P75_1P5, _MM_MANT_SIGN_SRC};
            let mantissa = self.each(|_, x| {
                let x = pulp::bytemuck::cast(x);
                let m = v4.avx512f._mm512_getmant_ps::<_MM_MANT_NORM_P75_1P5, _MM_MANT_SIGN_SRC>(x);
                pulp::bytemuck::cast(m)
            });
            // Moves the boundary from 2 to 3/2.
            let exponent = (self * self.all(4.0 / 3.0))
                .each(|_, x| pulp::bytemuck::cast(v4.avx512f._mm512_getexp_ps(pulp::bytemuck::cast(x))));
            return (exponent, mantissa);
        }
        let (mut exponent, mut mantissa) = (self, self);
        for k in 0..K {
            let simd = self.simd;
            let bits = simd.transmute_u32s_f32s(self.registers[k]);
            let shift = simd.splat_u32s(23);
            let power = simd.wrapping_dyn_shr_u32s(simd.add_u32s(bits, simd.splat_u32s(TO_SPLIT)), shift);
            let m = simd.add_u32s(
                simd.sub_u32s(bits, simd.wrapping_dyn_shl_u32s(power, shift)),
                simd.splat_u32s(0x3f80_0000),
            );
            mantissa.registers[k] = simd.transmute_f32s_u32s(m);
            // Converts k to f32: these are the bits of 2^23 + k.
            exponent.registers[k] =
                simd.transmute_f32s_u32s(simd.or_u32s(power, simd.splat_u32s(0x4b00_0000)));
        }
        (exponent - self.all(8_388_608.0 + 127.0), mantissa)
    }

    /// log2 x of a normal x > 0 below 2^127 without a division; relative error of the result below 4e-7, near 1 too.
    #[inline(always)]
    pub fn log2_quick(self) -> Self {
        let (exponent, m) = self.exponent_and_mantissa();
        let u = m - self.all(1.0);
        // log2(1 + u) / u; coefficients fitted to 3e-8.
        let series = u.polynomial([
            LOG2_E,
            -0.721_348_5,
            0.480_902_08,
            -0.360_575_9,
            0.288_191_5,
            -0.242_723_52,
            0.216_324_91,
            -0.174_230_26,
            0.078_066_714,
        ]);
        series.mul_add(u, exponent)
    }

    /// The sum of c\[i\] x^i by pairs of terms: a chain of five dependent steps.
    #[inline(always)]
    fn polynomial(self, c: [f32; 9]) -> Self {
        let pair = |i: usize| self.all(c[i + 1]).mul_add(self, self.all(c[i]));
        let square = self * self;
        let fourth = square * square;
        let low = pair(2).mul_add(square, pair(0));
        let high = pair(6).mul_add(square, pair(4));
        self.all(c[8]).mul_add(fourth, high).mul_add(fourth, low)
    }

    /// log2(1 + x) for x in [0, 1], relative error below 3e-7.
    #[inline(always)]
    pub fn log2_of_one_plus(self) -> Self {
        let series = self.polynomial([
            LOG2_E,
            -0.721_340_24,
            0.480_693_07,
            -0.358_409_23,
            0.275_643_83,
            -0.197_123_44,
            0.112_860_925,
            -0.042_569_723,
            0.007_549_798_6,
        ]);
        series * self
    }

    /// 2^x for x in [-1/2, 1/2]; coefficients fitted to 3e-9.
    #[inline(always)]
    fn exp2_of_half(self) -> Self {
        let (square, one) = (self * self, self.all(1.0));
        let low = self.all(6.931_472e-1).mul_add(self, one);
        let middle = self.all(5.550_327e-2).mul_add(self, self.all(2.402_265e-1));
        let high = self.all(1.340_042_8e-3).mul_add(self, self.all(9.618_057e-3));
        let high = self.all(1.546_144_5e-4).mul_add(square, high);
        high.mul_add(square, middle).mul_add(square, low)
    }

    /// 2^x for x <= 127, relative error below 2e-7; 2^-126 for x < -126.
    #[inline(always)]
    pub fn exp2(self) -> Self {
        self.max(self.all(-126.0)).exp2_quick()
    }

    /// 2^x for x in [-126, 127], relative error below 2e-7.
    #[inline(always)]
    pub fn exp2_quick(self) -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = avx512(self.simd) {
            // The difference from the nearest integer.
            let f = self.each(|_, x| {
                pulp::bytemuck::cast(v4.avx512dq._mm512_reduce_ps::<0>(pulp::bytemuck::cast(x)))
            });
            return f.exp2_of_half().zip(self - f, |_, p, whole| {
                let power = v4.avx512f._mm512_scalef_ps(pulp::bytemuck::cast(p), pulp::bytemuck::cast(whole));
                pulp::bytemuck::cast(power)
            });
        }
        // Adding 1.5 * 2^23 leaves the nearest integer in the low bits.
        let magic = self.all(12_582_912.0);
        let whole = self + magic;
        let f = self - (whole - magic);
        f.exp2_of_half().zip(whole, |simd, p, whole| {
            let scale = simd.wrapping_dyn_shl_u32s(simd.transmute_u32s_f32s(whole), simd.splat_u32s(23));
            simd.transmute_f32s_u32s(simd.add_u32s(simd.transmute_u32s_f32s(p), scale))
        })
    }
}

impl<S: Simd> Mask<S> {
    /// From a bit for each lane.
    #[inline(always)]
    pub fn of_bits(simd: S, bits: u32) -> Self {
        const NUMBERS: [u32; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
        let numbers = S::as_simd_u32s(&NUMBERS).0[0];
        let one = simd.splat_u32s(1);
        let bit = simd.and_u32s(simd.wrapping_dyn_shr_u32s(simd.splat_u32s(bits), numbers), one);
        Self { simd, registers: [simd.equal_u32s(bit, one)] }
    }

    /// The number of lanes that [`Lanes::pack`] writes for this mask.
    #[inline(always)]
    pub fn packed(self) -> usize {
        #[cfg(target_arch = "x86_64")]
        if avx512(self.simd).is_some() {
            return self.bits().count_ones() as usize;
        }
        S::F32_LANES
    }

    /// True where two integers are equal.
    #[inline(always)]
    pub(crate) fn of_equal(simd: S, a: S::u32s, b: S::u32s) -> Self {
        Self { simd, registers: [simd.equal_u32s(a, b)] }
    }

    /// The lanes that it was made for.
    #[inline(always)]
    pub(crate) fn simd(self) -> S {
        self.simd
    }

    /// `a` where true, `b` elsewhere, for integers.
    #[inline(always)]
    pub(crate) fn select_u32(self, a: S::u32s, b: S::u32s) -> S::u32s {
        self.simd.select_u32s(self.registers[0], a, b)
    }

    /// A bit for each lane.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = avx2(self.simd) {
            return v3.avx._mm256_movemask_ps(pulp::bytemuck::cast(self.registers[0])) as u32;
        }
        let bytes = pulp::bytemuck::bytes_of(&self.registers[0]);
        match *bytes {
            [bits] => u32::from(bits),
            [low, high] => u32::from(u16::from_le_bytes([low, high])),
            _ => bytes
                .chunks_exact(4)
                .enumerate()
                .fold(0, |bits, (i, lane)| bits | u32::from(lane[3] >> 7) << i),
        }
    }
}

impl<S: Simd, const K: usize> Mask<S, K> {
    /// From bits: bit `lane` belongs to a lane of the `K` registers from register `i` on.
    #[inline(always)]
    pub fn of_bits_from(simd: S, bits: u32, i: usize) -> Self {
        let first = Mask::<S>::of_bits(simd, bits >> (i * S::F32_LANES));
        let mut registers = [first.registers[0]; K];
        for k in 1..K {
            registers[k] = Mask::<S>::of_bits(simd, bits >> ((i + k) * S::F32_LANES)).registers[0];
        }
        Self { simd, registers }
    }

    /// The bits of all registers, at the positions of register `i` on.
    #[inline(always)]
    pub fn bits_from(self, i: usize) -> u32 {
        let mut bits = 0;
        for k in 0..K {
            bits |= self.part(k).bits() << ((i + k) * S::F32_LANES);
        }
        bits
    }

    /// Register `k`.
    #[inline(always)]
    pub fn part(self, k: usize) -> Mask<S> {
        Mask { simd: self.simd, registers: [self.registers[k]] }
    }

    /// `a` where true, `b` elsewhere.
    #[inline(always)]
    pub fn select(self, a: Lanes<S, K>, mut b: Lanes<S, K>) -> Lanes<S, K> {
        for k in 0..K {
            b.registers[k] = self.simd.select_f32s(self.registers[k], a.registers[k], b.registers[k]);
        }
        b
    }

    #[inline(always)]
    fn zip(mut self, other: Self, of: impl Fn(S, S::m32s, S::m32s) -> S::m32s) -> Self {
        for k in 0..K {
            self.registers[k] = of(self.simd, self.registers[k], other.registers[k]);
        }
        self
    }

    /// True in these lanes and not in `other`'s.
    #[inline(always)]
    pub fn and_not(self, other: Self) -> Self {
        self.zip(other, |simd, a, b| simd.and_m32s(a, simd.not_m32s(b)))
    }

    /// Whether any lane is true.
    #[inline(always)]
    pub fn any(self) -> bool {
        let mut all = self.registers[0];
        for &register in &self.registers[1..] {
            all = self.simd.or_m32s(all, register);
        }
        self.simd.first_true_m32s(all) < S::F32_LANES
    }
}

impl<S: Simd, const K: usize> BitAnd for Mask<S, K> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        self.zip(other, |simd, a, b| simd.and_m32s(a, b))
    }
}

impl<S: Simd, const K: usize> BitOr for Mask<S, K> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        self.zip(other, |simd, a, b| simd.or_m32s(a, b))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl<S: Simd, const K: usize> $trait for Lanes<S, K> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |simd, a, b| simd.$instruction(a, b))
            }
        }
    };
}

operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

impl<S: Simd, const K: usize> Neg for Lanes<S, K> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|simd, x| simd.neg_f32s(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, Debug)]
    enum Function {
        Log2Quick,
        Log2OfOnePlus,
        Exp2,
        Recip,
        RecipRough,
        Rsqrt,
        RootRough,
    }

    type Truth = fn(f64) -> f64;

    /// A function of numbers in place.
    struct Apply<'a>(Function, &'a mut [f32]);

    impl pulp::WithSimd for Apply<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for register in S::as_mut_simd_f32s(self.1).0 {
                let x = Lanes::<S>::new(simd, *register);
                let y = match self.0 {
                    Function::Log2Quick => x.log2_quick(),
                    Function::Log2OfOnePlus => x.log2_of_one_plus(),
                    Function::Exp2 => x.exp2(),
                    Function::Recip => x.recip(),
                    Function::RecipRough => x.recip_rough(),
                    Function::Rsqrt => x.rsqrt(),
                    Function::RootRough => x.root_rough(),
                };
                *register = y.register();
            }
        }
    }

    /// The values of a function by each kind of lanes that this machine has.
    fn values(function: Function, x: &[f32]) -> Vec<Vec<f32>> {
        let mut all = vec![x.to_vec(), x.to_vec()];
        pulp::WithSimd::with_simd(Apply(function, &mut all[0]), pulp::Scalar);
        pulp::Arch::new().dispatch(Apply(function, &mut all[1]));
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = pulp::x86::V3::try_new() {
            let mut values = x.to_vec();
            pulp::Simd::vectorize(v3, Apply(function, &mut values));
            all.push(values);
        }
        all
    }

    #[test]
    fn functions_have_their_stated_error_by_all_kinds_of_lanes() {
        // A prime stride over the bit patterns of all normal numbers from 2^-126 to 2^127.
        let normal = (0x0080_0000..0x7f00_0000u32).step_by(4_099).map(f32::from_bits);
        let near_one = (0x3f00_0000..0x4000_0000u32).step_by(97).map(f32::from_bits);
        let normal: Vec<f32> = normal.chain(near_one).collect();
        let within = |least: f32, most: f32| -> Vec<f32> {
            normal.iter().copied().filter(|x| (least..most).contains(x)).collect()
        };
        let exponents = || (-126_000..127_000).map(|i| i as f32 / 1000.0).collect();
        let up_to_one = || (1..=1_000_000).map(|i| i as f32 / 1e6).collect();
        let of_one_plus = |x: f64| x.ln_1p() / std::f64::consts::LN_2;
        let last_place = f64::from(f32::EPSILON) / 2.0;
        let cases: [(Function, Vec<f32>, Truth, f64); 7] = [
            (Function::Log2Quick, normal.clone(), f64::log2, 4e-7),
            (Function::Log2OfOnePlus, up_to_one(), of_one_plus, 3e-7),
            (Function::Exp2, exponents(), f64::exp2, 2e-7),
            (Function::Recip, within(1e-30, 1e30), f64::recip, 2.0 * last_place),
            (Function::RecipRough, within(1e-30, 1e30), f64::recip, 1e-4),
            (Function::Rsqrt, within(1e-38, 1e38), |x| 1.0 / x.sqrt(), 3.0 * last_place),
            (Function::RootRough, within(1e-30, 1e38), f64::sqrt, 1e-4),
        ];
        for (function, mut samples, truth, most) in cases {
            samples.truncate(samples.len() / 16 * 16);
            assert!(samples.len() > 100_000, "{function:?}");
            for (kind, values) in values(function, &samples).into_iter().enumerate() {
                for (&x, value) in samples.iter().zip(values) {
                    let truth = truth(f64::from(x));
                    let error = (f64::from(value) - truth).abs() / truth.abs().max(1e-37);
                    assert!(error < most, "{function:?} {kind}: {value} at {x}, {error}");
                }
            }
        }
    }

    /// Packs registers and unpacks them.
    struct PackAndUnpack([f32; 16], u32);

    impl pulp::WithSimd for PackAndUnpack {
        type Output = ([f32; 16], usize);

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> ([f32; 16], usize) {
            let Self(x, mask) = self;
            let (mut packed, mut count) = ([f32::NAN; 32], 0);
            let mut firsts = [0; 16];
            let below = |i: usize| (mask >> (i * S::F32_LANES)) & (u32::MAX >> (32 - S::F32_LANES));
            for i in 0..16 / S::F32_LANES {
                let lanes = Mask::of_bits(simd, below(i));
                firsts[i] = count;
                Lanes::<S>::new(simd, S::as_simd_f32s(&x).0[i]).pack(lanes, &mut packed[count..]);
                count += lanes.packed();
            }
            let mut back = [f32::NAN; 16];
            for i in 0..16 / S::F32_LANES {
                let register = Lanes::<S>::unpack(simd, below(i), &packed[firsts[i]..]).register();
                S::as_mut_simd_f32s(&mut back).0[i] = register;
            }
            (back, count)
        }
    }

    #[test]
    fn packed_lanes_come_back_to_their_places() {
        let x = std::array::from_fn(|i| i as f32);
        for mask in 0..=0xffff {
            for (back, count) in [
                pulp::Arch::new().dispatch(PackAndUnpack(x, mask)),
                pulp::WithSimd::with_simd(PackAndUnpack(x, mask), pulp::Scalar),
            ] {
                assert!((mask.count_ones() as usize..=16).contains(&count));
                for lane in (0..16).filter(|lane| mask >> lane & 1 == 1) {
                    assert_eq!(back[lane], x[lane], "{mask:x}");
                }
            }
        }
    }

    struct Bits(u32);

    impl pulp::WithSimd for Bits {
        type Output = u32;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> u32 {
            let all = if S::F32_LANES < 32 { (1 << S::F32_LANES) - 1 } else { u32::MAX };
            Mask::<S>::of_bits(simd, self.0 & all).bits() | (self.0 & !all)
        }
    }

    #[test]
    fn bits_become_lanes_and_lanes_bits() {
        for i in 0..32 {
            for bits in [1u32 << i, !(1 << i), 0x9e37_79b9_u32.rotate_left(i)] {
                assert_eq!(pulp::Arch::new().dispatch(Bits(bits)), bits);
                assert_eq!(pulp::WithSimd::with_simd(Bits(bits), pulp::Scalar), bits);
            }
        }
    }

    #[test]
    fn powers_of_extremes_are_finite() {
        let of = |x: f32| Lanes::splat(pulp::Scalar, x);
        assert_eq!(of(1.0).log2_quick().register(), 0.0);
        assert_eq!(of(-1e30).exp2().register(), 2f32.powi(-126));
        assert_eq!(of(0.0).exp2().register(), 1.0);
    }
}
