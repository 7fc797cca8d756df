//! Captures of independent tools, and an independent tool that reads captures of encspec.

mod independent_captures;
