//! Concentric push-pull robots in a browser.
//!
//! [`serve`] opens a page on this computer that sends what is asked of a robot and draws the answers as they
//! come. The server listens on the loopback address only, under a path that nobody else can guess, and answers
//! no page but its own. Every connection has its own robot and its own solver; of several requests that wait, the
//! newest is solved. The page (`web/`, bundled into `dist/`) is part of the binary.
//!
//! [`save::page`] makes a page that needs no server.
//!
//! Messages of the page are JSON ([`session`]); shapes go back in binary ([`message`]).

mod bundle;
mod cloud;
mod describe;
mod drag;
#[cfg(feature = "server")]
mod guard;
#[cfg(feature = "server")]
mod live;
pub mod message;
pub mod save;
#[cfg(feature = "server")]
mod server;
pub mod session;
mod touch;

#[cfg(feature = "server")]
pub use server::{Options, serve};
