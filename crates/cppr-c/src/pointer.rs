//! What callers hand over, checked as far as it can be: null, alignment, size, UTF-8.

use crate::status::{cppr_code, say};
use cppr::Vector3;
use std::ffi::{CStr, c_char};

type Checked<T> = Result<T, cppr_code>;

fn refuse<T>(pointer: *const T, what: &str) -> Checked<()> {
    if pointer.is_null() {
        return Err(say(cppr_code::BadArgument, format_args!("{what} is a null pointer")));
    }
    if !pointer.is_aligned() {
        return Err(say(cppr_code::BadArgument, format_args!("{what} points to no whole number of values")));
    }
    Ok(())
}

/// What a pointer points to.
///
/// # Safety
/// Not null, it points to a `T` that outlives `'a` and is not changed meanwhile.
pub(crate) unsafe fn object<'a, T>(pointer: *const T, what: &str) -> Checked<&'a T> {
    refuse(pointer, what)?;
    // SAFETY: not null, aligned; the rest is the caller's promise.
    Ok(unsafe { &*pointer })
}

fn fits<T>(count: usize, what: &str) -> Checked<()> {
    if count.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX.unsigned_abs()) {
        return Err(say(cppr_code::BadArgument, format_args!("{what} cannot have {count} values")));
    }
    Ok(())
}

/// An array of `count` values.
///
/// # Safety
/// Not null, it points to `count` values that outlive `'a` and are not changed meanwhile.
pub(crate) unsafe fn array<'a, T>(pointer: *const T, count: usize, what: &str) -> Checked<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    refuse(pointer, what)?;
    fits::<T>(count, what)?;
    // SAFETY: not null, aligned, of a size that can be; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// An array of `count` numbers to be written, set to NaN: what is not written later shows.
///
/// # Safety
/// Not null, it points to memory for `count` numbers that nobody else uses during `'a`.
pub(crate) unsafe fn output<'a>(pointer: *mut f64, count: usize, what: &str) -> Checked<&'a mut [f64]> {
    if count == 0 {
        return Ok(&mut []);
    }
    refuse(pointer, what)?;
    fits::<f64>(count, what)?;
    // SAFETY: not null, aligned, of a size that can be; the memory is the caller's promise. Writing first makes it values.
    unsafe {
        for i in 0..count {
            pointer.add(i).write(f64::NAN);
        }
        Ok(std::slice::from_raw_parts_mut(pointer, count))
    }
}

/// A vector of three numbers.
///
/// # Safety
/// Not null, it points to three numbers.
pub(crate) unsafe fn vector(pointer: *const f64, what: &str) -> Checked<Vector3<f64>> {
    // SAFETY: the caller's promise.
    let three = unsafe { array(pointer, 3, what) }?;
    Ok(Vector3::from_column_slice(three))
}

/// The same; zero for a null pointer.
///
/// # Safety
/// Not null, it points to three numbers.
pub(crate) unsafe fn vector_or_zero(pointer: *const f64, what: &str) -> Checked<Vector3<f64>> {
    if pointer.is_null() {
        return Ok(Vector3::zeros());
    }
    // SAFETY: the caller's promise.
    unsafe { vector(pointer, what) }
}

/// A text in UTF-8.
///
/// # Safety
/// Not null, it points to bytes that end with 0 and outlive `'a`.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Checked<&'a str> {
    refuse(pointer, what)?;
    // SAFETY: not null; the rest is the caller's promise.
    let bytes = unsafe { CStr::from_ptr(pointer) };
    let code = cppr_code::BadArgument;
    bytes.to_str().map_err(|error| say(code, format_args!("{what} is not UTF-8: {error}")))
}
