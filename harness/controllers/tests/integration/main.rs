//! Controller and master against scripted devices, strangers and mirrors, on a clock that jumps.

mod common;
mod connection;
mod dp;
mod dp_exchange;
mod dp_services;
mod dp_start_up;
mod dp_strangers;
mod exchange;
mod http;
mod records;
mod server;
mod start_up;
mod strangers;
