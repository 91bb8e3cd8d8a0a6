//! Arrays made element by element, inside of kernels.

/// The array of `value(0)`, `value(1)`, …
///
/// Like [`std::array::from_fn`], but always inlined: a closure that stays a function of its own is not compiled for the
/// instructions of the kernel that calls it, and then every operation on lanes in it is a function call.
#[inline(always)]
pub fn array<T: Copy, const N: usize>(mut value: impl FnMut(usize) -> T) -> [T; N] {
    let mut all = [value(0); N];
    for (i, place) in all.iter_mut().enumerate().skip(1) {
        *place = value(i);
    }
    all
}

/// A closure that is always inlined, for kernels that call one more than once: see [`array()`].
#[macro_export]
macro_rules! inlined {
    ($($closure:tt)+) => {{
        #[inline(always)]
        $($closure)+
    }};
}
