//! Stands in for the bake until it is here: slopes by the taps of `along`, no more.

use super::{Stencil, Taps, stencil::TAPS};
use crate::tableau::DoubleDouble as D;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    #[default]
    Wrap,
    Clamp,
    Mirror,
    OneSided,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Green {
    Up,
    Down,
}

pub trait Height: Copy {
    fn value(self) -> f32;
}
impl Height for u8 {
    fn value(self) -> f32 {
        f32::from(self) / 255.0
    }
}
impl Height for u16 {
    fn value(self) -> f32 {
        f32::from(self) / 65535.0
    }
}
impl Height for f32 {
    fn value(self) -> f32 {
        self
    }
}

pub trait Normal: Copy {
    fn pack(n: [f32; 3]) -> Self;
}
impl Normal for [f32; 3] {
    fn pack(n: [f32; 3]) -> Self {
        n
    }
}
fn level(x: f32, most: f32) -> f32 {
    ((x + 1.0) / 2.0 * most + 0.5).floor()
}
impl Normal for [u8; 3] {
    fn pack(n: [f32; 3]) -> Self {
        n.map(|x| level(x, 255.0) as u8)
    }
}
impl Normal for [u16; 3] {
    fn pack(n: [f32; 3]) -> Self {
        n.map(|x| level(x, 65535.0) as u16)
    }
}
impl Normal for [u8; 2] {
    fn pack(n: [f32; 3]) -> Self {
        [n[0], n[1]].map(|x| level(x, 255.0) as u8)
    }
}
impl Normal for [u16; 2] {
    fn pack(n: [f32; 3]) -> Self {
        [n[0], n[1]].map(|x| level(x, 65535.0) as u16)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Heights<'a, H> {
    texels: &'a [H],
    width: usize,
    height: usize,
}

impl<'a, H: Height> Heights<'a, H> {
    pub fn new(texels: &'a [H], width: usize, height: usize) -> Result<Self, BakeError> {
        if texels.len() == width * height { Ok(Self { texels, width, height }) } else { Err(BakeError) }
    }
}

#[derive(Debug)]
pub struct BakeError;
impl std::fmt::Display for BakeError {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "1 heights are not finite, the first at column 0, row 0")
    }
}

#[derive(Clone, Copy)]
pub struct Bake<'s> {
    stencil: &'s Stencil<'s>,
    scale: f64,
    texel: [f64; 2],
    border: [Border; 2],
    green: Green,
}

impl<'s> Bake<'s> {
    pub fn new(stencil: &'s Stencil<'s>) -> Self {
        Self { stencil, scale: 1.0, texel: [1.0; 2], border: [Border::Wrap; 2], green: Green::Up }
    }
    pub fn height_scale(self, scale: f64) -> Self {
        Self { scale, ..self }
    }
    pub fn texel_size(self, texel: [f64; 2]) -> Self {
        Self { texel, ..self }
    }
    pub fn border(self, border: [Border; 2]) -> Self {
        Self { border, ..self }
    }
    pub fn green(self, green: Green) -> Self {
        Self { green, ..self }
    }
    pub fn best_fit(self, _: bool) -> Self {
        self
    }
    pub fn missing_as_border(self, _: bool) -> Self {
        self
    }

    pub fn slopes(&self, b: &Heights<impl Height>) -> Result<Vec<[f32; 2]>, BakeError> {
        if b.texels.iter().any(|h| !h.value().is_finite()) {
            return Err(BakeError);
        }
        let find = |border, i: isize, n: usize| match border {
            Border::Wrap => i.rem_euclid(n as isize) as usize,
            _ => i.clamp(0, n as isize - 1) as usize,
        };
        let at = |x: isize, y: isize| {
            let (x, y) = (find(self.border[0], x, b.width), find(self.border[1], y, b.height));
            f64::from(b.texels[y * b.width + x].value())
        };
        let taps = &self.stencil.along;
        let sum = |f: &dyn Fn(isize) -> f64| -> f64 {
            (0..taps.len).map(|j| taps.weight[j].hi() * f(taps.first + j as isize)).sum()
        };
        let mut out = vec![];
        for y in 0..b.height as isize {
            for x in 0..b.width as isize {
                let slope = [sum(&|j| at(x + j, y)), sum(&|j| at(x, y - j))];
                let scaled = [0, 1].map(|i| (slope[i] * self.scale / self.texel[i]) as f32);
                out.push(scaled);
            }
        }
        Ok(out)
    }

    pub fn normals<N: Normal>(&self, b: &Heights<impl Height>) -> Result<Vec<N>, BakeError> {
        let side = if self.green == Green::Up { 1.0 } else { -1.0 };
        let normal = |[b_s, b_t]: [f32; 2]| {
            let length = (b_s * b_s + b_t * b_t + 1.0).sqrt();
            N::pack([-b_s / length, -b_t * side / length, 1.0 / length])
        };
        Ok(self.slopes(b)?.into_iter().map(normal).collect())
    }
}

pub mod stencils {
    use super::*;

    pub struct Entry {
        pub name: &'static str,
        pub stencil: Stencil<'static>,
    }

    const ONE: Taps = {
        let mut weight = [D::of(0.0); TAPS];
        weight[0] = D::of(1.0);
        Taps { first: 0, len: 1, weight }
    };

    const fn stencil(title: &'static str, first: isize, taps: &[f64], at: f64) -> Stencil<'static> {
        let mut weight = [D::of(0.0); TAPS];
        let mut i = 0;
        while i < taps.len() {
            weight[i] = D::of(taps[i]);
            i += 1;
        }
        let along = Taps { first, len: taps.len(), weight };
        let (cite, note) = ("", "");
        Stencil {
            title,
            cite,
            note,
            order: taps.len() - 1,
            digits: 0,
            at: D::of(at),
            along,
            across: ONE,
            left: ONE,
        }
    }

    static ALL: [Entry; 3] = [
        Entry { name: "forward2", stencil: stencil("forward", 0, &[-1.0, 1.0], 0.5) },
        Entry { name: "central2", stencil: stencil("central", -1, &[-0.5, 0.0, 0.5], 0.0) },
        Entry {
            name: "central4",
            stencil: stencil("central", -2, &[1.0 / 12.0, -2.0 / 3.0, 0.0, 2.0 / 3.0, -1.0 / 12.0], 0.0),
        },
    ];

    pub fn all() -> &'static [Entry] {
        &ALL
    }

    pub fn find(name: &str) -> Option<&'static Entry> {
        ALL.iter().find(|entry| entry.name == name)
    }
}

pub struct Level {
    pub width: usize,
    pub height: usize,
    pub slopes: Vec<[f32; 2]>,
}

pub fn mips(slopes: Vec<[f32; 2]>, width: usize, height: usize) -> Result<Vec<Level>, BakeError> {
    let mut levels = vec![Level { width, height, slopes }];
    while let Some(last) = levels.last().filter(|level| level.width * level.height > 1) {
        let (width, height) = ((last.width / 2).max(1), (last.height / 2).max(1));
        let (p, q) = (last.width / width, last.height / height);
        let mean = |i: usize| {
            let (x, y) = (i % width * p, i / width * q);
            let all = (0..p * q).map(|k| last.slopes[(y + k / p) * last.width + x + k % p]);
            all.fold([0.0; 2], |sum, b| [0, 1].map(|i| sum[i] + b[i] / (p * q) as f32))
        };
        let slopes = (0..width * height).map(mean).collect();
        levels.push(Level { width, height, slopes });
    }
    Ok(levels)
}

impl Bake<'_> {
    pub fn pack<N: Normal>(&self, slopes: &[[f32; 2]]) -> Vec<N> {
        let side = if self.green == Green::Up { 1.0 } else { -1.0 };
        let normal = |&[b_s, b_t]: &[f32; 2]| {
            let length = (b_s * b_s + b_t * b_t + 1.0).sqrt();
            N::pack([-b_s / length, -b_t * side / length, 1.0 / length])
        };
        slopes.iter().map(normal).collect()
    }
}
