//! The threads and vector instructions that a session runs on.

use crate::error::SessionError;
use estar_solver::LaneLevel;

/// The threads and vector instructions to run on: all cores and the best ones unless given.
///
/// # Errors
/// The machine cannot give them.
pub fn machine(
    threads: Option<usize>,
    lanes: Option<LaneLevel>,
) -> Result<(rayon::ThreadPool, LaneLevel), SessionError> {
    let lanes = lanes.unwrap_or_else(LaneLevel::best);
    if !lanes.is_available() {
        return Err(SessionError::NoLanes(lanes));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
    let reason = |error: rayon::ThreadPoolBuildError| SessionError::NoThreads { reason: error.to_string() };
    Ok((pool.map_err(reason)?, lanes))
}
