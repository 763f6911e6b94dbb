//! Points and vectors in space.

/// A point or a vector: x, y, z.
pub type Point = [f64; 3];

/// The smaller of two numbers, the first of equals; the first where they cannot be compared.
///
/// Differs from `f64::min`: that may return either zero, and never returns NaN.
#[inline(always)]
pub fn min(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The larger of two numbers, the first of equals; the first where they cannot be compared.
#[inline(always)]
pub fn max(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Return `a - b`.
#[inline(always)]
pub fn subtract(a: &Point, b: &Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Return the inner product.
#[inline(always)]
pub fn dot(a: &Point, b: &Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Return the cross product.
#[inline(always)]
pub fn cross(a: &Point, b: &Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Return the length.
#[inline(always)]
pub fn length(a: &Point) -> f64 {
    dot(a, a).sqrt()
}
