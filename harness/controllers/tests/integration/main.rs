//! Controller and master against scripted devices, independent implementations and reflectors, on a simulated clock.

mod common;
mod connection;
mod dp;
mod dp_exchange;
mod dp_ms2;
mod dp_profirust;
mod dp_repetition;
mod dp_services;
mod dp_start_up;
mod dp_token;
mod exchange;
mod hostile_frames;
mod http;
mod records;
mod server;
mod start_up;
