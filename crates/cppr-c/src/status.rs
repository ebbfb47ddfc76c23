//! How a call ended: a code, and the sentence behind it, kept for each thread.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, c_char};
use std::fmt::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Version of the binary interface. It changes only where a compiled program would no longer work; functions and enumerators are
/// added without a change.
pub const CPPR_ABI: u32 = 1;

/// How a call ended. Negative: it failed, and cppr_error_text() says why.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum cppr_code {
    /// Done; of a solve: a stable equilibrium.
    Ok = 0,
    /// A solve found an equilibrium that the robot leaves at the slightest disturbance. It can be read like a stable one.
    Unstable = 1,
    /// A solve found no equilibrium: cppr_solver_explain() says why. The next warm start goes from the last one found.
    NoEquilibrium = 2,
    /// A null pointer, a wrong size, an unknown number, no UTF-8.
    BadArgument = -1,
    /// The robot file cannot be read or describes no robot.
    BadRobot = -2,
    /// The command cannot be asked of this robot. Nothing was solved.
    BadCommand = -3,
    /// What is to be read does not exist: no equilibrium was found, or it has no derivative (at a fold).
    NoValue = -4,
    /// Another thread is using this solver.
    Busy = -5,
    /// A fault of the library; the solver is as new. Please report it.
    Internal = -6,
}

/// Room for the sentence before it grows: no refusal of a command is longer, so that it allocates once per thread.
const ROOM: usize = 1024;

thread_local! {
    static TEXT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

struct Sentence<'a>(&'a mut Vec<u8>);

impl Write for Sentence<'_> {
    fn write_str(&mut self, part: &str) -> fmt::Result {
        self.0.extend(part.bytes().filter(|byte| *byte != 0));
        Ok(())
    }
}

/// Keeps a sentence for the calling thread and hands the code on.
pub(crate) fn say(code: cppr_code, text: fmt::Arguments) -> cppr_code {
    // While a thread ends there is nobody to read it.
    let _ = TEXT.try_with(|kept| {
        if let Ok(mut kept) = kept.try_borrow_mut() {
            kept.clear();
            kept.reserve(ROOM);
            let _ = Sentence(&mut kept).write_fmt(text);
            kept.push(0);
        }
    });
    code
}

/// Runs an entry point; a panic ends here.
pub(crate) fn guard(run: impl FnOnce() -> Result<cppr_code, cppr_code>) -> i32 {
    let caught = catch_unwind(AssertUnwindSafe(run));
    let code = match caught {
        Ok(Ok(code) | Err(code)) => code,
        Err(panic) => fault(panic.as_ref()),
    };
    code as i32
}

/// The same for entry points that give a pointer or a number: `otherwise` where they fail.
pub(crate) fn guard_or<T>(otherwise: T, run: impl FnOnce() -> Result<T, cppr_code>) -> T {
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(value)) => value,
        Ok(Err(_)) => otherwise,
        Err(panic) => {
            fault(panic.as_ref());
            otherwise
        }
    }
}

fn fault(panic: &(dyn Any + Send)) -> cppr_code {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
    say(cppr_code::Internal, format_args!("a fault of the library, please report it: {text}"))
}

/// Why the last call of this thread that failed did so: one or more sentences, UTF-8. Empty before the first. Valid until the next
/// failure or explanation in this thread.
#[unsafe(no_mangle)]
pub extern "C" fn cppr_error_text() -> *const c_char {
    const NOTHING: &CStr = c"";
    let kept = TEXT.try_with(|text| text.try_borrow().ok().filter(|t| !t.is_empty()).map(|t| t.as_ptr()));
    kept.ok().flatten().map_or(NOTHING.as_ptr(), <*const u8>::cast)
}

/// CPPR_ABI of the library that is loaded: compare it with CPPR_ABI of the header.
#[unsafe(no_mangle)]
pub extern "C" fn cppr_abi() -> u32 {
    CPPR_ABI
}

/// Version of the library, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn cppr_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text() -> String {
        // SAFETY: the pointer is that of the sentence of this thread, which ends with 0.
        unsafe { CStr::from_ptr(cppr_error_text()) }.to_str().unwrap_or_default().to_owned()
    }

    #[test]
    #[allow(clippy::panic)]
    fn a_panic_becomes_a_code_and_a_sentence() {
        assert_eq!(text(), "");
        assert_eq!(guard(|| panic!("number {}", 7)), cppr_code::Internal as i32);
        assert_eq!(text(), "a fault of the library, please report it: number 7");
        assert!(guard_or(f64::NAN, || panic!("again")).is_nan());
        assert_eq!(text(), "a fault of the library, please report it: again");
        let code = guard(|| Err(say(cppr_code::BadArgument, format_args!("a\0b"))));
        assert_eq!((code, text().as_str()), (cppr_code::BadArgument as i32, "ab"));
    }
}
