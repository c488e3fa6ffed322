//! Mip levels of slopes: the slope of an area's mean height is the mean of its slopes, which no mean of
//! normals, let alone of colours, is.

use super::error::BakeError;

/// A level of slopes, the top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    pub width: usize,
    pub height: usize,
    pub slopes: Vec<[f32; 2]>,
}

/// All levels, from the slopes themselves to a single texel. Each is half the last one, rounded down, and each
/// of its texels is the mean over the area it covers, parts of texels counted by their part: exact for odd
/// sizes too, where it is taken from the first level.
pub fn mips(slopes: Vec<[f32; 2]>, width: usize, height: usize) -> Result<Vec<Level>, BakeError> {
    match width.checked_mul(height) {
        None | Some(0) => return Err(BakeError::Size { width, height }),
        Some(need) if need != slopes.len() => return Err(BakeError::Length { len: slopes.len(), need }),
        Some(_) => {}
    }
    let mut levels = vec![Level { width, height, slopes }];
    loop {
        let (first, last) = (&levels[0], &levels[levels.len() - 1]);
        if last.width * last.height == 1 {
            return Ok(levels);
        }
        let (width, height) = ((last.width / 2).max(1), (last.height / 2).max(1));
        // A part of a mean is no mean of a part: what does not divide is taken from the first level.
        let whole =
            last.width.is_multiple_of(width) && last.height.is_multiple_of(height) && divides(first, last);
        levels.push(mean(if whole { last } else { first }, width, height));
    }
}

fn divides(first: &Level, last: &Level) -> bool {
    first.width.is_multiple_of(last.width) && first.height.is_multiple_of(last.height)
}

/// The texels that part i of n covers on a line of `size`, with the part of each that it covers.
fn covered(i: usize, n: usize, size: usize) -> impl Iterator<Item = (usize, f64)> {
    // In units of 1/n of a texel, all numbers are whole.
    let (from, to) = (i * size, (i + 1) * size);
    (from / n..to.div_ceil(n)).map(move |x| {
        let part = to.min((x + 1) * n) - from.max(x * n);
        (x, part as f64 / size as f64)
    })
}

fn mean(of: &Level, width: usize, height: usize) -> Level {
    let columns: Vec<Vec<_>> = (0..width).map(|x| covered(x, width, of.width).collect()).collect();
    let mut slopes = Vec::with_capacity(width * height);
    let mut row = vec![[0f64; 2]; of.width];
    for y in 0..height {
        row.fill([0.0; 2]);
        for (y, part) in covered(y, height, of.height) {
            for (sum, slope) in row.iter_mut().zip(&of.slopes[y * of.width..]) {
                for (sum, slope) in sum.iter_mut().zip(slope) {
                    *sum += part * f64::from(*slope);
                }
            }
        }
        slopes.extend(columns.iter().map(|column| {
            let sum = column
                .iter()
                .fold([0.0; 2], |[s, t], &(x, part)| [s + part * row[x][0], t + part * row[x][1]]);
            sum.map(|x| x as f32)
        }));
    }
    Level { width, height, slopes }
}
