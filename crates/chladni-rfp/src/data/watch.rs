//! Observer of a fit: it is told each stage as that begins, and may stop the fit there.

use crate::data::error::FitError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

/// A request to stop a fit, shared between the thread that fits and the one that asks.
/// Clones are the same request.
#[derive(Debug, Clone, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// A token that asks for nothing yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the fit to stop at its next stage. It cannot be taken back.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// True once it was asked.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The receiver of a fit's progress, and the request that may stop it.
pub(crate) struct Watch<'a> {
    pub tell: &'a (dyn Fn(&str) + Sync),
    pub cancel: &'a CancelToken,
}

impl Watch<'_> {
    /// Tells that a stage begins.
    ///
    /// # Errors
    /// [`FitError::Cancelled`] where the fit is to stop here.
    pub fn stage(&self, name: &str) -> Result<(), FitError> {
        (self.tell)(name);
        match self.cancel.is_cancelled() {
            true => Err(FitError::Cancelled),
            false => Ok(()),
        }
    }
}
