//! The best rate of several rounds, as the benches print it.

use std::time::Instant;

const ROUNDS: usize = 10;

/// Runs the work several times and prints the best rate in `items` per second.
pub fn rate(name: &str, items: &str, count: usize, mut work: impl FnMut()) {
    let mut best = f64::MAX;
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        work();
        best = best.min(begin.elapsed().as_secs_f64());
    }
    println!("{name:<24} {:>8.2} million {items} a second", count as f64 / best / 1e6);
}
