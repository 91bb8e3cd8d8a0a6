//! What is made of the results of a run: series, plots, pictures, and the page that shows a run. Nothing here prints.

pub mod curves;
pub mod error;
pub mod page;
pub mod plot;
pub mod series;
pub mod sheets;
pub mod table;
