//! The page that shows a run while it runs, and afterwards.
//!
//! `results` reads what a run writes, `history` and `body` make curves and a surface of it, [`server`] hands them out by `http`.
//! Nothing is written, and nothing is asked of the loop that computes.

mod body;
mod history;
mod http;
mod results;
pub mod server;
mod stamp;
