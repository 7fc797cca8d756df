//! The responses that wait until they are fetched: PROFIdrive profile, base mode. A connection has one request at a time.

use alloc::vec::Vec;

/// The responses that wait, one for each connection `K` at most.
#[derive(Clone, Debug)]
pub struct Responses<K>(Vec<(K, Vec<u8>)>);

impl<K> Default for Responses<K> {
    fn default() -> Responses<K> {
        Responses(Vec::new())
    }
}

impl<K: Copy + PartialEq> Responses<K> {
    /// Keeps the response to a request of `connection`.
    pub fn keep(&mut self, connection: K, response: Vec<u8>) {
        self.forget(connection);
        self.0.push((connection, response));
    }

    /// The response for `connection`, if one waits; it can be fetched once.
    pub fn fetch(&mut self, connection: K) -> Option<Vec<u8>> {
        let at = self.0.iter().position(|(of, _)| *of == connection)?;
        Some(self.0.swap_remove(at).1)
    }

    /// Forgets what waits for `connection`: it has ended, or has sent another request.
    pub fn forget(&mut self, connection: K) {
        self.0.retain(|(of, _)| *of != connection);
    }
}
