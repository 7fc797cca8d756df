//! Responses that wait to be fetched (PROFIdrive profile, base mode). A connection has one request at a time.

use alloc::vec::Vec;

/// The waiting responses, at most one for each connection `K`.
#[derive(Clone, Debug)]
pub struct PendingResponses<K>(Vec<(K, Vec<u8>)>);

impl<K> Default for PendingResponses<K> {
    fn default() -> PendingResponses<K> {
        PendingResponses(Vec::new())
    }
}

impl<K: Copy + PartialEq> PendingResponses<K> {
    /// Stores the response to a request of `connection`.
    pub fn keep(&mut self, connection: K, response: Vec<u8>) {
        self.forget(connection);
        self.0.push((connection, response));
    }

    /// Removes and returns the response for `connection`, if there is one.
    pub fn fetch(&mut self, connection: K) -> Option<Vec<u8>> {
        let at = self.0.iter().position(|(of, _)| *of == connection)?;
        Some(self.0.swap_remove(at).1)
    }

    /// Drops the response for `connection`: it has ended or has sent another request.
    pub fn forget(&mut self, connection: K) {
        self.0.retain(|(of, _)| *of != connection);
    }
}
