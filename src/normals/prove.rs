//! The proof of a stencil: its moments are what its claims need, to double-double accuracy.

use super::moments::Moments;
use super::stencil::{Stencil, Taps};
use crate::tableau::{Broken, DoubleDouble as D, TableauError, Text, tolerance};

/// Proves that the stencil gives a plane its exact slope and leaks nothing of the other axis, the claimed
/// order, that the error is isotropic up to h^isotropic, that taps lying symmetrically have opposite weights
/// along the axis and the same across it, and that a compact left side can be solved.
pub(crate) const fn prove(stencil: &Stencil, isotropic: usize) -> Result<(), TableauError> {
    let tolerance = tolerance(stencil.digits);
    if !dominant(&stencil.left) {
        let text = "the left side cannot be solved safely: its weight at 0 must outweigh the others";
        return Err(broken(Broken::Shape, 0.0, Text::new().str(text)));
    }
    let highest = if isotropic + 1 > stencil.order { isotropic + 1 } else { stencil.order };
    let moments = Moments::of(stencil, stencil.at, highest);
    let laws = match exact_on_planes(&moments, tolerance) {
        Ok(()) => order(&moments, stencil.order, tolerance),
        error => error,
    };
    let laws = match laws {
        Ok(()) => isotropy(&moments, isotropic, tolerance),
        error => error,
    };
    match laws {
        Ok(()) => symmetry(stencil, tolerance),
        error => error,
    }
}

const fn broken(what: Broken, off: f64, text: Text) -> TableauError {
    TableauError::new(what, 0, off, text)
}

/// NaN is off.
const fn close(off: D, tolerance: f64) -> bool {
    off.hi().abs() <= tolerance
}

const fn dominant(left: &Taps) -> bool {
    let (mut middle, mut others, mut j) = (0.0, 0.0, 0);
    while j < left.len {
        let weight = left.weight[j].hi().abs();
        if left.first + j as isize == 0 {
            middle = weight;
        } else {
            others += weight;
        }
        j += 1;
    }
    middle > others
}

/// `the moment M_30`
const fn moment(along: usize, across: usize) -> Text {
    let text = Text::new().str("the moment M_").number(along);
    // 12 and 0 would read as 1 and 20.
    let text = if along > 9 || across > 9 { text.str(",") } else { text };
    text.number(across)
}

const fn off_by(text: Text, off: D, why: &str) -> TableauError {
    broken(Broken::Moment, off.hi(), text.str(" is off by ").size(off.hi()).str(": ").str(why))
}

const fn exact_on_planes(moments: &Moments, tolerance: f64) -> Result<(), TableauError> {
    let Moments { along, across, scale_along, scale_across } = moments;
    if !close(along[0], tolerance * scale_along[0]) {
        return Err(off_by(moment(0, 0), along[0], "the weights must sum to 0"));
    }
    let ramp = along[1].minus(D::ONE);
    if !close(ramp, tolerance * scale_along[1]) {
        return Err(off_by(moment(1, 0), ramp, "a ramp must have the slope 1"));
    }
    let sum = across[0].minus(D::ONE);
    if !close(sum, tolerance * scale_across[0]) {
        return Err(off_by(Text::new().str("the sum of the smoothing row"), sum, "it must be 1"));
    }
    if !close(across[1], tolerance * scale_across[1]) {
        return Err(off_by(moment(1, 1), across[1], "the slope of the other axis leaks in"));
    }
    Ok(())
}

/// M_p0 = 0 for p from 2 to the order, M_1q = 0 for 1 + q up to it; of the other mixed moments each has a
/// factor of these.
const fn order(moments: &Moments, order: usize, tolerance: f64) -> Result<(), TableauError> {
    let mut p = 2;
    while p <= order {
        let why = Text::new().str("order ").number(order).str(" needs 0");
        if !close(moments.along[p], tolerance * moments.scale_along[p]) {
            return Err(off_by(moment(p, 0), moments.along[p], why.as_str()));
        }
        if !close(moments.across[p - 1], tolerance * moments.scale_across[p - 1]) {
            return Err(off_by(moment(1, p - 1), moments.across[p - 1], why.as_str()));
        }
        p += 1;
    }
    Ok(())
}

/// The terms of the symbol of even degree vanish, those of odd degree are multiples of
/// z_x (z_x^2 + z_y^2)^m.
const fn isotropy(moments: &Moments, isotropic: usize, tolerance: f64) -> Result<(), TableauError> {
    let mut degree = 2;
    while degree <= isotropic + 1 {
        let mut q = 0;
        while q < degree {
            let (off, scale) = moments.anisotropy(degree - q, q);
            if !close(off, tolerance * scale) {
                let why = Text::new().str("the error in h^").number(degree - 1).str(" is not isotropic");
                return Err(off_by(moment(degree - q, q), off, why.as_str()));
            }
            q += 1;
        }
        degree += 1;
    }
    Ok(())
}

const fn symmetry(stencil: &Stencil, tolerance: f64) -> Result<(), TableauError> {
    let Stencil { along, across, left, at, .. } = stencil;
    if across.first + across.last() != 0 {
        let text = Text::new().str("the smoothing row does not lie symmetrically about 0");
        return Err(broken(Broken::Symmetry, 0.0, text));
    }
    match mirrored(across, D::ONE, " of the smoothing row differ", tolerance) {
        Ok(()) => {}
        error => return error,
    }
    if left.first + left.last() == 0 {
        match mirrored(left, D::ONE, " of the left side differ", tolerance) {
            Ok(()) => {}
            error => return error,
        }
    }
    // One-sided tables and those leaning to one side have no mirror image.
    if (along.first + along.last()) as f64 == 2.0 * at.hi() {
        return mirrored(along, D::ONE.neg(), " are not opposite", tolerance);
    }
    Ok(())
}

/// Each weight is `sign` times the one in the mirror.
const fn mirrored(taps: &Taps, sign: D, how: &str, tolerance: f64) -> Result<(), TableauError> {
    let mut j = 0;
    while j < taps.len {
        let k = taps.len - 1 - j;
        let off = taps.weight[k].minus(taps.weight[j].times(sign));
        if !close(off, tolerance) {
            let text = offset(Text::new().str("the weights at "), taps.first + j as isize).str(" and ");
            let text = offset(text, taps.first + k as isize).str(how).str(": off by ").size(off.hi());
            return Err(broken(Broken::Symmetry, off.hi(), text));
        }
        j += 1;
    }
    Ok(())
}

const fn offset(text: Text, j: isize) -> Text {
    let text = if j < 0 { text.str("-") } else { text };
    text.number(j.unsigned_abs())
}
